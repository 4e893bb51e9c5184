//! Rows above the names, lines behind the table, and stamps that come twice.

use super::super::{Case, FROM, TO, g, good, push, refused, s};
use super::{plain, table};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = slices();
    cases.extend(contradictions());
    cases.extend(styles());
    cases.extend(unit_lines());
    cases.extend(asked_for());
    cases.extend(footers());
    cases.extend(doubled_stamps());
    cases
}

/// The rows of a crash recorder's export above its names; `changes` are other values of rows, by their keys.
fn slice(changes: &[(&str, &str)]) -> String {
    let mut head = String::new();
    for (key, values) in [
        ("Headers", ","),
        ("Test Date", "01/02/2026,01/02/2026"),
        ("Test Time", "10:00:00,10:00:00"),
        ("Test ID", "T1,T1"),
        ("Sample Rate (Hz)", "10000,10000"),
        ("Hardware AA Filter (-3dB)", "2000,2000"),
        ("Data Channel Number", "1,2"),
        ("ISO Channel Code", "11SILLLE0000ACYP,11SILLLE0000ACZP"),
        ("Channel Description", "Sill left AC Y,Sill left AC Z"),
        ("Sensor S/N", "P1,P2"),
        ("Software Filter (SAE Class)", "NONE,NONE"),
        ("Software Filter (-3dB)", "NONE,NONE"),
        ("Engineering Unit", "g ,g "),
        ("User Comment", ","),
        ("Number of Pre-Zero Data Pts", "200,200"),
        ("Number of Post-Zero Data Pts", "600,600"),
        ("Scale Factor (EU/CNT)", "0.061,0.061"),
        ("Data Starts Here", ","),
    ] {
        let change = changes.iter().find(|(changed, _)| *changed == key);
        let values = change.map_or(values, |(_, values)| values);
        head += &format!("{key},{values},\n");
    }
    head += "Time,Chan 0:P1,Chan 1:P2,";
    table(&head, |k| format!("{},{},{},", s(k), g(k), g(k + 9)))
}

/// What is found in each of these exports.
const SLICE: [&str; 3] = [
    "info preamble",
    "info channel-chosen",
    "info time-unit-assumed",
];

/// Exports of crash recorders need no option: names, unit and channel stand above the table.
fn slices() -> Vec<Case> {
    let read =
        |name: &str, changes: &[(&str, &str)]| good(name, slice(changes)).channel("Chan 0:P1");
    let chosen = ["info preamble", "info time-unit-assumed"];
    vec![
        read("slice.csv", &[]).finds(&SLICE),
        read("slice-told.csv", &[])
            .options(&["--header-line", "19"])
            .finds(&SLICE),
        read("slice-by-code.csv", &[])
            .options(&["--channel", "11SILLLE0000ACYP"])
            .finds(&chosen),
        read("slice-by-description.csv", &[])
            .options(&["--channel", "sill left ac y"])
            .finds(&chosen),
        read(
            "slice-without-codes.csv",
            &[("ISO Channel Code", "NONE,NONE")],
        )
        .finds(&SLICE),
        // A place in a dummy, and a code that contradicts its description.
        refused(
            "slice-head.csv",
            slice(&[
                ("ISO Channel Code", "11HEAD0000H3ACYP,11HEAD0000H3ACZP"),
                ("Channel Description", "Head AC Y,Head AC Z"),
            ]),
            &["Chan 0:P1 (`11HEAD0000H3ACYP`)", "--channel"],
        ),
        refused(
            "slice-other-description.csv",
            slice(&[("Channel Description", "Head AC Y,Sill left AC Z")]),
            &["Chan 0:P1 (`head`)", "--channel"],
        ),
        read("slice-overridden.csv", &[])
            .options(&["--unit", "m/s2"])
            .unit("m/s2", g)
            .exit(3)
            .finds(&SLICE)
            .finds(&[
                "warning unit-overridden",
                "warning implausible-peak",
                "warning implausible-velocity",
            ]),
        read(
            "slice-class.csv",
            &[("Software Filter (SAE Class)", "60,60")],
        )
        .finds(&SLICE)
        .finds(&["warning already-filtered"]),
        read(
            "slice-class-1000.csv",
            &[("Software Filter (SAE Class)", "CFC 1000,CFC 1000")],
        )
        .finds(&SLICE)
        .finds(&["info already-filtered"]),
        read("slice-corner.csv", &[("Software Filter (-3dB)", "100,100")])
            .finds(&SLICE)
            .finds(&["warning already-filtered"]),
        refused(
            "slice-volts.csv",
            slice(&[("Engineering Unit", "V,V")]),
            &[
                "`V` in the preamble of `Chan 0:P1`",
                "--sensitivity '20 g/V'",
            ],
        )
        .options(&["--channel", "2", "--unit", "g"]),
        refused(
            "slice-no-unit.csv",
            slice(&[("Engineering Unit", "NONE,NONE")]),
            &["no unit of acceleration", "--unit"],
        ),
    ]
}

