//! JSON messages: one walk through the text that hands out every scalar with its path.
//!
//! Nothing is kept of what is not requested, so that a large message costs time but no memory.

use super::types::{Leaf, Sink, TextMark, damaged_message, step_into};
use crate::error::Error;
use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// Walks `message` and hands each scalar with its path, such as `a.b[2].c`, to `sink`.
pub(super) fn walk(message: &[u8], sink: Sink<'_>) -> Result<(), Error> {
    let mut deserializer = serde_json::Deserializer::from_slice(message);
    let mut path = String::new();
    JsonWalk {
        path: &mut path,
        sink,
    }
    .deserialize(&mut deserializer)
    .and_then(|()| deserializer.end())
    .map_err(|error| damaged_message("a JSON message", &error.to_string()))
}

struct JsonWalk<'a> {
    path: &'a mut String,
    sink: Sink<'a>,
}

impl JsonWalk<'_> {
    fn leaf<E>(self, leaf: Leaf) -> Result<(), E> {
        (self.sink)(self.path, leaf);
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for JsonWalk<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for JsonWalk<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "JSON")
    }

    fn visit_bool<E>(self, _value: bool) -> Result<(), E> {
        self.leaf(Leaf::Boolean)
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.leaf(Leaf::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.leaf(Leaf::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.leaf(Leaf::Number(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<(), E> {
        self.leaf(Leaf::Text(TextMark::new(value.as_bytes())))
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.leaf(Leaf::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let length = self.path.len();
        for index in 0_u64.. {
            self.path.push_str(&format!("[{index}]"));
            let element = elements.next_element_seed(JsonWalk {
                path: &mut *self.path,
                sink: &mut *self.sink,
            })?;
            self.path.truncate(length);
            if element.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<(), A::Error> {
        let length = self.path.len();
        while let Some(key) = entries.next_key::<std::borrow::Cow<'de, str>>()? {
            step_into(self.path, &key);
            entries.next_value_seed(JsonWalk {
                path: &mut *self.path,
                sink: &mut *self.sink,
            })?;
            self.path.truncate(length);
        }
        Ok(())
    }
}
