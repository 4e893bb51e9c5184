//! Units of acceleration in many spellings, other quantities, and what only looks like an acceleration.

use super::super::{Case, g, good, numbers, push, refused, s};
use super::table;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = spellings();
    cases.extend(ambiguous());
    cases.extend(other_quantities());
    cases.extend(sensitivities());
    cases.extend(counted_faults());
    cases.extend(columns());
    cases
}

/// Units of small accelerations, in header cells and in rows of units.
fn spellings() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, (head, unit, per_g)) in [
        ("Time (s),acc y (milli-g)", "mg", 1e3),
        ("Time (s),sill left ay [mG]", "mg", 1e3),
        ("Time (s),acc y (milli g)", "mg", 1e3),
        ("Time (s),Y (mg)", "mg", 1e3),
        ("time_s,acc_y_mg", "mg", 1e3),
        ("time,acc y\ns,mg", "mg", 1e3),
        ("time_s,accel y (cm/s2)", "cm/s2", 980.665),
        ("time_s,ay [cm/s²]", "cm/s2", 980.665),
        ("time_s,acc_y_cm_s2", "cm/s2", 980.665),
        ("time_s,acc y (Gal)", "cm/s2", 980.665),
        ("time,ay\ns,cm/s^2", "cm/s2", 980.665),
        ("time_s,acc y (in/s2)", "in/s2", 9.806_65 / 0.0254),
        ("time_s,acc y [in/s^2]", "in/s2", 9.806_65 / 0.0254),
        ("time_s,acc y (inch/s²)", "in/s2", 9.806_65 / 0.0254),
        ("time,ay\ns,in/(s*s)", "in/s2", 9.806_65 / 0.0254),
    ]
    .into_iter()
    .enumerate()
    {
        let text = move |k: i64| format!("{:.6}", push(k) * per_g);
        let names = head.split('\n').next().unwrap();
        let channel = names.split_once(',').unwrap().1;
        let file = table(head, |k| format!("{},{}", s(k), text(k)));
        let case = good(&format!("small-unit-{index}.csv"), file);
        cases.push(case.channel(channel).unit(unit, text));
    }
    cases
}

/// `mg` and `Gal` where no word says that accelerations are meant.
fn ambiguous() -> Vec<Case> {
    let names = [
        "mass (mg)",
        "weight [mg]",
        "ch1 (mg)",
        "tank (gal)",
        "sensor (Gal)",
    ];
    let case = |(index, name): (usize, &&str)| {
        let text = table(&format!("time_s,{name}"), |k| format!("{},{}", s(k), g(k)));
        refused(
            &format!("ambiguous-{index}.csv"),
            text,
            &[name, "other quantities share"],
        )
    };
    names.iter().enumerate().map(case).collect()
}

/// What is no acceleration is not made one by a unit.
fn other_quantities() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, (head, quantity)) in [
        ("time_s,acc y (V)", "V"),
        ("time_s,acc y (Volt)", "Volt"),
        ("time_s,acc y [volts]", "volts"),
        ("time_s,acc y (mV)", "mV"),
        ("time_s,acc y (N)", "N"),
        ("time_s,acc y (counts)", "counts"),
        ("time_s,acc y [LSB]", "LSB"),
        ("time_s,acc y (pC)", "pC"),
        ("time_s,acc y (%FS)", "%FS"),
        ("time_s,acc y (bar)", "bar"),
        ("time_s,acc y (deg/s)", "deg/s"),
        ("time_s,cDAQ1Mod1/ai0 (V)", "V"),
        ("time_s,acc_y_counts", "counts"),
        ("time_s,ay raw volts", "volts"),
        ("time_s,ay counts (g)", "counts"),
        ("second,sill left ay\ns,Volt", "Volt"),
        ("time,acc y\ns,Digits", "Digits"),
        ("time,acc y\ns,mV RMS", "mV RMS"),
        ("time,acc y (g)\ns,V", "V"),
    ]
    .into_iter()
    .enumerate()
    {
        let text = table(head, |k| format!("{},{}", s(k), g(k)));
        let way_on = format!("--sensitivity '20 g/{quantity}'");
        let says = [&format!("`{quantity}` in the"), &*way_on];
        let file = |kind: &str| format!("other-quantity-{kind}{index}.csv");
        let told = refused(&file(""), text.clone(), &says);
        cases.push(told.options(&["--channel", "2", "--unit", "g"]));
        cases.push(refused(&file("silent-"), text, &says).options(&["--channel", "2"]));
    }
    let volts = table("time_s,acc y (V)", |k| format!("{},{}", s(k), g(k)));
    cases.push(refused(
        "volts.csv",
        volts.clone(),
        &["none is an acceleration", "--sensitivity"],
    ));
    cases.push(
        refused(
            "volts-card.csv",
            volts,
            &["`V` in the header", "though the card states g"],
        )
        .beside("volts-card.csv.toml", "channel = 2\nunit = \"g\"\n"),
    );
    cases
}

