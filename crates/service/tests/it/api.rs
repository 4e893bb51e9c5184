//! The interface by its routes: what is asked and what comes back.

use crate::support::{Client, Folder, Service, root, signal, wait_for, without_run};
use serde_json::{Value, json};
use std::process::Command;

#[track_caller]
fn check_verdict(client: &Client, asking: &Value) -> Vec<u8> {
    client.post("/v1/verdicts?wait=60", asking).expect(200).body
}

/// The document is that of the command line, byte for byte but for the run itself.
#[test]
fn cli_the_document_is_that_of_the_command_line() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let program =
        std::path::Path::new(crate::support::PROGRAM).with_file_name("examples/latchgate");
    for (name, options, request) in [
        ("burst.csv", &[][..], json!({})),
        (
            "surviving.csv",
            &["--members", "512"][..],
            json!({"members": 512}),
        ),
        (
            "surviving.csv",
            &["--members", "0", "--transfer", "0.9..1"],
            json!({"members": 0, "transfer": "0.9..1"}),
        ),
        (
            "half_sine_30g_11ms.csv",
            &["--opens-when", "both", "--members", "0"],
            json!({"opens_when": "both", "members": 0}),
        ),
    ] {
        let id = client.upload(name)["id"].clone();
        let served = check_verdict(&client, &json!({"recording": id, "request": request}));
        let document: Value = serde_json::from_slice(&served).unwrap();
        let report = document["report_id"].as_str().unwrap();
        let out = folder.0.join(format!("report-{report}"));
        let status = Command::new(&program)
            .arg("replay")
            .arg(root().join("signals").join(name))
            .args(options)
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap();
        assert!(
            status.stderr.is_empty(),
            "{}",
            String::from_utf8_lossy(&status.stderr)
        );
        let written = std::fs::read(out.join("verdict.json")).unwrap();
        assert_eq!(without_run(&served), without_run(&written), "{name}");
        for file in ["report.html", "event.svg", "series.csv"] {
            let served = client
                .get(&format!("/v1/verdicts/{report}/{file}"))
                .expect(200)
                .body;
            assert!(
                served == std::fs::read(out.join(file)).unwrap(),
                "{name}: {file}"
            );
        }
    }
}

#[test]
fn cli_an_upload_is_known_again() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let path = "/v1/recordings?name=burst.csv";
    let first = client.send("POST", path, &signal("burst.csv")).expect(201);
    let again = client.send("POST", path, &signal("burst.csv")).expect(200);
    assert_eq!(first.json(), again.json());
    let recording = first.json();
    assert_eq!(recording["channel"], "acceleration y (g)");
    assert_eq!(recording["channels"][0]["samples"], 6001);
    assert!(recording["findings"].is_array() && recording["candidates"].is_array());
    let id = recording["id"].as_str().unwrap();
    let got = client
        .get(&format!("/v1/recordings/{id}"))
        .expect(200)
        .json();
    assert_eq!(got, recording);
    // Under another name it is another recording: readers go by names.
    let other = client.send("POST", "/v1/recordings?name=b.csv", &signal("burst.csv"));
    assert_ne!(other.expect(201).json()["id"], recording["id"]);
}

/// A form may be as large as the raw file: browsers send forms.
#[test]
fn cli_a_large_recording_is_taken_as_a_form() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["upload_mib=4"]);
    let client = service.client();
    let table = |rows: usize| format!("t_s,acc_y_g\n{}", "0.0001,1\n".repeat(rows));
    let kept = client.upload_bytes("long.csv", table(300_000).as_bytes(), None);
    assert!(kept.expect(201).json()["bytes"].as_u64().unwrap() > 2 << 20);
    let refused = client.upload_bytes("longer.csv", table(700_000).as_bytes(), None);
    assert_eq!(refused.expect(413).json()["limit"]["name"], "upload_bytes");
}

#[test]
fn cli_settings_read_a_recording_otherwise() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let table = "Some export\n0;0,5\n0,001;0,7\n0,002;0,1\n0,003;0,2\n0,004;0,3\n";
    let uploaded = client
        .send("POST", "/v1/recordings?name=a.csv", table.as_bytes())
        .expect(201);
    let id = uploaded.json()["id"].as_str().unwrap().to_string();
    let path = |request: &str| format!("/v1/recordings/{id}?request={request}");
    let read = client
        .get(&path(
            "%7B%22skip_lines%22:1,%22decimal%22:%22,%22,%22time_column%22:%221%22%7D",
        ))
        .expect(200)
        .json();
    assert_eq!(read["channels"][0]["samples"], 5, "{read}");
    assert_eq!(read["preview"][0], "Some export");
    let slip = client
        .get(&path("%7B%22skip_line%22:1%7D"))
        .expect(400)
        .json();
    assert!(
        slip["detail"]
            .as_str()
            .unwrap()
            .contains("did you mean `skip_lines`?"),
        "{slip}"
    );
}

