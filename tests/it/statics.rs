//! Static thresholds by direction, linkages, and the check of a sled pulse.

#![allow(clippy::excessive_precision, reason = "values at 200 bits")]

use crate::support::{Folder, latchgate};
use serde_json::Value;

/// Runs `latchgate static` on a design.
fn thresholds(folder: &Folder, design: &str) -> Value {
    let file = folder.write("design.toml", design);
    let done = latchgate(&["static", &file, "--no-report", "--format", "json"]);
    assert_eq!(done.code, 0, "{}", done.err);
    done.document()
}

#[track_caller]
fn check(row: &Value, key: &str, wanted: f64) {
    let got = row[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} in {row}"));
    assert!((got / wanted - 1.0).abs() < 1e-13, "{key}: {got}, {wanted}");
}

fn row<'a>(document: &'a Value, direction: &str) -> &'a Value {
    let rows = document["rows"].as_array().unwrap();
    rows.iter()
        .find(|row| row["direction"] == direction)
        .unwrap()
}

/// What the calculation rests on and the design does not state is named; what an option states is not.
#[test]
fn cli_what_the_design_does_not_state_is_said() {
    let folder = Folder::new("static-borrowed");
    let file = folder.write("d.toml", "base = \"paper\"\n[lever]\nmass_kg = 0.15\n");
    let asked = ["static", &file, "--no-report"];
    let set = ["--set", "lever.preload_torque_nm=3"];
    for (more, names) in [
        (
            &[][..],
            "example: stiffness of the spring, preload torque, distance of its centre of mass.",
        ),
        (
            &set,
            "example: stiffness of the spring, distance of its centre of mass.",
        ),
    ] {
        let done = latchgate(&[&asked[..], more].concat());
        let text = done.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("Not stated in the design"), "{text}");
        assert!(text.contains(names), "{text}");
    }
    let whole = latchgate(&["static", "--no-report"]);
    assert!(!whole.out.contains("Not stated"), "{}", whole.out);
}

/// A replay of the sled pulse stands beside the thresholds; where the two say different things, the reason does.
#[test]
fn cli_a_sled_pulse_is_replayed_beside_the_thresholds() {
    let folder = Folder::new("static-sled");
    let slanted =
        "axis = [0, 0, 1]\ncenter_of_mass = [-0.04596194077712559, -0.04596194077712559, 0]\n";
    let design = |preload: f64, axis: &str, deviation: f64| {
        format!(
            "name = \"d\"\nbase = \"paper\"\n[lever]\npreload_torque_nm = {preload}\n{axis}\
             [tolerance]\npreload_torque_nm = {deviation}\nmass_kg = 0\n"
        )
    };
    let opens_later = "30 g at rest do not open it";
    for (preload, axis, deviation, standard, holds, verdict, reason) in [
        (4.0, "", 0.0, "r11", true, "pass", None),
        (2.95, "", 0.0, "r11", true, "fail", Some(opens_later)),
        (2.0, "", 0.0, "r11", false, "fail", None),
        // Held along the axes, and not along the direction that the pulse has.
        (2.2, slanted, 0.0, "206", true, "fail", None),
        // Three of its deviations less would not hold it; few springs are that weak.
        (
            4.2,
            "",
            0.48,
            "r11",
            false,
            "pass",
            Some("counts every spring by its least output"),
        ),
    ] {
        let file = folder.write("d.toml", design(preload, axis, deviation));
        let asked = ["static", &file, "--standard", standard, "--no-report"];
        let document = latchgate(&[&asked[..], &["--format", "json"]].concat()).document();
        assert_eq!(document["answers"][0]["holds"], holds, "{preload}");
        assert_eq!(document["sled"]["verdict"], verdict, "{preload}");
        let text = latchgate(&asked).out;
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("Replay of pulse:sled206-33g"), "{text}");
        for sentence in [opens_later, "counts every spring by its least output"] {
            assert_eq!(text.contains(sentence), reason == Some(sentence), "{text}");
        }
        assert!(!text.contains("A constant load opens it"), "{text}");
        if !axis.is_empty() {
            continue;
        }
        let replayed = latchgate(&[
            "replay",
            "pulse:sled206-33g,opens-when=positive",
            "--design",
            &file,
            "--no-report",
            "--no-advice",
            "--format",
            "json",
        ]);
        assert_eq!(replayed.document()["verdict"], verdict);
    }
}

/// A handle and a weight that balances it: the weight may be thrown off, and its spring with it.
#[test]
fn verif_elements_that_balance_hold_nothing_that_falls_when_they_part() {
    let folder = Folder::new("static-balance");
    let design = |vectors: bool, pinned: bool| {
        let (handle, weight) = match vectors {
            false => ("arm_m = 0.065", "arm_m = -0.1"),
            true => (
                "axis = [0, 0, 1]\ncenter_of_mass = [-0.065, 0, 0]",
                "axis = [0, 0, 1]\ncenter_of_mass = [0.1, 0.002, 0]",
            ),
        };
        format!(
            "name = \"balanced\"\n[tolerance]\npreload_torque_nm = 0\n\
             [[linkage]]\nname = \"handle\"\nmass_kg = 0.1475\n{handle}\nspring_torque_nm = 0.3\n\
             [[linkage]]\nname = \"weight\"\nmass_kg = 0.0945\n{weight}\nspring_torque_nm = 3.0\npinned = {pinned}\n"
        )
    };
    let alone_g = 0.3 / (0.1475 * 0.065 * 9.80665);
    for (vectors, apart_g) in [(false, alone_g - 1.0), (true, alone_g)] {
        let free = thresholds(&folder, &design(vectors, false));
        let any = &free["answers"][1];
        assert_eq!(any["holds"], Value::Null, "{any}");
        assert_eq!(any["not_shown"], "joined");
        let opens = any["opens_at_g"].as_f64().unwrap();
        assert!(opens > 30.0, "{opens}");
        // By vectors the worst direction is one of many that were tried.
        let row = if vectors {
            row(&free, "+Y")
        } else {
            row(&free, "space")
        };
        check(row, "apart_g", apart_g);
        assert!(any["apart_g"].as_f64().unwrap() <= apart_g * (1.0 + 1e-12));
        let joined = thresholds(&folder, &design(vectors, true));
        assert_eq!(joined["answers"][1]["holds"], true);
        // Pressed the other way the handle is what parts, and leaves the weight.
        let apart_g = joined["answers"][1]["apart_g"].as_f64();
        let wanted = vectors.then(|| 3.0 / (0.0945 * 0.1_f64.hypot(0.002) * 9.80665));
        let off = apart_g
            .zip(wanted)
            .map(|(found, wanted)| (found / wanted - 1.0).abs());
        assert_eq!(apart_g.is_some(), vectors);
        assert!(off.is_none_or(|off| off < 1e-3), "{apart_g:?} {wanted:?}");
        let file = folder.write("balanced.toml", design(vectors, false));
        let text = latchgate(&["static", &file, "--no-report"]).out;
        assert!(text.starts_with("STATIC  NOT SHOWN TO HOLD 30 g"), "{text}");
        assert!(text.contains("pinned = true"), "{text}");
        // Nor does a replay of the sled pulse pass beside it.
        let whole = |pinned: bool| {
            let stop = "[lever]\npivot_damping_nm_s_per_rad = 1e-4\n[stop]\nrestitution = 0.7\n\
                        stiffness_n_per_m = 1e7\ndamping_n_s_per_m = 100\nradius_m = 0.05\n";
            let elements = design(vectors, pinned);
            let elements = elements.replace("nm = 0\n", "nm = 0\ncenter_of_mass_m = 0\n");
            elements.replace("mass_kg = ", "moment_of_inertia_kg_m2 = 2e-3\nmass_kg = ") + stop
        };
        let sled = |pinned: bool| thresholds(&folder, &whole(pinned))["sled"].clone();
        assert_eq!(sled(false)["verdict"], "undecided", "{}", sled(false));
        assert_eq!(sled(true)["verdict"], "pass", "{}", sled(true));
    }
}