/// A sensitivity makes accelerations of the quantity that it is for.
fn sensitivities() -> Vec<Case> {
    let mut cases = Vec::new();
    let used = ["info sensitivity-used"];
    for (index, (head, sensitivity, unit, scale)) in [
        ("time_s,acc y (V)", "20 g/V", "g", 20.0),
        ("time_s,acc y (mV)", "20 g/V", "g", 20.0 / 1e3),
        ("time_s,acc y (Volts)", "50 mV/g", "g", 1e3 / 50.0),
        ("time_s,acc y [V]", "5 mV/(m/s2)", "m/s2", 1e3 / 5.0),
        ("time_s,acc y (counts)", "0.061 g/CNT", "g", 0.061),
        ("time_s,acc y [LSB]", "16384 lsb/g", "g", 1.0 / 16_384.0),
        ("time_s,acc y (pC)", "10 pC/g", "g", 1.0 / 10.0),
        ("time,acc y\ns,mV RMS", "0.02 g/mV RMS", "g", 0.02),
    ]
    .into_iter()
    .enumerate()
    {
        let per_g = match unit {
            "g" => 1.0 / scale,
            _ => 9.806_65 / scale,
        };
        let text = move |k: i64| format!("{:.9}", push(k) * per_g);
        let values = numbers(text)
            .into_iter()
            .map(|value| value * scale)
            .collect();
        let names = head.split('\n').next().unwrap();
        let channel = names.split_once(',').unwrap().1;
        let file = table(head, |k| format!("{},{}", s(k), text(k)));
        let case = good(&format!("sensitivity-{index}.csv"), file).channel(channel);
        let case = case.change(|read| read.unit = unit).values(values);
        let case = case.options(&["--sensitivity", sensitivity]);
        cases.push(case.finds(&used));
    }
    let volts = table("time_s,acc y (V)", |k| {
        format!("{},{:.6}", s(k), push(k) / 20.0)
    });
    let plain = table("time_s,acc_y_g", |k| format!("{},{}", s(k), g(k)));
    let text = |k: i64| format!("{:.6}", push(k) / 20.0);
    let values = || {
        numbers(text)
            .into_iter()
            .map(|value| value * 20.0)
            .collect()
    };
    cases.extend([
        refused(
            "sensitivity-of-another.csv",
            volts.clone(),
            &["samples in counts", "`V`"],
        )
        .options(&["--channel", "2", "--sensitivity", "20 g/counts"]),
        refused(
            "sensitivity-of-g.csv",
            plain,
            &["samples in V", "`g` in the header"],
        )
        .options(&["--sensitivity", "20 g/V"]),
        good("sensitivity-card.csv", volts.clone())
            .channel("acc y (V)")
            .values(values())
            .beside("sensitivity-card.csv.toml", "sensitivity = \"20 g/V\"\n")
            .finds(&used),
        // The option counts before the card's unit.
        good("sensitivity-over-card.csv", volts)
            .channel("acc y (V)")
            .values(values())
            .beside("sensitivity-over-card.csv.toml", "unit = \"g\"\n")
            .options(&["--sensitivity", "20 g/V"])
            .finds(&used),
    ]);
    cases
}

