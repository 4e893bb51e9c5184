//! Turns of owners: who was served longest ago comes next.

use std::collections::HashMap;

/// The number of the last turn of each owner.
#[derive(Debug, Default)]
pub struct Turns {
    count: u64,
    last: HashMap<String, u64>,
}

impl Turns {
    /// Returns the last turn of an owner; `None`, which comes before all, if there was none.
    pub fn last(&self, owner: &str) -> Option<u64> {
        self.last.get(owner).copied()
    }

    /// Gives an owner a turn.
    pub fn serve(&mut self, owner: &str) {
        self.count += 1;
        self.last.insert(owner.into(), self.count);
    }
}
