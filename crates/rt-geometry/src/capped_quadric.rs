//! Cylinders, cones and frusta: a curved side between two heights, with or without caps.

use crate::disk::{cap_uv, on_disk};
use crate::error::{ShapeError, check_coordinates, check_length, check_radius};
use crate::quadric_side::{Inside, QuadricSide, azimuth};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::{Aabb, DVec3, Interval, Ray};

#[cfg(test)]
mod tests;

/// Cylinder, cone or frustum around the y axis, from a bottom to a top: a closed solid with caps, or an open surface
/// without. Its normal points outwards, away from the axis on the side; at an apex it is opposite to the incident ray.
///
/// On the side, the texture coordinate `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½. `v`
/// runs from 0 at the bottom to 1 at the top. On the caps they run from 0 to 1 over the square around the disk, upright
/// and unmirrored from outside. `v` runs along −z on the top and along +z on the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CappedQuadric {
    side: QuadricSide,
    bottom: f64,
    top: f64,
    caps: bool,
}

/// QuadricFace of a hit, stored in its `uv[0]`.
#[derive(Clone, Copy)]
enum QuadricFace {
    Side = 0,
    Bottom = 1,
    Top = 2,
}

impl QuadricFace {
    fn from_number(number: f64) -> Self {
        match number as u8 {
            1 => Self::Bottom,
            2 => Self::Top,
            _ => Self::Side,
        }
    }
}

