//! Earlier spellings of fields and choices, which are still read, each with a warning that names the present one.

use super::cursor::{Cursor, Key};
use crate::Warning;
use crate::error::times;
use crate::excerpt::Position;

/// An earlier spelling of a field, of a choice for a field, or of a choice with a value.
struct Deprecated {
    /// Fields or choices that have the field; empty for a choice with a value, which is known everywhere but in a map of names.
    parents: &'static [&'static str],
    /// Field of the choice; `None` if the spelling is that of a field or of a choice with a value.
    choice_of: Option<&'static str>,
    old: &'static str,
    new: &'static str,
}

/// Lights with an intensity.
const DELTA_LIGHTS: &[&str] = &["point", "directional", "spot"];

/// Lights with a radiance.
const AREA_LIGHTS: &[&str] = &["quad", "disk", "sphere", "cylinder"];

/// Fields whose values have names of the user's choice.
const MAPS: &[&str] = &["materials", "groups"];

const DEPRECATED: [Deprecated; 32] = [
    field(&["quad", "disk", "light", "phong"], "shines", "emission_sides"),
    field(&["point"], "lamp_radius", "shadow_near"),
    field(&["settings"], "depth", "max_depth"),
    field(&["settings"], "roulette_from", "rr_start_depth"),
    field(&["object_space"], "least", "min_spp"),
    field(&["diffuse"], "color", "albedo"),
    field(&["diffuse"], "colour", "albedo"),
    field(&["mirror"], "color", "reflectance"),
    field(&["mirror"], "colour", "reflectance"),
    field(&["metallic_roughness"], "color", "base_color"),
    field(&["metallic_roughness"], "colour", "base_color"),
    field(&["glass", "thin_glass"], "color", "transmittance"),
    field(&["glass", "thin_glass"], "colour", "transmittance"),
    field(&["glossy"], "color", "diffuse"),
    field(&["glossy"], "colour", "diffuse"),
    field(&["phong"], "colour", "color"),
    field(&["light"], "color", "radiance"),
    field(&["light"], "colour", "radiance"),
    field(&["light"], "emission", "radiance"),
    field(DELTA_LIGHTS, "color", "intensity"),
    field(DELTA_LIGHTS, "colour", "intensity"),
    field(AREA_LIGHTS, "color", "radiance"),
    field(AREA_LIGHTS, "colour", "radiance"),
    field(&["sphere", "disk"], "centre", "center"),
    choice_with_value("grey", "gray"),
    choice(&["settings"], "integrator", "caustics", "path_caustics"),
    choice(&["settings"], "integrator", "ao", "ambient_occlusion"),
    choice(&["settings"], "sampler", "center", "centre"),
    choice(&["settings"], "accel", "wide", "bvh8"),
    choice(&["settings"], "accel", "spheres", "sphere_tree"),
    choice(&["settings"], "accel", "cylinders", "cylinder_tree"),
    choice(&["metal"], "metal", "aluminum", "aluminium"),
];

const fn field(parents: &'static [&'static str], old: &'static str, new: &'static str) -> Deprecated {
    Deprecated { parents, choice_of: None, old, new }
}

/// Spelling of a choice with a value.
const fn choice_with_value(old: &'static str, new: &'static str) -> Deprecated {
    Deprecated { parents: &[], choice_of: None, old, new }
}

/// Spelling of a choice for a field.
const fn choice(
    parents: &'static [&'static str],
    field: &'static str,
    old: &'static str,
    new: &'static str,
) -> Deprecated {
    Deprecated { parents, choice_of: Some(field), old, new }
}

impl Deprecated {
    /// True if the spelling is deprecated for this parent.
    fn is_below(&self, parent: &str) -> bool {
        if self.parents.is_empty() { !MAPS.contains(&parent) } else { self.parents.contains(&parent) }
    }
}

/// Present spellings of a deprecated field: several if parents differ, none for all other words. A `parent` limits them to its own.
pub(super) fn present_spellings(old: &str, parent: Option<&str>) -> impl Iterator<Item = &'static str> {
    let deprecated = DEPRECATED.iter().filter(move |spelling| {
        spelling.choice_of.is_none() && spelling.old == old && parent.is_none_or(|parent| spelling.is_below(parent))
    });
    deprecated.map(|spelling| spelling.new)
}

