//! The `.EV5`: one line for each curve, fields divided by `|`.

use crate::error::{Error, Place};
use crate::examine::clock;
use crate::held::{self, Statement};
use crate::remarks::{self, Remark, Span};
use crate::words::{Words, word_list};
use crate::{Finding, Limits, SensorPlace, Stated, TestFacts, encoding, text, time_base};
use latchgate_kernel::units::{AccelerationUnit, SampleRate};
use std::ops::Range;
use std::rc::Rc;

/// Fields of a line of instrumentation.
const FIELDS: usize = 20;

/// Seat field of a sensor on the vehicle itself.
const NO_SEAT: &[&str] = &["", "NA", "N/A", "0", "00"];

/// Beginnings of the attachments that are plainly on a vehicle's structure.
static STRUCTURE: Words = word_list!("nhtsa-structure");

/// Beginnings of attachments that may be doors. Which of them are is not known for certain, and a door needs no
/// word: so nothing is known of their place until a card states it.
const MAY_BE_DOOR: [&str; 2] = ["DO", "DR"];

/// The instrumentation of a test.
#[derive(Debug)]
pub(super) struct TestInstruments {
    pub(super) entries: Vec<CurveEntry>,
}

/// A curve as its line describes it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CurveEntry {
    vehicle: u32,
    pub(super) number: u32,
    /// Its line, codes in capitals, and the range of each field in it.
    line: String,
    fields: [Range<usize>; FIELDS],
    /// Facts of the test.
    test: Rc<TestSections>,
}

// Positions of fields in a line.
/// Type of sensor: `AC` for acceleration.
pub(super) const SENSOR: usize = 2;
const SEAT: usize = 3;
const ATTACHMENT: usize = 4;
const AXIS: usize = 5;
const X_UNIT: usize = 6;
pub(super) const Y_UNIT: usize = 7;
const PREFILTER: usize = 8;
/// Make and serial number of the sensor, and the day of its calibration.
const MAKE: usize = 9;
const CALIBRATED: usize = 10;
const RATING: usize = 11;
/// Largest magnitude, in percent of the rating.
const PEAK_PERCENT: usize = 12;
/// Indices of the first and the last sample; the one at first contact is 0.
const FIRST: usize = 14;
const LAST: usize = 15;
/// Interval as printed [µs].
const INTERVAL_US: usize = 16;
const STATUS: usize = 17;
const RANK: usize = 18;
const COMMENT: usize = 19;

/// Fields that hold codes, which some programs write in small letters.
const CODES: [usize; 7] = [SENSOR, SEAT, ATTACHMENT, AXIS, X_UNIT, STATUS, RANK];

impl TestInstruments {
    pub(super) fn read(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Error> {
        let (content, _) = encoding::text_of(bytes, limits)?;
        let mut entries: Vec<CurveEntry> = Vec::new();
        let mut section = String::new();
        let mut test = TestSections::default();
        for (number, line) in text::lines(&content) {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                test.comment(line);
                continue;
            }
            if let Some(name) = line.strip_prefix("-----") {
                section = name.trim_end_matches('-').trim().to_string();
                continue;
            }
            if section != "INSTRUMENTATION" {
                test.line(&section, line);
                continue;
            }
            let place = Place::default().line(number);
            let entry = CurveEntry::read(line).map_err(|error| error.at(place.clone()))?;
            if entries.iter().any(|earlier| earlier.number == entry.number) {
                return Err(Error::malformed(
                    "one line for each curve",
                    format!("curve {} twice", entry.number),
                    "keep the right one in the .EV5",
                )
                .at(place));
            }
            if entries.len() as u64 >= limits.archive_entries {
                return Err(limits.over("archive_entries", "more curves").at(place));
            }
            entries.push(entry);
        }
        let test = Rc::new(test);
        for entry in &mut entries {
            entry.test = Rc::clone(&test);
        }
        Ok(Self { entries })
    }

    pub(super) fn find(&self, number: u32) -> Option<&CurveEntry> {
        self.entries.iter().find(|entry| entry.number == number)
    }
}

/// Facts from the sections before the instrumentation.
#[derive(Debug, Default, PartialEq)]
struct TestSections {
    number: Option<String>,
    facts: TestFacts,
    /// Number, year and identification of each vehicle.
    vehicles: Vec<(u32, String)>,
}

impl TestSections {
    /// Reads a comment: the database writes the test's number there.
    fn comment(&mut self, line: &str) {
        if let Some((_, number)) = line.split_once("Test Number:") {
            let number = number.trim().trim_start_matches('0');
            self.number = (!number.is_empty()).then(|| number.to_string());
        }
    }

