//! Texture statements of MTL files: options, then a file name that may contain spaces.

use rt_shading::{Channel, UvMap};

/// Arguments of `map_Kd` and similar statements.
#[derive(Debug, PartialEq)]
pub(super) struct TextureMap {
    /// Path as written, with slashes.
    pub(super) file: String,
    /// True if the edge pixels are repeated instead of the image.
    pub(super) clamp: bool,
    /// Added to the texture coordinates after their multiplication by `scale`.
    offset: [f64; 2],
    pub(super) scale: [f64; 2],
    /// Factor of the slopes of a bump map.
    pub(super) bump: f64,
    /// Channel of the image, if specified.
    pub(super) channel: Option<Channel>,
    /// Options that would change the image and are not supported.
    pub(super) ignored: Vec<String>,
}

/// Options, and whether they are a matter of taste (filtering, channels of scalar maps).
const OPTIONS: [(&str, Arguments, bool); 14] = [
    ("-blendu", Arguments::Exactly(1), true),
    ("-blendv", Arguments::Exactly(1), true),
    ("-boost", Arguments::Exactly(1), true),
    ("-cc", Arguments::Exactly(1), true),
    ("-colorspace", Arguments::Exactly(1), true),
    ("-texres", Arguments::Exactly(1), true),
    ("-bm", Arguments::Exactly(1), true),
    ("-imfchan", Arguments::Exactly(1), true),
    ("-type", Arguments::Exactly(1), true),
    ("-clamp", Arguments::Switch, true),
    ("-mm", Arguments::Exactly(2), false),
    ("-o", Arguments::Numbers, false),
    ("-s", Arguments::Numbers, false),
    ("-t", Arguments::Numbers, false),
];

enum Arguments {
    Exactly(usize),
    Switch,
    Numbers,
}

impl TextureMap {
    /// `None` without a file name. Some programs write options after the name.
    pub(super) fn parse(statement: &str) -> Option<Self> {
        let (offset, scale, ignored) = ([0.0; 2], [1.0; 2], Vec::new());
        let mut map = Self { file: String::new(), clamp: false, offset, scale, bump: 1.0, channel: None, ignored };
        let mut rest = statement.trim();
        while let Some(after) = map.option(rest) {
            rest = after;
        }
        let (file, mut rest) = rest.split_at(end_of_name(rest));
        while let Some(after) = map.option(rest.trim_start()) {
            rest = after;
        }
        map.file = file.trim_end().trim_matches('"').replace('\\', "/");
        (!map.file.is_empty()).then_some(map)
    }

    /// Parses the option at the beginning of the text, and returns the rest; `None` without an option.
    fn option<'t>(&mut self, text: &'t str) -> Option<&'t str> {
        let (word, mut rest) = first_word(text);
        let (name, arguments, harmless) = OPTIONS.iter().find(|(name, ..)| word == *name)?;
        let mut values = Vec::new();
        for _ in 0..3 {
            let (word, after) = first_word(rest);
            let wanted = match arguments {
                Arguments::Exactly(count) => values.len() < *count && !word.is_empty(),
                Arguments::Switch => values.is_empty() && matches!(word, "on" | "off"),
                Arguments::Numbers => word.parse::<f32>().is_ok(),
            };
            if !wanted {
                break;
            }
            values.push(word);
            rest = after;
        }
        // The third number is for textures in space.
        let numbers = || values.iter().filter_map(|value| value.parse::<f64>().ok()).filter(|n| n.is_finite());
        match *name {
            "-o" => self.offset.iter_mut().zip(numbers()).for_each(|(part, number)| *part = number),
            "-s" => self.scale.iter_mut().zip(numbers()).for_each(|(part, number)| *part = number),
            "-bm" => self.bump = numbers().next().unwrap_or(1.0),
            "-clamp" => self.clamp |= values == ["on"],
            "-imfchan" => self.channel = values.first().and_then(|name| channel_of(name)),
            _ if !harmless && !is_identity(name, &values) => self.ignored.push(format!("{name} {}", values.join(" "))),
            _ => {}
        }
        Some(rest)
    }

    /// True if the texture coordinates differ from those of the mesh.
    pub(super) fn has_own_coordinates(&self) -> bool {
        self.offset != [0.0; 2] || self.scale != [1.0; 2]
    }

    /// Map from the coordinates of the mesh to those of the texture.
    pub(super) fn coordinates(&self) -> UvMap {
        let ([s, t], [u, v]) = (self.scale, self.offset);
        UvMap { is_second: false, rows: [[s, 0.0, u], [0.0, t, v]] }
    }
}

