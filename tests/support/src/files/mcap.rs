//! MCAP logs, record by record, so that the reader is not held against its own idea of the format.

#[path = "../../../../examples/support/imu.rs"]
pub mod imu;

pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";
pub const ACCEL_SCHEMA: &str = "\
std_msgs/Header header
Accel accel
================================================================================
MSG: geometry_msgs/Accel
Vector3 linear
Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

// ---------------------------------------------------------------- building files

/// Bytes of a CDR message, aligned as they are appended.
pub struct Cdr {
    little: bool,
    body: Vec<u8>,
}

impl Cdr {
    pub fn new(little: bool) -> Self {
        let body = Vec::new();
        Self { little, body }
    }

    fn put<const N: usize>(mut self, little: [u8; N]) -> Self {
        let mut bytes = little;
        if !self.little {
            bytes.reverse();
        }
        self.body.resize(self.body.len().next_multiple_of(N), 0);
        self.body.extend(bytes);
        self
    }

    pub fn u8(self, value: u8) -> Self {
        self.put(value.to_le_bytes())
    }

    pub fn i16(self, value: i16) -> Self {
        self.put(value.to_le_bytes())
    }

    pub fn u32(self, value: u32) -> Self {
        self.put(value.to_le_bytes())
    }

    pub fn f32(self, value: f32) -> Self {
        self.put(value.to_le_bytes())
    }

    pub fn f64(self, value: f64) -> Self {
        self.put(value.to_le_bytes())
    }

    pub fn f64s(self, values: &[f64]) -> Self {
        values.iter().fold(self, |cdr, value| cdr.f64(*value))
    }

    pub fn text(self, text: &str) -> Self {
        let mut cdr = self.u32(text.len() as u32 + 1);
        cdr.body.extend(text.as_bytes());
        cdr.body.push(0);
        cdr
    }

    pub fn header(self, stamp_ns: u64, frame: &str) -> Self {
        self.u32((stamp_ns / 1_000_000_000) as u32)
            .u32((stamp_ns % 1_000_000_000) as u32)
            .text(frame)
    }

    pub fn finish(self) -> Vec<u8> {
        let mut message = vec![0, u8::from(self.little), 0, 0];
        message.extend(self.body);
        message
    }
}

pub fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![opcode];
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
    bytes
}

pub fn text(text: &str) -> Vec<u8> {
    let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
    bytes.extend(text.as_bytes());
    bytes
}

pub fn header() -> Vec<u8> {
    record(0x01, &[text("ros2"), text("test")].concat())
}

pub fn schema(id: u16, name: &str, encoding: &str, data: &str) -> Vec<u8> {
    let body = [
        id.to_le_bytes().to_vec(),
        text(name),
        text(encoding),
        text(data),
    ];
    record(0x03, &body.concat())
}

pub fn channel(id: u16, schema: u16, topic: &str, encoding: &str) -> Vec<u8> {
    let mut body = id.to_le_bytes().to_vec();
    body.extend(schema.to_le_bytes());
    body.extend([text(topic), text(encoding), text("")].concat());
    record(0x04, &body)
}

pub fn message(channel: u16, log_time: u64, data: &[u8]) -> Vec<u8> {
    message_at(channel, (log_time, log_time), data)
}

/// A message with its times of logging and of publishing.
pub fn message_at(channel: u16, (log, publish): (u64, u64), data: &[u8]) -> Vec<u8> {
    let mut body = channel.to_le_bytes().to_vec();
    body.extend(7_u32.to_le_bytes());
    body.extend(log.to_le_bytes());
    body.extend(publish.to_le_bytes());
    body.extend(data);
    record(0x05, &body)
}

pub fn chunk(compression: &str, size: u64, crc: u32, data: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 16];
    body.extend(size.to_le_bytes());
    body.extend(crc.to_le_bytes());
    body.extend(text(compression));
    body.extend((data.len() as u64).to_le_bytes());
    body.extend(data);
    record(0x06, &body)
}

/// Packs records into a chunk with its checksum.
pub fn packed(compression: &str, records: &[u8]) -> Vec<u8> {
    let data = match compression {
        "zstd" => {
            ruzstd::encoding::compress_to_vec(records, ruzstd::encoding::CompressionLevel::Fastest)
        }
        "lz4" => lz4(records),
        _ => records.to_vec(),
    };
    chunk(compression, records.len() as u64, crc32(records), &data)
}

pub fn lz4(records: &[u8]) -> Vec<u8> {
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    std::io::Write::write_all(&mut encoder, records).unwrap();
    encoder.finish().unwrap()
}

