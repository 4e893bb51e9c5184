//! What strangers can take from others: no connection for long, and no allowance but their own.

use crate::support::{
    Client, Folder, HANG, ServedEnd, Service, let_the_tokens_age, served_end, wait_for,
};
use latchgate_service::allowances::Allowances;
use latchgate_service::supply::Supply;
use rustix::net::{AddressFamily, SocketType, sockopt};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpStream};
use std::time::{Duration, Instant};

/// Connects from an address of the loopback.
fn connect_from(service: &Service, last: u8) -> TcpStream {
    let socket = rustix::net::socket(AddressFamily::INET, SocketType::STREAM, None).unwrap();
    // What is sent shall wait at the other end.
    sockopt::set_socket_recv_buffer_size(&socket, 16 << 10).unwrap();
    let from = SocketAddrV4::new(Ipv4Addr::new(127, 0, 0, last), 0);
    rustix::net::bind(&socket, &from).unwrap();
    let to: SocketAddr = service.address.parse().unwrap();
    rustix::net::connect(&socket, &to).unwrap();
    let stream = TcpStream::from(socket);
    stream.set_read_timeout(Some(HANG)).unwrap();
    stream
}

/// Asks once from an address, with further lines of the head; returns the status and the answer.
fn get_from(service: &Service, last: u8, path: &str, lines: &str) -> (u16, String) {
    let mut stream = connect_from(service, last);
    let host = &service.address;
    let head = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{lines}\r\n");
    stream.write_all(head.as_bytes()).unwrap();
    let mut answer = Vec::new();
    // What is refused at once may be cut when the rest of the request comes.
    let _ = stream.read_to_end(&mut answer);
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let status = answer.split(' ').nth(1).and_then(|word| word.parse().ok());
    (status.unwrap_or(0), answer)
}

/// Opens connections that send half a head and no more.
fn idle(service: &Service, last: u8, count: usize) -> Vec<TcpStream> {
    let idle = (0..count).map(|_| {
        let mut stream = connect_from(service, last);
        let _ = stream.write_all(b"GET /healthz HTTP/1.1\r\n");
        stream
    });
    idle.collect()
}

/// With this a connection with half a head is held as long as a test lasts.
const HELD: &str = "header_s=3600";

/// One address takes the places of no other; beyond its own it is told so. A named proxy may have all.
#[test]
fn verif_an_address_has_its_places() {
    let folder = Folder::new();
    let settings = [
        "connections=64",
        "address_connections=8",
        "proxies=127.0.0.3",
        HELD,
    ];
    let token = format!("Authorization: Bearer {}\r\n", folder.token("lab", "read"));
    let service = Service::start(&folder, &settings);
    let taken = idle(&service, 1, 8);
    wait_for("they are taken", || {
        get_from(&service, 1, "/v1/limits", &token).0 == 503
    });
    let (_, answer) = get_from(&service, 1, "/v1/limits", &token);
    let says = "limit connections of 64 crossed: found as many, or 8 of this address";
    assert!(answer.contains(says), "{answer}");
    assert_eq!(get_from(&service, 2, "/v1/limits", &token).0, 200);
    assert_eq!(get_from(&service, 1, "/healthz", "").0, 200);
    let of_proxy = idle(&service, 3, 20);
    assert_eq!(get_from(&service, 3, "/v1/limits", &token).0, 200);
    drop((taken, of_proxy));
    wait_for("they are free again", || {
        get_from(&service, 1, "/v1/limits", &token).0 == 200
    });
}

/// However many hold connections and say nothing, whoever watches the service is answered.
#[test]
fn verif_health_is_answered_where_no_place_is_left() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["connections=8", "address_connections=8", HELD]);
    let _taken = idle(&service, 1, 300);
    for _ in 0..20 {
        for path in ["/healthz", "/readyz"] {
            let (status, answer) = get_from(&service, 1, path, "");
            assert_eq!(status, 200, "{path}: {answer}");
        }
        let (status, answer) = get_from(&service, 2, "/v1/limits", "");
        assert_eq!(status, 503, "{answer}");
    }
}

