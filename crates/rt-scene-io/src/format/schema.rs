//! JSON Schema of scene files.
//!
//! `scene.schema.json` holds it, so that programs need not build it. The feature `schema` derives it from the types; a test
//! compares the two, and rewrites the file if they differ.

use serde_json::Value;

/// The JSON Schema of [`SceneFile`](super::SceneFile), for editors to complete and check scene files by.
pub const fn json_schema() -> &'static str {
    include_str!("scene.schema.json")
}

/// The schema as a value.
pub(super) fn value() -> Value {
    serde_json::from_str(json_schema()).unwrap_or_default()
}

/// Alternatives of a schema.
pub(super) fn choices(schema: &Value) -> impl Iterator<Item = &Value> {
    ["oneOf", "anyOf"].into_iter().filter_map(|key| schema.get(key)?.as_array()).flatten()
}

/// The name of a choice that is an object of one field.
pub(super) fn choice_name(choice: &Value) -> Option<&str> {
    let [one] = &choice.get("required")?.as_array()?[..] else { return None };
    one.as_str()
}

/// Name of the definition that a schema refers to.
pub(super) fn reference(schema: &Value) -> Option<&str> {
    schema.get("$ref")?.as_str()?.rsplit('/').next()
}

pub(super) fn type_of(schema: &Value) -> &str {
    match schema.get("type") {
        Some(Value::Array(kinds)) => kinds.first().and_then(Value::as_str),
        kind => kind.and_then(Value::as_str),
    }
    .unwrap_or_default()
}

/// The length of a list of fixed length.
pub(super) fn length(schema: &Value) -> Option<usize> {
    schema.get("maxItems").and_then(Value::as_u64).and_then(|length| usize::try_from(length).ok())
}

#[cfg(all(test, feature = "schema"))]
mod tests {
    use crate::format::SceneFile;

    #[test]
    fn the_stored_schema_is_that_of_the_types() {
        let mut derived = serde_json::to_string_pretty(&schemars::schema_for!(SceneFile)).expect("a schema");
        derived.push('\n');
        if derived != super::json_schema() {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/format/scene.schema.json");
            std::fs::write(path, &derived).expect("a file");
            panic!("{path} was out of date; it has been rewritten: commit it");
        }
    }
}
