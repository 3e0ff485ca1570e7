//! The measurements of one mesh.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use rt_accel::{AcceleratorKind, AcceleratorQueries, AnyAccelerator};
use rt_geometry::TriangleMesh;

use super::{
    files::{self, HitRecord, RayRecord},
    jobs::{Job, RayFile},
    mismatch::Mismatches,
    options::RayOptions,
    table::{BuildResult, RayResult, RayResults, TreeShape},
    trace::{Bits, Method, trace},
};
use crate::{bench::timing_stats::Spread, error::TaskError};

/// Builds that take longer than this together are not repeated.
const PATIENCE: Duration = Duration::from_secs(2);

/// A mesh whose triangles have the numbers of the file.
struct Scene<'j> {
    job: &'j Job,
    mesh: TriangleMesh,
    /// The number in the file of each triangle of the mesh, if any was dropped for having no area.
    numbers: Option<Vec<u32>>,
}

/// Measures everything on the threads of the current pool.
pub(super) fn job(job: &Job, options: &RayOptions, figures: &mut RayResults) -> Result<(), TaskError> {
    let scene = Scene::load(job)?;
    let judge = match options.same_as {
        Some(kind) => Some(AnyAccelerator::build(kind, &scene.mesh).map_err(other)?),
        None => None,
    };
    for &kind in &options.accel {
        let (structure, build) = build(&scene, kind, options)?;
        figures.builds.push(build);
        for set in &job.sets {
            figures.rays.push(rays(&scene, &structure, judge.as_ref(), set, options)?);
        }
    }
    Ok(())
}

impl<'j> Scene<'j> {
    fn load(job: &'j Job) -> Result<Self, TaskError> {
        let data = files::read_mesh(&job.mesh)?;
        let all = data.triangles.clone();
        let (mesh, _) = TriangleMesh::build(data).map_err(other)?;
        let kept = &mesh.data().triangles;
        let numbers = (kept.len() < all.len()).then(|| numbers(&all, kept));
        Ok(Self { job, mesh, numbers })
    }

    fn renumber(&self, hits: &mut [HitRecord]) {
        let Some(numbers) = &self.numbers else { return };
        for hit in hits {
            hit.triangle = numbers.get(hit.triangle as usize).copied().unwrap_or(u32::MAX);
        }
    }
}

/// The place in `all` of each triangle of `kept`, which has the same order. Equal triangles are kept or dropped alike.
fn numbers(all: &[[u32; 3]], kept: &[[u32; 3]]) -> Vec<u32> {
    let mut kept = kept.iter().peekable();
    let numbered = (0..).zip(all).filter(|(_, triangle)| kept.next_if_eq(triangle).is_some());
    numbered.map(|(number, _)| number).collect()
}

fn build(
    scene: &Scene<'_>,
    kind: AcceleratorKind,
    options: &RayOptions,
) -> Result<(AnyAccelerator, BuildResult), TaskError> {
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    let started = Instant::now();
    loop {
        let watch = Watch::start();
        let structure = AnyAccelerator::build_with(kind, options.quality, &scene.mesh).map_err(other)?;
        let seconds = watch.seconds();
        cpu.push(seconds.cpu);
        wall.push(seconds.wall);
        if cpu.len() >= options.reps as usize || started.elapsed() > PATIENCE {
            let bytes = structure.memory();
            let figure = BuildResult {
                scene: scene.job.scene.clone(),
                structure: kind.name(),
                quality: options.quality.name(),
                threads: options.threads,
                triangles: scene.mesh.data().triangles.len(),
                cpu_seconds: Spread::of(cpu),
                wall_seconds: Spread::of(wall),
                bytes,
                bytes_per_triangle: bytes as f64 / scene.mesh.data().triangles.len() as f64,
                mesh_bytes: scene.mesh.memory(),
                shape: TreeShape::of(&structure),
            };
            return Ok((structure, figure));
        }
    }
}

