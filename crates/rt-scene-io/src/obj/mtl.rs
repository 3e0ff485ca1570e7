//! MTL files, cleaned up for `tobj`.
//!
//! `tobj` panics on colours with fewer than three numbers and gives up on the first bad statement without telling
//! where it is. Materials matter less than geometry, so a bad statement is left out here, with a warning, and the
//! rest of the file counts.

use super::texture_map::TextureMap;
use crate::text::lines::{Line, lines};

/// Maps that have no effect here.
pub(super) const UNUSED: [&str; 6] = ["map_Pcr", "map_aniso", "map_anisor", "disp", "decal", "refl"];

/// A statement that was left out: its line, and why.
pub(super) type LineWarning = (usize, String);

/// A statement that the format does not have, or that has no meaning here.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct UnknownStatement {
    /// Line of the first.
    pub(super) line: usize,
    pub(super) keyword: String,
    /// Number of occurrences.
    pub(super) count: usize,
}

#[derive(Debug, Default)]
pub(super) struct MtlFile {
    /// All numbers are finite and not negative. Tf, Tr, map_Ke and the physical parameters (Pr, Pm, ...) are among the unknown
    /// parameters.
    pub(super) materials: Vec<tobj::Material>,
    /// Invalid statements that were skipped.
    pub(super) warnings: Vec<LineWarning>,
    /// Unknown statements that were skipped: each keyword once.
    pub(super) unknown: Vec<UnknownStatement>,
}

/// Maximum number of unknown keywords in warnings.
const MAX_UNKNOWN: usize = 100;

/// Keywords, in the case that `tobj` requires; the case in files varies.
const KEYWORDS: [&str; 33] = [
    "newmtl", "Ka", "Kd", "Ks", "Ke", "Tf", "Ns", "Ni", "d", "Tr", "illum", "Pr", "Pm", "Ps", "Pc", "Pcr", "aniso",
    "anisor", "map_Ka", "map_Kd", "map_Ks", "map_Ke", "map_Ns", "map_d", "map_Bump", "bump", "map_Pr", "map_Pm",
    "map_Ps", "map_Pc", "norm", "disp", "decal",
];

/// The materials of a file, and its ignored statements.
pub(super) fn parse(text: &str) -> MtlFile {
    let mut clean = String::new();
    let mut warnings = Vec::new();
    let mut unknown: Vec<UnknownStatement> = Vec::new();
    let mut has_no_material = false;
    for line in lines(text) {
        let statement = statement(&line);
        if line.split().0.eq_ignore_ascii_case("newmtl") {
            has_no_material = statement.is_err();
        } else if has_no_material {
            continue;
        }
        let word = line.split().0;
        if !is_known(word) {
            if let Some(known) = unknown.iter_mut().find(|unknown| unknown.keyword == word) {
                known.count += 1;
            } else if unknown.len() < MAX_UNKNOWN {
                unknown.push(UnknownStatement { line: line.number, keyword: word.to_owned(), count: 1 });
            }
            continue;
        }
        match statement {
            Ok(statement) => {
                if is_above_one(&statement) {
                    warnings.push((line.number, format!("`{statement}` is clamped to 1")));
                }
                clean.push_str(&statement);
                clean.push('\n');
            }
            Err(reason) => warnings.push((line.number, reason)),
        }
    }
    let read = tobj::load_mtl_buf(&mut clean.as_bytes());
    let (materials, _) = read.unwrap_or_else(|error| {
        warnings.push((1, format!("no material can be read: {error}")));
        Default::default()
    });
    MtlFile { materials, warnings, unknown }
}

/// True for a fraction above 1.
fn is_above_one(statement: &str) -> bool {
    let mut words = statement.split(' ');
    let is_fraction = words.next().is_some_and(|keyword| matches!(keyword, "Kd" | "d" | "Tr" | "Pr" | "Pm"));
    is_fraction && words.any(|word| word.parse::<f32>().is_ok_and(|number| number > 1.0))
}

/// The statement in the form that `tobj` reads.
fn statement(line: &Line<'_>) -> Result<String, String> {
    let (word, rest) = line.split();
    let keyword = KEYWORDS.into_iter().find(|k| k.eq_ignore_ascii_case(word)).unwrap_or(word);
    match keyword {
        "Ka" | "Kd" | "Ks" | "Ke" | "Tf" => {
            let numbers = line.arguments().map(number).collect::<Result<Vec<f32>, _>>()?;
            match numbers[..] {
                [gray] => Ok(format!("{keyword} {gray} {gray} {gray}")),
                [r, g, b, ..] => Ok(format!("{keyword} {r} {g} {b}")),
                _ => Err(format!("`{keyword}` needs one or three numbers, but has {}", numbers.len())),
            }
        }
        // `d -halo 0.5` is a dissolve that grows towards the silhouette; its value is the last word.
        "Ns" | "Ni" | "d" | "Tr" | "Pr" | "Pm" | "Ps" | "Pc" | "Pcr" | "aniso" | "anisor" => {
            let word = line.arguments().last().ok_or_else(|| format!("`{keyword}` needs a number"))?;
            Ok(format!("{keyword} {}", number(word)?))
        }
        "illum" => {
            let word = line.arguments().next().unwrap_or_default();
            match word.parse::<u8>() {
                Ok(model @ 0..=10) => Ok(format!("illum {model}")),
                _ => Err(format!("`{word}` is not an illumination model; give a number from 0 to 10")),
            }
        }
        "newmtl" if rest.is_empty() => Err("`newmtl` needs a name, and so do the statements that follow it".to_owned()),
        _ if rest.is_empty() => Err(format!("`{word}` needs a name")),
        _ if is_map(keyword) && TextureMap::parse(rest).is_none() => {
            Err(format!("`{word} {rest}` has no file name of an image"))
        }
        _ => Ok(format!("{keyword} {rest}")),
    }
}

