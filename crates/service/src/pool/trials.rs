//! Trials of a child against its jail, which show an operator what is stopped.

use super::words::{Answer, Trial};
use rustix::process::{Resource, Rlimit, setrlimit};
use std::fs::File;
use std::net::{TcpStream, UdpSocket};
use std::process::Command;

/// Memory that a child tries to allocate [bytes].
const MEMORY: usize = 1 << 30;

/// Runs a trial; one that fails was stopped.
pub(super) fn attempt(trial: Trial) -> Answer {
    let outcome = match trial {
        Trial::OpenFile => File::open("/etc/hostname").map(|_| "a file was opened"),
        Trial::WriteFile => {
            let path = std::env::temp_dir().join(format!("latchgate-trial-{}", std::process::id()));
            let made = File::create(&path).map(|_| "a file was made");
            let _ = std::fs::remove_file(path);
            made
        }
        Trial::Connect => TcpStream::connect("127.0.0.1:9")
            .map(|_| "a connection was made")
            .or_else(
                // A refused connection has passed the jail.
                |error| match error.kind() {
                    std::io::ErrorKind::ConnectionRefused => Ok("a connection was tried"),
                    _ => Err(error),
                },
            ),
        Trial::SendDatagram => UdpSocket::bind("127.0.0.1:0")
            .and_then(|socket| socket.send_to(b"x", "127.0.0.1:9"))
            .map(|_| "a datagram was sent"),
        Trial::StartProgram => Command::new("/bin/true")
            .status()
            .map(|_| "a program was run"),
        Trial::SignalParent => match rustix::process::getppid() {
            Some(parent) => rustix::process::test_kill_process(parent)
                .map(|()| "a signal was sent")
                .map_err(Into::into),
            None => Err(std::io::Error::other("no parent is to be seen")),
        },
        Trial::TakeMemory => {
            let mut memory = vec![0_u8; MEMORY];
            for byte in memory.iter_mut().step_by(4096) {
                *byte = 1;
            }
            Ok(if std::hint::black_box(&memory).len() == MEMORY {
                "the memory was taken"
            } else {
                "nothing"
            })
        }
        Trial::RunMemory => memmap2::MmapMut::map_anon(4096)
            .and_then(memmap2::MmapMut::make_exec)
            .map(|_| "memory may be run"),
        Trial::RaiseMemory => {
            let none = Rlimit {
                current: None,
                maximum: None,
            };
            setrlimit(Resource::As, none)
                .map(|()| "the limit is gone")
                .map_err(Into::into)
        }
        Trial::TakeTime => {
            let mut count = 0_u64;
            loop {
                count = std::hint::black_box(count).wrapping_add(1);
            }
        }
    };
    match outcome {
        Ok(reached) => Answer::Tried {
            stopped: false,
            how: reached.into(),
        },
        Err(error) => Answer::Tried {
            stopped: true,
            how: error.to_string(),
        },
    }
}
