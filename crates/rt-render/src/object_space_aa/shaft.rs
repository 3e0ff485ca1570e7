//! Light shaft: the space between a surface patch and a light, and its occlusion.
//!
//! ```text
//!      ·──────────────────·
//!     ( m ─────────────────── light          points within the radius of the patch around the line
//!      ·──────────────────·
//! ```
//!
//! The shaft contains all segments from the patch to the light: their distance from the line is largest at the start.

use core::ops::ControlFlow;

use rt_accel::{Accelerator as _, AnyAccelerator, Region};
use rt_geometry::Primitives as _;
use rt_math::{Aabb, DVec3, Interval, Ray, SlabRay};
use rt_shading::DeltaLight;

use super::patch::SurfacePatch;
use crate::{instance::Instances, primitive_form::PrimitiveForm};

/// All segments from a patch to a delta light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightShaft {
    /// Ray from the centre of the patch: to the light at parameter 1, or in its direction.
    line: Ray,
    slab: SlabRay,
    radius: f64,
    /// Position of the light; `None` for a directional light.
    position: Option<DVec3>,
    /// Objects within this distance of the light cast no shadow.
    shadow_near: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Occlusion {
    /// No segment is occluded.
    Nowhere,
    /// Some segments may be occluded.
    Somewhere,
    /// All segments are occluded.
    Everywhere,
}

impl LightShaft {
    pub(super) fn new(patch: &SurfacePatch, light: &DeltaLight) -> Self {
        let (position, shadow_near) = (light.kind.position(), light.kind.shadow_near());
        let line = Ray::new(patch.centre, light.kind.offset_from(patch.centre));
        Self { line, slab: SlabRay::new(&line), radius: patch.radius, position, shadow_near }
    }

    /// Occlusion by all primitives except that of the patch, which is convex and does not occlude itself. Objects whose material
    /// `attenuates` light count as if they occluded a part.
    pub(super) fn occluded(
        &self,
        world: &Instances<'_>,
        accelerator: &AnyAccelerator,
        (excluded, attenuates): (u32, &impl Fn(u32) -> bool),
    ) -> Occlusion {
        let mut occluded = Occlusion::Nowhere;
        accelerator.visit_overlapping(world, self, |index| {
            if attenuates(world.instances[index as usize].material) {
                occluded = Occlusion::Somewhere;
            } else if index != excluded && world.casts_shadow(index) {
                match self.occluded_by(&world.form(index)) {
                    Occlusion::Nowhere => {}
                    Occlusion::Somewhere => occluded = Occlusion::Somewhere,
                    Occlusion::Everywhere => {
                        occluded = Occlusion::Everywhere;
                        return ControlFlow::Break(());
                    }
                }
            }
            ControlFlow::Continue(())
        });
        occluded
    }

    /// Occlusion by a primitive whose bounds overlap the shaft.
    fn occluded_by(&self, form: &PrimitiveForm) -> Occlusion {
        match *form {
            PrimitiveForm::Sphere { centre, radius } => self.occluded_by_sphere(centre, radius),
            PrimitiveForm::Plane { point, normal } => self.occluded_by_plane(point, normal.normalize_or_zero()),
            PrimitiveForm::Flat | PrimitiveForm::Faces | PrimitiveForm::Other => Occlusion::Somewhere,
        }
    }

    fn occluded_by_sphere(&self, centre: DVec3, radius: f64) -> Occlusion {
        let from_light = self.position.map_or(f64::INFINITY, |position| (centre - position).length());
        if from_light + radius <= self.shadow_near {
            return Occlusion::Nowhere;
        }
        let Ray { origin, direction, .. } = self.line;
        let nearest = ((centre - origin).dot(direction) / direction.length_squared()).max(0.0);
        let nearest = if self.position.is_some() { nearest.min(1.0) } else { nearest };
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

    fn occluded_by_plane(&self, point: DVec3, normal: DVec3) -> Occlusion {
        let height = normal.dot(self.line.origin - point);
        // Height of a positional light, or slope towards a directional one.
        let end = self.position.map_or(normal.dot(self.line.direction), |position| normal.dot(position - point));
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

    /// True if the line hits the padded bounds, expanded by the radius.
    fn overlaps(&self, aabb: &Aabb) -> bool {
        let padded = aabb.padded();
        let span = if self.position.is_some() { Interval::new(0.0, 1.0) } else { Interval::FORWARD };
        Aabb::new(padded.min - self.radius, padded.max + self.radius).clip(&self.slab, span).is_some()
    }
}
