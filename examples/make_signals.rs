//! Makes the recordings in `signals/`, each from a formula, with its card.
//!
//! `cargo run --example make_signals` writes the folder again, byte for byte the same;
//! `cargo run --example make_signals -- FOLDER` writes elsewhere. The bytes do not depend on
//! the machine: sines come from `libm`, noise from a seeded integer generator, values are
//! printed with fixed decimals.
//!
//! A negative acceleration opens the lever in all of them. They start 20 ms or more before first
//! contact (time 0), carry a little sensor noise from the first sample to the last, and have
//! died away at their end.

#![allow(clippy::disallowed_methods, reason = "a program of its own")]

use latchgate_kernel::pulse::Pulse;
use std::collections::BTreeMap;
use std::error::Error;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

#[path = "support/imu.rs"]
mod imu;

/// Standard gravity [m/s²].
const STANDARD_GRAVITY: f64 = 9.806_65;

/// One file of `signals/`: name and content.
pub(crate) type File = (String, Vec<u8>);

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| {
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("signals")
            .display()
            .to_string()
    });
    std::fs::create_dir_all(&folder)?;
    for (name, bytes) in all()? {
        std::fs::write(Path::new(&folder).join(name), bytes)?;
    }
    Ok(())
}

/// Returns every file of `signals/`.
pub(crate) fn all() -> Result<Vec<File>, Box<dyn Error>> {
    let mut files = Vec::new();
    for recording in [
        burst(),
        half_sine(),
        sill(),
        sled(),
        surviving(),
        burst_imu()?,
        ugly(),
    ] {
        files.push((format!("{}.toml", recording.name), recording.card()));
        files.push((recording.name.to_string(), recording.bytes));
    }
    files.sort();
    Ok(files)
}

/// A recording with what its card says.
struct Recording {
    name: &'static str,
    channel: &'static str,
    unit: &'static str,
    rate_hz: u32,
    range_g: u32,
    /// Sets the card's key `synthetic`, which switches the checks for clipping and dead sensors off.
    synthetic: bool,
    /// What the card states of a push that is weaker than a crash's, by the formula [m/s].
    velocity_change_m_s: Option<f64>,
    notes: String,
    bytes: Vec<u8>,
}

impl Recording {
    fn card(&self) -> Vec<u8> {
        let synthetic = if self.synthetic {
            "synthetic = true\n"
        } else {
            ""
        };
        let velocity = self
            .velocity_change_m_s
            .map_or_else(String::new, |velocity| {
                format!("velocity_change_m_s = {velocity}\n")
            });
        format!(
            "channel = \"{}\"\nunit = \"{}\"\nopens_when = \"negative\"\nrate = {}.0\nrange_g = {}.0\n{synthetic}{velocity}\
             place = \"door\"\ntransfer = 1\n\
             source = \"computed by examples/make_signals.rs of latchgate; measured nowhere\"\n\
             licence = \"CC0-1.0\"\nnotes = \"\"\"\n{}\"\"\"\n",
            self.channel, self.unit, self.rate_hz, self.range_g, self.notes
        )
        .into_bytes()
    }
}

/// Samples at `rate_hz` from index `first` to `last`, index 0 being first contact.
#[derive(Clone, Copy)]
struct Grid {
    rate_hz: u32,
    first: i32,
    last: i32,
}

impl Grid {
    fn time_s(self, index: i32) -> f64 {
        f64::from(index) / f64::from(self.rate_hz)
    }

    /// Evaluates `formula` [g] at each sample and adds `noise_g` (one standard deviation).
    fn sample(self, formula: impl Fn(f64) -> f64, noise_g: f64, seed: u64) -> Vec<(i32, f64)> {
        let mut noise = Noise(seed);
        (self.first..=self.last)
            .map(|index| {
                (
                    index,
                    formula(self.time_s(index)) + noise_g * noise.next_value(),
                )
            })
            .collect()
    }
}

/// SplitMix64 (Steele, Lea and Flood, 2014), four uniform draws summed to mean 0 and variance 1.
struct Noise(u64);

impl Noise {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn uniform(&mut self) -> f64 {
        let upper = u32::try_from(self.bits() >> 32).expect("32 bits are left");
        f64::from(upper) / 4_294_967_296.0
    }

    fn next_value(&mut self) -> f64 {
        let sum = self.uniform() + self.uniform() + self.uniform() + self.uniform();
        (sum - 2.0) * 3.0_f64.sqrt()
    }
}

/// Prints with fixed decimals, never `-0.000`.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.bytes().any(|byte| matches!(byte, b'1'..=b'9')) {
        text
    } else {
        text.trim_start_matches('-').to_string()
    }
}

