//! Sets of primitives, spans and rays that break accelerators which were only tried on pleasant ones.

mod rays;
mod scenes;
mod validation;

use crate::soup::Solid;
use rt_accel::{Aabb, DVec3, Interval, Ray};
use rt_tests::Draw;

const FORWARD: Interval = Interval::FORWARD;

fn unit_box(corner: DVec3) -> Solid {
    Solid::Box(Aabb::new(corner, corner + 1.0))
}

fn down(x: f64, z: f64) -> Ray {
    Ray::new(DVec3::new(x, 10.0, z), DVec3::NEG_Y)
}

/// Rays from a sphere around the box to random points of it.
fn rays_at(target: &Aabb, count: usize) -> Vec<Ray> {
    let mut draw = Draw::new(9);
    let radius = target.extent().length();
    (0..count)
        .map(|_| {
            let origin = target.centre() + draw.point().normalize_or(DVec3::X) * radius;
            let point = target.centre() + draw.point() * 0.5 * target.extent();
            Ray::new(origin, point - origin)
        })
        .collect()
}

fn exp2(exponent: i32) -> f64 {
    rt_math::transcendental::exp2(f64::from(exponent))
}
