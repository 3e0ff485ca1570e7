//! The measurements of one mesh.

use std::{path::Path, time::Duration};

use rt_accel::{Accelerator, AcceleratorKind, AnyAccelerator};
use rt_geometry::TriangleMesh;

use super::{
    files::{self, HitRecord},
    jobs::{Job, RayFile},
    mismatch::Mismatches,
    options::RayOptions,
    table::{BuildResult, RayResult, RayResults, TreeShape},
    trace::{Method, Query, trace},
};
use crate::{
    costs::RayAnswer,
    error::TaskError,
    timings::{Spread, Timings},
};

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
    let build_oracle = |kind| AnyAccelerator::build(kind, &scene.mesh).map_err(TaskError::other);
    let oracle = options.same_as.map(build_oracle).transpose()?;
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
    let build = || AnyAccelerator::build_with(kind, options.quality, &scene.mesh).map_err(TaskError::other);
    let (accelerator, Timings { cpu, wall }) = Timings::of(options.reps, PATIENCE, build)?;
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
    Ok((accelerator, figure))
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
    let wrong = set.reference.as_deref().map(|path| wrong(path, &hits, set.query, scene.job.tolerance)).transpose()?;
    // Rays with other bits than those of `same_as`, which traces single rays.
    let differing = oracle.map(|oracle| {
        let mut ours = vec![RayAnswer::Miss; rays.len()];
        let mut theirs = ours.clone();
        trace(accelerator, &scene.mesh, method, &rays, &mut ours);
        trace(oracle, &scene.mesh, Method { batch: None, ..method }, &rays, &mut theirs);
        ours.iter().zip(&theirs).filter(|(ours, theirs)| ours != theirs).count()
    });
    let hit = hits.iter().filter(|hit| hit.is_hit()).count();
    let ((), timings) = Timings::of(options.reps, Duration::MAX, || {
        trace(accelerator, &scene.mesh, method, &rays, &mut hits);
        std::hint::black_box(&hits);
        Ok(())
    })?;
    let mega_rays =
        |seconds: Vec<f64>| Spread::of(seconds.into_iter().map(|seconds| rays.len() as f64 / seconds * 1e-6).collect());
    Ok(RayResult {
        scene: scene.job.scene.clone(),
        kind: set.kind.clone(),
        accelerator: accelerator.kind().name(),
        query: set.query,
        batch: options.batch,
        threads: options.threads,
        rays: rays.len(),
        hits: hit,
        mrays_per_cpu_second: mega_rays(timings.cpu),
        mrays_per_second: mega_rays(timings.wall),
        wrong,
        differing,
    })
}

/// Compares with the hits in a file.
fn wrong(path: &Path, hits: &[HitRecord], query: Query, tolerance: f32) -> Result<Mismatches, TaskError> {
    let reference = files::read_hits(path)?;
    if reference.len() != hits.len() {
        let (there, here) = (reference.len(), hits.len());
        return Err(TaskError::Other(format!("{}: {there} hits for {here} rays", path.display())));
    }
    Ok(Mismatches::count(&reference, hits, query, tolerance))
}
