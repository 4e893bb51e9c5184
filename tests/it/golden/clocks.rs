//! Clocks of text tables: units of time, stamps as words, indices without a name, and clocks beside one
//! another.

use super::{Case, FROM, TO, g, good, refused, s};

/// A table of a stamp and a sample in each row, `;` between them.
fn stamped(name: &str, stamp: impl Fn(i64) -> String) -> String {
    let row = |k: i64| format!("{};{}\n", stamp(k), g(k));
    let rows: String = (FROM..TO).map(row).collect();
    format!("{name};acc_y_g\n{rows}")
}

/// The table without the rows of 11 ms of the push.
fn rows_lost(name: &str, stamp: impl Fn(i64) -> String) -> String {
    let row = |k: i64| match (60..170).contains(&k) {
        true => String::new(),
        false => format!("{};{}\n", stamp(k), g(k)),
    };
    let rows: String = (FROM..TO).map(row).collect();
    format!("{name};acc_y_g\n{rows}")
}

/// The time of sample `k`, counted from a full second, as hours, minutes, seconds and 0.1 ms.
struct Instant {
    hour: i64,
    minute: i64,
    second: i64,
    tick: i64,
}

/// Sample `k`, sample 0 lying at `second` of a day, which may be the one before.
fn at(second: i64, k: i64) -> Instant {
    let ticks = (second * 10_000 + k).rem_euclid(86_400 * 10_000);
    let seconds = ticks / 10_000;
    Instant {
        hour: seconds / 3600,
        minute: seconds / 60 % 60,
        second: seconds % 60,
        tick: ticks % 10_000,
    }
}

/// `09:59:59.9800`, sample 0 lying at `second` of the day.
fn of_day(second: i64, k: i64) -> String {
    let t = at(second, k);
    format!(
        "{:02}:{:02}:{:02}.{:04}",
        t.hour, t.minute, t.second, t.tick
    )
}

/// As [`of_day`], on a clock of twelve hours.
fn of_half_day(second: i64, k: i64) -> String {
    let t = at(second, k);
    let half = if t.hour < 12 { "AM" } else { "PM" };
    let hour = (t.hour + 11) % 12 + 1;
    format!(
        "{hour}:{:02}:{:02}.{:04} {half}",
        t.minute, t.second, t.tick
    )
}

/// The first word before midnight, the second from then on.
fn day<'a>(k: i64, (before, after): (&'a str, &'a str)) -> &'a str {
    if k < 0 { before } else { after }
}

const TEN: i64 = 36_000;
const NOON: i64 = 43_200;

/// What a record that seems to last 8 ms is told beside.
const SHORT: [&str; 3] = [
    "warning ends-early",
    "warning implausible-velocity",
    "warning no-pre-event-data",
];

type Spelling = (&'static str, &'static str, fn(i64) -> String);