/// Word after the colon that follows the key at this byte, and its byte; empty for a value that is not a word.
fn choice_after(text: &str, key: usize) -> (usize, &str) {
    let start = text[key..].find(':').map_or(text.len(), |colon| key + colon + 1);
    let value = text[start..].trim_start_matches(|c: char| c.is_whitespace() || c == '"');
    let end = value.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(value.len());
    (text.len() - value.len(), &value[..end])
}

/// True if the word occurs next to a colon or a comment, or before a parenthesis, and not only as part of a longer word.
fn has_word(text: &str, word: &str) -> bool {
    let is_mark = |byte: u8| matches!(byte, b':' | b'/');
    text.match_indices(word).any(|(start, _)| {
        let (before, after) = (&text.as_bytes()[..start], &text.as_bytes()[start + word.len()..]);
        let is_part = |byte: Option<&u8>| byte.is_some_and(|&byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let is_blank = |byte: &&u8| byte.is_ascii_whitespace() || **byte == b'"';
        let next = after.iter().find(|byte| !is_blank(byte));
        let last = before.iter().rfind(|byte| !is_blank(byte));
        !is_part(before.last())
            && !is_part(after.first())
            && ([last, next].into_iter().flatten().any(|&byte| is_mark(byte)) || next == Some(&b'('))
    })
}

/// One warning per deprecated spelling in the sound text of a scene. `file` is named in them.
pub(super) fn warnings(text: &str, file: &str) -> Vec<Warning> {
    let mut found: [Option<(usize, usize)>; DEPRECATED.len()] = [None; DEPRECATED.len()];
    // Most scenes have none, and a search is faster than the scanner.
    let may_be_in = |spelling: &Deprecated| {
        let mut around = spelling.choice_of.as_slice().iter().chain(spelling.parents);
        (spelling.parents.is_empty() || around.any(|word| text.contains(word))) && has_word(text, spelling.old)
    };
    if !DEPRECATED.iter().any(may_be_in) {
        return Vec::new();
    }
    Cursor::walk(text, text.len(), |cursor, name, at| {
        for (spelling, found) in DEPRECATED.iter().zip(&mut found) {
            let (at, word) = match spelling.choice_of {
                None => (at, name),
                Some(field) if field == name => choice_after(text, at),
                Some(_) => continue,
            };
            if word == spelling.old
                && matches!(cursor.container().last(), Some(Key::Name(parent)) if spelling.is_below(parent))
            {
                let (_, count) = found.get_or_insert((at, 0));
                *count += 1;
            }
        }
    });
    let warning = |(spelling, found): (&Deprecated, Option<(usize, usize)>)| {
        let (at, count) = found?;
        let Position { line, column } = Position::of(text, at);
        let message =
            format!("the spelling `{}` is deprecated: write `{}`{}", spelling.old, spelling.new, times(count));
        Some(Warning { place: format!("{file}:{line}:{column}"), message })
    };
    DEPRECATED.iter().zip(found).filter_map(warning).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{SceneFile, parse_json, parse_ron};

    /// A scene with all deprecated spellings, a rectangle with a depth, and a material named like a spelling.
    const OLD: &str = r#"(
    settings: (depth: 3, roulette_from: 2, adaptive: object_space(least: 2), integrator: depth),
    lights: [point(position: (0, 1, 0), lamp_radius: 0.5), quad(corner: (0, 1, 0), edges: ((1, 0, 0), (0, 0, 1)), shines: both)],
    materials: {"shines": phong(shines: front), "lamp": light(shines: both)},
    nodes: [(shape: rectangle(width: 1, depth: 2), material: "shines")],
)"#;

    fn with_new_spellings(text: &str) -> String {
        text.replace("shines: ", "emission_sides: ")
            .replace("lamp_radius", "shadow_near")
            .replace("(depth", "(max_depth")
            .replace("roulette_from", "rr_start_depth")
            .replace("least", "min_spp")
    }

    #[test]
    fn deprecated_spellings_are_read_with_a_warning_each() {
        let path = Path::new("s.ron");
        let old = parse_ron(OLD, path).expect("a scene");
        let new = parse_ron(&with_new_spellings(OLD), path).expect("a scene");
        let messages: Vec<String> = old.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            messages,
            [
                "s.ron:3:115: the spelling `shines` is deprecated: write `emission_sides` (3 times, this is the first)",
                "s.ron:3:41: the spelling `lamp_radius` is deprecated: write `shadow_near`",
                "s.ron:2:16: the spelling `depth` is deprecated: write `max_depth`",
                "s.ron:2:26: the spelling `roulette_from` is deprecated: write `rr_start_depth`",
                "s.ron:2:67: the spelling `least` is deprecated: write `min_spp`",
            ]
        );
        assert!(new.warnings.is_empty(), "{:?}", new.warnings);
        assert_eq!(SceneFile { warnings: Vec::new(), ..old }, new);
    }

    /// Some were read without a warning, and those of glass and glossy materials were refused. The schema does not have them.
    #[test]
    fn undocumented_colours_are_read_with_a_warning_each() {
        let light = |light: &str| format!("(nodes: [], lights: [{light}])");
        let material = |material: &str| format!("(nodes: [], materials: {{\"light\": {material}}})");
        let area = "radius: 1, color: 1";
        for (old, spelling, new) in [
            (material("diffuse(color: 0.5)"), "color", "albedo"),
            (material("mirror(colour: 0.5)"), "colour", "reflectance"),
            (material("metallic_roughness(color: 0.5)"), "color", "base_color"),
            (material("phong(colour: 0.5)"), "colour", "color"),
            (material("glass(color: 0.5)"), "color", "transmittance"),
            (material("thin_glass(colour: 0.5)"), "colour", "transmittance"),
            (material("glossy(color: 0.5)"), "color", "diffuse"),
            (material("light(color: 2)"), "color", "radiance"),
            (material("light(emission: 2)"), "emission", "radiance"),
            (light("point(position: (0, 1, 0), color: 2)"), "color", "intensity"),
            (light("directional(direction: (0, -1, 0), color: 2)"), "color", "intensity"),
            (light("spot(position: (0, 1, 0), direction: (0, -1, 0), color: 2)"), "color", "intensity"),
            (light("quad(corner: (0, 1, 0), edges: ((1, 0, 0), (0, 0, 1)), color: 2)"), "color", "radiance"),
            (light(&format!("disk(center: (0, 1, 0), normal: (0, 1, 0), {area})")), "color", "radiance"),
            (light(&format!("sphere(center: (0, 1, 0), {area})")), "color", "radiance"),
            (light(&format!("cylinder(base: (0, 1, 0), top: (0, 2, 0), {area})")), "color", "radiance"),
            ("(nodes: [(shape: sphere(centre: (0, 1, 0)))])".to_owned(), "centre", "center"),
        ] {
            let parsed = |text: &str| parse_ron(text, Path::new("s.ron")).unwrap_or_else(|error| panic!("{error}"));
            let read = parsed(&old);
            let messages: Vec<&str> = read.warnings.iter().map(|warning| &*warning.message).collect();
            assert_eq!(messages, [format!("the spelling `{spelling}` is deprecated: write `{new}`")], "{old}");
            let present = parsed(&old.replacen(&format!("{spelling}:"), &format!("{new}:"), 1));
            assert!(present.warnings.is_empty(), "{old}");
            assert_eq!(SceneFile { warnings: Vec::new(), ..read }, present);
        }
    }

    /// They were read without a warning. Materials and groups may have any name.
    #[test]
    fn undocumented_words_for_grey_and_aluminium_are_read_with_a_warning_each() {
        let grey = "the spelling `grey` is deprecated: write `gray`";
        let aluminum = "the spelling `aluminum` is deprecated: write `aluminium`";
        for (text, old, new, expected) in [
            ("(nodes: [(material: diffuse(albedo: grey(0.5)))])", "grey", "gray", Some(grey)),
            ("(nodes: [], background: constant( grey (0.5)))", "grey", "gray", Some(grey)),
            ("(nodes: [], lights: [ambient(grey(0.5))])", "grey", "gray", Some(grey)),
            (r#"{"nodes": [], "lights": [{"ambient": {"grey": 0.5}}]}"#, "grey", "gray", Some(grey)),
            (r#"{"nodes": [], "materials": {"m": {"phong": {"diffuse": {"grey": 0.5}}}}}"#, "grey", "gray", Some(grey)),
            (r#"(nodes: [], materials: {"grey": mirror()}, groups: {"grey": [()]})"#, "", "", None),
            (r#"{"nodes": [], "materials": {"grey": {"mirror": {}}}, "groups": {"grey": []}}"#, "", "", None),
            ("(nodes: [(material: metal(metal: aluminum))])", "aluminum", "aluminium", Some(aluminum)),
            (r#"{"nodes": [{"material": {"metal": {"metal": "aluminum"}}}]}"#, "aluminum", "aluminium", Some(aluminum)),
        ] {
            let parsed = |text: &str| match text.starts_with('{') {
                true => parse_json(text, Path::new("s.json")).unwrap_or_else(|error| panic!("{error}")),
                false => parse_ron(text, Path::new("s.ron")).unwrap_or_else(|error| panic!("{error}")),
            };
            let read = parsed(text);
            let messages: Vec<&str> = read.warnings.iter().map(|warning| &*warning.message).collect();
            assert_eq!(messages, Vec::from_iter(expected), "{text}");
            let present = parsed(&text.replace(old, new));
            assert!(present.warnings.is_empty() || old.is_empty(), "{text}");
            assert_eq!(SceneFile { warnings: Vec::new(), ..read }, present);
        }
    }

    /// The message said that the documented field was given twice.
    #[test]
    fn a_field_under_both_of_its_names_is_one_field() {
        let ron = "(nodes: [], lights: [point(position: (0, 3, 0), color: 1, intensity: 2)])";
        let json = r#"{"nodes": [], "materials": {"m": {"diffuse": {"albedo": 1, "color": 2}}}}"#;
        let ron = parse_ron(ron, Path::new("s.ron")).expect_err("twice").to_string();
        let json = parse_json(json, Path::new("s.json")).expect_err("twice").to_string();
        // Other materials have `color` in place of `diffuse`, but this one has both.
        let phong = "(nodes: [], materials: {\"m\": phong(color: 1, diffuse: 0.5, diffuse: 0.6)})";
        let phong = parse_ron(phong, Path::new("s.ron")).expect_err("twice").to_string();
        assert!(phong.contains("the field `diffuse` is given twice"), "{phong}");
        assert!(ron.starts_with("s.ron:1:49: `color` and `intensity` are the same field: remove `color`"), "{ron}");
        assert!(json.starts_with("s.json:1:60: `color` and `albedo` are the same field: remove `color`"), "{json}");
        let twice = parse_ron("(nodes: [(shape: sphere(radius: 1, radius: 2))])", Path::new("s.ron"));
        let twice = twice.expect_err("twice").to_string();
        assert!(twice.contains("the field `radius` is given twice"), "{twice}");
    }

    #[test]
    fn deprecated_choices_are_read_with_a_warning_each() {
        for (field, old, new, column) in [
            ("integrator", "caustics", "path_caustics", 36),
            ("integrator", "ao", "ambient_occlusion", 36),
            ("sampler", "center", "centre", 33),
            ("accel", "wide", "bvh8", 31),
            ("accel", "spheres", "sphere_tree", 31),
            ("accel", "cylinders", "cylinder_tree", 31),
        ] {
            let ron = |choice: &str| format!("(nodes: [], settings: ({field}: {choice}))");
            let parsed = |text: &str| parse_ron(text, Path::new("s.ron")).expect("a scene");
            let (read, present) = (parsed(&ron(old)), parsed(&ron(new)));
            let messages: Vec<String> = read.warnings.iter().map(ToString::to_string).collect();
            let place = format!("s.ron:1:{column}");
            assert_eq!(messages, [format!("{place}: the spelling `{old}` is deprecated: write `{new}`")]);
            assert!(present.warnings.is_empty());
            assert_eq!(SceneFile { warnings: Vec::new(), ..read }, present);
            let json = format!(r#"{{"nodes": [], "settings": {{"{field}" : "{old}"}}}}"#);
            assert_eq!(parse_json(&json, Path::new("s.json")).expect("a scene").warnings.len(), 1);
        }
    }

    #[test]
    fn parts_of_words_are_no_words() {
        use super::has_word;
        for text in ["(depth: 3)", "{\"depth\" : 3}", "integrator:depth,", "depth/* c */: 3", "constant(depth (3))"] {
            assert!(has_word(text, "depth"), "{text}");
        }
        for text in ["max_depth: 3", "depths: 3", "(\"depth\", 3)", "depth of field, (fov: 3)", ""] {
            assert!(!has_word(text, "depth"), "{text}");
        }
    }

    #[test]
    fn json_and_ron_warn_alike() {
        let text = r#"{"nodes": [], "settings": {"depth": 3}, "materials": {"shines": {"phong": {"shines": "both"}}}}"#;
        let file = parse_json(text, Path::new("s.json")).expect("a scene");
        let places: Vec<&str> = file.warnings.iter().map(|warning| warning.place.as_str()).collect();
        assert_eq!(places, ["s.json:1:76", "s.json:1:28"]);
        assert!(parse_json(&file.to_json(), Path::new("s.json")).expect("a scene").warnings.is_empty());
    }
}
