//! Build and traversal of some accelerators: random spheres in a cube, rays between random points around it.
//!
//! `cargo bench -p rt-accel` runs all; a filter such as `closest/bvh` runs some.

#![allow(missing_docs, reason = "criterion's macros generate public functions")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rt_accel::{Accelerator, Bvh, DVec3, Interval, Linear, NoProbe, Ray, UniformGrid};
use rt_geometry::{Sphere, Spheres};
use rt_math::random::{hash, unit};

fn point(words: [u64; 2]) -> DVec3 {
    let draw = |axis| unit(hash(&[words[0], words[1], axis])) * 2.0 - 1.0;
    DVec3::new(draw(0), draw(1), draw(2))
}

fn spheres(count: u64) -> Spheres {
    let radius = 0.35 / rt_math::transcendental::cbrt(count as f64);
    Spheres::new((0..count).map(|i| Sphere::new(point([1, i]), radius).expect("a sphere")).collect())
}

fn rays() -> Vec<Ray> {
    (0..4096)
        .map(|i| {
            let origin = point([2, i]).normalize_or(DVec3::X) * 3.0;
            Ray::new(origin, point([3, i]) - origin)
        })
        .collect()
}

fn bench_queries<A: Accelerator>(criterion: &mut Criterion, name: &str, accelerator: &A, spheres: &Spheres) {
    let rays = rays();
    let count = spheres.as_slice().len();
    for query in ["closest", "occluded"] {
        let mut group = criterion.benchmark_group(query);
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(BenchmarkId::new(name, count), |bencher| {
            bencher.iter(|| {
                let mut sum = 0.0;
                for ray in &rays {
                    if query == "closest" {
                        let hit = accelerator.closest(spheres, black_box(ray), Interval::FORWARD, &mut NoProbe);
                        sum += hit.map_or(0.0, |hit| hit.t);
                    } else if accelerator.occluded(spheres, black_box(ray), Interval::SEGMENT, &mut NoProbe) {
                        sum += 1.0;
                    }
                }
                sum
            });
        });
        group.finish();
    }
}

fn accelerators(criterion: &mut Criterion) {
    for count in [10, 1000, 100_000] {
        let spheres = spheres(count);
        if count <= 1000 {
            bench_queries(criterion, "linear", &Linear::build(&spheres).expect("spheres have bounds"), &spheres);
        }
        bench_queries(criterion, "grid", &UniformGrid::build(&spheres).expect("spheres have bounds"), &spheres);
        bench_queries(criterion, "bvh", &Bvh::build(&spheres).expect("spheres have bounds"), &spheres);
    }
    let mut group = criterion.benchmark_group("build");
    group.sample_size(10);
    for count in [1000, 100_000, 1_000_000] {
        let spheres = spheres(count);
        group.throughput(Throughput::Elements(count));
        group.bench_function(BenchmarkId::new("grid", count), |b| b.iter(|| UniformGrid::build(&spheres)));
        group.bench_function(BenchmarkId::new("bvh", count), |b| b.iter(|| Bvh::build(&spheres)));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(500));
    targets = accelerators
}
criterion_main!(benches);
