//! The decisions of a sweep as columns: an array of recordings × designs for each quantity.
//!
//! # Source
//!
//! NumPy Enhancement Proposal 1, "A Simple File Format for NumPy Arrays", version 1.0.

use crate::pipeline::DecisionRow;
use latchgate_recording::error::{Error, Place};
use latchgate_report::Unplaced;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// A number of a row.
type NumberOf = fn(&DecisionRow) -> Option<f64>;

/// The numbers of a row, `NaN` where there is none.
const NUMBERS: [(&str, NumberOf); 6] = [
    ("peak_angle_rad", |row| row.peak_angle_rad),
    ("uncertainty_rad", |row| row.uncertainty_rad),
    ("coast_peak_angle_rad", |row| row.coast_peak_angle_rad),
    ("threshold_rad", |row| Some(row.threshold_rad)),
    ("share_lower", |row| row.share.map(|share| share.0)),
    ("share_upper", |row| row.share.map(|share| share.1)),
];

/// The array of answers, each as the exit code of a replay.
const VERDICT: &str = "verdict";

/// Bytes to a multiple of which a header is filled up.
const ALIGNED: usize = 64;

/// Columns that are being written, beside their place.
#[derive(Debug)]
pub struct Columns {
    beside: Unplaced,
    verdicts: BufWriter<File>,
    numbers: Vec<BufWriter<File>>,
}

impl Columns {
    /// Begins the columns that are to be put in place as `folder`.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if they cannot be written.
    pub fn beside(folder: &Path, recordings: &[String], designs: &[String]) -> Result<Self, Error> {
        let beside = Unplaced::beside(folder)?;
        let shape = (recordings.len(), designs.len());
        let array = |name: &str, kind: &str| {
            let path = beside.path().join(format!("{name}.npy"));
            let begun = File::create(&path).map(BufWriter::new).and_then(|mut out| {
                out.write_all(&header(kind, shape))?;
                Ok(out)
            });
            begun.map_err(|error| Error::io_at("write the columns", &path, &error))
        };
        for (name, list) in [("recordings", recordings), ("designs", designs)] {
            let path = beside.path().join(format!("{name}.json"));
            serde_json::to_vec(list)
                .map_err(io::Error::from)
                .and_then(|text| fs::write(&path, text))
                .map_err(|error| Error::io_at("write the columns", &path, &error))?;
        }
        Ok(Self {
            verdicts: array(VERDICT, "|u1")?,
            numbers: NUMBERS
                .iter()
                .map(|(name, _)| array(name, "<f8"))
                .collect::<Result<_, _>>()?,
            beside,
        })
    }

    /// Adds the next pair, designs of one recording after the other.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written.
    pub fn add(&mut self, row: &DecisionRow) -> Result<(), Error> {
        let mut written = self.verdicts.write_all(&[row.verdict.exit_code()]);
        for ((_, number), out) in NUMBERS.iter().zip(&mut self.numbers) {
            let number = number(row).unwrap_or(f64::NAN);
            written = written.and_then(|()| out.write_all(&number.to_le_bytes()));
        }
        written.map_err(|error| Error::io_at("write the columns", self.beside.path(), &error))
    }

    /// Puts the columns in place, where a folder of columns is replaced.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if that fails, [`latchgate_recording::error::ErrorKind::Malformed`] where
    /// anything else stands there.
    pub fn settle(mut self, folder: &Path) -> Result<(), Error> {
        for out in self.numbers.iter_mut().chain([&mut self.verdicts]) {
            out.flush()
                .map_err(|error| Error::io_at("write the columns", folder, &error))?;
        }
        self.beside.settle(folder, |_| others(folder)).map(drop)
    }
}

/// Refuses to replace a folder that holds what are no columns.
fn others(folder: &Path) -> Option<Result<(), Error>> {
    let arrays = NUMBERS.iter().map(|(name, _)| *name).chain([VERDICT]);
    let mut ours: BTreeSet<String> = arrays.map(|name| format!("{name}.npy")).collect();
    ours.extend(["recordings.json", "designs.json"].map(String::from));
    let names = fs::read_dir(folder).ok()?.flatten();
    let mut names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let other = names.find(|name| !ours.contains(name))?;
    let error = Error::malformed(
        "a folder of columns alone, since it is replaced",
        format!("`{other}` in it"),
        "name another folder for the columns",
    );
    Some(Err(error.at(Place::path(folder))))
}

/// Returns the header of an array in the order of C.
fn header(kind: &str, (rows, columns): (usize, usize)) -> Vec<u8> {
    let said =
        format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let magic = b"\x93NUMPY\x01\x00";
    let whole = (magic.len() + 2 + said.len() + 1).next_multiple_of(ALIGNED);
    let length = whole - magic.len() - 2;
    let mut header = magic.to_vec();
    header.extend((length as u16).to_le_bytes());
    header.extend(said.as_bytes());
    header.resize(whole - 1, b' ');
    header.push(b'\n');
    header
}
