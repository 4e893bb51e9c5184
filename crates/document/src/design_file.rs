//! Design files: lever, stop, criterion and tolerances in TOML, and overrides of their numbers.

use crate::design_document::{DOCUMENT, DesignDocument};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::catch::Catch;
use latchgate_kernel::model::linkage::{LinkageElement, Reduced};
use latchgate_kernel::model::parameters::{CATCH_PARAMETERS, DesignParameter, PARAMETERS, Slot};
use latchgate_kernel::model::tolerance::Tolerance;
use latchgate_kernel::model::vector::Vector;
use latchgate_recording::Limits;
use latchgate_recording::error::{Error, Place, with_article};
use latchgate_verdict::statics::StaticLever;
use std::path::Path;

/// Key of a design file that says whose values a lever takes that it does not state, and its one value.
const BASE: &str = "base";
const PAPER: &str = "paper";

/// Tables of a design file.
const SECTIONS: [&str; 6] = ["lever", "stop", "criterion", "tolerance", "input", "catch"];

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
/// let file = b"name = \"stiff\"\nbase = \"paper\"\n[lever]\npreload_torque_nm = 2.82\n";
/// let design = design_from_bytes("stiff.toml", file, &Limits::default())?;
/// assert_eq!(design.lever.preload_torque_nm, 2.82);
/// // Without `base` a lever is stated whole.
/// let part = design_from_bytes("part.toml", b"[lever]\nmass_kg = 1", &Limits::default());
/// assert!(part.unwrap_err().to_string().contains("preload_torque_nm"));
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
        design.name = stem(file);
    }
    Ok(design)
}

/// Reads the design of a verdict document, which states its lever whole.
///
/// # Errors
///
/// Says which key is wrong or missing, and how.
pub fn design_from_document(design: &serde_json::Value) -> Result<Design, String> {
    let read: Design = serde_path_to_error::deserialize(design.clone())
        .map_err(|error| format!("{}: {}", error.path(), error.inner()))?;
    let lever = design.get("lever");
    let states = |key: &str| lever.is_some_and(|lever| lever.get(key).is_some());
    let missing: Vec<&str> = lever_keys().filter(|key| !states(key)).collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        return Err(format!(
            "lever: expected every number of it, found none of {missing}"
        ));
    }
    Ok(read)
}

/// Reads the tables of a design file as JSON has them, or the design of a verdict document, which has the key
/// `modified`; no table at all is the paper's example.
///
/// # Errors
///
/// As [`from_toml`] of the tables; for a document as [`design_from_document`].
pub fn design_from_json(design: &serde_json::Value) -> Result<Design, String> {
    let Some(tables) = design.as_object() else {
        return Err("expected an object with the tables of a design file".into());
    };
    if tables.contains_key("modified") {
        return design_from_document(design);
    }
    if tables.is_empty() {
        return Ok(Design::reference());
    }
    let table = toml::Table::try_from(tables).map_err(|error| error.to_string())?;
    from_table(&table, "").map_err(|error| error.to_string())
}