/// Stamps that are counted from the first of them.
const ABSOLUTE: &[Spelling] = &[
    ("time-of-day", "Time", |k| of_day(TEN, k)),
    ("time-of-day-comma", "Uhrzeit", |k| {
        of_day(TEN, k).replace('.', ",")
    }),
    ("time-of-day-ticks", "Heure", |k| {
        of_day(TEN, k).replace('.', ":")
    }),
    ("time-of-day-unnamed", "", |k| of_day(TEN, k)),
    ("time-of-day-other-name", "Marke", |k| of_day(TEN, k)),
    ("time-of-half-a-day", "Time", |k| of_half_day(NOON, k)),
    ("midnight", "Time", |k| of_day(0, k)),
    ("midnight-of-half-a-day", "time", |k| of_half_day(0, k)),
    ("minutes", "Time", |k| of_day(TEN, k)[3..].to_string()),
    ("date-german", "Zeit", |k| {
        format!("01.05.2024 {}", of_day(TEN, k))
    }),
    ("date-german-short", "Datum", |k| {
        format!("1.5.24, {}", of_day(TEN, k))
    }),
    ("date-american", "Date", |k| {
        format!("05/01/2024 {}", of_half_day(NOON, k))
    }),
    ("date-american-short", "Timestamp", |k| {
        format!("5/13/24 {}", of_half_day(NOON, k))
    }),
    ("date-slashes", "t", |k| {
        format!("2024/05/01 {}", of_day(TEN, k))
    }),
    ("date-matlab", "Time", |k| {
        format!("01-May-2024 {}", of_day(TEN, k))
    }),
    ("date-month-german", "Zeit", |k| {
        format!("1. Mai 2024 {}", of_day(TEN, k))
    }),
    ("date-month-first", "When", |k| {
        format!("Mai 1, 2024 {}", of_day(TEN, k))
    }),
    ("date-zone", "Time", |k| {
        format!("2024-05-01T{}+02:00", of_day(TEN, k))
    }),
    ("date-basic", "Time", |k| {
        format!("20240501T{}Z", of_day(TEN, k).replace(':', ""))
    }),
    ("date-over-a-month", "Zeit", |k| {
        format!("{} {}", day(k, ("30.04.2024", "01.05.2024")), of_day(0, k))
    }),
    ("date-over-a-year", "Time", |k| {
        format!("{} {}", day(k, ("12/31/2023", "01/01/2024")), of_day(0, k))
    }),
];

/// Stamps with a zero of their own.
const RELATIVE: &[Spelling] = &[
    ("pandas", "Time", |k| match k {
        0 => "0 days".into(),
        1.. => format!("0 days {}", of_day(0, k)),
        _ => format!("-1 days +{}", of_day(0, k)),
    }),
    ("pandas-index", "", |k| match k {
        0.. => format!("0 days {}00", of_day(0, k)),
        _ => format!("-1 days +{}00", of_day(0, k)),
    }),
    ("python", "elapsed", |k| match k {
        0.. => of_day(0, k)[1..].into(),
        _ => format!("\"-1 day, {}\"", of_day(0, k)),
    }),
    ("signed", "Time", |k| match k {
        0.. => of_day(0, k),
        _ => format!("-{}", of_day(0, -k)),
    }),
    ("signed-minutes", "Time", |k| match k {
        0.. => of_day(0, k)[3..].into(),
        _ => format!("-{}", &of_day(0, -k)[3..]),
    }),
    ("ms-in-the-cell", "Time", |k| {
        format!("{:.1} ms", k as f64 / 10.0)
    }),
    ("ms-in-the-cell-comma", "Zeit", |k| {
        format!("{:.1} ms", k as f64 / 10.0).replace('.', ",")
    }),
    ("us-in-the-cell", "Time", |k| format!("{}us", 100 * k)),
    ("s-in-the-cell", "t", |k| format!("{} s", s(k))),
    ("unit-that-changes", "Time", |k| match k.abs() < 10 {
        true => format!("{} us", 100 * k),
        false => format!("{:.1} ms", k as f64 / 10.0),
    }),
];

pub(super) fn cases() -> Vec<Case> {
    let mut cases = words();
    cases.extend(words_of_few_digits());
    cases.extend(words_not_read());
    cases.extend(units());
    cases.extend(rates());
    cases.extend(unnamed());
    cases.extend(beside());
    cases
}

