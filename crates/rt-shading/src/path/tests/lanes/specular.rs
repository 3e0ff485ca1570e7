//! Metals, mirrors and glass in lanes, compared with the reference.

use super::*;

/// Replaces materials of a scene.
type SceneChange = fn(TestScene) -> TestScene;

/// Some materials replaced by metals and a mirror, whose interpolated normals send directions to the wrong side of the surface.
fn with_metals(mut scene: TestScene) -> TestScene {
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

/// Some materials replaced by dielectrics, which overlap: clear, absorbing, tinted, of the index of air, and of another priority.
fn with_glass(scene: TestScene) -> TestScene {
    with_glasses(scene, [0.0; 5])
}

/// Version of [`with_glass`] for rough surfaces, one of them smooth.
fn with_rough_glass(scene: TestScene) -> TestScene {
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
    for (kinds, replaced) in
        LIT_BY.into_iter().flat_map(|kinds| [with_metals, with_glass, with_rough_glass].map(|with| (kinds, with)))
    {
        let mut scene = replaced(TestScene::new(kinds, 1.0));
        for transport in [Transport::Full, Transport::NonCaustic] {
            for (max_depth, rr_start_depth) in [(6, 2), (0, 9), (2, 0)] {
                let settings = PathSettings { transport, rr_start_depth, ..settings(max_depth) };
                let (expected, of_expected) = of_reference(&mut scene, settings, &rays);
                let (found, counts) = in_f64(&mut scene, settings, &rays);
                assert!(counts.lanes_used > 500, "{counts:?}");
                assert_eq!(of_expected.passages, counts.passages, "{kinds:?}, {settings:?}");
                // Of a light source itself, and of its reflection, rounding decides whether the source reaches a point or one next to it.
                let differs = |(a, b): &(&RadianceSample, &RadianceSample)| a.hit != b.hit || difference(a, b) > 1e-7;
                let differing: Vec<_> = expected.iter().zip(&found).filter(differs).collect();
                let most = if kinds.others { 4 } else { 0 };
                assert!(differing.len() <= most, "{differing:?}, {kinds:?}, {settings:?}");
            }
        }
    }
}

/// The radiance would be right as well if each hit were shaded by itself.
#[test]
fn a_metal_and_glass_are_shaded_in_lanes() {
    let rays = camera_rays(1500, 1.0);
    for (replaced, material) in
        [(with_metals as SceneChange, 1), (with_metals, 2), (with_glass, 1), (with_glass, 2), (with_rough_glass, 1)]
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
    for (kinds, replaced) in
        [(LIT_BY[1], with_metals as SceneChange), (LIT_BY[4], with_glass), (LIT_BY[4], with_rough_glass)]
    {
        let mut scene = replaced(TestScene::new(kinds, 1.0));
        let one = in_f32(&mut scene, None, settings(5), &rays);
        for level in [LaneLevel::avx2(), LaneLevel::best()].into_iter().flatten() {
            let lanes = in_f32(&mut scene, Some(level), settings(5), &rays);
            assert_eq!(one.1.without_lanes(), lanes.1.without_lanes(), "{level:?}, {kinds:?}");
            assert_same_bits(&one.0, &lanes.0, &format!("{level:?}, {kinds:?}"));
        }
    }
}
