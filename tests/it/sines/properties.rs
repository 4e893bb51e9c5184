//! What holds for the studies of sines whatever the numbers: threads change no bit, a stop keeps
//! what is done, a state that is carried along is, and capture is no guess.

use super::{
    after_the_first_step, all, basins_of, basins_options, check_near, forced, one_amplitude,
};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::{Section, State};
use latchgate_study::attractor;
use latchgate_study::basins::{self, Basins};
use latchgate_study::bifurcation::{self, Diagram, Sweep};
use latchgate_study::excitation_map;

fn diagram(stop: StopModel, doublings: u32) -> bifurcation::Options {
    bifurcation::Options {
        forced: forced(stop, 100.0),
        amplitudes_g: Range::new(0.9, 1.7),
        points: 17,
        transient: 60,
        periods: 12,
        initial: Some(State::new(0.07, 2.7)),
        sweep: Sweep::None,
        doublings,
    }
}

fn ensemble() -> attractor::Options {
    attractor::Options {
        amplitudes_g: Range::new(2.4, 2.6),
        points: 12,
        compared_steps: Some(200),
        ..one_amplitude(forced(StopModel::Rigid, 100.0), 0.0, 20, 20)
    }
}

fn map() -> excitation_map::Options {
    excitation_map::Options {
        forced: forced(StopModel::Soft, 1.0),
        amplitudes_g: Range::new(0.0, 6.0),
        angular_frequencies_rad_s: Range::new(20.0, 200.0),
        grid: (8, 6),
        periods: 5,
    }
}

/// The same work by one thread and by two.
#[track_caller]
fn check_threads<T: PartialEq>(what: &str, of: impl Fn(&Control<'_>) -> T) {
    let alone = of(&all(1));
    assert!(alone == of(&all(2)), "{what}");
}

#[test]
fn prop_threads_change_nothing() {
    check_threads("bifurcation", |control| {
        bifurcation::run(&diagram(StopModel::Rigid, 1), control).unwrap()
    });
    check_threads("attractor", |control| {
        attractor::run(&ensemble(), control).unwrap()
    });
    check_threads("excitation-map", |control| {
        excitation_map::run(&map(), control).unwrap()
    });
    check_threads("basins", calm);
}

/// Where nothing settles, every cell is followed to the end: by all threads, in order.
#[test]
fn prop_threads_change_no_basin_of_chaos() {
    let options = basins::Options {
        amplitude_g: 2.5,
        transient: 20,
        ..basins_options(StopModel::Soft, 5, 20)
    };
    check_threads("chaos", |control| {
        let found = basins::run(&options, control).unwrap();
        assert!(found.complete);
        assert!(found.attractors.iter().any(|one| one.period == 0));
        found
    });
}

fn swept(stop: StopModel, sweep: Sweep, initial: Option<State>) -> Diagram {
    let options = bifurcation::Options {
        amplitudes_g: Range::new(0.3, 1.5),
        points: 61,
        initial,
        sweep,
        doublings: 0,
        ..diagram(stop, 0)
    };
    bifurcation::run(&options, &all(2)).unwrap()
}

/// Motion III, once begun, lasts far below lift-off, down to where it is born; the lever at rest
/// stays there up to lift-off.
#[test]
fn val_a_sweep_carries_the_state_along() {
    for (stop, birth) in [
        (StopModel::Soft, 0.415_660_115_4),
        (StopModel::Rigid, 0.418_637_738_2),
    ] {
        let down = swept(stop, Sweep::Down, Some(State::new(0.075, 3.4)));
        assert!(down.columns.is_sorted_by_key(|c| c.amplitude_g.to_bits()));
        for column in &down.columns {
            let moves = column.peak_angle_rad > 0.05;
            let what = format!("{} A = {}", stop.name(), column.amplitude_g);
            if column.amplitude_g > birth + 0.02 {
                assert!(moves && column.period == Some(1), "{what}");
            }
            if column.amplitude_g < birth {
                assert!(!moves, "{what}: {}", column.peak_angle_rad);
            }
        }
        let up = swept(stop, Sweep::Up, None);
        for column in &up.columns {
            let (amplitude, peak) = (column.amplitude_g, column.peak_angle_rad);
            let what = format!("{} A = {amplitude}: {peak:e}", stop.name());
            if amplitude < 1.0632 {
                assert!(peak < 1e-4, "{what}");
            }
            // Just above lift-off the hops are smaller than what the soft stop gives.
            if stop == StopModel::Rigid {
                assert_eq!(peak > 0.0, amplitude > 1.0633, "{what}");
            }
            assert!(amplitude < 1.3 || peak > 1e-3, "{what}");
        }
    }
}

/// Follows every fifth cell along either side to its end, step by step, without capture.
fn check_followed(found: &Basins) {
    let options = &found.options;
    let columns = options.grid.0 as usize;
    let forced = &options.forced;
    for (index, cell) in found.cells.iter().enumerate() {
        if index % columns % 5 != 1 || index / columns % 5 != 1 {
            continue;
        }
        let row = found.rows()[index];
        let start = State::new(row.angle_rad, row.angular_velocity_rad_s);
        let mut strobe = forced.strobe(options.amplitude_g, Some(start)).unwrap();
        for _ in 0..options.transient {
            strobe.advance().unwrap();
        }
        let section: Section = strobe.advance().unwrap();
        let state = section.state();
        let reached = if section.peak_angle_rad <= 1e-9 {
            Some(0)
        } else {
            found
                .attractors
                .iter()
                .skip(1)
                .find(|one| {
                    one.points
                        .iter()
                        .any(|at| forced.distance(*at, state) < 1e-4)
                })
                .map(|one| one.index)
        };
        assert_eq!(*cell, reached, "{}: {start:?}", forced.stop.name());
    }
}

/// The finer cells are those of the grid, but for the ones at a boundary.
#[track_caller]
fn check_cuts(found: &Basins) {
    let side = found.options.grid.0 as usize;
    assert_eq!(found.fine.len(), 4 * side * side);
    let cell = |column: usize, row: usize| found.cells[row * side + column];
    let mut cut = 0;
    for index in 0..side * side {
        let (column, row) = (index % side, index / side);
        let at_boundary = (column > 0 && cell(column - 1, row) != cell(column, row))
            || (column + 1 < side && cell(column + 1, row) != cell(column, row))
            || (row > 0 && cell(column, row - 1) != cell(column, row))
            || (row + 1 < side && cell(column, row + 1) != cell(column, row));
        cut += usize::from(at_boundary);
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let part = found.fine[(2 * row + y) * 2 * side + 2 * column + x];
            assert!(at_boundary || part == cell(column, row));
            assert!(part.is_some());
        }
    }
    assert_eq!(
        found.boundary_share,
        Some(cut as f64 / (side * side) as f64)
    );
    let exponent = found.uncertainty_exponent.expect("a boundary");
    assert!((0.0..1.0).contains(&exponent), "{exponent}");
}

