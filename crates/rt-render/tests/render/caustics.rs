//! Caustics compared with closed forms and with path tracing.

use rt_camera::CameraSettings;
use rt_geometry::{Rectangle, Shape};
use rt_math::{DVec2, DVec3, Rgb, Transform};
use rt_render::{PlanOptions, Rendering, RunOptions, StopRule};
use rt_scene_io::{Content, Integrator, MeshId, RenderSettings, Scene, SceneNode};
use rt_shading::{
    Background, ColorTexture, DeltaLight, DeltaLightKind, Falloff, InteriorMedium, Material, MaterialModel,
    bsdf::ComplexIor, light::EmissionSides,
};

use crate::support::{self, camera, compile, cuboid, everything, film, node, plane, sphere};

const IOR: f64 = 1.5;

fn dielectric(roughness: f64, absorption: Rgb) -> Material {
    let transmittance = ColorTexture::Constant(Rgb::WHITE);
    let interior = Some(InteriorMedium { absorption, ..InteriorMedium::clear(IOR) });
    Material { interior, ..Material::new("glass".into(), MaterialModel::Dielectric { roughness, transmittance }) }
}

fn surface(model: MaterialModel) -> Material {
    Material::new("surface".into(), model)
}

fn diffuse(albedo: f64) -> Material {
    surface(MaterialModel::Diffuse { albedo: ColorTexture::Constant(Rgb::gray(albedo)), roughness: 0.0 })
}

fn emissive(radiance: f64, emission_sides: EmissionSides) -> Material {
    let emission = ColorTexture::Constant(Rgb::gray(radiance));
    Material { emission, emission_sides, ..Material::new("lamp".into(), MaterialModel::Black) }
}

fn floor() -> Content {
    plane(DVec3::ZERO, DVec3::Y)
}

fn light(kind: DeltaLightKind) -> DeltaLight {
    DeltaLight::new(kind, Rgb::gray(1.0))
}

/// A pinhole camera in the middle of things, so that nothing stands between it and what it looks at.
fn scene(camera: CameraSettings, materials: Vec<Material>, nodes: Vec<SceneNode>, lights: Vec<DeltaLight>) -> Scene {
    let mut scene = support::scene(camera, [16, 16], materials, nodes);
    let settings = RenderSettings { spp: 1 << 10, passes: Some(16), ..scene.settings };
    scene.settings = RenderSettings { integrator: Integrator::Caustics, ..settings };
    scene.appearance.lights = lights;
    Scene { name: "caustics".into(), ..scene }
}

fn nodes(of: &[(Content, u32)]) -> Vec<SceneNode> {
    of.iter().map(|(content, material)| node(content.clone(), *material)).collect()
}

fn render(scene: &Scene) -> Rendering {
    support::render(scene, PlanOptions::default(), RunOptions { maps: true, ..RunOptions::default() })
}

/// Radiances of the first channel with their standard errors.
fn measured(rendering: &Rendering) -> impl Iterator<Item = (f64, f64)> {
    let errors = rendering.standard_error.as_ref().expect("maps were requested");
    rendering.film.pixels().iter().zip(errors.pixels()).map(|(p, e)| (f64::from(p[0]), f64::from(e[0])))
}

/// Compares the radiance of pixels with its closed form, a function of the point seen on a plane `distance` in front of the camera.
fn assert_shows(scene: &Scene, distance: f64, truth: impl Fn(DVec2) -> f64, what: &str) {
    let rendering = render(scene);
    let half = distance * rt_math::transcendental::tan(0.4);
    let point = |i: usize| DVec2::new((i % 16) as f64 - 7.5, 7.5 - (i / 16) as f64) * (half / 8.0);
    // The ratio to the closed form, separately for the middle of the image and its border.
    for is_middle in [true, false] {
        let [mut sum, mut variance, mut count] = [0.0; 3];
        for (i, (value, error)) in measured(&rendering).enumerate() {
            let at = point(i);
            if (at.abs().max_element() < 0.5 * half) == is_middle {
                let truth = truth(at);
                (sum, variance, count) =
                    (sum + value / truth, variance + (error / truth) * (error / truth), count + 1.0);
            }
        }
        let (ratio, error) = (sum / count, variance.sqrt() / count);
        assert!(error < 0.02, "{what}: {ratio} ± {error} says nothing");
        assert!((ratio - 1.0).abs() < 5.0 * error + 1e-3, "{what}: {ratio} ± {error} of what is known");
    }
}

/// Unpolarised transmittance of one surface of glass.
fn transmittance(cos: f64) -> f64 {
    1.0 - rt_shading::optics::fresnel(cos, IOR)
}

