//! The reference page of the format, made of the JSON Schema.
//!
//! Descriptions of fields end in a line of marks: `Unit: degrees. Default: 40. Example: fov: 35.`
//!
//! A field with a default in the schema needs no mark for it. Without an example, one is made from its type.

use std::fmt::Write;

use serde_json::{Map, Value};

use super::schema::{self, choice_name, choices, length, reference, type_of};

/// The types in the order in which they are described, each with its heading.
const TYPES: [(&str, &str); 36] = [
    ("Scene", "Scene"),
    ("Node", "Nodes"),
    ("Shape", "Shapes"),
    ("InsideRule", "Inside of polygons"),
    ("Step", "Steps of a transformation"),
    ("NodeMaterial", "Material of a node"),
    ("Material", "Materials"),
    ("Highlight", "Highlights"),
    ("Metal", "Metals"),
    ("EmissionSides", "Emission sides"),
    ("Color", "Colours"),
    ("ColorTexture", "Coefficients and textures"),
    ("Wrap", "Edges of images"),
    ("Light", "Lights"),
    ("LightUnits", "Units of lights"),
    ("Falloff", "Falloff"),
    ("Background", "Background"),
    ("Camera", "Cameras"),
    ("FovAxis", "Sides of the image"),
    ("Lens", "Lens"),
    ("NodeAnimation", "Animations of nodes"),
    ("NodeKey", "Keys of nodes"),
    ("CameraAnimation", "Animations of cameras"),
    ("CameraKey", "Keys of cameras"),
    ("Interpolation", "Interpolation"),
    ("Film", "Film"),
    ("Filter", "Filters"),
    ("Tone", "Tone curves"),
    ("Encoding", "Encodings"),
    ("Settings", "Settings"),
    ("Integrator", "Integrators"),
    ("Sampler", "Samplers"),
    ("Adaptive", "Adaptive sampling"),
    ("LightSampling", "Choice of lights"),
    ("Accel", "Accelerators"),
    ("Truth", "Truth"),
];

const INTRODUCTION: &str = r##"# The scene format

Every field of scene files (`.ron` and `.json`), with its type, unit, default, meaning and an example. `rt-cli schema --markdown`
writes this page from the source of the format; [scene.schema.json](../scenes/scene.schema.json) says the same to editors.

The smallest scene has one node. Everything else has a default:

```ron
(nodes: [(shape: sphere(), material: diffuse(albedo: 0.8))])
```

The same in JSON. There a choice such as `sphere(radius: 2)` is an object with one field, vectors stand in brackets, and
`$schema` may name the schema:

```json
{"$schema": "scene.schema.json", "nodes": [{"shape": {"sphere": {}}, "material": {"diffuse": {"albedo": 0.8}}}]}
```

| written in RON | written in JSON | meaning |
|---|---|---|
| `0.3` | `0.3` | number; where a colour is expected, grey |
| `(1, 0, 0)` | `[1, 0, 0]` | vector, or linear red, green and blue |
| `"#ff0000"`, `"#f00"` | `"#ff0000"`, `"#f00"` | colour as web pages write it |
| `sphere(radius: 2)` | `{"sphere": {"radius": 2}}` | choice with fields |
| `path` | `"path"` | choice without fields |
| `{"red": ...}` | `{"red": ...}` | names and values |

**Coordinates.** The y axis points up, cameras look along −z, and coordinates are right-handed. Angles are in degrees. A scene
may use any unit of length; all lengths are in that unit.

**Colours.** `"#ff0000"` is a display colour: each pair of digits is a value of the sRGB curve from 00 to ff. It is decoded to
linear light before use, so that `"#808080"` is 0.216 and not 0.5. `"#f80"` is short for `"#ff8800"`. Digits for alpha are
refused. Numbers are linear already: `0.5`, `(1, 0.5, 0)`, `gray(0.5)` and `rgb(1, 0.5, 0)` are used as they are.

**Light.** Radiance 1 is shown as white unless `film` has an exposure.

"##;

/// The reference page of scene files, in Markdown.
pub fn reference_page() -> String {
    let root = schema::value();
    let format = Format { root: &root };
    let mut page = INTRODUCTION.to_owned();
    for (name, heading) in TYPES {
        format.describe(name, heading, &mut page);
    }
    page.trim_end().to_owned() + "\n"
}

struct Format<'s> {
    root: &'s Value,
}

