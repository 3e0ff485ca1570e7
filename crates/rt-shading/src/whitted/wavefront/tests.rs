//! Comparison of the wavefront integrator with [`Whitted`], which shades one hit at a time in `f64`.

use super::*;
use crate::{
    Background, InteriorMedium, Whitted,
    lane_set::Float64Lane,
    wavefront::test_world::{ShapeWorld, TestPrimitive, TestShape, camera_rays, difference},
    whitted::tests::lanes,
};
use rt_geometry::Sphere;
use rt_math::DVec3;

/// Materials of the tests of lanes that this integrator supports, with lights at this scale.
fn appearance(scale: f64) -> Appearance {
    let mut appearance = lanes::appearance();
    let phongs = LanePhong::of_all(&appearance, &ShadingFeatures::ALL);
    let mut phongs = phongs.iter();
    let is_supported = |phong: &Option<LanePhong>| phong.as_ref().is_some_and(|phong| phong.exponent() <= MAX_EXPONENT);
    appearance.materials.retain(|_| phongs.next().is_some_and(is_supported));
    // Fog: rays pass its surface as a null interface, which accounts for absorption up to there.
    let clear = appearance.materials.last().cloned().expect("a clear material");
    let fog = InteriorMedium { absorption: Rgb::new(0.4, 0.3, 0.2) / scale, ..InteriorMedium::clear(1.0) };
    appearance.materials.push(Material { interior: Some(fog), ..clear });
    for light in &mut appearance.lights {
        if let Some(position) = light.kind.position_mut() {
            *position *= scale;
        }
    }
    appearance
}

type Image = (Vec<RadianceSample>, ShadingCounts);

/// Camera rays with what they see.
struct View<'a> {
    features: ShadingFeatures,
    appearance: &'a Appearance,
    rays: &'a [(Ray, Interval)],
}

impl View<'_> {
    fn misses(&self) -> Vec<RadianceSample> {
        vec![RadianceSample::MISS; self.rays.len()]
    }

    fn of_whitted(&self, world: &mut ShapeWorld) -> Image {
        let mut seen = self.misses();
        let mut whitted = Whitted::new(4, 1e-3, self.features);
        whitted.radiance_of(world, self.appearance, self.rays, &mut seen);
        (seen, whitted.take_counts())
    }

    fn of_wavefront(&self, level: Option<LaneLevel>, world: &mut ShapeWorld) -> Image {
        let mut seen = self.misses();
        let mut wavefront = WavefrontWhitted::new(4, 1e-3, self.features, self.appearance);
        wavefront.set_lanes(level);
        wavefront.radiance_of(world, self.appearance, self.rays, &mut seen);
        (seen, wavefront.take_counts())
    }

    /// The wavefront integrator with `f64` for shading as well.
    fn in_f64(&self, world: &mut ShapeWorld) -> Image {
        let mut seen = self.misses();
        let &Self { features, appearance, rays } = self;
        let WavefrontWhitted { settings, .. } = &WavefrontWhitted::new(4, 1e-3, features, appearance);
        let mut streams = Wavefront::<f64>::default();
        let shade = &Shade { lanes: Float64Lane::new(), settings, appearance, has_time: false };
        for (rays, seen) in rays.chunks(STREAM_CAPACITY).zip(seen.chunks_mut(STREAM_CAPACITY)) {
            let mut stream = RayStream::default();
            rays.iter().for_each(|(ray, span)| stream.push(ray, *span));
            streams.trace(shade, world, (0, &mut stream, seen), |world, wave, spawned, seen| {
                spawned.shade(shade, world, wave, seen);
            });
        }
        (seen, streams.spawned.counts)
    }
}

fn features() -> [ShadingFeatures; 5] {
    [
        ShadingFeatures::ALL,
        ShadingFeatures { shadows: false, ambient: false, ..ShadingFeatures::ALL },
        ShadingFeatures { highlights: false, fresnel: false, ..ShadingFeatures::ALL },
        ShadingFeatures { reflection: false, absorption: false, ..ShadingFeatures::ALL },
        ShadingFeatures { refraction: false, ..ShadingFeatures::ALL },
    ]
}

