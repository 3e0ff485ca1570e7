//! Identity of an image: a hash of all inputs that it depends on.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use rt_scene_io::{InputHashes, LoadErrorKind};
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

use crate::args::{ImageArgs, InputArgs};
use crate::error::CliError;
use crate::stdin::{self, is_dash};

/// Size of the blocks that are read and hashed, in bytes.
const BLOCK: usize = 1 << 20;

/// Hash of the program version, of all input files, and of the options that change the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Identity([u8; 16]);

impl Identity {
    /// Identity of an image with these options and input files, some with `known` hashes. Files are named relative to the scene, so
    /// that each machine may have its own directory.
    pub(crate) fn new(
        input: &InputArgs,
        image: &ImageArgs,
        files: &[PathBuf],
        known: &InputHashes,
    ) -> Result<Self, CliError> {
        let folder = input.scene.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
        let folder = folder.canonicalize().unwrap_or_default();
        let named = files.iter().map(|file| Ok((name_in(&folder, file), hash_of(file, known)?)));
        let mut named = named.collect::<Result<Vec<_>, CliError>>()?;
        named.sort_unstable();
        named.dedup();
        let mut hasher = Xxh3::new();
        let mut add = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        add(env!("CARGO_PKG_VERSION").as_bytes());
        add(choices(input, image).as_bytes());
        // The environment image may also be a texture of the scene.
        add(input.piped.as_ref().map_or(&[][..], |piped| &piped.bytes));
        add(&image.env.as_deref().map_or(Ok(Vec::new()), |file| hash_of(file, known).map(Vec::from))?);
        for (name, hash) in &named {
            add(name.as_bytes());
            add(hash);
        }
        Ok(Self(hasher.digest128().to_le_bytes()))
    }

    /// Identity with further options.
    pub(crate) fn with(&self, options: &str) -> Self {
        let mut hasher = Xxh3::new();
        hasher.update(&self.0);
        hasher.update(options.as_bytes());
        Self(hasher.digest128().to_le_bytes())
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

fn name_in(folder: &Path, file: &Path) -> String {
    let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    file.strip_prefix(folder).unwrap_or(&file).to_string_lossy().into_owned()
}

/// Hash of the content of a file that has been read.
pub(crate) fn hash_bytes(bytes: &[u8]) -> [u8; 16] {
    xxh3_128(bytes).to_le_bytes()
}

/// Hash of a file: the known one, or else that of its present content.
pub(crate) fn hash_of(file: &Path, known: &InputHashes) -> Result<[u8; 16], CliError> {
    if let Some(hash) = known.get(file) {
        return Ok(hash);
    }
    let failed = |error: std::io::Error| CliError::from(LoadErrorKind::Io(error).at(file, ""));
    if is_dash(file) {
        return Ok(hash_bytes(&stdin::content(None, None)?));
    }
    let mut hasher = Xxh3::new();
    let mut reader = File::open(file).map_err(failed)?;
    let mut block = Vec::new();
    while reader.by_ref().take(BLOCK as u64).read_to_end(&mut block).map_err(failed)? > 0 {
        hasher.update(&block);
        block.clear();
    }
    Ok(hasher.digest128().to_le_bytes())
}

/// Text of all options that change the image. The patterns are exhaustive, so that a new option cannot be forgotten.
fn choices(input: &InputArgs, image: &ImageArgs) -> String {
    let InputArgs {
        scene: _,
        input_format: _,
        piped: _,
        asset_root: _,
        ground,
        lights,
        at_time,
        timing,
        animation,
        variant,
        memory: _,
        max_file_size: _,
    } = input;
    let ImageArgs {
        size,
        spp,
        passes,
        adaptive,
        min_spp,
        max_depth,
        seed,
        clamp,
        integrator,
        sampler,
        light_sampling,
        accel: _,
        simd: _,
        precision,
        build_quality: _,
        full_plan: _,
        view,
        crop,
        background,
        env: _,
    } = image;
    let of_input = (ground, lights, at_time, timing, animation, variant);
    let how_much = (size, spp, passes, adaptive, min_spp, max_depth, seed, clamp);
    format!("{of_input:?} {how_much:?} {:?}", (integrator, sampler, light_sampling, precision, view, crop, background))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command};

    fn identity(folder: &Path, options: &str) -> Identity {
        let scene = folder.join("scene.ron");
        let words = ["rt-cli", "render"].into_iter().chain(options.split_whitespace());
        let scene_word = scene.to_str().expect("text");
        let Some(Command::Render(args)) = Cli::parse_from(words.chain([scene_word])).command else {
            panic!("a render")
        };
        let files = [scene, folder.join("model.obj")];
        Identity::new(&args.input, &args.image, &files, &InputHashes::default()).expect("readable")
    }

    #[test]
    fn identities_depend_on_content_and_options_and_not_on_paths_and_speed() {
        let [one, other] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        for folder in [&one, &other] {
            fs::write(folder.path().join("scene.ron"), "a scene").expect("written");
            fs::write(folder.path().join("model.obj"), vec![7; BLOCK + 1]).expect("written");
        }
        let plain = identity(one.path(), "");
        assert_eq!(plain, identity(other.path(), "--accel bvh --build-quality high -o other.png --threads 3"));
        let env = format!("--env {}", one.path().join("model.obj").display());
        let options = [
            env.as_str(),
            "--size 8x8",
            "--seed 1",
            "--spp 2",
            "--precision f64",
            "--look-from 1,2,3",
            "--depth 3",
            "--clamp 3",
            "--lights none",
            "--background white",
            "--integrator path",
            "--crop 0,0,4,4",
            "--ground",
            "--at-time 1",
            "--fps 25",
        ];
        for option in options {
            assert_ne!(plain, identity(one.path(), option), "{option}");
        }
        fs::write(other.path().join("model.obj"), vec![8; BLOCK + 1]).expect("written");
        assert_ne!(plain, identity(other.path(), ""));
    }
}