fn table(header: &str, grid: Grid, samples: &[(i32, f64)], time_decimals: usize) -> Vec<u8> {
    let mut text = format!("{header}\n");
    for (index, value) in samples {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{},{}",
            fixed(grid.time_s(*index), time_decimals),
            fixed(*value, 4)
        );
    }
    text.into_bytes()
}

fn half_sine_g(t: f64, amplitude_g: f64, duration_s: f64) -> f64 {
    let peak = amplitude_g;
    Pulse::HalfSine { peak, duration_s }.at(t)
}

/// Scale that brings the largest sample of the burst at 20 kHz to 1000 g.
const BURST_SCALE_G: f64 = 148.8;

/// A sin² envelope of 35 ms over 24 tones from 20 to 480 Hz whose phases follow the golden ratio.
pub(crate) fn burst_g(t: f64) -> f64 {
    let burst = Pulse::Burst {
        scale: BURST_SCALE_G,
        duration_s: 0.035,
        phases: 5.0,
    };
    burst.at(t)
}

const BURST_FORMULA: &str = "\
a(t) = S sin^2(pi t/D) sum over j = 1..24 of sin(2 pi (20 j t + p_j)), 0 <= t <= D, else 0,
with D = 35 ms, p_j = frac(5 P j^2) and P = (sqrt(5)-1)/2.
";

fn burst() -> Recording {
    let grid = Grid {
        rate_hz: 20_000,
        first: -1000,
        last: 5000,
    };
    let samples = grid.sample(burst_g, 0.05, 11);
    Recording {
        name: "burst.csv",
        channel: "acceleration y (g)",
        unit: "g",
        rate_hz: grid.rate_hz,
        range_g: 2000,
        synthetic: true,
        velocity_change_m_s: None,
        notes: format!(
            "A burst of 35 ms whose peak is near 1000 g, of the kind that a latch sees in a side impact.\n\
             {BURST_FORMULA}S = {BURST_SCALE_G} g; noise of 0.05 g rms, seed 11.\n"
        ),
        bytes: table("time (s),acceleration y (g)", grid, &samples, 5),
    }
}

fn half_sine() -> Recording {
    let grid = Grid {
        rate_hz: 10_000,
        first: -500,
        last: 2500,
    };
    let samples = grid.sample(|t| half_sine_g(t, -30.0, 0.011), 0.03, 12);
    Recording {
        name: "half_sine_30g_11ms.csv",
        channel: "acceleration y (g)",
        unit: "g",
        rate_hz: grid.rate_hz,
        range_g: 200,
        synthetic: true,
        velocity_change_m_s: None,
        notes: "A half-sine: a(t) = -30 g sin(pi t/D), 0 <= t <= D = 11 ms, else 0.\n\
                Noise of 0.03 g rms, seed 12.\n"
            .into(),
        bytes: table("time (s),acceleration y (g)", grid, &samples, 4),
    }
}

/// Scale that brings the largest sample of the sill's pulse to 60 g.
const SILL_SCALE: f64 = 1.376;

/// Tones of a struck sill: start [s], frequency [Hz], decay [s], amplitude [g].
const SILL_TONES: [(f64, f64, f64, f64); 5] = [
    (0.001, 95.0, 0.018, 16.0),
    (0.004, 212.0, 0.012, 18.0),
    (0.012, 347.0, 0.010, 17.0),
    (0.021, 148.0, 0.016, 15.0),
    (0.030, 520.0, 0.008, 8.0),
];

/// Two overlapping pushes, under which the structure rings.
pub(crate) fn sill_g(t: f64) -> f64 {
    let haversine = |start_s: f64, duration_s: f64| {
        let share = (t - start_s) / duration_s;
        match (0.0..=1.0).contains(&share) {
            true => 0.5 * (1.0 - libm::cos(2.0 * PI * share)),
            false => 0.0,
        }
    };
    let tones = SILL_TONES.iter().filter(|tone| t > tone.0);
    let tones = tones.map(|(start_s, frequency_hz, decay_s, amplitude_g)| {
        let since_s = t - start_s;
        let rises = 1.0 - libm::exp(-since_s / 0.0008);
        let tone = libm::sin(2.0 * PI * frequency_hz * since_s);
        amplitude_g * tone * rises * libm::exp(-since_s / decay_s)
    });
    let pushes = 26.0 * haversine(0.0, 0.026) + 20.0 * haversine(0.014, 0.050);
    -SILL_SCALE * (pushes + tones.sum::<f64>())
}

