//! Charts of the studies, each a file of its own, light or dark as the viewer prefers.
//!
//! `attractor`, `basins`, `bifurcation` and `excitation_map` show motion on sines and share
//! `dynamics`; `stability` and `work_precision` compare methods, which `methods` draws; `damages` is of recordings;
//! `free_vibration`, `histories`, `restitution`, `shock`, `spectrogram` and `step_size` are the
//! paper's other figures.

mod attractor;
mod basins;
mod bifurcation;
mod damages;
mod dynamics;
mod excitation_map;
mod free_vibration;
mod histories;
mod methods;
mod restitution;
mod shock;
mod spectrogram;
mod stability;
mod step_size;
mod work_precision;

use crate::attractor::Attractor;
use crate::basins::Basins;
use crate::bifurcation::Diagram;
use crate::damages::Damages;
use crate::excitation_map::ExcitationMap;
use crate::free_vibration::FreeVibration;
use crate::histories::Histories;
use crate::restitution::Equivalence;
use crate::shock::Shock;
use crate::spectrogram::MotionSpectrogram;
use crate::stability::Stability;
use crate::step_size::StepSize;
use crate::work_precision::WorkPrecision;

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

macro_rules! charts {
    ($($(#[$doc:meta])* $name:ident($result:ty), $rules:expr;)*) => {$(
        $(#[$doc])*
        pub fn $name(result: &$result) -> String {
            $name::draw(result).stand_alone_with($rules)
        }
    )*};
}

charts! {
    /// Draws the section at one amplitude.
    attractor([Attractor]), dynamics::RULES;
    /// Draws the basins of attraction, one panel per stop.
    basins([Basins]), dynamics::RULES;
    /// Draws sections against the amplitude, one panel per stop.
    bifurcation([Diagram]), dynamics::RULES;
    /// Draws what damage is seen, kind by kind.
    damages(Damages), damages::RULES;
    /// Draws what excitation opens the latch, one panel per stop.
    excitation_map([ExcitationMap]), dynamics::RULES;
    /// Draws free vibration with and without a stop.
    free_vibration(FreeVibration), RULES;
    /// Draws the histories from several starts.
    histories(Histories), RULES;
    /// Draws damping against restitution.
    restitution(Equivalence), RULES;
    /// Draws a shock and the answers to it.
    shock(Shock), RULES;
    /// Draws the spectrogram of a free vibration.
    spectrogram(MotionSpectrogram), RULES;
    /// Draws where methods fail.
    stability(Stability), methods::RULES;
    /// Draws the limit of the fixed step.
    step_size(StepSize), RULES;
    /// Draws error against cost.
    work_precision(WorkPrecision), methods::RULES;
}
