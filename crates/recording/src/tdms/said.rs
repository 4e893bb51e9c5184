//! What properties and channels of text say of samples and test.

use super::object::{Object, is_technical};
use super::scale;
use super::segment::ObjectPath;
use super::value::Value;
use crate::channel_name::words;
use crate::csv;
use crate::examine::clock::{RateStatement, UsedClock};
use crate::remarks::{self, Remark, RemarkPlace, Span};
use crate::{Finding, Severity, Stated, TestFacts, fact, joined_facts};
use std::collections::BTreeMap;

/// Tells whether a text under a name such as `status`, `overload` or `IsOverloaded` does not say that all is
/// well.
pub(super) fn says_bad(name: &str, text: &str) -> bool {
    csv::says_bad(name, text) || csv::says_bad(&words(name).join(" "), text)
}

/// Tells whether a text under a name says that samples are not known to be good; `DASTAT` is the word of
/// NHTSA's database.
fn is_bad_status(name: &str, text: &str) -> bool {
    match name.eq_ignore_ascii_case("DASTAT") {
        true => !["", "AM", "CM"].contains(&text),
        false => says_bad(name, text),
    }
}

/// Returns what a text under a name comes to.
fn remark(name: &str, text: &str, teller: &str) -> Option<Remark> {
    let small = name.to_lowercase();
    let named = format!("{name}: {text}");
    let (text, place) = if says_bad(name, text) {
        (&*named, RemarkPlace::State(None))
    } else if remarks::is_key(name) || small == "inscom" {
        (text, RemarkPlace::Channel)
    } else if is_of_filters(name) {
        (&*named, RemarkPlace::Channel)
    } else {
        (&*named, RemarkPlace::Apart)
    };
    (!text.is_empty()).then(|| Remark::new(text, place, teller))
}

/// Tells whether a property speaks of filters.
fn is_of_filters(key: &str) -> bool {
    let small = key.to_lowercase();
    let words = ["filter", "cfc", "frequency class"];
    words.iter().any(|word| small.contains(word))
}

/// Returns what the properties of a group or of the file say of filters, and those of a channel by a number.
pub(super) fn of_filters(object: &Object) -> impl Iterator<Item = Remark> {
    let is_own = matches!(object.path, ObjectPath::Channel(..));
    let teller = format!("{} says", teller(object));
    let properties = object.properties();
    let filters = properties.filter(|(key, _)| !is_technical(key) && is_of_filters(key));
    filters.filter_map(move |(key, value)| {
        let is_said = match value {
            Value::Text(text) => !is_own && !text.trim().is_empty(),
            Value::Number(number, _) => *number > 0.0,
            _ => false,
        };
        let text = format!("{key}: {}", value.text());
        is_said.then(|| Remark::new(&text, RemarkPlace::Channel, teller.clone()))
    })
}

/// What the properties of a group or of the file say of every channel under it.
pub(super) struct ParentSaid {
    /// One finding of a state that is not good; others would add nothing.
    bad: Option<Finding>,
    filters: Vec<Remark>,
    scale: Option<String>,
    rates: Vec<StatedRate>,
}

/// A property that states a rate or an interval in words of the writer's own.
struct StatedRate {
    shown: String,
    rate: RateStatement,
}

/// Returns what an object states of its rate beside the format's own properties.
fn stated_rates(object: &Object) -> impl Iterator<Item = StatedRate> {
    // Under FS stands a full scale as often as a rate.
    let is_word = |key: &str| !is_technical(key) && !key.eq_ignore_ascii_case("fs");
    let properties = object.properties().filter(move |(key, _)| is_word(key));
    properties.filter_map(|(key, value)| {
        let text = value.text();
        let rate = csv::rates_under_name(key, &text)?;
        let (key, text) = (crate::text::shown(key), crate::text::shown(&text));
        let shown = format!("the property `{key}` of {} is {text}", teller(object));
        Some(StatedRate { shown, rate })
    })
}

/// Properties of one object that are compared with the clock.
const MOST_RATES: usize = 8;

