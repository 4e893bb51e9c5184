//! Guards the page as it is worked with: read off, zoomed, curves on and off, downloaded; and that
//! it is whole without its script.

use super::{Case, fixture, html};
use latchgate_report::series;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Returns what a browser makes of a page.
fn dom(name: &str, page: &str, options: &[&str]) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("live");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("{name}.html"));
    std::fs::write(&path, page).unwrap();
    let program = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".into());
    let profile = folder.join(format!("{name}-profile"));
    let done = Command::new(program)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--virtual-time-budget=4000",
        ])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(options)
        .arg("--dump-dom")
        .arg(format!("file://{}", Path::new(&path).display()))
        .stderr(Stdio::null())
        .output()
        .unwrap();
    let _ = std::fs::remove_dir_all(profile);
    String::from_utf8_lossy(&done.stdout).into_owned()
}

fn page(case: &Case) -> String {
    html::render(&case.document, Some(&case.evidence))
}

/// Appends what a person would do; the page's own policy would not let it run.
fn driven(page: &str, acts: &str) -> String {
    let policy = page.find("<meta http-equiv").unwrap();
    let end = policy + page[policy..].find("/>").unwrap() + 2;
    let open = format!("{}{}", &page[..policy], &page[end..]);
    let driver = format!(
        "<script>const s = document.querySelector('#event svg');\
         const key = (k, o) => s.dispatchEvent(new KeyboardEvent('keydown', Object.assign({{key: k, bubbles: true}}, o)));\
         const read = () => document.querySelector('output').textContent;\
         const said = []; {acts}; \
         const p = document.createElement('pre'); p.id = 'said'; p.textContent = said.join('|'); document.body.append(p);</script></body>"
    );
    open.replace("</body>", &driver)
}

fn said(dom: &str) -> Vec<String> {
    let start = dom.find("<pre id=\"said\">").expect("the driver ran") + 15;
    let end = start + dom[start..].find("</pre>").unwrap();
    dom[start..end].split('|').map(String::from).collect()
}

#[test]
fn cli_the_page_runs_its_script_under_its_policy_and_is_whole_without() {
    let page = page(&fixture::failing());
    let live = dom("policy", &page, &[]);
    assert!(live.contains("Whole record</button>") && live.contains("Download series"));
    // Without it the page is what is written.
    assert!(!page.contains("<button"));
    let drawn = page.split("<script").next().unwrap();
    assert!(drawn.contains("id=\"event\"") && drawn.contains("class=\"run-"));
}

#[test]
fn cli_cursors_read_off_and_keys_zoom_and_curves_go() {
    let acts = "key('ArrowRight'); said.push(read()); key('b'); key('ArrowRight', {shiftKey: true}); \
        said.push(read()); const before = s.querySelector('.drawn').textContent; key('+'); \
        said.push(String(before !== s.querySelector('.drawn').textContent)); key('0'); \
        said.push(String(before === s.querySelector('.drawn').textContent)); \
        const all = s.querySelectorAll('.drawn path').length; \
        document.querySelector('.live button[aria-pressed]').click(); \
        said.push(String(all - s.querySelectorAll('.drawn path').length)); \
        key('Escape'); said.push(read())";
    let case = fixture::failing();
    let said = said(&dom("driven", &driven(&page(&case), acts), &[]));
    assert!(said[0].starts_with("t ") && said[0].contains("m/s") && said[0].contains("rad"));
    assert!(
        said[1].contains("\u{394}t ") && said[1].contains("\u{394}a "),
        "{said:?}"
    );
    assert_eq!(said[2..5], ["true", "true", "1"], "{said:?}");
    assert!(said[5].starts_with("Point at the plot"), "{said:?}");
}

/// The page's download and the folder's CSV are the same bytes.
#[test]
fn verif_the_page_holds_the_series_of_its_folder() {
    let case = fixture::failing();
    let page = page(&case);
    let start = page.find("id=\"series\">").unwrap() + 12;
    let end = start + page[start..].find("</script>").unwrap();
    let table = series::csv(&case.evidence.series);
    assert!(page[start..end] == table, "another series");
    assert_eq!(table.lines().count(), case.evidence.series.time_s.len() + 1);
    assert!(table.starts_with(
        "time_s,acceleration_recorded_m_s2,acceleration_used_m_s2,velocity_m_s,angle_"
    ));
}

/// The report on paper: a PDF beside the page, by the browser that is found.
#[test]
fn cli_a_report_is_printed() {
    let folder = crate::support::Folder::new("printed");
    let out = folder.path().join("out");
    let file = crate::support::signal_file("surviving.csv");
    let out_text = out.to_str().unwrap();
    let asked = [
        "replay",
        &file,
        "--members",
        "0",
        "--pdf",
        "--out",
        out_text,
    ];
    let done = crate::support::latchgate(&asked);
    assert_eq!((done.code, done.err.as_str()), (0, ""));
    let printed = std::fs::read(out.join("report.pdf")).unwrap();
    assert!(printed.starts_with(b"%PDF-") && printed.len() > 20_000);
    // What could not be written before is still told.
    let series = folder.path().join("no-such-folder/series.csv");
    let unwritten = [&asked[..], &["--series", series.to_str().unwrap()]].concat();
    let done = crate::support::latchgate(&unwritten);
    assert_eq!(done.code, 4);
    assert!(done.err.contains("no-such-folder"), "{}", done.err);
    // Another report in its place has none until it is printed.
    let other = [
        "replay",
        &file,
        "--members",
        "0",
        "--filter",
        "none",
        "--out",
        out_text,
    ];
    assert_eq!(crate::support::latchgate(&other).code, 0);
    assert!(!out.join("report.pdf").exists());
}