#[test]
fn cli_a_verdict_lasts_and_is_listed() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let asking =
        json!({"recording": id, "request": {"members": 128}, "set": ["lever.preload_torque_nm=3"]});
    let first = client.post("/v1/verdicts?wait=60", &asking).expect(200);
    let document = first.json();
    assert_eq!(
        document["design"]["modified"],
        json!(["lever.preload_torque_nm"])
    );
    let report = document["report_id"].as_str().unwrap();
    assert_eq!(
        first.header("location"),
        Some(format!("/v1/verdicts/{report}").as_str())
    );
    // The same question has the same answer, from the store: the run is that of the first time.
    assert_eq!(
        client.post("/v1/verdicts", &asking).expect(200).body,
        first.body
    );
    let path = format!("/v1/verdicts/{report}");
    let got = client.get(&path).expect(200);
    assert_eq!(got.body, first.body);
    assert_eq!(
        client.get(&format!("{path}.json")).expect(200).body,
        first.body
    );
    let tag = got.header("etag").unwrap().to_string();
    assert_eq!(got.header("cache-control"), Some("private, no-cache"));
    let known = client.clone().with("If-None-Match", &tag);
    let unchanged = known.get(&path).expect(304);
    // A browser takes the headers of a 304 for its copy.
    for name in ["cache-control", "content-security-policy", "etag"] {
        assert_eq!(unchanged.header(name), got.header(name), "{name}");
    }
    let listed = client.get("/v1/verdicts?filter=burst&verdict=pass").json();
    let fail = client.get("/v1/verdicts?filter=burst&verdict=fail").json();
    let both =
        listed["verdicts"].as_array().unwrap().len() + fail["verdicts"].as_array().unwrap().len();
    assert_eq!(both, 1, "{listed} {fail}");
    assert_eq!(
        client.get("/v1/verdicts?filter=nothing").json()["verdicts"],
        json!([])
    );
}

#[test]
fn cli_lists_come_in_parts() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("surviving.csv")["id"].clone();
    for torque in 0..5 {
        let set = format!("lever.preload_torque_nm=1.{torque}");
        check_verdict(
            &client,
            &json!({"recording": id, "request": {"members": 0}, "set": [set]}),
        );
    }
    let mut seen = Vec::new();
    let mut cursor = String::new();
    loop {
        let part = client
            .get(&format!("/v1/verdicts?limit=2{cursor}"))
            .expect(200)
            .json();
        for entry in part["verdicts"].as_array().unwrap() {
            seen.push(entry["report_id"].as_str().unwrap().to_string());
        }
        match part["next"].as_i64() {
            Some(next) => cursor = format!("&cursor={next}"),
            None => break,
        }
    }
    assert_eq!(seen.len(), 5);
    seen.dedup();
    assert_eq!(seen.len(), 5);
}

