//! Shading of primitives in lanes, compared with the reference, which shades one hit at a time in `f64`.

use super::{Independent, PathSettings, mean_and_error, metallic_roughness, paths as settings};
use crate::{
    Appearance, Background, BsdfCache, ColorTexture, DeltaLight, DeltaLightKind, Falloff, InteriorList, InteriorMedium,
    LaneLevel, LightUnits, Material, MaterialModel, PathTracer, Phong, RadianceSample, ReferencePathTracer,
    ShadingCounts, ShadingFeatures, StreamTriangle, Transport,
    bsdf::ComplexIor,
    light::{
        Emission, EmissionSides, EnvironmentLight, Light, LightId, LightSampling, LightSet, MeshLight, QuadLight,
        SphereLight,
    },
    path::{Clamp, Lighting, lane_material::LaneMaterials},
    wavefront::test_world::{
        Rendered, ShapeWorld, TestPrimitive, TestShape, assert_close, assert_same_at_all_levels, camera_rays,
        in_streams, number, shares_of_differences, vector,
    },
};
use rt_geometry::{RayStream, Sphere};
use rt_math::{DVec3, Interval, Ray, Rgb};

/// Diffuse materials: of the shapes, of the lights, and one that emits without being a light.
fn materials() -> Vec<Material> {
    let diffuse = |at: u64| {
        let albedo = Rgb::new(number(at, 50), number(at, 51), number(at, 52));
        Material::new(String::new(), Phong { diffuse: ColorTexture::Constant(albedo), ..Phong::default() })
    };
    let emitting = |at: u64, radiance: Rgb, sides: EmissionSides| Material {
        emission: ColorTexture::Constant(radiance),
        emission_sides: sides,
        ..diffuse(at)
    };
    let black = Phong { diffuse: ColorTexture::ZERO, ..Phong::default() };
    let mut materials: Vec<_> = (0..6).map(diffuse).collect();
    materials.push(Material::new(String::new(), black));
    materials.push(emitting(7, Rgb::new(0.1, 0.2, 0.0), EmissionSides::Front));
    materials.push(emitting(8, LIGHT, EmissionSides::Both));
    materials.push(emitting(9, LIGHT, EmissionSides::Front));
    materials
}

/// Materials of lights, which emit on both sides, and on the front. Those before are of other shapes.
const EMITTERS: [u32; 2] = [8, 9];

/// Index of no material.
const MISSING: u32 = 99;

/// Radiance of all lights.
const LIGHT: Rgb = Rgb::new(7.0, 5.0, 3.0);

/// World with lights of some kinds.
struct TestScene {
    world: ShapeWorld,
    appearance: Appearance,
    lights: LightSet,
    features: ShadingFeatures,
}

/// Kinds of lights in a [`TestScene`].
#[derive(Clone, Copy, Debug)]
struct LightKinds {
    quad: bool,
    others: bool,
    delta: bool,
    sky: bool,
}

const LIT_BY: [LightKinds; 5] = [
    LightKinds { quad: true, others: false, delta: false, sky: false },
    LightKinds { quad: true, others: true, delta: true, sky: false },
    LightKinds { quad: false, others: false, delta: true, sky: false },
    LightKinds { quad: false, others: false, delta: false, sky: true },
    LightKinds { quad: true, others: true, delta: true, sky: true },
];

