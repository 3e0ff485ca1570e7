//! Progress file with a line of JSON per tile: a run continues where an earlier run stopped or was killed.

use std::{
    fs::{self, File, OpenOptions},
    hash::{DefaultHasher, Hasher},
    io::Write,
    path::{Path, PathBuf},
};

use super::{lecture_numbers::Tile, tile_job::TileResult};
use crate::{error::TaskError, files};

/// The measured tiles, in the order of [`Tile::nth`] without a gap.
#[derive(Debug)]
pub(super) struct ProgressFile {
    path: PathBuf,
    units: Vec<TileResult>,
}

/// Name of the file for this renderer and this scene on this machine. Only measurements under equal conditions make one
/// sample, so that others have another file.
pub(super) fn name(program: &Path, scene: &Path) -> Result<String, TaskError> {
    let mut hasher = DefaultHasher::new();
    for path in [program, scene] {
        let bytes = fs::read(path).map_err(TaskError::file(path))?;
        hasher.write_usize(bytes.len());
        hasher.write(&bytes);
    }
    hasher.write(crate::processor::processor().as_bytes());
    Ok(format!("tiles-{:016x}.jsonl", hasher.finish()))
}

impl ProgressFile {
    /// Reads the file, if there is one. A damaged file is an error that names it; a last line that is not whole, which a
    /// kill leaves, is cut off.
    pub(super) fn open(path: PathBuf) -> Result<Self, TaskError> {
        let text = files::read_if_present(&path)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        if whole < text.len() {
            let file = OpenOptions::new().write(true).open(&path);
            file.and_then(|file| file.set_len(whole as u64)).map_err(TaskError::file(&path))?;
        }
        let mut units = Vec::new();
        for (index, line) in text[..whole].lines().enumerate() {
            let unit = serde_json::from_str(line).ok();
            let unit = unit.filter(|unit: &TileResult| Tile::nth(index) == Some(unit.tile) && unit.is_sound());
            let (line, path) = (index + 1, path.display());
            let damaged =
                || TaskError::Other(format!("{path}:{line}: cannot have been measured; start over with --fresh"));
            units.push(unit.ok_or_else(damaged)?);
        }
        Ok(Self { path, units })
    }

    pub(super) fn units(&self) -> &[TileResult] {
        &self.units
    }

    /// The tile to measure next; `None` if the image is whole.
    pub(super) fn next(&self) -> Option<Tile> {
        Tile::nth(self.units.len())
    }

    /// Adds the measurements of the next tile.
    pub(super) fn append(&mut self, unit: TileResult) -> Result<(), TaskError> {
        let line = serde_json::to_string(&unit).map_err(TaskError::other)? + "\n";
        let file = OpenOptions::new().append(true).create(true).open(&self.path);
        let written = file.and_then(|mut file: File| file.write_all(line.as_bytes()).and_then(|()| file.sync_all()));
        written.map_err(TaskError::file(&self.path))?;
        self.units.push(unit);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tile_job::Measured, *};

    fn unit(index: usize) -> TileResult {
        let measured = Measured { cpu_seconds: 0.1, mse: 1e-9 };
        let tile = Tile::nth(index).unwrap();
        TileResult { tile, rays_per_sample: 9.0, jittered: measured, best: [measured; 3] }
    }

    /// Text of a file with two tiles.
    fn two() -> String {
        [0, 1].map(|index| serde_json::to_string(&unit(index)).unwrap() + "\n").concat()
    }

    fn opened(text: &str) -> Result<ProgressFile, TaskError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tiles.jsonl");
        fs::write(&path, text).unwrap();
        let mut file = ProgressFile::open(path.clone())?;
        file.append(unit(file.units().len()))?;
        ProgressFile::open(path)
    }

    #[test]
    fn it_goes_on_after_the_last_whole_line() {
        for (left_over, tiles) in [("", 3), ("{\"tile\"", 3)] {
            assert_eq!(opened(&(two() + left_over)).unwrap().units(), (0..tiles).map(unit).collect::<Vec<_>>());
        }
        assert_eq!(opened("").unwrap().next(), Tile::nth(1));
    }

    #[test]
    fn damage_is_refused_by_name() {
        let good = two();
        let mut swapped: Vec<&str> = good.lines().collect();
        swapped.reverse();
        let [negative, unknown] = [("0.1", "-0.1"), ("\"mse\"", "\"variance\"")].map(|(a, b)| good.replacen(a, b, 1));
        for bad in ["\n", &negative, &unknown, &(swapped.join("\n") + "\n")] {
            let error = opened(bad).unwrap_err().to_string();
            assert!(error.contains("tiles.jsonl:1: ") && error.contains("--fresh"), "{bad}: {error}");
        }
    }

    #[test]
    fn other_bytes_of_the_program_or_the_scene_give_another_file() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        fs::write(&a, "0123456789").unwrap();
        let of = |text: &str| {
            fs::write(&b, text).unwrap();
            [name(&a, &b).unwrap(), name(&b, &a).unwrap()]
        };
        let same = of("0123456789");
        assert_eq!(same[0], same[1]);
        for other in ["0123456780", "\x000123456789", "012345678", "0123456789\0", ""] {
            let [first, second] = of(other);
            assert!(first != second && !same.contains(&first) && !same.contains(&second), "{other:?}");
        }
    }
}
