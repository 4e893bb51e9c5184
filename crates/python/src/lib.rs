//! What the Python package asks of latchgate: recordings in, documents, tables and pages out.
//!
//! Settings, designs and documents pass as JSON, arrays as NumPy's. Python's own names and checks stand
//! in `python/latchgate/`, which alone imports this module.

#![allow(
    clippy::disallowed_methods,
    reason = "a door of its own: it tells how long an answer took, and has today's date"
)]

use latchgate::cli::pdf;
use latchgate::document::json;
use latchgate::gate::{self, GateFile, Plan, Store, SummaryOptions, files, summary::GateSummary};
use latchgate::pipeline::units::AccelerationUnit;
use latchgate::pipeline::{
    self, Control, Design, Error, ErrorKind, Extras, Limits, MarginRequest, Outcome, Prepared,
    Request, Source, SpectrumRequest, Stored, apply_override, design_from_bytes, read_within,
};
use latchgate::report;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::fmt::{Display, Write as _};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

pyo3::import_exception!(latchgate._errors, NotJudged);

/// How often a wish to stop is looked for.
const PAUSE: Duration = Duration::from_millis(50);

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SETTINGS", Request::keys().collect::<Vec<_>>())?;
    module.add_class::<Judged>()?;
    module.add_class::<Lever>()?;
    module.add_function(wrap_pyfunction!(inspect, module)?)?;
    module.add_function(wrap_pyfunction!(margin, module)?)?;
    module.add_function(wrap_pyfunction!(rows, module)?)?;
    module.add_function(wrap_pyfunction!(run_gate, module)?)?;
    module.add_function(wrap_pyfunction!(spectrum, module)?)?;
    module.add_function(wrap_pyfunction!(table, module)?)
}

/// A design that was read and checked.
#[pyclass(frozen)]
struct Lever(Design);

#[pymethods]
impl Lever {
    /// Reads a design file, or the text of one, or takes the paper's design, and changes keys by assignments.
    #[new]
    fn new(file: Option<PathBuf>, text: Option<&str>, changes: Vec<String>) -> PyResult<Self> {
        let limits = Limits::default();
        let mut design = match (file, text) {
            (Some(path), _) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let most = ("settings_bytes", limits.settings_bytes);
                read_within(&path, &name, "read the design file", most)
                    .and_then(|bytes| design_from_bytes(&name, &bytes, &limits))
                    .map_err(|error| not_judged(&error))?
            }
            (None, Some(text)) => {
                design_from_bytes("design", text.as_bytes(), &limits).map_err(wrong)?
            }
            (None, None) => Design::reference(),
        };
        for assignment in changes {
            apply_override(&mut design, &assignment).map_err(wrong)?;
        }
        design.validate().map_err(wrong)?;
        Ok(Self(design))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }
}

/// An answer, with what it takes to draw it, to verify it and to write its report.
#[pyclass(frozen)]
struct Judged {
    source: Source,
    request: Request,
    design: Design,
    outcome: Outcome,
    /// The same with what a report draws.
    drawn: OnceLock<Outcome>,
}

