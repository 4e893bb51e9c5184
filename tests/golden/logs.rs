//! MCAP logs: encodings, packing, clocks, and files that contradict themselves.

use super::{Case, FROM, TO, good, push, refused, to_and_fro};
use latchgate_test_support::mcap::{
    ACCEL_SCHEMA, Cdr, MAGIC, channel, chunk, crc32, file, imu, imu_schema, lz4, message,
    message_at, packed, schema, statistics,
};
use latchgate_test_support::mcap::{
    block, described, double, message_type, schema_of_bytes, whole,
};

/// The instant of first contact, sample 0 [ns].
const CONTACT: i64 = 1_700_000_000_000_000_000;

/// What a log writes for sample `k` [m/s²].
pub(super) fn value(k: i64) -> f64 {
    push(k) * 9.806_65
}

pub(super) fn stamp(k: i64) -> u64 {
    (CONTACT + 100_000 * k) as u64
}

/// A message per sample, logged a millisecond after its stamp.
pub(super) fn messages(body: impl Fn(i64) -> Vec<u8>) -> Vec<Vec<u8>> {
    (FROM..TO)
        .map(|k| message(1, stamp(k) + 1_000_000, &body(k)))
        .collect()
}

fn imu_message(k: i64) -> Vec<u8> {
    imu::imu_message_cdr(stamp(k), "imu", [0.0, value(k), 9.8])
}

fn topic() -> Vec<Vec<u8>> {
    vec![imu_schema(1), channel(1, 1, "/imu", "cdr")]
}

fn imu_records() -> Vec<Vec<u8>> {
    [topic(), messages(imu_message)].concat()
}

/// A log of these records, with statistics that agree.
pub(super) fn log(records: &[Vec<u8>]) -> Vec<u8> {
    let count = records.iter().filter(|record| record[0] == 5).count() as u64;
    file(records, &[statistics(&[(1, count)])])
}

pub(super) fn of(schema: Vec<u8>, encoding: &str, body: impl Fn(i64) -> Vec<u8>) -> Vec<u8> {
    let topic = vec![schema, channel(1, 1, "/door", encoding)];
    log(&[topic, messages(body)].concat())
}

/// A log that is read: time zero is stated, since a log's clock begins in 1970.
pub(super) fn read(name: &str, bytes: Vec<u8>, channel: &str) -> Case {
    good(name, bytes)
        .options(&["--time-zero", "1700000000"])
        .channel(channel)
        .unit("m/s2", |_| "0".into())
        .values((FROM..TO).map(value).collect())
}

/// A log of the one topic `/imu`; that its lateral field was taken is said.
fn imu_log(name: &str, bytes: Vec<u8>) -> Case {
    read(name, bytes, "/imu:linear_acceleration.y").finds(&["info channel-chosen"])
}

pub(super) fn stamped_header(k: i64) -> Cdr {
    Cdr::new(true).header(stamp(k), "door")
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = encodings();
    cases.extend(packing());
    cases.extend(clocks());
    cases.extend(whose_clock());
    cases.extend(time_zeros());
    cases.extend(broken());
    cases
}

/// The three times of sample `k` of a log [ns], of which cases change one or two.
#[derive(Clone, Copy)]
struct Clocks {
    header: fn(i64) -> u64,
    log: fn(i64) -> u64,
    publish: fn(i64) -> u64,
}

/// As a sound log has them: published after 0.2 ms, logged after 1 ms.
const SOUND: Clocks = Clocks {
    header: stamp,
    log: |k| stamp(k) + 1_000_000,
    publish: |k| stamp(k) + 200_000,
};

impl Clocks {
    /// Messages of the type `sensor_msgs/Imu`.
    fn of_imu(self) -> Vec<u8> {
        let one = |k| {
            let body = imu::imu_message_cdr((self.header)(k), "imu", [0.0, value(k), 9.8]);
            message_at(1, ((self.log)(k), (self.publish)(k)), &body)
        };
        log(&[topic(), (FROM..TO).map(one).collect()].concat())
    }