/// Light emitted between two cones arrives between two circles: E(x) = I T² sin θ / (x · dx/dθ).
///
/// Regression: a bulb of glass around the light, within which shadow rays end, took the slab away: paths never left its medium.
#[test]
fn a_glass_slab_transmits_light_by_snell_and_fresnel() {
    let (height, thickness) = (9.0, 0.8);
    let position = DVec3::Y * height;
    let camera = camera(DVec3::Y * 4.0, DVec3::ZERO, DVec3::NEG_Z, 0.8);
    let slab = cuboid([-2.0, 5.0, -2.0], [2.0, 5.0 + thickness, 2.0]);
    let kind = |shadow_near| DeltaLightKind::Point { position, falloff: Falloff::InverseSquare, shadow_near };
    let materials = vec![diffuse(0.6), dielectric(0.0, Rgb::BLACK)];
    let of = [(floor(), 0), (slab, 1), (sphere(0.0, height, 0.0, 0.2), 1)];
    let alone = scene(camera, materials.clone(), nodes(&of[..2]), vec![light(kind(0.0))]);
    let in_bulb = scene(camera, materials, nodes(&of), vec![light(kind(0.3))]);
    let radiance = |s: f64| {
        let (c, s2) = ((1.0 - s * s).sqrt(), s / IOR);
        let c2 = (1.0 - s2 * s2).sqrt();
        let x = (height - thickness) * s / c + thickness * s2 / c2;
        let by_angle = (height - thickness) / (c * c) + thickness * c / (IOR * c2 * c2 * c2);
        // Classical units scale intensity by π, and a diffuse surface reflects albedo / π.
        (x, 0.6 * transmittance(c) * transmittance(c) * s / (x * by_angle))
    };
    let truth = |at: DVec2| {
        let (mut low, mut high) = (1e-9, 0.5);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if radiance(middle).0 < at.length() { low = middle } else { high = middle }
        }
        radiance(low).1
    };
    for (mut scene, what) in [(alone, "slab"), (in_bulb, "slab and bulb")] {
        // Exclude interreflection within the glass, which arrives elsewhere.
        scene.settings.depth = 2;
        // The bulb is one more target of its paths.
        scene.settings.spp *= if what == "slab" { 1 } else { 4 };
        assert_shows(&scene, 4.0, truth, what);
    }
}

/// Regression: light paths through glass without shadow came to the light that shadow rays had found behind it.
#[test]
fn light_passed_glass_without_shadow_twice() {
    let height = 9.0;
    let camera = camera(DVec3::Y * 4.0, DVec3::ZERO, DVec3::NEG_Z, 0.8);
    let position = DVec3::Y * height;
    let kind = DeltaLightKind::Point { position, falloff: Falloff::InverseSquare, shadow_near: 0.0 };
    let mut nodes = nodes(&[(floor(), 0), (cuboid([-9.0, 5.0, -9.0], [9.0, 6.0, 9.0]), 1)]);
    nodes[1].casts_shadow = false;
    // It neither refracts nor reflects much.
    let mut glass = dielectric(0.0, Rgb::BLACK);
    glass.interior = Some(InteriorMedium::clear(1.0001));
    let scene = scene(camera, vec![diffuse(0.6), glass], nodes, vec![light(kind)]);
    let truth = |at: DVec2| {
        let square = at.length_squared() + height * height;
        0.6 * height / (square * square.sqrt())
    };
    assert_shows(&scene, 4.0, truth, "glass without shadow");
}

/// Regression: light paths through glass without shadow ended at a surface with a mirror lobe and another one.
#[test]
fn clear_glass_without_shadow_changes_no_caustic() {
    let camera = camera(DVec3::Y * 2.0, DVec3::Y * 4.0, DVec3::NEG_Z, 0.8);
    let mirror = Shape::Rectangle(Rectangle::new(12.0, 12.0).expect("a rectangle"));
    let mix = MaterialModel::Mix(vec![
        (0.7, MaterialModel::Mirror { reflectance: ColorTexture::Constant(Rgb::gray(0.9)) }),
        (0.3, MaterialModel::Diffuse { albedo: ColorTexture::Constant(Rgb::gray(0.3)), roughness: 0.0 }),
    ]);
    let mut clear = dielectric(0.0, Rgb::BLACK);
    clear.interior = Some(InteriorMedium::clear(1.0001));
    let of = [
        (cuboid([-1.0, 4.0, -1.0], [1.0, 4.1, 1.0]), 0),
        (Content::Shape(mirror), 1),
        (cuboid([-12.0, 0.4, -12.0], [12.0, 0.6, 12.0]), 2),
    ];
    let position = DVec3::new(0.4, 1.0, 0.2);
    let kind = DeltaLightKind::Point { position, falloff: Falloff::InverseSquare, shadow_near: 0.0 };
    let of_nodes = |count: usize| {
        let mut nodes = nodes(&of[..count]);
        nodes.iter_mut().skip(2).for_each(|slab| slab.casts_shadow = false);
        let materials = vec![diffuse(0.3), surface(mix.clone()), clear.clone()];
        let mut scene = scene(camera, materials, nodes, vec![light(kind)]);
        (scene.settings.depth, scene.settings.seed) = (20, count as u64);
        render(&scene)
    };
    let (without, with) = (of_nodes(2), of_nodes(3));
    let (blocks, whole) = scores(&with, &without);
    assert!(largest(&blocks) < 4.5 && whole.abs() < 4.5, "{blocks:.1?}, all {whole:.1}");
}

