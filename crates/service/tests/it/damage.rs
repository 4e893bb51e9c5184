//! What survives: kills, a full disk, damaged files, the end of service.

use crate::access::blobs;
use crate::support::{Client, Folder, PROGRAM, Service, signal, wait_for, without_run};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Numbers that come out the same each time, of which tests draw their moments.
struct Chance(u64);

impl Chance {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }
}

fn asking(id: &Value, number: u64) -> Value {
    let set = format!("lever.preload_torque_nm={}", 2.0 + 1e-5 * number as f64);
    let members = if number.is_multiple_of(4) { 128 } else { 0 };
    json!({"recording": id, "request": {"members": members, "opens_when": "negative"}, "set": [set]})
}

fn kills(default: u64) -> u64 {
    std::env::var("LATCHGATE_SERVICE_KILLS").map_or(default, |text| text.parse().unwrap())
}

/// A gate of a dozen pairs.
fn gate() -> String {
    let designs = (0..12).map(|number| {
        let torque = 2.0 + 0.1 * f64::from(number);
        format!("[[designs]]\nname = \"d{number}\"\nset = {{ \"lever.preload_torque_nm\" = {torque} }}\n")
    });
    let head = "[[recordings]]\nfiles = \"burst.csv\"\nmembers = 128\nopens_when = \"negative\"\n";
    format!("{head}{}", designs.collect::<String>())
}

/// Lists the verdicts on questions by their identity, sorted; those of the gate have designs of other
/// names.
fn judged(client: &Client) -> Vec<String> {
    let mut found = Vec::new();
    let mut path = "/v1/verdicts?design=paper&limit=200".to_string();
    loop {
        let part = client.get(&path).expect(200).json();
        let verdicts = part["verdicts"].as_array().unwrap().iter();
        found.extend(verdicts.map(|own| own["report_id"].as_str().unwrap().to_string()));
        match part["next"].as_i64() {
            Some(next) => path = format!("/v1/verdicts?design=paper&limit=200&cursor={next}"),
            None => break,
        }
    }
    found.sort();
    found
}

/// Submits the gate and waits for its summary.
fn gate_summary(client: &Client) -> Vec<u8> {
    let id = client.send("POST", "/v1/gates", gate().as_bytes()).json()["id"].clone();
    let place = format!("/v1/gates/{}", id.as_str().unwrap());
    wait_for("the gate is decided", || {
        client.get(&place).expect(200).json()["state"] == "done"
    });
    client
        .get(&format!("{place}/summary.json"))
        .expect(200)
        .body
}

/// Answers of a service that nothing disturbs, and the summary of a gate.
fn undisturbed(numbers: impl Iterator<Item = u64>) -> (BTreeMap<u64, String>, Vec<u8>) {
    let folder = Folder::new();
    let service = Service::start(&folder, &["wait_s=60"]);
    let client = service.client();
    let id = client.try_upload("burst.csv").unwrap()["id"].clone();
    let answers = numbers.map(|number| {
        let answer = client
            .post("/v1/verdicts", &asking(&id, number))
            .expect(200);
        (number, without_run(&answer.body))
    });
    (answers.collect(), gate_summary(&client))
}