/// What the rows above say is held against samples and options.
fn contradictions() -> Vec<Case> {
    let read = |name: &str, changes: &[(&str, &str)]| {
        good(name, slice(changes))
            .channel("Chan 0:P1")
            .finds(&SLICE)
    };
    let time = ["blocking time-contradicted"];
    let mut cases = vec![
        read("slice-rate-near.csv", &[("Sample Rate (Hz)", "9800,9800")])
            .finds(&["warning rate-contradicted"]),
        read(
            "slice-rate-unread.csv",
            &[("Sample Rate (Hz)", "extern,extern")],
        )
        .finds(&["warning statement-unread"]),
        read(
            "slice-zero.csv",
            &[
                ("Number of Pre-Zero Data Pts", "100,100"),
                ("Number of Post-Zero Data Pts", "700,700"),
            ],
        )
        .unusable(
            &time,
            &["`Number of Pre-Zero Data Pts` on line 15", "--time-zero"],
        ),
        read(
            "slice-zero-told.csv",
            &[
                ("Number of Pre-Zero Data Pts", "100,100"),
                ("Number of Post-Zero Data Pts", "700,700"),
            ],
        )
        .options(&["--time-zero", "0"])
        .finds(&["warning time-zero-contradicted"]),
        read(
            "slice-short.csv",
            &[("Number of Post-Zero Data Pts", "900,900")],
        )
        .unusable(&["blocking samples-missing"], &["states 1100 samples"]),
        read("slice-clipped.csv", &[("User Comment", "signal clipped,")])
            .unusable(&["blocking laboratory-remark"], &["signal clipped"]),
        read(
            "slice-comment-of-another.csv",
            &[("User Comment", ",signal clipped")],
        ),
        read(
            "slice-counted.csv",
            &[("Headers", ",\nDropped samples,0,0")],
        )
        .finds(&["info laboratory-remark"]),
        read(
            "slice-dropped.csv",
            &[("Headers", ",\nDropped samples,3,0")],
        )
        .unusable(&["blocking laboratory-remark"], &["Dropped samples: 3"]),
    ];
    for (index, row) in [
        ",\nAbtastrate [Hz],1000,1000",
        ",\nSampling frequency,100 kHz,100 kHz",
        ",\nSample interval,1 ms,1 ms",
        ",\nSample interval (us),10,",
        ",\nSampling period: 2.5E-5 s",
    ]
    .iter()
    .enumerate()
    {
        let case = read(&format!("slice-rate-{index}.csv"), &[("Headers", row)]);
        cases.push(case.unusable(&time, &["on line 2 is", "gives 10000 Hz"]));
    }
    for (index, comment) in [
        "Sample rate: 1000 Hz",
        "samplerate = 2 kS/s",
        "Abtastrate: 20 kHz",
    ]
    .iter()
    .enumerate()
    {
        let text = plain(&format!("# {comment}\ntime_s,acc_y_g"));
        let case = good(&format!("comment-rate-{index}.csv"), text);
        cases.push(case.finds(&["warning rate-contradicted"]));
    }
    for (index, comment) in ["Sample rate: 10000 Hz", "rate: 5", "video rate: 1000 Hz"]
        .iter()
        .enumerate()
    {
        let text = plain(&format!("# {comment}\ntime_s,acc_y_g"));
        cases.push(good(&format!("comment-rate-fits-{index}.csv"), text));
    }
    let untimed = |rate: &str| {
        let head =
            format!("Sled 7\nSample rate (Hz),{rate}\nPre-trigger samples,200\nacc_y_g,acc_x_g");
        table(&head, |k| format!("{},{}", g(k), g(k + 9)))
    };
    let found = ["info preamble", "info channel-chosen"];
    cases.extend([
        good("rate-above.csv", untimed("10000"))
            .options(&["--header-line", "4"])
            .finds(&found)
            .finds(&["info rate-above-table"]),
        good("rate-above-told.csv", untimed("10000"))
            .options(&["--header-line", "4", "--rate-hz", "10000"])
            .finds(&found),
        good("rate-above-contradicted.csv", untimed("1000"))
            .options(&["--header-line", "4", "--rate-hz", "10000"])
            .finds(&found)
            .unusable(&time, &["`Sample rate (Hz)` on line 2 is `1000`"]),
        refused(
            "rate-above-unclear.csv",
            untimed("fast"),
            &["no time column", "--rate-hz"],
        )
        .options(&["--header-line", "4"]),
    ]);
    cases
}

