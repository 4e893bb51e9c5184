//! The report: what people read says what the verdict says, is well formed, safe and the same
//! each time. The documents are made up (see `fixture`); no number here checks the physics.

mod fixture;
mod terminal;

use fixture::Case;
use latchgate_document::design_file::apply_override;
use latchgate_document::{Document, json, number};
use latchgate_kernel::model::stop::StopModel;
use latchgate_report::plot::chart::Point;
use latchgate_report::terminal::Look;
use latchgate_report::{escape, html, plot, series, sparkline, text};
use latchgate_verdict::margin::Advice;
use latchgate_verdict::{Answer, Ensemble};
use std::path::PathBuf;

/// Elements that HTML and SVG close by themselves; the page writes them as `<br/>`.
#[track_caller]
pub(super) fn check_balanced(name: &str, markup: &str) {
    let mut open: Vec<String> = Vec::new();
    let mut rest = markup;
    while let Some(start) = rest.find('<') {
        let before = &rest[..start];
        check_entities(name, before);
        let tail = &rest[start + 1..];
        // A quoted attribute may hold anything but a quote and `<`.
        let mut quote = None;
        let end = tail
            .char_indices()
            .find(|(_, c)| match quote {
                Some(open) => {
                    if *c == open {
                        quote = None;
                    }
                    false
                }
                None if *c == '"' || *c == '\'' => {
                    quote = Some(*c);
                    false
                }
                None => *c == '>',
            })
            .unwrap_or_else(|| panic!("{name}: a tag without an end: {:.60}", &rest[start..]))
            .0;
        let tag = &tail[..end];
        assert!(!tag.contains('<'), "{name}: `<` inside the tag <{tag}>");
        rest = &tail[end + 1..];
        if let Some(closing) = tag.strip_prefix('/') {
            let opened = open.pop();
            assert_eq!(
                opened.as_deref(),
                Some(closing),
                "{name}: </{closing}> at {rest:.60}"
            );
        } else if !tag.starts_with('!') && !tag.ends_with('/') {
            let element = tag.split_whitespace().next().unwrap();
            open.push(element.to_string());
            if element == "style" {
                let end = rest.find("</style>").unwrap();
                assert!(!rest[..end].contains('<'), "{name}: `<` in a style");
                rest = &rest[end..];
            }
        }
    }
    assert!(open.is_empty(), "{name}: still open at the end: {open:?}");
}

#[track_caller]
fn check_entities(name: &str, text: &str) {
    for (at, _) in text.match_indices('&') {
        let entity: String = text[at..].chars().take(7).collect();
        let known = ["&amp;", "&lt;", "&gt;", "&quot;", "&#39;"];
        assert!(
            known.iter().any(|known| entity.starts_with(known)),
            "{name}: a bare & before {entity}"
        );
    }
}

#[track_caller]
fn check_offline(name: &str, markup: &str) {
    let without = markup.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for word in [
        "http:", "https:", "//www", "<link", "@import", "src=", "NaN", "inf ",
    ] {
        assert!(!without.contains(word), "{name} holds `{word}`");
    }
    for (at, _) in without.match_indices("href=\"") {
        let target = &without[at + 6..at + 28];
        assert!(
            target.starts_with('#') || target.starts_with("data:image/png;base64,"),
            "{name} refers to {target}"
        );
    }
    for (at, _) in without.match_indices("url(") {
        assert!(
            without[at..].starts_with("url(#"),
            "{name}: a url that is no fragment"
        );
    }
}

fn render(case: &Case) -> String {
    html::render(&case.document, Some(&case.evidence))
}

#[track_caller]
fn check_holds(markup: &str, words: &[&str]) {
    for word in words {
        assert!(markup.contains(word), "the page does not hold `{word}`");
    }
}

/// Returns a text as the page holds it between tags, where an apostrophe is no markup.
fn between_tags(text: &str) -> String {
    escape::markup(text).replace("&#39;", "'")
}

fn temporary_folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join("report")
        .join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    folder
}

