//! `latchgate init`: a commented file to start from.

use super::failure::Failure;
use super::output;
use crate::pipeline::{Control, Limits, Source, card_for};
use clap::{Args, ValueEnum};
use latchgate_recording::error::Error;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Options of `init`.
#[derive(Debug, Clone, Args)]
pub struct InitArguments {
    /// What to write
    #[arg(value_enum)]
    pub template: Template,
    /// File to write [default: card.toml, design.toml or gate.toml]; of a card, or the recording that it is of
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Of a design: the lever alone, or an inertia catch beside it
    #[arg(long, value_enum, default_value_t = MechanismKind::Lever)]
    pub mechanism: MechanismKind,
}

/// What a design to start from holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MechanismKind {
    /// The lever alone.
    Lever,
    /// An inertia catch beside it.
    Catch,
}

/// A file to start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// What a recording's file does not state: RECORDING.toml.
    Card,
    /// A lever, its stop and the criterion.
    Design,
    /// Recordings times designs, and what is required of them.
    Gate,
}

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &InitArguments) -> Result<u8, Failure> {
    const DESIGN: &str = include_str!("init/design.toml");
    let (name, text) = match (arguments.template, arguments.mechanism) {
        (Template::Design, MechanismKind::Lever) => ("design.toml", DESIGN.to_string()),
        (Template::Design, MechanismKind::Catch) => (
            "design.toml",
            [DESIGN, include_str!("init/catch.toml")].concat(),
        ),
        (_, MechanismKind::Catch) => {
            return Err(Failure::Usage(Error::malformed(
                "--mechanism with `design`",
                "--mechanism with another file",
                "latchgate init design --mechanism catch",
            )));
        }
        (Template::Card, _) => ("card.toml", include_str!("init/card.toml").to_string()),
        (Template::Gate, _) => ("gate.toml", include_str!("init/gate.toml").to_string()),
    };
    if arguments.template == Template::Card
        && let Some(recording) = arguments.file.as_deref().filter(|path| is_recording(path))
    {
        return card_of(recording);
    }
    let path = arguments.file.as_deref().unwrap_or(Path::new(name));
    create(path, &text).map_err(Failure::Data)?;
    output::text(&format!("{}\n", path.display())).map_err(Failure::Data)?;
    Ok(0)
}

/// True of a file or folder that is there and is no card.
fn is_recording(path: &Path) -> bool {
    let is_card = path
        .extension()
        .is_some_and(|extension| extension == "toml");
    path.exists() && !is_card
}

/// Writes the card of a recording beside it: what its file says, and blanks for the rest.
fn card_of(recording: &Path) -> Result<u8, Failure> {
    let mut name = recording.as_os_str().to_owned();
    name.push(".toml");
    let path = PathBuf::from(name);
    let source = Source::File(recording.to_path_buf());
    // A card that is there is not to be read first: it stays as it is.
    if path.exists() {
        return create(&path, "").map(|()| 0).map_err(Failure::Data);
    }
    let text = card_for(&source, &Limits::default(), &Control::default()).map_err(Failure::Data)?;
    create(&path, &text).map_err(Failure::Data)?;
    output::text(&format!("{}\n", path.display())).map_err(Failure::Data)?;
    Ok(0)
}

/// Writes a new file.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if it exists, or cannot be written.
pub(super) fn create(path: &Path, text: &str) -> Result<(), Error> {
    OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(path)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => Error::io_at(
                "write a file to start from",
                path,
                &"it is there already and stays as it is; name a file that is not there yet",
            ),
            _ => Error::io_at("write a file to start from", path, &error),
        })
}