impl TestScene {
    fn new(kinds: LightKinds, scale: f64) -> Self {
        let emission = |sides| Emission::new(LIGHT, sides).expect("light");
        let mut world = ShapeWorld::new(EMITTERS[0], scale).with_shading_normals();
        for primitive in world.0.iter_mut().filter(|primitive| primitive.material == EMITTERS[0]) {
            primitive.material = MISSING;
        }
        let mut lights = Vec::new();
        let mut add = |light: Light, triangle: Option<u32>, shapes: Vec<TestShape>, material| {
            let light_id = LightId { index: lights.len() as u32, triangle };
            world.0.extend(shapes.into_iter().map(|shape| TestPrimitive { shape, material, light: Some(light_id) }));
            lights.push(light);
        };
        if kinds.quad {
            let [corner, x, y] = [DVec3::new(-1.0, 4.0, -1.0), DVec3::X * 2.0, DVec3::Z * 2.0].map(|v| v * scale);
            let quad = QuadLight::new(corner, [x, y], emission(EmissionSides::Both)).expect("a light");
            let [a, b, c] = [corner + x, corner + x + y, corner + y];
            add(
                Light::Quad(quad),
                None,
                vec![TestShape::triangle([corner, a, b]), TestShape::triangle([corner, b, c])],
                EMITTERS[0],
            );
        }
        if kinds.others {
            let (centre, radius) = (DVec3::new(3.0, 2.0, 1.0) * scale, 0.5 * scale);
            let sphere = SphereLight::new(centre, radius, emission(EmissionSides::Front)).expect("a light");
            let shape = TestShape::Sphere(Sphere::new(centre, radius).expect("a sphere"));
            add(Light::Sphere(sphere), None, vec![shape], EMITTERS[1]);
            let triangle = [DVec3::new(-4.0, 1.0, 2.0), DVec3::new(-4.0, 2.0, 2.0), DVec3::new(-3.0, 1.5, 3.0)];
            let triangle = triangle.map(|v| v * scale);
            let mesh = MeshLight::new([triangle], emission(EmissionSides::Both)).expect("a light");
            add(Light::Mesh(mesh), Some(0), vec![TestShape::triangle(triangle)], EMITTERS[0]);
        }
        let mut background = Background::Constant(Rgb::BLACK);
        if kinds.sky {
            let radiance = Rgb::new(0.3, 0.4, 0.6);
            lights.push(Light::Environment(EnvironmentLight::constant(radiance).expect("a light")));
            background = Background::Constant(radiance);
        }
        if kinds.delta {
            let delta = |kind, casts_shadows| {
                Light::Delta(DeltaLight { casts_shadows, ..DeltaLight::new(kind, Rgb::new(2.0, 1.5, 1.0)) })
            };
            let position = DVec3::new(1.0, 3.5, 2.0) * scale;
            lights.push(delta(DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 }, true));
            lights.push(delta(DeltaLightKind::Directional { direction: DVec3::new(0.6, -0.8, 0.0) }, true));
            lights.push(delta(DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 }, false));
        }
        let lights = LightSet::new(lights, LightSampling::Tree, 10.0 * scale);
        let appearance = Appearance { materials: materials(), background, ..Appearance::default() };
        Self { world, appearance, lights, features: ShadingFeatures::ALL }
    }

    /// Scene with some materials replaced.
    fn with_materials(kinds: LightKinds, materials: fn() -> [Material; 5]) -> Self {
        let mut scene = Self::new(kinds, 1.0);
        scene.appearance.materials[1..6].clone_from_slice(&materials());
        scene
    }

    fn sphere(kinds: LightKinds, material: Material) -> Self {
        let mut scene = Self::new(kinds, 1.0);
        let shape = TestShape::Sphere(Sphere::new(DVec3::ZERO, 3.0).expect("a sphere"));
        scene.world = ShapeWorld(vec![TestPrimitive { shape, material: 0, light: None }]);
        scene.appearance.materials = vec![material];
        scene
    }

    /// True if a material is shaded in lanes under the lights of the scene.
    fn has_in_lanes(&self, material: Material) -> bool {
        let appearance = Appearance { materials: vec![material], ..self.appearance.clone() };
        let lighting = Lighting { appearance: &appearance, lights: &self.lights, bsdfs: &BsdfCache::default() };
        LaneMaterials::new(lighting, Transport::Full, &ShadingFeatures::ALL).get(0).is_some()
    }
}

/// Materials that replace diffuse ones.
const REPLACED: [fn() -> [Material; 5]; 6] = [
    specular::metals,
    specular::mirror_mixes,
    specular::glass,
    specular::rough_glass,
    layered::layers,
    layered::black_layers,
];

fn samplers(count: usize) -> Vec<Independent> {
    (0..count as u64).map(|key| Independent { key, dimension: 0 }).collect()
}

/// Radiance of camera rays.
fn traced(scene: &mut TestScene, mut paths: PathTracer, rays: &[(Ray, Interval)]) -> Rendered {
    let TestScene { world, appearance, lights, .. } = scene;
    let bsdfs = BsdfCache::default();
    let lighting = Lighting { appearance, lights, bsdfs: &bsdfs };
    let samplers = samplers(rays.len());
    let seen = in_streams(rays, |range, rays, seen| {
        paths.radiance_of_stream(world, lighting, rays, &mut samplers[range].to_vec(), seen);
    });
    (seen, paths.take_counts())
}

