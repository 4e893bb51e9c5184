//! Faults in the samples of a table that is well written.

use super::{Case, FROM, TO, g, good, push, s};

/// A table whose samples [g] are `of(k)`, and the card beside it.
fn case(name: &str, card: &str, of: impl Fn(i64) -> f64) -> Case {
    let text = |k: i64| format!("{:.3}", of(k));
    let rows: String = (FROM..TO)
        .map(|k| format!("{},{}\n", s(k), text(k)))
        .collect();
    let read = good(name, format!("time_s,acc_y_g\n{rows}")).unit("g", text);
    if card.is_empty() {
        read
    } else {
        read.beside(&format!("{name}.toml"), card)
    }
}

/// The noise of the push alone.
fn noise(k: i64) -> f64 {
    if (0..200).contains(&k) {
        push(k) - 30.0 * (std::f64::consts::PI * k as f64 / 200.0).sin()
    } else {
        push(k)
    }
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = saturation();
    cases.extend(stretches());
    cases.extend(suspicions());
    cases
}

fn saturation() -> Vec<Case> {
    let clipping = ["blocking clipping"];
    vec![
        case("whole.csv", "", push),
        case("range-wide.csv", "range_g = 200.0\n", push),
        case("clipped.csv", "", |k| push(k).min(20.0)).unusable(&clipping, &["saturated"]),
        case("clipped-below.csv", "", |k| (-push(k)).max(-20.0))
            .positive_opens()
            .unusable(&clipping, &["saturated"]),
        case("beyond-range.csv", "range_g = 30.0\n", push).unusable(&clipping, &["full scale"]),
        case("clipped-short.csv", "", |k| push(k).min(29.0)).unusable(&clipping, &["saturated"]),
        // 2^12 quanta of 7 mg, the last code of a converter of 13 bits, and the last bit trembles.
        case("converter.csv", "", |k| {
            let formula = 35.0 * (std::f64::consts::PI * k as f64 / 200.0).sin();
            let pulse = if (0..200).contains(&k) {
                formula / 0.007
            } else {
                0.0
            };
            0.007 * (pulse.round() + (k * k).rem_euclid(3) as f64).min(4096.0)
        })
        .unusable(&clipping, &["saturated"]),
        // A flat top of a formula is none of a sensor.
        case("declared.csv", "synthetic = true\n", |k| push(k).min(20.0))
            .finds(&["info synthetic"]),
        case("trapezium.csv", "", |k| match k {
            0..20 => k as f64,
            20..180 => 20.0,
            180..200 => (200 - k) as f64,
            _ => 0.0,
        })
        .unusable(
            &["blocking clipping", "warning noise-unknown"],
            &["synthetic = true"],
        ),
    ]
}

fn stretches() -> Vec<Case> {
    vec![
        case("dead.csv", "", |_| 0.0).unusable(&["blocking dead-sensor"], &["no motion"]),
        case("flicker.csv", "", |k| if k % 3 == 0 { 0.01 } else { 0.0 }).unusable(
            &["blocking dead-sensor", "warning implausible-velocity"],
            &["flicker"],
        ),
        // The cable comes off in the push, and the channel stands at its end.
        case("frozen-loud.csv", "", |k| {
            if k < 60 { push(k) } else { 201.038 }
        })
        .unusable(
            &[
                "blocking clipping",
                "blocking ends-inside-event",
                "warning ends-early",
                "warning implausible-velocity",
                "warning zero-shift",
            ],
            &["unusable"],
        ),
        case("frozen-quiet.csv", "", |k| {
            if (220..420).contains(&k) {
                0.25
            } else {
                push(k)
            }
        })
        .unusable(&["blocking frozen"], &["a chance below 1e-9"]),
        case("drop-out.csv", "", |k| {
            if (90..110).contains(&k) { 0.0 } else { push(k) }
        })
        .unusable(&["blocking drop-out"], &["lost"]),
        case("spike.csv", "", |k| if k == 300 { 25.0 } else { push(k) }).finds(&["warning spike"]),
        case("starts-inside.csv", "", |k| push(k - FROM + 60)).unusable(
            &[
                "blocking starts-inside-event",
                "blocking ends-inside-event",
                "warning ends-early",
                "warning pre-event-not-quiet",
                "warning drift",
            ],
            &["The start of the event is missing"],
        ),
        case("ends-inside.csv", "", |k| push(k - TO + 100)).unusable(
            &[
                "blocking ends-inside-event",
                "warning ends-early",
                "warning implausible-velocity",
            ],
            &["The end of the event is missing"],
        ),
    ]
}

fn suspicions() -> Vec<Case> {
    vec![
        // 6 g, and 0.75 m/s: less than a crash gives, and legitimate if a person says so.
        case("weak.csv", "", |k| {
            (push(k) - noise(k)) / 5.0 + noise(k) / 20.0
        })
        .exit(3)
        .finds(&["warning implausible-velocity"]),
        case("weak-stated.csv", "velocity_change_m_s = 0.8\n", |k| {
            (push(k) - noise(k)) / 5.0 + noise(k) / 20.0
        })
        .finds(&["info velocity-stated"]),
        case("gravity.csv", "", |k| push(k) + 1.0).finds(&["warning gravity-suspected"]),
        case("zero-shift.csv", "", |k| {
            if k > 100 { push(k) + 3.0 } else { push(k) }
        })
        .finds(&["warning zero-shift"]),
        case("g-for-ms2.csv", "", |k| push(k) * 9.806_65)
            .exit(3)
            .finds(&["warning implausible-velocity"]),
        case("ms2-for-g.csv", "", |k| push(k) / 9.806_65)
            .exit(3)
            .finds(&["warning implausible-peak", "warning implausible-velocity"]),
        case("aliased.csv", "", |k| {
            let ringing = if (20..180).contains(&k) { 25.0 } else { 0.0 };
            push(k) + if k % 2 == 0 { ringing } else { -ringing }
        })
        .exit(3)
        .finds(&["warning aliasing-suspected", "warning spike"]),
        // Declared the other way round, the same push opens the lever.
        case("opens.csv", "", |k| -push(k)).exit(1),
        case("no-pre-event.csv", "", push)
            .options(&["--time-zero", "-0.02"])
            .clock(10_000.0, 0.0)
            .finds(&["warning no-pre-event-data"]),
        good(
            "neighbours.csv",
            "time_s,acc_y_left (g),acc_y (g)\n".to_string()
                + &(FROM..TO)
                    .map(|k| format!("{},{},{}\n", s(k), g(k), g(k)))
                    .collect::<String>(),
        )
        .options(&["--channel", "acc_y (g)"])
        .channel("acc_y (g)"),
    ]
}
