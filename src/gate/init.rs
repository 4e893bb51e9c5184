//! A first gate file, from the recordings in a folder.

use super::plan::is_recording;
use crate::pipeline::{Control, Limits, Prepared, Request, Source, in_quotes};
use latchgate_recording::error::{Error, Place};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Largest number of files that are opened.
const FILES_MAX: usize = 10_000;

/// Largest depth of folders.
const DEPTH_MAX: usize = 16;

/// Beginning of the file.
const HEAD: &str = "\
# Recordings, designs and required answers; docs/gate.md lists the keys.

require = \"pass\"
";

/// End of the file.
const TAIL: &str = "\
[[designs]]                       # the paper's lever; file = \"designs/mine.toml\" for another
name = \"paper\"

# [[designs]]
# name = \"stiffer\"
# set = { \"lever.preload_torque_nm\" = 2.82 }

# [[require]]                     # a control that must fail shows that the gate can
# recordings = \"controls/*.csv\"
# verdict = \"fail\"

# [[allow]]                       # an undecided pair, for a time
# recordings = \"pole_07.csv\"
# designs = \"paper\"
# reason = \"repeat test ordered\"
# until = 2027-03-31
";

/// Returns the text of a gate file for the recordings in a folder. Those that cannot be judged as
/// they are become comments with the reason, and so do those whose channel is not plainly lateral.
///
/// # Errors
///
/// [`ErrorKind::Io`] if the folder cannot be listed, [`Stopped`](latchgate_kernel::error::Error::Stopped), and
/// [`ErrorKind::Empty`] if it holds no file.
pub fn first(folder: &Path, limits: &Limits, control: &Control<'_>) -> Result<String, Error> {
    let mut listed = Listed::default();
    listed.add(folder, 0)?;
    let Listed { mut paths, reports } = listed;
    paths.sort();
    if paths.is_empty() {
        return Err(Error::empty("the folder holds no file", "recordings").at(Place::path(folder)));
    }
    let looked = control.try_map(&paths, |path| {
        let source = Source::File(path.clone());
        let control = control.with_threads(1);
        control.unmeasured(|control| {
            match Prepared::open(&source, &Request::default(), limits, control) {
                Ok(prepared) => {
                    let finding = |code: &str| {
                        let mut findings = prepared.findings().iter();
                        findings.find(|finding| finding.code == code)
                    };
                    let doubt = finding("channel-not-lateral");
                    Ok(Looked {
                        doubt: doubt.map(|doubt| doubt.text.clone()),
                        waits_for_place: finding("place").is_some(),
                        waits_for_axis: prepared.is_across(),
                    })
                }
                Err(refused) if refused.error.is_stopped() => Err(refused.error),
                Err(refused) => Ok(Looked {
                    doubt: Some(refused.error.to_string()),
                    ..Looked::default()
                }),
            }
        })
    })?;
    let mut included = String::new();
    let mut excluded: BTreeMap<String, (String, &str)> = BTreeMap::new();
    let mut waiting: Vec<String> = Vec::new();
    for (path, looked) in paths.iter().zip(looked) {
        let name = name_below(path, folder);
        match looked.doubt {
            None => {
                let _ = writeln!(included, "    {},", in_quotes(&name));
                waiting.extend(looked.waits_for_place.then_some(name));
            }
            Some(reason) => {
                let lines = match (looked.waits_for_place, looked.waits_for_axis) {
                    (true, true) => "# transfer = \"LO..HI\"\n# accept = \"axis\"\n",
                    (true, false) => "# transfer = \"LO..HI\"\n",
                    (false, true) => "# accept = \"axis\"\n",
                    (false, false) => "",
                };
                excluded.insert(name, (reason, lines));
            }
        }
    }
    excluded.extend(reports.iter().map(|report| {
        let all_of_it = format!("{}/**", name_below(report, folder));
        (
            all_of_it,
            (
                "the folder of a report: it holds a verdict.json".to_string(),
                "",
            ),
        )
    }));
    let mut out = String::from(HEAD);
    if !included.is_empty() {
        let _ = write!(
            out,
            "\n[[recordings]]\nfiles = [\n{included}]\n# opens_when = \"negative\"\n"
        );
        out.push_str(&transfer_line(&waiting));
    }
    if !excluded.is_empty() {
        out.push_str("\n# Not judged as they are; include those that a setting fixes:\n");
    }
    for (name, (reason, lines)) in excluded {
        let reason = reason.replace(|c: char| c.is_control(), " ");
        let name = in_quotes(&name);
        let _ = write!(
            out,
            "#\n# {reason}\n# [[recordings]]\n# files = [{name}]\n{lines}"
        );
    }
    out.push('\n');
    out.push_str(TAIL);
    Ok(out)
}