#[pymethods]
impl Judged {
    /// Judges a recording: a file, or the bytes of one with its name.
    #[new]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        bytes: Option<Vec<u8>>,
        settings: &str,
        lever: &Lever,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let began = Instant::now();
        let (source, request) = (source(&path, bytes)?, request(settings)?);
        let design = checked(&request, lever)?;
        // A question of nominal runs alone wants its answer soon: without the filter table.
        let extras = Extras {
            filter_table: request.members > 0,
            ..Extras::default()
        };
        let mut outcome = judged(py, threads, &source, &request, &design, extras)?;
        outcome.document.run.elapsed_s = began.elapsed().as_secs_f64();
        Ok(Self {
            source,
            request,
            design,
            outcome,
            drawn: OnceLock::new(),
        })
    }

    /// The document, as the command line writes it.
    fn document<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, json::render(&self.outcome.document).as_bytes())
    }

    /// The terminal's text.
    fn text(&self) -> String {
        self.outcome.to_string()
    }

    /// The sentence that says what the verdict means.
    fn headline(&self) -> String {
        report::headline(&self.outcome.document).replace('\u{a0}', " ")
    }

    /// Signal and trajectories by column.
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        if let Some(evidence) = &self.drawn(py, None)?.evidence {
            for (name, values) in report::series::columns(&evidence.series) {
                columns.set_item(name, PyArray1::from_slice(py, values))?;
            }
        }
        Ok(columns)
    }

    /// View, panels, curves and marks of the event's plot as JSON, where there is something to draw.
    fn event(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let drawn = self.drawn(py, None)?;
        let evidence = drawn.evidence.as_ref();
        let data = evidence
            .and_then(|evidence| report::plot::event_data(&drawn.document, &evidence.series));
        Ok(data.map(|data| data.to_string()))
    }

    /// The first block of the report as a page.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let drawn = self.drawn(py, None)?;
        let series = drawn.evidence.as_ref().map(|evidence| &evidence.series);
        let block = report::html::first_block(&drawn.document, series).into_string();
        let style = report::html::style();
        Ok(format!(
            "<!DOCTYPE html><meta charset=\"utf-8\"><style>{style}</style><main>{block}</main>"
        ))
    }

    /// Writes the report into a folder.
    fn report(&self, py: Python<'_>, folder: PathBuf, with_pdf: bool) -> PyResult<()> {
        let drawn = self.drawn(py, None)?;
        let mut document = drawn.document.clone();
        document.run = self.outcome.document.run.clone();
        watched(py, None, |control| {
            let limits = Limits::default();
            let prepared = Prepared::open(&self.source, &self.request, &limits, control)
                .map_err(|refused| refused.error)?;
            prepared.advise(&self.design, &mut document, control)?;
            let files = report::files(&document, drawn.evidence.as_ref());
            let path = match &self.source {
                Source::File(path) => Some(path.as_path()),
                _ => None,
            };
            report::write(&folder, files, path)?;
            if with_pdf {
                pdf::print(&folder)?;
            }
            Ok(())
        })
    }

    /// Makes the run again and compares it, with the files of the report in a folder if one is named; as JSON.
    fn verify(
        &self,
        py: Python<'_>,
        folder: Option<PathBuf>,
        threads: Option<usize>,
    ) -> PyResult<String> {
        let document = match &folder {
            // It has the advice, too.
            Some(folder) => std::fs::read(folder.join("verdict.json"))?,
            None => json::render(&self.outcome.document).into_bytes(),
        };
        let stored = Stored::from_json(&document).map_err(|error| not_judged(&error))?;
        let verification = watched(py, threads, |control| {
            let (source, request) = (&self.source, stored.request());
            let (limits, folder) = (Limits::default(), folder.as_deref());
            pipeline::verify(&stored, source, request, false, folder, &limits, control)
        })?;
        Ok(json::render(&verification))
    }
}

impl Judged {
    /// Returns the answer with what a report draws; made at the first wish for it.
    fn drawn(&self, py: Python<'_>, threads: Option<usize>) -> PyResult<&Outcome> {
        if let Some(drawn) = self.drawn.get() {
            return Ok(drawn);
        }
        let extras = Extras {
            filter_table: true,
            evidence: true,
            ..Extras::default()
        };
        let drawn = judged(
            py,
            threads,
            &self.source,
            &self.request,
            &self.design,
            extras,
        )?;
        if drawn.document.report_id != self.outcome.document.report_id {
            let text = format!(
                "{}: the recording or its card changed after it was judged; judge it again",
                self.source.name()
            );
            return Err(NotJudged::new_err((text, Vec::<String>::new())));
        }
        Ok(self.drawn.get_or_init(|| drawn))
    }
}

/// Judges, and refuses what was not judged.
fn judged(
    py: Python<'_>,
    threads: Option<usize>,
    source: &Source,
    request: &Request,
    design: &Design,
    extras: Extras,
) -> PyResult<Outcome> {
    watched(py, threads, |control| {
        let limits = Limits::default();
        let outcome = pipeline::judge(source, request, design, extras, &limits, control);
        match outcome.refusal {
            Some(error) => Err(error),
            None => Ok(outcome),
        }
    })
}

/// Lists what a recording holds; JSON as the command line writes it.
#[pyfunction]
fn inspect(
    py: Python<'_>,
    path: PathBuf,
    settings: &str,
    threads: Option<usize>,
) -> PyResult<String> {
    let (source, request) = (source(&path, None)?, request(settings)?);
    let listing = watched(py, threads, |control| {
        pipeline::inspect(&source, &request, &Limits::default(), control)
    })?;
    Ok(json::render(&listing))
}

/// Says how far a verdict is from changing; JSON as the command line writes it.
#[pyfunction]
fn margin(
    py: Python<'_>,
    path: PathBuf,
    bytes: Option<Vec<u8>>,
    settings: &str,
    lever: &Lever,
    threads: Option<usize>,
) -> PyResult<String> {
    let began = Instant::now();
    let source = source(&path, bytes)?;
    let request = MarginRequest::try_from(entries(settings)?).map_err(bad_setting)?;
    request.replay.check().map_err(wrong)?;
    let design = checked(&request.replay, lever)?;
    let outcome = watched(py, threads, |control| {
        pipeline::margin(&source, &request, &design, &Limits::default(), control)
    })?;
    let mut document = outcome.document;
    document.run.elapsed_s = began.elapsed().as_secs_f64();
    if outcome.margins.spoiled {
        let file = &document.recording.file;
        let text =
            format!("{file}: the recording has a blocking finding; its margins prove nothing");
        return Err(NotJudged::new_err((text, Vec::<String>::new())));
    }
    Ok(json::render(&document))
}

