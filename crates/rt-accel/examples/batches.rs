//! Rays per second of batches in the caller's arrays, on one thread, from the arrays of `bindings/python/examples/speed.py`.
//!
//! `speed.py --rust PROGRAM` runs it on the mesh and the rays of the other programs. By hand, with `speed.py --keep FOLDER`:
//! `cargo run --release -p rt-accel --example batches -- closest FOLDER primary`. Queries are `closest` and `occluded`. The
//! output is JSON: seconds of the processor and number of hits for each kind of rays.

#![allow(clippy::print_stdout, reason = "the result of the program")]

use std::path::Path;
use std::time::Instant;
use std::{env, fs};

use rt_accel::{HitBatch, RayBatch, Scene, TriangleMesh};

type Failure = Box<dyn std::error::Error>;

/// Calls of which the fastest counts.
const CALLS: usize = 2;

/// Rows of three numbers from a file of numpy, whose type is `descr`.
///
/// Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>, version 1.
fn rows<T, const BYTES: usize>(path: &Path, descr: &str, number: fn([u8; BYTES]) -> T) -> Result<Vec<[T; 3]>, Failure> {
    let bytes = fs::read(path)?;
    let wrong = || format!("{} is not an array of {descr} with three columns in C order", path.display());
    let [b'\x93', b'N', b'U', b'M', b'P', b'Y', 1, 0, low, high, rest @ ..] = &bytes[..] else {
        return Err(wrong().into());
    };
    let (header, numbers) = rest.split_at_checked(u16::from_le_bytes([*low, *high]).into()).ok_or_else(wrong)?;
    let header = str::from_utf8(header)?;
    let is_right = [&format!("'descr': '{descr}'"), "'fortran_order': False", ", 3)"].map(|part| header.contains(part));
    if is_right != [true; 3] || numbers.len() % (3 * BYTES) != 0 {
        return Err(wrong().into());
    }
    let numbers = numbers.as_chunks::<BYTES>().0.as_chunks::<3>().0;
    Ok(numbers.iter().map(|row| row.map(number)).collect())
}

/// Seconds of the processor that this thread used, or of the clock where the system does not tell.
fn seconds(start: Instant) -> f64 {
    let statistics = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let used = statistics.split(' ').next().and_then(|nanoseconds| nanoseconds.parse::<f64>().ok());
    used.map_or_else(|| start.elapsed().as_secs_f64(), |nanoseconds| nanoseconds * 1e-9)
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [query, folder, kinds @ ..] = &arguments[..] else {
        return Err("usage: batches closest|occluded FOLDER KIND...".into());
    };
    let folder = Path::new(folder);
    let vertices = rows(&folder.join("vertices.npy"), "<f4", f32::from_le_bytes)?;
    let triangles = rows(&folder.join("faces.npy"), "<u4", u32::from_le_bytes)?;
    let scene = Scene::new(TriangleMesh::new(&vertices, &triangles)?)?;
    let mut results = Vec::new();
    for kind in kinds {
        let origins = rows(&folder.join(format!("{kind}.origins.npy")), "<f8", f64::from_le_bytes)?;
        let directions = rows(&folder.join(format!("{kind}.directions.npy")), "<f8", f64::from_le_bytes)?;
        let (best, n_hits) = measure(&scene, &RayBatch::new(&origins[..], &directions[..])?, query)?;
        results.push(format!("\"{kind}\": {{\"seconds\": {best}, \"hits\": {n_hits}}}"));
    }
    println!("{{{}}}", results.join(", "));
    Ok(())
}

/// Seconds of the fastest call, and the number of rays that hit.
fn measure(scene: &Scene<'_>, rays: &RayBatch<'_>, query: &str) -> Result<(f64, usize), Failure> {
    let n = rays.len();
    let start = Instant::now();
    let (mut best, mut n_hits) = (f64::INFINITY, 0);
    for _ in 0..CALLS {
        let before = seconds(start);
        match query {
            "closest" => {
                let (mut t, mut primitive) = (vec![0.0; n], vec![0; n]);
                let (mut instance, mut uv) = (vec![0; n], vec![[0.0; 2]; n]);
                let (instance, uv) = (Some(&mut instance[..]), Some(&mut uv[..]));
                scene.closest_batch(rays, &mut HitBatch { t: &mut t, primitive: &mut primitive, instance, uv })?;
                best = (seconds(start) - before).min(best);
                n_hits = primitive.iter().filter(|id| **id != HitBatch::MISS).count();
            }
            "occluded" => {
                let mut occluded = vec![false; n];
                scene.occluded_batch(rays, &mut occluded)?;
                best = (seconds(start) - before).min(best);
                n_hits = occluded.iter().filter(|is_occluded| **is_occluded).count();
            }
            _ => return Err(format!("{query} is not one of closest, occluded").into()),
        }
    }
    Ok((best, n_hits))
}
