//! The store by itself: jobs under leases, fencing, rows and blobs that are found damaged.

use crate::support::{Folder, Service, let_the_tokens_age};
use latchgate_service::auth::{Door, Presented, Recognition, Scope, SessionTimes, Visitor};
use latchgate_service::store::{
    BlobFolder, Blobs, GateOutcome, Job, JobState, Ledger, Manifest, Question, SqliteLedger,
    StoreError, StoredFile, StoredGate, StoredResult, StoredSession, StoredToken, Summary,
    sha256_hex,
};
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

fn ledger(folder: &Folder) -> SqliteLedger {
    SqliteLedger::open(&folder.0.join("ledger.sqlite")).unwrap()
}

fn question(number: usize) -> Question {
    Question {
        recording: "r".into(),
        request: json!({"seed": number}),
        design: json!({}),
        design_name: None,
        decision_alone: false,
    }
}

fn result(id: &str) -> StoredResult {
    StoredResult {
        report_id: id.into(),
        recording: "r".into(),
        summary: Summary::default(),
        files: [].into(),
        created_ms: 1,
        content_sha256: "c".into(),
        job: "a".into(),
        numbers_revision: 1,
        is_stripped: false,
        lost: [].into(),
        asked_by: String::new(),
    }
}

fn taken(ledger: &SqliteLedger, now_ms: i64) -> Job {
    ledger
        .take(now_ms, now_ms + 100)
        .unwrap()
        .expect("a job waits")
}

#[test]
fn verif_an_attempt_that_lost_its_lease_changes_nothing() {
    let folder = Folder::new();
    let ledger = ledger(&folder);
    assert!(ledger.submit("a", &question(1), "me").unwrap().1);
    assert!(!ledger.submit("a", &question(1), "me").unwrap().1, "known");
    let first = taken(&ledger, 10);
    assert_eq!(ledger.take(20, 120).unwrap(), None, "one holds it");
    assert_eq!(ledger.reclaim(50, false).unwrap(), 0, "the lease holds");
    ledger.hold("a", first.attempt, 300).unwrap();
    assert_eq!(
        ledger.reclaim(200, false).unwrap(),
        0,
        "a heartbeat held it"
    );
    assert_eq!(ledger.reclaim(400, false).unwrap(), 1);
    let second = taken(&ledger, 400);
    assert_eq!((first.attempt, second.attempt), (1, 2));
    for late in [
        ledger.hold("a", first.attempt, 900),
        ledger.finish("a", first.attempt, &result("x")),
        ledger.refuse("a", first.attempt, &json!({}), true),
        ledger.give_back("a", first.attempt, true, 0).map(|_| ()),
    ] {
        assert_eq!(late, Err(StoreError::Fenced));
    }
    assert_eq!(
        ledger.result("x").unwrap(),
        None,
        "nothing of the late attempt is kept"
    );
    ledger.finish("a", second.attempt, &result("y")).unwrap();
    let done = JobState::Done {
        report_id: "y".into(),
    };
    assert_eq!(ledger.job("a").unwrap().unwrap().state, done);
    assert_eq!(
        ledger.finish("a", second.attempt, &result("z")),
        Err(StoreError::Fenced)
    );
}

#[test]
fn verif_what_runs_at_the_end_of_a_process_waits_again() {
    let folder = Folder::new();
    let first = ledger(&folder);
    first.submit("a", &question(1), "me").unwrap();
    let job = taken(&first, 10);
    let second = ledger(&folder);
    assert_eq!(second.reclaim(11, true).unwrap(), 1);
    let again = taken(&second, 12);
    assert_eq!(again.failures, job.failures, "no fault of the recording");
}

