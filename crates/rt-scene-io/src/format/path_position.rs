//! Positions of paths such as `nodes[2].material` in the text of a scene.

use super::cursor::{Cursor, Key};

/// Best match of a path so far.
#[derive(Clone, Copy, Debug, Default)]
struct Match {
    /// Keys of the path that the text has, from the first on.
    n_found: usize,
    /// Keys of the text between them: names of choices, which paths may omit.
    n_skipped: usize,
    /// Byte at which the value or its name begins.
    byte: usize,
}

/// For each path, the byte at which it begins in a valid text. If the text lacks its end, as it does for a default value, this is the
/// beginning of the innermost list or struct around it. `None` if the text has no part of the path.
pub(crate) fn positions_of(text: &str, paths: &[&str]) -> Vec<Option<usize>> {
    let paths: Vec<Vec<Key<'_>>> = paths.iter().map(|path| keys(path)).collect();
    let mut best = vec![Match::default(); paths.len()];
    Cursor::walk(text, text.len(), |cursor, _, start| {
        // Texts can be long, and most paths are found early.
        let mut open = paths
            .iter()
            .zip(&mut best)
            .filter(|(path, best)| best.n_found < path.len() || best.n_skipped > 0)
            .peekable();
        if open.peek().is_none() {
            return;
        }
        let here = cursor.path();
        for (path, best) in open {
            let found = Match::of(path, &here, start, cursor);
            if (found.n_found, best.n_skipped) > (best.n_found, found.n_skipped) {
                *best = found;
            }
        }
    });
    best.iter().map(|best| (best.n_found > 0).then_some(best.byte)).collect()
}

impl Match {
    /// Compares a path with that of a field of the text, whose name begins at the byte `start`.
    fn of(path: &[Key<'_>], here: &[Key<'_>], start: usize, cursor: &Cursor<'_>) -> Self {
        let mut found = Self::default();
        let mut n_skipped = 0;
        for (depth, key) in here.iter().enumerate() {
            if path.get(found.n_found) == Some(key) {
                // The first field of an element stands for the element.
                let byte = if depth + 1 == here.len() { start } else { cursor.innermost_element().unwrap_or(start) };
                found = Self { n_found: found.n_found + 1, n_skipped, byte };
            } else if found.n_found > 0 && matches!(key, Key::Name(_)) {
                n_skipped += 1;
            } else {
                break;
            }
        }
        found
    }
}

/// Keys of a path.
fn keys(path: &str) -> Vec<Key<'_>> {
    let mut keys = Vec::new();
    let mut rest = path;
    while !rest.is_empty() {
        let (key, end) = if let Some(quoted) = rest.strip_prefix("[\"") {
            let length = quoted.find("\"]").unwrap_or(quoted.len());
            (Key::Name(&quoted[..length]), length + 4)
        } else if let Some(index) = rest.strip_prefix('[') {
            let length = index.find(']').unwrap_or(index.len());
            (index[..length].parse().map_or(Key::Name(&index[..length]), Key::Index), length + 2)
        } else {
            let length = rest.find(['.', '[']).unwrap_or(rest.len());
            (Key::Name(&rest[..length]), length)
        };
        keys.push(key);
        rest = rest.get(end..).unwrap_or_default();
        rest = rest.strip_prefix('.').unwrap_or(rest);
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Text from the position of a path on, up to the end of its line.
    fn at<'t>(text: &'t str, path: &str) -> Option<&'t str> {
        positions_of(text, &[path])[0].and_then(|byte| text[byte..].lines().next())
    }

    const RON: &str = r#"// nodes: [(), (material: "comment")]
(
    camera: (look_from: (0, 0, 5)),
    materials: {
        "a.b [0]": phong(diffuse: (1, 0, 0)),
    },
    groups: {"g": [(children: [(material: "deep")])]},
    nodes: [
        (shape: sphere(radius: 1), material: "a.b [0]"),
        // The material of the child comes first.
        (children: [(material: "child")], material: "own"),
        (
            shape: box(),
        ),
    ],
)"#;

    #[test]
    fn paths_begin_at_the_name_of_their_field() {
        for (path, expected) in [
            ("camera", "camera: (look_from: (0, 0, 5)),"),
            ("camera.look_from", "look_from: (0, 0, 5)),"),
            ("materials[\"a.b [0]\"].diffuse", "diffuse: (1, 0, 0)),"),
            ("materials[\"a.b [0]\"]", "\"a.b [0]\": phong(diffuse: (1, 0, 0)),"),
            ("groups[\"g\"][0].children[0].material", "material: \"deep\")])]},"),
            ("nodes[0].shape", "shape: sphere(radius: 1), material: \"a.b [0]\"),"),
            ("nodes[0].shape.radius", "radius: 1), material: \"a.b [0]\"),"),
            ("nodes[1].material", "material: \"own\"),"),
            ("nodes[1].children[0].material", "material: \"child\")], material: \"own\"),"),
        ] {
            assert_eq!(at(RON, path), Some(expected), "{path}");
        }
    }

    #[test]
    fn elements_and_missing_fields_begin_at_their_list_or_struct() {
        assert_eq!(at(RON, "camera.fov"), Some("camera: (look_from: (0, 0, 5)),"));
        assert_eq!(at(RON, "nodes[1]"), Some("(children: [(material: \"child\")], material: \"own\"),"));
        assert_eq!(at(RON, "nodes[2].material"), Some("("));
        assert_eq!(at(RON, "nodes[7].material"), Some("nodes: ["));
        for path in ["film.size", "", "[0]", "material", "[\"", "[", "..", "nodes["] {
            let found = at(RON, path);
            assert!(found.is_none() || path == "nodes[", "{path}: {found:?}");
        }
    }

    /// The position was that of the list.
    #[test]
    fn elements_that_are_choices_begin_at_their_names() {
        assert_eq!(at("(lights: [ambient(1), ambient(-1)])", "lights[1]"), Some("ambient(-1)])"));
        assert_eq!(at("(transform: [translate(1, 0, 0), scale(0)])", "transform[1]"), Some("scale(0)])"));
    }

    #[test]
    fn json_has_the_same_paths() {
        let json = r#"{"nodes": [{"shape": {"sphere": {"radius": 1}}}, {"material": "m"}]}"#;
        assert_eq!(at(json, "nodes[0].shape.radius"), Some(r#""radius": 1}}}, {"material": "m"}]}"#));
        assert_eq!(at(json, "nodes[1].material"), Some(r#""material": "m"}]}"#));
        assert_eq!(at(json, "nodes[1]"), Some(r#"{"material": "m"}]}"#));
    }

    #[test]
    fn all_paths_are_found_in_one_pass() {
        let found = positions_of(RON, &["nodes", "camera", "lights"]);
        assert_eq!(found, [RON.find("nodes: [\n"), RON.find("camera"), None]);
    }
}