/// A field as a row of a table.
struct FieldRow {
    field: String,
    kind: String,
    unit: String,
    default: String,
    meaning: String,
    example: String,
}

/// A description without its marks, and the marks.
#[derive(Default)]
struct Description {
    meaning: String,
    unit: Option<String>,
    default: Option<String>,
    example: Option<String>,
}

impl<'s> Format<'s> {
    fn definition(&self, name: &str) -> &'s Value {
        let definitions = self.root.get("$defs").and_then(|all| all.get(name));
        if name == "Scene" { self.root } else { definitions.unwrap_or(&Value::Null) }
    }

    fn describe(&self, name: &str, heading: &str, page: &mut String) {
        let schema = self.definition(name);
        // Writing to memory cannot fail.
        let _ = writeln!(page, "## {heading}\n");
        let _ = writeln!(page, "`{name}`. {}\n", Description::of(schema).meaning);
        if schema.get("properties").is_some() {
            self.table(schema, page);
            return;
        }
        let (plain, rich): (Vec<&Value>, Vec<&Value>) =
            choices(schema).partition(|choice| self.fields_of(choice).is_none());
        if !plain.is_empty() {
            page.push_str("| written | meaning |\n|---|---|\n");
            for choice in plain {
                let _ = writeln!(page, "| {} | {} |", code(&self.form(choice)), cell(&Description::of(choice).meaning));
            }
            page.push('\n');
        }
        for choice in rich {
            let (Some(name), Some(fields)) = (choice_name(choice), self.fields_of(choice)) else { continue };
            let _ = writeln!(page, "### `{name}`\n\n{}\n", Description::of(choice).meaning);
            if properties(fields).is_some_and(|fields| !fields.is_empty()) {
                self.table(fields, page);
            }
        }
    }

    /// True for a type that is no choice.
    fn has_fields(&self, name: &str) -> bool {
        self.definition(name).get("properties").is_some()
    }

    /// The fields of a choice that has fields.
    fn fields_of(&self, choice: &'s Value) -> Option<&'s Value> {
        let inner = choice.get("properties")?.get(choice_name(choice)?)?;
        (type_of(inner) == "object").then_some(inner)
    }

    fn table(&self, schema: &'s Value, page: &mut String) {
        page.push_str("| field | type | unit | default | meaning | example |\n|---|---|---|---|---|---|\n");
        for FieldRow { field, kind, unit, default, meaning, example } in self.rows(schema) {
            let _ = writeln!(
                page,
                "| `{field}` | {} | {unit} | {} | {} | {} |",
                cell(&kind),
                cell(&default),
                cell(&meaning),
                code(&example)
            );
        }
        page.push('\n');
    }

    /// The fields of an object: those that are needed first.
    fn rows(&self, schema: &'s Value) -> Vec<FieldRow> {
        let Some(fields) = properties(schema) else { return Vec::new() };
        let mut rows: Vec<(bool, FieldRow)> = fields
            .iter()
            .map(|(name, field)| {
                let description = Description::of(field);
                let is_needed = is_required(schema, name);
                let default = match (is_needed, description.default, field.get("default")) {
                    (true, ..) => "needed".to_owned(),
                    (_, Some(said), _) => said,
                    (_, None, Some(Value::Object(_))) if reference(field).is_some_and(|name| self.has_fields(name)) => {
                        "that of each field".to_owned()
                    }
                    (_, None, Some(value)) => format!("`{}`", self.ron(value, field)),
                    (_, None, None) => "none".to_owned(),
                };
                let example = description.example.unwrap_or_else(|| format!("{name}: {}", self.sample(field, 0)));
                let unit = description.unit.unwrap_or_else(|| "–".to_owned());
                let (field, kind) = (name.clone(), self.kind(field));
                (!is_needed, FieldRow { field, kind, unit, default, meaning: description.meaning, example })
            })
            .collect();
        rows.sort_by_key(|(is_optional, _)| *is_optional);
        rows.into_iter().map(|(_, row)| row).collect()
    }

    /// The type of a value, in a few words with links.
    fn kind(&self, schema: &'s Value) -> String {
        if let Some(name) = reference(schema) {
            let heading = TYPES.iter().find(|(known, _)| *known == name).map_or(name, |(_, heading)| heading);
            return format!("[{name}](#{})", heading.to_lowercase().replace(' ', "-"));
        }
        if let Some(inner) = present(schema) {
            return self.kind(inner);
        }
        match type_of(schema) {
            "number" => "number".to_owned(),
            "integer" => "whole number".to_owned(),
            "string" => "text".to_owned(),
            "boolean" => "`true` or `false`".to_owned(),
            "array" => match (length(schema), elements(schema)) {
                (Some(3), Some(_)) if holds_numbers(schema) => "(x, y, z)".to_owned(),
                (Some(count), Some(inner)) if count <= 4 => {
                    let of = |i: usize| prefix(schema, i).unwrap_or(inner);
                    let kinds: Vec<String> = (0..count).map(|i| self.kind(of(i))).collect();
                    format!("({})", kinds.join(", "))
                }
                (_, Some(inner)) => format!("list of {}", self.kind(inner)),
                (_, None) => "list".to_owned(),
            },
            _ => schema
                .get("additionalProperties")
                .map_or("object".to_owned(), |inner| format!("{{name: {}}}", self.kind(inner))),
        }
    }

    /// Notation of a choice.
    fn form(&self, choice: &'s Value) -> String {
        if let Some(example) = Description::of(choice).example {
            return example;
        }
        if let Some(name) = choice.get("const").and_then(Value::as_str) {
            return name.to_owned();
        }
        if choice_name(choice).is_some() { self.sample_of_choice(choice, 0) } else { self.sample(choice, 0) }
    }

    /// A value of this type, in RON.
    fn sample(&self, schema: &'s Value, depth: usize) -> String {
        if let Some(value) =
            schema.get("default").filter(|value| !value.is_object() && *value != &Value::Array(Vec::new()))
        {
            return self.ron(value, schema);
        }
        match reference(schema) {
            Some("Color") => return "\"#ffcc88\"".to_owned(),
            Some("ColorTexture") => return "(0.8, 0.3, 0.1)".to_owned(),
            Some("Material" | "NodeMaterial") => return "diffuse(albedo: 0.8)".to_owned(),
            Some(name) => return self.sample(self.definition(name), depth),
            None => {}
        }
        if let Some(inner) = present(schema) {
            return self.sample(inner, depth);
        }
        if let Some(choice) = choices(schema).last() {
            return self.form(choice);
        }
        match type_of(schema) {
            "number" => "1.5".to_owned(),
            "integer" => "16".to_owned(),
            // Colours are the only texts that follow a pattern.
            "string" if schema.get("pattern").is_some() => "\"#ff8000\"".to_owned(),
            "string" => "\"name\"".to_owned(),
            "boolean" => "true".to_owned(),
            "array" => {
                let Some(inner) = elements(schema) else { return "[]".to_owned() };
                match length(schema) {
                    Some(3) if holds_numbers(schema) => "(0, 1, 0)".to_owned(),
                    Some(2) if holds_numbers(schema) => "(0, 1)".to_owned(),
                    Some(count) => {
                        let of = |i: usize| prefix(schema, i).unwrap_or(inner);
                        let values: Vec<String> = (0..count).map(|i| self.sample(of(i), depth + 1)).collect();
                        format!("({})", values.join(", "))
                    }
                    None if depth > 3 => "[]".to_owned(),
                    None => format!("[{}]", self.sample(inner, depth + 1)),
                }
            }
            _ => match schema.get("additionalProperties").filter(|inner| inner.is_object()) {
                Some(inner) => format!("{{\"name\": {}}}", self.sample(inner, depth + 1)),
                None => format!("({})", self.required(schema, depth)),
            },
        }
    }

    fn sample_of_choice(&self, choice: &'s Value, depth: usize) -> String {
        let Some(name) = choice_name(choice) else { return String::new() };
        let Some(inner) = choice.get("properties").and_then(|fields| fields.get(name)) else { return String::new() };
        if type_of(inner) == "object" {
            return format!("{name}({})", self.required(inner, depth));
        }
        let value = self.sample(inner, depth + 1);
        // The values of a choice with several stand in its own parentheses.
        if inner.get("prefixItems").is_some() { format!("{name}{value}") } else { format!("{name}({value})") }
    }

    /// The fields that an object needs.
    fn required(&self, schema: &'s Value, depth: usize) -> String {
        let fields = properties(schema).into_iter().flatten().filter(|(name, _)| is_required(schema, name));
        let written = fields.map(|(name, field)| {
            Description::of(field).example.unwrap_or_else(|| format!("{name}: {}", self.sample(field, depth + 1)))
        });
        written.collect::<Vec<_>>().join(", ")
    }

    /// A value of the schema in RON.
    fn ron(&self, value: &Value, schema: &'s Value) -> String {
        match value {
            Value::Array(values) => {
                let of = |i: usize| prefix(schema, i).or_else(|| elements(schema)).unwrap_or(&Value::Null);
                let written: Vec<String> = values.iter().enumerate().map(|(i, value)| self.ron(value, of(i))).collect();
                let list = written.join(", ");
                if length(schema).is_some() { format!("({list})") } else { format!("[{list}]") }
            }
            Value::Object(fields) => match fields.iter().next() {
                // The short spelling of a colour.
                Some((name, inner)) if name == "gray" => self.ron(inner, &Value::Null),
                Some((name, inner)) => format!("{name}({})", self.ron(inner, &Value::Null)),
                None => "()".to_owned(),
            },
            // A choice without fields.
            Value::String(word) if reference(schema).is_some() => word.clone(),
            Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), |number| number.to_string()),
            other => other.to_string(),
        }
    }
}

