//! MCAP logs: which topic and field is taken, and what the messages say against it.

use super::logs::{log, messages, of, read, stamp, stamped_header, value};
use super::{Case, FROM, TO, good, push, refused};
use latchgate_test_support::mcap::{
    Cdr, channel, file, imu, imu_schema, message, schema, statistics,
};
use latchgate_test_support::mcap::{block, described, double, message_type, schema_of_bytes};

/// A log of JSON messages on the topic `/door`.
fn json(body: impl Fn(i64) -> String) -> Vec<u8> {
    of(
        schema(1, "Door", "jsonschema", "{\"type\": \"object\"}"),
        "json",
        |k| body(k).into_bytes(),
    )
}

/// A log of messages on the topic `/door` that hold these fields, doubles all.
fn doubles(fields: &[&str], body: impl Fn(i64) -> Vec<f64>) -> Vec<u8> {
    let text: String = fields
        .iter()
        .map(|name| format!("float64 {name}\n"))
        .collect();
    of(schema(1, "lab/msg/Door", "ros2msg", &text), "cdr", |k| {
        Cdr::new(true).f64s(&body(k)).finish()
    })
}

/// A log without stamps in its messages, read at the times at which they were logged.
fn logged(name: &str, bytes: Vec<u8>, channel: &str) -> Case {
    good(name, bytes)
        .options(&["--time-zero", "1700000000.001"])
        .channel(channel)
        .unit("g", |_| "0".into())
        .values((FROM..TO).map(push).collect())
        .finds(&["warning log-time"])
}

/// The stamp of sample `k` in JSON, its parts named so.
fn in_json(k: i64, seconds: &str, nanoseconds: &str) -> String {
    let (s, ns) = (stamp(k) / 1_000_000_000, stamp(k) % 1_000_000_000);
    format!("{{\"{seconds}\": {s}, \"{nanoseconds}\": {ns}}}")
}

/// An Imu message of ROS 2 whose covariance begins with `first`, from a frame.
fn imu(k: i64, frame: &str, first: f64) -> Vec<u8> {
    let mut covariance = [0.0; 9];
    covariance[0] = first;
    Cdr::new(true)
        .header(stamp(k), frame)
        .f64s(&[0.0, 0.0, 0.0, 1.0])
        .f64s(&[0.0; 9])
        .f64s(&[0.0; 3])
        .f64s(&[0.0; 9])
        .f64s(&[0.0, value(k), 9.8])
        .f64s(&covariance)
        .finish()
}

fn imu_log(body: impl Fn(i64) -> Vec<u8>) -> Vec<u8> {
    of(imu_schema(1), "cdr", body)
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = choices();
    cases.extend(doubts());
    cases.extend(twins());
    cases.extend(nothing_to_choose());
    cases
}

/// One topic recorded twice, by two senders: the door and one that shakes less.
fn twins() -> Vec<Case> {
    let bytes = || {
        let weak = |k: i64| {
            let weak = imu::imu_message_cdr(stamp(k), "door", [0.0, 0.1 * value(k), 9.8]);
            message(4, stamp(k) + 1_000_000, &weak)
        };
        let topics = vec![
            imu_schema(1),
            channel(1, 1, "/imu", "cdr"),
            channel(4, 1, "/imu", "cdr"),
        ];
        let count = (TO - FROM) as u64;
        let weak: Vec<Vec<u8>> = (FROM..TO).map(weak).collect();
        file(
            &[topics, messages(stamped_imu), weak].concat(),
            &[statistics(&[(1, count), (4, count)])],
        )
    };
    let named = |name: &'static str, asked: &'static str| {
        read(name, bytes(), "/imu:linear_acceleration.y (channel id 1)")
            .options(&["--channel", asked])
            .finds(&["warning neighbours-disagree"])
    };
    let all = [
        "/imu:linear_acceleration.y (channel id 1)",
        "/imu:linear_acceleration.y (channel id 4)",
        "--channel '/imu:linear_acceleration.y (channel id 4)'",
    ];
    vec![
        refused("twins.mcap", bytes(), &all),
        refused("twins-by-field.mcap", bytes(), &all)
            .options(&["--channel", "/imu:linear_acceleration.y"]),
        refused("twins-by-topic.mcap", bytes(), &["/imu (channel id 4)"])
            .options(&["--channel", "/imu"]),
        refused(
            "no-such-twin.mcap",
            bytes(),
            &["no channel `/imu (channel id 2)`"],
        )
        .options(&["--channel", "/imu (channel id 2)"]),
        named("one.mcap", "/imu:linear_acceleration.y (channel id 1)"),
        named("one-by-topic.mcap", "/imu (channel id 1)"),
        read(
            "other.mcap",
            bytes(),
            "/imu:linear_acceleration.y (channel id 4)",
        )
        .options(&["--channel", "/imu:linear_acceleration.y (channel id 4)"])
        // A tenth of a crash: a pass needs a person's word.
        .exit(3)
        .values((FROM..TO).map(|k| 0.1 * value(k)).collect())
        .finds(&[
            "warning implausible-peak",
            "warning implausible-velocity",
            "warning neighbours-disagree",
        ]),
    ]
}

