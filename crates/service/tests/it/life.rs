//! The life of what is stored: deleted, expired, lost and made again, opened where nothing can be
//! written, taken over from an earlier version.

use crate::access::blobs;
use crate::damage::blob_of;
use crate::support::{Client, Folder, Service, signal, wait_for, without_run};
use latchgate_service::clock::now_ms;
use latchgate_service::store::{BlobFolder, Blobs, Ledger, Manifest, SqliteLedger};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;

/// Uploads `burst.csv` and has it judged; returns its path and that of the verdict.
fn judged(client: &Client) -> (String, String) {
    let id = client.upload("burst.csv")["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    let verdict = client.post("/v1/verdicts?wait=60", &question).expect(200);
    let place = verdict.header("location").unwrap().to_string();
    (format!("/v1/recordings/{}", id.as_str().unwrap()), place)
}

fn bytes_in(folder: &Folder, wanted: &[u8]) -> bool {
    let files = walk(&folder.data());
    files.iter().any(|path| {
        let bytes = fs::read(path).unwrap_or_default();
        bytes.windows(wanted.len()).any(|window| window == wanted)
    })
}

fn walk(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        if entry.path().is_dir() {
            found.extend(walk(&entry.path()));
        } else {
            found.push(entry.path());
        }
    }
    found
}

/// Of a recording that is deleted the samples go, with every curve made of them; its verdict's
/// document and who deleted it stay. Uploaded again it is judged again, and its report is whole.
#[test]
fn cli_a_recording_is_deleted() {
    let folder = Folder::new();
    let tokens = ["read,submit", "read,delete"].map(|scopes| folder.token("ada", scopes));
    let service = Service::start(&folder, &[]);
    let [writer, deleter] = tokens.map(|token| service.client().bearer(&token));
    let (recording, verdict) = judged(&writer);
    let document = writer.get(&verdict).expect(200).body;
    let page = writer
        .get(&format!("{verdict}/report.html"))
        .expect(200)
        .body;
    // A line of samples, as the file and the list of its first lines hold it.
    let text = String::from_utf8(signal("burst.csv")).unwrap();
    let line = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .nth(2)
        .unwrap();
    assert!(bytes_in(&folder, line.as_bytes()));
    writer.send("DELETE", &recording, &[]).expect(403);
    let gone = deleter.send("DELETE", &recording, &[]).expect(200).json();
    assert_eq!(
        (&gone["name"], &gone["by"], &gone["why"]),
        (&json!("burst.csv"), &json!("ada"), &json!("asked"))
    );
    assert_eq!(blobs(&folder), 1, "the document alone");
    let problem = writer.get(&recording).expect(410).json();
    assert!(
        problem["detail"].as_str().unwrap().contains("by ada"),
        "{problem}"
    );
    assert_eq!(writer.get("/v1/recordings").json()["recordings"], json!([]));
    let listed = writer.get("/v1/deletions").expect(200).json();
    assert_eq!(listed["deletions"], json!([gone]));
    assert!(writer.get(&verdict).expect(200).body == document);
    for file in ["report.html", "series.csv", "event.svg"] {
        let problem = writer.get(&format!("{verdict}/{file}")).expect(410).json();
        assert_eq!(problem["code"], "recording-deleted");
    }
    writer.get(&verdict.replace("/v1", "")).expect(200);
    let id = recording.rsplit('/').next().unwrap();
    let other = json!({"recording": id, "request": {"members": 0, "filter": "cfc600"}});
    writer.post("/v1/verdicts?wait=60", &other).expect(410);
    writer.post("/v1/what-if", &other).expect(410);
    // The answer that was given stands.
    let same = json!({"recording": id, "request": {"members": 0}});
    assert!(writer.post("/v1/verdicts", &same).expect(200).body == document);
    deleter.send("DELETE", &recording, &[]).expect(200);
    deleter
        .send("DELETE", &recording.replace(id, &"0".repeat(64)), &[])
        .expect(404);
    wait_for("no sample lies in the ledger's log", || {
        !bytes_in(&folder, line.as_bytes())
    });
    assert_eq!(folder.run(&["fsck"]).0, 0);
    // Uploaded again.
    assert_eq!(writer.upload("burst.csv")["id"], *id);
    assert!(writer.get(&verdict).expect(200).body == document);
    assert!(
        writer
            .get(&format!("{verdict}/report.html"))
            .expect(200)
            .body
            == page
    );
    writer.post("/v1/verdicts?wait=60", &other).expect(200);
}