/// Numbers that no element of a latch has are said, with an inertia or without.
#[test]
fn cli_elements_of_another_world_are_warned_of() {
    let folder = Folder::new("static-elements");
    for (mass_kg, arm_m, said) in [
        (0.05, 0.03, None),
        (50.0, 0.03, Some("The mass of element `pawl` is 50 kg")),
        (0.05, -30.0, Some("The arm of element `handle` is 30 m")),
    ] {
        let design = format!(
            "[tolerance]\npreload_torque_nm = 0\n\
             [[linkage]]\nname = \"pawl\"\nmass_kg = {mass_kg}\narm_m = 0.03\nspring_torque_nm = 5\n\
             [[linkage]]\nname = \"handle\"\nmass_kg = 0.01\narm_m = {arm_m}\n"
        );
        let notes = thresholds(&folder, &design)["notes"].to_string();
        match said {
            Some(said) => assert!(notes.contains(said), "{notes}"),
            None => assert!(!notes.contains("Check the design file"), "{notes}"),
        }
    }
}

/// One body, as a lever and as a linkage of one element, has the same steps and the same answer.
#[test]
fn verif_a_linkage_of_one_element_is_that_lever() {
    let folder = Folder::new("static-one");
    let center =
        "axis = [0, 0, 1]\ncenter_of_mass = [-0.04596194077712559, -0.04596194077712559, 0]\n";
    let lever = format!(
        "base = \"paper\"\n[lever]\npreload_torque_nm = 1.72\nspring_stiffness_nm_per_rad = 2.6\n{center}\
         [criterion]\nthreshold_rad = 0.5\n[tolerance]\npreload_torque_nm = 0\nspring_stiffness_nm_per_rad = 0\n"
    );
    let linkage = format!(
        "[criterion]\nthreshold_rad = 0.5\n[tolerance]\npreload_torque_nm = 0\nspring_stiffness_nm_per_rad = 0\n\
         [[linkage]]\nname = \"handle\"\nmass_kg = 0.1475\nspring_torque_nm = 1.72\n\
         spring_stiffness_nm_per_rad = 2.6\n{center}"
    );
    let [lever, linkage] = [lever, linkage].map(|design| thresholds(&folder, &design));
    for direction in ["-X", "+Y", "plane", "space"] {
        for key in ["step_g", "counts_g"] {
            let wanted = row(&lever, direction)[key].as_f64().unwrap();
            check(row(&linkage, direction), key, wanted);
        }
    }
    assert_eq!(lever["answers"][0]["holds"], false);
    assert_eq!(linkage["answers"][0]["holds"], false);
}

/// The paper's lever, values at 200 bits: lift-off, J839, hold with the arm turned, least step.
#[test]
fn val_the_reference_levers_thresholds() {
    let folder = Folder::new("static-paper");
    let document = thresholds(&folder, "base = \"paper\"\n");
    let worst = row(&document, "space");
    for (key, wanted) in [
        ("lift_off_g", 1.06358927038115),
        ("j839_g", 1.26035328540166),
        ("hold_g", 1.4571173004221764718),
        ("step_g", 1.2608785858122345153),
    ] {
        check(worst, key, wanted);
    }
    assert_eq!(document["rows"].as_array().unwrap().len(), 1);
    // A handle hinged in front, its mass behind: it opens to the left, by an acceleration to the right.
    let axis = "name = \"handle\"\nbase = \"paper\"\n[lever]\naxis = [0, 0, 1]\ncenter_of_mass = [-0.065, 0, 0]\n";
    let document = thresholds(&folder, axis);
    let right = row(&document, "+Y");
    check(right, "step_g", 1.2624563274843171287);
    // Along an axis fixed to the vehicle the hold needs 1/cos φ* more.
    check(right, "hold_g", 1.4571173004221764718 / 0.1_f64.cos());
    check(row(&document, "space"), "step_g", 1.2608785858122345153);
    assert_eq!(row(&document, "-Y")["counts_g"], Value::Null);
    assert_eq!(row(&document, "+X")["counts_g"], Value::Null);
    assert_eq!(document["opening"], serde_json::json!([0.0, -1.0, 0.0]));
    // Along the direction at π/4 to the way, a mass in front of the pivot.
    let diagonal = "base = \"paper\"\n[lever]\naxis = [0, 0, 1]\ncenter_of_mass = [-0.04596194077712559, -0.04596194077712559, 0]\n";
    check(
        row(&thresholds(&folder, diagonal), "plane"),
        "step_g",
        1.2624563274843171287,
    );
    let steps = thresholds(&folder, diagonal);
    let both = ["+X", "-X", "+Y", "-Y"].map(|axis| row(&steps, axis)["step_g"].as_f64());
    let across = both
        .iter()
        .flatten()
        .filter(|step| (**step - 1.7002970891452654765).abs() < 1e-12);
    assert_eq!(across.count(), 1, "{both:?}");
}