/// Reads what a static calculation needs of a design file, with overrides, and what part it is of: of a linkage no
/// moment of inertia, damping or stop.
///
/// # Errors
///
/// As [`design_from_bytes`]; of a linkage, as [`StaticLever::of_linkage`], and for overrides of what an
/// incomplete one lacks.
pub fn static_from_bytes(
    file: &str,
    bytes: &[u8],
    overrides: &[String],
    limits: &Limits,
) -> Result<StaticDesign, Error> {
    let place = Place::file(file);
    let text = String::from_utf8_lossy(bytes);
    let document = document_of(&text).map_err(|error| error.at(place.clone()))?;
    if let Some(table) = std::str::from_utf8(bytes)
        .ok()
        .and_then(|text| text.parse().ok())
        && let Some(linkage) = linkage_of(&table).map_err(|error| error.at(place.clone()))?
        && !lacks(&table, &linkage).is_empty()
    {
        // The rest of the file is checked as any other.
        let mut without_linkage: toml::Table = table.clone();
        without_linkage.remove("linkage");
        without_linkage.insert(BASE.into(), PAPER.into());
        let checked =
            from_table(&without_linkage, &text).map_err(|error| error.at(place.clone()))?;
        if !overrides.is_empty() {
            return Err(Error::malformed(
                "a whole design, for overrides",
                format!(
                    "a linkage that lacks {}",
                    lacks(&table, &linkage).join(", ")
                ),
                "change the file",
            )
            .at(place));
        }
        let lever = table.get("lever").and_then(toml::Value::as_table);
        let is_redundant = |key: &&String| key.as_str() != "pivot_damping_nm_s_per_rad";
        if let Some(key) = lever.and_then(|lever| lever.keys().find(is_redundant)) {
            let redundant_key = format!("lever.{key} beside a linkage");
            let hint = "leave it out: the elements say all of the lever";
            return Err(Error::malformed("a linkage alone", redundant_key, hint).at(place));
        }
        limit_stated(&table, &linkage).map_err(|error| error.at(place.clone()))?;
        let name = match table.contains_key("name") {
            true => checked.name,
            false => stem(file),
        };
        let lever = StaticLever::of_linkage(name, checked.criterion.threshold_rad, linkage);
        let mut lever = lever.map_err(|error| Error::from(error).at(place))?;
        lever.has_catch = checked.catch.is_some();
        let scatter = |key: &str, value: f64| {
            let tolerance = checked.tolerance.get(key)?;
            Some(tolerance.deviation(value))
        };
        let stiffness = lever.spring_stiffness_nm_per_rad;
        lever.preload_deviation_nm = scatter("preload_torque_nm", lever.preload_torque_nm);
        lever.stiffness_deviation_nm_per_rad = scatter("spring_stiffness_nm_per_rad", stiffness);
        return Ok(StaticDesign {
            lever,
            document,
            whole: None,
        });
    }
    let mut design = design_from_bytes(file, bytes, limits)?;
    if text
        .parse()
        .is_ok_and(|table: toml::Table| !table.contains_key("name"))
    {
        design.name = stem(file);
    }
    for assignment in overrides {
        apply_override(&mut design, assignment)?;
    }
    design.validate()?;
    Ok(StaticDesign {
        lever: StaticLever::from(&design),
        document,
        whole: Some(design),
    })
}

/// What a static calculation takes from a design file.
#[derive(Debug, Clone)]
pub struct StaticDesign {
    /// The lever.
    pub lever: StaticLever,
    /// What part it is of.
    pub document: DesignDocument,
    /// The design, unless the file lacks what only a replay needs.
    pub whole: Option<Design>,
}

/// Returns what a file says of its part; of a file that is refused by what reads the rest, nothing.
fn document_of(text: &str) -> Result<DesignDocument, Error> {
    let table: Option<toml::Table> = text.parse().ok();
    let document = table.as_ref().and_then(|table| table.get(DOCUMENT));
    match document.and_then(toml::Value::as_table) {
        Some(entries) => DesignDocument::of_table(entries, text),
        None => Ok(DesignDocument::default()),
    }
}

/// Returns the elements of a linkage, if the file holds one.
fn linkage_of(table: &toml::Table) -> Result<Option<Vec<LinkageElement>>, Error> {
    let Some(value) = table.get("linkage") else {
        return Ok(None);
    };
    let elements: Vec<LinkageElement> =
        value.clone().try_into().map_err(|error: toml::de::Error| {
            let hint = "write [[linkage]] tables with name, mass_kg, arm_m, ratio and spring";
            Error::malformed("the elements of a linkage", error.message(), hint)
        })?;
    Ok(Some(elements))
}

/// Lists what a replay needs and a design with a linkage does not state: nothing is taken from the paper's lever.
fn lacks(table: &toml::Table, linkage: &[LinkageElement]) -> Vec<String> {
    let without = linkage
        .iter()
        .filter(|element| element.moment_of_inertia_kg_m2.is_none());
    let mut lacking: Vec<String> = without
        .map(|element| format!("moment_of_inertia_kg_m2 of `{}`", element.name))
        .collect();
    for parameter in PARAMETERS {
        let is_needed = matches!(parameter.slot, Slot::Stop(_))
            || parameter.name == "lever.pivot_damping_nm_s_per_rad";
        let (section, key) = parameter.name.split_once('.').unwrap_or_default();
        let stated = table.get(section).and_then(|section| section.get(key));
        if is_needed && stated.is_none() {
            lacking.push(parameter.name.into());
        }
    }
    lacking
}

