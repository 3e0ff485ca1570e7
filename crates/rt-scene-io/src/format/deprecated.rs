//! Earlier spellings of fields, which are still read, each with a warning that names the present one.

use super::cursor::{Cursor, Key};
use crate::Warning;
use crate::excerpt::Position;

/// An earlier spelling of a field.
struct Deprecated {
    /// Fields or choices that have the field.
    parents: &'static [&'static str],
    old: &'static str,
    new: &'static str,
}

const DEPRECATED: [Deprecated; 5] = [
    Deprecated { parents: &["quad", "disk", "light", "phong"], old: "shines", new: "emission_sides" },
    Deprecated { parents: &["point"], old: "lamp_radius", new: "shadow_near" },
    Deprecated { parents: &["settings"], old: "depth", new: "max_depth" },
    Deprecated { parents: &["settings"], old: "roulette_from", new: "rr_start_depth" },
    Deprecated { parents: &["object_space"], old: "least", new: "min_spp" },
];

/// Present spelling of a deprecated one; `None` for all other words.
pub(super) fn present_spelling(old: &str) -> Option<&'static str> {
    DEPRECATED.iter().find(|spelling| spelling.old == old).map(|spelling| spelling.new)
}

/// One warning per deprecated spelling in the sound text of a scene. `file` is named in them.
pub(super) fn warnings(text: &str, file: &str) -> Vec<Warning> {
    let mut found: [Option<(usize, usize)>; DEPRECATED.len()] = [None; DEPRECATED.len()];
    if !DEPRECATED.iter().any(|spelling| text.contains(spelling.old)) {
        return Vec::new();
    }
    Cursor::walk(text, text.len(), |cursor, name, at| {
        for (spelling, found) in DEPRECATED.iter().zip(&mut found).filter(|(spelling, _)| spelling.old == name) {
            if matches!(cursor.container().last(), Some(Key::Name(parent)) if spelling.parents.contains(parent)) {
                let (_, count) = found.get_or_insert((at, 0));
                *count += 1;
            }
        }
    });
    let warning = |(spelling, found): (&Deprecated, Option<(usize, usize)>)| {
        let (at, count) = found?;
        let Position { line, column } = Position::of(text, at);
        let times = if count > 1 { format!(" ({count} times, this is the first)") } else { String::new() };
        let message = format!("the spelling `{}` is deprecated: write `{}`{times}", spelling.old, spelling.new);
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

    #[test]
    fn json_and_ron_warn_alike() {
        let text = r#"{"nodes": [], "settings": {"depth": 3}, "materials": {"shines": {"phong": {"shines": "both"}}}}"#;
        let file = parse_json(text, Path::new("s.json")).expect("a scene");
        let places: Vec<&str> = file.warnings.iter().map(|warning| warning.place.as_str()).collect();
        assert_eq!(places, ["s.json:1:76", "s.json:1:28"]);
        assert!(parse_json(&file.to_json(), Path::new("s.json")).expect("a scene").warnings.is_empty());
    }
}