/// The worked example of UN R11, Annex 4: averaged springs as forces, no stiffness.
const WORKED_EXAMPLE: &str = "name = \"R11\"\n\
    [[linkage]]\nname = \"knob rod\"\nmass_kg = 0.0163\narm_m = 0.0315\nratio = 1.1933333333333334\n\
    spring_force_n = 4.50125235\nspring_arm_m = 0.0315\n\
    [[linkage]]\nname = \"handle\"\nmass_kg = 0.0227\narm_m = 0.01067\nratio = 1.1933333333333334\n\
    [[linkage]]\nname = \"half of the link\"\nmass_kg = 0.0061\narm_m = -0.00483\nratio = 1.1933333333333334\n\
    [[linkage]]\nname = \"pawl\"\nmass_kg = 0.0422\narm_m = 0.0019\nspring_torque_nm = 0.450125235\n";

#[test]
fn val_the_worked_example_of_un_r11() {
    let folder = Folder::new("static-r11");
    let document = thresholds(&folder, WORKED_EXAMPLE);
    check(&document, "preload_torque_nm", 0.6193273108365);
    let unbalance = document["unbalance_kg_m"].as_f64().unwrap();
    assert!((unbalance - 9.46773893333e-4).abs() < 5e-16, "{unbalance}");
    let worst = row(&document, "space");
    let got = worst["lift_off_g"].as_f64().unwrap();
    assert!((got - 66.7042156999625).abs() < 1e-9, "{got}");
    // The margin that the example itself states: of 30 g, in kgf m.
    let margin = document["torque_left_nm"].as_f64().unwrap() / 9.80665;
    assert!((margin - 0.0347505932).abs() < 1e-10, "{margin}");
    assert_eq!(document["linkage"].as_array().unwrap().len(), 4);
    // Nothing is taken from the paper's lever: a replay says what it lacks.
    let file = folder.write("r11.toml", WORKED_EXAMPLE);
    let done = latchgate(&[
        "replay",
        "pulse:sled206-33g",
        "--design",
        &file,
        "--no-report",
    ]);
    assert_eq!(done.code, 4, "{}", done.out);
    for lacking in [
        "moment_of_inertia_kg_m2 of `pawl`",
        "stop.restitution",
        "pivot_damping",
    ] {
        assert!(done.err.contains(lacking), "{}", done.err);
    }
}

/// The designs that the page on standards computes by hand, to its digits.
#[test]
fn val_designs_computed_by_hand() {
    let folder = Folder::new("static-by-hand");
    let handle = thresholds(
        &folder,
        "base = \"paper\"\n[lever]\npreload_torque_nm = 3.3\naxis = [0, 0, 1]\n\
         center_of_mass = [-0.04596, -0.04596, 0]\n[tolerance]\npreload_torque_nm = \"2 %\"\n\
         spring_stiffness_nm_per_rad = 0\n",
    );
    let levers = thresholds(
        &folder,
        "[[linkage]]\nname = \"pawl\"\nmass_kg = 0.05\narm_m = 0.03\nspring_torque_nm = 0.5\n\
         [[linkage]]\nname = \"handle\"\nmass_kg = 0.02\narm_m = 0.02\nratio = 2\n\
         spring_stiffness_nm_per_rad = 0.1\n[criterion]\nthreshold_rad = 0.15\n\
         [tolerance]\npreload_torque_nm = 0.01\nspring_stiffness_nm_per_rad = 0\n",
    );
    for (document, direction, key, wanted) in [
        (&handle, "-X", "lift_off_g", 46.660),
        (&handle, "-X", "j839_g", 46.939),
        (&handle, "-X", "hold_g", 43.127),
        (&handle, "-X", "step_g", 44.776),
        (&handle, "-X", "counts_g", 46.660),
        (&handle, "space", "j839_g", 33.191),
        (&levers, "space", "j839_g", 22.168),
        (&levers, "space", "lift_off_g", 20.838),
        (&levers, "space", "counts_g", 19.838),
    ] {
        let got = row(document, direction)[key].as_f64().unwrap();
        assert!((got - wanted).abs() < 6e-4, "{direction} {key}: {got}");
    }
}

/// A whole linkage is replayed, and its document is that of the lever that it comes to.
#[test]
fn cli_a_whole_linkage_is_replayed() {
    let folder = Folder::new("static-linkage");
    let stop = "[lever]\npivot_damping_nm_s_per_rad = 1e-4\n[stop]\nrestitution = 0.7\n\
                stiffness_n_per_m = 1e7\ndamping_n_s_per_m = 100\nradius_m = 0.05\n";
    let mut design = WORKED_EXAMPLE.replace("mass_kg", "moment_of_inertia_kg_m2 = 1e-4\nmass_kg");
    design += stop;
    design += "[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\n";
    let file = folder.write("whole.toml", &design);
    let replay = |more: &[&str]| {
        let fixed = [
            "replay",
            "pulse:sled206-33g",
            "--no-report",
            "--format",
            "json",
        ];
        latchgate(&[&fixed, more].concat())
    };
    // Elements that nothing joins may part, which a replay does not follow.
    let loose = replay(&["--design", &file]);
    assert_eq!(loose.code, 3, "{}", loose.err);
    let why = loose.document()["why"][0].to_string();
    assert!(why.contains("linkage-may-part"), "{why}");
    // Three of four pinned leave one lever.
    let pinned = design.replacen("moment_of", "pinned = true\nmoment_of", 3);
    let file = folder.write("whole.toml", &pinned);
    let whole = replay(&["--design", &file]);
    let document = whole.document();
    assert_eq!(whole.code, 0, "{}", whole.err);
    assert_eq!(document["design"]["linkage"].as_array().unwrap().len(), 4);
    let lever = &document["design"]["lever"];
    let numbers = [
        "moment_of_inertia_kg_m2",
        "pivot_damping_nm_s_per_rad",
        "spring_stiffness_nm_per_rad",
        "preload_torque_nm",
        "mass_kg",
        "center_of_mass_m",
    ];
    let mut plain = String::from("name = \"plain\"\n[lever]\n");
    for key in numbers {
        plain += &format!("{key} = {:?}\n", lever[key].as_f64().unwrap());
    }
    plain += stop.split_once('\n').unwrap().1.split_once('\n').unwrap().1;
    plain += "[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\n";
    let plain = folder.write("plain.toml", plain);
    let plain = replay(&["--design", &plain]).document();
    assert_eq!(plain["nominal"], document["nominal"]);
    assert_eq!(plain["ensemble"], document["ensemble"]);
    // What contradicts the elements is refused, in a file and in a document.
    let wrong = folder.write(
        "wrong.toml",
        design.replace("[lever]\n", "[lever]\npreload_torque_nm = 3\n"),
    );
    let done = replay(&["--design", &wrong]);
    assert_eq!(done.code, 4);
    assert!(done.err.contains("leave it out"), "{}", done.err);
}

