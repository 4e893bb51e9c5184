//! Guards `latchgate spectrum` at the process boundary.

use crate::support::{Done, Folder, latchgate, signal_file};
use serde_json::Value;

fn spectrum(arguments: &[&str]) -> Done {
    let mut all = vec!["spectrum"];
    all.extend(arguments);
    latchgate(&all)
}

/// Returns the document that an option-free question answers with.
fn document(arguments: &[&str]) -> Value {
    let mut all = arguments.to_vec();
    all.extend(["--no-report", "--format", "json"]);
    let done = spectrum(&all);
    assert_eq!(done.code, 0, "{}", done.err);
    done.document()
}

fn numbers(list: &Value) -> Vec<Option<f64>> {
    list.as_array().unwrap().iter().map(Value::as_f64).collect()
}

const SLED: &str = "pulse:half-sine,peak=30g,duration=30ms,opens-when=positive";
const SHORT: &str = "pulse:half-sine,peak=60g,duration=5ms,opens-when=positive";

#[test]
fn cli_curves_zones_and_their_envelope_are_told() {
    let document = document(&[SLED, SHORT, "--share", "0.5"]);
    assert_eq!(document["schema"], "latchgate.spectrum/1");
    let strokes = numbers(&document["stroke_m"]);
    assert_eq!(strokes.len(), 24);
    let curves: Vec<_> = (0..2)
        .map(|curve| numbers(&document["spectrum_m_s2"][curve]))
        .collect();
    let envelope = numbers(&document["envelope_m_s2"]);
    let covering = numbers(&document["share_m_s2"]);
    for place in 0..24 {
        let values = [curves[0][place], curves[1][place]];
        let highest = values.into_iter().flatten().reduce(f64::max);
        assert_eq!(envelope[place], highest);
        let by = document["envelope_by"][place].as_u64();
        assert_eq!(by.and_then(|by| values[by as usize]), highest);
        // Half of two curves is the lower.
        let both = values[0].zip(values[1]);
        assert_eq!(covering[place], both.map(|(one, other)| one.min(other)));
        for (curve, value) in values.iter().enumerate() {
            let zone = document["zone_from_m_s2"][curve][place].as_f64();
            assert!(zone.is_none_or(|from| value.is_some_and(|value| from <= value)));
        }
    }
    // The short pulse is the stronger for a lever that must come far to open least.
    assert_eq!(document["envelope_by"][0], 1);
    assert_eq!(document["envelope_by"][18], 0);
    let settings = &document["settings"];
    assert_eq!(settings["restitution"], serde_json::json!([0.8, 0.8]));
    assert_eq!(settings["levers"], 128);
    assert!(document["recordings"][0]["recording"]["sha256"].is_string());
    assert_eq!(document["report_id"].as_str().unwrap().len(), 64);
}

#[test]
fn cli_the_same_spectrum_has_the_same_bytes() {
    let ask = |threads: &str| {
        let more = ["--threads", threads, "--no-report", "--format", "json"];
        let mut all = vec![SHORT];
        all.extend(more);
        let text = spectrum(&all).out;
        text.split("\"run\"").next().unwrap().to_string()
    };
    assert_eq!(ask("1"), ask("2"));
}

#[test]
fn cli_a_design_has_its_place_and_reserves() {
    let folder = Folder::new("spectrum-design");
    let design = |preload: f64| {
        let text = format!(
            "name = \"d{preload}\"\nbase = \"paper\"\n[lever]\npreload_torque_nm = {preload}\n\
             [tolerance]\npreload_torque_nm = \"2 %\"\nmass_kg = \"1 %\"\n"
        );
        folder.write(&format!("d{preload}.toml"), text)
    };
    let [strong_file, weak_file] = [4.0, 0.5].map(design);
    let document = document(&[SLED, "--design", &strong_file, "--design", &weak_file]);
    let [strong, weak] = [0, 1].map(|index| &document["designs"][index]);
    assert_eq!(strong["place"], "above");
    let load = strong["reserve_load"].as_f64().unwrap();
    let preload = strong["reserve_preload"].as_f64().unwrap();
    // Lift-off 42.5 g over a curve of some 23 g at this stroke.
    assert!((0.4..0.5).contains(&preload), "{preload}");
    assert!((1.5..1.9).contains(&load), "{load}");
    // The rule says the same of pulses that are so many times as strong.
    for (times, code) in [(0.97 * load, 0), (load, 3)] {
        let peak = 30.0 * times;
        let pulse = format!("pulse:half-sine,peak={peak}g,duration=30ms,opens-when=positive");
        let done = latchgate(&[
            "replay",
            &pulse,
            "--design",
            &strong_file,
            "--no-report",
            "--no-advice",
        ]);
        assert_eq!(done.code, code, "{times}: {}", done.out);
    }
    assert_eq!(weak["place"], "below");
    assert!(weak["reserve_load"].is_null());
    assert!(
        weak["reserve_load_reason"]
            .as_str()
            .unwrap()
            .contains("does not pass")
    );
    assert!(weak["reserve_preload"].as_f64().unwrap() < -1.0);
}