#[test]
fn cli_designs_have_versions() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let keep = |torque: f64| {
        let design = json!({"base": "paper", "lever": {"preload_torque_nm": torque}});
        let kept = client.post("/v1/designs", &json!({"name": "stiff", "design": design}));
        kept.expect(201).json()["reference"]
            .as_str()
            .unwrap()
            .to_string()
    };
    assert_eq!(keep(2.0), "stiff@1");
    assert_eq!(keep(3.0), "stiff@2");
    assert_eq!(keep(3.0), "stiff@2");
    let first = client.get("/v1/designs/stiff@1").expect(200).json();
    assert_eq!(first["design"]["lever"]["preload_torque_nm"], 2.0);
    let id = client.upload("burst.csv")["id"].clone();
    let of = |design: Value| {
        let asking = json!({"recording": id, "request": {"members": 0}, "design": design});
        let document: Value = serde_json::from_slice(&check_verdict(&client, &asking)).unwrap();
        document["report_id"].clone()
    };
    assert_eq!(
        of(json!("stiff@1")),
        of(json!({"name": "stiff", "base": "paper", "lever": {"preload_torque_nm": 2.0}})),
        "without a name of its own it has that under which it is kept"
    );
    let made = json!({"name": "stiffer", "design": "stiff@2", "set": ["stop.restitution=0.7"]});
    let made = client.post("/v1/designs", &made).expect(201).json();
    assert_eq!(made["design"]["lever"]["preload_torque_nm"], 3.0);
    assert_eq!(
        (&made["design"]["name"], &made["design"]["modified"]),
        (&json!("stiffer"), &json!([]))
    );
    let page = client.get("/designs?baseline=stiff@1").expect(200).text();
    assert!(
        page.contains("restitution of the stop 0.7 (was 0.8)"),
        "{page}"
    );
    assert_ne!(of(json!("stiff@1")), of(json!("stiff")));
    client
        .post(
            "/v1/verdicts",
            &json!({"recording": id, "design": "stiff@7"}),
        )
        .expect(404);
    let slip = json!({"recording": id, "design": {"base": "paper", "lever": {"mas_kg": 1}}});
    let slip = client.post("/v1/verdicts", &slip).expect(400).json();
    assert!(
        slip["detail"].as_str().unwrap().contains("mass_kg"),
        "{slip}"
    );
}

/// An inertia catch and a second in-plane channel are judged as from the command line: −5 g opens the lever to
/// 0.157 rad, beside the catch to no more than where that stops it, and with 100 g inwards not to its limit.
#[test]
fn verif_catch_and_second_channel_are_judged() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let shape = |t: f64| (t / 0.005).min((0.020 - t) / 0.005).clamp(0.0, 1.0);
    let row = |k: i32| {
        let t = f64::from(k) * 1e-4;
        format!("{t:.4},{:e},{:e}\n", 100.0 * shape(t), -5.0 * shape(t))
    };
    let rows: String = (-200..2000).map(row).collect();
    let table = format!("t_s,acc_x_g,acc_y_g\n{rows}");
    let card = "synthetic = true\nopens_when = \"negative\"\n";
    let id = client
        .upload_bytes("two.csv", table.as_bytes(), Some(card.as_bytes()))
        .expect(201)
        .json()["id"]
        .clone();
    let directions = json!({"axis": [0.0, 0.0, 1.0], "center_of_mass": [-0.065, 0.0, 0.0]});
    let catch = json!({
        "moment_of_inertia_kg_m2": 1e-6, "pivot_damping_nm_s_per_rad": 1e-6,
        "spring_stiffness_nm_per_rad": 0.002, "preload_torque_nm": 3.7e-4, "unbalance_kg_m": 4.8e-5,
        "engagement_angle_rad": 0.15, "end_stop_angle_rad": 0.3, "lever_angle_rad": 0.06,
        "rest_restitution": 0.4, "end_stop_restitution": 0.4, "engagement_restitution": 0.3,
        "reversible": true
    });
    let known = json!({"preload_torque_nm": 0.0, "mass_kg": 0.0});
    let cases = [
        (
            json!({"name": "alone", "base": "paper"}),
            None,
            "fail",
            0.15..0.16,
        ),
        (
            json!({"name": "caught", "base": "paper", "catch": catch, "tolerance": known}),
            None,
            "pass",
            0.06..0.060_001,
        ),
        (
            json!({"name": "across", "base": "paper", "lever": directions, "tolerance": known}),
            Some("acc_x_g"),
            "pass",
            0.09..0.091,
        ),
    ];
    for (design, second, verdict, peaks) in cases {
        let request = json!({"channel": "acc_y_g", "radial_channel": second, "members": 0});
        let asking = json!({"recording": id, "request": request, "design": design});
        let document: Value = serde_json::from_slice(&check_verdict(&client, &asking)).unwrap();
        assert_eq!(document["verdict"], verdict, "{}", document["why"]);
        let peak = document["nominal"]["peak_angle_rad"].as_f64().unwrap();
        assert!(peaks.contains(&peak), "{design}: {peak}");
    }
}