/// A lever at 45° holds 30 g along the axes and not in any direction.
#[test]
fn verif_a_slanted_lever_passes_the_axes_and_fails_the_sphere() {
    let folder = Folder::new("static-slanted");
    // T0/(m L) = 21.22 g, no spring beyond the preload.
    let torque = 21.22 * 9.80665 * 0.1475 * 0.065;
    let design = format!(
        "base = \"paper\"\n[lever]\npreload_torque_nm = {torque:?}\nspring_stiffness_nm_per_rad = 0\n\
         axis = [0, 0, 1]\ncenter_of_mass = [-0.04596194077712559, 0.04596194077712559, 0]\n"
    );
    let document = thresholds(&folder, &design);
    check(row(&document, "space"), "j839_g", 21.22);
    check(row(&document, "plane"), "j839_g", 21.22);
    let axes = ["+X", "-X", "+Y", "-Y"].map(|axis| row(&document, axis)["counts_g"].as_f64());
    let along: Vec<f64> = axes.into_iter().flatten().collect();
    assert_eq!(along.len(), 2);
    assert!(
        along
            .iter()
            .all(|level| (level - 21.22 * 2.0_f64.sqrt()).abs() < 1e-9),
        "{along:?}"
    );
    let file = folder.write("slanted.toml", &design);
    let done = latchgate(&["static", &file, "--no-report"]);
    assert!(
        done.out.contains("SPRING NOT STATED") || done.out.contains("DOES NOT HOLD 30 g"),
        "{}",
        done.out
    );
    let stated = folder.write(
        "stated.toml",
        design + "[tolerance]\npreload_torque_nm = 0\n",
    );
    let page = latchgate(&["static", &stated, "--no-report"]).out;
    assert!(page.starts_with("STATIC  DOES NOT HOLD 30 g"), "{page}");
    for (standard, holds) in [("206", true), ("r11", false), ("j839", false)] {
        let asked = [
            "static",
            &stated,
            "--no-report",
            "--format",
            "json",
            "--standard",
            standard,
        ];
        let answers = latchgate(&asked).document()["answers"].clone();
        assert_eq!(answers.as_array().unwrap().len(), 1);
        assert_eq!(answers[0]["holds"], holds, "{answers}");
    }
}

/// A spring counts with its least output: three standard deviations below the nominal one unless others, or the least
/// itself, are stated; one of which nothing is stated holds nothing, and a stiffness of which nothing is stated counts as
/// none.
#[test]
fn verif_a_spring_counts_with_its_least_output() {
    let folder = Folder::new("static-spring");
    let lever =
        "base = \"paper\"\n[lever]\npreload_torque_nm = 3.3\nspring_stiffness_nm_per_rad = 0.4\n";
    let asked = |tolerance: &str, more: &[&str]| {
        let file = folder.write("spring.toml", format!("{lever}{tolerance}"));
        let fixed = ["static", &file, "--no-report", "--format", "json"];
        latchgate(&[&fixed, more].concat()).document()
    };
    // m L · 1 g of the paper's lever, and what its spring has by the limit angle on average.
    let per_g = 0.1475 * 0.065 * 9.80665;
    let level = |closed: f64, stiffness: f64| (closed + 0.5 * stiffness * 0.1) / per_g - 1.0;
    for (tolerance, more, closed, stiffness, holds) in [
        (
            "[tolerance]\npreload_torque_nm = 0.5\n",
            &[][..],
            1.8,
            0.0,
            Some(false),
        ),
        (
            "[tolerance]\npreload_torque_nm = 0.5\n",
            &["--spring-deviations", "0"],
            3.3,
            0.0,
            Some(true),
        ),
        (
            "[tolerance]\npreload_torque_nm = \"1 %\"\n",
            &[],
            3.3 * 0.97,
            0.0,
            Some(true),
        ),
        (
            "[tolerance]\npreload_torque_nm = 0\nspring_stiffness_nm_per_rad = 0.1\n",
            &[],
            3.3,
            0.1,
            Some(true),
        ),
        ("", &["--spring-torque-min", "2.5"], 2.5, 0.0, Some(false)),
        ("", &["--spring-torque-min", "3.25"], 3.25, 0.0, Some(true)),
        // A statement of another number is none of the spring.
        ("[tolerance]\nmass_kg = 0\n", &[], 3.3, 0.4, None),
        ("", &[], 3.3, 0.4, None),
    ] {
        let document = asked(tolerance, more);
        let worst = row(&document, "space");
        let (counts, nominal) = (worst["counts_g"].as_f64(), worst["nominal_g"].as_f64());
        assert!(
            (counts.unwrap() - level(closed, stiffness)).abs() < 1e-9,
            "{tolerance} {more:?}: {worst}"
        );
        assert!(
            (nominal.unwrap() - level(3.3, 0.4)).abs() < 1e-9,
            "{tolerance} {more:?}: {worst}"
        );
        for answer in document["answers"].as_array().unwrap() {
            // Without an axis the standard of axes is not told that the worst direction is one of them.
            let holds = match (answer["standard"].as_str(), holds) {
                (Some("206"), Some(false)) => None,
                (_, holds) => holds,
            };
            assert_eq!(
                answer["holds"].as_bool(),
                holds,
                "{tolerance} {more:?}: {answer}"
            );
        }
    }
    // A linkage that a replay could not follow states it as well.
    let linkage = WORKED_EXAMPLE.to_string() + "[tolerance]\npreload_torque_nm = \"2 %\"\n";
    let document = thresholds(&folder, &linkage);
    let (lift_off, least) = (66.7042156999625, 0.94);
    check(row(&document, "space"), "lift_off_g", lift_off * least);
    for wrong in [
        ["--spring-deviations", "-1"],
        ["--spring-torque-min", "nan"],
        // More than the paper's spring has: a slip of the unit.
        ["--spring-torque-min", "100"],
    ] {
        let option = format!("{}={}", wrong[0], wrong[1]);
        let done = latchgate(&["static", &option]);
        assert_eq!(done.code, 2, "{option}: {}", done.err);
    }
}

