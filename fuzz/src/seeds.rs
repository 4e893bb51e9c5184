//! Seeds: small whole files of each kind, from which mutation starts.

use std::fmt::Write as _;

/// Rows of most seeds: few, so that a change hits what matters and many are tried.
const ROWS: i32 = 10;

fn value(k: i32) -> f64 {
    40.0 * (f64::from(k) * 0.37).sin()
}

fn table(head: &str, separator: &str, comma: bool) -> String {
    let mut text = head.to_string();
    for k in 0..ROWS {
        let mut row = format!(
            "{:.4}{separator}{:.3}\n",
            f64::from(k - 10) * 1e-4,
            value(k)
        );
        if comma {
            row = row.replace('.', ",");
        }
        text.push_str(&row);
    }
    text
}

fn utf_16(text: &str) -> Vec<u8> {
    let mut bytes = vec![0xFF, 0xFE];
    bytes.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
    bytes
}

fn csv() -> Vec<Vec<u8>> {
    let mut seeds: Vec<Vec<u8>> = [
        table("time_s,acc_y_g\n", ",", false),
        table("Zeit [s];a quer [g]\n", ";", true),
        table("time\tay\ns\tm/s2\n", "\t", false),
        table("# made by\n\"t (ms)\",\"acc y (g)\"\n", ",", false),
        table("sep=;\nt;ay_g\n", ";", false),
        table("", " ", false),
        table("n,t,acc_y_g,acc_x_g\n1,", ",2,", false),
        table("time_s,acc_y_g\r\n", ",", false).replace('\n', "\r\n"),
        "acc_y_g\n1.5\n-2e3\n+.25\n0\n7.\n1e-9\n".into(),
        "t,ay_g\n0,1\n0.001,nan\n0.002,\n0.002,3,\n".into(),
        "t;ay_g\n0;1,5\n0,001;2.5\n".into(),
        format!(
            "t,ay_g\n0.1,{}\n0.2,123456789012345678901234567890\n",
            "9".repeat(40)
        ),
    ]
    .into_iter()
    .map(String::into_bytes)
    .collect();
    // More rows than those that layouts are found from.
    let rows: String = (0..66).map(|k| format!("{k},{}\n", k % 7)).collect();
    seeds.push(format!("t_ms,ay_g\n{rows}").into_bytes());
    seeds.push(utf_16(&table("time_s,acc_y_g\n", ",", false)));
    seeds.push(
        [
            b"# 45 \xB0\n".as_slice(),
            table("t,ay_g\n", ",", false).as_bytes(),
        ]
        .concat(),
    );
    seeds
}

fn lvm() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for columns in ["No", "One", "Multi"] {
        let mut text = format!(
            "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\t{columns}\nMulti_Headings\tYes\nDate\t2020/01/01\n***End_of_Header***\t\n\nChannels\t2\t\t\nSamples\t{ROWS}\t{ROWS}\t\nY_Unit_Label\tg\tg\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\nDelta_X\t0.0001\t0.0001\t\n***End_of_Header***\t\t\t\nX_Value\tay\tax\tComment\n"
        );
        for k in 0..ROWS {
            let t = f64::from(k) * 1e-4;
            let (a, b) = (value(k), value(k + 3));
            match columns {
                "No" => writeln!(text, "\t{a:.3}\t{b:.3}"),
                "One" => writeln!(text, "{t:.4}\t{a:.3}\t{b:.3}"),
                _ => writeln!(text, "{t:.4}\t{a:.3}\t{t:.4}\t{b:.3}"),
            }
            .expect("a string takes all");
        }
        seeds.push(text.replace('.', ",").into_bytes());
        seeds.push(text.into_bytes());
    }
    seeds
}