#[test]
fn cli_a_design_above_waits_for_the_words_of_a_pass() {
    let folder = Folder::new("spectrum-words");
    let head = "base = \"paper\"\n[lever]\npreload_torque_nm = 4.0\n";
    let stated = "[tolerance]\npreload_torque_nm = \"2 %\"\nmass_kg = \"1 %\"\n";
    let whole = folder.write("whole.toml", format!("name = \"whole\"\n{head}{stated}"));
    let bare = folder.write("bare.toml", format!("name = \"bare\"\n{head}"));
    let file = folder.path().join("sled.csv");
    std::fs::copy(signal_file("sled_30g_30ms.csv"), &file).unwrap();
    let file = file.to_str().unwrap();
    let arguments = [
        file,
        "--opens-when",
        "negative",
        "--design",
        &whole,
        "--design",
        &bare,
    ];
    let unplaced = document(&arguments);
    let awaits = |document: &Value, design: usize| -> String {
        let awaits = document["designs"][design]["awaits"].as_array().unwrap();
        let awaits = awaits.iter().map(|what| what.as_str().unwrap());
        awaits.collect::<Vec<_>>().join("; ")
    };
    assert!(awaits(&unplaced, 0).contains("factor from the sensor's place"));
    assert!(!awaits(&unplaced, 0).contains("scatter"));
    assert!(
        awaits(&unplaced, 1).ends_with("how far the preload scatters; how far the mass scatters")
    );
    // On one line, however wide the terminal.
    let text = || {
        let out = spectrum(&[&arguments[..], &["--no-report"]].concat()).out;
        out.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let waiting = text();
    assert!(waiting.contains("above every curve;"), "{waiting}");
    assert!(!waiting.contains("curve: stays"), "{waiting}");
    assert!(
        waiting.contains("a pass needs a person's word on"),
        "{waiting}"
    );
    // With every word there, in the card, it stays.
    std::fs::copy(
        signal_file("sled_30g_30ms.csv.toml"),
        folder.path().join("sled.csv.toml"),
    )
    .unwrap();
    assert_eq!(awaits(&document(&arguments), 0), "");
    let stated = text();
    assert_eq!(
        stated.matches("above every curve: stays").count(),
        1,
        "{stated}"
    );
}

#[test]
fn cli_a_lever_beside_a_catch_has_no_place() {
    let folder = Folder::new("spectrum-catch");
    let design = folder.path().join("catch.toml");
    let made = latchgate(&[
        "init",
        "design",
        "--mechanism",
        "catch",
        design.to_str().unwrap(),
    ]);
    assert_eq!(made.code, 0, "{}", made.err);
    let document = document(&[SHORT, "--design", design.to_str().unwrap()]);
    let point = &document["designs"][0];
    assert!(point["place"].is_null() && point["reserve_load"].is_null());
    assert!(point["reason"].as_str().unwrap().contains("catch"));
}

#[test]
fn cli_an_unusable_recording_is_an_error_unless_it_is_left_out() {
    let folder = Folder::new("spectrum-unusable");
    let empty = folder.write("empty.csv", "");
    let document = document(&[SHORT, &empty, "--leave-out-unusable"]);
    assert_eq!(document["recordings"].as_array().unwrap().len(), 1);
    let left = &document["left_out"][0];
    assert_eq!(left["file"], "empty.csv");
    assert!(left["reason"].as_str().unwrap().contains("empty"));
    // Where nothing is left there is no answer.
    let done = spectrum(&[&empty, "--leave-out-unusable", "--no-report"]);
    assert_eq!(done.code, 4);
    // A dead sensor is a recording, and none that tells anything.
    let dead = folder.write(
        "dead.csv",
        "t_s,acc_y_g\n".to_string()
            + &(0..800)
                .map(|k| format!("{:.4},0.5\n", f64::from(k) / 1e4))
                .collect::<String>(),
    );
    let done = spectrum(&[&dead, "--no-report"]);
    assert_eq!(done.code, 4, "{}", done.out);
    assert!(
        done.err.contains("an unusable recording has no spectrum"),
        "{}",
        done.err
    );
}

/// A bad file at the end is told before the first curve is followed: a work limit that every curve would exceed is
/// never met.
#[test]
fn cli_a_bad_file_is_told_before_the_first_curve() {
    let folder = Folder::new("spectrum-order");
    let empty = folder.write("empty.csv", "");
    let little_work = ["--limit", "work=1000", "--no-report"];
    let alone = spectrum(&[&[SHORT][..], &little_work].concat());
    assert!(alone.err.contains("work"), "{}", alone.err);
    let done = spectrum(&[&[SHORT, &empty][..], &little_work].concat());
    assert_eq!((done.code, &*done.out), (4, ""));
    assert!(
        done.err
            .starts_with("latchgate: empty.csv: the file is empty"),
        "{}",
        done.err
    );
}

#[test]
fn cli_files_of_one_name_are_told_apart() {
    let folder = Folder::new("spectrum-twins");
    let push = |g: f64| {
        let row = |k: i32| {
            let value = if (0..60).contains(&k) { -g } else { 0.0 };
            format!("{:.4},{value}\n", f64::from(k) / 1e4)
        };
        "t_s,acc_y_g\n".to_string() + &(-100..900).map(row).collect::<String>()
    };
    let files = [("one", 30.0), ("other", 60.0)].map(|(name, g)| {
        std::fs::create_dir(folder.path().join(name)).unwrap();
        folder.write(&format!("{name}/push.csv"), push(g))
    });
    let document = document(&[&files[0], &files[1], "--opens-when", "negative"]);
    let names = [0, 1].map(|index| document["recordings"][index]["name"].as_str().unwrap());
    assert_eq!(names, ["push.csv acc_y_g −", "push.csv acc_y_g − (2)"]);
    let highest = [0, 1].map(|curve| document["spectrum_m_s2"][curve][0].as_f64().unwrap());
    assert!(highest[1] > 1.8 * highest[0], "{highest:?}");
}

#[test]
fn cli_values_out_of_range_are_wrong_usage() {
    for (option, value, named) in [
        ("--restitution", "1.2", "restitution"),
        ("--restitution", "0.9..0.5", "LO must not be above HI"),
        ("--limit-angle", "2", "limit angle"),
        ("--share", "1.5", "share"),
        ("--share", "0", "--share"),
    ] {
        let done = spectrum(&[SHORT, option, value, "--no-report"]);
        assert_eq!(done.code, 2, "{option} {value}: {}", done.err);
        assert!(done.err.contains(named), "{option} {value}: {}", done.err);
    }
}

#[test]
fn cli_page_table_and_chart_are_written() {
    let folder = Folder::new("spectrum-report");
    let out = folder.path().join("out");
    let done = spectrum(&[
        &signal_file("half_sine_30g_11ms.csv"),
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(done.code, 0, "{}", done.err);
    assert!(
        done.out
            .starts_with("This recording demands a lift-off of more than"),
        "{}",
        done.out
    );
    assert!(done.out.contains("spectrum.html"), "{}", done.out);
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let table = read("spectrum.csv");
    assert_eq!(table.lines().count(), 25);
    assert!(table.starts_with("stroke_m,envelope_m_s2,"), "{table}");
    let stored: Value = serde_json::from_str(&read("spectrum.json")).unwrap();
    let first: f64 = table
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .nth(1)
        .unwrap()
        .parse()
        .unwrap();
    assert_eq!(stored["spectrum_m_s2"][0][0].as_f64(), Some(first));
    assert!(read("spectrum.html").contains("<svg") && read("spectrum.svg").starts_with("<svg"));
    // A second run takes the place of the first; a folder of other things is refused.
    let again = spectrum(&[SHORT, "--out", out.to_str().unwrap()]);
    assert_eq!(again.code, 0, "{}", again.err);
    let own = folder.path().join("own");
    std::fs::create_dir(&own).unwrap();
    std::fs::write(own.join("thesis.txt"), "mine").unwrap();
    let refused = spectrum(&[SHORT, "--out", own.to_str().unwrap()]);
    assert_eq!(refused.code, 4, "{}", refused.err);
}

/// A half-sine of 11 ms and 30 g at 10 kHz that opens on its negative sign, noise in the last digits; from `held_s` on
/// 20 ms of one value, as of a sensor that hangs.
fn pushed(folder: &Folder, name: &str, transfer: &str, held_s: Option<f64>) -> String {
    let mut text = String::from("time (s),acceleration y (g)\n");
    for index in -300..1500 {
        let time_s = f64::from(index) / 1e4;
        let push = match (0.0..0.011).contains(&time_s) {
            true => -30.0 * libm::sin(std::f64::consts::PI * time_s / 0.011),
            false => 0.0,
        };
        let noise = 0.03 * libm::sin(f64::from(index * index % 3067));
        let a = match held_s.is_some_and(|from| (from..from + 0.02).contains(&time_s)) {
            true => 1.2345,
            false => push + noise,
        };
        text += &format!("{time_s:.4},{a:.4}\n");
    }
    let card = format!("opens_when = \"negative\"\nplace = \"body\"\ntransfer = {transfer}\n");
    folder.write(&format!("{name}.toml"), card);
    folder.write(name, text)
}

/// Of the factors between sensor and latch the one that asks most counts, at every stroke.
#[test]
fn cli_the_factor_that_asks_most_makes_the_curve() {
    let folder = Folder::new("spectrum-transfer");
    let curve = |name: &str, transfer: &str| {
        let document = document(&[&pushed(&folder, name, transfer, None)]);
        numbers(&document["spectrum_m_s2"][0])
    };
    let (one, two) = (curve("one.csv", "1"), curve("two.csv", "2"));
    assert_eq!(curve("span.csv", "\"1..2\""), two);
    let more = one.iter().zip(&two).filter(|(one, two)| one < two).count();
    assert!(more > 20, "{one:?} {two:?}");
}

/// A fault after the push ends the record for the curve, which says so.
#[test]
fn cli_a_fault_ends_the_record_of_a_curve() {
    let folder = Folder::new("spectrum-cut");
    let whole = document(&[&pushed(&folder, "whole.csv", "1", None)]);
    let file = pushed(&folder, "held.csv", "1", Some(0.08));
    let cut = document(&[&file]);
    assert!(whole["recordings"][0]["judged_until_s"].is_null());
    assert_eq!(cut["recordings"][0]["judged_until_s"], 0.0799);
    let [whole, held] = [&whole, &cut].map(|document| numbers(&document["spectrum_m_s2"][0]));
    // At small strokes the push alone decides.
    assert_eq!(whole[..8], held[..8]);
    let told = spectrum(&[&file, "--no-report"]).out;
    assert!(
        told.contains("before a fault") && told.contains("79.90 ms"),
        "{told}"
    );
}

/// A push that closes asks for nothing: the least lift-off that was followed is told as a bound, never a number as if
/// it were the curve's.
#[test]
fn cli_a_curve_below_its_lowest_window_is_a_bound() {
    let closing = "pulse:half-sine,peak=30g,duration=10ms,opens-when=negative";
    let document = document(&[closing]);
    let floor = document["recordings"][0]["floor_m_s2"].as_f64();
    let values = numbers(&document["spectrum_m_s2"][0]);
    assert!(values.iter().all(|value| *value == floor), "{values:?}");
    let floor_g = floor.unwrap() / 9.80665;
    assert!((0.2..0.3).contains(&floor_g), "{floor_g}");
    let told = spectrum(&[closing, "--no-report"]).out;
    assert!(
        told.contains("none opens") && told.contains("≤0.287"),
        "{told}"
    );
}

/// A lever whose centre of mass lies beyond its pivot opens on the other sign: what the rule fails is never above.
#[test]
fn cli_an_overbalanced_lever_is_above_no_curve_that_opens_it() {
    let folder = Folder::new("spectrum-overbalanced");
    let design = folder.write(
        "over.toml",
        "name = \"over\"\nbase = \"paper\"\n[lever]\ncenter_of_mass_m = -0.065\npreload_torque_nm = 0.5\n\
         [tolerance]\npreload_torque_nm = \"2 %\"\nmass_kg = \"1 %\"\n",
    );
    for (sign, opens) in [("positive", false), ("negative", true)] {
        let pulse = format!("pulse:half-sine,peak=30g,duration=10ms,opens-when={sign}");
        let asked = ["replay", &pulse, "--design", &design, "--no-report"];
        assert_eq!(latchgate(&asked).code, i32::from(opens), "{sign}");
        let document = document(&[&pulse, "--design", &design]);
        let point = &document["designs"][0];
        assert_eq!(point["place"] == "above", !opens, "{point}");
        assert!(point["reserve_load"].is_null(), "{point}");
    }
}