    /// Messages without a stamp, in g.
    fn of_float(self) -> Vec<u8> {
        let topic = vec![
            schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data\n"),
            channel(1, 1, "/door/ay_g", "cdr"),
        ];
        let one = |k| {
            let body = Cdr::new(true).f64(push(k)).finish();
            message_at(1, ((self.log)(k), (self.publish)(k)), &body)
        };
        log(&[topic, (FROM..TO).map(one).collect()].concat())
    }
}

/// A log whose times run this many times as fast as the stamps in the messages.
pub(super) fn logged_at(times: f64) -> Vec<u8> {
    let one = |k| {
        let after = (times * (stamp(k) - stamp(FROM)) as f64).round() as i64;
        let logged = (stamp(FROM) as i64 + after + 1_000_000) as u64;
        let body = imu::imu_message_cdr(stamp(k), "imu", [0.0, value(k), 9.8]);
        message_at(1, (logged, logged), &body)
    };
    log(&[topic(), (FROM..TO).map(one).collect()].concat())
}

/// The instant of sample `k` on a clock that runs `percent` as fast [ns].
fn scaled(k: i64, percent: u64) -> u64 {
    stamp(FROM) + (stamp(k) - stamp(FROM)) * percent / 100
}

/// Every other stamp twice, as some drivers write them.
fn doubled(k: i64) -> u64 {
    stamp(k - k.rem_euclid(2))
}

/// The stamp's nanoseconds where its seconds should be, and the reverse: it stands still.
fn still(_: i64) -> u64 {
    CONTACT as u64
}

fn whose_clock() -> Vec<Case> {
    let by = |name: &str, clocks: Clocks, source: &str| {
        imu_log(name, clocks.of_imu())
            .options(&["--time-source", source])
            .finds(&["info time-source"])
    };
    let plain = |name: &str, clocks: Clocks| {
        good(name, clocks.of_float())
            .options(&["--channel", "/door/ay_g:data", "--unit", "g"])
            .options(&["--time-zero", "1700000000.0002"])
            .channel("/door/ay_g:data")
            .values((FROM..TO).map(push).collect())
            .finds(&["warning channel-not-lateral"])
    };
    let refused = |name: &str, bytes: Vec<u8>, says: &[&str]| {
        refused(name, bytes, &[&["time must increase"], says].concat())
    };
    let twice = Clocks {
        header: doubled,
        ..SOUND
    };
    let frozen = Clocks {
        header: still,
        ..SOUND
    };
    let unlogged = Clocks {
        log: |_| 0,
        ..SOUND
    };
    let mut cases = vec![
        by("header.mcap", SOUND, "header"),
        by("log.mcap", SOUND, "log").clock(10_000.0, -0.019),
        by("publish.mcap", SOUND, "publish").clock(10_000.0, -0.0198),
        by("capitals.mcap", SOUND, "LOG").clock(10_000.0, -0.019),
        refused(
            "doubled.mcap",
            twice.of_imu(),
            &[
                "channel /imu, message 2",
                "the time of logging is sound: state --time-source log",
                "the time of publishing is sound: state --time-source publish",
            ],
        ),
        by("doubled-by-log.mcap", twice, "log").clock(10_000.0, -0.019),
        refused("still.mcap", frozen.of_imu(), &["--time-source log"]),
        by("still-by-publish.mcap", frozen, "publish").clock(10_000.0, -0.0198),
        // Of a log that has no clock, the sender's.
        refused(
            "unlogged.mcap",
            unlogged.of_float(),
            &["the time of publishing is sound: state --time-source publish"],
        )
        .options(&["--channel", "/door/ay_g:data", "--unit", "g"]),
        plain("unlogged-by-publish.mcap", unlogged)
            .options(&["--time-source", "publish"])
            .finds(&["info time-source"]),
        super::refused(
            "no-stamp.mcap",
            SOUND.of_float(),
            &["messages with stamps", "state --time-source log or publish"],
        )
        .options(&["--channel", "/door/ay_g:data", "--time-source", "header"]),
        refused(
            "all-broken.mcap",
            Clocks {
                header: still,
                log: doubled,
                publish: still,
            }
            .of_imu(),
            &["no clock of the log is sound"],
        ),
        super::refused("table.csv", "time_s,acc_y_g\n0,1\n", &["--time-source"])
            .options(&["--time-source", "log"]),
    ];
    cases.push(
        imu_log("card.mcap", SOUND.of_imu())
            .beside("card.mcap.toml", "time_source = \"publish\"\n")
            .clock(10_000.0, -0.0198)
            .finds(&["info time-source"]),
    );
    // Some drivers write the seconds in place of the nanoseconds.
    let seconds_twice = || {
        let one = |k| {
            let mut body = imu::imu_message_cdr(stamp(k), "imu", [0.0, value(k), 9.8]);
            body.copy_within(4..8, 8);
            message(1, stamp(k) + 1_000_000, &body)
        };
        log(&[topic(), (FROM..TO).map(one).collect()].concat())
    };
    cases.push(super::refused(
        "seconds-twice.mcap",
        seconds_twice(),
        &[
            "nanoseconds below 10^9, found 1699999999 s and 1699999999 ns",
            "the time of logging is sound: state --time-source log",
        ],
    ));
    cases.push(
        imu_log("seconds-twice-by-log.mcap", seconds_twice())
            .options(&["--time-source", "log"])
            .clock(10_000.0, -0.019)
            .finds(&["info time-source"]),
    );
    cases.extend(disagreeing());
    cases
}

