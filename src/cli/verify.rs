//! `latchgate verify`: the run inside a verdict made again, and compared.

use super::args::{Arguments, Command, Common, OutputFormat, ReplayArguments, VerifyArguments};
use super::replay::{self, Tables};
use super::{Failure, output};
use crate::error::{Error, ErrorKind, Place};
use crate::model::Design;
use crate::recording::Limits;
use crate::report;
use crate::verdict::verify::{self, Comparison, Difference};
use clap::Parser;
use serde::Serialize;
use serde_json::Value;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Exit code for a run that comes to something else.
const DIFFERENT: u8 = 1;

/// Bytes of a verdict that are taken in: one with two hundred impacts of four runs has less than
/// a hundredth of it.
const VERDICT_BYTES: u64 = 64 << 20;

/// The document that `verify --format json` prints.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    schema: &'static str,
    same: bool,
    verdict: Both<'a>,
    version: Both<'a>,
    recording: Recording<'a>,
    differences: usize,
    first_difference: Option<&'a Difference>,
}

#[derive(Debug, Serialize)]
struct Both<'a> {
    stored: Option<&'a str>,
    now: Option<&'a str>,
}

#[derive(Debug, Serialize)]
struct Recording<'a> {
    file: &'a str,
    sha256: Both<'a>,
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &VerifyArguments, common: &Common) -> Result<u8, Failure> {
    let stored = read(&own.verdict).map_err(Failure::Data)?;
    let (mut asked, mut limits) = asked(own, &stored).map_err(Failure::Data)?;
    for assignment in &common.limit {
        limits.set(assignment).map_err(Failure::Usage)?;
    }
    let design = design(&stored).map_err(|error| Failure::Data(error.at(place(&own.verdict))))?;
    check_design(own, &asked, &design).map_err(Failure::Data)?;
    asked.design = None;
    asked.set.clear();
    let source = replay::source(&asked.read.recording);
    // What goes with a verdict is made again where the verdict holds it.
    let tables = Tables {
        filters: stored["filters"]
            .as_array()
            .is_some_and(|rows| !rows.is_empty()),
        preload: stored["preload_answer"].is_object(),
        evidence: false,
    };
    let (mut document, _, _) = replay::document(&asked, common, &design, &source, &limits, tables);
    // It is what was run, but for where recording and design came from.
    document.request.command = stored["request"]["command"]
        .as_str()
        .unwrap_or_default()
        .to_string();
    let now: Value = serde_json::from_str(&report::json::render(&document)).map_err(|error| {
        Failure::Data(malformed(&own.verdict, "a document", &error.to_string()))
    })?;
    let renamed = own.recording.is_some();
    let comparison = verify::compare(&stored, &now, renamed);
    let answer = Answer {
        schema: "latchgate.verify/1",
        same: comparison.first.is_none(),
        verdict: both(&stored, &now, |document| &document["verdict"]),
        version: both(&stored, &now, |document| &document["run"]["version"]),
        recording: Recording {
            file: stored["recording"]["file"].as_str().unwrap_or(""),
            sha256: both(&stored, &now, |document| &document["recording"]["sha256"]),
        },
        differences: comparison.differences,
        first_difference: comparison.first.as_ref(),
    };
    match common.format {
        OutputFormat::Json => output::document(&report::json::render(&answer)),
        OutputFormat::Text => output::text(&text(&answer, &comparison)),
    }
    .map_err(Failure::Data)?;
    Ok(if answer.same { 0 } else { DIFFERENT })
}

fn both<'a>(
    stored: &'a Value,
    now: &'a Value,
    of: impl for<'b> Fn(&'b Value) -> &'b Value,
) -> Both<'a> {
    Both {
        stored: of(stored).as_str(),
        now: of(now).as_str(),
    }
}

fn text(answer: &Answer<'_>, comparison: &Comparison) -> String {
    let mut out = String::new();
    let mut line = |name: &str, text: &str| {
        out.push_str(&format!(
            "  {name:<15} {}\n",
            report::escape::terminal(text)
        ));
    };
    line("recording", answer.recording.file);
    let pair = |both: &Both<'_>| {
        let (stored, now) = (both.stored.unwrap_or("none"), both.now.unwrap_or("none"));
        if stored == now {
            stored.to_string()
        } else {
            format!("{stored} in the verdict, {now} now")
        }
    };
    line("verdict", &pair(&answer.verdict));
    line("version", &pair(&answer.version));
    match &comparison.first {
        None => line(
            "compared",
            "every key but version and time taken, every number to its last digit",
        ),
        Some(first) => {
            line("first", &first.text);
            line(
                "differences",
                &format!("{} values in all", comparison.differences),
            );
        }
    }
    let word = if answer.same { "SAME" } else { "DIFFERENT" };
    format!("{word}\n{out}")
}

fn place(path: &Path) -> Place {
    Place::file(path.display().to_string())
}

fn malformed(path: &Path, expected: &str, found: &str) -> Error {
    Error::from(ErrorKind::Malformed {
        expected: expected.into(),
        found: found.into(),
        hint: "give the verdict.json that latchgate replay wrote".into(),
    })
    .at(place(path))
}