/// A body that comes drop by drop loses its place; a sign-in is short.
#[test]
fn verif_a_body_has_its_time_and_its_size() {
    let folder = Folder::new();
    let token = folder.token("lab", "read,submit");
    let service = Service::start(&folder, &["question_s=2"]);
    for (path, line) in [
        ("/login", String::new()),
        ("/v1/verdicts", format!("Authorization: bearer {token}\r\n")),
    ] {
        let mut stream = connect_from(&service, 1);
        let host = &service.address;
        let head =
            format!("POST {path} HTTP/1.1\r\nHost: {host}\r\n{line}Content-Length: 4000\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        let began = Instant::now();
        // At this pace the body would take a quarter of an hour.
        while stream.write_all(b" ").is_ok() {
            std::thread::sleep(Duration::from_millis(200));
            assert!(began.elapsed() < HANG, "{path}");
        }
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let late = format!("\"path\":\"{path}\",\"status\":408");
        wait_for("the log says that it was late", || {
            let log = std::fs::read_to_string(&service.log).unwrap();
            log.contains(&late)
        });
    }
    let form = service.client();
    let form = form.with("Content-Type", "application/x-www-form-urlencoded");
    let refused = form.send("POST", "/login", &[b'x'; 5000]).expect(413);
    assert!(refused.text().contains("login_bytes"), "{}", refused.text());
    form.send("POST", "/login", &[b'x'; 4000]).expect(401);
}

/// Clients that state a body and send none, or a part of one, keep nobody's question from its answer; a sign-out is
/// short.
#[test]
fn verif_a_body_that_does_not_come_delays_nobody() {
    let folder = Folder::new();
    let token = folder.token("lab", "read,submit");
    let service = Service::start(&folder, &["question_s=120", "address_connections=300"]);
    let host = &service.address;
    let known = format!("Authorization: bearer {token}\r\n");
    let begin = |(path, line, bytes, sent): (&str, &str, usize, usize)| {
        let mut stream = connect_from(&service, 1);
        let head = format!(
            "POST {path} HTTP/1.1\r\nHost: {host}\r\n{line}Content-Length: {bytes}\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(&vec![b' '; sent]).unwrap();
        stream
    };
    let silent = ("/v1/verdicts", known.as_str(), 1 << 20, 0);
    let begun = ("/v1/gates", known.as_str(), 1 << 20, 1 << 10);
    let stranger = ("/login", "", 4000, 1);
    let streams: Vec<TcpStream> = [silent, begun, stranger]
        .into_iter()
        .flat_map(|request| (0..80).map(move |_| request))
        .map(begin)
        .collect();
    wait_for("they are under way", || {
        streams
            .iter()
            .all(|stream| served_end(stream) == ServedEnd::Idle)
    });
    let question = json!({"recording": "none"});
    let client = service.client().bearer(&token);
    client.post("/v1/verdicts", &question).expect(404);
    let form = ("Content-Type", "application/x-www-form-urlencoded");
    let stranger = service.client().with(form.0, form.1);
    stranger.send("POST", "/login", b"token=no").expect(401);
    let is_held = |stream: &TcpStream| served_end(stream) == ServedEnd::Idle;
    assert!(streams.iter().all(is_held), "they were let go of first");
    let refused = service.client().send("POST", "/logout", &[b'x'; 65]);
    let refused = refused.expect(413);
    assert!(refused.text().contains("logout_bytes"));
    service.client().send("POST", "/logout", b"").expect(303);
}

/// However many owners take what they can of a supply, the next one finds some.
#[test]
fn verif_a_supply_has_some_for_the_next() {
    let supply = Supply::new(1 << 20);
    let mut parts = Vec::new();
    for owners in 1..20 {
        let mut held = supply.open(&owners.to_string());
        assert!(held.grow(1), "{owners} owners");
        while held.grow(1) {}
        parts.push(held);
        if owners == 1 {
            let mut again = supply.open("1");
            assert!(
                !again.grow(1),
                "an owner has one share, in however many parts"
            );
        }
    }
    drop(parts);
    assert!(supply.open("1").grow(1 << 19), "all is free again");
}

/// Reads so many bytes every 100 ms until something holds or nothing more comes; returns how many came.
#[track_caller]
fn read_slowly(stream: &mut TcpStream, bytes: usize, holds: impl Fn(&TcpStream) -> bool) -> usize {
    let began = Instant::now();
    let mut piece = vec![0; bytes];
    let mut taken = 0;
    while !holds(stream) {
        assert!(began.elapsed() < HANG, "{taken} bytes were taken");
        match stream.read(&mut piece) {
            Ok(0) | Err(_) => break,
            Ok(count) => taken += count,
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    taken
}

/// An answer that is taken drop by drop loses its place, one that is taken slowly does not.
#[test]
fn verif_an_answer_is_taken_at_a_least_pace() {
    const REQUESTS: usize = 60;
    // Longer than a write may wait, which is 20 s.
    const SLOWLY: Duration = Duration::from_secs(25);
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let one = service.client().get("/openapi.json").expect(200).body.len();
    let ask = || {
        let mut stream = connect_from(&service, 1);
        let host = &service.address;
        let request = format!("GET /openapi.json HTTP/1.1\r\nHost: {host}\r\n\r\n");
        let last =
            format!("GET /openapi.json HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        let requests = request.repeat(REQUESTS - 1) + &last;
        stream.write_all(requests.as_bytes()).unwrap();
        stream
    };
    let (mut dripping, mut slow) = (ask(), ask());
    let began = Instant::now();
    let slow = std::thread::spawn(move || {
        // 40 KiB/s is twenty times the least pace: a machine may do much else meanwhile.
        let taken = read_slowly(&mut slow, 4 << 10, |_| began.elapsed() > SLOWLY);
        let mut rest = Vec::new();
        let _ = slow.read_to_end(&mut rest);
        taken + rest.len()
    });
    let is_closed = |stream: &TcpStream| served_end(stream) == ServedEnd::Closed;
    let taken = read_slowly(&mut dripping, 1, is_closed);
    let mut rest = Vec::new();
    let _ = dripping.read_to_end(&mut rest);
    let (drops, slow) = (taken + rest.len(), slow.join().unwrap());
    let all = one * REQUESTS;
    assert!(drops < all / 2, "{drops} of {all} bytes came");
    assert!(slow >= all, "{slow} of {all} bytes came");
}

/// Sends so many requests over one connection and reads every answer.
fn get_often(service: &Service, path: &str, count: usize) {
    let mut stream = TcpStream::connect(&service.address).unwrap();
    let mut reader = stream.try_clone().unwrap();
    let reading = std::thread::spawn(move || reader.read_to_end(&mut Vec::new()));
    let host = &service.address;
    for number in 0..count {
        let end = if number + 1 == count {
            "Connection: close\r\n"
        } else {
            ""
        };
        let head = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{end}\r\n");
        stream.write_all(head.as_bytes()).unwrap();
    }
    reading.join().unwrap().unwrap();
}

/// Asks until an allowance is used up. On a slow machine more comes in between, one for each second;
/// as many as there are here is more than any machine lets pass where an allowance is shared.
#[track_caller]
fn wait_for_refusal(mut ask: impl FnMut() -> u16) {
    let began = Instant::now();
    loop {
        match ask() {
            429 => return,
            status => assert!(matches!(status, 200 | 401), "{status}"),
        }
        assert!(began.elapsed() < HANG, "none was refused");
    }
}

/// Strangers have an allowance each, and none where a page or whoever watches the service asks.
#[test]
fn verif_strangers_share_no_allowance() {
    let folder = Folder::new();
    let token = folder.token("lab", "read");
    let settings = ["rate_per_s=1", "rate_burst=20", "proxies=127.0.0.3"];
    let service = Service::start(&folder, &settings);
    get_often(&service, "/assets/app.css", 2500);
    for path in ["/readyz", "/healthz", "/login"] {
        assert_eq!(get_from(&service, 1, path, "").0, 200, "{path}");
    }
    let strange = || get_from(&service, 1, "/v1/limits", "").0;
    assert_eq!(strange(), 401);
    wait_for_refusal(strange);
    assert_eq!(get_from(&service, 2, "/login", "").0, 200);
    let known = format!("Authorization: BEARER {token}\r\n");
    assert_eq!(get_from(&service, 1, "/v1/limits", &known).0, 200);
    // Behind a proxy each of its clients has an allowance, of IPv6 each network; nobody else is believed.
    let through = |last: u8, client: &str| {
        let line = format!("X-Forwarded-For: 10.0.0.9, {client}, 127.0.0.3\r\n");
        get_from(&service, last, "/login", &line).0
    };
    for number in 0..30 {
        assert_eq!(through(3, &format!("192.0.2.{number}")), 200);
    }
    let mut hosts = 0..=u16::MAX;
    wait_for_refusal(|| through(3, &format!("2001:db8::{:x}", hosts.next().unwrap())));
    assert_eq!(through(3, "2001:db8:0:1::1"), 200);
    let mut hosts = 0..=u16::MAX;
    wait_for_refusal(|| {
        let [high, low] = hosts.next().unwrap().to_be_bytes();
        through(1, &format!("198.18.{high}.{low}"))
    });
}

/// What is remembered of addresses is bounded: beyond that the unknown share one allowance.
#[test]
fn verif_the_memory_of_allowances_is_bounded() {
    let allowances = Allowances::default();
    // Nothing is added meanwhile, however long this takes.
    for number in 0..5000 {
        let _ = allowances.take(&format!("{number}"), 0, 1);
    }
    assert!(allowances.take("new", 0, 1).is_err());
    assert!(allowances.take("newer", 0, 1).is_err());
    // Where allowances are whole again there is room.
    let allowances = Allowances::default();
    for number in 0..5000 {
        allowances.take(&format!("{number}"), 1 << 32, 2).unwrap();
    }
}

/// Requests, refusals and sign-ins are told with where they come from; secrets are not.
#[test]
fn cli_the_log_says_who_asked_from_where() {
    let folder = Folder::new();
    let token = folder.token("lab", "read");
    let service = Service::start(&folder, &["proxies=127.0.0.3", "log=warn"]);
    let client = "X-Forwarded-For: 192.0.2.7\r\n";
    get_from(&service, 3, "/v1/verdicts?filter=hidden", client);
    let form = Client::with(
        service.client(),
        "Content-Type",
        "application/x-www-form-urlencoded",
    );
    let body = format!("token={token}");
    form.send("POST", "/login", body.as_bytes()).expect(303);
    let audit = |what: &str| -> Value {
        let log = std::fs::read_to_string(&service.log).unwrap();
        assert!(!log.contains("hidden") && !log.contains(&token), "{log}");
        let lines = log
            .lines()
            .map(|line| serde_json::from_str::<Value>(line).unwrap());
        let mut lines = lines.filter(|line| line["target"] == "audit");
        lines
            .find(|line| line["fields"]["what"] == what)
            .unwrap_or_else(|| panic!("no {what} in {log}"))["fields"]
            .clone()
    };
    let refused = audit("refused");
    assert_eq!(refused["which"], "GET /v1/verdicts");
    assert_eq!(refused["from"], "192.0.2.7 by 127.0.0.3");
    assert_eq!(
        (&audit("signed in")["who"], &audit("signed in")["from"]),
        (&json!("lab"), &json!("127.0.0.1"))
    );
}

/// Returns the most memory that the service had, without its children [KiB].
fn peak_kib(service: &Service) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", service.child.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|rest| rest.trim().strip_suffix(" kB"));
    kib.unwrap().parse().unwrap()
}

/// However many begin forms and go no further, or ask for pages that read whole reports, the service
/// stays small.
#[test]
fn verif_forms_and_pages_keep_the_service_small() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["address_connections=1024"]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let mut ids = Vec::new();
    for torque in 0..3 {
        let set = format!("lever.preload_torque_nm=2.{torque}");
        let question = json!({"recording": id, "request": {"members": 0}, "set": [set]});
        let verdict = client.post("/v1/verdicts?wait=60", &question).expect(200);
        ids.push(verdict.json()["report_id"].as_str().unwrap().to_string());
    }
    let begun = "x".repeat(15 << 10);
    let form = format!(
        "POST /v1/recordings HTTP/1.1\r\nHost: {}\r\nX-Long: {begun}\r\n\
         Content-Type: multipart/form-data; boundary=zz\r\nTransfer-Encoding: chunked\r\n\r\n\
         {:x}\r\n{begun}\r\n",
        service.address,
        begun.len()
    );
    let forms: Vec<TcpStream> = (0..600)
        .map(|number| {
            let mut stream = connect_from(&service, 1 + (number % 8) as u8);
            let _ = stream.write_all(form.as_bytes());
            stream
        })
        .collect();
    let compared = format!("/compare?id={}&id={}&id={}", ids[0], ids[1], ids[2]);
    let one = format!("/verdicts/{}", ids[0]);
    std::thread::scope(|scope| {
        for number in 0..40 {
            let place = if number % 2 == 0 { &one } else { &compared };
            scope.spawn(|| service.client().get(place).expect(200));
        }
    });
    let peak = peak_kib(&service);
    println!("{} MiB with {} forms", peak >> 10, forms.len());
    assert!(peak < 128 << 10, "{peak} KiB");
}

/// However many send long bodies at once, and leave their answers lying, the service stays small.
#[test]
fn verif_the_service_stays_small() {
    let folder = Folder::new();
    let token = folder.token("lab", "read,submit");
    let service = Service::start(&folder, &["address_connections=1024"]);
    let keys = "nonsense = 1\n".repeat(70_000);
    let head = format!(
        "POST /v1/gates HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {token}\r\n\
         Transfer-Encoding: chunked\r\n\r\n{:x}\r\n",
        service.address,
        keys.len()
    );
    let streams: Vec<TcpStream> = (0..250)
        .map(|number| {
            let mut stream = connect_from(&service, 1 + (number % 8) as u8);
            stream.set_nonblocking(true).unwrap();
            let _ = stream.write(head.as_bytes());
            stream
        })
        .collect();
    let began = Instant::now();
    let mut sent = vec![0; streams.len()];
    let mut advanced = Instant::now();
    let whole = loop {
        for (stream, sent) in streams.iter().zip(&mut sent) {
            let rest = &keys.as_bytes()[*sent..];
            let mut stream = stream;
            match stream.write(&rest[..rest.len().min(64 << 10)]) {
                Ok(count) if count > 0 => {
                    *sent += count;
                    advanced = Instant::now();
                }
                _ => {}
            }
        }
        let whole = sent.iter().filter(|sent| **sent == keys.len()).count();
        // Those that the token's half of the memory takes; what finds none is refused.
        if whole >= 10 && advanced.elapsed() > Duration::from_secs(1) {
            break whole;
        }
        assert!(began.elapsed() < HANG, "{whole} bodies were taken");
    };
    let peak = peak_kib(&service);
    println!("{} MiB after {whole} bodies", peak >> 10);
    assert!(peak < 128 << 10, "{peak} KiB");
    drop(streams);
    service.client().get("/healthz").expect(200);
}

/// Whoever reads the log sees which tokens were made and taken back meanwhile.
#[test]
fn cli_the_log_says_which_tokens_were_made() {
    let folder = Folder::new();
    let token = folder.token("lab", "read");
    let service = Service::start(&folder, &["log=warn"]);
    let asked = || {
        let_the_tokens_age();
        let client = service.client().bearer(&token);
        client.get("/v1/verdicts").expect(200);
        std::fs::read_to_string(&service.log).unwrap()
    };
    asked();
    folder.token("ada", "read");
    let log = asked();
    assert!(
        log.contains(r#""what":"token made","which":"ada#2""#),
        "{log}"
    );
    assert!(!log.contains("lab#1"), "{log}");
    assert_eq!(folder.run(&["token", "revoke", "ada"]).0, 0);
    let log = asked();
    assert!(
        log.contains(r#""what":"token taken back","which":"ada#2""#),
        "{log}"
    );
}

/// However many take their time with a file of a report, everybody else is answered.
#[test]
fn verif_slow_readers_hold_no_thread() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["address_connections=200"]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    let verdict = client.post("/v1/verdicts?wait=60", &question).expect(200);
    let place = verdict.header("location").unwrap().to_string();
    let ask_and_wait = |_| {
        let mut stream = connect_from(&service, 1);
        let host = &service.address;
        let head = format!("GET {place}/report.html HTTP/1.1\r\nHost: {host}\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        stream
    };
    let begins = |stream: &TcpStream| stream.peek(&mut [0]).is_ok_and(|count| count == 1);
    let is_held = |stream: &TcpStream| served_end(stream) != ServedEnd::Closed;
    // Readers that take nothing are let go of after 20 s. On a machine that needs longer for three
    // answers nothing is learnt, and others are asked for.
    let are_answered_meanwhile = (0..5).any(|_| {
        let readers: Vec<TcpStream> = (0..100).map(ask_and_wait).collect();
        assert!(readers.iter().all(begins));
        for path in ["/readyz", "/v1/limits", "/v1/verdicts"] {
            let (status, answer) = get_from(&service, 2, path, "");
            assert_eq!(status, 200, "{path}: {answer}");
        }
        readers.iter().all(is_held)
    });
    assert!(are_answered_meanwhile, "others wait until the readers go");
}