/// Asks until there is an answer.
fn answer(client: &Client, asking: &Value) -> String {
    let mut last = None;
    for _ in 0..200 {
        match client.try_send_json("/v1/verdicts?wait=20", asking) {
            Ok(answer) if answer.status == 200 => return without_run(&answer.body),
            other => last = Some(other.map(|answer| answer.text())),
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("no answer: {last:?}");
}

/// Processor time by which a service that was killed is ready.
const READY: Duration = Duration::from_millis(250);

/// No rate, since everything that was acknowledged is asked for at once.
const FAST: [&str; 2] = ["rate_per_s=1000000", "rate_burst=1000000"];

/// What was acknowledged: recordings, deletions, and questions by number with their job.
#[derive(Default)]
struct Acknowledged {
    recordings: Vec<Value>,
    deleted: Vec<Value>,
    jobs: BTreeMap<u64, String>,
    gate: bool,
}

impl Acknowledged {
    fn extend(&mut self, other: Self) {
        self.recordings.extend(other.recordings);
        self.deleted.extend(other.deleted);
        self.jobs.extend(other.jobs);
        self.gate |= other.gate;
    }

    fn every_kind(&self) -> bool {
        self.gate
            && !self.recordings.is_empty()
            && !self.deleted.is_empty()
            && !self.jobs.is_empty()
    }

    /// Checks that the last so many recordings and jobs are there.
    #[track_caller]
    fn check(&self, client: &Client, last: usize) {
        for id in self.recordings.iter().rev().take(last) {
            let path = format!("/v1/recordings/{}", id.as_str().unwrap());
            let channels = client.get(&path).expect(200).json()["channels"].clone();
            assert_eq!(channels.as_array().unwrap().len(), 1);
        }
        for id in self.deleted.iter().rev().take(last) {
            let path = format!("/v1/recordings/{}", id.as_str().unwrap());
            client.get(&path).expect(410);
        }
        for job in self.jobs.values().rev().take(last) {
            client.get(&format!("/v1/jobs/{job}")).expect(200);
        }
    }
}

/// Killed at moments of no choice while it uploads and judges, the service loses nothing that it
/// has acknowledged and answers as it would have; each round asks other questions.
/// `LATCHGATE_SERVICE_KILLS` says how often.
#[test]
fn verif_kills_of_the_service_lose_nothing() {
    let folder = Folder::new();
    let mut chance = Chance(1);
    let mut acknowledged = Acknowledged::default();
    let mut ready = Duration::ZERO;
    // A slow machine needs more and longer rounds until each kind of request was acknowledged.
    let rounds = (0..60).map(|round| (round, round < kills(6)));
    for (round, asked) in rounds {
        if !asked && acknowledged.every_kind() {
            break;
        }
        let mut service = Service::start(&folder, &FAST);
        let client = service.client();
        client.get("/readyz").expect(200);
        ready = ready.max(service.processor_time());
        acknowledged.check(&client, 20);
        let busy: Vec<_> = (0..3)
            .map(|hand| {
                let client = client.clone();
                std::thread::spawn(move || load(&client, round, hand))
            })
            .collect();
        let longer = 1 + round / kills(6);
        std::thread::sleep(Duration::from_millis(20 + longer * chance.below(400)));
        service.child.kill().unwrap();
        service.child.wait().unwrap();
        for hand in busy {
            acknowledged.extend(hand.join().unwrap());
        }
    }
    let service = Service::start(&folder, &FAST);
    let client = service.client();
    acknowledged.check(&client, usize::MAX);
    assert!(acknowledged.every_kind());
    let (expected, summary) = undisturbed(acknowledged.jobs.keys().copied());
    let id = client.try_upload("burst.csv").unwrap()["id"].clone();
    for (number, expected) in &expected {
        let path = format!("/v1/jobs/{}", acknowledged.jobs[number]);
        wait_for("a question is answered", || {
            client.get(&path).expect(200).json()["state"] == "done"
        });
        let own = answer(&client, &asking(&id, *number));
        assert!(own == *expected, "question {number}");
    }
    assert!(gate_summary(&client) == summary, "the gate is another");
    let found = judged(&client);
    assert!(
        found.windows(2).all(|pair| pair[0] != pair[1]),
        "one is there twice"
    );
    assert!(found.len() >= expected.len());
    let whole = folder.run(&["fsck"]);
    assert_eq!(whole.0, 0, "{}", whole.1);
    println!(
        "{} recordings, {} deletions and {} questions acknowledged; ready by {ready:?} of work at most",
        acknowledged.recordings.len(),
        acknowledged.deleted.len(),
        expected.len()
    );
    assert!(ready < READY, "{ready:?}");
}

/// Killed while tokens are made, rotated and taken back, and the commands for it with the service, it lets nobody in
/// whose token was taken back, keeps nobody out whose token was made, and loses no recording and no deletion.
#[test]
fn verif_kills_while_tokens_rotate_let_nobody_in() {
    let folder = Folder::new();
    let admin = folder.token("admin", "read,submit,delete");
    let mut chance = Chance(3);
    let mut acknowledged = Acknowledged::default();
    let mut live: BTreeMap<u64, String> = BTreeMap::new();
    let mut taken_back: Vec<String> = Vec::new();
    let token_command = |action: &str, name: &str| {
        let mut command = Command::new(PROGRAM);
        command.args(["token", action, name]);
        if action == "create" {
            command.args(["--scopes", "read"]);
        }
        command.arg("--data").arg(folder.data());
        let command = command.stdout(Stdio::piped()).stderr(Stdio::null());
        command.spawn().unwrap()
    };
    let mut met = 0;
    for round in 0..kills(6) {
        let mut service = Service::start(&folder, &FAST);
        let client = service.client().bearer(&admin);
        acknowledged.check(&client, 20);
        let status = |token: &str| service.client().bearer(token).get("/v1/limits").status;
        for token in live.values() {
            assert_eq!(status(token), 200, "round {round}");
        }
        for token in &taken_back {
            assert_eq!(status(token), 401, "round {round}");
        }
        assert_eq!(service.client().get("/v1/limits").status, 401);
        let hand = std::thread::spawn(move || load(&client, round, 0));
        let commands = 2 + chance.below(6);
        for number in 0..=commands {
            let holder = chance.below(4);
            let action = match live.contains_key(&holder) {
                false => "create",
                true if chance.below(3) == 0 => "revoke",
                true => "rotate",
            };
            let mut command = token_command(action, &format!("holder-{holder}"));
            let before = live.remove(&holder);
            if number == commands {
                // The last command and the service are killed at once; nobody said what became of it.
                std::thread::sleep(Duration::from_millis(chance.below(30)));
                service.child.kill().unwrap();
                let _ = command.kill();
            }
            let output = command.wait_with_output().unwrap();
            if !output.status.success() {
                met += u64::from(number == commands);
                // Whether it has a token is not known: from now on it has none.
                let name = format!("holder-{holder}");
                let gone = token_command("revoke", &name).wait_with_output().unwrap();
                if gone.status.success() {
                    taken_back.extend(before);
                }
                continue;
            }
            taken_back.extend(before);
            if action != "revoke" {
                let token = String::from_utf8(output.stdout).unwrap();
                live.insert(holder, token.trim().to_string());
            }
        }
        service.child.wait().unwrap();
        acknowledged.extend(hand.join().unwrap());
    }
    let service = Service::start(&folder, &FAST);
    acknowledged.check(&service.client().bearer(&admin), usize::MAX);
    let whole = folder.run(&["fsck"]);
    assert_eq!(whole.0, 0, "{}", whole.1);
    assert!(!taken_back.is_empty() && !live.is_empty());
    println!(
        "{} recordings and {} deletions acknowledged; {} tokens taken back, {} live, {met} commands killed at work",
        acknowledged.recordings.len(),
        acknowledged.deleted.len(),
        taken_back.len(),
        live.len()
    );
}

/// Uploads and asks until nobody answers; returns what was acknowledged.
fn load(client: &Client, round: u64, hand: u64) -> Acknowledged {
    let mut own = Acknowledged::default();
    for turn in 0.. {
        let name = format!("r{round}-{hand}-{turn}.csv");
        let path = format!("/v1/recordings?name={name}");
        let table = "t_s,acc_y_g\n0,1\n0.001,2\n0.002,1\n0.003,0\n";
        let Ok(answer) = client.try_send("POST", &path, table.as_bytes()) else {
            break;
        };
        if matches!(answer.status, 200 | 201) {
            let id = answer.json()["id"].clone();
            if turn % 3 == hand {
                let path = format!("/v1/recordings/{}", id.as_str().unwrap());
                match client.try_send("DELETE", &path, &[]) {
                    Ok(answer) if answer.status == 200 => own.deleted.push(id),
                    // Whether it was deleted nobody said.
                    Ok(_) => {}
                    Err(_) => break,
                }
            } else {
                own.recordings.push(id);
            }
        }
        let Ok(burst) = client.try_upload("burst.csv") else {
            break;
        };
        match client.try_send("POST", "/v1/gates", gate().as_bytes()) {
            Ok(answer) => own.gate |= matches!(answer.status, 200 | 202),
            Err(_) => break,
        }
        let number = round * 300 + hand * 100 + turn % 100;
        let question = asking(&burst["id"], number);
        match client.try_send_json("/v1/verdicts?wait=0", &question) {
            Ok(answer) if answer.status == 202 => {
                let job = answer.json()["job"].as_str().unwrap().to_string();
                own.jobs.insert(number, job);
            }
            Ok(_) => {}
            Err(_) => break,
        }
    }
    own
}

/// Tells whether a process runs just now.
fn is_at_work(process: &str) -> bool {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let rest = stat.rsplit_once(") ").map(|(_, rest)| rest);
    rest.is_some_and(|rest| rest.starts_with('R'))
}

/// Children that are killed at their work cost time, and change nothing.
#[test]
fn verif_kills_of_children_change_nothing() {
    let kills = kills(12);
    let folder = Folder::new();
    let service = Service::start(&folder, &["places=2"]);
    let client = service.client();
    let id = client.try_upload("burst.csv").unwrap()["id"].clone();
    let mut chance = Chance(2);
    client.send("POST", "/v1/gates", gate().as_bytes());
    let lost = || -> u64 {
        let counters = client.get("/metrics").text();
        let count = counters
            .lines()
            .find_map(|line| line.strip_prefix("latchgate_children_lost_total "));
        count.unwrap().parse().unwrap()
    };
    let mut answers = BTreeMap::new();
    // A question that was quicker than the kill says nothing, so another one is asked.
    for number in 0..50 * kills {
        if lost() >= kills {
            break;
        }
        // Those with an ensemble take long enough to be met at work.
        let question = asking(&id, 4 * number);
        let asked = client.post("/v1/verdicts?wait=0", &question);
        let path = format!("/v1/jobs/{}", asked.json()["job"].as_str().unwrap_or(""));
        let state = || client.get(&path).json()["state"].clone();
        wait_for("it is at work", || state() != "queued");
        std::thread::sleep(Duration::from_millis(chance.below(60)));
        while state() != "done" {
            let mut children = service.children();
            children.retain(|child| is_at_work(child));
            let which = chance.below(children.len().max(1) as u64) as usize;
            let Some(child) = children.get(which) else {
                continue;
            };
            if Command::new("kill")
                .args(["-9", child])
                .status()
                .unwrap()
                .success()
            {
                break;
            }
        }
        answers.insert(4 * number, answer(&client, &question));
    }
    println!("{} questions, {} children killed", answers.len(), lost());
    assert!(lost() >= kills, "{} of {kills} were met at work", lost());
    let (expected, summary) = undisturbed(answers.keys().copied());
    for (number, expected) in &expected {
        assert!(answers[number] == *expected, "question {number}");
    }
    assert!(gate_summary(&client) == summary, "the gate is another");
    assert_eq!(judged(&client).len(), expected.len(), "none is there twice");
}

#[test]
fn verif_a_damaged_file_is_never_served() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.try_upload("burst.csv").unwrap()["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    let document = client.post("/v1/verdicts?wait=60", &question).expect(200);
    let path = format!(
        "/v1/verdicts/{}",
        document.json()["report_id"].as_str().unwrap()
    );
    let page = client.get(&format!("{path}/report.html")).expect(200).body;
    let blob = blob_of(&folder, &page);
    let mut damaged = page.clone();
    damaged[1000] ^= 1;
    fs::write(&blob, &damaged).unwrap();
    let (code, text) = folder.run(&["fsck"]);
    assert_eq!(code, 4);
    assert!(text.contains("report.html"), "{text}");
    // It is made again.
    let again = client.get(&format!("{path}/report.html")).expect(200);
    assert!(again.body == page, "another page");
    assert_eq!(folder.run(&["fsck"]).0, 0);
    // A damaged recording is not judged either; uploaded again it is whole.
    let recording = blob_of(&folder, &signal("burst.csv"));
    fs::write(&recording, b"t_s,acc_y_g\n").unwrap();
    let other = json!({"recording": id, "request": {"members": 0, "filter": "cfc600"}});
    // One that a child still holds was read whole.
    for child in service.children() {
        Command::new("kill").args(["-9", &child]).status().unwrap();
    }
    let refused = client.post("/v1/verdicts?wait=60", &other);
    assert!(refused.status >= 400, "{}", refused.text());
    assert_eq!(refused.json()["code"], "damaged");
    client.try_upload("burst.csv").unwrap();
    assert_eq!(folder.run(&["fsck"]).0, 0);
    client.post("/v1/verdicts?wait=60", &other).expect(200);
}

pub(crate) fn blob_of(folder: &Folder, bytes: &[u8]) -> std::path::PathBuf {
    let sha256 = latchgate_service::store::sha256_hex(bytes);
    folder.data().join("blobs").join(&sha256[..2]).join(sha256)
}

/// Submits a gate and waits until it is decided; returns its place.
fn decided_gate(client: &Client, name: &str, text: &str) -> String {
    let path = format!("/v1/gates?name={name}");
    let gate = client.send("POST", &path, text.as_bytes());
    assert!(matches!(gate.status, 200 | 202), "{}", gate.text());
    let place = format!("/v1/gates/{}", gate.json()["id"].as_str().unwrap());
    wait_for("the gate is decided", || {
        client.get(&place).expect(200).json()["state"] == "done"
    });
    place
}

/// A damaged row is missed in its list, which says so, and holds up nothing else.
#[test]
fn regress_a_damaged_row_costs_that_row_alone() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let text = |files: &str, torque: f64| {
        let set = format!("\"lever.preload_torque_nm\" = {torque}");
        format!(
            "[[recordings]]\nfiles = \"{files}\"\nmembers = 0\nopens_when = \"negative\"\n\
             [[designs]]\nname = \"d\"\nset = {{ {set} }}\n"
        )
    };
    let lost = client.upload_bytes("lost.csv", &signal("burst.csv"), None);
    let lost = lost.expect(201).json()["id"].clone();
    let id = client.upload("burst.csv")["id"].clone();
    for set in ["lever.preload_torque_nm=2.1", "lever.preload_torque_nm=2.2"] {
        let question = json!({"recording": id, "request": {"members": 0}, "set": [set]});
        client.post("/v1/verdicts?wait=60", &question).expect(200);
    }
    for name in ["a", "b"] {
        let design =
            json!({"name": name, "design": {"base": "paper", "lever": {"preload_torque_nm": 2.5}}});
        client.post("/v1/designs", &design).expect(201);
    }
    let first = decided_gate(&client, "first", &text("burst.csv", 2.3));
    let second = decided_gate(&client, "second", &text("burst.csv", 2.4));
    decided_gate(&client, "third", &text("burst.csv", 2.5));
    assert_eq!(service.end(), 0);
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    for sql in [
        "UPDATE recordings SET body = replace(body, 'lost', 'lOst') WHERE body LIKE '%lost.csv%'",
        "UPDATE results SET body = body || ' ' WHERE number = 1",
        "UPDATE designs SET body = body || ' ' WHERE name = 'a'",
        "UPDATE gates SET body = body || ' ' WHERE name = 'third'",
        // The outcome of the first cannot be made, which must not hold up the second.
        "UPDATE gates SET outcome = NULL, outcome_sum = NULL WHERE name = 'first'",
        "UPDATE gates SET outcome = NULL, outcome_sum = NULL WHERE name = 'second'",
        "UPDATE jobs SET answer = answer || ' ' WHERE id = (SELECT job FROM pairs WHERE gate =
             (SELECT id FROM gates WHERE name = 'first'))",
    ] {
        assert_eq!(connection.execute(sql, []).unwrap(), 1, "{sql}");
    }
    drop(connection);
    let service = Service::start(&folder, &[]);
    let client = service.client();
    for (list, least) in [
        ("recordings", 1),
        ("verdicts", 1),
        ("designs", 1),
        ("gates", 2),
    ] {
        let found = client.get(&format!("/v1/{list}")).expect(200).json();
        assert_eq!(found["damaged"], 1, "{list}: {found}");
        assert!(found[list].as_array().unwrap().len() >= least, "{found}");
    }
    let recording = format!("/recordings/{}", id.as_str().unwrap());
    for page in ["/", "/gates", "/designs", &recording] {
        client.get(page).expect(200);
    }
    assert!(
        client
            .get("/designs")
            .text()
            .contains("1 damaged row left out")
    );
    let log = fs::read_to_string(&service.log).unwrap();
    assert!(log.contains("design a@1"), "it is named: {log}");
    wait_for("the second is settled", || {
        client.get(&second).expect(200).json()["state"] == "done"
    });
    assert_eq!(client.get(&first).expect(500).json()["code"], "damaged");
    // The damaged recording might be one that the pattern means: no gate passes without it.
    let path = "/v1/gates?name=all";
    let refused = client.send("POST", path, text("*.csv", 2.6).as_bytes());
    let refused = refused.expect(400).json();
    let detail = refused["detail"].as_str().unwrap();
    assert!(detail.contains(lost.as_str().unwrap()), "{detail}");
    decided_gate(&client, "own", &text(id.as_str().unwrap(), 2.4));
    // Uploaded again, it is whole again.
    let again = client.upload_bytes("lost.csv", &signal("burst.csv"), None);
    assert_eq!(again.json()["id"], lost);
    assert_eq!(client.get("/v1/recordings").json()["damaged"], 0);
    assert_eq!(
        client
            .send("POST", path, text("*.csv", 2.6).as_bytes())
            .status,
        202
    );
}

