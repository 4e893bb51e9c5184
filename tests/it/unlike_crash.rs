//! Guards what a record that is unlike a crash needs for a pass: a person's word on its velocity change
//! and on its clock.

use crate::support::{Done, Folder, half_sine, latchgate, signal, table};
use latchgate::pipeline::{
    self, AcceptedWord, Answer, Card, CardPolarity, Control, Design, Extras, Limits, MarginRequest,
    Outcome, Request, Severity, Source, TransferRange,
};
use latchgate_document::design_file::apply_override;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::conditioning::velocity_change_m_s;
use std::f64::consts::PI;

/// Half a sine of that peak [m/s²] and length [s] from an instant on [s].
type Push = (f64, f64, f64);

fn pushes(seconds: f64, all: &[Push]) -> f64 {
    let value = |t: f64| {
        let each = all
            .iter()
            .map(|(peak, start, length)| half_sine(t, *start, *length, *peak));
        each.sum::<f64>()
    };
    let samples = (0..=(seconds * 1e4) as i32).map(|index| value(f64::from(index) / 1e4));
    velocity_change_m_s(&signal(1e4, samples.collect()))
}

/// By hand: half a sine adds up to 2·peak·length/π.
#[test]
fn verif_the_velocity_change_is_the_largest_over_three_tenths_of_a_second() {
    let one = |peak: f64, length: f64| 2.0 * peak * length / PI;
    for (what, seconds, all, expected) in [
        ("one push", 0.3, vec![(100.0, 0.05, 0.06)], one(100.0, 0.06)),
        (
            "its sign is none",
            0.3,
            vec![(-100.0, 0.05, 0.06)],
            one(100.0, 0.06),
        ),
        (
            "a short record",
            0.12,
            vec![(100.0, 0.05, 0.06)],
            one(100.0, 0.06),
        ),
        (
            "two that are far apart",
            1.0,
            vec![(100.0, 0.05, 0.06), (100.0, 0.6, 0.06)],
            one(100.0, 0.06),
        ),
        (
            "two that are near",
            1.0,
            vec![(100.0, 0.05, 0.06), (100.0, 0.2, 0.06)],
            2.0 * one(100.0, 0.06),
        ),
        (
            "a push and its return",
            0.3,
            vec![(100.0, 0.05, 0.06), (-100.0, 0.12, 0.06)],
            0.0,
        ),
        (
            "a return that comes late",
            1.0,
            vec![(100.0, 0.05, 0.06), (-50.0, 0.6, 0.06)],
            one(100.0, 0.06),
        ),
    ] {
        let found = pushes(seconds, &all);
        assert!(
            (found - expected).abs() < 1e-3 * one(100.0, 0.06),
            "{what}: {found}"
        );
    }
}

/// A push in the direction that holds the lever: it passes, whatever its size.
fn push(velocity_m_s: f64) -> String {
    let peak_g = velocity_m_s * PI / (2.0 * 0.06 * STANDARD_GRAVITY);
    table(move |t| half_sine(t, 0.0, 0.06, peak_g) + 0.02 * (t * 9_100.0).sin())
}

fn asking() -> Request {
    Request {
        members: 0,
        opens_when: Some(CardPolarity::Negative),
        transfer: Some(TransferRange::ONE),
        ..Request::default()
    }
}

fn judged(source: &Source, request: &Request) -> Outcome {
    pipeline::judge(
        source,
        request,
        &Design::reference(),
        Extras::default(),
        &Limits::default(),
        &Control::default(),
    )
}

