//! Rays per second of a batch in the caller's arrays: `cargo run --release -p rt-accel --example batches -- [RAYS]`.
//!
//! The mesh and the rays are those of `bindings/python/examples/speed.py`, so that the two can be compared.

#![allow(clippy::print_stdout, reason = "the result of the program")]

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use rt_accel::{HitBatch, RayBatch, Scene, TriangleMesh};
use rt_math::transcendental::{cos, sin};

/// Star-shaped mesh of 2 n² triangles.
fn bumpy_sphere(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let point = |i: u32, j: u32| {
        let u = f64::from(i) / f64::from(n) * TAU;
        let v = 0.02 + f64::from(j) / f64::from(n) * (PI - 0.04);
        let radius = 1.0 + 0.1 * sin(17.0 * u) * sin(13.0 * v);
        [sin(v) * cos(u), sin(v) * sin(u), cos(v)].map(|c| (radius * c) as f32)
    };
    let index = |i: u32, j: u32| i % n * (n + 1) + j;
    let squares = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let lower = squares().map(|(i, j)| [index(i, j), index(i + 1, j), index(i + 1, j + 1)]);
    let upper = squares().map(|(i, j)| [index(i, j), index(i + 1, j + 1), index(i, j + 1)]);
    let vertices = (0..n).flat_map(|i| (0..=n).map(move |j| point(i, j))).collect();
    (vertices, lower.chain(upper).collect())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let n_rays: f64 = std::env::args().nth(1).map_or(Ok(1e6), |text| text.parse())?;
    let side = n_rays.sqrt() as usize;
    let (vertices, triangles) = bumpy_sphere(660);
    let scene = Scene::new(TriangleMesh::new(&vertices, &triangles)?)?;
    let slope = |i: usize| 0.9 * i as f64 / (side - 1) as f64 - 0.45;
    let directions: Vec<[f64; 3]> =
        (0..side).flat_map(|j| (0..side).map(move |i| [slope(i), slope(j), -1.0])).collect();
    let origins = vec![[0.0, 0.0, 3.0]; directions.len()];
    let rays = RayBatch::new(&origins[..], &directions[..])?;
    let (mut t, mut primitive) = (vec![0.0; rays.len()], vec![0; rays.len()]);
    let (mut instance, mut uv) = (vec![0; rays.len()], vec![[0.0; 2]; rays.len()]);
    let mut seconds = f64::INFINITY;
    for _ in 0..5 {
        let mut hits =
            HitBatch { t: &mut t, primitive: &mut primitive, instance: Some(&mut instance), uv: Some(&mut uv) };
        let started = Instant::now();
        scene.closest_batch(&rays, &mut hits)?;
        seconds = started.elapsed().as_secs_f64().min(seconds);
    }
    let n_hits = primitive.iter().filter(|id| **id != HitBatch::MISS).count();
    let rate = rays.len() as f64 / seconds / 1e6;
    println!("{} triangles, {} rays, {n_hits} hits: {rate:.2} Mrays/s on one thread", triangles.len(), rays.len());
    Ok(())
}