fn in_f64(scene: &mut TestScene, settings: PathSettings, rays: &[(Ray, Interval)]) -> Rendered {
    let paths = PathTracer::new(settings, scene.features).in_f64();
    traced(scene, paths, rays)
}

/// Radiance in `f32`, in lanes of a level or one by one.
fn in_f32(
    scene: &mut TestScene,
    level: Option<LaneLevel>,
    settings: PathSettings,
    rays: &[(Ray, Interval)],
) -> Rendered {
    let mut paths = PathTracer::new(settings, scene.features);
    paths.set_lanes(level);
    traced(scene, paths, rays)
}

/// Radiance by the reference integrator, and its counts of clamped contributions.
fn of_reference(scene: &mut TestScene, settings: PathSettings, rays: &[(Ray, Interval)]) -> Rendered {
    let bsdfs = BsdfCache::default();
    let TestScene { world, appearance, lights, .. } = scene;
    let lighting = Lighting { appearance, lights, bsdfs: &bsdfs };
    let (camera_media, counts) = (InteriorList::default(), ShadingCounts::default());
    let mut reference = ReferencePathTracer { settings, lighting, camera_media, counts };
    let li = |((ray, _), mut sampler): (&(Ray, Interval), Independent)| reference.li(world, ray, &mut sampler);
    let seen = rays.iter().zip(samplers(rays.len())).map(li).collect();
    (seen, reference.counts)
}

/// Asserts that the radiance in `f64`, of hits in lanes, is that of the reference, with different transport and depths.
fn assert_radiance_of_reference(scene: &mut TestScene, kinds: LightKinds, rays: &[(Ray, Interval)]) {
    for transport in [Transport::Full, Transport::NonCaustic] {
        for (max_depth, rr_start_depth) in [(6, 2), (0, 9), (2, 0)] {
            let settings = PathSettings { transport, rr_start_depth, ..settings(max_depth) };
            let (expected, of_expected) = of_reference(scene, settings, rays);
            let (found, counts) = in_f64(scene, settings, rays);
            assert!(counts.lanes_used > 500, "{counts:?}");
            assert_eq!(of_expected.null_interfaces, counts.null_interfaces, "{kinds:?}, {settings:?}");
            // Of a light source itself, and of its reflection, rounding decides whether the source reaches a point or one next to it.
            assert_close(&expected, &found, 1e-7, if kinds.others { 4 } else { 0 }, (kinds, settings));
        }
    }
}

#[test]
fn shading_in_f64_gives_the_radiance_of_the_reference() {
    let rays = camera_rays(1500, 1.0);
    for kinds in LIT_BY {
        for (max_depth, clamp) in [(5, Clamp::NONE), (0, Clamp::NONE), (3, Clamp::new(0.2).expect("a bound"))] {
            let settings = PathSettings { clamp, ..settings(max_depth) };
            let mut scene = TestScene::new(kinds, 1.0);
            let (expected, counts) = of_reference(&mut scene, settings, &rays);
            let (found, found_counts) = in_f64(&mut scene, settings, &rays);
            assert_eq!(counts.clamped, found_counts.clamped, "{kinds:?}, {settings:?}");
            // On a light source, rounding decides whether the source itself reaches a point or one next to it.
            assert_close(&expected, &found, 1e-9, if kinds.others { 3 } else { 0 }, (kinds, settings));
        }
    }
}

/// Covers features that a plan leaves out, other choices of lights, other delta lights, and roulette from the start.
#[test]
fn shading_in_f64_agrees_with_the_reference_for_other_settings() {
    let rays = camera_rays(600, 1.0);
    let compare = |scene: &mut TestScene, settings: PathSettings| {
        let (expected, _) = of_reference(scene, settings, &rays);
        let (found, counts) = in_f64(scene, settings, &rays);
        assert_close(&expected, &found, 1e-9, 0, settings);
        counts
    };
    let mut unlit = TestScene::new(LIT_BY[2], 1.0);
    for material in &mut unlit.appearance.materials {
        material.emission = ColorTexture::ZERO;
    }
    unlit.features.emission = false;
    assert!(compare(&mut unlit, settings(1)).depth_limited > 100);
    let mut scene = TestScene::new(LIT_BY[1], 1.0);
    let settings = settings(4);
    compare(&mut scene, PathSettings { transport: Transport::NonCaustic, rr_start_depth: 0, ..settings });
    for sampling in [LightSampling::Uniform, LightSampling::Power] {
        scene.lights = LightSet::new(scene.lights.lights().to_vec(), sampling, 10.0);
        compare(&mut scene, settings);
    }
    let position = DVec3::new(0.5, 3.0, 1.0);
    let kinds = [
        DeltaLightKind::Point { position, falloff: Falloff::InverseSquare, shadow_near: 0.5 },
        DeltaLightKind::Spot {
            position,
            direction: DVec3::NEG_Y,
            cos_inner: 0.9,
            cos_outer: 0.5,
            falloff: Falloff::InverseSquare,
        },
    ];
    let lights = kinds
        .map(|kind| Light::Delta(DeltaLight { units: LightUnits::Physical, ..DeltaLight::new(kind, Rgb::gray(30.0)) }));
    scene.lights = LightSet::new(lights.to_vec(), LightSampling::Tree, 10.0);
    scene.appearance.background = Background::Gradient { bottom: Rgb::gray(0.1), top: Rgb::new(0.2, 0.4, 0.9) };
    compare(&mut scene, settings);
}

