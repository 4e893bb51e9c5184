//! Origin of a request: the address of its connection, and the one that a trusted proxy reports.

use super::listener::NO_ADDRESS;
use axum::http::HeaderMap;
use std::fmt;
use std::net::{IpAddr, Ipv6Addr};

/// The connection of a request.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peer {
    /// Its other end; of a socket none.
    pub(super) address: IpAddr,
    /// True for a socket and for a proxy of the configuration, whose headers on the client are trusted.
    pub(super) is_proxy: bool,
    /// True if the connection has no place, and is answered on health alone.
    pub(super) is_spare: bool,
}

/// Origin of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Caller {
    /// The other end of the connection.
    pub(crate) peer: IpAddr,
    /// Client of a trusted proxy.
    pub(crate) client: Option<IpAddr>,
}

impl Caller {
    /// Returns the origin of a request. The last address in `x-forwarded-for` that is no proxy's counts, if the peer
    /// is a trusted proxy.
    pub(super) fn of(peer: Peer, headers: &HeaderMap, proxies: &[IpAddr]) -> Self {
        let values = headers.get_all("x-forwarded-for").iter();
        let values = values.filter_map(|value| value.to_str().ok());
        let addresses = values.flat_map(|value| value.split(',')).map(str::trim);
        let mut addresses: Vec<IpAddr> = addresses.filter_map(|text| text.parse().ok()).collect();
        addresses.retain(|address| !proxies.contains(&address.to_canonical()));
        let last = addresses.last().map(IpAddr::to_canonical);
        Self {
            peer: peer.address,
            client: last.filter(|_| peer.is_proxy),
        }
    }

    /// Returns the network of the origin, as [`network_of`].
    pub(super) fn network(self) -> IpAddr {
        network_of(self.client.unwrap_or(self.peer))
    }
}

/// Returns an address; of IPv6 its first 64 bits, since one client has all addresses below them.
pub(super) fn network_of(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let bits = u128::from(address) & !u128::from(u64::MAX);
            IpAddr::V6(Ipv6Addr::from(bits))
        }
        address => address,
    }
}

impl fmt::Display for Caller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.client {
            None if self.peer == NO_ADDRESS => f.write_str("the socket"),
            None => self.peer.fmt(f),
            Some(client) if self.peer == NO_ADDRESS => write!(f, "{client} by the socket"),
            Some(client) => write!(f, "{client} by {}", self.peer),
        }
    }
}
