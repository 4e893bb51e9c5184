//! Asks a service whether it answers, as whoever watches a container does.

use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpStream};
use std::time::Duration;

/// Time in which it must answer.
const TIME: Duration = Duration::from_secs(3);

/// Asks the service that listens at an address.
pub(super) fn ask(listen: SocketAddr) -> Result<String, String> {
    let mut address = listen;
    // One that listens at every address does so at the loopback's.
    address.set_ip(match listen.ip() {
        IpAddr::V4(Ipv4Addr::UNSPECIFIED) => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(Ipv6Addr::UNSPECIFIED) => Ipv6Addr::LOCALHOST.into(),
        stated => stated,
    });
    let answer = answer_of(address);
    let answer = answer.map_err(|error| format!("{address} does not answer: {error}"))?;
    if answer.starts_with("HTTP/1.1 200 ") {
        return Ok("it answers".into());
    }
    let first = answer.lines().next().unwrap_or("nothing");
    Err(format!("{address} does not answer as it should: {first}"))
}

fn answer_of(address: SocketAddr) -> io::Result<String> {
    let mut stream = TcpStream::connect_timeout(&address, TIME)?;
    stream.set_read_timeout(Some(TIME))?;
    stream.set_write_timeout(Some(TIME))?;
    stream.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")?;
    let mut answer = Vec::new();
    stream.take(4096).read_to_end(&mut answer)?;
    Ok(String::from_utf8_lossy(&answer).into_owned())
}