/// What another recording holds as well stays, and the share of who uploaded is free again.
#[test]
fn regress_a_deletion_takes_nothing_that_another_needs() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["own_mib=1"]);
    let client = service.client();
    let table = format!("t_s,acc_y_g\n{}", "0.0001,1\n".repeat(60_000));
    let put = |name: &str| {
        client.send(
            "POST",
            &format!("/v1/recordings?name={name}"),
            table.as_bytes(),
        )
    };
    let id = |answer: &Value| format!("/v1/recordings/{}", answer["id"].as_str().unwrap());
    let first = id(&put("a.csv").expect(201).json());
    put("b.csv").expect(507);
    client.send("DELETE", &first, &[]).expect(200);
    let second = id(&put("b.csv").expect(201).json());
    drop(client);
    drop(service);
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let third = client
        .send("POST", "/v1/recordings?name=c.csv", table.as_bytes())
        .expect(201)
        .json();
    client.send("DELETE", &second, &[]).expect(200);
    assert_eq!(blobs(&folder), 1);
    client.get(&id(&third)).expect(200);
    assert_eq!(folder.run(&["fsck"]).0, 0);
}

/// Keeps `burst.csv` as one that came so many days ago.
fn came_before(folder: &Folder, days: i64) -> Manifest {
    let blobs = BlobFolder::open(&folder.data().join("blobs")).unwrap();
    let mut blob = blobs.begin().unwrap();
    blob.write(&signal("burst.csv")).unwrap();
    let manifest = Manifest {
        name: "burst.csv".into(),
        files: vec![blob.finish("burst.csv").unwrap()],
        card: None,
    };
    let ledger = SqliteLedger::open(&folder.data().join("ledger.sqlite")).unwrap();
    let then = now_ms() - days * 86_400_000;
    assert!(ledger.put_recording(&manifest, "me", then).unwrap());
    manifest
}

/// Waits until a service that has begun to run has looked, from begin to end, for what is to be
/// deleted by age. It notes when it begins to serve and when each such look begins.
fn wait_for_upkeep(folder: &Folder) {
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    let mut noted = BTreeSet::new();
    wait_for("the upkeep is done", || {
        let sql = "SELECT at_ms FROM looked";
        let last: i64 = connection.query_row(sql, [], |row| row.get(0)).unwrap_or(0);
        noted.insert(last);
        // An earlier service's, the start, the look, and the next one, which begins after it.
        noted.len() >= 4
    });
}

/// Recordings that are older than the operator keeps them are deleted, by the service and by no
/// person; without that setting none is.
#[test]
fn cli_recordings_expire_where_the_operator_says_so() {
    let folder = Folder::new();
    assert_eq!(Service::start(&folder, &[]).end(), 0);
    let manifest = came_before(&folder, 40);
    let old = format!("/v1/recordings/{}", manifest.id());
    let service = Service::start(&folder, &["upkeep_s=1"]);
    let client = service.client();
    let question =
        json!({"recording": manifest.id(), "request": {"members": 0, "opens_when": "negative"}});
    let verdict = client.post("/v1/verdicts?wait=60", &question).expect(200);
    let verdict = verdict.header("location").unwrap().to_string();
    let young = client.upload("surviving.csv")["id"]
        .as_str()
        .unwrap()
        .to_string();
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    // A column without its row's hash decides nothing.
    let aged = "UPDATE recordings SET created_ms = 1 WHERE id = ?";
    connection.execute(aged, [&young]).unwrap();
    wait_for_upkeep(&folder);
    client.get(&old).expect(200);
    assert_eq!(service.end(), 0);
    let service = Service::start(&folder, &["upkeep_s=1", "keep_days=30"]);
    let client = service.client();
    wait_for("it expires", || client.get(&old).status == 410);
    let detail = client.get(&old).json()["detail"].clone();
    assert!(detail.as_str().unwrap().contains("keep_days"), "{detail}");
    client.get(&format!("/v1/recordings/{young}")).expect(200);
    client.get(&verdict).expect(200);
    let listed = client.get("/v1/deletions").json();
    assert_eq!(listed["deletions"][0]["why"], "keep_days");
}

