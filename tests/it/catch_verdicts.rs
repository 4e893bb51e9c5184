//! An inertia catch in design files, verdicts, reports and the study.
//!
//! Expected instants and peaks are those of a Taylor series of both bodies at 200 bits (see `catch`).

use crate::support::{Done, Folder, finish, latchgate, program};
use latchgate_document::design_file::from_toml;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::model::tolerance::Tolerance;
use latchgate_kernel::pulse::{Pulse, Vertex};
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions};
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::signal::Projection;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};
use latchgate_study::catch;
use latchgate_verdict::ensemble::Scatter;
use serde_json::Value;
use std::fs;

/// The design of the study, as a file.
const DESIGN: &str = "\
name = \"with a catch\"
base = \"paper\"
[lever]
preload_torque_nm = 1.0
[catch]
moment_of_inertia_kg_m2 = 1e-6
pivot_damping_nm_s_per_rad = 1e-6
spring_stiffness_nm_per_rad = 0.002
preload_torque_nm = 0.0037
unbalance_kg_m = 4.8e-5
engagement_angle_rad = 0.15
end_stop_angle_rad = 0.3
lever_angle_rad = 0.06
rest_restitution = 0.4
end_stop_restitution = 0.4
engagement_restitution = 0.3
reversible = true
";

/// That levers made by it do not differ, which a pass needs to be told.
const ALIKE: &str = "[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\nrestitution = 0.02\n";

/// Two trapezoids of −40 g and 12 ms each, this far apart [ms], as a pulse's word.
fn two_pulses(gap_ms: f64) -> String {
    let second = 12.0 + gap_ms;
    let points = [
        (0.0, 0.0),
        (1.0, -40.0),
        (11.0, -40.0),
        (12.0, 0.0),
        (second, 0.0),
        (second + 1.0, -40.0),
        (second + 11.0, -40.0),
        (second + 12.0, 0.0),
    ];
    let points: Vec<String> = points
        .iter()
        .map(|(time, value)| format!("{time}:{value}"))
        .collect();
    format!(
        "pulse:polyline,points={},unit=g,rate=20kHz,tail=200ms",
        points.join("/")
    )
}

/// Replays the nominal lever of a design file on a rigid stop.
fn replayed(folder: &Folder, design: &str, recording: &str, further: &[&str]) -> Done {
    folder.write("design.toml", design);
    let design = folder.path().join("design.toml");
    let design = design.to_str().unwrap();
    let mut arguments = vec!["replay", recording, "--design", design];
    arguments.extend(["--opens-when", "negative", "--format", "json"]);
    arguments.extend(further);
    latchgate(&arguments)
}

const NOMINAL: [&str; 4] = ["--no-report", "--members", "0", "--model=rigid"];

#[test]
fn verif_two_pulses_are_judged_by_what_the_catch_does() {
    let folder = Folder::new("catch-two-pulses");
    let cases = [
        ("held in both", DESIGN.to_string(), 10.0, "pass"),
        ("overtaken in the second", DESIGN.to_string(), 16.0, "fail"),
        (
            "locked in the first",
            DESIGN.replace("reversible = true", "reversible = false"),
            16.0,
            "pass",
        ),
    ];
    for (name, design, gap_ms, expected) in cases {
        let done = replayed(&folder, &(design + ALIKE), &two_pulses(gap_ms), &NOMINAL);
        let document = done.document();
        assert_eq!(document["verdict"], expected, "{name}: {}", document["why"]);
        let mechanism = &document["mechanism"];
        assert_eq!(mechanism["kind"], "inertia-catch", "{name}");
        let near = |found: &Value, expected: f64| {
            let found = found.as_f64().unwrap_or(f64::NAN);
            assert!(
                (found - expected).abs() < 1e-12,
                "{name}: {found}, not {expected}"
            );
        };
        let run = &mechanism["runs"][0];
        near(&mechanism["speed_ratio"], 1.779_917_601_043_024_9);
        near(&run["engaged_s"], 0.005_058_223_780_534_052);
        near(&run["lever_arrives_s"], 0.006_850_148_730_732_922);
        let why = document["why"].as_array().unwrap();
        assert!(why.iter().any(|reason| reason["code"] == "catch"), "{name}");
        if expected == "fail" {
            near(&run["lever_passes_s"], 0.031_710_381_875_066_52);
            near(&document["nominal"]["peak_angle_rad"], 0.733_836_703_863_60);
        }
    }
}