/// Each spelling, as it is, with rows lost under a stated rate, and under a rate ten times too high.
fn words() -> Vec<Case> {
    let mut cases = Vec::new();
    let zero = ["--time-zero", "0.02"];
    let absolute = ABSOLUTE
        .iter()
        .map(|one| (one, &zero[..], "info time-absolute"));
    let relative = RELATIVE.iter().map(|one| (one, &[][..], ""));
    for ((name, head, stamp), zero, finding) in absolute.chain(relative) {
        let finding: Vec<&str> = [finding]
            .into_iter()
            .filter(|one| !one.is_empty())
            .collect();
        let comma = stamp(1).contains(',') && stamp(1).contains("ms");
        let marks: &[&str] = if comma { &["info decimal-comma"] } else { &[] };
        let numbers = |text: String| if comma { text.replace('.', ",") } else { text };
        let file = |kind: &str| format!("{kind}{name}.csv");
        let text = numbers(stamped(head, stamp));
        cases.push(
            good(&file(""), text.clone())
                .options(zero)
                .finds(&finding)
                .finds(marks),
        );
        let lost = good(&file("lost-"), numbers(rows_lost(head, stamp)));
        cases.push(
            lost.options(zero)
                .options(&["--rate-hz", "10000"])
                .samples((TO - FROM) as usize)
                .finds(&finding)
                .finds(marks)
                .unusable(&["blocking gap"], &["gap in time"]),
        );
        let says = ["expected the stated rate of 100000 Hz", "10000 Hz by"];
        cases.push(refused(&file("fast-"), text, &says).options(&["--rate-hz", "100000"]));
    }
    // The 4th of March or the 3rd of April: the day that follows sooner is meant.
    let slashes = |k| format!("{} {}", day(k, ("03/04/2024", "03/05/2024")), of_day(0, k));
    cases.push(
        good("date-of-unknown-order.csv", stamped("Time", slashes))
            .options(&zero)
            .finds(&["info time-absolute", "warning date-order-assumed"]),
    );
    cases
}

/// Stamps that are coarser than the interval, so that a stated rate tells the time.
fn words_of_few_digits() -> Vec<Case> {
    let cut = |digits: usize| move |k: i64| of_day(TEN, k)[..digits].to_string();
    let dated = |k: i64| format!("2024-05-01T{}", &of_day(TEN, k)[..12]);
    let american = |k: i64| format!("05/01/2024 {} AM", &of_day(TEN, k)[..8]);
    let rated = ["--rate-hz", "10000", "--time-zero", "0.02"];
    let coarse = ["warning stamps-coarse", "info time-absolute"];
    let mut cases: Vec<Case> = [
        ("coarse-ms.csv", stamped("Time", cut(12))),
        ("coarse-s.csv", stamped("Time", cut(8))),
        ("coarse-iso-ms.csv", stamped("Time", dated)),
        ("coarse-american-s.csv", stamped("Date", american)),
        (
            "coarse-minutes.csv",
            stamped("Date", |k| format!("1.5.2024 {}", &of_day(TEN, k)[..5])),
        ),
    ]
    .into_iter()
    .map(|(name, text)| good(name, text).options(&rated).finds(&coarse))
    .collect();
    cases.extend([
        refused(
            "coarse-no-rate.csv",
            stamped("Time", dated),
            &["time must increase", "--rate-hz"],
        ),
        refused(
            "coarse-fast.csv",
            stamped("Time", dated),
            &["repeat and are off"],
        )
        .options(&["--rate-hz", "100000"]),
        refused(
            "coarse-lost.csv",
            rows_lost("Time", dated),
            &["repeat and are off"],
        )
        .options(&rated[..2]),
        // The begin of the recording in each row is no clock.
        good(
            "begin-in-each-row.csv",
            stamped("Begin", |_| "10:00:00.0000".into()),
        )
        .options(&rated),
        good(
            "date-in-each-row.csv",
            stamped("Date", |_| "01.05.2024".into()),
        )
        .options(&rated),
    ]);
    cases
}