/// What groups and file say, each looked through once: both may hold as many properties as there are
/// channels.
pub(super) struct ParentsSaid<'a>(BTreeMap<&'a ObjectPath, ParentSaid>);

impl<'a> ParentsSaid<'a> {
    pub(super) fn of(objects: &'a [Object]) -> Self {
        let is_parent = |object: &&Object| !matches!(object.path, ObjectPath::Channel(..));
        let parent_by_path = |object: &'a Object| {
            let parent = ParentSaid {
                bad: bad_properties(object).next().map(|(_, finding)| finding),
                filters: of_filters(object).take(MOST_FILTERS).collect(),
                scale: scale::scale_in_words(object),
                rates: stated_rates(object).take(MOST_RATES).collect(),
            };
            (&object.path, parent)
        };
        Self(
            objects
                .iter()
                .filter(is_parent)
                .map(parent_by_path)
                .collect(),
        )
    }

    fn over<'b>(&'b self, objects: &'b [&Object]) -> impl Iterator<Item = &'b ParentSaid> {
        objects.iter().filter_map(|object| self.0.get(&object.path))
    }

    /// Returns what they say of the state of a channel whose `objects` these are.
    pub(super) fn findings(&self, objects: &[&Object]) -> Vec<Finding> {
        self.over(objects)
            .filter_map(|parent| parent.bad.clone())
            .collect()
    }

    /// Says that a channel or what is above it states another rate than that of its clock [Hz].
    pub(super) fn rate_finding(
        &self,
        objects: &[&Object],
        used: UsedClock<'_>,
        doubts: &mut Vec<String>,
    ) -> Option<Finding> {
        let channel_rates: Vec<StatedRate> = objects
            .first()
            .into_iter()
            .flat_map(|channel| stated_rates(channel).take(MOST_RATES))
            .collect();
        let parent_rates = self.over(objects).flat_map(|parent| &parent.rates);
        let mut findings = Vec::new();
        for stated in channel_rates.iter().chain(parent_rates) {
            used.compare(&stated.shown, &stated.rate)
                .tell(&mut findings, doubts);
        }
        let is_blocking = |finding: &&Finding| finding.severity == Severity::Blocking;
        findings
            .iter()
            .find(is_blocking)
            .or(findings.first())
            .cloned()
    }

    /// Returns what they say of filters.
    pub(super) fn filters(&self, objects: &[&Object]) -> Vec<Remark> {
        self.over(objects)
            .flat_map(|parent| parent.filters.clone())
            .collect()
    }

    /// Returns what they say of a scale in words of the writer's own.
    pub(super) fn scale(&self, objects: &[&Object]) -> Option<String> {
        self.over(objects).find_map(|parent| parent.scale.clone())
    }
}

/// Remarks on filters that are taken from a group or the file.
const MOST_FILTERS: usize = 8;

/// Names an object in a sentence.
pub(super) fn teller(object: &Object) -> String {
    match &object.path {
        ObjectPath::File => "the file".into(),
        ObjectPath::Group(name) => format!("the group `{}`", crate::text::shown(name)),
        ObjectPath::Channel(_, name) => format!("the channel `{}`", crate::text::shown(name)),
    }
}

/// Returns what the properties of file and groups say in words.
pub(super) fn of_file(objects: &[Object]) -> Vec<Remark> {
    let parents = objects.iter().filter_map(|object| match &object.path {
        ObjectPath::File => Some((object, "the file".to_string())),
        ObjectPath::Group(name) => {
            Some((object, format!("the group `{}`", crate::text::shown(name))))
        }
        ObjectPath::Channel(..) => None,
    });
    let remarks = parents.flat_map(|(object, teller)| {
        let texts = texts(object);
        texts.map(move |(key, text)| {
            let text = format!("{key}: {text}");
            Remark::new(&text, RemarkPlace::Apart, format!("{teller} says"))
        })
    });
    remarks.collect()
}

/// Returns what the properties of a channel say in words.
pub(super) fn of_channel(object: &Object) -> Vec<Remark> {
    let teller = "the file says of this channel";
    let texts = texts(object).filter(|(key, text)| !is_bad_status(key, text));
    let remarks = texts.filter_map(|(key, text)| remark(key, &text, teller));
    remarks.collect()
}