/// A form that is refused at its end leaves none of its files, and what a kill left between a file
/// and its row is collected a day later.
#[test]
fn regress_nothing_lies_in_the_store_that_no_row_names() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let parts: [(&str, &str, &[u8]); 3] = [
        ("file", "a.csv", b"t_s,acc_y_g\n0,1\n"),
        ("part", "b.csv", b"t_s,acc_y_g\n0,2\n"),
        ("part", "../c.csv", b"t_s,acc_y_g\n0,3\n"),
    ];
    client.upload_form("", &parts).expect(400);
    wait_for("nothing is left", || blobs(&folder) == 0);
    client.upload_form("", &parts[..2]).expect(201);
    assert_eq!(blobs(&folder), 2);
    let long_ago = std::time::SystemTime::now() - Duration::from_secs(2 * 86_400);
    let put = |bytes: &[u8], is_old: bool| {
        let path = blob_of(&folder, bytes);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        if is_old {
            let file = fs::File::open(&path).unwrap();
            file.set_modified(long_ago).unwrap();
        }
        path
    };
    let (fresh, old) = (put(b"fresh", false), put(b"old", true));
    let kept = put(parts[0].2, true);
    let (code, text) = folder.run(&["fsck", "--collect"]);
    assert_eq!(code, 4, "not beside a service: {text}");
    assert!(old.exists());
    assert_eq!(service.end(), 0);
    let (code, text) = folder.run(&["fsck", "--collect"]);
    assert_eq!(code, 0, "{text}");
    assert!(
        text.contains("1 files of 3 bytes that no row names"),
        "{text}"
    );
    assert_eq!(
        [fresh.exists(), old.exists(), kept.exists()],
        [true, false, true]
    );
    put(b"old", true);
    let _service = Service::start(&folder, &[]);
    wait_for("it is collected", || !old.exists());
    assert!(fresh.exists() && kept.exists());
}

