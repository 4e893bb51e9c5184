//! Gates over what is stored: the same as the command line's, with progress and baseline.

use crate::support::{Client, Folder, Service, root};
use serde_json::{Value, json};
use std::fs;
use std::process::Command;

const SIGNALS: [&str; 3] = ["burst.csv", "half_sine_30g_11ms.csv", "surviving.csv"];

/// A gate over three recordings and two designs, of which one burst is let through.
const GATE: &str = r#"
require = [
    { verdict = "fail" },
    { recordings = "surviving.csv", verdict = "pass" },
    { designs = "balanced", verdict = "pass" },
]

[[recordings]]
files = ["*.csv"]

[[designs]]
name = "paper"

[[designs]]
name = "balanced"
set = { "lever.center_of_mass_m" = 0.0035 }
"#;

fn submit(client: &Client, query: &str, text: &str) -> (u16, Value) {
    let client = client.clone().with("Content-Type", "application/toml");
    let answer = client.send("POST", &format!("/v1/gates{query}"), text.as_bytes());
    (answer.status, answer.json())
}

/// Submits a gate and waits for its end by its events; returns its entry.
#[track_caller]
pub(crate) fn decided(client: &Client, query: &str, text: &str) -> Value {
    let (status, entry) = submit(client, query, text);
    assert!(matches!(status, 200 | 202), "{entry}");
    let place = format!("/v1/gates/{}", entry["id"].as_str().unwrap());
    let events = client.get(&format!("{place}/events")).expect(200).text();
    assert!(events.contains("event: done"), "{events}");
    let entry = client.get(&place).expect(200).json();
    assert_eq!(entry["state"], "done");
    entry
}

fn file(client: &Client, entry: &Value, name: &str) -> Vec<u8> {
    let id = entry["id"].as_str().unwrap();
    client
        .get(&format!("/v1/gates/{id}/{name}"))
        .expect(200)
        .body
}

/// Every file of a gate is that of the command line, byte for byte, and its pairs have the identity
/// of the verdicts.
#[test]
fn cli_a_gate_is_that_of_the_command_line() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let place = folder.0.join("gate");
    fs::create_dir(&place).unwrap();
    for name in SIGNALS {
        client.upload(name);
        for name in [name.to_string(), format!("{name}.toml")] {
            fs::copy(root().join("signals").join(&name), place.join(&name)).unwrap();
        }
    }
    fs::write(place.join("gate.toml"), GATE).unwrap();
    let entry = decided(&client, "?name=gate.toml", GATE);
    let program =
        std::path::Path::new(crate::support::PROGRAM).with_file_name("examples/latchgate");
    let ran = Command::new(program)
        .args([
            "gate",
            "gate.toml",
            "--reports",
            "none",
            "--no-store",
            "--out",
            "../out",
        ])
        .current_dir(&place)
        .output()
        .unwrap();
    assert_eq!(
        Some(i64::from(ran.status.code().unwrap())),
        entry["exit_code"].as_i64()
    );
    for name in [
        "summary.json",
        "summary.csv",
        "junit.xml",
        "summary.md",
        "index.html",
    ] {
        let written = fs::read_to_string(folder.0.join("out").join(name)).unwrap();
        // Pairs that are jobs of the service have no times.
        let mut parts = written.split(" time=\"");
        let mut expected = parts.next().unwrap().to_string();
        for part in parts {
            assert_eq!(name, "junit.xml");
            expected.push_str(part.split_once('"').unwrap().1);
        }
        let served = String::from_utf8(file(&client, &entry, name)).unwrap();
        assert!(served == expected, "{name}: {served} against {expected}");
    }
    let summary: Value = serde_json::from_slice(&file(&client, &entry, "summary.json")).unwrap();
    let pairs = summary["pairs"].as_array().unwrap();
    assert_eq!(pairs.len(), 6);
    // The verdict of a pair has the identity that the gate names.
    let burst = pairs
        .iter()
        .find(|pair| pair["recording"] == "burst.csv" && pair["design"] == "paper");
    let id = client.upload("burst.csv")["id"].clone();
    let set = json!([]);
    let verdict = client
        .post(
            "/v1/verdicts?wait=60",
            &json!({"recording": id, "set": set}),
        )
        .expect(200)
        .json();
    assert_eq!(verdict["report_id"], burst.unwrap()["row"]["report_id"]);
    // The same gate is known, whatever became of the service meanwhile.
    drop(service);
    let service = Service::start(&folder, &[]);
    let (status, again) = submit(&service.client(), "?name=gate.toml", GATE);
    assert_eq!((status, &again), (200, &entry));
    assert_eq!(folder.run(&["fsck"]).0, 0);
}

