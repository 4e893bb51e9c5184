//! What a study shows, in one sentence, from its headline figures.

use crate::Headline;
use latchgate_document::number::trimmed;
use latchgate_kernel::model::stop::StopModel;

/// The figures of a study, to be looked up by their words.
#[derive(Clone, Copy)]
struct Figures<'a>(&'a [Headline]);

impl<'a> Figures<'a> {
    /// Those of subjects and names that start so, each with a value.
    fn all(self, subject: &'a str, what: &'a str) -> impl Iterator<Item = (&'a Headline, f64)> {
        let meant = move |line: &&Headline| {
            line.subject.starts_with(subject) && line.what.starts_with(what)
        };
        let found = self.0.iter().filter(meant);
        found.filter_map(|line| Some((line, line.value?)))
    }

    /// The first of them.
    fn first(self, subject: &'a str, what: &'a str) -> Option<f64> {
        self.all(subject, what).next().map(|(_, value)| value)
    }

    /// The first of them, as text.
    fn text(self, subject: &'a str, what: &'a str) -> Option<String> {
        Some(trimmed(self.first(subject, what)?, 3))
    }

    /// The stop of the first figure.
    fn stop(self) -> &'static str {
        on_stop(self.0.iter().find_map(|line| line.model))
    }
}

fn on_stop(model: Option<StopModel>) -> &'static str {
    match model {
        Some(StopModel::Soft) => "on the soft stop",
        _ => "on the rigid stop",
    }
}

/// Returns what a study shows; `None` where its figures do not say, as those of a study that was interrupted.
pub fn sentence(study: &str, headlines: &[Headline]) -> Option<String> {
    let figures = Figures(headlines);
    match study {
        "attractor" => attractor(figures),
        "basins" => basins(figures),
        "bifurcation" => bifurcation(figures),
        "catch" => catch(figures),
        "damages" => Some(format!(
            "{} of {} damages pass in silence, and {} of {} that no check can tell.",
            figures.text("damages", "passes in silence")?,
            figures.text("damages", "number")?,
            figures.text("damages nobody", "passes in silence")?,
            figures.text("damages nobody", "number")?,
        )),
        "excitation-map" => Some(format!(
            "From rest a sine opens the latch from {} g on, at {} rad/s, {}.",
            figures.text("", "least A of the contour")?,
            figures.text("", "at ω")?,
            figures.stop(),
        )),
        "free-vibration" => free_vibration(figures),
        "histories" => histories(figures),
        "parameters" => parameters(figures),
        "restitution" => Some(format!(
            "A soft stop that gives back {} of the speed without preload gives back {} at 0.1 rad/s with it: R is no constant.",
            figures.text("limits", "exit over entry speed, no preload")?,
            figures.text("limits", "with preload, entry at 0.1")?,
        )),
        "shock" => shock(figures),
        "spectrogram" => Some(format!(
            "The bounces quicken from {} Hz to {} Hz at the tenth: no single frequency describes them.",
            figures.text("", "frequency of the first")?,
            figures.text("", "frequency of the tenth")?,
        )),
        "stability" => Some(format!(
            "Runge-Kutta 4 at the paper's step gives back {} to {} of the speed, by where its grid meets the stop; right is {}.",
            figures.text("contact", "rk4 at N = 10000: least ratio")?,
            figures.text("contact", "rk4 at N = 10000: largest ratio")?,
            figures.text("contact", "exit speed over entry speed, right")?,
        )),
        "step-size" => Some(format!(
            "A contact is stable from {} steps a period on, and right to 1 % from {} on.",
            figures.text("limit", "the same as steps per period")?,
            figures.text("limit", "N from which the ratio is right to 1 %")?,
        )),
        "work-precision" => Some(format!(
            "On the shock Runge-Kutta 4 at the paper's step errs by {} rad in {} times the time of the event-driven method, whose error is below {} rad.",
            figures.text("shock", "rk4 at the paper's step: error of the peak")?,
            figures.text("shock", "rk4 at the paper's step: time over")?,
            figures.text("shock", "event-driven: bound")?,
        )),
        _ => None,
    }
}

