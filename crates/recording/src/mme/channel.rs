//! Channel files: header and samples.
//!
//! The header is read by its keys, the samples line by line. Both are in this file since the header's
//! statements (extremes, times, count) are compared with the samples.

use crate::TestFacts;
use crate::channel_name::ChannelName;
use crate::code::{self, CLASSES, Code};
use crate::draft::UniformSamples;
use crate::error::{Error, Place};
use crate::examine::clock::{self, Comparison, HeaderClock};
use crate::held::{self, Statement};
use crate::number::{Decimal, PrintedDigits};
use crate::remarks::{self, Remark, Span};
use crate::words::{Words, word_list};
use crate::{Finding, Limits, Stated, encoding, fact, joined_facts, text, time_base};
use latchgate_kernel::units::{AccelerationUnit, SampleRate};

/// Value that means "nothing".
const NOTHING: &str = "NOVALUE";

// The head of each list explains it.
static STATED_ONCE: Words = word_list!("iso-mme-once");
static MEASURED: Words = word_list!("iso-mme-measured");
static COMPUTED: Words = word_list!("iso-mme-computed");

/// Values of the channel frequency class that mean no filter.
const UNFILTERED: [&str; 3] = ["0", "NONE", "UNFILTERED"];

/// Part of the largest magnitude by which a stated extreme may differ [-].
const EXTREME_AGREEMENT: f64 = 1e-4;

/// Fewest samples from the first one to an instant that can confirm the interval.
const FAR_SAMPLES: f64 = 20.0;

/// Fewest words of a line without a key that continues the text before it.
const WORDS_OF_TEXT: usize = 3;

/// Kind of a line of a channel file, up to its first sample.
enum HeaderLine<'a> {
    Key(&'a str, &'a str),
    /// Text that was cut at a fixed width and goes on.
    Continued(&'a str),
    /// A sample, or a text in its place.
    Sample,
}

/// Distinguishes header from samples. Only text of several words continues a line without a key: anything
/// shorter may be meant as a sample, and is refused as one.
fn header_line(line: &str) -> HeaderLine<'_> {
    if let Some((key, value)) = line.split_once(':')
        && key.chars().any(char::is_alphabetic)
    {
        return HeaderLine::Key(key.trim(), value.trim());
    }
    let is_word = |word: &str| word.starts_with(char::is_alphabetic);
    let words = line.split_whitespace().filter(|word| is_word(word)).count();
    if words >= WORDS_OF_TEXT && is_word(line) {
        HeaderLine::Continued(line)
    } else {
        HeaderLine::Sample
    }
}

/// True if the head is that of a channel file.
pub(super) fn looks_like_channel(head: &[u8]) -> bool {
    let is_code = |line: &str| {
        line.split_once(':')
            .is_some_and(|(key, _)| key.trim().eq_ignore_ascii_case("Channel code"))
    };
    encoding::head_of(head)
        .split(['\n', '\r'])
        .filter(|line| !line.is_empty())
        .take(64)
        .any(is_code)
}

/// The header of a channel file: keys and values in their order.
#[derive(Debug, Clone, Default)]
pub(super) struct ChannelHeader {
    lines: Vec<(Box<str>, Box<str>)>,
    code: Option<Code>,
    is_whole: bool,
}

impl ChannelHeader {
    /// Reads the header at the start of decoded text.
    pub(super) fn read(content: &str) -> Self {
        let mut header = Self::default();
        for (_, line) in text::lines(content) {
            let line = line.trim();
            match header_line(line) {
                _ if line.is_empty() => {}
                HeaderLine::Key(key, value) => header.lines.push((key.into(), value.into())),
                HeaderLine::Continued(text) => {
                    let key = header.lines.last().map(|(key, _)| key.clone());
                    header.lines.extend(key.map(|key| (key, text.into())));
                }
                HeaderLine::Sample => {
                    header.is_whole = true;
                    // A text that is no number does not end the header: the reading of samples refuses it, and the lines
                    // after it may still name the channel.
                    if text::header_number(line).is_some() || line == NOTHING {
                        break;
                    }
                }
            }
        }
        header.lines.shrink_to_fit();
        header.code = header.value("Channel code").and_then(Code::new);
        header
    }

    /// Returns the bytes of keys and values, with the memory that each entry takes.
    pub(super) fn bytes(&self) -> u64 {
        const KEPT_WITH_EACH: usize = 64;
        self.lines
            .iter()
            .map(|(key, value)| (key.len() + value.len() + KEPT_WITH_EACH) as u64)
            .sum()
    }

