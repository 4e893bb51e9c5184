//! Gates on a cluster: written to a folder that its nodes see, then submitted and monitored by the command
//! line, `latchgate gate`, whose store of shares holds their progress.
//!
//! The folder holds the input and the ledger the outcome, so that a service that restarts finds both again.
//! Submitting a gate twice is harmless: pairs in the store are not judged again.

use crate::app::{App, Parts};
use crate::config::EngineOptions;
use crate::engine::{EngineTasks, Look};
use crate::gate::{self, Decided};
use crate::problem::Problem;
use crate::store::{GateRecording, GateStanding, StoreError, StoredFile, StoredGate, sha256_of};
use axum::http::StatusCode;
use latchgate::gate::{Collection, GateFile, JudgedRecording, Plan, Submission};
use latchgate::pipeline::{Control, Error, Limits};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Time between two polls of a gate.
const EVERY: Duration = Duration::from_secs(2);

/// Polls in a row that find nothing of a gate in the queue before it counts as lost.
const GONE: u32 = 3;

/// Polls in a row without an answer before a gate is given up.
const UNANSWERED: u32 = 20;

/// Number of times that tasks which never run are submitted again.
const RESUBMITS: u32 = 3;

/// Largest number of bytes of a program's message that are passed on.
const TOLD: u64 = 2000;

/// Name of the gate file.
const GATE: &str = "gate.toml";

/// State of a gate, as the command line reports it.
#[derive(Debug, Default, Deserialize)]
struct GateStatus {
    done: u64,
    missing: u64,
    engine: Option<EngineTasks>,
}

/// Submits the waiting gates and polls the others, until the service ends.
pub async fn keep(app: App) {
    loop {
        let kept = app.apart(|parts| {
            for standing in parts.ledger.open_gates()?.entries {
                if standing.gate.engine.is_some()
                    && let Err(problem) = step(parts, &standing)
                {
                    // One gate that fails does not hold up the others.
                    let gate = &standing.gate.id;
                    tracing::warn!(%gate, problem = %problem.detail, "a gate of the cluster cannot be looked at");
                }
            }
            Ok(())
        });
        if let Err(problem) = kept.await {
            tracing::warn!(problem = %problem.detail, "gates of the cluster cannot be looked at");
        }
        tokio::time::sleep(EVERY).await;
    }
}

/// Takes the next step of a gate, if it is due.
fn step(parts: &Parts, standing: &GateStanding) -> Result<(), Problem> {
    let gate = &standing.gate;
    let mut look = parts
        .engine
        .looks()
        .get(&gate.id)
        .cloned()
        .unwrap_or_default();
    if look.next.is_some_and(|next| Instant::now() < next) {
        return Ok(());
    }
    let Some(options) = &parts.config.engine else {
        let text = "the service runs without an engine now; start it with `engine`".into();
        return fail(parts, gate, text);
    };
    let began = Instant::now();
    let place = Place {
        folder: options.folder.join(&gate.id),
        options,
    };
    match place.advance(parts, standing, &mut look) {
        Ok(Some(decided)) => {
            gate::settle(parts, gate, decided)?;
            parts.engine.looks().remove(&gate.id);
            return Ok(());
        }
        Ok(None) => {}
        Err(text) => return fail(parts, gate, text),
    }
    look.next = Some(Instant::now() + EVERY.max(began.elapsed() * 5));
    parts.engine.looks().insert(gate.id.clone(), look);
    Ok(())
}

/// Ends a gate with a problem. Submitting it again starts it again, so the mark of its submission is removed.
fn fail(parts: &Parts, gate: &StoredGate, text: String) -> Result<(), Problem> {
    if let Some(options) = &parts.config.engine {
        let _ = fs::remove_file(options.folder.join(&gate.id).join("submitted"));
    }
    let detail = format!("{text}; what is judged is kept, submit the gate again to go on");
    let title = "The cluster has not judged the gate";
    let problem = Problem::new(StatusCode::BAD_GATEWAY, "engine", title, detail);
    gate::end_without(parts, gate, &problem)?;
    parts.engine.looks().remove(&gate.id);
    Ok(())
}

/// Folder of a gate of the cluster.
struct Place<'a> {
    folder: PathBuf,
    options: &'a EngineOptions,
}