/// Says which properties of a channel, of its group or of the file state that its samples are not known to be good; of NHTSA's words
/// for data that are bad in part, from the instant on that a remark plainly names.
pub(super) fn status_findings(object: &Object, span: Span) -> Vec<Finding> {
    let since = |(stated, blocking): (String, Finding)| {
        let from = match &*stated {
            "QD" | "CF" => remarks::plainly_bad_from(&of_channel(object)),
            _ => None,
        };
        blocking.since(from.filter(|at_s| span.holds(*at_s)))
    };
    bad_properties(object).map(since).collect()
}

/// Returns what is stated of samples that are not known to be good, with a finding of it.
fn bad_properties(object: &Object) -> impl Iterator<Item = (String, Finding)> {
    // A flag is whole; other numbers are those of a sensor, as the error of its linearity is.
    let is_part = |value: &Value| {
        value
            .number()
            .is_some_and(|number| number.fract().abs() > 0.0)
    };
    let properties = object.properties();
    let properties = properties.filter(move |(key, value)| !is_technical(key) && !is_part(value));
    properties.filter_map(|(key, value)| {
        let stated = value.text();
        is_bad_status(key, &stated).then(|| {
            let (key, shown) = (crate::text::shown(key), crate::text::shown(&stated));
            let owner = match &object.path {
                ObjectPath::Channel(..) => String::new(),
                _ => format!(" of {}", teller(object)),
            };
            let text =
                format!("the property `{key}`{owner} states \"{shown}\". Use another channel");
            (stated, Finding::blocking("invalid-by-laboratory", text))
        })
    })
}

fn texts(object: &Object) -> impl Iterator<Item = (&str, String)> {
    object.properties().filter_map(|(key, value)| match value {
        Value::Text(_) if !is_technical(key) => Some((key, value.text())),
        _ => None,
    })
}

/// Returns what a channel of text says of the channels beside it.
pub(super) fn of_texts(object: &Object, name: &str) -> Vec<Remark> {
    let teller = format!("the channel `{}` says", crate::text::shown(name));
    let remarks = object
        .texts
        .texts()
        .filter_map(|text| remark(name, text, &teller));
    let more = object.texts.is_full().then(|| {
        let text = "more texts than are read";
        Remark::new(text, RemarkPlace::State(None), teller.clone())
    });
    remarks.chain(more).collect()
}

/// Takes what a channel, its group and the file state of sensor and test; `objects` holds them.
pub(super) fn state(object: &Object, stated: &mut Stated, objects: &[&Object]) {
    let any = |keys: &[&str]| {
        let mut values = keys
            .iter()
            .flat_map(|key| objects.iter().map(move |object| object.property(key)));
        values.find_map(|value| fact(&value?.text()))
    };
    let channel_fact = |key: &str| object.property(key).and_then(|value| fact(&value.text()));
    let number = |key: &str| {
        object
            .property(key)
            .and_then(Value::number)
            .filter(|number| *number > 0.0)
    };
    let file = objects
        .iter()
        .find(|object| object.path == ObjectPath::File);
    let title = file
        .and_then(|file| file.property("name"))
        .and_then(|name| fact(&name.text()));
    stated.full_scale = number("INSRAT");
    stated.prefilter_hz = number("PREFIL");
    stated.status = channel_fact("DASTAT").or_else(|| channel_fact("Data status"));
    stated.test = TestFacts {
        test: any(&["title", "test"]).or(title),
        vehicle: any(&["vehicle"]),
        laboratory: any(&["laboratory"])
            .or_else(|| any(&["author"]).map(|name| format!("author {name}"))),
        date: any(&["date", "datetime", "wf_start_time"]),
        sensor: joined_facts([
            channel_fact("sensor"),
            channel_fact("serial number"),
            channel_fact("INSMAN"),
        ]),
        location: joined_facts([
            channel_fact("location"),
            channel_fact("SENATT"),
            channel_fact("AXIS"),
        ]),
        ..TestFacts::default()
    };
}