impl Description {
    fn of(schema: &Value) -> Self {
        let text = schema.get("description").and_then(Value::as_str).unwrap_or_default();
        let mut description = Self::default();
        let marks = text
            .lines()
            .last()
            .filter(|line| ["Unit: ", "Default: ", "Example: "].iter().any(|mark| line.starts_with(mark)));
        let meaning = marks.map_or(text, |marks| &text[..text.len() - marks.len()]);
        description.meaning = meaning.split_whitespace().collect::<Vec<_>>().join(" ");
        let mut rest = marks.unwrap_or_default();
        while let Some((mark, after)) = rest.split_once(": ") {
            let end = [". Unit: ", ". Default: ", ". Example: "].iter().filter_map(|next| after.find(next)).min();
            let value = after[..end.unwrap_or(after.len())].trim_end_matches('.').to_owned();
            match mark {
                "Unit" => description.unit = Some(value),
                "Default" => description.default = Some(value),
                _ => description.example = Some(value.trim_matches('`').to_owned()),
            }
            rest = end.map_or("", |end| &after[end + 2..]);
        }
        description
    }
}

fn properties(schema: &Value) -> Option<&Map<String, Value>> {
    schema.get("properties").and_then(Value::as_object)
}

fn is_required(schema: &Value, name: &str) -> bool {
    schema.get("required").and_then(Value::as_array).is_some_and(|names| names.iter().any(|known| known == name))
}

