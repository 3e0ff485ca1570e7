//! Rays through a mesh, both from neutral files that other tracers read as well, so that all do the same work.
//!
//! What is timed begins with the ray as the file has it and ends with its hit as a file would have it.

use std::path::PathBuf;

use clap::builder::TypedValueParser;
use rt_accel::{AcceleratorKind, AcceleratorQueries, AnyAccelerator, BuildStats, wide::Quality};
use serde::Serialize;

use super::{print, quality, spread::Spread, structure};
use crate::error::TaskError;

mod files;
mod jobs;
mod measure;
mod table;
mod trace;
mod wrong;

use trace::Query;
use wrong::Wrong;

/// What the command line asks for.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// Pairs of files: a mesh and rays through it.
    #[arg(value_name = "MESH RAYS", required_unless_present = "folder")]
    files: Vec<PathBuf>,
    /// Measure every SCENE.mesh of this folder with every SCENE.KIND.rays, against SCENE.KIND.ref where it exists.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["files", "reference"])]
    folder: Option<PathBuf>,
    /// Of the folder, only these scenes.
    #[arg(long, value_delimiter = ',', requires = "folder")]
    scene: Vec<String>,
    /// Of the folder, only these kinds of rays.
    #[arg(long, value_delimiter = ',', requires = "folder")]
    kind: Vec<String>,
    /// Structures to measure.
    #[arg(long, value_delimiter = ',', default_value = "bvh", value_parser = structure())]
    accel: Vec<AcceleratorKind>,
    /// How much time the builder of the wide tree takes.
    #[arg(long, default_value = "medium", value_parser = quality())]
    quality: Quality,
    /// What to ask of each ray; by default whether a ray of a file `*.shadow.rays` is occluded, and the closest hit of
    /// all others.
    #[arg(long)]
    query: Option<Query>,
    /// Trace batches of this many rays instead of single rays.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "4096", value_name = "RAYS",
          value_parser = positive())]
    batch: Option<usize>,
    /// Threads that build and trace.
    #[arg(long, default_value_t = 1, value_parser = positive())]
    threads: usize,
    /// Measurements of each figure, after a pass that is checked and not timed.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
    /// Trace only every so many-th ray.
    #[arg(long, default_value_t = 1, value_parser = positive())]
    every: usize,
    /// Write the hits to this file, or those of a folder into this folder.
    #[arg(long, value_name = "HITS")]
    out: Option<PathBuf>,
    /// Count wrong hits by this file; give it once for each pair.
    #[arg(long, value_name = "REF")]
    reference: Vec<PathBuf>,
    /// How far the parameter of a hit may be off beside a ten-thousandth of it: a number or a file with one. By
    /// default MESH with the ending `.eps`, or 1e-5.
    #[arg(long)]
    eps: Option<String>,
    /// Count the rays of which this structure, asked one by one, gives an answer with other bits.
    #[arg(long, value_name = "ACCEL", value_parser = structure())]
    same_as: Option<AcceleratorKind>,
}

fn positive() -> impl TypedValueParser<Value = usize> {
    clap::value_parser!(u32).range(1..).map(|number| number as usize)
}

/// Building one structure over one mesh.
#[derive(Debug, Serialize)]
struct BuildFigure {
    scene: String,
    structure: &'static str,
    /// Meaningless but for the wide tree.
    quality: &'static str,
    threads: usize,
    /// Those with an area.
    triangles: usize,
    cpu_seconds: Spread,
    wall_seconds: Spread,
    /// Of the structure itself.
    bytes: usize,
    bytes_per_triangle: f64,
    /// Of vertices and indices, which the caller keeps.
    mesh_bytes: usize,
    shape: Shape,
}

/// What the builder made.
#[derive(Debug, Serialize)]
struct Shape {
    nodes: usize,
    leaves: usize,
    references: usize,
    max_depth: usize,
    sah_cost: Option<f64>,
}

impl Shape {
    fn of(structure: &AnyAccelerator) -> Self {
        let BuildStats { nodes, leaves, references, max_depth, sah_cost, .. } = structure.build_stats();
        Self { nodes, leaves, references, max_depth, sah_cost }
    }
}

/// Tracing one set of rays through one structure.
#[derive(Debug, Serialize)]
struct RayFigure {
    scene: String,
    kind: String,
    structure: &'static str,
    query: Query,
    /// Rays of a batch; `None` for single rays.
    batch: Option<usize>,
    threads: usize,
    rays: usize,
    /// Rays that hit something.
    hits: usize,
    /// Millions of rays for each second of a processor.
    mrays_per_cpu_second: Spread,
    /// Millions of rays for each second on the wall.
    mrays_per_second: Spread,
    /// By the reference, if there is one.
    wrong: Option<Wrong>,
    /// Answers with other bits than those of `--same-as`.
    differing: Option<usize>,
}

impl RayFigure {
    /// The clock to believe: a single thread's is that of its processor, several threads' that of the wall.
    fn mega_rays(&self) -> Spread {
        if self.threads == 1 { self.mrays_per_cpu_second } else { self.mrays_per_second }
    }
}

/// All that was measured.
#[derive(Debug, Default, Serialize)]
struct Figures {
    builds: Vec<BuildFigure>,
    rays: Vec<RayFigure>,
}

/// Measures and prints.
pub(super) fn run(options: &Options) -> Result<(), TaskError> {
    let figures = figures(options)?;
    print(&figures, &table::markdown(&figures))
}

fn figures(options: &Options) -> Result<Figures, TaskError> {
    let jobs = jobs::jobs(options)?;
    if let (Some(_), Some(folder)) = (&options.folder, &options.out) {
        std::fs::create_dir_all(folder).map_err(TaskError::file(folder))?;
    }
    let threads = rayon::ThreadPoolBuilder::new().num_threads(options.threads);
    let pool = threads.build().map_err(|error| TaskError::Other(error.to_string()))?;
    let mut figures = Figures::default();
    pool.install(|| jobs.iter().try_for_each(|job| measure::job(job, options, &mut figures)))?;
    Ok(figures)
}

/// Options as the command line gives them.
#[cfg(test)]
fn parsed(args: &[&str]) -> Options {
    use clap::{Args, FromArgMatches};
    let command = Options::augment_args(clap::Command::new("rays").no_binary_name(true));
    Options::from_arg_matches(&command.get_matches_from(args)).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
        assert_eq!(set.wrong, Some(Wrong { leaks: 17, ghosts: 1, wrong_t: 0 }));
        assert!(set.mrays_per_cpu_second.min > 0.0 && figures.builds[0].bytes > 0);
    }
}
