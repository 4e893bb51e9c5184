//! Outside truths in `tests/data/`.

use serde_json::Value;
use std::path::{Path, PathBuf};

/// The project's folder.
pub fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors()
        .nth(2)
        .expect("tests/support lies two folders down")
}

/// A file of `tests/data/`, whose README tells where it comes from.
#[track_caller]
pub fn data(name: &str) -> PathBuf {
    let path = root().join("tests/data").join(name);
    assert!(path.exists(), "{} is missing", path.display());
    path
}

/// A document of `tests/data/`.
#[track_caller]
pub fn json(name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(data(name)).unwrap()).unwrap()
}

/// A number that stands there as one, or with more digits than a number has, as text.
pub fn number(value: &Value) -> f64 {
    value
        .as_str()
        .map_or_else(|| value.as_f64().unwrap(), |text| text.parse().unwrap())
}

/// Two columns of a file of `tests/data/`, time and value, after any header lines.
#[track_caller]
pub fn columns(name: &str) -> Vec<(f64, f64)> {
    std::fs::read_to_string(data(name))
        .unwrap()
        .lines()
        .filter_map(|line| {
            let mut cells = line
                .split([',', '\t'])
                .map(|cell| cell.trim().parse::<f64>());
            Some((cells.next()?.ok()?, cells.next()?.ok()?))
        })
        .collect()
}
