//! Metals, mirrors and glass in lanes, compared with the reference.

use super::*;

/// Metals and a mirror, whose interpolated normals send directions to the wrong side of the surface.
pub(super) fn metals() -> [Material; 5] {
    let metal = |ior, roughness| MaterialModel::Conductor { ior, roughness };
    let tinted = ColorTexture::Constant(Rgb::new(0.9, 0.6, 0.3));
    let models = [
        metal(ComplexIor::GOLD, 0.3),
        metal(ComplexIor::SILVER, 0.0),
        metal(ComplexIor::COPPER, 1.0),
        metal(ComplexIor::CHROMIUM, 0.0),
        Phong { mirror: tinted, ..Phong::BLACK }.into(),
    ];
    models.map(|model| Material::new(String::new(), model))
}

/// Mixes with a mirror: with a diffuse lobe, smooth and rough, with a highlight, and with both.
pub(super) fn mirror_mixes() -> [Material; 5] {
    let of_color = |r, g, b| ColorTexture::Constant(Rgb::new(r, g, b));
    let (red, blue, gray) = (of_color(0.6, 0.1, 0.1), of_color(0.1, 0.2, 0.4), of_color(0.3, 0.3, 0.3));
    let phong = |diffuse, specular| Phong { diffuse, specular, mirror: gray, exponent: 30.0, ..Phong::BLACK };
    let rough = MaterialModel::Diffuse { albedo: blue, roughness: 0.6 };
    let mix = MaterialModel::Mix(vec![(0.7, rough), (0.3, MaterialModel::Mirror { reflectance: red })]);
    let models: [MaterialModel; 5] = [
        phong(red, ColorTexture::ZERO).into(),
        mix,
        phong(blue, of_color(8.0, 4.0, 6.0)).into(),
        phong(ColorTexture::ZERO, of_color(6.0, 6.0, 6.0)).into(),
        Phong { mirror: of_color(0.0, 1e-9, 0.0), ..phong(red, blue) }.into(),
    ];
    models.map(|model| Material::new(String::new(), model))
}

/// Dielectrics, which overlap: clear, absorbing, tinted, of the index of air, and of another priority.
pub(super) fn glass() -> [Material; 5] {
    of_glass([0.0; 5])
}

/// Version of [`glass`] for rough surfaces, one of them smooth.
pub(super) fn rough_glass() -> [Material; 5] {
    of_glass([0.1, 0.3, 0.5, 0.0, 1.0])
}

fn of_glass(roughnesses: [f64; 5]) -> [Material; 5] {
    let clear = InteriorMedium::clear(1.5);
    let media = [
        (Rgb::WHITE, clear),
        (Rgb::WHITE, InteriorMedium { absorption: Rgb::new(0.5, 0.1, 0.2), ..clear }),
        (Rgb::new(0.9, 0.5, 0.7), InteriorMedium { ior: 2.4, priority: 2, ..clear }),
        (Rgb::WHITE, InteriorMedium { ior: 1.0, absorption: Rgb::new(0.1, 0.5, 0.0), priority: 1 }),
        (Rgb::WHITE, InteriorMedium::clear(0.7)),
    ];
    core::array::from_fn(|at| {
        let ((transmittance, interior), roughness) = (media[at], roughnesses[at]);
        let transmittance = ColorTexture::Constant(transmittance);
        let model = MaterialModel::Dielectric { roughness, transmittance };
        Material { interior: Some(interior), ..Material::new(String::new(), model) }
    })
}

/// Regression: light from the front of a triangle of rough glass, but from behind its interpolated normal, was transmitted.
#[test]
fn light_on_whose_side_normals_disagree_is_not_transmitted() {
    let mut scene = TestScene::new(LIT_BY[2], 1.0);
    let mut shape =
        TestShape::triangle([DVec3::new(-3.0, 0.0, 3.0), DVec3::new(3.0, 0.0, 3.0), DVec3::new(0.0, 0.0, -3.0)]);
    if let TestShape::Triangle(StreamTriangle { normal, vertex_normals, .. }, _) = &mut shape {
        assert_eq!(*normal, DVec3::Y);
        *vertex_normals = Some([DVec3::new(-1.0, 1.0, 0.0).normalize().as_vec3(); 3]);
    }
    scene.world = ShapeWorld(vec![TestPrimitive { shape, material: 0, light: None }]);
    scene.appearance.materials = of_glass([1.0; 5])[..1].to_vec();
    let light = |position| {
        let kind = DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 };
        Light::Delta(DeltaLight { casts_shadows: false, ..DeltaLight::new(kind, Rgb::WHITE) })
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
        let is_as_lit = |seen: &RadianceSample| seen.hit && (seen.radiance.max_component() > 0.0) == is_lit;
        assert!(expected.iter().all(is_as_lit), "{expected:?}");
        assert_close(&expected, &found, 1e-7, 0, position);
    }
}

/// A light of almost no radiance keeps all hits out of lanes.
#[test]
fn specular_lobes_are_followed_as_from_hits_one_by_one() {
    let rays = camera_rays(1500, 1.0);
    let settings = PathSettings { transport: Transport::Specular, ..settings(5) };
    let all = [metals, mirror_mixes, rough_glass, layered::layers];
    for (kinds, materials) in LIT_BY.into_iter().flat_map(|kinds| all.map(|materials| (kinds, materials))) {
        let mut scene = TestScene::with_materials(kinds, materials);
        scene.appearance.ambient = Rgb::gray(0.1);
        let (found, counts) = in_f64(&mut scene, settings, &rays);
        let kind = DeltaLightKind::Directional { direction: DVec3::Y };
        let dark = DeltaLight { units: LightUnits::Physical, ..DeltaLight::new(kind, Rgb::gray(1e-100)) };
        let lights = scene.lights.lights().iter().cloned().chain([Light::Delta(dark)]).collect();
        scene.lights = LightSet::new(lights, LightSampling::Tree, 10.0);
        let (expected, counts_of_one) = in_f64(&mut scene, settings, &rays);
        assert!(counts.lanes_used > 500 && counts_of_one.lanes == 0, "{counts:?}, {counts_of_one:?}");
        assert_close(&expected, &found, 1e-7, if kinds.others { 4 } else { 0 }, kinds);
    }
}