/// Workbooks: the parts of an .xlsx, with form feeds between them, and an .xls of xlwt.
fn workbook() -> Vec<Vec<u8>> {
    let book = "<workbook><workbookPr date1904=\"0\"/><sheets><sheet name=\"Data\" sheetId=\"1\" r:id=\"r1\"/>\
                </sheets><calcPr fullCalcOnLoad=\"0\"/></workbook>";
    let relations = "<Relationships><Relationship Id=\"r1\" Type=\"x/worksheet\" Target=\"worksheets/sheet1.xml\"/>\
                     <Relationship Id=\"r2\" Type=\"x/styles\" Target=\"styles.xml\"/>\
                     <Relationship Id=\"r3\" Type=\"x/sharedStrings\" Target=\"/xl/sharedStrings.xml\"/></Relationships>";
    let styles = "<styleSheet><numFmts><numFmt numFmtId=\"164\" formatCode=\"hh:mm:ss.000\"/></numFmts>\
                  <cellXfs><xf numFmtId=\"0\"/><xf numFmtId=\"164\"/></cellXfs></styleSheet>";
    let strings =
        "<sst><si><t>Time</t></si><si><r><t>Acc &amp; Y </t></r><r><t>[g]</t></r></si></sst>";
    let row = |number: u32| {
        let days = f64::from(number) * 1e-4 / 86_400.0;
        let value = f64::from(number % 7) * 1.5;
        format!(
            "<row r=\"{number}\"><c r=\"A{number}\" s=\"1\"><v>{days}</v></c>\
             <c r=\"B{number}\"><f>1+1</f><v>{value}</v></c></row>"
        )
    };
    let rows: String = (2..12).map(row).collect();
    let sheet = format!(
        "<worksheet><cols><col min=\"3\" max=\"4\" hidden=\"1\"/></cols><sheetData><row r=\"1\">\
         <c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" t=\"s\"><v>1</v></c></row>{rows}</sheetData>\
         <mergeCells><mergeCell ref=\"A1:A1\"/></mergeCells></worksheet>"
    );
    let parts = [book, relations, styles, strings, &sheet].join("\x0C");
    let old = include_bytes!("../../tests/data/workbook/xlwt.xls");
    vec![parts.into_bytes(), old.to_vec()]
}

/// The files that npTDMS reads as we do.
fn tdms() -> Vec<Vec<u8>> {
    macro_rules! file {
        ($name:literal) => {
            include_bytes!(concat!("../../tests/data/tdms/", $name, ".tdms")).to_vec()
        };
    }
    vec![
        file!("plain"),
        file!("segments"),
        file!("stamps"),
        file!("big-endian"),
        file!("interleaved"),
        file!("lists"),
        file!("unclosed"),
    ]
}

fn ev5() -> Vec<Vec<u8>> {
    let header = "# comment\n----- TEST -----\n7292|x|y|\n----- INSTRUMENTATION -----\n1|146|AC|NA|DSLF|YG|SEC|G'S|1650|M|01/JAN/2020|2000|10|0.0|-10|29|100|AM|P|NO COMMENTS\n1|147|AC|NA|DSLF|YG|SEC|G'S|1650|M|01/JAN/2020|2000|101|0.0|-10|29|100|QD|R|NO VALID DATA AFTER 64.6 MILLISECONDS\n----- END -----";
    vec![
        header.as_bytes().to_vec(),
        table("", "\t", false).into_bytes(),
        "-0.020000\t-1.659300\n-0.019900\t1.0\n".into(),
    ]
}

fn iso_mme() -> Vec<Vec<u8>> {
    let mut channel = format!(
        "Test object number          :1\nChannel code                :11DOORLE0000ACYA\nUnit                        :m/(s*s)\nReference channel           :implicit\nSampling interval           :0.0001\nTime of first sample        :-0.001\nNumber of samples           :{ROWS}\nChannel amplitude class     :1472\nFirst global maximum value  :3.9E+1\nData status                 :ok\nComments                    :a\nComments                    :b: c\n"
    );
    for k in 0..ROWS {
        writeln!(channel, "{:.3}", value(k)).expect("a string takes all");
    }
    let holes = channel.replace("\n-", "\nNOVALUE\n-");
    let head = "Data format edition number  :1.6\nLaboratory test ref.        :x\nTest number                 :7\nImpact side test object 1   :LE\n";
    let list = "Instrumentation standard    :ISO 6487\nNumber of channels          :1\nName of channel 001         :11DOORLE0000ACYA / x\n";
    let files = [
        ("t.mme", head.as_bytes()),
        ("Channel/t.chn", list.as_bytes()),
        ("Channel/t.001", channel.as_bytes()),
    ];
    vec![
        channel.clone().into_bytes(),
        holes.into_bytes(),
        head.into(),
        list.into(),
        zip(&files),
        tar(&files),
        gzip(&tar(&files)),
    ]
}

fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

fn small(length: usize) -> u32 {
    u32::try_from(length).expect("seeds are small")
}