/// Jobs are taken in turn by owner, of each the oldest first; an owner's pairs of gates come after his questions.
#[test]
fn verif_owners_are_served_in_turn() {
    let folder = Folder::new();
    let ledger = ledger(&folder);
    let submit = |id: String, owner: &str, decision_alone: bool| {
        let question = Question {
            decision_alone,
            ..question(1)
        };
        assert!(ledger.submit(&id, &question, owner).unwrap().1);
    };
    for number in 0..300 {
        submit(format!("busy{number}"), "busy", false);
    }
    for owner in ["ann", "zoe"] {
        submit(format!("{owner}0"), owner, false);
        submit(format!("{owner}-pair"), owner, true);
    }
    let mut order: Vec<String> = (0..5).map(|_| taken(&ledger, 10).id).collect();
    assert_eq!(order, ["busy0", "ann0", "zoe0", "busy1", "ann-pair"]);
    // Five run, and Zoe's pair has its turn before any more of the busy one.
    let behind = |id: &str| ledger.place(id).unwrap().map(|place| place.behind);
    assert_eq!(behind("busy2"), Some(5 + 1));
    assert_eq!(behind("busy9"), Some(5 + 7 + 1));
    assert_eq!(behind("busy1"), None, "it runs");
    // Who comes later has his turn at once, with his question first.
    submit("new-pair".into(), "new", true);
    submit("new0".into(), "new", false);
    assert_eq!(
        behind("new0"),
        Some(5 + 1 + 1),
        "one turn of each other owner"
    );
    assert_eq!(taken(&ledger, 10).id, "new0");
    let question = ledger.take_question(10, 110).unwrap().unwrap();
    assert_eq!(question.id, "busy2", "the others have pairs alone");
    while let Some(job) = ledger.take(10, 110).unwrap() {
        order.push(job.id);
    }
    assert_eq!(order[5..8], ["zoe-pair", "new-pair", "busy3"]);
    assert_eq!(order.len(), 5 + 2 + 297);
}

#[test]
fn verif_a_job_given_back_waits_its_time() {
    let folder = Folder::new();
    let ledger = ledger(&folder);
    for id in ["a", "b"] {
        ledger.submit(id, &question(1), "me").unwrap();
    }
    let job = taken(&ledger, 10);
    assert_eq!(
        ledger.give_back(&job.id, job.attempt, true, 500).unwrap(),
        1
    );
    assert_eq!(taken(&ledger, 20).id, "b", "the others go on");
    assert_eq!(ledger.take(499, 600).unwrap(), None);
    assert_eq!(taken(&ledger, 500).failures, 1);
    let load = ledger.load("me").unwrap();
    assert_eq!((load.queued, load.running, load.owner_jobs), (0, 2, 2));
}

/// Pauses are times of a process: at the start of the next nobody waits for one.
#[test]
fn regress_no_pause_outlives_its_process() {
    let folder = Folder::new();
    let first = ledger(&folder);
    first.submit("a", &question(1), "me").unwrap();
    let job = taken(&first, 1_000_000);
    first
        .give_back(&job.id, job.attempt, false, 1_000_400)
        .unwrap();
    assert_eq!(first.take(1_000_000, 1_000_100).unwrap(), None);
    let second = ledger(&folder);
    second.reclaim(20, true).unwrap();
    assert_eq!(taken(&second, 20).id, "a");
}

/// A job whose row is damaged is asked anew by the same question.
#[test]
fn regress_a_damaged_job_is_asked_anew() {
    let folder = Folder::new();
    let ledger = ledger(&folder);
    ledger.submit("a", &question(1), "me").unwrap();
    let job = taken(&ledger, 1);
    ledger.finish("a", job.attempt, &result("x")).unwrap();
    let connection = rusqlite::Connection::open(folder.0.join("ledger.sqlite")).unwrap();
    let damage = "UPDATE jobs SET answer = replace(answer, 'x', 'y')";
    assert_eq!(connection.execute(damage, []).unwrap(), 1);
    assert!(matches!(ledger.job("a"), Err(StoreError::Damaged { .. })));
    assert!(ledger.submit("a", &question(1), "me").unwrap().1);
    assert_eq!(taken(&ledger, 1).id, "a");
}

