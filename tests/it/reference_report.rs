//! Guards `reports/burst`: what the README's first command writes, kept for readers and
//! compared here. To renew it: `latchgate replay signals/burst.csv --out reports/burst`.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn verdict(folder: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("verdict.json")).unwrap()).unwrap()
}

/// Numbers agree to a millionth: the last digits may move with the kernel, and errors of
/// rounding, with the sentences that quote them, are noise.
#[track_caller]
fn check_same(path: &str, found: &Value, kept: &Value) {
    match (found, kept) {
        (Value::Object(found), Value::Object(kept)) => {
            let names = |map: &serde_json::Map<String, Value>| -> Vec<String> {
                map.keys().cloned().collect()
            };
            assert_eq!(names(found), names(kept), "keys of {path}");
            for (name, value) in found {
                if !matches!(name.as_str(), "elapsed_s" | "work") {
                    check_same(&format!("{path}.{name}"), value, &kept[name]);
                }
            }
        }
        (Value::Array(found), Value::Array(kept)) => {
            assert_eq!(found.len(), kept.len(), "length of {path}");
            for (index, (found, kept)) in found.iter().zip(kept).enumerate() {
                check_same(&format!("{path}[{index}]"), found, kept);
            }
        }
        (Value::Number(found), Value::Number(kept)) => {
            let (found, kept) = (found.as_f64().unwrap(), kept.as_f64().unwrap());
            let near = (found - kept).abs() <= 1e-6 * kept.abs();
            let noise = found.abs() < 1e-9 && kept.abs() < 1e-9;
            assert!(near || noise, "{path}: {found} now, {kept} kept");
        }
        (Value::String(found), Value::String(kept)) => {
            assert!(
                found == kept || found.contains("rad from integration"),
                "{path}: {found} now, {kept} kept"
            );
        }
        _ => assert_eq!(found, kept, "{path}"),
    }
}

#[test]
fn cli_the_reference_report_is_what_the_first_command_writes() {
    let folder = std::env::temp_dir().join(format!("latchgate-reference-{}", std::process::id()));
    let status = Command::new(env!("CARGO_BIN_EXE_latchgate"))
        .current_dir(root())
        .args(["replay", "signals/burst.csv", "--out"])
        .arg(&folder)
        .output()
        .unwrap()
        .status;
    assert_eq!(status.code(), Some(1), "the burst fails");
    let kept = root().join("reports/burst");
    check_same("verdict", &verdict(&folder), &verdict(&kept));
    let files = |folder: &Path| -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    assert_eq!(files(&folder), files(&kept));
    std::fs::remove_dir_all(&folder).unwrap();
}