/// Logs of which no field can be taken: the message names what there is, or says why there is none.
fn nothing_to_choose() -> Vec<Case> {
    let of_type = |definition: &str, body: &dyn Fn(i64) -> Vec<u8>| {
        of(
            schema(1, "lab/msg/Door", "ros2msg", definition),
            "cdr",
            body,
        )
    };
    let plain = |encoding: &str| of(schema(1, "Door", encoding, ""), encoding, |_| vec![1, 2, 3]);
    let batch = |text: &'static str| json(move |k| text.replace("Y", &push(k).to_string()));
    let one = "latchgate reads one sample a message";
    vec![
        refused(
            "float.mcap",
            of_type("float64 data\n", &|k| Cdr::new(true).f64(push(k)).finish()),
            &[
                "/door (lab/msg/Door, cdr): 800 messages with /door:data",
                "--channel",
            ],
        ),
        refused(
            "vector.mcap",
            of_type("float32 x\nfloat32 y\nfloat32 z\nfloat32 t\n", &|k| {
                let y = push(k) as f32;
                Cdr::new(true).f32(0.0).f32(y).f32(0.0).f32(20.0).finish()
            }),
            &["with /door:x, /door:y, /door:z and 1 more"],
        ),
        refused(
            "sequence.mcap",
            of_type("float64[] ay_g\n", &|k| {
                Cdr::new(true).u32(2).f64s(&[push(k), push(k)]).finish()
            }),
            &[
                "arrays of numbers, ay_g[0..]",
                one,
                "export the topic as CSV",
            ],
        ),
        refused(
            "batch.mcap",
            batch("{\"samples\": [{\"ay_g\": Y}, {\"ay_g\": Y}]}"),
            &["arrays of numbers, samples[0..].ay_g", one],
        ),
        refused(
            "bare-batch.mcap",
            batch("[Y, Y, Y]"),
            &["arrays of numbers, [0..]", one],
        ),
        refused(
            "stamped-batch.mcap",
            batch("{\"count\": 2, \"accel\": {\"y\": [Y, Y]}}"),
            &[
                "with /door:count (arrays of numbers, accel.y[0..]",
                one,
                "export the topic",
            ],
        ),
        refused(
            "quoted.mcap",
            batch("{\"ay_g\": \"Y\"}"),
            &[
                "numbers in quotes, ay_g, are not read",
                "export the topic as CSV",
            ],
        ),
        refused(
            "quoted-by-name.mcap",
            batch("{\"ay_g\": \"Y\", \"n\": 1}"),
            &["no channel `/door:ay_g`", "numbers in quotes, ay_g,"],
        )
        .options(&["--channel", "/door:ay_g"]),
        refused(
            "cbor.mcap",
            plain("cbor"),
            &["messages in `cbor` are not read"],
        ),
        refused(
            "flat.mcap",
            plain("flatbuffer"),
            &["messages in `flatbuffer` are not read"],
        ),
    ]
}

/// The door beside a cabin of a type of its own; one without a name is JSON.
fn beside_door(name: &str, definition: &str, cabin: impl Fn(i64) -> Vec<u8>) -> Vec<u8> {
    let (id, encoding) = match name.is_empty() {
        true => (0, "json"),
        false => (2, "cdr"),
    };
    let mut own = vec![schema(1, "lab/msg/Door", "ros2msg", "float64 ay_g\n")];
    own.extend((id > 0).then(|| schema(id, name, "ros2msg", definition)));
    own.extend([
        channel(1, 1, "/door", "cdr"),
        channel(2, id, "/cabin", encoding),
    ]);
    let door = messages(|k| Cdr::new(true).f64(push(k)).finish());
    let cabin = (FROM..TO).map(|k| message(2, stamp(k) + 1_000_000, &cabin(k)));
    let count = (TO - FROM) as u64;
    file(
        &[own, door, cabin.collect()].concat(),
        &[statistics(&[(1, count), (2, count)])],
    )
}