#[test]
fn verif_page_and_plots_are_well_formed_and_offline() {
    for (name, case) in fixture::all() {
        let page = render(&case);
        let page = page.strip_prefix("<!DOCTYPE html>\n").unwrap();
        check_balanced(name, page);
        check_offline(name, page);
        let figures = plot::figures(&case.document, Some(&case.evidence));
        for figure in &figures {
            let label = format!("{name}/{}", figure.name);
            for svg in [figure.inline(), figure.stand_alone()] {
                check_balanced(&label, &svg);
                check_offline(&label, &svg);
                check_holds(
                    &svg,
                    &[
                        "role=\"img\"",
                        "<title id=",
                        "<desc id=",
                        "xmlns=\"http://www.w3.org/2000/svg\"",
                    ],
                );
            }
            assert!(
                !figure.stand_alone().contains("var(--"),
                "{label}: a file of its own needs plain colours"
            );
            check_holds(&figure.stand_alone(), &["prefers-color-scheme:dark"]);
        }
    }
}

#[test]
fn verif_ids_of_a_page_are_unique() {
    for (name, case) in fixture::all() {
        let page = render(&case);
        let mut ids: Vec<&str> = page
            .match_indices(" id=\"")
            .map(|(at, _)| page[at + 5..].split('"').next().unwrap())
            .collect();
        let all = ids.len();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), all, "{name}: an id stands twice");
        for (at, _) in page.match_indices("url(#") {
            let target = page[at + 5..].split(')').next().unwrap();
            assert!(
                ids.contains(&target),
                "{name}: url(#{target}) leads nowhere"
            );
        }
    }
}

#[test]
fn verif_same_input_same_bytes_whatever_the_run_took() {
    for (name, mut case) in fixture::all() {
        let first = render(&case);
        let figures = plot::figures(&case.document, Some(&case.evidence));
        case.document.run.elapsed_s = 987_654_321.25;
        assert_eq!(first, render(&case), "{name}");
        assert_eq!(
            figures,
            plot::figures(&case.document, Some(&case.evidence)),
            "{name}"
        );
        assert!(
            !render(&case).contains("987654321"),
            "{name}: the page tells the time the run took"
        );
    }
}

#[test]
fn verif_the_page_says_what_the_verdict_says() {
    for (name, case) in fixture::all() {
        let page = render(&case);
        let (word, class) = match case.document.verdict {
            Answer::Pass => ("<strong>PASS</strong>", "card pass"),
            Answer::Fail => ("<strong>FAIL</strong>", "card fail"),
            Answer::Undecided => ("<strong>UNDECIDED</strong>", "card undecided"),
            Answer::Unusable => ("<strong>UNUSABLE</strong>", "card unusable"),
        };
        check_holds(&page, &[word, class]);
        let other = ["PASS", "FAIL", "UNDECIDED", "UNUSABLE"];
        let shown = other
            .iter()
            .filter(|w| page.contains(&format!("<strong>{w}</strong>")))
            .count();
        assert_eq!(shown, 1, "{name}: one verdict, not several");
        check_holds(
            &page,
            &[
                "@page{size:A4",
                "break-inside:avoid",
                "@media print",
                "prefers-color-scheme:dark",
            ],
        );
        check_holds(
            &page,
            &[
                "does not replace a compliance test",
                "hold for the recording",
                "End of report",
                "9.80665",
            ],
        );
        for reason in &case.document.why {
            check_holds(&page, &[&between_tags(&reason.text), &*reason.code]);
        }
        for finding in &case.document.findings {
            check_holds(&page, &[&between_tags(&finding.text), &*finding.code]);
        }
        if let Some(run) = &case.document.nominal {
            let shown = if run.peak_angle_rad > std::f64::consts::FRAC_PI_2 {
                "&gt; 90°".to_string()
            } else {
                number::significant(run.peak_angle_rad, 2)
            };
            let usable = case.document.verdict != Answer::Unusable;
            assert!(!usable || page.contains(&shown), "{name}: {shown}");
        } else {
            assert!(!page.contains("<dt>Largest angle"), "{name}");
        }
        check_holds(
            &page,
            &[
                &format!("members = {}", case.document.request.members),
                &between_tags(&case.document.decision_rule),
            ],
        );
    }
}

#[test]
fn verif_an_unusable_recording_has_no_figures_in_its_headline() {
    let case = fixture::unusable();
    let page = render(&case);
    let card = page.split("<section").nth(1).unwrap();
    let card = card.split("</section>").next().unwrap();
    assert!(
        !card.contains("Largest angle") && !card.contains("rad"),
        "{card}"
    );
    let shown = text::render(&case.document, None, Look::default());
    assert!(!shown.contains("largest angle") && !shown.contains("limit angle"));
}

#[test]
fn verif_a_pass_without_an_ensemble_claims_no_more() {
    let case = fixture::passing();
    let page = render(&case);
    check_holds(&page, &["The nominal lever stays:", "No ensemble was run"]);
}

