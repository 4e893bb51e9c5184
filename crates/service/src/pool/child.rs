//! The child's side: reads orders from its standard input, answers on its standard output.

use super::answer::Worker;
use super::frame;
use super::words::{Answer, Beat, ChildMessage, Enclosed, Enclosure, OrderMessage};
use crate::jail;
use latchgate::pipeline::{Control, Source};
use std::io::{self, BufReader, Read, Write};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Largest number of recordings that a child holds.
const HELD: usize = 6;

/// Time between two beats.
const BEAT: Duration = Duration::from_millis(200);

/// A recording that the child holds.
struct HeldRecording {
    id: String,
    source: Source,
    /// The bytes of the file to read.
    head: Arc<[u8]>,
    bytes: u64,
}

/// Enters the jail and answers orders until its input ends.
///
/// # Errors
///
/// Any error of the pipes: the parent has gone, or breaks the protocol.
pub fn work(memory_bytes: u64) -> io::Result<()> {
    let out = Mutex::new(io::stdout());
    let mut input = BufReader::new(io::stdin());
    say(
        &out,
        &ChildMessage::Hello {
            jail: jail::enter(memory_bytes),
        },
    )?;
    let mut recordings: Vec<HeldRecording> = Vec::new();
    let mut worker = Worker::default();
    while let Some(message) = frame::read::<OrderMessage>(&mut input)? {
        jail::allow_cpu(message.cpu_s);
        let id = message.order.needs().unwrap_or("").to_string();
        if let Some(enclosed) = &message.enclosed {
            let fresh = receive(&mut input, &id, enclosed)?;
            recordings.retain(|recordings| recordings.id != id);
            make_room(&mut recordings, fresh.bytes, memory_bytes / 4);
            recordings.push(fresh);
        } else if let Some(index) = recordings.iter().position(|recordings| recordings.id == id) {
            let recording = recordings.remove(index);
            recordings.push(recording);
        }
        let ids: Vec<String> = recordings
            .iter()
            .map(|recordings| recordings.id.clone())
            .collect();
        worker.keep_only(&ids);
        let nothing = (Source::bytes("", *b""), Arc::from([]));
        let (source, head) = recordings
            .last()
            .filter(|recordings| recordings.id == id)
            .map_or(nothing, |recordings| {
                (recordings.source.clone(), Arc::clone(&recordings.head))
            });
        let (answer, files) = beating(&out, |control, tell| {
            worker.answer(&message.order, (&source, &head), control, tell)
        });
        deliver(&out, answer, &files, ids)?;
    }
    Ok(())
}

fn say(out: &Mutex<io::Stdout>, message: &ChildMessage) -> io::Result<()> {
    let mut out = out
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    frame::write(&mut *out, message)?;
    out.flush()
}

/// Runs work while sending beats; the work tells its steps, and what answer it knows before its end.
fn beating<T>(out: &Mutex<io::Stdout>, work: impl FnOnce(&Control<'_>, &dyn Fn(Beat)) -> T) -> T {
    let last = Mutex::new(Instant::now());
    let proceed = |part: Option<f64>| {
        let Ok(mut last) = last.try_lock() else {
            return true;
        };
        if last.elapsed() < BEAT {
            return true;
        }
        *last = Instant::now();
        // If a beat cannot be sent the parent has gone, so the work stops.
        let beat = Beat {
            part,
            ..Beat::default()
        };
        say(out, &ChildMessage::Beat(beat)).is_ok()
    };
    let tell = |beat: Beat| {
        // A parent that has gone is noticed at the next beat.
        let _ = say(out, &ChildMessage::Beat(beat));
    };
    let control = Control {
        threads: 1,
        proceed: &proceed,
    };
    work(&control, &tell)
}

/// Sends an answer, then the bytes of its files. The work has ended: no beat can come between the two.
fn deliver(
    out: &Mutex<io::Stdout>,
    answer: Answer,
    files: &[(String, Vec<u8>)],
    holds: Vec<String>,
) -> io::Result<()> {
    let enclosed = files.iter().map(|(name, bytes)| Enclosed {
        name: name.clone(),
        bytes: bytes.len() as u64,
    });
    say(
        out,
        &ChildMessage::Answer {
            answer,
            files: enclosed.collect(),
            holds,
        },
    )?;
    let mut out = out
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    for (_, bytes) in files {
        out.write_all(bytes)?;
    }
    out.flush()
}

/// Drops the oldest recordings until there is room for `bytes` more.
fn make_room(recordings: &mut Vec<HeldRecording>, bytes: u64, bytes_max: u64) {
    let total_bytes = |recordings: &[HeldRecording]| {
        recordings
            .iter()
            .map(|recordings| recordings.bytes)
            .sum::<u64>()
    };
    while !recordings.is_empty()
        && (recordings.len() >= HELD || total_bytes(recordings) + bytes > bytes_max)
    {
        recordings.remove(0);
    }
}

fn receive(input: &mut impl Read, id: &str, enclosed: &Enclosure) -> io::Result<HeldRecording> {
    let mut files = Vec::with_capacity(enclosed.files.len());
    for file in &enclosed.files {
        files.push((file.name.clone(), bytes_of(input, file)?));
    }
    let head = files
        .iter()
        .find(|(name, _)| *name == enclosed.name)
        .map_or_else(|| Arc::from([]), |(_, bytes)| Arc::clone(bytes));
    let mut source = Source::files(enclosed.name.clone(), files);
    let mut bytes = enclosed.files.iter().map(|file| file.bytes).sum();
    if let Some(card) = &enclosed.card {
        source = source.with_card(bytes_of(input, card)?);
        bytes += card.bytes;
    }
    Ok(HeldRecording {
        id: id.into(),
        source,
        head,
        bytes,
    })
}

fn bytes_of(input: &mut impl Read, file: &Enclosed) -> io::Result<Arc<[u8]>> {
    let length = usize::try_from(file.bytes).map_err(io::Error::other)?;
    let mut bytes = Vec::with_capacity(length);
    frame::copy(input, file.bytes, |piece| {
        bytes.extend_from_slice(piece);
        Ok(())
    })?;
    Ok(bytes.into())
}