/// Clocks that run differently: none is believed, whichever is asked for.
fn disagreeing() -> Vec<Case> {
    let blocked = |name: &str, clocks: Clocks| {
        imu_log(name, clocks.of_imu()).unusable(
            &["blocking time-contradicted"],
            &["One of the two is wrong"],
        )
    };
    vec![
        blocked(
            "log-slow.mcap",
            Clocks {
                log: |k| scaled(k, 1000),
                ..SOUND
            },
        ),
        blocked(
            "log-fast.mcap",
            Clocks {
                log: |k| scaled(k, 10),
                ..SOUND
            },
        ),
        blocked(
            "log-160.mcap",
            Clocks {
                log: |k| scaled(k, 160),
                ..SOUND
            },
        ),
        blocked(
            "publish-half.mcap",
            Clocks {
                publish: |k| scaled(k, 50),
                ..SOUND
            },
        ),
        blocked(
            "asked-for.mcap",
            Clocks {
                log: |k| scaled(k, 1000),
                ..SOUND
            },
        )
        .options(&["--time-source", "header"])
        .finds(&["info time-source"]),
        blocked(
            "log-140.mcap",
            Clocks {
                log: |k| scaled(k, 140),
                ..SOUND
            },
        ),
        // These do not run differently: a clock that stands still, one late message, and messages that come
        // in bundles.
        imu_log(
            "log-zero.mcap",
            Clocks {
                log: |_| 0,
                ..SOUND
            }
            .of_imu(),
        ),
        imu_log(
            "late.mcap",
            Clocks {
                log: |k| stamp(k) + if k == TO - 1 { 70_000_000 } else { 0 },
                ..SOUND
            }
            .of_imu(),
        ),
        imu_log(
            "bundles.mcap",
            Clocks {
                log: |k| stamp(k - k.rem_euclid(250) + 250),
                ..SOUND
            }
            .of_imu(),
        ),
        // The stamps jump where the log does not: messages may be missing.
        imu_log(
            "jump.mcap",
            Clocks {
                header: |k| stamp(k) + if k < 100 { 0 } else { 30_000_000 },
                ..SOUND
            }
            .of_imu(),
        )
        .samples(1100)
        .unusable(
            &["blocking gap", "blocking straight-line"],
            &["the time of logging has no gap: state --time-source log"],
        ),
        imu_log(
            "jump-by-log.mcap",
            Clocks {
                header: |k| stamp(k) + if k < 100 { 0 } else { 30_000_000 },
                ..SOUND
            }
            .of_imu(),
        )
        .options(&["--time-source", "log"])
        .clock(10_000.0, -0.019)
        .finds(&["info time-source", "warning log-time-differs"]),
    ]
}

