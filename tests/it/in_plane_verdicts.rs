//! A second in-plane channel in verdicts: what it does to the lever, what is refused, and what one channel leaves out.
//!
//! Peaks are those of a Taylor series of both accelerations at 200 bits (see `in_plane`).

use crate::support::{Done, Folder, finish, latchgate, program};
use latchgate_kernel::units::SampleRate;
use latchgate_recording::{Channel, Stated, axis_of};
use serde_json::Value;
use std::fs;

/// A lever that turns about a vertical axis, its centre of mass behind the pivot at this angle [degrees].
fn design(angle_deg: f64) -> String {
    let (sine, cosine) = libm::sincos(angle_deg.to_radians());
    format!(
        "name = \"handle\"\nbase = \"paper\"\n[lever]\naxis = [0.0, 0.0, 1.0]\ncenter_of_mass = [{}, {}, 0.0]\n\
         [tolerance]\npreload_torque_nm = 0\nmass_kg = 0\n",
        -0.065 * cosine,
        -0.065 * sine
    )
}

const CARD: &str = "synthetic = true\nopens_when = \"negative\"\n";

/// Trapezoids of 5, 10 and 5 ms along Y and X [g], as a table with two channels.
fn table(y_g: f64, x_g: f64) -> String {
    let shape = |t: f64| (t / 0.005).min((0.020 - t) / 0.005).clamp(0.0, 1.0);
    let row = |k: i32| {
        let t = f64::from(k) * 1e-4;
        format!("{t:.4},{:e},{:e}\n", x_g * shape(t), y_g * shape(t))
    };
    let rows: String = (-200..2000).map(row).collect();
    format!("t_s,acc_x_g,acc_y_g\n{rows}")
}

struct Files {
    folder: Folder,
    recording: String,
    design: String,
}

fn files(name: &str, table: &str, design: &str) -> Files {
    let folder = Folder::new(name);
    let recording = folder.write("two.csv", table);
    folder.write("two.csv.toml", CARD);
    let design = folder.write("design.toml", design);
    Files {
        folder,
        recording,
        design,
    }
}

impl Files {
    fn replay(&self, further: &[&str]) -> Done {
        let mut arguments = vec!["replay", &self.recording, "--design", &self.design];
        arguments.extend(["--channel", "acc_y_g", "--format", "json"]);
        arguments.extend(further);
        latchgate(&arguments)
    }

    fn document(&self, further: &[&str]) -> Value {
        let done = self.replay(further);
        assert!(done.code != 2 && done.code != 4, "{}", done.err);
        done.document()
    }
}

const ACROSS: [&str; 2] = ["--radial-channel", "acc_x_g"];

/// The nominal lever on a rigid stop, along straight lines between the samples as recorded.
const PLAIN: [&str; 9] = [
    "--no-report",
    "--members=0",
    "--model=rigid",
    "--between=linear",
    "--filter=none",
    "--bias=none",
    "--radial-channel=acc_x_g",
    "--log=error",
    "--threads=1",
];

fn peak(document: &Value) -> f64 {
    document["nominal"]["peak_angle_rad"].as_f64().unwrap()
}

#[test]
fn verif_the_second_channel_turns_a_verdict() {
    let cases = [
        (0.0, 0.156_747_191_175_469_43, "fail"),
        (20.0, 0.173_842_738_004_834_8, "fail"),
        (-20.0, 0.140_978_543_813_911, "fail"),
        (100.0, 0.256_354_150_461_219_4, "fail"),
        (-100.0, 0.090_203_050_940_178_45, "pass"),
    ];
    for (outwards_g, expected, verdict) in cases {
        // The centre of mass lies behind the pivot: outwards is backwards.
        let name = format!("in-plane-{outwards_g}");
        let files = files(&name, &table(-5.0, -outwards_g), &design(0.0));
        let document = files.document(&PLAIN);
        assert_eq!(document["verdict"], verdict, "{outwards_g}");
        let found = peak(&document);
        assert!((found - expected).abs() < 1e-13, "{outwards_g}: {found}");
        assert_eq!(document["in_plane"]["second_axis"], "X");
    }
}