impl Place<'_> {
    /// Submits the gate, or polls it; returns the decisions once all are in the store.
    fn advance(
        &self,
        parts: &Parts,
        standing: &GateStanding,
        look: &mut Look,
    ) -> Result<Option<Decided>, String> {
        let gate = &standing.gate;
        let marked = self.folder.join("submitted");
        if !marked.exists() {
            self.lay_out(parts, gate)?;
            self.submit(gate)?;
            File::create(&marked).map_err(|error| error.to_string())?;
            return Ok(None);
        }
        let status = match self.status() {
            Ok(status) => status,
            Err(text) => {
                look.unanswered += 1;
                let error = Some(text.clone());
                look.tasks = Some(EngineTasks {
                    error,
                    ..EngineTasks::default()
                });
                return if look.unanswered >= UNANSWERED {
                    Err(text)
                } else {
                    Ok(None)
                };
            }
        };
        look.unanswered = 0;
        look.decided = status.done;
        if status.missing == 0 {
            return self.decided(parts, gate).map(Some);
        }
        let tasks = status.engine.unwrap_or_default();
        let idle = tasks.error.is_none() && tasks.running + tasks.waiting == 0;
        if idle && tasks.stuck > 0 && look.resubmits < RESUBMITS {
            look.resubmits += 1;
            self.run(&["--resubmit"])?;
        }
        let is_gone = idle && !(tasks.collecting && tasks.stuck == 0);
        look.gone = if is_gone { look.gone + 1 } else { 0 };
        look.tasks = Some(tasks);
        if look.gone < GONE {
            return Ok(None);
        }
        Err(format!(
            "{} of {} pairs are not in the store, and nothing in the queue is to judge them; see \
             what the tasks printed in {}",
            status.missing,
            gate.recordings.len() * gate.designs.len(),
            self.folder.join("store/engine").display()
        ))
    }

    /// Writes recordings, designs and gate file into the folder that the nodes read.
    fn lay_out(&self, parts: &Parts, gate: &StoredGate) -> Result<(), String> {
        let io_text = |error: io::Error| format!("{}: {error}", self.folder.display());
        fs::create_dir_all(self.folder.join("designs")).map_err(io_text)?;
        let mut placed = Vec::with_capacity(gate.recordings.len());
        for recording in &gate.recordings {
            placed.push(self.place(parts, recording)?);
        }
        for (number, design) in gate.designs.iter().enumerate() {
            let text = design_text(design);
            fs::write(self.folder.join(design_file(number)), text).map_err(io_text)?;
        }
        fs::write(self.folder.join(GATE), gate_file(gate, &placed)?).map_err(io_text)?;
        let read = self.plan()?;
        if read
            .designs
            .iter()
            .map(|design| json!(design))
            .eq(gate.designs.iter().cloned())
        {
            return Ok(());
        }
        Err("a design cannot be handed over as it is".into())
    }

    /// Writes the files of a recording; returns the path of the one to read.
    fn place(&self, parts: &Parts, recording: &GateRecording) -> Result<String, String> {
        let stored = parts
            .ledger
            .recording(&recording.id)
            .map_err(|error| error.to_string())?;
        let manifest = stored.ok_or("a recording of the gate is gone")?.manifest;
        let home = format!("recordings/{}", recording.id);
        let path = format!("{home}/{}", manifest.name);
        // A recording without a file of its name is the folder that its files form.
        let is_file = manifest.files.iter().any(|file| file.name == manifest.name);
        let around = if is_file { &home } else { &path };
        let card = manifest
            .card
            .iter()
            .map(|card| (format!("{path}.toml"), card));
        let files = manifest.files.iter();
        let files = files.map(|file| (format!("{around}/{}", file.name), file));
        for (name, file) in files.chain(card) {
            self.copy(parts, &name, file)
                .map_err(|error| format!("{name}: {error}"))?;
        }
        Ok(path)
    }

    fn copy(&self, parts: &Parts, name: &str, file: &StoredFile) -> Result<(), StoreError> {
        let path = self.folder.join(name);
        // Nodes can write in this folder, so an existing file counts only if its hash is right.
        if fs::metadata(&path).is_ok_and(|metadata| metadata.len() == file.bytes)
            && sha256_of(File::open(&path)?)? == file.sha256
        {
            return Ok(());
        }
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder)?;
        let space = rustix::fs::statvfs(folder).map_err(io::Error::from)?;
        if space.f_bavail.saturating_mul(space.f_frsize) < parts.config.free_bytes + file.bytes {
            return Err(StoreError::Full);
        }
        let beside = self.folder.join("unfinished");
        io::copy(
            &mut parts.blobs.open(&file.sha256)?,
            &mut File::create(&beside)?,
        )?;
        Ok(fs::rename(&beside, &path)?)
    }

    fn submit(&self, gate: &StoredGate) -> Result<(), String> {
        let pairs = (gate.recordings.len() * gate.designs.len()) as u64;
        let shares = pairs.div_ceil(self.options.share_pairs);
        let shares = shares.clamp(1, gate.recordings.len() as u64).to_string();
        let mut words = vec![
            "--submit",
            "slurm",
            "--parts",
            &shares,
            "--untried",
            "--reports",
            "none",
            "--out",
            "out",
            "--",
        ];
        words.extend(self.options.words.iter().map(String::as_str));
        self.run(&words).map(drop)
    }

    fn status(&self) -> Result<GateStatus, String> {
        let answer = self.run(&["--status", "--format", "json"])?;
        serde_json::from_str(&answer).map_err(|error| format!("how the gate stands: {error}"))
    }

    /// Runs the command line on the gate; returns its standard output.
    fn run(&self, words: &[&str]) -> Result<String, String> {
        let (out, err) = (self.folder.join("printed"), self.folder.join("said"));
        let io_text = |error: io::Error| format!("{}: {error}", self.options.program.display());
        let mut child = Command::new(&self.options.program)
            .args(["gate", GATE, "--store", "store"])
            .args(words)
            .current_dir(&self.folder)
            .stdin(Stdio::null())
            .stdout(File::create(&out).map_err(io_text)?)
            .stderr(File::create(&err).map_err(io_text)?)
            .spawn()
            .map_err(io_text)?;
        let began = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().map_err(io_text)? {
                break status;
            }
            if began.elapsed() >= self.options.time {
                let _ = child.kill();
                let _ = child.wait();
                let seconds = self.options.time.as_secs();
                return Err(format!(
                    "latchgate gate {} did not end in `engine_s` of {seconds} s",
                    words.first().unwrap_or(&"")
                ));
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        if status.success() {
            return fs::read_to_string(&out).map_err(io_text);
        }
        let mut message = String::new();
        let read = File::open(&err).and_then(|file| file.take(TOLD).read_to_string(&mut message));
        let lines = message
            .lines()
            .map(|line| line.trim_start_matches("latchgate: "));
        let message = lines.collect::<Vec<_>>().join("; ");
        Err(match read {
            Ok(1..) => message,
            _ => format!("latchgate gate ended with {status}"),
        })
    }

    /// Reads the gate from the folder, as the nodes do.
    fn plan(&self) -> Result<Plan, String> {
        let first_text =
            |errors: Vec<Error>| errors.first().map_or_else(String::new, Error::to_string);
        let text = fs::read_to_string(self.folder.join(GATE)).map_err(|error| error.to_string())?;
        let limits = Limits::default();
        let file = GateFile::from_toml(GATE, &text, &limits).map_err(first_text)?;
        Plan::of(GATE, &file, &self.folder, &[], &limits).map_err(first_text)
    }

    /// Reads the decisions out of the store, in the order of the gate's recordings.
    fn decided(&self, parts: &Parts, gate: &StoredGate) -> Result<Decided, String> {
        let error_text = |error: Error| error.to_string();
        let (plan, limits) = (self.plan()?, Limits::default());
        let store = self.folder.join("store");
        let submission = Submission::read(&store, GATE).map_err(error_text)?;
        let control = Control::default();
        // Writing the recordings again checks that the nodes judged the files that the service holds.
        for recording in &gate.recordings {
            self.place(parts, recording)?;
        }
        let collection = Collection::of(&plan, &store, submission.as_ref(), &limits, &control);
        let judged = collection.and_then(|collection| {
            collection.check_unchanged(&limits, &control)?;
            collection.judged()
        });
        let names = plan
            .recordings
            .iter()
            .map(|recording| recording.name.as_str());
        let by_name: BTreeMap<&str, JudgedRecording> =
            names.zip(judged.map_err(error_text)?).collect();
        let mut decisions = Vec::with_capacity(gate.recordings.len());
        for recording in &gate.recordings {
            let mut name = self.place(parts, recording)?;
            if let Some(channel) = recording.request["channel"].as_str() {
                name = format!("{name}#{channel}");
            }
            let judged = by_name.get(name.as_str()).cloned();
            decisions.push(judged.ok_or_else(|| format!("{name} is not in the store"))?);
        }
        Ok(decisions)
    }
}

