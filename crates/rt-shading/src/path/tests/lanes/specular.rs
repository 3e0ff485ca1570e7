//! Metals, mirrors and glass in lanes, compared with the reference.

use super::*;

/// Replaces materials of a scene.
type SceneChange = fn(TestScene) -> TestScene;

/// Some materials replaced by metals and a mirror, whose interpolated normals send directions to the wrong side of the surface.
pub(super) fn with_metals(mut scene: TestScene) -> TestScene {
    let metal = |ior, roughness| MaterialModel::Conductor { ior, roughness };
    let tinted = ColorTexture::Constant(Rgb::new(0.9, 0.6, 0.3));
    let metals = [
        metal(ComplexIor::GOLD, 0.3),
        metal(ComplexIor::SILVER, 0.0),
        metal(ComplexIor::COPPER, 1.0),
        metal(ComplexIor::CHROMIUM, 0.0),
    ];
    let metals = metals.map(|model| Material::new(String::new(), model));
    let mirror = Material::new(String::new(), Phong { mirror: tinted, ..Phong::BLACK });
    for (material, metal) in scene.appearance.materials[1..].iter_mut().zip(metals.into_iter().chain([mirror])) {
        *material = metal;
    }
    scene
}

/// Some materials replaced by mixes with a mirror: with a diffuse lobe, smooth and rough, with a highlight, and with both.
pub(super) fn with_mirror_mixes(mut scene: TestScene) -> TestScene {
    let of_color = |r, g, b| ColorTexture::Constant(Rgb::new(r, g, b));
    let (red, blue, gray) = (of_color(0.6, 0.1, 0.1), of_color(0.1, 0.2, 0.4), of_color(0.3, 0.3, 0.3));
    let phong = |diffuse, specular| Phong { diffuse, specular, mirror: gray, exponent: 30.0, ..Phong::BLACK };
    let rough = MaterialModel::Diffuse { albedo: blue, roughness: 0.6 };
    let mix = MaterialModel::Mix(vec![(0.7, rough), (0.3, MaterialModel::Mirror { reflectance: red })]);
    let mixes: [MaterialModel; 5] = [
        phong(red, ColorTexture::ZERO).into(),
        mix,
        phong(blue, of_color(8.0, 4.0, 6.0)).into(),
        phong(ColorTexture::ZERO, of_color(6.0, 6.0, 6.0)).into(),
        Phong { mirror: of_color(0.0, 1e-9, 0.0), ..phong(red, blue) }.into(),
    ];
    for (material, mix) in scene.appearance.materials[1..].iter_mut().zip(mixes) {
        *material = Material::new(String::new(), mix);
    }
    scene
}

/// Some materials replaced by dielectrics, which overlap: clear, absorbing, tinted, of the index of air, and of another priority.
fn with_glass(scene: TestScene) -> TestScene {
    with_glasses(scene, [0.0; 5])
}

/// Version of [`with_glass`] for rough surfaces, one of them smooth.
pub(super) fn with_rough_glass(scene: TestScene) -> TestScene {
    with_glasses(scene, [0.1, 0.3, 0.5, 0.0, 1.0])
}

fn with_glasses(mut scene: TestScene, roughnesses: [f64; 5]) -> TestScene {
    let clear = InteriorMedium::clear(1.5);
    let glass = |transmittance, interior| {
        let transmittance = ColorTexture::Constant(transmittance);
        let model = MaterialModel::Dielectric { roughness: 0.0, transmittance };
        Material { interior: Some(interior), ..Material::new(String::new(), model) }
    };
    let glasses = [
        glass(Rgb::WHITE, clear),
        glass(Rgb::WHITE, InteriorMedium { absorption: Rgb::new(0.5, 0.1, 0.2), ..clear }),
        glass(Rgb::new(0.9, 0.5, 0.7), InteriorMedium { ior: 2.4, priority: 2, ..clear }),
        glass(Rgb::WHITE, InteriorMedium { ior: 1.0, absorption: Rgb::new(0.1, 0.5, 0.0), priority: 1 }),
        glass(Rgb::WHITE, InteriorMedium::clear(0.7)),
    ];
    let materials = scene.appearance.materials[1..].iter_mut();
    for ((material, glass), of_surface) in materials.zip(glasses).zip(roughnesses) {
        *material = glass;
        if let MaterialModel::Dielectric { roughness, .. } = &mut material.model {
            *roughness = of_surface;
        }
    }
    scene
}

#[test]
fn specular_surfaces_in_f64_have_the_radiance_of_the_reference() {
    let rays = camera_rays(1500, 1.0);
    let all = [with_metals as SceneChange, with_mirror_mixes, with_glass, with_rough_glass];
    for (kinds, replaced) in LIT_BY.into_iter().flat_map(|kinds| all.map(|with| (kinds, with))) {
        let mut scene = replaced(TestScene::new(kinds, 1.0));
        assert_radiance_of_reference(&mut scene, kinds, &rays);
    }
}