/// One sensor whose channel is zero changes no bit of the nominal run.
#[test]
fn verif_a_second_channel_of_zeros_changes_no_bit() {
    let files = files("in-plane-zeros", &table(-5.0, 0.0), &design(0.0));
    let both = files.document(&["--no-report", "--members=0", "--radial-channel=acc_x_g"]);
    let alone = files.document(&["--no-report", "--members=0"]);
    for key in ["nominal", "models", "error_budget_rad"] {
        assert_eq!(both[key], alone[key], "{key}");
    }
}

/// Lever and accelerations turned together about the pivot's axis give the same motion, whatever door it is.
#[test]
fn verif_turning_lever_and_accelerations_together_changes_nothing() {
    // Along the way of the centre of mass −5 g, outwards 40 g.
    let (along, outwards) = (-5.0, 40.0);
    let mut peaks = Vec::new();
    for angle_deg in [0.0, 30.0, -50.0] {
        let (sine, cosine) = libm::sincos(f64::to_radians(angle_deg));
        // Of a left door with its centre of mass at this angle behind the pivot: radial (−cos, −sin), tangential (sin, −cos).
        let x = -outwards * cosine + along * sine;
        let y = -outwards * sine - along * cosine;
        let name = format!("in-plane-turned-{angle_deg}");
        let left = files(&name, &table(y, x), &design(angle_deg));
        peaks.push(peak(
            &left.document(&[&PLAIN[..], &["--opens-when=positive"]].concat()),
        ));
        let name = format!("in-plane-mirrored-{angle_deg}");
        let right = files(&name, &table(-y, x), &design(angle_deg));
        peaks.push(peak(
            &right.document(&[&PLAIN[..], &["--opens-when=negative"]].concat()),
        ));
    }
    for found in &peaks {
        assert!((found - peaks[0]).abs() < 1e-12, "{peaks:?}");
    }
}

