//! The way from a small part of a surface to a light, and what stands in it.
//!
//! ```text
//!      ·──────────────────·
//!     ( m ─────────────────── light          all points nearer to the line than the radius of the patch
//!      ·──────────────────·
//! ```
//!
//! A way from a point of the patch to the light runs within it: at each share of its length it is at most as far from the
//! line as at its start.

use core::ops::ControlFlow;

use rt_accel::{Accelerator as _, AnyAccelerator, Region};
use rt_math::{Aabb, DVec3, Interval, Ray, SlabRay};
use rt_shading::DeltaLight;

use super::patch::SurfacePatch;
use crate::primitive_form::{HasForm, PrimitiveForm};

/// Segments from a patch to a delta light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightShaft {
    /// From the middle of the patch to the light at parameter 1, or in its direction.
    line: Ray,
    slab: SlabRay,
    radius: f64,
    /// Place of the light; `None` for light from infinitely far away.
    place: Option<DVec3>,
    /// Radius around the place within which nothing casts a shadow.
    shadow_near: f64,
}

/// Occlusion of a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Occlusion {
    /// None of the ways.
    Nowhere,
    /// Maybe some of the ways.
    Somewhere,
    /// All ways.
    Everywhere,
}

impl LightShaft {
    pub(super) fn new(patch: &SurfacePatch, light: &DeltaLight) -> Self {
        let (place, shadow_near) = (light.kind.position(), light.kind.shadow_near());
        let line = Ray::new(patch.centre, light.kind.offset_from(patch.centre));
        Self { line, slab: SlabRay::new(&line), radius: patch.radius, place, shadow_near }
    }

    /// Occlusion by all primitives except that of the patch: a convex surface does not
    /// stand in its own light.
    pub(super) fn blocked<W: HasForm>(&self, world: &W, structure: &AnyAccelerator, own: u32) -> Occlusion {
        let mut blocked = Occlusion::Nowhere;
        structure.visit_overlapping(world, self, |index| {
            if index != own && world.casts_shadow(index) {
                match self.blocked_by(&world.form(index)) {
                    Occlusion::Nowhere => {}
                    Occlusion::Somewhere => blocked = Occlusion::Somewhere,
                    Occlusion::Everywhere => {
                        blocked = Occlusion::Everywhere;
                        return ControlFlow::Break(());
                    }
                }
            }
            ControlFlow::Continue(())
        });
        blocked
    }

    /// Occlusion by a primitive whose bounds overlap the shaft.
    fn blocked_by(&self, form: &PrimitiveForm) -> Occlusion {
        match *form {
            PrimitiveForm::Sphere { centre, radius } => self.blocked_by_ball(centre, radius),
            PrimitiveForm::Plane { point, normal } => self.blocked_by_plane(point, normal.normalize_or_zero()),
            PrimitiveForm::Flat | PrimitiveForm::Faces | PrimitiveForm::Other => Occlusion::Somewhere,
        }
    }

    fn blocked_by_ball(&self, centre: DVec3, radius: f64) -> Occlusion {
        let from_light = self.place.map_or(f64::INFINITY, |place| (centre - place).length());
        if from_light + radius <= self.shadow_near {
            return Occlusion::Nowhere;
        }
        let Ray { origin, direction, .. } = self.line;
        let nearest = ((centre - origin).dot(direction) / direction.length_squared()).max(0.0);
        let nearest = if self.place.is_some() { nearest.min(1.0) } else { nearest };
        let distance = (self.line.at(nearest) - centre).length();
        let ends_are_outside =
            (centre - origin).length() > radius + self.radius && from_light > radius + self.shadow_near;
        if distance > radius + self.radius {
            Occlusion::Nowhere
        } else if ends_are_outside && distance + self.radius < radius {
            Occlusion::Everywhere
        } else {
            Occlusion::Somewhere
        }
    }

    fn blocked_by_plane(&self, point: DVec3, normal: DVec3) -> Occlusion {
        let height = normal.dot(self.line.origin - point);
        // Of the light, or whether the way there rises.
        let end = self.place.map_or(normal.dot(self.line.direction), |place| normal.dot(place - point));
        if height.abs() <= self.radius || end == 0.0 {
            Occlusion::Somewhere
        } else if (height > 0.0) == (end > 0.0) {
            Occlusion::Nowhere
        } else if self.shadow_near == 0.0 {
            Occlusion::Everywhere
        } else {
            Occlusion::Somewhere
        }
    }
}

impl Region for LightShaft {
    fn bounds(&self) -> Aabb {
        Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY)
    }

    /// True if the line meets the own box, widened by the radius.
    fn overlaps(&self, aabb: &Aabb) -> bool {
        let own = aabb.padded();
        let span = if self.place.is_some() { Interval::new(0.0, 1.0) } else { Interval::FORWARD };
        Aabb::new(own.min - self.radius, own.max + self.radius).clip(&self.slab, span).is_some()
    }
}
