//! Design files: lever, stop, criterion and tolerances in TOML, and overrides of their numbers.

use latchgate_kernel::model::Design;
use latchgate_recording::Limits;
use latchgate_recording::error::{Error, Place, with_article};
use std::path::Path;

/// Tables of a design file.
const SECTIONS: [&str; 5] = ["lever", "stop", "criterion", "tolerance", "input"];

/// Reads a design from the bytes of a TOML file; one without a name of its own is named after the
/// file.
///
/// Whoever reads the bytes from a file need not read more than `limits.settings_bytes` and one.
///
/// # Examples
///
/// ```
/// use latchgate_document::design_file::design_from_bytes;
/// use latchgate_recording::Limits;
///
/// let file = b"name = \"stiff\"\n[lever]\npreload_torque_nm = 2.82\n";
/// let design = design_from_bytes("stiff.toml", file, &Limits::default())?;
/// assert_eq!(design.lever.preload_torque_nm, 2.82);
/// let slip = design_from_bytes("slip.toml", b"[lever]\nmas_kg = 1", &Limits::default());
/// assert!(slip.unwrap_err().to_string().contains("mass_kg"));
/// # Ok::<(), latchgate_recording::error::Error>(())
/// ```
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::LimitExceeded`] beyond the limit,
/// [`latchgate_recording::error::ErrorKind::Malformed`] if they are no UTF-8, and those of [`from_toml`],
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
    let mut design = from_toml(text).map_err(|error| error.at(place))?;
    if design.name.is_empty() {
        design.name = Path::new(file).file_stem().map_or_else(
            || "design".into(),
            |stem| stem.to_string_lossy().into_owned(),
        );
    }
    Ok(design)
}

/// Reads the text of a design file; keys that are absent take the reference design's values.
///
/// # Errors
///
/// [`Malformed`](latchgate_recording::error::ErrorKind::Malformed) if the text is not TOML or a value is of the wrong type,
/// [`UnknownName`](latchgate_recording::error::ErrorKind::UnknownName) for an unknown key, with the nearest known one,
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a value that no lever can have.
pub fn from_toml(text: &str) -> Result<Design, Error> {
    let table: toml::Table = text
        .parse()
        .map_err(|error: toml::de::Error| malformed(&error, text))?;
    let mut design = Design::reference();
    design.name = "design".into();
    for (key, value) in &table {
        match value {
            toml::Value::String(name) if key == "name" => design.name.clone_from(name),
            toml::Value::Table(entries) if SECTIONS.contains(&key.as_str()) => {
                put_section(&mut design, key, entries, text)?;
            }
            other => {
                return Err(wrong_entry(key, other).at(Place::of_key(text, None, key)));
            }
        }
    }
    design.validate()?;
    Ok(design)
}

/// Applies an override such as `lever.preload_torque_nm=2.82`.
///
/// # Errors
///
/// As [`from_toml`].
pub fn apply_override(design: &mut Design, assignment: &str) -> Result<(), Error> {
    let Some((key, value)) = assignment.split_once('=') else {
        return Err(Error::malformed(
            "KEY=VALUE",
            format!("`{assignment}`"),
            "for example the setting `set` = lever.preload_torque_nm=2.82",
        ));
    };
    let (key, value) = (key.trim(), value.trim());
    if key == "name" {
        design.name = value.to_string();
        return Ok(());
    }
    let number: f64 = value.parse().map_err(|_| {
        Error::malformed(
            format!("a number for {key}"),
            format!("`{value}`"),
            "write a decimal number with a dot",
        )
    })?;
    Ok(design.override_number(key, number)?)
}

/// Takes in a table of a design file.
fn put_section(
    design: &mut Design,
    section: &str,
    entries: &toml::Table,
    text: &str,
) -> Result<(), Error> {
    if section == "tolerance" {
        // A file that names its tolerances names all of them.
        design.tolerance.clear();
    }
    for (key, value) in entries {
        number(key, value)
            .and_then(|value| Ok(design.put_number(&format!("{section}.{key}"), value)?))
            .map_err(|error| error.at(Place::of_key(text, Some(section), key)))?;
    }
    Ok(())
}

/// Says what is wrong with an entry of a design file that is neither its name nor a section.
fn wrong_entry(key: &str, value: &toml::Value) -> Error {
    let expected = match key {
        "name" => "a text for `name`".into(),
        section if SECTIONS.contains(&section) => format!("a table [{section}]"),
        _ => {
            let known: Vec<_> = std::iter::once("name").chain(SECTIONS).collect();
            return Error::unknown("design key", key, &known);
        }
    };
    Error::malformed(
        expected,
        with_article(value.type_str()),
        "see the design file in the README",
    )
}

fn number(key: &str, value: &toml::Value) -> Result<f64, Error> {
    match value {
        toml::Value::Float(number) => Ok(*number),
        toml::Value::Integer(number) => Ok(*number as f64),
        other => Err(Error::malformed(
            format!("a number for `{key}`"),
            with_article(other.type_str()),
            "write a decimal number with a dot, without quotes",
        )),
    }
}

fn malformed(error: &toml::de::Error, text: &str) -> Error {
    Error::malformed(
        "a design file in TOML",
        error.message().to_string(),
        "see the design file in the README",
    )
    .at(Place::of_span(text, error.span()))
}
