//! Shading of primitives in lanes, compared with hits that are shaded one by one in `f64`.

use super::*;
use crate::{
    Background, ColorTexture, DeltaLight, DeltaLightKind, Falloff, Highlight, InteriorMedium, LightUnits, Material,
    Phong, Texture, TextureId, Transmission,
    wavefront::test_world::{
        Rendered, ShapeWorld, TestPrimitive, TestShape, assert_close, assert_same_at_all_levels, assert_same_bits,
        camera_rays, in_streams, shares_of_differences,
    },
};
use rt_geometry::Sphere;
use rt_math::{DVec3, Rgb};

/// Position of the first light.
const LIGHT: DVec3 = DVec3::new(0.7, 1.9, -0.4);

fn lights() -> Vec<DeltaLight> {
    let kinds = [
        DeltaLightKind::Point { position: LIGHT, falloff: Falloff::InverseSquare, shadow_near: 0.0 },
        DeltaLightKind::Point { position: DVec3::new(-5.0, 4.0, 3.0), falloff: Falloff::None, shadow_near: 0.3 },
        DeltaLightKind::Directional { direction: DVec3::new(0.48, -0.6, 0.64) },
        DeltaLightKind::Spot {
            position: DVec3::new(2.0, 5.0, 1.0),
            direction: DVec3::NEG_Y,
            cos_inner: 0.9,
            cos_outer: 0.7,
            falloff: Falloff::InverseSquare,
        },
        DeltaLightKind::Spot {
            position: DVec3::new(0.0, 0.0, 6.0),
            direction: DVec3::NEG_Z,
            cos_inner: 0.8,
            cos_outer: -0.5,
            falloff: Falloff::None,
        },
    ];
    let light = |(at, kind): (usize, DeltaLightKind)| DeltaLight {
        units: if at % 2 == 0 { LightUnits::Classical } else { LightUnits::Physical },
        casts_shadows: at != 4,
        ..DeltaLight::new(kind, Rgb::new(0.9, 0.3 * at as f64, 0.7))
    };
    let mut lights: Vec<_> = kinds.into_iter().enumerate().map(light).collect();
    let dark = DeltaLight { intensity: Rgb::BLACK, ..lights[0].clone() };
    lights.push(dark);
    lights
}

fn all_materials() -> Appearance {
    let color = |r, g, b| ColorTexture::Constant(Rgb::new(r, g, b));
    let textured = |id| ColorTexture::Textured(TextureId(id), Rgb::new(0.9, 0.8, 0.7));
    let checker = textured(0);
    let matte = Phong { diffuse: color(0.5, 0.6, 0.2), ambient: color(0.2, 0.1, 0.3), ..Phong::default() };
    let shiny = |highlight, exponent| Phong { specular: color(0.3, 0.2, 0.5), highlight, exponent, ..matte };
    let mut phongs = vec![matte, Phong { mirror: color(0.5, 0.4, 0.3), ..shiny(Highlight::Phong, 3.0) }, Phong::BLACK];
    for highlight in [Highlight::Phong, Highlight::Blinn] {
        phongs.extend([0.0, 1.0, 40.0, 2.5, 2000.0].map(|exponent| shiny(highlight, exponent)));
    }
    phongs.push(Phong { diffuse: checker, specular: checker, ..shiny(Highlight::Phong, 7.0) });
    phongs.push(Phong { ambient: checker, mirror: textured(1), ..shiny(Highlight::Blinn, 7.0) });
    // Cells of two sizes, and a texture that lanes do not evaluate.
    phongs.push(Phong { diffuse: checker, specular: textured(2), ..shiny(Highlight::Phong, 2.0) });
    phongs.push(Phong { diffuse: checker, specular: textured(3), ..shiny(Highlight::Phong, 2.0) });
    phongs.push(Phong { diffuse: ColorTexture::ZERO, mirror: color(0.0, 0.1, 0.2), ..shiny(Highlight::Blinn, 9.0) });
    let mut materials: Vec<_> = phongs.into_iter().map(|phong| Material::new(String::new(), phong)).collect();
    materials[0].emission = color(0.1, 0.2, 0.3);
    materials[1].emission = checker;
    let transmission = |fresnel| Some(Transmission { coefficient: color(0.9, 0.8, 0.9), fresnel });
    let glass = |fresnel| Phong { transmission: transmission(fresnel), mirror: color(1.0, 0.9, 1.0), ..matte };
    let tinted = Phong { transmission: Some(Transmission { coefficient: checker, fresnel: false }), ..glass(true) };
    let clear = Transmission { coefficient: color(1.0, 1.0, 1.0), fresnel: true };
    let clear = Phong { transmission: Some(clear), mirror: color(1.0, 1.0, 1.0), ..Phong::BLACK };
    let absorbing = InteriorMedium { absorption: Rgb::new(0.1, 0.0, 0.2), ..InteriorMedium::clear(1.5) };
    for (phong, interior) in [
        (glass(true), Some(absorbing)),
        (glass(true), Some(InteriorMedium::clear(1.5))),
        (glass(false), Some(InteriorMedium::clear(2.4))),
        (glass(true), None),
        (tinted, Some(absorbing)),
        (clear, Some(InteriorMedium::clear(1.0))),
        (clear, Some(InteriorMedium { priority: 3, ..InteriorMedium::clear(1.3) })),
    ] {
        materials.push(Material { interior, ..Material::new(String::new(), phong) });
    }
    Appearance {
        materials,
        textures: vec![
            Texture::Checker { even: Rgb::WHITE, odd: Rgb::BLACK, size: 0.6 },
            Texture::Checker { even: Rgb::new(0.1, 0.2, 0.3), odd: Rgb::new(0.9, 0.0, 0.5), size: 0.6 },
            Texture::Checker { even: Rgb::WHITE, odd: Rgb::BLACK, size: 1.7 },
            Texture::VertexColor(None),
        ],
        lights: lights(),
        ambient: Rgb::new(0.1, 0.2, 0.1),
        background: Background::Constant(Rgb::new(0.2, 0.3, 0.5)),
    }
}

