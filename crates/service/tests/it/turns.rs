//! Owners have their turns: whoever asks much slows himself.

use crate::support::{Folder, Service, wait_for};
use latchgate_service::pool::{HeldFirst, Orders};
use serde_json::json;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Takes the next order for a child that holds nothing.
fn taken(orders: &mut Orders<&'static str>) -> Option<(String, &'static str)> {
    orders.take(|_| false, &mut HeldFirst::default())
}

/// Owners have turns, and one of them never all places.
#[test]
fn verif_orders_are_taken_in_turn() {
    let mut orders = Orders::new(3);
    for _ in 0..50 {
        orders.push("busy", None, "of many");
    }
    orders.push("ann", None, "of ann");
    orders.push("zoe", None, "of zoe");
    let mut owners = Vec::new();
    while let Some((owner, _)) = taken(&mut orders) {
        owners.push(owner);
    }
    assert_eq!(owners, ["busy", "ann", "zoe", "busy"]);
    orders.push("ann", None, "of ann");
    assert_eq!(taken(&mut orders).unwrap().0, "ann");
    assert_eq!(taken(&mut orders), None, "the last place is another's");
    orders.done("busy");
    assert_eq!(taken(&mut orders).unwrap().0, "busy");
    // Where there is one place alone, it is for all.
    let mut orders = Orders::new(1);
    orders.push("busy", None, "of many");
    assert!(taken(&mut orders).is_some());
}

/// A recording that a child holds is preferred a few times, among orders of the same owner.
#[test]
fn verif_a_held_recording_is_preferred_a_few_times() {
    let mut orders = Orders::new(100);
    let mut held_first = HeldFirst::default();
    let mut take = |orders: &mut Orders<&str>| {
        let (_, order) = orders.take(|id| id == "held", &mut held_first).unwrap();
        order.to_string()
    };
    orders.push("ann", Some("other"), "first");
    for _ in 0..30 {
        orders.push("ann", Some("held"), "held");
    }
    assert_eq!(take(&mut orders), "held");
    let passed = (0..30).position(|_| take(&mut orders) == "first").unwrap();
    assert!((1..8).contains(&passed), "{passed} times");
    orders.push("zoe", Some("other"), "of zoe");
    assert_eq!(take(&mut orders), "of zoe", "turns come before");
}

/// Returns the niceness of each child.
fn niceness(service: &Service) -> Vec<i32> {
    let of_child = |child: String| {
        let stat = std::fs::read_to_string(format!("/proc/{child}/stat")).ok()?;
        // The name before the parenthesis may hold blanks; `nice` is field 19.
        stat.rsplit_once(") ")?.1.split(' ').nth(16)?.parse().ok()
    };
    service
        .children()
        .into_iter()
        .filter_map(of_child)
        .collect()
}

/// Pairs of gates leave the processor to questions for which somebody waits.
#[test]
fn verif_pairs_of_gates_stand_back() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["places=1"]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    // It passes: one that fails has a report made afterwards, and that does not stand back.
    let gate = "[[recordings]]\nfiles = [\"pulse:doorslam-300-6,tail=0.1s\"]\n[[designs]]\nname = \"stiff\"\n\
                set = [\"lever.preload_torque_nm=8\"]\n";
    let entry = crate::gates::decided(&client, "?name=one", gate);
    assert_eq!(entry["exit_code"], 0, "{entry}");
    let stood_back = niceness(&service);
    let question = json!({"recording": id, "request": {"members": 0}});
    client.post("/v1/verdicts?wait=60", &question).expect(200);
    let came_forward = niceness(&service);
    let own = came_forward[0];
    assert!(stood_back.contains(&(own + 10)), "{stood_back:?}");
    assert!(
        came_forward.iter().all(|niceness| *niceness == own),
        "{came_forward:?}"
    );
}

/// However many questions one owner has under way, another's are answered.
#[test]
fn verif_a_flood_of_one_stops_no_other() {
    let folder = Folder::new();
    let (much, lab) = (
        folder.token("much", "read"),
        folder.token("lab", "read,submit"),
    );
    let service = Service::start(&folder, &["places=1"]);
    let client = service.client().bearer(&lab);
    // Reading it takes so long that there is always another that waits.
    let rows = (0..40_000).map(|row| format!("{:.5},{}\n", f64::from(row) * 1e-5, row % 7));
    let table = format!("t_s,acc_y_g\n{}", rows.collect::<String>());
    let long = client.send("POST", "/v1/recordings?name=long.csv", table.as_bytes());
    let id = long.expect(201).json()["id"].clone();
    let path = format!(
        "/v1/recordings/{}?request=%7B%22header_line%22:1%7D",
        id.as_str().unwrap()
    );
    let (ends, answers) = (AtomicBool::new(false), AtomicU64::new(0));
    std::thread::scope(|scope| {
        for _ in 0..12 {
            scope.spawn(|| {
                let client = service.client().bearer(&much);
                while !ends.load(Ordering::Relaxed) {
                    client.get(&path).expect(200);
                    answers.fetch_add(1, Ordering::Relaxed);
                }
            });
        }
        let asked = std::panic::catch_unwind(|| {
            wait_for("the flood is under way", || {
                answers.load(Ordering::Relaxed) >= 12
            });
            let kept = client.upload("sled_30g_30ms.csv");
            assert_eq!(kept.get("problem"), None, "{kept}");
            let question = json!({"recording": kept["id"], "request": {"members": 0}});
            client.post("/v1/verdicts?wait=60", &question).expect(200);
            let what_if = json!({"recording": kept["id"]});
            client.post("/v1/what-if", &what_if).expect(200);
        });
        ends.store(true, Ordering::Relaxed);
        asked.unwrap();
    });
}
