//! Files of a study: rows as CSV, headline figures as JSON, a chart as SVG.

use crate::Headline;
use crate::sentence::sentence;
use crate::work_precision::Truth;
use latchgate_document::{json, number};
use latchgate_kernel::model::stop::StopModel;
use latchgate_recording::error::{Error, ErrorKind, Place};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

/// Content of `NAME.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name and version of this form.
    pub schema: Cow<'static, str>,
    /// The study's name.
    pub study: Cow<'static, str>,
    /// The study's options, its design among them.
    pub parameters: serde_json::Value,
    /// True if the work was not stopped.
    pub complete: bool,
    /// Headline figures.
    pub headlines: Vec<Headline>,
    /// The truth of each case, if the study has cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cases: Vec<Truth>,
    /// Further results, in a form of the study's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub results: Option<serde_json::Value>,
    /// Version of the program.
    pub version: Cow<'static, str>,
    /// Time that the study took [s].
    pub elapsed_s: f64,
}

/// Rows of a study, as CSV.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StudyTable {
    /// End of its file's name before `.csv`: nothing, or a stop's name after a hyphen.
    pub suffix: String,
    /// The file.
    pub csv: Vec<u8>,
}

impl StudyTable {
    /// Lays out the rows of `NAME.csv`.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if a row cannot be written.
    pub fn of<T: Serialize>(rows: &[T]) -> Result<Self, Error> {
        Ok(Self {
            suffix: String::new(),
            csv: csv(rows)?,
        })
    }

    /// Lays out the rows of one stop: `NAME.csv` if it is the only one of `stops`, else as
    /// [`Self::of_stop`].
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if a row cannot be written.
    pub fn of_stops<T: Serialize + Default>(
        stops: &[StopModel],
        stop: StopModel,
        rows: &[T],
    ) -> Result<Self, Error> {
        if stops.len() == 1 {
            Ok(Self {
                suffix: String::new(),
                csv: csv_or_header(rows)?,
            })
        } else {
            Self::of_stop(stop, rows)
        }
    }

    /// Lays out the rows of one stop, `NAME-rigid.csv` or `NAME-soft.csv`.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if a row cannot be written.
    pub fn of_stop<T: Serialize + Default>(stop: StopModel, rows: &[T]) -> Result<Self, Error> {
        Ok(Self {
            suffix: format!("-{}", stop.name()),
            csv: csv_or_header(rows)?,
        })
    }
}

/// A study ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyFiles {
    /// The study's name, and the files' without their ends.
    pub name: Cow<'static, str>,
    /// Its rows.
    pub tables: Vec<StudyTable>,
    /// Its chart.
    pub svg: String,
    /// Its figures.
    pub json: String,
}

impl StudyFiles {
    /// Returns the files of a study.
    pub fn new(summary: &Summary, tables: Vec<StudyTable>, svg: String) -> Self {
        Self {
            name: summary.study.clone(),
            tables,
            svg,
            json: json::render(summary),
        }
    }

    /// Writes the tables, `NAME.svg` and `NAME.json` into `dir`, which is created if absent, and
    /// returns their paths.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if the folder cannot be made or a file not be written.
    pub fn write(&self, dir: &Path) -> Result<Vec<PathBuf>, Error> {
        let failed = |action, path: &Path, error: &std::io::Error| {
            Error::from(ErrorKind::Io {
                action,
                reason: error.to_string(),
            })
            .at(Place::file(path.display().to_string()))
        };
        fs::create_dir_all(dir).map_err(|error| failed("make the study's folder", dir, &error))?;
        let mut contents: Vec<(String, &[u8])> = self
            .tables
            .iter()
            .map(|table| {
                let name = format!("{}{}.csv", self.name, table.suffix);
                (name, table.csv.as_slice())
            })
            .collect();
        contents.push((format!("{}.svg", self.name), self.svg.as_bytes()));
        contents.push((format!("{}.json", self.name), self.json.as_bytes()));
        let mut written = Vec::new();
        for (name, content) in contents {
            let path = dir.join(name);
            fs::write(&path, content).map_err(|error| failed("write the study", &path, &error))?;
            written.push(path);
        }
        Ok(written)
    }
}

fn csv<T: Serialize>(rows: &[T]) -> Result<Vec<u8>, Error> {
    let refused = |reason: String| {
        Error::from(ErrorKind::Io {
            action: "write the study's rows",
            reason,
        })
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer
            .serialize(row)
            .map_err(|error| refused(error.to_string()))?;
    }
    writer
        .into_inner()
        .map_err(|error| refused(error.to_string()))
}

/// As [`csv`]; of no rows, the line of the columns' names.
fn csv_or_header<T: Serialize + Default>(rows: &[T]) -> Result<Vec<u8>, Error> {
    if !rows.is_empty() {
        return csv(rows);
    }
    let mut lines = csv(&[T::default()])?;
    let header = lines.iter().position(|byte| *byte == b'\n');
    lines.truncate(header.map_or(0, |end| end + 1));
    Ok(lines)
}

/// Returns the summary for a terminal, with the files that were written.
pub fn text(summary: &Summary, written: &[PathBuf]) -> String {
    let mut out = format!("study {}\n", summary.study);
    if !summary.complete {
        out.push_str("\ninterrupted: what follows speaks of what was done until then\n");
    }
    let mut last = String::new();
    for line in &summary.headlines {
        let subject = match line.model {
            Some(model) => format!("{}, {} stop", line.subject, model.name()),
            None => line.subject.clone(),
        };
        if subject != last {
            out.push_str(&format!("\n{subject}\n"));
            last = subject;
        }
        let value = line.value.map_or_else(
            || "none".to_string(),
            |value| number::trimmed(value, line.digits),
        );
        out.push_str(&format!("  {}: {value}\n", line.what));
    }
    let names: Vec<String> = written
        .iter()
        .filter_map(|path| path.file_name())
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    if let Some(sentence) = sentence(&summary.study, &summary.headlines) {
        out.push_str(&format!("\n{sentence}\n"));
    }
    let folder = written.first().and_then(|path| path.parent());
    out.push_str(&format!(
        "\nwritten to {}: {}\n",
        folder.unwrap_or(Path::new(".")).display(),
        names.join(", ")
    ));
    out
}
