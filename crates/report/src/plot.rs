//! Plots in SVG: the same drawing stands inline in the report and alone in a file.
//!
//! Colours are classes. Inline they take the page's CSS variables, so one drawing serves light,
//! dark and print; alone the drawing carries its own colours for light and dark. Paths keep
//! hundredths of a unit, and long signals keep every extremum (see [`thin`]).
//!
//! Of reports: `event`, `acceleration`, `angle`, `catch`, `spread`, `drivers`, `phase`, `spectrogram`, `spectra` and `sled`;
//! of two verdicts: `overlay`; of margins: `margin`; of spectra: `response_spectrum`. All but `event` are a `chart`, drawn in a `frame`
//! with its `axis` on a `canvas`; `heat` and `raster` make pictures of cells and points, `thin` shortens curves, `style`
//! holds colours and rules.

mod acceleration;
mod angle;
pub mod axis;
pub mod canvas;
mod catch;
pub mod chart;
mod drivers;
mod error_bar;
pub(crate) mod event;
pub mod frame;
pub mod heat;
mod margin;
pub(super) mod overlay;
mod phase;
pub mod raster;
mod response_spectrum;
mod sled;
mod spectra;
pub mod spectrogram;
mod spread;
pub mod style;
pub mod thin;

use self::chart::{ACROSS, At, Chart, Panel, Point};
use self::frame::{FOOTER, Scale, WIDE};
pub(super) use self::margin::{
    RULES as MARGIN_RULES, figures as margin_figures, stand_alone as margin_stand_alone,
};
pub(super) use self::response_spectrum::{
    RULES as SPECTRUM_RULES, figure as spectrum_figure, stand_alone as spectrum_stand_alone,
};
use crate::escape;
use crate::words;
use latchgate_document::Document;
use latchgate_document::number::exact;
use latchgate_kernel::range::{Range, Window};
use latchgate_verdict::{Evidence, SampledSeries, Trace};
use serde_json::Value;
use std::fmt::Write as _;

/// Name of the plot that stands on the first page.
pub const EVENT: &str = event::NAME;

/// Name of the plot that stands beside the ensemble.
pub const DRIVERS: &str = drivers::NAME;

/// Every plot's name, in the order of the report; its file is the name plus `.svg`.
pub const NAMES: [&str; 10] = [
    event::NAME,
    acceleration::NAME,
    angle::NAME,
    catch::NAME,
    spread::NAME,
    drivers::NAME,
    phase::NAME,
    spectrogram::NAME,
    spectra::NAME,
    sled::NAME,
];

/// Width of every drawing [units of its view box].
pub const WIDTH: f64 = 900.0;

/// A drawing, not yet wrapped for its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name: file name without `.svg`, and prefix of the ids inside.
    pub name: &'static str,
    /// Its content in a few words.
    pub title: String,
    /// How to read it, one or two sentences.
    pub caption: String,
    /// Text for a reader who does not see the drawing, with its numbers.
    pub description: String,
    /// Height in units of the drawing.
    pub height: f64,
    /// Elements of the drawing, as SVG.
    pub body: String,
}

impl Figure {
    /// Returns the drawing for a page that holds [`style::variables`] and [`style::RULES`].
    pub fn inline(&self) -> String {
        self.wrap("")
    }

    /// Returns the drawing as a file of its own, light or dark as the viewer prefers.
    pub fn stand_alone(&self) -> String {
        self.wrap(&style::stand_alone())
    }

    /// As [`Figure::stand_alone`] with further rules in terms of the colours' variables.
    pub fn stand_alone_with(&self, rules: &str) -> String {
        self.wrap(&style::stand_alone_with(rules))
    }

    fn wrap(&self, style: &str) -> String {
        let mut out = String::with_capacity(self.body.len() + style.len() + 1024);
        let Self { name, height, .. } = self;
        let (title, description) = (
            escape::markup(&self.title),
            escape::markup(&self.description),
        );
        // Writing into a String cannot fail.
        let _ = write!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {WIDTH} {height}\" \
             width=\"{WIDTH}\" height=\"{height}\" role=\"img\" \
             aria-labelledby=\"{name}-title {name}-description\">\n\
             <title id=\"{name}-title\">{title}</title>\n\
             <desc id=\"{name}-description\">{description}</desc>\n"
        );
        if !style.is_empty() {
            let _ = writeln!(out, "<style>\n{style}</style>");
        }
        let _ = writeln!(
            out,
            "<rect class=\"paper\" width=\"{WIDTH}\" height=\"{height}\"/>"
        );
        out.push_str(&self.body);
        out.push_str("</svg>\n");
        out
    }
}

