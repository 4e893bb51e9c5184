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
        // What is signed is the report: its lines stand below rule, hash and limits.
        assert!(
            report.contains("Checked by") && !page.contains("Checked by"),
            "{name}"
        );
        assert!(
            page.contains(&format!("/v1/verdicts/{id}/report.html")),
            "{name}"
        );
        assert!(page.contains("UTC by <strong>local</strong>"), "{name}");
        let series = format!("data-from=\"/v1/verdicts/{id}/series.csv\"");
        assert!(page.contains(&series), "{name}: samples to read off");
    }
}

/// Without its recording a verdict stays, says who deleted that, and offers nothing that needs it.
#[test]
fn cli_the_page_of_a_verdict_outlives_its_recording() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let id = judged(&client, "burst.csv", &json!({"members": 0}), &json!([]));
    let page = format!("/verdicts/{id}");
    assert!(client.get(&page).text().contains("id=\"what-if\""));
    let recording = client.upload("burst.csv")["id"].clone();
    let recording = recording.as_str().unwrap();
    let gone = format!("/recordings/{recording}/delete");
    let gone = client.send("POST", &gone, b"").expect(303);
    assert_eq!(gone.header("location"), Some("/recordings"));
    let page = client.get(&page).expect(200).text();
    assert!(page.contains("The recording was deleted on "), "{page}");
    assert!(page.contains("<strong>FAIL</strong>"), "{page}");
    assert!(!page.contains("id=\"what-if\""), "{page}");
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
    // The list names the newest first, and its comparison goes from the oldest on.
    let chosen = client.get(&format!("/compare?sort=oldest&id={b}&id={a}"));
    assert!(chosen.expect(200).text().contains(written));
    let turned = client.get(&format!("/compare?id={b}&id={a}")).expect(200);
    assert!(!turned.text().contains(written));
    let list = client.get("/").text();
    assert!(list.contains("<input type=\"hidden\" name=\"sort\" value=\"oldest\">"));
    let one = client.get(&format!("/compare?id={a}")).expect(400);
    let none = client.get("/compare").expect(200);
    for page in [one, none] {
        assert!(page.text().contains("Tick two to 8 verdicts"));
    }
}

/// Where HTML is asked for, a what-if is answered with the report's card of the nominal lever and its angle at
/// each sample of the report's series.
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
    let angle = between(&card, "<script type=\"application/json\">", "</script>");
    let angle: Vec<f64> = serde_json::from_str(angle).unwrap();
    let judged = client.post("/v1/verdicts?wait=60", &asking).expect(200);
    let judged = judged.json();
    let id = judged["report_id"].as_str().unwrap();
    let series = client.get(&format!("/v1/verdicts/{id}/series.csv")).text();
    let mut lines = series.lines();
    let column = lines.next().unwrap().split(',');
    // The card is that of the nominal run.
    let named = format!("angle_{}", judged["nominal"]["model"].as_str().unwrap());
    let column = column.take_while(|name| !name.starts_with(&named)).count();
    let kept = lines.map(|line| line.split(',').nth(column).unwrap().parse::<f64>().unwrap());
    let kept: Vec<f64> = kept.collect();
    assert_eq!(angle.len(), kept.len());
    let apart = angle
        .iter()
        .zip(&kept)
        .map(|(new, kept)| (new - kept).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-6, "the same lever");
}