/// The full report of a pair that is not as required is that of the command line: `verdict.json` byte
/// for byte but for `run`, the other files but for that and what names it.
#[test]
fn cli_reports_of_a_gate_are_those_of_the_command_line() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let place = folder.0.join("gate");
    fs::create_dir(&place).unwrap();
    for name in SIGNALS {
        client.upload(name);
        for name in [name.to_string(), format!("{name}.toml")] {
            fs::copy(root().join("signals").join(&name), place.join(&name)).unwrap();
        }
    }
    let gate = GATE.replace("{ verdict = \"fail\" },", "");
    fs::write(place.join("gate.toml"), &gate).unwrap();
    let entry = decided(&client, "?name=gate.toml", &gate);
    let program =
        std::path::Path::new(crate::support::PROGRAM).with_file_name("examples/latchgate");
    let arguments = ["gate", "gate.toml", "--no-store", "--out", "../out"];
    let ran = Command::new(program)
        .args(arguments)
        .current_dir(&place)
        .output()
        .unwrap();
    assert_eq!(ran.status.code(), Some(1));
    let mut compared = 0;
    let mut open = vec![folder.0.join("out")];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(&path).unwrap().map(|own| own.unwrap().path()));
        } else if path.ends_with("verdict.json") {
            let written = fs::read(&path).unwrap();
            let document: Value = serde_json::from_slice(&written).unwrap();
            let id = document["report_id"].as_str().unwrap();
            let address = format!("/v1/verdicts/{id}/verdict.json");
            crate::support::wait_for("the report", || client.get(&address).status == 200);
            let served = client.get(&address).body;
            let [served, written] = [&served, &written].map(|own| crate::support::without_run(own));
            assert!(served == written, "{id}");
            // The command line's gates have the series in the page alone.
            let page = fs::read_to_string(path.with_file_name("report.html")).unwrap();
            let address = format!("/v1/verdicts/{id}/series.csv");
            let series = String::from_utf8(client.get(&address).body).unwrap();
            assert!(
                series.len() > 1000 && page.contains(series.trim_end()),
                "{id}"
            );
            compared += 1;
        }
    }
    assert_eq!(Some(compared), entry["not_as_required"].as_u64());
    assert!(compared > 0);
}