/// True for keywords that mean something, here or in other programs that read the format.
fn is_known(word: &str) -> bool {
    KEYWORDS.iter().chain(&UNUSED).any(|known| known.eq_ignore_ascii_case(word))
}

/// True for statements that name an image.
fn is_map(keyword: &str) -> bool {
    keyword.starts_with("map_") || matches!(keyword, "bump" | "norm" | "disp" | "decal")
}

fn number(word: &str) -> Result<f32, String> {
    match word.parse::<f32>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        Ok(number) => Err(format!("{number} is not a finite number of at least 0")),
        Err(_) => Err(format!("`{word}` is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_statements_reach_the_material() {
        let text = "newmtl a b\nKd .5 0.25 1e-1 # red\nks 0.5\nNS 12\nd -halo 0.25\nillum 7\nmap_kd -s 1 1 1 a b.png\n\
                    Tf 1 1 1\nnewmtl c\nmap_Ke e.png\nPr 0.5";
        let MtlFile { materials, warnings, .. } = parse(text);
        assert_eq!(warnings, []);
        let [a, c] = &materials[..] else { panic!("two materials") };
        assert_eq!((a.name.as_str(), c.name.as_str()), ("a b", "c"));
        assert_eq!((a.diffuse, a.specular), (Some([0.5, 0.25, 0.1]), Some([0.5; 3])));
        assert_eq!((a.shininess, a.dissolve, a.illumination_model), (Some(12.0), Some(0.25), Some(7)));
        assert_eq!(a.diffuse_texture.as_deref(), Some("-s 1 1 1 a b.png"));
        assert_eq!(a.unknown_param["Tf"], "1 1 1");
        assert_eq!(c.unknown_param["map_Ke"], "e.png");
    }

    #[test]
    fn a_material_without_a_name_changed_the_one_before_it() {
        let MtlFile { materials, warnings, .. } = parse("newmtl a\nKd 0 1 0\nnewmtl\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n");
        let colours: Vec<_> = materials.iter().map(|material| material.diffuse).collect();
        assert_eq!(colours, [Some([0.0, 1.0, 0.0]), Some([0.0, 0.0, 1.0])]);
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].0 == 3 && warnings[0].1.contains("needs a name"), "{warnings:?}");
    }

    #[test]
    fn maps_that_name_no_image_were_left_out_without_a_word() {
        let MtlFile { warnings, .. } = parse("newmtl a\nmap_Kd -s 2 2\nbump -bm 1\n");
        let expected = [
            (2, "`map_Kd -s 2 2` has no file name of an image".to_owned()),
            (3, "`bump -bm 1` has no file name of an image".to_owned()),
        ];
        assert_eq!(warnings, expected);
    }

    #[test]
    fn fractions_above_1_were_clamped_without_a_word() {
        let MtlFile { warnings, .. } = parse("newmtl a\nKd 1 2 0.5\nKe 9\nPr 1\nPm 3\nd 1.5\nNi 1.5\n");
        let said = |line, statement: &str| (line, format!("`{statement}` is clamped to 1"));
        assert_eq!(warnings, [said(2, "Kd 1 2 0.5"), said(5, "Pm 3"), said(6, "d 1.5")]);
    }

    #[test]
    fn bad_statements_are_left_out_with_their_line() {
        let text = "newmtl a\nKd 1 2\nKs x 1 1\nKa\nNs -1\nNi nan\nillum 11\nmap_Kd\nKe 1 1 1e99\nKd 1 1 1\nnewmtl\n";
        let MtlFile { materials, warnings, .. } = parse(text);
        assert_eq!(materials.len(), 1);
        assert_eq!((materials[0].diffuse, materials[0].specular), (Some([1.0; 3]), None));
        let lines: Vec<usize> = warnings.iter().map(|(line, _)| *line).collect();
        assert_eq!(lines, [2, 3, 4, 5, 6, 7, 8, 9, 11]);
        assert_eq!(warnings[0].1, "`Kd` needs one or three numbers, but has 2");
        assert_eq!(warnings[3].1, "-1 is not a finite number of at least 0");
    }
}