fn sill() -> Recording {
    let grid = Grid {
        rate_hz: 10_000,
        first: -400,
        last: 1600,
    };
    let samples = grid.sample(sill_g, 0.05, 18);
    let tones = SILL_TONES
        .iter()
        .map(|(start_s, frequency_hz, decay_s, amplitude_g)| {
            format!(
                "{} ms, {frequency_hz} Hz, {} ms, {amplitude_g} g\n",
                1e3 * start_s,
                1e3 * decay_s
            )
        });
    Recording {
        name: "sill_60g.csv",
        channel: "acceleration y (g)",
        unit: "g",
        rate_hz: grid.rate_hz,
        range_g: 500,
        synthetic: true,
        velocity_change_m_s: None,
        notes: format!(
            "A pulse like that of a struck door sill: two pushes, under which the structure rings.\n\
             a(t) = -{SILL_SCALE} (26 g h(t, 0, 26 ms) + 20 g h(t, 14 ms, 50 ms) + sum of tones), h(t, t0, D) = (1 - cos(2 pi (t - t0)/D))/2\n\
             for 0 <= t - t0 <= D, else 0; each tone from its start t0 on A (1 - exp(-(t - t0)/0.8 ms)) exp(-(t - t0)/tau) sin(2 pi f (t - t0)),\n\
             t0, f, tau, A:\n{}\
             Noise of 0.05 g rms, seed 18.\n",
            tones.collect::<String>()
        ),
        bytes: table("time (s),acceleration y (g)", grid, &samples, 4),
    }
}

/// A plateau of 33 g between shoulders of half a cosine, up in 23 ms, down from 56 to 84 ms.
pub(crate) fn sled_g(t: f64) -> f64 {
    let shoulder = |share: f64| (1.0 - libm::cos(PI * share)) / 2.0;
    let height = if !(0.0..=0.084).contains(&t) {
        0.0
    } else if t < 0.023 {
        shoulder(t / 0.023)
    } else if t <= 0.056 {
        1.0
    } else {
        shoulder((0.084 - t) / 0.028)
    };
    -33.0 * height
}

fn sled() -> Recording {
    let grid = Grid {
        rate_hz: 10_000,
        first: -500,
        last: 2500,
    };
    let samples = grid.sample(sled_g, 0.03, 13);
    Recording {
        name: "sled_30g_30ms.csv",
        channel: "acceleration y (g)",
        unit: "g",
        rate_hz: grid.rate_hz,
        range_g: 200,
        synthetic: true,
        velocity_change_m_s: None,
        notes: "A pulse like that of a door-latch sled test: above 30 g for more than 30 ms.\n\
                It is not the pulse of any regulation. Its shape lies inside a corridor known at second hand only:\n\
                upper (0 ms, 6 g) (20, 36) (60, 36) (100, 0), lower (5, 0) (25, 30) (55, 30) (70, 0).\n\
                a(t) = -33 g h(t): h rises as (1 - cos(pi t/23 ms))/2 to 1 at 23 ms, stays until 56 ms,\n\
                and falls as (1 - cos(pi (84 ms - t)/28 ms))/2 to 0 at 84 ms.\n\
                Noise of 0.03 g rms, seed 13.\n"
            .into(),
        bytes: table("time (s),acceleration y (g)", grid, &samples, 4),
    }
}

/// A short push with a weak rebound.
pub(crate) fn surviving_g(t: f64) -> f64 {
    half_sine_g(t, -5.0, 0.010) + half_sine_g(t - 0.010, 0.5, 0.030)
}

fn surviving() -> Recording {
    let grid = Grid {
        rate_hz: 10_000,
        first: -500,
        last: 2500,
    };
    let samples = grid.sample(surviving_g, 0.02, 14);
    Recording {
        name: "surviving.csv",
        channel: "acceleration y (g)",
        unit: "g",
        rate_hz: grid.rate_hz,
        range_g: 50,
        // The record is noisy enough to stand the checks that the key would switch off, and a
        // damaged copy of it that keeps the card shall be found out.
        synthetic: false,
        velocity_change_m_s: Some(0.22),
        notes: "A pulse that the paper's lever survives on both stops:\n\
                a(t) = -5 g sin(pi t/10 ms) for 0 <= t <= 10 ms, then a rebound of\n\
                +0.5 g sin(pi (t - 10 ms)/30 ms) for 10 <= t <= 40 ms, else 0.\n\
                Noise of 0.02 g rms, seed 14. The key `synthetic` is left out although the signal is computed:\n\
                the checks for clipping and dead sensors hold for it, and for any damaged copy. By the formula the\n\
                velocity changes by 0.2186 m/s.\n"
            .into(),
        bytes: table("time (s),acceleration y (g)", grid, &samples, 4),
    }
}