#[test]
fn shading_in_f64_gives_the_radiance_of_the_recursive_integrator() {
    let appearance = appearance(1.0);
    let mut world = ShapeWorld::new(appearance.materials.len() as u32, 1.0);
    let rays = camera_rays(2000, 1.0);
    for features in features() {
        let view = View { features, appearance: &appearance, rays: &rays };
        let (expected, counts) = view.of_whitted(&mut world);
        let (found, found_counts) = view.in_f64(&mut world);
        assert_eq!(counts.without_lanes(), found_counts.without_lanes(), "{features:?}");
        for (at, (a, b)) in expected.iter().zip(&found).enumerate() {
            assert!(a.hit == b.hit && difference(a, b) < 1e-12, "ray {at}: {a:?}, {b:?}, {features:?}");
        }
    }
}

/// Regression: a deferred ray continued with the distance up to which absorption was accounted for of the ray that had just left the
/// scene.
#[test]
fn a_deferred_ray_in_tinted_glass_does_not_know_of_fog_that_the_mirrored_ray_has_passed() {
    let mut appearance = appearance(1.0);
    let is_absorbing = |material: &Material| material.interior.is_some_and(|medium| !medium.absorption.is_black());
    appearance.materials.retain(is_absorbing);
    let n_materials = appearance.materials.len();
    appearance.materials =
        [&appearance.materials[0], &appearance.materials[n_materials - 1]].map(Clone::clone).to_vec();
    let mut world = ShapeWorld::new(2, 1.0);
    let rays = camera_rays(2000, 1.0);
    let view = View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &rays };
    let (expected, counts) = view.of_whitted(&mut world);
    let (found, _) = view.in_f64(&mut world);
    assert!(counts.passages > 1000 && counts.fresnel > 1000, "{counts:?}");
    for (at, (a, b)) in expected.iter().zip(&found).enumerate() {
        assert!(difference(a, b) < 1e-12, "ray {at}: {a:?}, {b:?}");
    }
}

/// Regression: the normal of a hit that rounding puts on the centre was not a number.
#[test]
fn a_hit_that_is_rounded_to_the_centre_of_a_tiny_sphere_faces_the_viewer() {
    let appearance = Appearance {
        materials: vec![Material::new(String::new(), crate::Phong::default())],
        lights: vec![lanes::appearance().lights.swap_remove(2)],
        ..Appearance::default()
    };
    let sphere = Sphere::new(DVec3::ZERO, 1e-9).expect("a sphere");
    let mut world = ShapeWorld(vec![TestPrimitive { shape: TestShape::Sphere(sphere), material: 0, light: None }]);
    // Against the direction of the light, so that the side of the viewer is lit.
    let towards_light = DVec3::new(-0.48, 0.6, -0.64);
    let rays = [(Ray::new(towards_light * 1e8, -towards_light), Interval::FORWARD)];
    let view = View {
        features: ShadingFeatures { shadows: false, ..ShadingFeatures::ALL },
        appearance: &appearance,
        rays: &rays,
    };
    let (expected, _) = view.of_whitted(&mut world);
    let (found, _) = view.of_wavefront(LaneLevel::best(), &mut world);
    assert!(expected[0].hit && expected[0].radiance.max_component() > 0.1, "{expected:?}");
    assert!(difference(&expected[0], &found[0]) < 1e-6, "{expected:?}, {found:?}");
}

#[test]
fn the_worlds_of_these_tests_have_all_cases() {
    let appearance = appearance(1.0);
    let mut world = ShapeWorld::new(appearance.materials.len() as u32, 1.0);
    let (seen, counts) =
        View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &camera_rays(2000, 1.0) }
            .of_whitted(&mut world);
    assert!(seen.iter().any(|seen| !seen.hit) && counts.shadow_rays_skipped > 1000 && counts.mirrors > 1000);
    assert!(counts.refractions > 300 && counts.fresnel > 200 && counts.absorption > 50, "{counts:?}");
    assert!(counts.passages > 20 && counts.highlights > 1000 && counts.depth_limited > 20, "{counts:?}");
}

