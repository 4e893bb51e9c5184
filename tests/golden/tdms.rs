//! TDMS files, as LabVIEW and DIAdem write them.

use super::{Case, FROM, TO, good, push, refused};
use latchgate_test_support::tdms::{
    BIG, Bytes, DAQMX, F32, F64, I8, I16, INSTANT, INTERLEAVED, LITTLE, Property, Raw, Said, text,
};

const COUNT: u64 = (TO - FROM) as u64;
const Y: &str = "/'Vehicle'/'acc y'";
const X: &str = "/'Vehicle'/'acc x'";
const CLOCK: [Property<'static>; 2] = [
    ("wf_increment", Said::Number(1e-4)),
    ("wf_start_offset", Said::Number(-0.02)),
];
const G: Property<'static> = ("unit_string", Said::Text(b"g"));

/// Samples from one index to another as doubles.
fn doubles(bytes: Bytes, from: i64, to: i64) -> Vec<u8> {
    let value = |k| bytes.ordered(push(k).to_le_bytes());
    (from..to).flat_map(value).collect()
}

fn pushes() -> Vec<f64> {
    (FROM..TO).map(push).collect()
}

/// What a channel in g with a clock says, and more.
fn with<'a>(more: &[Property<'a>]) -> Vec<Property<'a>> {
    [&[G, CLOCK[0], CLOCK[1]], more].concat()
}