/// Materials of all kinds, with lights at this scale.
fn appearance(scale: f64) -> Appearance {
    let mut appearance = all_materials();
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

/// Shapes of these materials. Every second triangle has interpolated normals, some of which face away from the viewer.
fn shapes(appearance: &Appearance, scale: f64) -> ShapeWorld {
    ShapeWorld::new(appearance.materials.len() as u32, scale).with_shading_normals()
}

/// Camera rays with what they see.
struct View<'a> {
    features: ShadingFeatures,
    appearance: &'a Appearance,
    rays: &'a [(Ray, Interval)],
}

impl View<'_> {
    fn whitted(&self) -> Whitted {
        Whitted::new(4, 1e-3, self.features)
    }

    fn traced(&self, mut whitted: Whitted, world: &mut impl StreamQueries) -> Rendered {
        let seen =
            in_streams(self.rays, |_, rays, seen| whitted.radiance_of_stream(world, self.appearance, rays, seen));
        (seen, whitted.take_counts())
    }

    /// Radiance of hits that are shaded one by one in `f64`.
    fn one_by_one(&self, world: &mut ShapeWorld) -> Rendered {
        self.traced(self.whitted().in_f64(), &mut SingleQueries::new(world))
    }

    /// Radiance in `f32`, in lanes of a level.
    fn in_lanes(&self, level: Option<LaneLevel>, world: &mut ShapeWorld) -> Rendered {
        let mut whitted = self.whitted();
        whitted.set_lanes(level);
        self.traced(whitted, world)
    }

    /// Radiance with the code for lanes, in `f64`.
    fn in_f64(&self, world: &mut ShapeWorld) -> Rendered {
        self.traced(self.whitted().in_f64(), world)
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
fn lanes_in_f64_give_the_radiance_of_hits_that_are_shaded_one_by_one() {
    let appearance = appearance(1.0);
    let mut world = shapes(&appearance, 1.0);
    let rays = camera_rays(2000, 1.0);
    for features in features() {
        let view = View { features, appearance: &appearance, rays: &rays };
        let (expected, counts) = view.one_by_one(&mut world);
        let (found, found_counts) = view.in_f64(&mut world);
        assert_eq!(counts.without_lanes(), found_counts.without_lanes(), "{features:?}");
        assert_close(&expected, &found, 1e-12, 0, features);
    }
}

/// Regression: checkered triangles were shaded with the normals of their planes.
#[test]
fn checkered_triangles_are_shaded_with_interpolated_normals() {
    let mut appearance = appearance(1.0);
    let is_checkered = |material: &Material| {
        let phong = material.to_phong();
        matches!(
            [phong.diffuse, phong.ambient],
            [ColorTexture::Textured(TextureId(0), _), _] | [_, ColorTexture::Textured(..)]
        )
    };
    appearance.materials.retain(is_checkered);
    let mut world = shapes(&appearance, 1.0);
    world.0.retain(|primitive| matches!(primitive.shape, TestShape::Triangle(..)));
    let rays = camera_rays(2000, 1.0);
    let view = View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &rays };
    let (expected, _) = view.one_by_one(&mut world);
    let (found, counts) = view.in_f64(&mut world);
    assert!(counts.lanes_used > 200, "{counts:?}");
    assert_close(&expected, &found, 1e-12, 0, "checkered triangles");
}

