//! The latch response spectra of some recordings, their envelope, and designs beside them, as a document.

use super::answer;
use super::prepared::Prepared;
use latchgate_document::SpectrumDocument;
use latchgate_document::blocks::RecordingBlock;
use latchgate_document::identity;
use latchgate_document::spectrum_document::{
    CurveBlock, DesignPoint, Envelope, LeftOut, SpectrumRequest, SpectrumSettings, covering,
    times_the_others,
};
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::error::{Error, Place};
use latchgate_recording::{Limits, Source};
use latchgate_verdict::Polarity;
use latchgate_verdict::awaited;
use latchgate_verdict::margin::{self, Advice, Quantity};
use latchgate_verdict::response_spectrum::plane::{Place as DesignPlace, PlanePoint};
use latchgate_verdict::response_spectrum::{
    Column, LEVERS, LeverFamily, OPENING_ALLOWED, OPENING_SURELY, READINGS, SpectrumOptions,
    SpectrumRecording, judged_span, strokes_m,
};
use std::collections::BTreeMap;

/// A curve with what a design needs of it.
struct Curve {
    block: CurveBlock,
    spectrum_m_s2: Vec<Option<f64>>,
    zone_from_m_s2: Vec<Option<f64>>,
    single_push_m_s2: Vec<f64>,
    /// Place and reserves of each design at this curve.
    placed: Vec<Option<Placed>>,
}

/// A design beside one curve.
struct Placed {
    place: DesignPlace,
    load: Reserve,
    preload: Reserve,
}

/// A reserve, or why there is none.
#[derive(Debug, Clone)]
struct Reserve {
    /// To be compared: below all others where it does not pass, infinite beyond what was tried.
    rank: f64,
    reason: Option<String>,
}

impl Reserve {
    /// Returns the number, where it is one.
    fn value(&self) -> Option<f64> {
        Some(self.rank).filter(|rank| rank.is_finite())
    }

    fn none(rank: f64, reason: impl Into<String>) -> Self {
        Self {
            rank,
            reason: Some(reason.into()),
        }
    }

    fn of(rank: f64) -> Self {
        Self { rank, reason: None }
    }

    /// Takes the reserve in load from the scales of the recording at which a design passes.
    fn in_load(advice: Option<Advice>) -> Self {
        let Some(advice) = advice else {
            return Self::none(f64::NEG_INFINITY, SPOILED);
        };
        match (advice.covers(Quantity::Scale, 1.0), advice.does_not) {
            (true, Some(first)) => Self::of(first),
            (true, None) => Self::none(f64::INFINITY, "more than 100 times the recording passes"),
            (false, _) => Self::none(f64::NEG_INFINITY, "the recording as it is does not pass"),
        }
    }

    /// Takes that in preload from the preloads at which it passes.
    fn in_preload(advice: Option<Advice>, own_nm: f64) -> Self {
        let Some(advice) = advice else {
            return Self::none(f64::NEG_INFINITY, SPOILED);
        };
        match advice.safe_from {
            Some(least_nm) => Self::of(1.0 - least_nm / own_nm),
            None => Self::none(f64::NEG_INFINITY, advice.text),
        }
    }
}

const SPOILED: &str = "a blocking finding spoils the recording";