/// Rows of one test differ by what was declared; what is in doubt says why; a search without a hit says so.
#[test]
fn cli_lists_tell_verdicts_apart() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let bytes = crate::support::signal("half_sine_30g_11ms.csv");
    let uploaded = client.upload_bytes("sled.csv", &bytes, None).json();
    for request in [
        json!({"members": 0}),
        json!({"members": 0, "opens_when": "negative"}),
    ] {
        let asking = json!({"recording": uploaded["id"], "request": request});
        client.post("/v1/verdicts?wait=60", &asking).expect(200);
    }
    let page = client.get("/").expect(200).text();
    let row = |direction: &str| {
        let mut rows = page.split("<tr>");
        let cell = format!("data-label=\"Opens on\">{direction}</td>");
        rows.any(|row| row.contains(&cell))
    };
    assert!(row("negative") && row("not declared"), "{page}");
    let undecided = between(&page, "UNDECIDED", "</td>");
    assert!(undecided.contains("class=\"doubt\""), "{undecided}");
    let none = client.get("/?filter=nowhere").expect(200).text();
    assert!(none.contains("No verdict fits this search"), "{none}");
    assert!(!none.contains("None yet"), "{none}");
    let page = client.get("/recordings?sort=name").expect(200).text();
    assert!(page.contains("sled.csv</a>"), "{page}");
    assert_eq!(page.matches("aria-sort=\"ascending\"").count(), 1);
    // Sorted another way than by date, a list goes on where its part before ended.
    let listed = |query: &str| {
        client
            .get(&format!("/v1/verdicts?{query}"))
            .expect(200)
            .json()
    };
    let directions = |list: &Value| {
        let list = list["verdicts"].as_array().unwrap();
        let each = list.iter().map(|verdict| verdict["opens_when"].clone());
        each.collect::<Vec<Value>>()
    };
    let oldest = listed("sort=oldest&limit=1");
    let rest = listed(&format!("sort=oldest&limit=1&cursor={}", oldest["next"]));
    assert_eq!(directions(&oldest), [Value::Null]);
    assert_eq!(directions(&rest), [json!("negative")]);
    assert_eq!(directions(&listed("sort=file")).len(), 2);
}

/// A page speaks of its fields by their labels, marks the one that is missing, and asks for nothing that the
/// file cannot have.
#[test]
fn cli_a_form_marks_what_is_missing() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let page = |name: &str, bytes: &[u8], query: &str| {
        let id = client.upload_bytes(name, bytes, None).json()["id"].clone();
        let page = format!("/recordings/{}{query}", id.as_str().unwrap());
        let page = client.get(&page).expect(200).text();
        assert!(!page.contains("request."), "{page}");
        page
    };
    let rows: String = (0..2000)
        .map(|row| format!("{},1\n", row as f64 / 1e4))
        .collect();
    let bare = format!("time,acc_y\n{rows}");
    let unit = page("bare.csv", bare.as_bytes(), "");
    assert!(
        unit.contains(
            "<select name=\"unit\" aria-invalid=\"true\" aria-describedby=\"error-unit\">"
        ),
        "{unit}"
    );
    assert!(between(&unit, "id=\"error-unit\">", "</span>").contains("“Unit of acceleration”"));
    // A decimal comma is taken, what is no number is marked.
    let comma = page("bare.csv", bare.as_bytes(), "?unit=g&time_zero=0,05");
    assert!(!comma.contains("aria-invalid"), "{comma}");
    assert!(between(&comma, "data-request=\"", "\"").contains("0.05"));
    let word = page("bare.csv", bare.as_bytes(), "?unit=g&time_zero=soon");
    assert!(
        word.contains("name=\"time_zero\" placeholder=\"0\" value=\"soon\" aria-invalid=\"true\""),
        "{word}"
    );
    // A workbook is no table of text.
    let workbook = page("test.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0\0\0\0", "");
    assert!(!workbook.contains("Decimal mark"), "{workbook}");
}

/// Where nothing was judged yet, the first page offers a sample whose question the interface takes as it stands.
#[test]
fn cli_an_empty_home_offers_a_sample() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let page = client.get("/").expect(200).text();
    let asking = between(&page, "data-asking=\"", "\"").replace("&quot;", "\"");
    let asking: Value = serde_json::from_str(&asking).unwrap();
    assert_eq!(
        asking["recording"],
        "pulse:half-sine,peak=30g,duration=10ms"
    );
    let searched = client.get("/?filter=nowhere").expect(200).text();
    assert!(!searched.contains("data-asking"), "{searched}");
    client.post("/v1/verdicts?wait=60", &asking).expect(200);
    let page = client.get("/").expect(200).text();
    assert!(page.contains("pulse:half-sine") && !page.contains("data-asking"));
}

/// A report names who asked for it first, where a token tells.
#[test]
fn cli_a_report_names_who_asked_for_it() {
    let folder = Folder::new();
    let token = folder.token("lab", "read,submit");
    let service = Service::start(&folder, &[]);
    let client = service.client().bearer(&token);
    let id = judged(&client, "surviving.csv", &json!({"members": 0}), &json!([]));
    let document = client.get(&format!("/v1/verdicts/{id}")).json();
    assert_eq!(document["run"]["by"], "lab");
    let report = client.get(&format!("/v1/verdicts/{id}/report.html"));
    assert!(report.text().contains("<th>Made by</th><td>lab</td>"));
}