/// Ensemble, drivers, single inputs and filters, each number where a reader looks for it.
#[test]
fn verif_an_ensemble_is_shown_with_all_that_it_rests_on() {
    let mut case = fixture::failing();
    let page = render(&case);
    check_holds(
        &page,
        &[
            "The lever opens at ",
            "82 to 87\u{a0}%",
            "98.75\u{a0}% confidence",
            "1\u{202f}731 of 2\u{202f}048",
            "class=\"gauge share\"",
            "id=\"ensemble\"",
            "id=\"drivers\"",
            "id=\"spread\"",
            "id=\"filters\"",
            "The bias of the acceleration drives the peak most",
            "restitution of the stop",
            "could not be followed",
            "0.44",
            "Needs 6000 Hz &amp; more.",
            "in use",
            "left in, the peak is 5.6",
            "0.0987\u{a0}rad",
            "seed 1",
        ],
    );
    assert!(!page.contains("No ensemble was run") && !page.contains("NaN"));
    let look = Look {
        detail: true,
        ..Look::default()
    };
    let shown = text::render(&case.document, None, look);
    check_holds(
        &shown,
        &[
            "varied       1 731 of 2 048 varied levers open (rigid stop, more than 82 % of levers and readings, at 98.75 % confidence); soft stop: 1 731 of 2 048",
            "sensitive    to bias of the acceleration (-0.83), restitution of the stop (0.24)",
            "by filter    nominal lever alone: none 7.45° (",
        ],
    );
    // What goes with the peak no more than chance gives is not called a driver.
    let ensemble = case.document.ensemble.as_mut().unwrap();
    ensemble.rank_correlation_by_chance = Some(0.9);
    check_holds(
        &render(&case),
        &["No parameter goes with the peak beyond what chance"],
    );
    let ensemble = case.document.ensemble.as_mut().unwrap();
    ensemble.drivers.clear();
    case.document.what_if.clear();
    case.evidence.quantile_band = None;
    let page = render(&case);
    check_holds(&page, &["No parameter drives the peak"]);
    assert!(!page.contains("id=\"drivers\"") && !page.contains("id=\"spread\""));
}

/// Where levers could not be followed, or rounding has lost the runs of a stop, the confidence is stated with their
/// number and how they count.
#[test]
fn verif_lost_levers_stand_beside_the_confidence() {
    let mut case = fixture::failing();
    case.document.ensembles[0].failed_to_run = 3;
    for run in case.document.models.values_mut() {
        run.numerical_error_rad = 0.02 * f64::from(u8::from(run.model == StopModel::Rigid));
    }
    let shown = text::render(&case.document, None, Look::default());
    let share = "more than 82 % of levers and readings, at 98.75 % confidence; 3 could not be followed and count as shut)";
    check_holds(&shown, &[share]);
    let page = render(&case);
    check_holds(
        &page,
        &[
            "Rigid stop: 3 could not be followed and count as shut.",
            "Soft stop: 1 could not be followed and counts as shut.",
            "Impacts carry rounding to 1.1° on the rigid stop. Its 2048 varied levers count as computed",
        ],
    );
    assert_eq!(page.matches("Impacts carry rounding").count(), 1);
}

/// The share shown first is that on which the answer hangs, whichever stop leads in the angle.
#[test]
fn verif_the_share_of_the_decisive_stop_leads() {
    let mut case = fixture::failing();
    let document = &mut case.document;
    document.verdict = Answer::Pass;
    document.opens = None;
    for answer in &mut document.answers {
        answer.answer = Answer::Pass;
    }
    for (ensemble, (exceeded, upper)) in
        document.ensembles.iter_mut().zip([(2, 0.004), (40, 0.031)])
    {
        ensemble.exceeded = exceeded;
        (ensemble.p_lower, ensemble.p_upper) = (0.0, upper);
        ensemble.p_upper_with_coast = upper;
    }
    document.ensemble = document.ensembles.first().cloned();
    let shown = text::render(document, None, Look::default());
    let first = "varied       40 of 2 048 varied levers open (soft stop, fewer than 3.1 % of";
    check_holds(&shown, &[first, "); rigid stop: 2 of 2 048"]);
    let page = render(&case);
    let tile = page
        .split("<dt>Varied levers that open</dt>")
        .nth(1)
        .unwrap();
    let tile = tile.split("</div>").next().unwrap();
    check_holds(
        tile,
        &[
            "40 of 2\u{202f}048",
            "soft stop: fewer than 3.1",
            "rigid stop: 2 of 2\u{202f}048",
        ],
    );
}

