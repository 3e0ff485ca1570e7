//! Shadow rays through media with the index of refraction of air.
//!
//! ```text
//!   surface ●───────│░░░ absorbs ░░░│─────── □ light        light · exp(−absorption · length)
//! ```
//!
//! Light passes the surface of such a medium straight, and so do shadow rays. If nothing occludes them, the media on their way are found by
//! closest hits.

use crate::{
    Appearance, InteriorList, Material, SceneQueries, ShadingCounts, ShadingFeatures, SurfaceHit,
    hit_context::HitContext, medium_tracker::MediumTracker,
};
use rt_geometry::RayKind;
use rt_math::{Interval, Ray, Rgb};

impl Appearance {
    /// True if the media on the way of shadow rays are found, with these features. That is so if one that they pass absorbs. It is also so
    /// if air may be a bubble in glass, whose surface is visible. It then has at least the priority of the glass.
    pub fn has_shadow_media(&self, features: &ShadingFeatures) -> bool {
        let priorities = |is_so: fn(&Material) -> bool| {
            let of = move |material: &Material| material.interior.filter(|_| is_so(material));
            self.materials.iter().filter_map(of).map(|interior| interior.priority)
        };
        let of_air = priorities(Material::is_air).max();
        let of_glass = priorities(|it| it.interior.is_some_and(|interior| interior.ior != 1.0)).min();
        let has_bubbles = of_air.zip(of_glass).is_some_and(|(air, glass)| air >= glass);
        let absorbs = features.absorption && self.materials.iter().any(Material::attenuates_shadow_rays);
        features.refraction && (absorbs || has_bubbles)
    }
}

impl Material {
    /// True if the surface is invisible in air. Such objects must cast no shadow ([`SurfaceHit::casts_shadow`]).
    pub fn passes_shadow_rays(&self) -> bool {
        self.is_air() || self.attenuates_shadow_rays()
    }

    /// True for a clear surface around an absorbing medium of index 1.
    pub fn attenuates_shadow_rays(&self) -> bool {
        let is_dim = self.interior.is_some_and(|interior| interior.ior == 1.0 && !interior.is_air());
        is_dim && self.is_clear()
    }
}

/// Media along a shadow ray, and what they transmit.
#[derive(Clone, Debug)]
pub(crate) struct ShadowMedia {
    media: MediumTracker,
    transmittance: Rgb,
}

impl ShadowMedia {
    /// Ray that starts in the media of a path, behind the surface at which the path is.
    pub(crate) fn of_path(media: &MediumTracker, at: f64) -> Self {
        Self { media: media.at(at), transmittance: Rgb::WHITE }
    }

    /// Ray that starts in these media.
    pub(crate) fn new(interior: InteriorList) -> Self {
        Self { media: MediumTracker::new(interior), transmittance: Rgb::WHITE }
    }

    /// Passes the closest hit of a ray that nothing occludes. Returns the rest of the span; `None` if the surface occludes it after all:
    /// that of such a medium within glass.
    pub(crate) fn pass(
        &mut self,
        (features, materials): (&ShadingFeatures, &[Material]),
        (ray, span): (&Ray, Interval),
        hit: &SurfaceHit,
        counts: &mut ShadingCounts,
    ) -> Option<Interval> {
        let behind = hit.span_after(ray);
        let rest = Interval { min: behind.min, max: behind.max.min(span.max) };
        let context = HitContext::new(features, materials, ray, hit);
        let Some(context) = context.filter(|context| context.material.passes_shadow_rays()) else { return Some(rest) };
        let interface = context.interface(&mut self.media.interior, materials, hit.medium_entry());
        let interface = interface.as_ref();
        if context.is_visible(interface) {
            return None;
        }
        self.media.skip_interface(interface, hit, context.length, &mut self.transmittance, counts);
        Some(rest)
    }

    /// Transmittance up to this parameter of the ray. The last medium of a ray to infinity does not absorb: its end is unknown.
    pub(crate) fn transmittance_to(&self, materials: &[Material], ray: &Ray, t: f64) -> Rgb {
        let mut transmittance = self.transmittance;
        if t.is_finite() {
            self.media.absorb(materials, None, t, ray.direction.length(), &mut transmittance);
        }
        transmittance
    }

    /// Span of a shadow ray up to the light, at parameter 1 or infinity. Objects near the light may be excluded from its own span.
    pub(crate) fn span(span: Interval) -> Interval {
        if span.max.is_finite() { Interval { max: Interval::SEGMENT.max, ..span } } else { span }
    }

