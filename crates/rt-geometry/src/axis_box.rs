//! Axis-aligned boxes as shapes.

use crate::error::{ShapeError, check_coordinates};
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::float::gamma;
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A closed solid box with faces along the axes; its normal points outwards. It may be flat.
///
/// Each face has texture coordinates from 0 to 1, upright and unmirrored from outside: `v` runs along +y on the four
/// sides, along −z on the top (+y) and along +z on the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisBox {
    bounds: Aabb,
}

/// One of the six faces, numbered as in the `uv[0]` of a hit: twice the axis, plus one for the greater side.
#[derive(Clone, Copy)]
struct Face {
    axis: usize,
    greater: bool,
}

impl Face {
    fn number(self) -> f64 {
        (2 * self.axis + usize::from(self.greater)) as f64
    }

    fn from_number(number: f64) -> Self {
        let number = number as usize;
        Self { axis: (number / 2).min(2), greater: number % 2 == 1 }
    }
}

impl AxisBox {
    /// The box from `min` to `max`.
    ///
    /// # Errors
    /// If `min` exceeds `max` on an axis or a number is not finite.
    pub fn new(min: DVec3, max: DVec3) -> Result<Self, ShapeError> {
        check_coordinates([min, max])?;
        match (0..3).find(|&axis| min[axis] > max[axis]) {
            Some(axis) => Err(ShapeError::InvertedBox { axis, min: min[axis], max: max[axis] }),
            None => Ok(Self { bounds: Aabb::new(min, max) }),
        }
    }

    /// The extent of the box.
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Where the ray enters the box, or where it leaves it if the entry is before `span`. `None` on a miss, and for
    /// rays without a direction. At an edge the face of the lowest axis wins.
    ///
    /// The slab test (Williams et al. 2005) without any widening: two boxes that share a face compute the same `t` for
    /// it, so no ray slips between them.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let inverse = ray.direction.recip();
        let nowhere = Face { axis: 0, greater: false };
        let (mut enter, mut enter_face) = (f64::NEG_INFINITY, nowhere);
        let (mut leave, mut leave_face) = (f64::INFINITY, nowhere);
        for axis in 0..3 {
            let low = (self.bounds.min[axis] - ray.origin[axis]) * inverse[axis];
            let high = (self.bounds.max[axis] - ray.origin[axis]) * inverse[axis];
            let backwards = inverse[axis].is_sign_negative();
            let (near, far) = if backwards { (high, low) } else { (low, high) };
            // A ray in the plane of a face gives NaN, which fails both comparisons: the box is closed.
            if near > enter {
                (enter, enter_face) = (near, Face { axis, greater: backwards });
            }
            if far < leave {
                (leave, leave_face) = (far, Face { axis, greater: !backwards });
            }
        }
        if enter > leave {
            return None;
        }
        let t = span.first(enter, leave)?;
        // A NaN in the ray must miss, but in the loop it looks like a ray within a face.
        if !t.is_finite() || ray.origin.is_nan() || ray.direction.is_nan() {
            return None;
        }
        let face = if t == enter { enter_face } else { leave_face };
        Some(ShapeHit { t, uv: [face.number(), 0.0] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect). The point lies exactly on its face.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        let Aabb { min, max } = self.bounds;
        let Face { axis, greater } = Face::from_number(hit.uv[0]);
        let mut point = ray.at(hit.t).max(min).min(max);
        point[axis] = if greater { max[axis] } else { min[axis] };
        let mut normal = DVec3::ZERO;
        normal[axis] = if greater { 1.0 } else { -1.0 };
        // The point is exact across its face. The bound makes room for a ray that leaves a face at coordinate 0,
        // where the next number is too near to tell apart.
        let point_error = DVec3::splat(gamma(3) * self.bounds.max_abs());
        let uv = if needs.uv { self.face_uv(point, axis, greater) } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, normal, uv)
    }

    fn face_uv(&self, point: DVec3, axis: usize, greater: bool) -> [f64; 2] {
        let along = |axis: usize, forwards: bool| {
            let (min, max) = (self.bounds.min[axis], self.bounds.max[axis]);
            let fraction = if max > min { (point[axis] - min) / (max - min) } else { 0.0 };
            if forwards { fraction } else { 1.0 - fraction }
        };
        match axis {
            0 => [along(2, !greater), along(1, true)],
            1 => [along(0, true), along(2, !greater)],
            _ => [along(0, greater), along(1, true)],
        }
    }
}
