//! Closest hits of tinybvh, for `compare.py`.
//!
//! Standard input holds numbers that are separated by white space: the number of triangles, and nine coordinates for each of them.
//! The number of rays follows, and for each ray the origin, the direction, and the largest t. Rays start at t = 0, as tinybvh has no
//! other start. Each line of the output is `t triangle` or `miss`; t counts in lengths of the direction that was given.

#![allow(clippy::print_stdout, reason = "the result of the program")]

use std::error::Error;
use std::io::{self, Read as _};
use std::str::{FromStr, SplitWhitespace};

use tinybvh_rs::{Intersector as _, Ray, bvh};

/// Index of no triangle; tinybvh leaves it alone if a ray hits nothing.
const MISS: u32 = u32::MAX;

fn next<T: FromStr<Err: Error + 'static>>(words: &mut SplitWhitespace<'_>) -> Result<T, Box<dyn Error>> {
    Ok(words.next().ok_or("the input ends early")?.parse()?)
}

fn vector(words: &mut SplitWhitespace<'_>) -> Result<[f32; 3], Box<dyn Error>> {
    Ok([next(words)?, next(words)?, next(words)?])
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::new();
    io::stdin().read_to_string(&mut text)?;
    let mut words = text.split_whitespace();
    let n_triangles: usize = next(&mut words)?;
    let mut corners = Vec::new();
    for _ in 0..3 * n_triangles {
        let [x, y, z] = vector(&mut words)?;
        corners.push([x, y, z, 0.0]);
    }
    let bvh = bvh::BVH::new(corners.as_slice().into()).map_err(|error| error.to_string())?;
    let n_rays: usize = next(&mut words)?;
    for _ in 0..n_rays {
        let (origin, direction) = (vector(&mut words)?, vector(&mut words)?);
        let t_max: f64 = next(&mut words)?;
        // `Ray::new` normalises the direction, so that distances are those of a direction of length 1.
        let mut ray = Ray::new(origin, direction);
        let length = direction.iter().map(|c| f64::from(*c) * f64::from(*c)).sum::<f64>().sqrt();
        ray.hit.t = (t_max * length).min(f64::from(tinybvh_rs::INFINITE)) as f32;
        ray.hit.prim = MISS;
        bvh.intersect(&mut ray);
        match ray.hit.prim {
            MISS => println!("miss"),
            triangle => println!("{:e} {triangle}", f64::from(ray.hit.t) / length),
        }
    }
    Ok(())
}
