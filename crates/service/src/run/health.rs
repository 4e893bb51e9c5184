//! Asks a service whether it answers, for the health check of a container.

use crate::config::Listen;
use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, TcpStream};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// Longest time of the answer.
const TIME: Duration = Duration::from_secs(3);

/// Asks the service that listens at a place.
pub(super) fn ask(listen: &Listen) -> Result<String, String> {
    let answer = answer_of(listen);
    let answer = answer.map_err(|error| format!("{listen} does not answer: {error}"))?;
    if answer.starts_with("HTTP/1.1 200 ") {
        return Ok("it answers".into());
    }
    let first = answer.lines().next().unwrap_or("nothing");
    Err(format!("{listen} does not answer as it should: {first}"))
}

fn answer_of(listen: &Listen) -> io::Result<String> {
    match listen {
        Listen::Tcp(listen) => {
            let mut address = *listen;
            // A service that listens on all addresses answers on the loopback.
            address.set_ip(match listen.ip() {
                IpAddr::V4(Ipv4Addr::UNSPECIFIED) => Ipv4Addr::LOCALHOST.into(),
                IpAddr::V6(Ipv6Addr::UNSPECIFIED) => Ipv6Addr::LOCALHOST.into(),
                stated => stated,
            });
            let stream = TcpStream::connect_timeout(&address, TIME)?;
            stream.set_read_timeout(Some(TIME))?;
            stream.set_write_timeout(Some(TIME))?;
            answer_by(stream)
        }
        Listen::Unix(path) => {
            let stream = UnixStream::connect(path)?;
            stream.set_read_timeout(Some(TIME))?;
            stream.set_write_timeout(Some(TIME))?;
            answer_by(stream)
        }
    }
}

fn answer_by(mut stream: impl Read + Write) -> io::Result<String> {
    stream.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")?;
    let mut answer = Vec::new();
    stream.take(4096).read_to_end(&mut answer)?;
    Ok(String::from_utf8_lossy(&answer).into_owned())
}