#[test]
fn cli_a_backup_is_taken_and_restored() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.try_upload("burst.csv").unwrap()["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    let document = client.post("/v1/verdicts?wait=60", &question).expect(200);
    let copy = folder.0.join("copy");
    let (code, text) = folder.run(&["backup", copy.to_str().unwrap()]);
    assert_eq!(code, 0, "{text}");
    assert_eq!(
        folder.run(&["backup", copy.to_str().unwrap()]).0,
        4,
        "never over another"
    );
    assert_eq!(
        folder.run(&["restore", copy.to_str().unwrap()]).0,
        4,
        "never over data"
    );
    assert_eq!(service.end(), 0);
    fs::remove_dir_all(folder.data()).unwrap();
    let (code, text) = folder.run(&["restore", copy.to_str().unwrap()]);
    assert_eq!(code, 0, "{text}");
    let service = Service::start(&folder, &[]);
    let path = document.header("location").unwrap();
    assert_eq!(service.client().get(path).expect(200).body, document.body);
}

/// SIGTERM under load: whoever is being answered is answered whole.
#[test]
fn verif_the_end_of_service_cuts_no_answer() {
    for round in 0..kills(3).min(20) {
        let folder = Folder::new();
        let service = Service::start(&folder, &["places=2"]);
        let client = service.client();
        let id = client.try_upload("burst.csv").unwrap()["id"].clone();
        let answered = Arc::new(AtomicU64::new(0));
        let busy: Vec<_> = (0..4)
            .map(|hand| {
                let (client, id) = (client.clone(), id.clone());
                let answered = Arc::clone(&answered);
                std::thread::spawn(move || {
                    for number in 0.. {
                        let question = asking(&id, hand * 1000 + number);
                        match client.try_send_json("/v1/verdicts?wait=20", &question) {
                            // A cut answer is an error of its own.
                            Err(error) => {
                                let text = error.to_string();
                                assert!(!text.contains("the answer is cut"), "{text}");
                                break;
                            }
                            Ok(answer) if answer.status == 503 => break,
                            Ok(answer) => {
                                assert!(matches!(answer.status, 200 | 202), "{}", answer.text());
                                answered.fetch_add(1, Ordering::Relaxed);
                            }
                        }
                    }
                })
            })
            .collect();
        // Four are under way, whichever were answered before.
        wait_for("some are answered", || {
            answered.load(Ordering::Relaxed) > round
        });
        assert_eq!(service.end(), 0);
        for hand in busy {
            hand.join().unwrap();
        }
    }
}

