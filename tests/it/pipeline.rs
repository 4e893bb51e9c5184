//! The face of the library: a question as data, a recording that is read once, documents that can
//! be read back, and what names them.

use crate::support::{Folder, data, finish, program};
use latchgate::cli::compare::VerdictComparison;
use latchgate::cli::limits::LimitList;
use latchgate::gate::GateSummary;
use latchgate::pipeline::{
    self, CardPolarity, Cfc, Control, Design, Document, Extras, FilterChoice, Limits, Listing,
    MarginRequest, NUMBERS_REVISION, Outcome, Prepared, Request, Source, Stored, Verification,
};
use latchgate_document::blocks::Verdicts;
use latchgate_document::design_file::apply_override;
use latchgate_document::request::PolaritySource;
use latchgate_document::{MarginDocument, json};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::model::parameters::{Condition, PARAMETERS};
use latchgate_kernel::range::Window;
use latchgate_kernel::units::{AccelerationUnit, OpensWhen};
use latchgate_recording::error::ErrorKind;
use latchgate_recording::setting::Setting;
use latchgate_study::files::Summary;
use latchgate_verdict::Answer;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

fn signals(name: &str) -> Source {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("signals");
    Source::File(folder.join(name))
}

fn nominal() -> Request {
    Request {
        members: 0,
        ..Request::default()
    }
}

fn judged(source: &Source, request: &Request, design: &Design) -> Outcome {
    let (limits, control) = (Limits::default(), Control::default());
    pipeline::judge(
        source,
        request,
        design,
        Extras::default(),
        &limits,
        &control,
    )
}

fn document_of(source: &Source, request: &Request) -> Document {
    judged(source, request, &Design::reference()).document
}

fn request(value: Value) -> Request {
    serde_json::from_value(value).unwrap()
}

/// Every setting of a replay, at a value that is not its default.
fn every_setting() -> Value {
    json!({
        "input_format": "csv", "channel": "acc_y", "time_column": "t", "time_unit": "ms",
        "time_source": "publish",
        "header_line": 3, "skip_lines": 2, "decimal": ",", "rate_hz": 1e4, "time_zero": -0.01, "unit": "m/s2", "opens_when": "both",
        "unit_line": 4, "last_line": 900, "sheet": "Data", "radial_channel": "acc_x", "sensitivity": "20 g/V",
        "bias": "-0.02..-0.005", "filter": "cfc180", "filter_standard": "saej211",
        "between": "linear", "resample": 20_000.0, "window": "-0.01..0.2", "model": "rigid", "method": "moreau-jean",
        "steps_per_period": 2500, "tolerance": 1e-9, "members": 128, "seed": 7, "phi0": 0.01,
        "omega0": -1.5, "sled206": true, "accepted_remarks": ["DROP OUT"], "velocity_change": 4.5,
        "accept": ["clock", "axis"], "transfer": "0.8..1.5", "siblings": true, "limit": {"text_bytes": 1_000_000}
    })
}

#[test]
fn verif_a_replay_in_one_breath_fills_a_request_and_shows_the_terminals_text() {
    let Source::File(path) = signals("burst.csv") else {
        unreachable!("a signal is a file");
    };
    let mut heavier = Design::reference();
    apply_override(&mut heavier, "lever.mass_kg=0.16").unwrap();
    let replay = latchgate::replay(&path)
        .channel("2")
        .unit(AccelerationUnit::StandardGravity)
        .opens_when(CardPolarity::Negative)
        .filter(FilterChoice::Class(Cfc::Cfc180))
        .members(200)
        .design(heavier)
        .threads(1);
    let outcome = replay.judge().unwrap();
    let asked = json!({"channel": "2", "unit": "g", "opens_when": "negative", "filter": "cfc180", "members": 200});
    assert_eq!(outcome.document.request, request(asked));
    let path = path.to_str().unwrap();
    let printed = finish(program().args([
        "replay",
        path,
        "--channel",
        "2",
        "--unit",
        "g",
        "--opens-when",
        "negative",
        "--filter",
        "cfc180",
        "--members",
        "200",
        "--set",
        "lever.mass_kg=0.16",
        "--no-report",
    ]));
    assert_eq!(outcome.to_string(), printed.out);
    assert!(outcome.evidence.is_some());

    let error = latchgate::replay("signals/absent.csv").judge().unwrap_err();
    assert!(matches!(error.kind(), ErrorKind::Io { .. }), "{error}");
    let error = replay
        .request(nominal())
        .channel("acc_z")
        .judge()
        .unwrap_err();
    assert!(error.to_string().contains("acc_z"), "{error}");
}