#[track_caller]
fn check(outcome: &Outcome, answer: Answer, code: Option<&str>, what: &str) {
    let document = &outcome.document;
    assert_eq!(document.verdict, answer, "{what}: {:#?}", document.why);
    let codes = [
        "implausible-velocity",
        "velocity-contradicted",
        "velocity-stated",
        "clock-implausible",
        "clock-accepted",
    ];
    let found = document.findings.iter().map(|one| &*one.code);
    let found: Vec<&str> = found.filter(|code| codes.contains(code)).collect();
    assert_eq!(found, Vec::from_iter(code), "{what}");
    let asking = document.findings.iter().filter(|one| one.needs_word);
    assert_eq!(asking.count() > 0, answer == Answer::Undecided, "{what}");
    let first = document.why.first().map(|reason| &*reason.code);
    assert_eq!(
        first == Some("needs-word"),
        answer == Answer::Undecided,
        "{what}"
    );
}

/// The stated velocity counts within a factor of two either way; outside of 2 to 30 m/s a pass needs it.
#[test]
fn verif_a_velocity_is_held_against_what_a_person_states() {
    use Answer::{Pass, Undecided, Unusable};
    for (velocity, stated, answer, code) in [
        (1.9, None, Undecided, Some("implausible-velocity")),
        (2.1, None, Pass, None),
        (29.0, None, Pass, None),
        (31.0, None, Undecided, Some("implausible-velocity")),
        (1.9, Some(1.0), Pass, Some("velocity-stated")),
        (1.9, Some(3.7), Pass, Some("velocity-stated")),
        (1.9, Some(0.9), Unusable, Some("velocity-contradicted")),
        (1.9, Some(4.0), Unusable, Some("velocity-contradicted")),
        (31.0, Some(20.0), Pass, Some("velocity-stated")),
        (5.0, Some(5.5), Pass, None),
        // A tenth, as after a lost decimal, and g for m/s².
        (0.5, Some(5.0), Unusable, Some("velocity-contradicted")),
        (49.0, Some(5.0), Unusable, Some("velocity-contradicted")),
        // What stands alone would be plausible.
        (20.0, Some(5.0), Unusable, Some("velocity-contradicted")),
    ] {
        let what = format!("{velocity} m/s, {stated:?} stated");
        let text = push(velocity);
        let request = Request {
            velocity_change_m_s: stated,
            ..asking()
        };
        let outcome = judged(&Source::bytes("a.csv", text.as_bytes()), &request);
        check(&outcome, answer, code, &what);
        let said = outcome.document.recording.velocity_change_m_s.unwrap();
        assert!((said / velocity - 1.0).abs() < 0.01, "{what}: {said}");
        // The card says it alike.
        let card = stated.map_or(String::new(), |stated| {
            format!("velocity_change_m_s = {stated:?}\n")
        });
        let source = Source::bytes("a.csv", text.as_bytes()).with_card(card.as_bytes());
        check(&judged(&source, &asking()), answer, code, &what);
    }
    // What a formula made needs no word, but a stated velocity counts all the same.
    let source =
        |card: &str| Source::bytes("a.csv", push(0.5).as_bytes()).with_card(card.as_bytes());
    check(
        &judged(&source("synthetic = true"), &asking()),
        Pass,
        None,
        "a formula",
    );
    let both = "synthetic = true\nvelocity_change_m_s = 5.0";
    let code = Some("velocity-contradicted");
    check(
        &judged(&source(both), &asking()),
        Unusable,
        code,
        "a formula",
    );
}

/// `rows` samples at a rate, first contact after a fifth of them, with stamps.
fn stamped(rate_hz: f64, seconds: f64) -> String {
    let peak_g = 4.0 * PI / (2.0 * 0.03 * STANDARD_GRAVITY);
    let mut text = String::from("time_s,acc_y_g\n");
    let count = ((seconds + 0.02) * rate_hz) as i32;
    for index in 0..count {
        let t = f64::from(index) / rate_hz - 0.02;
        let value = half_sine(t, 0.0, 0.03, peak_g) + 0.05 * (t * 9_100.0).sin();
        text += &format!("{t:.7},{value:.3}\n");
    }
    text
}