    /// True if a sample follows the header, so that all of it was read.
    pub(super) fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Returns a value other than a placeholder.
    pub(super) fn value(&self, key: &str) -> Option<&str> {
        self.values(key).next()
    }

    /// Returns all values of a key, without placeholders.
    fn values<'a>(&'a self, key: &str) -> impl Iterator<Item = &'a str> + use<'a> {
        let key = key.to_ascii_lowercase();
        self.lines
            .iter()
            .filter(move |(line_key, _)| line_key.eq_ignore_ascii_case(&key))
            .map(|(_, value)| &**value)
            .filter(|value| !value.is_empty() && *value != NOTHING)
    }

    /// Refuses a header that states channel, time or unit twice and differently.
    pub(super) fn check_repeated_keys(&self) -> Result<(), Error> {
        for key in STATED_ONCE.iter() {
            let mut values = self.values(key);
            let Some(first) = values.next() else { continue };
            let other = values.find(|value| {
                !value.eq_ignore_ascii_case(first)
                    && match (text::header_number(first), text::header_number(value)) {
                        (Some(first), Some(other)) => first.total_cmp(&other).is_ne(),
                        _ => true,
                    }
            });
            if let Some(other) = other {
                return Err(Error::malformed(
                    format!("one `{key}` in the channel's header"),
                    format!("`{}` and `{}`", text::shown(first), text::shown(other)),
                    "keep the right one in the header",
                ));
            }
        }
        Ok(())
    }

    pub(super) fn code(&self) -> Option<&Code> {
        self.code.as_ref()
    }

    /// Returns the name of the channel: its code, else its name.
    pub(super) fn label(&self) -> Option<String> {
        let code = self.value("Channel code");
        let label = code.or_else(|| self.value("Name of the channel"));
        label.map(str::to_string)
    }

    pub(super) fn is_time(&self) -> bool {
        self.code.is_some_and(|code| code.is_time())
    }

    /// True if the channel is a linear acceleration: by its code, else by its unit.
    pub(super) fn is_acceleration(&self) -> bool {
        match &self.code {
            Some(code) => code.is_acceleration(),
            None => self.unit_of_acceleration().is_some(),
        }
    }

    /// Returns the unit, if it is one of acceleration; it may be in square brackets.
    pub(super) fn unit_of_acceleration(&self) -> Option<AccelerationUnit> {
        let text = self.value("Unit")?;
        let inner = text
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'));
        AccelerationUnit::from_spelling(inner.unwrap_or(text).trim())
    }

    /// Returns the reason why the channel is not chosen as a lateral acceleration of a vehicle's structure
    /// unless it is named.
    pub(super) fn doubt(&self) -> Option<String> {
        let named = ["Channel code", "Name of the channel"].map(|key| self.value(key));
        let words = named.into_iter().flatten();
        let words = words.map(|text| ChannelName::from_header(text, 1));
        let Some(code) = self.code.as_ref() else {
            let mut words: Vec<ChannelName> = words.collect();
            words.retain(|word| !word.label.is_empty());
            let says = words.iter().any(ChannelName::says_lateral_acceleration);
            let silent = || "neither code nor name says lateral acceleration".to_string();
            let doubt = words.iter().find_map(ChannelName::contradiction);
            return doubt.or_else(|| (!says).then(silent));
        };
        let reason = if !code.is_acceleration() {
            "its dimension is not AC (acceleration)"
        } else if !code.is_lateral() {
            "its direction is not Y"
        } else if !code.is_structure() {
            "its place is not known as part of the vehicle's structure"
        } else {
            // A header cell that is a code repeats the code, which was judged above.
            let named = |word: &ChannelName| Code::new(&word.label).is_none();
            return words.filter(named).find_map(|word| word.contradiction());
        };
        Some(reason.into())
    }

    pub(super) fn not_lateral_finding(&self) -> Option<Finding> {
        let label = text::shown(self.label().unwrap_or_default());
        Some(Finding::not_lateral(&label, &self.doubt()?))
    }

    /// Returns the name of the channel that holds the times, if they are explicit.
    pub(super) fn reference_channel(&self) -> Result<Option<&str>, Error> {
        let name = self.value("Reference channel name");
        let Some(kind) = self.value("Reference channel") else {
            // A name alone means a channel of times as well.
            return Ok(name);
        };
        let begins = |word: &str| kind.to_ascii_lowercase().starts_with(word);
        if begins("explicit") {
            Ok(Some(name.unwrap_or("a channel without a name")))
        } else if begins("implicit") {
            Ok(None)
        } else {
            Err(Error::malformed(
                "`Reference channel` implicit or explicit",
                format!("`{}`", text::shown(kind)),
                "correct the header",
            ))
        }
    }

    /// Returns a number of the clock. One that cannot be read is an error: it must not be guessed.
    fn clock_number(&self, key: &str, hint: &str) -> Result<Option<(f64, &str)>, Error> {
        let Some(printed) = self.value(key) else {
            return Ok(None);
        };
        let Some(number) = text::header_number(printed) else {
            let found = format!("`{}`", text::shown(printed));
            return Err(Error::malformed(format!("`{key}` in seconds"), found, hint));
        };
        Ok(Some((number, printed)))
    }

    /// Returns the rate that the sampling interval states.
    pub(super) fn interval(&self) -> Result<Option<SampleRate>, Error> {
        let hint = "state the rate with the setting `rate_hz`";
        let Some((interval_s, printed)) = self.clock_number("Sampling interval", hint)? else {
            return Ok(None);
        };
        time_base::rate_of_interval(interval_s, text::last_digit(printed)).map(Some)
    }

    pub(super) fn first_time(&self) -> Result<Option<f64>, Error> {
        let stated = self.clock_number("Time of first sample", "correct the header")?;
        Ok(stated.map(|(first_s, _)| first_s))
    }

    /// Compares the header's statements of the clock with the stamps of the channel of times [s], printed to
    /// `digit_s`; `None` where it states none.
    pub(super) fn clock_comparison(
        &self,
        stamps_s: &[f64],
        digit_s: f64,
        stated_hz: Option<f64>,
    ) -> Option<Comparison> {
        let printed = self.statement("Time of first sample");
        let first_s = printed.and_then(|stated| text::header_number(stated.text));
        // Beside explicit times, an interval of 0 or a text means that none is stated.
        let interval = self.statement("Sampling interval");
        let rate = self.interval().ok().flatten();
        let clock = |start_s: f64, hertz: f64| HeaderClock {
            source: "the channel's header, beside its channel of times,",
            start_s,
            start_digit_s: printed.map_or(0.0, |stated| text::last_digit(stated.text)),
            start_intervals: 0.0,
            hertz,
            slack: interval.map_or(0.0, |stated| clock::slack(stated.text)),
        };
        let first_stamp_s = *stamps_s.first()?;
        match (first_s, rate) {
            (None, None) => None,
            (start_s, Some(rate)) => {
                let stated = clock(start_s.unwrap_or(first_stamp_s), rate.hertz());
                Some(stated.compare(stamps_s, digit_s, stated_hz))
            }
            (Some(start_s), None) => {
                let steps = stamps_s.len().saturating_sub(1).max(1) as f64;
                let hertz = steps / (stamps_s.last()? - first_stamp_s);
                let begun = clock(start_s, hertz).compare(&stamps_s[..1], digit_s, stated_hz);
                // That the first instant is right says nothing of the rate.
                (begun != Comparison::Confirmed).then_some(begun)
            }
        }
    }

    /// Returns the channel frequency class that the header states, `CFC` before it or not.
    fn stated_class(&self) -> Option<String> {
        let text = self.value("Channel frequency class")?.to_ascii_uppercase();
        let class = text
            .strip_prefix("CFC")
            .unwrap_or(&text)
            .trim_matches([' ', '_', '-', '=']);
        let letter = match class.as_bytes() {
            [letter] => code::class_of(*letter),
            _ => None,
        };
        Some(letter.unwrap_or(class).to_string()).filter(|class| !class.is_empty())
    }

    /// Returns the facts of sensor and place.
    fn test_facts(&self) -> TestFacts {
        let value_of = |key: &str| self.value(key).and_then(fact);
        TestFacts {
            sensor: joined_facts(["Transducer type", "Transducer id"].map(value_of)),
            location: value_of("Channel code")
                .or_else(|| value_of("Location"))
                .or_else(|| value_of("Name of the channel")),
            ..TestFacts::default()
        }
    }

    /// Returns the test object that the channel belongs to, as codes and keys name it.
    pub(super) fn object(&self) -> Option<String> {
        let by_code = || Some(char::from(self.code?.object()).to_string());
        let stated = self.value("Test object number").map(ToString::to_string);
        stated.or_else(by_code)
    }

    /// Returns the facts beside the samples; findings name entries that cannot be read.
    pub(super) fn stated(&self, findings: &mut Vec<Finding>) -> Stated {
        let mut positive = |key: &str| {
            let number = self
                .statement(key)?
                .number(|number| number >= 0.0, findings);
            number.filter(|number| *number > 0.0)
        };
        let full_scale = positive("Channel amplitude class");
        let prefilter_hz = positive("Pre-filter type");
        let class = self.stated_class();
        let is_class = |class: &String| CLASSES.contains(&class.as_str());
        let unfiltered = |class: &String| UNFILTERED.contains(&class.as_str());
        if let (Some(class), Some(stated)) = (&class, self.statement("Channel frequency class"))
            && !is_class(class)
            && !unfiltered(class)
        {
            findings.push(stated.unread());
        }
        let code_class = || self.code?.filter_class().map(ToString::to_string);
        Stated {
            location: self.value("Name of the channel").map(ToString::to_string),
            full_scale,
            prefilter_hz,
            unfiltered: class.as_ref().is_some_and(unfiltered)
                || self.code.is_some_and(|code| code.says_unfiltered()),
            filter_class: class.filter(is_class).or_else(code_class),
            status: self.value("Data status").map(ToString::to_string),
            test: self.test_facts(),
            ..Stated::default()
        }
    }

    /// Returns the laboratory's free words on the channel.
    pub(super) fn remark(&self) -> Remark {
        let comments = self.lines.iter();
        let comments = comments.filter(|(key, value)| remarks::is_key(key) && &**value != NOTHING);
        let comments: Vec<&str> = comments.map(|(_, value)| &**value).collect();
        Remark::of_channel(&comments)
    }

    /// Returns the findings on the status of the samples; a comment may state its instant.
    pub(super) fn status_findings(&self, span: Span) -> Vec<Finding> {
        let from = remarks::plainly_bad_from(&[self.remark()]).filter(|at_s| span.holds(*at_s));
        let statuses = self.values("Data status");
        let findings = statuses.filter_map(|status| status_finding(status, from));
        findings.collect()
    }

    /// Returns a statement of the header, unless it is a placeholder.
    fn statement<'a>(&'a self, key: &'a str) -> Option<Statement<'a>> {
        self.value(key).map(|text| Statement { key, text })
    }

    /// Returns the name of an instant of an extreme that agrees with the interval in use.
    pub(super) fn instant_confirms(&self, clock: &UniformSamples) -> Option<String> {
        // Near the first sample, an instant would agree with nearly any interval.
        let far_s = FAR_SAMPLES / clock.rate.hertz();
        [("maximum", 1.0), ("minimum", -1.0)]
            .into_iter()
            .find_map(|(word, sign)| {
                let key = format!("Time of {word} value");
                let time = self.statement(&key)?;
                let time_s = text::header_number(time.text)?;
                let signed = clock.values.iter().map(|value| sign * value);
                let extreme = sign * signed.fold(f64::MIN, f64::max);
                let is_confirmed = instant_finding(time, clock, extreme, 0.0).is_none();
                (is_confirmed && (time_s - clock.start_s).abs() >= far_s).then_some(key)
            })
    }

    /// Returns the time of the first sample [s] by the instants that the header states of both extremes, where it
    /// states no other and the two agree.
    pub(super) fn start_by_extremes(&self, values: &[f64], interval_s: f64) -> Option<f64> {
        let start = |word: &str, sign: f64| {
            let time = self.value(&format!("Time of {word} value"))?;
            let time_s = text::header_number(time)?;
            let index = first_extreme(values, sign)?;
            let slack_s = 0.5 * text::last_digit(time) + 0.01 * interval_s;
            Some((time_s - index as f64 * interval_s, slack_s))
        };
        let ((of_maximum, slack_s), (of_minimum, other_slack_s)) =
            (start("maximum", 1.0)?, start("minimum", -1.0)?);
        let start_s = if slack_s <= other_slack_s {
            of_maximum
        } else {
            of_minimum
        };
        // No more digits than the instants have.
        let start_s = (start_s / interval_s * 100.0).round() * interval_s / 100.0;
        ((of_maximum - of_minimum).abs() <= slack_s + other_slack_s).then_some(start_s)
    }

    /// Compares the header's statements on the samples with them; `stamped` is true if a channel of times has
    /// a stamp for each.
    pub(super) fn held_findings(
        &self,
        clock: &UniformSamples,
        count: usize,
        stamped: bool,
    ) -> Vec<Finding> {
        let mut findings = Vec::new();
        if let Some(stated) = self.statement("Number of samples") {
            stated.count(count, stamped, clock.span().end_s, &mut findings);
        }
        let values = &clock.values;
        let largest = values.iter().copied().map(f64::abs).fold(0.0, f64::max);
        let slack = EXTREME_AGREEMENT * largest;
        if let Some(stated) = self.statement("Maximum absolute value") {
            stated.extreme(largest, slack, &mut findings);
        }
        for (word, sign) in [("maximum", 1.0), ("minimum", -1.0)] {
            let signed = values.iter().map(|value| sign * value);
            let extreme = sign * signed.fold(f64::MIN, f64::max);
            let key = format!("First global {word} value");
            let Some(stated) = self.statement(&key) else {
                continue;
            };
            let before = findings.len();
            stated.extreme(extreme, slack, &mut findings);
            let key = format!("Time of {word} value");
            let Some(time) = self.statement(&key).filter(|_| findings.len() == before) else {
                continue;
            };
            let tolerance = slack + text::last_digit(stated.text);
            findings.extend(instant_finding(time, clock, extreme, tolerance));
        }
        findings
    }

    /// Compares the header's statements on the channel with its code, and blocks computed samples.
    pub(super) fn contradictions(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        let starts = |statement: &Statement, words: &[&str]| {
            let text = statement.text.to_ascii_uppercase();
            words.iter().any(|word| text.starts_with(word))
        };
        if let Some(source) = self.statement("Data source") {
            let text = source.text.to_ascii_lowercase();
            if COMPUTED.iter().any(|word| text.contains(word)) {
                findings.push(source.contradicts("replay needs samples that were measured"));
            } else if !MEASURED.iter().any(|word| text.contains(word)) {
                findings.push(source.unread());
            }
        }
        let Some(code) = self.code else {
            return findings;
        };
        let says = |part: &str| format!("the code {} says {part}", code.text());
        if let Some(stated) = self.statement("Dimension")
            && code.is_acceleration()
            && !starts(&stated, &["AC", "BESCHL"])
        {
            findings.push(stated.contradicts(&says("AC, acceleration")));
        }
        if let Some(stated) = self.statement("Direction")
            && let Some(axis) = code.axis()
            && !starts(&stated, &[axis, &format!("+{axis}"), &format!("-{axis}")])
        {
            findings.push(stated.contradicts(&says(axis)));
        }
        findings.extend(self.filter_contradiction(code));
        findings
    }

    /// Compares class and cut-off of the filter with the last letter of the code.
    fn filter_contradiction(&self, code: Code) -> Option<Finding> {
        let code_class = code.filter_class()?;
        let says = || format!("the code {} says CFC {code_class}", code.text());
        if let Some(stated) = self.statement("Channel frequency class")
            && let Some(stated_class) = self.stated_class()
            && stated_class != code_class
            && CLASSES.contains(&stated_class.as_str())
        {
            return Some(stated.contradicts(&says()));
        }
        // Some write the class there, others its corner frequency, about 1.65 times the class. Other
        // classes are outside this range.
        let stated = self.statement("Cut off frequency")?;
        let class: f64 = code_class.parse().ok()?;
        let Some(hertz) = text::header_number(stated.text) else {
            return Some(stated.unread());
        };
        (!(0.9 * class..=2.0 * class).contains(&hertz)).then(|| stated.contradicts(&says()))
    }
}