fn attractor(figures: Figures<'_>) -> Option<String> {
    if let Some((line, period)) = figures.all("", "period [").next() {
        return Some(format!(
            "The motion {} repeats after {} periods of the excitation.",
            on_stop(line.model),
            trimmed(period, 3)
        ));
    }
    let mut growths = figures.all("", "largest Lyapunov exponent");
    Some(match growths.find(|(_, growth)| *growth > 0.0) {
        Some((line, growth)) => format!(
            "The motion {} is chaotic: a small difference grows {} times a period of the excitation.",
            on_stop(line.model),
            trimmed(libm::exp(growth), 3)
        ),
        None => "No period was seen, and no growth of small differences.".into(),
    })
}

fn basins(figures: Figures<'_>) -> Option<String> {
    let rests = figures.first("", "I (rest): share")?;
    Some(format!(
        "Under one excitation the lever comes to rest from {} % of the starts and moves for good from the others, {}.",
        trimmed(100.0 * rests, 3),
        figures.stop(),
    ))
}

fn bifurcation(figures: Figures<'_>) -> Option<String> {
    let lifts_off = figures.text("", "a lever at rest leaves")?;
    let stop = figures.stop();
    Some(match figures.text("", "least A with lasting motion [") {
        Some(moves) => format!(
            "The lever lifts off from {lifts_off} g on, and moves for good from {moves} g on, {stop}."
        ),
        None => format!(
            "The lever lifts off from {lifts_off} g on, and no amplitude tried keeps it in motion, {stop}."
        ),
    })
}

fn catch(figures: Figures<'_>) -> Option<String> {
    Some(format!(
        "Two pulses open the lever alone at {} of {} gaps and beside an irreversible catch at {}; ringing opens it there at {} of {} frequencies.",
        figures.text("two pulses, lever alone", "gaps that open")?,
        figures.text("two pulses, lever alone", "gaps tried")?,
        figures.text("two pulses, irreversible", "gaps that open")?,
        figures.text("ringing, irreversible", "frequencies that open")?,
        figures.text("ringing, irreversible", "frequencies tried")?,
    ))
}

fn free_vibration(figures: Figures<'_>) -> Option<String> {
    let shortening = figures.all("", "fifth over first time");
    let (with, least) = shortening.min_by(|one, other| one.1.total_cmp(&other.1))?;
    Some(match least < 1.0 - 1e-6 {
        true => format!(
            "With {} the fifth bounce takes {} of the first's time: preload ends in chatter.",
            with.subject,
            trimmed(least, 3)
        ),
        false => "All bounces take the same time.".into(),
    })
}

fn histories(figures: Figures<'_>) -> Option<String> {
    let rests = figures.all("", "rests in the end");
    let (mut starts, mut rest) = (0, 0);
    for (_, rests) in rests {
        starts += 1;
        rest += usize::from(rests > 0.0);
    }
    (starts > 0).then(|| {
        format!("{rest} of {starts} runs come to rest and the others move for good: the start and the stop decide.")
    })
}

fn parameters(figures: Figures<'_>) -> Option<String> {
    let holds: Vec<_> = figures.all("", "values within the limit").collect();
    let first = holds.first()?.0.model;
    let of_first = holds.iter().filter(|(line, _)| line.model == first);
    let (some, none): (Vec<_>, Vec<_>) = of_first.partition(|(_, values)| *values > 0.0);
    let names = |lines: &[&(&Headline, f64)]| {
        let names = lines.iter().map(|(line, _)| {
            let name = line.subject.split(" [").next();
            name.unwrap_or(&line.subject).to_string()
        });
        names.collect::<Vec<_>>().join(", ")
    };
    let stop = figures.stop();
    Some(match (some.is_empty(), none.is_empty()) {
        (false, false) => format!(
            "Some value of {} holds the lever, and none of {}, {stop}.",
            names(&some),
            names(&none)
        ),
        (false, true) => format!("Some value of each number holds the lever, {stop}."),
        _ => format!("No value of any number holds the lever, {stop}."),
    })
}

fn shock(figures: Figures<'_>) -> Option<String> {
    let first = &figures.0.first()?.subject;
    let peak = figures.text(first, "peak angle")?;
    let stop = figures.stop();
    Some(match figures.first(first, "threshold crossed first") {
        Some(crossed_s) => format!(
            "Under the shock ({first}) the lever opens after {} ms, {stop}.",
            trimmed(1e3 * crossed_s, 3)
        ),
        None => format!(
            "Under the shock ({first}) the lever stays: its largest angle is {peak} rad, {stop}."
        ),
    })
}