/// Reads recordings one after the other and returns their latch response spectra, with the place of each design.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Control, Limits, Source, SpectrumRequest, spectrum};
///
/// let sources = [Source::File("signals/half_sine_30g_11ms.csv".into())];
/// let request = SpectrumRequest::default();
/// let (limits, control) = (Limits::default(), Control::unwatched(2));
/// let document = spectrum(&sources, &request, &[], &limits, &control)?;
/// // A lever of 1 mm stroke must hold some 23 of the 30 g.
/// let asked_g = document.spectrum_m_s2[0][0].unwrap() / 9.80665;
/// assert!((20.0..27.0).contains(&asked_g));
/// # Ok::<(), latchgate::pipeline::Error>(())
/// ```
///
/// # Errors
///
/// Those of [`Prepared::open`] and of the spectrum of the first recording that has none, unless such are left out;
/// the first of them where all are; [`Stopped`](latchgate_kernel::error::Error::Stopped).
pub fn spectrum(
    sources: &[Source],
    request: &SpectrumRequest,
    designs: &[Design],
    limits: &Limits,
    control: &Control<'_>,
) -> Result<SpectrumDocument, Error> {
    request.check()?;
    if sources.len() > 1 && !request.leave_out_unusable {
        // Nobody waits for curves to learn that the last recording has none.
        for source in sources {
            let prepared = open(source, request, limits, control)?;
            judged_span(&prepared.conditioned, &prepared.facts.findings)
                .map_err(|error| error.at(Place::file(source.name())))?;
        }
    }
    let family = LeverFamily::of_chart(request.restitution);
    let mut curves: Vec<Curve> = Vec::new();
    let mut left_out = Vec::new();
    let mut first_error = None;
    for (index, source) in sources.iter().enumerate() {
        let part = |index: usize| index as f64 / sources.len() as f64;
        let found = control.during(part(index), part(index + 1), |control| {
            curves_of(source, request, &family, designs, limits, control)
        });
        match found {
            Ok(found) => curves.extend(found),
            Err(error) if error.is_stopped() || !request.leave_out_unusable => return Err(error),
            Err(error) => {
                left_out.push(LeftOut {
                    file: source.name(),
                    reason: error.to_string(),
                });
                first_error.get_or_insert(error);
            }
        }
    }
    if let (true, Some(error)) = (curves.is_empty(), first_error) {
        return Err(error);
    }
    Ok(document(curves, left_out, request, &family, designs))
}