/// Returns the place of the first largest sample, or of the first least one with -1 for `sign`.
fn first_extreme(values: &[f64], sign: f64) -> Option<usize> {
    // Of equal ones the last in this order, so that the first counts.
    let signed = |index: &usize| sign * values[*index];
    (0..values.len())
        .rev()
        .max_by(|one, other| signed(one).total_cmp(&signed(other)))
}

/// True if the largest and the least sample lie so far apart that their instants tell the interval.
pub(super) fn extremes_are_apart(values: &[f64]) -> bool {
    let places = [1.0, -1.0].map(|sign| first_extreme(values, sign));
    match places {
        [Some(one), Some(other)] => one.abs_diff(other) as f64 >= FAR_SAMPLES,
        _ => false,
    }
}

/// Compares the instant at which the header places an extreme with the samples.
fn instant_finding(
    stated: Statement<'_>,
    clock: &UniformSamples,
    extreme: f64,
    tolerance: f64,
) -> Option<Finding> {
    let Some(time_s) = text::header_number(stated.text) else {
        return Some(stated.unread());
    };
    let interval_s = 1.0 / clock.rate.hertz();
    let slack = 1.5 * interval_s + text::last_digit(stated.text);
    let has_extreme = clock.values.iter().enumerate().any(|(index, value)| {
        (value - extreme).abs() <= tolerance
            && (clock.start_s + index as f64 * interval_s - time_s).abs() <= slack
    });
    (!has_extreme).then(|| {
        let text = format!(
            "{} in the header is {time_s} s, but the samples differ there. The time base is wrong, \
             or samples are missing. Check header and file",
            stated.key
        );
        Finding::blocking("peak-contradicted", text)
    })
}