/// A question that is at work when its recording goes is refused, and leaves nothing of it.
#[test]
fn regress_a_deletion_meets_a_question_at_work() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let jobs: Vec<String> = (0..4)
        .map(|number| {
            let set = format!("lever.preload_torque_nm=2.{number}");
            let request = json!({"members": 512, "opens_when": "both"});
            let question = json!({"recording": id, "request": request, "set": [set]});
            let answer = client.post("/v1/verdicts?wait=0", &question).expect(202);
            answer.json()["job"].as_str().unwrap().to_string()
        })
        .collect();
    let path = format!("/v1/recordings/{}", id.as_str().unwrap());
    client.send("DELETE", &path, &[]).expect(200);
    let standing = |job: &String| client.get(&format!("/v1/jobs/{job}")).expect(200).json();
    for job in &jobs {
        wait_for("it ends", || {
            matches!(standing(job)["state"].as_str(), Some("done" | "refused"))
        });
    }
    let last = standing(&jobs[3]);
    assert_eq!(last["problem"]["code"], "recording-deleted", "{last}");
    // No page or curve is served, and what a child had made meanwhile is gone from the disk.
    for job in jobs
        .iter()
        .map(standing)
        .filter(|own| own["state"] == "done")
    {
        let report = format!(
            "/v1/verdicts/{}/report.html",
            job["report_id"].as_str().unwrap()
        );
        client.get(&report).expect(410);
    }
    let documents = jobs
        .iter()
        .map(standing)
        .filter(|own| own["state"] == "done");
    assert_eq!(blobs(&folder), documents.count(), "documents alone");
    assert_eq!(folder.run(&["fsck"]).0, 0);
}

/// A file of a report that was lost is made again; one that was made with other numbers says which.
#[test]
fn regress_a_lost_report_is_made_again() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let (_, verdict) = judged(&client);
    let files = ["verdict.json", "report.html", "series.csv", "event.svg"];
    let read = |name: &str| client.get(&format!("{verdict}/{name}")).expect(200).body;
    let before = files.map(read);
    let lose_all = || {
        for path in walk(&folder.data().join("blobs")) {
            let bytes = fs::read(&path).unwrap();
            if bytes != signal("burst.csv")
                && bytes
                    != fs::read(crate::support::root().join("signals/burst.csv.toml"))
                        .unwrap_or_default()
            {
                fs::remove_file(path).unwrap();
            }
        }
    };
    lose_all();
    for (name, before) in files.iter().zip(&before) {
        let again = read(name);
        if *name == "verdict.json" {
            assert_eq!(without_run(&again), without_run(before));
        } else {
            assert!(again == *before, "{name} is another");
        }
    }
    assert_eq!(folder.run(&["fsck"]).0, 0);
    // The page of the verdict heals, too.
    lose_all();
    client.get(&verdict.replace("/v1", "")).expect(200);
    client.get(&format!("{verdict}/none.svg")).expect(404);
    // Where it cannot be made again, what there is stays: the answer to the question, too.
    let page = blob_of(&folder, &before[1]);
    fs::remove_file(&page).unwrap();
    fs::write(blob_of(&folder, &signal("burst.csv")), "t_s,acc_y_g\n").unwrap();
    for child in service.children() {
        let _ = std::process::Command::new("kill")
            .args(["-9", &child])
            .status();
    }
    let problem = client.get(&format!("{verdict}/report.html"));
    assert!(problem.status >= 500, "{}", problem.text());
    let id = client.get("/v1/recordings").json()["recordings"][0]["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    client.post("/v1/verdicts?wait=60", &question).expect(200);
    client.upload("burst.csv");
    assert!(read("report.html") == before[1], "it is made again now");
    // Another revision of the numbers would make another report.
    lose_all();
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    connection
        .execute("UPDATE jobs SET id = 'other'", [])
        .unwrap();
    let problem = client.get(&format!("{verdict}/report.html"));
    assert!(matches!(problem.status, 410 | 500), "{}", problem.text());
}