/// The door chooses rows and clauses; part, revision and drawing stand on the page.
#[test]
fn cli_a_door_chooses_its_rows_and_the_page_says_of_what_it_is() {
    let folder = Folder::new("static-door");
    // A flap that opens upwards: 20 g along Z, nothing along X and Y.
    let torque = 20.0 * 9.80665 * 0.1475 * 0.065;
    let flap = format!(
        "base = \"paper\"\n[lever]\npreload_torque_nm = {torque:?}\nspring_stiffness_nm_per_rad = 0\n\
         axis = [1, 0, 0]\ncenter_of_mass = [0, -0.065, 0]\n[tolerance]\npreload_torque_nm = 0\n\
         [document]\npart = \"4711-0815\"\nrevision = \"C\"\ndrawing = \"D 17\"\nauthor = \"A. Maker\"\ndate = 2026-03-01\n"
    );
    let file = folder.write("flap.toml", flap);
    for (door, holds, clause) in [
        (
            "hinged",
            true,
            "S4.1.1.4(c), by calculation after S5.1.1.4(a); UN R11 6.1.4.1",
        ),
        ("sliding", true, "S4.2.1.3(b); UN R11 6.2.3"),
        (
            "back",
            false,
            "S4.1.1.4(c), by calculation after S5.1.1.4(a)",
        ),
    ] {
        let asked = [
            "static",
            &file,
            "--no-report",
            "--door",
            door,
            "--standard",
            "206",
        ];
        let json = latchgate(&[&asked[..], &["--format", "json"]].concat()).document();
        assert_eq!(json["answers"][0]["holds"], holds, "{door}: {json}");
        let text = latchgate(&asked)
            .out
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        assert!(text.contains(clause), "{door}: {text}");
    }
    for (door, code) in [("", 0), (", door = \"back\"", 1)] {
        let gate = folder.write(
            "gate.toml",
            format!(
                "require_static_g = {{ g = 30, standard = \"206\"{door} }}\n[[recordings]]\n\
                 files = [\"pulse:haversine,peak=3g,duration=10ms\"]\n[[designs]]\nfile = \"flap.toml\"\n"
            ),
        );
        let out = folder.path().join("gate").to_str().unwrap().to_string();
        let done = latchgate(&[
            "gate",
            &gate,
            "--reports",
            "none",
            "--no-store",
            "--out",
            &out,
        ]);
        assert_eq!(
            done.out.contains("opens under the static load"),
            code == 1,
            "{}",
            done.out
        );
        assert!(
            done.out.contains("side door") || done.out.contains("back door"),
            "{}",
            done.out
        );
    }
    let out = folder.path().join("page");
    latchgate(&["static", &file, "--out", out.to_str().unwrap()]);
    let page = std::fs::read_to_string(out.join("static.html")).unwrap();
    for said in [
        "4711-0815",
        "D 17",
        "A. Maker",
        "2026-03-01",
        "0.1475 kg × 0.065 m",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // What no latch has is said here as in a replay.
    let heavy = [
        "static",
        &file,
        "--no-report",
        "--set",
        "lever.moment_of_inertia_kg_m2=1",
        "--set",
        "lever.mass_kg=60",
    ];
    let heavy = latchgate(&heavy);
    assert!(
        heavy.out.contains("lever.mass_kg is 60 kg"),
        "{}{}",
        heavy.out,
        heavy.err
    );
    let wrong = folder.write(
        "wrong.toml",
        "base = \"paper\"\n[document]\npartt = \"1\"\n",
    );
    for asked in [
        &["static", &wrong][..],
        &["replay", "pulse:sled206-33g", "--design", &wrong],
    ] {
        let done = latchgate(asked);
        assert_eq!(done.code, 4, "{}", done.out);
        assert!(done.err.contains("did you mean `part`"), "{}", done.err);
    }
}

/// Gravity counts where it opens, and is left out where it holds the latch shut.
#[test]
fn verif_gravity_counts_where_it_opens() {
    let folder = Folder::new("static-gravity");
    let flap = |center: &str| {
        let design =
            format!("base = \"paper\"\n[lever]\naxis = [1, 0, 0]\ncenter_of_mass = {center}\n");
        thresholds(&folder, &design)
    };
    // The mass to the right of the axis X moves down as it opens: gravity helps it.
    let down = flap("[0, 0.065, 0]");
    assert_eq!(down["gravity_share"], 1.0);
    let upward = row(&down, "-Z");
    let both = ["j839_g", "j839_with_gravity_g"].map(|key| upward[key].as_f64().unwrap());
    assert!((both[0] - both[1] - 1.0).abs() < 1e-12, "{both:?}");
    assert_eq!(upward["counts_g"], upward["j839_with_gravity_g"]);
    let up = flap("[0, -0.065, 0]");
    assert_eq!(up["gravity_share"], -1.0);
    let downward = row(&up, "+Z");
    assert_eq!(downward["j839_with_gravity_g"], Value::Null);
    assert_eq!(downward["counts_g"], downward["j839_g"]);
    assert_eq!(
        downward["margin_interior"].as_f64(),
        downward["counts_g"].as_f64().map(|g| g / 10.0)
    );
}

#[test]
fn cli_wrong_directions_and_elements_are_refused() {
    let folder = Folder::new("static-wrong");
    for (design, told) in [
        ("base = \"paper\"\n[lever]\naxis = [0, 0, 1]\n", "both"),
        (
            "base = \"paper\"\n[lever]\naxis = [0, 0, 0]\ncenter_of_mass = [1, 0, 0]\n",
            "neither of length 0",
        ),
        (
            "base = \"paper\"\n[lever]\naxis = [0, 0, 1]\ncenter_of_mass = [0, 0, 1]\n",
            "off the axis",
        ),
        (
            "base = \"paper\"\n[lever]\naxis = [0, 1]\ncenter_of_mass = [0, 0, 1]\n",
            "three numbers",
        ),
        (
            "base = \"paper\"\n[lever]\ncenter_of_mass_m = 0.05\naxis = [0, 0, 1]\ncenter_of_mass = [-0.065, 0, 0]\n",
            "the distance of lever.center_of_mass",
        ),
        ("[[linkage]]\nname = \"a\"\nmass_kg = 1\n", "arm_m, or axis"),
        (
            "[[linkage]]\nname = \"a\"\nmass_kg = 1\narm_m = 0.1\nmas = 1\n",
            "unknown field `mas`",
        ),
        (
            "[[linkage]]\nname = \"a\"\nmass_kg = -1\narm_m = 0.1\n",
            "zero or positive",
        ),
        (
            "[[linkage]]\nname = \"a\"\nmass_kg = 1\narm_m = 0.1\n",
            "springs that close it",
        ),
    ] {
        let file = folder.write("wrong.toml", design);
        let done = latchgate(&["static", &file, "--no-report"]);
        assert_eq!(
            (done.code, done.out.as_str()),
            (4, ""),
            "{design}: {}",
            done.err
        );
        assert!(done.err.contains(told), "{design}: {}", done.err);
    }
}

/// The page is written, names the clauses, and says what is unverified; the gate holds designs against it.
#[test]
fn cli_a_page_to_file_and_a_row_of_the_gate() {
    let folder = Folder::new("static-page");
    let out = folder.path().join("page");
    let done = latchgate(&["static", "--out", out.to_str().unwrap()]);
    assert_eq!(done.code, 0, "{}", done.err);
    let page = std::fs::read_to_string(out.join("static.html")).unwrap();
    for text in [
        "UN R11 Annex 4, 2.1.2",
        "SAE J839 was not",
        "DOES NOT HOLD 30 g",
        "Signature",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let again = latchgate(&["static", "--out", out.to_str().unwrap()]);
    assert_eq!(again.code, 0, "{}", again.err);
    for (preload, code) in [("0.5", 1), ("2.9", 1), ("3.6", 0)] {
        let gate = folder.write(
            "gate.toml",
            format!(
                "require_static_g = 30\n[[recordings]]\nfiles = [\"pulse:haversine,peak=3g,duration=10ms\"]\n\
                 [[designs]]\nname = \"lever\"\nset = [\"lever.preload_torque_nm={preload}\"]\n"
            ),
        );
        let summary = folder.path().join(format!("gate-{preload}"));
        let fixed = ["gate", &gate, "--reports", "none", "--no-store", "--out"];
        let done = latchgate(&[&fixed[..], &[summary.to_str().unwrap()]].concat());
        assert_eq!(done.code, code, "{} {}", done.out, done.err);
        assert!(
            done.out.contains("hold 30 g") || done.out.contains("holds 30 g"),
            "{}",
            done.out
        );
        let junit = std::fs::read_to_string(summary.join("junit.xml")).unwrap();
        assert!(junit.contains("name=\"static\""), "{junit}");
        assert_eq!(junit.contains("<failure"), code == 1, "{junit}");
    }
    for (value, found) in [
        ("0", "found `0`"),
        ("{ g = 30 }", "found no `standard`"),
        ("{ g = 30, standard = \"207\" }", "found the standard `207`"),
        (
            "{ g = 30, standard = \"206\", door = \"boot\" }",
            "found the door `boot`",
        ),
        ("{ g = 30, standard = \"206\", k = 3 }", "found the key `k`"),
    ] {
        let text =
            format!("require_static_g = {value}\n[[recordings]]\nfiles = [\"x\"]\n[[designs]]\n");
        let wrong = folder.write("wrong.toml", text);
        let done = latchgate(&["gate", &wrong, "--reports", "none", "--no-store"]);
        assert!(done.err.contains("a load in g, above 0"), "{}", done.err);
        assert!(done.err.contains(found), "{}", done.err);
    }
}

fn sled(word: &str, more: &[&str]) -> Value {
    let fixed = ["inspect", word, "--sled206", "--format", "json"];
    latchgate(&[&fixed, more].concat()).document()["sled206"].clone()
}

/// Pulse, mass of the weight [kg], direction that opens, release and crossing [s], peak [rad].
type WeightedCase = (&'static str, f64, &'static str, f64, Option<f64>, f64);

/// The paper's lever with a weight [kg] fixed 0.03 m behind its pivot, on sled pulses: release and crossing [s], peak
/// [rad], by a Taylor integrator of order 34 at 200 bits. With 0.35 kg the weight overbalances it.
const WEIGHTED: [WeightedCase; 6] = [
    (
        "sled206-lower",
        0.0,
        "positive",
        0.0057090595135874338,
        Some(0.021319088942705745),
        2.9688041873094044917,
    ),
    (
        "sled206-upper",
        0.0,
        "positive",
        0.0,
        Some(0.012915512189888104),
        2.6001196607133494953,
    ),
    (
        "sled206-33g",
        0.0,
        "positive",
        7.0905951358743381e-4,
        Some(0.016319088942705745),
        2.5916857019655887909,
    ),
    (
        "sled206-33g",
        0.15,
        "positive",
        0.0013362374617237389,
        Some(0.021564245363770032),
        2.5359003797700813967,
    ),
    (
        "sled206-33g",
        0.308,
        "positive",
        0.019562900968401501,
        None,
        0.011205366638739133728,
    ),
    (
        "sled206-33g",
        0.35,
        "negative",
        0.0074499814646789278,
        Some(0.050227508449575873),
        0.39000360219372388053,
    ),
];

#[test]
fn val_a_lever_with_a_fixed_weight_on_sled_pulses() {
    for (pulse, weight_kg, sign, release_s, crossing_s, peak_rad) in WEIGHTED {
        let arm_m = (0.1475 * 0.065 - 0.03 * weight_kg) / 0.1475;
        let inertia = 8.888e-4 + 9e-4 * weight_kg;
        let done = latchgate(&[
            "replay",
            &format!("pulse:{pulse},opens-when={sign}"),
            "--model",
            "rigid",
            "--members",
            "0",
            "--no-report",
            "--no-advice",
            "--format",
            "json",
            "--set",
            &format!("lever.center_of_mass_m={arm_m:?}"),
            "--set",
            &format!("lever.moment_of_inertia_kg_m2={inertia:?}"),
        ]);
        let nominal = done.document()["nominal"].clone();
        let label = format!("{pulse} {weight_kg}: {nominal}");
        let number = |key: &str| nominal[key].as_f64();
        let stated = number("numerical_error_rad").unwrap();
        let off = (number("peak_angle_rad").unwrap() - peak_rad).abs();
        assert!(off <= stated && stated < 1e-12, "{label}");
        assert!(
            (number("first_release_s").unwrap() - release_s).abs() < 1e-15,
            "{label}"
        );
        let crossing = number("first_crossing_s");
        assert_eq!(crossing.is_some(), crossing_s.is_some(), "{label}");
        let late = crossing
            .zip(crossing_s)
            .map_or(0.0, |(found, wanted)| (found - wanted).abs());
        assert!(late < 1e-15, "{label}");
    }
}

/// The pulse of 33 g holds 30 g for 39.55 ms, and for 39.71 ms after CFC 60: it is valid. A plateau of 29 ms
/// is not, nor a pulse that comes late.
#[test]
fn val_a_sled_pulse_is_checked() {
    let valid = sled("pulse:sled206-33g,rate=10kHz", &[]);
    let held = valid["held_s"].as_f64().unwrap();
    assert!((held - 0.03971).abs() < 1e-5, "{valid}");
    assert_eq!(valid["answer"], "valid", "{valid}");
    assert_eq!(valid["below"], Value::Null);
    // Its other sign is the same pulse.
    let mirrored = "pulse:trapezoid,peak=-33g,rise=22ms,hold=35ms,fall=28ms,rate=10kHz";
    assert_eq!(sled(mirrored, &[])["held_s"].as_f64(), Some(held));
    let short = sled(
        "pulse:polyline,points=0:0/20:30.5/49:30.5/69:0,unit=g,rate=10kHz",
        &[],
    );
    assert_eq!(short["answer"], "not-valid", "{short}");
    assert!(short["held_s"].as_f64().unwrap() < 0.030);
    // It holds its level, but rises too late for the corridor, which is never shifted to fit.
    let late = sled(
        "pulse:polyline,points=0:0/20:0/30:33/70:33/80:0,unit=g,rate=10kHz",
        &[],
    );
    assert_eq!(
        (&late["answer"], late["held_s"].as_f64() > Some(0.030)),
        (&Value::from("not-valid"), true)
    );
    assert!(late["below"]["by_g"].as_f64().unwrap() > 10.0, "{late}");
    // What exceeds 36 g, all else met, was the harder pulse; what lies beside the corridor at less is outside it.
    let points = |points: &str| format!("pulse:polyline,points={points},unit=g,rate=10kHz");
    let harder = sled(&points("0:0/22:33/30:40/50:40/57:33/85:0"), &[]);
    assert_eq!(harder["answer"], "valid-if-held", "{harder}");
    assert!(
        harder["above_level"]["by_g"].as_f64().unwrap() > 3.0,
        "{harder}"
    );
    assert_eq!(harder["above"], Value::Null, "{harder}");
    let steep = sled(
        "pulse:trapezoid,peak=40g,rise=18ms,hold=40ms,fall=25ms,rate=10kHz",
        &[],
    );
    assert_eq!(steep["answer"], "not-valid", "{steep}");
    let again = sled(
        &points("0:0/22:33/57:33/85:0/115:0/120:32/170:32/180:0"),
        &[],
    );
    assert_eq!(again["answer"], "not-valid", "{again}");
    assert!(again["outside"]["by_g"].as_f64().unwrap() > 20.0, "{again}");
    let long = sled(&points("0:0/22:34/80:34/90:34/110:0"), &[]);
    assert_eq!(long["answer"], "not-valid", "{long}");
    assert!(long["above"]["by_g"].as_f64().unwrap() > 20.0, "{long}");
    assert_eq!(long["above_level"], Value::Null, "{long}");
}

/// A recording's own clock is the corridor's, moved by what a person states and by nothing else.
#[test]
fn cli_the_corridor_lies_at_time_zero() {
    let folder = Folder::new("sled-zero");
    let table: String = (0..2000)
        .map(|k| {
            let t = f64::from(k) * 1e-4;
            let since = t - 0.1;
            let level = (since / 0.022).min((0.085 - since) / 0.028).clamp(0.0, 1.0) * 33.0;
            format!("{t:.4},{level:.6}\n")
        })
        .collect();
    let file = folder.write("platform.csv", format!("t_s,acc_y_g\n{table}"));
    folder.write("platform.csv.toml", "synthetic = true\n");
    assert_eq!(sled(&file, &[])["answer"], "not-valid");
    let moved = sled(&file, &["--time-zero", "0.1"]);
    assert_eq!(moved["answer"], "valid", "{moved}");
    let out = folder.path().join("report");
    let fixed = [
        "replay",
        &file,
        "--time-zero",
        "0.1",
        "--sled206",
        "--opens-when",
        "negative",
    ];
    let done = latchgate(&[&fixed[..], &["--out", out.to_str().unwrap()]].concat());
    assert!(
        done.out.contains("A valid sled pulse"),
        "{} {}",
        done.out,
        done.err
    );
    assert!(out.join("sled206.svg").is_file());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("As a sled pulse"));
    let verified = latchgate(&["verify", out.join("verdict.json").to_str().unwrap()]);
    assert_eq!(verified.code, 0, "{} {}", verified.out, verified.err);
}

/// What is no number, too large for one, or beyond what a latch can bear makes no latch of one that opens.
#[test]
fn verif_no_odd_number_holds_30_g() {
    let folder = Folder::new("static-odd");
    let element = |rest: &str| {
        format!(
            "[[linkage]]\nname = \"a\"\nmass_kg = 0.1\nspring_torque_nm = 1\n{rest}\n\
             [[linkage]]\nname = \"b\"\nmass_kg = 0.001\naxis = [0, 0, 1]\ncenter_of_mass = [0.1, 0, 0]\n"
        )
    };
    for refused in [
        element("axis = [0, 0, 1]\ncenter_of_mass = [nan, 0, 0]"),
        element("axis = [0, 0, 1e200]\ncenter_of_mass = [0.1, 0, 0]"),
        element("axis = [0, 0, 1]\ncenter_of_mass = [0.1, 0, 0]\nratio = 0"),
        element("axis = [0, 0, 1]\ncenter_of_mass = [0.1, 0, 0]\nspring_force_n = 3"),
        element(
            "axis = [0, 0, 1]\ncenter_of_mass = [0.1, 0, 0]\nratio = 10\nspring_stiffness_nm_per_rad = 1e308",
        ),
        element("axis = [0, 0, 1]\ncenter_of_mass = [0.1, 0, 0]\nspring_stiffness_nm_per_rad = 1"),
        element("axis = [0, 0, 1]\ncenter_of_mass = [0.1, 0, 0]")
            + "[lever]\npreload_torque_nm = 100\n",
        "base = \"paper\"\n[lever]\naxis = [0, 0, 1]\ncenter_of_mass = [inf, 0, 0]\n".into(),
    ] {
        let file = folder.write("odd.toml", &refused);
        let done = latchgate(&["static", &file, "--no-report"]);
        assert_eq!(
            (done.code, done.out.as_str()),
            (4, ""),
            "{refused}: {}",
            done.err
        );
    }
    // A raised limit, or one beyond 90°, is not averaged over.
    let soft =
        "base = \"paper\"\n[lever]\npreload_torque_nm = 0.1\nspring_stiffness_nm_per_rad = 20\n";
    let file = folder.write("soft.toml", soft);
    let raised = [
        "static",
        &file,
        "--no-report",
        "--format",
        "json",
        "--set",
        "criterion.threshold_rad=3",
    ];
    let document = latchgate(&raised).document();
    let plain = thresholds(&folder, soft);
    assert_eq!(document["rows"], plain["rows"]);
    assert_eq!(
        document["modified"],
        serde_json::json!(["criterion.threshold_rad 3 (0.1)"])
    );
    let far = thresholds(
        &folder,
        &format!("{soft}[criterion]\nthreshold_rad = 100\n"),
    );
    assert_eq!(
        far["threshold_rad"].as_f64(),
        Some(std::f64::consts::FRAC_PI_2)
    );
    // Beside an axis the sign is the vector's.
    let file = folder.write(
        "axis.toml",
        "base = \"paper\"\n[lever]\naxis = [0, 0, 1]\ncenter_of_mass = [-0.065, 0, 0]\n",
    );
    let turned = latchgate(&[
        "static",
        &file,
        "--no-report",
        "--set",
        "lever.center_of_mass_m=-0.065",
    ]);
    assert_eq!(turned.code, 4, "{}", turned.out);
}

/// Where the arm turns towards a fixed direction, the step counts that opens the lever before SAE J839.
#[test]
fn verif_the_step_counts_where_it_opens_sooner() {
    let folder = Folder::new("static-step");
    let document = thresholds(
        &folder,
        "base = \"paper\"\n[lever]\npreload_torque_nm = 1\nspring_stiffness_nm_per_rad = 7.7\naxis = [0, 0, 1]\n\
         center_of_mass = [-0.045961940777125, 0.045961940777125, 0]\n[criterion]\nthreshold_rad = 0.5\n",
    );
    let mut sooner = 0;
    for row in document["rows"].as_array().unwrap() {
        let [step, level, lift_off, counts] = ["step_g", "j839_g", "lift_off_g", "counts_g"]
            .map(|key| row[key].as_f64().unwrap_or(f64::INFINITY));
        // What does not lift a lever off opens it at no step.
        assert_eq!(counts, step.max(lift_off).min(level), "{row}");
        sooner += usize::from(step < level);
    }
    assert!(sooner > 0);
}

/// A verdict of a design with an axis, and of one with a linkage, is verified.
#[test]
fn cli_designs_with_directions_are_verified() {
    let folder = Folder::new("static-verify");
    let axis = "base = \"paper\"\n[lever]\naxis = [0, 0, 1]\ncenter_of_mass = [-0.065, 0, 0]\n"
        .to_string();
    let linkage = WORKED_EXAMPLE.replace("mass_kg", "moment_of_inertia_kg_m2 = 1e-4\nmass_kg")
        + "[lever]\npivot_damping_nm_s_per_rad = 1e-4\n[stop]\nrestitution = 0.7\n\
           stiffness_n_per_m = 1e7\ndamping_n_s_per_m = 100\nradius_m = 0.05\n";
    for (name, design) in [("axis", axis), ("linkage", linkage)] {
        let file = folder.write(&format!("{name}.toml"), design);
        let out = folder.path().join(name);
        let word = "pulse:haversine,peak=30g,duration=10ms";
        let fixed = ["replay", word, "--design", &file, "--members", "0", "--out"];
        let done = latchgate(&[&fixed[..], &[out.to_str().unwrap()]].concat());
        assert!(done.code < 4, "{}", done.err);
        let verified = latchgate(&["verify", out.join("verdict.json").to_str().unwrap()]);
        assert_eq!(
            verified.code, 0,
            "{name}: {} {}",
            verified.out, verified.err
        );
        assert_eq!(
            done.out.contains("radial-left-out"),
            name == "axis",
            "{}",
            done.out
        );
    }
}

/// A record that lacks part of the corridor, or has a blocking finding, is no valid sled pulse.
#[test]
fn verif_a_sled_pulse_is_valid_only_as_a_whole() {
    let folder = Folder::new("sled-whole");
    let table = |from: i32, to: i32, top: f64| {
        let rows = (from..to).map(|k| {
            let t = f64::from(k) * 1e-4;
            let level = (t / 0.022).min((0.085 - t) / 0.028).clamp(0.0, 1.0) * 33.0;
            let ripple = 0.02 * f64::from((k * 7).rem_euclid(11));
            format!("{t:.4},{:.6}\n", (level + ripple).min(top))
        });
        format!("t_s,acc_y_g\n{}", rows.collect::<String>())
    };
    for (name, from, to, top, range) in [
        ("whole", -200, 1000, 99.0, 2000),
        ("late", 248, 1000, 99.0, 2000),
        ("cut", -200, 555, 99.0, 2000),
        ("clipped", -200, 1000, 31.0, 31),
    ] {
        let file = folder.write(&format!("{name}.csv"), table(from, to, top));
        folder.write(&format!("{name}.csv.toml"), format!("range_g = {range}\n"));
        let check = sled(&file, &[]);
        let is_valid = check["answer"] == "valid";
        assert_eq!(is_valid, name == "whole", "{name}: {check}");
    }
}
