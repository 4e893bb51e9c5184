//! Remarks: what a person wrote of a channel blocks until a person accepts it, by every door.

use crate::remark_words::HARMLESS_IN_TRUTH;
use crate::support::{Folder, latchgate};
use latchgate::pipeline::{
    self, Answer, Control, Design, Extras, Finding, Limits, MarginRequest, Outcome, Request,
    Severity, Source, Stored,
};
use std::sync::atomic::{AtomicU32, Ordering};

/// A push that the paper's lever survives, below `head`.
fn table(head: &str) -> String {
    let row = |k: i32| {
        let x = f64::from(k);
        let push = if (0..200).contains(&k) {
            30.0 * (std::f64::consts::PI * x / 200.0).sin()
        } else {
            0.0
        };
        let noise = 0.05 * (0.91 * x).sin() + 0.03 * (2.3 * x + 1.0).sin();
        format!("{:.4},{:.3}\n", x / 1e4, push + noise)
    };
    format!("{head}\n{}", (-200..700).map(row).collect::<String>())
}

/// The same as a curve of NHTSA with its header: status and comment.
fn curve(status: &str, comment: &str) -> (Folder, Source) {
    let rows = table("").replace(',', "\t");
    let line = format!(
        "1|146|AC|NA|DSLF|YG|SEC|G'S|1650||01/01/20|2000|2|0.0|-200|699|100|{status}|P|{comment}"
    );
    // Tests run side by side, and each folder is emptied when it is made.
    static MADE: AtomicU32 = AtomicU32::new(0);
    let made = MADE.fetch_add(1, Ordering::Relaxed);
    let folder = Folder::new(&format!("remark-curve-{made}"));
    folder.write("v1.EV5", format!("----- INSTRUMENTATION -----\n{line}"));
    let path = folder.write("v1.146", rows.trim_start());
    (folder, Source::File(path.into()))
}

fn csv(text: impl AsRef<[u8]>) -> Source {
    Source::bytes("a.csv", text.as_ref())
}

fn asking(accepted: &[&str]) -> Request {
    Request {
        members: 0,
        opens_when: Some(pipeline::CardPolarity::Negative),
        accepted_remarks: accepted.iter().map(ToString::to_string).collect(),
        transfer: Some(pipeline::TransferRange::ONE),
        ..Request::default()
    }
}

fn judged(source: &Source, accepted: &[&str]) -> Outcome {
    let (design, limits) = (Design::reference(), Limits::default());
    let control = Control::default();
    pipeline::judge(
        source,
        &asking(accepted),
        &design,
        Extras::default(),
        &limits,
        &control,
    )
}

/// Findings that speak of remarks.
fn of_remarks(outcome: &Outcome) -> impl Iterator<Item = &Finding> {
    let is_of_remark = |finding: &&Finding| {
        finding.code.contains("remark") || finding.code == "invalid-by-laboratory"
    };
    outcome.document.findings.iter().filter(is_of_remark)
}

/// Checks answer, and codes with severity of what was found, notes of no interest left out.
#[track_caller]
fn check(outcome: &Outcome, answer: Answer, codes: &[(&str, Severity)]) {
    let document = &outcome.document;
    assert!(outcome.refusal.is_none(), "{:?}", outcome.refusal);
    assert_eq!(document.verdict, answer, "{:#?}", document.findings);
    let mut found: Vec<(&str, Severity)> = of_remarks(outcome)
        .map(|one| (&*one.code, one.severity))
        .collect();
    let mut codes = codes.to_vec();
    found.sort_unstable();
    codes.sort_unstable();
    assert_eq!(found, codes, "{:#?}", document.findings);
}

const BLOCKS: (&str, Severity) = ("laboratory-remark", Severity::Blocking);
const SHOWN: (&str, Severity) = ("laboratory-remark", Severity::Info);
const ACCEPTED: (&str, Severity) = ("remark-accepted", Severity::Warning);
const STALE: (&str, Severity) = ("accepted-remark-not-found", Severity::Warning);
const STATUS: (&str, Severity) = ("invalid-by-laboratory", Severity::Blocking);

/// Harmless in truth, but not for a program to tell: a line in the question is enough.
#[test]
fn val_a_person_accepts_a_remark_by_its_text() {
    let comments = HARMLESS_IN_TRUTH.iter();
    for comment in comments.chain(&["AIRBAG FIRED AT 12 MS"]) {
        let (_folder, source) = curve("AM", comment);
        check(&judged(&source, &[]), Answer::Unusable, &[BLOCKS]);
        check(&judged(&source, &[comment]), Answer::Pass, &[ACCEPTED]);
        let spaced = format!(" {} ", comment.replace(' ', "  "));
        check(&judged(&source, &[&spaced]), Answer::Pass, &[ACCEPTED]);
        // Not by a part of it, in other letters, or by another.
        for other in [&comment[1..], &comment.to_lowercase(), "NO COMMENTS", ""] {
            let outcome = judged(&source, &[other]);
            check(&outcome, Answer::Unusable, &[BLOCKS, STALE]);
        }
    }
    for comment in ["DRIVER HEAD Y", "THORAX CG"] {
        let (_folder, source) = curve("AM", comment);
        check(&judged(&source, &[]), Answer::Pass, &[SHOWN]);
    }
    let (_folder, source) = curve("AM", "NO COMMENTS");
    check(&judged(&source, &[]), Answer::Pass, &[]);
}