/// More than 50 kHz, or less than 60 ms after contact, need a person's word; a fail stays one.
#[test]
fn verif_a_clock_that_no_crash_recorder_has_needs_a_word() {
    let accepting = Request {
        accepted: vec![AcceptedWord::Clock],
        ..asking()
    };
    for (rate_hz, seconds, odd) in [
        (10_000.0, 0.1, false),
        (50_000.0, 0.1, false),
        (51_200.0, 0.1, true),
        (100_000.0, 0.1, true),
        (10_000.0, 0.063, false),
        (10_000.0, 0.058, true),
        (100_000.0, 0.045, true),
    ] {
        let what = format!("{rate_hz} Hz, {seconds} s");
        let text = stamped(rate_hz, seconds);
        let source = Source::bytes("a.csv", text.as_bytes());
        let (answer, code) = match odd {
            true => (Answer::Undecided, Some("clock-implausible")),
            false => (Answer::Pass, None),
        };
        check(&judged(&source, &asking()), answer, code, &what);
        let code = odd.then_some("clock-accepted");
        check(&judged(&source, &accepting), Answer::Pass, code, &what);
        let card = b"accepted = [\"clock\"]\n";
        let carded = Source::bytes("a.csv", text.as_bytes()).with_card(*card);
        check(&judged(&carded, &asking()), Answer::Pass, code, &what);
        let opens = Request {
            opens_when: Some(CardPolarity::Positive),
            ..asking()
        };
        assert_eq!(
            judged(&source, &opens).document.verdict,
            Answer::Fail,
            "{what}"
        );
    }
}

/// A file that states rate and time in two places that agree needs nobody's word on its clock.
#[test]
fn verif_a_clock_that_is_stated_twice_needs_no_word() {
    let folder = Folder::new("clock-twice");
    let rows = |separator: &str| stamped(100_000.0, 0.1).replace(',', separator);
    let body = |text: String| text.split_once('\n').unwrap().1.to_string();
    let samples = body(rows("\t"));
    let count = samples.lines().count();
    // NHTSA: the interval in the header [µs], and the stamps.
    let line = format!(
        "1|146|AC|NA|DSLF|YG|SEC|G'S|1650||01/01/20|2000|2|0.0|-2000|{}|10|AM|P|NONE",
        count as i32 - 2001
    );
    folder.write("v1.EV5", format!("----- INSTRUMENTATION -----\n{line}"));
    let curve = folder.write("v1.146", &samples);
    let bare = folder.write("v2.146", &samples);
    // LabVIEW: Delta_X, and a column of times.
    let lvm = |delta: &str, name: &str| {
        let head = "LabVIEW Measurement\t\nReader_Version\t2\t\nSeparator\tTab\nDecimal_Separator\t.\n\
             Multi_Headings\tNo\nX_Columns\tOne\n***End_of_Header***\t\n\
             Channels\t1\t\nSamples\tCOUNT\t\nY_Unit_Label\tg\t\nX0\t-0.02\t\nDelta_X\tDELTA\t\n\
             ***End_of_Header***\t\t\nX_Value\tacc_y\tComment\n";
        let head = head
            .replace("COUNT", &count.to_string())
            .replace("DELTA", delta);
        folder.write(name, head + &samples)
    };
    // ISO-MME: the interval, and the instant of the largest sample.
    let values: Vec<f64> = samples
        .lines()
        .map(|row| row.split('\t').nth(1).unwrap().parse().unwrap())
        .collect();
    let largest = values.iter().copied().fold(f64::MIN, f64::max);
    let place = values.iter().position(|value| *value == largest).unwrap();
    let mme = |instant: &str, name: &str| {
        let listed: String = values.iter().map(|value| format!("{value}\n")).collect();
        let head = format!(
            "Channel code                :11SILBLE0000ACYA\nUnit                        :g\n\
             Reference channel           :implicit\nSampling interval           :0.00001\n\
             Time of first sample        :-0.02\n{instant}\
             Number of samples           :{count}\n"
        );
        folder.write(name, head + &listed)
    };
    let instant = format!(
        "First global maximum value  :{largest}\nTime of maximum value       :{:.5}\n",
        place as f64 / 1e5 - 0.02
    );
    for (path, what, code) in [
        (&curve, "EV5 and stamps", 0),
        (&bare, "stamps alone", 3),
        (&lvm("0.00001", "one.lvm"), "Delta_X and times", 0),
        (&lvm("0.0001", "two.lvm"), "Delta_X against times", 4),
        (&mme(&instant, "one.001"), "interval and instant", 0),
        (&mme("", "two.001"), "interval alone", 3),
    ] {
        let asked = [
            "--unit",
            "g",
            "--opens-when",
            "negative",
            "--members",
            "0",
            "--transfer",
            "1",
            "--no-report",
        ];
        let done = latchgate(&[&["replay", path][..], &asked].concat());
        assert_eq!(done.code, code, "{what}: {}{}", done.out, done.err);
    }
}