/// Returns the latch response spectra of recordings, with designs beside them; JSON as the command line writes it.
#[pyfunction]
fn spectrum(
    py: Python<'_>,
    recordings: Vec<PathBuf>,
    settings: &str,
    levers_share: (f64, f64, f64, Option<f64>),
    leave_out_unusable: bool,
    levers: Vec<Py<Lever>>,
    threads: Option<usize>,
) -> PyResult<String> {
    let began = Instant::now();
    let (from, to, limit_angle_rad, share) = levers_share;
    let request = SpectrumRequest {
        replay: self::request(settings)?,
        restitution: (from, to),
        limit_angle_rad,
        share,
        leave_out_unusable,
    };
    request.check().map_err(wrong)?;
    let designs: Vec<Design> = levers
        .iter()
        .map(|lever| checked(&request.replay, lever.get()))
        .collect::<PyResult<_>>()?;
    let sources: Vec<Source> = recordings
        .iter()
        .map(|path| source(path, None))
        .collect::<PyResult<_>>()?;
    let mut document = watched(py, threads, |control| {
        pipeline::spectrum(&sources, &request, &designs, &Limits::default(), control)
    })?;
    document.run.elapsed_s = began.elapsed().as_secs_f64();
    Ok(json::render(&document))
}

/// Judges recordings with designs, each recording read once; one list of rows a recording, as JSON, behind
/// the largest number of varied levers.
#[pyfunction]
fn rows(
    py: Python<'_>,
    recordings: Vec<PathBuf>,
    settings: &str,
    levers: Vec<Py<Lever>>,
    threads: Option<usize>,
) -> PyResult<(u32, String)> {
    let request = request(settings)?;
    let designs: Vec<Design> = levers
        .iter()
        .map(|lever| checked(&request, lever.get()))
        .collect::<PyResult<_>>()?;
    let sources: Vec<Source> = recordings
        .iter()
        .map(|path| source(path, None))
        .collect::<PyResult<_>>()?;
    let rows = watched(py, threads, |control| {
        control.try_map(&sources, |source| {
            control.unmeasured(|control| {
                let control = control.with_threads(1);
                match Prepared::open(source, &request, &Limits::default(), &control) {
                    Ok(prepared) => {
                        let rows = designs.iter().map(|design| prepared.row(design, &control));
                        rows.collect::<Result<Vec<_>, _>>()
                    }
                    Err(refused) if refused.error.is_stopped() => Err(refused.error),
                    Err(refused) => Ok(designs.iter().map(|design| refused.row(design)).collect()),
                }
            })
        })
    })?;
    let text = serde_json::to_string(&rows).map_err(wrong)?;
    Ok((request.members, text))
}

/// Runs a gate; returns its summary as JSON. With a store what was judged before is not judged again, with
/// a folder the files of the gate are written there.
#[pyfunction]
fn run_gate(
    py: Python<'_>,
    path: PathBuf,
    store: Option<PathBuf>,
    out: Option<PathBuf>,
    date: Option<String>,
    threads: Option<usize>,
) -> PyResult<String> {
    let limits = Limits::default();
    let plan = plan(&path, &limits)?;
    let store = match store {
        None => Store::unkept(),
        Some(folder) => Store::open(&folder, "").map_err(|error| not_judged(&error))?,
    };
    let date = date.unwrap_or_else(|| {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        gate::file::day(since.map_or(0, |since| since.as_secs() / 86_400) as i64)
    });
    if !gate::file::is_day(&date) {
        return Err(wrong(format!(
            "date: expected a day as YYYY-MM-DD, found {date:?}"
        )));
    }
    let began = Instant::now();
    let summary = watched(py, threads, |control| {
        let run = gate::run(&plan, &limits, &store, &|| began.elapsed(), control)?;
        let asked = SummaryOptions {
            date: &date,
            ..SummaryOptions::default()
        };
        let summary: GateSummary = gate::summarise(&plan, run.recordings, asked);
        if let Some(folder) = &out {
            let reports = files::Reports::Failing;
            files::write(folder, &plan, &summary, reports, &limits, control)?;
        }
        let mut text = Vec::new();
        summary.write_json(&mut text)?;
        Ok(text)
    })?;
    String::from_utf8(summary).map_err(wrong)
}