/// A pair that was refused because the machine was busy is decided again when its gate is asked
/// again; one whose recording ends its reader is not.
#[test]
fn verif_a_gate_is_open_again_where_its_refusals_pass() {
    let folder = Folder::new();
    let ledger = ledger(&folder);
    for (code, passes) in [("reader-was-late", true), ("ends-its-reader", false)] {
        let pair = Question {
            decision_alone: true,
            design: json!({"name": code}),
            ..question(1)
        };
        let gate: StoredGate = serde_json::from_value(json!({
            "id": code, "name": "gate", "text": "", "recordings": [{"name": "a", "id": "a", "request": {}}],
            "designs": [pair.design], "versions": {}, "baseline": null, "allow_removed": false,
            "no_worse": false, "date": "", "created_ms": 0,
        }))
        .unwrap();
        assert!(ledger.put_gate(&gate, vec![pair.clone()], "lab").unwrap());
        let job = taken(&ledger, 0);
        ledger
            .refuse(&job.id, job.attempt, &json!({"code": code}), !passes)
            .unwrap();
        let outcome = GateOutcome {
            exit_code: 4,
            not_as_required: 1,
            files: BTreeMap::new(),
            problem: None,
        };
        ledger.end_gate(code, &outcome).unwrap();
        assert_eq!(ledger.gate(code).unwrap().unwrap().outcome, Some(outcome));
        assert_eq!(ledger.put_gate(&gate, vec![pair], "lab").unwrap(), passes);
        let standing = ledger.gate(code).unwrap().unwrap();
        assert_eq!(
            (standing.outcome.is_none(), standing.decided == 0),
            (passes, passes)
        );
        if passes {
            let job = taken(&ledger, 0);
            ledger.decide(&job.id, job.attempt, &json!({})).unwrap();
        }
    }
}

/// Of many takers each job goes to one.
#[test]
fn verif_each_job_is_taken_once() {
    let folder = Folder::new();
    let ledger = Arc::new(ledger(&folder));
    for number in 0..200 {
        ledger
            .submit(&format!("j{number}"), &question(number), "me")
            .unwrap();
    }
    let takers: Vec<_> = (0..4)
        .map(|_| {
            let ledger = Arc::clone(&ledger);
            std::thread::spawn(move || {
                let mut got = Vec::new();
                while let Some(job) = ledger.take(1, 1000).unwrap() {
                    got.push(job.id);
                }
                got
            })
        })
        .collect();
    let mut all: Vec<String> = takers
        .into_iter()
        .flat_map(|taker| taker.join().unwrap())
        .collect();
    all.sort();
    all.dedup();
    assert_eq!(all.len(), 200);
}

#[test]
fn verif_a_damaged_row_is_never_served() {
    let folder = Folder::new();
    let ledger = ledger(&folder);
    let file = StoredFile {
        name: "a.csv".into(),
        sha256: sha256_hex(b"x"),
        bytes: 1,
    };
    let manifest = Manifest {
        name: "a.csv".into(),
        files: vec![file],
        card: None,
    };
    let id = manifest.id();
    assert!(ledger.put_recording(&manifest, "me", 1).unwrap());
    ledger.put_listing(&id, &json!({"channels": []})).unwrap();
    ledger.submit("a", &question(1), "me").unwrap();
    let job = taken(&ledger, 1);
    ledger.finish("a", job.attempt, &result("x")).unwrap();
    ledger.submit("b", &question(2), "me").unwrap();
    let design = json!({"lever": 1});
    ledger.put_design("d", &design, "me", 1).unwrap();
    assert_eq!(ledger.check().unwrap().damaged, Vec::<String>::new());
    let change = |sql: &str| {
        let connection = rusqlite::Connection::open(folder.0.join("ledger.sqlite")).unwrap();
        assert_eq!(connection.execute(sql, []).unwrap(), 1, "{sql}");
    };
    change("UPDATE recordings SET listing = replace(listing, '[]', '[1]')");
    assert!(matches!(
        ledger.recording(&id),
        Err(StoreError::Damaged { .. })
    ));
    change("UPDATE results SET body = replace(body, '\"x\"', '\"y\"')");
    assert!(matches!(
        ledger.result("x"),
        Err(StoreError::Damaged { .. })
    ));
    change("UPDATE jobs SET answer = '\"z\"' WHERE id = 'a'");
    assert!(matches!(ledger.job("a"), Err(StoreError::Damaged { .. })));
    change("UPDATE jobs SET body = replace(body, '2', '3') WHERE id = 'b'");
    change("UPDATE designs SET version = 2");
    assert!(matches!(
        ledger.design("d", None),
        Err(StoreError::Damaged { .. })
    ));
    assert_eq!(ledger.check().unwrap().damaged.len(), 5);
    // A damaged job does not stop the others.
    ledger.submit("c", &question(3), "me").unwrap();
    assert_eq!(ledger.take(1, 2).unwrap(), None, "set aside");
    assert_eq!(taken(&ledger, 1).id, "c");
}

