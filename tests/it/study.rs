//! The studies: what they compute, and what the command writes.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_study::cases::BETWEEN_SAMPLES;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::stability::{self, Grade, Stability, situations};
use latchgate_study::work_precision::{self, Options, Status, WorkPrecision};
use std::cell::Cell;
use std::path::PathBuf;
use std::process::Output;

fn small() -> Options {
    Options {
        design: Design::reference(),
        models: vec![StopModel::Rigid, StopModel::Soft],
        gravity_m_s2: 9.81,
        angular_frequency_rad_s: 100.0,
        amplitude_g: 5.0,
        periods: 3,
        points: 3,
        repetitions: 1,
    }
}

/// Runs with a clock that ticks once a look, so that times are the same in every run.
fn compare(options: &Options) -> WorkPrecision {
    let ticks = Cell::new(0.0);
    let clock = || {
        ticks.set(ticks.get() + 1.0);
        ticks.get()
    };
    work_precision::run(options, &clock).unwrap()
}

fn stable() -> Stability {
    stability::run(&stability::Options {
        design: Design::reference(),
        gravity_m_s2: 9.81,
        points: 24,
    })
    .unwrap()
}

#[test]
fn verif_no_row_claims_less_error_than_the_truth_has() {
    let result = compare(&small());
    assert_eq!(result.truths.len(), 8);
    for row in &result.rows {
        let truth = result
            .truths
            .iter()
            .find(|truth| truth.case == row.case && truth.model == row.model)
            .unwrap();
        assert!(truth.peak_angle_bound_rad > 0.0 && truth.final_angle_bound_rad > 0.0);
        let place = format!("{} {} {}", row.case, row.model.name(), row.method);
        if let Some(error) = row.peak_angle_error_rad {
            assert!(error >= truth.peak_angle_bound_rad, "{place}: {error:e}");
        } else {
            assert_eq!(row.status, Status::Unstable, "{place}");
        }
        assert!(row.steps > 0 && row.rhs >= row.steps, "{place}");
        if row.method == "event-driven" && row.tolerance_rad.is_none() {
            assert_eq!(row.status, Status::Ok, "{place}");
        }
    }
}

#[test]
fn verif_every_method_gets_better_with_its_setting() {
    let result = compare(&small());
    // Between samples no setting helps.
    let solved = result
        .truths
        .iter()
        .filter(|truth| truth.case != BETWEEN_SAMPLES);
    for truth in solved {
        for method in ["rk4-located", "dopri5-samples", "dopri5"] {
            let errors: Vec<f64> = result
                .rows
                .iter()
                .filter(|row| row.case == truth.case && row.model == truth.model)
                .filter(|row| row.method == method)
                .filter_map(|row| row.final_angle_error_rad)
                .collect();
            let (first, last) = (errors[0], errors[errors.len() - 1]);
            assert!(
                last <= first.max(1e-10) && last < 1e-5,
                "{} {} {method}: {errors:?}",
                truth.case,
                truth.model.name()
            );
        }
    }
}

/// What lies between the samples of a smooth formula: straight lines lose percents of the peak by any
/// method and setting, refined ones the square of their interval, polynomials within the band next to nothing.
#[test]
fn val_what_lies_between_samples_is_lost_by_straight_lines_and_kept_by_the_band() {
    let result = compare(&small());
    for model in [StopModel::Rigid, StopModel::Soft] {
        let rows = || {
            let rows = result.rows.iter();
            rows.filter(|row| row.case == BETWEEN_SAMPLES && row.model == model)
        };
        let error = |between: &str| {
            let mut kernel = rows().filter(|row| row.method == "event-driven");
            let row = kernel.find(|row| row.between == Some(between)).unwrap();
            row.peak_angle_error_rad.unwrap()
        };
        let lines = [error("linear"), error("linear-4"), error("linear-16")];
        assert!(lines[0] > 1e-3, "{model:?}: {lines:?}");
        for pair in lines.windows(2) {
            let order = libm::log(pair[0] / pair[1]) / libm::log(4.0);
            assert!((1.7..2.3).contains(&order), "{model:?}: {lines:?}");
        }
        let band = error("band-limited");
        assert!(band < 1e-6, "{model:?}: {band:e}");
        let others = rows().filter(|row| row.method != "event-driven");
        for row in others {
            assert_eq!(row.between, Some("linear"));
            if let Some(error) = row.peak_angle_error_rad {
                assert!(error > 0.05 * lines[0], "{row:?}");
            }
        }
    }
}