/// The instant of first contact on the log's clock, and as times are shown.
fn time_zeros() -> Vec<Case> {
    let at = |name: &str, zero: &str| {
        good(name, log(&imu_records()))
            .options(&["--time-zero", zero])
            .channel("/imu:linear_acceleration.y")
            .unit("m/s2", |_| "0".into())
            .values((FROM..TO).map(value).collect())
            .finds(&["info channel-chosen"])
    };
    let outside = |zero: &str| {
        refused(
            "zero-outside.mcap",
            log(&imu_records()),
            &[
                "--time-zero",
                "1699999999.98 and 1700000000.0599 s",
                "0 and 0.0799 s",
            ],
        )
        .options(&["--time-zero", zero])
        .named(&format!("time zero at {zero}"))
    };
    vec![
        at("zero-absolute.mcap", "1700000000"),
        at("zero-shown.mcap", "0.02").finds(&["info time-zero-outside"]),
        at("zero-early.mcap", "0.01")
            .clock(10_000.0, -0.01)
            .finds(&["info time-zero-outside"]),
        at("zero-before.mcap", "1699999999.97")
            .clock(10_000.0, 0.01)
            .finds(&["warning time-zero-outside", "warning no-pre-event-data"]),
        outside("5"),
        outside("-0.01"),
        outside("1600000000"),
        outside("1700000060"),
    ]
}

