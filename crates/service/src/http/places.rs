//! Places for connections: so many in all and for each address, and a few more that are asked for
//! health alone.

use super::caller::network_of;
use std::collections::{BTreeMap, VecDeque};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::task::AbortHandle;

/// Connections beyond the places.
pub(crate) const SPARE: usize = 32;

/// Places that are taken, by address.
#[derive(Debug, Default)]
pub(super) struct Places(Arc<Mutex<BTreeMap<IpAddr, usize>>>);

impl Places {
    /// Takes a place unless `most` are taken, or `most_of_one` by this address.
    pub(super) fn take(&self, peer: IpAddr, most: usize, most_of_one: usize) -> Option<Place> {
        let address = network_of(peer);
        let mut taken = locked(&self.0);
        let of_all: usize = taken.values().sum();
        let own = taken.entry(address).or_default();
        if of_all >= most || *own >= most_of_one {
            let is_unknown = *own == 0;
            if is_unknown {
                taken.remove(&address);
            }
            return None;
        }
        *own += 1;
        Some(Place {
            taken: Arc::clone(&self.0),
            address,
        })
    }
}

/// A place, free again when it is dropped.
#[derive(Debug)]
pub(super) struct Place {
    taken: Arc<Mutex<BTreeMap<IpAddr, usize>>>,
    address: IpAddr,
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut taken = locked(&self.taken);
        if let Some(own) = taken.get_mut(&self.address) {
            *own -= 1;
            if *own == 0 {
                taken.remove(&self.address);
            }
        }
    }
}

/// Connections that found no place. Each new one ends the oldest, so that whoever asks at once is
/// answered however many others come and say nothing.
#[derive(Debug, Default)]
pub(super) struct Spare(VecDeque<AbortHandle>);

impl Spare {
    pub(super) fn push(&mut self, connection: AbortHandle) {
        self.0.push_back(connection);
        if self.0.len() > SPARE
            && let Some(oldest) = self.0.pop_front()
        {
            oldest.abort();
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
