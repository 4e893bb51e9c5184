//! The words of a gate file for editors: a JSON Schema, and an example to start from.

use super::file::{ALLOW_KEYS, DESIGN_KEYS, FILES, REQUIRE_KEYS, REQUIRE_STATIC, TABLES};
use crate::pipeline::Request;
use latchgate_verdict::statics::{Door, Standard};
use serde_json::{Map, Value, json};

/// Returns the JSON Schema of a gate file, draft 2020-12.
pub fn schema() -> Value {
    let text = json!({"type": "string"});
    let texts = json!({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]});
    let verdict = json!({"enum": ["pass", "fail"]});
    let mut recordings = Map::from_iter([(
        FILES.to_string(),
        described(&texts, "Paths or patterns, relative to the gate file"),
    )]);
    for key in Request::keys() {
        recordings.insert(
            key.into(),
            described(&json!({}), "As the option of latchgate replay"),
        );
    }
    let set =
        json!({"anyOf": [{"type": "object"}, {"type": "array", "items": {"type": "string"}}]});
    let load = json!({"type": "number", "exclusiveMinimum": 0});
    let standards = Standard::ALL.map(Standard::word);
    let doors = Door::ALL.map(Door::word);
    let day = json!({"type": "string", "pattern": "^[0-9]{4}-[0-9]{2}-[0-9]{2}$"});
    let array = |keys: &[&str], needed: &[&str], schema: &dyn Fn(&str) -> Value| {
        let properties: Map<String, Value> = keys
            .iter()
            .map(|key| ((*key).to_string(), schema(key)))
            .collect();
        table(&Value::Object(properties), needed)
    };
    let [recordings_key, designs_key, require_key, allow_key] = TABLES;
    let require = array(&REQUIRE_KEYS, &["verdict"], &|key| match key {
        "verdict" => verdict.clone(),
        _ => described(&text, "Pattern of names; all if left out"),
    });
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "latchgate gate",
        "type": "object",
        "additionalProperties": false,
        "required": [recordings_key, designs_key],
        "properties": {
            recordings_key: {"type": "array", "minItems": 1, "items": table(&Value::Object(recordings), &[FILES])},
            designs_key: {"type": "array", "minItems": 1, "items": array(&DESIGN_KEYS, &[], &|key| match key {
                "set" => described(&set, "Overrides of design keys"),
                "file" => described(&text, "Design file, relative to the gate file; the paper's \
                                            lever if left out"),
                _ => described(&text, "Name; that of the design file if left out"),
            })},
            REQUIRE_STATIC: {
                "description": "Static load that every design is to hold [g], in any direction, or in those of a standard",
                "anyOf": [load, {
                    "type": "object", "additionalProperties": false, "required": ["g", "standard"],
                    "properties": {"g": load, "standard": {"enum": standards}, "door": {"enum": doors}},
                }],
            },
            require_key: {"anyOf": [verdict, {"type": "array", "items": require}]},
            allow_key: {"type": "array", "items": array(&ALLOW_KEYS, &ALLOW_KEYS, &|key| match key {
                "until" => described(&day, "Last day on which the exception holds"),
                "reason" => described(&text, "Why the undecided pair is let through"),
                _ => described(&text, "Pattern of names"),
            })},
        },
    })
}

fn table(properties: &Value, needed: &[&str]) -> Value {
    json!({"type": "object", "additionalProperties": false, "required": needed, "properties": properties})
}

fn described(schema: &Value, what: &str) -> Value {
    let mut schema = schema.clone();
    if let Value::Object(object) = &mut schema {
        object.insert("description".into(), what.into());
    }
    schema
}