/// A pass waits for the factors from the sensor to the latch, and takes them as a number or a text; a wrong range is
/// the message of its field.
#[test]
fn verif_a_pass_waits_for_the_factors_to_the_latch() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let push = |t: f64| 12.0 * (t / 0.06 * std::f64::consts::PI).sin().max(0.0);
    let row = |k: i32| {
        let t = f64::from(k) * 1e-4;
        let push = if (0.0..0.06).contains(&t) {
            push(t)
        } else {
            0.0
        };
        format!("{t:.4},{:.6}\n", push + 0.02 * (t * 9_100.0).sin())
    };
    let rows: String = (-500..=2500).map(row).collect();
    let table = format!("time_s,acc_y_g\n{rows}");
    let id = client
        .upload_bytes("push.csv", table.as_bytes(), None)
        .expect(201)
        .json()["id"]
        .clone();
    for (transfer, verdict) in [
        (Value::Null, "undecided"),
        (json!(1), "pass"),
        (json!("0.8..1.5"), "pass"),
    ] {
        let request = json!({"opens_when": "negative", "members": 0, "transfer": transfer});
        let asking = json!({"recording": id, "request": request});
        let document: Value = serde_json::from_slice(&check_verdict(&client, &asking)).unwrap();
        assert_eq!(
            document["verdict"], verdict,
            "{transfer}: {}",
            document["why"]
        );
    }
    for wrong in [
        json!("2..1"),
        json!(0),
        json!(-1.0),
        json!("much"),
        json!([1, 2]),
    ] {
        let request = json!({"opens_when": "negative", "members": 0, "transfer": wrong});
        let asking = json!({"recording": id, "request": request});
        let problem = client.post("/v1/verdicts", &asking).expect(400).json();
        assert!(
            problem["detail"].to_string().contains("transfer"),
            "{problem}"
        );
    }
}

/// A what-if is the nominal run of the same question, and is kept nowhere.
#[test]
fn cli_a_what_if_is_the_nominal_run() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let asking = json!({"recording": id, "set": ["lever.preload_torque_nm=2.5"]});
    let quick = client.post("/v1/what-if", &asking).expect(200).json();
    assert_eq!(client.get("/v1/verdicts").json()["verdicts"], json!([]));
    let document: Value = serde_json::from_slice(&check_verdict(&client, &asking)).unwrap();
    assert_eq!(quick["nominal"], document["nominal"]);
    assert!(quick["ensemble"].is_null() && document["ensemble"].is_object());
}

#[test]
fn cli_a_job_tells_its_steps() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let accepted = client
        .post("/v1/verdicts?wait=0", &json!({"recording": id}))
        .expect(202);
    let place = accepted.header("location").unwrap().to_string();
    let events = client.get(&format!("{place}/events")).expect(200).text();
    assert!(events.contains("event: done"), "{events}");
    let standing = client.get(&place).expect(200).json();
    assert_eq!(standing["state"], "done");
    client
        .get(standing["verdict"].as_str().unwrap())
        .expect(200);
    // Asked again, the end is told at once.
    assert!(
        client
            .get(&format!("{place}/events"))
            .expect(200)
            .text()
            .contains("event: done")
    );
}

/// The verdict of a question is told before its advice and report are there.
#[test]
fn verif_a_verdict_is_told_before_its_advice() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("surviving.csv")["id"].clone();
    let accepted = client.post("/v1/verdicts?wait=0", &json!({ "recording": id }));
    let place = accepted.expect(202).json()["job"]
        .as_str()
        .unwrap()
        .to_string();
    let told = client
        .get(&format!("/v1/jobs/{place}/events"))
        .expect(200)
        .text();
    let steps = told.lines().filter_map(|line| line.strip_prefix("data: "));
    let steps: Vec<Value> = steps
        .map(|step| serde_json::from_str(step).unwrap())
        .collect();
    let known = steps.iter().find(|step| step["first_answer"].is_object());
    let known = known.unwrap_or_else(|| panic!("{told}"));
    assert_eq!(known["state"], "running");
    let done = steps.last().unwrap();
    let verdict = client
        .get(done["verdict"].as_str().unwrap())
        .expect(200)
        .json();
    assert_eq!(known["first_answer"]["verdict"], verdict["verdict"]);
    assert!(verdict["preload_answer"].is_object(), "{verdict:#}");
    let headline = known["first_answer"]["headline"].as_str().unwrap();
    let listed = client.get("/v1/verdicts").expect(200).text();
    assert!(listed.contains(headline), "{headline}: {listed}");
}

/// All that a page loads is small: the script below 40 kB, everything below 200 kB.
#[test]
fn tidy_the_page_is_small() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let question = json!({"recording": id, "request": {"members": 128}});
    let verdict = client
        .post("/v1/verdicts?wait=60", &question)
        .expect(200)
        .json();
    let page = format!("/verdicts/{}", verdict["report_id"].as_str().unwrap());
    let page = client.get(&page).expect(200).text();
    let mut bytes = page.len();
    for name in page.split('"').filter(|text| text.starts_with("/assets/")) {
        bytes += client.get(name).expect(200).body.len();
    }
    assert!(bytes < 200_000, "{bytes}");
    let script = client.get("/assets/app.js").expect(200).body.len();
    assert!(script < 40_000, "{script}");
}

