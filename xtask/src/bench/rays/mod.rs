//! Rays through a mesh, both from neutral files that other tracers read as well, so that all do the same work.
//!
//! The timed part starts with the ray in the format of the file and ends with a hit in that format.

use super::common::print;
use crate::error::TaskError;

mod files;
mod jobs;
mod measure;
mod mismatch;
mod options;
mod table;
mod trace;

pub(super) use options::RayOptions;
use table::RayResults;

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

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::{mismatch::Mismatches, options::parsed, *};

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