/// Schema of an optional value that is present.
fn present(schema: &Value) -> Option<&Value> {
    let options = schema.get("anyOf")?.as_array()?;
    let is_null = |option: &&Value| type_of(option) == "null";
    options.iter().any(|option| is_null(&option)).then(|| options.iter().find(|option| !is_null(option)))?
}

fn elements(schema: &Value) -> Option<&Value> {
    schema.get("items").or_else(|| prefix(schema, 0))
}

/// True for a list of fixed length of numbers only.
fn holds_numbers(schema: &Value) -> bool {
    let is_number = |inner: &Value| type_of(inner) == "number";
    match schema.get("prefixItems").and_then(Value::as_array) {
        Some(all) => all.iter().all(is_number),
        None => schema.get("items").is_some_and(is_number),
    }
}

fn prefix(schema: &Value, index: usize) -> Option<&Value> {
    schema.get("prefixItems")?.get(index)
}

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// Code in a cell of a table.
fn code(text: &str) -> String {
    format!("`{}`", cell(text))
}

#[cfg(test)]
mod tests {
    use serde::de::DeserializeOwned;

    use super::super::*;
    use super::*;

    /// Parses a value of a type of this name.
    fn parse(name: &str, text: &str) -> Result<(), String> {
        fn of<T: DeserializeOwned>(text: &str) -> Result<(), String> {
            ron_options::ron_options().from_str::<T>(text).map(drop).map_err(|error| error.to_string())
        }
        macro_rules! types {
            ($($name:literal $type:ty,)*) => {
                match name {
                    $($name => of::<$type>(text),)*
                    _ => Err("no such type".to_owned()),
                }
            };
        }
        types! {
            "Scene" SceneFile, "Node" Node, "Shape" Shape, "InsideRule" InsideRule, "Step" Step, "Material" Material,
            "NodeMaterial" NodeMaterial, "Highlight" Highlight, "Metal" Metal, "EmissionSides" EmissionSides, "Color" Color,
            "ColorTexture" ColorTexture, "Wrap" Wrap, "Light" Light, "LightUnits" LightUnits, "Falloff" Falloff,
            "Background" Background, "Camera" Camera, "FovAxis" FovAxis, "Lens" Lens, "NodeAnimation" NodeAnimation, "NodeKey" NodeKey,
            "CameraAnimation" CameraAnimation, "CameraKey" CameraKey, "Interpolation" Interpolation, "Film" Film,
            "Filter" Filter, "Tone" Tone, "Encoding" Encoding, "Settings" Settings, "Integrator" Integrator,
            "Sampler" Sampler, "Adaptive" Adaptive, "LightSampling" LightSampling, "Accel" Accel, "Truth" Truth,
        }
    }

