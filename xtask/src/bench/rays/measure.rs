//! The measurements of one mesh.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use rt_accel::{Accelerator, AcceleratorKind, AnyAccelerator};
use rt_geometry::TriangleMesh;

use super::{
    files::{self, HitRecord, RayRecord},
    jobs::{Job, RayFile},
    mismatch::Mismatches,
    options::RayOptions,
    table::{BuildResult, RayResult, RayResults, TreeShape},
    trace::{Method, trace},
};
use crate::{bench::timing_stats::Spread, costs::RayAnswer, error::TaskError};

/// Builds that take longer than this together are not repeated.
const PATIENCE: Duration = Duration::from_secs(2);

struct MeshScene<'j> {
    job: &'j Job,
    mesh: TriangleMesh,
}

/// Measures everything on the threads of the current pool.
pub(super) fn job(job: &Job, options: &RayOptions, figures: &mut RayResults) -> Result<(), TaskError> {
    let (mesh, _) = TriangleMesh::build(files::read_mesh(&job.mesh)?).map_err(TaskError::other)?;
    let scene = MeshScene { job, mesh };
    let oracle = match options.same_as {
        Some(kind) => Some(AnyAccelerator::build(kind, &scene.mesh).map_err(TaskError::other)?),
        None => None,
    };
    for &kind in &options.accel {
        let (accelerator, build) = build(&scene, kind, options)?;
        figures.builds.push(build);
        for set in &job.sets {
            figures.rays.push(rays(&scene, &accelerator, oracle.as_ref(), set, options)?);
        }
    }
    Ok(())
}

fn build(
    scene: &MeshScene<'_>,
    kind: AcceleratorKind,
    options: &RayOptions,
) -> Result<(AnyAccelerator, BuildResult), TaskError> {
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    let started = Instant::now();
    loop {
        let watch = Watch::start();
        let accelerator = AnyAccelerator::build_with(kind, options.quality, &scene.mesh).map_err(TaskError::other)?;
        let seconds = watch.seconds();
        cpu.push(seconds.cpu);
        wall.push(seconds.wall);
        if cpu.len() >= options.reps as usize || started.elapsed() > PATIENCE {
            let bytes = accelerator.memory();
            let figure = BuildResult {
                scene: scene.job.scene.clone(),
                accelerator: kind.name(),
                quality: options.quality.name(),
                threads: options.threads,
                triangles: scene.mesh.data().triangles.len(),
                cpu_seconds: Spread::of(cpu),
                wall_seconds: Spread::of(wall),
                bytes,
                bytes_per_triangle: bytes as f64 / scene.mesh.data().triangles.len() as f64,
                mesh_bytes: scene.mesh.memory(),
                shape: TreeShape::of(&accelerator),
            };
            return Ok((accelerator, figure));
        }
    }
}

fn rays(
    scene: &MeshScene<'_>,
    accelerator: &AnyAccelerator,
    oracle: Option<&AnyAccelerator>,
    set: &RayFile,
    options: &RayOptions,
) -> Result<RayResult, TaskError> {
    let rays = files::read_rays(&set.rays)?;
    let method = Method { query: set.query, batch: options.batch };
    let mut hits = vec![HitRecord::MISS; rays.len()];
    trace(accelerator, &scene.mesh, method, &rays, &mut hits);
    let wrong = match &set.reference {
        Some(path) => Some(wrong(path, &hits, scene, set)?),
        None => None,
    };
    let differing = oracle.map(|oracle| differing(scene, accelerator, oracle, method, &rays));
    let hit = hits.iter().filter(|hit| hit.is_hit()).count();
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    for _ in 0..options.reps {
        let watch = Watch::start();
        trace(accelerator, &scene.mesh, method, &rays, &mut hits);
        let seconds = watch.seconds();
        std::hint::black_box(&hits);
        cpu.push(rays.len() as f64 / seconds.cpu * 1e-6);
        wall.push(rays.len() as f64 / seconds.wall * 1e-6);
    }
    Ok(RayResult {
        scene: scene.job.scene.clone(),
        kind: set.kind.clone(),
        accelerator: accelerator.kind().name(),
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
    scene: &MeshScene<'_>,
    set: &RayFile,
) -> Result<Mismatches, TaskError> {
    let reference = files::read_hits(path)?;
    if reference.len() != hits.len() {
        let (there, here) = (reference.len(), hits.len());
        return Err(TaskError::Other(format!("{}: {there} hits for {here} rays", path.display())));
    }
    Ok(Mismatches::count(&reference, hits, set.query, scene.job.tolerance))
}

/// Rays that the accelerator answers with other bits than `same_as`, which traces single rays.
fn differing(
    scene: &MeshScene<'_>,
    accelerator: &AnyAccelerator,
    oracle: &AnyAccelerator,
    method: Method,
    rays: &[RayRecord],
) -> usize {
    let mut ours = vec![RayAnswer::Miss; rays.len()];
    let mut theirs = ours.clone();
    trace(accelerator, &scene.mesh, method, rays, &mut ours);
    trace(oracle, &scene.mesh, Method { batch: None, ..method }, rays, &mut theirs);
    ours.iter().zip(&theirs).filter(|(ours, theirs)| ours != theirs).count()
}

/// CPU time of all threads, and wall time.
struct Watch {
    cpu: ProcessTime,
    wall: Instant,
}

struct ClockTimes {
    cpu: f64,
    wall: f64,
}

impl Watch {
    fn start() -> Self {
        Self { cpu: ProcessTime::now(), wall: Instant::now() }
    }

    fn seconds(&self) -> ClockTimes {
        ClockTimes { cpu: self.cpu.elapsed().as_secs_f64(), wall: self.wall.elapsed().as_secs_f64() }
    }
}