#[test]
fn verif_every_setting_of_a_request_is_written_and_read_back() {
    let value = every_setting();
    let whole = request(value.clone());
    assert_eq!(serde_json::to_value(&whole).unwrap(), value);
    let of_margin = ["counterweight_radius", "design", "set"];
    // Of the run of a gate, not of a question.
    let of_gates = ["allow_removed", "out", "store"];
    let known: BTreeSet<&str> = Setting::ALL.iter().map(|setting| setting.key()).collect();
    let here: BTreeSet<&str> = value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .chain(of_margin)
        .chain(of_gates)
        .collect();
    assert_eq!(here, known, "a setting that no request holds, or another");

    let margin = json!({"members": 0, "counterweight_radius": 0.02});
    let asked: MarginRequest = serde_json::from_value(margin.clone()).unwrap();
    let written = serde_json::to_value(&asked).unwrap();
    for (key, value) in margin.as_object().unwrap() {
        assert_eq!(written[key], *value, "{key}");
    }
    assert_eq!(
        serde_json::from_value::<MarginRequest>(written).unwrap(),
        asked
    );
    let default = Request::default();
    assert_eq!(request(json!({})), default);
    assert_eq!(
        request(serde_json::to_value(&default).unwrap()),
        default,
        "defaults are written out and read back"
    );
    assert!(default.stated().is_empty());
}

#[track_caller]
fn check_refused(value: Value, words: &[&str]) {
    let error = serde_json::from_value::<Request>(value).unwrap_err();
    let text = error.to_string();
    for word in words {
        assert!(text.contains(word), "{word:?} in {text:?}");
    }
}

#[test]
fn val_a_request_refuses_what_it_does_not_know() {
    check_refused(
        json!({"chanel": 2}),
        &["unknown setting `chanel`", "did you mean `channel`?"],
    );
    check_refused(json!({"threads": 2}), &["unknown setting `threads`"]);
    check_refused(json!({"filter": "cfc100"}), &["`filter`", "cfc1000"]);
    check_refused(json!({"members": -1}), &["`members`", "-1"]);
    check_refused(json!({"members": 1e9}), &["`members`"]);
    check_refused(
        json!({"window": "0.2..0.1"}),
        &["`window`", "START must lie before END"],
    );
    check_refused(
        json!({"rate_hz": "fast"}),
        &["`rate_hz`", "a number", "fast"],
    );
    check_refused(
        json!({"limit": {"text_byte": 1}}),
        &["`limit`", "text_bytes"],
    );
    // What cannot go together is refused before anything is read.
    let inside = Request {
        phi0_rad: Some(-0.01),
        ..nominal()
    };
    assert!(inside.check().is_err());
    let refusal = judged(&signals("burst.csv"), &inside, &Design::reference());
    assert_eq!(refusal.document.verdict, Answer::Unusable);
    assert!(refusal.refusal.unwrap().to_string().contains("`phi0`"));
}

#[test]
fn val_request_before_card_before_file() {
    let table: String = (0..900)
        .map(|k| {
            let push = if (300..600).contains(&k) { -3.0 } else { 0.0 };
            format!("{},{push},{}\n", f64::from(k - 300) / 1e4, -push)
        })
        .collect();
    let bytes = format!("t_s,acc_y_g,acc_y2_g\n{table}").into_bytes();
    let card = b"channel = \"acc_y2_g\"\nopens_when = \"negative\"\nsynthetic = true\n";
    let with = |request: &Request| {
        document_of(
            &Source::bytes("a.csv", bytes.clone()).with_card(*card),
            request,
        )
    };
    let by_card = with(&nominal()).recording;
    assert_eq!(by_card.channel.as_deref(), Some("acc_y2_g"));
    assert_eq!(by_card.unit_source.as_deref(), Some("header"));
    assert_eq!(by_card.opens_when_source, PolaritySource::Card);
    let asked = Request {
        channel: Some("acc_y_g".into()),
        ..request(json!({"members": 0, "opens_when": "positive", "unit": "m/s2"}))
    };
    let document = with(&asked);
    assert_eq!(document.recording.channel.as_deref(), Some("acc_y_g"));
    assert_eq!(document.recording.unit_source.as_deref(), Some("option"));
    assert_eq!(document.recording.opens_when_source, PolaritySource::Option);
    assert_eq!(document.nominal.unwrap().opens_when, OpensWhen::Positive);
}

