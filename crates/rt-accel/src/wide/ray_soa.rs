//! Eight rays as a structure of arrays.

use rt_geometry::{RayStream, StreamArray};
use rt_math::{Aabb, BOUNDS_PADDING, DVec3, FAR_FACTOR, Interval, Ray};

use super::f64x8::{F64x8, PACKET};
use super::simd::Simd;

/// Padding of boxes that lie within padded bounds, relative to their maximum coordinate.
pub(super) const INNER_PAD: f64 = 0.5 * BOUNDS_PADDING;

/// A number of each of eight rays. Not by loops over arrays, which would be cleared first.
macro_rules! by_ray {
    ($simd:expr, $rays:expr, |$ray:pat_param, $span:pat_param| $number:expr) => {{
        let [a, b, c, d, e, f, g, h] = $rays;
        let number = |&($ray, $span): &(Ray, Interval)| $number;
        F64x8::new($simd, [number(a), number(b), number(c), number(d), number(e), number(f), number(g), number(h)])
    }};
}

/// Directions of eight rays.
#[inline(always)]
pub(super) fn directions<S: Simd>(simd: S, rays: &[(Ray, Interval); PACKET]) -> [F64x8<S>; 3] {
    [
        by_ray!(simd, rays, |ray, _| ray.direction.x),
        by_ray!(simd, rays, |ray, _| ray.direction.y),
        by_ray!(simd, rays, |ray, _| ray.direction.z),
    ]
}

/// Eight rays of any directions.
#[derive(Clone, Copy)]
pub(super) struct RaySoa8<S: Simd> {
    pub(super) origin: [F64x8<S>; 3],
    pub(super) direction: [F64x8<S>; 3],
    /// Equals [`SlabRay::inverse`](rt_math::SlabRay), unless it was left out by [`load`](Self::load).
    pub(super) inverse: [F64x8<S>; 3],
    pub(super) min: F64x8<S>,
    pub(super) max: F64x8<S>,
}

