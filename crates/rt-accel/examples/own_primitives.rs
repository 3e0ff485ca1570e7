//! Traces primitives of your own, here discs, with every accelerator, and compares what they cost.
//!
//! `cargo run --release -p rt-accel --example own_primitives`

#![allow(clippy::print_stdout, reason = "an example shows its results")]

use std::error::Error;
use std::time::Instant;

use rt_accel::{Aabb, Accelerator, Bvh, Counters, DVec3, Hit, Interval, Linear, NoProbe, Primitives, Ray, UniformGrid};

/// A flat disc: a centre, a unit normal, and a radius.
struct Disc {
    centre: DVec3,
    normal: DVec3,
    radius: f64,
}

struct Discs(Vec<Disc>);

impl Primitives for Discs {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        let disc = &self.0[index as usize];
        // Along each axis a disc reaches as far as its normal leans away from it.
        let reach = (DVec3::ONE - disc.normal * disc.normal).max(DVec3::ZERO).map(f64::sqrt) * disc.radius;
        Some(Aabb::new(disc.centre - reach, disc.centre + reach))
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let disc = &self.0[index as usize];
        let t = (disc.centre - ray.origin).dot(disc.normal) / ray.direction.dot(disc.normal);
        let is_on_disc = ray.at(t).distance_squared(disc.centre) <= disc.radius * disc.radius;
        (span.contains(t) && is_on_disc).then_some(Hit { t, instance: 0, primitive: index, uv: [0.0; 2] })
    }
}

/// Discs on a spiral around a sphere, facing outward, each a golden angle further than the one before.
fn spiral(count: u32) -> Discs {
    let (cos, sin) = (-0.737_368_878_078_32, 0.675_490_294_261_524);
    let (mut x, mut z) = (1.0, 0.0);
    let disc = |i: u32| {
        let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        (x, z) = (cos * x - sin * z, sin * x + cos * z);
        let normal = DVec3::new(x, 0.0, z).normalize() * (1.0 - y * y).sqrt() + DVec3::Y * y;
        Disc { centre: normal, normal, radius: 1.5 / f64::from(count).sqrt() }
    };
    Discs((0..count).map(disc).collect())
}

/// Traces all rays and reports their sum, so that accelerators can be compared at a glance.
fn trace<A: Accelerator>(name: &str, accelerator: &A, discs: &Discs, rays: &[Ray]) {
    let start = Instant::now();
    let hits = rays.iter().filter_map(|ray| accelerator.closest(discs, ray, Interval::FORWARD, &mut NoProbe));
    let (count, sum) = hits.fold((0, 0.0), |(count, sum), hit| (count + 1, sum + hit.t));
    let seconds = start.elapsed().as_secs_f64();

    // The same once more, counting: a probe that counts costs time, `NoProbe` costs nothing.
    let mut counters = Counters::default();
    for ray in rays {
        accelerator.closest(discs, ray, Interval::FORWARD, &mut counters);
    }
    let tests = counters.total().tests as f64 / rays.len() as f64;
    let speed = rays.len() as f64 / seconds / 1e6;
    println!("{name:12} {speed:8.3} Mrays/s {tests:9.2} tests per ray, {count} hits, sum of t {sum}");
}

fn main() -> Result<(), Box<dyn Error>> {
    let discs = spiral(5000);
    let ray = |i: u32| {
        let at = |k: u32| f64::from(k) / 50.0 - 1.0;
        Ray::new(DVec3::new(at(i % 100), at(i / 100), 3.0), DVec3::new(0.05, -0.02, -1.0))
    };
    let rays: Vec<_> = (0..10_000).map(ray).collect();

    trace("Linear", &Linear::build(&discs)?, &discs, &rays);
    trace("UniformGrid", &UniformGrid::build(&discs)?, &discs, &rays);
    let bvh = Bvh::build(&discs)?;
    trace("Bvh", &bvh, &discs, &rays);
    println!("The tree: {:?}, {} bytes", bvh.build_stats(), bvh.memory());
    Ok(())
}
