//! Columns that say row by row what the samples of a table are worth: which names and words count, from which
//! instant a flag blocks, and which channel it concerns.

use crate::csv::read_table;
use crate::support::with_channel;
use latchgate_recording::{ReadOptions, Selection, Severity};

const ROWS: usize = 40;

/// A table of [`ROWS`] rows at 1 kHz from −10 ms on, with two channels and one more column.
fn table(name: &str, with_stamps: bool, word: impl Fn(usize) -> &'static str) -> String {
    let head = if with_stamps { "time_s," } else { "" };
    let mut text = format!("{head}acc_y_g,acc_z_g,{name}\n");
    for row in 0..ROWS {
        let stamp = match with_stamps {
            true => format!("{:.3},", row as f64 / 1e3 - 0.01),
            false => String::new(),
        };
        // Numbers that are no flags.
        let sample = 2.5 + 0.25 * (row % 7) as f64;
        text += &format!("{stamp}{sample},{},{}\n", -sample, word(row));
    }
    text
}

/// The instants from which a flag blocks a channel [s]: none, or one of the whole channel or from then on.
fn flagged(text: &str, options: &ReadOptions) -> Vec<Option<f64>> {
    let read = read_table(text, options, Selection::Lateral).unwrap();
    let findings = read.channels[0].findings.iter();
    let flags = findings.filter(|one| one.code == "invalid-by-laboratory");
    flags
        .map(|one| {
            assert_eq!(one.severity, Severity::Blocking);
            one.at_s
        })
        .collect()
}

/// A column that says which samples are good, or which are bad, blocks from the first bad one on, be it the
/// first row or the last.
#[test]
fn verif_a_flag_of_bad_samples_blocks_from_its_row_on() {
    let stamped = with_channel("acc_y_g");
    let by_rate = ReadOptions {
        rate_hz: Some(1000.0),
        ..with_channel("acc_y_g")
    };
    for (name, good, bad) in [
        ("valid", "1", "0"),
        ("valid", "true", "false"),
        ("Valid", "yes", "no"),
        ("validity", "1.0", "0.0"),
        ("isValid", "TRUE", "FALSE"),
        ("acc_y_g_valid", "1", "0"),
        ("data valid", "y", "n"),
        ("gültig", "ja", "nein"),
        ("overload", "0", "1"),
        ("clipped", "false", "true"),
        ("sensor fault", "no", "yes"),
        ("acc_y_g error", "0", "1"),
    ] {
        for first in [0, 1, 2, 17, ROWS - 2, ROWS - 1] {
            // From there on, or in this row alone.
            for for_good in [true, false] {
                let is_bad = |row: usize| row == first || (for_good && row > first);
                let word = |row: usize| if is_bad(row) { bad } else { good };
                let expected_s = first as f64 / 1e3 - 0.01;
                let found = flagged(&table(name, true, word), &stamped);
                assert_eq!(found.len(), 1, "{name}: {bad} in row {first}");
                let at_s = found[0].unwrap();
                assert!((at_s - expected_s).abs() < 1e-12, "{name}: {at_s}");
                let found = flagged(&table(name, false, word), &by_rate);
                let at_s = found[0].unwrap();
                assert!((at_s - first as f64 / 1e3).abs() < 1e-12, "{name}: {at_s}");
            }
        }
        let found = flagged(&table(name, true, |_| good), &stamped);
        assert_eq!(found, [], "{name}: {good} throughout");
    }
}

/// A flag with a channel's name before it concerns that channel alone; any other concerns all.
#[test]
fn verif_a_flag_concerns_the_channel_of_its_name() {
    let bad_row = |row: usize| if row == 17 { "0" } else { "1" };
    for (name, channel, blocks) in [
        ("valid", "acc_y_g", true),
        ("valid", "acc_z_g", true),
        ("acc_y_g_valid", "acc_y_g", true),
        ("acc_y_g_valid", "acc_z_g", false),
        ("acc_z_g_valid", "acc_y_g", false),
        ("acc_z_g_valid", "acc_z_g", true),
    ] {
        let found = flagged(&table(name, true, bad_row), &with_channel(channel));
        assert_eq!(found.len(), usize::from(blocks), "{name} on {channel}");
    }
}
