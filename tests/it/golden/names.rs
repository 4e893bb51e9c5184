//! What names say: computed columns, places off the structure, filters, and what spoils a unit.

use super::{Case, FROM, TO, g, good, refused, s};

/// A table of stamps and as many equal columns as the header has names beside the time.
fn table(head: &str) -> String {
    let line = head.lines().next().unwrap_or_default();
    let columns = line.split(',').count() - 1;
    let rows: String = (FROM..TO)
        .map(|k| {
            let cells = vec![g(k); columns].join(",");
            format!("{},{cells}\n", s(k))
        })
        .collect();
    format!("{head}\n{rows}")
}

/// A LabVIEW file of one channel.
fn labview(name: &str, unit: &str) -> String {
    let rows: String = (FROM..TO).map(|k| format!("\t{}\n", g(k))).collect();
    format!(
        "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\n\
         Decimal_Separator\t.\nMulti_Headings\tNo\nX_Columns\tNo\nTime_Pref\tRelative\n\
         ***End_of_Header***\t\n\nChannels\t1\t\nSamples\t800\t\nY_Unit_Label\t{unit}\t\n\
         X_Dimension\tTime\t\nX0\t-0.02\t\nDelta_X\t0.0001\t\n***End_of_Header***\t\n\
         X_Value\t{name}\tComment\n{rows}"
    )
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = computed();
    cases.extend(plausible());
    cases.extend(places());
    cases.extend(filters());
    cases.extend(units());
    cases
}

/// Each name alone is refused, with its neighbours as well, and read with a warning if asked for.
fn never_unasked(kind: &str, names: &[&str]) -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let alone = table(&format!("time_s,{name}"));
        cases.push(refused(
            &format!("{kind}-{index}.csv"),
            alone,
            &["--channel", name],
        ));
    }
    for (index, name) in names.iter().enumerate().step_by(7) {
        let pair = table(&format!("time_s,acc (g),{name}"));
        cases.push(refused(
            &format!("{kind}-beside-{index}.csv"),
            pair,
            &["--channel", name],
        ));
        cases.push(
            good(
                &format!("{kind}-asked-{index}.csv"),
                table(&format!("time_s,acc_z (g),{name}")),
            )
            .options(&["--channel", "3"])
            .channel(name)
            .finds(&["warning channel-not-lateral"]),
        );
    }
    cases
}

fn computed() -> Vec<Case> {
    let mut cases = never_unasked(
        "computed",
        &[
            "|ay| (g)",
            "abs(ay) (g)",
            "acc res (g)",
            "acceleration magnitude (g)",
            "a_res_y (g)",
            "acc y peak (g)",
            "ay_max (g)",
            "ay min (g)",
            "acc y peak hold (g)",
            "ay rms (g)",
            "ay std (g)",
            "ay error (g)",
            "ay target (g)",
            "ay limit (g)",
            "ay model (g)",
            "ay simulated (g)",
            "ay_sim (g)",
            "acc y CAE (g)",
            "acc y PSD (g)",
            "acc y FFT (g)",
            "acc y spectrum (g)",
            "ay derivative (g)",
            "jerk y (g)",
            "ay1-ay2 (g)",
            "acc y left - acc y right (g)",
            "ay diff (g)",
            "ay mean (g)",
            "acc y average (g)",
            "vel_y (g)",
            "mass (g)",
            "ay envelope (g)",
            "ayabs (g)",
            "maxaccy (g)",
            "-ay (g)",
            "ay inverted (g)",
            "Beschl. quer Betrag [g]",
            "Mittelwert ay [g]",
            "ay Maximum [g]",
            "Effektivwert ay [g]",
            "ay Fehler [g]",
            "Ableitung ay [g]",
            "Summe ay [g]",
        ],
    );
    // Places with a hyphen, numbers, and one thing said twice.
    for (index, name) in [
        "A-pillar a y (g)",
        "B-Pillar acc-y (g)",
        "B pillar lateral acceleration Y (g)",
        "Accelerometer #2 y axis (g)",
    ]
    .iter()
    .enumerate()
    {
        let text = table(&format!("time_s,{name}"));
        cases.push(good(&format!("not-computed-{index}.csv"), text).channel(name));
    }
    cases.extend([
        good(
            "raw-before-computed.csv",
            table("time_s,ay (g),ay_max (g),|ay| (g),ares (g)"),
        )
        .channel("ay (g)")
        .finds(&["info channel-chosen"]),
        refused(
            "computed.lvm",
            labview("|acc y|", "g"),
            &["|acc y|", "--channel"],
        ),
        good("computed-asked.lvm", labview("|acc y|", "g"))
            .options(&["--channel", "|acc y|"])
            .channel("|acc y|")
            .finds(&["warning channel-not-lateral"]),
    ]);
    cases
}