/// A preload down to which a pass holds stands with its distance in standard deviations, where these are stated.
#[test]
fn verif_the_preload_margin_is_told_in_standard_deviations() {
    let mut case = fixture::passing();
    let document = &mut case.document;
    let mut advice = Advice {
        safe_from: Some(0.083),
        until: 0.3,
        does_not: Some(0.082),
        tried: 40,
        reason: None,
        text: "Passes down to a preload of 0.083 N·m".into(),
    };
    document.preload_answer = Some(advice.clone());
    let told = "standard deviations of the stated scatter below the present value.";
    document.design.tolerance.clear();
    let unstated = text::render(document, None, Look::default());
    assert!(!unstated.contains("standard deviations of"), "{unstated}");
    for (scatter, expected) in [
        ("5 %", Some("that is 3.4 ")),
        ("0.004", Some("that is 4.2 ")),
        ("0", None),
    ] {
        let assignment = format!("tolerance.preload_torque_nm={scatter}");
        apply_override(&mut document.design, &assignment).unwrap();
        let shown = text::render(document, None, Look::default());
        let expected = expected.map(|start| format!("{start}{told}"));
        let is_told = expected
            .as_ref()
            .is_some_and(|text| shown.contains(&**text));
        assert_eq!(is_told, expected.is_some(), "{scatter}: {shown}");
        assert_eq!(
            shown.contains(told),
            expected.is_some(),
            "{scatter}: {shown}"
        );
    }
    // A value that passes with all above and is the least tried has none to spare.
    apply_override(&mut document.design, "tolerance.preload_torque_nm=5 %").unwrap();
    advice.safe_from = Some(0.1);
    document.preload_answer = Some(advice);
    let page = render(&case);
    check_holds(
        &page,
        &["; the present value is the lowest of them: no margin."],
    );
}

/// The largest angle has its error as a bar, which ends at the angle plus its error where the panel reaches that far.
#[test]
fn verif_the_largest_angle_has_its_error_as_a_bar() {
    let mut case = fixture::passing();
    let document = &mut case.document;
    let error_rad = 0.01;
    for answer in &mut document.answers {
        answer.uncertainty_rad = Some(error_rad);
    }
    let limit_rad = document.threshold_rad;
    let figures = plot::figures(&case.document, Some(&case.evidence));
    for name in ["event", "angle"] {
        let figure = figures.iter().find(|figure| figure.name == name).unwrap();
        let heights = |class: &str| -> Vec<[f64; 2]> {
            let lines = figure.body.split("<line ").skip(1);
            let lines = lines.filter(|line| line.contains(&format!("class=\"{class}\"")));
            let number = |line: &str, key: &str| {
                let value = line.split(&format!(" {key}=\"")).nth(1).unwrap();
                value.split('"').next().unwrap().parse::<f64>().unwrap()
            };
            lines
                .map(|line| [number(line, "y1"), number(line, "y2")])
                .collect()
        };
        let (bars, zeros, limits) = (heights("mark error-bar"), heights("zero"), heights("limit"));
        let bar = bars
            .iter()
            .find(|[y1, y2]| (y1 - y2).abs() > 15.0 || name == "angle");
        let [low, high] = *bar.unwrap_or_else(|| panic!("{name}: {bars:?}"));
        // One radian, by the lines of zero and of the limit angle in the last panel.
        let radian = (zeros.last().unwrap()[0] - limits.last().unwrap()[0]) / limit_rad;
        let length = (low - high) / radian;
        assert!(
            (length - 2.0 * error_rad).abs() < 2e-4 || name == "angle",
            "{name}: {length}"
        );
    }
    // Of a fail whose angle is not known a bar would say nothing.
    let mut case = fixture::failing();
    for answer in &mut case.document.answers {
        answer.uncertainty_rad = Some(9.0);
    }
    let figures = plot::figures(&case.document, Some(&case.evidence));
    let event = figures
        .iter()
        .find(|figure| figure.name == "event")
        .unwrap();
    assert!(!event.body.contains("mark error-bar"));
}