/// The orders that are printed: events on the grid leave the first, located ones keep the fourth, a graze
/// grows to its square root.
#[test]
fn val_fitted_orders_of_convergence() {
    let options = Options {
        periods: 100,
        points: 2,
        ..small()
    };
    let compared = compare(&options);
    let grazed = stable();
    let order = |headlines: &[latchgate_study::Headline], model: StopModel, begins: &str| {
        let mut of = headlines.iter();
        let of = of.find(|of| of.model == Some(model) && of.what.starts_with(begins));
        of.unwrap().value.unwrap()
    };
    for (found, expected) in [
        (
            order(&compared.headlines, StopModel::Rigid, "rk4: order"),
            1.0,
        ),
        (
            order(&compared.headlines, StopModel::Rigid, "rk4-located: order"),
            4.0,
        ),
        (
            order(&compared.headlines, StopModel::Soft, "rk4-located: order"),
            4.0,
        ),
        (
            order(&grazed.headlines, StopModel::Rigid, "order of that growth"),
            0.5,
        ),
    ] {
        assert!(
            (found - expected).abs() < 0.1 * expected,
            "{found}, expected {expected}"
        );
    }
}

/// The kernel's own time is the unit: its row is 1 exactly, and no timing of it was shorter.
#[test]
fn verif_times_are_against_the_kernels_own_row() {
    // A clock whose every look takes a little less long than the one before.
    let looks = Cell::new(0.0);
    let clock = || {
        looks.set(looks.get() + 1.0);
        1e3 * looks.get() - 1e-3 * looks.get() * looks.get()
    };
    let options = Options {
        repetitions: 2,
        ..small()
    };
    let result = work_precision::run(&options, &clock).unwrap();
    for truth in &result.truths {
        let own: Vec<&work_precision::Row> = result
            .rows
            .iter()
            .filter(|row| row.case == truth.case && row.model == truth.model)
            .collect();
        // Of several readings the last is that of a verdict.
        let kernel = own
            .iter()
            .rfind(|row| row.method == "event-driven" && row.tolerance_rad.is_none())
            .unwrap();
        assert_eq!(
            (kernel.time_ratio, kernel.time_s),
            (1.0, truth.kernel_time_s)
        );
        for row in own {
            assert_eq!(row.time_ratio, row.time_s / truth.kernel_time_s, "{row:?}");
        }
    }
}

/// A lever without a spring has no natural period, and so no steps in one: those rows are left
/// out. A weak excitation brings no lever to the touch: no graze is looked at.
#[test]
fn verif_what_a_lever_cannot_show_is_left_out() {
    let mut springless = small();
    springless.design.lever.spring_stiffness_nm_per_rad = 0.0;
    springless.points = 2;
    let result = compare(&springless);
    assert!(result.rows.iter().all(|row| row.steps_per_period.is_none()));
    assert!(result.rows.iter().any(|row| row.method == "dopri5"));
    let weak = stability::run(&stability::Options {
        design: Design::reference(),
        gravity_m_s2: 1e-3,
        points: 2,
    })
    .unwrap();
    assert!(weak.rows.iter().all(|row| row.subject != "graze"));
    assert!(weak.rows.iter().any(|row| row.subject == "contact"));
}

/// The paper's way at a tenth of its steps on the soft stop does not pass for an answer.
#[test]
fn val_failures_are_marked_and_not_dropped() {
    let result = compare(&small());
    let coarse: Vec<&work_precision::Row> = result
        .rows
        .iter()
        .filter(|row| row.method == "rk4" && row.steps_per_period == Some(1000))
        .collect();
    assert_eq!(coarse.len(), 8);
    assert!(
        coarse.iter().all(|row| row.status != Status::Ok),
        "{coarse:?}"
    );
    assert!(
        result
            .rows
            .iter()
            .all(|row| row.method != "moreau-jean" || row.model == StopModel::Rigid)
    );
}

#[test]
fn verif_a_study_is_the_same_in_every_run() {
    // Thousands of rows: which one differs is better looked up in the CSV than printed here.
    assert!(compare(&small()) == compare(&small()), "work-precision");
    assert!(stable() == stable(), "stability");
}

