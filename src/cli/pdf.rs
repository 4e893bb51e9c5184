//! A report as PDF: an installed browser prints its page.

use latchgate_recording::error::{Error, ErrorKind};
use latchgate_report::PDF_FILE;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

/// Environment variable with the path of the browser.
const VARIABLE: &str = "CHROMIUM";

/// Names under which Chromium and its relatives are installed.
const NAMES: [&str; 7] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
];

/// Usual paths outside the search path.
const PLACES: [&str; 4] = [
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
];

/// Interval of polling the browser for its end.
const PAUSE: Duration = Duration::from_millis(50);

/// Largest number of polls: a minute.
const PAUSES: u32 = 1200;

/// Prints the page of the report in `folder` beside it.
///
/// # Errors
///
/// [`ErrorKind::Malformed`] where no browser is found, or where it prints nothing.
pub fn print(folder: &Path) -> Result<PathBuf, Error> {
    let target = folder.join(PDF_FILE);
    let Some(browser) = browser() else {
        return Err(refused(
            &target,
            "a Chromium or Chrome to print the report",
            "none is installed",
            &format!("install one, or set the variable {VARIABLE} to its path"),
        ));
    };
    // An earlier PDF must not pass for that of this report.
    let _ = fs::remove_file(&target);
    let page = folder.join(latchgate_report::REPORT_FILE);
    let profile = format!("latchgate-pdf-{}", std::process::id());
    let profile = std::env::temp_dir().join(profile);
    let ended = run(&browser, &page, &target, &profile);
    let _ = fs::remove_dir_all(&profile);
    let failure = match ended {
        Ok(()) if target.is_file() => return Ok(target),
        Ok(()) => "it printed nothing".to_string(),
        Err(failure) => failure,
    };
    Err(refused(
        &target,
        &format!("{} to print the report", browser.display()),
        &failure,
        "print report.html from a browser",
    ))
}

fn refused(target: &Path, expected: &str, found: &str, hint: &str) -> Error {
    Error::from(ErrorKind::Malformed {
        expected: expected.into(),
        found: found.into(),
        hint: hint.into(),
    })
    .at(super::verify::place(target))
}

/// Finds a browser: the one of the variable, or the first that is installed.
fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(VARIABLE).filter(|named| !named.is_empty()) {
        return Some(PathBuf::from(named));
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let installed = NAMES.iter().flat_map(|name| {
        folders
            .iter()
            .map(move |folder| folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX)))
    });
    let places = PLACES.iter().map(PathBuf::from);
    installed.chain(places).find(|path| path.is_file())
}

/// Runs the browser until it ends, a minute at most; the error is the reason of a failure.
fn run(browser: &Path, page: &Path, target: &Path, profile: &Path) -> Result<(), String> {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let option = |name: &str, path: PathBuf| {
        let mut option = OsString::from(name);
        option.push(path);
        option
    };
    let mut child = Command::new(browser)
        // The browser's sandbox fails in most containers. The page loads nothing from elsewhere.
        .args(["--headless=new", "--no-sandbox", "--disable-gpu"])
        .args([
            "--no-pdf-header-footer",
            "--disable-extensions",
            "--no-first-run",
        ])
        .arg(option("--user-data-dir=", absolute(profile)))
        .arg(option("--print-to-pdf=", absolute(target)))
        .arg(absolute(page))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("it cannot be started: {error}"))?;
    for _ in 0..PAUSES {
        match child.try_wait() {
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => return Err(format!("it ended with {status}")),
            Ok(None) => thread::sleep(PAUSE),
            Err(error) => return Err(error.to_string()),
        }
    }
    let _ = child.kill();
    let _ = child.wait();
    Err("it did not end within a minute".into())
}