#[test]
fn the_scenes_of_these_tests_have_all_cases() {
    let rays = camera_rays(1500, 1.0);
    for kinds in LIT_BY {
        let mut scene = TestScene::new(kinds, 1.0);
        let (seen, counts) = in_f64(&mut scene, settings(5), &rays);
        let lit = seen.iter().filter(|seen| seen.radiance.max_component() > 0.0).count();
        let missed = seen.iter().filter(|seen| !seen.hit).count();
        assert!(lit > 700 && missed > 100, "{lit}, {missed}, {kinds:?}");
        assert!(counts.shadow_rays_skipped > 100, "{counts:?}, {kinds:?}");
        let clamped = PathSettings { clamp: Clamp::new(0.2).expect("a bound"), ..settings(3) };
        let (_, clamped) = in_f64(&mut scene, clamped, &rays);
        assert!(clamped.clamped > 10, "{clamped:?}, {kinds:?}");
    }
}

#[test]
fn lanes_have_the_bits_of_single_hits_at_all_levels() {
    for kinds in LIT_BY {
        for n_rays in [1, 7, 8, 9, 255, 257, 600] {
            let rays = camera_rays(n_rays, 1.0);
            let mut scene = TestScene::new(kinds, 1.0);
            let context = format!("{n_rays} rays, {kinds:?}");
            assert_same_at_all_levels(|level| in_f32(&mut scene, level, settings(5), &rays), &context);
        }
    }
}

#[test]
fn all_materials_in_f64_have_the_radiance_of_the_reference() {
    let rays = camera_rays(1500, 1.0);
    for (kinds, materials) in LIT_BY.into_iter().flat_map(|kinds| REPLACED.map(|materials| (kinds, materials))) {
        assert_radiance_of_reference(&mut TestScene::with_materials(kinds, materials), kinds, &rays);
    }
}

#[test]
fn all_materials_have_the_bits_of_single_hits_at_all_levels() {
    let rays = camera_rays(600, 1.0);
    for (kinds, materials) in [LIT_BY[1], LIT_BY[4]].into_iter().flat_map(|kinds| REPLACED.map(|with| (kinds, with))) {
        let mut scene = TestScene::with_materials(kinds, materials);
        assert_same_at_all_levels(|level| in_f32(&mut scene, level, settings(5), &rays), &format!("{kinds:?}"));
    }
}

/// The radiance would be right as well if each hit were shaded by itself.
#[test]
fn all_materials_are_shaded_in_lanes() {
    let rays = camera_rays(1500, 1.0);
    let is_visible = |material: &Material| material.interior.is_none_or(|interior| interior.ior != 1.0);
    for material in REPLACED.into_iter().flat_map(|materials| materials()).filter(is_visible) {
        let mut scene = TestScene::sphere(LIT_BY[3], material);
        let (seen, counts) = in_f32(&mut scene, None, settings(5), &rays);
        let n_hits = seen.iter().filter(|seen| seen.hit).count() as u64;
        let material = &scene.appearance.materials[0];
        // Refracted rays hit the sphere again, from inside.
        let min_used = if material.interior.is_some() { 3 * n_hits / 2 } else { n_hits };
        assert!(n_hits > 500 && counts.lanes_used >= min_used, "{n_hits}, {counts:?}, {material:?}");
    }
}