/// Errors name limit, value, place and the way out, in words of HTTP.
#[test]
fn cli_problems_say_what_to_do() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["upload_mib=1"]);
    let client = service.client();
    let large = client
        .send("POST", "/v1/recordings?name=a.csv", &vec![b'1'; 2 << 20])
        .expect(413);
    assert_eq!(
        large.header("content-type"),
        Some("application/problem+json")
    );
    assert_eq!(large.json()["limit"]["value"], 1 << 20);
    let several = "t_s,a_g,b_g\n0,1,1\n0.001,2,1\n0.002,1,1\n0.003,1,2\n";
    let id = client
        .send("POST", "/v1/recordings?name=two.csv", several.as_bytes())
        .expect(201);
    let id = id.json()["id"].clone();
    let asked = client
        .post("/v1/verdicts?wait=60", &json!({"recording": id}))
        .expect(422)
        .json();
    assert_eq!(asked["verdict"], "unusable");
    assert_eq!(asked["candidates"], json!(["a_g"]), "{asked}");
    let detail = asked["detail"].as_str().unwrap();
    assert!(
        detail.contains("the field `request.channel` = NAME"),
        "{detail}"
    );
    assert_eq!(asked["document"]["verdict"], "unusable");
    let limited = json!({"recording": id, "request": {"channel": "a_g", "limit": {"lines": 2}}});
    let limited = client
        .post("/v1/verdicts?wait=60", &limited)
        .expect(422)
        .json();
    assert_eq!(limited["limit"]["name"], "lines", "{limited}");
    assert!(
        limited["detail"]
            .as_str()
            .unwrap()
            .contains("`request.limit.lines`"),
        "{limited}"
    );
    client
        .post("/v1/verdicts", &json!({"recording": "0".repeat(64)}))
        .expect(404);
    client.get("/v1/nothing").expect(404);
    client.send("DELETE", "/v1/verdicts", &[]).expect(405);
    for path in [
        "/v1/verdicts?limit=abc",
        "/v1/gates?limit=x",
        "/v1/recordings?limit=abc",
    ] {
        let answer = client.get(path).expect(400);
        let kind = answer.header("content-type");
        assert_eq!(kind, Some("application/problem+json"), "{path}");
    }
    for name in ["../a.csv", "/a.csv", "a//b.csv", "a%5Cb.csv"] {
        client
            .send("POST", &format!("/v1/recordings?name={name}"), b"1")
            .expect(400);
    }
}

#[test]
fn cli_the_description_is_the_committed_one() {
    let (code, text) = Folder::new().run(&["openapi"]);
    assert_eq!(code, 0);
    let committed = std::fs::read_to_string(root().join("crates/service/openapi.json")).unwrap();
    assert!(
        text == committed,
        "renew it: latchgate-serve openapi > crates/service/openapi.json"
    );
}

#[test]
fn cli_health_limits_and_counters_are_told() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    assert_eq!(client.get("/healthz").expect(200).text(), "ok\n");
    assert_eq!(client.get("/readyz").expect(200).text(), "ready\n");
    let limits = client.get("/v1/limits").expect(200).json();
    assert!(limits["jail"]["seccomp"].is_boolean(), "{limits}");
    assert!(limits["limits"].as_array().unwrap().len() > 20);
    assert!(
        client
            .get("/metrics")
            .expect(200)
            .text()
            .contains("latchgate_jobs_queued 0")
    );
}

#[test]
fn cli_the_configuration_tells_its_origins() {
    let folder = Folder::new();
    let file = folder.0.join("service.toml");
    std::fs::write(&file, "queue = 7\nrate_per_s = 9\n").unwrap();
    let output = Command::new(crate::support::PROGRAM)
        .args([
            "config",
            "show",
            "--origin",
            "--set",
            "own_queue=3",
            "--config",
        ])
        .arg(&file)
        .env("LATCHGATE_SERVE_RATE_PER_S", "11")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let line = |key: &str| text.lines().find(|line| line.starts_with(key)).unwrap();
    assert!(
        line("queue =").ends_with("# file ".to_string().as_str())
            || line("queue =").contains("# file ")
    );
    assert_eq!(
        line("rate_per_s ="),
        "rate_per_s = \"11\"  # environment LATCHGATE_SERVE_RATE_PER_S"
    );
    assert_eq!(line("own_queue ="), "own_queue = \"3\"  # command line");
    assert_eq!(line("order_s ="), "order_s = \"120\"  # default");
    let (code, text) = folder.run(&["--set", "qeue=1", "config", "show"]);
    assert_eq!(code, 4);
    assert!(text.contains("unknown key `qeue`"), "{text}");
}