/// Words that no form fits: where they change from row to row, a rate alone would hide rows that are lost.
fn words_not_read() -> Vec<Case> {
    let rated = ["--rate-hz", "10000", "--time-zero", "0.02"];
    let says = ["times that latchgate reads", "10:00:00.0001"];
    let spelled = |k: i64| of_day(TEN, k).replacen(':', "h", 1).replacen(':', "m", 1);
    let mut cases: Vec<Case> = [
        ("words-not-read.csv", rows_lost("Time", spelled)),
        ("words-not-read-unnamed.csv", rows_lost("", spelled)),
        (
            "words-not-read-other-name.csv",
            rows_lost("Mark", |k| format!("T+{}", s(k + 300))),
        ),
        (
            "words-not-read-coarse.csv",
            rows_lost("time", |k| format!("~{:.2}", k as f64 / 1e4 + 1.0)),
        ),
        (
            "words-in-ticks.csv",
            rows_lost("Tick", |k| format!("0x{:05x} {k}", 4096 + k)),
        ),
        (
            "labels-lost.csv",
            rows_lost("Label", |k| format!("S{:04}", k - FROM)),
        ),
    ]
    .into_iter()
    .map(|(name, text)| refused(name, text, &says).options(&rated))
    .collect();
    cases.extend([
        good(
            "labels.csv",
            stamped("Label", |k| format!("S{:04}", k - FROM)),
        )
        .options(&rated),
        good(
            "phases.csv",
            stamped("Phase", |k| format!("phase {}", i64::from(k >= 0))),
        )
        .options(&rated),
        good("time-not-filled.csv", stamped("Time", |_| "n/a".into())).options(&rated),
    ]);
    cases
}

/// Units of time, in the head of a column, in a row of units, above the table, and by option.
fn units() -> Vec<Case> {
    let ticks = |seconds: f64, decimals: usize| {
        move |k: i64| format!("{:.decimals$}", k as f64 / 1e4 / seconds)
    };
    let mut cases = Vec::new();
    for (index, (head, seconds, decimals)) in [
        ("time (10 us)", 1e-5, 0),
        ("Time [0.1 ms]", 1e-4, 0),
        ("t (0,1 ms)", 1e-4, 0),
        ("time_100ns", 1e-7, 0),
        ("Timestamp (100 ns ticks)", 1e-7, 0),
        ("time in 0.1 ms", 1e-4, 0),
        ("Zeit 100 us", 1e-4, 0),
        ("t / 10 µs", 1e-5, 0),
        ("Time [1/1000 s]", 1e-3, 1),
        ("time (1e-5 s)", 1e-5, 0),
        ("Zeit [min]", 60.0, 9),
        ("time_h", 3600.0, 11),
        ("Time (days)", 86_400.0, 12),
        ("Zeit [Stunden]", 3600.0, 11),
    ]
    .into_iter()
    .enumerate()
    {
        let text = stamped(head, ticks(seconds, decimals));
        cases.push(good(&format!("unit-in-the-head-{index}.csv"), text));
    }
    for (index, (unit, seconds, decimals)) in [
        ("10us", 1e-5, 0),
        ("0.01ms", 1e-5, 0),
        ("100 ns", 1e-7, 0),
        ("0.1 MS", 1e-4, 0),
        ("min", 60.0, 9),
        ("hour", 3600.0, 11),
        ("day", 86_400.0, 12),
    ]
    .into_iter()
    .enumerate()
    {
        let text = stamped("time", ticks(seconds, decimals));
        cases.push(
            good(&format!("unit-by-option-{index}.csv"), text).options(&["--time-unit", unit]),
        );
        let text = stamped("time", ticks(seconds, decimals)).replace('\n', "\r\n");
        let text = text.replacen("\r\n", &format!("\r\n{unit};g\r\n"), 1);
        cases.push(good(&format!("unit-in-a-row-{index}.csv"), text));
        let above = format!("Sled 07\nTime unit;{unit}\n\n");
        let text = stamped("time", ticks(seconds, decimals));
        cases.push(
            good(&format!("unit-above-{index}.csv"), above + &text)
                .finds(&["info preamble"])
                .options(&["--header-line", "4"]),
        );
    }
    let days = |k: i64| format!("{:.12}", 45_413.0 + (36_000.0 + k as f64 / 1e4) / 86_400.0);
    let zero = ["--time-zero", "0.02"];
    cases.extend([
        // `min` and `d` beside other names are no units of time.
        good("least-value.csv", stamped("time_s", s)).named("unit-of-another"),
        good("days-by-option.csv", stamped("Time", days))
            .options(&["--time-unit", "day"])
            .options(&zero)
            .finds(&["info time-absolute"]),
        good("days-by-rate.csv", stamped("Time", days))
            .options(&["--rate-hz", "10000"])
            .options(&zero)
            .finds(&["info time-absolute", "warning time-unit-assumed"]),
        refused(
            "days-by-another-rate.csv",
            stamped("Time", days),
            &["--time-unit"],
        )
        .options(&["--rate-hz", "100000"]),
        refused(
            "unit-above-contradicts.csv",
            format!("Time unit;s\n{}", stamped("t (ms)", s)),
            &["--time-unit"],
        )
        .options(&["--header-line", "2"]),
        good(
            "unit-overridden.csv",
            stamped("time (10 us)", ticks(1e-4, 0)),
        )
        .options(&["--time-unit", "0.1ms"])
        .finds(&["warning time-unit-overridden"]),
    ]);
    cases
}

