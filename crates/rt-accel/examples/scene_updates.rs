//! Times changes of a scene of many small meshes against building it afresh, and its queries before and after.
//!
//! `cargo run -p rt-accel --example scene_updates [MESHES]`

#![allow(clippy::print_stdout, reason = "a program")]

use std::error::Error;
use std::time::Instant;

use rt_accel::{BuildParams, DVec3, GeometryId, Interval, Ray, Scene, SceneBuilder, Transform, TriangleMesh};
use rt_math::random::{hash, unit};

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];

/// Change of a scene.
type Change<'c> = dyn Fn(&mut SceneBuilder<'static>) -> Result<(), Box<dyn Error>> + 'c;

/// Random point in the unit cube.
fn point(seed: u64, index: usize) -> DVec3 {
    DVec3::from([0, 1, 2].map(|axis| unit(hash(&[seed, index as u64, axis]))))
}

/// Small tetrahedron around the origin.
fn vertices(seed: u64, index: usize) -> Vec<[f64; 3]> {
    (0..4).map(|corner| (0.02 * (point(seed, 4 * index + corner) - 0.5)).to_array()).collect()
}

fn mesh(index: usize) -> Result<TriangleMesh<'static>, Box<dyn Error>> {
    Ok(TriangleMesh::new(vertices(1, index), TETRAHEDRON.to_vec())?)
}

/// Shortest of three runs in milliseconds, and the result of the last.
fn timed<T>(mut work: impl FnMut() -> Result<T, Box<dyn Error>>) -> Result<(f64, T), Box<dyn Error>> {
    let (mut best, mut last) = (f64::INFINITY, None);
    for _ in 0..3 {
        let started = Instant::now();
        last = Some(work()?);
        best = best.min(started.elapsed().as_secs_f64() * 1e3);
    }
    last.map(|result| (best, result)).ok_or_else(|| "three runs have a last one".into())
}

/// Millions of closest hits per second.
fn speed(scene: &Scene<'_>) -> Result<f64, Box<dyn Error>> {
    const RAYS: usize = 100_000;
    let (milliseconds, _) = timed(|| {
        let ray = |i: usize| Ray::new(point(2, i), point(3, i) - 0.5);
        Ok((0..RAYS).filter(|&i| scene.closest(&ray(i), Interval::FORWARD).is_some()).count())
    })?;
    Ok(RAYS as f64 / milliseconds * 1e-3)
}

fn main() -> Result<(), Box<dyn Error>> {
    let n: usize = std::env::args().nth(1).map_or(Ok(10_000), |n| n.parse())?;
    let build = || {
        let (mut builder, mut ids) = (SceneBuilder::new(BuildParams::BALANCED), Vec::<GeometryId>::new());
        for index in 0..n {
            ids.push(builder.add(mesh(index)?)?);
            builder.place_at(ids[index], &Transform::translate(point(4, index)))?;
        }
        Ok((builder.build()?, ids))
    };
    let (milliseconds, (scene, ids)) = timed(build)?;
    let per_change = (n / 100).max(1);
    println!("{n} meshes: built in {milliseconds:.2} ms, {:.2} Mrays/s", speed(&scene)?);
    let report = |what: &str, change: &Change<'_>| {
        let (milliseconds, changed) = timed(|| {
            let mut builder = scene.to_builder();
            change(&mut builder)?;
            Ok(builder.build()?)
        })?;
        println!("{what} {per_change}: {milliseconds:.2} ms, then {:.2} Mrays/s", speed(&changed)?);
        Ok::<_, Box<dyn Error>>(())
    };
    report("insert", &|builder| {
        for index in n..n + per_change {
            let id = builder.add(mesh(index)?)?;
            builder.place_at(id, &Transform::translate(point(4, index)))?;
        }
        Ok(())
    })?;
    report("remove", &|builder| (0..per_change).try_for_each(|i| Ok(builder.remove((i * 100) as u32)?)))?;
    report("move", &|builder| {
        let place = |i: usize| Transform::translate(point(5, i));
        (0..per_change).try_for_each(|i| Ok(builder.set_transform((i * 100) as u32, &place(i))?))
    })?;
    report("deform", &|builder| {
        (0..per_change).try_for_each(|i| Ok(builder.set_vertices(ids[i * 100], vertices(6, i))?))
    })
}