fn choices() -> Vec<Case> {
    // A cabin that shakes little, beside the door.
    let cabin = |k: i64| 0.05 * push(k);
    let wide: Vec<String> = (0..70).map(|index| format!("value_{index}")).collect();
    let wide: Vec<&str> = wide.iter().map(String::as_str).collect();
    let of_wide = |first: &[&str], last: &[&str]| {
        let fields = [first, &wide, last].concat();
        doubles(&fields, |k| {
            let mut numbers = vec![0.0; fields.len()];
            for (number, name) in numbers.iter_mut().zip(&fields) {
                match *name {
                    "cabin_ay_g" => *number = cabin(k),
                    "door_ay_g" => *number = push(k),
                    _ => {}
                }
            }
            numbers
        })
    };
    let two_kinds = |begin: &str| {
        let body = |k| format!("{begin}\"ay_g\": {}}}", cabin(k)).into_bytes();
        beside_door("", "", body)
    };
    let typed = |name: &str, definition: &str| {
        let body = |k| Cdr::new(true).f64(cabin(k)).finish();
        beside_door(name, definition, body)
    };
    let name_alone = |name: &'static str| doubles(&[name], |k| vec![push(k)]);
    vec![
        refused(
            "json-beside-own.mcap",
            two_kinds("{"),
            &["several channels", "/door:ay_g", "/cabin:ay_g"],
        ),
        logged("no-json-beside-own.mcap", two_kinds("{{"), "/door:ay_g")
            .finds(&["info channel-chosen", "warning channel-left-out"]),
        refused(
            "type-unknown-beside-own.mcap",
            typed("lab/msg/Cabin", "float64 ay_g\nGone gone\n"),
            &["channel /cabin: expected a definition of lab/Gone"],
        ),
        refused(
            "type-without-its-field-beside-own.mcap",
            typed("geometry_msgs/msg/AccelStamped", "float64 x\n"),
            &["several channels", "/door:ay_g", "/cabin:accel.linear.y"],
        ),
        logged(
            "after-seventy.mcap",
            of_wide(&[], &["door_ay_g"]),
            "/door:door_ay_g",
        )
        .finds(&["info channel-chosen"]),
        refused(
            "before-and-after-seventy.mcap",
            of_wide(&["cabin_ay_g"], &["door_ay_g"]),
            &["several channels", "/door:cabin_ay_g", "/door:door_ay_g"],
        ),
        logged(
            "redundant.mcap",
            doubles(&["accel_y_g", "accel_y_redundant_g"], |k| {
                vec![push(k), -push(k)]
            }),
            "/door:accel_y_g",
        )
        .finds(&["info channel-chosen"]),
        refused(
            "head.mcap",
            name_alone("head_ay_g"),
            &["/door:head_ay_g (`head` is no known word)", "--channel"],
        ),
        refused(
            "barrier.mcap",
            name_alone("barrier_ay_g"),
            &["(`barrier` is no known word)", "--channel"],
        ),
        logged(
            "head-by-name.mcap",
            name_alone("head_ay_g"),
            "/door:head_ay_g",
        )
        .options(&["--channel", "/door:head_ay_g"])
        .finds(&["warning channel-not-lateral"]),
        refused(
            "dummy-topic.mcap",
            log(&[
                vec![imu_schema(1), channel(1, 1, "/dummy/imu", "cdr")],
                messages(|k| imu(k, "head", 0.0)),
            ]
            .concat()),
            &["(`dummy` is no known word)", "--channel"],
        ),
        // The first message does not tell all fields.
        refused(
            "null-at-first.mcap",
            json(|k| {
                let door = if k == FROM {
                    "null".into()
                } else {
                    push(k).to_string()
                };
                format!(
                    "{{\"cabin\": {{\"ay_g\": {}}}, \"door\": {{\"ay_g\": {door}}}}}",
                    cabin(k)
                )
            }),
            &["several channels", "/door:cabin.ay_g", "/door:door.ay_g"],
        ),
        refused(
            "field-later.mcap",
            json(|k| {
                let door = format!(", \"door\": {{\"ay_g\": {}}}", push(k));
                let door = if k < FROM + 5 { "" } else { &door };
                format!("{{\"cabin\": {{\"ay_g\": {}}}{door}}}", cabin(k))
            }),
            &["another lateral acceleration", "--channel"],
        ),
    ]
}