/// With 100 000 jobs waiting, a service that was killed is ready as soon as with none.
#[test]
fn verif_a_long_queue_is_no_hindrance() {
    use latchgate_service::store::{Ledger, Question, SqliteLedger};
    let folder = Folder::new();
    fs::create_dir_all(folder.data()).unwrap();
    let ledger = Arc::new(SqliteLedger::open(&folder.data().join("ledger.sqlite")).unwrap());
    let hands: Vec<_> = (0..16)
        .map(|hand| {
            let ledger = Arc::clone(&ledger);
            std::thread::spawn(move || {
                for number in 0..6250 {
                    let question = Question {
                        recording: "0".repeat(64),
                        request: json!({}),
                        design: json!({"number": number}),
                        design_name: None,
                        decision_alone: false,
                    };
                    ledger
                        .submit(&format!("{hand}-{number}"), &question, "lab")
                        .unwrap();
                }
            })
        })
        .collect();
    for hand in hands {
        hand.join().unwrap();
    }
    drop(ledger);
    for _ in 0..3 {
        let mut service = Service::start(&folder, &[]);
        service.client().get("/readyz").expect(200);
        let ready = service.processor_time();
        println!("ready by {ready:?} of work");
        assert!(ready < READY, "{ready:?}");
        service.child.kill().unwrap();
        service.child.wait().unwrap();
    }
}

