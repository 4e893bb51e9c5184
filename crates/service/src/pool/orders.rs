//! Orders of waiting people, taken in turn by owner.

use crate::turns::Turns;
use std::collections::{HashMap, VecDeque};

/// Number of times in a row that a place may pass over an order for one whose recording its child holds.
const HELD_FIRST: u32 = 4;

/// Orders that wait, and the number of those at work by owner.
#[derive(Debug)]
pub struct Orders<T> {
    waiting: VecDeque<Waiting<T>>,
    at_work: HashMap<String, usize>,
    turns: Turns,
    own_places: usize,
}

#[derive(Debug)]
struct Waiting<T> {
    owner: String,
    recording: Option<String>,
    order: T,
}

/// Number of times in a row that a place passed over an order.
#[derive(Debug, Default)]
pub struct HeldFirst(u32);

impl<T> Orders<T> {
    /// Returns no orders. `places` is the number of places that take orders. An owner has one less at a time, where
    /// there are several: then the next owner finds one free, however long the others' orders take.
    pub fn new(places: usize) -> Self {
        Self {
            waiting: VecDeque::new(),
            at_work: HashMap::new(),
            turns: Turns::default(),
            own_places: places.saturating_sub(1).max(1),
        }
    }

    /// Returns the number of waiting orders of each owner.
    pub fn waiting(&self) -> HashMap<&str, u64> {
        let mut counts = HashMap::new();
        for waiting in &self.waiting {
            *counts.entry(waiting.owner.as_str()).or_default() += 1;
        }
        counts
    }

    /// Returns true if none waits or is at work.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty() && self.at_work.is_empty()
    }

    /// Adds an order, with the recording that it needs.
    pub fn push(&mut self, owner: &str, recording: Option<&str>, order: T) {
        self.waiting.push_back(Waiting {
            owner: owner.into(),
            recording: recording.map(String::from),
            order,
        });
    }

    /// Takes the next order and its owner: of the owner who was served longest ago, the oldest order, or a few times
    /// in a row the oldest whose recording the place's child holds, since it needs no transfer.
    pub fn take(
        &mut self,
        holds: impl Fn(&str) -> bool,
        held_first: &mut HeldFirst,
    ) -> Option<(String, T)> {
        let has_place = |owner: &str| {
            let at_work = self.at_work.get(owner).copied();
            at_work.unwrap_or(0) < self.own_places
        };
        let owners = self.waiting.iter().map(|waiting| waiting.owner.as_str());
        let owner = owners
            .filter(|owner| has_place(owner))
            .min_by_key(|owner| self.turns.last(owner))?
            .to_string();
        let own = |waiting: &Waiting<T>| waiting.owner == owner;
        let is_held = |waiting: &Waiting<T>| waiting.recording.as_deref().is_some_and(&holds);
        let oldest = self.waiting.iter().position(own)?;
        let held = self
            .waiting
            .iter()
            .position(|waiting| own(waiting) && is_held(waiting));
        let index = held.filter(|_| held_first.0 < HELD_FIRST).unwrap_or(oldest);
        held_first.0 = if index == oldest { 0 } else { held_first.0 + 1 };
        let waiting = self.waiting.remove(index)?;
        self.turns.serve(&owner);
        *self.at_work.entry(owner.clone()).or_default() += 1;
        Some((owner, waiting.order))
    }

    /// Says that an order of an owner was carried out.
    pub fn done(&mut self, owner: &str) {
        if let Some(count) = self.at_work.get_mut(owner) {
            *count -= 1;
            if *count == 0 {
                self.at_work.remove(owner);
            }
        }
    }

    /// Removes orders, for instance those of clients that have gone.
    pub fn retain(&mut self, keep: impl Fn(&T) -> bool) {
        self.waiting.retain(|waiting| keep(&waiting.order));
    }
}