/// A zip archive of stored files.
fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut data, mut index) = (Vec::new(), Vec::new());
    for (name, bytes) in files {
        let start = small(data.len());
        let mut common = vec![20, 0, 0, 0, 0, 0, 0, 0, 33, 80];
        common.extend(checksum(bytes).to_le_bytes());
        common.extend(small(bytes.len()).to_le_bytes());
        common.extend(small(bytes.len()).to_le_bytes());
        common.extend(&small(name.len()).to_le_bytes()[..2]);
        common.extend([0, 0]);
        data.extend(b"PK\x03\x04");
        data.extend(&common);
        data.extend(name.as_bytes());
        data.extend(*bytes);
        index.extend(b"PK\x01\x02\x14\0");
        index.extend(&common);
        index.extend([0; 10]);
        index.extend(start.to_le_bytes());
        index.extend(name.as_bytes());
    }
    let (start, size, count) = (small(data.len()), small(index.len()), small(files.len()));
    data.extend(index);
    data.extend(b"PK\x05\x06\0\0\0\0");
    data.extend(&count.to_le_bytes()[..2]);
    data.extend(&count.to_le_bytes()[..2]);
    data.extend(size.to_le_bytes());
    data.extend(start.to_le_bytes());
    data.extend([0, 0]);
    data
}

fn tar(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut out = Vec::new();
    for (name, bytes) in files {
        let mut head = vec![0_u8; 512];
        head[..name.len()].copy_from_slice(name.as_bytes());
        head[124..135].copy_from_slice(format!("{:011o}", bytes.len()).as_bytes());
        head[156] = b'0';
        head[257..263].copy_from_slice(b"ustar\0");
        head[148..156].fill(b' ');
        let sum: u32 = head.iter().map(|byte| u32::from(*byte)).sum();
        head[148..155].copy_from_slice(format!("{sum:06o}\0").as_bytes());
        out.extend(head);
        out.extend(*bytes);
        out.resize(out.len().next_multiple_of(512), 0);
    }
    out.resize(out.len() + 1024, 0);
    out
}

/// A gzip member of stored blocks.
fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![0x1F, 0x8B, 8, 0, 0, 0, 0, 0, 0, 3];
    let blocks: Vec<&[u8]> = bytes.chunks(60_000).collect();
    for (index, block) in blocks.iter().enumerate() {
        out.push(u8::from(index + 1 == blocks.len()));
        let length = &small(block.len()).to_le_bytes()[..2];
        out.extend(length);
        out.extend(length.iter().map(|byte| !byte));
        out.extend(*block);
    }
    out.extend(checksum(bytes).to_le_bytes());
    out.extend(small(bytes.len()).to_le_bytes());
    out
}

fn record(opcode: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    let mut out = vec![opcode];
    out.extend((body.len() as u64).to_le_bytes());
    out.extend(body);
    out
}

fn text(text: &str) -> Vec<u8> {
    let mut out = small(text.len()).to_le_bytes().to_vec();
    out.extend(text.as_bytes());
    out
}

/// A log of one topic; `body` makes message `k`.
fn log(schema: (&str, &str, &[u8]), encoding: &str, body: impl Fn(i32) -> Vec<u8>) -> Vec<u8> {
    let (name, kind, definition) = schema;
    let mut inside = record(
        3,
        &[
            &[1, 0],
            &text(name),
            &text(kind),
            &small(definition.len()).to_le_bytes(),
            definition,
        ],
    );
    inside.extend(record(
        4,
        &[&[1, 0, 1, 0], &text("/imu"), &text(encoding), &[0; 4]],
    ));
    for k in 0..12 {
        let time = (1_000_000_000 + 1_000_000 * i64::from(k)).to_le_bytes();
        inside.extend(record(5, &[&[1, 0, 0, 0, 0, 0], &time, &time, &body(k)]));
    }
    let size = (inside.len() as u64).to_le_bytes();
    // Half of the seeds put their records into a chunk, without a checksum.
    let data = if encoding == "cdr" || encoding == "json" {
        record(6, &[&[0; 16], &size, &[0; 4], &text(""), &size, &inside])
    } else {
        inside
    };
    let magic = b"\x89MCAP0\r\n";
    [
        magic.to_vec(),
        record(1, &[&text("ros2"), &text("seed")]),
        data,
        record(15, &[&[0; 4]]),
        record(2, &[&[0; 20]]),
        magic.to_vec(),
    ]
    .concat()
}

