//! Guards the answers on damaged copies and on real recordings.

use super::*;

use super::settings::check_unusable;

/// Cuts a table at a share of its peak and keeps the digits of its numbers.
fn clipped(text: &str, share: f64) -> String {
    let values = || {
        text.lines()
            .skip(1)
            .map(|line| line.split_once(',').unwrap())
    };
    let peak = values()
        .map(|(_, value)| value.parse::<f64>().unwrap().abs())
        .fold(0.0, f64::max);
    let limit = share * peak;
    values().fold(
        format!("{}\n", text.lines().next().unwrap()),
        |out, (time, value)| {
            let value: f64 = value.parse().unwrap();
            out + &format!("{time},{:.4}\n", value.clamp(-limit, limit))
        },
    )
}

#[test]
fn cli_a_clipped_copy_of_the_surviving_pulse_never_passes() {
    let folder = Folder::new("clipped");
    let text = fs::read_to_string(signal_file("surviving.csv")).unwrap();
    let card = fs::read_to_string(signal_file("surviving.csv.toml")).unwrap();
    for share in [0.95, 0.8, 0.5] {
        for with_card in [true, false] {
            let name = format!("{share}-{with_card}.csv");
            let file = folder.write(&name, clipped(&text, share));
            if with_card {
                folder.write(&format!("{name}.toml"), &card);
            }
            let document = check_unusable(&["replay", &file], "saturated");
            assert!(document["findings"].to_string().contains("clipping"));
        }
    }
    // The copy that nothing was cut from still passes: it is the clipping that is seen.
    let file = folder.write("whole.csv", clipped(&text, 1.0));
    let told = ["--velocity-change", "0.22", "--transfer", "1"];
    check_verdict(&[&["replay", &file][..], &told].concat(), 0, "pass");
}

/// Part 1 of the rule: what was lost before the fault stays lost; what was lost after it is not known.
#[test]
fn cli_a_fault_after_the_crossing_does_not_save_the_door() {
    let folder = Folder::new("order");
    let open = |t: f64, start: f64| half_sine(t, start, 0.03, -20.0);
    let loud = |t: f64, start: f64| half_sine(t, start, 0.01, 300.0).min(100.0);
    let rough = |t: f64| 0.01 * (t * 9_100.0).sin();
    let early = folder.write(
        "early.csv",
        table(|t| open(t, 0.0) + loud(t, 0.1) + rough(t).min(0.0)),
    );
    let document = check_verdict(&["replay", &early, "--opens-when", "negative"], 1, "fail");
    let why = document["why"].to_string();
    assert!(why.contains("failed-before-fault"), "{why}");
    assert!(document["findings"].to_string().contains("clipping"));
    let late = folder.write(
        "late.csv",
        table(|t| open(t, 0.1) + loud(t, 0.0) + rough(t).min(0.0)),
    );
    let document = check_unusable(
        &["replay", &late, "--opens-when", "negative"],
        "The channel was saturated",
    );
    assert!(document["nominal"]["first_crossing_s"].as_f64().unwrap() > 0.1);
}

const RAW: [&str; 6] = ["--unit", "g", "--filter", "none", "--bias", "none"];

/// Figures of curve 148 of NHTSA test 7292 as recorded, on the rigid stop, from an integration
/// in quadruple precision.
#[test]
fn val_cli_curve_148_reaches_the_reference_peaks() {
    let path = data("recordings/nhtsa_v07292.148");
    let file = path.to_str().unwrap();
    for (sign, code, verdict, peak) in [
        // What lies between the samples changes the order of its impacts, so that the nominal
        // run alone decides nothing.
        ("negative", 3, "undecided", 0.053_142_473_084_1),
        ("positive", 1, "fail", 1.238_497_634_5),
    ] {
        let arguments = [
            &["replay", file, "--model", "rigid", "--opens-when", sign][..],
            &["--members", "0", "--between", "linear"],
            &RAW[..],
        ]
        .concat();
        let document = check_verdict(&arguments, code, verdict);
        let found = document["nominal"]["peak_angle_rad"].as_f64().unwrap();
        assert!(
            (found - peak).abs() < 1e-9 * peak,
            "{sign}: {found}, expected {peak}"
        );
    }
}

/// A dead and a clipped channel pass under no combination of options.
#[test]
fn val_cli_faulty_channels_never_pass() {
    for curve in ["038", "056"] {
        let path = data(&format!("recordings/nhtsa_v07292.{curve}"));
        let file = path.to_str().unwrap();
        for sign in [
            &[][..],
            &["--opens-when", "negative"],
            &["--opens-when", "positive"],
            &["--opens-when", "both"],
        ] {
            for filter in [&[][..], &["--filter", "none"], &["--filter", "cfc60"]] {
                for bias in [&[][..], &["--bias", "none"]] {
                    for model in ["auto", "rigid", "soft"] {
                        let arguments = [
                            &[
                                "replay",
                                file,
                                "--unit",
                                "g",
                                "--no-report",
                                "--format",
                                "json",
                                "--model",
                                model,
                            ],
                            sign,
                            filter,
                            bias,
                        ]
                        .concat();
                        let done = latchgate(&arguments);
                        assert!(
                            matches!(done.code, 1 | 4),
                            "{arguments:?}: exit {}",
                            done.code
                        );
                        let verdict = done.document()["verdict"].clone();
                        assert_eq!(verdict, if done.code == 1 { "fail" } else { "unusable" });
                    }
                }
            }
        }
    }
}
