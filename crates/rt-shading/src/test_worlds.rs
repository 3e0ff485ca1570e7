//! Worlds for tests of integrators that query them with single rays.

use crate::{Appearance, ColorTexture, SceneQueries, ShadingFeatures, SurfaceHit, Whitted, light::LightId};
use rt_geometry::{InteractionFlags, RayKind, Shape, SurfaceInteraction};
use rt_math::{DVec3, Interval, Ray, Rgb};

/// Function that returns the shading normal of a hit.
type ShadingNormal = dyn Fn(&SurfaceHit) -> DVec3;

/// Shapes, each with its material and light.
#[derive(Default)]
pub(crate) struct ShapeList {
    pub(crate) shapes: Vec<(Shape, u32, Option<u32>)>,
    /// Shading normals that are not those of the shapes.
    pub(crate) shading_normal: Option<Box<ShadingNormal>>,
    /// Rays so far, if they are recorded.
    pub(crate) rays: Option<Vec<Ray>>,
    /// Materials of objects that cast no shadow.
    pub(crate) shadowless: Vec<u32>,
}

impl SceneQueries for ShapeList {
    fn closest(&mut self, ray: &Ray, span: Interval, _: RayKind, needs: InteractionFlags) -> Option<SurfaceHit> {
        self.rays.iter_mut().for_each(|rays| rays.push(*ray));
        let hits = self.shapes.iter().enumerate();
        let hits = hits.filter_map(|(object, (shape, ..))| Some((object, shape.intersect(ray, span)?)));
        let (object, hit) = hits.min_by(|a, b| a.1.t.total_cmp(&b.1.t))?;
        let (shape, material, light) = &self.shapes[object];
        let mut surface = SurfaceHit::new(hit.t, shape.surface(ray, &hit, needs), object as u32, *material);
        surface.casts_shadow = !self.shadowless.contains(material);
        surface.light = light.map(|index| LightId { index, triangle: None });
        if let Some(shading_normal) = &self.shading_normal {
            surface.interaction.shading_normal = shading_normal(&surface);
        }
        Some(surface)
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        let shadowless = &self.shadowless;
        let casters = self.shapes.iter().filter(|(_, material, _)| !shadowless.contains(material));
        casters.into_iter().any(|(shape, ..)| shape.intersect(ray, span).is_some())
    }
}

/// Function that returns the closest hit of a ray. Nothing casts shadows.
pub(crate) struct HitFunction<F>(pub(crate) F);

impl<F: FnMut(&Ray, Interval) -> Option<SurfaceHit>> SceneQueries for HitFunction<F> {
    fn closest(&mut self, ray: &Ray, span: Interval, _: RayKind, _: InteractionFlags) -> Option<SurfaceHit> {
        self.0(ray, span)
    }

    fn occluded(&mut self, _: &Ray, _: Interval) -> bool {
        false
    }
}

/// Hit of object 0 at a point with this normal, without rounding error.
pub(crate) fn flat_hit(t: f64, point: DVec3, normal: DVec3, material: u32) -> SurfaceHit {
    SurfaceHit::new(t, SurfaceInteraction::flat(point, DVec3::ZERO, normal, [0.0; 2]), 0, material)
}

pub(crate) const fn gray(value: f64) -> ColorTexture {
    ColorTexture::Constant(Rgb::gray(value))
}

/// Whitted's integrator with the features that these materials need.
pub(crate) fn whitted_of(appearance: &Appearance, max_depth: u32) -> Whitted {
    Whitted::new(max_depth, 0.0, ShadingFeatures::of(appearance, |_| true))
}