/// Names that laboratories and loggers give to channels that may well be the one. `+` is taken;
/// of the others each is offered with the word that raises the doubt, and read where it is chosen.
const PLAUSIBLE: &str = "
+ ay [g]
+ a_y [g]
+ acc y [g]
+ acc_y [g]
+ accel_y [g]
+ Accel Y [g]
+ accY [g]
+ lateral acceleration [g]
+ Lateral Acc [g]
+ G Lat [g]
+ g_lat [g]
+ Y [g]
+ Door Y [g]
+ Left front door Y [g]
+ Door inner panel Y [g]
+ Door sill Y right [g]
+ B-pillar Y [g]
+ B pillar lower lateral [g]
+ C Pillar Y [g]
+ Vehicle CG Y [g]
+ Center of gravity lateral [g]
+ Rear floor Y 2 [g]
+ Struck side sill Y [g]
+ Latch lock Y [g]
+ Tunnel acc y [g]
+ Beschl. B-Säule quer [g]
+ Tür links vorn Beschleunigung Y [g]
+ Schweller rechts a y [g]
+ DSLF YG [g]
+ door handle y [g]
+ ch 3 acc y [g]
striker: Door striker Y [g]
striker: Latch striker acc y [g]
window: Window motor Y [g]
head: Head restraint Y [g]
knee: Knee bolster Y [g]
chest: Chest-level door Y [g]
pelvis: Pelvis-level door Y [g]
shoulder: Door panel shoulder level Y [g]
hip: Hip point area door Y [g]
pole: Struck side pole Y [g]
impact: B pillar at pole impact Y [g]
status: Lock status side Y [g]
module: Door module norm Y [g]
mass: Latch mass Y [g]
model: Model 7264 Y [g]
ref: Ref 12 Y [g]
t1: T1 Y acceleration
max: Max 2000 g Y
min: Door Y min range
force: G Force Lat
motor: Mirror motor Y [g]
engine: Engine side Y [g]
seat: Seat crossmember Y [g]
driver: Driver door Y [g]
passenger: Passenger side B-pillar Y [g]
opposite: Opposite sill Y [g]
far: Far side rocker Y [g]
non: Non struck side door Y [g]
battery: Battery tray Y [g]
hinge: Upper hinge Y [g]
mirror: Mirror base Y [g]
acc1: kanal 7 Y [g]
dummy: Dummy head Y [g]
barrier: Barrier Y [g]
resultant: Resultant door Y [g]
computed: Y computed [g]
x: Door X [g]
";

/// Names with a word or sign that is on no list: offered, where a list of bad words took them.
const DOUBTED: [&str; 14] = [
    "acc y minivan (g)",
    "acc y standard (g)",
    "acc y meaning (g)",
    "Lateral acceleration - ay (g)",
    "driver door ay (g)",
    "passenger side sill acc y (g)",
    "poleward ay (g)",
    "T13 acc y (g)",
    "acc y* CFC=60 (g)",
    "acc y* N=60 (g)",
    "ay not filtered (g)",
    "acc y X1 (g)",
    "acc_y X1 [g]",
    "B-pillar E y (g)",
];

fn plausible() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, name) in DOUBTED.iter().enumerate() {
        let text = table(&format!("time_s,{name}"));
        let says = ["each with its doubt", name, "--channel"];
        cases.push(refused(&format!("doubted-{index}.csv"), text, &says));
    }
    for (index, line) in PLAUSIBLE
        .lines()
        .filter(|line| !line.is_empty())
        .enumerate()
    {
        let file = |kind: &str| format!("plausible-{kind}{index}.csv");
        if let Some(name) = line.strip_prefix("+ ") {
            let text = table(&format!("time_s,{name}"));
            cases.push(good(&file(""), text).channel(name));
            continue;
        }
        let name = line.split_once(": ").unwrap().1;
        let text = table(&format!("time_s,acc x [g],{name}"));
        let choose = format!("--channel '{name}'");
        cases.push(refused(
            &file(""),
            text.clone(),
            &["each with its doubt", name, &choose],
        ));
        cases.push(
            good(&file("chosen-"), text)
                .options(&["--channel", name, "--unit", "g"])
                .channel(name)
                .finds(&["warning channel-not-lateral"]),
        );
    }
    cases
}