/// Page two: the answers of the rule in a table, the hash of the design, the velocity change with its scatter.
#[test]
fn verif_the_sheet_holds_rule_design_and_velocity() {
    let mut case = fixture::failing();
    let criterion = case.document.design.criterion;
    case.document.decision_rule = latchgate_verdict::decision_rule(&criterion).into();
    let hash = "ab".repeat(32);
    check_holds(
        &render(&case),
        &[
            "<th>pass</th><td>if the upper bound of p, those",
            "<th>fail</th><td>if the lower bound of p is at least 95 %",
            "<th>undecided</th><td>if neither holds at the last look",
            &format!("SHA-256 of the design file</th><td><code>{hash}"),
            "<th>Velocity change</th><td>4.1\u{a0}m/s ± 0.15\u{a0}m/s (one standard deviation)",
        ],
    );
    case.document.decision_rule = latchgate_verdict::NOMINAL_DECISION_RULE.as_str().into();
    case.document.run.set_design_file(None);
    let hash = latchgate_document::identity::design_sha256(&case.document.design);
    check_holds(
        &render(&case),
        &[
            "<th>undecided</th><td>otherwise</td>",
            &format!("SHA-256 of the design, as judged</th><td><code>{hash}"),
        ],
    );
}

/// The first line of an undecided verdict names what decides, and nothing that does not.
#[test]
fn verif_an_undecided_verdict_names_the_remedy_that_decides() {
    let mut case = fixture::failing();
    let document = &mut case.document;
    document.verdict = Answer::Undecided;
    for answer in &mut document.answers {
        answer.answer = Answer::Undecided;
    }
    let headline = |document: &Document| {
        let text = text::render(document, None, Look::default());
        text.lines().next().unwrap().to_string()
    };
    document.why[0].code = "members-cross".into();
    let none = headline(document);
    assert!(none.contains("No single tolerance decides"), "{none}");
    let know_bias = |ensemble: &mut Ensemble| {
        ensemble.drivers[0].answer_if_known = Answer::Fail;
    };
    // One stop alone is not enough.
    assert!(document.ensembles.len() > 1);
    document.ensembles[..1].iter_mut().for_each(know_bias);
    assert_eq!(headline(document), none);
    document.ensembles.iter_mut().for_each(know_bias);
    let bias = headline(document);
    assert!(bias.contains("zero is known to ±0.1"), "{bias}");

    document.why[0].code = "uncertainty-spans-threshold".into();
    let distance = |document: &Document, index: usize| {
        let answer = &document.answers[index];
        let run = &document.models[&answer.model];
        (run.peak_angle_rad - document.threshold_rad).abs()
    };
    for index in 0..document.answers.len() {
        let distance_rad = distance(document, index);
        let answer = &mut document.answers[index];
        answer.interpolation_error_rad = Some(2.0 * distance_rad);
        answer.noise_rad = Some(0.1 * distance_rad);
        answer.uncertainty_rad = Some(2.3 * distance_rad);
    }
    let rate = headline(document);
    assert!(rate.contains("a higher sample rate would decide"), "{rate}");
    // The noise of the other stop reaches the limit by itself: no rate decides.
    let last = document.answers.len() - 1;
    let distance_rad = distance(document, last);
    let answer = &mut document.answers[last];
    answer.noise_rad = Some(0.9 * distance_rad);
    answer.uncertainty_rad = Some(3.9 * distance_rad);
    let neither = headline(document);
    assert!(
        neither.contains("The largest angle is not known"),
        "{neither}"
    );
    // Each by itself: what lies between the samples on one stop, the noise on the other.
    let answer = &mut document.answers[last];
    answer.interpolation_error_rad = Some(0.2 * distance_rad);
    answer.uncertainty_rad = Some(2.1 * distance_rad);
    let both = headline(document);
    assert!(
        both.contains("What lies between the samples is not known, and the noise hides the answer"),
        "{both}"
    );
}

#[test]
fn verif_a_coast_above_the_peak_is_said() {
    let mut case = fixture::passing();
    let run = case.document.nominal.as_mut().unwrap();
    run.coast_peak_angle_rad = Some(run.peak_angle_rad * 1.5);
    check_holds(
        &render(&case),
        &["After the record ends the lever could still reach"],
    );
}

#[test]
fn verif_text_begins_with_the_verdict() {
    for (name, case) in fixture::all() {
        let shown = text::render(&case.document, Some(&PathBuf::from("out")), Look::default());
        let word = case.document.verdict.name().to_uppercase();
        let first = shown.lines().next().unwrap();
        assert_eq!(first.split_whitespace().nth(1), Some(&*word), "{name}");
        assert!(shown.lines().count() <= 15, "{name}: {shown}");
        assert!(shown.contains("report.html"), "{name}");
        assert!(shown.ends_with('\n'), "{name}");
    }
}

