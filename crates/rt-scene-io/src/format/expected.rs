//! Values that the format expects at a position, in words.
//!
//! The JSON Schema lists them for every position. It is parsed when the first error is explained.

use std::sync::LazyLock;

use serde_json::Value;

use super::cursor::Key;
use super::schema::{choice_name, choices, length, reference, type_of};
use super::{deprecated, schema};

/// Notation of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Notation {
    Ron,
    Json,
}

/// The schema of scene files.
pub(super) struct Schema(&'static Value);

/// Parsed when the first mistake is explained, once for all.
static SCHEMA: LazyLock<Value> = LazyLock::new(schema::value);

/// Alternatives at a position.
#[derive(Clone, Debug)]
pub(super) struct Slot<'s> {
    alternatives: Vec<&'s Value>,
    /// The type or the choice that the fields here belong to.
    pub(super) context: &'s str,
    /// The type, if it has a name.
    pub(super) definition: Option<&'s str>,
}

impl Schema {
    pub(super) fn new() -> Self {
        Self(&SCHEMA)
    }

    /// Alternatives at the end of a path; `None` if the path leaves the format.
    pub(super) fn slot(&self, path: &[Key<'_>]) -> Option<Slot<'_>> {
        let mut slot = self.expand(vec![self.0], "Scene");
        slot.definition = Some("Scene");
        for key in path {
            slot = self.step(&slot, *key)?;
        }
        Some(slot)
    }

    fn step<'s>(&'s self, slot: &Slot<'s>, key: Key<'_>) -> Option<Slot<'s>> {
        let of = |name: &str| slot.alternatives.iter().filter_map(|any| any.get(name)).collect::<Vec<_>>();
        let inner = match key {
            Key::Name(name) => {
                let find = |name: &str| {
                    of("properties").into_iter().find_map(|fields| fields.as_object()?.get_key_value(name))
                };
                let known = find(name).or_else(|| deprecated::present_spellings(name, None).find_map(find));
                match known {
                    Some((name, field)) => return Some(self.expand(vec![field], name)),
                    None => of("additionalProperties").into_iter().filter(|any| any.is_object()).collect(),
                }
            }
            Key::Index(index) | Key::Argument(index) => {
                let list = of("prefixItems").into_iter().filter_map(Value::as_array);
                let fixed: Vec<&Value> = list.filter_map(|list| list.get(index)).collect();
                // A choice around one value is written with parentheses around that value.
                let is_argument = matches!(key, Key::Argument(_));
                if is_argument && (slot.definition.is_some() || fixed.is_empty()) {
                    return Some(slot.clone());
                }
                if fixed.is_empty() { of("items") } else { fixed }
            }
        };
        (!inner.is_empty()).then(|| self.expand(inner, slot.context))
    }

    /// Follows references and choices between schemas.
    fn expand<'s>(&'s self, schemas: Vec<&'s Value>, context: &'s str) -> Slot<'s> {
        let mut slot = Slot { alternatives: Vec::new(), context, definition: None };
        let mut waiting = schemas;
        waiting.reverse();
        while let Some(schema) = waiting.pop() {
            if let Some(name) = reference(schema) {
                if let Some((name, definition)) =
                    self.0.get("$defs").and_then(Value::as_object).and_then(|all| all.get_key_value(name))
                {
                    if slot.definition.is_none() {
                        (slot.definition, slot.context) = (Some(name.as_str()), name);
                    }
                    waiting.push(definition);
                }
                continue;
            }
            let choices: Vec<&Value> = choices(schema).collect();
            if choices.is_empty() {
                if type_of(schema) != "null" {
                    slot.alternatives.push(schema);
                }
            } else {
                waiting.extend(choices.into_iter().rev());
            }
        }
        slot
    }
}

impl<'s> Slot<'s> {
    /// True if a field of this name can be here.
    pub(super) fn has_field(&self, name: &str) -> bool {
        self.alternatives.iter().any(|any| any.get("properties").is_some_and(|fields| fields.get(name).is_some()))
    }

    /// The names of the fields here.
    pub(super) fn fields(&self) -> Vec<String> {
        let fields = self.alternatives.iter().filter_map(|any| any.get("properties")?.as_object());
        fields.flat_map(|fields| fields.keys().cloned()).collect()
    }

