//! Kernels of accelerators one by one, for all instruction sets of the processor. These are the test of eight boxes,
//! leaves of triangles and spheres, lists of spheres, and exact tests in `f64`.
//!
//! `cargo bench -p rt-accel --bench kernels` runs all; a filter such as `list` runs some. Rays are prepared anew for each
//! query, as they are in an image, so that the first numbers of a kind hold that as well.

#![allow(missing_docs, reason = "criterion's macros generate public functions")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rt_accel::{
    Aabb, Accelerator, DVec3, Hit, Interval, Linear, NoProbe, PrimitiveGeometry, Primitives, Ray, SlabRay, WideBvh,
    brute_force, wide::SimdLevel,
};
use rt_geometry::{WatertightRay, intersect_triangle};
use rt_math::Vec3;
use rt_math::random::{hash, unit};

const N_RAYS: usize = 1024;

/// Boxes, triangles and spheres with the kernels of this project.
#[derive(Clone, Copy)]
enum Solid {
    Box(Aabb),
    Triangle([Vec3; 3]),
    Sphere(DVec3, f64),
}

struct Solids(Vec<Solid>);

impl Primitives for Solids {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        Some(match self.0[index as usize] {
            Solid::Box(aabb) => aabb,
            Solid::Triangle(vertices) => Aabb::from_points(vertices.map(|vertex| vertex.as_dvec3())),
            Solid::Sphere(centre, radius) => Aabb::new(centre - radius, centre + radius),
        })
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let (t, uv) = match self.0[index as usize] {
            Solid::Box(aabb) => (aabb.clip(&SlabRay::new(ray), span)?.min, [0.0; 2]),
            Solid::Triangle(vertices) => {
                let hit = WatertightRay::new(ray).intersect(vertices.map(|vertex| vertex.as_dvec3()), span)?;
                (hit.t, hit.uv)
            }
            Solid::Sphere(centre, radius) => (sphere(centre, radius, ray, span)?, [0.0; 2]),
        };
        Some(Hit { t, instance: 0, primitive: index, uv })
    }

    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        match self.0[index as usize] {
            Solid::Box(aabb) => PrimitiveGeometry::Box(aabb),
            Solid::Triangle(vertices) => PrimitiveGeometry::ExactTriangle(vertices),
            Solid::Sphere(centre, radius) => PrimitiveGeometry::Sphere(centre, radius),
        }
    }
}

#[inline(always)]
fn sphere(centre: DVec3, radius: f64, ray: &Ray, span: Interval) -> Option<f64> {
    let f = ray.origin - centre;
    let a = ray.direction.length_squared();
    let b = -f.dot(ray.direction);
    let discriminant = radius * radius - (f + ray.direction * (b / a)).length_squared();
    if discriminant < 0.0 {
        return None;
    }
    let q = b + (a * discriminant).sqrt().copysign(b);
    let (t0, t1) = ((f.length_squared() - radius * radius) / q, q / a);
    span.first(t0.min(t1), t0.max(t1))
}

fn point(words: [u64; 2]) -> DVec3 {
    let draw = |axis| unit(hash(&[words[0], words[1], axis])) * 2.0 - 1.0;
    DVec3::new(draw(0), draw(1), draw(2))
}

/// Spheres in a cube, of which a ray passes some ten whatever their number.
fn spheres(count: u64) -> Solids {
    let radius = (2.0 / (count as f64)).sqrt().min(0.3);
    Solids((0..count).map(|i| Solid::Sphere(point([1, i]), radius)).collect())
}

/// Triangles around the origin.
fn triangles(count: u64) -> Solids {
    let triangle = |i| Solid::Triangle([0, 1, 2].map(|vertex| (point([4 + vertex, i]) * 0.7).as_vec3()));
    Solids((0..count).map(triangle).collect())
}

/// Small boxes at the corners of a cube, two to each, so that each corner becomes a leaf.
fn boxes() -> Solids {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 2.0 - 1.0;
    Solids((0..16).map(|i| Solid::Box(Aabb::new(corner(i / 2) - 0.1, corner(i / 2) + 0.1))).collect())
}