/// Regression: a refracted ray continued with the distance up to which absorption was accounted for of the mirrored ray.
#[test]
fn a_refracted_ray_in_tinted_glass_does_not_know_of_fog_that_the_mirrored_ray_has_passed() {
    let mut appearance = appearance(1.0);
    let is_absorbing = |material: &Material| material.interior.is_some_and(|medium| !medium.absorption.is_black());
    appearance.materials.retain(is_absorbing);
    let n_materials = appearance.materials.len();
    appearance.materials =
        [&appearance.materials[0], &appearance.materials[n_materials - 1]].map(Clone::clone).to_vec();
    let mut world = ShapeWorld::new(2, 1.0);
    let rays = camera_rays(2000, 1.0);
    let view = View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &rays };
    let (expected, counts) = view.one_by_one(&mut world);
    let (found, _) = view.in_f64(&mut world);
    assert!(counts.null_interfaces > 1000 && counts.fresnel > 1000, "{counts:?}");
    assert_close(&expected, &found, 1e-12, 0, "tinted glass and fog");
}

/// Regression: the normal of a hit that rounding puts on the centre was not a number.
#[test]
fn a_hit_that_is_rounded_to_the_centre_of_a_tiny_sphere_faces_the_viewer() {
    let appearance = Appearance {
        materials: vec![Material::new(String::new(), crate::Phong::default())],
        lights: vec![lights().swap_remove(2)],
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
    let (expected, _) = view.one_by_one(&mut world);
    let (found, _) = view.in_lanes(LaneLevel::best(), &mut world);
    assert!(expected[0].hit && expected[0].radiance.max_component() > 0.1, "{expected:?}");
    assert_close(&expected, &found, 1e-6, 0, "tiny sphere");
}

#[test]
fn the_worlds_of_these_tests_have_all_cases() {
    let appearance = appearance(1.0);
    let mut world = shapes(&appearance, 1.0);
    let (seen, counts) =
        View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &camera_rays(2000, 1.0) }
            .one_by_one(&mut world);
    assert!(seen.iter().any(|seen| !seen.hit) && counts.shadow_rays_skipped > 1000 && counts.mirrors > 1000);
    assert!(counts.refractions > 300 && counts.fresnel > 200 && counts.absorption > 50, "{counts:?}");
    assert!(counts.null_interfaces > 20 && counts.highlights > 1000 && counts.depth_limited > 20, "{counts:?}");
}

#[test]
fn lanes_have_the_bits_of_single_hits_at_all_levels() {
    let appearance = appearance(1.0);
    let mut world = shapes(&appearance, 1.0);
    for features in features() {
        for n_rays in [1, 7, 8, 9, 255, 256, 257, 1000] {
            let rays = camera_rays(n_rays, 1.0);
            let view = View { features, appearance: &appearance, rays: &rays };
            let context = format!("{n_rays} rays, {features:?}");
            assert_same_at_all_levels(|level| view.in_lanes(level, &mut world), &context);
        }
    }
}

/// Regression: rays that had hit different spheres were not shaded together.
#[test]
fn spheres_of_a_material_share_lanes() {
    let Some(level) = LaneLevel::best() else { return };
    let mut appearance = appearance(1.0);
    appearance.materials.truncate(1);
    let mut world = ShapeWorld::new(0, 1.0);
    world.0.retain(|primitive| matches!(primitive.shape, TestShape::Sphere(_)));
    let rays = camera_rays(1000, 1.0);
    let view = View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &rays };
    let (seen, counts) = view.in_lanes(Some(level), &mut world);
    let n_hits = seen.iter().filter(|seen| seen.hit).count() as u64;
    let n_groups = seen.chunks(8).filter(|seen| seen.iter().any(|seen| seen.hit)).count() as u64;
    assert!(n_hits > 300, "{n_hits}");
    assert_eq!((counts.lanes_used, counts.lanes), (n_hits, 8 * n_groups));
}

/// Glass whose surfaces all spawn two rays, for trees with more rays than a wave has space for.
fn glass(n_lights: usize) -> Appearance {
    let mut appearance = all_materials();
    let spawns_two = |material: &Material| {
        material.interior.is_some_and(|medium| medium.ior > 1.0) && material.to_phong().transmission.is_some()
    };
    appearance.materials.retain(spawns_two);
    appearance.lights = lights().into_iter().cycle().take(n_lights).collect();
    appearance
}