fn rays(
    scene: &Scene<'_>,
    structure: &AnyAccelerator,
    judge: Option<&AnyAccelerator>,
    set: &RayFile,
    options: &RayOptions,
) -> Result<RayResult, TaskError> {
    let rays = every(options.every, files::read_rays(&set.rays)?);
    let method = Method { query: set.query, batch: options.batch };
    let mut hits = vec![HitRecord::MISS; rays.len()];
    trace(structure, &scene.mesh, method, &rays, &mut hits);
    scene.renumber(&mut hits);
    if let Some(path) = &set.hits {
        files::write_hits(path, &hits)?;
    }
    let wrong = match &set.reference {
        Some(path) => Some(wrong(path, &hits, scene, set, options)?),
        None => None,
    };
    let differing = judge.map(|judge| differing(scene, structure, judge, method, &rays));
    let hit = hits.iter().filter(|hit| hit.is_hit()).count();
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    for _ in 0..options.reps {
        let watch = Watch::start();
        trace(structure, &scene.mesh, method, &rays, &mut hits);
        let seconds = watch.seconds();
        std::hint::black_box(&hits);
        cpu.push(rays.len() as f64 / seconds.cpu * 1e-6);
        wall.push(rays.len() as f64 / seconds.wall * 1e-6);
    }
    Ok(RayResult {
        scene: scene.job.scene.clone(),
        kind: set.kind.clone(),
        structure: structure.kind().name(),
        query: set.query,
        batch: options.batch,
        threads: options.threads,
        rays: rays.len(),
        hits: hit,
        mrays_per_cpu_second: Spread::of(cpu),
        mrays_per_second: Spread::of(wall),
        wrong,
        differing,
    })
}

fn wrong(
    path: &std::path::Path,
    hits: &[HitRecord],
    scene: &Scene<'_>,
    set: &RayFile,
    options: &RayOptions,
) -> Result<Mismatches, TaskError> {
    let reference = every(options.every, files::read_hits(path)?);
    if reference.len() != hits.len() {
        let (there, here) = (reference.len(), hits.len());
        return Err(TaskError::Other(format!("{}: {there} hits for {here} rays", path.display())));
    }
    Ok(Mismatches::count(&reference, hits, set.query, scene.job.tolerance))
}

/// Rays that the accelerator answers with other bits than `same_as`, which traces single rays.
fn differing(
    scene: &Scene<'_>,
    structure: &AnyAccelerator,
    judge: &AnyAccelerator,
    method: Method,
    rays: &[RayRecord],
) -> usize {
    let mut ours = vec![Bits::Miss; rays.len()];
    let mut theirs = ours.clone();
    trace(structure, &scene.mesh, method, rays, &mut ours);
    trace(judge, &scene.mesh, Method { batch: None, ..method }, rays, &mut theirs);
    ours.iter().zip(&theirs).filter(|(ours, theirs)| ours != theirs).count()
}

/// Every `step`-th element.
fn every<T>(step: usize, all: Vec<T>) -> Vec<T> {
    if step == 1 { all } else { all.into_iter().step_by(step).collect() }
}

/// Both clocks: that of the processor, on which neighbours do not count, over all threads, and that of the wall.
struct Watch {
    cpu: ProcessTime,
    wall: Instant,
}

struct Seconds {
    cpu: f64,
    wall: f64,
}

impl Watch {
    fn start() -> Self {
        Self { cpu: ProcessTime::now(), wall: Instant::now() }
    }

    fn seconds(&self) -> Seconds {
        Seconds { cpu: self.cpu.elapsed().as_secs_f64(), wall: self.wall.elapsed().as_secs_f64() }
    }
}

fn other(error: impl std::fmt::Display) -> TaskError {
    TaskError::Other(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_keep_the_numbers_of_the_file() {
        let all = [[0, 0, 1], [0, 1, 2], [3, 3, 3], [0, 1, 2], [2, 1, 4]];
        assert_eq!(numbers(&all, &[[0, 1, 2], [0, 1, 2], [2, 1, 4]]), [1, 3, 4]);
    }
}