/// A catch that nothing moves leaves every number as it is; the lever alone has no mechanism.
#[test]
fn verif_a_catch_without_unbalance_changes_no_number() {
    let folder = Folder::new("catch-idle");
    let recording = two_pulses(16.0);
    let (lever, _) = DESIGN.split_once("[catch]").unwrap();
    let idle = DESIGN.replace("unbalance_kg_m = 4.8e-5", "unbalance_kg_m = 0.0");
    let of = |design: &str| replayed(&folder, design, &recording, &["--no-report"]).document();
    let (plain, beside) = (of(lever), of(&idle));
    assert!(plain.get("mechanism").is_none());
    for key in [
        "verdict",
        "nominal",
        "models",
        "ensemble",
        "error_budget_rad",
        "opens",
    ] {
        assert_eq!(plain[key], beside[key], "{key}");
    }
}

/// Every member of a batch comes as far as the scalar kernel says, lever and catch drawn alike.
#[test]
fn verif_members_beside_a_catch_agree_with_the_scalar_kernel() {
    let mut design = from_toml(DESIGN).unwrap();
    for (key, deviation) in [
        ("catch.unbalance_kg_m", 5e-6),
        ("catch.engagement_angle_rad", 0.02),
        ("catch.lever_angle_rad", 0.004),
        ("preload_torque_nm", 0.1),
    ] {
        design
            .tolerance
            .insert(key.into(), Tolerance::Deviation(deviation));
    }
    design.validate().unwrap();
    let scatter = Scatter::new(&design, 0.0, 1).unwrap();
    let level = -40.0 * STANDARD_GRAVITY;
    let vertices = [(0, 0.0), (1, level), (11, level), (12, 0.0)];
    let both = [0, 26].into_iter().flat_map(|start| {
        vertices.map(|(at, value)| Vertex::new(f64::from(start + at) * 1e-3, value))
    });
    let rate = SampleRate::from_hertz(20_000.0).unwrap();
    let reading = Pulse::Polyline(both.collect()).reading(rate, 1000).unwrap();
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let options = BatchOptions {
            stop,
            projection: Projection::ALIGNED,
            opens_when: OpensWhen::Negative,
            initial: None,
            window: None,
            coast: true,
            asked: AskedPeaks::ALL,
            threshold_rad: design.criterion.threshold_rad,
            threads: 2,
        };
        let member = |index: usize| scatter.member(u32::try_from(index).unwrap());
        let peaks = batch::peaks(&reading, 200, &member, &options).unwrap();
        let mut stopped = 0;
        for (index, peak) in peaks.iter().enumerate() {
            let member = member(index);
            let drawn = Design {
                lever: member.lever,
                stop: member.stop,
                catch: member.catch,
                ..design.clone()
            };
            let seen = reading.scaled(member.scale, member.bias_m_s2);
            let outcome =
                replay::run(&seen, &drawn, &RunOptions::new(stop, OpensWhen::Negative)).unwrap();
            let catch = outcome.catch.unwrap();
            assert_eq!(catch.tie_s, None, "{index}");
            stopped += usize::from(catch.stops > 0);
            let away = (peak.peak_angle_rad - outcome.run.peak_angle_rad).abs();
            assert!(away < 1e-9, "{index}: {away:e}");
        }
        assert!((20..=200).contains(&stopped), "{stopped}");
    }
}

#[test]
fn verif_a_report_with_a_catch_is_drawn_and_verified() {
    let folder = Folder::new("catch-report");
    let out = folder.path().join("report");
    let out = out.to_str().unwrap();
    let done = replayed(
        &folder,
        DESIGN,
        &two_pulses(16.0),
        &["--members=128", "--out", out],
    );
    assert_eq!(done.code, 1, "{}", done.err);
    let picture = fs::read_to_string(format!("{out}/catch.svg")).unwrap();
    assert!(picture.contains("ψb = 0.15 rad") && picture.contains("φb = 0.06 rad"));
    let page = fs::read_to_string(format!("{out}/report.html")).unwrap();
    assert!(page.contains("passes it at 31.7"), "what the catch did");
    assert!(
        page.contains("Catch: unbalance, mass times arm"),
        "its numbers"
    );
    let verified = latchgate(&["verify", &format!("{out}/verdict.json")]);
    assert_eq!(verified.code, 0, "{}{}", verified.out, verified.err);
}