fn design_file(number: usize) -> String {
    format!("designs/{number}.toml")
}

/// Returns the gate file of the cluster: the entries of the gate with the paths in the folder. It has no
/// requirements; the service checks those itself.
fn gate_file(gate: &StoredGate, placed: &[String]) -> Result<String, String> {
    let odd = || "the gate file cannot be read again".to_string();
    let file =
        GateFile::from_toml(&gate.name, &gate.text, &Limits::default()).map_err(|_| odd())?;
    let text = gate.text.trim_start_matches('\u{feff}');
    let table: toml::Table = toml::from_str(text).map_err(|_| odd())?;
    let entries = table
        .get("recordings")
        .and_then(toml::Value::as_array)
        .ok_or_else(odd)?;
    let requests: Vec<Value> = file
        .recordings
        .iter()
        .map(|entry| json!(entry.request))
        .collect();
    let mut files = vec![Vec::new(); requests.len()];
    for (recording, path) in gate.recordings.iter().zip(placed) {
        let entry = requests
            .iter()
            .position(|request| *request == recording.request);
        files[entry.ok_or_else(odd)?].push(path);
    }
    let mut text = String::new();
    for (entry, mut files) in entries.iter().zip(files) {
        files.dedup();
        if files.is_empty() {
            continue;
        }
        let mut entry = json!(entry);
        entry["files"] = json!(files);
        text += "[[recordings]]\n";
        for (key, value) in entry.as_object().into_iter().flatten() {
            text += &format!("{} = {}\n", json!(key), toml_of(value));
        }
    }
    for (number, design) in gate.designs.iter().enumerate() {
        let file = json!(design_file(number));
        let set = changed(design).map(|key| format!("{key}={}", number_at(design, key)));
        let set: Vec<String> = set.collect();
        text += &format!("[[designs]]\nfile = {file}\n");
        if !set.is_empty() {
            text += &format!("set = {}\n", toml_of(&json!(set)));
        }
    }
    Ok(text)
}

