//! What the Python package asks of latchgate: recordings in, documents, tables and pages out.
//!
//! Settings, designs and documents pass as JSON, arrays as NumPy's. Python's own names and checks stand
//! in `python/latchgate/`, which alone imports this module.

#![allow(
    clippy::disallowed_methods,
    reason = "a door of its own: it tells how long an answer took, and has today's date"
)]

use latchgate::cli::{clock, pdf};
use latchgate::document::json;
use latchgate::gate::{self, GateFile, Plan, Store, SummaryOptions, files, summary::GateSummary};
use latchgate::pipeline::units::{AccelerationUnit, TimeUnit};
use latchgate::pipeline::{
    self, Control, Design, Error, ErrorKind, Extras, Limits, MarginRequest, Outcome, Prepared,
    Request, Source, SpectrumRequest, Stored, apply_override, design_from_bytes, read_within,
};
use latchgate::report::angle::KnownPeak;
use latchgate::report::terminal::{Look, PIPED};
use latchgate::report::{self, text};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::ffi::OsString;
use std::fmt::{Display, Write as _};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

pyo3::import_exception!(latchgate._errors, MissingFile);
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
    module.add_function(wrap_pyfunction!(keywords, module)?)?;
    module.add_function(wrap_pyfunction!(margin, module)?)?;
    module.add_function(wrap_pyfunction!(peak_text, module)?)?;
    module.add_function(wrap_pyfunction!(restored, module)?)?;
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
                check_exists(&path)?;
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
#[pyclass(frozen, module = "latchgate._native")]
struct Judged {
    source: Source,
    /// The bytes of the recording where it is no file.
    bytes: Option<Arc<[u8]>>,
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
        let bytes: Option<Arc<[u8]>> = bytes.map(Into::into);
        let (source, request) = (source(&path, bytes.clone())?, request(settings)?);
        let design = checked(&request, lever)?;
        // A question of nominal runs alone wants its answer soon: without the filter table.
        let extras = Extras {
            filter_table: request.members > 0,
            ..Extras::default()
        };
        let mut outcome = judged(py, threads, &source, &request, &design, extras)?;
        let run = &mut outcome.document.run;
        (run.elapsed_s, run.date) = (began.elapsed().as_secs_f64(), Some(clock::date_of_run()));
        Ok(Self {
            source,
            bytes,
            request,
            design,
            outcome,
            drawn: OnceLock::new(),
        })
    }

    /// The answer with its question, for pickle: [`restored`] takes it. What a report draws is left out,
    /// since it can be made again.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Pickled<'py>)> {
        let path = match &self.source {
            Source::File(path) => path.clone().into_os_string(),
            source => source.name().into(),
        };
        let question = (
            serde_json::to_string(&self.request.stated()).map_err(wrong)?,
            serde_json::to_string(&self.design).map_err(wrong)?,
        );
        let restored = py.import("latchgate._native")?.getattr("restored")?;
        Ok((
            restored,
            (path, self.bytes(py), question, self.document(py)),
        ))
    }

    /// The bytes of the recording where it is no file.
    fn bytes<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        self.bytes.as_ref().map(|bytes| PyBytes::new(py, bytes))
    }

    /// The recording's file name.
    #[getter]
    fn name(&self) -> String {
        self.source.name()
    }

    /// The document, as the command line writes it.
    fn document<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, json::render(&self.outcome.document).as_bytes())
    }

    /// The terminal's text, with what to type next in Python.
    fn text(&self) -> String {
        let look = Look {
            width: Some(PIPED),
            worded: in_python,
            ..Look::default()
        };
        text::render(&self.outcome.document, None, look)
    }

    /// The sentence that says what the verdict means.
    fn headline(&self) -> String {
        with_keywords(&report::headline(&self.outcome.document)).replace('\u{a0}', " ")
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

    /// Says how far the verdict is from changing, as [`margin`].
    fn margin(
        &self,
        py: Python<'_>,
        counterweight_radius: Option<f64>,
        threads: Option<usize>,
    ) -> PyResult<String> {
        let mut entries = self.request.stated();
        if let Some(radius) = counterweight_radius {
            entries.insert("counterweight_radius".into(), radius.into());
        }
        let request = MarginRequest::try_from(entries).map_err(bad_setting)?;
        margin_of(py, &self.source, &request, &self.design, threads)
    }
}

/// What is pickled of an answer: path or name, bytes, settings and design as JSON, document.
type Pickled<'py> = (
    OsString,
    Option<Bound<'py, PyBytes>>,
    (String, String),
    Bound<'py, PyBytes>,
);