fn open(
    source: &Source,
    request: &SpectrumRequest,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<Prepared, Error> {
    Prepared::open(source, &request.replay, limits, control).map_err(|refused| refused.error)
}

/// Returns the curves of one recording: one for each direction that is asked.
fn curves_of(
    source: &Source,
    request: &SpectrumRequest,
    family: &LeverFamily,
    designs: &[Design],
    limits: &Limits,
    control: &Control<'_>,
) -> Result<Vec<Curve>, Error> {
    let prepared = open(source, request, limits, control)?;
    let place = || Place::file(source.name());
    let signs = prepared.facts.polarity.signs();
    let policy = prepared.facts.request.policy(prepared.facts.polarity);
    let options = SpectrumOptions {
        seed: policy.seed,
        work: policy.work,
        between: policy.between,
    };
    let factors = prepared.factors();
    let mut curves: Vec<Curve> = Vec::new();
    for (number, factor) in factors.iter().enumerate() {
        // A factor between the sensor's place and the latch is another recording; the highest curve counts.
        let at_latch = prepared.at_factor(*factor);
        let (conditioned, findings) = (&at_latch.conditioned, &at_latch.facts.findings);
        let cache = at_latch.readings();
        let of_factor = || {
            let recording =
                SpectrumRecording::new(conditioned, findings, options.clone(), cache, control)?;
            let tasks = factors.len() * signs.len();
            let of_sign = signs.iter().enumerate().map(|(index, opens_when)| {
                let part = |index: usize| (number * signs.len() + index) as f64 / tasks as f64;
                control.during(part(index), part(index + 1), |control| {
                    curve(&at_latch, &recording, family, *opens_when, designs, control)
                })
            });
            of_sign.collect::<Result<Vec<_>, Error>>()
        };
        let found = of_factor().map_err(|error| error.at(place()))?;
        curves = match curves.is_empty() {
            true => found,
            false => curves
                .into_iter()
                .zip(found)
                .map(|(before, next)| before.and(next))
                .collect(),
        };
    }
    Ok(curves)
}

impl Curve {
    /// Joins the curves of two factors between the sensor's place and the latch: what asks more of a latch counts.
    fn and(mut self, other: Self) -> Self {
        let pairs = self.spectrum_m_s2.iter_mut().zip(other.spectrum_m_s2);
        pairs.for_each(|(own, other)| *own = highest(*own, other));
        let pairs = self.zone_from_m_s2.iter_mut().zip(other.zone_from_m_s2);
        // None reaches below the lowest window.
        pairs.for_each(|(own, other)| *own = own.zip(other).map(|(own, other)| own.min(other)));
        let pairs = self.single_push_m_s2.iter_mut().zip(other.single_push_m_s2);
        pairs.for_each(|(own, other)| *own = own.max(other));
        self.block.strongest_m_s2 = self.block.strongest_m_s2.max(other.block.strongest_m_s2);
        self.block.levers += other.block.levers;
        let pairs = self.placed.iter_mut().zip(other.placed);
        for (own, other) in pairs {
            if let (Some(own), Some(other)) = (own.as_mut(), other) {
                own.place = own.place.min(other.place);
                for (own, other) in [
                    (&mut own.load, other.load),
                    (&mut own.preload, other.preload),
                ] {
                    if other.rank < own.rank {
                        *own = other;
                    }
                }
            }
        }
        self
    }
}

fn highest(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    one.into_iter().chain(other).reduce(f64::max)
}

fn curve(
    prepared: &Prepared,
    recording: &SpectrumRecording<'_>,
    family: &LeverFamily,
    opens_when: OpensWhen,
    designs: &[Design],
    control: &Control<'_>,
) -> Result<Curve, Error> {
    let strokes = strokes_m();
    let of_chart = if designs.is_empty() { 1.0 } else { 0.5 };
    let found = control.during(0.0, of_chart, |control| {
        recording.spectrum(family, opens_when, control)
    })?;
    let placed = designs.iter().enumerate().map(|(index, design)| {
        let part = |index: usize| 0.5 + 0.5 * index as f64 / designs.len() as f64;
        control.during(part(index), part(index + 1), |control| {
            placed(prepared, recording, opens_when, design, control)
        })
    });
    let placed = placed.collect::<Result<Vec<_>, Error>>()?;
    let columns: Vec<Column> = strokes.iter().map(|stroke_m| found.at(*stroke_m)).collect();
    let facts = &prepared.facts;
    let channel = facts.recording.channel.as_deref().unwrap_or_default();
    let block = CurveBlock {
        name: name(&facts.recording.file, channel, opens_when),
        opens_when,
        axis: facts.axis,
        strongest_m_s2: found.strongest_m_s2,
        floor_m_s2: found.floor_m_s2(),
        judged_until_s: recording.judged_until_s,
        times_the_others: None,
        levers: found.levers,
        recording: facts.recording.clone(),
        conditioning: facts.conditioning(&prepared.conditioned),
        test: facts.test.clone(),
        findings: facts.findings.clone(),
    };
    Ok(Curve {
        block,
        spectrum_m_s2: columns.iter().map(|column| column.spectrum_m_s2).collect(),
        zone_from_m_s2: columns.iter().map(|column| column.zone_from_m_s2).collect(),
        single_push_m_s2: recording.single_push(family, opens_when, &strokes),
        placed,
    })
}

/// Returns where a design lies at a curve and what reserve it has there, by the rule; `None` of one without a place.
fn placed(
    prepared: &Prepared,
    recording: &SpectrumRecording<'_>,
    opens_when: OpensWhen,
    design: &Design,
    control: &Control<'_>,
) -> Result<Option<Placed>, Error> {
    let Some(point) = PlanePoint::of(design) else {
        return Ok(None);
    };
    let place =
        control.unmeasured(|control| point.place(design, recording, opens_when, control))?;
    let facts = &prepared.facts;
    let policy = facts.request.policy(Polarity::Declared(opens_when));
    let (conditioned, findings) = (&prepared.conditioned, &facts.findings);
    let advice = |quantity: Quantity| {
        let policy = &policy;
        margin::advice(
            quantity,
            conditioned,
            findings,
            design,
            policy,
            None,
            control,
        )
    };
    let load = Reserve::in_load(advice(Quantity::Scale)?);
    // The rule has the last word: what does not pass is not above.
    let place = match place {
        DesignPlace::Above if load.rank == f64::NEG_INFINITY => DesignPlace::Zone,
        place => place,
    };
    Ok(Some(Placed {
        place,
        load,
        preload: Reserve::in_preload(advice(Quantity::Preload)?, design.lever.preload_torque_nm),
    }))
}

/// Names a curve: the file, its channel where that says more, and the sign that opens. What ends the name of the file
/// and begins that of the channel (an EV5 curve's number) stands there once.
fn name(file: &str, channel: &str, opens_when: OpensWhen) -> String {
    let sign = match opens_when {
        OpensWhen::Negative => "−",
        OpensWhen::Positive => "+",
    };
    match channel {
        _ if file.starts_with(latchgate_recording::pulse::PREFIX) => {
            // What its settings fill in stands in the document.
            let word = file.split(",rate=").next().unwrap_or(file);
            format!("{word} {sign}")
        }
        "" => format!("{file} {sign}"),
        channel if file.contains(channel) || channel.contains(file) => format!("{file} {sign}"),
        channel => {
            let number = file.rsplit_once('.').map_or("", |(_, ending)| ending);
            let rest = channel.strip_prefix(number).unwrap_or(channel).trim_start();
            format!("{file} {rest} {sign}")
        }
    }
}

fn document(
    mut curves: Vec<Curve>,
    left_out: Vec<LeftOut>,
    request: &SpectrumRequest,
    family: &LeverFamily,
    designs: &[Design],
) -> SpectrumDocument {
    let stroke_m = strokes_m();
    let spectra: Vec<Vec<Option<f64>>> = curves
        .iter()
        .map(|curve| curve.spectrum_m_s2.clone())
        .collect();
    let sister = |index: usize| {
        let block: &CurveBlock = &curves[index].block;
        (block.axis, block.opens_when)
    };
    let far = times_the_others(&spectra, sister);
    for (curve, times) in curves.iter_mut().zip(far) {
        curve.block.times_the_others = times;
    }
    number_twins(&mut curves);
    let points = designs
        .iter()
        .enumerate()
        .map(|(index, design)| point(design, &curves, index));
    let designs_placed: Vec<DesignPoint> = points.collect();
    // Pulses by formula stand beside the recordings: a crash makes the requirement.
    let is_pulse = |curve: &Curve| curve.block.recording.format.as_deref() == Some("pulse");
    let recorded: Vec<usize> = (0..curves.len())
        .filter(|index| !is_pulse(&curves[*index]))
        .collect();
    let counted = match recorded.is_empty() {
        true => (0..curves.len()).collect(),
        false => recorded,
    };
    let counting: Vec<Vec<Option<f64>>> = counted
        .iter()
        .map(|index| spectra[*index].clone())
        .collect();
    let envelope = Envelope::of(&counting, stroke_m.len());
    // A share is one of recordings: of two directions the one that asks more.
    let mut by_recording: Vec<Vec<Option<f64>>> = Vec::new();
    let mut last: Option<(&str, Option<&str>)> = None;
    for (index, own) in counted.iter().zip(&counting) {
        let read = &curves[*index].block.recording;
        let subject = (read.file.as_str(), read.channel.as_deref());
        match by_recording.last_mut().filter(|_| last == Some(subject)) {
            Some(before) => {
                let pairs = before.iter_mut().zip(own);
                pairs.for_each(|(before, own)| *before = highest(*before, *own));
            }
            None => by_recording.push(own.clone()),
        }
        last = Some(subject);
    }
    let by = envelope.by.iter();
    let envelope_by = by.map(|by| by.map(|place| counted[place])).collect();
    let read: Vec<RecordingBlock> = curves
        .iter()
        .map(|curve| curve.block.recording.clone())
        .collect();
    SpectrumDocument {
        schema: "latchgate.spectrum/1".into(),
        report_id: identity::spectrum_id(&read, request, designs),
        share_m_s2: request
            .share
            .map(|share| covering(&by_recording, stroke_m.len(), share)),
        zone_from_m_s2: curves
            .iter()
            .map(|curve| curve.zone_from_m_s2.clone())
            .collect(),
        single_push_m_s2: curves
            .iter()
            .map(|curve| curve.single_push_m_s2.clone())
            .collect(),
        recordings: curves.into_iter().map(|curve| curve.block).collect(),
        left_out,
        stroke_m,
        spectrum_m_s2: spectra,
        envelope_m_s2: envelope.values_m_s2,
        envelope_by,
        designs: designs_placed,
        settings: settings(request, family),
        request: request.clone(),
        run: answer::run_block(),
    }
}

/// Gives curves of one name, which files of one name in two folders lead to, a number each.
fn number_twins(curves: &mut [Curve]) {
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for curve in curves {
        let name = &mut curve.block.name;
        let count = known.entry(name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            *name = format!("{name} ({count})");
        }
    }
}

fn settings(request: &SpectrumRequest, family: &LeverFamily) -> SpectrumSettings {
    let Design {
        lever, stop, input, ..
    } = family.design();
    let inertia = lever.moment_of_inertia_kg_m2;
    let (from, to) = request.restitution;
    SpectrumSettings {
        restitution: request.restitution,
        restitution_deviation: (from >= to).then(|| family.restitution_deviation()),
        limit_angle_rad: request.limit_angle_rad,
        spring_per_inertia_1_s2: lever.spring_stiffness_nm_per_rad / inertia,
        damping_per_inertia_1_s: lever.pivot_damping_nm_s_per_rad / inertia,
        contact_rad_s: stop.contact_angular_frequency_rad_s(lever),
        scale_deviation: input.scale,
        bias_deviation_m_s2: input.bias_g * STANDARD_GRAVITY,
        levers: LEVERS,
        opening_allowed: OPENING_ALLOWED,
        opening_surely: OPENING_SURELY,
        readings: READINGS,
        seed: request.replay.seed,
    }
}

/// Returns where a design lies to the curve that asks most of it.
fn point(design: &Design, curves: &[Curve], index: usize) -> DesignPoint {
    let lever = &design.lever;
    let half = 0.5 * lever.spring_stiffness_nm_per_rad * design.criterion.threshold_rad;
    let counted_m_s2 = (lever.preload_torque_nm + half) / lever.unbalance_kg_m();
    let placed_at = |curve: usize| curves[curve].placed[index].as_ref();
    let least = |rank: &dyn Fn(&Placed) -> f64| {
        let ranked = (0..curves.len()).filter_map(|curve| Some((curve, rank(placed_at(curve)?))));
        ranked.reduce(|least, next| if next.1 < least.1 { next } else { least })
    };
    let worst = least(&|placed| f64::from(placed.place as u8)).map(|(curve, _)| curve);
    let load_by = least(&|placed| placed.load.rank).map(|(curve, _)| curve);
    let preload_by = least(&|placed| placed.preload.rank).map(|(curve, _)| curve);
    let load = load_by
        .and_then(placed_at)
        .map(|placed| placed.load.clone());
    let preload = preload_by
        .and_then(placed_at)
        .map(|placed| placed.preload.clone());
    let (stroke_m, liftoff_m_s2) = (
        design.criterion.threshold_rad * lever.moment_of_inertia_kg_m2 / lever.unbalance_kg_m(),
        lever.lift_off_acceleration_m_s2(),
    );
    let point = PlanePoint::of(design);
    DesignPoint {
        name: design.name.clone(),
        stroke_m,
        stroke_span_m: point.map_or((stroke_m, stroke_m), |point| point.stroke_span_m),
        liftoff_m_s2,
        liftoff_span_m_s2: point.map_or((liftoff_m_s2, liftoff_m_s2), |point| {
            point.lift_off_span_m_s2
        }),
        counted_m_s2,
        place: worst.and_then(placed_at).map(|placed| placed.place),
        place_by: worst,
        reason: point
            .is_none()
            .then(|| "a lever beside a catch has no place in the plane".into()),
        awaits: awaited(
            curves.iter().flat_map(|curve| &curve.block.findings),
            design,
        ),
        reserve_load: load.as_ref().and_then(Reserve::value),
        reserve_load_reason: load.and_then(|load| load.reason),
        reserve_preload: preload.as_ref().and_then(Reserve::value),
        reserve_preload_reason: preload.and_then(|preload| preload.reason),
        reserve_by: load_by,
        design: design.clone(),
    }
}
