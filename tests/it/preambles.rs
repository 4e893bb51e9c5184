//! What the rows above a table's names state of its columns.

use crate::csv::read_table;
use crate::support::with_channel;
use latchgate_recording::{ReadOptions, Selection, Severity};

/// What rows above the names state of a column: filters, full scale, code, sensor and test.
#[test]
fn val_rows_above_the_names_state_what_they_say() {
    let rows: String = (0..20)
        .map(|row| format!("{:.4},{row},{row}\n", f64::from(row) / 1e4))
        .collect();
    let stated = |above: &str| {
        let text = format!("{above}\ntime_s,acc y (g),acc z (mg)\n{rows}");
        let read = read_table(text, &with_channel("3"), Selection::Lateral);
        read.unwrap().channels.remove(0).stated
    };
    for (row, scale) in [
        ("Range (g),50,20", Some(20e3)),
        ("Full scale,±500 g,±2000 mg", Some(2000.0)),
        ("Messbereich;-5..5 g", Some(5e3)),
        ("Range (EU),100,2000", Some(2000.0)),
        ("Measuring range,10 V,10 V", None),
        ("Range,100,200", None),
    ] {
        let row = row.replace(';', ",");
        let found = stated(&row).full_scale;
        let off = found
            .zip(scale)
            .map_or(0.0, |(found, scale)| found / scale - 1.0);
        assert!(
            found.is_some() == scale.is_some() && off.abs() < 1e-12,
            "{row}: {found:?}"
        );
    }
    for (row, class, corner) in [
        ("SAE Class,60,180", Some("180"), None),
        ("Filter,CFC 60,CFC 600", Some("600"), None),
        ("CFC class: 1000", Some("1000"), None),
        ("Filterklasse,CFC_60,keine", None, None),
        ("Cutoff frequency (kHz),1,2", None, Some(2000.0)),
        ("Hardware AA Filter (-3dB),4300,NONE", None, None),
        ("Filter,100 Hz,650 Hz", None, Some(650.0)),
    ] {
        let stated = stated(row);
        let found = (stated.filter_class.as_deref(), stated.prefilter_hz);
        assert_eq!(found, (class, corner), "{row}");
    }
    let facts = stated(
        "ISO code,11SILLLE0000ACYP,11SILLLE0000ACZP\nChannel name,Sill Y,Sill Z\nSensor S/N,P1,P2\n\
         Test ID,T7\nTest Date,2026-01-02\nVehicle,sedan\nLaboratory,X",
    );
    assert_eq!(facts.location.as_deref(), Some("11SILLLE0000ACZP"));
    let test = facts.test;
    for (found, expected) in [
        (test.sensor, "P2"),
        (test.location, "Sill Z"),
        (test.test, "T7"),
        (test.date, "2026-01-02"),
        (test.vehicle, "sedan"),
        (test.laboratory, "X"),
    ] {
        assert_eq!(found.as_deref(), Some(expected));
    }
}

/// Rows that are missing by the count above the names: with stamps they are those after the last one, without
/// stamps they may be missing anywhere.
#[test]
fn verif_missing_rows_without_stamps_block_everything() {
    let table = |count: usize, stamp: fn(u32) -> String, names: &str| {
        let rows = (0..20).map(|row| format!("{}{}\n", stamp(row), row % 7));
        let rows: String = rows.collect();
        format!("Test,7\nNumber of samples,{count}\n{names}\n{rows}")
    };
    let stamped = |count| {
        let stamp = |row| format!("{:.4},", f64::from(row) / 1e4);
        (table(count, stamp, "time_s,acc y (g)"), None)
    };
    let by_rate = |count| {
        let stamp = |_| String::from("5,");
        (table(count, stamp, "acc z (g),acc y (g)"), Some(1e4))
    };
    for ((text, rate_hz), expected) in [
        (stamped(20), None),
        (stamped(21), Some(Some(19.0 / 1e4))),
        (stamped(400), Some(Some(19.0 / 1e4))),
        (by_rate(20), None),
        (by_rate(21), Some(None)),
        (by_rate(400), Some(None)),
    ] {
        let options = ReadOptions {
            rate_hz,
            header_line: Some(3),
            ..with_channel("acc y (g)")
        };
        let read = read_table(text.as_str(), &options, Selection::Lateral).unwrap();
        let channel = &read.channels[0];
        let missing = channel.findings.iter().chain(&read.findings);
        let mut missing = missing.filter(|one| one.code == "samples-missing");
        let found = missing.next().map(|one| {
            assert_eq!(one.severity, Severity::Blocking);
            one.at_s
        });
        assert_eq!(found, expected, "{text}");
    }
}