impl<S: Simd> RaySoa8<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, rays: &[(Ray, Interval); PACKET]) -> Self {
        let direction = directions(simd, rays);
        Self {
            origin: [
                by_ray!(simd, rays, |ray, _| ray.origin.x),
                by_ray!(simd, rays, |ray, _| ray.origin.y),
                by_ray!(simd, rays, |ray, _| ray.origin.z),
            ],
            direction,
            inverse: inverse(simd, direction),
            min: by_ray!(simd, rays, |_, span| span.min),
            max: by_ray!(simd, rays, |_, span| span.max),
        }
    }

    /// Eight rays of a stream from the index `at` on. Their inverse is needed to cross boxes and triangles.
    #[inline(always)]
    pub(super) fn load(simd: S, rays: &RayStream, at: usize, has_inverse: bool) -> Self {
        let load = |numbers: &StreamArray<f64>| F64x8::new(simd, *numbers.vector(at));
        let [x, y, z] = &rays.direction;
        let direction = [load(x), load(y), load(z)];
        let [x, y, z] = &rays.origin;
        Self {
            origin: [load(x), load(y), load(z)],
            direction,
            inverse: if has_inverse { inverse(simd, direction) } else { direction },
            min: load(&rays.min),
            max: load(&rays.max),
        }
    }

    /// The rays with their inverse.
    #[inline(always)]
    pub(super) fn with_inverse(self, simd: S) -> Self {
        Self { inverse: inverse(simd, self.direction), ..self }
    }

    /// Entry into and exit from boxes whose sides are moved outward by `pad`.
    #[inline(always)]
    pub(super) fn cross_box(&self, simd: S, low: [F64x8<S>; 3], high: [F64x8<S>; 3], pad: F64x8<S>) -> [F64x8<S>; 2] {
        let (mut enter, mut leave) = (F64x8::splat(simd, f64::NEG_INFINITY), F64x8::splat(simd, f64::INFINITY));
        for axis in 0..3 {
            let one = low[axis].sub(simd, pad).sub(simd, self.origin[axis]).mul(simd, self.inverse[axis]);
            let other = high[axis].add(simd, pad).sub(simd, self.origin[axis]).mul(simd, self.inverse[axis]);
            // In this order two NaNs are no constraint. After one the box may seem missed, and the scalar test resolves it.
            enter = one.min(simd, other).max(simd, enter);
            leave = one.max(simd, other).min(simd, leave);
        }
        [enter, leave]
    }

    /// A bit for each ray that may pass a box within its span, at `t` or before: for all that [`Aabb::clip`] accepts. Spans begin at 0 or
    /// later.
    #[inline(always)]
    pub(super) fn may_pass(&self, simd: S, bounds: &Aabb, t: F64x8<S>) -> u32 {
        let side = |side: DVec3| side.to_array().map(|number| F64x8::splat(simd, number));
        let zero = F64x8::splat(simd, 0.0);
        let [enter, leave] = self.cross_box(simd, side(bounds.min), side(bounds.max), zero);
        let enter = enter.max(simd, self.min);
        let leave = leave.mul(simd, F64x8::splat(simd, FAR_FACTOR)).min(simd, self.max).min(simd, t);
        // Rays along a side may have NaN, which is no constraint.
        let [x, y, z] = self.inverse;
        let nothing = x.add(simd, y).add(simd, z).mul(simd, zero);
        enter.le(simd, leave) | (0xff & !nothing.le(simd, zero))
    }

    /// By axis: a bit for each ray with its largest direction component there, with the ties of [`WatertightRay`].
    #[inline(always)]
    pub(super) fn by_steepest_axis(&self, simd: S) -> [u32; 3] {
        let [x, y, z] = [self.direction[0].abs(simd), self.direction[1].abs(simd), self.direction[2].abs(simd)];
        let along_x = y.lt(simd, x) & z.lt(simd, x);
        let along_y = z.lt(simd, y) & !along_x;
        [along_x, along_y, 0xff & !(along_x | along_y)]
    }

    /// By ray: the coordinates turned so that the direction is largest along the last, as in the space of
    /// [`WatertightRay`](rt_geometry::WatertightRay). Also a bit for each ray along x, and one for each other along y.
    #[inline(always)]
    pub(super) fn turned(&self, simd: S) -> (Self, u32, u32) {
        let [x, y, z] = [self.direction[0].abs(simd), self.direction[1].abs(simd), self.direction[2].abs(simd)];
        // Negative where x, or y, is largest.
        let (by_x, by_y) = (y.max(simd, z).sub(simd, x), z.sub(simd, y));
        let turned = Self {
            origin: turn(simd, self.origin, by_x, by_y),
            direction: turn(simd, self.direction, by_x, by_y),
            inverse: turn(simd, self.inverse, by_x, by_y),
            min: self.min,
            max: self.max,
        };
        let along_x = by_x.signs(simd);
        (turned, along_x, by_y.signs(simd) & !along_x)
    }

    /// A bit for each ray that starts at 0 or later, and whose squared length is far from the limits of `f64`.
    #[inline(always)]
    pub(super) fn in_safe_range(&self, simd: S) -> u32 {
        let [x, y, z] = self.direction;
        let squared = x.mul(simd, x).add(simd, y.mul(simd, y)).add(simd, z.mul(simd, z));
        F64x8::splat(simd, 0.0).le(simd, self.min)
            & F64x8::splat(simd, 1e-100).le(simd, squared)
            & squared.lt(simd, F64x8::splat(simd, 1e100))
    }
}

#[inline(always)]
fn inverse<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3]) -> [F64x8<S>; 3] {
    let one = F64x8::splat(simd, 1.0);
    [one.div(simd, x), one.div(simd, y), one.div(simd, z)]
}

/// Cyclic order of the coordinates: y, z, x where `by_x` is negative, otherwise z, x, y where `by_y` is negative.
#[inline(always)]
fn turn<S: Simd>(simd: S, [x, y, z]: [F64x8<S>; 3], by_x: F64x8<S>, by_y: F64x8<S>) -> [F64x8<S>; 3] {
    [
        by_x.select_by_sign(simd, by_y.select_by_sign(simd, x, z), y),
        by_x.select_by_sign(simd, by_y.select_by_sign(simd, y, x), z),
        by_x.select_by_sign(simd, by_y.select_by_sign(simd, z, y), x),
    ]
}

/// Result of intersecting eight rays with one primitive, or with one each.
pub(super) struct PacketHit<S: Simd> {
    /// A bit for each ray that hits.
    pub(super) hit: u32,
    /// A bit for each ray that needs the scalar test; all others miss.
    pub(super) uncertain: u32,
    pub(super) t: F64x8<S>,
    /// See [`Hit::uv`](rt_geometry::Hit).
    pub(super) uv: [F64x8<S>; 2],
}