    /// Reads a line of another section.
    fn line(&mut self, section: &str, line: &str) {
        let fields: Vec<&str> = line.split('|').map(str::trim).collect();
        let field = |index: usize| {
            let text = fields.get(index).copied().unwrap_or("");
            (!text.is_empty() && text != "0").then(|| text.to_string())
        };
        match section {
            "TEST" => {
                let numbered = self.number.clone().into_iter().chain(field(1));
                let test: Vec<String> = numbered.collect();
                self.facts = TestFacts {
                    test: (!test.is_empty()).then(|| test.join(", ")),
                    date: field(3),
                    laboratory: field(4),
                    speed: field(14).map(|speed| format!("{speed} km/h")),
                    ..TestFacts::default()
                };
            }
            "VEHICLE" => {
                if let Ok(number) = fields[0].parse() {
                    let year = field(3).into_iter();
                    let identity = field(6).map(|identity| format!("VIN {identity}"));
                    let words: Vec<String> = year.chain(identity).collect();
                    self.vehicles.push((number, words.join(", ")));
                }
            }
            _ => {}
        }
    }

    /// Returns the facts of the test of a curve and of its sensor.
    fn of(&self, entry: &CurveEntry) -> TestFacts {
        let mut vehicles = self.vehicles.iter();
        let vehicle = vehicles.find(|(number, _)| *number == entry.vehicle);
        let labelled = |name: &str, text: &str| {
            let empty = text.is_empty() || text == "0";
            (!empty).then(|| format!("{name}{text}"))
        };
        let range = |rating| format!("range {rating} {}", entry.of(Y_UNIT));
        let sensor = [
            labelled("", entry.of(MAKE)),
            labelled("calibrated ", entry.of(CALIBRATED)),
            entry.rating().map(range),
        ];
        let sensor: Vec<String> = sensor.into_iter().flatten().collect();
        TestFacts {
            vehicle: vehicle.map(|(number, words)| format!("vehicle {number}: {words}")),
            sensor: (!sensor.is_empty()).then(|| sensor.join(", ")),
            location: Some(format!("{} {}", entry.of(ATTACHMENT), entry.of(AXIS))),
            ..self.facts.clone()
        }
    }
}

impl CurveEntry {
    fn read(line: &str) -> Result<Self, Error> {
        let mut line = line.to_string();
        let mut fields = [const { 0..0 }; FIELDS];
        let mut count = 0;
        let mut from = 0;
        // The comment is the last field and may hold a `|` itself; lines of other sections end with one.
        for text in line.splitn(FIELDS, '|') {
            let trimmed = text.trim();
            let start = from + text.len() - text.trim_start().len();
            fields[count] = start..start + trimmed.len();
            count += 1;
            from += text.len() + 1;
        }
        if count < FIELDS - 1 {
            return Err(Error::malformed(
                format!("{FIELDS} fields divided by |"),
                format!("{count}"),
                "the .EV5 is damaged; fetch it again",
            ));
        }
        let parts: Vec<&str> = line[fields[COMMENT].clone()]
            .split('|')
            .map(str::trim)
            .collect();
        let joined = parts.join("|");
        let comment = joined.trim_end_matches('|').trim();
        fields[COMMENT] = line.len()..line.len() + comment.len();
        line.push_str(comment);
        for code in CODES {
            line[fields[code].clone()].make_ascii_uppercase();
        }
        let entry = Self {
            vehicle: 0,
            number: 0,
            line,
            fields,
            test: Rc::default(),
        };
        Ok(Self {
            vehicle: entry.whole(0, "the vehicle's number")?,
            number: entry.whole(1, "the curve's number")?,
            ..entry
        })
    }

    fn whole(&self, field: usize, what: &str) -> Result<u32, Error> {
        self.of(field).parse().map_err(|_| {
            Error::malformed(
                format!("{what} in field {}", field + 1),
                format!("`{}`", text::shown(self.of(field))),
                "the .EV5 is damaged; fetch it again",
            )
        })
    }

    /// Returns a field.
    pub(super) fn of(&self, field: usize) -> &str {
        &self.line[self.fields[field].clone()]
    }

    /// Returns the channel's name: number, vehicle, sensor, attachment, axis and rank.
    pub(super) fn name(&self) -> String {
        let mut name = format!("{} V{} {}", self.number, self.vehicle, self.of(SENSOR));
        if !self.is_seatless() {
            name.push_str(&format!(" seat {}", self.of(SEAT)));
        }
        name.push_str(&format!(" {} {}", self.of(ATTACHMENT), self.of(AXIS)));
        if self.is_redundant() {
            name.push_str(" redundant");
        }
        name
    }

