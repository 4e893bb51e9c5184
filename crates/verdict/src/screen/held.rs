//! The bound on a lever that never leaves its soft stop.
//!
//! Its motion is linear but for cos φ: levers of one frequency and damping ratio in contact, be they
//! designs or members, differ by a factor. So what a recording does to such a lever is worked out
//! once. Numbers in comments are those of `docs/screens.md`.

use super::soft::{self, ContactResponse};
use super::{Seen, Subject, Terms};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Mutex;

/// Stops of which a recording's response is kept: those of the members of a first look, whose
/// restitution is scattered alike for each design, and of many designs.
const KEPT_MAX: usize = 4096;

/// Part of the way from rest to lift-off, and of the energy there, that is taken for certainly less:
/// [`soft::measure`] says the same of such a lever.
const WAY_MAX: f64 = 0.9;

/// Part of that way that the cosine may add at most.
const COSINE_MAX: f64 = 0.01;

/// The responses of one recording, by frequency and damping ratio of the contact.
#[derive(Debug, Default)]
pub(super) struct Responses(Mutex<BTreeMap<[u64; 2], Option<ContactResponse>>>);

impl Responses {
    /// Returns the response of a stop; `None` where it was not asked for before, since of one lever
    /// alone a pass over the samples says more.
    fn of(&self, seen: &Seen<'_>, frequency: f64, ratio: f64) -> Option<ContactResponse> {
        // A thread that panicked has not left half a list.
        let mut known = self.0.lock().unwrap_or_else(|held| held.into_inner());
        let stop = [frequency, ratio].map(f64::to_bits);
        match known.get_mut(&stop) {
            Some(response) => {
                Some(*response.get_or_insert_with(|| soft::response(seen, frequency, ratio)))
            }
            None => {
                if known.len() < KEPT_MAX {
                    known.insert(stop, None);
                }
                None
            }
        }
    }
}

/// (S8) Returns whether the lever certainly stays in contact throughout, the coast included, with no
/// more energy at the end than holds it there.
pub(super) fn stays_in_contact(terms: &Terms, subject: &Subject, seen: &Seen<'_>) -> bool {
    let (Some(responses), None, None) = (seen.responses, subject.initial, subject.window) else {
        return false;
    };
    let (lever, stop) = (&subject.lever, &subject.stop);
    let rest = -stop.rest_angle_rad(lever);
    let frequency = stop.contact_angular_frequency_rad_s(lever);
    let damping = stop.contact_damping_nm_s_per_rad(lever);
    let ratio = 0.5 * damping / (lever.moment_of_inertia_kg_m2 * frequency);
    if !(rest > 0.0 && ratio > 0.0 && ratio < 0.999) {
        return false;
    }
    let Some(response) = responses.of(seen, frequency, ratio) else {
        return false;
    };
    let compliance = 1.0 / (frequency * frequency);
    let spread = (1.0 - ratio * ratio).sqrt();
    let (factor, offset) = (seen.factor, seen.offset_m_s2.abs());
    // What a constant acceleration from rest on does, by either way of (S3).
    let phase = frequency * terms.interval;
    let arch = 0.125 * phase * phase * (1.0 + 2.0 * ratio) / spread;
    let shift = (2.0 + 1.0 / spread + arch) * offset * compliance;
    let most = (factor * response.least).max(factor * response.most) + shift;
    let far = factor.abs() * response.far + shift;
    // What the cosine adds, doubled, by the integral of the impulse response's magnitude and by the
    // sum that a pass over the samples makes.
    let fading = libm::exp(-PI * ratio / spread);
    let settling = (1.0 + fading) / (1.0 - fading);
    let summed = phase / ((1.0 - libm::exp(-ratio * phase)) * spread);
    let depth = 2.0 * (rest + terms.gain * far);
    let push = terms.gain * seen.at_most_either_way();
    let added = push * depth * depth * settling.max(summed) * compliance;
    let of_offset = offset * (1.0 + 1.0 / (1.0 - ratio).sqrt()) / frequency;
    let end = terms.gain * (factor.abs() * response.end + of_offset) + 2.5 * frequency * added;
    added <= COSINE_MAX * rest
        && terms.gain * most + added <= WAY_MAX * rest
        && end <= WAY_MAX * frequency * rest * (1.0 - ratio).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::{Decided, SeenBefore, decide, measure, peak_at_most};
    use super::*;
    use latchgate_kernel::model::Design;
    use latchgate_kernel::model::stop::StopModel;
    use latchgate_kernel::signal::Signal;
    use latchgate_kernel::units::{OpensWhen, SampleRate};

    /// Whatever is said of many levers at once, a pass over the samples says of each.
    #[test]
    fn prop_what_is_said_of_all_levers_in_contact_holds_for_each() {
        let mut state = 7_u64;
        let mut random = |least: f64, most: f64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            least + (most - least) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut asked, mut held) = (0, 0);
        for _ in 0..60 {
            let (peak, noise, tone) = (random(1.0, 300.0), random(0.0, 20.0), random(50.0, 3000.0));
            let hertz = random(2_000.0, 40_000.0);
            let samples = (0..600).map(|index| {
                let time = f64::from(index) / hertz;
                peak * libm::sin(6.3 * tone * time) * libm::exp(-time * 100.0)
                    + random(-noise, noise)
            });
            let Ok(rate) = SampleRate::from_hertz(hertz) else {
                continue;
            };
            let signal = Signal {
                start_s: 0.0,
                rate,
                samples: samples.collect(),
            };
            let known = SeenBefore::of(&signal);
            let mut design = Design::reference();
            design.stop.damping_n_s_per_m *= random(0.1, 8.0);
            for _ in 0..40 {
                design.lever.preload_torque_nm = random(0.05, 8.0);
                design.lever.mass_kg = random(0.05, 0.5);
                let subject = Subject {
                    lever: design.lever,
                    stop: design.stop,
                    model: StopModel::Soft,
                    threshold_rad: 0.1,
                    initial: None,
                    window: None,
                };
                let one = Seen::known(&signal, &known, OpensWhen::Negative);
                let seen = one.changed(random(0.9, 1.1), random(-1.0, 1.0));
                let alone = Seen {
                    responses: None,
                    ..seen
                };
                asked += 1;
                assert_eq!(decide(&subject, &seen), decide(&subject, &alone));
                assert_eq!(
                    peak_at_most(&subject, &seen),
                    peak_at_most(&subject, &alone)
                );
                let Some(terms) = Terms::of(&subject, &seen) else {
                    continue;
                };
                if stays_in_contact(&terms, &subject, &seen) {
                    held += 1;
                    let pass = measure(&subject, &alone, false);
                    assert_eq!(pass.answer(), Some(Decided::Pass));
                    assert_eq!(pass.peak_at_most, Some(0.0));
                }
            }
        }
        assert!((500..2000).contains(&held), "{held} of {asked}");
    }
}
