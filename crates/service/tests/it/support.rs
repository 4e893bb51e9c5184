//! A service started for a test, and a client that sends what it is told to, byte by byte.

use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_latchgate-serve");

static NEXT: AtomicU32 = AtomicU32::new(0);

/// Returns the folder of the project.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the bytes of a signal of the project.
pub(crate) fn signal(name: &str) -> Vec<u8> {
    fs::read(root().join("signals").join(name)).unwrap()
}

/// A folder that goes with the test.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new() -> Self {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("latchgate-service-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn data(&self) -> PathBuf {
        self.0.join("data")
    }

    /// Runs a command of the service on this folder.
    pub(crate) fn run(&self, arguments: &[&str]) -> (i32, String) {
        let output = Command::new(PROGRAM)
            .args(arguments)
            .arg("--data")
            .arg(self.data())
            .output()
            .unwrap();
        let text = [output.stdout, output.stderr].concat();
        (
            output.status.code().unwrap(),
            String::from_utf8(text).unwrap(),
        )
    }

    /// Makes a token.
    pub(crate) fn token(&self, name: &str, scopes: &str) -> String {
        let output = Command::new(PROGRAM)
            .args(["token", "create", name, "--scopes", scopes, "--data"])
            .arg(self.data())
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap().trim().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A service that runs.
pub(crate) struct Service {
    pub(crate) child: Child,
    pub(crate) address: String,
    pub(crate) log: PathBuf,
}

impl Service {
    pub(crate) fn start(folder: &Folder, settings: &[&str]) -> Self {
        let mut command = Command::new(PROGRAM);
        command.arg("--data").arg(folder.data());
        for setting in settings {
            command.args(["--set", setting]);
        }
        Self::of(command, folder)
    }

    /// Starts a command that serves, and waits until it says where.
    pub(crate) fn of(mut command: Command, folder: &Folder) -> Self {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let log = folder.0.join(format!("log-{number}"));
        let mut child = command
            .args(["--listen", "127.0.0.1:0"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(fs::File::create(&log).unwrap())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        let address = line
            .split("http://")
            .nth(1)
            .and_then(|rest| rest.split('/').next());
        let Some(address) = address else {
            let _ = child.wait();
            panic!(
                "it did not start: {line}{}",
                fs::read_to_string(&log).unwrap()
            );
        };
        Self {
            child,
            address: address.into(),
            log,
        }
    }

    pub(crate) fn client(&self) -> Client {
        Client {
            address: self.address.clone(),
            headers: Vec::new(),
        }
    }

    /// Sends a signal.
    pub(crate) fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args([name, &id]).status().unwrap();
        assert!(sent.success());
    }

    /// Ends it with SIGTERM and returns its exit code.
    pub(crate) fn end(mut self) -> i32 {
        self.signal("-TERM");
        let status = self.child.wait().unwrap();
        status.code().unwrap_or(-1)
    }

    /// Returns the processor time that it has used, without its children. Other than the time on a
    /// clock it does not grow while the machine does something else.
    pub(crate) fn processor_time(&self) -> Duration {
        let stat = fs::read_to_string(format!("/proc/{}/stat", self.child.id())).unwrap();
        // The name before the parenthesis may hold blanks; `utime` and `stime` are fields 14 and 15.
        let fields = stat
            .rsplit_once(") ")
            .unwrap()
            .1
            .split(' ')
            .skip(11)
            .take(2);
        let ticks: u64 = fields.map(|field| field.parse::<u64>().unwrap()).sum();
        // Linux counts 100 ticks a second for every program.
        Duration::from_millis(10 * ticks)
    }

    /// Returns the process ids of its children.
    pub(crate) fn children(&self) -> Vec<String> {
        let path = format!("/proc/{0}/task", self.child.id());
        let tasks = fs::read_dir(path).unwrap().flatten();
        let of_task = |task: fs::DirEntry| fs::read_to_string(task.path().join("children"));
        tasks
            .filter_map(|task| of_task(task).ok())
            .flat_map(|ids| ids.split_whitespace().map(String::from).collect::<Vec<_>>())
            .collect()
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The service's end of a connection, as the system sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ServedEnd {
    /// It is open, and the service has read all that was sent.
    Idle,
    /// It is open, and something that was sent has not been read.
    Unread,
    /// The service has closed it.
    Closed,
}

/// Looks at the service's end of a connection.
pub(crate) fn served_end(stream: &TcpStream) -> ServedEnd {
    const ESTABLISHED: &str = "01";
    let [client, server] = [stream.local_addr(), stream.peer_addr()].map(|address| {
        // A connection that was reset has no peer any more.
        address.ok().map(|address| endpoint(&address))
    });
    let (Some(client), Some(server)) = (client, server) else {
        return ServedEnd::Closed;
    };
    let table = fs::read_to_string("/proc/net/tcp").unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split_whitespace().collect())
        .collect();
    let end = |local: &str, remote: &str| {
        let is_meant = |row: &&Vec<&str>| row[1] == local && row[2] == remote;
        rows.iter().find(is_meant)
    };
    let (Some(sent), Some(received)) = (end(&client, &server), end(&server, &client)) else {
        return ServedEnd::Closed;
    };
    if received[3] != ESTABLISHED {
        return ServedEnd::Closed;
    }
    // Column 4 holds the bytes that wait to be sent and those that wait to be read.
    let waits = |row: &[&str], side: usize| row[4].split(':').nth(side).unwrap() != "00000000";
    if waits(sent, 0) || waits(received, 1) {
        ServedEnd::Unread
    } else {
        ServedEnd::Idle
    }
}

/// Spells an address as `/proc/net/tcp` does.
fn endpoint(address: &SocketAddr) -> String {
    let IpAddr::V4(ip) = address.ip() else {
        panic!("{address}: the tests use the loopback of IPv4")
    };
    format!(
        "{:08X}:{:04X}",
        u32::from_ne_bytes(ip.octets()),
        address.port()
    )
}

/// An answer.
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) headers: Vec<(String, String)>,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&self.body)))
    }

    pub(crate) fn text(&self) -> String {
        String::from_utf8(self.body.clone()).unwrap()
    }

    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        let found = self
            .headers
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|(_, value)| value.as_str())
    }

    #[track_caller]
    pub(crate) fn expect(self, status: u16) -> Self {
        let body = String::from_utf8_lossy(&self.body);
        assert_eq!(
            self.status,
            status,
            "{}",
            body.chars().take(600).collect::<String>()
        );
        self
    }
}

