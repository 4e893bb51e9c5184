//! The fields of a request in and out of serde.
//!
//! Serde's derived code reads and writes them ([`Request`] is its own `remote`); what stands here calls it
//! by settings, so that an unknown key names the nearest known one and a bad value names its setting.

use super::Request;
use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fmt;

/// Reads the fields that are stated; an error names the key and says what was expected.
pub(super) fn read(stated: Map<String, Value>) -> Result<Request, (String, String)> {
    let mut track = serde_path_to_error::Track::new();
    let value = Value::Object(stated);
    let tracked = serde_path_to_error::Deserializer::new(value, &mut track);
    Request::deserialize(tracked).map_err(|error| (track.path().to_string(), error.to_string()))
}

/// Returns every field that has a value, defaults among them.
pub(super) fn write(request: &Request) -> BTreeMap<String, Value> {
    let written = Request::serialize(request, serde_json::value::Serializer);
    // An empty table in its place would give other questions the same identity.
    let Ok(Value::Object(fields)) = written else {
        unreachable!("a request is a struct of plain numbers and texts");
    };
    fields.into_iter().collect()
}

impl Serialize for Request {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        BTreeMap::from(self.clone()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Request {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stated = SettingsAsStated::deserialize(deserializer)?;
        Self::try_from(stated.0).map_err(D::Error::custom)
    }
}

/// Settings as a document states them: each key once, since of two some readers take the first.
pub(super) struct SettingsAsStated(pub(super) BTreeMap<String, Value>);

impl<'de> Deserialize<'de> for SettingsAsStated {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct EachKeyOnce;

        impl<'de> Visitor<'de> for EachKeyOnce {
            type Value = SettingsAsStated;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table of settings")
            }

            fn visit_map<A: MapAccess<'de>>(
                self,
                mut map: A,
            ) -> Result<SettingsAsStated, A::Error> {
                let mut entries = BTreeMap::new();
                while let Some((key, value)) = map.next_entry::<String, Value>()? {
                    if entries.insert(key.clone(), value).is_some() {
                        return Err(A::Error::custom(format!("the key `{key}` stands twice")));
                    }
                }
                Ok(SettingsAsStated(entries))
            }
        }

        deserializer.deserialize_map(EachKeyOnce)
    }
}