/// Radiance by the point that is seen.
type KnownMean<'a> = &'a dyn Fn(DVec2) -> f64;

/// A flat mirror acts as a mirrored copy of the light.
#[test]
fn a_flat_mirror_reflects_each_kind_of_light() {
    let camera = camera(DVec3::Y * 2.0, DVec3::Y * 4.0, DVec3::NEG_Z, 0.8);
    let mirror = Shape::Rectangle(Rectangle::new(12.0, 12.0).expect("a rectangle"));
    let nodes = nodes(&[(cuboid([-1.0, 4.0, -1.0], [1.0, 4.1, 1.0]), 0), (Content::Shape(mirror), 1)]);
    let white = ColorTexture::Constant(Rgb::gray(0.8));
    let materials = vec![diffuse(0.5), surface(MaterialModel::Mirror { reflectance: white })];
    let position = DVec3::new(0.4, 1.0, 0.2);
    let point = |falloff| DeltaLightKind::Point { position, falloff, shadow_near: 0.0 };
    let spot = DeltaLightKind::Spot {
        position,
        direction: DVec3::NEG_Y,
        cos_inner: 0.9,
        cos_outer: 0.3,
        falloff: Falloff::InverseSquare,
    };
    let sun = DVec3::new(1.0, -1.0, 0.0).normalize();
    // Radiance of a point of the ceiling, 4 above the mirror, by a light at a height. The camera looks up: left is +x.
    let from = |height: f64, at: DVec2, has_falloff: bool| {
        let offset = DVec3::new(-at.x, 4.0, -at.y) - DVec3::new(position.x, height, position.z);
        let square = offset.length_squared();
        0.5 * offset.y / square.sqrt() / if has_falloff { square } else { 1.0 }
    };
    let cases: [(&str, DeltaLightKind, KnownMean<'_>); 4] = [
        ("point", point(Falloff::InverseSquare), &|at| from(1.0, at, true) + 0.8 * from(-1.0, at, true)),
        ("no falloff", point(Falloff::None), &|at| from(1.0, at, false) + 0.8 * from(-1.0, at, false)),
        ("spot", spot, &|at| 0.8 * from(-1.0, at, true)),
        ("sun", DeltaLightKind::Directional { direction: sun }, &|_| 0.8 * 0.5 * -sun.y),
    ];
    for (what, kind, truth) in cases {
        let mut scene = scene(camera, materials.clone(), nodes.clone(), vec![light(kind)]);
        // Exclude interreflection between ceiling and mirror.
        scene.settings.depth = 1;
        // Few of its paths meet the ceiling.
        if what == "sun" {
            scene.settings.spp *= 4;
        }
        assert_shows(&scene, 2.0, truth, what);
    }
}

/// Scene that path tracing can render as well: its area lights are large, one of them behind glass.
///
/// Objects: clear, rough and absorbing glass spheres, a metal block, and a mesh with interpolated normals.
pub(crate) fn comparable() -> Scene {
    let camera = camera([0.0, 3.0, 7.0], DVec3::Y * 0.8, DVec3::Y, 0.8);
    let contents = [
        (floor(), 0),
        (sphere(-1.2, 1.0, 0.5, 0.8), 1),
        (sphere(0.6, 0.6, 1.2, 0.5), 2),
        (cuboid([1.2, 0.1, -1.0], [2.0, 1.6, 0.2]), 3),
        (sphere(2.4, 0.9, 1.6, 0.5), 4),
        (sphere(-2.6, 3.4, 0.4, 0.9), 5),
        (cuboid([-0.5, 3.4, 1.0], [1.1, 3.45, 2.2]), 6),
        (sphere(2.6, 2.6, -1.0, 0.9), 1),
        (sphere(2.6, 2.6, -1.0, 0.5), 5),
        (sphere(-0.2, 0.7, 2.2, 0.4), 7),
        // A bumpy sheet with interpolated normals.
        (Content::Mesh(MeshId(0)), 0),
    ];
    let coat = MaterialModel::Mix(vec![
        (0.5, MaterialModel::Mirror { reflectance: ColorTexture::Constant(Rgb::gray(0.9)) }),
        (0.5, MaterialModel::Diffuse { albedo: ColorTexture::Constant(Rgb::gray(0.7)), roughness: 0.3 }),
    ]);
    let materials = vec![
        diffuse(0.7),
        dielectric(0.0, Rgb::BLACK),
        dielectric(0.4, Rgb::new(0.2, 0.5, 1.0)),
        surface(MaterialModel::Conductor { ior: ComplexIor::GOLD, roughness: 0.0 }),
        dielectric(0.0, Rgb::new(1.5, 0.3, 0.1)),
        emissive(4.0, EmissionSides::Front),
        emissive(3.0, EmissionSides::Both),
        surface(coat),
    ];
    let mut scene = scene(camera, materials, nodes(&contents), vec![]);
    scene.appearance.background = Background::Constant(Rgb::gray(0.05));
    scene.settings = RenderSettings { spp: 1024, passes: Some(16), depth: 7, ..scene.settings };
    (scene.film.width, scene.film.height) = (24, 16);
    scene.meshes = everything().meshes;
    if let Some(sheet) = scene.nodes.last_mut() {
        sheet.parent_from_local = Transform::translate(DVec3::new(-1.4, 0.05, 2.4));
    }
    scene
}

/// z-scores of the difference of two renderings, by blocks of 4 × 4 pixels, and of all pixels.
fn scores(a: &Rendering, b: &Rendering) -> (Vec<f64>, f64) {
    let (width, all) = (a.film.width() as usize, a.film.pixels().len());
    let mut sums = vec![(0.0, 0.0); all / 16 + 1];
    for (i, ((a, da), (b, db))) in measured(a).zip(measured(b)).enumerate() {
        for block in [i % width / 4 + i / width / 4 * (width / 4), all / 16] {
            sums[block].0 += a - b;
            sums[block].1 += da * da + db * db;
        }
    }
    let mut scores: Vec<f64> = sums.iter().map(|(difference, variance)| difference / variance.sqrt()).collect();
    let whole = scores.pop().unwrap_or(f64::NAN);
    (scores, whole)
}

fn largest(scores: &[f64]) -> f64 {
    scores.iter().fold(0.0, |largest, z| largest.max(z.abs()))
}

/// Light tracing with path tracing is unbiased: no path is counted twice or lost.
#[test]
fn caustics_agree_with_path_tracing() {
    let caustics = comparable();
    let mut path = caustics.clone();
    path.settings.integrator = Integrator::Path;
    path.settings.seed = 1;
    let (both, one) = (render(&caustics), render(&path));
    let (blocks, whole) = scores(&both, &one);
    let square = blocks.iter().map(|z| z * z).sum::<f64>() / blocks.len() as f64;
    assert!(
        largest(&blocks) < 4.5 && whole.abs() < 4.0 && square < 2.0,
        "{blocks:.1?}, all {whole:.1}, χ² {square:.2}"
    );
    // The test is meaningful only if much of the light arrives by caustics.
    let mut direct = caustics.clone();
    (direct.settings.depth, direct.settings.spp) = (1, 256);
    let (blocks, whole) = scores(&render(&direct), &one);
    assert!(largest(&blocks) > 20.0 && whole.abs() > 20.0, "{blocks:.1?}, all {whole:.1}");
}

#[test]
fn without_mirrors_and_glass_it_is_path_tracing() {
    let mut scene = comparable();
    scene.settings.spp = 4;
    let both = |scene: &Scene| {
        let settings =
            [Integrator::Caustics, Integrator::Path].map(|integrator| RenderSettings { integrator, ..scene.settings });
        settings.map(|settings| film(&Scene { settings, ..scene.clone() }))
    };
    for scene in [&scene, &everything()] {
        let [caustics, path] = both(scene);
        assert_ne!(caustics, path, "{}: there is nothing to compare", scene.name);
    }
    scene.appearance.materials = vec![diffuse(0.5), diffuse(0.5), diffuse(0.5), diffuse(0.5), diffuse(0.5)];
    scene.appearance.materials.extend([
        emissive(4.0, EmissionSides::Front),
        emissive(3.0, EmissionSides::Both),
        diffuse(0.4),
    ]);
    let [caustics, path] = both(&scene);
    assert_eq!(caustics, path);
}

#[test]
fn passes_until_time_or_error_have_light_paths_too() {
    let mut scene = comparable();
    scene.settings.spp = 4;
    let plan = compile(&scene);
    let rule = StopRule { max_spp: 64, ..StopRule::default() };
    let until = plan.render_until(&RunOptions { maps: true, ..RunOptions::default() }, &rule, |_| {}).expect("threads");
    scene.settings.spp = 512;
    let (_, whole) = scores(&until, &render(&scene));
    assert!(whole.abs() < 4.5, "{whole}");
}