/// Returns view, panels, curves and marks of the plot on the first page, from which a script can redraw it with
/// the columns of [`crate::series::csv`].
pub fn event_data(document: &Document, series: &SampledSeries) -> Option<Value> {
    event::draw(document, series).map(|(_, data)| data)
}

/// Draws every plot that the evidence has data for, in the order of [`NAMES`].
pub fn figures(document: &Document, evidence: Option<&Evidence>) -> Vec<Figure> {
    let Some(evidence) = evidence else {
        return Vec::new();
    };
    let context = PlotContext::new(document, evidence);
    [
        event::draw(document, &evidence.series).map(|(figure, _)| figure),
        acceleration::chart(&context).map(Chart::draw),
        angle::chart(&context).map(Chart::draw),
        catch::chart(&context).map(Chart::draw),
        spread::chart(&context).map(Chart::draw),
        drivers::chart(&context).map(Chart::draw),
        phase::chart(&context).map(Chart::draw),
        spectrogram::chart(&context).map(Chart::draw),
        spectra::chart(&context).map(Chart::draw),
        sled::chart(&context).map(Chart::draw),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Data that all plots share: the results, and one time axis.
struct PlotContext<'a> {
    document: &'a Document,
    evidence: &'a Evidence,
    /// The window shown.
    span: Window,
    /// Factor from seconds to the time shown.
    time_scale: f64,
    time_unit: &'static str,
    /// Identity of the drawing outside its report.
    origin: String,
}

impl<'a> PlotContext<'a> {
    fn new(document: &'a Document, evidence: &'a Evidence) -> Self {
        let mut instants = Vec::new();
        for signal in [&evidence.raw, &evidence.used] {
            if !signal.samples.is_empty() {
                instants.extend([signal.start_s, signal.end_s()]);
            }
        }
        for trace in &evidence.traces {
            let ends = [trace.points.first(), trace.points.last()];
            instants.extend(ends.into_iter().flatten().map(|point| point.time_s));
        }
        let Range { low, high } = frame::extent(instants.into_iter());
        let span = if low <= high {
            Window::new(low, high)
        } else {
            Window::new(0.0, 1.0)
        };
        let (time_scale, time_unit) = time_unit(span);
        Self {
            document,
            evidence,
            span,
            time_scale,
            time_unit,
            origin: origin(document),
        }
    }

    /// Returns a panel across the drawing over the plots' common time axis, in the unit shown.
    fn over_time(&self, height: f64) -> Panel {
        let title = format!("time [{}]", self.time_unit);
        Panel::new(&WIDE, ACROSS, height).x(title, self.time())
    }

    /// Returns the scale of that axis.
    fn time(&self) -> Scale {
        let Window { from_s, until_s } = self.span;
        Scale::Linear(from_s * self.time_scale, until_s * self.time_scale)
    }

    /// Returns an empty chart with the report's identity at its foot.
    fn chart(&self) -> Chart {
        Chart {
            room: [0.0, 16.0, FOOTER],
            origin: self.origin.clone(),
            ..Chart::default()
        }
    }

    /// Adds the ends of the judged window, if one was requested.
    fn judged_window(&self, panel: Panel) -> Panel {
        let window = self.document.request.window_s;
        let ends = window
            .into_iter()
            .flat_map(|window| [window.from_s, window.until_s]);
        panel.each(ends, |panel, end| {
            panel.upright("edge", end * self.time_scale)
        })
    }

    /// Adds the line of the limit angle across, with its words at the left.
    fn limit(&self, panel: Panel) -> Panel {
        let limit = self.document.threshold_rad;
        let label_place = (At::Low(8.0), At::Value(limit, -6.0));
        let text = format!("limit {} rad", exact(limit));
        panel
            .level("limit", limit)
            .text("alarm halo", label_place, text)
    }

    /// Returns the angle over time of a trace, in the unit of time shown.
    fn angles(&self, trace: &Trace) -> impl Iterator<Item = Point> {
        let (points, scale) = (trace.points.iter(), self.time_scale);
        points.map(move |point| Point::new(point.time_s * scale, point.angle_rad))
    }
}

/// Returns the factor from seconds to the time that a plot of a window shows, and its unit.
fn time_unit(shown: Window) -> (f64, &'static str) {
    if shown.until_s - shown.from_s > 2.0 {
        (1.0, "s")
    } else {
        (1e3, "ms")
    }
}

fn origin(document: &Document) -> String {
    let recording = &document.recording;
    let shorten = |text: &str| -> String {
        if text.chars().count() > 40 {
            text.chars().take(39).chain(['…']).collect()
        } else {
            text.to_string()
        }
    };
    let mut text = shorten(&recording.file);
    if let Some(channel) = &recording.channel {
        text.push_str(" · ");
        text.push_str(&shorten(channel));
    }
    text.push_str(" · report ");
    text.push_str(&words::report_name(document));
    text
}