/// CRC-32 bit by bit (ISO 3309), apart from the crate that the reader uses.
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

pub fn data_end(crc: u32) -> Vec<u8> {
    record(0x0F, &crc.to_le_bytes())
}

pub fn statistics(by_channel: &[(u16, u64)]) -> Vec<u8> {
    let total: u64 = by_channel.iter().map(|(_, count)| count).sum();
    let mut body = total.to_le_bytes().to_vec();
    body.extend([0; 34]);
    body.extend((by_channel.len() as u32 * 10).to_le_bytes());
    for (id, count) in by_channel {
        body.extend(id.to_le_bytes());
        body.extend(count.to_le_bytes());
    }
    record(0x0B, &body)
}

pub fn footer(summary_start: u64) -> Vec<u8> {
    let mut body = summary_start.to_le_bytes().to_vec();
    body.extend([0; 12]);
    record(0x02, &body)
}

/// Puts a file together: magic, header, `data`, end of data, `summary`, footer, magic.
pub fn file(data: &[Vec<u8>], summary: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = [MAGIC, &header(), &data.concat(), &data_end(0)].concat();
    let start = if summary.is_empty() { 0 } else { bytes.len() };
    bytes.extend(summary.concat());
    bytes.extend([&footer(start as u64), MAGIC].concat());
    bytes
}

pub const START: u64 = 1_700_000_000_123_456_789;
pub const INTERVAL: u64 = 100_000;

/// Values whose last bits matter.
pub fn values(count: usize) -> Vec<f64> {
    (0..count)
        .map(|index| (index as f64 + 1.0) / 3.0 * if index % 2 == 0 { -1.0 } else { 1e3 })
        .collect()
}

pub fn stamp(index: usize) -> u64 {
    START + index as u64 * INTERVAL
}

pub fn imu_schema(id: u16) -> Vec<u8> {
    schema(id, imu::IMU_SCHEMA_NAME, "ros2msg", imu::IMU_SCHEMA)
}

/// One Imu topic on channel 1 with `count` messages.
pub fn imu_messages(count: usize) -> Vec<Vec<u8>> {
    values(count)
        .iter()
        .enumerate()
        .map(|(index, value)| {
            let data = imu::imu_message_cdr(stamp(index), "imu", [0.0, *value, 9.8]);
            message(1, stamp(index), &data)
        })
        .collect()
}

pub fn imu_data(count: usize) -> Vec<Vec<u8>> {
    let mut data = vec![imu_schema(1), channel(1, 1, "/imu", "cdr")];
    data.extend(imu_messages(count));
    data
}

// ---------------------------------------------------------------- protobuf

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push((value & 0x7F) as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

pub fn block(number: u64, content: &[u8]) -> Vec<u8> {
    [
        varint(number << 3 | 2),
        varint(content.len() as u64),
        content.to_vec(),
    ]
    .concat()
}

pub fn whole(number: u64, value: u64) -> Vec<u8> {
    [varint(number << 3), varint(value)].concat()
}

pub fn double(number: u64, value: f64) -> Vec<u8> {
    [varint(number << 3 | 1), value.to_le_bytes().to_vec()].concat()
}

/// A field of a descriptor: name, number, label, type, type name.
pub fn described(name: &str, number: u64, label: u64, kind: u64, type_name: &str) -> Vec<u8> {
    let mut field = [
        block(1, name.as_bytes()),
        whole(3, number),
        whole(4, label),
        whole(5, kind),
    ]
    .concat();
    if !type_name.is_empty() {
        field.extend(block(6, type_name.as_bytes()));
    }
    block(2, &field)
}

pub fn message_type(name: &str, fields: &[Vec<u8>]) -> Vec<u8> {
    block(4, &[block(1, name.as_bytes()), fields.concat()].concat())
}

/// `lab.Crash { Timestamp stamp = 1; Vector accel = 3; repeated double raw = 5; }`
pub fn schema_of_bytes(id: u16, name: &str, encoding: &str, data: &[u8]) -> Vec<u8> {
    let text = |text: &str| {
        [
            (text.len() as u32).to_le_bytes().to_vec(),
            text.as_bytes().to_vec(),
        ]
        .concat()
    };
    let body = [
        id.to_le_bytes().to_vec(),
        text(name),
        text(encoding),
        (data.len() as u32).to_le_bytes().to_vec(),
        data.to_vec(),
    ]
    .concat();
    record(3, &body)
}