/// A client that opens a connection for each request.
#[derive(Debug, Clone)]
pub(crate) struct Client {
    pub(crate) address: String,
    pub(crate) headers: Vec<(String, String)>,
}

impl Client {
    pub(crate) fn with(mut self, name: &str, value: &str) -> Self {
        self.headers.push((name.into(), value.into()));
        self
    }

    pub(crate) fn bearer(self, token: &str) -> Self {
        self.with("Authorization", &format!("Bearer {token}"))
    }

    pub(crate) fn get(&self, path: &str) -> Answer {
        self.send("GET", path, &[])
    }

    pub(crate) fn send(&self, method: &str, path: &str, body: &[u8]) -> Answer {
        self.try_send(method, path, body)
            .unwrap_or_else(|error| panic!("{method} {path}: {error}"))
    }

    pub(crate) fn post(&self, path: &str, body: &Value) -> Answer {
        let client = self.clone().with("Content-Type", "application/json");
        client.send("POST", path, body.to_string().as_bytes())
    }

    pub(crate) fn try_send(
        &self,
        method: &str,
        path: &str,
        body: &[u8],
    ) -> std::io::Result<Answer> {
        let mut stream = TcpStream::connect(&self.address)?;
        stream.set_read_timeout(Some(HANG))?;
        let mut head = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        if !self.headers.iter().any(|(name, _)| name == "Host") {
            head += &format!("Host: {}\r\n", self.address);
        }
        for (name, value) in &self.headers {
            head += &format!("{name}: {value}\r\n");
        }
        head += &format!("Content-Length: {}\r\n\r\n", body.len());
        stream.write_all(head.as_bytes())?;
        // It may answer before it has read all.
        let _ = stream.write_all(body);
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        if answer.is_empty() {
            return Err(std::io::Error::other("nothing was answered"));
        }
        parse(&answer).ok_or_else(|| std::io::Error::other("the answer is cut"))
    }

