//! Rays through a mesh, both from neutral files that other tracers read as well, so that all do the same work.
//!
//! The timed part starts with the ray in the format of the file and ends with a hit in that format.

use std::path::PathBuf;

use clap::builder::TypedValueParser;
use rt_accel::{AcceleratorKind, wide::Quality};

use super::common::{accelerator, print, quality};
use crate::error::TaskError;

mod files;
mod jobs;
mod measure;
mod mismatch;
mod table;
mod trace;

use table::RayResults;

/// Options of `bench rays`.
#[derive(Debug, clap::Args)]
pub(super) struct RayOptions {
    /// Measure all SCENE.mesh with SCENE.KIND.rays in this directory, against SCENE.KIND.ref if it exists.
    #[arg(long, value_name = "DIR")]
    folder: PathBuf,
    /// Measure only these scenes.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    /// Measure these accelerators.
    #[arg(long, value_delimiter = ',', default_value = "bvh", value_parser = accelerator())]
    accel: Vec<AcceleratorKind>,
    /// Choose the build quality of the wide BVH.
    #[arg(long, default_value = "medium", value_parser = quality())]
    quality: Quality,
    /// Trace batches of this many rays instead of single rays.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "4096", value_name = "RAYS",
          value_parser = positive())]
    batch: Option<usize>,
    /// Set the number of threads for building and tracing.
    #[arg(long, default_value_t = 1, value_parser = positive())]
    threads: usize,
    /// Measure each value this often, after a pass that is checked and not timed.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
    /// Count the rays whose hit is not bit-identical to that of this accelerator, traced as single rays.
    #[arg(long, value_name = "ACCEL", value_parser = accelerator())]
    same_as: Option<AcceleratorKind>,
}

fn positive() -> impl TypedValueParser<Value = usize> {
    clap::value_parser!(u32).range(1..).map(|number| number as usize)
}

/// Measures and prints.
pub(super) fn run(options: &RayOptions) -> Result<(), TaskError> {
    let figures = figures(options)?;
    print(&figures, &figures)
}

fn figures(options: &RayOptions) -> Result<RayResults, TaskError> {
    let jobs = jobs::jobs(options)?;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(options.threads);
    let pool = threads.build().map_err(TaskError::other)?;
    let mut figures = RayResults::default();
    pool.install(|| jobs.iter().try_for_each(|job| measure::job(job, options, &mut figures)))?;
    Ok(figures)
}

/// Parses options for a folder.
#[cfg(test)]
fn parsed(folder: &std::path::Path, args: &[&str]) -> RayOptions {
    use clap::{Args, FromArgMatches};
    let command = RayOptions::augment_args(clap::Command::new("rays").no_binary_name(true));
    let all = [&["--folder", folder.to_str().unwrap()], args].concat();
    RayOptions::from_arg_matches(&command.get_matches_from(all)).unwrap()
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::{mismatch::Mismatches, *};

    fn write(folder: &Path, name: &str, words: &[u32]) {
        fs::write(folder.join(name), words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    }

    /// A square of two triangles with one without area between them, and rays down on it, of which every third misses.
    fn write_scene(folder: &Path) {
        let mut mesh = vec![4, 3];
        mesh.extend([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0f32].map(f32::to_bits));
        mesh.extend([0, 1, 2, 0, 1, 1, 0, 2, 3]);
        let ray = |i: usize| {
            let x = if i.is_multiple_of(3) { 2.0 } else { i as f32 / 100.0 };
            [x, 0.5, 3.0, 0.0, 0.0, 0.0, -1.0, 1e30].map(f32::to_bits)
        };
        let rays: Vec<u32> = (0..99).flat_map(ray).collect();
        for (name, words) in [("square.mesh", &mesh), ("square.primary.rays", &rays), ("square.shadow.rays", &rays)] {
            write(folder, name, words);
        }
    }

    #[test]
    fn single_rays_and_batches_on_any_number_of_threads_give_the_same_hits() {
        let folder = tempfile::tempdir().unwrap();
        write_scene(folder.path());
        for args in [&[][..], &["--batch=7", "--threads", "2"]] {
            let args = [&["--reps", "1", "--same-as", "linear"], args].concat();
            let figures = figures(&parsed(folder.path(), &args)).unwrap();
            assert_eq!(figures.rays.len(), 2);
            assert!(figures.rays.iter().all(|set| (set.rays, set.hits, set.differing) == (99, 66, Some(0))));
        }
    }

    #[test]
    fn hits_are_held_against_the_reference() {
        let folder = tempfile::tempdir().unwrap();
        write_scene(folder.path());
        let mut right = vec![3f32; 99];
        right[1] = 2.9;
        right[2] = f32::INFINITY;
        let right: Vec<u32> = right.iter().flat_map(|t| [t.to_bits(), 0]).collect();
        write(folder.path(), "square.primary.ref", &right);
        let figures = figures(&parsed(folder.path(), &[])).unwrap();
        let [set, shadows] = &figures.rays[..] else { panic!("two sets") };
        assert_eq!(set.wrong, Some(Mismatches { leaks: 33, ghosts: 1, wrong_t: 1 }));
        assert!(set.mrays_per_cpu_second.min > 0.0 && figures.builds[0].bytes > 0 && shadows.wrong.is_none());
    }
}