/// Rays from around into a cube.
fn rays() -> Vec<Ray> {
    let ray = |i| {
        let origin = point([2, i]).normalize_or(DVec3::X) * 3.0;
        Ray::new(origin, (point([3, i]) - origin).normalize_or(DVec3::X))
    };
    (0..N_RAYS as u64).map(ray).collect()
}

fn levels() -> impl Iterator<Item = SimdLevel> {
    SimdLevel::ALL.iter().copied().filter(|level| level.is_available())
}

/// Times the closest and any hit of all rays, with an accelerator.
fn bench_accelerator<A: Accelerator>(
    criterion: &mut Criterion,
    group: &str,
    id: &str,
    accelerator: &A,
    solids: &Solids,
    unit: u64,
) {
    let closest = |ray: &Ray| accelerator.closest(solids, ray, Interval::FORWARD, &mut NoProbe);
    let occluded = |ray: &Ray| accelerator.occluded(solids, ray, Interval::FORWARD, &mut NoProbe);
    bench_queries(criterion, group, id, closest, occluded, unit);
}

/// Times the closest and any hit of all rays.
fn bench_queries(
    criterion: &mut Criterion,
    group: &str,
    id: &str,
    closest: impl Fn(&Ray) -> Option<Hit>,
    occluded: impl Fn(&Ray) -> bool,
    unit: u64,
) {
    let rays = rays();
    let mut group = criterion.benchmark_group(group);
    group.throughput(Throughput::Elements(unit * N_RAYS as u64));
    group.bench_function(BenchmarkId::new("closest", id), |bencher| {
        bencher.iter(|| rays.iter().filter_map(|ray| closest(black_box(ray))).map(|hit| hit.t).sum::<f64>());
    });
    group.bench_function(BenchmarkId::new("occluded", id), |bencher| {
        bencher.iter(|| rays.iter().filter(|ray| occluded(black_box(ray))).count());
    });
    group.finish();
}

fn lists(criterion: &mut Criterion) {
    for count in [2, 4, 8, 12, 16, 24, 32, 100, 1000] {
        let spheres = spheres(count);
        let closest = |ray: &Ray| brute_force::closest(&spheres, ray, Interval::FORWARD, &mut NoProbe);
        let occluded = |ray: &Ray| brute_force::occluded(&spheres, ray, Interval::FORWARD, &mut NoProbe);
        bench_queries(criterion, "list", &format!("f64/{count}"), closest, occluded, count);
        for level in levels() {
            let list = Linear::build(&spheres).expect("spheres have bounds").with_level(level);
            bench_accelerator(criterion, "list", &format!("{}/{count}", level.name()), &list, &spheres, count);
        }
        let tree = WideBvh::build(&spheres).expect("spheres have bounds");
        bench_accelerator(criterion, "list", &format!("tree/{count}"), &tree, &spheres, count);
    }
}

/// One node that is missed; one node and a leaf of so many.
fn nodes_and_leaves(criterion: &mut Criterion) {
    let cases = [("node", boxes()), ("leaf of triangles", triangles(4)), ("leaf of spheres", spheres(4))];
    for (name, solids) in cases {
        for level in levels() {
            let tree = WideBvh::build(&solids).expect("all have bounds").with_level(level);
            bench_accelerator(criterion, name, level.name(), &tree, &solids, 1);
        }
    }
}

/// Exact test with given vertices.
fn decisions(criterion: &mut Criterion) {
    let rays = rays();
    let vertices = [DVec3::new(-1.0, -1.0, 0.1), DVec3::new(1.0, -0.9, 0.0), DVec3::new(0.0, 1.0, -0.1)];
    let mut group = criterion.benchmark_group("decision");
    group.throughput(Throughput::Elements(N_RAYS as u64));
    group.bench_function("triangle", |bencher| {
        let intersect_primitive = |ray: &Ray| {
            let slab_ray = SlabRay::new(black_box(ray));
            intersect_triangle(vertices, 0, &slab_ray, &WatertightRay::new(ray), Interval::FORWARD)
        };
        bencher.iter(|| rays.iter().filter_map(intersect_primitive).map(|hit| hit.t).sum::<f64>());
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .measurement_time(Duration::from_millis(500))
        .warm_up_time(Duration::from_millis(200))
        .sample_size(20);
    targets = lists, nodes_and_leaves, decisions
}
criterion_main!(benches);