#[test]
fn the_radiance_of_a_ray_depends_on_no_other_ray() {
    // From 65 lights on, waves have space for fewer rays. Fog has null interfaces, and attenuates shadow rays.
    for (n_lights, batch, has_fog, is_f64) in [
        (0, 256, false, false),
        (2, 256, true, false),
        (65, 248, false, true),
        (300, 48, true, true),
        (300, 5, false, false),
    ] {
        let mut appearance = glass(n_lights);
        if has_fog {
            appearance.materials.extend(self::appearance(1.0).materials.pop());
        }
        let n_materials = appearance.materials.len() as u32;
        let mut world = ShapeWorld::new(n_materials, 1.0);
        let rays = camera_rays(1000, 1.0);
        let media: Vec<_> = (0..rays.len() as u32)
            .map(
                |ray| if ray % 3 == 0 { InteriorList::filled_with(ray % n_materials) } else { InteriorList::default() },
            )
            .collect();
        // One integrator for batches of different sizes, the first and the last of which are alike.
        let whitted = Whitted::new(6, 1e-6, ShadingFeatures::ALL);
        let mut whitted = if is_f64 { whitted.in_f64() } else { whitted };
        let mut render = |size: usize| -> Rendered {
            let seen = rays.chunks(size).zip(media.chunks(size)).flat_map(|(rays, media)| {
                in_streams(rays, |_, rays, seen| {
                    whitted.set_camera_media(media);
                    whitted.radiance_of_stream(&mut world, &appearance, rays, seen);
                })
            });
            (seen.collect(), whitted.take_counts())
        };
        let (alone, expected) = render(1);
        for size in [batch, 7, batch] {
            let (together, counts) = render(size);
            let context = format!("{n_lights} lights, batches of {size}, fog: {has_fog}, f64: {is_f64}");
            assert_same_bits(&alone, &together, &context);
            assert_eq!(counts.without_lanes(), expected.without_lanes(), "{context}");
            assert!(counts.refractions > 2000 && (counts.null_interfaces > 500 || !has_fog), "{counts:?}");
        }
    }
}

/// Shares of rays whose radiance differs by more than 1e-5 and 1e-3 from that in `f64`.
fn differences_in_f32(scale: f64) -> [f64; 2] {
    let appearance = appearance(scale);
    let mut world = shapes(&appearance, scale);
    let rays = camera_rays(4000, scale);
    let view = View { features: ShadingFeatures::ALL, appearance: &appearance, rays: &rays };
    let (exact, _) = view.one_by_one(&mut world);
    let (found, _) = view.in_lanes(LaneLevel::best(), &mut world);
    shares_of_differences(&exact, &found, [1e-5, 1e-3])
}

#[test]
fn f32_differs_where_rays_take_another_way() {
    let [above_rounding, another_way] = differences_in_f32(1.0);
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
        let mut world = shapes(&appearance, scale);
        let rays = camera_rays(1000, scale);
        let features = ShadingFeatures { absorption: false, ..ShadingFeatures::ALL };
        let view = View { features, appearance: &appearance, rays: &rays };
        let (exact, _) = view.one_by_one(&mut world);
        let (found, _) = view.in_lanes(LaneLevel::best(), &mut world);
        assert_close(&exact, &found, 1e-3, 9, scale);
    }
}

#[test]
fn numbers_that_leave_the_range_of_f32_are_not_shaded_in_lanes() {
    let color = |r, g, b| ColorTexture::Constant(Rgb::new(r, g, b));
    let plain = Material::new(String::new(), Phong { diffuse: color(0.5, 0.6, 0.2), ..Phong::default() });
    let plain_scene = Appearance { materials: vec![plain], lights: lights(), ..Appearance::default() };
    let is_in_lanes =
        |appearance: &Appearance| LanePhongs::new(appearance, &ShadingFeatures::of(appearance, |_| true)).are_complete;
    assert!(is_in_lanes(&plain_scene));
    let mut bright = plain_scene.clone();
    bright.lights[0].intensity = Rgb::gray(1e20);
    let mut dense = plain_scene.clone();
    dense.materials[0].interior = Some(InteriorMedium::clear(1e6));
    let mut narrow = plain_scene.clone();
    for light in &mut narrow.lights {
        if let DeltaLightKind::Spot { cos_inner, cos_outer, .. } = &mut light.kind {
            (*cos_inner, *cos_outer) = (1.0, 1.0 - 1e-8);
        }
    }
    let sharp_phong = Phong { specular: ColorTexture::Constant(Rgb::WHITE), exponent: 1e5, ..Phong::default() };
    let mut sharp = plain_scene.clone();
    sharp.materials.push(Material::new(String::new(), sharp_phong));
    // Without lights, no highlight is computed; the choice is the same.
    let unlit = Appearance { lights: Vec::new(), ..sharp.clone() };
    for other in [bright, dense, narrow, sharp, unlit] {
        assert!(!is_in_lanes(&other), "{other:?}");
    }
}