/// A stated rate beside a unit that is not read, or beside none.
fn rates() -> Vec<Case> {
    let filetime = |k: i64| (133_590_000_000_000_000_i64 + 1000 * (k - FROM)).to_string();
    let by = |count: i64| move |k: i64| (count * k).to_string();
    let rated = ["--rate-hz", "10000"];
    let assumed = ["warning time-unit-assumed"];
    let mut cases = Vec::new();
    for (index, head) in [
        "Timestamp ticks",
        "time (clocks)",
        "Zeit [Takte]",
        "time [div]",
    ]
    .iter()
    .enumerate()
    {
        let text = stamped(head, by(33));
        let file = |kind: &str| format!("ticks-{kind}{index}.csv");
        cases.push(refused(
            &file(""),
            text.clone(),
            &["a known unit of time", "--time-unit", "--rate-hz"],
        ));
        cases.push(good(&file("rate-"), text).options(&rated).finds(&assumed));
        cases.push(
            good(&file("lost-"), rows_lost(head, by(33)))
                .options(&rated)
                .samples((TO - FROM) as usize)
                .finds(&assumed)
                .unusable(&["blocking gap"], &["gap in time"]),
        );
    }
    cases.extend([
        good("us-by-rate.csv", stamped("time", by(100)))
            .options(&rated)
            .finds(&assumed),
        good(
            "ms-by-rate.csv",
            stamped("time", |k| format!("{:.1}", k as f64 / 10.0)),
        )
        .options(&rated)
        .finds(&assumed),
        // In microseconds these would be 20 kHz, which is faster than what is stated.
        good("10us-by-rate.csv", stamped("time", by(50)))
            .options(&["--rate-hz", "2000"])
            .clock(2000.0, -0.1)
            .finds(&assumed)
            .finds(&["warning rate-below-default-filter"]),
        // In milliseconds they are 10 kHz, and a slip by ten makes no unit of its own.
        refused(
            "ms-by-a-rate-too-high.csv",
            stamped("time", |k| format!("{:.1}", k as f64 / 10.0)),
            &["expected the stated rate of 100000 Hz", "--time-unit"],
        )
        .options(&["--rate-hz", "100000"]),
        // An unknown word is no unit: seconds contradict the rate.
        refused(
            "word-by-a-rate-too-high.csv",
            stamped("Engine time", s),
            &["expected the stated rate of 100000 Hz", "10000 Hz by"],
        )
        .options(&["--rate-hz", "100000"]),
        // 100 ns since 1601 are known by their size.
        good("filetime.csv", stamped("Full Timestamp", filetime))
            .options(&["--time-unit", "100ns", "--time-zero", "13359000000.02"])
            .samples((TO - FROM) as usize)
            .clock(10_000.0, -0.02),
        good(
            "filetime-in-ns.csv",
            stamped("Full Timestamp", |k| {
                (133_590_000_000_000_000_i64 + 5000 * (k - FROM)).to_string()
            }),
        )
        .options(&["--time-unit", "ns", "--time-zero", "133590000.001"])
        .samples((TO - FROM) as usize)
        .clock(200_000.0, -0.001)
        .finds(&SHORT)
        .unusable(
            &["blocking time-contradicted"],
            &["counts 100ns from a date"],
        ),
        refused(
            "filetime-by-a-rate-too-high.csv",
            stamped("Full Timestamp (ticks)", filetime),
            &["expected the stated rate of 100000 Hz"],
        )
        .options(&["--rate-hz", "100000"]),
        refused(
            "s-by-a-rate-too-high.csv",
            stamped("time", s),
            &["expected the stated rate of 100000 Hz", "10000 Hz by"],
        )
        .options(&["--rate-hz", "100000"]),
    ]);
    cases
}