fn grades(result: &Stability, subject: &str, method: &str) -> Vec<Grade> {
    let grades: Vec<Grade> = result
        .rows
        .iter()
        .filter(|row| row.subject == subject && row.method == method)
        .map(|row| row.grade)
        .collect();
    assert!(!grades.is_empty(), "{subject}: no rows of {method}");
    grades
}

/// Each situation has one right answer, and methods that share no code but the lever's equation
/// agree on it: the event-driven kernel and the adaptive pair restarted at samples.
#[test]
fn verif_every_situation_has_its_right_answer() {
    let result = stable();
    for subject in situations::SUBJECTS {
        for grade in grades(&result, subject, "dopri5-samples") {
            assert_eq!(grade, Grade::Right, "{subject}");
        }
        for grade in grades(&result, subject, "rk4-located") {
            assert!(grade <= Grade::Close, "{subject}: {grade:?}");
        }
    }
    // Where events lie on the grid, at least these go wrong.
    for subject in [
        "spike-of-one-sample",
        "several-impacts-in-a-step",
        "jumps-between-samples",
        "torque-changes-sign-inside-samples",
    ] {
        let worst = grades(&result, subject, "rk4").into_iter().max();
        assert!(worst >= Some(Grade::Poor), "{subject}: {worst:?}");
    }
}

#[test]
fn val_the_map_of_step_against_stiffness_shows_the_limit() {
    let result = stable();
    assert!((result.contact_limit - 2.931).abs() < 1e-3);
    assert!((result.right_ratio - 0.7998).abs() < 1e-4);
    for row in result.rows.iter().filter(|row| row.subject == "contact") {
        let reach = row.step_s.unwrap() * result.contact_frequency_rad_s;
        if row.method != "rk4" {
            continue;
        }
        let gains = row.value.is_none_or(|ratio| !(0.0..=1.0).contains(&ratio));
        if reach < 1.0 {
            assert!(!gains, "gains energy at {reach}: {row:?}");
        }
        if reach < 0.05 {
            assert!(row.grade <= Grade::Poor, "{row:?}");
        }
    }
    // Beyond the limit most phases of entry gain energy or never come out.
    let beyond: Vec<bool> = result
        .rows
        .iter()
        .filter(|row| row.subject == "contact" && row.method == "rk4")
        .filter(|row| row.step_s.unwrap() * result.contact_frequency_rad_s > 3.2)
        .map(|row| row.value.is_none_or(|ratio| !(0.0..=1.0).contains(&ratio)))
        .collect();
    let share = beyond.iter().filter(|gains| **gains).count() * 100 / beyond.len();
    assert!(share > 75, "{share} % of {}", beyond.len());
}

#[test]
fn verif_chatter_and_graze_are_graded() {
    let result = stable();
    assert!(
        grades(&result, "chatter", "rk4")
            .iter()
            .all(|grade| *grade == Grade::Failed)
    );
    assert!(
        grades(&result, "chatter", "rk4-located")
            .iter()
            .all(|grade| *grade == Grade::Right)
    );
    assert!(
        grades(&result, "graze", "dopri5-samples")
            .iter()
            .all(|grade| *grade == Grade::Right)
    );
    assert!(
        grades(&result, "graze", "rk4")
            .iter()
            .any(|grade| *grade >= Grade::Close)
    );
}

#[track_caller]
fn check_headline(result: &Stability, subject: &str, stop: StopModel, least: f64, most: f64) {
    let headline = result
        .headlines
        .iter()
        .find(|headline| headline.subject == subject && headline.model == Some(stop))
        .unwrap();
    let value = headline.value.unwrap();
    assert!(
        (least..=most).contains(&value),
        "{}: {value}, expected {least} to {most}",
        headline.what
    );
}

/// In quad precision 1e-12 rad/s too much moves the angle by 2.56e-8 rad on the rigid stop, and
/// the growth falls with the root of the change: 2.56e4 √(1e-12/1e-9) = 809 s for 1e-9 rad/s. The
/// soft stop passes through the touch; its steepest is the largest change's contact.
#[test]
fn val_a_graze_grows_on_the_rigid_stop_and_not_on_the_soft_one() {
    let result = stable();
    check_headline(&result, "graze", StopModel::Rigid, 800.0, 820.0);
    check_headline(&result, "graze", StopModel::Soft, 0.012, 0.1);
}