impl CappedQuadric {
    /// The cylinder x² + z² ≤ radius² with `bottom` ≤ y ≤ `top`; only its side if it has no `caps`.
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60), the top is not above the bottom, or a number is not finite.
    pub fn cylinder(radius: f64, bottom: f64, top: f64, caps: bool) -> Result<Self, ShapeError> {
        check_coordinates([DVec3::new(bottom, top, 0.0)])?;
        check_radius(radius)?;
        if bottom >= top {
            return Err(ShapeError::NoHeight { bottom, top });
        }
        Ok(Self { side: QuadricSide { height: bottom, radius, slope: 0.0 }, bottom, top, caps })
    }

    /// The cone with its base of this radius at y = 0 and its apex at y = `height`; only its side if it has no `caps`.
    ///
    /// # Errors
    /// If the radius or the height is not positive (at least 1e-60), or not finite.
    pub fn cone(radius: f64, height: f64, caps: bool) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        check_length("height", height)?;
        let side = QuadricSide { height, radius: 0.0, slope: -radius / height };
        Ok(Self { side, bottom: 0.0, top: height, caps })
    }

    /// The frustum from a disk at y = 0 to one at y = `height`; only its side without `caps`. Either disk may be the
    /// larger one; for a tip use [`cone`](Self::cone).
    ///
    /// # Errors
    /// If a radius or the height is not positive (at least 1e-60), or not finite.
    pub fn frustum(bottom_radius: f64, top_radius: f64, height: f64, caps: bool) -> Result<Self, ShapeError> {
        check_radius(bottom_radius)?;
        check_radius(top_radius)?;
        check_length("height", height)?;
        let slope = (top_radius - bottom_radius) / height;
        // Near the smaller end a rounding error matters most.
        let side = if bottom_radius < top_radius {
            QuadricSide { height: 0.0, radius: bottom_radius, slope }
        } else {
            QuadricSide { height, radius: top_radius, slope }
        };
        Ok(Self { side, bottom: 0.0, top: height, caps })
    }

    /// Radius of a cylinder, and of the smaller end of a cone or frustum.
    pub const fn radius(&self) -> f64 {
        self.side.radius
    }

    /// Radii of the bottom and of the top; 0 at the apex of a cone.
    pub fn radii(&self) -> [f64; 2] {
        self.heights().map(|y| self.side.radius_at(y))
    }

    /// Heights of the bottom and of the top.
    pub const fn heights(&self) -> [f64; 2] {
        [self.bottom, self.top]
    }

    /// True for a closed solid, false for an open surface.
    pub const fn has_caps(&self) -> bool {
        self.caps
    }

    /// The smallest box around it, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        let [bottom, top] = self.radii();
        let reach = bottom.max(top);
        let reach = DVec3::new(reach.next_up(), 0.0, reach.next_up());
        Aabb::new(DVec3::Y * self.bottom - reach, DVec3::Y * self.top + reach)
    }

    /// Support function: the farthest point is on one of the rims.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        let across = DVec3::new(direction.x, 0.0, direction.z).length();
        let rim = |y: f64| direction.y * y + across * self.side.radius_at(y);
        rim(self.bottom).max(rim(self.top))
    }

    /// First intersection within `span`. `None` on a miss, and for rays without a direction. See
    /// [`InfiniteQuadric`](crate::InfiniteQuadric) for the arithmetic.
    ///
    /// A ray along the axis of a cylinder hits the caps alone, rims included.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        if self.caps {
            self.intersect_solid(ray, span)
        } else {
            let in_range = |t: f64| (self.bottom..=self.top).contains(&(ray.origin.y + t * ray.direction.y));
            let t = self.side.first_crossing(ray, span, in_range)?;
            Some(ShapeHit { t, uv: [0.0; 2] })
        }
    }

    /// The solid is convex: a ray is inside where it is inside the side and between the caps, as for a box. So no ray
    /// passes between the side and a cap, and one through a rim hits one of the two: the side on a tie.
    fn intersect_solid(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let (mut enter, mut leave) = self.inside_of_side(ray)?;
        let (mut enter_face, mut leave_face) = (QuadricFace::Side, QuadricFace::Side);
        let (origin, speed) = (ray.origin.y, ray.direction.y);
        if speed == 0.0 {
            if !(self.bottom..=self.top).contains(&origin) {
                return None;
            }
        } else {
            let (low, high) = ((self.bottom - origin) / speed, (self.top - origin) / speed);
            let upwards = speed > 0.0;
            let (near, far) = if upwards { (low, high) } else { (high, low) };
            if near > enter {
                (enter, enter_face) = (near, if upwards { QuadricFace::Bottom } else { QuadricFace::Top });
            }
            if far < leave {
                (leave, leave_face) = (far, if upwards { QuadricFace::Top } else { QuadricFace::Bottom });
            }
        }
        if enter > leave {
            return None;
        }
        let t = span.first(enter, leave).filter(|t| t.is_finite())?;
        let face = if t == enter { enter_face } else { leave_face };
        Some(ShapeHit { t, uv: [f64::from(face as u8), 0.0] })
    }

    /// Part of the ray inside the side. A steep ray is in the nappe of positive radius.
    fn inside_of_side(&self, ray: &Ray) -> Option<(f64, f64)> {
        Some(match self.side.inside(ray)? {
            Inside::Everywhere => (f64::NEG_INFINITY, f64::INFINITY),
            Inside::Between(near, far) => (near, far),
            Inside::Beyond(_, far) if self.side.slope * ray.direction.y > 0.0 => (far, f64::INFINITY),
            Inside::Beyond(near, _) => (f64::NEG_INFINITY, near),
        })
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let (y, normal) = match QuadricFace::from_number(hit.uv[0]) {
            QuadricFace::Side => return self.side_surface(ray, hit.t, needs),
            QuadricFace::Bottom => (self.bottom, DVec3::NEG_Y),
            QuadricFace::Top => (self.top, DVec3::Y),
        };
        let radius = self.side.radius_at(y);
        let (point, point_error) = on_disk(ray, hit.t, y, radius);
        let uv = if needs.uv { cap_uv(point, radius, normal.y) } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, normal, uv)
    }

    fn side_surface(&self, ray: &Ray, t: f64, needs: InteractionFlags) -> SurfaceInteraction {
        let mut surface = self.side.surface(ray, t, [self.bottom, self.top]);
        if needs.uv {
            let height = (surface.point.y - self.bottom) / (self.top - self.bottom);
            surface.uv = [azimuth(surface.point), height];
        }
        surface
    }
}
