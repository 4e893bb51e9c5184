//! Words in remarks: which ones are faults, and from which instant on they hold, as the notes beside
//! the samples of a table show.

use latchgate_recording::{Finding, Limits, ReadOptions, Selection, Severity, Source};

/// The instant of the note [s].
const NOTED_S: f64 = 0.15;

/// Returns what a note beside the last sample of a table comes to, if it blocks.
#[track_caller]
fn doubt(text: &str) -> Option<Finding> {
    let row = |k: i32| format!("{:.3},{},\n", f64::from(k) / 1e3, k % 7);
    let rows: String = (-20..150).map(row).collect();
    let table = format!("t_s,acc_y_g,notes\n{rows}{NOTED_S:.3},0,\"{text}\"\n");
    let limits = Limits {
        line_bytes: 4 << 20,
        ..Limits::default()
    };
    let source = Source::bytes("a.csv", table.into_bytes());
    let read = latchgate_recording::read(
        &source,
        &ReadOptions::default(),
        Selection::Lateral,
        &limits,
    );
    let mut found = read.expect("a table").findings;
    found.retain(|one| one.severity == Severity::Blocking);
    assert!(found.len() <= 1, "{text}: {found:#?}");
    let found = found.pop();
    assert!(found.iter().all(|one| one.code == "laboratory-remark"));
    found
}

/// Remarks with a word of faults that a person knows to be harmless.
pub(crate) const HARMLESS_IN_TRUTH: [&str; 9] = [
    "NO CLIPPING",
    "DEAD PEDAL",
    "REPLACED BROKEN SENSOR BEFORE TEST",
    "SENSOR REPLACED AFTER FAILED PRETEST",
    "MOUNTED NEAR DAMAGED PANEL",
    "TEST SPEED QUESTIONABLE",
    "TEST FAILED TO REACH 50 KM/H",
    "BACKUP FOR 148 IF LOST",
    "BAD KISSINGEN",
];

#[track_caller]
fn check_fault(texts: &[&str]) {
    for text in texts {
        let found = doubt(text).unwrap_or_else(|| panic!("{text}"));
        assert!(found.text.contains("is a fault word"), "{}", found.text);
    }
}

#[track_caller]
fn check_harmless(texts: &[&str]) {
    for text in texts {
        assert_eq!(doubt(text), None, "{text}");
    }
}

/// Phrases of laboratories, loggers and people, in the languages that are in the list.
#[test]
fn val_fault_words_are_found_however_they_are_written() {
    check_fault(&[
        // Spelling: case, blanks, marks, accents.
        "DROP OUT",
        "drop-out",
        "Dropouts seen",
        "N.G.",
        "n. g.",
        "no val id data",
        "questionalbe",
        "SATURTED AT PEAK",
        "ungültig",
        "UNGUELTIG",
        "ungultig",
        "u\u{308}bersteuert",
        "signal?? see report",
        "???",
        "don't use",
        "Error42",
        // Faults.
        "OVER SCALE",
        "SCALE EXCEEDED",
        "max range hit",
        "hit limit",
        "rectified",
        "absolute values",
        "peak hold",
        "AC coupled",
        "MULTIPLIED BY -1",
        "SIGN CONVENTION OPPOSITE TO SAE",
        "MOUNTED BACKWARDS",
        "ROTATED 180 DEG",
        "ACTUALLY X AXIS",
        "SIMULATED",
        "simulation data",
        "values must be doubled",
        "sensor off",
        "cable out",
        "POLARITY REVERSED",
        "AXES SWITCHED",
        "UNITS ARE M/S2",
        "DATA IN M/S/S",
        "CABLE CUT",
        "SENSOR CAME OFF",
        "CHANNEL WENT OPEN",
        "DATA ENDS EARLY",
        "OVER-RANGE",
        "OFF SCALE",
        "REACHED FULL SCALE",
        "FULL SCALE WAS REACHED",
        "buffer overrun, samples skipped",
        "clip",
        "gap",
        "OVL",
        "QUES. DATA THROUGHOUT THE EVENT.",
        "CRUX MID UPPER RIGHT THORAX;QUESTIONABLE DATA PER VRTC",
        "CHANNEL MISLABELED",
        "# data valid until 64 ms",
        // In other languages.
        "NICHT AUSWERTBAR",
        "SIGNAL UNPLAUSIBEL",
        "MESSBEREICH ÜBERSCHRITTEN",
        "Messbereichsüberschreitung",
        "verloren",
        "Fehler",
        "Kabelbruch",
        "n.i.O.",
        "Signalausfall",
        "keine Daten",
        "CAPTEUR DEFAILLANT",
        "capteur défaillant",
        "VOIE PERDUE",
        "valeurs écrêtées",
        "fuori scala",
        "señal perdida",
        "fuera de rango",
        "ongeldig",
        "överstyrd",
        "ogiltig",
        "danSEN",
        "ケーブル断線",
    ]);
    // No denial is read, and no place: a person does that.
    check_fault(&HARMLESS_IN_TRUTH);
}