/// Regression: light from the front of a triangle of rough glass, but from behind its interpolated normal, was transmitted.
#[test]
fn light_on_whose_side_normals_disagree_is_not_transmitted() {
    let mut scene = with_rough_glass(TestScene::new(LIT_BY[2], 1.0));
    let mut shape =
        TestShape::triangle([DVec3::new(-3.0, 0.0, 3.0), DVec3::new(3.0, 0.0, 3.0), DVec3::new(0.0, 0.0, -3.0)]);
    if let TestShape::Triangle(StreamTriangle { normal, vertex_normals, .. }, _) = &mut shape {
        assert_eq!(*normal, DVec3::Y);
        *vertex_normals = Some([DVec3::new(-1.0, 1.0, 0.0).normalize().as_vec3(); 3]);
    }
    scene.world = ShapeWorld(vec![TestPrimitive { shape, material: 0, light: None }]);
    scene.appearance.materials = vec![scene.appearance.materials[1].clone()];
    if let MaterialModel::Dielectric { roughness, .. } = &mut scene.appearance.materials[0].model {
        *roughness = 1.0;
    }
    let light = |position| {
        let kind = DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 };
        let (intensity, units) = (Rgb::WHITE, LightUnits::Classical);
        Light::Delta(DeltaLight { name: String::new(), kind, intensity, units, casts_shadows: false })
    };
    let eye = DVec3::new(-5.0, 0.6, 0.0);
    let ray =
        |at: u32| (Ray::new(eye, vector(u64::from(at), 7) * 0.3 * DVec3::new(1.0, 0.0, 1.0) - eye), Interval::FORWARD);
    let rays: Vec<_> = (0..64).map(ray).collect();
    for (position, is_lit) in [(DVec3::new(5.0, 0.6, 0.0), false), (DVec3::new(5.0, -5.0, 0.0), true)] {
        scene.lights = LightSet::new(vec![light(position)], LightSampling::Tree, 10.0);
        let (expected, _) = of_reference(&mut scene, settings(0), &rays);
        let (found, counts) = in_f64(&mut scene, settings(0), &rays);
        assert!(counts.lanes_used >= 64, "{counts:?}");
        for (expected, found) in expected.iter().zip(&found) {
            assert_eq!(expected.radiance.max_component() > 0.0, is_lit, "{expected:?}");
            assert!(expected.hit && found.hit && difference(expected, found) < 1e-7, "{expected:?}, {found:?}");
        }
    }
}

/// The radiance would be right as well if each hit were shaded by itself.
#[test]
fn a_metal_and_glass_are_shaded_in_lanes() {
    let rays = camera_rays(1500, 1.0);
    for (replaced, material) in
        [(with_metals as SceneChange, 1), (with_metals, 2), (with_glass, 1), (with_glass, 2), (with_rough_glass, 1)]
            .into_iter()
            .chain([1, 2, 3, 4, 5].map(|material| (with_mirror_mixes as SceneChange, material)))
    {
        let mut scene = replaced(TestScene::new(LIT_BY[3], 1.0));
        let sphere = TestShape::Sphere(Sphere::new(DVec3::ZERO, 3.0).expect("a sphere"));
        scene.world = ShapeWorld(vec![TestPrimitive { shape: sphere, material, light: None }]);
        let (seen, counts) = in_f32(&mut scene, None, settings(5), &rays);
        let n_hits = seen.iter().filter(|seen| seen.hit).count() as u64;
        // Refracted rays hit the sphere again, from inside.
        let min_used =
            if scene.appearance.materials[material as usize].interior.is_some() { 3 * n_hits / 2 } else { n_hits };
        assert!(n_hits > 500 && counts.lanes_used >= min_used, "{n_hits}, {counts:?}");
    }
}

#[test]
fn specular_surfaces_have_the_bits_of_single_hits_at_all_levels() {
    let rays = camera_rays(600, 1.0);
    for (kinds, replaced) in [
        (LIT_BY[1], with_metals as SceneChange),
        (LIT_BY[4], with_mirror_mixes),
        (LIT_BY[4], with_glass),
        (LIT_BY[4], with_rough_glass),
    ] {
        let mut scene = replaced(TestScene::new(kinds, 1.0));
        assert_same_bits_at_all_levels(&mut scene, settings(5), &rays, &format!("{kinds:?}"));
    }
}

/// A light of almost no radiance keeps all hits out of lanes.
#[test]
fn specular_lobes_are_followed_as_from_hits_one_by_one() {
    let rays = camera_rays(1500, 1.0);
    let settings = PathSettings { transport: Transport::Specular, ..settings(5) };
    let all = [with_metals as SceneChange, with_mirror_mixes, with_rough_glass, layered::with_layers];
    for (kinds, replaced) in LIT_BY.into_iter().flat_map(|kinds| all.map(|with| (kinds, with))) {
        let mut scene = replaced(TestScene::new(kinds, 1.0));
        scene.appearance.ambient = Rgb::gray(0.1);
        let (found, counts) = in_f64(&mut scene, settings, &rays);
        let kind = DeltaLightKind::Directional { direction: DVec3::Y };
        let (name, intensity, units) = (String::new(), Rgb::gray(1e-100), LightUnits::Physical);
        let dark = Light::Delta(DeltaLight { name, kind, intensity, units, casts_shadows: false });
        let lights = scene.lights.lights().iter().cloned().chain([dark]).collect();
        scene.lights = LightSet::new(lights, LightSampling::Tree, 10.0);
        let (expected, counts_of_one) = in_f64(&mut scene, settings, &rays);
        assert!(counts.lanes_used > 500 && counts_of_one.lanes == 0, "{counts:?}, {counts_of_one:?}");
        let differs = |(a, b): &(&RadianceSample, &RadianceSample)| a.hit != b.hit || difference(a, b) > 1e-7;
        let differing: Vec<_> = expected.iter().zip(&found).filter(differs).collect();
        let most = if kinds.others { 4 } else { 0 };
        assert!(differing.len() <= most, "{differing:?}, {kinds:?}");
    }
}
