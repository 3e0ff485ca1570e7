//! Rays that look for the seams.

use rt_accel::{Aabb, DVec3, Interval, NoProbe, Ray, SphereKernel, brute_force};

use super::draw::Draw;
use super::{Solid, Soup};

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
        direction[axis] = neighbour(direction[axis], draw);
    }
    let ray = Ray::new(origin, direction);
    Query { ray, span: span(soup, &ray, draw) }
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
            origin[axis] = neighbour(origin[axis], draw);
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

/// Mostly everything in front; sometimes a piece, the hit itself, or a span that ends at the hit or next to it.
fn span(soup: &Soup, ray: &Ray, draw: &mut Draw) -> Interval {
    let hit = |span| brute_force::closest(soup, ray, span, &mut NoProbe).map_or(1.0, |hit| hit.t);
    let forward = Interval::FORWARD;
    match draw.below(12) {
        0 => Interval::new(draw.between(0.0, 1.0), draw.between(0.5, 2.0)),
        1 => Interval::new(hit(forward), hit(forward)),
        2 => Interval::new(0.0, hit(forward)),
        3 => Interval::new(0.0, hit(forward).next_down()),
        4 => Interval::new(hit(forward).next_up(), f64::INFINITY),
        5 => Interval::new(-2.0, 2.0),
        6 => Interval::new(0.0, 0.0),
        7 => Interval::SEGMENT,
        _ => forward,
    }
}

fn neighbour(x: f64, draw: &mut Draw) -> f64 {
    match draw.below(4) {
        0 => x.next_up(),
        1 => x.next_down(),
        2 => x.next_up().next_up(),
        _ => x,
    }
}