/// What each credential may do, or nothing if the ledger cannot be read.
fn rights(path: &Path, credentials: &[Option<Presented>]) -> Vec<Vec<Scope>> {
    let ledger = SqliteLedger::read_only(path);
    let door = Door::new(SessionTimes {
        idle_ms: i64::MAX,
        whole_ms: i64::MAX,
    });
    let may = |presented: &Option<Presented>| {
        let ledger = ledger.as_ref().ok()?;
        match door.look(ledger, presented.as_ref()) {
            Ok(Recognition::Open(visitor) | Recognition::Known(visitor)) => Some(visitor),
            _ => None,
        }
    };
    let scopes = |visitor: &Visitor| {
        Scope::ALL
            .into_iter()
            .filter(|scope| visitor.may(*scope))
            .collect()
    };
    let visitors = credentials.iter().map(may);
    visitors
        .map(|visitor| visitor.as_ref().map_or(Vec::new(), scopes))
        .collect()
}

/// No single flipped bit of the pages of tokens and sessions, of their counters and of the tables' list gives anybody a
/// right, and neither do such pages when they are zero or another page's.
#[test]
fn verif_no_damage_of_the_ledger_gives_a_right() {
    let folder = Folder::new();
    let path = folder.0.join("ledger.sqlite");
    let made = ledger(&folder);
    let now = 1_700_000_000_000;
    let token = |name: &str, scopes: &str, ends_ms: Option<i64>| {
        let token = StoredToken {
            number: 0,
            sha256: sha256_hex(name.as_bytes()),
            name: name.into(),
            label: String::new(),
            scopes: scopes.into(),
            created_ms: now,
            ends_ms,
            used_ms: None,
            revoked: false,
        };
        made.put_token(&token).unwrap()
    };
    token("reader", "read", None);
    let revoked = token("revoked", "read,submit", None);
    token("ended", "read,delete", Some(now));
    let last = token("last", "read,submit", None);
    for (name, token) in [("of revoked", revoked), ("of last", last)] {
        let session = StoredSession {
            sha256: sha256_hex(name.as_bytes()),
            token,
            created_ms: now,
            seen_ms: now,
        };
        made.put_session(&session).unwrap();
    }
    made.end_token(revoked, None).unwrap();
    made.settle().unwrap();
    drop(made);
    const PAGE: usize = 4096;
    let credentials = [
        None,
        Some(Presented::Token("nobody".into())),
        Some(Presented::Token("reader".into())),
        Some(Presented::Token("revoked".into())),
        Some(Presented::Token("ended".into())),
        Some(Presented::Token("last".into())),
        Some(Presented::Session("of revoked".into())),
        Some(Presented::Session("of last".into())),
    ];
    let whole = fs::read(&path).unwrap();
    let copy = folder.0.join("copy.sqlite");
    fs::write(&copy, &whole).unwrap();
    let before = rights(&copy, &credentials);
    assert_eq!(before.iter().filter(|scopes| !scopes.is_empty()).count(), 3);
    let root_pages: Vec<usize> = {
        let connection = rusqlite::Connection::open(&copy).unwrap();
        let sql = "SELECT rootpage FROM sqlite_master WHERE name IN ('tokens', 'sessions', 'sqlite_sequence')";
        let mut statement = connection.prepare(sql).unwrap();
        let pages = statement.query_map([], |row| row.get::<_, u32>(0)).unwrap();
        pages.map(|page| page.unwrap() as usize).collect()
    };
    assert_eq!(root_pages.len(), 3);
    let mut kept = 0;
    let mut check = |offset: usize, bytes: &[u8], what: &str| {
        let file = fs::OpenOptions::new().write(true).open(&copy).unwrap();
        file.write_all_at(bytes, offset as u64).unwrap();
        let after = rights(&copy, &credentials);
        file.write_all_at(&whole[offset..offset + bytes.len()], offset as u64)
            .unwrap();
        for (before, after) in before.iter().zip(&after) {
            let is_less = after.iter().all(|scope| before.contains(scope));
            assert!(is_less, "{what} at {offset}: {before:?} became {after:?}");
        }
        kept += usize::from(after == before);
    };
    for number in root_pages {
        let first = (number - 1) * PAGE;
        let page = &whole[first..first + PAGE];
        // Between the pointers and the cells nothing is stored.
        let cells = usize::from(u16::from_be_bytes([page[5], page[6]]));
        for offset in (0..64).chain(cells..PAGE) {
            for bit in 0..8 {
                check(first + offset, &[page[offset] ^ 1 << bit], "a bit");
            }
        }
        check(first, &[0; PAGE], "zeros");
        for other in whole.chunks_exact(PAGE) {
            check(first, other, "another page");
        }
    }
    let listed = b"CREATE TABLE tokens";
    let list = whole
        .windows(listed.len())
        .position(|text| text == listed)
        .unwrap();
    // Before its text the row of the list holds the table's name and first page.
    for offset in (0..128).chain(list - 64..list + 400) {
        for bit in 0..8 {
            check(
                offset,
                &[whole[offset] ^ 1 << bit],
                "a bit of the list of tables",
            );
        }
    }
    assert!(kept > 0, "no damage is harmless: the copies are not read");
}