#[test]
fn verif_both_channels_are_scattered_drawn_and_verified() {
    let files = files("in-plane-report", &table(-5.0, -20.0), &design(20.0));
    let out = files.folder.path().join("report");
    let out = out.to_str().unwrap();
    let document = files.document(&[&ACROSS[..], &["--members=128", "--out", out]].concat());
    let drivers = document["ensemble"]["drivers"].as_array().unwrap();
    for parameter in ["input.scale", "input.radial_scale", "input.radial_bias_g"] {
        let varies = |driver: &Value| driver["parameter"] == parameter;
        assert!(drivers.iter().any(varies), "{parameter}");
    }
    let codes: Vec<&Value> = document["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|finding| &finding["code"])
        .collect();
    assert!(codes.contains(&&Value::from("in-plane-door")), "{codes:?}");
    assert!(
        !codes.contains(&&Value::from("radial-left-out")),
        "{codes:?}"
    );
    let picture = fs::read_to_string(format!("{out}/acceleration.svg")).unwrap();
    assert!(picture.contains("acc_x_g, across, as used"));
    let page = fs::read_to_string(format!("{out}/report.html")).unwrap();
    assert!(page.contains("Second in-plane channel"));
    // Cosine and sine of 20°.
    let mut arguments = vec!["replay", &files.recording, "--design", &files.design];
    arguments.extend(["--channel", "acc_y_g", "--members", "0", "--no-report"]);
    arguments.extend(ACROSS);
    let told = latchgate(&arguments).out;
    let told = told.split_whitespace().collect::<Vec<_>>().join(" ");
    let sums = "right door: 0.94 Y + 0.342 X along the lever's way, 0.342 Y \u{2212} 0.94 X across";
    assert!(told.contains(sums), "{told}");
    let verified = latchgate(&["verify", &format!("{out}/verdict.json")]);
    assert_eq!(verified.code, 0, "{}{}", verified.out, verified.err);
}

/// A constant acceleration along the arm as large as the neighbour's peak would take the pass.
#[test]
fn verif_one_channel_says_what_it_leaves_out() {
    let cases = [
        (
            "could take it",
            -3.0,
            100.0,
            Some("this pass hangs on what was left out"),
        ),
        ("could not", -0.5, 1.0, None),
    ];
    for (name, y_g, x_g, expected) in cases {
        let folder = format!("in-plane-left-out-{x_g}");
        let files = files(&folder, &table(y_g, x_g), &design(0.0));
        let document = files.document(&["--no-report", "--members=0"]);
        assert_eq!(document["verdict"], "pass", "{name}");
        let findings = document["findings"].as_array().unwrap();
        let left_out = findings
            .iter()
            .find(|finding| finding["code"] == "radial-left-out");
        let text = left_out.expect(name)["text"].as_str().unwrap();
        assert!(text.contains("acc_x_g reaches"), "{name}: {text}");
        let hangs = text.contains("this pass hangs on what was left out");
        assert_eq!(hangs, expected.is_some(), "{name}: {text}");
        let why = document["why"].as_array().unwrap();
        let told = why.iter().any(|reason| reason["code"] == "radial-left-out");
        assert!(told, "{name}: {why:?}");
    }
}

/// Other axes drive a lever whose way is oblique to Y: what one channel shows cannot pass it.
#[test]
fn verif_one_channel_cannot_pass_an_oblique_lever() {
    let files = files("in-plane-oblique", &table(0.5, 1.0), &design(45.0));
    let document = files.document(&["--no-report", "--members=0"]);
    assert_eq!(document["verdict"], "undecided", "{}", document["why"]);
    assert_eq!(document["why"][0]["code"], "radial-left-out");
    let both = files.document(&["--no-report", "--members=0", "--radial-channel=acc_x_g"]);
    assert_eq!(both["verdict"], "pass", "{}", both["why"]);
}

/// A side that the code contradicts, and a velocity that no crash has, stand against a pass.
#[test]
fn verif_a_second_channel_that_contradicts_forbids_a_pass() {
    let coded = |x_g: f64| {
        let named = table(0.2, x_g).replace("acc_x_g", "11SILL0000LEACX0 (g)");
        named.replace("acc_y_g", "11SILL0000LEACY0 (g)")
    };
    // Negative acceleration opens the right door, and the code says left.
    let cases = [
        ("side", coded(1.0), "negative", "in-plane-side"),
        ("velocity", coded(3000.0), "positive", "in-plane-velocity"),
    ];
    for (name, table, opens_when, code) in cases {
        let folder = Folder::new(&format!("in-plane-against-{name}"));
        let recording = folder.write("two.csv", table);
        folder.write("two.csv.toml", "synthetic = true\n");
        let design = folder.write("design.toml", design(0.0));
        let done = latchgate(&[
            "replay",
            &recording,
            "--design",
            &design,
            "--channel=3",
            "--radial-channel=2",
            "--opens-when",
            opens_when,
            "--members=0",
            "--no-report",
            "--set=lever.preload_torque_nm=50",
            "--format=json",
        ]);
        let document = done.document();
        assert_eq!(
            document["verdict"], "undecided",
            "{name}: {}{}",
            document["why"], done.err
        );
        assert_eq!(document["why"][0]["code"], code, "{name}");
    }
}

#[test]
fn verif_what_is_no_second_channel_is_refused() {
    let three = table(-5.0, 20.0).replace("acc_x_g", "acc_z_g");
    let askew = design(0.0).replace("[0.0, 0.0, 1.0]", "[0.0, 0.3, 1.0]");
    let beside = "--radial-channel=acc_x_g";
    let cases = [
        (
            "itself",
            table(-5.0, 0.0),
            design(0.0),
            "--radial-channel=acc_y_g",
            "alike",
        ),
        (
            "none",
            table(-5.0, 0.0),
            design(0.0),
            "--radial-channel=acc_w_g",
            "acc_w_g",
        ),
        (
            "another axis",
            three,
            design(0.0),
            "--radial-channel=acc_z_g",
            "along X",
        ),
        (
            "an axis behind a unit",
            table(-5.0, 20.0).replace("acc_x_g", "acc_z (m/s2)"),
            design(0.0),
            "--radial-channel=acc_z (m/s2)",
            "along X",
        ),
        (
            "another place",
            table(-5.0, 20.0).replace("acc_x_g", "head_acc_x_g"),
            design(0.0),
            "--radial-channel=head_acc_x_g",
            "of the place of acc_y_g",
        ),
        (
            "an unknown axis",
            table(-5.0, 20.0).replace("acc_x_g", "foo (g)"),
            design(0.0),
            "--radial-channel=foo (g)",
            "an axis in the code or name",
        ),
        (
            "the same samples",
            table(-5.0, -5.0),
            design(0.0),
            beside,
            "alike",
        ),
        ("no plane", table(-5.0, 0.0), askew, beside, "along X or Z"),
        (
            "across alone",
            table(-5.0, 0.0),
            design(90.0),
            beside,
            "lateral acceleration turns",
        ),
        (
            "no axis",
            table(-5.0, 0.0),
            "name = \"lever\"\nbase = \"paper\"\n".into(),
            beside,
            "lever.axis",
        ),
    ];
    for (name, table, design, option, part) in cases {
        let files = files(
            &format!("in-plane-no-{}", name.replace(' ', "-")),
            &table,
            &design,
        );
        let done = files.replay(&["--no-report", option]);
        assert_eq!(done.code, 4, "{name}: {}", done.err);
        assert!(done.err.contains(part), "{name}: {}", done.err);
    }
    let files = files("in-plane-sensitivity", &table(-5.0, 0.0), &design(0.0));
    let done = files.replay(&[beside, "--sensitivity=20 g/V"]);
    assert_eq!(done.code, 2, "{}", done.err);
}

#[test]
fn reads_the_axis_of_a_channel() {
    let cases = [
        ("acc_x_g", None, Some(('X', false))),
        ("/door/imu:linear_acceleration.z", None, Some(('Z', false))),
        ("lateral acceleration", None, Some(('Y', false))),
        ("accX", None, Some(('X', false))),
        ("Querbeschleunigung", None, Some(('Y', false))),
        ("11SILL00LE00ACXA", None, Some(('X', false))),
        ("11SILL00LE00AC1A", None, Some(('X', true))),
        ("11SILL0000LEAC10 (g)", None, Some(('X', true))),
        ("accel z (m/s2)", None, Some(('Z', false))),
        ("longitudinal acceleration", None, Some(('X', false))),
        ("vertical", None, Some(('Z', false))),
        ("curve 7", Some("DSRF XG"), Some(('X', false))),
        ("acceleration", None, None),
        ("x of y", None, None),
    ];
    for (name, location, expected) in cases {
        let channel = Channel {
            name: name.into(),
            unit: None,
            unit_source: "header",
            start_s: 0.0,
            rate: SampleRate::from_hertz(1e4).unwrap(),
            values: vec![0.0; 2],
            stated: Stated {
                location: location.map(String::from),
                ..Stated::default()
            },
            findings: Vec::new(),
            pulse: None,
        };
        let axis = axis_of(&channel).map(|axis| (axis.letter, axis.is_reversed));
        assert_eq!(axis, expected, "{name}");
    }
}

/// A gate takes two channels as a replay does: outwards acceleration opens, inwards holds.
#[test]
fn verif_a_gate_takes_the_second_channel() {
    for (inwards_g, code) in [(150.0, 0), (-20.0, 1)] {
        let name = format!("in-plane-gate-{inwards_g}");
        let files = files(&name, &table(-5.0, inwards_g), &design(0.0));
        let gate = "[[recordings]]\nfiles = [\"two.csv\"]\nchannel = \"acc_y_g\"\nradial_channel = \"acc_x_g\"\n\
                    opens_when = \"negative\"\nmembers = 128\n[[designs]]\nfile = \"design.toml\"\n";
        files.folder.write("gate.toml", gate);
        let arguments = ["gate", "gate.toml", "--out", "out", "--reports", "none"];
        let done = finish(program().current_dir(files.folder.path()).args(arguments));
        assert_eq!(done.code, code, "{inwards_g}: {}{}", done.out, done.err);
    }
}