/// Shares lie within their own standard errors of those of 100 × 100 cells.
#[track_caller]
fn check_shares(found: &Basins, shares: [f64; 3]) {
    for (attractor, share) in found.attractors.iter().zip(shares) {
        let error = attractor.standard_error.unwrap();
        assert!(error > 0.0 && error < 0.03, "{error}");
        check_near(
            &attractor.name,
            attractor.share.unwrap(),
            share,
            4.0 * error,
        );
    }
    let sum: f64 = found.attractors.iter().map(|one| one.share.unwrap()).sum();
    check_near("sum of the shares", sum, 1.0, 1e-12);
}

#[track_caller]
fn check_promises(stop: StopModel, shares: [f64; 3]) {
    let found = basins_of(stop, 25, 300, &all(2));
    assert_eq!(found.rows().len(), 625);
    check_followed(&found);
    check_cuts(&found);
    check_shares(&found, shares);
}

#[test]
fn verif_basins_of_the_rigid_stop_hold_what_they_promise() {
    check_promises(StopModel::Rigid, [0.3012, 0.0212, 0.6776]);
}

#[test]
fn verif_basins_of_the_soft_stop_hold_what_they_promise() {
    check_promises(StopModel::Soft, [0.3129, 0.0186, 0.6685]);
}

/// Basins of rest and motion III alone.
fn calm(control: &Control<'_>) -> Basins {
    let options = basins::Options {
        amplitude_g: 0.7,
        ..basins_options(StopModel::Rigid, 22, 150)
    };
    basins::run(&options, control).unwrap()
}