/// What was found out about a table is told, and what a person states takes its place.
#[test]
fn cli_a_table_says_how_it_was_understood() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let check = |text: &str, request: &str, expected: &Value| {
        let id = client
            .upload_bytes("table.csv", text.as_bytes(), None)
            .json()["id"]
            .clone();
        let path = format!("/v1/recordings/{}?request={request}", id.as_str().unwrap());
        let listing = client.get(&path).expect(200).json();
        let mapping = listing["mapping"].as_object();
        let mapping = mapping.unwrap_or_else(|| panic!("{text}: {listing}"));
        for (key, value) in expected.as_object().unwrap() {
            assert_eq!(&mapping[key], value, "{key}: {listing}");
        }
    };
    let plain = "t_s,acc_y_g\n0.001,1.5\n0.002,1.6\n0.003,1.7\n";
    let found = json!({"separator": "comma", "decimal": ".", "header_line": 1, "data_line": 2,
        "time_column": "t_s", "time_unit": "s"});
    check(plain, "%7B%7D", &found);
    let german = "Pr\u{fc}fstand 3\nZeit [ms];a_y [g]\n0,1;2,5\n0,2;2,6\n0,3;2,7\n";
    let found = json!({"separator": "semicolon", "decimal": ",", "header_line": 2, "data_line": 3,
        "time_column": "Zeit [ms]", "time_unit": "ms"});
    check(german, "%7B%22header_line%22:2%7D", &found);
    let stated = "%7B%22header_line%22:2,%22time_unit%22:%22s%22%7D";
    check(german, stated, &json!({"time_unit": "s"}));
    // Lines above the names are found where they begin with a word.
    check(german, "%7B%7D", &found);
    // A number alone may be a sample, so it is asked about; where the names seem to stand is told.
    let seems =
        json!({"separator": "semicolon", "header_line": 2, "data_line": 3, "time_column": null});
    let numbered = german.replace("Pr\u{fc}fstand 3", "3");
    check(&numbered, "%7B%7D", &seems);
    let bare = "1.5\t3\n1.6\t4\n1.7\t5\n";
    let found =
        json!({"separator": "tab", "header_line": null, "data_line": 1, "time_column": null});
    check(bare, "%7B%22rate_hz%22:1000%7D", &found);
    // A file of another kind is no table.
    let zip = client
        .upload_bytes("odd.bin", b"PK\x03\x04nothing", None)
        .json();
    assert!(zip["mapping"].is_null(), "{zip}");
}

/// Designs that are stated inline and differ have names that tell them apart, in the words of the
/// report; one that is kept has name and version.
#[test]
fn cli_inline_designs_have_names_that_tell_them_apart() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    client
        .post(
            "/v1/designs",
            &json!({"name": "latch", "set": ["lever.preload_torque_nm=3"]}),
        )
        .expect(201);
    let name = |design: Value, set: Value| {
        let asking =
            json!({"recording": id, "request": {"members": 0}, "design": design, "set": set});
        let report = client
            .post("/v1/verdicts?wait=60", &asking)
            .expect(200)
            .json();
        let page = format!("/verdicts/{}", report["report_id"].as_str().unwrap());
        let page = client.get(&page).expect(200).text();
        let name = page.split("Design <strong>").nth(1).unwrap();
        name.split("</strong>").next().unwrap().to_string()
    };
    let names = [
        name(
            json!({"base": "paper", "lever": {"preload_torque_nm": 2.5}}),
            json!([]),
        ),
        name(
            json!({"base": "paper", "lever": {"preload_torque_nm": 2.6}}),
            json!([]),
        ),
        name(json!({}), json!(["lever.preload_torque_nm=2.5"])),
        name(json!("latch"), json!([])),
        name(json!("latch"), json!(["lever.preload_torque_nm=2.5"])),
    ];
    let nm = "\u{a0}N\u{b7}m";
    let expected = [
        format!("design, modified: preload torque 2.5{nm} (0.1)"),
        format!("design, modified: preload torque 2.6{nm} (0.1)"),
        format!("paper, modified: preload torque 2.5{nm} (0.1)"),
        "latch@1".to_string(),
        format!("latch@1, modified: preload torque 2.5{nm} (3)"),
    ];
    assert_eq!(names, expected);
}