/// Preambles of other programs, in other languages and with other separators.
fn styles() -> Vec<Case> {
    let one = |head: &str, separator: &str| table(head, |k| format!("{}{separator}{}", s(k), g(k)));
    let comma = |head: &str| table(head, |k| format!("{};{}", s(k), g(k)).replace('.', ","));
    let scope = "Model,MDO3024\nFirmware Version,1.28\n\nPoint Format,Y\nHorizontal Units,s\n\
                 Horizontal Scale,0.004\nSample Interval,1e-04\nRecord Length,800\n\
                 Gating,0.0% to 100.0%\nProbe Attenuation,1\nVertical Units,V\n,\n,\nLabel,\nTIME,CH1";
    let volts = table(scope, |k| format!("{},{:.6}", s(k), push(k) / 20.0));
    let two_lines = table("x-axis,1,2\nsecond,Volt,Volt", |k| {
        format!("{},{:.6},{:.6}", s(k), push(k + 9) / 20.0, push(k) / 20.0)
    });
    let values = (FROM..TO).map(|k| format!("{:.6}", push(k) / 20.0));
    let values = values
        .map(|text| 20.0 * text.parse::<f64>().unwrap())
        .collect();
    let mut cases = vec![
        good("scope.csv", volts.clone())
            .options(&["--sensitivity", "20 g/V"])
            .channel("CH1")
            .values(values)
            .finds(&["info preamble", "info sensitivity-used"]),
        refused(
            "scope-as-g.csv",
            volts.clone(),
            &["`V` in the preamble of `CH1`", "--sensitivity"],
        )
        .options(&["--channel", "CH1", "--unit", "g"]),
        good("scope-slow.csv", volts.replace("1e-04", "1e-03"))
            .options(&["--sensitivity", "20 g/V"])
            .channel("CH1")
            .samples(800)
            .finds(&["info preamble", "info sensitivity-used"])
            .unusable(
                &["blocking time-contradicted"],
                &["`Sample Interval` on line 7"],
            ),
        good("scope-of-two-lines.csv", two_lines)
            .options(&["--sensitivity", "20 g/V", "--channel", "2"])
            .channel("2")
            .samples(800)
            .finds(&["info sensitivity-used", "warning column-by-name"]),
        good(
            "german.csv",
            comma(
                "Prüfung;Schlitten 7\nAbtastrate [kHz];10\nEinheit;g\nKanalname;Schweller links Y\n\
                   Aufnehmer;7264\n\nZeit [s];Kanal 1",
            ),
        )
        .channel("Kanal 1")
        .finds(&["info preamble", "info decimal-comma"]),
        good(
            "french.txt",
            one(
                "Essai\tE12\nFréquence d'échantillonnage\t10 kHz\nUnité\tm/s²\n\nTemps (s)\tacc y",
                "\t",
            ),
        )
        .channel("acc y")
        .unit("m/s2", g)
        .exit(3)
        .finds(&[
            "info preamble",
            "warning implausible-peak",
            "warning implausible-velocity",
        ]),
        good(
            "colons.csv",
            one(
                "Sled test 7\nSample rate: 10000 Hz\nUnit: g\nSensor: 123\n\ntime_s,acc_y",
                ",",
            ),
        )
        .channel("acc_y")
        .finds(&["info preamble"]),
        good(
            "blanks.txt",
            one(
                "Sled test 7\nSample rate: 10 kHz\nUnit = g\n\ntime_s acc_y",
                " ",
            ),
        )
        .channel("acc_y")
        .finds(&["info preamble"]),
        good(
            "units-above.csv",
            one("Sled test 7\ns,g\nleft sill,from trigger\ntime,acc_y", ","),
        )
        .channel("acc_y")
        .finds(&["info preamble"]),
        good(
            "japanese.csv",
            one("サンプリング周波数,10 kHz\n単位,g\ntime_s,acc_y", ","),
        )
        .channel("acc_y")
        .finds(&["info preamble"]),
        good(
            "spanish.csv",
            one(
                "Ensayo;7\nFrecuencia de muestreo (Hz);10000\nUnidad;g\ntiempo [s];acel y",
                ";",
            ),
        )
        .channel("acel y")
        .options(&["--channel", "acel y"])
        .finds(&["info preamble", "warning channel-not-lateral"]),
        refused(
            "two-units.csv",
            one("Unit,g\nInput,7\nUnits,m/s2\ntime_s,acc_y", ","),
            &["no unit of acceleration", "--unit"],
        ),
    ];
    let two = |unit: &str| {
        table(&format!("Sled 7,,\n{unit}\ntime_s,acc y,acc z"), |k| {
            format!("{},{},{}", s(k), g(k + 9), g(k))
        })
    };
    cases.extend([
        good("unit-of-all.csv", two("Unit,g"))
            .options(&["--channel", "3"])
            .channel("acc z")
            .finds(&["info preamble", "warning channel-not-lateral"]),
        refused(
            "unit-of-one.csv",
            two("Unit,g,"),
            &["no unit of acceleration"],
        )
        .options(&["--channel", "3"]),
    ]);
    for (index, row) in [
        "Filter class,60",
        "CFC: 180",
        "Filterklasse,CFC_600",
        "Filter,Butterworth 4",
    ]
    .iter()
    .enumerate()
    {
        let text = one(&format!("Sled test 7\n{row}\ntime_s,acc_y_g"), ",");
        let case = good(&format!("class-{index}.csv"), text);
        cases.push(case.finds(&["info preamble", "warning already-filtered"]));
    }
    cases
}