/// Returns an answer that was pickled, as it was given.
#[pyfunction]
fn restored(
    path: PathBuf,
    bytes: Option<Vec<u8>>,
    settings_design: (String, String),
    document: &[u8],
) -> PyResult<Judged> {
    let (settings, design) = settings_design;
    let bytes: Option<Arc<[u8]>> = bytes.map(Into::into);
    Ok(Judged {
        // The file may be gone, or on another machine: the answer stands without it.
        source: named_source(&path, bytes.clone())?,
        bytes,
        request: request(&settings)?,
        design: serde_json::from_str(&design).map_err(wrong)?,
        outcome: Outcome {
            document: serde_json::from_slice(document).map_err(wrong)?,
            evidence: None,
            refusal: None,
            offers: Vec::new(),
        },
        drawn: OnceLock::new(),
    })
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
    settings: &str,
    lever: &Lever,
    threads: Option<usize>,
) -> PyResult<String> {
    let source = source(&path, None)?;
    let request = MarginRequest::try_from(entries(settings)?).map_err(bad_setting)?;
    request.replay.check().map_err(wrong)?;
    let design = checked(&request.replay, lever)?;
    margin_of(py, &source, &request, &design, threads)
}

fn margin_of(
    py: Python<'_>,
    source: &Source,
    request: &MarginRequest,
    design: &Design,
    threads: Option<usize>,
) -> PyResult<String> {
    let began = Instant::now();
    let outcome = watched(py, threads, |control| {
        pipeline::margin(source, request, design, &Limits::default(), control)
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
    let source_of = if leave_out_unusable {
        named_source
    } else {
        source
    };
    let sources: Vec<Source> = recordings
        .iter()
        .map(|path| source_of(path, None))
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
        .map(|path| named_source(path, None))
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

/// Returns a peak [rad] as the terminal shows it in a table.
#[pyfunction]
fn peak_text(peak: f64, uncertainty: Option<f64>, threshold: f64, opens: bool) -> String {
    KnownPeak::of(peak, uncertainty, threshold, opens)
        .short()
        .replace('\u{a0}', " ")
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
    let date = date.unwrap_or_else(clock::today);
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
            let dated = (&summary, date.as_str());
            files::write(folder, (&plan, &store), dated, reports, &limits, control)?;
        }
        let mut text = Vec::new();
        summary.write_json(&mut text)?;
        Ok(text)
    })?;
    String::from_utf8(summary).map_err(wrong)
}

fn plan(path: &Path, limits: &Limits) -> PyResult<Plan> {
    check_exists(path)?;
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

/// Slowest rate at which times without a stated unit pass for seconds [Hz]: no crash recording is slower.
const SLOWEST_HZ: f64 = 250.0;

/// Returns a table of two columns, time and acceleration, each number in the fewest digits that read
/// back. The arrays are read where they lie. The time is in seconds unless its unit is stated; where that
/// makes no crash recording, the head leaves the unit out, so that the reader of the table doubts it.
#[pyfunction]
fn table<'py>(
    py: Python<'py>,
    time: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    unit: Option<&str>,
    time_unit: Option<&str>,
) -> PyResult<Bound<'py, PyBytes>> {
    let (time, values) = (time.as_array(), values.as_array());
    let span = time
        .last()
        .zip(time.first())
        .map(|(last, first)| last - first);
    let is_slow = span.is_some_and(|span| span * SLOWEST_HZ > (time.len() - 1) as f64);
    let mut text = String::from("time");
    if let Some(unit) = time_unit {
        let known = TimeUnit::from_spelling(unit).ok_or_else(|| {
            let known = "s, ms, us, ns, min, h, day, 10us";
            wrong(format!(
                "the time unit `{unit}` is not known; known: {known}"
            ))
        })?;
        text += &format!(" [{known}]");
    } else if !is_slow {
        text += " [s]";
    }
    text += ",acceleration";
    if let Some(unit) = unit {
        let known = AccelerationUnit::from_spelling(unit).ok_or_else(|| {
            let known = AccelerationUnit::ALL.map(|(_, name)| name).join(", ");
            wrong(format!("the unit `{unit}` is not known; known: {known}"))
        })?;
        text += &format!(" [{}]", known.name());
    }
    text.push('\n');
    for (time, value) in time.iter().zip(values) {
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

/// As [`named_source`], of a file that is there.
fn source(path: &Path, bytes: Option<Arc<[u8]>>) -> PyResult<Source> {
    let source = named_source(path, bytes)?;
    if let Source::File(path) = &source {
        check_exists(path)?;
    }
    Ok(source)
}

/// Refuses a path that names nothing, with the folder in which it was looked for.
fn check_exists(path: &Path) -> PyResult<()> {
    match path.metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let shown = path.display().to_string();
            let folder = std::env::current_dir().ok().filter(|_| path.is_relative());
            let folder = folder.map_or(String::new(), |folder| format!(" in {}", folder.display()));
            let text = format!("{shown}: there is no such file{folder}");
            Err(MissingFile::new_err((text, Vec::<String>::new(), shown)))
        }
        _ => Ok(()),
    }
}