/// systemd has nothing to say of the unit but that the program is not installed.
#[test]
fn tidy_the_unit_for_systemd_is_one() {
    let unit = root().join("crates/service/latchgate-serve.service");
    let output = Command::new("systemd-analyze")
        .arg("verify")
        .arg(unit)
        .output()
        .unwrap_or_else(|error| {
            panic!("systemd-analyze: {error}; install the package systemd, as tests/run does")
        });
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let own = said
        .lines()
        .filter(|line| line.contains("latchgate-serve.service"));
    let odd: Vec<&str> = own
        .filter(|line| !line.contains("is not executable"))
        .collect();
    assert!(odd.is_empty(), "{odd:?}");
}

/// systemd finds the unit little exposed: at most 1.5 of 10.
#[test]
fn tidy_the_unit_for_systemd_is_shut_in() {
    let unit = root().join("crates/service/latchgate-serve.service");
    let output = Command::new("systemd-analyze")
        .args(["security", "--offline=yes", "--threshold=15"])
        .arg(unit)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success() && said.contains("Overall exposure level"),
        "{said}"
    );
}

/// A pulse stands where a recording may: the document is that of the command line, and no word reads a file.
#[test]
fn cli_a_pulse_is_judged_as_on_the_command_line() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let program =
        std::path::Path::new(crate::support::PROGRAM).with_file_name("examples/latchgate");
    for word in [
        "pulse:sled206-33g,opens-when=positive",
        "pulse:half-sine,peak=500m/s2,duration=11ms",
    ] {
        let asking = json!({"recording": word, "request": {"members": 0}});
        let served = check_verdict(&client, &asking);
        let ran = Command::new(&program)
            .args(["replay", word, "--members", "0", "--out"])
            .arg(folder.0.join("report"))
            .output()
            .unwrap();
        assert!(matches!(ran.status.code(), Some(0 | 1)), "{ran:?}");
        let written = std::fs::read(folder.0.join("report/verdict.json")).unwrap();
        assert_eq!(without_run(&served), without_run(&written), "{word}");
        // It is a recording from then on.
        let document: Value = serde_json::from_slice(&served).unwrap();
        let list = client.get("/v1/recordings?limit=10").expect(200).json();
        let names = list["recordings"].as_array().unwrap().iter();
        let known: Vec<&str> = names.map(|entry| entry["name"].as_str().unwrap()).collect();
        let name = document["recording"]["file"].as_str().unwrap();
        assert!(known.contains(&name), "{name}: {known:?}");
    }
    for word in [
        "pulse:polyline,file=/etc/hostname",
        "pulse:half-sine,peak=30g",
        "pulse:nothing",
    ] {
        let refused = client.post("/v1/verdicts?wait=60", &json!({"recording": word}));
        assert!(
            (400..500).contains(&refused.status),
            "{word}: {}",
            refused.status
        );
    }
    // The content of an upload names no file either.
    let text = b"pulse:polyline,file=/etc/hostname".as_slice();
    let known = client
        .send("POST", "/v1/recordings?name=points", text)
        .expect(201)
        .json();
    assert!(known["problem"].is_object(), "{known}");
    let gate = "[[recordings]]\nfiles = [\"pulse:doorslam-300-6,tail=0.1s\"]\n[[designs]]\n\
                set = [\"lever.preload_torque_nm=8\"]\nname = \"stiff\"\n";
    let entry = crate::gates::decided(&client, "?name=slams", gate);
    assert_eq!(entry["exit_code"], 0, "{entry}");
}