/// Returns the keys of a design that were overridden.
fn changed(design: &Value) -> impl Iterator<Item = &str> {
    design["modified"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
}

fn number_at<'a>(design: &'a Value, key: &str) -> &'a Value {
    let (table, key) = key.split_once('.').unwrap_or((key, ""));
    &design[table][key]
}

/// Returns the design file of a design without its overrides; the node applies them again, since they are part
/// of the design's identity.
fn design_text(design: &Value) -> String {
    let mut before = design.clone();
    before["criterion"]["raised_from_rad"] = Value::Null;
    for key in changed(design) {
        if let Some((table, name)) = key.split_once('.') {
            before[table][name] = design["modified_from"][key].clone();
        }
    }
    let keys = before.as_object().into_iter().flatten();
    let keys = keys.filter(|(key, _)| !key.starts_with("modified"));
    let lines = keys.map(|(key, value)| format!("{} = {}\n", json!(key), toml_of(value)));
    lines.collect()
}

/// Writes a value as TOML on one line. Texts and numbers are those of JSON.
fn toml_of(value: &Value) -> String {
    match value {
        Value::Object(table) => {
            let stated = table.iter().filter(|(_, value)| !value.is_null());
            let keys = stated.map(|(key, value)| format!("{} = {}", json!(key), toml_of(value)));
            format!("{{ {} }}", keys.collect::<Vec<_>>().join(", "))
        }
        Value::Array(list) => {
            let values: Vec<String> = list.iter().map(toml_of).collect();
            format!("[{}]", values.join(", "))
        }
        // TOML takes no DEL in a text.
        Value::String(text) => json!(text).to_string().replace('\u{7f}', "\\u007f"),
        other => other.to_string(),
    }
}