/// What a program wrote for programs cannot be talked away.
#[test]
fn val_a_status_cannot_be_accepted() {
    for status in ["QD", "CF", "MN", "NO", "XX"] {
        let (_folder, source) = curve(status, "DEAD PEDAL");
        let outcome = judged(&source, &["DEAD PEDAL", status]);
        check(&outcome, Answer::Unusable, &[STATUS, ACCEPTED, STALE]);
    }
    // From the instant on that the comment names, accepted or not.
    let comment = "NO VALID DATA AFTER 30 MS";
    for accepted in [&[][..], &[comment]] {
        let (_folder, source) = curve("QD", comment);
        let outcome = judged(&source, accepted);
        let findings = &outcome.document.findings;
        let status = findings.iter().find(|one| one.code == STATUS.0);
        assert_eq!(status.unwrap().at_s, Some(0.03));
    }
    let rows = |k: i32, row: &str| format!("{row},{}\n", i32::from(k < 300));
    let text = table("time_s,acc_y_g");
    let (head, body) = text.split_once('\n').unwrap();
    let rows: String = (0..)
        .zip(body.lines())
        .map(|(k, row)| rows(k, row))
        .collect();
    let source = csv(format!("{head},valid\n{rows}"));
    let request = Request {
        channel: Some("acc_y_g".into()),
        ..asking(&["valid: 0", "0"])
    };
    let outcome = pipeline::judge(
        &source,
        &request,
        &Design::reference(),
        Extras::default(),
        &Limits::default(),
        &Control::default(),
    );
    check(&outcome, Answer::Unusable, &[STATUS, STALE, STALE]);
}

/// Each is accepted by itself; what is accepted and not there is told, with what comes near.
#[test]
fn val_each_remark_is_accepted_by_itself() {
    let head = "# acc_y_g: cable was loose\n# N.G.\n# door, left\ntime_s,acc_y_g";
    let source = csv(table(head));
    let (loose, no_good) = ("acc_y_g: cable was loose", "N.G.");
    check(&judged(&source, &[]), Answer::Unusable, &[BLOCKS, BLOCKS]);
    let outcome = judged(&source, &[loose]);
    check(&outcome, Answer::Unusable, &[BLOCKS, ACCEPTED]);
    let outcome = judged(&source, &[loose, no_good, "door, left"]);
    check(&outcome, Answer::Pass, &[ACCEPTED, ACCEPTED]);
    let outcome = judged(&source, &[loose, "N.G"]);
    check(&outcome, Answer::Unusable, &[BLOCKS, ACCEPTED, STALE]);
    let stale = outcome
        .document
        .findings
        .iter()
        .find(|one| one.code == STALE.0);
    let text = &stale.unwrap().text;
    assert!(
        text.contains("\"N.G\"") && text.contains("nearest is \"N.G.\""),
        "{text}"
    );
}

/// The message holds the line for the card as it must be written, whatever the remark holds.
#[test]
fn val_the_message_gives_the_line_for_the_card() {
    for remark in [
        "cable lost",
        "said \"lost\"",
        r"C:\lost $HOME `x` it's",
        "verloren \u{201e}ü\u{201c}",
        "lost\u{202e}\u{200b}again",
    ] {
        let head = format!("# acc_y_g: {remark}\ntime_s,acc_y_g");
        let source = csv(table(&head));
        let outcome = judged(&source, &[]);
        check(&outcome, Answer::Unusable, &[BLOCKS]);
        let text = &outcome.document.findings[0].text;
        let line = &text[text.find("accepted_remarks = [").unwrap()..];
        let source = csv(table(&head)).with_card(line.as_bytes());
        let outcome = judged(&source, &[]);
        check(&outcome, Answer::Pass, &[ACCEPTED]);
        assert!(outcome.document.findings[0].text.contains("by the card"));
    }
}