/// The same files give the same document from a folder and from memory, card and files beside
/// among them, but a name that no file bears is refused in the same words, too.
#[test]
fn val_memory_is_as_good_as_a_folder() {
    let folder = Folder::new("pipeline-memory");
    let mut files = Vec::new();
    for name in ["burst.csv", "surviving.csv", "burst_imu.mcap"] {
        let path = format!("signals/{name}");
        let bytes = std::fs::read(&path).unwrap();
        let card = std::fs::read(format!("{path}.toml")).unwrap();
        let memory = Source::bytes(name, bytes.clone()).with_card(card);
        assert_eq!(
            document_of(&memory, &nominal()),
            document_of(&signals(name), &nominal()),
            "{name}"
        );
        files.push((name.to_string(), bytes));
    }
    // An ISO-MME test: a header, the channels in a folder of their own.
    let channel = |code: &str, sign: f64| {
        let samples: String = (0..900)
            .map(|k| {
                let push = if (300..600).contains(&k) {
                    30.0 * sign
                } else {
                    0.0
                };
                format!("{:.3}\n", push + 0.01 * f64::from(k % 7))
            })
            .collect();
        format!(
            "Channel code :{code}\nUnit :m/(s*s)\nSampling interval :0.0001\n\
             Time of first sample :-0.03\nNumber of samples :900\n{samples}"
        )
    };
    let package = [
        ("t/t.mme".to_string(), "Data format edition number :1.6\nLaboratory test ref. number :T1\n".to_string()),
        ("t/Channel/t.chn".into(), "Number of channels :2\nName of channel 001 :11DOORLE00ACYA\nName of channel 002 :11DOORLE00ACXA\n".into()),
        ("t/Channel/t.001".into(), channel("11DOORLE0000ACYA", -1.0)),
        ("t/Channel/t.002".into(), channel("11DOORLE0000ACXA", 1.0)),
    ];
    for (name, text) in &package {
        folder.write(name, text.as_bytes());
    }
    let inner = package.iter().map(|(name, text)| {
        let name = name.strip_prefix("t/").unwrap().to_string();
        (name, text.as_bytes().into())
    });
    let memory = Source::files("t", inner);
    let disk = Source::File(folder.path().join("t"));
    let both = [&memory, &disk].map(|source| document_of(source, &nominal()));
    assert_eq!(both[0], both[1]);
    assert_eq!(
        both[0].recording.format.as_deref(),
        Some("iso-mme"),
        "{:?}",
        both[0].why
    );
    assert!(both[0].nominal.is_some(), "{:?}", both[0].why);
    assert_eq!(both[0].recording.parts[0].file, "Channel/t.001");
    let listings = [&memory, &disk].map(|source| {
        pipeline::inspect(source, &nominal(), &Limits::default(), &Control::default()).unwrap()
    });
    assert_eq!(listings[0], listings[1]);
    assert_eq!(listings[0].channels.len(), 2);
}

#[test]
fn verif_the_identity_is_that_of_the_question() {
    let source = signals("surviving.csv");
    let id = |request: &Request| {
        let outcome = judged(&source, request, &Design::reference());
        outcome.document.report_id
    };
    let plain = id(&nominal());
    assert_eq!(plain.len(), 64);
    assert_eq!(plain, id(&nominal()), "the same question");
    let mut seen = BTreeSet::from([plain.clone()]);
    for (key, value) in every_setting().as_object().unwrap() {
        let mut asked = serde_json::to_value(nominal()).unwrap();
        asked[key] = value.clone();
        // Steps are a part of the methods that take them.
        if key == "steps_per_period" {
            asked["method"] = json!("rk4");
        }
        assert!(seen.insert(id(&request(asked))), "{key} is no part of it");
    }
    // A default that is stated is no other question.
    let stated = request(json!({"members": 0, "seed": 1, "model": "auto", "resample": "native"}));
    assert_eq!(id(&stated), plain);
    let mut design = Design::reference();
    apply_override(&mut design, "lever.mass_kg=0.15").unwrap();
    let mut renamed = Design::reference();
    renamed.name = "other".into();
    for other in [design, renamed] {
        let document = judged(&source, &nominal(), &other).document;
        assert!(seen.insert(document.report_id));
    }
    // Name, bytes and card of the recording.
    let bytes = std::fs::read("signals/surviving.csv").unwrap();
    let card = std::fs::read("signals/surviving.csv.toml").unwrap();
    let memory = |name: &str, bytes: Vec<u8>| Source::bytes(name, bytes);
    let same = memory("surviving.csv", bytes.clone()).with_card(card.clone());
    assert_eq!(document_of(&same, &nominal()).report_id, plain);
    let mut longer = card.clone();
    longer.push(b'\n');
    let mut changed = bytes.clone();
    changed.push(b'\n');
    for other in [
        memory("surviving.csv", bytes.clone()),
        memory("surviving.csv", bytes.clone()).with_card(longer),
        memory("surviving.csv", changed).with_card(card.clone()),
        memory("other.csv", bytes).with_card(card),
    ] {
        assert!(seen.insert(document_of(&other, &nominal()).report_id));
    }
}