/// What one look at a recording shows.
#[derive(Default)]
struct Looked {
    /// Why it is not judged as it is.
    doubt: Option<String>,
    /// A pass waits for the factors from its sensor's place to the latch.
    waits_for_place: bool,
    /// Its channel is known not to be lateral.
    waits_for_axis: bool,
}

/// Returns the line that the recordings wait for whose sensor is not known to be at door or latch.
fn transfer_line(waiting: &[String]) -> String {
    const NAMED: usize = 3;
    if waiting.is_empty() {
        return String::new();
    }
    let mut names: Vec<&str> = waiting.iter().map(String::as_str).take(NAMED).collect();
    let further = format!("{} more", waiting.len().saturating_sub(NAMED));
    if waiting.len() > NAMED {
        names.push(&further);
    }
    let names = names.join(", ").replace(|c: char| c.is_control(), " ");
    format!(
        "# A pass waits for the factors from the sensor's place to the latch, of: {names}\n\
         # transfer = \"LO..HI\"\n"
    )
}

/// True of a curve of NHTSA's EV5 format, `v07292.146`.
fn is_curve(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    !extension.is_empty() && extension.chars().all(|letter| letter.is_ascii_digit())
}

fn name_below(path: &Path, folder: &Path) -> String {
    let relative = path.strip_prefix(folder).unwrap_or(path);
    let parts: Vec<_> = relative
        .components()
        .map(|part| part.as_os_str().to_string_lossy())
        .collect();
    parts.join("/")
}

/// What a folder holds.
#[derive(Default)]
struct Listed {
    /// What may be recordings.
    paths: Vec<PathBuf>,
    /// Folders of reports, whose tables are no recordings.
    reports: Vec<PathBuf>,
}

impl Listed {
    /// Adds what a folder holds.
    fn add(&mut self, folder: &Path, depth: usize) -> Result<(), Error> {
        let failed = |error: std::io::Error| Error::io_at("list the folder", folder, &error);
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            paths.push(entry.map_err(failed)?.path());
        }
        paths.sort();
        // A header beside its curves holds no other channel than they do.
        let of_curves: BTreeSet<PathBuf> = paths
            .iter()
            .filter(|path| is_curve(path))
            .map(|path| path.with_extension(""))
            .collect();
        for path in paths {
            let extension = path.extension().unwrap_or_default();
            if extension.eq_ignore_ascii_case("ev5") && of_curves.contains(&path.with_extension(""))
            {
                continue;
            }
            let hidden = path
                .file_name()
                .is_some_and(|name| name.to_string_lossy().starts_with('.'));
            if hidden || self.paths.len() >= FILES_MAX {
                continue;
            }
            if is_recording(&path) {
                self.paths.push(path);
            } else if path.is_dir() && depth < DEPTH_MAX && !path.is_symlink() {
                if path.join("verdict.json").exists() {
                    self.reports.push(path);
                } else {
                    self.add(&path, depth + 1)?;
                }
            }
        }
        Ok(())
    }
}
