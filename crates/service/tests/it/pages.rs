//! Pages of verdicts: they show what report and command line show.

use crate::support::{Client, Folder, PROGRAM, Service};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Asks for a verdict on a signal; returns its identity.
fn judged(client: &Client, name: &str, request: &Value, set: &Value) -> String {
    let id = client.upload(name)["id"].clone();
    let asking = json!({"recording": id, "request": request, "set": set});
    let answer = client.post("/v1/verdicts?wait=60", &asking).expect(200);
    answer.json()["report_id"].as_str().unwrap().to_string()
}

/// Returns what stands between two texts.
#[track_caller]
fn between<'a>(page: &'a str, start: &str, end: &str) -> &'a str {
    let rest = page.split_once(start).expect(start).1;
    rest.split_once(end).expect(end).0
}

/// Head, card, plot and findings of the page are the report's, byte by byte, and so is what its script draws from.
#[test]
fn cli_the_page_of_a_verdict_is_the_first_block_of_its_report() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    for (name, request) in [
        ("burst.csv", json!({"members": 128})),
        ("surviving.csv", json!({"members": 0})),
        (
            "half_sine_30g_11ms.csv",
            json!({"opens_when": "both", "members": 0}),
        ),
    ] {
        let id = judged(&client, name, &request, &json!([]));
        let report = client.get(&format!("/v1/verdicts/{id}/report.html"));
        let (report, page) = (report.text(), client.get(&format!("/verdicts/{id}")).text());
        let block = between(&report, "<main>", "<section id=\"judged\"");
        assert!(block.contains("<figure id=\"event\">"), "{name}");
        assert!(page.contains(block), "{name}: the first block");
        let data = |page: &str| between(page, "id=\"event-data\">", "</script>").to_string();
        assert_eq!(data(&page), data(&report), "{name}");
        let series = format!("data-from=\"/v1/verdicts/{id}/series.csv\"");
        assert!(page.contains(&series), "{name}: samples to read off");
    }
}

/// The comparison is that of `latchgate compare`.
#[test]
fn cli_the_comparison_is_that_of_the_command_line() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let request = json!({"members": 128});
    let ids = ["0.1", "2.5"].map(|torque| {
        let set = json!([format!("lever.preload_torque_nm={torque}")]);
        judged(&client, "burst.csv", &request, &set)
    });
    let mut command = Command::new(Path::new(PROGRAM).with_file_name("examples/latchgate"));
    let out = folder.0.join("compared");
    command.arg("compare").arg("--out").arg(&out);
    for id in &ids {
        let place = folder.0.join(id);
        fs::create_dir(&place).unwrap();
        for name in ["verdict.json", "series.csv"] {
            let file = client.get(&format!("/v1/verdicts/{id}/{name}")).expect(200);
            fs::write(place.join(name), file.body).unwrap();
        }
        command.arg(place.join("verdict.json"));
    }
    command.output().unwrap();
    let written = fs::read_to_string(out.join("compare.html")).unwrap();
    let written = between(&written, "<main>", "</main>");
    assert!(written.contains("<path class=\"verdict-b\""));
    let [a, b] = ids;
    let page = client.get(&format!("/compare?id={a}&id={b}")).expect(200);
    assert!(page.text().contains(written));
    assert!(page.text().contains(&format!("/compare?id={b}&amp;id={a}")));
    client.get(&format!("/compare?id={a}")).expect(400);
}

/// Where HTML is asked for, a what-if is answered with the report's card of the nominal lever.
#[test]
fn cli_a_what_if_has_a_card() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let asking = json!({"recording": id, "set": ["lever.preload_torque_nm=0.1"]});
    let html = client.clone().with("Accept", "text/html");
    let card = html.post("/v1/what-if", &asking).expect(200).text();
    assert!(
        card.contains("<strong>FAIL</strong><span>The nominal lever opens"),
        "{card}"
    );
    assert!(
        card.contains("<dt>Varied levers</dt><dd class=\"value\">none</dd>"),
        "{card}"
    );
}