fn plan(path: &Path, limits: &Limits) -> PyResult<Plan> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let most = ("settings_bytes", limits.settings_bytes);
    let shown = path.display().to_string();
    let bytes = read_within(path, &shown, "read the gate file", most);
    let bytes = bytes.map_err(|error| not_judged(&error))?;
    let text = String::from_utf8(bytes).map_err(wrong)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let folder = path.parent().unwrap_or(Path::new(""));
    let folder = if folder == Path::new("") {
        Path::new(".")
    } else {
        folder
    };
    GateFile::from_toml(&name, text, limits)
        .and_then(|file| Plan::of(&name, &file, folder, &[], limits))
        .map_err(|errors| {
            let mut lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
            lines.dedup();
            NotJudged::new_err((lines.join("\n"), Vec::<String>::new()))
        })
}

/// Returns a table of two columns, time [s] and acceleration, each number in the fewest digits that read
/// back. The arrays are read where they lie.
#[pyfunction]
fn table<'py>(
    py: Python<'py>,
    time_s: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    unit: Option<&str>,
) -> PyResult<Bound<'py, PyBytes>> {
    let unit = unit.map(|unit| {
        AccelerationUnit::from_spelling(unit).ok_or_else(|| {
            let known = AccelerationUnit::ALL.map(|(_, name)| name).join(", ");
            PyValueError::new_err(format!("the unit `{unit}` is not known; known: {known}"))
        })
    });
    let mut text = match unit.transpose()? {
        Some(unit) => format!("time [s],acceleration [{}]\n", unit.name()),
        None => "time [s],acceleration\n".to_string(),
    };
    for (time, value) in time_s.as_array().iter().zip(values.as_array()) {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{time:?},{value:?}");
    }
    Ok(PyBytes::new(py, text.as_bytes()))
}

/// Does work without holding the interpreter, and stops it where Python wants it to: at Ctrl-C.
fn watched<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce(&Control<'_>) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let cores = || thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let stop = AtomicBool::new(false);
    let control = Control {
        threads: threads.unwrap_or_else(cores).max(1),
        proceed: &|_| !stop.load(Ordering::Relaxed),
    };
    let answered: PyResult<Option<Result<T, Error>>> = py.detach(|| {
        thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            scope.spawn(|| {
                let sender = sender;
                // Nobody waits any more after a wish to stop.
                let _ = sender.send(work(&control));
            });
            loop {
                match receiver.recv_timeout(PAUSE) {
                    Ok(answer) => return Ok(Some(answer)),
                    // The work panicked, which the scope hands on.
                    Err(RecvTimeoutError::Disconnected) => return Ok(None),
                    Err(RecvTimeoutError::Timeout) => {
                        Python::attach(|py| py.check_signals())
                            .inspect_err(|_| stop.store(true, Ordering::Relaxed))?;
                    }
                }
            }
        })
    });
    match answered? {
        Some(answer) => answer.map_err(|error| not_judged(&error)),
        None => Err(wrong("the work ended without an answer")),
    }
}

/// Returns what a path names, a file or a pulse by its word, or the bytes of a file of that name.
fn source(path: &Path, bytes: Option<Vec<u8>>) -> PyResult<Source> {
    match bytes {
        Some(bytes) => Ok(Source::bytes(path.to_string_lossy(), bytes)),
        None => pipeline::pulse::source_at(path).map_err(|error| not_judged(&error)),
    }
}

fn entries(settings: &str) -> PyResult<std::collections::BTreeMap<String, serde_json::Value>> {
    serde_json::from_str(settings).map_err(wrong)
}

fn request(settings: &str) -> PyResult<Request> {
    let request = Request::from_entries(entries(settings)?).map_err(bad_setting)?;
    request.check().map_err(wrong)?;
    Ok(request)
}

fn checked(request: &Request, lever: &Lever) -> PyResult<Design> {
    request.check_design(&lever.0).map_err(wrong)?;
    Ok(lever.0.clone())
}

/// A keyword that there is none of is another error than a value that a setting does not take.
fn bad_setting(error: Error) -> PyErr {
    match error.kind() {
        ErrorKind::UnknownName { .. } => PyTypeError::new_err(error.to_string()),
        _ => wrong(error),
    }
}

fn wrong(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Says why there is no answer, with the channels to choose from where several could be meant.
fn not_judged(error: &Error) -> PyErr {
    let candidates = match error.kind() {
        ErrorKind::AmbiguousChannel { candidates } => {
            let candidates = candidates.0.iter();
            candidates
                .filter_map(|one| one.setting_value.clone())
                .collect()
        }
        _ => Vec::new(),
    };
    NotJudged::new_err((error.to_string(), candidates))
}
