//! The listener for requests: an address with a port, or a socket in the file system.

use crate::config::Listen;
use std::fs::{self, Permissions};
use std::io;
use std::net::{IpAddr, Ipv4Addr};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::path::Path;
use tokio::net::{TcpListener, TcpStream, UnixListener, UnixStream};
use tokio_util::either::Either;

/// Time in which a client must acknowledge sent bytes [ms].
const SEND_MS: u32 = 60_000;

/// Mode of the socket, which the service's user and group may open.
const SOCKET_MODE: u32 = 0o660;

/// Size of the system's send buffer [bytes].
const HELD_BYTES: usize = 64 << 10;

/// A connection.
pub(super) type Connection = Either<TcpStream, UnixStream>;

/// A listener for requests.
#[derive(Debug)]
pub enum Listener {
    /// An address with a port.
    Tcp(TcpListener),
    /// A socket in the file system.
    Unix(UnixListener),
}

impl Listener {
    /// Listens; returns the address in words as well.
    ///
    /// # Errors
    ///
    /// What is in the way, in a sentence.
    pub async fn bind(listen: &Listen) -> Result<(Self, String), String> {
        let bind_error =
            |error: io::Error| format!("{listen}: {error}; choose another with --listen");
        match listen {
            Listen::Tcp(address) => {
                let listener = TcpListener::bind(address).await.map_err(bind_error)?;
                let address = listener.local_addr().map_err(bind_error)?;
                Ok((Self::Tcp(listener), format!("http://{address}/")))
            }
            Listen::Unix(path) => {
                remove_left(path).map_err(bind_error)?;
                let listener = UnixListener::bind(path).map_err(bind_error)?;
                fs::set_permissions(path, Permissions::from_mode(SOCKET_MODE))
                    .map_err(bind_error)?;
                Ok((Self::Unix(listener), listen.to_string()))
            }
        }
    }

    /// Waits for a connection; returns its peer's address, which a socket does not have.
    pub(super) async fn accept(&self) -> io::Result<(Connection, Option<IpAddr>)> {
        match self {
            Self::Tcp(listener) => {
                let (stream, peer) = listener.accept().await?;
                let _ = stream.set_nodelay(true);
                let _ = rustix::net::sockopt::set_tcp_user_timeout(&stream, SEND_MS);
                let _ = rustix::net::sockopt::set_socket_send_buffer_size(&stream, HELD_BYTES);
                Ok((Either::Left(stream), Some(peer.ip().to_canonical())))
            }
            Self::Unix(listener) => {
                let (stream, _) = listener.accept().await?;
                let _ = rustix::net::sockopt::set_socket_send_buffer_size(&stream, HELD_BYTES);
                Ok((Either::Right(stream), None))
            }
        }
    }
}

/// Address in place of a socket's peer.
pub(super) const NO_ADDRESS: IpAddr = IpAddr::V4(Ipv4Addr::UNSPECIFIED);

/// Removes the socket of a service that has ended; one with a listener stays.
fn remove_left(path: &Path) -> io::Result<()> {
    let is_socket = fs::symlink_metadata(path).is_ok_and(|about| about.file_type().is_socket());
    if is_socket && std::os::unix::net::UnixStream::connect(path).is_err() {
        fs::remove_file(path)?;
    }
    Ok(())
}