/// Shares of rays whose radiance differs by more than 1e-4 and 1e-2 from that in `f64`.
fn differences_in_f32(scale: f64) -> [f64; 2] {
    let rays = camera_rays(3000, scale);
    let mut scene = TestScene::new(LIT_BY[1], scale);
    let (exact, _) = of_reference(&mut scene, settings(5), &rays);
    let (found, _) = in_f32(&mut scene, None, settings(5), &rays);
    shares_of_differences(&exact, &found, [1e-4, 1e-2])
}

#[test]
fn f32_differs_where_paths_take_another_way() {
    let [above_rounding, another_way] = differences_in_f32(1.0);
    assert!(above_rounding < 0.02 && another_way < 0.003, "{above_rounding}, {another_way}");
}

#[test]
fn tiny_and_huge_scenes_do_not_leave_the_range_of_f32() {
    for scale in [1e-25, 1e-15, 1e15, 1e25] {
        let [_, another_way] = differences_in_f32(scale);
        assert!(another_way < 0.01, "{another_way} at scale {scale}");
    }
}

/// Regression: lights were sampled from the point on the surface, and weighted for a point next to it. Rounding puts points of a sphere
/// on either side of it, where its samples differ.
#[test]
fn the_radiance_in_a_closed_light_source_is_that_of_the_series() {
    let emission = Emission::new(Rgb::WHITE, EmissionSides::Both).expect("light");
    let (centre, radius) = (DVec3::new(0.3, -0.7, 1.1), 1.3);
    let source = SphereLight::new(centre, radius, emission).expect("a light");
    let shape = TestShape::Sphere(Sphere::new(centre, radius).expect("a sphere"));
    let grey = Phong { diffuse: ColorTexture::Constant(Rgb::gray(0.5)), ..Phong::default() };
    let material = Material { emission: ColorTexture::Constant(Rgb::WHITE), ..Material::new(String::new(), grey) };
    let light = Some(LightId { index: 0, triangle: None });
    let mut scene = TestScene {
        world: ShapeWorld(vec![TestPrimitive { shape, material: 0, light }]),
        appearance: Appearance { materials: vec![material], ..Appearance::default() },
        lights: LightSet::new(vec![Light::Sphere(source)], LightSampling::Tree, 1.0),
        features: ShadingFeatures::ALL,
    };
    let rays: Vec<_> =
        (0..100_000).map(|key| (Ray::new(DVec3::new(0.1, 0.2, 0.3), vector(key, 90)), Interval::FORWARD)).collect();
    let (seen, _) = in_f32(&mut scene, None, settings(100), &rays);
    let (mean, error) = mean_and_error(&seen);
    // 1 / (1 − ½)
    assert!((mean - 2.0).abs() < 4.0 * error && error < 0.003, "{mean} ± {error}");
}

/// Regression: only surfaces of which lanes know the material were kept out of lanes.
#[test]
fn lights_out_of_the_range_of_f32_keep_all_hits_out_of_lanes() {
    let rays = camera_rays(1500, 1.0);
    let mut scene = TestScene::new(LIT_BY[2], 1.0);
    let position = DVec3::new(0.5, 300.0, 1.0);
    let kind = DeltaLightKind::Spot {
        position,
        direction: DVec3::NEG_Y,
        cos_inner: 1.0 - 1e-5,
        cos_outer: 1.0 - 5e-5,
        falloff: Falloff::None,
    };
    let spot = DeltaLight { units: LightUnits::Physical, ..DeltaLight::new(kind, Rgb::gray(30.0)) };
    scene.lights = LightSet::new(vec![Light::Delta(spot)], LightSampling::Tree, 10.0);
    let (exact, _) = of_reference(&mut scene, settings(5), &rays);
    let (found, counts) = in_f32(&mut scene, LaneLevel::best(), settings(5), &rays);
    let lit = exact.iter().filter(|seen| seen.radiance.max_component() > 0.0).count();
    assert!(lit > 300 && counts.lanes == 0, "{lit}, {counts:?}");
    assert_close(&exact, &found, 1e-5, 0, "narrow spot");
}

