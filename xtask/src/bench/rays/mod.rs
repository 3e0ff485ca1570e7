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
    if let (Some(_), Some(folder)) = (&options.folder, &options.out) {
        std::fs::create_dir_all(folder).map_err(TaskError::file(folder))?;
    }
    let threads = rayon::ThreadPoolBuilder::new().num_threads(options.threads);
    let pool = threads.build().map_err(|error| TaskError::Other(error.to_string()))?;
    let mut figures = RayResults::default();
    pool.install(|| jobs.iter().try_for_each(|job| measure::job(job, options, &mut figures)))?;
    Ok(figures)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{mismatch::Mismatches, options::parsed, *};

    /// A square of two triangles with one without area between them, and rays down on it, of which every third misses.
    fn write_scene(folder: &std::path::Path) {
        let mut mesh = vec![4, 3];
        mesh.extend([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0f32].map(f32::to_bits));
        mesh.extend([0, 1, 2, 0, 1, 1, 0, 2, 3]);
        let ray = |i: usize| {
            let x = if i.is_multiple_of(3) { 2.0 } else { i as f32 / 100.0 };
            [x, 0.5, 3.0, 0.0, 0.0, 0.0, -1.0, 1e30].map(f32::to_bits)
        };
        let rays: Vec<u32> = (0..99).flat_map(ray).collect();
        for (name, words) in [("square.mesh", &mesh), ("square.primary.rays", &rays), ("square.shadow.rays", &rays)] {
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            fs::write(folder.join(name), bytes).unwrap();
        }
    }

    #[test]
    fn single_rays_and_batches_on_any_number_of_threads_write_the_same_hits() {
        let folder = tempfile::tempdir().unwrap();
        write_scene(folder.path());
        let here = folder.path().to_str().unwrap();
        let out = folder.path().join("out");
        let out = out.to_str().unwrap();
        let run = |args: &[&str]| {
            let common = ["--folder", here, "--out", out, "--reps", "1", "--same-as", "linear"];
            let figures = figures(&parsed(&[&common, args].concat())).unwrap();
            assert!(figures.rays.iter().all(|set| (set.rays, set.hits, set.differing) == (99, 66, Some(0))));
            ["primary", "shadow"].map(|kind| fs::read(format!("{out}/square.{kind}.hit")).unwrap())
        };
        let single = run(&[]);
        assert_eq!(run(&["--batch=7", "--threads", "2"]), single);
        let hits = files::read_hits(&folder.path().join("out/square.primary.hit")).unwrap();
        let hit = |triangle| files::HitRecord { t: 3.0, triangle };
        assert_eq!([hits[0], hits[1], hits[98]], [files::HitRecord::MISS, hit(2), hit(0)], "numbers as in the file");
    }

    #[test]
    fn hits_are_held_against_the_reference() {
        let folder = tempfile::tempdir().unwrap();
        write_scene(folder.path());
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let [mesh, rays, reference] = ["square.mesh", "square.primary.rays", "reference"].map(path);
        let mut right = vec![files::HitRecord { t: 3.0, triangle: 0 }; 99];
        right[1] = files::HitRecord { t: 2.9, triangle: 2 };
        right[2] = files::HitRecord::MISS;
        files::write_hits(reference.as_ref(), &right).unwrap();
        let figures = figures(&parsed(&[&mesh, &rays, "--reference", &reference, "--every", "2"])).unwrap();
        let [set] = &figures.rays[..] else { panic!("one set") };
        assert_eq!(set.rays, 50);
        assert_eq!(set.wrong, Some(Mismatches { leaks: 17, ghosts: 1, wrong_t: 0 }));
        assert!(set.mrays_per_cpu_second.min > 0.0 && figures.builds[0].bytes > 0);
    }
}
