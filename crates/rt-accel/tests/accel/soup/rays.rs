//! Rays that look for the seams.

use rt_accel::{Aabb, DVec3, Interval, NoProbe, Ray, SphereKernel, brute_force};

use super::{Solid, Soup};
use rt_tests::{Draw, span_at};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Query {
    pub(crate) ray: Ray,
    pub(crate) span: Interval,
}

/// A ray from and to places where rounding matters: vertices, edges, corners, silhouettes, faces, surfaces. It may be
/// along an axis, or have components that are zero of either sign, tiny, or one step away from something special.
pub(crate) fn adversarial(soup: &Soup, world: &Aabb, draw: &mut Draw) -> Query {
    let origin = origin(soup, world, draw);
    let target = special_point(soup, draw);
    let mut direction = target - origin;
    if draw.one_in(4) {
        direction *= draw.pick(&[1e-3, 1e3, 1e-12, 1e12, -1.0, 1e-100, 1e100]);
    }
    if draw.one_in(3) {
        for axis in 0..3 {
            if draw.one_in(2) {
                direction[axis] = draw.pick(&[0.0, -0.0, 5e-324, -5e-324, 1e-310, -1e-310, 1e-200, 1e-30, -1e-17]);
            }
        }
    }
    if draw.one_in(3) {
        let axis = draw.below(3);
        direction[axis] = draw.neighbour(direction[axis]);
    }
    let ray = Ray::new(origin, direction);
    let hit = || brute_force::closest(soup, &ray, Interval::FORWARD, &mut NoProbe).map_or(1.0, |hit| hit.t);
    Query { ray, span: span_at(hit, draw) }
}

fn origin(soup: &Soup, world: &Aabb, draw: &mut Draw) -> DVec3 {
    let size = world.extent().max_element();
    let mut origin = match draw.below(8) {
        0 | 1 => world.centre() + draw.point() * size * 2.0,
        2 => world.centre() + draw.point() * size * 1e6,
        3 => special_point(soup, draw) + draw.point() * size * 1e-6,
        4 => special_point(soup, draw),
        5 => DVec3::new(world.min.x, draw.point().y * size, special_point(soup, draw).z),
        _ => world.min + draw.point().abs() * world.extent(),
    };
    if draw.one_in(3) {
        // In a plane of something, or one step off it.
        let axis = draw.below(3);
        origin[axis] = special_point(soup, draw)[axis];
        if draw.one_in(2) {
            origin[axis] = draw.neighbour(origin[axis]);
        }
    }
    origin
}

/// A vertex, a point on an edge, a corner of (padded) bounds, or a silhouette point.
fn special_point(soup: &Soup, draw: &mut Draw) -> DVec3 {
    let solid = soup.0[draw.below(soup.0.len())];
    let Some(bounds) = solid.bounds() else { return draw.point() };
    match (solid, draw.below(6)) {
        (Solid::Triangle(vertices), 0 | 1) => draw.pick(&vertices),
        (Solid::Facet(vertices), 0 | 1) => draw.pick(&vertices).as_dvec3(),
        (Solid::Facet([a, b, _]), 2) => a.as_dvec3().lerp(b.as_dvec3(), draw.pick(&[0.25, 0.5, 0.3])),
        (Solid::Triangle([a, b, _]), 2) => a.lerp(b, draw.pick(&[0.25, 0.5, 0.3])),
        (Solid::Sphere { centre, radius } | Solid::Round(SphereKernel { centre, radius }), 0 | 1) => {
            centre + draw.point().normalize_or(DVec3::X) * radius
        }
        (Solid::Sphere { centre, radius } | Solid::Round(SphereKernel { centre, radius }), 2) => {
            centre + draw.pick(&DVec3::AXES) * radius
        }
        (_, 3) => draw.pick(&bounds.padded().corners()),
        (_, 4) => {
            let (a, b) = (draw.pick(&bounds.corners()), draw.pick(&bounds.corners()));
            a.lerp(b, draw.pick(&[0.0, 0.5, 0.3]))
        }
        _ => draw.pick(&bounds.corners()),
    }
}