/// The columns beyond the first doubling have period 2, and lie on the branch of period 1: it is
/// found once, with its birth. A branch begun on one of them used to take its place, without.
#[test]
fn regress_a_branch_is_found_once_and_whole() {
    let options = bifurcation::Options {
        amplitudes_g: Range::new(0.4, 2.0),
        points: 33,
        initial: None,
        transient: 500,
        periods: 40,
        ..diagram(StopModel::Soft, 2)
    };
    let found = bifurcation::run(&options, &all(2)).unwrap();
    let periods = |wanted| {
        let with = |column: &&bifurcation::AmplitudeColumn| column.period == Some(wanted);
        found.columns.iter().filter(with).count()
    };
    assert!(
        periods(1) > 2 && periods(2) > 1,
        "{} and {}",
        periods(1),
        periods(2)
    );
    // Both are of `reference/bifurcations_w100.json` as well.
    let with_doubling: Vec<_> = found
        .branches
        .iter()
        .filter(|branch| {
            branch
                .bifurcations()
                .any(|one| (one.orbit.amplitude_g - 1.753_715_585_397).abs() < 1e-9)
        })
        .collect();
    assert_eq!(with_doubling.len(), 1, "{:#?}", found.branches);
    let birth = with_doubling[0].birth.as_ref().unwrap();
    check_near("birth", birth.orbit.amplitude_g, 0.415_660_115_422_9, 1e-9);
    assert_eq!(with_doubling[0].doublings.len(), 2);
}

/// Stops the work when half of it is done; one thread, since another may have begun the rest.
fn half() -> Control<'static> {
    Control {
        threads: 1,
        proceed: &|part| part.is_none_or(|part| part < 0.5),
    }
}

#[test]
fn verif_a_stop_keeps_what_is_done() {
    let options = diagram(StopModel::Soft, 2);
    let (whole, part) = (
        bifurcation::run(&diagram(StopModel::Soft, 0), &all(2)).unwrap(),
        bifurcation::run(&options, &half()).unwrap(),
    );
    assert!(whole.complete && !part.complete && part.branches.is_empty());
    assert!(
        (8..17).contains(&part.columns.len()),
        "{}",
        part.columns.len()
    );
    for column in &part.columns {
        assert!(whole.columns.contains(column), "A = {}", column.amplitude_g);
    }
    let options = bifurcation::Options {
        sweep: Sweep::Down,
        ..options
    };
    let part = bifurcation::run(&options, &half()).unwrap();
    assert!(!part.complete);
    assert_eq!(part.columns.len(), 9);
    assert_eq!(part.columns[8].amplitude_g, 1.7);

    let (whole, part) = (
        attractor::run(&ensemble(), &all(2)).unwrap(),
        attractor::run(&ensemble(), &half()).unwrap(),
    );
    assert!(whole.complete && !part.complete);
    assert!(part.rows.len() < whole.rows.len());
    assert!(part.rows.iter().all(|row| whole.rows.contains(row)));

    let (whole, part) = (
        excitation_map::run(&map(), &all(2)).unwrap(),
        excitation_map::run(&map(), &half()).unwrap(),
    );
    assert!(whole.complete && !part.complete);
    assert!((3..6).contains(&part.boundary.len()));
    assert!(part.rows.iter().all(|row| whole.rows.contains(row)));
    assert!(part.boundary.iter().all(|at| whole.boundary.contains(at)));

    let (whole, part) = (calm(&all(2)), calm(&half()));
    assert!(whole.complete && !part.complete && part.fine.is_empty());
    let done = part.cells.iter().flatten().count();
    assert!((242..484).contains(&done), "{done}");
    assert_eq!(part.rows().len(), done);
    for (whole, part) in whole.cells.iter().zip(&part.cells) {
        assert!(part.is_none() || whole == part);
    }
}

/// A stop while branches were followed used to pass for the end of the work.
#[test]
fn regress_a_stop_between_steps_is_told() {
    let options = diagram(StopModel::Soft, 2);
    let part = after_the_first_step(|control| bifurcation::run(&options, control).unwrap());
    assert_eq!(part.columns.len(), 17);
    assert!(!part.complete && part.branches.is_empty());
    let part = after_the_first_step(calm);
    assert!(part.cells.iter().all(Option::is_some));
    assert!(!part.complete && part.fine.is_empty() && part.uncertainty_exponent.is_none());
    assert!(
        part.attractors
            .iter()
            .all(|one| one.share.is_some_and(|share| share > 0.0))
    );
}

/// The fixed-step method used to run on after a stop, however long that took.
#[test]
fn regress_a_stop_ends_the_method_compared_with() {
    let options = attractor::Options {
        compared_steps: Some(100),
        ..one_amplitude(forced(StopModel::Rigid, 100.0), 1.05, 10, 200)
    };
    let part = attractor::run(
        &options,
        &Control {
            threads: 1,
            proceed: &|part| part.is_none_or(|part| part < 0.5),
        },
    )
    .unwrap();
    assert!(!part.complete);
    let count = |method| part.rows.iter().filter(|row| row.method == method).count();
    assert_eq!((count("event-driven"), count("rk4")), (200, 95));
}
