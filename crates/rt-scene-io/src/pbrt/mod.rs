//! Scenes of pbrt-v4 (Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th edition, 2023, and the description of its file
//! format).
//!
//! ```text
//! text ── tokens ── directives ──> options: Camera, Film               ──> camera, image size
//!            └ Include                      graphics state: CTM, material, light
//!                                           Shape, ObjectInstance      ──> nodes below one mirror
//!                                           LightSource                ──> lights, sky
//! ```
//!
//! The world of the format is left-handed: it is mirrored below one node, unless its camera is a mirror too. Instances of
//! objects share their meshes. Media, motion, curves and partial shapes are skipped or approximated with a warning. Unused
//! parameters are reported. The colour 1 of a light is white. A file that uses names before their definition is read again with
//! all definitions.

mod file_scope;
mod light;
mod material;
mod parameters;
mod reader;
mod shape;
mod spectrum;
mod state;
mod texture;
mod view;
mod world;

use std::path::Path;

use self::file_scope::FileScope;
use self::reader::PbrtReader;
use crate::error::ErrorAt;
use crate::files::decode_text;
use crate::memory::{FileSample, load_within_budget};
use crate::{LoadError, LoadOptions, Model};

/// Bytes of memory that loading takes at its peak: the text, its parameters as numbers, and a node for each shape.
fn peak_bytes(sample: &FileSample) -> u64 {
    let [shapes, materials] = sample.over_lines(|line| {
        let words = || line.split(u8::is_ascii_whitespace);
        let count = |keywords: &[&[u8]]| words().filter(|word| keywords.contains(word)).count() as u64;
        [count(&[b"Shape"]), count(&[b"Material", b"MakeNamedMaterial"])]
    });
    sample.size * 3 + 900 * shapes + 500 * materials
}

pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    load_within_budget(path, options, peak_bytes, |bytes| load_text(&decode_text(bytes).at(path, "")?, path, options))
}

/// Loads the scene in `text`; references are relative to `path`.
fn load_text(text: &str, path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let mut reader = PbrtReader::new(FileScope { root_file: path, options });
    reader.read(text);
    // Textures may follow the materials that use them, and materials the shapes.
    for _ in 0..2 {
        if reader.has_forward_references() {
            reader = reader.with_definitions();
            reader.read(text);
        }
    }
    reader.finish()
}

#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod texture_tests;