#[test]
fn verif_json_keeps_every_digit_and_the_order() {
    for (name, case) in fixture::all() {
        let shown = json::render(&case.document);
        assert!(shown.ends_with("}\n"), "{name}");
        let read: serde_json::Value = serde_json::from_str(&shown).unwrap();
        let plain = serde_json::to_string(&case.document).unwrap();
        let plain: serde_json::Value = serde_json::from_str(&plain).unwrap();
        assert_eq!(read, plain, "{name}: layout changed the content");
        if let Some(run) = &case.document.nominal {
            // Read by the standard library, which rounds correctly.
            let digits = shown.split("\"peak_angle_rad\": ").nth(1).unwrap();
            let peak: f64 = digits.split(',').next().unwrap().parse().unwrap();
            assert_eq!(peak.to_bits(), run.peak_angle_rad.to_bits(), "{name}");
        }
        let keys: Vec<&str> = shown
            .lines()
            .filter_map(|line| line.strip_prefix("  \""))
            .filter_map(|line| line.split('"').next())
            .collect();
        assert_eq!(keys.first(), Some(&"schema"), "{name}");
        assert_eq!(keys.last(), Some(&"run"), "{name}: {keys:?}");
    }
}

#[test]
fn verif_text_from_files_stays_text() {
    let hostile = "<script>alert(1)</script>\"'&\u{1b}[31m\u{202e}]]>";
    let mut case = fixture::undecided();
    let document = &mut case.document;
    document.recording.file = hostile.into();
    document.recording.channel = Some(hostile.into());
    document.recording.sha256 = Some(hostile.into());
    document.recording.content_sha256 = Some(hostile.into());
    document.recording.card_sha256 = Some(hostile.into());
    document.recording.format = Some(hostile.into());
    document.recording.unit_source = Some(hostile.into());
    document.test.vehicle = Some(hostile.into());
    document.decision_rule = hostile.into();
    document.run.version = hostile.into();
    document.design.name = hostile.into();
    document.request.channel = Some(hostile.into());
    document.why[0].text = hostile.into();
    document.why[0].code = hostile.into();
    document.findings[0].text = hostile.into();
    document.findings[0].code = hostile.into();
    let page = render(&case);
    check_balanced("hostile", page.strip_prefix("<!DOCTYPE html>\n").unwrap());
    assert!(
        !page.contains("<script>alert"),
        "markup from a file became markup"
    );
    assert!(
        page.contains("&lt;script&gt;"),
        "markup from a file is shown as text"
    );
    for c in ['\u{1b}', '\u{202e}'] {
        assert!(!page.contains(c), "{c:?} reached the page");
        assert!(
            !text::render(&case.document, None, Look::default()).contains(c),
            "{c:?} reached the terminal"
        );
    }
    for figure in plot::figures(&case.document, Some(&case.evidence)) {
        check_balanced(figure.name, &figure.stand_alone());
        assert!(!figure.stand_alone().contains("<script"));
    }
    case.document.why[0].text = "one\nPASS\rtwo".into();
    let lines = text::render(&case.document, None, Look::default());
    assert!(
        lines.lines().all(|line| line != "PASS"),
        "a reason forged a line:\n{lines}"
    );
}

#[test]
fn verif_write_leaves_no_older_file_behind() {
    let folder = temporary_folder("older");
    let failing = fixture::failing();
    let first = latchgate_report::write(
        &folder,
        latchgate_report::files(&failing.document, Some(&failing.evidence)),
        None,
    )
    .unwrap();
    // A sled pulse is drawn where it was asked for, a catch where the design has one.
    assert_eq!(first.len(), 3 + plot::NAMES.len() - 2);
    assert!(first.iter().all(|path| path.exists()));
    let unread = fixture::unread();
    let second = latchgate_report::write(
        &folder,
        latchgate_report::files(&unread.document, None),
        None,
    )
    .unwrap();
    let mut left: Vec<_> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    left.sort();
    let mut expected = second;
    expected.sort();
    assert_eq!(left, expected, "plots of the earlier run are gone");
}