/// On a disk with few files no work is taken once they are used up, and the reason is told.
#[test]
fn verif_a_disk_without_files_takes_no_work() {
    let folder = Folder::new();
    fs::create_dir_all(folder.data()).unwrap();
    let data = folder.data().display().to_string();
    let mut command = Command::new("unshare");
    let script = format!(
        "mount -t tmpfs -o size=64m,nr_inodes=400 none {data} && exec {} --data {data} --set free_mib=0 \"$@\"",
        crate::support::PROGRAM
    );
    command.args(["--mount", "--map-root-user", "sh", "-c", &script, "sh"]);
    let service = Service::of(command, &folder);
    let client = service.client();
    client.get("/readyz").expect(200);
    let upload = |number: u32| {
        let table = format!("t_s,acc_y_g\n0,1\n0.001,{number}\n");
        let path = format!("/v1/recordings?name=n{number}.csv");
        client.send("POST", &path, table.as_bytes())
    };
    let refused = (0..400).map(upload).find(|answer| answer.status != 201);
    let refused = refused.unwrap().expect(507).json();
    assert_eq!(refused["limit"]["name"], "free_files", "{refused}");
    let unready = client.get("/readyz").expect(503).json();
    assert_eq!(unready["limit"]["name"], "free_files", "{unready}");
    let figures = client.get("/metrics").expect(200).text();
    assert!(
        figures.contains("\nlatchgate_disk_free_files "),
        "{figures}"
    );
}