/// Reads a verdict, within bounds.
fn read(path: &Path) -> Result<Value, Error> {
    let unreadable = |error: std::io::Error| {
        Error::from(ErrorKind::Io {
            action: "read the verdict",
            reason: error.to_string(),
        })
        .at(place(path))
    };
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(VERDICT_BYTES + 1).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > VERDICT_BYTES {
        return Err(Error::from(ErrorKind::LimitExceeded {
            limit: "verdict_bytes",
            value: VERDICT_BYTES,
            found: "a larger file".into(),
        })
        .at(place(path)));
    }
    let stored: Value = serde_json::from_slice(&bytes)
        .map_err(|error| malformed(path, "a JSON document", &error.to_string()))?;
    match stored["schema"].as_str() {
        Some("latchgate.verdict/1") if stored["run"]["version"].is_string() => Ok(stored),
        Some("latchgate.verdict/1") => Err(malformed(path, "run.version", "none")),
        found => Err(malformed(
            path,
            "\"schema\": \"latchgate.verdict/1\"",
            &found.map_or_else(|| "no schema".into(), |name| format!("{name:?}")),
        )),
    }
}

/// Takes what was asked, and within which limits, from the command inside the verdict; the
/// recording is looked for.
fn asked(own: &VerifyArguments, stored: &Value) -> Result<(ReplayArguments, Limits), Error> {
    let command = stored["request"]["command"]
        .as_str()
        .ok_or_else(|| malformed(&own.verdict, "request.command", "none"))?;
    let unknown = |found: String| {
        malformed(
            &own.verdict,
            "in request.command a replay that this version knows",
            &found,
        )
    };
    let words = words(command).ok_or_else(|| unknown(format!("{command:?}")))?;
    let (mut asked, common) = match Arguments::try_parse_from(&words) {
        Ok(Arguments {
            command: Command::Replay(asked),
            common,
        }) => (*asked, common),
        Ok(_) => return Err(unknown(format!("{command:?}"))),
        Err(error) => {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or("").to_string();
            return Err(unknown(format!("{command:?}, {first}")));
        }
    };
    asked.out = None;
    asked.read.recording = recording(own, stored)?;
    Ok((asked, common.limits()?))
}

/// Checks that the design of the verdict is the one that its command gives: the reference design
/// with what `--set` says, or any that holds what `--set` says where it came from a file.
fn check_design(
    own: &VerifyArguments,
    asked: &ReplayArguments,
    stored: &Design,
) -> Result<(), Error> {
    let mut given = if asked.design.is_some() {
        stored.clone()
    } else {
        Design::reference()
    };
    for assignment in &asked.set {
        given
            .set(assignment)
            .map_err(|error| error.at(place(&own.verdict)))?;
    }
    if given == *stored {
        return Ok(());
    }
    Err(Error::from(ErrorKind::Malformed {
        expected: "the design that request.command gives".into(),
        found: "another one".into(),
        hint: "command and design of a verdict belong together; it was changed by hand, or put \
               together from two"
            .into(),
    })
    .at(place(&own.verdict)))
}

/// Returns the recording: the one that is named, else that of the verdict's name beside the
/// verdict or in the current folder.
fn recording(own: &VerifyArguments, stored: &Value) -> Result<PathBuf, Error> {
    if let Some(path) = &own.recording {
        return existing(path);
    }
    let name = stored["recording"]["file"].as_str().unwrap_or("");
    // A name alone: a verdict does not say where on this machine to look.
    let name = Path::new(name).file_name().unwrap_or_default();
    let beside = own.verdict.parent().unwrap_or(Path::new("")).join(name);
    let here = PathBuf::from(name);
    let found = [&beside, &here]
        .into_iter()
        .find(|path| !name.is_empty() && path.is_file());
    found.cloned().ok_or_else(|| {
        Error::from(ErrorKind::Io {
            action: "find the recording",
            reason: format!(
                "no file {name:?} beside the verdict or in the current folder; name it with --recording"
            ),
        })
        .at(place(&own.verdict))
    })
}

fn existing(path: &Path) -> Result<PathBuf, Error> {
    if path.is_file() {
        return Ok(path.to_path_buf());
    }
    Err(Error::from(ErrorKind::Io {
        action: "read the recording",
        reason: "no such file".into(),
    })
    .at(place(path)))
}

/// Splits a command line as a POSIX shell would where only single quotes and `\'` quote.
fn words(line: &str) -> Option<Vec<String>> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut letters = line.chars();
    while let Some(letter) = letters.next() {
        match letter {
            ' ' => words.extend(word.take()),
            '\'' => {
                let word = word.get_or_insert_default();
                loop {
                    match letters.next()? {
                        '\'' => break,
                        inner => word.push(inner),
                    }
                }
            }
            '\\' => word.get_or_insert_default().push(letters.next()?),
            plain => word.get_or_insert_default().push(plain),
        }
    }
    words.extend(word.take());
    Some(words)
}

/// Takes the design from a verdict, key by key, with the checks of a design file.
fn design(stored: &Value) -> Result<Design, Error> {
    let absent = |what: &str, found: &Value| {
        Error::from(ErrorKind::Malformed {
            expected: format!("{what} of the design"),
            found: found.to_string(),
            hint: "give the verdict.json that latchgate replay wrote".into(),
        })
    };
    let whole = &stored["design"];
    let mut design = Design::reference();
    design.tolerance.clear();
    design.name = whole["name"]
        .as_str()
        .ok_or_else(|| absent("the name", &whole["name"]))?
        .to_string();
    for section in ["lever", "stop", "criterion", "input", "tolerance"] {
        let keys = whole[section]
            .as_object()
            .ok_or_else(|| absent(section, &whole[section]))?;
        for (key, value) in keys {
            let number = value.as_f64().ok_or_else(|| absent(key, value))?;
            design.set(&format!("{section}.{key}={number}"))?;
        }
    }
    design.validate()?;
    Ok(design)
}