/// Against a baseline: what fails newly is told, pages show it first, what vanished is an error, and
/// what is not as required has a full report.
#[test]
fn cli_a_gate_is_held_against_its_baseline() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    for name in SIGNALS {
        client.upload(name);
    }
    let design = |torque: f64| {
        let body = json!({"name": "lever", "set": [format!("lever.preload_torque_nm={torque}"), "lever.center_of_mass_m=0.0035"]});
        client.post("/v1/designs", &body).expect(201);
    };
    design(0.1);
    let gate = "require = \"pass\"\n[[recordings]]\nfiles = [\"burst.csv\", \"surviving.csv\"]\n\
                [[designs]]\nname = \"lever\"\nfile = \"lever\"\n";
    let first = decided(&client, "?name=latch", gate);
    assert_eq!(first["exit_code"], 0, "{first}");
    // A version without the balance opens.
    client
        .post("/v1/designs", &json!({"name": "lever"}))
        .expect(201);
    let id = first["id"].as_str().unwrap();
    let second = decided(&client, &format!("?name=latch&baseline={id}"), gate);
    assert_eq!(second["exit_code"], 1, "{second}");
    let summary: Value = serde_json::from_slice(&file(&client, &second, "summary.json")).unwrap();
    assert_eq!(
        summary["baseline"]["newly_failing"],
        json!([["burst.csv", "lever"]])
    );
    let page = format!("/gates/{}", second["id"].as_str().unwrap());
    let shown = client.get(&page).expect(200).text();
    let (changed, matrix) = (shown.find("newly failing"), shown.find("id=\"matrix\""));
    assert!(changed.unwrap() < matrix.unwrap());
    assert!(shown.contains("◆ newly failing"));
    // The pair leads to its report, which was made because it is not as required.
    crate::support::wait_for("the full report", || {
        client.get(&format!("{page}/runs/0")).status == 303
    });
    // A stored design has the name that its file would have: a question about it is the same.
    let recording = client.upload("burst.csv")["id"].clone();
    let verdict = client.post(
        "/v1/verdicts?wait=60",
        &json!({"recording": recording, "design": "lever@2"}),
    );
    let verdict = verdict.expect(200).json();
    assert_eq!(
        verdict["report_id"],
        summary["pairs"][0]["row"]["report_id"]
    );
    let listed = client.get("/v1/verdicts").json();
    assert_eq!(listed["verdicts"][0]["design_version"], "lever@2");
    let alone = client.get(&format!("{page}/runs/1")).expect(200).text();
    assert!(alone.contains("Make the report"), "{alone}");
    let fewer = gate.replace(", \"surviving.csv\"", "");
    let third = decided(&client, &format!("?name=latch&baseline={id}"), &fewer);
    assert_eq!(third["exit_code"], 4, "a pair vanished: {third}");
    let listed = client.get("/v1/gates").expect(200).json();
    assert_eq!(listed["gates"].as_array().unwrap().len(), 3);
    client.get("/gates").expect(200);
}

/// What does not fit is told at once, each at its line, and nothing is judged.
#[test]
fn cli_a_gate_that_does_not_fit_is_refused() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["gate_pairs=2"]);
    let client = service.client();
    for name in SIGNALS {
        client.upload(name);
    }
    let (status, problem) = submit(&client, "", GATE);
    assert_eq!(
        (status, &problem["limit"]["name"]),
        (413, &json!("gate_pairs"))
    );
    let wrong = "require = \"pas\"\n[[recordings]]\nfiles = \"other.csv\"\n[[designs]]\nfile = \"none@2\"\n";
    let (status, problem) = submit(&client, "", wrong);
    assert_eq!(
        (status, &problem["code"]),
        (400, &json!("bad-gate")),
        "{problem}"
    );
    let wrong = wrong.replace("pas\"", "pass\"");
    let (status, problem) = submit(&client, "", &wrong);
    assert_eq!(status, 400);
    let detail = problem["detail"].as_str().unwrap();
    assert!(
        detail.contains("other.csv") && detail.contains("gate:2") && detail.contains("none@2"),
        "{detail}"
    );
    let one = "[[recordings]]\nfiles = \"burst.csv\"\n[[designs]]\nname = \"paper\"\n";
    let (status, problem) = submit(&client, "?baseline=0", one);
    assert_eq!(status, 404, "{problem}");
    let (status, _) = submit(&client, "?date=tomorrow", one);
    assert_eq!(status, 400);
    assert_eq!(client.get("/v1/gates").json()["gates"], json!([]));
    // Patterns and rules that would take long are no way to hold the service up.
    let before = service.processor_time();
    let name = "a".repeat(200);
    client
        .send(
            "POST",
            &format!("/v1/recordings?name={name}"),
            b"t_s,acceleration y\n0,1\n",
        )
        .expect(201);
    let pattern = format!("{}b", "*a".repeat(60));
    assert_eq!(
        submit(&client, "", &one.replace("burst.csv", &pattern)).0,
        400
    );
    let rules = "[[require]]\nverdict = \"pass\"\n".repeat(1001);
    let (status, problem) = submit(&client, "", &format!("{one}{rules}"));
    assert_eq!(
        (status, &problem["limit"]["name"]),
        (413, &json!("gate_rules"))
    );
    let used = service.processor_time() - before;
    assert!(used < std::time::Duration::from_secs(2), "{used:?}");
    // A recording that cannot be read is unusable, and no gate passes with it.
    client
        .send("POST", "/v1/recordings?name=odd.csv", b"nothing of a table")
        .expect(201);
    let odd = one.replace("burst.csv", "odd.csv");
    assert_eq!(decided(&client, "", &odd)["exit_code"], 4);
}