fn stem(file: &str) -> String {
    Path::new(file).file_stem().map_or_else(
        || "design".into(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// Reads the text of a design file. A lever is stated whole, or `base = "paper"` gives it the values of the
/// paper's example; other keys that are absent take the reference design's values, and of the tolerances that of the
/// restitution alone.
///
/// # Errors
///
/// [`Malformed`](latchgate_recording::error::ErrorKind::Malformed) if the text is not TOML, a value is of the wrong type or
/// the lever is not whole,
/// [`UnknownName`](latchgate_recording::error::ErrorKind::UnknownName) for an unknown key, with the nearest known one,
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a value that no lever can have.
pub fn from_toml(text: &str) -> Result<Design, Error> {
    let table: toml::Table = text
        .parse()
        .map_err(|error: toml::de::Error| malformed(&error, text))?;
    from_table(&table, text)
}

fn from_table(table: &toml::Table, text: &str) -> Result<Design, Error> {
    let mut design = Design::reference();
    design.name = "design".into();
    // What scatters the lever itself is the file's to state.
    design.tolerance.retain(|key, _| key == "restitution");
    design.not_stated = not_stated(table);
    if let Some(linkage) = linkage_of(table)? {
        put_linkage(&mut design, table, linkage)?;
    }
    // Its numbers are known to `[tolerance]`, which may stand before it.
    if let Some(entries) = table.get("catch").and_then(toml::Value::as_table) {
        design.catch = Some(stated_catch(entries, text)?);
    }
    for (key, value) in table {
        match value {
            toml::Value::Array(_) if key == "linkage" => {}
            toml::Value::String(name) if key == "name" => design.name.clone_from(name),
            // It is checked with the lever.
            toml::Value::String(_) if key == BASE => {}
            // Shown by whoever shows it, and never computed with.
            toml::Value::Table(entries) if key == DOCUMENT => {
                DesignDocument::of_table(entries, text)?;
            }
            toml::Value::Table(entries) if SECTIONS.contains(&key.as_str()) => {
                put_section(&mut design, key, entries, text)?;
            }
            other => {
                return Err(wrong_entry(key, other).at(Place::of_key(text, None, key)));
            }
        }
    }
    lever_stated(table, text)?;
    if let Some(directions) = design.lever.directions() {
        let is_stated = |lever: &toml::Value| lever.get("center_of_mass_m").is_some();
        if !table.get("lever").is_some_and(is_stated) {
            design.lever.center_of_mass_m = directions.distance_m;
        }
    }
    design.validate()?;
    Ok(design)
}

/// Sees to it that the lever is stated whole: by all of its numbers, by a linkage, or by `base = "paper"`.
fn lever_stated(table: &toml::Table, text: &str) -> Result<(), Error> {
    match table.get(BASE) {
        Some(toml::Value::String(base)) if base == PAPER => return Ok(()),
        Some(other) => {
            let found = match other {
                toml::Value::String(text) => format!("`{text}`"),
                other => with_article(other.type_str()),
            };
            let hint = "write base = \"paper\", or leave it out and state every number of [lever]";
            let error = Error::malformed("\"paper\" for `base`", found, hint);
            return Err(error.at(Place::of_key(text, None, BASE)));
        }
        None => {}
    }
    let is_table = |section: &str| table.get(section).is_some_and(toml::Value::is_table);
    // A lever that is no table is refused as such.
    if table.contains_key("linkage") || (table.contains_key("lever") && !is_table("lever")) {
        return Ok(());
    }
    let missing: Vec<&str> = PARAMETERS
        .iter()
        .filter(|parameter| matches!(parameter.slot, Slot::Lever(_)) && !states(table, parameter))
        .map(DesignParameter::key)
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(Error::malformed(
        "every number of [lever]",
        format!("none of {}", missing.join(", ")),
        "state them, or write base = \"paper\" above the tables if the lever shall take them from the paper's example",
    ))
}

/// Lists the keys of a lever's numbers.
fn lever_keys() -> impl Iterator<Item = &'static str> {
    let of_lever = PARAMETERS
        .iter()
        .filter(|parameter| matches!(parameter.slot, Slot::Lever(_)));
    of_lever.map(DesignParameter::key)
}

/// Returns true if a file states a number, or what it follows from.
fn states(table: &toml::Table, parameter: &DesignParameter) -> bool {
    let (section, key) = parameter.name.split_once('.').unwrap_or_default();
    let entries = table.get(section).and_then(toml::Value::as_table);
    let has = |key: &str| entries.is_some_and(|entries| entries.contains_key(key));
    has(key) || (key == "center_of_mass_m" && has("center_of_mass"))
}

/// Lists the numbers of lever, stop, criterion and input that a file does not state.
fn not_stated(table: &toml::Table) -> Vec<String> {
    let has_linkage = table.contains_key("linkage");
    let unstated = PARAMETERS.iter().filter(|parameter| {
        let is_reduced = has_linkage && matches!(parameter.slot, Slot::Lever(_));
        !is_reduced && !states(table, parameter)
    });
    let tolerance = table.get("tolerance").and_then(toml::Value::as_table);
    let states_restitution = tolerance.is_some_and(|own| own.contains_key("restitution"));
    let of_tolerance = (!states_restitution).then_some("tolerance.restitution");
    let names = unstated.map(|parameter| parameter.name);
    names.chain(of_tolerance).map(String::from).collect()
}

/// Applies an override such as `lever.preload_torque_nm=2.82`, or a share, `tolerance.mass_kg=2 %`.
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
    // A share may stand in quotes, as in a file.
    let quoted = value
        .strip_prefix('"')
        .and_then(|value| value.strip_suffix('"'));
    let value = quoted.unwrap_or(value);
    if key == "name" {
        design.name = value.to_string();
        return Ok(());
    }
    if let (Some(tolerance), true) = (key.strip_prefix("tolerance."), value.ends_with('%')) {
        return Ok(design.override_tolerance(tolerance, share(key, value)?)?);
    }
    let number: f64 = value.parse().map_err(|_| {
        Error::malformed(
            format!("a number for {key}"),
            format!("`{value}`"),
            match key.starts_with("tolerance.") {
                true => "write a decimal number with a dot, or a share: 5%",
                false => "write a decimal number with a dot",
            },
        )
    })?;
    Ok(design.override_number(key, number)?)
}

/// Sees to it that a linkage with springs that grow states how far they go: the paper's limit is not its own.
fn limit_stated(table: &toml::Table, linkage: &[LinkageElement]) -> Result<(), Error> {
    let grows = linkage
        .iter()
        .any(|element| element.spring_stiffness_nm_per_rad > 0.0);
    let stated = table
        .get("criterion")
        .and_then(|criterion| criterion.get("threshold_rad"));
    if !grows || stated.is_some() {
        return Ok(());
    }
    Err(Error::malformed(
        "criterion.threshold_rad of a linkage with a spring stiffness",
        "none",
        "state the angle of the pawl up to which the springs are averaged",
    ))
}

/// Takes in a linkage, of which the whole lever comes.
fn put_linkage(
    design: &mut Design,
    table: &toml::Table,
    linkage: Vec<LinkageElement>,
) -> Result<(), Error> {
    limit_stated(table, &linkage)?;
    let lacking = lacks(table, &linkage);
    let damping = table
        .get("lever")
        .and_then(|lever| lever.get("pivot_damping_nm_s_per_rad"));
    let damping = damping.map(|value| number("pivot_damping_nm_s_per_rad", value));
    let reduced = Reduced::of(&linkage)?;
    let lever = reduced.lever(damping.transpose()?.unwrap_or_default());
    let (true, Some(lever)) = (lacking.is_empty(), lever) else {
        return Err(Error::malformed(
            "all that a replay needs of a linkage",
            format!("none of {}", lacking.join(", ")),
            "state it in the design file; `latchgate static` needs none of it",
        ));
    };
    design.lever = lever;
    design.linkage = linkage;
    Ok(())
}

/// Takes in a table of a design file.
fn put_section(
    design: &mut Design,
    section: &str,
    entries: &toml::Table,
    text: &str,
) -> Result<(), Error> {
    for (key, value) in entries {
        if section == "catch" && key == "reversible" {
            continue;
        }
        if section == "lever" && key == BASE {
            let error = Error::malformed(
                "`base` above the tables",
                "one in [lever]",
                "move the line above the first table",
            );
            return Err(error.at(Place::of_key(text, Some(section), key)));
        }
        if section == "lever" && matches!(key.as_str(), "axis" | "center_of_mass") {
            let vector = vector(key, value)
                .map_err(|error| error.at(Place::of_key(text, Some(section), key)))?;
            match key.as_str() {
                "axis" => design.lever.axis = Some(vector),
                _ => design.lever.center_of_mass = Some(vector),
            }
            continue;
        }
        if section == "tolerance" && value.is_table() {
            return Err(Error::malformed(
                "a number for each key of [tolerance]",
                format!("a table `{key}`"),
                format!("put the key in quotes: \"{key}.unbalance_kg_m\" = 1e-6"),
            )
            .at(Place::of_key(text, Some(section), key)));
        }
        let put = match value {
            toml::Value::String(written) if section == "tolerance" => {
                share(key, written).and_then(|tolerance| Ok(design.put_tolerance(key, tolerance)?))
            }
            _ => number(key, value)
                .and_then(|value| Ok(design.put_number(&format!("{section}.{key}"), value)?)),
        };
        put.map_err(|error| error.at(Place::of_key(text, Some(section), key)))?;
    }
    Ok(())
}

/// Returns a catch without its numbers, of which nothing is assumed: the table states all of them.
fn stated_catch(entries: &toml::Table, text: &str) -> Result<Catch, Error> {
    let keys = CATCH_PARAMETERS.iter().map(|parameter| parameter.key());
    let lacking: Vec<&str> = keys
        .chain(["reversible"])
        .filter(|key| !entries.contains_key(*key))
        .collect();
    if !lacking.is_empty() {
        return Err(Error::malformed(
            "every number of [catch], and reversible",
            format!("none of {}", lacking.join(", ")),
            "state them; `latchgate init design` writes a file with a catch, if asked for its mechanism",
        ));
    }
    match entries.get("reversible") {
        Some(toml::Value::Boolean(reversible)) => Ok(Catch {
            reversible: *reversible,
            ..Catch::default()
        }),
        other => Err(Error::malformed(
            "true or false for `reversible`",
            other.map_or_else(String::new, |value| with_article(value.type_str())),
            "write reversible = true for a catch that falls back",
        )
        .at(Place::of_key(text, Some("catch"), "reversible"))),
    }
}

fn vector(key: &str, value: &toml::Value) -> Result<Vector, Error> {
    let parts = value.as_array().map(Vec::as_slice).unwrap_or_default();
    let [x, y, z] = parts else {
        return Err(Error::malformed(
            format!("three numbers for `{key}`, along X, Y and Z"),
            with_article(value.type_str()),
            "write [0.0, 0.0, 1.0]",
        ));
    };
    Ok(Vector([number(key, x)?, number(key, y)?, number(key, z)?]))
}

/// Says what is wrong with an entry of a design file that is neither its name nor a section.
fn wrong_entry(key: &str, value: &toml::Value) -> Error {
    let expected = match key {
        "name" | BASE => format!("a text for `{key}`"),
        section if section == DOCUMENT || SECTIONS.contains(&section) => {
            format!("a table [{section}]")
        }
        _ => {
            let keys = ["name", BASE, DOCUMENT].into_iter().chain(SECTIONS);
            let keys: Vec<_> = keys.collect();
            return Error::unknown("design key", key, &keys);
        }
    };
    Error::malformed(
        expected,
        with_article(value.type_str()),
        "see the design file in the README",
    )
}

/// Reads a tolerance that is a share of its value.
fn share(key: &str, written: &str) -> Result<Tolerance, Error> {
    Tolerance::from_percent(written).map_err(|found| {
        Error::malformed(
            format!("a number in its unit, or a share such as \"5 %\", for `{key}`"),
            found,
            "write the standard deviation as a number without quotes, or as a share of the value",
        )
    })
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
