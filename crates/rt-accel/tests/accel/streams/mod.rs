//! Streams give the results of single queries: for coherent bundles, incoherent rays and mixes, in small and large trees.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::soup::rays::{Query, adversarial};
use crate::soup::{Solid, Soup};
use rt_accel::wide::SimdLevel;
use rt_accel::{
    Aabb, DVec3, Hit, HitStream, Interval, PacketKernel, PrimitiveGeometry, Primitives, Ray, RayStream, STREAM_CAPACITY,
};
use rt_tests::Draw;

/// Closest hits of an accelerator or a small set, which share no trait: `closest!(accelerator, primitives, rays, probe)`.
macro_rules! closest {
    ($accel:expr, $primitives:expr, $rays:expr, $probe:expr) => {
        crate::streams::closest($rays, |rays, hits| $accel.closest_stream($primitives, rays, hits, $probe))
    };
}

/// Version of `closest` for any hits.
macro_rules! occluded {
    ($accel:expr, $primitives:expr, $rays:expr, $probe:expr) => {
        crate::streams::occluded($rays, |rays, occluded| $accel.occluded_stream($primitives, rays, occluded, $probe))
    };
}

mod instances;
mod small_sets;
mod small_trees;
mod trees;

/// Counts scalar tests.
struct Counting<'a>(&'a Soup, AtomicU32);

impl Primitives for Counting<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.0.bounds(index)
    }
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.intersect(index, ray, span)
    }
    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        self.0.geometry(index)
    }
    fn packet_kernel(&self, index: u32) -> PacketKernel {
        self.0.packet_kernel(index)
    }
}

/// Rays in bundles of 1 to 20, or of 100 and more: neighbours of one ray, with the same origin or nearby ones.
fn bundles(soup: &Soup, n_rays: usize, draw: &mut Draw) -> Vec<(Ray, Interval)> {
    let world = Aabb::from_points(soup.0.iter().filter_map(Solid::bounds).flat_map(|bounds| [bounds.min, bounds.max]));
    let size = world.extent().max_element();
    let mut rays = Vec::new();
    while rays.len() < n_rays {
        let Query { ray, span } = if draw.one_in(2) {
            adversarial(soup, &world, draw)
        } else {
            let origin = world.centre() + draw.point() * size;
            Query {
                ray: Ray::new(origin, world.centre() + draw.point() * size * 0.4 - origin),
                span: Interval::FORWARD,
            }
        };
        let spread = draw.pick(&[0.0, 1e-9, 1e-3, 0.05]);
        // In proportion to each component, or to the maximum, so that signs change.
        let around = if draw.one_in(2) { ray.direction } else { DVec3::splat(ray.direction.abs().max_element()) };
        let width = if draw.one_in(2) { size * draw.pick(&[0.0, 1e-9, 0.01]) } else { 0.0 };
        let n = if draw.one_in(8) { 100 + draw.below(200) } else { 1 + draw.below(20) };
        for _ in 0..n {
            let jitter = draw.point() * spread;
            let (origin, direction) = (ray.origin + draw.point() * width, ray.direction + around * jitter);
            rays.push((Ray { origin, direction, ..ray }, span));
        }
    }
    rays.truncate(n_rays);
    rays
}

pub(crate) fn closest(rays: &[(Ray, Interval)], mut trace: impl FnMut(&RayStream, &mut HitStream)) -> Vec<Option<Hit>> {
    let mut hits = HitStream::default();
    let mut all = Vec::new();
    for rays in rays.chunks(STREAM_CAPACITY) {
        trace(&stream_of(rays), &mut hits);
        all.extend((0..rays.len()).map(|at| hits.get(at)));
    }
    all
}

pub(crate) fn occluded(rays: &[(Ray, Interval)], mut trace: impl FnMut(&RayStream, &mut [bool])) -> Vec<bool> {
    let mut all = Vec::new();
    for rays in rays.chunks(STREAM_CAPACITY) {
        let mut occluded = vec![true; rays.len() + 9];
        trace(&stream_of(rays), &mut occluded);
        let unused = occluded.split_off(rays.len());
        assert!(unused.iter().all(|occluded| *occluded), "entries beyond the stream are not changed");
        all.extend(occluded);
    }
    all
}

/// Rays as a stream that held others before: numbers behind the last ray have no meaning.
pub(crate) fn stream_of(rays: &[(Ray, Interval)]) -> RayStream {
    let mut stream = RayStream::default();
    let others = [f64::NAN, 1e300, -0.5].map(|number| Ray::new(DVec3::splat(number), DVec3::new(-number, 1.0, number)));
    others.iter().cycle().take(STREAM_CAPACITY).for_each(|other| stream.push(other, Interval::FORWARD));
    stream.clear();
    rays.iter().for_each(|(ray, span)| stream.push(ray, *span));
    stream
}

fn key(hit: Option<Hit>) -> Option<(u64, u32, u32, [u64; 2])> {
    hit.map(|hit| (hit.t.to_bits(), hit.instance, hit.primitive, hit.uv.map(f64::to_bits)))
}

fn levels() -> impl Iterator<Item = SimdLevel> {
    SimdLevel::ALL.iter().copied().filter(|level| level.is_available())
}

/// Replaces some rays and spans by ones outside the range of the filters.
fn with_odd_ones(mut rays: Vec<(Ray, Interval)>, draw: &mut Draw) -> Vec<(Ray, Interval)> {
    let odd = [
        Ray::new(DVec3::splat(1e300), DVec3::NEG_ONE),
        Ray::new(DVec3::ZERO, DVec3::ZERO),
        Ray::new(DVec3::X * 3.0, DVec3::NEG_X * 1e-300),
        Ray::new(DVec3::X * 3.0, DVec3::NEG_X * 1e200),
        Ray::new(DVec3::splat(f64::NAN), DVec3::NEG_Y),
        Ray::new(DVec3::X, DVec3::new(0.0, f64::NEG_INFINITY, 0.0)),
    ];
    let numbers = [f64::NAN, f64::NEG_INFINITY, -1.0, -0.0, 0.0, f64::MIN_POSITIVE, 1.0, 5.0, f64::INFINITY];
    for (ray, span) in &mut rays {
        if draw.one_in(40) {
            *ray = draw.pick(&odd);
        }
        if draw.one_in(10) {
            *span = Interval::new(draw.pick(&numbers), draw.pick(&numbers));
        }
    }
    rays
}
