//! Files of a study: rows as CSV, headline figures as JSON, a chart as SVG.

use super::json;
use crate::error::{Error, ErrorKind, Place};
use crate::study::Headline;
use crate::study::stability::Stability;
use crate::study::work_precision::{Truth, WorkPrecision};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What stands in `NAME.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name and version of this form.
    pub schema: &'static str,
    /// The study's name.
    pub study: &'static str,
    /// What was asked for.
    pub parameters: BTreeMap<&'static str, serde_json::Value>,
    /// What to take away.
    pub headlines: Vec<Headline>,
    /// The truth of each case, where the study has cases.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cases: Vec<Truth>,
    /// Version of the program.
    pub version: &'static str,
    /// Time that the study took [s].
    pub elapsed_s: f64,
}

/// A study ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Files {
    /// The study's name, and the files' without their ends.
    pub name: &'static str,
    /// Its rows.
    pub csv: Vec<u8>,
    /// Its chart.
    pub svg: String,
    /// Its figures.
    pub json: String,
}

impl Files {
    /// Lays out the study of error against cost.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if a row cannot be written.
    pub fn work_precision(result: &WorkPrecision, summary: &Summary) -> Result<Self, Error> {
        Ok(Self {
            name: summary.study,
            csv: csv(&result.rows)?,
            svg: super::plot::work_precision(result),
            json: json::render(summary),
        })
    }

    /// Lays out the study of where methods fail.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if a row cannot be written.
    pub fn stability(result: &Stability, summary: &Summary) -> Result<Self, Error> {
        Ok(Self {
            name: summary.study,
            csv: csv(&result.rows)?,
            svg: super::plot::stability(result),
            json: json::render(summary),
        })
    }

    /// Writes `NAME.csv`, `NAME.svg` and `NAME.json` into `dir`, which is created if absent, and
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
        let mut written = Vec::new();
        for (end, content) in [
            ("csv", self.csv.as_slice()),
            ("svg", self.svg.as_bytes()),
            ("json", self.json.as_bytes()),
        ] {
            let path = dir.join(format!("{}.{end}", self.name));
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

/// Returns the summary for a terminal.
#[must_use]
pub fn text(summary: &Summary, folder: &Path) -> String {
    let mut out = format!("study {}\n", summary.study);
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
            |value| super::number::trimmed(value, 4),
        );
        out.push_str(&format!("  {}: {value}\n", line.what));
    }
    out.push_str(&format!(
        "\nwritten to {}: {name}.csv, {name}.svg, {name}.json\n",
        folder.display(),
        name = summary.study
    ));
    out
}