fn replayed(folder: &Folder, text: &str, options: &[&str]) -> Done {
    let path = folder.write("a.csv", text);
    let fixed = [
        "replay",
        &path,
        "--opens-when",
        "negative",
        "--members",
        "0",
        "--transfer",
        "1",
        "--no-report",
    ];
    latchgate(&[&fixed[..], options].concat())
}

#[test]
fn cli_a_pass_waits_for_a_persons_word() {
    let folder = Folder::new("word");
    let weak = push(0.5);
    let done = replayed(&folder, &weak, &[]);
    assert_eq!(done.code, 3, "{}", done.out);
    let first: Vec<&str> = done.out.split_whitespace().collect();
    let first = first.join(" ");
    assert!(
        first.contains("A pass needs a person's word on the velocity change. State together: --velocity-change M/S."),
        "{first}"
    );
    assert!(
        !done.out.contains("what samples need not show"),
        "{}",
        done.out
    );
    let done = replayed(&folder, &weak, &["--velocity-change", "0.6"]);
    assert_eq!(done.code, 0, "{}", done.out);
    assert!(
        done.out
            .contains("what samples need not show: a wrong sign"),
        "{}",
        done.out
    );
    assert_eq!(
        replayed(&folder, &weak, &["--velocity-change", "6"]).code,
        4
    );
    // Both words are asked for at once, and can be given at once.
    let short = stamped(100_000.0, 0.05).replace("acc_y_g", "acc_y (m/s2)");
    let done = replayed(&folder, &short, &[]);
    let first: Vec<&str> = done.out.split_whitespace().collect();
    let first = first.join(" ");
    assert!(
        first.contains("State together: --velocity-change M/S --accept clock."),
        "{first}"
    );
    let both = ["--velocity-change", "0.4", "--accept", "CLOCK"];
    assert_eq!(replayed(&folder, &short, &both).code, 0);
    // Words that are none are wrong usage, and those that are known are named.
    for wrong in [&["--accept", "weak-pulse"][..], &["--accept", "clock,unit"]] {
        let done = replayed(&folder, &weak, wrong);
        assert_eq!(done.code, 2, "{wrong:?}");
        assert!(done.err.contains("clock"), "{}", done.err);
    }
    for wrong in ["0", "-5", "nan", "fast"] {
        let done = replayed(&folder, &weak, &["--velocity-change", wrong]);
        assert_eq!(done.code, 2, "{wrong}");
    }
    for (card, word) in [
        ("accepted = [\"clocks\"]", "clock"),
        ("accepted = \"clock\"", "a list of words"),
        ("velocity_change_m_s = -1.0", "velocity_change_m_s"),
        (
            "velocity_change = 1.0",
            "did you mean `velocity_change_m_s`?",
        ),
    ] {
        let error = Card::from_toml(card).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

/// A gate waits as a replay does, and its file speaks for a person.
#[test]
fn cli_a_gate_waits_for_a_persons_word() {
    let folder = Folder::new("word-gate");
    folder.write("weak.csv", push(0.5));
    for (keys, code) in [
        ("", 3),
        ("velocity_change = 0.5\n", 0),
        ("velocity_change = 0.5\naccept = [\"clock\"]\n", 0),
        ("velocity_change = 0.5\naccept = \"clock\"\n", 0),
        ("velocity_change = 50\n", 4),
        ("accept = [\"clock\"]\n", 3),
        ("accept = [\"weak\"]\n", 4),
    ] {
        let gate = format!(
            "require = \"pass\"\n[[recordings]]\nfiles = \"weak.csv\"\nopens_when = \"negative\"\n\
             members = 0\ntransfer = 1\n{keys}[[designs]]\nname = \"paper\"\n"
        );
        let path = folder.write("gate.toml", gate);
        let done = latchgate(&["gate", &path, "--no-store", "--reports", "none"]);
        assert_eq!(done.code, code, "{keys}{}{}", done.out, done.err);
    }
}

/// Margins are those with the word; the verdict beside them waits for it.
#[test]
fn verif_margins_are_judged_as_with_a_persons_word() {
    let text = push(0.5);
    let margin = |velocity: Option<f64>| {
        let request = MarginRequest {
            replay: Request {
                velocity_change_m_s: velocity,
                opens_when: Some(CardPolarity::Positive),
                ..asking()
            },
            ..MarginRequest::default()
        };
        let mut stiff = Design::reference();
        apply_override(&mut stiff, "lever.preload_torque_nm=2.0").unwrap();
        let source = Source::bytes("a.csv", text.as_bytes());
        let (limits, control) = (Limits::default(), Control::default());
        let outcome = pipeline::margin(&source, &request, &stiff, &limits, &control).unwrap();
        serde_json::to_value(outcome.document).unwrap()
    };
    let (without, with) = (margin(None), margin(Some(0.5)));
    assert_eq!(
        (&without["verdict"], &with["verdict"]),
        (&"undecided".into(), &"pass".into())
    );
    for key in [
        "nominal_state",
        "scale_to_flip",
        "least_preload_torque_nm",
        "least_preload_torque_nm_safe_from",
        "counterweight",
        "restitution",
        "boundaries",
        "answers",
    ] {
        assert_eq!(without[key], with[key], "{key}");
    }
    let notes = without["notes"].to_string();
    assert!(notes.contains("needs a person's word"), "{notes}");
    assert!(!with["notes"].to_string().contains("word"), "{with}");
}

/// The flag and the number stand in the document, and the number is that of the finding and the page.
#[test]
fn verif_one_velocity_change_everywhere() {
    let outcome = judged(&Source::bytes("a.csv", push(0.5).as_bytes()), &asking());
    let document = serde_json::to_value(&outcome.document).unwrap();
    let velocity = document["recording"]["velocity_change_m_s"]
        .as_f64()
        .unwrap();
    let findings = document["findings"].as_array().unwrap();
    let asking: Vec<_> = findings
        .iter()
        .filter(|one| one["needs_word"] == true)
        .collect();
    assert_eq!(asking.len(), 1, "{findings:?}");
    assert_eq!(asking[0]["severity"], "warning");
    let shown = latchgate_kernel::units::plain(velocity, 3);
    let text = asking[0]["text"].as_str().unwrap();
    assert!(text.contains(&format!("{shown} m/s")), "{text}");
    let files = outcome.files();
    let (_, page) = files
        .iter()
        .find(|(name, _)| name == "report.html")
        .unwrap();
    let page = String::from_utf8_lossy(page);
    let on_page = format!("{}\u{a0}m/s", shown.trim_end_matches('0'));
    assert!(page.contains(&on_page), "{on_page}");
    assert!(
        document["conditioning"]
            .get("velocity_change_m_s")
            .is_none()
    );
    let others = findings.iter().filter(|one| one["severity"] == "blocking");
    assert_eq!(others.count(), 0);
    assert_eq!(outcome.document.findings[0].severity, Severity::Warning);
}
