//! Charts of the studies, each a file of its own, light or dark as the viewer prefers.
//!
//! `attractor`, `basins`, `bifurcation` and `excitation_map` show motion on sines; `stability` and `work_precision` compare methods, which `methods` draws; `damages` is of recordings, `catch` of an inertia catch;
//! `free_vibration`, `histories`, `parameters`, `restitution`, `shock`, `spectrogram` and `step_size` are the
//! paper's other figures.

mod attractor;
mod basins;
mod bifurcation;
mod catch;
mod damages;
mod excitation_map;
mod free_vibration;
mod histories;
mod methods;
mod parameters;
mod restitution;
mod shock;
mod spectrogram;
mod stability;
mod step_size;
mod work_precision;

use crate::attractor::Attractor;
use crate::basins::Basins;
use crate::bifurcation::Diagram;
use crate::catch::CatchStudy;
use crate::damages::Damages;
use crate::excitation_map::ExcitationMap;
use crate::free_vibration::FreeVibration;
use crate::histories::Histories;
use crate::parameters::Parameters;
use crate::restitution::Equivalence;
use crate::shock::Shock;
use crate::spectrogram::MotionSpectrogram;
use crate::stability::Stability;
use crate::step_size::StepSize;
use crate::work_precision::WorkPrecision;
use latchgate_kernel::replay::TracePoint;
use latchgate_report::plot::chart::Point;

/// Rules of the charts of motions, in terms of the colours' variables.
const RULES: &str = "\
.plot .line{fill:none;stroke-width:1.4;stroke-linejoin:round}
.plot .fine{stroke-width:.9}
.plot .bold{stroke-width:2.2}
.plot .nothing{stroke:var(--raw);stroke-dasharray:5 3}
.plot .rigid{stroke:var(--first)}
.plot .soft{stroke:var(--second)}
.plot .third{stroke:var(--third)}
.plot .ink{stroke:var(--ink)}
.plot .failing{stroke:var(--fail)}
.plot .dash{stroke-dasharray:6 4}
.plot .dotted{stroke-dasharray:1.5 3.5}
.plot .ridge{fill:none;stroke:#ffffff;stroke-width:1.6}
.plot .ridge-edge{fill:none;stroke:#000000;stroke-width:3.4;stroke-opacity:.55}
.plot .ridge-dot{fill:#ffffff;stroke:#000000;stroke-width:.8}
.plot .pull{fill:var(--fail);opacity:.22}
.plot .between{fill:var(--second);opacity:.25}
.plot .small{font-size:12px}
.plot .spot{fill:var(--ink);stroke:var(--paper);stroke-width:1}
";

/// Rules of the charts of motion on sines, in terms of the colours' variables.
const SINE_RULES: &str = "\
.plot image{image-rendering:pixelated}
.plot .birth{fill:none;stroke:var(--pass);stroke-width:1.5}
.plot .doubling{fill:none;stroke:var(--fail);stroke-width:1.5}
.plot .contour{fill:none;stroke:var(--paper);stroke-width:4;stroke-linejoin:round}
.plot .contour-ink{fill:none;stroke:#e02020;stroke-width:2;stroke-linejoin:round}
.plot .lift{fill:none;stroke:#ffffff;stroke-width:2;stroke-dasharray:11 7}
.plot .lift-edge{fill:none;stroke:#000000;stroke-width:4;stroke-opacity:.45}
.plot .few-event-driven{fill:#2d7dcd;stroke:var(--paper);stroke-width:.75}
.plot .few-rk4{fill:#de7020;stroke:var(--paper);stroke-width:.75}
.plot .ring{fill:none;stroke:var(--ink);stroke-width:1.5}
.plot .tiny{font-size:11.5px}
";

macro_rules! charts {
    ($($(#[$doc:meta])* $name:ident($result:ty), $rules:expr;)*) => {$(
        $(#[$doc])*
        pub fn $name(result: &$result) -> String {
            $name::chart(result).draw().stand_alone_with($rules)
        }
    )*};
}

charts! {
    /// Draws the section at one amplitude.
    attractor([Attractor]), SINE_RULES;
    /// Draws the basins of attraction, one panel per stop.
    basins([Basins]), SINE_RULES;
    /// Draws sections against the amplitude, one panel per stop.
    bifurcation([Diagram]), SINE_RULES;
    /// Draws lever and catch under two pulses and ringing.
    catch(CatchStudy), RULES;
    /// Draws the shares of damage that are detected, kind by kind.
    damages(Damages), damages::RULES;
    /// Draws the excitation that opens the latch, one panel per stop.
    excitation_map([ExcitationMap]), SINE_RULES;
    /// Draws free vibration with and without a stop.
    free_vibration(FreeVibration), RULES;
    /// Draws the histories from several starts.
    histories(Histories), RULES;
    /// Draws the peak under a shock against each number of the lever.
    parameters(Parameters), RULES;
    /// Draws damping against restitution.
    restitution(Equivalence), RULES;
    /// Draws a shock and the answers to it.
    shock(Shock), RULES;
    /// Draws the spectrogram of a free vibration.
    spectrogram(MotionSpectrogram), RULES;
    /// Draws the failures of methods.
    stability(Stability), methods::RULES;
    /// Draws the limit of the fixed step.
    step_size(StepSize), RULES;
    /// Draws error against cost.
    work_precision(WorkPrecision), methods::RULES;
}

/// Returns the angle over time, in units of time of which a second has `per_second`.
fn angles(trace: &[TracePoint], per_second: f64) -> impl Iterator<Item = Point> {
    let points = trace.iter();
    points.map(move |point| Point::new(point.time_s * per_second, point.angle_rad))
}