fn places() -> Vec<Case> {
    let mut cases = never_unasked(
        "place",
        &[
            "11PELV0000ESACY0 [g]",
            "11HEAD0000ESACYA (g)",
            "11SPIN1200ESACYC [g]",
            "11CHST0000ESACYC [g]",
            "11THSP0100ESACYC [g]",
            "B0BARR000000ACYD (g)",
            "14BPILLE0000ACXD (g)",
            "14BPILLE0000VEY0 (g)",
            "T1 acc y (g)",
            "T12 Y acceleration g",
            "ES2 ay (g)",
            "ES-2re ay (g)",
            "WorldSID ay (g)",
            "SID pelvis y (g)",
            "ATD ay (g)",
            "Hybrid III ay (g)",
            "occupant ay (g)",
            "driver head ay (g)",
            "passenger ay (g)",
            "sternum acc y (g)",
            "hip ay (g)",
            "thorax ay (g)",
            "femur ay (g)",
            "sled acc y (g)",
            "trolley ay (g)",
            "impactor ay (g)",
            "bullet ay (g)",
            "pole ay (g)",
            "engine ay (g)",
            "helmet ay (g)",
            "far side ay (g)",
            "Schlitten ay (g)",
        ],
    );
    for (index, name) in [
        "left front door ay (g)",
        "struck side sill acc y (g)",
        "Centre of gravity Y [g]",
        "DSRF YG (g)",
    ]
    .iter()
    .enumerate()
    {
        let text = table(&format!("time_s,{name}"));
        cases.push(good(&format!("structure-{index}.csv"), text).channel(name));
    }
    cases.extend([
        refused(
            "sled-beside-pillar.csv",
            table("time_s,B-pillar (g),sled ay (g)"),
            &["no channel", "--channel"],
        ),
        good(
            "code.csv",
            table("time_s,11PELV0000ESACY0 (g),14BPILLE0000ACY0 (g)"),
        )
        .channel("14BPILLE0000ACY0 (g)")
        .finds(&["info channel-chosen"]),
        good("code-diverges.csv", table("time_s,14BPILLE0000AC20 (g)"))
            .channel("14BPILLE0000AC20 (g)")
            .finds(&["warning sign-diverges"]),
        refused(
            "place.lvm",
            labview("sled acc y", "g"),
            &["sled acc y", "--channel"],
        ),
    ]);
    cases
}

fn filters() -> Vec<Case> {
    let mut cases = Vec::new();
    for (index, (name, severity)) in [
        ("ay CFC60 (g)", "warning"),
        ("ay CFC 180 (g)", "warning"),
        ("ay_cfc_600 (g)", "warning"),
        ("ay SAE 60 (g)", "warning"),
        ("ay (g) (CFC1000)", "info"),
        ("ay filtered (g)", "warning"),
        ("Beschl. quer gefiltert [g]", "warning"),
        ("14BPILLE0000ACYD (g)", "warning"),
        ("14BPILLE0000ACYA (g)", "info"),
    ]
    .iter()
    .enumerate()
    {
        let finding = format!("{severity} already-filtered");
        cases.push(
            good(
                &format!("filtered-{index}.csv"),
                table(&format!("time_s,{name}")),
            )
            .channel(name)
            .finds(&[&finding]),
        );
    }
    for (index, name) in ["ay unfiltered (g)", "ay raw (g)"].iter().enumerate() {
        let text = table(&format!("time_s,{name}"));
        cases.push(good(&format!("unfiltered-{index}.csv"), text).channel(name));
    }
    for (index, (first, second)) in [
        ("B-Pillar [g]", "B-Pillar quer CFC60 [g]"),
        ("door raw [g]", "door y filtered [g]"),
        ("14BPILLE0000ACY0 (g)", "14BPILLE0000ACYD (g)"),
        ("acc_y_red (g)", "acc_y_cfc60 (g)"),
        ("ay (g)", "ay CFC60 (g)"),
    ]
    .iter()
    .enumerate()
    {
        cases.push(refused(
            &format!("raw-and-filtered-{index}.csv"),
            table(&format!("time_s,{first},{second}")),
            &["several channels", first, second],
        ));
    }
    cases.extend([
        // The third may be the second without its filter, whatever its axis is called.
        refused(
            "filtered-of-three.csv",
            table("time_s,acc_x_cfc60 (g),acc_y_cfc60 (g),acc_z (g)"),
            &["several channels", "acc_y_cfc60 (g)", "--channel"],
        ),
        good("filtered.lvm", labview("acc y CFC60", "g"))
            .channel("acc y CFC60")
            .finds(&["warning already-filtered"]),
    ]);
    cases
}

