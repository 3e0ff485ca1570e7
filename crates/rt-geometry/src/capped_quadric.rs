//! Cylinders, cones and frusta: a curved side between two heights, with or without caps.

use crate::disk::{cap_uv, on_disk};
use crate::quadric_side::{Inside, QuadricSide, azimuth};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// Part of a [`QuadricSide`] between two heights: a closed solid with caps, else an open surface with two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CappedQuadric {
    pub(crate) side: QuadricSide,
    pub(crate) bottom: f64,
    pub(crate) top: f64,
    pub(crate) caps: bool,
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
    pub(crate) fn bounds(&self) -> Aabb {
        let reach = self.side.radius_at(self.bottom).max(self.side.radius_at(self.top));
        let reach = DVec3::new(reach.next_up(), 0.0, reach.next_up());
        Aabb::new(DVec3::Y * self.bottom - reach, DVec3::Y * self.top + reach)
    }

    /// Support function: the farthest point is on one of the rims.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        let across = DVec3::new(direction.x, 0.0, direction.z).length();
        let rim = |y: f64| direction.y * y + across * self.side.radius_at(y);
        rim(self.bottom).max(rim(self.top))
    }

    #[inline]
    pub(crate) fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
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

    pub(crate) fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
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