    /// True if a requested name means this curve: its number, its name, or attachment and axis.
    pub(super) fn answers_to(&self, requested: &str) -> bool {
        let requested = requested.trim().to_ascii_uppercase();
        requested.parse() == Ok(self.number)
            || requested == self.name().to_ascii_uppercase()
            || requested == format!("{} {}", self.of(ATTACHMENT), self.of(AXIS))
    }

    /// True if the sensor has no seat, as one in a dummy has.
    fn is_seatless(&self) -> bool {
        NO_SEAT.contains(&self.of(SEAT))
    }

    /// True if it is a second sensor at a place that has one.
    pub(super) fn is_redundant(&self) -> bool {
        self.of(RANK) == "R"
    }

    /// Returns the key that primary and redundant sensors of one place share.
    pub(super) fn place(&self) -> (u32, &str, &str) {
        (self.vehicle, self.of(ATTACHMENT), self.of(AXIS))
    }

    pub(super) fn unit(&self) -> Option<AccelerationUnit> {
        let plain = self.of(Y_UNIT).to_ascii_uppercase();
        match plain.as_str() {
            "METERS/SEC**2" | "M/S**2" => Some(AccelerationUnit::MetrePerSecondSquared),
            _ => AccelerationUnit::from_spelling(self.of(Y_UNIT)),
        }
        .filter(|_| self.of(SENSOR) == "AC" || self.of(SENSOR).is_empty())
    }

    /// Returns time of the first sample [s] and rate as the line states them.
    pub(super) fn clock(&self) -> Option<(f64, SampleRate)> {
        let interval_us = text::header_number(self.of(INTERVAL_US)).filter(|us| *us > 0.0)?;
        let digit = text::last_digit(self.of(INTERVAL_US));
        let rate = time_base::rate_of_interval(interval_us / 1e6, digit / 1e6).ok()?;
        let is_whole = |number: &f64| number.fract().total_cmp(&0.0).is_eq();
        let first = text::header_number(self.of(FIRST)).filter(is_whole)?;
        // The product of whole microseconds is exact, and so is the nearest double to its
        // quotient; index over rate may be off by a last bit.
        let product = first * interval_us;
        let by_rate = first / rate.hertz();
        let by_product = product / 1e6;
        let start = if (by_rate - by_product).abs() <= 8.0 * f64::EPSILON * by_rate.abs() {
            by_product
        } else {
            by_rate
        };
        Some((start, rate))
    }

    /// Returns half a microsecond of the interval's last digit by the interval [-].
    pub(super) fn interval_slack(&self) -> f64 {
        clock::slack(self.of(INTERVAL_US))
    }

    /// Returns the finding that the stated unit of time is not seconds, as this format's stamps are;
    /// `confirmed` is true if indices and interval agree with seconds.
    pub(super) fn time_unit_finding(&self, confirmed: bool) -> Option<Finding> {
        const SECONDS: [&str; 6] = ["", "S", "SEC", "SECS", "SECOND", "SECONDS"];
        if SECONDS.contains(&self.of(X_UNIT)) {
            return None;
        }
        let text = format!(
            "the header states `{}` as the unit of time (XUNITS), but this format has seconds. The \
             stamps were read as seconds. Indices and interval",
            text::shown(self.of(X_UNIT))
        );
        Some(match confirmed {
            true => Finding::warning("time-unit-overridden", format!("{text} confirm that")),
            false => Finding::blocking(
                "time-contradicted",
                format!("{text} do not confirm that. Correct the .EV5"),
            ),
        })
    }

    pub(super) fn stated(&self) -> Stated {
        let status = self.of(STATUS);
        Stated {
            location: Some(format!("{} {}", self.of(ATTACHMENT), self.of(AXIS))),
            place: self.sensor_place(),
            full_scale: self.rating(),
            prefilter_hz: text::header_number(self.of(PREFILTER)).filter(|corner| *corner > 0.0),
            status: (!status.is_empty()).then(|| status.to_string()),
            test: self.test.of(self),
            ..Stated::default()
        }
    }

    /// Returns the place of a sensor that plainly sits on the body.
    fn sensor_place(&self) -> Option<SensorPlace> {
        let begins = |start: &&str| self.of(ATTACHMENT).starts_with(*start);
        let is_body =
            self.is_seatless() && STRUCTURE.iter().any(begins) && !MAY_BE_DOOR.iter().any(begins);
        is_body.then_some(SensorPlace::Body)
    }