#[test]
fn verif_write_says_which_path_failed() {
    let folder = temporary_folder("blocked");
    std::fs::create_dir_all(folder.parent().unwrap()).unwrap();
    std::fs::write(&folder, "a file where the folder should be").unwrap();
    let case = fixture::unread();
    let error =
        latchgate_report::write(&folder, latchgate_report::files(&case.document, None), None)
            .unwrap_err();
    std::fs::remove_file(&folder).unwrap();
    assert!(error.to_string().contains("blocked"), "{error}");
    assert!(error.to_string().contains("report folder"), "{error}");
}

#[test]
fn verif_broken_numbers_draw_without_a_trace_of_them() {
    let mut case = fixture::failing();
    case.evidence.used.samples[100] = f64::NAN;
    case.evidence.raw.samples[200] = f64::INFINITY;
    case.evidence.traces[0].points[50].angle_rad = f64::NAN;
    case.evidence.traces[0].points[60].velocity_rad_s = f64::NEG_INFINITY;
    case.evidence.spectrum_raw.amplitude_m_s2[3] = f64::NAN;
    case.evidence.spectrogram.amplitude_m_s2[3][2] = f64::NAN;
    case.document.screens.impulse_m_s = Some(f64::NAN);
    let page = render(&case);
    check_balanced("broken", page.strip_prefix("<!DOCTYPE html>\n").unwrap());
    check_offline("broken", &page);
    assert!(!json::render(&case.document).contains("NaN"));
}

#[test]
fn verif_empty_evidence_draws_nothing_and_says_so() {
    let mut case = fixture::unread();
    case.evidence.raw.samples.clear();
    case.evidence.used.samples.clear();
    case.evidence.series.time_s.clear();
    case.evidence.spectrogram.time_s.clear();
    case.evidence.spectrogram.amplitude_m_s2.clear();
    case.evidence.spectrum_raw.frequency_hz.clear();
    case.evidence.spectrum_used.frequency_hz.clear();
    assert!(plot::figures(&case.document, Some(&case.evidence)).is_empty());
    check_holds(&render(&case), &["nothing that could be drawn"]);
}

#[test]
fn verif_extreme_signals_still_draw() {
    for scale in [0.0, 1e-300, 1e300] {
        let mut case = fixture::failing();
        for signal in [&mut case.evidence.raw, &mut case.evidence.used] {
            signal
                .samples
                .iter_mut()
                .for_each(|sample| *sample *= scale);
        }
        for point in case
            .evidence
            .traces
            .iter_mut()
            .flat_map(|trace| &mut trace.points)
        {
            point.angle_rad *= scale;
            point.velocity_rad_s *= scale;
        }
        for figure in plot::figures(&case.document, Some(&case.evidence)) {
            check_balanced(figure.name, &figure.inline());
            check_offline(figure.name, &figure.inline());
        }
    }
}

#[test]
fn verif_long_signals_stay_small() {
    let mut case = fixture::failing();
    let pattern = case.evidence.used.samples.clone();
    case.evidence.used.samples = pattern.iter().cycle().take(400_000).copied().collect();
    let figures = plot::figures(&case.document, Some(&case.evidence));
    let bytes = figures[0].inline().len();
    assert!(bytes < 120_000, "{bytes} bytes for the acceleration");
}

/// A generator good enough to scatter test points; the seed is printed on failure.
struct Scatter(u64);

