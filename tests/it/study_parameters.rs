//! The study of the paper's conclusion: peaks under the shock against the lever's numbers.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_study::parameters::{self, Number, Options, Parameters};
use latchgate_study::shock;

fn study(design: Design, points: u32) -> Parameters {
    let options = Options {
        design,
        models: vec![StopModel::Rigid, StopModel::Soft],
        gravity_m_s2: STANDARD_GRAVITY,
        points,
    };
    parameters::run(&options, &Control::default()).unwrap()
}

/// Beyond the torque of the strongest sample a lever never leaves its rigid stop; below it does.
#[test]
fn verif_a_preload_beyond_the_strongest_push_holds_the_lever() {
    let design = Design::reference();
    let options = shock::Options {
        design: design.clone(),
        models: vec![StopModel::Rigid],
        gravity_m_s2: STANDARD_GRAVITY,
        amplitude_g: 1000.0,
        duration_s: 0.1,
    };
    let result = shock::run(&options).unwrap();
    let strongest = result.signals[0]
        .samples
        .iter()
        .fold(0.0_f64, |most, a| most.max(-a));
    let torque = strongest * design.lever.unbalance_kg_m();
    let mut sides = [0, 0];
    for row in study(design, 41).rows {
        if (row.number, row.stop) != (Number::Preload, StopModel::Rigid) {
            continue;
        }
        let peak = row.peak_angle_rad.unwrap();
        assert_eq!(peak > 0.0, row.value < torque, "{row:?}, {torque}");
        sides[usize::from(peak > 0.0)] += 1;
    }
    assert!(sides[0] > 0 && sides[1] > 30, "{sides:?}");
}

/// At the design's own number every row is the peak of the shock itself.
#[test]
fn verif_the_present_value_is_the_shock_itself() {
    let mut design = Design::reference();
    // Ends of the ranges, where a row has exactly this value.
    design.lever.preload_torque_nm = 0.01;
    design.stop.restitution = 1.0;
    let options = shock::Options {
        design: design.clone(),
        models: vec![StopModel::Rigid],
        gravity_m_s2: STANDARD_GRAVITY,
        amplitude_g: 1000.0,
        duration_s: 0.0,
    };
    let run = shock::run(&options).unwrap().responses.remove(0).run;
    let peak = run
        .coast_peak_angle_rad
        .unwrap_or(0.0)
        .max(run.peak_angle_rad);
    let rows = study(design.clone(), 3).rows;
    for number in [Number::Preload, Number::Restitution] {
        let own = |row: &&parameters::Row| {
            row.number == number && row.stop == StopModel::Rigid && row.value == number.of(&design)
        };
        let row = rows.iter().find(own).unwrap();
        assert!(
            (row.peak_angle_rad.unwrap() - peak).abs() < 1e-9,
            "{row:?}, {peak}"
        );
    }
    // Restitution is of the rigid stop alone, stiffness of the soft one.
    let stops = |number: Number| {
        let of_number = rows.iter().filter(|row| row.number == number);
        let mut stops: Vec<StopModel> = of_number.map(|row| row.stop).collect();
        stops.dedup();
        stops
    };
    assert_eq!(stops(Number::Restitution), [StopModel::Rigid]);
    assert_eq!(stops(Number::StopStiffness), [StopModel::Soft]);
    assert_eq!(stops(Number::Inertia), [StopModel::Rigid, StopModel::Soft]);
}