/// The line of the units, where no key that is known tells it.
fn unit_lines() -> Vec<Case> {
    let text = |row: &str| {
        let head = format!("Sled 7\nKind,1,2\n{row}\ntime_s,acc y,acc z");
        table(&head, |k| format!("{},{},{}", s(k), g(k), g(k + 9)))
    };
    let told = ["--unit-line", "3"];
    let found = ["info preamble", "info channel-chosen"];
    let mut cases = Vec::new();
    for (index, row) in ["EUnits,g,g", "Grandeur,g,m/s2", "what it is,[g],[g]"]
        .iter()
        .enumerate()
    {
        let case = good(&format!("unit-line-{index}.csv"), text(row));
        cases.push(case.channel("acc y").options(&told).finds(&found));
    }
    cases.push(
        good("unit-line-without-key.csv", text(",g,V"))
            .channel("acc y")
            .options(&["--header-line", "4"])
            .options(&told)
            .finds(&["info preamble"]),
    );
    let described = plain("time,acc_y\nfrom trigger,g").replace("time,", "time_s,");
    cases.extend([
        // Units of acceleration above the channels are such whatever the key.
        good("unit-line-untold.csv", text("EUnits,g,g"))
            .channel("acc y")
            .finds(&found),
        refused(
            "unit-line-untold-other.csv",
            text("EUnits,g,V"),
            &["no unit of acceleration"],
        ),
        refused(
            "unit-line-nowhere.csv",
            text("EUnits,g,g"),
            &["units of the columns on line 99"],
        )
        .options(&["--unit-line", "99"]),
        refused(
            "unit-line-wide.csv",
            text("EUnits,g,g,g,g"),
            &["units of 3 columns"],
        )
        .options(&told),
        good("unit-line-card.csv", text("EUnits,g,g"))
            .channel("acc y")
            .beside("unit-line-card.csv.toml", "unit_line = 3\n")
            .finds(&found),
        good("unit-line-below.csv", described)
            .channel("acc_y")
            .options(&["--header-line", "1", "--unit-line", "2"]),
        refused(
            "unit-line.lvm",
            "LabVIEW Measurement\t\n",
            &["leave out --unit-line"],
        )
        .options(&["--unit-line", "2"]),
    ]);
    cases
}