/// A count of faults that is none is shown; anything else with a fault word blocks.
fn counted_faults() -> Vec<Case> {
    let said = |kind: &str, index: usize, words: &str| {
        let text = table(&format!("# {words}\ntime_s,acc_y_g"), |k| {
            format!("{},{}", s(k), g(k))
        });
        good(&format!("counted-{kind}-{index}.csv"), text)
    };
    let none = [
        "Skipped samples: 0",
        "Integrity: True, Skipped samples: 0",
        "overflows 0",
        "Dropped: 0",
        "dropouts = none",
        "Overload: no",
        "CLIPPED NO",
        "Status: errors 0",
        "Lost packets: 0; clipped: none",
    ];
    let some = [
        "overflows 0 on A, 3 on B",
        "CH 0 OVERFLOW",
        "no overflow recorded",
        "overflows: 0, B: 3",
        "Skipped samples: 0, clipped: 3",
        "Skipped samples: 10",
        "overflows 0.4",
        "number of overflows: 0",
        "clipped: none, but see channel 3",
        "clipped: not known",
        "no data, overflows 0",
        "drop, out: 0",
        "overflow: nobody looked",
        "0 overflows",
    ];
    let none = none.iter().enumerate();
    let none =
        none.map(|(index, words)| said("none", index, words).finds(&["info laboratory-remark"]));
    let some = some.iter().enumerate().map(|(index, words)| {
        said("some", index, words).unusable(&["blocking laboratory-remark"], &["accepted_remarks"])
    });
    none.chain(some).collect()
}

/// Names that are numbers, turning rates beside accelerations, and rows that hold the time alone.
fn columns() -> Vec<Case> {
    let scope = table("x-axis,1,2", |k| format!("{},{},{}", s(k), g(k + 5), g(k)));
    let mut cases = vec![
        good("named-by-number.csv", scope.clone())
            .options(&["--header-line", "1", "--unit", "g"])
            .options(&["--channel", "2", "--time-column", "x-axis"])
            .channel("2")
            .finds(&["warning column-by-name", "info time-unit-assumed"]),
        good(
            "named-by-its-own-number.csv",
            table("1,2", |k| format!("{},{}", s(k), g(k))),
        )
        .options(&["--header-line", "1", "--unit", "g"])
        .options(&["--channel", "2", "--time-column", "1"])
        .channel("2")
        .finds(&["info time-unit-assumed"]),
        // The name of the samples' column, where that of the times was meant.
        refused(
            "time-by-name.csv",
            scope,
            &[":7, column 2", "time must increase"],
        )
        .options(&[
            "--header-line",
            "1",
            "--channel",
            "3",
            "--time-column",
            "1",
            "--unit",
            "g",
        ]),
    ];
    for (index, names) in [
        "a_x,a_z,g_x,g_y",
        "acc x,acc z,g x,g y",
        "Ax,Az,G X,G Y",
        "accel.x,accel.z,g.x,g.y",
    ]
    .into_iter()
    .enumerate()
    {
        let text = table(&format!("time_s,{names}"), |k| {
            format!("{},{},{},{},{}", s(k), g(k + 1), g(k + 2), g(k + 3), g(k))
        });
        let name = names.rsplit(',').next().unwrap();
        let case = good(&format!("turning-rate-{index}.csv"), text);
        let chosen = case
            .options(&["--unit", "g", "--channel", name])
            .channel(name);
        cases.push(chosen.finds(&["warning channel-not-lateral"]));
    }
    let rates = table("time_s,a_x,a_z,g_x,g_y,g_z", |k| {
        format!(
            "{},{},{},{},{},{}",
            s(k),
            g(k),
            g(k + 1),
            g(k + 2),
            g(k + 3),
            g(k + 4)
        )
    });
    cases.push(
        refused(
            "turning-rates.csv",
            rates,
            &["g_y (its `g` beside `a_x`", "--channel"],
        )
        .options(&["--unit", "g"]),
    );
    for (index, (names, cells)) in [
        ("Timestamp,X,Y,Z", 4),
        ("time;acc_y_g", 2),
        ("t [s]\tax\tay [g]", 3),
        ("time_s,acc_y_g,status", 3),
    ]
    .into_iter()
    .enumerate()
    {
        let says = [
            &*format!(":2: expected rows of {cells} cells"),
            "rows of one cell",
        ];
        cases.push(refused(
            &format!("only-time-{index}.csv"),
            table(names, s),
            &says,
        ));
    }
    cases
}
