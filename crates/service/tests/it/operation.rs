//! What whoever runs the service sees of it.

use crate::support::{Folder, Service, wait_for};
use serde_json::json;
use std::collections::BTreeMap;

/// Reads the text format of Prometheus: each sample by its name with labels, each name with a help and
/// a type before its first sample.
fn samples(text: &str) -> BTreeMap<String, f64> {
    let mut types: BTreeMap<String, String> = BTreeMap::new();
    let mut helped = "";
    let mut samples = BTreeMap::new();
    assert!(text.ends_with('\n'));
    for line in text.lines() {
        if let Some(help) = line.strip_prefix("# HELP ") {
            helped = help.split_once(' ').unwrap().0;
        } else if let Some(kind) = line.strip_prefix("# TYPE ") {
            let (name, kind) = kind.split_once(' ').unwrap();
            assert_eq!(name, helped, "help and type stand together");
            assert!(matches!(kind, "counter" | "gauge" | "histogram"), "{line}");
            assert_eq!(types.insert(name.into(), kind.into()), None, "{line}");
        } else {
            let (key, value) = line.rsplit_once(' ').unwrap();
            let name = key.split('{').next().unwrap();
            assert!(
                name.bytes()
                    .all(|byte| byte == b'_' || byte.is_ascii_lowercase())
            );
            let is_part = |part: &str| name.strip_suffix(part) == Some(helped);
            match types[helped].as_str() {
                "histogram" => assert!(
                    ["_bucket", "_sum", "_count"].iter().any(|p| is_part(p)),
                    "{line}"
                ),
                kind => assert_eq!(
                    (name, kind == "counter"),
                    (helped, name.ends_with("_total")),
                    "{line}"
                ),
            }
            assert_eq!(
                samples.insert(key.to_string(), value.parse().unwrap()),
                None,
                "{line}"
            );
        }
    }
    samples
}

/// The figures are in the format of Prometheus, and count what was done.
#[test]
fn cli_the_figures_count_what_was_done() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["places=1"]);
    let client = service.client();
    let figures = || samples(&client.get("/metrics").expect(200).text());
    let before = figures();
    let build = before
        .keys()
        .find(|key| key.starts_with("latchgate_build_info{version="));
    assert!(build.is_some(), "{before:?}");
    let recording = client.upload("burst.csv");
    let question = json!({"recording": recording["id"], "request": {"members": 0}});
    let verdict = client
        .post("/v1/verdicts?wait=60", &question)
        .expect(200)
        .json();
    let gate = "[[recordings]]\nfiles = \"burst.csv\"\nmembers = 0\n[[designs]]\nname = \"a\"\n";
    client
        .send("POST", "/v1/gates", gate.as_bytes())
        .expect(202);
    wait_for("the gate has its outcome", || {
        figures()["latchgate_jobs_done_total"] == 2.0 && figures()["latchgate_gates_open"] == 0.0
    });
    let after = figures();
    let answer = verdict["verdict"].as_str().unwrap();
    let of_answer = format!("latchgate_verdicts_total{{answer=\"{answer}\"}}");
    assert_eq!(after[&of_answer] - before[&of_answer], 2.0);
    assert_eq!(
        after["latchgate_recording_bytes"],
        recording["bytes"].as_f64().unwrap()
    );
    for kind in ["upload", "question", "gate"] {
        let buckets = ["0.005", "0.025", "0.1", "0.5", "2.5", "10", "60", "+Inf"];
        let name = |most| {
            format!("latchgate_request_duration_seconds_bucket{{kind=\"{kind}\",le=\"{most}\"}}")
        };
        let counts = buckets.map(|most| after[&name(most)]);
        assert!(counts.is_sorted() && counts[7] == 1.0, "{kind}: {counts:?}");
        assert_eq!(
            after[&format!("latchgate_request_duration_seconds_count{{kind=\"{kind}\"}}")],
            1.0
        );
        assert!(after[&format!("latchgate_request_duration_seconds_sum{{kind=\"{kind}\"}}")] > 0.0);
    }
    // What waits gets older.
    for number in 0..100 {
        let request = json!({"members": 10_000, "opens_when": "both", "seed": number});
        let question = json!({"recording": recording["id"], "request": request});
        client.post("/v1/verdicts?wait=0", &question);
    }
    wait_for("the oldest is a second old", || {
        figures()["latchgate_jobs_oldest_seconds"] >= 1.0
    });
}