#[test]
fn a_call_with_too_few_samplers_does_nothing() {
    let mut scene = TestScene::new(LIT_BY[0], 1.0);
    let bsdfs = BsdfCache::default();
    let mut stream = RayStream::default();
    camera_rays(3, 1.0).iter().for_each(|(ray, span)| stream.push(ray, *span));
    let mut paths = PathTracer::new(settings(1), ShadingFeatures::ALL);
    let marked = RadianceSample { radiance: Rgb::gray(9.0), hit: false };
    let mut seen = [marked; 3];
    let TestScene { world, appearance, lights, .. } = &mut scene;
    let lighting = Lighting { appearance, lights, bsdfs: &bsdfs };
    paths.radiance_of_stream(world, lighting, &mut stream, &mut samplers(2), &mut seen);
    assert_eq!(seen, [marked; 3]);
    paths.radiance_of_stream(world, lighting, &mut stream, &mut samplers(3), &mut seen);
    assert!(seen.iter().all(|seen| *seen != marked));
}

#[test]
fn narrow_lobes_textured_materials_and_numbers_out_of_the_range_of_f32_are_not_shaded_in_lanes() {
    let scene = TestScene::new(LIT_BY[1], 1.0);
    let in_lanes = |material| scene.has_in_lanes(material);
    let plain = &scene.appearance.materials[1];
    let of_model = |model: MaterialModel| Material { model, ..plain.clone() };
    let grey = ColorTexture::Constant(Rgb::gray(0.5));
    let glossy = |exponent| of_model(MaterialModel::Glossy { diffuse: grey, specular: grey, exponent });
    let glowing = |emission| Material { emission, ..plain.clone() };
    assert!(scene.appearance.materials.iter().all(|material| in_lanes(material.clone())));
    for other in [glossy(30.0), of_model(MaterialModel::Diffuse { albedo: grey, roughness: 0.3 })] {
        assert!(in_lanes(other.clone()), "{other:?}");
    }
    assert!(in_lanes(of_model(metallic_roughness(0.5, 0.3))));
    let gold = |roughness| of_model(MaterialModel::Conductor { ior: ComplexIor::GOLD, roughness });
    assert!(in_lanes(gold(0.0)) && in_lanes(gold(0.2)) && !in_lanes(gold(0.05)));
    let glass = |roughness, ior| Material {
        interior: Some(InteriorMedium::clear(ior)),
        ..of_model(MaterialModel::Dielectric { roughness, transmittance: ColorTexture::Constant(Rgb::WHITE) })
    };
    assert!(in_lanes(glass(0.0, 1.5)) && in_lanes(glass(0.1, 1.5)) && in_lanes(glass(0.0, 1.01)));
    let mirror =
        |reflectance: f64| MaterialModel::Mirror { reflectance: ColorTexture::Constant(Rgb::gray(reflectance)) };
    let mix = |first, second| of_model(MaterialModel::Mix(vec![(0.5, first), (0.5, second)]));
    let diffuse = MaterialModel::Diffuse { albedo: grey, roughness: 0.0 };
    let shiny =
        |exponent| of_model(Phong { diffuse: grey, specular: grey, mirror: grey, exponent, ..Phong::BLACK }.into());
    assert!(in_lanes(mix(diffuse.clone(), mirror(0.5))) && in_lanes(shiny(30.0)));
    for other in [
        mix(mirror(0.5), diffuse.clone()),
        mix(mirror(0.5), mirror(0.2)),
        mix(diffuse, mirror(1e-20)),
        shiny(1e5),
        glowing(ColorTexture::Constant(Rgb::gray(1e20))),
        glowing(ColorTexture::Textured(crate::TextureId(0), Rgb::WHITE)),
        Material { interior: Some(InteriorMedium::clear(1.5)), ..plain.clone() },
        glass(0.05, 1.5),
        glass(0.5, 1.05),
        glass(0.0, 1.0),
        glossy(1e5),
        of_model(metallic_roughness(0.5, 0.01)),
        of_model(MaterialModel::Diffuse { albedo: ColorTexture::Constant(Rgb::gray(1e-20)), roughness: 0.0 }),
    ] {
        assert!(!in_lanes(other.clone()), "{other:?}");
    }
    let position = DVec3::new(1.0, 3.5, 2.0);
    let glaring =
        DeltaLight::new(DeltaLightKind::Point { position, falloff: Falloff::None, shadow_near: 0.0 }, Rgb::gray(1e30));
    let lights = LightSet::new(vec![Light::Delta(glaring)], LightSampling::Tree, 10.0);
    let lighting = Lighting { appearance: &scene.appearance, lights: &lights, bsdfs: &BsdfCache::default() };
    assert!(LaneMaterials::new(lighting, Transport::Full, &ShadingFeatures::ALL).get(0).is_none());
}

mod layered;
mod specular;