    /// Follows a ray that nothing occludes, one hit after the other. Returns its transmittance.
    pub(crate) fn follow(
        mut self,
        world: &mut dyn SceneQueries,
        scene: (&ShadingFeatures, &[Material]),
        (ray, span): (&Ray, Interval),
        counts: &mut ShadingCounts,
    ) -> Rgb {
        let mut span = Self::span(span);
        while let Some(hit) = world.closest(ray, span, RayKind::Shadow, scene.0.surface()) {
            let Some(rest) = self.pass(scene, (ray, span), &hit, counts) else { return Rgb::BLACK };
            span = rest;
        }
        self.transmittance_to(scene.1, ray, span.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        BsdfCache, DeltaLight, DeltaLightKind, Falloff, InteriorMedium, Lighting, MaterialModel, PathSettings, Phong,
        ReferencePathTracer, Transport,
        light::{Light, LightSampling, LightSet},
        path::Clamp,
        test_worlds::{ShapeList, gray, whitted_of},
    };
    use rt_geometry::{Cuboid, Plane, Shape};
    use rt_math::{DVec3, Sampler, transcendental::exp};

    /// Numbers that no light without area needs.
    struct NoNumbers;

    impl Sampler for NoNumbers {
        fn next_1d(&mut self) -> f64 {
            0.5
        }

        fn next_2d(&mut self) -> [f64; 2] {
            [0.5; 2]
        }
    }

    fn solid(ior: f64, absorption: f64, priority: i32) -> Material {
        let clear = MaterialModel::Dielectric { roughness: 0.0, transmittance: gray(1.0) };
        let interior = InteriorMedium { ior, absorption: Rgb::gray(absorption), priority };
        Material { interior: Some(interior), ..Material::new(String::new(), clear) }
    }

    /// Heights of bottom and top, and the material.
    type Slab = (f64, f64, u32);

    /// Radiance of a white floor below slabs of these materials, lit from straight above. The camera is close to the floor.
    fn floor_under(slabs: &[Slab], materials: &[Material], light: DeltaLightKind) -> f64 {
        let white = Material::new(String::new(), Phong { diffuse: gray(1.0), ..Phong::BLACK });
        let materials = [&[white], materials].concat();
        let lights = vec![DeltaLight::new(light, Rgb::WHITE)];
        let appearance = Appearance { materials, lights, ..Appearance::default() };
        let slab = |&(bottom, top, material): &Slab| {
            let [min, max] = [DVec3::new(-9.0, bottom, -9.0), DVec3::new(9.0, top, 9.0)];
            (Shape::Cuboid(Cuboid::new(min, max).expect("a slab")), material, None)
        };
        let floor = (Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Y).expect("a plane")), 0, None);
        let shapes = slabs.iter().map(slab).chain([floor]).collect();
        let passed = |at: &u32| appearance.materials[*at as usize].passes_shadow_rays();
        let shadowless = (0..appearance.materials.len() as u32).filter(passed).collect();
        let mut world = ShapeList { shapes, shadowless, ..ShapeList::default() };
        let ray = Ray::new(DVec3::Y * 0.01, DVec3::NEG_Y);
        let mut camera_media = InteriorList::default();
        camera_media.find_enclosing_media(&mut world, &appearance.materials, &ray);

        let mut whitted = whitted_of(&appearance, 0);
        whitted.set_camera_media(core::slice::from_ref(&camera_media));
        let seen = whitted.radiance(&mut world, &appearance, &ray).radiance.g;
        let lights = appearance.lights.iter().cloned().map(Light::Delta).collect();
        let lights = LightSet::new(lights, LightSampling::Power, 1.0);
        let bsdfs = BsdfCache::new(&appearance, |_| true);
        let lighting = Lighting { appearance: &appearance, lights: &lights, bsdfs: &bsdfs };
        let settings = PathSettings { max_depth: 0, rr_start_depth: 0, transport: Transport::Full, clamp: Clamp::NONE };
        let counts = ShadingCounts::default();
        let by_path =
            ReferencePathTracer { settings, lighting, camera_media, counts }.li(&mut world, &ray, &mut NoNumbers);
        assert!((by_path.radiance.g - seen).abs() < 1e-12, "{by_path:?}, {seen}");
        seen
    }

    fn bulb(height: f64) -> DeltaLightKind {
        DeltaLightKind::Point { position: DVec3::Y * height, falloff: Falloff::None, shadow_near: 0.0 }
    }

    /// Regression: point, spot and directional lights did not reach through a medium with the index of air that absorbs.
    #[test]
    fn shadow_rays_ended_at_smoke() {
        let smoke = [solid(1.0, 0.5, 0), solid(1.0, 2.0, 1), solid(1.5, 0.0, 0), solid(1.5, 0.1, 9)];
        let sun = DeltaLightKind::Directional { direction: DVec3::NEG_Y };
        let thick = 0.5;
        let cases: [(&[Slab], _, f64); 10] = [
            (&[], bulb(4.0), 0.0),
            (&[(1.0, 2.0, 1)], bulb(4.0), thick),
            (&[(1.0, 2.0, 1)], sun, thick),
            // The light, the floor, or both are within the smoke.
            (&[(1.0, 2.0, 1)], bulb(1.5), 0.25),
            (&[(-1.0, 2.0, 1)], bulb(4.0), 1.005),
            (&[(-1.0, 2.0, 1)], bulb(1.0), 0.505),
            // Where both overlap, the greater priority counts. Equal media are one.
            (&[(1.0, 2.0, 1), (1.5, 3.0, 2)], bulb(4.0), 0.25 + 3.0),
            (&[(1.0, 2.0, 1), (1.5, 3.0, 1)], bulb(4.0), 1.0),
            (&[(1.0, 2.0, 1), (1.2, 1.5, 2), (2.5, 3.0, 1)], sun, 0.35 + 0.6 + 0.25),
            // Everything is in glass, which counts where both overlap.
            (&[(-1.0, 6.0, 4), (1.0, 2.0, 1)], bulb(4.0), 0.401),
        ];
        for (slabs, light, depth) in cases {
            let seen = floor_under(slabs, &smoke, light);
            assert!((seen - exp(-depth)).abs() < 1e-12, "{slabs:?}: {seen}, {}", exp(-depth));
        }
        // Glass ends shadow rays, also that in which smoke is.
        for slabs in [[(1.0, 2.0, 1), (2.5, 3.0, 3)], [(1.0, 2.0, 1), (0.5, 2.5, 4)]] {
            assert_eq!(floor_under(&slabs, &smoke, bulb(4.0)), 0.0, "{slabs:?}");
        }
    }
}