/// What reads the recording once judges many designs, each as if it were the first.
#[test]
fn verif_a_prepared_recording_judges_many_designs() {
    let source = signals("burst.csv");
    let (limits, control) = (Limits::default(), Control::default());
    let prepared = Prepared::open(&source, &nominal(), &limits, &control).unwrap();
    for preload in [0.1, 1.0, 3.0] {
        let mut design = Design::reference();
        apply_override(&mut design, &format!("lever.preload_torque_nm={preload}")).unwrap();
        let again = prepared
            .judge(&design, Extras::default(), &control)
            .document;
        assert_eq!(again, judged(&source, &nominal(), &design).document);
        assert_eq!(again.report_id, prepared.report_id(&design));
    }
    let two = Control::unwatched(2);
    let design = Design::reference();
    let extras = Extras {
        filter_table: true,
        preload_answer: true,
        evidence: true,
    };
    assert_eq!(
        prepared.judge(&design, extras, &two).document,
        prepared.judge(&design, extras, &control).document,
        "threads change no number"
    );
}

#[test]
fn val_a_refusal_is_a_document() {
    let nothing = Source::bytes("a.csv", *b"");
    let outcome = judged(&nothing, &nominal(), &Design::reference());
    let document = &outcome.document;
    assert_eq!(document.verdict, Answer::Unusable);
    assert!(document.nominal.is_none() && document.recording.sha256.is_some());
    assert_eq!(document.why[0].code, "input-refused");
    let names: Vec<String> = outcome.files().into_iter().map(|(name, _)| name).collect();
    assert!(
        names.starts_with(&["report.html".into(), "verdict.json".into()]),
        "{names:?}"
    );
    // Several channels could be meant: each is offered with its shape.
    let twins = Source::bytes("a.csv", *b"t_s,a_y_g,b_y_g\n0,1,2\n0.1,2,3\n0.2,1,2\n");
    let outcome = judged(&twins, &nominal(), &Design::reference());
    assert!(matches!(
        outcome.refusal.unwrap().kind(),
        ErrorKind::AmbiguousChannel { .. }
    ));
    assert_eq!(outcome.offers.len(), 2);
    assert!(outcome.offers.iter().all(|offer| !offer.spark.is_empty()));
}

/// The wish to stop ends reading, judging and margins wherever it comes, and nothing else is
/// made of it.
#[test]
fn verif_a_wish_to_stop_ends_the_work() {
    let source = signals("burst.csv");
    let limits = Limits::default();
    let asked = Request {
        members: 512,
        ..Request::default()
    };
    let extras = Extras {
        filter_table: true,
        preload_answer: true,
        evidence: true,
    };
    let design = Design::reference();
    let count = AtomicUsize::new(0);
    let counting = Control {
        threads: 1,
        proceed: &|_| {
            count.fetch_add(1, Ordering::Relaxed);
            true
        },
    };
    let whole = pipeline::judge(&source, &asked, &design, extras, &limits, &counting);
    assert!(whole.refusal.is_none());
    let questions = count.load(Ordering::Relaxed);
    assert!(questions > 20, "asked only {questions} times");
    // Nothing is left to stop once the last question was asked.
    for after in (0..questions - 1).step_by(questions / 8) {
        let left = AtomicUsize::new(after);
        let stopping = Control {
            threads: 1,
            proceed: &|_| {
                left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
                    left.checked_sub(1)
                })
                .is_ok()
            },
        };
        let outcome = pipeline::judge(&source, &asked, &design, extras, &limits, &stopping);
        let error = outcome
            .refusal
            .clone()
            .unwrap_or_else(|| panic!("stopped after {after} of {questions}, and went on"));
        assert_eq!(
            error.kind(),
            &ErrorKind::Kernel(KernelError::Stopped),
            "after {after}"
        );
        // Nothing of it can be kept for an answer.
        assert_eq!(outcome.document.verdict, Answer::Unusable);
        assert_eq!(outcome.document.report_id, "");
        assert!(outcome.files().is_empty());
    }
    let margin = MarginRequest {
        replay: asked,
        ..MarginRequest::default()
    };
    let left = AtomicUsize::new(200);
    let stopping = Control {
        threads: 2,
        proceed: &|_| {
            left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
                left.checked_sub(1)
            })
            .is_ok()
        },
    };
    match pipeline::margin(&source, &margin, &design, &limits, &stopping) {
        Ok(outcome) => assert!(outcome.margins.stopped),
        Err(error) => assert_eq!(error.kind(), &ErrorKind::Kernel(KernelError::Stopped)),
    }
}