#[test]
fn verif_what_is_no_catch_is_refused() {
    let without = |key: &str| {
        let lines = DESIGN.lines().filter(|line| !line.starts_with(key));
        lines.collect::<Vec<_>>().join("\n")
    };
    let with = |from: &str, to: &str| DESIGN.replace(from, to);
    let cases = [
        (without("unbalance_kg_m"), "none of unbalance_kg_m"),
        (without("reversible"), "none of reversible"),
        (with("reversible = true", "reversible = 1"), "true or false"),
        (
            DESIGN.to_string() + "unbalanced_kg_m = 1.0\n",
            "catch.unbalance_kg_m",
        ),
        (
            with("end_stop_angle_rad = 0.3", "end_stop_angle_rad = 0.1"),
            "catch.end_stop_angle_rad",
        ),
        (
            with("rest_restitution = 0.4", "rest_restitution = 1.4"),
            "0 to 1",
        ),
        (
            with(
                "[lever]",
                "[tolerance]\n\"catch.unbalance\" = 1e-6\n[lever]",
            ),
            "tolerance.catch.unbalance_kg_m",
        ),
        (
            with("engagement_angle_rad = 0.15", "engagement_angle_rad = 0.0"),
            "lets no handle open",
        ),
        (
            with("preload_torque_nm = 1.0", "center_of_mass_m = -0.065"),
            "beside a catch",
        ),
        (
            with(
                "[lever]",
                "[tolerance]\ncatch.unbalance_kg_m = 1e-6\n[lever]",
            ),
            "put the key in quotes",
        ),
        (
            "[tolerance]\n\"catch.unbalance_kg_m\" = 1e-6\n".into(),
            "tolerance",
        ),
    ];
    for (text, part) in cases {
        let refused = from_toml(&text).map(|design| design.name);
        let message = refused.expect_err(&text).to_string();
        assert!(message.contains(part), "{part}: {message}");
    }
    let crossing = with(
        "[lever]",
        "[tolerance]\n\"catch.engagement_angle_rad\" = 0.03\n\"catch.end_stop_angle_rad\" = 0.03\n[lever]",
    );
    let refused = Scatter::new(&from_toml(&crossing).unwrap(), 0.0, 1);
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("engagement_angle_rad"), "{message}");
}

/// A number of the catch is overridden as any other; other studies say that they do not know it.
#[test]
fn cli_numbers_of_a_catch_are_set_and_other_studies_refuse_it() {
    let folder = Folder::new("catch-set");
    let set = ["--set", "catch.unbalance_kg_m=4.7e-5"];
    let done = replayed(
        &folder,
        DESIGN,
        &two_pulses(10.0),
        &[&NOMINAL[..], &set[..]].concat(),
    );
    let document = done.document();
    assert_eq!(document["design"]["catch"]["unbalance_kg_m"], 4.7e-5);
    assert_eq!(document["design"]["modified"][0], "catch.unbalance_kg_m");
    let design = folder.write("design.toml", DESIGN);
    let out = folder.path().join("study");
    let out = out.to_str().unwrap();
    let study = latchgate(&["study", "shock", "--design", &design, "--out", out]);
    assert_eq!(study.code, 4, "{}", study.out);
    assert!(study.err.contains("study catch"), "{}", study.err);
}