/// Where something else than names below a preamble could be meant, a person is asked.
fn asked_for() -> Vec<Case> {
    let heads = [
        "Sled 07\n0.5,0.7\ntime_s,acc_y_g",
        "10000,Hz\ntime_s,acc_y_g",
        "Sled 07\nwhen,acc_y_g",
        "Sled 07\ntime_s,acc_y_g\nfrom here,to there",
        "Sled 07\n,left\ntime_s,acc_y_g",
    ];
    let case = |(index, head): (usize, &&str)| {
        let text = plain(head);
        refused(&format!("below-{index}.csv"), text, &["--header-line"])
    };
    heads.iter().enumerate().map(case).collect()
}

/// Lines behind the table.
fn footers() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, lines) in [
        "EOF",
        "EOF\n",
        "Peak,30.1\nEOF\n",
        "\nSummary\nChannel,max,min\nacc_y,30.1,-0.1\n",
        "Rate 10000, channels 2\n",
        "x,y,z\n1,2,3\n4,5,6\n",
        "\"done\"\n",
    ]
    .iter()
    .enumerate()
    {
        let text = plain("time_s,acc_y_g") + lines;
        let file = |kind: &str| format!("footer-{kind}{index}.csv");
        let said = refused(&file(""), text.clone(), &["line 801", "--last-line 801"]);
        cases.push(said);
        let told = good(&file("told-"), text).options(&["--last-line", "801"]);
        cases.push(match index {
            // A line that begins with the channel's name is a remark of the channel.
            3 => told.finds(&["info laboratory-remark"]),
            5 => told.finds(&["warning rows-left-out"]),
            _ => told,
        });
    }
    let twice = plain("time_s,acc_y_g");
    let second = twice.split_once('\n').unwrap().1.to_string();
    let last = ["--last-line", "801"];
    cases.extend([
        refused(
            "second-section.csv",
            twice.clone() + "Section 2,again\n" + &second,
            &["--last-line 801"],
        ),
        good(
            "second-section-told.csv",
            twice.clone() + "Section 2\n" + &second,
        )
        .options(&last)
        .finds(&["warning rows-left-out"]),
        good("footer-clipped.csv", twice.clone() + "channel clipped\n")
            .options(&last)
            .unusable(&["blocking laboratory-remark"], &["channel clipped"]),
        good("footer-card.csv", twice.clone() + "EOF\n")
            .beside("footer-card.csv.toml", "last_line = 801\n"),
        // A bad cell among rows is no end of the table.
        refused(
            "bad-cell.csv",
            twice.replace(
                &format!("{},{}\n", s(100), g(100)),
                &format!("{},bad\n", s(100)),
            ),
            &[":302", "correct the cell"],
        ),
        refused(
            "ragged-among-rows.csv",
            twice.replace(
                &format!("{},{}\n", s(100), g(100)),
                &format!("{}\n", s(100)),
            ),
            &[":302", "ragged"],
        ),
    ]);
    cases
}

/// A stamp that comes twice ends what is used of a table; what came before stands.
fn doubled_stamps() -> Vec<Case> {
    let doubled = |at: i64| {
        table("time_s,acc_y_g", |k| {
            format!("{},{}", s(if k == at { k - 1 } else { k }), g(k))
        })
    };
    let read = |name: &str, at: i64| {
        let values = (FROM..at).map(|k| g(k).parse().unwrap()).collect();
        good(name, doubled(at)).values(values)
    };
    let found = ["blocking stamp-doubled"];
    vec![
        read("doubled-after.csv", 550).unusable(&found, &["holds 0.0549 s twice", "on line 752"]),
        read("doubled-after-opens.csv", 550)
            .positive_opens()
            .finds(&found)
            .exit(1),
        // One doubled stamp among fine ones is no matter of digits.
        // One doubled stamp among fine ones is no matter of digits.
        read("doubled-rate.csv", 550)
            .options(&["--rate-hz", "10000"])
            .unusable(&found, &["holds 0.0549 s twice"]),
        read("doubled-in-the-event.csv", 50).unusable(
            &[
                "blocking stamp-doubled",
                "blocking ends-inside-event",
                "warning ends-early",
                "warning implausible-velocity",
            ],
            &["holds 0.0049 s twice"],
        ),
        refused(
            "doubled-at-once.csv",
            doubled(-190),
            &[":12", "time must increase"],
        ),
    ]
}