/// A token whose row is damaged is refused alone, the check names it, and the next token that is made removes it. Where
/// none is left nobody is let in until one is made.
#[test]
fn verif_a_damaged_token_is_refused_until_another_is_made() {
    let folder = Folder::new();
    let token = folder.token("lab", "read");
    let other = folder.token("office", "read");
    let change = |sql: &str| {
        let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
        assert_eq!(connection.execute(sql, []).unwrap(), 1, "{sql}");
    };
    change("UPDATE tokens SET scopes = 'read,delete' WHERE number = 1");
    let (code, text) = folder.run(&["fsck"]);
    assert!(code == 4 && text.contains("token #1"), "{text}");
    let service = Service::start(&folder, &[]);
    let status = |token: &str| service.client().bearer(token).get("/v1/verdicts").status;
    assert_eq!((status(&token), status(&other)), (401, 200));
    change("DELETE FROM tokens WHERE number = 2");
    let_the_tokens_age();
    let refused = service.client().get("/v1/verdicts").expect(503).text();
    assert!(refused.contains("token create"), "{refused}");
    change("DELETE FROM tokens");
    let_the_tokens_age();
    assert_eq!((status(&token), status(&other)), (503, 503));
    let (code, text) = folder.run(&["fsck"]);
    assert!(code == 4 && text.contains("tokens"), "{text}");
    let new = folder.token("lab", "read");
    let_the_tokens_age();
    assert_eq!((status(&token), status(&new)), (401, 200));
    assert_eq!(folder.run(&["fsck"]).0, 0);
    drop(service);
    change("DELETE FROM tokens");
    let (code, text) = folder.run(&["--listen", "127.0.0.1:0"]);
    assert!(code == 4 && text.contains("token create"), "{text}");
}

#[test]
fn verif_a_blob_is_its_hash() {
    let folder = Folder::new();
    let blobs = BlobFolder::open(&folder.0).unwrap();
    let put = |bytes: &[u8]| {
        let mut writer = blobs.begin().unwrap();
        writer.write(bytes).unwrap();
        writer.finish("a").unwrap()
    };
    let file = put(b"some bytes");
    assert_eq!(file.sha256, sha256_hex(b"some bytes"));
    let mut text = String::new();
    blobs
        .open(&file.sha256)
        .unwrap()
        .read_to_string(&mut text)
        .unwrap();
    assert_eq!(text, "some bytes");
    std::fs::write(blobs.path(&file.sha256), "sOme bytes").unwrap();
    assert!(matches!(
        blobs.open(&file.sha256),
        Err(StoreError::Damaged { .. })
    ));
    // Uploaded again, it is whole again.
    put(b"some bytes");
    assert!(blobs.open(&file.sha256).is_ok());
    drop(blobs.begin().unwrap());
    assert_eq!(
        std::fs::read_dir(folder.0.join("unfinished"))
            .unwrap()
            .count(),
        0
    );
    // The next process counts what lies there.
    let again = BlobFolder::open(&folder.0).unwrap();
    assert_eq!((blobs.stored_bytes(), again.stored_bytes()), (10, 10));
    again.remove(&file.sha256).unwrap();
    assert_eq!(again.stored_bytes(), 0);
    assert!(matches!(
        blobs.open("../../etc/passwd"),
        Err(StoreError::Damaged { .. })
    ));
}