/// The template is a design that is judged, and its catch is the faster of the two.
#[test]
fn cli_init_writes_a_design_with_a_catch() {
    let folder = Folder::new("init-catch");
    let arguments = ["init", "design", "--mechanism", "catch"];
    let done = finish(program().current_dir(folder.path()).args(arguments));
    assert_eq!(done.code, 0, "{}", done.err);
    let text = fs::read_to_string(folder.path().join("design.toml")).unwrap();
    let design = from_toml(&text).unwrap();
    let (catch, lever) = (design.catch.unwrap(), design.lever);
    assert!(catch.lift_off_acceleration_m_s2() < lever.lift_off_acceleration_m_s2());
    assert!(catch.speed_ratio(&lever) > 1.0);
    assert!(catch.lever_angle_rad < design.criterion.threshold_rad);
    let other = latchgate(&["init", "card", "--mechanism", "catch"]);
    assert_eq!(other.code, 2);
}

/// A catch that the lever held at its engagement angle, and let go, is far beyond it when the lever meets it:
/// that is no tie. The peak is that of an integration by small steps, to its own error.
#[test]
fn verif_a_catch_that_was_held_and_let_go_is_no_tie() {
    let design = "\
name = \"held\"
[lever]
moment_of_inertia_kg_m2 = 0.00100871
pivot_damping_nm_s_per_rad = 8.58876e-05
spring_stiffness_nm_per_rad = 0.849803
preload_torque_nm = 1.791335418573443
mass_kg = 0.109438
center_of_mass_m = 0.0582119
[stop]
restitution = 0.676
[catch]
moment_of_inertia_kg_m2 = 3.6540786313987327e-06
pivot_damping_nm_s_per_rad = 4.46916e-07
spring_stiffness_nm_per_rad = 0.00243333
preload_torque_nm = 0.000437231
unbalance_kg_m = 2.83428e-05
engagement_angle_rad = 0.370695
end_stop_angle_rad = 0.769163
lever_angle_rad = 0.0390516
rest_restitution = 0.819
end_stop_restitution = 0.95
engagement_restitution = 0.003
reversible = true
";
    let points = "0:0/1.7:-58.489/6.7:-36.985/9.35:-23.513/12.15:-20.027/23.65:-16.877/27.55:-27.339/30.8:-14.795/37.25:-26.219/46.15:-23.143/46.5:0";
    let pulse = format!("pulse:polyline,points={points},unit=g,rate=20kHz,tail=200ms");
    let folder = Folder::new("catch-let-go");
    let document = replayed(&folder, &(design.to_string() + ALIKE), &pulse, &NOMINAL).document();
    assert_eq!(document["verdict"], "pass", "{}", document["why"]);
    let peak = document["nominal"]["peak_angle_rad"].as_f64().unwrap();
    assert!((peak - 0.081_334_032_9).abs() < 1e-9, "{peak}");
    let run = &document["mechanism"]["runs"][0];
    assert_eq!(
        (&run["stops"], &run["tie_s"]),
        (&Value::from(1), &Value::Null)
    );
}

/// What the numbers of a catch do not promise is told, and changes no verdict.
#[test]
fn verif_a_catch_whose_numbers_do_not_promise_to_hold_is_told() {
    let folder = Folder::new("catch-weak");
    let cases = [
        (None, None),
        (
            Some("catch.moment_of_inertia_kg_m2=2e-6"),
            Some("in a blow from rest the lever comes first (speed ratio 0.89, wanted at least 1)"),
        ),
        (
            Some("catch.preload_torque_nm=0.1"),
            Some("it leaves its rest at 212 g, the lever at 10.6 g"),
        ),
        (
            Some("catch.lever_angle_rad=0.12"),
            Some("it stops the lever at 6.88°, which is not below the limit angle of 5.73°"),
        ),
    ];
    for (set, expected) in cases {
        let further: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
        let recording = two_pulses(10.0);
        let done = replayed(
            &folder,
            DESIGN,
            &recording,
            &[&NOMINAL[..], &further].concat(),
        );
        let document = done.document();
        let mut findings = document["findings"].as_array().unwrap().iter();
        let text = findings
            .find(|finding| finding["code"] == "catch-weak")
            .map(|finding| finding["text"].as_str().unwrap());
        assert_eq!(text.is_some(), expected.is_some(), "{set:?}: {text:?}");
        if let (Some(text), Some(expected)) = (text, expected) {
            assert!(text.contains(expected), "{text}");
        }
    }
    let design = folder.write("static.toml", DESIGN);
    let done = latchgate(&["static", &design, "--no-report"]);
    assert!(
        done.out.contains("The inertia catch is not counted"),
        "{}",
        done.out
    );
}

