//! What properties and channels of text say of samples and test.

use super::object::Object;
use super::segment::ObjectPath;
use super::value::Value;
use crate::csv::says_bad;
use crate::remarks::{self, Remark, RemarkPlace, Span};
use crate::{Finding, Stated, TestFacts, fact, joined_facts};

/// Tells whether a property is one of the format's own, and no word of a person's.
pub(super) fn is_technical(key: &str) -> bool {
    let small = key.to_lowercase();
    ["ni_", "wf_"].iter().any(|start| small.starts_with(start))
        || [
            "name",
            "unit_string",
            "datatype",
            "displaytype",
            "monotony",
            "novaluekey",
        ]
        .contains(&&*small)
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
    let is_of_filters = ["filter", "cfc", "frequency class"];
    let (text, place) = if says_bad(name, text) {
        (&*named, RemarkPlace::State(None))
    } else if remarks::is_key(name) || small == "inscom" {
        (text, RemarkPlace::Channel)
    } else if is_of_filters.iter().any(|word| small.contains(word)) {
        (&*named, RemarkPlace::Channel)
    } else {
        (&*named, RemarkPlace::Apart)
    };
    (!text.is_empty()).then(|| Remark::new(text, place, teller))
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
    let said = parents.flat_map(|(object, of)| {
        let texts = texts(object);
        texts.map(move |(key, text)| {
            let text = format!("{key}: {text}");
            Remark::new(&text, RemarkPlace::Apart, format!("{of} says"))
        })
    });
    said.collect()
}

/// Returns what the properties of a channel say in words.
pub(super) fn of_channel(object: &Object) -> Vec<Remark> {
    let teller = "the file says of this channel";
    let said = texts(object).filter(|(key, text)| !is_bad_status(key, text));
    let said = said.filter_map(|(key, text)| remark(key, &text, teller));
    said.collect()
}

/// Says which properties of a channel state that its samples are not known to be good; of NHTSA's words
/// for data that are bad in part, from the instant on that a remark plainly names.
pub(super) fn status_findings(object: &Object, span: Span) -> Vec<Finding> {
    // A flag is whole; other numbers are those of a sensor, as the error of its linearity is.
    let is_part = |value: &Value| {
        value
            .number()
            .is_some_and(|number| number.fract().abs() > 0.0)
    };
    let properties = object.properties();
    let properties = properties.filter(|(key, value)| !is_technical(key) && !is_part(value));
    let bad = properties.filter_map(|(key, value)| {
        let stated = value.text();
        is_bad_status(key, &stated).then(|| {
            let from = match &*stated {
                "QD" | "CF" => remarks::plainly_bad_from(&of_channel(object)),
                _ => None,
            };
            let (key, stated) = (crate::text::shown(key), crate::text::shown(stated));
            let text = format!("the property `{key}` states \"{stated}\". Use another channel");
            let blocking = Finding::blocking("invalid-by-laboratory", text);
            blocking.since(from.filter(|at_s| span.holds(*at_s)))
        })
    });
    bad.collect()
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
    let said = object
        .texts
        .texts()
        .filter_map(|text| remark(name, text, &teller));
    let more = object.texts.is_full().then(|| {
        let text = "more texts than are read";
        Remark::new(text, RemarkPlace::State(None), teller.clone())
    });
    said.chain(more).collect()
}

/// Takes what a channel, its group and the file state of sensor and test; `objects` holds them.
pub(super) fn state(object: &Object, stated: &mut Stated, objects: &[&Object]) {
    let any = |keys: &[&str]| {
        let mut found = keys
            .iter()
            .flat_map(|key| objects.iter().map(move |one| one.property(key)));
        found.find_map(|value| fact(&value?.text()))
    };
    let own = |key: &str| object.property(key).and_then(|value| fact(&value.text()));
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
    stated.status = own("DASTAT").or_else(|| own("Data status"));
    stated.test = TestFacts {
        test: any(&["title", "test"]).or(title),
        vehicle: any(&["vehicle"]),
        laboratory: any(&["laboratory"])
            .or_else(|| any(&["author"]).map(|name| format!("author {name}"))),
        date: any(&["date", "datetime", "wf_start_time"]),
        sensor: joined_facts([own("sensor"), own("serial number"), own("INSMAN")]),
        location: joined_facts([own("location"), own("SENATT"), own("AXIS")]),
        ..TestFacts::default()
    };
}
