//! What tests through the process share: the program and its answers; with what the
//! tests of all crates share.

mod program;

pub(crate) use latchgate_test_support::*;
pub(crate) use program::{Done, advised, fed, finish, latchgate, program, without_run};

/// Names the channel of [`table`] by the code of a sensor at the door: a pass on it waits for no word on the place.
pub(crate) fn at_door(table: &str) -> String {
    table.replacen("acc_y_g", "11DOORLE0000ACYA (g)", 1)
}