    pub(crate) fn try_send_json(&self, path: &str, body: &Value) -> std::io::Result<Answer> {
        let client = self.clone().with("Content-Type", "application/json");
        client.try_send("POST", path, body.to_string().as_bytes())
    }

    /// Uploads a signal of the project without its card, if anybody answers.
    pub(crate) fn try_upload(&self, name: &str) -> std::io::Result<Value> {
        let answer = self.try_send(
            "POST",
            &format!("/v1/recordings?name={name}"),
            &signal(name),
        )?;
        serde_json::from_slice(&answer.body).map_err(std::io::Error::other)
    }

    /// Uploads a signal of the project with its card, as a browser's form does.
    pub(crate) fn upload(&self, name: &str) -> Value {
        let card = fs::read(root().join("signals").join(format!("{name}.toml"))).ok();
        self.upload_bytes(name, &signal(name), card.as_deref())
            .json()
    }

    pub(crate) fn upload_bytes(&self, name: &str, bytes: &[u8], card: Option<&[u8]>) -> Answer {
        let mut parts = vec![("file", name, bytes)];
        parts.extend(card.map(|card| ("card", "card.toml", card)));
        self.upload_form("", &parts)
    }

    /// Uploads parts of a form: role, name, bytes.
    pub(crate) fn upload_form(&self, query: &str, parts: &[(&str, &str, &[u8])]) -> Answer {
        let mut body = Vec::new();
        for (role, name, bytes) in parts {
            let head = format!(
                "--part\r\nContent-Disposition: form-data; name=\"{role}\"; filename=\"{name}\"\r\n\r\n"
            );
            body.extend_from_slice(head.as_bytes());
            body.extend_from_slice(bytes);
            body.extend_from_slice(b"\r\n");
        }
        body.extend_from_slice(b"--part--\r\n");
        let form = self
            .clone()
            .with("Content-Type", "multipart/form-data; boundary=part");
        form.send("POST", &format!("/v1/recordings{query}"), &body)
    }
}

/// Reads an answer; `None` where it is cut.
fn parse(bytes: &[u8]) -> Option<Answer> {
    let end = bytes.windows(4).position(|window| window == b"\r\n\r\n")?;
    let head = std::str::from_utf8(&bytes[..end]).ok()?;
    let mut lines = head.split("\r\n");
    let status = lines.next()?.split(' ').nth(1)?.parse().ok()?;
    let headers: Vec<(String, String)> = lines
        .filter_map(|line| line.split_once(": "))
        .map(|(name, value)| (name.to_lowercase(), value.to_string()))
        .collect();
    let find = |wanted: &str| headers.iter().find(|(name, _)| name == wanted);
    let mut body = bytes[end + 4..].to_vec();
    if let Some((_, length)) = find("content-length") {
        let length: usize = length.parse().ok()?;
        if body.len() < length {
            return None;
        }
        body.truncate(length);
    } else if find("transfer-encoding").is_some() {
        body = unchunked(&body)?;
    }
    Some(Answer {
        status,
        headers,
        body,
    })
}

fn unchunked(mut bytes: &[u8]) -> Option<Vec<u8>> {
    let mut body = Vec::new();
    loop {
        let end = bytes.windows(2).position(|window| window == b"\r\n")?;
        let length = usize::from_str_radix(std::str::from_utf8(&bytes[..end]).ok()?, 16).ok()?;
        bytes = &bytes[end + 2..];
        if length == 0 {
            return Some(body);
        }
        body.extend_from_slice(bytes.get(..length)?);
        bytes = bytes.get(length + 2..)?;
    }
}

/// Time after which a test counts as hanging. It bounds a hang and claims nothing about speed.
pub(crate) const HANG: Duration = Duration::from_secs(300);

/// Waits until something holds.
#[track_caller]
pub(crate) fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < HANG, "{what}: not after {HANG:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Lets the tokens and sessions that a service has in its memory become too old to be used: it
/// reads them again after a second. A sleep takes at least its time, on a busy machine as well.
pub(crate) fn let_the_tokens_age() {
    std::thread::sleep(Duration::from_millis(1100));
}

/// Returns a document without what may differ between two runs.
pub(crate) fn without_run(document: &[u8]) -> String {
    let text = std::str::from_utf8(document).unwrap();
    let (rest, _) = text
        .split_once("\n  \"run\": ")
        .expect("the run comes last");
    rest.to_string()
}