/// Returns a document as it is read back and written again.
fn again<T: serde::Serialize + serde::de::DeserializeOwned>(text: &str) -> String {
    let document: T = serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}"));
    json::render(&document)
}

#[test]
fn verif_documents_are_read_back() {
    let (limits, control) = (Limits::default(), Control::default());
    for (name, asked) in [
        ("burst.csv", json!({"members": 128})),
        (
            "burst.csv",
            json!({"members": 0, "method": "rk4", "steps_per_period": 50}),
        ),
        (
            "surviving.csv",
            json!({"opens_when": "both", "window": "0..0.05"}),
        ),
        ("ugly.csv", json!({})),
        (
            "half_sine_30g_11ms.csv",
            json!({"unit": "m/s2", "filter": "none", "model": "soft"}),
        ),
    ] {
        let source = signals(name);
        let design = Design::reference();
        let extras = Extras {
            filter_table: true,
            // The search takes longer than all the rest, and one document has what any has of it.
            preload_answer: name == "half_sine_30g_11ms.csv",
            evidence: true,
        };
        let outcome = pipeline::judge(&source, &request(asked), &design, extras, &limits, &control);
        assert_eq!(
            outcome.document.preload_answer.is_some(),
            extras.preload_answer
        );
        let text = json::render(&outcome.document);
        assert_eq!(again::<Document>(&text), text, "{name}");
        let stored: Document = serde_json::from_str(&text).unwrap();
        assert_eq!(stored.request, outcome.document.request);
        let listing = pipeline::inspect(&source, &nominal(), &limits, &control).unwrap();
        let text = json::render(&listing);
        assert_eq!(again::<Listing>(&text), text, "{name}");
    }
    for (name, asked) in [
        (
            "surviving.csv",
            json!({"members": 0, "counterweight_radius": 0.05}),
        ),
        ("burst.csv", json!({"members": 0})),
        ("burst_imu.mcap", json!({"members": 0})),
        ("half_sine_30g_11ms.csv", json!({"members": 0})),
        ("sled_30g_30ms.csv", json!({"members": 0})),
        ("ugly.csv", json!({"members": 0})),
    ] {
        let source = signals(name);
        let asked: MarginRequest = serde_json::from_value(asked).unwrap();
        let design = Design::reference();
        let margin = pipeline::margin(&source, &asked, &design, &limits, &control).unwrap();
        let text = json::render(&margin.document);
        assert_eq!(again::<MarginDocument>(&text), text, "{name}");
    }
}

/// What the other commands print, and the studies that are kept, is read back as well.
#[test]
fn verif_documents_of_every_command_are_read_back() {
    let folder = Folder::new("read-back");
    for name in ["burst.csv", "surviving.csv"] {
        let Source::File(path) = signals(name) else {
            unreachable!("a file")
        };
        std::fs::copy(&path, folder.path().join(name)).unwrap();
        std::fs::copy(
            path.with_extension("csv.toml"),
            folder.path().join(format!("{name}.toml")),
        )
        .unwrap();
    }
    let gate = "[[recordings]]\nfiles = [\"burst.csv\", \"surviving.csv\"]\nmembers = 0\n\
                [[designs]]\nname = \"paper\"\n";
    folder.write("gate.toml", gate);
    let run = |words: &[&str]| {
        let done = finish(program().args(words).current_dir(folder.path()));
        assert!(done.code < 4, "{words:?}: {}", done.err);
        done.out
    };
    let json = ["--format", "json"];
    let asked = |words: &[&str]| run(&[words, &json].concat());
    let nominal = ["--members", "0"];
    let several = asked(&[&["replay", "burst.csv", "surviving.csv"], &nominal[..]].concat());
    check_again::<Verdicts>("replay", &several);
    run(&[&["replay", "burst.csv", "--out", "a"], &nominal[..]].concat());
    run(&[&["replay", "surviving.csv", "--out", "b"], &nominal[..]].concat());
    for other in ["a/verdict.json", "b/verdict.json"] {
        check_again::<VerdictComparison>("compare", &asked(&["compare", "a/verdict.json", other]));
    }
    check_again::<Verification>("verify", &asked(&["verify", "a/verdict.json"]));
    let verdict = std::fs::read_to_string(folder.path().join("a/verdict.json")).unwrap();
    let moved = verdict.replacen("\"threshold_rad\": ", "\"threshold_rad\": 1", 1);
    folder.write("a/verdict.json", moved);
    check_again::<Verification>("verify", &asked(&["verify", "a/verdict.json"]));
    check_again::<LimitList>("limits", &asked(&["limits", "--limit", "lines=7"]));
    run(&["gate", "gate.toml", "--out", "gate", "--reports", "none"]);
    let summary = std::fs::read_to_string(folder.path().join("gate/summary.json")).unwrap();
    check_again::<GateSummary>("gate", &summary);
    for name in ["damages", "stability", "work-precision"] {
        let kept = std::fs::read_to_string(format!("reports/{name}/{name}.json")).unwrap();
        check_again::<Summary>(name, &kept);
    }
}