/// A file of one channel `acc y` of doubles.
fn file(properties: &[Property<'_>]) -> Vec<u8> {
    let object = LITTLE.object(Y, Raw::Numbers(F64, COUNT), properties);
    LITTLE.segment(0, Some(&[object]), &doubles(LITTLE, FROM, TO))
}

/// A file of `acc y` beside another channel, whose samples come first.
fn beside(
    path: &str,
    raw: Raw,
    said: &[Property<'_>],
    data: &[u8],
    own: &[Property<'_>],
) -> Vec<u8> {
    let objects = [
        LITTLE.object(path, raw, said),
        LITTLE.object(Y, Raw::Numbers(F64, COUNT), own),
    ];
    let data = [data, &doubles(LITTLE, FROM, TO)].concat();
    LITTLE.segment(0, Some(&objects), &data)
}

/// `acc y` of this interval [s] beside a channel of times at 10 kHz.
pub(super) fn stamped(interval_s: f64) -> Vec<u8> {
    let seconds: Vec<u8> = (FROM..TO)
        .flat_map(|k| (k as f64 / 1e4).to_le_bytes())
        .collect();
    let clock = [("wf_increment", Said::Number(interval_s)), CLOCK[1]];
    beside(
        "/'Vehicle'/'Time'",
        Raw::Numbers(F64, COUNT),
        &[("unit_string", text("s"))],
        &seconds,
        &[&[G], &clock[..]].concat(),
    )
}

fn read(name: &str, bytes: Vec<u8>) -> Case {
    good(name, bytes)
        .channel("acc y")
        .unit("g", |_| "0".into())
        .values(pushes())
}

/// A file of 16-bit counts, 400 of them 1 g, with what is said of their scale.
fn counts(properties: &[Property<'_>]) -> Vec<u8> {
    let object = LITTLE.object(Y, Raw::Numbers(I16, COUNT), properties);
    let data = (FROM..TO).flat_map(|k| count(k).to_le_bytes());
    LITTLE.segment(0, Some(&[object]), &data.collect::<Vec<u8>>())
}

fn count(k: i64) -> i16 {
    (push(k) * 400.0).round() as i16
}

const ONE_SCALE: Property<'static> = ("NI_Number_Of_Scales", Said::Count(1));
const KIND: &str = "NI_Scale[0]_Scale_Type";
const LINEAR: [Property<'static>; 4] = [
    (KIND, Said::Text(b"Linear")),
    ("NI_Scale[0]_Linear_Slope", Said::Number(0.0025)),
    ("NI_Scale[0]_Linear_Y_Intercept", Said::Number(0.125)),
    ("NI_Scale[0]_Linear_Input_Source", Said::Count(u32::MAX)),
];

/// A second scale, which takes away what the first adds.
const SECOND: [Property<'static>; 4] = [
    ("NI_Scale[1]_Scale_Type", Said::Text(b"Linear")),
    ("NI_Scale[1]_Linear_Slope", Said::Number(1.0)),
    ("NI_Scale[1]_Linear_Y_Intercept", Said::Number(-0.125)),
    ("NI_Scale[1]_Linear_Input_Source", Said::Count(0)),
];

/// Counts beside a property of their group or of the file.
fn of_parent(path: &str, said: Property<'_>) -> Vec<u8> {
    let objects = [
        LITTLE.object(path, Raw::Absent, &[said]),
        LITTLE.object(Y, Raw::Numbers(I16, COUNT), &with(&[])),
    ];
    let data: Vec<u8> = (FROM..TO).flat_map(|k| count(k).to_le_bytes()).collect();
    LITTLE.segment(0, Some(&objects), &data)
}

/// Counts beside a word that may be one of a scale, which no unit that is told makes good.
fn word_of_scale(key: &str) -> Case {
    let name = format!("word-{}.tdms", key.replace('/', "-"));
    let bytes = counts(&with(&[(key, Said::Number(3.0))]));
    refused(&name, bytes, &[&format!("`{key}` 3")]).options(&["--unit", "g"])
}

fn scales() -> Vec<Case> {
    let status = |word: &'static str| ("NI_Scaling_Status", text(word));
    let linear = with(&[&[ONE_SCALE, status("unscaled")], &LINEAR[..]].concat());
    let scaled: Vec<f64> = (FROM..TO)
        .map(|k| f64::from(count(k)) * 0.0025 + 0.125)
        .collect();
    let group = LITTLE.object(
        "/'Vehicle'",
        Raw::Absent,
        &[&[ONE_SCALE], &LINEAR[..]].concat(),
    );
    let by_group = {
        let object = LITTLE.object(Y, Raw::Numbers(I16, COUNT), &with(&[]));
        let data: Vec<u8> = (FROM..TO).flat_map(|k| count(k).to_le_bytes()).collect();
        LITTLE.segment(0, Some(&[group, object]), &data)
    };
    let kind = |word: &'static str| counts(&with(&[ONE_SCALE, (KIND, text(word))]));
    vec![
        read("linear.tdms", counts(&linear)).values(scaled.clone()),
        read("linear-of-the-group.tdms", by_group).values(scaled),
        refused(
            "thermocouple.tdms",
            kind("Thermocouple"),
            &[
                "NI_Scale[0]_Scale_Type `Thermocouple`",
                "from nptdms import",
            ],
        ),
        refused(
            "table.tdms",
            kind("Table"),
            &["`Table`", "from nptdms import"],
        ),
        refused(
            "no-slope.tdms",
            kind("Linear"),
            &["no NI_Scale[0]_Linear_Slope"],
        ),
        refused(
            "no-scale.tdms",
            counts(&with(&[ONE_SCALE])),
            &["no NI_Scale[0]_Scale_Type"],
        ),
        refused(
            "fewer-scales.tdms",
            counts(&with(
                &[&[("NI_Number_Of_Scales", Said::Count(0))], &LINEAR[..]].concat(),
            )),
            &["NI_Number_Of_Scales `0`"],
        ),
        refused(
            "odd-status.tdms",
            counts(&with(&[&[ONE_SCALE, status("half")], &LINEAR[..]].concat())),
            &["NI_Scaling_Status `half`"],
        ),
        refused(
            "gain.tdms",
            counts(&with(&[("Gain", Said::Number(0.0025))])),
            &["whole numbers beside `Gain`"],
        ),
        refused(
            "counts.tdms",
            counts(&with(&[])),
            &["whole numbers without a scale", "--unit g"],
        ),
        read("counts-told.tdms", counts(&with(&[])))
            .values((FROM..TO).map(|k| f64::from(count(k))).collect())
            .options(&["--unit", "g"])
            .positive_opens()
            .finds(&["warning implausible-peak", "warning implausible-velocity"])
            .exit(1),
        refused(
            "unscaled.tdms",
            file(&with(&[status("unscaled")])),
            &["NI_Scaling_Status `unscaled`"],
        ),
        refused(
            "gain-of-the-group.tdms",
            of_parent("/'Vehicle'", ("Gain", Said::Number(3.0))),
            &["`Gain` 3"],
        )
        .options(&["--unit", "g"]),
        refused(
            "gain-of-the-file.tdms",
            of_parent("/", ("Scale factor", text("6 g/count"))),
            &["`Scale factor`"],
        )
        .options(&["--unit", "g"]),
        word_of_scale("SCALEFACTOR"),
        word_of_scale("CalFactor2"),
        word_of_scale("Empfindlichkeit"),
        word_of_scale("mV/g"),
        word_of_scale("EU/count"),
        word_of_scale("NI_Gain"),
        word_of_scale("resolution"),
        refused(
            "gain-of-whole-doubles.tdms",
            {
                let object = LITTLE.object(
                    Y,
                    Raw::Numbers(F64, COUNT),
                    &with(&[("Gain", Said::Number(3.0))]),
                );
                let data = (FROM..TO).flat_map(|k| push(k).round().to_le_bytes());
                LITTLE.segment(0, Some(&[object]), &data.collect::<Vec<u8>>())
            },
            &["`Gain` 3"],
        ),
        refused(
            "scale-without-kind.tdms",
            counts(&with(&LINEAR[1..])),
            &["no NI_Scale[0]_Scale_Type"],
        ),
        refused(
            "scale-without-number.tdms",
            counts(&with(
                &[
                    &[("NI_Scale[p]_Linear_Slope", Said::Number(2.0))],
                    &LINEAR[..],
                ]
                .concat(),
            )),
            &["ni_scale[p]_linear_slope"],
        ),
        refused(
            "scales-uncounted.tdms",
            counts(&with(
                &[&[("NI_Number_Of_Scales", text("some"))], &LINEAR[..]].concat(),
            )),
            &["NI_Number_Of_Scales `some`"],
        ),
        refused(
            "scaled-twice.tdms",
            {
                let file = LITTLE.object("/", Raw::Absent, &[&[ONE_SCALE], &LINEAR[..]].concat());
                let object = LITTLE.object(Y, Raw::Numbers(I16, COUNT), &with(&[status("scaled")]));
                let data: Vec<u8> = (FROM..TO).flat_map(|k| count(k).to_le_bytes()).collect();
                LITTLE.segment(0, Some(&[file, object]), &data)
            },
            &["NI_Scaling_Status `scaled`"],
        ),
        read(
            "small-letters.tdms",
            counts(&with(&[
                ("ni_scale[0]_scale_type", text("Linear")),
                ("ni_scale[0]_linear_slope", Said::Number(0.0025)),
                ("ni_scale[0]_linear_y_intercept", Said::Number(0.125)),
            ])),
        )
        .values(
            (FROM..TO)
                .map(|k| f64::from(count(k)) * 0.0025 + 0.125)
                .collect(),
        ),
        refused(
            "source-missing.tdms",
            counts(&with(&[&LINEAR[..], &SECOND[..3]].concat())),
            &["no NI_Scale[1]_Linear_Input_Source"],
        ),
        refused(
            "source-of-words.tdms",
            counts(&with(
                &[
                    &LINEAR[..],
                    &SECOND[..3],
                    &[("NI_Scale[1]_Linear_Input_Source", text("zero"))],
                ]
                .concat(),
            )),
            &["NI_Scale[1]_Linear_Input_Source `zero`"],
        ),
        read(
            "two-scales.tdms",
            counts(&with(&[&LINEAR[..], &SECOND[..]].concat())),
        )
        .values(
            (FROM..TO)
                .map(|k| (f64::from(count(k)) * 0.0025 + 0.125) - 0.125)
                .collect(),
        ),
        refused(
            "coefficients-uncounted.tdms",
            counts(&with(&[
                (KIND, text("Polynomial")),
                ("NI_Scale[0]_Polynomial_Coefficients[0]", Said::Number(0.0)),
                ("NI_Scale[0]_Polynomial_Coefficients[1]", Said::Number(1.0)),
                ("NI_Scale[0]_Polynomial_Coefficients[2]", Said::Number(0.0)),
                ("NI_Scale[0]_Polynomial_Coefficients[3]", Said::Number(0.0)),
                ("NI_Scale[0]_Polynomial_Coefficients[4]", Said::Number(1.0)),
            ])),
            &["no NI_Scale[0]_Polynomial_Coefficients_Size"],
        ),
        refused(
            "daqmx.tdms",
            LITTLE.segment(DAQMX, Some(&[]), &[1]),
            &["DAQmx", "from nptdms import"],
        ),
        refused(
            "daqmx-index.tdms",
            LITTLE.segment(0, Some(&[LITTLE.object(Y, Raw::Other(0x1269), &[])]), &[1]),
            &["DAQmx"],
        ),
    ]
}

fn units() -> Vec<Case> {
    let unit = |unit: &'static [u8]| file(&[("unit_string", Said::Text(unit)), CLOCK[0], CLOCK[1]]);
    let si = |name: &str, bytes| {
        let values = (FROM..TO).map(push).collect();
        good(name, bytes)
            .channel("acc y")
            .unit("m/s2", |_| "0".into())
            .values(values)
            .finds(&["warning implausible-peak", "warning implausible-velocity"])
            .exit(3)
    };
    let later = [
        file(&CLOCK),
        LITTLE.segment(0, Some(&[LITTLE.object(Y, Raw::Absent, &[G])]), &[]),
    ];
    let changed = [
        file(&with(&[])),
        LITTLE.segment(
            0,
            Some(&[LITTLE.object(Y, Raw::Absent, &[("unit_string", text("m/s^2"))])]),
            &[],
        ),
    ];
    vec![
        si("metres.tdms", unit(b"m/s^2")),
        si("metres-1252.tdms", unit(b"m/s\xB2")),
        refused("no-unit.tdms", file(&CLOCK), &["no unit of acceleration"]),
        read("unit-told.tdms", file(&CLOCK)).options(&["--unit", "g"]),
        refused(
            "volts.tdms",
            unit(b"V"),
            &["by unit or code none is an acceleration", "--sensitivity"],
        ),
        read("volts-told.tdms", unit(b"V"))
            .options(&["--sensitivity", "1 g/V"])
            .finds(&["info sensitivity-used"]),
        read("unit-at-the-end.tdms", later.concat()),
        refused(
            "unit-twice.tdms",
            file(&with(&[("unit_string", text("m/s^2"))])),
            &["`unit_string` once"],
        ),
        refused(
            "unit-twice-in-other-letters.tdms",
            file(&with(&[("Unit_String", text("m/s^2"))])),
            &["once", "`g` and `m/s^2`"],
        ),
        refused(
            "offset-unread.tdms",
            file(&[G, CLOCK[0], ("wf_start_offset", Said::Extended)]),
            &["`wf_start_offset` of another type"],
        ),
        refused(
            "unit-changes.tdms",
            changed.concat(),
            &["one `unit_string`", "after 800 samples"],
        ),
    ]
}

/// Two halves of the recording in segments of their own, the second with properties.
fn halves(first: &[Property<'_>], second: &[Property<'_>]) -> Vec<u8> {
    let half = |raw, said: &[Property<'_>], from, to| {
        let object = LITTLE.object(Y, raw, said);
        LITTLE.segment(0, Some(&[object]), &doubles(LITTLE, from, to))
    };
    [
        half(
            Raw::Numbers(F64, COUNT / 2),
            first,
            FROM,
            FROM + COUNT as i64 / 2,
        ),
        half(Raw::AsBefore, second, FROM + COUNT as i64 / 2, TO),
    ]
    .concat()
}

fn clocks() -> Vec<Case> {
    let increment = |number| ("wf_increment", Said::Number(number));
    let offset = |number| ("wf_start_offset", Said::Number(number));
    let axis = |unit: &'static str| ("wf_xunit_string", text(unit));
    let start = |seconds| ("wf_start_time", Said::Instant(seconds));
    let rate = ["--rate-hz", "10000", "--time-zero", "0.02"];
    let times = |bytes: fn(i64) -> Vec<u8>| (FROM..TO).flat_map(bytes).collect::<Vec<u8>>();
    let seconds = times(|k| (k as f64 / 1e4).to_le_bytes().to_vec());
    let milliseconds = times(|k| (k as f64 / 10.0).to_le_bytes().to_vec());
    let instants = times(|k| LITTLE.instant(3_850_000_000.0 + (k - FROM) as f64 / 1e4));
    let numbers = Raw::Numbers(F64, COUNT);
    let time = |unit: &'static str, data: &[u8], own: &[Property<'_>]| {
        beside(
            "/'Vehicle'/'Time'",
            numbers,
            &[("unit_string", text(unit))],
            data,
            own,
        )
    };
    let slow: Vec<u8> = (FROM..TO)
        .flat_map(|k| (k as f64 / 5e3).to_le_bytes())
        .collect();
    let with_interval = [G, increment(2e-4)];
    let clock_beside = |path: &str, count: u64| {
        let data = &slow[..8 * count as usize];
        beside(path, Raw::Numbers(F64, count), &[], data, &[G])
    };
    let against_rate = |name: &str, bytes| {
        let name = format!("rate-against-{name}");
        let case = read(&name, bytes).options(&rate);
        case.unusable(&["blocking time-contradicted"], &["--rate-hz"])
    };
    let two_clocks_of = |first: &[u8], second: &[u8]| {
        let unit = [("unit_string", text("s"))];
        let objects = [
            LITTLE.object("/'Vehicle'/'Time'", numbers, &unit),
            LITTLE.object("/'Vehicle'/'Timestamp'", numbers, &unit),
            LITTLE.object(Y, numbers, &with(&[])),
        ];
        let data = [first, second, &doubles(LITTLE, FROM, TO)].concat();
        LITTLE.segment(0, Some(&objects), &data)
    };
    let two_clocks = {
        let objects = [
            LITTLE.object("/'Vehicle'/'Time'", numbers, &[("unit_string", text("s"))]),
            LITTLE.object(
                "/'Vehicle'/'Timestamp'",
                numbers,
                &[("unit_string", text("s"))],
            ),
            LITTLE.object(Y, numbers, &[G]),
        ];
        let data = [&slow[..], &seconds, &doubles(LITTLE, FROM, TO)].concat();
        LITTLE.segment(0, Some(&objects), &data)
    };
    vec![
        read(
            "ms.tdms",
            file(&[G, increment(0.1), offset(-20.0), axis("ms")]),
        ),
        read("ms-told.tdms", file(&[G, increment(0.1), offset(-20.0)]))
            .options(&["--time-unit", "ms"]),
        refused(
            "spectrum.tdms",
            file(&[G, increment(10.0), axis("Hz")]),
            &["samples over time", "wf_xunit_string `Hz`"],
        ),
        refused(
            "spectrum-by-name.tdms",
            file(&[G, increment(10.0), ("wf_xname", text("Frequency"))]),
            &["wf_xname `Frequency`"],
        ),
        refused(
            "no-clock.tdms",
            file(&[G]),
            &["no time column and no sample rate"],
        ),
        read("rate-told.tdms", file(&[G])).options(&rate),
        refused(
            "increment-0.tdms",
            file(&[G, increment(0.0)]),
            &["no time column and no sample rate"],
        ),
        refused(
            "increment-below-0.tdms",
            file(&[G, increment(-1e-4)]),
            &["wf_increment `-0.0001`"],
        ),
        refused(
            "increment-nan.tdms",
            file(&[G, increment(f64::NAN)]),
            &["wf_increment `NaN`"],
        ),
        refused(
            "rate-contradicted.tdms",
            file(&with(&[])),
            &["the stated rate of 5000 Hz", "10000 Hz by wf_increment"],
        )
        .options(&["--rate-hz", "5000"]),
        // A rate that a person states is held against each clock of the file.
        against_rate(
            "clock-beside.tdms",
            clock_beside("/'Vehicle'/'Time'", COUNT - 1),
        ),
        against_rate(
            "clock-of-another-group.tdms",
            clock_beside("/'Clock'/'Time'", COUNT),
        ),
        against_rate(
            "interval-beside.tdms",
            beside(X, numbers, &with_interval, &slow, &[G]),
        )
        .finds(&["info channel-chosen"]),
        against_rate("interval-of-the-group.tdms", {
            let objects = [
                LITTLE.object("/'Vehicle'", Raw::Absent, &[increment(2e-4)]),
                LITTLE.object(Y, numbers, &[G]),
            ];
            LITTLE.segment(0, Some(&objects), &doubles(LITTLE, FROM, TO))
        }),
        read(
            "rate-as-interval-beside.tdms",
            beside(X, numbers, &with(&[]), &slow, &[G]),
        )
        .options(&rate)
        .finds(&["info channel-chosen"]),
        read(
            "rate-against-starts.tdms",
            halves(&[G, start(3.8e9)], &[start(3.8e9 + 0.08)]),
        )
        .options(&rate)
        .unusable(&["blocking gap"], &["nother `wf_start_time`"]),
        read("untimed.tdms", file(&[G, increment(1.0)]))
            .options(&rate)
            .finds(&["warning timing-absent"]),
        refused(
            "increment-changes.tdms",
            halves(&with(&[]), &[increment(2e-4)]),
            &["one `wf_increment`", "`0.0002` after 400 samples"],
        ),
        read(
            "starts-differ.tdms",
            beside(
                X,
                numbers,
                &with(&[start(3.8e9)]),
                &doubles(LITTLE, FROM, TO),
                &with(&[start(3.8e9 + 0.035)]),
            ),
        )
        .finds(&["info channel-chosen", "warning starts-differ"]),
        read(
            "goes-on.tdms",
            halves(&with(&[start(3.8e9)]), &[start(3.8e9 + 0.04)]),
        ),
        read(
            "restarts.tdms",
            halves(&with(&[start(3.8e9)]), &[start(3.8e9 + 0.05)]),
        )
        .unusable(&["blocking gap"], &["nother `wf_start_time`"]),
        // A pause is judged in the unit of the interval, also where it is stated behind the instants.
        read(
            "goes-on-ms.tdms",
            halves(
                &[G, increment(0.1), offset(-20.0), axis("ms"), start(3.8e9)],
                &[start(3.8e9 + 0.04)],
            ),
        ),
        read(
            "restarts-ms.tdms",
            halves(
                &[G, start(3.8e9), increment(0.1), offset(-20.0), axis("ms")],
                &[start(3.8e9 + 40.0)],
            ),
        )
        .unusable(&["blocking gap"], &["nother `wf_start_time`"]),
        read(
            "starts-alike.tdms",
            halves(&with(&[start(3.8e9)]), &[start(3.8e9)]),
        ),
        refused(
            "scaled-stamps.tdms",
            beside(
                "/'Vehicle'/'Time'",
                numbers,
                &[&[("unit_string", text("s")), ONE_SCALE], &LINEAR[..]].concat(),
                &seconds,
                &[G],
            ),
            &["times and flags without a scale"],
        ),
        refused(
            "scaled-stamps-beside-increment.tdms",
            beside(
                "/'Vehicle'/'Time'",
                numbers,
                &[&[("unit_string", text("s")), ONE_SCALE], &LINEAR[..]].concat(),
                &seconds,
                &with(&[]),
            ),
            &["times and flags without a scale"],
        ),
        read(
            "two-clocks-against-increment.tdms",
            two_clocks_of(&slow, &slow),
        )
        .unusable(&["blocking time-contradicted"], &["wf_increment"]),
        read(
            "two-clocks-with-increment.tdms",
            two_clocks_of(&seconds, &seconds),
        ),
        read(
            "shorter-clock-against-increment.tdms",
            beside(
                "/'Vehicle'/'Time'",
                Raw::Numbers(F64, COUNT - 1),
                &[("unit_string", text("s"))],
                &slow[8..],
                &with(&[]),
            ),
        )
        .unusable(&["blocking time-contradicted"], &["wf_increment"]),
        read(
            "clock-of-another-group-against-increment.tdms",
            beside(
                "/'Clock'/'Time'",
                numbers,
                &[("unit_string", text("s"))],
                &slow,
                &with(&[]),
            ),
        )
        .unusable(&["blocking time-contradicted"], &["wf_increment"]),
        read("stamps.tdms", time("s", &seconds, &[G])),
        read("stamps-ms.tdms", time("ms", &milliseconds, &[G])),
        read("stamps-assumed.tdms", time("", &seconds, &[G])),
        read("stamps-and-increment.tdms", time("s", &seconds, &with(&[]))),
        read(
            "stamps-against-increment.tdms",
            time("s", &slow, &with(&[])),
        )
        .unusable(&["blocking time-contradicted"], &["wf_increment"]),
        read(
            "instants.tdms",
            beside(
                "/'Vehicle'/'Stamp'",
                Raw::Numbers(INSTANT, COUNT),
                &[],
                &instants,
                &[G],
            ),
        )
        .options(&["--time-zero", "0.02"]),
        refused(
            "two-clocks.tdms",
            two_clocks.clone(),
            &["one channel of times", "Time, Timestamp"],
        ),
        read("clock-told.tdms", two_clocks).options(&["--time-column", "Timestamp"]),
        refused(
            "short-clock.tdms",
            beside(
                "/'Vehicle'/'Time'",
                Raw::Numbers(F64, 10),
                &[],
                &seconds[..80],
                &[G],
            ),
            &["no time column and no sample rate"],
        ),
    ]
}

fn layouts() -> Vec<Case> {
    let own = with(&[]);
    let in_order = |bytes: Bytes| {
        let objects = [
            bytes.object(X, Raw::Numbers(F32, COUNT), &own),
            bytes.object(Y, Raw::Numbers(F64, COUNT), &own),
        ];
        let first = (FROM..TO).flat_map(|k| bytes.ordered((k as f32).to_le_bytes()));
        let data = [first.collect(), doubles(bytes, FROM, TO)].concat();
        bytes.segment(0, Some(&objects), &data)
    };
    let taking_turns = |bytes: Bytes| {
        let objects = [
            bytes.object(X, Raw::Numbers(F32, 100), &own),
            bytes.object(Y, Raw::Numbers(F64, 100), &own),
        ];
        let row = |k: i64| {
            let first = bytes.ordered((k as f32).to_le_bytes());
            [first, bytes.ordered(push(k).to_le_bytes())].concat()
        };
        let rows = |from: i64, to: i64| (from..to).flat_map(row).collect::<Vec<u8>>();
        [
            bytes.segment(INTERLEAVED, Some(&objects), &rows(FROM, TO - 100)),
            bytes.segment(INTERLEAVED, None, &rows(TO - 100, TO)),
        ]
        .concat()
    };
    let many = {
        let object = LITTLE.object(Y, Raw::Numbers(F64, 10), &own);
        let mut bytes = LITTLE.segment(0, Some(&[object]), &doubles(LITTLE, FROM, FROM + 10));
        for k in (FROM + 10..TO).step_by(10) {
            // Every other one in the other order of bytes.
            let order = if k % 20 == 0 { BIG } else { LITTLE };
            bytes.extend(order.segment(0, None, &doubles(order, k, k + 10)));
        }
        bytes
    };
    let whole = file(&own);
    let list_twice = {
        let object = LITTLE.object(Y, Raw::Numbers(F64, COUNT / 2), &own);
        LITTLE.segment(
            0,
            Some(&[object.clone(), object]),
            &doubles(LITTLE, FROM, TO),
        )
    };
    let object = |raw| {
        LITTLE.segment(
            0,
            Some(&[LITTLE.object(Y, raw, &own)]),
            &doubles(LITTLE, FROM, TO),
        )
    };
    let retyped = [whole.clone(), object(Raw::Numbers(F32, COUNT))].concat();
    let unclosed = {
        let object = LITTLE.object(Y, Raw::Numbers(F64, COUNT), &own);
        LITTLE.with_end(0, Some(&[object]), &doubles(LITTLE, FROM, TO - 50), |_| {
            u64::MAX
        })
    };
    let with_byte = |at: usize, byte: u8| {
        let mut bytes = whole.clone();
        bytes[at] = byte;
        bytes
    };
    let cut = |name: &str, bytes: &[u8], samples: i64| {
        read(name, bytes.to_vec())
            .values((FROM..FROM + samples).map(push).collect())
            .unusable(
                &["blocking samples-missing"],
                &["ends before its last segment"],
            )
    };
    let two = halves(&own, &[]);
    let half = two.len() - 400 * 8;
    let first_half = memchr::memmem::rfind(&two, b"TDSm").unwrap();
    vec![
        read("plain.tdms", whole.clone()),
        read("renamed.dat", whole.clone()),
        read("big-endian.tdms", in_order(BIG)).finds(&["info channel-chosen"]),
        read("interleaved.tdms", taking_turns(LITTLE)).finds(&["info channel-chosen"]),
        read("interleaved-big-endian.tdms", taking_turns(BIG)).finds(&["info channel-chosen"]),
        read("many-segments.tdms", many),
        read("two-halves.tdms", two.clone()),
        cut("cut.tdms", &whole[..whole.len() - 403], 749),
        cut("cut-in-list.tdms", &two[..half - 20], 400).finds(&["warning ends-early"]),
        cut("cut-in-lead-in.tdms", &two[..first_half + 20], 400).finds(&["warning ends-early"]),
        cut("unclosed.tdms", &unclosed, 750),
        refused("cut-in-first-list.tdms", &whole[..60], &["cut or damaged"]),
        refused(
            "tail.tdms",
            [&whole[..], &[0; 40]].concat(),
            &["begins with TDSm"],
        ),
        refused(
            "uneven.tdms",
            {
                let object = LITTLE.object(Y, Raw::Numbers(F64, COUNT), &own);
                LITTLE.segment(0, Some(&[object]), &doubles(LITTLE, FROM, TO - 1))
            },
            &["whole chunks of 6400 bytes"],
        ),
        refused("flags.tdms", with_byte(5, 1), &["the flags of TDMS"]),
        refused(
            "version.tdms",
            with_byte(8, 0x6A),
            &["version 4712 or 4713"],
        ),
        refused(
            "as-before-first.tdms",
            object(Raw::AsBefore),
            &["none before"],
        ),
        refused("listed-twice.tdms", list_twice, &["each object once"]),
        refused("retyped.tdms", retyped, &["one type of data"]),
        refused(
            "extended.tdms",
            object(Raw::Numbers(11, COUNT)),
            &["double precision"],
        ),
        refused(
            "unknown-type.tdms",
            object(Raw::Numbers(77, COUNT)),
            &["a type 0x4d"],
        ),
    ]
}

/// The recording under a property of its own, of its group or of the file.
fn under(path: &str, said: Property<'_>) -> Vec<u8> {
    if path == Y {
        return file(&with(&[said]));
    }
    let objects = [
        LITTLE.object(path, Raw::Absent, &[said]),
        LITTLE.object(Y, Raw::Numbers(F64, COUNT), &with(&[])),
    ];
    LITTLE.segment(0, Some(&objects), &doubles(LITTLE, FROM, TO))
}

/// A property that says that samples are not good.
fn parent(path: &str, said: Property<'_>) -> Case {
    let name = format!("bad-{}.tdms", said.0);
    let says = format!("`{}`", said.0);
    read(&name, under(path, said)).unusable(&["blocking invalid-by-laboratory"], &[&says])
}

fn faults() -> Vec<Case> {
    let with_sample = |value: f64| {
        let mut bytes = file(&with(&[]));
        let at = bytes.len() - 100 * 8;
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    let mut filled = pushes();
    filled[700] = filled[699];
    let said = |key: &'static str, word: &'static str| file(&with(&[(key, text(word))]));
    let flags: Vec<u8> = (FROM..TO).map(|k| u8::from(k >= 300)).collect();
    let flagged = |name: &str| beside(name, Raw::Numbers(I8, COUNT), &[], &flags, &with(&[]));
    let words = |words: &[&str]| {
        let mut end = 0_u32;
        let ends = words.iter().flat_map(|word| {
            end += u32::try_from(word.len()).unwrap();
            end.to_le_bytes()
        });
        let data = [ends.collect::<Vec<u8>>(), words.concat().into_bytes()].concat();
        let raw = Raw::Texts(words.len() as u64, data.len() as u64);
        beside("/'Vehicle'/'Comment'", raw, &[], &data, &with(&[]))
    };
    let extremes = |low, high| {
        let said = [
            ("minimum", Said::Number(low)),
            ("maximum", Said::Number(high)),
        ];
        file(&with(&said))
    };
    let least = pushes().into_iter().fold(f64::MAX, f64::min);
    let largest = pushes().into_iter().fold(f64::MIN, f64::max);
    vec![
        read("nan.tdms", with_sample(f64::NAN))
            .values(filled)
            .unusable(&["blocking gap"], &["sample 701"]),
        refused(
            "infinite.tdms",
            with_sample(f64::INFINITY),
            &["inf as sample 701"],
        ),
        read("described.tdms", said("description", "B-pillar, lower"))
            .finds(&["info laboratory-remark"]),
        read("failed.tdms", said("description", "sensor failed")).unusable(
            &["blocking laboratory-remark"],
            &["\"failed\" is a fault word"],
        ),
        read("status.tdms", said("status", "ok")),
        read("bad-status.tdms", said("Data status", "questionable")).unusable(
            &["blocking invalid-by-laboratory"],
            &["`Data status` states \"questionable\""],
        ),
        read("nhtsa-status.tdms", said("DASTAT", "AM")),
        read("nhtsa-bad-status.tdms", said("DASTAT", "CF")).unusable(
            &["blocking invalid-by-laboratory"],
            &["`DASTAT` states \"CF\""],
        ),
        read("filtered.tdms", said("Channel frequency class", "CFC 60"))
            .finds(&["warning already-filtered", "info laboratory-remark"]),
        read("flags.tdms", flagged("/'Vehicle'/'overload'")).unusable(
            &["blocking invalid-by-laboratory", "info channel-chosen"],
            &["`overload` says 1 from sample 501"],
        ),
        read("flags-of-doubles.tdms", {
            let flags: Vec<u8> = (FROM..TO)
                .flat_map(|k| f64::from(u8::from(k >= 300)).to_le_bytes())
                .collect();
            let raw = Raw::Numbers(F64, COUNT);
            beside("/'Vehicle'/'overload'", raw, &[], &flags, &with(&[]))
        })
        .unusable(
            &["blocking invalid-by-laboratory", "info channel-chosen"],
            &["`overload` says 1 from sample 501"],
        ),
        read(
            "flags-of-another-group.tdms",
            flagged("/'Status'/'acc y overload'"),
        )
        .unusable(
            &["blocking invalid-by-laboratory", "info channel-chosen"],
            &["says 1 from sample 501"],
        ),
        read(
            "flags-alone-in-a-group.tdms",
            flagged("/'Status'/'overload'"),
        )
        .unusable(
            &["blocking invalid-by-laboratory", "info channel-chosen"],
            &["says 1 from sample 501"],
        ),
        read("flags-with-a-scale.tdms", {
            let raw = Raw::Numbers(I8, COUNT);
            let said = [&[ONE_SCALE], &LINEAR[..]].concat();
            let flags = vec![0; COUNT as usize];
            beside("/'Vehicle'/'overload'", raw, &said, &flags, &with(&[]))
        })
        .unusable(
            &["blocking invalid-by-laboratory", "info channel-chosen"],
            &["could not be read"],
        ),
        parent("/'Vehicle'", ("overload", Said::Count(1))),
        parent("/", ("valid", Said::Count(0))),
        parent("/'Vehicle'", ("DASTAT", text("NO"))),
        parent(Y, ("IsOverloaded", Said::Count(1))),
        read(
            "filtered-group.tdms",
            under("/'Vehicle'", ("Channel frequency class", text("CFC 60"))),
        )
        .finds(&["warning already-filtered", "info laboratory-remark"]),
        read(
            "filtered-by-number.tdms",
            under("/", ("CFC", Said::Count(60))),
        )
        .finds(&["warning already-filtered", "info laboratory-remark"]),
        read("flags-of-another.tdms", {
            let objects = [
                LITTLE.object(X, Raw::Numbers(F64, COUNT), &with(&[])),
                LITTLE.object("/'Vehicle'/'acc x overload'", Raw::Numbers(I8, COUNT), &[]),
                LITTLE.object(Y, Raw::Numbers(F64, COUNT), &with(&[])),
            ];
            let samples = doubles(LITTLE, FROM, TO);
            LITTLE.segment(
                0,
                Some(&objects),
                &[&samples[..], &flags, &samples].concat(),
            )
        })
        .finds(&["info channel-chosen"]),
        read("words.tdms", words(&["ready", "", "end"])).finds(&["info laboratory-remark"]),
        read("words-of-a-fault.tdms", words(&["ready", "signal lost"])).unusable(
            &["blocking laboratory-remark", "info laboratory-remark"],
            &["signal lost"],
        ),
        read("extremes.tdms", extremes(least, largest)),
        read(
            "extremes-contradicted.tdms",
            extremes(least / 9.80665, largest / 9.80665),
        )
        .unusable(&["blocking peak-contradicted"], &["inimum in the header"]),
        read(
            "fewer.tdms",
            file(&with(&[("wf_samples", Said::Number(900.0))])),
        )
        .unusable(&["blocking samples-missing"], &["`wf_samples` states 900"]),
        read(
            "rate-in-words.tdms",
            file(&with(&[
                ("SampleRate", text("10 kHz")),
                ("FS", Said::Number(2000.0)),
            ])),
        ),
        read(
            "rate-in-words-rounded.tdms",
            file(&with(&[("SampleRate", Said::Number(9950.0))])),
        )
        .finds(&["warning time-differs"]),
        read(
            "rate-in-words-contradicted.tdms",
            beside(
                "/",
                Raw::Absent,
                &[("Sample rate", Said::Number(2e4))],
                &[],
                &with(&[]),
            ),
        )
        .unusable(
            &["blocking time-contradicted"],
            &["`Sample rate` of the file is 20000"],
        ),
        read(
            "interval-in-words-contradicted.tdms",
            file(&with(&[("dt", Said::Number(1e-5))])),
        )
        .unusable(&["blocking time-contradicted"], &["`dt` of the channel"]),
    ]
}

fn names() -> Vec<Case> {
    let two = |first: &str, second: &str| {
        let objects = [
            LITTLE.object(first, Raw::Numbers(F64, COUNT), &with(&[])),
            LITTLE.object(second, Raw::Numbers(F64, COUNT), &with(&[])),
        ];
        let data = [vec![0; 8 * COUNT as usize], doubles(LITTLE, FROM, TO)].concat();
        LITTLE.segment(0, Some(&objects), &data)
    };
    let one = |path: &str| {
        let object = LITTLE.object(path, Raw::Numbers(F64, COUNT), &with(&[]));
        LITTLE.segment(0, Some(&[object]), &doubles(LITTLE, FROM, TO))
    };
    vec![
        read("quoted.tdms", one("/'door ''2'' left'/'acc y'")),
        read("coded.tdms", one("/'07292'/'11DOORLE0000ACYP'")).channel("11DOORLE0000ACYP"),
        refused("dummy.tdms", one("/'Driver dummy'/'acc y'"), &["`driver`"]),
        refused(
            "occupant-word.tdms",
            one("/'WorldSID'/'acc y'"),
            &["`world`"],
        ),
        refused("driver.tdms", one("/'Driver'/'acc y'"), &["`driver`"]),
        refused("pelvis.tdms", one("/'Pelvis'/'acc y'"), &["`pelvis`"]),
        refused("es-2re.tdms", one("/'ES-2re'/'acc y'"), &["`es`"]),
        refused("insasse.tdms", one("/'Insasse'/'acc y'"), &["`insasse`"]),
        refused("pendulum.tdms", one("/'Pendulum'/'acc y'"), &["`pendulum`"]),
        refused("raw-counts.tdms", one("/'Raw counts'/'acc y'"), &["acc y"]),
        refused(
            "integrated.tdms",
            one("/'Integrated'/'acc y'"),
            &["`integrated`"],
        ),
        read("driver-told.tdms", one("/'Driver'/'acc y'"))
            .options(&["--channel", "acc y"])
            .finds(&["warning channel-not-lateral"]),
        read("test-number.tdms", one("/'V07292'/'acc y'")),
        read("measurement.tdms", one("/'Measurement 2'/'acc y'")),
        read(
            "dummy-and-door.tdms",
            two("/'Dummy'/'acc y'", "/'Door'/'acc y'"),
        )
        .channel("Door/acc y")
        .finds(&["info channel-chosen"]),
        refused(
            "same-names.tdms",
            two("/'Door'/'acc y'", "/'Sill'/'acc y'"),
            &["Door/acc y", "Sill/acc y"],
        ),
        read(
            "same-names-told.tdms",
            two("/'Door'/'acc y'", "/'Sill'/'acc y'"),
        )
        .channel("Sill/acc y")
        .options(&["--channel", "Sill/acc y"]),
        refused(
            "bad-path.tdms",
            one("/'Door/'acc y'"),
            &["a path as /'group'/'channel'"],
        ),
    ]
}

pub(super) fn cases() -> Vec<Case> {
    [layouts(), scales(), units(), clocks(), faults(), names()]
        .into_iter()
        .flatten()
        .collect()
}
