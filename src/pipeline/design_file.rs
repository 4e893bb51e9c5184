//! A design file within its limits.

use crate::error::{Error, Place};
use crate::model::Design;
use crate::recording::Limits;
use std::path::Path;

/// Reads a design from the bytes of a TOML file; one without a name of its own is named after the
/// file.
///
/// Whoever reads the bytes from a file need not read more than `limits.settings_bytes` and one.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Limits, design_from_bytes};
///
/// let file = b"name = \"stiff\"\n[lever]\npreload_torque_nm = 2.82\n";
/// let design = design_from_bytes("stiff.toml", file, &Limits::default())?;
/// assert_eq!(design.lever.preload_torque_nm, 2.82);
/// let slip = design_from_bytes("slip.toml", b"[lever]\nmas_kg = 1", &Limits::default());
/// assert!(slip.unwrap_err().to_string().contains("mass_kg"));
/// # Ok::<(), latchgate::error::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::error::ErrorKind::LimitExceeded`] beyond the limit,
/// [`crate::error::ErrorKind::Malformed`] if they are no UTF-8, and those of [`Design::from_toml`],
/// each at the file's name.
pub fn design_from_bytes(file: &str, bytes: &[u8], limits: &Limits) -> Result<Design, Error> {
    let place = Place::file(file);
    if bytes.len() as u64 > limits.settings_bytes {
        return Err(Error::over(
            "settings_bytes",
            limits.settings_bytes,
            "a larger design file",
        )
        .at(place));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        Error::malformed(
            "UTF-8",
            format!("a stray byte after {} bytes", error.valid_up_to()),
            "save the design file as UTF-8",
        )
        .at(place.clone())
    })?;
    let mut design = Design::from_toml(text).map_err(|error| error.at(place))?;
    if design.name.is_empty() {
        design.name = Path::new(file).file_stem().map_or_else(
            || "design".into(),
            |stem| stem.to_string_lossy().into_owned(),
        );
    }
    Ok(design)
}