/// A refused question or gate on pulses leaves nothing, and a pulse counts in its owner's share.
#[test]
fn regress_a_refused_question_keeps_no_pulse() {
    let folder = Folder::new();
    let pulse = |ms: u32| format!("pulse:half-sine,peak=30g,duration={ms}ms");
    let ask = |client: &crate::support::Client, ms: u32| {
        let question = json!({"recording": pulse(ms), "request": {"members": 0}});
        client.post("/v1/verdicts?wait=60", &question)
    };
    let gate = |client: &crate::support::Client, design: &str| {
        let file = format!(
            "[[recordings]]\nfiles = [\"{}\"]\n[[designs]]\n{design}\n",
            pulse(9)
        );
        client.send("POST", "/v1/gates?name=pulses", file.as_bytes())
    };
    let kept = |client: &crate::support::Client| {
        let list = client.get("/v1/recordings").expect(200).json();
        let recordings = list["recordings"].as_array().unwrap().len();
        (recordings, crate::access::blobs(&folder))
    };
    let service = Service::start(&folder, &["free_mib=1000000000"]);
    let client = service.client();
    ask(&client, 10).expect(507);
    gate(&client, "name = \"lever\"").expect(507);
    assert_eq!(kept(&client), (0, 0));
    drop(service);
    let service = Service::start(&folder, &[]);
    let client = service.client();
    gate(&client, "file = \"nowhere@1\"").expect(400);
    assert_eq!(kept(&client), (0, 0));
    drop(service);
    let service = Service::start(&folder, &["own_mib=1"]);
    let client = service.client();
    let rows = "0.0001,0.01\n".repeat(((1 << 20) - 20) / 12);
    let filler = format!("t_s,acc_y_g\n{rows}");
    let path = "/v1/recordings?name=filler.csv";
    client.send("POST", path, filler.as_bytes()).expect(201);
    let refused = ask(&client, 10).expect(507);
    assert!(refused.text().contains("own_bytes"), "{}", refused.text());
    assert_eq!(kept(&client).0, 1);
}

/// A job says what is done now, behind how many it waits, for how long, and how long its kind usually takes.
#[test]
fn cli_a_job_says_what_it_waits_for() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["places=1"]);
    let client = service.client();
    let id = client.upload("surviving.csv")["id"].clone();
    let ask = |set: &[&str], members: u64| {
        let asking = json!({"recording": id, "request": {"members": members}, "set": set});
        let accepted = client.post("/v1/verdicts?wait=0", &asking).expect(202);
        accepted.header("location").unwrap().to_string()
    };
    let standing = |place: &str| client.get(place).expect(200).json();
    let steps = |place: &str| -> Vec<Value> {
        let events = client.get(&format!("{place}/events")).expect(200).text();
        let steps = events
            .lines()
            .filter_map(|line| line.strip_prefix("data: "));
        steps
            .map(|step| serde_json::from_str(step).unwrap())
            .collect()
    };
    let first = steps(&ask(&[], 128));
    assert!(first.iter().all(|step| step["usual_s"].is_null()));
    // The children stand still, so that what comes now must wait.
    let children = service.children();
    let tell_children = |signal: &str| {
        let mut kill = std::process::Command::new("kill");
        assert!(kill.arg(signal).args(&children).status().unwrap().success());
    };
    tell_children("-STOP");
    let taken = ask(&["lever.preload_torque_nm=3"], 128);
    wait_for("it is taken", || standing(&taken)["state"] == "running");
    let (next, other) = (ask(&["lever.preload_torque_nm=4"], 128), ask(&[], 0));
    let [taken_now, next_now, other_now] = [&taken, &next, &other].map(|place| standing(place));
    let usual_s = taken_now["usual_s"].as_f64().unwrap();
    assert!(usual_s > 0.0 && taken_now["behind"].is_null());
    assert!(taken_now["since_s"].as_f64().unwrap() >= 0.0);
    assert_eq!(
        (&next_now["state"], &next_now["behind"]),
        (&json!("queued"), &json!(1))
    );
    assert_eq!(next_now["usual_s"], usual_s);
    assert!(next_now["since_s"].as_f64().unwrap() < 300.0 && next_now["doing"].is_null());
    assert_eq!(
        (&other_now["behind"], &other_now["usual_s"]),
        (&json!(2), &Value::Null)
    );
    tell_children("-CONT");
    let mut doings = std::collections::BTreeSet::new();
    for step in first.into_iter().chain(steps(&taken)).chain(steps(&next)) {
        doings.extend(step["doing"].as_str().map(String::from));
    }
    let known = ["advising", "judging", "reading", "reporting"];
    assert!(doings.contains("advising"), "{doings:?}");
    assert!(
        doings.iter().all(|doing| known.contains(&&**doing)),
        "{doings:?}"
    );
    let ended = standing(&next);
    assert_eq!(ended["state"], "done");
    assert!(
        ended["since_s"].is_null() && ended["usual_s"].is_null(),
        "{ended}"
    );
}