/// On a disk of 16 MiB: what does not fit is refused with 507, what was acknowledged stays
/// readable, and service goes on once there is space again.
#[test]
fn verif_a_full_disk_loses_nothing() {
    let folder = Folder::new();
    fs::create_dir_all(folder.data()).unwrap();
    let data = folder.data().display().to_string();
    // A disk of its own, seen by the service alone; `fill` is made and removed through it.
    let mut command = Command::new("unshare");
    let script = format!(
        "mount -t tmpfs -o size=16m none {data} && \
         exec {} --data {data} --set free_mib=0 --set log=warn \"$@\"",
        crate::support::PROGRAM
    );
    command.args(["--mount", "--map-root-user", "sh", "-c", &script, "sh"]);
    let service = Service::of(command, &folder);
    let client = service.client();
    let inside = format!("/proc/{}/root{data}", service.child.id());
    let filler = format!("{inside}/filler");
    fs::write(&filler, vec![0; 2 << 20]).unwrap();
    let mut acknowledged = Vec::new();
    let mut refused = 0;
    let rows: String = (0..30_000)
        .map(|row| format!("{:.4},{}\n", f64::from(row) * 1e-4, row % 7))
        .collect();
    for number in 0..80 {
        let table = format!("t_s,acc_y_g\n{rows}{number},0\n");
        let answer = client.send(
            "POST",
            &format!("/v1/recordings?name=n{number}.csv"),
            table.as_bytes(),
        );
        match answer.status {
            200 | 201 => acknowledged.push((answer.json()["id"].clone(), table)),
            507 => {
                refused += 1;
                assert!(answer.header("retry-after").is_some());
            }
            other => panic!("{other}: {}", answer.text()),
        }
    }
    assert!(
        refused > 0 && acknowledged.len() > 10,
        "{refused} refused, {} kept",
        acknowledged.len()
    );
    client.get("/readyz").expect(503);
    fs::remove_file(filler).unwrap();
    wait_for("work is taken again", || {
        let path = "/v1/recordings?name=after.csv";
        client
            .send("POST", path, b"t_s,acc_y_g\n0,1\n0.001,2\n")
            .status
            == 201
    });
    println!("{} kept, {refused} refused", acknowledged.len());
    // Every byte that was acknowledged is there, and nothing else is damaged.
    for (id, table) in &acknowledged {
        let path = format!("/v1/recordings/{}", id.as_str().unwrap());
        client.get(&path).expect(200);
        let sha256 = latchgate_service::store::sha256_hex(table.as_bytes());
        let blob = format!("{inside}/blobs/{}/{sha256}", &sha256[..2]);
        assert!(fs::read(&blob).unwrap() == table.as_bytes(), "{blob}");
    }
    // Where the service sees it: SQLite follows links, and elsewhere there is nothing.
    let fsck = Command::new("nsenter")
        .args([
            "--target",
            &service.child.id().to_string(),
            "--mount",
            "--user",
        ])
        .args(["--preserve-credentials", crate::support::PROGRAM])
        .args(["fsck", "--data", &data])
        .output();
    let fsck = fsck.unwrap();
    let said = String::from_utf8([fsck.stdout, fsck.stderr].concat()).unwrap();
    assert!(fsck.status.success(), "{said}");
}
