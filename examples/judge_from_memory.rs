//! Judges a recording that never was a file: bytes with a card, two designs, a wish to stop.

#![allow(clippy::print_stdout, reason = "a program")]

use latchgate::pipeline::{Control, Design, Extras, Limits, Prepared, Request, Source};
use std::sync::atomic::{AtomicBool, Ordering};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let table = include_bytes!("../signals/burst.csv").as_slice();
    let card = b"opens_when = \"negative\"\nsynthetic = true\n";
    let source = Source::bytes("burst.csv", table).with_card(*card);

    // Set from another thread, a signal or a closed connection, it ends the work soon.
    let stop = AtomicBool::new(false);
    let control = Control {
        threads: 2,
        proceed: &|_| !stop.load(Ordering::Relaxed),
    };
    let request: Request = serde_json::from_str(r#"{"members": 2048, "filter": "cfc1000"}"#)?;
    let prepared = Prepared::open(&source, &request, &Limits::default(), &control)
        .map_err(|refused| refused.error)?;

    let mut stiffer = Design::reference();
    stiffer.name = "stiffer".into();
    stiffer.override_number("lever.preload_torque_nm", 3.5)?;
    for design in [Design::reference(), stiffer] {
        let document = prepared
            .judge(&design, Extras::default(), &control)
            .document;
        let peak = document.nominal.map_or(f64::NAN, |run| run.peak_angle_rad);
        let id = &document.report_id[..8];
        let verdict = document.verdict.name();
        println!("{id} {}: {verdict} at {peak:.4} rad", design.name);
    }
    stop.store(true, Ordering::Relaxed);
    let stopped = prepared.judge(&Design::reference(), Extras::default(), &control);
    println!("stopped: {}", stopped.was_stopped());
    Ok(())
}