/// Waits until a gate has ended; returns its entry.
#[track_caller]
fn ended(client: &Client, id: &Value) -> Value {
    let place = format!("/v1/gates/{}", id.as_str().unwrap());
    let mut entry = Value::Null;
    crate::support::wait_for("the gate", || {
        entry = client.get(&place).expect(200).json();
        entry["state"] != "running"
    });
    entry
}

/// The outcome of a gate is made when its last pair is decided, whether or not anybody looks.
#[test]
fn cli_an_outcome_waits_for_nobody() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    for name in SIGNALS {
        client.upload(name);
    }
    let gate = GATE.replace("{ verdict = \"fail\" },", "");
    assert_eq!(submit(&client, "", &gate).0, 202);
    // The full reports of what is not as required are asked for with the outcome.
    crate::support::wait_for("the reports", || {
        let listed = client.get("/v1/verdicts").json();
        !listed["verdicts"].as_array().unwrap().is_empty()
    });
}

/// A pair that a busy machine did not get judged is no word against its recording: the gate has no
/// summary, says so, and goes on where it is submitted again.
#[test]
fn regress_a_pair_that_was_late_is_no_verdict() {
    let folder = Folder::new();
    let mut table = String::from("t_s,acc_y_g\n");
    for sample in 0..300_000 {
        let push = if sample % 40 < 20 { -40 } else { 30 };
        table += &format!("{:.5},{push}\n", f64::from(sample) * 1e-5);
    }
    let gate = "require = \"fail\"\n[[recordings]]\nfiles = \"slow.csv\"\nopens_when = \"both\"\n[[designs]]\nname = \"paper\"\n";
    let service = Service::start(&folder, &["order_s=1", "silence_s=1"]);
    let client = service.client();
    client
        .send("POST", "/v1/recordings?name=slow.csv", table.as_bytes())
        .expect(201);
    let (status, entry) = submit(&client, "", gate);
    assert_eq!(status, 202, "{entry}");
    let lost = ended(&client, &entry["id"]);
    assert_eq!(
        (&lost["state"], &lost["exit_code"], &lost["files"]),
        (&json!("failed"), &json!(4), &json!([]))
    );
    let problem = &lost["problem"];
    assert_eq!(problem["code"], "pairs-not-judged", "{problem}");
    let detail = problem["detail"].as_str().unwrap();
    assert!(
        detail.contains("1 of 1 pairs") && detail.contains("longer than 1 s"),
        "{detail}"
    );
    assert_eq!(service.end(), 0);
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let (status, entry) = submit(&client, "", gate);
    assert_eq!(status, 202, "{entry}");
    let done = ended(&client, &entry["id"]);
    assert_eq!(done["state"], "done", "{done}");
    let summary: Value = serde_json::from_slice(&file(&client, &done, "summary.json")).unwrap();
    let row = summary.to_string();
    // What the samples say, and no word of time.
    assert!(row.contains("dead-sensor"), "{row}");
}
