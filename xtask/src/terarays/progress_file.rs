//! Progress file: a run continues where an earlier run stopped or was killed.

use std::{
    fs,
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
};

use rt_math::random::hash;
use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use super::{lecture_numbers::Tile, tile_job::TileResult};
use crate::error::TaskError;

/// Changes with the meaning of the file.
const FORMAT: u32 = 1;

/// Conditions of the measurements. Only measurements under equal conditions make one sample.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RunConditions {
    format: u32,
    /// A hash of the renderer.
    program: String,
    /// A hash of the scene file.
    scene: String,
    pub processor: String,
}

/// The measured tiles, in the order of [`Tile::nth`] without a gap.
#[derive(Debug)]
pub(super) struct ProgressFile {
    path: PathBuf,
    state: State,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct State {
    conditions: RunConditions,
    units: Vec<TileResult>,
}

impl RunConditions {
    /// Conditions of this renderer and this scene on this machine.
    pub(super) fn here(program: &Path, scene: &Path) -> Result<Self, TaskError> {
        let fingerprint = |path: &Path| {
            let bytes = fs::read(path).map_err(TaskError::file(path))?;
            let word = |chunk: &[u8]| chunk.iter().fold(0, |word, &byte| word << 8 | u64::from(byte));
            let words: Vec<u64> = [bytes.len() as u64].into_iter().chain(bytes.chunks(8).map(word)).collect();
            Ok(format!("{:016x}", hash(&words)))
        };
        Ok(Self {
            format: FORMAT,
            program: fingerprint(program)?,
            scene: fingerprint(scene)?,
            processor: crate::processor::processor(),
        })
    }
}

impl ProgressFile {
    /// Reads the file, if there is one. A damaged file, or one of other conditions, is an error that names it.
    pub(super) fn open(path: PathBuf, conditions: RunConditions) -> Result<Self, TaskError> {
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return Ok(Self { path, state: State { conditions, units: Vec::new() } });
            }
            Err(error) => return Err(TaskError::file(&path)(error)),
        };
        let refused = |why: &str| {
            Err(TaskError::Other(format!("{}: {why}; rename it, or start over with --fresh", path.display())))
        };
        let state: State = match serde_json::from_str(&text) {
            Ok(state) => state,
            Err(error) => return refused(&format!("this is no state to go on from: {error}")),
        };
        if state.conditions != conditions {
            return refused("this was measured with another renderer or scene, or on another machine");
        }
        let is_sound = |(index, unit): (usize, &TileResult)| Tile::nth(index) == Some(unit.tile) && unit.is_sound();
        match state.units.iter().enumerate().position(|unit| !is_sound(unit)) {
            Some(index) => refused(&format!("tile {index} cannot have been measured")),
            None => Ok(Self { path, state }),
        }
    }

    /// All that was measured.
    pub(super) fn units(&self) -> &[TileResult] {
        &self.state.units
    }

    /// The tile to measure next; `None` if the image is whole.
    pub(super) fn next(&self) -> Option<Tile> {
        Tile::nth(self.state.units.len())
    }

    /// Adds the measurements of the next tile, and replaces the file atomically.
    pub(super) fn append(&mut self, unit: TileResult) -> Result<(), TaskError> {
        self.state.units.push(unit);
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let mut file = NamedTempFile::new_in(folder).map_err(TaskError::file(folder))?;
        let json =
            serde_json::to_vec(&self.state).map_err(|source| TaskError::Json { path: self.path.clone(), source })?;
        file.write_all(&json).and_then(|()| file.as_file().sync_all()).map_err(TaskError::file(file.path()))?;
        file.persist(&self.path).map_err(|error| TaskError::file(&self.path)(error.error))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tile_job::Measured, *};

    fn conditions() -> RunConditions {
        let [program, scene, processor] = ["p", "s", "m"].map(str::to_owned);
        RunConditions { format: FORMAT, program, scene, processor }
    }

    fn unit(tile: Tile) -> TileResult {
        let measured = Measured { cpu_seconds: 0.1, mse: 1e-9 };
        TileResult { tile, rays_per_sample: 9.0, jittered: measured, best: [measured; 3] }
    }

    /// Writes a progress file with two tiles and returns its path.
    fn two(folder: &Path) -> PathBuf {
        let path = folder.join("state.json");
        let mut progress_file = ProgressFile::open(path.clone(), conditions()).unwrap();
        for index in 0..2 {
            assert_eq!(progress_file.next(), Tile::nth(index));
            progress_file.append(unit(progress_file.next().unwrap())).unwrap();
        }
        path
    }

    #[test]
    fn it_goes_on_after_the_last_tile() {
        let folder = tempfile::tempdir().unwrap();
        let path = two(folder.path());
        // Leftover of a run that was killed while writing.
        fs::write(folder.path().join(".tmpAbCdEf"), "{\"condit").unwrap();
        let progress_file = ProgressFile::open(path, conditions()).unwrap();
        assert_eq!(progress_file.units(), [unit(Tile::nth(0).unwrap()), unit(Tile::nth(1).unwrap())]);
        assert_eq!(progress_file.next(), Tile::nth(2));
    }

    #[test]
    fn damage_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = two(folder.path());
        let good = fs::read_to_string(&path).unwrap();
        let negative = good.replacen("0.1", "-0.1", 1);
        let swapped = {
            let mut state: State = serde_json::from_str(&good).unwrap();
            state.units.swap(0, 1);
            serde_json::to_string(&state).unwrap()
        };
        let unknown = good.replacen("\"mse\"", "\"variance\"", 1);
        for bad in ["", &good[..good.len() / 2], &negative, &swapped, &unknown] {
            fs::write(&path, bad).unwrap();
            let error = ProgressFile::open(path.clone(), conditions()).unwrap_err().to_string();
            assert!(error.contains("state.json") && error.contains("--fresh"), "{bad}: {error}");
        }
    }

    #[test]
    fn other_conditions_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = two(folder.path());
        let other = RunConditions { program: "q".to_owned(), ..conditions() };
        let error = ProgressFile::open(path, other).unwrap_err().to_string();
        assert!(error.contains("state.json") && error.contains("another renderer"), "{error}");
    }

    #[test]
    fn a_fingerprint_is_of_every_byte() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        fs::write(&a, "0123456789").unwrap();
        let of = |text: &str| {
            fs::write(&b, text).unwrap();
            RunConditions::here(&a, &b).unwrap()
        };
        assert_eq!(of("0123456789"), of("0123456789"));
        for other in ["0123456780", "\x000123456789", "012345678", "0123456789\0", ""] {
            assert_ne!(of("0123456789"), of(other), "{other:?}");
        }
    }
}