/// A gate takes a design with a catch and the lever without it, each to its own answer.
#[test]
fn verif_a_gate_judges_with_and_without_the_catch() {
    let folder = Folder::new("catch-gate");
    let (lever, _) = DESIGN.split_once("[catch]").unwrap();
    folder.write("catch.toml", DESIGN.to_string() + ALIKE);
    folder.write("lever.toml", lever.replace("with a catch", "alone") + ALIKE);
    let pulse = two_pulses(60.0);
    let gate = format!(
        "[[recordings]]\nfiles = [\"{pulse}\"]\nopens_when = \"negative\"\nmembers = 128\n\
         [[designs]]\nfile = \"catch.toml\"\n[[designs]]\nfile = \"lever.toml\"\n\
         [[require]]\ndesigns = \"alone\"\nverdict = \"fail\"\n"
    );
    folder.write("gate.toml", gate);
    let arguments = ["gate", "gate.toml", "--out", "out", "--reports", "none"];
    let done = finish(program().current_dir(folder.path()).args(arguments));
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    let summary = fs::read(folder.path().join("out/summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    let mut answers: Vec<(&str, &str)> = summary["pairs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| {
            let verdict = &pair["row"]["verdict"];
            (pair["design"].as_str().unwrap(), verdict.as_str().unwrap())
        })
        .collect();
    answers.sort_unstable();
    assert_eq!(answers, [("alone", "fail"), ("with a catch", "pass")]);
}

/// Where static numbers promise and the record opens: the gap of 13.506 ms, and windows of the ringing.
#[test]
fn verif_the_study_of_the_catch_finds_where_the_record_opens() {
    let folder = Folder::new("catch-study");
    let out = folder.path().join("study");
    let arguments = [
        "study",
        "catch",
        "--format",
        "json",
        "--out",
        out.to_str().unwrap(),
    ];
    let done = latchgate(&arguments);
    assert_eq!(done.code, 0, "{}", done.err);
    let study = done.document();
    let value = |subject: &str, what: &str| {
        let mut lines = study["headlines"].as_array().unwrap().iter();
        let line = lines.find(|line| line["subject"] == subject && line["what"] == what);
        line.unwrap_or_else(|| panic!("{subject}: {what}"))["value"].as_f64()
    };
    let gap = value("two pulses, reversible catch", "opens from a gap on [ms]").unwrap();
    assert!((13.505_975..13.507).contains(&gap), "{gap}");
    assert_eq!(
        value("two pulses, irreversible catch", "gaps that open [-]"),
        Some(0.0)
    );
    assert_eq!(
        value("two pulses, lever alone", "gaps that open [-]"),
        Some(161.0)
    );
    let table = fs::read_to_string(out.join("catch.csv")).unwrap();
    let row_at = |gap_s: f64| {
        let is_meant = |row: &&str| {
            let cells: Vec<&str> = row.split(',').collect();
            cells[..3] == ["two-pulses", "rigid", "reversible-catch"]
                && (cells[3].parse::<f64>().unwrap() - gap_s).abs() < 1e-9
        };
        table
            .lines()
            .find(is_meant)
            .unwrap_or_else(|| panic!("{gap_s}"))
    };
    // Held, open from 14 to 20 ms, held from 22 to 26, open from 28 to 30, held from 35.
    for (gap_s, expected) in [
        (0.013, "false"),
        (0.014, "true"),
        (0.02, "true"),
        (0.022, "false"),
        (0.026, "false"),
        (0.028, "true"),
        (0.03, "true"),
        (0.035, "false"),
    ] {
        assert_eq!(row_at(gap_s).split(',').nth(5), Some(expected), "{gap_s}");
    }
    let lever = folder.write("lever.toml", "name = \"lever\"\nbase = \"paper\"\n");
    let refused = latchgate(&["study", "catch", "--design", &lever]);
    assert_eq!(refused.code, 4);
    assert!(refused.err.contains("[catch]"), "{}", refused.err);
    assert_eq!(catch::example().catch, from_toml(DESIGN).unwrap().catch);
}