/// The burst at 10 kHz as a log of `sensor_msgs/msg/Imu`.
fn burst_imu() -> Result<Recording, Box<dyn Error>> {
    const RATE_HZ: u32 = 10_000;
    // The logger's clock at the first sample; first contact comes 20 ms later.
    const START_NS: u64 = 100_000_000_000;
    const STEP_NS: u64 = 1_000_000_000 / RATE_HZ as u64;
    let grid = Grid {
        rate_hz: RATE_HZ,
        first: -200,
        last: 1000,
    };
    let lateral = grid.sample(burst_g, 0.05, 15);
    let mut noise = Noise(16);
    let mut transport = Noise(17);

    let mut writer = mcap::WriteOptions::new()
        .profile("ros2")
        .library("latchgate make_signals")
        .compression(None)
        .create(std::io::Cursor::new(Vec::new()))?;
    let schema = writer.add_schema(imu::IMU_SCHEMA_NAME, "ros2msg", imu::IMU_SCHEMA.as_bytes())?;
    let channel = writer.add_channel(schema, "/door/imu", "cdr", &BTreeMap::new())?;
    for (sequence, (_, lateral_g)) in (0_u32..).zip(&lateral) {
        let stamp_ns = START_NS + u64::from(sequence) * STEP_NS;
        let data = imu::imu_message_cdr(
            stamp_ns,
            "door",
            [
                0.05 * STANDARD_GRAVITY * noise.next_value(),
                STANDARD_GRAVITY * lateral_g,
                STANDARD_GRAVITY * (1.0 + 0.05 * noise.next_value()),
            ],
        );
        // A message reaches the logger 2 ms late, give or take some microseconds.
        let late_ns = 2_000_000 + transport.bits() % 40_000;
        writer.write_to_known_channel(
            &mcap::records::MessageHeader {
                channel_id: channel,
                sequence,
                log_time: stamp_ns + late_ns,
                publish_time: stamp_ns,
            },
            &data,
        )?;
    }
    writer.finish()?;
    Ok(Recording {
        name: "burst_imu.mcap",
        channel: "/door/imu:linear_acceleration.y",
        unit: "m/s2",
        rate_hz: RATE_HZ,
        range_g: 2000,
        synthetic: true,
        velocity_change_m_s: None,
        notes: format!(
            "The burst of burst.csv at 10 kHz as ROS 2 sensor_msgs/msg/Imu on /door/imu, times 9.80665 m/s^2 per g.\n\
             {BURST_FORMULA}S = {BURST_SCALE_G} g; noise of 0.05 g rms, seeds 15 to 17; z carries 1 g of gravity.\n\
             The header stamps start at 100.00 s; first contact is at 100.02 s (--time-zero 100.02).\n\
             Log times are 2 ms late with a jitter of 40 us.\n"
        ),
        bytes: writer.into_inner().into_inner(),
    })
}

/// A haversine as a spreadsheet of another country would export it.
fn ugly() -> Recording {
    let grid = Grid {
        rate_hz: 10_000,
        first: -500,
        last: 2000,
    };
    let samples = grid.sample(
        |t| {
            if (0.0..=0.020).contains(&t) {
                let s = libm::sin(PI * t / 0.020);
                -40.0 * s * s
            } else {
                0.0
            }
        },
        0.03,
        18,
    );
    let mut temperature = Noise(19);
    let mut text = String::from(
        "# Prüfstand 3, Schlitten\r\n# Messbereich ±200 g\r\n# Empfänger: Türschloss, quer\r\n\
         time;acceleration_y;temperature\r\nms;m/s²;°C\r\n",
    );
    for (index, value) in &samples {
        let cells = [
            fixed(1000.0 * grid.time_s(*index), 1),
            fixed(STANDARD_GRAVITY * value, 3),
            fixed(21.5 + 0.1 * temperature.next_value(), 1),
        ];
        text.push_str(&cells.join(";").replace('.', ","));
        text.push_str("\r\n");
    }
    Recording {
        name: "ugly.csv",
        channel: "acceleration_y",
        unit: "m/s2",
        rate_hz: grid.rate_hz,
        range_g: 200,
        synthetic: true,
        velocity_change_m_s: None,
        notes: "A haversine, a(t) = -40 g sin^2(pi t/20 ms), 0 <= t <= 20 ms, else 0, times 9.80665 m/s^2 per g;\n\
                noise of 0.03 g rms, seeds 18 and 19. Written the hard way: ISO-8859-1, CRLF, semicolons,\n\
                decimal commas, comment lines (one of which speaks of g), a units row, time in ms, a column\n\
                that is no acceleration.\n"
            .into(),
        bytes: latin_1(&text),
    }
}

/// Encodes as ISO-8859-1; every character used lies below U+0100.
fn latin_1(text: &str) -> Vec<u8> {
    text.chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap_or(b'?'))
        .collect()
}