/// What laboratories write of places, mountings and settings.
#[test]
fn val_places_and_settings_hold_no_fault_word() {
    check_harmless(&[
        "",
        "NO COMMENTS",
        "DRIVER HEAD Y",
        "DRIVER SIDE FOOTREST",
        "TOEPAN BEHIND CENTER OF ACCELERATOR",
        "OCCIPITAL CONDYLE ROTARY POT",
        "THORAX CG",
        "CALCULATED NECK FORCE COMPONENT Z-AXIS",
        "WHEEL BEARING HOUSING",
        "LEFT FRONT SILL AT B-POST",
        "DOOR LATCH STRIKER, NON-STRUCK SIDE",
        "SHIFT LEVER",
        "LEFT REAR SEAT CROSSMEMBER",
        "FILTERED AT 1650 HZ",
        "ANTI-ALIAS CUT-OFF 1650 HZ, 5 V AT FULL SCALE",
        "IMPACT AT 15 M/S",
        "SERIAL NUMBER A12S",
        "Endevco 7264-2000, s/n J12345",
        "offset removed",
        "Kanal 12, B-Säule links",
        "pied milieu gauche",
        "montante centrale",
    ]);
}

/// Checks from which instant on samples are bad [s]; `None` of an instant that may mean anything.
/// Where a text names none, it is that of the note.
#[track_caller]
fn check_instant(text: &str, expected: Option<f64>) {
    let found = doubt(text).unwrap_or_else(|| panic!("{text}"));
    assert_eq!(found.at_s, expected, "{text}");
}

/// From the instant on where nothing else can be meant.
#[test]
fn val_a_plain_instant_is_that_from_which_on_samples_are_bad() {
    for (text, at_s) in [
        ("NO VALID DATA AFTER 64.6 MILLISECONDS", 0.0646),
        (
            "EXCEEDED FULL SCALE AT 61.4 MILLSECONDS, QUESTIONABLE DATA THEREAFTER",
            0.0614,
        ),
        ("Sensor failed at 80ms", 0.08),
        ("signal lost after 0.12 s", 0.12),
        ("NO VALID DATA AFTER .010 SECONDS", 0.01),
        ("NO VALID DATA AFTER 10 MILISECONDS", 0.01),
        ("OVER RANGE AT 10 M SEC", 0.01),
        ("CABLE CUT AT 75,5 msec", 0.0755),
        ("ungültig ab 10 ms", 0.01),
        ("Kabelbruch bei 10 Millisekunden", 0.01),
        ("SPIKE AT 40 MS", 0.04),
        ("NO VALID DATA AFTER -5 MS", -0.005),
    ] {
        check_instant(text, Some(at_s));
    }
    for text in [
        // What is bad lies before, or between, or is not said.
        "NO VALID DATA BEFORE 12 MS",
        "DATA VALID AFTER 12 MS",
        "NO VALID DATA UNTIL 12 MS",
        "NOT VALID UNTIL 12 MS",
        "CLIPPED, FINE AFTER 10 MS",
        "CLIPPED. DATA AFTER 10 MS",
        "DROPOUT RECOVERED AFTER 10 MS",
        "BAD AT START, NORMAL FROM 10 MS",
        "CLIPPED BETWEEN 60 AND 65 MS",
        "saturated 60-65 ms",
        "NO VALID DATA AFTER 10 MS; TRIGGER AT 1 SECOND",
        "NO VALID DATA AFTER 10 MS AND BEFORE 5",
        "NO VALID DATA AFTER 10 MS OR SO, SEE LOG",
        "TIME ZERO AT 20 MS",
        "ONLY 30 MS OF DATA",
        "USE FIRST 30 MS ONLY",
        "after 10 ms",
        "DATA VALID UNTIL 90 MS",
        "gültig bis 80 ms",
        // Read in two ways, or written as programs do.
        "NO VALID DATA AFTER 1.0E-2 S",
        "NO VALID DATA AFTER 1,000 MS",
        "NO VALID DATA AFTER 1.000.5 MS",
    ] {
        check_instant(text, None);
    }
}

/// The work grows with the length of a text, not with its square.
#[test]
fn regress_long_remarks_are_read_in_one_pass() {
    for part in [
        "TO 1 S ",
        "NO THE DATA ",
        "BAD ",
        "??",
        "1,",
        "A\u{301}",
        "FEHLER",
    ] {
        let text = part.repeat(20_000) + " AT 10 MS";
        let found = doubt(&text).unwrap_or_else(|| panic!("{part}"));
        assert!(found.at_s.is_none_or(|at_s| at_s < NOTED_S), "{part}");
    }
}
