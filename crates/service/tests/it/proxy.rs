//! Users whom a proxy names, and the proxy of `nginx.conf` before the service.

use crate::support::{Folder, HANG, PROGRAM, Service, root, signal, wait_for};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

const HEADER: &str = "X-Forwarded-User";

/// A user is taken from a proxy that the configuration names, may do what the configuration says, and
/// is refused from elsewhere, beside a token, and where the name is none.
#[test]
fn cli_a_proxy_names_users_and_nobody_else_does() {
    let folder = Folder::new();
    let token = folder.token("lab", "read");
    let settings = [
        "user_header=x-forwarded-user",
        "user_scopes=read",
        "proxies=127.0.0.1",
    ];
    let service = Service::start(&folder, &settings);
    let ada = service.client().with(HEADER, "ada@example.com");
    for place in ["/login", "/", "/recordings"] {
        let page = ada.get(place).expect(200).text();
        assert!(
            page.contains("Signed in as <strong>ada@example.com"),
            "{page}"
        );
        assert!(!page.contains("No sign-in"), "{page}");
    }
    ada.get("/v1/verdicts").expect(200);
    ada.send("POST", "/v1/gates", b"").expect(403);
    let problem = ada
        .clone()
        .bearer(&token)
        .get("/v1/verdicts")
        .expect(401)
        .json();
    assert!(
        problem["detail"]
            .as_str()
            .unwrap()
            .contains("beside a token"),
        "{problem}"
    );
    ada.clone()
        .with(HEADER, "bob")
        .get("/v1/verdicts")
        .expect(401);
    for name in ["", " ", "#1", &"n".repeat(201)] {
        service
            .client()
            .with(HEADER, name)
            .get("/v1/verdicts")
            .expect(401);
    }
    // Nobody is let in without a name or a token.
    service.client().get("/v1/verdicts").expect(401);
    service
        .client()
        .bearer(&token)
        .get("/v1/verdicts")
        .expect(200);
    let log = fs::read_to_string(&service.log).unwrap();
    assert!(
        log.contains(r#""visitor":"ada@example.com@proxy""#),
        "{log}"
    );
    drop(service);
    // From elsewhere: the same header is believed of nobody, with a token neither.
    for settings in [
        &settings[..2],
        &["user_header=x-forwarded-user", "proxies=127.0.0.9"],
    ] {
        let service = Service::start(&folder, settings);
        let ada = service.client().with(HEADER, "ada@example.com");
        ada.get("/v1/verdicts").expect(401);
        ada.get("/").expect(401);
        ada.bearer(&token).get("/v1/verdicts").expect(401);
        service
            .client()
            .bearer(&token)
            .get("/v1/verdicts")
            .expect(200);
    }
    // Without the setting the header says nothing.
    let service = Service::start(&folder, &["proxies=127.0.0.1"]);
    let ada = service.client().with(HEADER, "ada@example.com");
    ada.get("/v1/verdicts").expect(401);
}

/// A user whom a proxy names and a token's holder of the same name are two owners.
#[test]
fn verif_a_user_of_a_proxy_is_no_holder_of_a_token() {
    let folder = Folder::new();
    let token = folder.token("ada", "read,submit");
    let (code, said) = folder.run(&["token", "create", "ada@proxy", "--scopes", "read"]);
    assert_ne!(code, 0, "{said}");
    let settings = [
        "user_header=x-forwarded-user",
        "user_scopes=read,submit",
        "proxies=127.0.0.1",
    ];
    let service = Service::start(&folder, &settings);
    let user = service.client().with(HEADER, "ada");
    let holder = service.client().bearer(&token);
    let owner = |recording: &serde_json::Value| recording["owner"].as_str().unwrap().to_string();
    assert_eq!(owner(&holder.upload("burst.csv")), "ada");
    assert_eq!(owner(&user.upload("sled_30g_30ms.csv")), "ada@proxy");
}

/// Before the first token the machine's own programs are let in, and nobody who may come through a proxy: one that
/// says for whom it asks, passes on the name it was asked for, or speaks as nginx does unless told otherwise.
#[test]
fn regress_a_proxy_opens_nothing_before_the_first_token() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let recording = format!("/v1/recordings/{}", id.as_str().unwrap());
    for (name, value) in [
        ("X-Forwarded-For", "198.51.100.4"),
        ("X-Forwarded-For", "127.0.0.1"),
        ("x-forwarded-proto", "https"),
        ("X-FORWARDED-USER", "ada"),
        ("Forwarded", "for=198.51.100.4"),
        ("Via", "1.1 edge"),
        ("X-Real-IP", "198.51.100.4"),
        ("Host", "latch.example.com"),
        ("Host", "localhost.example.com:8420"),
    ] {
        let through = client.clone().with(name, value);
        for (method, path) in [
            ("GET", "/v1/recordings"),
            ("GET", "/metrics"),
            ("POST", "/v1/recordings?name=a.csv"),
            ("POST", "/v1/designs"),
            ("DELETE", recording.as_str()),
        ] {
            let answer = through.send(method, path, b"t_s,a_g\n0,1\n").expect(401);
            assert!(answer.text().contains("token create"), "{}", answer.text());
        }
        let page = through.with("Accept", "text/html").get("/").expect(303);
        assert_eq!(page.header("location"), Some("/login"));
    }
    let mut stream = TcpStream::connect(&service.address).unwrap();
    stream.set_read_timeout(Some(HANG)).unwrap();
    let old = format!(
        "GET /v1/recordings HTTP/1.0\r\nHost: {}\r\n\r\n",
        service.address
    );
    stream.write_all(old.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.contains(" 401 "), "{answer}");
    client
        .clone()
        .with("Host", "LocalHost")
        .get(&recording)
        .expect(200);
    // The other settings of a proxy start nothing before a token exists.
    drop(service);
    let folder = Folder::new();
    let (code, text) = folder.run(&["--listen", "127.0.0.1:0", "--set", "proxies=127.0.0.1"]);
    assert_eq!(code, 4, "{text}");
    assert!(text.contains("token create"), "{text}");
    folder.token("lab", "read");
    drop(Service::start(&folder, &["proxies=127.0.0.1"]));
}

