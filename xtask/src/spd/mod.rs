//! `spd`: the Standard Procedural Databases (Haines, "A Proposal for Standard Graphics Environments", IEEE CG&A 7(11), 1987)
//! as NFF files of any size.
//!
//! ```text
//!   cargo xtask spd                           the small ones of scenes/spd
//!   cargo xtask spd balls --size 4 -o b.nff   one, of the size that the paper measures
//! ```
//!
//! The databases `balls`, `tetra` and `rings` have the original coordinates. The others follow the paper, which gives
//! their parts and the number of objects.

use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use crate::{error::TaskError, files, workspace::Workspace};

mod gears;
mod mountain;
mod nff;
mod rings;
mod sphereflake;
mod tetra;
mod tree;

use nff::Nff;

#[derive(Debug, clap::Args)]
pub(crate) struct SpdOptions {
    /// Write this database [default: all, in a small size, to scenes/spd]
    #[arg(value_enum)]
    database: Option<Database>,
    /// Set the size factor [default: size of the paper]
    #[arg(long, requires = "database")]
    size: Option<u32>,
    /// Write to this file [default: DATABASE.nff]
    #[arg(short, long, value_name = "FILE", requires = "database")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Database {
    /// Recursive spheres: (9^(size + 1) − 1) / 8 spheres.
    #[value(name = "balls")]
    Sphereflake,
    /// Glass gears: size³ gears of 146 polygons.
    Gears,
    /// Fractal mountain of 2 · 4^size triangles, and four glass spheres.
    Mountain,
    /// Interlocked rings: layers of 1, 4, 9, ... size² sets of 60 cylinders and spheres.
    Rings,
    /// Recursive tetrahedra: 4^size triangles.
    Tetra,
    /// Tree of 2^(size + 1) − 1 branches.
    Tree,
}

impl Database {
    const ALL: [Self; 6] = [Self::Sphereflake, Self::Gears, Self::Mountain, Self::Rings, Self::Tetra, Self::Tree];

    const fn name(self) -> &'static str {
        match self {
            Self::Sphereflake => "balls",
            Self::Gears => "gears",
            Self::Mountain => "mountain",
            Self::Rings => "rings",
            Self::Tetra => "tetra",
            Self::Tree => "tree",
        }
    }

    /// The size that the paper measures: some ten thousand objects.
    const fn size_of_paper(self) -> u32 {
        match self {
            Self::Sphereflake | Self::Gears => 4,
            Self::Mountain | Self::Tetra => 6,
            Self::Rings => 7,
            Self::Tree => 11,
        }
    }

    /// The size of the file in scenes/spd: less than 100 kB.
    const fn small_size(self) -> u32 {
        match self {
            Self::Sphereflake => 3,
            Self::Gears => 1,
            Self::Mountain | Self::Tetra => 4,
            Self::Rings => 2,
            Self::Tree => 8,
        }
    }

    /// Sizes with at most some million objects.
    const fn sizes(self) -> RangeInclusive<u32> {
        match self {
            Self::Sphereflake => 0..=7,
            Self::Gears => 1..=30,
            Self::Mountain => 0..=10,
            Self::Rings => 1..=60,
            Self::Tetra => 1..=11,
            Self::Tree => 0..=20,
        }
    }

    fn generate(self, size: u32) -> Nff {
        match self {
            Self::Sphereflake => sphereflake::sphereflake(size),
            Self::Gears => gears::gears(size),
            Self::Mountain => mountain::mountain(size),
            Self::Rings => rings::rings(size),
            Self::Tetra => tetra::tetra(size),
            Self::Tree => tree::tree(size),
        }
    }
}

/// Writes one database, or the small ones of the project.
pub(crate) fn run(workspace: &Workspace, options: &SpdOptions) -> Result<(), TaskError> {
    let Some(database) = options.database else {
        let folder = workspace.root.join("scenes/spd");
        fs::create_dir_all(&folder).map_err(TaskError::file(&folder))?;
        for database in Database::ALL {
            write(database, database.small_size(), &folder.join(database.name()).with_extension("nff"))?;
        }
        return Ok(());
    };
    let size = options.size.unwrap_or_else(|| database.size_of_paper());
    let sizes = database.sizes();
    if !sizes.contains(&size) {
        let (min, most) = sizes.into_inner();
        let name = database.name();
        return Err(TaskError::Other(format!("{name} of size {size}: give a size from {min} to {most}")));
    }
    let output = options.output.clone().unwrap_or_else(|| Path::new(database.name()).with_extension("nff"));
    write(database, size, &output)
}

fn write(database: Database, size: u32, output: &Path) -> Result<(), TaskError> {
    let file = database.generate(size);
    files::write(output, file.text())?;
    println!("{}: size {size}, {} objects", output.display(), file.objects());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of each object: `p`, `s` and `c` statements in order.
    fn objects(text: &str) -> Vec<(String, Vec<f64>)> {
        let mut statements: Vec<(String, Vec<f64>)> = Vec::new();
        for word in text.lines().filter(|line| !line.starts_with('#')).flat_map(str::split_whitespace) {
            match (word.parse(), statements.last_mut()) {
                (Ok(number), Some((_, numbers))) => numbers.push(number),
                _ => statements.push((word.to_owned(), Vec::new())),
            }
        }
        statements.retain(|(keyword, _)| matches!(keyword.as_str(), "p" | "s" | "c"));
        statements
    }

    #[test]
    fn databases_are_those_of_the_original_generators() {
        let Some(folder) = rt_tests::shared_or_skip("data/nff-spd") else { return };
        let cases = [
            (Database::Sphereflake, 1),
            (Database::Sphereflake, 2),
            (Database::Sphereflake, 3),
            (Database::Rings, 2),
            (Database::Tetra, 2),
            (Database::Tetra, 4),
        ];
        for (database, size) in cases {
            let path = folder.join(format!("{}-s{size}.nff", database.name()));
            let expected = objects(&fs::read_to_string(&path).expect("a file"));
            let actual = objects(database.generate(size).text());
            assert_eq!(actual.len(), expected.len(), "{}", path.display());
            for (i, (actual, expected)) in actual.iter().zip(&expected).enumerate() {
                assert_eq!(
                    (&actual.0, actual.1.len()),
                    (&expected.0, expected.1.len()),
                    "object {i} of {}",
                    path.display()
                );
                // Both files are rounded: theirs to six digits.
                let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1.5e-5 * a.abs().max(1.0);
                assert!(actual.1.iter().zip(&expected.1).all(near), "object {i}: {actual:?}, not {expected:?}");
            }
        }
    }

    #[test]
    fn files_that_come_along_are_those_of_the_generators() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/spd");
        for database in Database::ALL {
            let path = folder.join(database.name()).with_extension("nff");
            let text = fs::read_to_string(&path).expect("a file");
            assert!(text.len() < 100_000, "{}: {} bytes", path.display(), text.len());
            assert!(
                text == database.generate(database.small_size()).text(),
                "{}: run `cargo xtask spd`",
                path.display()
            );
        }
    }

    #[test]
    fn the_paper_has_this_many_polygons_spheres_and_cones() {
        let counts = [[1, 7381, 0], [9345, 0, 0], [8192, 4, 0], [1, 4200, 4200], [4096, 0, 0], [1, 4095, 4095]];
        for (database, counts) in Database::ALL.into_iter().zip(counts) {
            let file = database.generate(database.size_of_paper());
            assert_eq!([file.polygons, file.spheres, file.cones], counts, "{}", database.name());
            assert!(
                [database.size_of_paper(), database.small_size()].iter().all(|size| database.sizes().contains(size))
            );
        }
    }
}