impl Scatter {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[track_caller]
fn check_columns(seed: u64, count: usize, width: f64) {
    let mut scatter = Scatter(seed);
    let mut x = -5.0;
    let points: Vec<Point> = (0..count)
        .map(|_| {
            x += scatter.next() * width * 0.3;
            Point::new(x, scatter.next() - 0.5)
        })
        .collect();
    let kept = plot::thin::columns(points.iter().copied(), width);
    let columns: std::collections::BTreeSet<i64> = points
        .iter()
        .map(|point| (point.x / width).floor() as i64)
        .collect();
    assert!(
        kept.len() <= 4 * columns.len(),
        "seed {seed}: {} points for {} columns",
        kept.len(),
        columns.len()
    );
    for column in columns {
        let of = |points: &[Point]| -> Vec<f64> {
            points
                .iter()
                .filter(|point| (point.x / width).floor() as i64 == column)
                .map(|point| point.y)
                .collect()
        };
        let (all, left) = (of(&points), of(&kept));
        let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(most(&all), most(&left), "seed {seed}, column {column}");
        assert_eq!(least(&all), least(&left), "seed {seed}, column {column}");
        assert_eq!(
            (all.first(), all.last()),
            (left.first(), left.last()),
            "seed {seed}, column {column}"
        );
    }
    assert!(
        kept.windows(2).all(|pair| pair[0].x <= pair[1].x),
        "seed {seed}: order"
    );
}

#[test]
fn prop_thinned_columns_keep_every_extremum() {
    for seed in 0..60 {
        check_columns(
            seed,
            1 + (seed as usize * 37) % 900,
            0.5 + seed as f64 * 0.1,
        );
    }
}

#[test]
fn prop_thinned_curves_keep_their_extent_and_their_bound() {
    for seed in 0..40 {
        let mut scatter = Scatter(seed);
        let points: Vec<Point> = (0..5000)
            .map(|_| Point::new(scatter.next() * 700.0, scatter.next() * 300.0))
            .collect();
        let kept = plot::thin::curve(&points, 0.5, 1000);
        assert!(kept.len() <= 1000, "seed {seed}: {}", kept.len());
        let extent = |points: &[Point]| {
            points
                .iter()
                .fold((f64::MAX, f64::MIN, f64::MAX, f64::MIN), |e, p| {
                    (e.0.min(p.x), e.1.max(p.x), e.2.min(p.y), e.3.max(p.y))
                })
        };
        assert_eq!(extent(&points), extent(&kept), "seed {seed}");
        assert_eq!(
            (points.first(), points.last()),
            (kept.first(), kept.last()),
            "seed {seed}"
        );
    }
}

#[test]
fn verif_numbers_for_people() {
    for (value, digits, expected) in [
        (0.1, 5, "0.10000"),
        (-1.0455, 5, "\u{2212}1.0455"),
        (9.999_996, 5, "10.000"),
        (3.1e-13, 3, "3.10\u{a0}×\u{a0}10⁻¹³"),
        (123_456.7, 5, "123457"),
        (0.0, 5, "0"),
        (f64::NAN, 5, "\u{2013}"),
        (f64::INFINITY, 5, "\u{2013}"),
    ] {
        assert_eq!(number::significant(value, digits), expected, "{value}");
    }
    for (value, expected) in [
        (0.1, "0.1"),
        (8.888e-4, "8.888\u{a0}×\u{a0}10⁻⁴"),
        (1e7, "1\u{a0}×\u{a0}10⁷"),
        (9.806_65, "9.80665"),
        (-0.0, "0"),
    ] {
        assert_eq!(number::exact(value), expected);
    }
    assert_eq!(number::trimmed(2_083.333_333, 5), "2083.3");
    assert_eq!(number::trimmed(-20.0, 6), "\u{2212}20");
    assert_eq!(number::trimmed(1000.0, 3), "1000");
    assert_eq!(number::count(1_234_567), "1\u{202f}234\u{202f}567");
    assert_eq!(number::plain(-3.1e-7, 3), "-3.10e-7");
}

#[test]
fn verif_sparkline_shows_a_spike_of_one_sample() {
    let mut values = vec![0.0; 10_000];
    values[7_777] = -50.0;
    let line = sparkline::render(&values, 40);
    assert_eq!(line.chars().count(), 40);
    assert_eq!(
        line.chars().position(|c| c == '▁'),
        Some(7_777 * 40 / 10_000)
    );
    assert_eq!(line.chars().filter(|c| *c == '█').count(), 39);
    assert_eq!(sparkline::render(&[], 40), "");
    assert_eq!(sparkline::render(&[1.0, 1.0], 40), "▁▁");
    assert_eq!(sparkline::render(&[f64::NAN; 3], 2), "  ");
    assert_eq!(sparkline::render(&[0.0, 1.0, 2.0, 3.0], 4), "▁▃▆█");
    assert_eq!(sparkline::render(&[-f64::MAX, f64::MAX], 2), "▁█");
}

/// The page's download and the folder's CSV are the same bytes.
#[test]
fn verif_the_page_holds_the_series_of_its_folder() {
    let case = fixture::failing();
    let page = html::render(&case.document, Some(&case.evidence));
    let start = page.find("id=\"series\">").unwrap() + 12;
    let end = start + page[start..].find("</script>").unwrap();
    let table = series::csv(&case.evidence.series);
    assert!(page[start..end] == table, "another series");
    assert_eq!(table.lines().count(), case.evidence.series.time_s.len() + 1);
    assert!(table.starts_with(
        "time_s,acceleration_recorded_m_s2,acceleration_used_m_s2,velocity_m_s,angle_"
    ));
}