/// Luminance (`l`) and depth (`z`) read any channel of a grey image.
fn channel_of(name: &str) -> Option<Channel> {
    match name {
        "r" => Some(Channel::Red),
        "g" => Some(Channel::Green),
        "b" => Some(Channel::Blue),
        "m" => Some(Channel::Alpha),
        _ => None,
    }
}

fn is_identity(option: &str, values: &[&str]) -> bool {
    let expected = |i: usize| match (option, i) {
        ("-mm", 1) => 1.0,
        _ => 0.0,
    };
    values.iter().enumerate().all(|(i, value)| value.parse() == Ok(expected(i)))
}

/// End of a file name: an option after a word with a dot, or the end of the text.
fn end_of_name(text: &str) -> usize {
    let is_option = |word: &str| OPTIONS.iter().any(|(name, ..)| *name == word);
    let mut places = text.match_indices(' ').map(|(place, _)| place);
    places
        .find(|&place| text[..place].contains('.') && is_option(first_word(&text[place + 1..]).0))
        .unwrap_or(text.len())
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
        let TextureMap { file, clamp, ignored, .. } = TextureMap::parse(statement).expect("a file name");
        (file, clamp, ignored)
    }

    #[test]
    fn options_are_separated_from_the_name() {
        assert_eq!(parsed("a.png"), ("a.png".to_owned(), false, vec![]));
        assert_eq!(parsed("  my image.png "), ("my image.png".to_owned(), false, vec![]));
        assert_eq!(parsed("-clamp on -texres 512 -s 1 1 1 -o 0 x y.png"), ("x y.png".to_owned(), true, vec![]));
        assert_eq!(parsed("-t 0.1 a.png"), ("a.png".to_owned(), false, vec!["-t 0.1".to_owned()]));
        assert_eq!(parsed("-mm 0 2 -blendu off a.png").2, ["-mm 0 2"]);
        assert_eq!(parsed(r#""maps\wood 1.png""#).0, "maps/wood 1.png");
        assert_eq!(parsed("-clamp a.png"), ("a.png".to_owned(), false, vec![]), "a name was taken for a value");
        // An unknown option is part of the name.
        assert_eq!(parsed("-x.png").0, "-x.png");
    }

    #[test]
    fn options_may_follow_the_name() {
        let map = TextureMap::parse("-imfchan r bump map.jpg -bm 1.5 -clamp on").expect("a file name");
        assert_eq!(
            (map.file.as_str(), map.bump, map.channel, map.clamp),
            ("bump map.jpg", 1.5, Some(Channel::Red), true)
        );
        assert_eq!(parsed("-colorspace linear -bm 3 bumpmap.jpg").0, "bumpmap.jpg");
        assert_eq!(parsed("left -s right.png").0, "left -s right.png", "no file is named before it");
    }

    #[test]
    fn offset_and_scale_move_the_coordinates() {
        let map = TextureMap::parse("-s 2 3 1 -o 0.5 a.png").expect("a file name");
        assert!(map.has_own_coordinates() && map.ignored.is_empty());
        assert_eq!(map.coordinates().rows, [[2.0, 0.0, 0.5], [0.0, 3.0, 0.0]]);
        assert!(!TextureMap::parse("-s 1 1 1 -o 0 a.png").expect("a file name").has_own_coordinates());
    }

    #[test]
    fn the_height_of_bumps_and_the_channel_are_read() {
        let map = TextureMap::parse("-bm 0.3 -imfchan g bump.png").expect("a file name");
        assert_eq!((map.bump, map.channel), (0.3, Some(Channel::Green)));
        let map = TextureMap::parse("-bm nan -imfchan l bump.png").expect("a file name");
        assert_eq!((map.bump, map.channel), (1.0, None));
    }

    #[test]
    fn options_without_a_name() {
        assert_eq!(TextureMap::parse("-s 1 2 3"), None);
        assert_eq!(TextureMap::parse("-clamp"), None);
        assert_eq!(TextureMap::parse(""), None);
    }
}
