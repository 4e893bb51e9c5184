//! Guards what three axes at rest say of their unit.

use crate::mcap::{channel, file, imu, imu_schema, message, statistics};
use crate::support::{Folder, half_sine, latchgate};

const CODE: &str = "gravity-contradicts-unit";

/// A table of three axes, in that order, that rest at `rest` and are pushed along y.
fn axes(header: &str, rest: [f64; 3]) -> String {
    let mut text = format!("{header}\n");
    for index in -300..2000 {
        let t = f64::from(index) / 10_000.0;
        let noise = |phase: f64| 0.01 * (t * 9_100.0 + phase).sin();
        let [x, y, z] = rest;
        let push = half_sine(t, 0.0, 0.05, 20.0);
        text += &format!(
            "{t:.4},{:.4},{:.4},{:.4}\n",
            x + noise(0.0),
            y + push + noise(1.0),
            z + noise(2.0)
        );
    }
    text
}

/// Whether the axes contradict their unit, and whether that blocks.
fn severity(text: &str, options: &[&str]) -> Option<String> {
    let folder = Folder::new(&format!("gravity-{}", text.len() + options.len()));
    let path = folder.write("a.csv", text);
    let asked = [
        "--opens-when",
        "negative",
        "--members",
        "0",
        "--no-report",
        "--format",
        "json",
    ];
    let done = latchgate(&[&["replay", &path][..], &asked, options].concat());
    let document = done.document();
    let findings = document["findings"].as_array().unwrap();
    let found = findings.iter().find(|one| one["code"] == CODE)?;
    let blocks = found["severity"] == "blocking";
    assert_eq!(blocks, done.code == 4, "{}", done.err);
    Some(found["severity"].as_str().unwrap().to_string())
}

/// Words that say that gravity is in the samples make it block, in whichever language; without them, and
/// where they say the contrary, a wrong norm is a warning.
#[test]
fn verif_axes_at_rest_tell_their_unit() {
    let tilted = [0.6, -0.48, 0.64];
    for (header, rest, expected) in [
        (
            "t_s,ax (m/s2),ay (m/s2),az (m/s2)",
            [0.0, 0.0, 1.0],
            Some("warning"),
        ),
        ("t_s,ax (m/s2),ay (m/s2),az (m/s2)", tilted, Some("warning")),
        ("t_s,ax (m/s2),ay (m/s2),az (m/s2)", [0.1, 0.0, 9.8], None),
        (
            "t_s,acc_x_g,acc_y_g,acc_z_g",
            [0.0, 9.6, 2.0],
            Some("warning"),
        ),
        ("t_s,acc_x_g,acc_y_g,acc_z_g", [0.0, 0.0, 1.0], None),
        // Sensors that were set to zero say nothing.
        ("t_s,acc_x_g,acc_y_g,acc_z_g", [0.02, -0.01, 0.0], None),
        ("t_s,acc_x_g,acc_y_g,acc_z_g", [-2.8, 0.8, 0.3], None),
        // Whatever the axes are called, if there are three.
        (
            "t_s,längs [m/s²],acc quer [m/s²],hoch [m/s²]",
            [0.0, 0.0, 1.0],
            Some("warning"),
        ),
        (
            "t_s,a_x incl. gravity (m/s2),a_y incl. gravity (m/s2),a_z incl. gravity (m/s2)",
            [0.0, 0.0, 1.0],
            Some("blocking"),
        ),
        (
            "t_s,acc x mit Erdbeschleunigung (g),acc y mit Erdbeschleunigung (g),acc z mit Erdbeschleunigung (g)",
            [0.0, 0.0, 9.81],
            Some("blocking"),
        ),
        (
            "t_s,accelerationIncludingGravity x (m/s2),accelerationIncludingGravity y (m/s2),accelerationIncludingGravity z (m/s2)",
            [0.0, 0.0, 1.0],
            Some("blocking"),
        ),
        (
            "t_s,specific force x (m/s2),specific force y (m/s2),specific force z (m/s2)",
            [1.0, 0.0, 0.0],
            Some("blocking"),
        ),
        (
            "# accelerations include gravity\nt_s,ax (m/s2),ay (m/s2),az (m/s2)",
            [0.0, 0.0, 1.0],
            Some("blocking"),
        ),
        (
            "t_s,acc x without gravity (m/s2),acc y without gravity (m/s2),acc z without gravity (m/s2)",
            [0.0, 0.0, 1.0],
            Some("warning"),
        ),
        (
            "t_s,acc x centre of gravity (m/s2),acc y centre of gravity (m/s2),acc z centre of gravity (m/s2)",
            [0.0, 0.0, 1.0],
            Some("warning"),
        ),
    ] {
        let name = header.rsplit(',').nth(1).unwrap();
        let found = severity(&axes(header, rest), &["--channel", name]);
        assert_eq!(found.as_deref(), expected, "{header} {rest:?}");
    }
    // A lone g beside a unit leaves the unit open, so that a person states it.
    for words in ["with", "mit", "incl.", "con"] {
        let header = ["X", "Y", "Z"].map(|axis| format!("Acc{axis} {words} g (m/s2)"));
        let text = axes(&format!("t_s,{}", header.join(",")), tilted);
        let found = severity(&text, &["--channel", &header[1], "--unit", "m/s2"]);
        assert_eq!(found.as_deref(), Some("blocking"), "{words}");
    }
}

/// A log of an IMU that rests at that gravity and is pushed along y.
fn log(gravity: f64) -> Vec<u8> {
    let contact = 1_700_000_000_000_000_000_i64;
    let stamp = |k: i64| (contact + 500_000 * k) as u64;
    let body = |k: i64| {
        let t = k as f64 * 5e-4;
        let y = half_sine(t, 0.0, 0.05, 20.0 * gravity) + 0.01 * (t * 9_100.0).sin();
        imu::imu_message_cdr(stamp(k), "imu", [0.0, y, gravity])
    };
    let messages = (-100..400).map(|k| message(1, stamp(k), &body(k)));
    let topic = [imu_schema(1), channel(1, 1, "/imu", "cdr")];
    let records: Vec<Vec<u8>> = topic.into_iter().chain(messages).collect();
    file(&records, &[statistics(&[(1, 500)])])
}

/// The type of an IMU's message says m/s² and carries gravity, so that 1 at rest blocks, also where time
/// zero is not stated; the remedy that the message names works.
#[test]
fn verif_an_imu_at_rest_tells_its_unit() {
    let folder = Folder::new("gravity-imu");
    for (gravity, options, blocks) in [
        (1.0, &[][..], true),
        (9.81, &[], false),
        (1.0, &["--unit", "g"], false),
        (9.81, &["--unit", "g"], true),
    ] {
        let path = folder.write("a.mcap", log(gravity));
        for zero in [&["--time-zero", "1700000000"][..], &[]] {
            let asked = ["--opens-when", "negative", "--members", "0", "--no-report"];
            let done = latchgate(&[&["replay", &path][..], &asked, options, zero].concat());
            let what = format!("{gravity} {options:?} {zero:?}: {}", done.out);
            assert_eq!(done.out.contains(CODE), blocks, "{what}");
            assert_eq!(done.code == 4, blocks, "{what}");
            let listed = latchgate(&[&["inspect", &path][..], options, zero].concat());
            assert_eq!(listed.out.contains(CODE), blocks, "{what}");
        }
        if blocks && options.is_empty() {
            let done = latchgate(&["replay", &path, "--no-report"]);
            assert!(done.err.contains("--unit g"), "{}", done.err);
            assert!(done.err.contains("1.00 m/s2") && done.err.contains("9.81 m/s2"));
        }
    }
}