/// Returns the finding on a status of the samples; `from` is the instant from which a comment says that
/// they are bad [s].
fn status_finding(status: &str, from: Option<f64>) -> Option<Finding> {
    let text = format!("the laboratory's data status is: {}", text::shown(status));
    match status.to_ascii_lowercase().as_str() {
        "ok" | "o.k." | "as measured" => None,
        "linearised data" | "linearized data" | "scaling factor applied" => {
            Some(Finding::info("channel-computed", text))
        }
        "questionable data" | "channel failed" => {
            Some(Finding::blocking("invalid-by-laboratory", text).since(from))
        }
        _ => Some(Finding::blocking("invalid-by-laboratory", text)),
    }
}

/// The samples of a channel file.
#[derive(Debug)]
pub(super) struct Samples {
    /// Samples; a missing one repeats the value before it.
    pub(super) values: Vec<f64>,
    /// First and one past the last index of each run of missing samples.
    pub(super) holes: Vec<(usize, usize)>,
    /// The finding that the file ends in the middle of a line.
    pub(super) cut: Option<Finding>,
    /// Size of the last printed digit; 0 if unknown.
    pub(super) last_digit: f64,
}

impl Samples {
    pub(super) fn read(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Error> {
        let (content, _) = encoding::text_of(bytes, limits)?;
        let (mut values, mut holes): (Vec<f64>, Vec<(usize, usize)>) = (Vec::new(), Vec::new());
        let mut decimal = Decimal::Unknown;
        let mut digits = PrintedDigits::new();
        let (mut inside, mut empty) = (false, None);
        let mut marks = text::ColumnMarks::default();
        for (number, line) in text::lines(&content) {
            let (cell, place) = (line.trim(), Place::default().line(number));
            if cell.is_empty() {
                empty = empty.or(inside.then_some(place));
                continue;
            }
            if let Some(place) = empty {
                return Err(empty_line().at(place));
            }
            inside = inside || matches!(header_line(cell), HeaderLine::Sample);
            if !inside {
                continue;
            }
            if values.len() as u64 >= limits.samples {
                return Err(limits.over("samples", "more samples").at(place));
            }
            if cell == NOTHING {
                let index = values.len();
                match holes.last_mut().filter(|(_, end)| *end == index) {
                    Some((_, end)) => *end += 1,
                    None => holes.push((index, index + 1)),
                }
                values.push(values.last().copied().unwrap_or(0.0));
                continue;
            }
            values.push(text::sample(cell, &mut decimal).map_err(|error| error.at(place.clone()))?);
            digits.count(cell.as_bytes());
            marks.look(cell.as_bytes(), || place);
        }
        let hint = "export again without thousands marks, or with the same decimals in all \
                    numbers; a factor of 1000 is unclear here";
        marks.check(|_, marks| !marks.may_be_thousands(), hint)?;
        if values.is_empty() || holes.first() == Some(&(0, values.len())) {
            let found = "the channel file holds no sample";
            return Err(Error::empty(found, "one value a line after the header"));
        }
        Ok(Self {
            values,
            holes,
            cut: held::cut_line(&content),
            last_digit: digits.last_digit(),
        })
    }
}

fn empty_line() -> Error {
    Error::malformed(
        "a value in each line up to the last sample",
        "an empty line",
        "write NOVALUE there, or export again; a sample left out moves those after it",
    )
}
