//! Guards what a pass waits for where a sensor does not sit at the latch: its place, the factors from there to the
//! latch, the axis of its channel, and the other channels of its side.

use crate::support::{Done, Folder, half_sine, latchgate, table};
use latchgate::pipeline::{
    self, Answer, CardPolarity, Control, Design, Extras, Limits, Outcome, Request, Source,
    TransferRange,
};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::transfer::factors;
use serde_json::Value;
use std::f64::consts::PI;

/// Peak of half a sine of 60 ms that adds up to a velocity [g].
fn peak_g(velocity_m_s: f64) -> f64 {
    velocity_m_s * PI / (2.0 * 0.06 * STANDARD_GRAVITY)
}

/// A push of 5 m/s that holds the lever shut, with a little noise: all that a pass waits for is its place.
fn push(time: f64) -> f64 {
    half_sine(time, 0.0, 0.06, peak_g(5.0)) + 0.02 * (time * 9_100.0).sin()
}

fn asking() -> Request {
    Request {
        members: 0,
        opens_when: Some(CardPolarity::Negative),
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

fn range(text: &str) -> Option<TransferRange> {
    Some(TransferRange::from_text(text).unwrap())
}

const CODES: [&str; 8] = [
    "place",
    "place-overridden",
    "transfer-low",
    "axis",
    "axis-accepted",
    "axis-unknown",
    "synthetic-contradicted",
    "needs-word",
];

#[track_caller]
fn check(outcome: &Outcome, answer: Answer, codes: &[&str], what: &str) {
    let document = &outcome.document;
    assert_eq!(document.verdict, answer, "{what}: {:#?}", document.why);
    let found = document.findings.iter().map(|one| &*one.code);
    let found: Vec<&str> = found.filter(|code| CODES.contains(code)).collect();
    assert_eq!(found, codes, "{what}");
    let first = document.why.first().map(|reason| &*reason.code);
    let waits = answer == Answer::Undecided;
    assert_eq!(first == Some("needs-word"), waits, "{what}");
}

/// The recording in each format, with the code or attachment of its sensor.
fn ev5(folder: &Folder, attachment: &str) -> String {
    let rows: String = (-500..=2500)
        .map(|index| {
            let time = f64::from(index) / 1e4;
            format!("{time:.4}\t{:.6}\n", push(time))
        })
        .collect();
    let line = format!(
        "1|146|AC|NA|{attachment}|YG|SEC|G'S|1650||01/01/20|2000|0|0.0|-500|2500|100|AM|P|NONE"
    );
    let name = format!("v{attachment}");
    folder.write(
        &format!("{name}.EV5"),
        format!("----- INSTRUMENTATION -----\n{line}"),
    );
    folder.write(&format!("{name}.146"), rows)
}

fn mme(folder: &Folder, code: &str) -> String {
    let samples: String = (-500..=2500)
        .map(|index| format!("{:.6}\n", push(f64::from(index) / 1e4)))
        .collect();
    let head = format!(
        "Channel code                :{code}\nUnit                        :g\n\
         Reference channel           :implicit\nSampling interval           :0.0001\n\
         Time of first sample        :-0.05\nNumber of samples           :3001\n"
    );
    folder.write(&format!("{code}.001"), head + &samples)
}

/// Codes, heads and cards say the place; unless it is door or latch, a pass waits.
#[test]
fn verif_a_pass_waits_unless_the_sensor_is_at_door_or_latch() {
    use Answer::{Pass, Undecided};
    let folder = Folder::new("places");
    for (path, answer, place) in [
        (mme(&folder, "11DOORLE0000ACYA"), Pass, Some("door")),
        (mme(&folder, "11LATCLE0000ACYA"), Pass, Some("latch")),
        (mme(&folder, "11LOCKLE0000ACYA"), Pass, Some("latch")),
        (mme(&folder, "11SILBLE0000ACYA"), Undecided, Some("body")),
        (mme(&folder, "14BPILLO0000ACYA"), Undecided, Some("body")),
        // A barrier's door is none.
        (mme(&folder, "M1DOORLE0000ACYA"), Undecided, None),
        (ev5(&folder, "DSLF"), Undecided, Some("body")),
        (ev5(&folder, "VECG"), Undecided, Some("body")),
        // Which attachments are doors is not known for certain.
        (ev5(&folder, "DOLF"), Undecided, None),
        (folder.write("a.csv", table(push)), Undecided, None),
    ] {
        let channel = path.contains("M1DOOR").then(|| "M1DOORLE0000ACYA".into());
        let request = Request {
            channel,
            ..asking()
        };
        let outcome = judged(&Source::File(path.clone().into()), &request);
        let waits = answer == Undecided;
        let codes: &[&str] = if waits { &["place"] } else { &[] };
        check(&outcome, answer, codes, &path);
        let found = outcome.document.recording.place.map(|place| place.name());
        assert_eq!(found, place, "{path}");
        // A factor answers, 1 as well as another, and stands on the page as the person's word.
        for text in ["1", "0.5..2"] {
            let request = Request {
                transfer: range(text),
                ..request.clone()
            };
            let outcome = judged(&Source::File(path.clone().into()), &request);
            check(&outcome, Pass, &[], &path);
            let files = outcome.files();
            let (_, page) = files
                .iter()
                .find(|(name, _)| name == "report.html")
                .unwrap();
            let page = String::from_utf8_lossy(page);
            let said = match text {
                "1" => "factor 1 to the latch, stated for this run",
                _ => {
                    "factor 0.5 to 2 to the latch, stated for this run; 31 judged: pass at 0.5 to 2;"
                }
            };
            assert!(page.contains(said), "{path}: {said}");
        }
    }
}

/// The card counts before the file, and the option before the card.
#[test]
fn verif_a_card_says_place_and_factors() {
    use Answer::{Pass, Undecided};
    let text = table(push);
    let source = |card: &str| Source::bytes("a.csv", text.as_bytes()).with_card(card.as_bytes());
    for (card, answer) in [
        ("place = \"door\"", Pass),
        ("place = \"Latch\"", Pass),
        ("place = \"body\"", Undecided),
        ("transfer = 1", Pass),
        ("transfer = 1.0", Pass),
        ("transfer = \"0.8..1.5\"", Pass),
        ("place = \"body\"\ntransfer = \"0.8..1.5\"", Pass),
        // A formula needs no word.
        ("synthetic = true", Pass),
        ("synthetic = true\nplace = \"body\"", Pass),
        ("accepted = [\"axis\"]", Undecided),
    ] {
        let waits = answer == Undecided;
        let codes: &[&str] = if waits { &["place"] } else { &[] };
        check(&judged(&source(card), &asking()), answer, codes, card);
    }
    let both = judged(
        &source("transfer = \"0.8..1.5\""),
        &Request {
            transfer: range("2"),
            ..asking()
        },
    );
    let block = both.document.transfer.unwrap();
    assert_eq!(
        (block.from, block.to, block.source.name()),
        (2.0, 2.0, "option")
    );
    // A latch that moves a tenth of what the sensor's place does is a slip, or worth a look.
    for (card, codes) in [
        ("transfer = 0.05", &["transfer-low"][..]),
        (
            "place = \"door\"\ntransfer = \"0.01..0.09\"",
            &["transfer-low"],
        ),
        ("transfer = \"0.05..0.1\"", &[]),
    ] {
        check(&judged(&source(card), &asking()), Pass, codes, card);
    }
    // What the card says against the file is shown.
    let folder = Folder::new("places-card");
    let path = mme(&folder, "11SILBLE0000ACYA");
    folder.write("11SILBLE0000ACYA.001.toml", "place = \"door\"");
    let outcome = judged(&Source::File(path.into()), &asking());
    check(&outcome, Pass, &["place-overridden"], "card against code");
    // A pulse has no place.
    let pulse = "pulse:half-sine,peak=30g,duration=11ms,opens-when=positive";
    let source = pipeline::pulse::source_at(pulse.as_ref()).unwrap();
    let mut stiff = Design::reference();
    pipeline::apply_override(&mut stiff, "lever.preload_torque_nm=9").unwrap();
    let request = Request {
        members: 0,
        ..Request::default()
    };
    let (limits, control) = (Limits::default(), Control::default());
    let outcome = pipeline::judge(
        &source,
        &request,
        &stiff,
        Extras::default(),
        &limits,
        &control,
    );
    check(&outcome, Pass, &[], pulse);
}

/// Both ends and every value of E48 between; one factor alone where both are the same.
#[test]
fn verif_the_factors_of_a_range() {
    let of = |text: &str| factors(TransferRange::from_text(text).unwrap());
    assert_eq!(of("1"), [1.0]);
    assert_eq!(of("1..1.2"), [1.0, 1.05, 1.1, 1.15, 1.2]);
    assert_eq!(of("0.93..1.07"), [0.93, 0.953, 1.0, 1.05, 1.07]);
    assert_eq!(of("1.01..1.02"), [1.01, 1.02]);
    assert_eq!(of("0.1..10").len(), 97);
}

/// A factor is another recording: at 2 every number of the runs is that of the samples doubled, to the last bit.
#[test]
fn verif_a_factor_is_another_recording() {
    let samples = |scale: f64| {
        table(move |time| {
            let value = -half_sine(time, 0.0, 0.02, 4.0) + 0.3 + 0.05 * (time * 9_100.0).sin();
            // A sum of digits that doubling leaves exact.
            scale * (value * 1e4).round() / 1e4
        })
    };
    let request = Request {
        members: 200,
        velocity_change_m_s: None,
        ..asking()
    };
    let document = |scale: f64, transfer: Option<TransferRange>| {
        let text = samples(scale);
        let card = b"place = \"door\"\n";
        let source = Source::bytes("a.csv", text.as_bytes()).with_card(*card);
        let request = Request {
            transfer,
            ..request.clone()
        };
        serde_json::to_value(judged(&source, &request).document).unwrap()
    };
    let (scaled, doubled) = (document(1.0, range("2")), document(2.0, None));
    let plain = document(1.0, None);
    for key in [
        "nominal",
        "models",
        "answers",
        "ensemble",
        "error_budget_rad",
        "opens",
        "conditioning",
        "what_if",
    ] {
        assert_eq!(scaled[key], doubled[key], "{key}");
        assert_ne!(scaled[key], plain[key], "{key}");
    }
    // What the sensor recorded stays what it recorded.
    assert_eq!(scaled["recording"]["peak_g"], plain["recording"]["peak_g"]);
    // The factor 1 changes nothing but who speaks.
    let mut one = document(1.0, range("1"));
    for key in ["transfer", "request", "report_id"] {
        assert_ne!(one[key], plain[key], "{key}");
        one[key] = plain[key].clone();
    }
    assert_eq!(one.get("transfer"), Some(&Value::Null));
    one.as_object_mut().unwrap().remove("transfer");
    assert_eq!(one, plain);
}

/// Two pushes, of which the second meets the lever on its way out or on its way back, by the factor: it stays at both
/// ends of the range and opens between.
fn comb() -> String {
    let peak = 0.2 * PI / (2.0 * 0.005 * STANDARD_GRAVITY);
    table(move |time| -half_sine(time, 0.0, 0.005, peak) - half_sine(time, 0.06, 0.005, peak))
}

#[test]
fn verif_a_range_that_opens_between_its_ends_fails() {
    let text = comb();
    let mut soft = Design::reference();
    pipeline::apply_override(&mut soft, "lever.spring_stiffness_nm_per_rad=0.001").unwrap();
    let document = |transfer: &str| {
        let source = Source::bytes("a.csv", text.as_bytes()).with_card(*b"synthetic = true");
        let request = Request {
            transfer: range(transfer),
            model: latchgate::pipeline::ModelChoice::Only(latchgate::pipeline::StopModel::Rigid),
            ..asking()
        };
        let (limits, control) = (Limits::default(), Control::default());
        let extras = Extras::default();
        pipeline::judge(&source, &request, &soft, extras, &limits, &control).document
    };
    for end in ["1.2", "1.9"] {
        assert_eq!(document(end).verdict, Answer::Pass, "{end}");
    }
    let whole = document("1.2..1.9");
    assert_eq!(whole.verdict, Answer::Fail);
    let block = whole.transfer.clone().unwrap();
    let ends = [&block.answers[0], block.answers.last().unwrap()];
    assert_eq!(ends, [&Answer::Pass; 2]);
    assert!(1.2 < block.worst && block.worst < 1.9, "{block:?}");
    // The numbers are those of the factor that counts.
    let alone = document(&block.worst.to_string());
    assert_eq!(whole.nominal, alone.nominal);
    let said = whole.why.iter().find(|reason| reason.code == "transfer");
    let said = &said.unwrap().text;
    assert!(said.contains("from 1.2 to 1.9"), "{said}");
    // The worst is the largest angle of those that fail.
    let peak = |factor: &f64| {
        document(&factor.to_string())
            .nominal
            .unwrap()
            .peak_angle_rad
    };
    let failing = block.judged.iter().zip(&block.answers);
    let failing = failing.filter(|(_, answer)| **answer == Answer::Fail);
    let largest = failing.map(|(factor, _)| peak(factor)).fold(0.0, f64::max);
    assert_eq!(
        whole.nominal.unwrap().peak_angle_rad.to_bits(),
        largest.to_bits()
    );
}

/// Of several factors one question takes no more work than of one.
#[test]
fn verif_a_range_shares_the_limit_on_work() {
    let text = table(push);
    let source = Source::bytes("a.csv", text.as_bytes());
    let request = |transfer: &str| Request {
        transfer: range(transfer),
        limits: [("work".to_string(), 2_000_000)].into(),
        ..asking()
    };
    assert_eq!(
        judged(&source, &request("1")).document.verdict,
        Answer::Pass
    );
    let document = judged(&source, &request("0.1..10")).document;
    assert_eq!(document.verdict, Answer::Undecided);
    let codes: Vec<&str> = document.why.iter().map(|reason| &*reason.code).collect();
    assert!(codes.contains(&"work-limit"), "{codes:?}");
}

fn replayed(path: &str, options: &[&str]) -> Done {
    let fixed = ["replay", path, "--opens-when", "negative"];
    latchgate(&[&fixed[..], &["--members", "0", "--no-report"], options].concat())
}

/// A wrong range is one message: wrong usage as an option, a bad card or gate as a key.
#[test]
fn cli_a_wrong_range_is_refused() {
    let folder = Folder::new("places-wrong");
    let path = folder.write("a.csv", table(push));
    for wrong in [
        "2..1", "0", "0..1", "-1", "nan", "1..nan", "1..inf", "much", "1000",
    ] {
        let done = replayed(&path, &["--transfer", wrong]);
        assert_eq!(done.code, 2, "{wrong}: {}", done.out);
        assert_eq!(done.err.matches("--transfer").count(), 1, "{}", done.err);
        assert!(done.out.is_empty(), "{wrong}: {}", done.out);
        for card in [
            format!("transfer = \"{wrong}\"\n"),
            "transfer = 0.0\n".into(),
        ] {
            folder.write("a.csv.toml", card);
            let done = replayed(&path, &[]);
            assert_eq!(done.code, 4, "{wrong}: {}", done.out);
            assert!(done.err.contains("a.csv.toml:1: "), "{}", done.err);
            assert_eq!(done.err.matches("latchgate:").count(), 1, "{}", done.err);
        }
        std::fs::remove_file(folder.path().join("a.csv.toml")).unwrap();
        let gate = format!(
            "require = \"pass\"\n[[recordings]]\nfiles = \"a.csv\"\nopens_when = \"negative\"\n\
             transfer = \"{wrong}\"\n[[designs]]\nname = \"paper\"\n"
        );
        let gate = folder.write("gate.toml", gate);
        let done = latchgate(&["gate", &gate, "--no-store", "--reports", "none"]);
        assert_eq!(done.code, 4, "{wrong}");
        assert_eq!(done.err.matches("transfer").count(), 1, "{}", done.err);
    }
    for (card, said) in [
        ("place = \"sill\"", "latch, door, body"),
        ("place = \"dor\"", "did you mean `door`?"),
        ("place = 1", "to be \"latch\", \"door\" or \"body\""),
        ("transfer = [1]", "a number, or a text"),
    ] {
        folder.write("a.csv.toml", card);
        let done = replayed(&path, &[]);
        assert_eq!(done.code, 4, "{card}");
        assert!(done.err.contains("a.csv.toml:1: "), "{}", done.err);
        assert!(done.err.contains(said), "{}", done.err);
    }
}

/// A gate's key is the option, for all its recordings; the card of one counts where the key says nothing.
#[test]
fn cli_a_gate_states_the_factors_of_its_recordings() {
    let folder = Folder::new("places-gate");
    folder.write("a.csv", table(push));
    folder.write("b.csv", table(push));
    folder.write("b.csv.toml", "place = \"door\"\n");
    for (files, keys, code) in [
        ("*.csv", "", 3),
        ("b.csv", "", 0),
        ("*.csv", "transfer = 1\n", 0),
        ("*.csv", "transfer = \"0.8..1.5\"\n", 0),
    ] {
        let gate = format!(
            "require = \"pass\"\n[[recordings]]\nfiles = \"{files}\"\nopens_when = \"negative\"\n\
             members = 0\n{keys}[[designs]]\nname = \"paper\"\n"
        );
        let path = folder.write("gate.toml", gate);
        let done = latchgate(&["gate", &path, "--no-store", "--reports", "none"]);
        assert_eq!(done.code, code, "{files} {keys}{}{}", done.out, done.err);
    }
    // What a gate begins with names them.
    let done = latchgate(&["gate", "--init", folder.path().to_str().unwrap()]);
    let text = [done.out, done.err].concat();
    let written = std::fs::read_to_string(folder.path().join("gate.toml")).unwrap_or_default();
    let text = [text, written].concat();
    assert!(
        text.contains("# transfer = \"LO..HI\"") || done.code != 0,
        "{text}"
    );
}

/// A channel along X or Z waits for a word of its own; a factor does not mend it, a design along that axis does.
#[test]
fn verif_an_axis_waits_for_its_own_word() {
    use Answer::{Pass, Undecided};
    let text = table(push).replace("acc_y_g", "acc_x_g");
    let source = Source::bytes("a.csv", text.as_bytes());
    let request = Request {
        channel: Some("acc_x_g".into()),
        transfer: range("1"),
        ..asking()
    };
    check(&judged(&source, &request), Undecided, &["axis"], "X");
    let wide = Request {
        transfer: range("0.5..2"),
        ..request.clone()
    };
    check(&judged(&source, &wide), Undecided, &["axis"], "X, a range");
    let accepting = Request {
        accepted: vec![latchgate::pipeline::AcceptedWord::Axis],
        ..request.clone()
    };
    check(
        &judged(&source, &accepting),
        Pass,
        &["axis-accepted"],
        "X, accepted",
    );
    let carded = Source::bytes("a.csv", text.as_bytes()).with_card(*b"accepted = [\"axis\"]");
    check(
        &judged(&carded, &request),
        Pass,
        &["axis-accepted"],
        "X, by card",
    );
    let formula = Source::bytes("a.csv", text.as_bytes()).with_card(*b"synthetic = true");
    check(&judged(&formula, &request), Pass, &[], "X of a formula");
    // An acceptance that nothing waits for changes nothing.
    let lateral = table(push);
    let lateral = Source::bytes("a.csv", lateral.as_bytes());
    let unneeded = Request {
        channel: None,
        ..accepting
    };
    check(&judged(&lateral, &unneeded), Pass, &[], "Y, accepted");
    let (limits, control) = (Limits::default(), Control::default());
    let with = |axis: &str, centre: &str| {
        let text = format!(
            "name = \"turned\"\nbase = \"paper\"\n[lever]\naxis = {axis}\ncenter_of_mass = {centre}\n[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\n"
        );
        let design = pipeline::design_from_bytes("d.toml", text.as_bytes(), &limits).unwrap();
        pipeline::judge(
            &source,
            &request,
            &design,
            Extras::default(),
            &limits,
            &control,
        )
    };
    let along_x = with("[0.0, 1.0, 0.0]", "[0.0, 0.0, -0.065]");
    check(&along_x, Pass, &[], "a lever along X");
    let along_y = with("[0.0, 0.0, 1.0]", "[-0.065, 0.0, 0.0]");
    check(&along_y, Undecided, &["axis"], "a lever along Y");
    // One channel does not pass a lever between X and Y, and the axis is asked for beside that.
    let slanted = with("[0.0, 0.0, 1.0]", "[-0.046, -0.046, 0.0]").document;
    assert_eq!(slanted.verdict, Undecided);
    assert!(
        slanted
            .findings
            .iter()
            .any(|finding| finding.code == "axis")
    );
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// All that is missing stands in one message, with one command line and the lines of the card.
#[test]
fn cli_every_missing_word_stands_in_one_message() {
    let folder = Folder::new("places-words");
    // 70 kHz, 0.5 m/s, along X, of an unknown place.
    let rows: String = (-1400..7000)
        .map(|index| {
            let time = f64::from(index) / 7e4;
            let noise = 0.02 * (time * 9_100.0).sin();
            format!(
                "{time:.8},{:.6}\n",
                half_sine(time, 0.0, 0.06, peak_g(0.5)) + noise
            )
        })
        .collect();
    let path = folder.write("a.csv", format!("time_s,acc_x_g\n{rows}"));
    let done = replayed(&path, &["--channel", "acc_x_g"]);
    assert_eq!(done.code, 3, "{}", done.out);
    let text = one_line(&done.out);
    for said in [
        "A pass needs a person's word on the factor from the sensor's place to the latch, the axis of the channel, \
         the velocity change and the clock.",
        "State together: --transfer LO..HI --accept axis,clock --velocity-change M/S.",
        "in the card: `transfer = \"LO..HI\"`, `accepted = [\"axis\", \"clock\"]`, `velocity_change_m_s = M/S`.",
    ] {
        assert!(text.contains(said), "{said}\n{text}");
    }
    let all = [
        "--channel",
        "acc_x_g",
        "--transfer",
        "1",
        "--accept",
        "axis,clock",
    ];
    let all = [&all[..], &["--velocity-change", "0.5"]].concat();
    assert_eq!(replayed(&path, &all).code, 0);
    // The card states them for good.
    folder.write(
        "a.csv.toml",
        "channel = \"acc_x_g\"\ntransfer = \"1\"\naccepted = [\"axis\", \"clock\"]\nvelocity_change_m_s = 0.5\n",
    );
    assert_eq!(replayed(&path, &[]).code, 0);
    std::fs::remove_file(folder.path().join("a.csv.toml")).unwrap();
    // A direction that is missing too is named with them.
    let opening = folder.write("b.csv", table(push));
    let done = latchgate(&["replay", &opening, "--members", "0", "--no-report"]);
    assert_eq!(done.code, 3, "{}", done.out);
    let text = one_line(&done.out);
    let said = "State together: --opens-when negative|positive|both --transfer LO..HI.";
    assert!(text.contains(said), "{text}");
    // So is a place beside a missing unit.
    let bare = folder.write("c.csv", table(push).replace("acc_y_g", "acc_y"));
    let done = latchgate(&["replay", &bare, "--no-report"]);
    assert_eq!(done.code, 4);
    assert!(done.err.contains("--unit g|"), "{}", done.err);
    assert!(one_line(&done.err).contains(said), "{}", done.err);
}

/// A card of a recording holds what its file says, and a blank with a reason for the rest; filled in, it passes.
#[test]
fn cli_a_card_is_written_of_a_recording() {
    let folder = Folder::new("places-init");
    let path = ev5(&folder, "DSLF");
    let done = latchgate(&["init", "card", &path]);
    assert_eq!(done.code, 0, "{}", done.err);
    let card = format!("{path}.toml");
    let text = std::fs::read_to_string(&card).unwrap();
    for said in [
        "channel = \"146 V1 AC DSLF YG\"\n",
        "unit = \"g\"\n",
        "place = \"body\"\n",
        "location = \"DSLF YG\"\n",
        "# opens_when = ",
        "# transfer = \"LO..HI\"\n",
    ] {
        assert!(text.contains(said), "{said}\n{text}");
    }
    assert!(!text.contains("velocity_change_m_s"), "{text}");
    // It is never written over, and what it says changes no answer.
    let again = latchgate(&["init", "card", &path]);
    assert_eq!(again.code, 4, "{}", again.out);
    assert_eq!(std::fs::read_to_string(&card).unwrap(), text);
    assert_eq!(replayed(&path, &[]).code, 3);
    let filled = text.replace("# transfer = \"LO..HI\"", "transfer = \"0.8..1.5\"");
    std::fs::write(&card, filled).unwrap();
    assert_eq!(replayed(&path, &[]).code, 0);
    // What is missing is a blank with its reason.
    let rows = table(|time| push(time) / 10.0);
    let bare = folder.write("bare.csv", rows.replace("acc_y_g", "acc_z"));
    let done = latchgate(&["init", "card", &bare]);
    assert_eq!(done.code, 0, "{}", done.err);
    let text = std::fs::read_to_string(format!("{bare}.toml")).unwrap();
    for said in [
        "# channel = ",
        "# unit = ",
        "# place = ",
        "# transfer = ",
        "# accepted = [\"axis\"]",
    ] {
        assert!(text.contains(said), "{said}\n{text}");
    }
    let none = latchgate(&["init", "card", folder.write("empty.csv", "").as_str()]);
    assert_eq!(none.code, 4, "{}", none.out);
}

/// Three channels: the left sill, the left pillar and the right sill; the last two open the lever if their push is
/// negative.
fn three(velocity_m_s: f64) -> String {
    let opens = |time: f64| half_sine(time, 0.0, 0.06, peak_g(velocity_m_s));
    let rows: String = (-500..=2500)
        .map(|index| {
            let time = f64::from(index) / 1e4;
            let noise = 0.02 * (time * 9_100.0).sin();
            let (stays, falls) = (push(time), opens(time) + noise);
            format!("{time:.4},{stays:.6},{falls:.6},{falls:.6}\n")
        })
        .collect();
    format!("time_s,11SILBLE0000ACYA (g),11BPILLE0000ACYA (g),13SILBRI0000ACYA (g)\n{rows}")
}

/// Every lateral channel of that side is judged and named, the worst counts; verify repeats it.
#[test]
fn cli_siblings_are_judged_together() {
    let folder = Folder::new("places-siblings");
    let path = folder.write("a.csv", three(-5.0));
    let out = folder.path().join("report");
    let common = [
        "replay",
        &path,
        "--opens-when",
        "negative",
        "--members",
        "0",
    ];
    let left = ["--channel", "11SILBLE0000ACYA (g)", "--transfer", "1"];
    let alone = latchgate(&[&common[..], &left, &["--no-report"]].concat());
    assert_eq!(alone.code, 0, "{}{}", alone.out, alone.err);
    let siblings = [
        &common[..],
        &left,
        &["--siblings", "--out", out.to_str().unwrap()],
    ]
    .concat();
    let done = latchgate(&[&siblings[..], &["--format", "json"]].concat());
    assert_eq!(done.code, 1, "{}{}", done.out, done.err);
    let document = done.document();
    let named: Vec<(&str, &str, &str)> = document["siblings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| {
            let text = |key: &str| one[key].as_str().unwrap();
            (text("channel"), text("place"), text("answer"))
        })
        .collect();
    assert_eq!(
        named,
        [
            ("11SILBLE0000ACYA (g)", "body", "pass"),
            ("11BPILLE0000ACYA (g)", "body", "fail"),
        ]
    );
    assert_eq!(document["recording"]["channel"], "11BPILLE0000ACYA (g)");
    assert_eq!(document["request"]["channel"], "11SILBLE0000ACYA (g)");
    let text = latchgate(&siblings);
    for (channel, ..) in named {
        assert!(text.out.contains(channel), "{channel}\n{}", text.out);
    }
    let verdict = out.join("verdict.json");
    let verified = latchgate(&["verify", verdict.to_str().unwrap(), "--recording", &path]);
    assert_eq!(verified.code, 0, "{}{}", verified.out, verified.err);
    // A fail is worse than a pass that waits for its place.
    let waits = [&common[..], &left[..2], &["--no-report"]].concat();
    assert_eq!(latchgate(&waits).code, 3);
    assert_eq!(latchgate(&[&waits[..], &["--siblings"]].concat()).code, 1);
    // A gate judges them as a replay does.
    let gate = folder.write(
        "gate.toml",
        "require = \"pass\"\n[[recordings]]\nfiles = \"a.csv\"\nopens_when = \"negative\"\nmembers = 0\n\
         channel = \"11SILBLE0000ACYA (g)\"\ntransfer = 1\nsiblings = true\n[[designs]]\nname = \"paper\"\n",
    );
    let done = latchgate(&["gate", &gate, "--no-store", "--reports", "none"]);
    assert_eq!(done.code, 1, "{}{}", done.out, done.err);
    // A channel that stands alone on its side is judged alone, and that is said.
    let alone = [
        &common[..],
        &[
            "--channel",
            "13SILBRI0000ACYA (g)",
            "--siblings",
            "--no-report",
            "--format",
            "json",
        ],
    ];
    let document = latchgate(&alone.concat()).document();
    let has = |document: &serde_json::Value, code: &str| {
        let findings = document["findings"].as_array().unwrap();
        findings.iter().any(|finding| finding["code"] == code)
    };
    assert!(has(&document, "siblings-none"), "{}", document["findings"]);
    let both = ["--siblings", "--radial-channel", "x"];
    assert_eq!(replayed(&path, &both).code, 2);
    // The place of the card is that of one channel; another one waits.
    folder.write("b.csv", three(4.5));
    folder.write(
        "b.csv.toml",
        "channel = \"11SILBLE0000ACYA (g)\"\nplace = \"door\"\nopens_when = \"negative\"\n",
    );
    let path = folder.path().join("b.csv");
    let both = [
        "replay",
        path.to_str().unwrap(),
        "--members",
        "0",
        "--no-report",
    ];
    assert_eq!(latchgate(&both).code, 0);
    assert_eq!(latchgate(&[&both[..], &["--siblings"]].concat()).code, 3);
}

/// An advice for a range holds at every factor: that of the one which asks most.
#[test]
fn verif_an_advice_holds_at_every_factor() {
    let text = table(|time| -half_sine(time, 0.0, 0.02, 6.0));
    let preload = |transfer: &str| {
        let source = Source::bytes("a.csv", text.as_bytes());
        let request = pipeline::MarginRequest {
            replay: Request {
                transfer: range(transfer),
                ..asking()
            },
            ..pipeline::MarginRequest::default()
        };
        let (limits, control) = (Limits::default(), Control::default());
        let design = Design::reference();
        let outcome = pipeline::margin(&source, &request, &design, &limits, &control).unwrap();
        let number = outcome.document.number("least_preload_torque_nm_safe_from");
        number.unwrap()
    };
    let (low, high) = (preload("0.8"), preload("0.9"));
    assert!(low < high, "{low} {high}");
    assert!((preload("0.8..0.9") - high).abs() < 1e-12);
}

/// A person who tells how a place moves has not told the axis: it is said, and accepting the axis answers it.
#[test]
fn verif_an_axis_that_nothing_tells_is_said() {
    let text = table(push).replace("acc_y_g", "acceleration_g");
    let source = Source::bytes("a.csv", text.as_bytes());
    let request = Request {
        channel: Some("acceleration_g".into()),
        transfer: range("1"),
        ..asking()
    };
    check(
        &judged(&source, &request),
        Answer::Pass,
        &["axis-unknown"],
        "no axis",
    );
    let accepting = Request {
        accepted: vec![latchgate::pipeline::AcceptedWord::Axis],
        ..request.clone()
    };
    check(&judged(&source, &accepting), Answer::Pass, &[], "accepted");
    let formula = Source::bytes("a.csv", text.as_bytes()).with_card(*b"synthetic = true");
    check(&judged(&formula, &request), Answer::Pass, &[], "a formula");
}

/// A card that calls a sensor's recording synthetic lifts nothing: neither place, nor axis, nor noise.
#[test]
fn verif_a_sensor_in_the_file_is_not_synthetic() {
    let folder = Folder::new("places-synthetic");
    let path = mme(&folder, "11SILBLE0000ACYA");
    folder.write("11SILBLE0000ACYA.001.toml", "synthetic = true");
    let outcome = judged(&Source::File(path.into()), &asking());
    check(
        &outcome,
        Answer::Undecided,
        &["place", "synthetic-contradicted"],
        "a sill",
    );
    assert!(!outcome.document.conditioning.unwrap().synthetic);
}