    /// The example of a row, with the other fields that its type needs.
    fn whole(format: &Format<'_>, schema: &Value, row: &FieldRow) -> String {
        let others = format.rows(schema).into_iter();
        let others =
            others.filter(|other| other.default == "needed" && other.field != row.field).map(|other| other.example);
        others.chain([row.example.clone()]).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn every_example_of_the_page_is_read() {
        let root = schema::value();
        let format = Format { root: &root };
        let (mut faults, mut count) = (Vec::new(), 0);
        let mut check = |name: &str, text: String| {
            count += 1;
            if let Err(error) = parse(name, &text) {
                faults.push(format!("{name}: {text}: {error}"));
            }
        };
        for (name, _) in TYPES {
            let schema = format.definition(name);
            for row in format.rows(schema) {
                // Fields for JSON alone.
                if !row.field.starts_with('$') {
                    check(name, format!("({})", whole(&format, schema, &row)));
                }
            }
            for choice in choices(schema) {
                match (choice_name(choice), format.fields_of(choice)) {
                    (Some(chosen), Some(fields)) => {
                        for row in format.rows(fields) {
                            check(name, format!("{chosen}({})", whole(&format, fields, &row)));
                        }
                    }
                    _ => check(name, format.form(choice)),
                }
            }
        }
        assert!(faults.is_empty(), "{} of {count}\n{}", faults.len(), faults.join("\n"));
        assert!(count > 200, "{count}");
    }

    #[test]
    fn every_field_has_a_meaning_and_every_number_a_unit() {
        let root = schema::value();
        let format = Format { root: &root };
        let mut faults = Vec::new();
        for (name, _) in TYPES {
            let schema = format.definition(name);
            let objects = choices(schema).filter_map(|choice| format.fields_of(choice)).chain([schema]);
            for row in objects.flat_map(|schema| format.rows(schema)) {
                let is_number =
                    row.kind.contains("number") || row.kind.contains("(x, y, z)") || row.kind.contains("[Co");
                if row.meaning.is_empty() || (is_number && row.unit == "–") {
                    faults.push(format!("{name} {}: {} ({})", row.field, row.meaning, row.kind));
                }
            }
        }
        assert!(faults.is_empty(), "{}\n{}", faults.len(), faults.join("\n"));
    }

    #[test]
    fn every_type_of_the_schema_is_on_the_page() {
        let root = schema::value();
        let definitions = root["$defs"].as_object().expect("definitions");
        let missing: Vec<&String> =
            definitions.keys().filter(|name| TYPES.iter().all(|(known, _)| known != name)).collect();
        assert_eq!(missing, [""; 0]);
    }

    #[test]
    fn the_scenes_of_the_introduction_are_read() {
        let blocks: Vec<&str> = INTRODUCTION.split("```").skip(1).step_by(2).collect();
        assert_eq!(blocks.len(), 2);
        let path = std::path::Path::new("scene");
        parse_ron(blocks[0].strip_prefix("ron\n").expect("RON"), path).expect("a scene");
        parse_json(blocks[1].strip_prefix("json\n").expect("JSON"), path).expect("a scene");
    }

    #[test]
    fn marks_are_separated_from_the_meaning() {
        let schema =
            serde_json::json!({"description": "An\nangle.\n\nUnit: degrees. Default: 40.5. Example: `fov: 3.5`."});
        let Description { meaning, unit, default, example } = Description::of(&schema);
        assert_eq!(meaning, "An angle.");
        assert_eq!([unit, default, example].map(Option::unwrap), ["degrees", "40.5", "fov: 3.5"]);
    }
}