/// A long remark is accepted by what a finding quotes of it, or by what the report shows, the hash of
/// the whole among it; never by the start alone, nor for another end.
#[test]
fn val_a_long_remark_is_accepted_whole() {
    for repeated in [100, 2000] {
        let long = |end: &str| format!("acc_y_g: lost {}{end}", "é a ".repeat(repeated));
        let source = |text: &str| csv(table(&format!("# {text}\ntime_s,acc_y_g")));
        let outcome = judged(&source(&long("b")), &[]);
        check(&outcome, Answer::Unusable, &[BLOCKS]);
        let text = &outcome.document.findings[0].text;
        let (_, line) = text.rsplit_once("accepted_remarks = [\"").unwrap();
        let quoted = line.strip_suffix("\"]").unwrap();
        assert!(
            quoted.chars().count() < 300 && quoted.contains("SHA-256"),
            "{quoted}"
        );
        let (_, says) = text.split_once(": \"").unwrap();
        let (shown, _) = says.split_once("\". ").unwrap();
        assert_eq!(shown.contains("SHA-256"), repeated == 2000, "{shown}");
        for accepted in [quoted, shown] {
            let outcome = judged(&source(&long("b")), &[accepted]);
            check(&outcome, Answer::Pass, &[ACCEPTED]);
            let outcome = judged(&source(&long("c")), &[accepted]);
            check(&outcome, Answer::Unusable, &[BLOCKS, STALE]);
        }
        let (start, _) = quoted.split_once('…').unwrap();
        let outcome = judged(&source(&long("b")), &[start]);
        check(&outcome, Answer::Unusable, &[BLOCKS, STALE]);
    }
}

/// However many lines speak of faults, a screenful is told at a time, and all count.
#[test]
fn val_many_remarks_are_told_in_part_and_all_count() {
    let lines = |count: usize| -> Vec<String> {
        (0..count)
            .map(|k| format!("acc_y_g: bad, number {k}"))
            .collect()
    };
    let table = |lines: &[String]| {
        let head: String = lines.iter().map(|line| format!("# {line}\n")).collect();
        csv(table(&format!("{head}time_s,acc_y_g")))
    };
    let many = lines(3000);
    let outcome = judged(&table(&many), &[]);
    assert_eq!(outcome.document.verdict, Answer::Unusable);
    assert_eq!(of_remarks(&outcome).count(), 21);
    let few = lines(22);
    let mut accepted: Vec<&str> = few.iter().map(String::as_str).collect();
    check(
        &judged(&table(&few), &accepted),
        Answer::Pass,
        &[ACCEPTED; 22],
    );
    accepted.pop();
    let outcome = judged(&table(&few), &accepted);
    assert_eq!(outcome.document.verdict, Answer::Unusable);
}

/// What is accepted is part of the question, of its document and of all that repeats it.
#[test]
fn verif_acceptance_is_part_of_the_question() {
    let (_folder, source) = curve("AM", "DEAD PEDAL");
    let accepted = judged(&source, &["DEAD PEDAL"]).document;
    let asked = judged(&source, &[]).document;
    assert_ne!(accepted.report_id, asked.report_id);
    let value = serde_json::to_value(&accepted).unwrap();
    assert_eq!(value["request"]["accepted_remarks"][0], "DEAD PEDAL");
    assert!(serde_json::to_value(&asked).unwrap()["request"]["accepted_remarks"].is_null());

    let stored = Stored::from_json(value.to_string().as_bytes()).unwrap();
    let again = pipeline::verify(
        &stored,
        &source,
        stored.request(),
        false,
        None,
        &Limits::default(),
        &Control::default(),
    );
    assert!(again.unwrap().same);

    let margin = |accepted: &[&str]| {
        let request = MarginRequest {
            replay: asking(accepted),
            ..MarginRequest::default()
        };
        let (design, limits, control) =
            (Design::reference(), Limits::default(), Control::default());
        let outcome = pipeline::margin(&source, &request, &design, &limits, &control);
        serde_json::to_value(outcome.unwrap().document).unwrap()["verdict"].clone()
    };
    assert_eq!(margin(&["DEAD PEDAL"]), "pass");
    assert_ne!(margin(&[]), "pass");
}

/// The option and the card, at the process boundary, with the page of the report.
#[test]
fn cli_remarks_are_accepted_by_option_and_card() {
    let folder = Folder::new("accept-remark");
    let path = folder.write("a.csv", table("# Overload: 2\n# N.G.\ntime_s,acc_y_g"));
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let asked = [
        "replay",
        &path,
        "--opens-when",
        "negative",
        "--members",
        "0",
        "--transfer",
        "1",
        "--out",
        out,
    ];
    let refused = latchgate(&asked);
    assert_eq!(refused.code, 4);
    for part in [
        "--accept-remark \"Overload: 2\"",
        "accepted_remarks = [\"Overload: 2\"]",
    ] {
        assert!(refused.out.contains(part), "{}", refused.out);
    }
    let both = ["--accept-remark", "Overload: 2", "--accept-remark", "N.G."];
    let accepted = latchgate(&[&asked[..], &both].concat());
    assert_eq!(accepted.code, 0, "{}", accepted.err);
    assert!(accepted.out.contains("remark-accepted"), "{}", accepted.out);
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("Overload: 2") && page.contains("N.G."));

    let lines = "accepted_remarks = [\n  \"Overload: 2\",\n  \"N.G.\",\n]\n";
    folder.write("a.csv.toml", lines);
    assert_eq!(latchgate(&asked).code, 0);
    folder.write("a.csv.toml", "accepted_remarks = \"N.G.\"\n");
    let wrong = latchgate(&asked);
    assert_eq!(wrong.code, 4);
    assert!(wrong.err.contains("a list of texts"), "{}", wrong.err);
}
