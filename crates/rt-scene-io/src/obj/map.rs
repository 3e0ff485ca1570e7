//! Texture statements of MTL files: options, then a file name that may contain spaces.

use rt_shading::UvMap;

/// What follows `map_Kd` and its like.
#[derive(Debug, PartialEq)]
pub(super) struct Map {
    /// As written, with slashes.
    pub(super) file: String,
    /// Whether the image ends at its edge rather than to repeat.
    pub(super) clamp: bool,
    /// What is added to the texture coordinates after they are multiplied by `scale`.
    offset: [f64; 2],
    scale: [f64; 2],
    /// Options that would change the picture and are not followed.
    pub(super) ignored: Vec<String>,
}

/// Options, and whether they are a matter of taste (filtering, channels of scalar maps).
const OPTIONS: [(&str, Arguments, bool); 13] = [
    ("-blendu", Arguments::Exactly(1), true),
    ("-blendv", Arguments::Exactly(1), true),
    ("-boost", Arguments::Exactly(1), true),
    ("-cc", Arguments::Exactly(1), true),
    ("-texres", Arguments::Exactly(1), true),
    ("-bm", Arguments::Exactly(1), true),
    ("-imfchan", Arguments::Exactly(1), true),
    ("-type", Arguments::Exactly(1), true),
    ("-clamp", Arguments::Exactly(1), true),
    ("-mm", Arguments::Exactly(2), false),
    ("-o", Arguments::Numbers, false),
    ("-s", Arguments::Numbers, false),
    ("-t", Arguments::Numbers, false),
];

enum Arguments {
    Exactly(usize),
    /// One to three numbers.
    Numbers,
}

impl Map {
    /// `None` if no file name is left after the options.
    pub(super) fn parse(statement: &str) -> Option<Self> {
        let (mut rest, mut clamp, mut ignored) = (statement.trim(), false, Vec::new());
        let (mut offset, mut scale) = ([0.0; 2], [1.0; 2]);
        while let Some((name, arguments, harmless)) = OPTIONS.iter().find(|(name, ..)| first_word(rest).0 == *name) {
            rest = first_word(rest).1;
            let mut values = Vec::new();
            for _ in 0..3 {
                let (word, after) = first_word(rest);
                let wanted = match arguments {
                    Arguments::Exactly(count) => values.len() < *count && !word.is_empty(),
                    Arguments::Numbers => word.parse::<f32>().is_ok(),
                };
                if !wanted {
                    break;
                }
                values.push(word);
                rest = after;
            }
            clamp |= *name == "-clamp" && values == ["on"];
            let target = match *name {
                "-o" => Some(&mut offset),
                "-s" => Some(&mut scale),
                _ => None,
            };
            // The third number is for textures in space.
            if let Some(target) = target {
                let numbers = values.iter().filter_map(|value| value.parse::<f64>().ok()).filter(|n| n.is_finite());
                target.iter_mut().zip(numbers).for_each(|(part, number)| *part = number);
            } else if !harmless && !is_identity(name, &values) {
                ignored.push(format!("{name} {}", values.join(" ")));
            }
        }
        let file = rest.trim_matches('"').replace('\\', "/");
        (!file.is_empty()).then_some(Self { file, clamp, offset, scale, ignored })
    }

    /// Whether the texture coordinates are not those of the mesh.
    pub(super) fn has_own_coordinates(&self) -> bool {
        self.offset != [0.0; 2] || self.scale != [1.0; 2]
    }

    /// The way from the coordinates of the mesh to those of the texture.
    pub(super) fn coordinates(&self) -> UvMap {
        let ([s, t], [u, v]) = (self.scale, self.offset);
        UvMap { is_second: false, rows: [[s, 0.0, u], [0.0, t, v]] }
    }
}

fn is_identity(option: &str, values: &[&str]) -> bool {
    let expected = |i: usize| match (option, i) {
        ("-mm", 1) => 1.0,
        _ => 0.0,
    };
    values.iter().enumerate().all(|(i, value)| value.parse() == Ok(expected(i)))
}

fn first_word(text: &str) -> (&str, &str) {
    match text.split_once(char::is_whitespace) {
        Some((word, rest)) => (word, rest.trim_start()),
        None => (text, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(statement: &str) -> (String, bool, Vec<String>) {
        let Map { file, clamp, ignored, .. } = Map::parse(statement).expect("a file name");
        (file, clamp, ignored)
    }

    #[test]
    fn options_are_told_from_the_name() {
        assert_eq!(parsed("a.png"), ("a.png".to_owned(), false, vec![]));
        assert_eq!(parsed("  my image.png "), ("my image.png".to_owned(), false, vec![]));
        assert_eq!(parsed("-clamp on -texres 512 -s 1 1 1 -o 0 x y.png"), ("x y.png".to_owned(), true, vec![]));
        assert_eq!(parsed("-t 0.1 a.png"), ("a.png".to_owned(), false, vec!["-t 0.1".to_owned()]));
        assert_eq!(parsed("-mm 0 2 -blendu off a.png").2, ["-mm 0 2"]);
        assert_eq!(parsed(r#""maps\wood 1.png""#).0, "maps/wood 1.png");
        // Not an option that anyone knows: part of the name.
        assert_eq!(parsed("-x.png").0, "-x.png");
    }

    #[test]
    fn offset_and_scale_move_the_coordinates() {
        let map = Map::parse("-s 2 3 1 -o 0.5 a.png").expect("a file name");
        assert!(map.has_own_coordinates() && map.ignored.is_empty());
        assert_eq!(map.coordinates().rows, [[2.0, 0.0, 0.5], [0.0, 3.0, 0.0]]);
        assert!(!Map::parse("-s 1 1 1 -o 0 a.png").expect("a file name").has_own_coordinates());
    }

    #[test]
    fn options_without_a_name() {
        assert_eq!(Map::parse("-s 1 2 3"), None);
        assert_eq!(Map::parse("-clamp"), None);
        assert_eq!(Map::parse(""), None);
    }
}