fn encodings() -> Vec<Case> {
    let vector = "float64 x\nfloat64 y\nfloat64 z\n";
    let bar = "=".repeat(80);
    let ros1 = format!(
        "Header header\ngeometry_msgs/Vector3 accel\n{bar}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n{bar}\nMSG: geometry_msgs/Vector3\n{vector}"
    );
    let ros1_body = |k: i64| {
        let mut body = (k.unsigned_abs() as u32).to_le_bytes().to_vec();
        body.extend(((stamp(k) / 1_000_000_000) as u32).to_le_bytes());
        body.extend(((stamp(k) % 1_000_000_000) as u32).to_le_bytes());
        body.extend(3_u32.to_le_bytes());
        body.extend(b"bag");
        for number in [1.0, value(k), 2.0] {
            body.extend(f64::to_le_bytes(number));
        }
        body
    };
    let set = {
        let timestamp = [
            block(1, b"google/protobuf/timestamp.proto"),
            block(2, b"google.protobuf"),
            message_type(
                "Timestamp",
                &[
                    described("seconds", 1, 1, 3, ""),
                    described("nanos", 2, 1, 5, ""),
                ],
            ),
            block(12, b"proto3"),
        ]
        .concat();
        let own = [
            block(1, b"door.proto"),
            block(2, b"lab"),
            message_type(
                "Door",
                &[
                    described("stamp", 1, 1, 11, ".google.protobuf.Timestamp"),
                    described("ay_g", 2, 1, 1, ""),
                ],
            ),
            block(12, b"proto3"),
        ]
        .concat();
        [block(1, &timestamp), block(1, &own)].concat()
    };
    let proto = |k: i64| {
        let time = [
            whole(1, stamp(k) / 1_000_000_000),
            whole(2, stamp(k) % 1_000_000_000),
        ]
        .concat();
        [block(1, &time), double(2, push(k))].concat()
    };
    let json = |k: i64| {
        format!(
            "{{\"header\": {{\"stamp\": {{\"sec\": {}, \"nanosec\": {}}}}}, \"ay_g\": {}}}",
            stamp(k) / 1_000_000_000,
            stamp(k) % 1_000_000_000,
            push(k)
        )
        .into_bytes()
    };
    let in_g = |case: Case| {
        case.unit("g", |_| "0".into())
            .values((FROM..TO).map(push).collect())
    };
    let accel = |little: bool| {
        of(
            schema(1, "geometry_msgs/msg/AccelStamped", "ros2msg", ACCEL_SCHEMA),
            "cdr",
            |k| {
                Cdr::new(little)
                    .header(stamp(k), "d")
                    .f64s(&[1.0, value(k), 3.0, 4.0, 5.0, 6.0])
                    .finish()
            },
        )
    };
    let own = "std_msgs/Header header\nfloat32[3] v\nfloat64 ay_g\n";
    let own = format!(
        "{own}{bar}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{bar}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    );
    vec![
        imu_log("imu.mcap", log(&imu_records())),
        read("accel-little.mcap", accel(true), "/door:accel.linear.y")
            .finds(&["info channel-chosen"]),
        read("accel-big.mcap", accel(false), "/door:accel.linear.y")
            .finds(&["info channel-chosen"]),
        in_g(read(
            "own-message.mcap",
            of(schema(1, "lab/msg/Door", "ros2msg", &own), "cdr", |k| {
                stamped_header(k)
                    .f32(1.0)
                    .f32(2.0)
                    .f32(3.0)
                    .f64(push(k))
                    .finish()
            }),
            "/door:ay_g",
        ))
        .finds(&["info channel-chosen"]),
        refused(
            "ros1-no-unit.mcap",
            of(schema(1, "lab/Door", "ros1msg", &ros1), "ros1", ros1_body),
            &["no unit of acceleration", "--unit"],
        ),
        read(
            "ros1.mcap",
            of(schema(1, "lab/Door", "ros1msg", &ros1), "ros1", ros1_body),
            "/door:accel.y",
        )
        .options(&["--unit", "m/s2"])
        .finds(&["info channel-chosen"]),
        in_g(read(
            "protobuf.mcap",
            of(
                schema_of_bytes(1, "lab.Door", "protobuf", &set),
                "protobuf",
                proto,
            ),
            "/door:ay_g",
        ))
        .finds(&["info channel-chosen"]),
        in_g(read(
            "json.mcap",
            of(
                schema(1, "Door", "jsonschema", "{\"type\": \"object\"}"),
                "json",
                json,
            ),
            "/door:ay_g",
        ))
        .finds(&["info channel-chosen"]),
        read(
            "by-topic.mcap",
            log(&imu_records()),
            "/imu:linear_acceleration.y",
        )
        .options(&["--channel", "/imu"]),
        read(
            "by-field.mcap",
            log(&imu_records()),
            "/imu:linear_acceleration.y",
        )
        .options(&["--channel", "/imu:linear_acceleration.y"]),
        // An upright sensor: its vertical axis is 1 g throughout.
        read(
            "vertical.mcap",
            log(&imu_records()),
            "/imu:linear_acceleration.z",
        )
        .options(&["--channel", "/imu:linear_acceleration.z"])
        .values(vec![9.8; 800])
        .unusable(
            &[
                "warning channel-not-lateral",
                "blocking dead-sensor",
                "warning channel-not-lateral",
                "warning implausible-velocity",
            ],
            &["no motion"],
        ),
        refused(
            "no-field.mcap",
            log(&imu_records()),
            &[
                "no channel `/imu:linear_acceleration.w`",
                "/imu:linear_acceleration.y",
            ],
        )
        .options(&["--channel", "/imu:linear_acceleration.w"]),
        refused(
            "text-only.mcap",
            of(
                schema(1, "std_msgs/msg/String", "ros2msg", "string data"),
                "cdr",
                |_| Cdr::new(true).text("hello").finish(),
            ),
            &["no channel carries"],
        ),
        refused(
            "bad-schema.mcap",
            of(
                schema(1, "lab/msg/Door", "ros2msg", "what is this?"),
                "cdr",
                |k| stamped_header(k).finish(),
            ),
            &["/door"],
        ),
    ]
}

fn packing() -> Vec<Case> {
    let records = imu_records().concat();
    let (size, crc) = (records.len() as u64, crc32(&records));
    let count = (TO - FROM) as u64;
    let in_chunk = |chunk: Vec<u8>| file(&[chunk], &[statistics(&[(1, count)])]);
    let repeated: Vec<Vec<u8>> = messages(imu_message)
        .chunks(100)
        .map(|some| packed("zstd", &[topic().concat(), some.concat()].concat()))
        .collect();
    vec![
        imu_log("chunk.mcap", in_chunk(packed("", &records))),
        imu_log("zstd.mcap", in_chunk(packed("zstd", &records))),
        imu_log("lz4.mcap", in_chunk(packed("lz4", &records))),
        imu_log(
            "schema-in-each-chunk.mcap",
            file(&repeated, &[statistics(&[(1, count)])]),
        ),
        imu_log("no-summary.mcap", file(&imu_records(), &[])).finds(&["warning mcap-unverified"]),
        imu_log("other-topics.mcap", {
            let other = vec![
                schema(2, "std_msgs/msg/String", "ros2msg", "string data"),
                channel(2, 2, "/talk", "cdr"),
                channel(3, 2, "/silent", "cdr"),
                message(2, stamp(0), &Cdr::new(true).text("hello").finish()),
            ];
            file(
                &[imu_records(), other].concat(),
                &[statistics(&[(1, count), (2, 1)])],
            )
        }),
        refused(
            "chunk-crc.mcap",
            in_chunk(chunk("", size, crc ^ 1, &records)),
            &["checksum"],
        ),
        refused(
            "chunk-short.mcap",
            in_chunk(chunk("", size + 4, 0, &records)),
            &["as its header says"],
        ),
        refused(
            "cut-lz4.mcap",
            in_chunk(chunk("lz4", size, crc, &lz4(&records)[..200])),
            &["lz4"],
        ),
        refused(
            "bad-zstd.mcap",
            in_chunk(chunk("zstd", size, crc, &[7; 100])),
            &["zstd"],
        ),
        refused(
            "brotli.mcap",
            in_chunk(chunk("brotli", size, crc, &records)),
            &["`brotli`"],
        ),
        refused(
            "endless.mcap",
            {
                let mut endless = chunk("", size, crc, &records);
                endless[25..33].fill(0xFF);
                in_chunk(endless)
            },
            &["limit mcap_chunk_bytes"],
        ),
    ]
}

fn clocks() -> Vec<Case> {
    let changed = |change: &dyn Fn(&mut Vec<Vec<u8>>)| {
        let mut all = messages(imu_message);
        change(&mut all);
        log(&[topic(), all].concat())
    };
    let stamped = |k: i64, at: u64| {
        let body = imu::imu_message_cdr(at, "imu", [0.0, value(k), 9.8]);
        message(1, stamp(k) + 1_000_000, &body)
    };
    let all = |of: &dyn Fn(i64) -> Vec<u8>| log(&[topic(), (FROM..TO).map(of).collect()].concat());
    let at = (100 - FROM) as usize;
    vec![
        // A log's clock begins in 1970; unless told otherwise, its first sample is time zero.
        good("first-is-zero.mcap", log(&imu_records()))
            .channel("/imu:linear_acceleration.y")
            .unit("m/s2", |_| "0".into())
            .values((FROM..TO).map(value).collect())
            .clock(10_000.0, 0.0)
            .finds(&[
                "info channel-chosen",
                "info time-zero-first",
                "warning no-pre-event-data",
            ]),
        imu_log("no-frame.mcap", all(&|k| stamped(k, stamp(k)))),
        // Nothing was stamped, so the time of logging is all there is.
        imu_log("stamps-zero.mcap", all(&|k| stamped(k, 0)))
            .clock(10_000.0, -0.019)
            .finds(&["warning stamp-zero"]),
        imu_log("gap.mcap", changed(&|all| drop(all.drain(at..at + 60))))
            .samples(800)
            .unusable(
                &["blocking gap", "blocking straight-line"],
                &["gap in time"],
            ),
        refused(
            "back.mcap",
            changed(&|all| all[at] = stamped(100, stamp(50))),
            &["time must increase"],
        ),
        refused(
            "twice.mcap",
            changed(&|all| all[at] = stamped(100, stamp(99))),
            &["time must increase"],
        ),
        // 10 Hz for 20 s, as robots log.
        imu_log(
            "slow.mcap",
            log(&[
                topic(),
                (-100..100)
                    .map(|k: i64| {
                        let at = (CONTACT + 100_000_000 * k) as u64;
                        let body = imu::imu_message_cdr(at, "imu", [0.0, value(k), 9.8]);
                        message(1, at, &body)
                    })
                    .collect(),
            ]
            .concat()),
        )
        .clock(10.0, -10.0)
        .values((-100..100).map(value).collect())
        .unusable(
            &[
                "blocking low-rate",
                "warning rate-below-default-filter",
                "warning implausible-velocity",
                "blocking ends-inside-event",
                "warning zero-shift",
            ],
            &["unusable"],
        ),
        imu_log(
            "irregular.mcap",
            all(&|k| {
                stamped(
                    k,
                    stamp(k).wrapping_add_signed((1000.0 * to_and_fro(k)) as i64),
                )
            }),
        )
        .samples(799)
        .finds(&["warning time-irregular"]),
    ]
}

fn broken() -> Vec<Case> {
    let whole = log(&imu_records());
    let end = whole.len();
    let count = (TO - FROM) as u64;
    let changed = |index: usize, record: Vec<u8>| {
        let mut all = messages(imu_message);
        all[index] = record;
        log(&[topic(), all].concat())
    };
    let mut lost = imu_records();
    lost.remove(400);
    let two = [
        imu_records(),
        vec![channel(2, 1, "/imu2", "cdr")],
        (FROM..TO)
            .map(|k| message(2, stamp(k), &imu_message(k)))
            .collect(),
    ]
    .concat();
    let infinite = |k: i64| imu::imu_message_cdr(stamp(k), "imu", [0.0, f64::NAN, 9.8]);
    vec![
        refused("cut.mcap", &whole[..end / 2], &["the file is cut"]),
        refused("no-footer.mcap", &whole[..end - 37], &["footer"]),
        refused("no-end-magic.mcap", &whole[..end - 8], &["end magic"]),
        refused(
            "zeroed.mcap",
            [&whole[..end - 8], &[0; 8]].concat(),
            &["end magic"],
        ),
        // A whole file, then the tail of an older and longer one.
        refused(
            "tail.mcap",
            [&whole[..], &whole[end / 2..]].concat(),
            &["older, longer"],
        ),
        refused("magic-only.mcap", MAGIC, &["magic-only.mcap"]),
        refused(
            "no-messages.mcap",
            file(&topic(), &[]),
            &["no-messages.mcap"],
        ),
        refused(
            "lost.mcap",
            file(&lost, &[statistics(&[(1, count)])]),
            &["800 messages", "799"],
        ),
        refused(
            "unclosed.mcap",
            {
                let mut bytes = [MAGIC, &latchgate_test_support::mcap::header()].concat();
                bytes.push(6);
                bytes.extend([0xFF; 60]);
                bytes
            },
            &["all ones"],
        ),
        refused(
            "no-number.mcap",
            changed(300, message(1, stamp(100), &infinite(100))),
            &["finite", "/imu"],
        ),
        refused(
            "stub.mcap",
            changed(300, message(1, stamp(100), &[0, 1, 0, 0, 5])),
            &["/imu"],
        ),
        refused(
            "stranger.mcap",
            changed(300, message(9, stamp(100), &[])),
            &["channel 9"],
        ),
        refused(
            "two-topics.mcap",
            file(&two, &[statistics(&[(1, count), (2, count)])]),
            &[
                "several channels",
                "--channel /imu:linear_acceleration.y",
                "--channel /imu2:linear_acceleration.y",
                "▁",
            ],
        ),
        refused(
            "rate-against-stamps.mcap",
            whole.clone(),
            &["5000 Hz", "Hz by the times of the messages"],
        )
        .options(&["--rate-hz", "5000"]),
        refused(
            "time-unit.mcap",
            whole.clone(),
            &["leave out --time-column and --time-unit"],
        )
        .options(&["--time-unit", "ms"]),
        refused(
            "time-column.mcap",
            whole.clone(),
            &["leave out --time-column and --time-unit"],
        )
        .options(&["--time-column", "1"]),
    ]
}