fn doubts() -> Vec<Case> {
    let old = doubles(&["ax_g", "ay_g"], |k| vec![9.8, 0.1, push(k)]);
    let old_floats = of(
        schema(1, "lab/msg/Door", "ros2msg", "float32 ax_g\nfloat32 ay_g\n"),
        "cdr",
        |k| {
            Cdr::new(true)
                .f32(9.8)
                .f32(0.1)
                .f32(push(k) as f32)
                .finish()
        },
    );
    let in_map = {
        let entry = [
            block(1, b"AccEntry"),
            described("key", 1, 1, 9, ""),
            described("value", 2, 1, 1, ""),
            block(7, &[0x38, 1]),
        ]
        .concat();
        let own = [
            block(1, b"door.proto"),
            block(2, b"lab"),
            message_type(
                "Door",
                &[
                    described("acc", 1, 3, 11, ".lab.Door.AccEntry"),
                    block(3, &entry),
                ],
            ),
            block(12, b"proto3"),
        ]
        .concat();
        of(
            schema_of_bytes(1, "lab.Door", "protobuf", &block(1, &own)),
            "protobuf",
            |k| {
                let entry =
                    |key: &[u8], value: f64| block(1, &[block(1, key), double(2, value)].concat());
                [entry(b"ay", push(k)), entry(b"az", 1.0)].concat()
            },
        )
    };
    let stamped = |k: i64, path: &str, text: &str| {
        let stamp = if path.is_empty() {
            format!("\"timestamp\": {text}")
        } else {
            format!("\"{path}\": {{\"stamp\": {text}}}")
        };
        format!("{{{stamp}, \"ay_g\": {}}}", push(k))
    };
    let in_g = |name: &str, bytes: Vec<u8>| {
        read(name, bytes, "/door:ay_g")
            .unit("g", |_| "0".into())
            .values((FROM..TO).map(push).collect())
            .finds(&["info channel-chosen"])
    };
    let imu_read = |name: &str, bytes: Vec<u8>| {
        read(name, bytes, "/door:linear_acceleration.y").finds(&["info channel-chosen"])
    };
    vec![
        // What is left over is a field that the schema lacks, not padding.
        refused("older-schema.mcap", old, &["8 bytes more"]),
        refused("older-schema-floats.mcap", old_floats, &["4 bytes more"]),
        imu_read("estimate.mcap", imu_log(|k| imu(k, "door", 0.01))),
        refused(
            "no-estimate.mcap",
            imu_log(|k| imu(k, "door", -1.0)),
            &["linear_acceleration_covariance", "has none"],
        ),
        refused(
            "two-frames.mcap",
            imu_log(|k| imu(k, if k % 2 == 0 { "door" } else { "roof" }, 0.0)),
            &["another frame_id", "a separate topic"],
        ),
        refused("map.mcap", in_map, &["no channel `/door:acc[0].value`"]).options(&[
            "--channel",
            "/door:acc[0].value",
            "--unit",
            "g",
        ]),
        in_g(
            "json-secs.mcap",
            json(|k| stamped(k, "header", &in_json(k, "secs", "nsecs"))),
        ),
        in_g(
            "json-timestamp.mcap",
            json(|k| stamped(k, "", &in_json(k, "sec", "nsec"))),
        ),
        refused(
            "json-two-frames.mcap",
            json(|k| {
                let frame = if k < 100 { "door" } else { "roof" };
                let time = in_json(k, "sec", "nanosec");
                format!(
                    "{{\"header\": {{\"stamp\": {time}, \"frame_id\": \"{frame}\"}}, \"ay_g\": {}}}",
                    push(k)
                )
            }),
            &["another frame_id"],
        ),
        // Seconds of today need more digits than a double has; as written they are exact.
        good("zero-between.mcap", imu_log(|k| imu(k, "door", 0.0)))
            .options(&["--time-zero", "1699999999.98"])
            .channel("/door:linear_acceleration.y")
            .unit("m/s2", |_| "0".into())
            .values((FROM..TO).map(value).collect())
            .clock(10_000.0, 0.0)
            .finds(&["info channel-chosen", "warning no-pre-event-data"]),
        // Logged ten times as slowly as the stamps say.
        imu_read("slow-log.mcap", {
            let slow = |k: i64| message(1, stamp(FROM + 10 * (k - FROM)), &imu(k, "door", 0.0));
            let topic = vec![imu_schema(1), channel(1, 1, "/door", "cdr")];
            log(&[topic, (FROM..TO).map(slow).collect()].concat())
        })
        .unusable(
            &["blocking time-contradicted"],
            &["stamp in the messages spans 0.0799 s, but the time of logging 0.799 s"],
        ),
        refused(
            "many-fields.mcap",
            imu_log(|k| imu(k, "door", 0.0)),
            &["limit mcap_fields of 10 crossed"],
        )
        .options(&["--limit", "mcap_fields=10"]),
        imu_read("stamped.mcap", imu_log(stamped_imu)),
    ]
}

/// An Imu message as the log's own helper writes it, from the same frame.
fn stamped_imu(k: i64) -> Vec<u8> {
    stamped_header(k)
        .f64s(&[0.0, 0.0, 0.0, 1.0])
        .f64s(&[0.0; 9])
        .f64s(&[0.0; 3])
        .f64s(&[0.0; 9])
        .f64s(&[0.0, value(k), 9.8])
        .f64s(&[0.0; 9])
        .finish()
}