/// Returns what a path names, a file or a pulse by its word, or the bytes of a file of that name.
fn named_source(path: &Path, bytes: Option<Arc<[u8]>>) -> PyResult<Source> {
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
        ErrorKind::UnknownName { .. } => PyTypeError::new_err(with_keywords(&error.to_string())),
        _ => wrong(error),
    }
}

fn wrong(error: impl Display) -> PyErr {
    PyValueError::new_err(with_keywords(&error.to_string()))
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
    NotJudged::new_err((with_keywords(&error.to_string()), candidates))
}

/// Returns a text with Python's keywords.
#[pyfunction]
fn keywords(text: &str) -> String {
    with_keywords(text)
}

/// Returns a text of the terminal with what to type next in Python.
fn in_python(text: &str) -> String {
    with_keywords(text)
        .replace("latchgate margin searches", "result.margin() searches")
        .replace("-v tells them", "result.findings has them")
}

/// Writes settings with values as Python's keywords: ``the setting `filter` = none`` becomes
/// `filter="none"`. A setting without a value keeps its name, which is the keyword.
fn with_keywords(text: &str) -> String {
    // In one piece it would read as a setting's name that is not closed.
    const NAMED: &str = concat!("the setting ", '`');
    let mut written = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, named)) = rest.split_once(NAMED) {
        written += before;
        match named.split_once("` = ") {
            Some((key, stated)) if !key.contains('`') => {
                let (value, after) = first_value(key, stated);
                written += &format!("{key}={}", python_value(key, &value));
                rest = after;
            }
            _ => {
                written += NAMED;
                rest = named;
            }
        }
    }
    written += rest;
    // A keyword is stated once.
    written.replace("}, set={", ", ")
}

/// Splits a text behind the value at its start, which is quoted as for a shell, or ends with its word.
fn first_value<'a>(key: &str, text: &'a str) -> (String, &'a str) {
    if let Some(quote) = text.chars().next().filter(|c| ['\'', '"'].contains(c)) {
        let mut value = String::new();
        let mut rest = &text[1..];
        while let Some((part, after)) = rest.split_once(quote) {
            value += part;
            // An apostrophe within apostrophes.
            let Some(further) = after.strip_prefix("\\''") else {
                return (value, after);
            };
            value.push('\'');
            rest = further;
        }
    }
    let end = match key {
        // A channel's name may hold blanks; it ends its sentence.
        "radial_channel" => text.find(". ").unwrap_or(text.len()),
        _ => text
            .find(|c: char| c.is_whitespace() || c == ';' || c == ')')
            .unwrap_or(text.len()),
    };
    let word = &text[..end];
    // The decimal mark is a word of one.
    let value = match word.len() {
        1 => word,
        _ => word.trim_end_matches(['.', ',', ':']),
    };
    (value.into(), &text[value.len()..])
}

/// Returns a value as Python writes it for a keyword; what a person fills in stays bare.
fn python_value(key: &str, value: &str) -> String {
    const FILLED_IN: [&str; 9] = [
        "NAME",
        "HZ",
        "S",
        "UNIT",
        "DIR",
        "VALUE",
        "START",
        "END",
        "TOPIC:FIELD",
    ];
    let one = |value: &str| {
        let is_bare = FILLED_IN.contains(&value) || value == "…" || value.parse::<f64>().is_ok();
        if is_bare {
            value.to_string()
        } else {
            serde_json::Value::from(value).to_string()
        }
    };
    let several = |mark: &str, between: &str| {
        let values: Vec<String> = value.split(mark).map(one).collect();
        values.join(between)
    };
    match (key, value.split_once('=')) {
        ("set" | "limit", Some((name, value))) => format!("{{{}: {}}}", one(name), one(value)),
        ("window" | "bias", _) if value.contains("..") => format!("({})", several("..", ", ")),
        ("accepted_remarks", _) => format!("[{}]", one(value)),
        ("accept", _) if value.contains(',') => format!("[{}]", several(",", ", ")),
        ("sensitivity", _) => one(value),
        _ => several("|", "|"),
    }
}
