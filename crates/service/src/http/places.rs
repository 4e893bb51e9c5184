//! Places for connections, limited in total and by address, and a few spare connections that are answered on
//! health alone.

use super::caller::network_of;
use std::collections::{BTreeMap, VecDeque};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::task::AbortHandle;

/// Number of connections without a place: where hundreds of clients of one address connect again and again, each stays
/// long enough to be answered.
pub(crate) const SPARE: usize = 256;

/// Number of places in use, by address.
#[derive(Debug, Default)]
pub(super) struct Places(Arc<Mutex<BTreeMap<IpAddr, usize>>>);

impl Places {
    /// Takes a place unless `places_max` are taken, or `address_max` by this address.
    pub(super) fn take(
        &self,
        peer: IpAddr,
        places_max: usize,
        address_max: usize,
    ) -> Option<Place> {
        let address = network_of(peer);
        let mut by_address = locked(&self.0);
        let total: usize = by_address.values().sum();
        let count = by_address.entry(address).or_default();
        if total >= places_max || *count >= address_max {
            let is_unknown = *count == 0;
            if is_unknown {
                by_address.remove(&address);
            }
            return None;
        }
        *count += 1;
        Some(Place {
            by_address: Arc::clone(&self.0),
            address,
        })
    }
}

/// A place, free again when it is dropped.
#[derive(Debug)]
pub(super) struct Place {
    by_address: Arc<Mutex<BTreeMap<IpAddr, usize>>>,
    address: IpAddr,
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut by_address = locked(&self.by_address);
        if let Some(count) = by_address.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                by_address.remove(&self.address);
            }
        }
    }
}

/// Connections without a place. Each new one ends the oldest, so that a client that asks at once is answered,
/// however many silent ones connect.
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