/// Recordings are found by a part of their name, and listed in the order that is asked for, in parts.
#[test]
fn cli_recordings_are_listed_searched_and_sorted() {
    let folder = Folder::new();
    let (ada, bob) = (
        folder.token("ada", "read,submit"),
        folder.token("bob", "read,submit"),
    );
    let service = Service::start(&folder, &[]);
    let (ada, bob) = (service.client().bearer(&ada), service.client().bearer(&bob));
    let table = |rows: usize| {
        let rows = (0..rows).map(|row| format!("0.{row:04},{}\n", row % 3));
        format!("t_s,acc_y_g\n{}", rows.collect::<String>())
    };
    for (client, name, rows) in [(&ada, "b.csv", 5), (&bob, "A.csv", 50), (&ada, "c.csv", 20)] {
        client
            .send(
                "POST",
                &format!("/v1/recordings?name={name}"),
                table(rows).as_bytes(),
            )
            .expect(201);
    }
    let names = |query: &str| -> Vec<String> {
        let list = ada
            .get(&format!("/v1/recordings{query}"))
            .expect(200)
            .json();
        let entries = list["recordings"].as_array().unwrap().iter();
        entries
            .map(|own| own["name"].as_str().unwrap().to_string())
            .collect()
    };
    assert_eq!(names(""), ["c.csv", "A.csv", "b.csv"]);
    assert_eq!(names("?sort=oldest"), ["b.csv", "A.csv", "c.csv"]);
    assert_eq!(names("?sort=name"), ["A.csv", "b.csv", "c.csv"]);
    assert_eq!(names("?sort=size"), ["A.csv", "c.csv", "b.csv"]);
    assert_eq!(names("?sort=owner"), ["c.csv", "b.csv", "A.csv"]);
    assert_eq!(names("?filter=BOB"), ["A.csv"]);
    assert_eq!(names("?filter=a.CSV"), ["A.csv"]);
    ada.get("/v1/recordings?sort=colour").expect(400);
    for sort in ["newest", "oldest", "name", "size", "owner"] {
        let (mut seen, mut cursor) = (Vec::new(), String::new());
        loop {
            let list = ada
                .get(&format!("/v1/recordings?sort={sort}&limit=2{cursor}"))
                .json();
            let entries = list["recordings"].as_array().unwrap().iter();
            seen.extend(entries.map(|own| own["name"].as_str().unwrap().to_string()));
            match list["next"].as_i64() {
                Some(next) => cursor = format!("&cursor={next}"),
                None => break,
            }
        }
        assert_eq!(seen, names(&format!("?sort={sort}")), "{sort}");
    }
    let list = ada.get("/v1/recordings?filter=bob").json();
    let own = &list["recordings"][0];
    assert_eq!(
        (&own["owner"], &own["channels"], &own["verdicts"]),
        (&json!("bob"), &json!(1), &json!(0))
    );
    assert!(own["created_ms"].as_i64().unwrap() > 1_700_000_000_000);
}

/// A folder that is no data folder is neither filled nor closed to others, and a mistyped one is not
/// made by who looks.
#[test]
fn regress_a_foreign_folder_is_left_alone() {
    let folder = Folder::new();
    let foreign = folder.data();
    for command in [
        &["token", "list"][..],
        &["token", "revoke", "lab"],
        &["fsck"],
    ] {
        let (code, text) = folder.run(command);
        assert_eq!(code, 4, "{text}");
        assert!(text.contains("there are no data here"), "{text}");
        assert!(!foreign.exists());
    }
    fs::create_dir(&foreign).unwrap();
    fs::set_permissions(&foreign, fs::Permissions::from_mode(0o755)).unwrap();
    fs::write(foreign.join("letter.txt"), "mine").unwrap();
    for command in [
        &["token", "create", "lab"][..],
        &["--listen", "127.0.0.1:0"],
    ] {
        let (code, text) = folder.run(command);
        assert_eq!(code, 4, "{text}");
        assert!(text.contains("none of latchgate's"), "{text}");
    }
    assert_eq!(walk(&foreign).len(), 1);
    assert_eq!(
        fs::metadata(&foreign).unwrap().permissions().mode() & 0o777,
        0o755
    );
}