fn mcap() -> Vec<Vec<u8>> {
    let stamp = |k: i32| [(1_i32).to_le_bytes(), (1_000_000 * k).to_le_bytes()].concat();
    let accel = "std_msgs/Header header\nAccel accel\n================================================================================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n================================================================================\nMSG: geometry_msgs/Accel\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n================================================================================\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
    let six = |k: i32| {
        (0..6)
            .flat_map(|axis| value(k + axis).to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let cdr = move |k: i32| {
        [
            vec![0, 1, 0, 0],
            stamp(k),
            1_u32.to_le_bytes().to_vec(),
            vec![0; 4],
            vec![0; 4],
            six(k),
        ]
        .concat()
    };
    let own = "string name\nfloat32[3] v\nuint8[] pad\nfloat64 ay_g\n";
    let ros1 = |k: i32| {
        [
            text("abc"),
            vec![0; 12],
            text("xy"),
            value(k).to_le_bytes().to_vec(),
        ]
        .concat()
    };
    // A descriptor of `message M { double ay_g = 1; }` in proto3.
    let field = b"\x0a\x04ay_g\x18\x01\x20\x01\x28\x01";
    let message = [
        b"\x0a\x01M\x12".as_slice(),
        &[u8::try_from(field.len()).expect("short")],
        field,
    ]
    .concat();
    let file = [
        b"\x0a\x07m.proto\x22".as_slice(),
        &[u8::try_from(message.len()).expect("short")],
        &message,
        b"\x62\x06proto3",
    ]
    .concat();
    let set = [
        b"\x0a".as_slice(),
        &[u8::try_from(file.len()).expect("short")],
        &file,
    ]
    .concat();
    let proto = |k: i32| [vec![0x09], value(k).to_le_bytes().to_vec()].concat();
    let json = |k: i32| {
        format!(
            "{{\"t\":{k},\"accel\":{{\"ay_g\":{:.3}}},\"l\":[1,2]}}",
            value(k)
        )
        .into_bytes()
    };
    vec![
        log(
            (
                "geometry_msgs/msg/AccelStamped",
                "ros2msg",
                accel.as_bytes(),
            ),
            "cdr",
            cdr,
        ),
        log(("my/Own", "ros1msg", own.as_bytes()), "ros1", ros1),
        log(("M", "protobuf", &set), "protobuf", proto),
        log(("J", "jsonschema", b"{\"type\":\"object\"}"), "json", json),
    ]
}

fn settings() -> Vec<Vec<u8>> {
    [
        "name = \"x\"\nbase = \"paper\"\n[lever]\nmoment_of_inertia_kg_m2 = 8.888e-4\npivot_damping_nm_s_per_rad = 9.3e-5\nspring_stiffness_nm_per_rad = 0.37\npreload_torque_nm = 0.1\nmass_kg = 0.1475\ncenter_of_mass_m = 0.065\n[stop]\nrestitution = 0.8\nstiffness_n_per_m = 1e7\ndamping_n_s_per_m = 133.59\nradius_m = 0.1\n[criterion]\nthreshold_rad = 0.1\n[tolerance]\nrestitution = 0.02\n[input]\nscale = 0.01\nbias_g = 0.1\n",
        "channel = \"acc_y_g\"\nunit = \"g\"\nopens_when = \"negative\"\nrange_g = 500.0\nsynthetic = true\nsource = \"x\"\nlicence = \"CC0\"\nnotes = \"n\"\n",
        "lever.preload_torque_nm=2.82\nstop.restitution=0.5\nlever.mass_kg=1e-3\ncriterion.threshold_rad=0.2\n",
    ]
    .into_iter()
    .map(|text| text.as_bytes().to_vec())
    .collect()
}

/// Returns the seeds of a target.
pub fn of(target: &str) -> Vec<Vec<u8>> {
    match target {
        "csv" => csv(),
        "lvm" => lvm(),
        "tdms" => tdms(),
        "workbook" => workbook(),
        "ev5" => ev5(),
        "iso_mme" => iso_mme(),
        "mcap" => mcap(),
        "settings" => settings(),
        _ => [csv(), lvm(), tdms(), workbook(), ev5(), iso_mme(), mcap()].concat(),
    }
}