fn units() -> Vec<Case> {
    // Counts need more than a unit.
    let way_on = |name: &str| match ["counts", "LSB", "mV"]
        .iter()
        .any(|word| name.contains(word))
    {
        true => "--sensitivity",
        false => "--unit",
    };
    let mut cases = Vec::new();
    for (index, name) in [
        "ay x10 (g)",
        "ay x2 (g)",
        "ay % of FS 1000 (g)",
        "ay kilo (m/s2)",
        "ay counts (m/s2)",
        "ay LSB (m/s2)",
        "ay div 10 (g)",
        "ay E3 (g)",
        "ay 1e3 (g)",
        "ay k (g)",
        "ay thousand (g)",
        "ay gain 10 (g)",
        "ay FS 200 (g)",
    ]
    .iter()
    .enumerate()
    {
        let text = table(&format!("time_s,{name}"));
        let file = |kind: &str| format!("spoilt-unit-{kind}{index}.csv");
        cases.push(refused(&file(""), text.clone(), &[name, "--channel"]));
        let told = ["unit of acceleration", way_on(name)];
        cases.push(refused(&file("told-"), text, &told).options(&["--channel", "2"]));
    }
    for (index, name) in [
        "ay x10",
        "ay (x10)",
        "ay counts",
        "ay mV/g",
        "acc y (100 g)",
        "ay % of FS",
    ]
    .iter()
    .enumerate()
    {
        let text = table(&format!("time,{name}\ns,g"));
        let file = |kind: &str| format!("spoilt-row-{kind}{index}.csv");
        cases.push(refused(&file(""), text.clone(), &["--channel"]));
        let told = ["unit of acceleration", way_on(name)];
        cases.push(refused(&file("told-"), text, &told).options(&["--channel", "2"]));
    }
    cases.push(refused(
        "contradicted-row.csv",
        table("time,acc y (V)\ns,g"),
        &["none is an acceleration", "--sensitivity"],
    ));
    for (index, name) in ["acc y", "acc y (2)", "ay 2"].iter().enumerate() {
        let text = table(&format!("time,{name}\ns,g"));
        cases.push(good(&format!("plain-row-{index}.csv"), text).channel(name));
    }
    for (index, (name, unit)) in [
        ("acc y (g)", "m/s^2"),
        ("acc_y_g", "m/s^2"),
        ("acc_y_g", "mm/s^2"),
    ]
    .iter()
    .enumerate()
    {
        cases.push(refused(
            &format!("spoilt-{index}.lvm"),
            labview(name, unit),
            &["no unit of acceleration", "--unit"],
        ));
    }
    cases.push(refused(
        "spoilt-volts.lvm",
        labview("acc y (V)", "g"),
        &["none is an acceleration", "--sensitivity"],
    ));
    for (index, name) in ["acc y (100 g)", "acc y x10", "acc y counts"]
        .iter()
        .enumerate()
    {
        let file = |kind: &str| format!("spoilt-{kind}{index}.lvm");
        cases.push(refused(
            &file("name-"),
            labview(name, "g"),
            &[name, "--channel"],
        ));
        cases.push(
            refused(
                &file("told-"),
                labview(name, "g"),
                &["unit of acceleration", way_on(name)],
            )
            .options(&["--channel", "1"]),
        );
    }
    for (index, name) in ["acc y", "acc y (g)", "acc_y_g"].iter().enumerate() {
        cases.push(good(&format!("plain-{index}.lvm"), labview(name, "g")).channel(name));
    }
    cases.push(
        good("told.lvm", labview("acc y (g)", "m/s^2"))
            .options(&["--unit", "g"])
            .channel("acc y (g)")
            .finds(&["warning unit-overridden"]),
    );
    cases
}