/// A backup that nothing can be written into is checked, and restored into a folder and files that
/// are their owner's alone; the ledger's log is empty at the end of service.
#[test]
fn regress_a_backup_is_read_where_nothing_can_be_written() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let (_, verdict) = judged(&service.client());
    let document = service.client().get(&verdict).expect(200).body;
    let copy = folder.0.join("copy");
    let (code, text) = folder.run(&["backup", copy.to_str().unwrap()]);
    assert_eq!(code, 0, "{text}");
    assert_eq!(service.end(), 0);
    let log = fs::metadata(folder.data().join("ledger.sqlite-wal"));
    assert!(
        log.is_err() || log.unwrap().len() == 0,
        "the log was not emptied"
    );
    let names = || -> Vec<_> {
        let mut all = walk(&copy);
        all.sort();
        all
    };
    let before = names();
    let data = copy.to_str().unwrap();
    let mounted = std::process::Command::new("mount")
        .args(["--bind", data, data])
        .status();
    let is_mounted = mounted.is_ok_and(|status| status.success())
        && std::process::Command::new("mount")
            .args(["-o", "remount,ro,bind", data])
            .status()
            .is_ok_and(|status| status.success());
    let run = |arguments: &[&str]| {
        let output = std::process::Command::new(crate::support::PROGRAM)
            .args(arguments)
            .output()
            .unwrap();
        (
            output.status.code(),
            String::from_utf8([output.stdout, output.stderr].concat()).unwrap(),
        )
    };
    let checked = run(&["fsck", "--data", data]);
    let second = folder.0.join("second");
    let copied = run(&["backup", second.to_str().unwrap(), "--data", data]);
    // An empty folder that others may read becomes its owner's alone; one that holds files is left.
    fs::remove_dir_all(folder.data()).unwrap();
    fs::create_dir(folder.data()).unwrap();
    fs::set_permissions(folder.data(), fs::Permissions::from_mode(0o755)).unwrap();
    let letter = folder.data().join("letter.txt");
    fs::write(&letter, "mine").unwrap();
    let refused = folder.run(&["restore", data]);
    fs::remove_file(&letter).unwrap();
    let restored = folder.run(&["restore", data]);
    if is_mounted {
        std::process::Command::new("umount")
            .arg(data)
            .status()
            .unwrap();
    }
    assert_eq!(checked.0, Some(0), "{}", checked.1);
    assert_eq!(copied.0, Some(0), "{}", copied.1);
    assert_eq!(restored.0, 0, "{}", restored.1);
    assert_eq!(refused.0, 4, "{}", refused.1);
    assert_eq!(names(), before, "what was read was written to");
    let mode = |path: &std::path::Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&folder.data()), 0o700);
    for path in walk(&folder.data()) {
        assert_eq!(mode(&path), 0o600, "{}", path.display());
    }
    let service = Service::start(&folder, &[]);
    assert!(service.client().get(&verdict).expect(200).body == document);
}

/// Data of the version before are made new at the start, with tokens, recordings and designs.
#[test]
fn cli_data_of_the_version_before_are_taken_over() {
    let folder = Folder::new();
    fs::create_dir(folder.data()).unwrap();
    let kept = crate::support::root().join("crates/service/tests/data/ledger-2.sql");
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    connection
        .execute_batch(&fs::read_to_string(kept).unwrap())
        .unwrap();
    drop(connection);
    let (code, text) = folder.run(&["fsck"]);
    assert_eq!(code, 4);
    assert!(
        text.contains("version 2") && text.contains("start the service"),
        "{text}"
    );
    let token = "lg_0000000000000000000000000000000000000000000000000000000000000002";
    let service = Service::start(&folder, &[]);
    let client = service.client().bearer(token);
    let list = client.get("/v1/recordings?sort=name").expect(200).json();
    let own = &list["recordings"][0];
    assert_eq!(
        (&own["name"], &own["owner"]),
        (&json!("burst.csv"), &json!("lab"))
    );
    assert_eq!(
        client.get("/v1/designs/stiff@1").expect(200).json()["version"],
        1
    );
    let text = folder.run(&["token", "list"]).1;
    assert!(
        text.contains("lab#1") && text.contains("gone#2") && text.contains("revoked"),
        "{text}"
    );
    // One of a later version is left as it is.
    drop(client);
    assert_eq!(service.end(), 0);
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    connection.pragma_update(None, "user_version", 9).unwrap();
    drop(connection);
    let (code, text) = folder.run(&["--listen", "127.0.0.1:0"]);
    assert_eq!(code, 4);
    assert!(text.contains("version 9"), "{text}");
}