/// Asks over a socket; returns the answer.
fn asked(socket: &Path, head: &str) -> String {
    let mut stream = UnixStream::connect(socket).unwrap();
    stream.set_read_timeout(Some(HANG)).unwrap();
    let request = format!("{head}\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

struct Ends(Child);

impl Drop for Ends {
    fn drop(&mut self) {
        if matches!(self.0.try_wait(), Ok(None)) {
            let _ = Command::new("kill").arg(self.0.id().to_string()).status();
        }
        let _ = self.0.wait();
    }
}

/// Starts a service at a socket.
fn at_socket(folder: &Folder, socket: &Path, settings: &[&str]) -> Ends {
    let mut command = Command::new(PROGRAM);
    command.arg("--data").arg(folder.data());
    command
        .arg("--listen")
        .arg(format!("unix:{}", socket.display()));
    for setting in settings {
        command.args(["--set", setting]);
    }
    let child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let service = Ends(child);
    wait_for("the socket is there", || {
        UnixStream::connect(socket).is_ok()
    });
    service
}

/// A socket takes users and tokens; one that an ended service left is taken over, and one at which
/// somebody listens is not.
#[test]
fn cli_a_socket_is_served() {
    let folder = Folder::new();
    let socket = folder.0.join("socket");
    let listen = format!("unix:{}", socket.display());
    let (code, text) = folder.run(&["--listen", &listen]);
    assert_eq!(code, 4, "{text}");
    assert!(text.contains("user_header"), "{text}");
    let settings = ["user_header=x-forwarded-user"];
    let mut service = at_socket(&folder, &socket, &settings);
    let answer = asked(
        &socket,
        "GET /v1/verdicts HTTP/1.1\r\nX-Forwarded-User: ada",
    );
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    let answer = asked(&socket, "GET /v1/verdicts HTTP/1.1");
    assert!(answer.starts_with("HTTP/1.1 401"), "{answer}");
    assert_eq!(folder.run(&["health", "--listen", &listen]).0, 0);
    let second = Folder::new();
    let (code, text) = second.run(&["--listen", &listen, "--set", settings[0]]);
    assert_eq!(code, 4, "{text}");
    assert!(text.contains("in use"), "{text}");
    // Killed, it leaves its socket.
    service.0.kill().unwrap();
    service.0.wait().unwrap();
    assert!(socket.exists());
    assert_eq!(folder.run(&["health", "--listen", &listen]).0, 4);
    let _again = at_socket(&folder, &socket, &settings);
    let answer = asked(&socket, "GET /readyz HTTP/1.1");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

fn run(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(output.status.success(), "{program}: {text}");
    text
}

/// `nginx.conf` as it stands, but for the places of its files and its port: who signs in at nginx is
/// known here, what a client sends under the header's name is not, and every answer forbids browsers
/// to come without TLS.
#[test]
fn cli_the_sample_of_a_proxy_works() {
    let folder = Folder::new();
    let own = |name: &str| folder.0.join(name).display().to_string();
    let (key, certificate) = (own("key.pem"), own("certificate.pem"));
    run(
        "openssl",
        &[
            "req",
            "-x509",
            "-newkey",
            "rsa:2048",
            "-nodes",
            "-days",
            "2",
            "-subj",
            "/CN=latch.example.com",
            "-keyout",
            &key,
            "-out",
            &certificate,
        ],
    );
    let password = run("openssl", &["passwd", "-apr1", "secret"]);
    fs::write(folder.0.join("users"), format!("ada:{password}")).unwrap();
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = free.local_addr().unwrap().port();
    let other = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let programs = other.local_addr().unwrap().port();
    drop((free, other));
    let token = folder.token("prometheus", "admin");
    let sample = fs::read_to_string(root().join("crates/service/nginx.conf")).unwrap();
    let socket = folder.0.join("socket");
    let mut text = sample.clone();
    for (from, to) in [
        ("listen 443 ssl", format!("listen 127.0.0.1:{port} ssl")),
        (
            "listen 8443 ssl",
            format!("listen 127.0.0.1:{programs} ssl"),
        ),
        (
            "unix:/run/latchgate/socket:",
            format!("unix:{}:", socket.display()),
        ),
        ("users;", format!("{};", own("users"))),
        ("certificate.pem", certificate.clone()),
        ("key.pem", key.clone()),
        ("nginx.pid", own("nginx.pid")),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, &to, if from == "users;" { 1 } else { 9 });
    }
    fs::write(folder.0.join("nginx.conf"), text).unwrap();
    let settings = ["user_header=x-forwarded-user"];
    let _service = at_socket(&folder, &socket, &settings);
    // Its workers are nobody's; the test's folder is their owner's alone.
    let nginx = Command::new("nginx")
        .args([
            "-e",
            "stderr",
            "-g",
            "daemon off; user root;",
            "-p",
            &own(""),
            "-c",
            &own("nginx.conf"),
        ])
        .stderr(fs::File::create(folder.0.join("nginx.log")).unwrap())
        .spawn()
        .unwrap();
    let _nginx = Ends(nginx);
    wait_for("nginx listens", || {
        TcpStream::connect(("127.0.0.1", port)).is_ok()
    });
    let ask = |port: u16, arguments: &[&str], path: &str| {
        let url = format!("https://latch.example.com:{port}{path}");
        let place = format!("latch.example.com:{port}:127.0.0.1");
        let mut all = vec![
            "-s",
            "-i",
            "--cacert",
            certificate.as_str(),
            "--resolve",
            &place,
        ];
        all.extend(arguments);
        all.push(&url);
        run("curl", &all)
    };
    let curl = |arguments: &[&str], path: &str| ask(port, arguments, path);
    let stranger = curl(&["-H", "X-Forwarded-User: ada"], "/v1/verdicts");
    assert!(stranger.contains(" 401 "), "{stranger}");
    assert!(
        stranger.contains("Strict-Transport-Security: max-age=31536000"),
        "{stranger}"
    );
    let named = curl(
        &["-u", "ada:secret", "-H", "X-Forwarded-User: mallory"],
        "/login",
    );
    assert!(
        named.contains(" 200 ") && named.contains("ada") && !named.contains("mallory"),
        "{named}"
    );
    assert!(named.contains("Strict-Transport-Security"), "{named}");
    let burst = folder.0.join("burst.csv");
    fs::write(&burst, signal("burst.csv")).unwrap();
    let file = format!("@{}", burst.display());
    let upload = curl(
        &["-u", "ada:secret", "--data-binary", &file],
        "/v1/recordings?name=burst.csv",
    );
    assert!(
        upload.contains(" 201 ") && upload.contains(r#""owner":"ada@proxy""#),
        "{upload}"
    );
    // A browser's change, whose page lies at another port than that of TLS.
    let origin = format!("Origin: https://latch.example.com:{port}");
    let change = curl(
        &[
            "-u",
            "ada:secret",
            "-H",
            &origin,
            "-H",
            "Content-Type: application/json",
            "-d",
            "{\"name\": \"d\"}",
        ],
        "/v1/designs",
    );
    assert!(change.contains(" 201 "), "{change}");
    // Programs come by their token, and are named by nobody.
    let bearer = format!("Authorization: Bearer {token}");
    let figures = ask(programs, &["-H", &bearer], "/metrics");
    assert!(
        figures.contains(" 200 ") && figures.contains("latchgate_build_info"),
        "{figures}"
    );
    let stranger = ask(programs, &["-H", "X-Forwarded-User: ada"], "/v1/verdicts");
    assert!(stranger.contains(" 401 "), "{stranger}");
}