/// Indices without a name, or with one that says nothing.
fn unnamed() -> Vec<Case> {
    // As Python prints -0.0199, by multiples of 0.0001.
    let index = |k: i64| format!("{}", (k - FROM) as f64 * 0.0001 - 0.02);
    let ms = |k: i64| format!("{}", k as f64 / 10.0);
    let rated = ["--rate-hz", "10000"];
    let assumed = ["info time-unit-assumed"];
    let mut cases = Vec::new();
    for (at, head) in ["", "\"\"", "Unnamed: 0", "index", "X", "abscissa"]
        .iter()
        .enumerate()
    {
        let text = stamped(head, index);
        let file = |kind: &str| format!("index-{kind}{at}.csv");
        cases.push(refused(
            &file(""),
            text.clone(),
            &["10000 Hz if in seconds", "--time-column 1"],
        ));
        cases.push(
            good(&file("taken-"), text.clone())
                .options(&["--time-column", "1"])
                .finds(&assumed),
        );
        cases.push(
            good(&file("rate-"), text.clone())
                .options(&rated)
                .finds(&assumed),
        );
        cases.push(
            refused(
                &file("fast-"),
                text,
                &["expected the stated rate of 100000 Hz", "10000 Hz by"],
            )
            .options(&["--rate-hz", "100000"]),
        );
        cases.push(
            good(&file("lost-"), rows_lost(head, index))
                .options(&rated)
                .samples((TO - FROM) as usize)
                .finds(&assumed)
                .unusable(&["blocking gap"], &["gap in time"]),
        );
    }
    let by_rate = ["warning time-unit-assumed"];
    cases.extend([
        good("index-ms.csv", stamped("", ms))
            .options(&rated)
            .finds(&by_rate),
        good("index-ms-told.csv", stamped("", ms)).options(&["--time-unit", "ms"]),
        refused(
            "index-ms-fast.csv",
            stamped("", ms),
            &["expected the stated rate of 100000 Hz"],
        )
        .options(&["--rate-hz", "100000"]),
        good("index-us.csv", stamped("", |k| (100 * k).to_string()))
            .options(&rated)
            .finds(&by_rate),
        good("index-counts.csv", stamped("", |k| (k - FROM).to_string()))
            .options(&rated)
            .options(&["--time-zero", "0.02"]),
        good(
            "index-by-three.csv",
            stamped("", |k| (3 * k - 3 * FROM).to_string()),
        )
        .options(&rated)
        .options(&["--time-zero", "0.02"])
        .finds(&["warning index-step"]),
    ]);
    cases
}