/// A container asks by the program itself whether it answers.
#[test]
fn cli_health_is_asked_by_a_command() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["connections=1"]);
    let port = service.address.rsplit_once(':').unwrap().1.to_string();
    let _taken = std::net::TcpStream::connect(&service.address).unwrap();
    for address in [format!("127.0.0.1:{port}"), format!("0.0.0.0:{port}")] {
        let (code, text) = folder.run(&["health", "--listen", &address]);
        assert_eq!((code, text.trim()), (0, "it answers"));
    }
    assert_eq!(service.end(), 0);
    let (code, text) = folder.run(&["health", "--listen", &format!("127.0.0.1:{port}")]);
    assert_eq!(code, 4, "{text}");
    assert!(text.contains("does not answer"), "{text}");
}

/// Where nothing can be written no work is taken: the ledger is locked by somebody else.
#[test]
fn verif_readiness_needs_a_ledger_that_can_be_written() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    client.get("/readyz").expect(200);
    let other = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    other.execute_batch("BEGIN IMMEDIATE").unwrap();
    wait_for("it is not ready", || {
        let answer = client.get("/readyz");
        answer.status == 503 && answer.text().contains("the store does not work")
    });
    client.get("/healthz").expect(200);
    other.execute_batch("ROLLBACK").unwrap();
    wait_for("it is ready again", || client.get("/readyz").status == 200);
}

/// Where the disk is too full no work is taken.
#[test]
fn cli_readiness_needs_space_on_the_disk() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["free_mib=1000000000"]);
    let problem = service.client().get("/readyz").expect(503).json();
    assert_eq!(problem["limit"]["name"], "free_bytes", "{problem}");
}

/// The figures say whose work takes the places, and how much is stored at the moment.
#[test]
fn verif_the_figures_say_whose_work_it_is() {
    let folder = Folder::new();
    let scopes = "read,submit,delete,admin";
    let (ann, zoe) = (
        folder.token("ann", scopes),
        folder.token("zoe \"z\"", scopes),
    );
    let service = Service::start(&folder, &[]);
    let (ann, zoe) = (service.client().bearer(&ann), service.client().bearer(&zoe));
    let figures = || samples(&ann.get("/metrics").expect(200).text());
    let id = ann.upload("burst.csv")["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    zoe.post("/v1/verdicts?wait=60", &question).expect(200);
    let busy = |owner: &str, work: &str| {
        let name = "latchgate_owner_busy_seconds_total";
        let key = format!("{name}{{owner=\"{owner}\",work=\"{work}\"}}");
        figures().get(&key).copied().unwrap_or(0.0)
    };
    wait_for("their work is counted", || {
        busy("ann", "orders") > 0.0 && busy(r#"zoe \"z\""#, "jobs") > 0.0
    });
    assert_eq!(busy("ann", "jobs"), 0.0);
    let stored = || figures()["latchgate_stored_bytes"];
    let on_disk = || -> f64 {
        let folders = std::fs::read_dir(folder.data().join("blobs")).unwrap();
        let folders = folders.map(|entry| entry.unwrap().path());
        let files = folders.flat_map(|folder| std::fs::read_dir(folder).unwrap());
        files
            .map(|file| file.unwrap().metadata().unwrap().len() as f64)
            .sum()
    };
    assert!(on_disk() > 0.0);
    wait_for("all that lies there is counted", || stored() == on_disk());
    let path = format!("/v1/recordings/{}", id.as_str().unwrap());
    ann.send("DELETE", &path, b"").expect(200);
    wait_for("what went is counted no more", || stored() == on_disk());
}
