//! Guards the looks of the report: a browser must show it, in light and in dark, and print it
//! on A4. Chromium is needed; without it these tests fail (tests/run installs it).

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Returns an empty folder for one test.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("pictures")
        .join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn chromium() -> String {
    if let Ok(program) = std::env::var("CHROMIUM") {
        return program;
    }
    ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|program| {
            Command::new(program)
                .arg("--version")
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status()
                .is_ok_and(|status| status.success())
        })
        .expect(
            "chromium is not installed; run tests/run, which installs it, or name it in CHROMIUM",
        )
        .to_string()
}

/// Runs a headless browser on `page` and waits for the file it writes.
#[track_caller]
fn browse(page: &Path, arguments: &[String], written: &Path) {
    // A profile of its own, so that tests may run at the same time and no setting leaks in.
    let profile = written.with_extension("profile");
    let mut child = Command::new(chromium())
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--disable-extensions",
            "--no-first-run",
            "--hide-scrollbars",
            "--force-device-scale-factor=1",
        ])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(arguments)
        .arg(format!("file://{}", page.display()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_secs(120);
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > deadline {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("chromium did not finish within 120 s on {}", page.display());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = std::fs::remove_dir_all(&profile);
    assert!(written.is_file(), "chromium wrote no {}", written.display());
}

/// What a picture shows, as far as a program can tell.
#[derive(Debug)]
struct Looks {
    /// Distinct colours, each channel coarsened to 16 steps.
    colours: usize,
    /// Share of pixels that differ from the most frequent colour.
    inked: f64,
    /// Mean brightness, 0 to 255.
    brightness: f64,
    /// Horizontal bands of 100 pixels that hold ink, of all bands.
    inked_bands: (usize, usize),
}

fn looks(picture: &Path) -> Looks {
    let file = std::io::BufReader::new(std::fs::File::open(picture).unwrap());
    let mut decoder = png::Decoder::new(file);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    let channels = frame.color_type.samples();
    assert!(channels >= 3, "a picture in colour");
    let pixels: Vec<[u8; 3]> = bytes[..frame.buffer_size()]
        .chunks_exact(channels)
        .map(|pixel| [pixel[0] >> 4, pixel[1] >> 4, pixel[2] >> 4])
        .collect();
    let mut counts = std::collections::BTreeMap::new();
    for pixel in &pixels {
        *counts.entry(*pixel).or_insert(0_usize) += 1;
    }
    let (ground, ground_count) = counts.iter().max_by_key(|(_, count)| **count).unwrap();
    let band = frame.width as usize * 100;
    let bands: Vec<bool> = pixels
        .chunks(band)
        .map(|band| band.iter().filter(|pixel| *pixel != ground).count() > 50)
        .collect();
    let total: u64 = pixels
        .iter()
        .flatten()
        .map(|part| u64::from(*part) * 17)
        .sum();
    Looks {
        colours: counts.keys().collect::<BTreeSet<_>>().len(),
        inked: 1.0 - *ground_count as f64 / pixels.len() as f64,
        brightness: total as f64 / (3 * pixels.len()) as f64,
        inked_bands: (bands.iter().filter(|inked| **inked).count(), bands.len()),
    }
}

/// Takes a picture of `page`, 1000 pixels wide and 3000 high, in light or dark.
#[track_caller]
fn screenshot(page: &Path, name: &str, dark: bool) -> Looks {
    let picture = page.with_file_name(format!("{name}.png"));
    let scheme = u8::from(!dark);
    browse(
        page,
        &[
            "--window-size=1000,3000".into(),
            format!("--blink-settings=preferredColorScheme={scheme}"),
            format!("--screenshot={}", picture.display()),
        ],
        &picture,
    );
    looks(&picture)
}

/// Returns the page sizes [pt] in the order in which the PDF file states them.
fn page_sizes(pdf: &[u8]) -> Vec<(f64, f64)> {
    let text: String = pdf.iter().map(|byte| char::from(*byte)).collect();
    text.split("/MediaBox")
        .skip(1)
        .map(|rest| {
            let inner = rest.split(['[', ']']).nth(1).unwrap();
            let numbers: Vec<f64> = inner
                .split_whitespace()
                .map(|number| number.parse().unwrap())
                .collect();
            (numbers[2] - numbers[0], numbers[3] - numbers[1])
        })
        .collect()
}

#[track_caller]
fn print(page: &Path) -> Vec<(f64, f64)> {
    let pdf = page.with_extension("pdf");
    browse(
        page,
        &[
            "--no-pdf-header-footer".into(),
            format!("--print-to-pdf={}", pdf.display()),
        ],
        &pdf,
    );
    page_sizes(&std::fs::read(&pdf).unwrap())
}

/// Writes the report of `recording` and returns where it lies.
#[track_caller]
fn report_of(recording: &str, expected_exit: i32) -> PathBuf {
    let folder = scratch(recording);
    let output = crate::support::program()
        .arg("replay")
        .arg(
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("signals")
                .join(recording),
        )
        .arg("--out")
        .arg(&folder)
        .output()
        .unwrap();
    assert_eq!(
        output.status.code(),
        Some(expected_exit),
        "{recording}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let page = folder.join("report.html");
    assert!(page.is_file(), "{recording}: no report.html in --out");
    page
}

#[track_caller]
fn check_report(recording: &str, expected_exit: i32) {
    let page = report_of(recording, expected_exit);
    let html = std::fs::read_to_string(&page).unwrap();
    for fetched in ["src=\"http", "href=\"http", "url(http", "@import"] {
        assert!(
            !html.contains(fetched),
            "{recording}: the report must open offline, found {fetched}"
        );
    }

    let light = screenshot(&page, "light", false);
    let dark = screenshot(&page, "dark", true);
    for (name, looks) in [("light", &light), ("dark", &dark)] {
        assert!(
            looks.colours >= 12 && looks.inked > 0.02 && looks.inked < 0.8,
            "{recording}, {name}: too plain for verdict, curves and a spectrogram: {looks:?}"
        );
        let (inked, all) = looks.inked_bands;
        assert!(
            inked * 10 >= all * 8,
            "{recording}, {name}: large parts are empty: {looks:?}"
        );
    }
    assert!(
        light.brightness > 180.0 && dark.brightness < 90.0,
        "{recording}: light {light:?}, dark {dark:?}"
    );

    let sizes = print(&page);
    assert!(
        (2..=12).contains(&sizes.len()),
        "{recording}: {} pages",
        sizes.len()
    );
    for (width, height) in sizes {
        // A4 is 210 mm x 297 mm.
        assert!(
            (width - 595.28).abs() < 1.0 && (height - 841.89).abs() < 1.0,
            "{recording}: a page of {width} x {height} pt, expected A4"
        );
    }
}

#[test]
fn cli_report_of_a_failing_recording_can_be_seen_and_printed() {
    check_report("burst.csv", 1);
}

#[test]
fn cli_report_of_a_passing_recording_can_be_seen_and_printed() {
    check_report("surviving.csv", 0);
}

/// The checks above would be worth nothing if an empty page passed them.
#[test]
fn verif_an_empty_page_looks_empty() {
    let page = scratch("empty").join("page.html");
    std::fs::write(&page, "<!doctype html><title>empty</title>").unwrap();
    let looks = screenshot(&page, "light", false);
    assert_eq!(looks.colours, 1, "{looks:?}");
    assert_eq!(looks.inked_bands.0, 0, "{looks:?}");
}

/// Colour scheme and page size are what the page asks for, not a constant of the browser.
#[test]
fn verif_the_browser_tells_dark_from_light_and_a4_from_a5() {
    let page = scratch("scheme").join("page.html");
    std::fs::write(
        &page,
        "<!doctype html><style>@page{size:A5} body{background:#fff} \
         @media (prefers-color-scheme: dark){body{background:#000}}</style>",
    )
    .unwrap();
    assert!(screenshot(&page, "light", false).brightness > 250.0);
    assert!(screenshot(&page, "dark", true).brightness < 5.0);
    let sizes = print(&page);
    assert_eq!(sizes.len(), 1);
    assert!((sizes[0].0 - 419.5).abs() < 1.0, "{sizes:?}");
}