/// Checks that a document is read back as it was written, whatever way it was indented.
#[track_caller]
fn check_again<T: serde::Serialize + serde::de::DeserializeOwned>(name: &str, text: &str) {
    let written: Value = serde_json::from_str(text).unwrap();
    let read: Value = serde_json::from_str(&again::<T>(text)).unwrap();
    assert_eq!(read, written, "{name}");
}

/// A stored verdict comes out again, byte for byte; one that was changed by hand is refused.
#[test]
fn verif_a_stored_verdict_is_made_again() {
    let source = signals("surviving.csv");
    let asked = request(json!({"members": 128, "filter": "none"}));
    let document = document_of(&source, &asked);
    assert_eq!(document.run.numbers_revision, Some(NUMBERS_REVISION));
    let text = json::render(&document);
    let verified = |text: &str| {
        let stored = Stored::from_json(text.as_bytes())?;
        let request = stored.request().clone();
        let (limits, control) = (Limits::default(), Control::default());
        pipeline::verify(&stored, &source, &request, false, None, &limits, &control)
    };
    let same = verified(&text).unwrap();
    assert!(same.same, "{same:?}");
    for (key, value) in [
        ("request/members", json!(129)),
        ("request/filter", json!("cfc60")),
        ("request/channel", json!("acc_y")),
        ("design/lever/mass_kg", json!(0.2)),
        ("design/name", json!("other")),
        ("recording/sha256", json!("ab".repeat(32))),
    ] {
        let mut changed: Value = serde_json::from_str(&text).unwrap();
        let (block, last) = key.rsplit_once('/').unwrap();
        changed.pointer_mut(&format!("/{block}")).unwrap()[last] = value;
        let error = verified(&changed.to_string()).unwrap_err();
        assert!(error.to_string().contains("report_id"), "{key}: {error}");
    }
    // A number that was changed is a difference, not a doubt.
    let peak = format!(
        "\"peak_angle_rad\": {}",
        document.nominal.unwrap().peak_angle_rad
    );
    let verification = verified(&text.replacen(&peak, "\"peak_angle_rad\": 0.01", 1)).unwrap();
    assert!(!verification.same && verification.differences > 0);
}

/// The example program judges bytes with a card and two designs, in at most forty lines.
#[test]
fn val_the_example_of_the_library_runs() {
    let source = std::fs::read_to_string("examples/judge_from_memory.rs").unwrap();
    assert!(
        source.lines().count() <= 40,
        "{} lines",
        source.lines().count()
    );
    assert!(!source.contains("clap"));
    // A run of all targets has built it already, with the packages' features of that run; another
    // set of features would be another build of everything.
    let mut run = if std::env::var_os("LATCHGATE_EXAMPLES_BUILT").is_some() {
        let tests = std::env::current_exe().unwrap();
        let profile = tests.parent().unwrap().parent().unwrap();
        std::process::Command::new(profile.join("examples/judge_from_memory"))
    } else {
        let mut cargo = std::process::Command::new(env!("CARGO"));
        cargo.args([
            "run",
            "--quiet",
            "--locked",
            "--example",
            "judge_from_memory",
        ]);
        cargo
    };
    let done = run.output().unwrap();
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(
        done.status.success(),
        "{said}{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 3, "{said}");
    assert!(
        lines[0].contains("paper: fail") && lines[1].contains("stiffer: "),
        "{said}"
    );
    assert_ne!(lines[0].split(' ').next(), lines[1].split(' ').next());
    assert_eq!(lines[2], "stopped: true");
}

/// The files of the outside world in `tests/data` give documents that can be read back, too.
#[test]
fn verif_documents_of_real_recordings_are_read_back() {
    let folder = data("recordings");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let document = document_of(&Source::File(path.clone()), &nominal());
        let text = json::render(&document);
        assert_eq!(again::<Document>(&text), text, "{}", path.display());
        seen += 1;
    }
    assert!(seen > 5);
}

