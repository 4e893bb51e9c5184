//! What no template says: samples by formulas of their own, and archives that other programs packed or
//! that were damaged.

use super::case::{FROM, TO, push, s};
use latchgate_test_support::tar_of;
use std::f64::consts::PI;

/// The samples [g] of a table that is built.
fn sample(table: &str, name: &str) -> Option<fn(i64) -> f64> {
    match (table, name) {
        ("samples", "converter.csv") => Some(converter),
        ("samples", "weak.csv" | "weak-stated.csv") => Some(weak),
        ("samples", "aliased.csv") => Some(aliased),
        _ => None,
    }
}

/// The bytes of a file that is built.
pub(super) fn bytes(table: &str, name: &str) -> Option<Vec<u8>> {
    let sample = sample(table, name)?;
    let rows = (FROM..TO).map(|k| format!("{},{:.3}\n", s(k), sample(k)));
    Some(format!("time_s,acc_y_g\n{}", rows.collect::<String>()).into_bytes())
}

/// The numbers that it holds.
pub(super) fn values(table: &str, name: &str) -> Option<Vec<f64>> {
    let sample = sample(table, name)?;
    let number = |k| format!("{:.3}", sample(k)).parse().ok();
    (FROM..TO).map(number).collect()
}

fn half_sine(k: i64, height: f64) -> f64 {
    match (0..200).contains(&k) {
        true => height * (PI * k as f64 / 200.0).sin(),
        false => 0.0,
    }
}

/// 2^12 quanta of 7 mg, the last code of a converter of 13 bits, and the last bit trembles.
fn converter(k: i64) -> f64 {
    let formula = 35.0 * (PI * k as f64 / 200.0).sin();
    let pulse = if (0..200).contains(&k) {
        formula / 0.007
    } else {
        0.0
    };
    0.007 * (pulse.round() + (k * k).rem_euclid(3) as f64).min(4096.0)
}

/// A fifth of the pulse with a twentieth of the noise: 6 g and 0.75 m/s, less than a crash gives.
fn weak(k: i64) -> f64 {
    let noise = push(k) - half_sine(k, 30.0);
    (push(k) - noise) / 5.0 + noise / 20.0
}

/// The push under a ringing at half the rate.
fn aliased(k: i64) -> f64 {
    let ringing = if (20..180).contains(&k) { 25.0 } else { 0.0 };
    push(k) + if k % 2 == 0 { ringing } else { -ringing }
}

/// The bytes of a file after an alteration of that name.
pub(super) fn altered(alteration: &str, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = bytes.to_vec();
    let length = bytes.len();
    match alteration {
        // Of the samples alone, not of the times.
        "minus-signs" => {
            return Some(
                String::from_utf8(bytes)
                    .ok()?
                    .replace(",-", ",\u{2212}")
                    .into_bytes(),
            );
        }
        // In the middle of the one large file.
        "flipped-inside" => bytes[length / 2] ^= 0x55,
        // In the checksum of a gzip.
        "flipped-checksum" => bytes[length - 6] ^= 0xFF,
        "doubled" => bytes.extend_from_within(..),
        "same-name-twice" => replace(&mut bytes, b"Channel/T7.009", b"Channel/T7.001"),
        "backslashes" => replace(&mut bytes, b"Channel/T7", b"Channel\\T7"),
        "hard-link" => append_link(&mut bytes, b'1'),
        "symbolic-link" => append_link(&mut bytes, b'2'),
        // Flags and packing in the two headers of each file of a zip.
        "encrypted" => set_word(&mut bytes, 6, 8, 1),
        "bzip2" => set_word(&mut bytes, 8, 10, 12),
        "lzma" => set_word(&mut bytes, 8, 10, 14),
        _ => return None,
    }
    Some(bytes)
}

/// Replaces bytes by as many others, wherever they stand.
fn replace(bytes: &mut [u8], old: &[u8], new: &[u8]) {
    for at in 0..bytes.len() - old.len() {
        if bytes[at..].starts_with(old) {
            bytes[at..at + new.len()].copy_from_slice(new);
        }
    }
}

/// Sets a word in each file's two headers in a zip, at these places.
fn set_word(bytes: &mut [u8], local: usize, central: usize, word: u16) {
    for at in 0..bytes.len() - 4 {
        let place = match &bytes[at..at + 4] {
            b"PK\x03\x04" => at + local,
            b"PK\x01\x02" => at + central,
            _ => continue,
        };
        bytes[place..place + 2].copy_from_slice(&word.to_le_bytes());
    }
}

/// Appends an entry to a tar that links to its first channel.
fn append_link(tar: &mut Vec<u8>, kind: u8) {
    let mut header = tar_of(&[("Channel/T7.002".into(), Vec::new())])[..512].to_vec();
    header[156] = kind;
    header[157..157 + 14].copy_from_slice(b"Channel/T7.001");
    header[148..156].fill(b' ');
    let sum: u32 = header.iter().map(|byte| u32::from(*byte)).sum();
    header[148..155].copy_from_slice(format!("{sum:06o}\0").as_bytes());
    tar.truncate(tar.len() - 1024);
    tar.extend(header);
    tar.resize(tar.len() + 1024, 0);
}
