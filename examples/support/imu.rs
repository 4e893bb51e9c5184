//! An MCAP log as a ROS 2 recorder writes it: `sensor_msgs/msg/Imu` messages in CDR.
//!
//! Shared by the tests and by the example that makes the recordings of `signals/`, each of
//! which takes it in with `#[path]`.

#![allow(
    dead_code,
    unreachable_pub,
    reason = "each program that takes this file in uses a part of it"
)]

use std::collections::BTreeMap;
use std::io::Cursor;

/// The full name of the message type.
pub const IMU_SCHEMA_NAME: &str = "sensor_msgs/msg/Imu";

/// The definition of `sensor_msgs/msg/Imu` with every type it uses, as a recorder stores it:
/// parts divided by a line of 80 equals signs.
pub const IMU_SCHEMA: &str = "\
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance # row major about x, y, z axes
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance

================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id

================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec

================================================================================
MSG: geometry_msgs/Quaternion
float64 x 0
float64 y 0
float64 z 0
float64 w 1

================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
";

/// Returns one `sensor_msgs/msg/Imu` message in little-endian CDR, its header included.
///
/// `stamp_ns` is the instant of measurement [ns], `linear_acceleration` is along x, y and z
/// [m/s²]. Orientation and angular velocity are marked as not measured (first covariance −1).
pub fn imu_message_cdr(stamp_ns: u64, frame: &str, linear_acceleration: [f64; 3]) -> Vec<u8> {
    let mut body = Vec::new();
    let seconds = i32::try_from(stamp_ns / 1_000_000_000).expect("a stamp before the year 2038");
    let nanoseconds = u32::try_from(stamp_ns % 1_000_000_000).expect("below 10^9");
    body.extend(seconds.to_le_bytes());
    body.extend(nanoseconds.to_le_bytes());
    let length = u32::try_from(frame.len() + 1).expect("a short frame name");
    body.extend(length.to_le_bytes());
    body.extend(frame.as_bytes());
    body.push(0);
    body.resize(body.len().next_multiple_of(8), 0);
    let unmeasured = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let orientation = [0.0, 0.0, 0.0, 1.0];
    let angular_velocity = [0.0; 3];
    for value in orientation
        .iter()
        .chain(&unmeasured)
        .chain(&angular_velocity)
        .chain(&unmeasured)
        .chain(&linear_acceleration)
        .chain(&[0.0; 9])
    {
        body.extend(f64::to_le_bytes(*value));
    }
    let mut message = vec![0, 1, 0, 0];
    message.append(&mut body);
    message
}

/// Returns an MCAP log with one topic of Imu messages whose lateral (y) acceleration is
/// `lateral` [m/s²], the first at `start_ns` [ns] and each `interval_ns` [ns] after the one before.
///
/// One uncompressed chunk per 768 KiB of messages, with summary, statistics and checksums.
/// The same arguments give the same bytes.
pub fn imu_recording(topic: &str, start_ns: u64, interval_ns: u64, lateral: &[f64]) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .compression(None)
        .profile("ros2")
        .library("latchgate")
        .create(Cursor::new(Vec::new()))
        .expect("memory takes every byte");
    let schema = writer
        .add_schema(IMU_SCHEMA_NAME, "ros2msg", IMU_SCHEMA.as_bytes())
        .expect("the first schema");
    let channel_id = writer
        .add_channel(schema, topic, "cdr", &BTreeMap::new())
        .expect("the first channel");
    for (sequence, value) in (0_u32..).zip(lateral) {
        let stamp = start_ns + u64::from(sequence) * interval_ns;
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence,
            log_time: stamp,
            publish_time: stamp,
        };
        let data = imu_message_cdr(stamp, "imu", [0.0, *value, 9.806_65]);
        writer
            .write_to_known_channel(&header, &data)
            .expect("memory takes every byte");
    }
    writer.finish().expect("memory takes every byte");
    writer.into_inner().into_inner()
}