/// A number that no lever can have is refused wherever the design comes from: none may turn a
/// fail into a pass.
#[test]
fn regress_impossible_designs_are_not_judged() {
    let source = signals("half_sine_30g_11ms.csv");
    let written = serde_json::to_value(Design::reference()).unwrap();
    for parameter in PARAMETERS {
        let (section, key) = parameter.name.split_once('.').unwrap();
        // A centre of mass may lie on either side of the pivot.
        let third = match parameter.condition {
            Condition::NotZero => 0.0,
            _ => -1.0,
        };
        for bad in [f64::NAN, f64::INFINITY, third] {
            let mut design = Design::reference();
            match parameter.name {
                "lever.moment_of_inertia_kg_m2" => design.lever.moment_of_inertia_kg_m2 = bad,
                "lever.pivot_damping_nm_s_per_rad" => design.lever.pivot_damping_nm_s_per_rad = bad,
                "lever.spring_stiffness_nm_per_rad" => {
                    design.lever.spring_stiffness_nm_per_rad = bad;
                }
                "lever.preload_torque_nm" => design.lever.preload_torque_nm = bad,
                "lever.mass_kg" => design.lever.mass_kg = bad,
                "lever.center_of_mass_m" => design.lever.center_of_mass_m = bad,
                "stop.restitution" => design.stop.restitution = bad,
                "stop.stiffness_n_per_m" => design.stop.stiffness_n_per_m = bad,
                "stop.damping_n_s_per_m" => design.stop.damping_n_s_per_m = bad,
                "stop.radius_m" => design.stop.radius_m = bad,
                "criterion.threshold_rad" => design.criterion.threshold_rad = bad,
                "criterion.open_share" => design.criterion.open_share = bad,
                "criterion.confidence" => design.criterion.confidence = bad,
                "input.scale" => design.input.scale = bad,
                "input.bias_g" => design.input.bias_g = bad,
                other => panic!("a new number: {other}"),
            }
            for members in [0, 128] {
                let asked = Request {
                    members,
                    ..Request::default()
                };
                let outcome = judged(&source, &asked, &design);
                let name = parameter.name;
                let refusal = outcome.refusal.unwrap_or_else(|| panic!("{name} = {bad}"));
                assert!(refusal.to_string().contains(name), "{name}: {refusal}");
                assert_eq!(outcome.document.verdict, Answer::Unusable);
            }
        }
        let mut stated = written.clone();
        stated[section][key] = json!(third);
        let error = serde_json::from_value::<Design>(stated).unwrap_err();
        assert!(error.to_string().contains(parameter.name), "{error}");
    }
    assert_eq!(
        serde_json::from_value::<Design>(written).unwrap(),
        Design::reference()
    );
}

/// A soft stop that glues the lever is no stop: refused with its damping ratio.
#[test]
fn verif_a_stop_damped_like_glue_is_refused() {
    let mut design = Design::reference();
    let damping = design.stop.damping_n_s_per_m / design.contact_damping_ratio();
    design.stop.damping_n_s_per_m = 50.1 * damping;
    let outcome = judged(&signals("burst.csv"), &nominal(), &design);
    let refusal = outcome.refusal.unwrap().to_string();
    assert!(
        refusal.contains("damping ratio") && refusal.contains("at most 50"),
        "{refusal}"
    );
    design.stop.damping_n_s_per_m = 49.9 * damping;
    assert!(
        judged(&signals("burst.csv"), &nominal(), &design)
            .refusal
            .is_none()
    );
}