    /// Fields that a choice with fields needs; `None` for a choice with a value.
    pub(super) fn required_fields(&self) -> Option<Vec<&'s str>> {
        let [any] = self.alternatives[..] else { return None };
        any.get("properties").filter(|_| self.definition.is_none())?;
        let required = any.get("required").and_then(Value::as_array);
        Some(required.into_iter().flatten().filter_map(Value::as_str).collect())
    }

    /// Name of a choice here of several values without names, and their number.
    pub(super) fn value_count(&self, name: &str) -> Option<(&'s str, u64)> {
        self.alternatives.iter().find_map(|any| {
            let (name, values) = any.get("properties")?.as_object()?.get_key_value(name)?;
            Some((name.as_str(), values.get("maxItems")?.as_u64()?))
        })
    }

    /// The names of the choices here, and whether each has fields or values of its own.
    pub(super) fn choices(&self) -> Vec<(&'s str, bool)> {
        let name = |any: &'s Value| -> Option<(&'s str, bool)> {
            if let Some(name) = any.get("const").and_then(Value::as_str) {
                return Some((name, false));
            }
            let fields = any.get("properties")?.as_object().filter(|fields| fields.len() == 1)?;
            Some((fields.get_key_value(choice_name(any)?)?.0, true))
        };
        let named =
            self.alternatives.iter().copied().filter_map(|any| match any.get("enum").and_then(Value::as_array) {
                Some(names) => Some(names.iter().filter_map(|name| Some((name.as_str()?, false))).collect()),
                None => name(any).map(|one| vec![one]),
            });
        if self.definition.is_none() { Vec::new() } else { named.flatten().collect() }
    }

    /// True for names and their values.
    pub(super) fn is_map(&self) -> bool {
        self.alternatives.iter().any(|any| any.get("additionalProperties").is_some_and(Value::is_object))
    }

    /// Elements of a list of fixed length.
    pub(super) fn fixed_length(&self) -> Option<usize> {
        self.alternatives.iter().find_map(|any| length(any))
    }

    /// Description of the expected value.
    pub(super) fn words(&self, notation: Notation) -> String {
        let is_ron = notation == Notation::Ron;
        match (self.definition, is_ron) {
            (Some("Scene"), true) => return "a scene, which begins with `(`: (nodes: [...])".to_owned(),
            (Some("Scene"), false) => return "a scene, which begins with `{`: {\"nodes\": [...]}".to_owned(),
            (Some("Color"), true) => return "a colour: a number, (r, g, b) or \"#rrggbb\"".to_owned(),
            (Some("Color"), false) => return "a colour: a number, [r, g, b] or \"#rrggbb\"".to_owned(),
            (Some("ColorTexture"), true) => {
                return "a colour: a number, (r, g, b), \"#rrggbb\", checker(...) or image(...)".to_owned();
            }
            (Some("ColorTexture"), false) => {
                let texture = "{\"checker\": {...}} or {\"image\": {...}}";
                return format!("a colour: a number, [r, g, b], \"#rrggbb\", {texture}");
            }
            (Some("NodeMaterial"), true) => {
                return "a material: its name in quotes, or one such as diffuse(albedo: 0.8)".to_owned();
            }
            (Some("NodeMaterial"), false) => {
                return "a material: its name, or one such as {\"diffuse\": {\"albedo\": 0.8}}".to_owned();
            }
            _ => {}
        }
        let choices = self.choices();
        if !choices.is_empty() {
            let mut listed: Vec<String> = choices.iter().take(12).map(|(name, _)| format!("`{name}`")).collect();
            if choices.len() > listed.len() {
                listed.push("...".to_owned());
            }
            return if listed.len() == 1 { listed.concat() } else { format!("one of {}", listed.join(", ")) };
        }
        self.alternatives.first().map_or_else(|| "another value".to_owned(), |schema| self.words_of(schema, notation))
    }

    fn words_of(&self, schema: &Value, notation: Notation) -> String {
        let is_ron = notation == Notation::Ron;
        match type_of(schema) {
            "number" => "a number".to_owned(),
            "integer" if schema.get("minimum").and_then(Value::as_f64) == Some(0.0) => {
                "a whole number from 0 up".to_owned()
            }
            "integer" => "a whole number".to_owned(),
            "string" => "text in double quotes".to_owned(),
            "boolean" => "true or false".to_owned(),
            "array" => match (self.fixed_length(), is_ron) {
                (Some(length), true) if has_parts(schema) => format!("{length} values in parentheses"),
                (Some(length), false) if has_parts(schema) => format!("{length} values in brackets"),
                (Some(2), true) => "two values: (a, b)".to_owned(),
                (Some(2), false) => "two values: [a, b]".to_owned(),
                (Some(3), true) => "(x, y, z)".to_owned(),
                (Some(3), false) => "[x, y, z]".to_owned(),
                (Some(length), true) => format!("{length} values in parentheses"),
                (Some(length), false) => format!("{length} values in brackets"),
                (None, _) if is_list_of_steps(schema) => "a list of steps in brackets".to_owned(),
                (None, _) => "a list in brackets".to_owned(),
            },
            _ if self.is_map() => "names and values in braces: {\"name\": ...}".to_owned(),
            _ if is_ron => "fields in parentheses: (name: value, ...)".to_owned(),
            _ => "fields in braces: {\"name\": value, ...}".to_owned(),
        }
    }
}

/// True for a list of fixed length whose elements have parts, such as points.
fn has_parts(schema: &Value) -> bool {
    ["/prefixItems/0", "/items"].iter().filter_map(|part| schema.pointer(part)).any(|part| type_of(part) == "array")
}

fn is_list_of_steps(schema: &Value) -> bool {
    schema.pointer("/items/$ref").and_then(Value::as_str) == Some("#/$defs/Step")
}
