//! Sets of rays of each kind.

use rt_accel::Accelerator;
use rt_geometry::{NoProbe, SurfaceInteraction};
use rt_math::{
    Aabb, DVec3, Interval, Ray,
    random::{hash, unit},
};

use super::Surfaces;

#[derive(Debug)]
pub(crate) struct RaySet {
    pub kind: &'static str,
    /// Ask whether anything is hit, not what is hit first.
    pub any: bool,
    pub rays: Vec<(Ray, Interval)>,
}

/// A point that sees the whole box, and how to look at it.
#[derive(Debug)]
struct CameraView {
    eye: DVec3,
    middle: DVec3,
    right: DVec3,
    up: DVec3,
}

impl CameraView {
    fn of(bounds: &Aabb) -> Self {
        let middle = (bounds.min + bounds.max) * 0.5;
        let size = (bounds.max - bounds.min).length();
        let back = DVec3::new(0.4, 0.5, 1.0).normalize();
        let right = DVec3::Y.cross(back).normalize();
        Self {
            eye: middle + back * (1.2 * size),
            middle,
            right: right * (size / 2.0),
            up: back.cross(right) * (size / 2.0),
        }
    }
}

/// Rays from a camera in front of the box, row by row.
pub(crate) fn primary(bounds: &Aabb, count: u32) -> RaySet {
    let view = CameraView::of(bounds);
    let side = count.isqrt().max(1);
    let ray = |index: u32| {
        let [x, y] = [index % side, index / side].map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(side) - 1.0);
        let direction = view.middle + view.right * x - view.up * y - view.eye;
        (Ray::new(view.eye, direction.normalize()), Interval::FORWARD)
    };
    RaySet { kind: "primary", any: false, rays: (0..side * side).map(ray).collect() }
}

/// Rays from the hits of the primary rays to a light above the camera.
pub(crate) fn shadow(bounds: &Aabb, surfaces: &[SurfaceInteraction], count: u32) -> RaySet {
    let view = CameraView::of(bounds);
    let light = view.eye + view.up + view.right;
    let ray = |surface: &SurfaceInteraction| (surface.spawn_shadow_ray(light, 0.0), Interval::SEGMENT);
    RaySet { kind: "shadow", any: true, rays: cycled(surfaces, count).map(|(_, surface)| ray(surface)).collect() }
}

/// Cosine-distributed rays from the hits of the primary rays, towards a random point of the unit sphere around the tip
/// of the normal (Shirley).
pub(crate) fn diffuse(surfaces: &[SurfaceInteraction], eye_rays: &RaySet, count: u32) -> RaySet {
    let Some((first, _)) = eye_rays.rays.first() else {
        return RaySet { kind: "diffuse", any: false, rays: Vec::new() };
    };
    let ray = |(index, surface): (u64, &SurfaceInteraction)| {
        let to_eye = first.origin - surface.point;
        let normal = surface.geometric_normal * to_eye.dot(surface.geometric_normal).signum();
        (surface.spawn_ray((normal + on_sphere(index)).normalize_or(normal), 0.0), Interval::SPAWNED)
    };
    RaySet { kind: "diffuse", any: false, rays: cycled(surfaces, count).map(ray).collect() }
}

/// Rays between random points of the box.
pub(crate) fn random(bounds: &Aabb, count: u32) -> RaySet {
    let point = |index: u64, end: u64| {
        let [x, y, z] = [0, 1, 2].map(|axis| unit(hash(&[index, end, axis])));
        bounds.min + (bounds.max - bounds.min) * DVec3::new(x, y, z)
    };
    let ray = |index| {
        let origin = point(index, 0);
        (Ray::new(origin, (point(index, 1) - origin).normalize_or(DVec3::X)), Interval::FORWARD)
    };
    RaySet { kind: "random", any: false, rays: (0..u64::from(count)).map(ray).collect() }
}

/// Surfaces at what the rays hit.
pub(crate) fn surfaces<P: Surfaces>(
    primitives: &P,
    accelerator: &impl Accelerator,
    rays: &RaySet,
) -> Vec<SurfaceInteraction> {
    let surface = |(ray, span): &(Ray, Interval)| {
        primitives.surface(ray, &accelerator.closest(primitives, ray, *span, &mut NoProbe)?)
    };
    rays.rays.iter().filter_map(surface).collect()
}

/// The surfaces again and again until there are `count`, numbered; none if there are none.
fn cycled(surfaces: &[SurfaceInteraction], count: u32) -> impl Iterator<Item = (u64, &SurfaceInteraction)> {
    (0..u64::from(count)).zip(surfaces.iter().cycle())
}

/// A random point of the unit sphere: a point inside it, found by rejection, moved outwards.
fn on_sphere(index: u64) -> DVec3 {
    let candidate = |attempt: u64| {
        let [x, y, z] = [0, 1, 2].map(|axis| 2.0 * unit(hash(&[index, attempt, axis])) - 1.0);
        DVec3::new(x, y, z)
    };
    let inside = (0..).map(candidate).find(|point| (1e-9..=1.0).contains(&point.length_squared()));
    inside.unwrap_or(DVec3::X).normalize()
}