#[track_caller]
fn check_grade(value: Option<f64>, right: f64, bound: f64, want: Grade) {
    assert_eq!(
        Grade::of(value, right, bound),
        want,
        "{value:?} of {right} ± {bound}"
    );
}

#[test]
fn verif_grades_follow_their_shares() {
    check_grade(Some(1.0), 1.0, 0.0, Grade::Right);
    check_grade(Some(1.0 + 1e-5), 1.0, 0.0, Grade::Close);
    check_grade(Some(1.0 + 1e-5), 1.0, 1e-4, Grade::Right);
    check_grade(Some(1.05), 1.0, 0.0, Grade::Poor);
    check_grade(Some(-1.0), 1.0, 0.0, Grade::Wrong);
    check_grade(Some(f64::NAN), 1.0, 1.0, Grade::Failed);
    check_grade(None, 1.0, 1.0, Grade::Failed);
}

/// Charts are well-formed, hold no number that is none, and name every method.
#[test]
fn verif_charts_are_whole() {
    let compared = compare(&small());
    let stable = stable();
    for (svg, table, methods) in [
        (
            chart::work_precision(&compared),
            StudyTable::of(&compared.rows).unwrap(),
            [
                "event-driven",
                "Runge-Kutta 4 on a grid (rk4)",
                "Runge-Kutta 4, events located",
                "Dormand-Prince 5(4)",
                "Dormand-Prince, sample by sample",
                "Moreau-Jean time stepping",
            ]
            .as_slice(),
        ),
        (
            chart::stability(&stable),
            StudyTable::of(&stable.rows).unwrap(),
            [
                "Runge-Kutta 4 on a grid (rk4)",
                "Runge-Kutta 4, events located",
                "Dormand-Prince 5(4)",
                "Dormand-Prince, sample by sample",
                "Moreau-Jean time stepping",
            ]
            .as_slice(),
        ),
    ] {
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(svg.contains("prefers-color-scheme:dark"));
        assert!(!svg.contains("var(--"), "a rule kept its variable");
        for method in methods {
            assert!(svg.contains(&format!(">{method}<")), "{method}");
        }
        let text = String::from_utf8(table.csv).unwrap();
        assert!(text.lines().count() > 20);
        assert!(
            !text.contains("NaN") && !text.contains("inf"),
            "a number that is none"
        );
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("study-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

fn latchgate(arguments: &[&str]) -> Output {
    crate::support::program()
        .args(arguments)
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

#[track_caller]
fn check_exit(arguments: &[&str], code: i32, word: &str) -> Output {
    let output = latchgate(arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    assert!(
        said.contains(word),
        "{arguments:?}: expected `{word}` in: {said}"
    );
    output
}

/// The figures of a study make a sentence.
#[track_caller]
pub(crate) fn check_sentence(name: &str, printed: &serde_json::Value) {
    let headlines: Vec<latchgate_study::Headline> =
        serde_json::from_value(printed["headlines"].clone()).unwrap();
    let sentence = latchgate_study::sentence::sentence(name, &headlines).unwrap();
    assert!(
        sentence.ends_with('.') && sentence.contains(|letter: char| letter.is_ascii_digit()),
        "{sentence}"
    );
}

#[track_caller]
fn check_study(name: &str, more: &[&str]) -> serde_json::Value {
    let out = folder(name);
    let mut arguments = vec![
        "study",
        name,
        "--out",
        out.to_str().unwrap(),
        "--format",
        "json",
    ];
    arguments.extend(more);
    let output = check_exit(&arguments, 0, "");
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let stored = std::fs::read_to_string(out.join(format!("{name}.json"))).unwrap();
    assert_eq!(
        printed,
        serde_json::from_str::<serde_json::Value>(&stored).unwrap()
    );
    assert_eq!(printed["study"], name);
    assert!(printed["elapsed_s"].as_f64().unwrap() >= 0.0);
    assert!(printed["headlines"].as_array().unwrap().len() > 5);
    check_sentence(name, &printed);
    for end in ["csv", "svg"] {
        assert!(out.join(format!("{name}.{end}")).metadata().unwrap().len() > 1000);
    }
    printed
}

#[test]
fn cli_study_work_precision_writes_rows_figures_and_a_chart() {
    let printed = check_study(
        "work-precision",
        &[
            "--periods",
            "1",
            "--points",
            "2",
            "--repetitions",
            "1",
            "--model",
            "rigid",
            "--gravity",
            "9.81",
        ],
    );
    assert_eq!(printed["parameters"]["gravity_m_s2"], 9.81);
    assert_eq!(printed["parameters"]["model"], serde_json::json!(["rigid"]));
    assert_eq!(printed["cases"].as_array().unwrap().len(), 4);
}

#[test]
fn cli_study_stability_writes_rows_figures_and_a_chart() {
    check_study("stability", &["--points", "8"]);
}

#[test]
fn cli_study_says_where_its_files_went() {
    let out = folder("text");
    let output = check_exit(
        &[
            "study",
            "stability",
            "--points",
            "8",
            "--out",
            out.to_str().unwrap(),
        ],
        0,
        "",
    );
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("stability.csv")
            && text.contains("contact, soft stop")
            && text.contains(
                "\nRunge-Kutta 4 at the paper's step gives back 0.788 to 0.82 of the speed"
            ),
        "{text}"
    );
}

#[test]
fn cli_study_refuses_wrong_usage() {
    check_exit(&["study"], 2, "work-precision");
    check_exit(&["study", "stabilty"], 2, "stability");
    check_exit(&["study", "work-precision", "--omega", "0"], 2, "--omega");
    check_exit(&["study", "work-precision", "--points", "1"], 2, "--points");
    check_exit(&["study", "stability", "--omega", "1"], 2, "--omega");
    check_exit(
        &["study", "stability", "--set", "lever.mas_kg=1"],
        2,
        "lever.mass_kg",
    );
}

#[test]
fn cli_study_that_cannot_write_ends_with_four() {
    let file = folder("file");
    std::fs::write(&file, "in the way").unwrap();
    check_exit(
        &[
            "study",
            "stability",
            "--points",
            "8",
            "--out",
            file.to_str().unwrap(),
        ],
        4,
        "folder",
    );
}

#[track_caller]
fn check_method(arguments: &[&str], code: i32, words: &[&str]) {
    let signal = concat!(env!("CARGO_MANIFEST_DIR"), "/signals/surviving.csv");
    let mut all = vec![
        "replay",
        signal,
        "--no-report",
        "--format",
        "json",
        "--members",
        "0",
    ];
    all.extend(arguments);
    let output = latchgate(&all);
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    for word in words {
        assert!(
            said.contains(word),
            "{arguments:?}: expected `{word}` in {said}"
        );
    }
}

#[test]
fn cli_a_method_known_to_fail_says_so() {
    check_method(
        &[
            "--method",
            "rk4",
            "--steps-per-period",
            "1000",
            "--model",
            "soft",
        ],
        3,
        &["method-known-to-fail", "gains energy"],
    );
    check_method(
        &["--method", "rk4", "--model", "soft"],
        3,
        &[
            "method-without-bound",
            "method-known-to-fail",
            "entry and exit lie on the grid",
        ],
    );
    check_method(
        &[
            "--method",
            "dopri5",
            "--tolerance",
            "1e-3",
            "--model",
            "rigid",
        ],
        3,
        &["method-known-to-fail", "is loose", "loses its order"],
    );
    check_method(
        &["--method", "moreau-jean", "--model", "rigid"],
        3,
        &[
            "method-known-to-fail",
            "\"method\": \"moreau-jean\"",
            "comparison-method",
        ],
    );
    check_method(
        &[
            "--method",
            "rk4-located",
            "--steps-per-period",
            "500",
            "--model",
            "soft",
        ],
        3,
        &["method-known-to-fail", "where ten would be few"],
    );
}

#[test]
fn cli_a_method_on_a_stop_it_does_not_know_is_wrong_usage() {
    check_method(&["--method", "moreau-jean"], 2, &["--model rigid"]);
    check_method(
        &["--method", "moreau-jean", "--model", "soft"],
        2,
        &["--model rigid"],
    );
    check_method(
        &["--method", "dopri5", "--tolerance", "1e-16"],
        2,
        &["1e-14"],
    );
}