/// What a request holds can be written and read back, or it is refused.
#[test]
fn regress_requests_that_no_document_could_state_are_refused() {
    let bad: [fn(&mut Request); 7] = [
        |request| request.window_s = Some(Window::new(f64::NAN, f64::NAN)),
        |request| request.window_s = Some(Window::new(f64::NEG_INFINITY, f64::INFINITY)),
        |request| request.tolerance_rad = Some(-1.0),
        |request| request.rate_hz = Some(f64::NAN),
        |request| request.phi0_rad = Some(f64::NAN),
        |request| request.members = u32::MAX,
        |request| {
            request.rate_hz = Some(1e4);
            request.time_column = Some("t".into());
        },
    ];
    for (index, change) in bad.into_iter().enumerate() {
        let mut asked = nominal();
        change(&mut asked);
        assert!(asked.check().is_err(), "{index}: {asked:?}");
        let outcome = judged(&signals("burst.csv"), &asked, &Design::reference());
        assert!(outcome.refusal.is_some(), "{index}");
    }
    check_refused(json!({"channel": 0}), &["`channel`: must be a name"]);
    check_refused(
        json!({"filter": "cfc61"}),
        &["the setting `filter`: expected none, cfc60"],
    );
    let twice = serde_json::from_str::<Request>(r#"{"members": 0, "members": 10000}"#);
    assert!(
        twice
            .unwrap_err()
            .to_string()
            .contains("`members` stands twice")
    );
    let radius = serde_json::from_value::<MarginRequest>(json!({"counterweight_radius": 0}));
    assert!(
        radius
            .unwrap_err()
            .to_string()
            .contains("counterweight_radius")
    );
}

/// Spellings of one question, and questions that only look alike.
#[test]
fn regress_one_question_has_one_identity() {
    let source = signals("surviving.csv");
    let id = |value: Value| document_of(&source, &request(value)).report_id;
    assert_eq!(
        id(json!({"members": 0, "window": "-0..0.05"})),
        id(json!({"members": 0, "window": "0..0.05"}))
    );
    let limit = Limits::default().text_bytes;
    assert_eq!(
        id(json!({"members": 0, "limit": {"text_bytes": limit}})),
        id(json!({"members": 0}))
    );
    // Limits of the caller are part of it, and stand in the document.
    let few = Limits {
        samples: 100,
        ..Limits::default()
    };
    let control = Control::default();
    let design = Design::reference();
    let within = |limits| {
        pipeline::judge(
            &source,
            &nominal(),
            &design,
            Extras::default(),
            limits,
            &control,
        )
    };
    let (narrow, wide) = (within(&few).document, within(&Limits::default()).document);
    assert_ne!(narrow.report_id, wide.report_id);
    assert_eq!(narrow.request.limits["samples"], 100);
    // A card that cannot be read is another card than the next.
    let table = std::fs::read("signals/surviving.csv").unwrap();
    let with_card = |unit: &str| {
        let card = format!("unit = \"{unit}\"\n").into_bytes();
        let source = Source::bytes("surviving.csv", table.clone()).with_card(card);
        document_of(&source, &nominal())
    };
    let (furlong, mile) = (with_card("furlong"), with_card("mile"));
    assert_eq!(furlong.verdict, Answer::Unusable);
    assert_ne!(furlong.report_id, mile.report_id);
    let mut plain = Design::reference();
    let mut negative = Design::reference();
    apply_override(&mut plain, "input.bias_g=0").unwrap();
    apply_override(&mut negative, "input.bias_g=-0").unwrap();
    let [plain, negative] = [plain, negative].map(|design| {
        let document = judged(&source, &nominal(), &design).document;
        json::render(&document.design)
    });
    assert_eq!(plain, negative);
}

/// The card among named bytes is the card, as it is in a folder.
#[test]
fn regress_a_card_among_named_bytes_is_read() {
    let files = ["burst.csv", "burst.csv.toml"].map(|name| {
        let bytes = std::fs::read(format!("signals/{name}")).unwrap();
        (name.to_string(), bytes.into())
    });
    let memory = Source::files("burst.csv", files);
    assert_eq!(
        document_of(&memory, &nominal()),
        document_of(&signals("burst.csv"), &nominal())
    );
}

/// A run that only estimates its error decides no pass, by whatever method: where the default passes,
/// every method to compare with stays undecided.
#[test]
fn verif_only_a_bound_passes() {
    let source = signals("surviving.csv");
    for method in [
        "event-driven",
        "rk4",
        "rk4-located",
        "dopri5",
        "dopri5-samples",
        "moreau-jean",
    ] {
        let request = request(json!({"method": method, "model": "rigid", "members": 0}));
        let document = document_of(&source, &request);
        let runs = || document.models.values().chain(&document.nominal);
        let bounded = runs().all(|run| run.error.is_bound());
        assert_eq!(bounded, method == "event-driven", "{method}");
        let expected = if bounded { "pass" } else { "undecided" };
        assert_eq!(document.verdict.name(), expected, "{method}");
        assert!(runs().count() >= 2, "{method}");
        for run in runs() {
            assert_eq!(run.error.rad(), run.numerical_error_rad, "{method}");
        }
    }
}