#[test]
fn lanes_have_the_bits_of_single_hits_at_all_levels() {
    let appearance = appearance(1.0);
    let mut world = ShapeWorld::new(appearance.materials.len() as u32, 1.0);
    if LaneLevel::best().is_none() {
        println!("skipped: this processor lacks AVX2");
    }
    for features in features() {
        for n_rays in [1, 7, 8, 9, 255, 256, 257, 1000] {
            let rays = camera_rays(n_rays, 1.0);
            let view = View { features, appearance: &appearance, rays: &rays };
            let one = view.of_wavefront(None, &mut world);
            for level in [LaneLevel::avx2(), LaneLevel::best()].into_iter().flatten() {
                let lanes = view.of_wavefront(Some(level), &mut world);
                assert_eq!(one.1.without_lanes(), lanes.1.without_lanes(), "{n_rays} rays, {level:?}, {features:?}");
                for (at, (a, b)) in one.0.iter().zip(&lanes.0).enumerate() {
                    let bits = |seen: &RadianceSample| seen.radiance.to_array().map(f64::to_bits);
                    assert!(bits(a) == bits(b) && a.hit == b.hit, "ray {at} of {n_rays}: {a:?}, {b:?}, {level:?}");
                }
            }
        }
    }
}

/// Shares of rays whose radiance differs by more than 1e-5 and 1e-3 from that in `f64`.
fn shares_of_differences(scale: f64) -> [f64; 2] {
    let appearance = appearance(scale);
    let mut world = ShapeWorld::new(appearance.materials.len() as u32, scale);
    let rays = camera_rays(4000, scale);
    let view = View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &rays };
    let (exact, _) = view.of_whitted(&mut world);
    let (found, _) = view.of_wavefront(LaneLevel::best(), &mut world);
    [1e-5, 1e-3].map(|bound| {
        let differing = exact.iter().zip(&found).filter(|(a, b)| !(difference(a, b) < bound && a.hit == b.hit));
        differing.count() as f64 / rays.len() as f64
    })
}

#[test]
fn f32_differs_where_rays_take_another_way() {
    let [above_rounding, another_way] = shares_of_differences(1.0);
    assert!(above_rounding < 0.02 && another_way < 0.002, "{above_rounding}, {another_way}");
}

#[test]
fn tiny_and_huge_scenes_do_not_leave_the_range_of_f32() {
    for scale in [1e-25, 1e-18, 1e17, 1e25] {
        // Inverse squares of such distances are out of the range of colours themselves.
        let mut appearance = appearance(scale);
        appearance.lights.retain(|light| {
            !matches!(light.kind, crate::DeltaLightKind::Point { falloff: crate::Falloff::InverseSquare, .. })
                && !matches!(light.kind, crate::DeltaLightKind::Spot { falloff: crate::Falloff::InverseSquare, .. })
        });
        let mut world = ShapeWorld::new(appearance.materials.len() as u32, scale);
        let rays = camera_rays(1000, scale);
        let features = ShadingFeatures { absorption: false, ..ShadingFeatures::ALL };
        let view = View { features, appearance: &appearance, rays: &rays };
        let (exact, _) = view.of_whitted(&mut world);
        let (found, _) = view.of_wavefront(LaneLevel::best(), &mut world);
        let differing = exact.iter().zip(&found).filter(|(a, b)| !(difference(a, b) < 1e-3));
        assert!(differing.count() < 10, "scale {scale}");
    }
}

#[test]
fn numbers_that_leave_the_range_of_f32_are_not_supported() {
    let usual = appearance(1.0);
    assert!(WavefrontWhitted::supports(&usual));
    let mut bright = usual.clone();
    bright.lights[0].intensity = Rgb::gray(1e20);
    let mut dense = usual.clone();
    dense.materials.last_mut().expect("a material").interior = Some(InteriorMedium::clear(1e6));
    let faint = Appearance { background: Background::Constant(Rgb::gray(1e-30)), ..usual.clone() };
    let mut narrow = usual.clone();
    for light in &mut narrow.lights {
        if let crate::DeltaLightKind::Spot { cos_inner, cos_outer, .. } = &mut light.kind {
            (*cos_inner, *cos_outer) = (1.0, 1.0 - 1e-8);
        }
    }
    let mut sharp = usual.clone();
    let specular = crate::ColorTexture::Constant(Rgb::WHITE);
    let sharp_phong = crate::Phong { specular, exponent: 1e5, ..crate::Phong::default() };
    sharp.materials.push(Material::new(String::new(), sharp_phong));
    let lights = core::iter::repeat_n(usual.lights[0].clone(), MAX_LIGHTS + 1).collect();
    for other in [bright, dense, faint, narrow, sharp, Appearance { lights, ..usual }, lanes::appearance()] {
        assert!(!WavefrontWhitted::supports(&other), "{other:?}");
    }
}