/// Two clocks in one table.
fn beside() -> Vec<Case> {
    let table = |head: &str, row: &dyn Fn(i64) -> String| {
        let rows: String = (FROM..TO).map(|k| row(k) + "\n").collect();
        format!("{head}\n{rows}")
    };
    let fast = |k: i64| format!("{:.5}", k as f64 / 1e5);
    let iso = |k: i64| format!("2024-05-01T{}", of_day(TEN, k));
    let by_time = ["--time-column", "Time (s)"];
    let mut cases = Vec::new();
    type Beside<'a> = (&'a str, Box<dyn Fn(i64) -> String>);
    let clocks: Vec<Beside> = vec![
        ("DateTime", Box::new(iso)),
        ("Uhrzeit", Box::new(|k| of_day(TEN, k))),
        ("Elapsed", Box::new(s)),
        (
            "Elapsed (ms)",
            Box::new(|k| format!("{:.1}", k as f64 / 10.0 + 100.0)),
        ),
        (
            "epoch",
            Box::new(|k| format!("{:.4}", 1_714_557_600.0 + k as f64 / 1e4)),
        ),
        (
            "ts",
            Box::new(|k| (1_714_557_600_000_000_i64 + 100 * k).to_string()),
        ),
        ("Time (ms)", Box::new(|k| format!("{:.1}", k as f64 / 10.0))),
        ("Sample (10 kHz)", Box::new(|k| (k - FROM).to_string())),
        ("Wall clock", Box::new(|k| format!("{:?}", of_day(TEN, k)))),
    ];
    for (index, (name, clock)) in clocks.iter().enumerate() {
        let head = format!("Time (s);{name};acc_y_g");
        let file = |kind: &str| format!("beside-{kind}{index}.csv");
        let same = table(&head, &|k| format!("{};{};{}", s(k), clock(k), g(k)));
        let counts = name.starts_with("Sample") || *name == "ts";
        let chosen: Vec<&str> = counts
            .then_some("info channel-chosen")
            .into_iter()
            .collect();
        cases.push(good(&file("same-"), same).options(&by_time).finds(&chosen));
        let other = table(&head, &|k| format!("{};{};{}", fast(k), clock(k), g(k)));
        cases.push(
            good(&file(""), other)
                .options(&by_time)
                .clock(100_000.0, -0.002)
                .finds(&SHORT)
                .finds(&chosen)
                .unusable(&["blocking time-contradicted"], &[name, "Time (s)"]),
        );
        // The other way round, and behind the channel.
        let head = format!("{name};acc_y_g;Time (s)");
        let behind = table(&head, &|k| format!("{};{};{}", clock(k), g(k), fast(k)));
        cases.push(
            good(&file("behind-"), behind)
                .options(&by_time)
                .clock(100_000.0, -0.002)
                .finds(&SHORT)
                .finds(&chosen)
                .unusable(&["blocking time-contradicted"], &[name, "Time (s)"]),
        );
    }
    let whole = |k: i64| of_day(TEN, k)[..8].to_string();
    let slow = |k: i64| format!("{:.1}", k as f64 / 10.0);
    cases.extend([
        // A clock of whole seconds says nothing of 80 ms, and much of 80 s.
        good(
            "beside-whole-seconds.csv",
            table("Time (s);Clock;acc_y_g", &|k| {
                format!("{};{};{}", fast(k), whole(k), g(k))
            }),
        )
        .clock(100_000.0, -0.002)
        .exit(3)
        .finds(&SHORT),
        good(
            "beside-whole-seconds-slow.csv",
            table("Time (s);Clock;acc_y_g", &|k| {
                format!("{};{};{}", slow(k), whole(k), g(k))
            }),
        )
        .clock(10.0, -20.0)
        .unusable(
            &["blocking time-contradicted", "blocking low-rate"],
            &["Clock"],
        )
        .finds(&[
            "warning implausible-velocity",
            "warning rate-below-default-filter",
        ]),
        // A clock of words that stands still and one that is empty in most rows.
        good(
            "beside-updates.csv",
            table("Time (s);GPS time;acc_y_g", &|k| {
                format!("{};{};{}", s(k), of_day(TEN, k / 300 * 300), g(k))
            }),
        ),
        good(
            "beside-few.csv",
            table("Time (s);Clock;acc_y_g", &|k| {
                let stamp = if k % 300 == 0 {
                    of_day(TEN, k)
                } else {
                    String::new()
                };
                format!("{};{stamp};{}", fast(k), g(k))
            }),
        )
        .clock(100_000.0, -0.002)
        .exit(3)
        .finds(&SHORT),
        good(
            "rate-beside-a-count.csv",
            table("Sample (10 kHz);acc_y_g", &|k| {
                format!("{};{}", k - FROM, g(k))
            }),
        )
        .options(&["--rate-hz", "100000"])
        .clock(100_000.0, 0.0)
        .finds(&SHORT)
        .finds(&["info channel-chosen"])
        .unusable(
            &["blocking time-contradicted"],
            &["Sample (10 kHz)", "the stated rate"],
        ),
    ]);
    cases
}
