//! Units of columns and of times that a header or the stamps themselves make doubtful.

use super::super::{Case, g, good, refused};
use super::{clocked, plain, table};

/// Header cells that end in a unit which is not that of the column.
pub(super) fn doubtful_units() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, name) in [
        "acc_y in 100 g",
        "acc_y 100 g",
        "acc_y (x 9.81 m/s2)",
        "acc_y mV/g",
        "acc_y [g*s]",
        "acc_y [g·s]",
        "acc_y (0.1 g)",
        "acc_y counts / g",
        "acc_y k m/s2",
        "acc_y [k m/s2]",
        "acc_y m g",
        "acc_y milli g",
        "acc_y range 50 g",
        "acc_y (range 50 g",
        "acc_y (m/s2) / g",
        "acc_y_g (m/s2)",
        "acc_y (g) x10",
        "acc_y*10 [g]",
        "acc_y / 10 [g]",
        "acc_y x 100 [g]",
        "acc_y x10 g",
        "acc_y_100_g",
        "acc_y_mV_g",
        "acc_y [m/s2)",
        "acc_y [m/s*s]",
    ]
    .iter()
    .enumerate()
    {
        let text = plain(&format!("time_s,{name}"));
        let file = |kind: &str| format!("doubtful-unit-{kind}{index}.csv");
        let way_on = match name.contains("counts") || name.contains("mV") {
            true => "--sensitivity",
            false => "--unit",
        };
        cases.push(refused(&file(""), text.clone(), &[]).says(&[
            name,
            "each with its doubt",
            "--channel",
        ]));
        cases.push(
            refused(&file("told-"), text, &["unit of acceleration", way_on])
                .options(&["--channel", "2"]),
        );
    }
    for (index, name) in [
        "Acceleration Y g",
        "acc y / g",
        "ay/g",
        "Beschleunigung Y in g",
        "S12 Y acceleration g",
        "acc (g) y2",
        "acc_y_2_g",
        "Beschl. quer [g]",
        "acc_y (G's)",
        "acc 1 y [g]",
        "acc 1/2 y [g]",
        "acc_y (G's) 'left'",
    ]
    .iter()
    .enumerate()
    {
        cases.push(
            good(
                &format!("stated-unit-{index}.csv"),
                plain(&format!("time_s,{name}")),
            )
            .channel(name),
        );
    }
    cases
}

/// Units of time that the header or the stamps themselves contradict, and stamps that repeat.
pub(super) fn doubtful_times() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, name) in [
        "time x100 us",
        "time in 2 ms",
        "time_2us",
        "time_cycles",
        "time_h2",
        "Timestamp ticks",
    ]
    .iter()
    .enumerate()
    {
        cases.push(refused(
            &format!("doubtful-time-{index}.csv"),
            plain(&format!("{name},acc_y_g")),
            &["a known unit of time", "--time-unit"],
        ));
    }
    // Seconds that the header calls nanoseconds.
    for (index, name) in ["time_ns", "Timestamp ns"].iter().enumerate() {
        cases.push(refused(
            &format!("ns-over-seconds-{index}.csv"),
            plain(&format!("{name},acc_y_g")),
            &["Hz by", "--time-unit"],
        ));
    }
    cases.extend([
        refused(
            "ms-over-seconds.csv",
            plain("t (ms),acc_y_g"),
            &["Hz by the time column `t (ms)`", "--time-unit"],
        ),
        good("ms-over-seconds-told.csv", plain("t (ms),acc_y_g"))
            .options(&["--time-unit", "s"])
            .finds(&["warning time-unit-overridden"]),
        refused(
            "stamps-coarse.csv",
            clocked(10_000.0, 3),
            &[":3", "time must increase", "--rate-hz"],
        ),
        good("stamps-coarse-rate.csv", clocked(10_000.0, 3))
            .options(&["--rate-hz", "10000"])
            .finds(&["warning stamps-coarse"]),
        good("stamps-coarse-12khz.csv", clocked(12_000.0, 4))
            .options(&["--rate-hz", "12000"])
            .clock(12_000.0, -200.0 / 12_000.0)
            .finds(&["warning stamps-coarse"]),
        good(
            "stamps-of-three-digits.csv",
            table("time_s,acc_y_g", |k| {
                format!("{:.2E},{}", k as f64 / 2e3, g(k))
            }),
        )
        .samples(403)
        .clock(2_000.0, -0.1)
        .unusable(
            &[
                "blocking stamp-doubled",
                "blocking gap",
                "warning ends-early",
                "warning rate-below-default-filter",
            ],
            &["holds 0.101 s twice", "--rate-hz"],
        ),
        good(
            "stamps-of-three-digits-rate.csv",
            table("time_s,acc_y_g", |k| {
                format!("{:.2E},{}", k as f64 / 2e3, g(k))
            }),
        )
        .options(&["--rate-hz", "2000"])
        .clock(2_000.0, -0.1)
        .finds(&["warning stamps-coarse", "warning rate-below-default-filter"]),
        refused(
            "stamps-coarse-other-rate.csv",
            clocked(10_000.0, 3),
            &["repeat and are off"],
        )
        .options(&["--rate-hz", "9500"]),
        // A row too many among coarse stamps moves all that follow.
        refused(
            "stamps-coarse-missing.csv",
            clocked(10_000.0, 3).replace(
                &(100..130)
                    .map(|k| format!("{:.3},{}\n", k as f64 / 1e4, g(k)))
                    .collect::<String>(),
                "",
            ),
            &["repeat and are off"],
        )
        .options(&["--rate-hz", "10000"]),
        refused(
            "jump.csv",
            table("time_s,acc_y_g", |k| {
                let stamp = k as f64 / 1e4 + if k < 100 { 0.0 } else { 360_000.0 };
                format!("{stamp:.4},{}", g(k))
            }),
            &["samples", "0.0099", "later"],
        ),
    ]);
    cases
}