/// A refusal quotes what it could not read, and goes with its recording; a row that is damaged keeps
/// no file alive.
#[test]
fn regress_a_deletion_leaves_no_word_of_the_recording() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let table = "t_s,acc_y_g\n0,1\n0.001,SECRETCELL99\n0.002,1\n0.003,0\n";
    let path = "/v1/recordings?name=odd.csv";
    let id = client
        .send("POST", path, table.as_bytes())
        .expect(201)
        .json()["id"]
        .clone();
    client
        .post("/v1/verdicts?wait=60", &json!({"recording": id}))
        .expect(422);
    assert!(bytes_in(&folder, b"SECRETCELL99"));
    let path = format!("/v1/recordings/{}", id.as_str().unwrap());
    client.send("DELETE", &path, &[]).expect(200);
    wait_for("nothing holds it", || !bytes_in(&folder, b"SECRETCELL99"));
    let (recording, _) = judged(&client);
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    let damage = "UPDATE results SET body = replace(body, 'burst', 'bursT')";
    assert_eq!(connection.execute(damage, []).unwrap(), 1);
    client.send("DELETE", &recording, &[]).expect(200);
    assert_eq!(folder.run(&["fsck"]).0, 0, "the damaged row is gone, too");
    // A deletion whose row is damaged is one all the same.
    let damage = "UPDATE deletions SET body = replace(body, 'asked', 'askeD')";
    assert_eq!(connection.execute(damage, []).unwrap(), 2);
    client.get(&recording).expect(410);
}

/// A result whose row is damaged is made whole by the same question.
#[test]
fn regress_a_damaged_result_is_answered_anew() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let (_, verdict) = judged(&client);
    let document = client.get(&verdict).expect(200).body;
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    let damage = "UPDATE results SET body = replace(body, 'burst', 'bursT')";
    assert_eq!(connection.execute(damage, []).unwrap(), 1);
    client.get(&verdict).expect(500);
    let id = client.get("/v1/recordings").json()["recordings"][0]["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    let again = client
        .post("/v1/verdicts?wait=60", &question)
        .expect(200)
        .body;
    assert_eq!(without_run(&again), without_run(&document));
    assert_eq!(folder.run(&["fsck"]).0, 0);
}

/// A clock that is far ahead at the start deletes nothing: for a day nobody believes it.
#[test]
fn regress_a_clock_that_went_far_deletes_nothing() {
    let folder = Folder::new();
    assert_eq!(Service::start(&folder, &[]).end(), 0);
    // As if the last look were two years ago, and the recording of then.
    let recording = format!("/v1/recordings/{}", came_before(&folder, 700).id());
    let ledger = SqliteLedger::open(&folder.data().join("ledger.sqlite")).unwrap();
    ledger.note_upkeep(now_ms() - 700 * 86_400_000).unwrap();
    drop(ledger);
    let service = Service::start(&folder, &["upkeep_s=1", "keep_days=30"]);
    wait_for_upkeep(&folder);
    service.client().get(&recording).expect(200);
    let log = fs::read_to_string(&service.log).unwrap();
    assert!(log.contains("the clock went far"), "{log}");
    assert_eq!(service.end(), 0);
    // Once it is believed, the age counts, and a new upload makes it young.
    let service = Service::start(&folder, &[]);
    service
        .client()
        .upload_bytes("burst.csv", &signal("burst.csv"), None)
        .expect(200);
    assert_eq!(service.end(), 0);
    let service = Service::start(&folder, &["upkeep_s=1", "keep_days=30"]);
    wait_for_upkeep(&folder);
    service.client().get(&recording).expect(200);
}