    /// Returns the reason why the curve is not chosen as a lateral acceleration of the vehicle's structure
    /// unless it is named.
    pub(super) fn doubt(&self) -> Option<String> {
        let is_plain = |start: &&str| self.of(ATTACHMENT).starts_with(*start);
        let sensor = self.of(SENSOR);
        Some(if sensor != "AC" {
            format!("its sensor type is {sensor}, not AC (acceleration)")
        } else if !self.of(AXIS).starts_with('Y') {
            format!("its axis is {}, not a lateral one", self.of(AXIS))
        } else if !self.is_seatless() {
            "it sits in a dummy, not on the vehicle's structure".into()
        } else if !STRUCTURE.iter().any(is_plain) {
            let place = self.of(ATTACHMENT);
            format!("its attachment {place} is not known as part of the structure")
        } else {
            return None;
        })
    }

    pub(super) fn not_lateral_finding(&self) -> Option<Finding> {
        Some(Finding::not_lateral(&self.name(), &self.doubt()?))
    }

    /// Returns the laboratory's free words on the curve.
    pub(super) fn remark(&self) -> Remark {
        Remark::of_channel(&[self.of(COMMENT)])
    }

    /// Returns the finding on the status of the samples; the comment may state its instant.
    pub(super) fn status_finding(&self, span: Span) -> Option<Finding> {
        let (word, part_way) = match self.of(STATUS) {
            "" | "AM" => return None,
            "CM" => {
                let text = "the laboratory computed this channel from others. Prefer a measured \
                            one";
                return Some(Finding::info("channel-computed", text));
            }
            "QD" => ("questionable data", true),
            "CF" => ("data that become invalid part-way", true),
            "MN" => ("meaningless data", false),
            "NO" => ("no data", false),
            _ => ("an unknown status", false),
        };
        let from = remarks::plainly_bad_from(&[self.remark()]);
        let from = from.filter(|at_s| part_way && span.holds(*at_s));
        let text = format!(
            "the laboratory states {word} (status {}). Use another channel",
            self.of(STATUS)
        );
        Some(Finding::blocking("invalid-by-laboratory", text).since(from))
    }

    /// Returns the findings on compared fields that cannot be read.
    pub(super) fn unread_findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        type Fits = fn(f64) -> bool;
        let is_whole: Fits = |number| number.fract().total_cmp(&0.0).is_eq();
        let is_positive: Fits = |number| number > 0.0;
        // A rating or a filter of 0 means none.
        let is_rating: Fits = |number| number >= 0.0;
        let fields = [
            ("NFP", FIRST, is_whole),
            ("NLP", LAST, is_whole),
            ("DELT", INTERVAL_US, is_positive),
            ("INSRAT", RATING, is_rating),
            ("CHLMAX", PEAK_PERCENT, is_rating),
            ("PREFIL", PREFILTER, is_rating),
        ];
        for (key, field, fits) in fields {
            let text = self.of(field);
            if !text.is_empty() || matches!(field, FIRST | LAST | INTERVAL_US) {
                Statement { key, text }.number(fits, &mut findings);
            }
        }
        findings
    }

    /// Compares the stated peak, in percent of the rating, with the samples.
    pub(super) fn peak_finding(&self, values: &[f64]) -> Option<Finding> {
        let (rating, stated) = (self.rating()?, text::header_number(self.of(PEAK_PERCENT))?);
        let peak = values.iter().copied().map(f64::abs).fold(0.0, f64::max);
        let found = 100.0 * peak / rating;
        // The percentage is printed whole; a shortened or filtered copy differs by more.
        ((found - stated).abs() > 1.0 + 0.02 * stated.abs()).then(|| {
            let text = format!(
                "the header states a peak of {stated} % of the range of {rating} (CHLMAX), but the \
                 samples reach {found:.1} %. Unit or range is wrong, or samples are cut off or not \
                 of this header. Check unit and files"
            );
            Finding::blocking("peak-contradicted", text)
        })
    }

    /// Compares the stated number of samples with the file.
    pub(super) fn count_finding(&self, found: usize, end_s: f64) -> Option<Finding> {
        let stated =
            text::header_number(self.of(LAST))? - text::header_number(self.of(FIRST))? + 1.0;
        held::count("the header (NFP, NLP)", stated, found, true, end_s)
    }

    /// Returns the full scale, if one is stated.
    fn rating(&self) -> Option<f64> {
        text::header_number(self.of(RATING)).filter(|rating| *rating > 0.0)
    }
}
