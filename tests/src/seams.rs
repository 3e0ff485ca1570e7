//! Rays that look for the seams.

use crate::Draw;
use rt_geometry::Primitives;
use rt_math::{Aabb, DVec3, Interval, Ray};

/// Pairs of rays per primitive that are looked at for grazing ones.
const PROBES: usize = 6;
/// Enough to halve the way between any two numbers of `f64` until they are neighbours.
const HALVINGS: usize = 64;

/// Places and rays where rounding decides, found by looking: on surfaces, at corners of boxes, and where a hit turns
/// into a miss.
#[derive(Clone, Debug)]
pub struct Seams {
    around: Aabb,
    points: Vec<DVec3>,
    /// Origin and aim of rays that pass within rounding of the edge or silhouette of something.
    grazing: Vec<[DVec3; 2]>,
}

impl Seams {
    /// The seams of a set as it is met within the box `around`.
    pub fn of<P: Primitives>(primitives: &P, around: Aabb, draw: &mut Draw) -> Self {
        let mut seams = Self { around, points: around.corners().to_vec(), grazing: Vec::new() };
        for index in 0..primitives.len() as u32 {
            let target = primitives.bounds(index).unwrap_or(around);
            seams.points.extend(target.corners());
            seams.points.extend(target.padded().corners());
            for _ in 0..PROBES {
                seams.probe(primitives, index, &target, draw);
            }
        }
        seams
    }

    /// With more points to aim at and start from, such as vertices.
    pub fn including(mut self, points: impl IntoIterator<Item = DVec3>) -> Self {
        self.points.extend(points);
        self
    }

    /// Looks at two points of the target from one origin, and for the border between them if only one is a hit.
    fn probe<P: Primitives>(&mut self, primitives: &P, index: u32, target: &Aabb, draw: &mut Draw) {
        let origin = self.around.centre() + draw.point() * self.around.extent();
        let hit = |aim: DVec3| {
            let ray = Ray::new(origin, aim - origin);
            primitives.intersect(index, &ray, Interval::FORWARD).map(|hit| ray.at(hit.t))
        };
        let [mut inside, mut outside] = [(); 2].map(|()| target.centre() + draw.point() * target.extent() * 0.6);
        let (first, second) = (hit(inside), hit(outside));
        self.points.extend(first.into_iter().chain(second));
        if first.is_some() == second.is_some() {
            return;
        }
        if second.is_some() {
            (inside, outside) = (outside, inside);
        }
        for _ in 0..HALVINGS {
            let middle = inside.midpoint(outside);
            *(if hit(middle).is_some() { &mut inside } else { &mut outside }) = middle;
        }
        self.grazing.extend([[origin, inside], [origin, outside]]);
        self.points.push(inside);
    }

    /// A ray from somewhere around to somewhere within.
    pub fn random(&self, draw: &mut Draw) -> Ray {
        let (centre, extent) = (self.around.centre(), self.around.extent());
        let origin = centre + draw.point() * extent;
        Ray::new(origin, centre + draw.point() * extent * 0.5 - origin)
    }

    /// A ray between positions where rounding matters, or along an axis. Components may be zero of either sign, tiny,
    /// or one step away from a special number.
    pub fn adversarial(&self, draw: &mut Draw) -> Ray {
        let [origin, aim] = if !self.grazing.is_empty() && draw.one_in(3) {
            self.grazing[draw.below(self.grazing.len())]
        } else {
            [self.origin(draw), self.point(draw)]
        };
        let mut direction = aim - origin;
        if draw.one_in(4) {
            direction *= draw.pick(&[1e-3, 1e3, 1e-12, 1e12, -1.0, 1e-100, 1e100]);
        }
        if draw.one_in(4) {
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
        Ray::new(origin, direction)
    }

    fn point(&self, draw: &mut Draw) -> DVec3 {
        self.points[draw.below(self.points.len())]
    }

    fn origin(&self, draw: &mut Draw) -> DVec3 {
        let (centre, extent) = (self.around.centre(), self.around.extent());
        let size = extent.max_element();
        let mut origin = match draw.below(8) {
            0 | 1 => centre + draw.point() * size * 2.0,
            2 => centre + draw.point() * size * 1e6,
            3 => self.point(draw) + draw.point() * size * 1e-6,
            4 => self.point(draw),
            _ => centre + draw.point() * extent * 0.5,
        };
        if draw.one_in(3) {
            // In a plane of something, or one step off it.
            let axis = draw.below(3);
            let coordinate = self.point(draw)[axis];
            origin[axis] = draw.neighbour(coordinate);
        }
        origin
    }
}

/// A span for a ray whose closest hit is at `t()`. Mostly it is everything in front; sometimes a piece, the hit itself,
/// or a span that ends at the hit or next to it.
pub fn span_at(t: impl FnOnce() -> f64, draw: &mut Draw) -> Interval {
    match draw.below(12) {
        0 => Interval::new(draw.between(0.0, 1.0), draw.between(0.5, 2.0)),
        1 => {
            let t = t();
            Interval::new(t, t)
        }
        2 => Interval::new(0.0, t()),
        3 => Interval::new(0.0, t().next_down()),
        4 => Interval::new(t().next_up(), f64::INFINITY),
        5 => Interval::new(-2.0, 2.0),
        6 => Interval::new(0.0, 0.0),
        7 => Interval::SEGMENT,
        _ => Interval::FORWARD,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ShapeKind, ShapeSet};
    use rt_math::Transform;

    #[test]
    fn grazing_rays_hit_and_miss_side_by_side() {
        let mut draw = Draw::new(5);
        let set = ShapeSet::scattered(ShapeKind::ALL, 60, &Transform::IDENTITY, &mut draw);
        let seams = Seams::of(&set, Aabb::new(DVec3::splat(-1.5), DVec3::splat(1.5)), &mut draw);
        assert!(seams.grazing.len() > 60, "{}", seams.grazing.len());
        let differing = seams.grazing.chunks(2).filter(|pair| {
            let hits = |[origin, aim]: [DVec3; 2]| {
                let ray = Ray::new(origin, aim - origin);
                (0..60u32).map(|index| set.intersect(index, &ray, Interval::FORWARD).is_some()).collect::<Vec<_>>()
            };
            assert!((pair[0][1] - pair[1][1]).abs().max_element() < 1e-14);
            hits(pair[0]) != hits(pair[1])
        });
        assert_eq!(differing.count(), seams.grazing.len() / 2);
    }
}
