mod lanes;
mod reference;
mod shading_normals;

use super::*;
use crate::{
    Appearance, Background, BsdfCache, ColorTexture, DeltaLight, DeltaLightKind, Falloff, InteriorMedium, LightUnits,
    Material, MaterialModel, Phong, ReferencePathTracer, SceneQueries, Transmission,
    light::{DiskLight, Emission, EmissionSides, EnvironmentLight, Light, LightSampling, LightSet, QuadLight},
    stream_queries::SingleQueries,
    test_worlds::{HitFunction, ShapeList, flat_hit, gray, whitted_of},
    wavefront::test_world::{assert_close, assert_same_bits, in_streams},
};
use core::ops::Range;
use rt_geometry::{Plane, Polygon, Shape, Sphere};
use rt_math::{DVec3, Interval, Ray, Rgb, random};

/// Independent numbers.
#[derive(Clone)]
pub(super) struct Independent {
    pub(super) key: u64,
    pub(super) dimension: u64,
}

impl Sampler for Independent {
    fn next_1d(&mut self) -> f64 {
        self.dimension += 1;
        random::unit(random::hash(&[self.key, self.dimension]))
    }

    fn next_2d(&mut self) -> [f64; 2] {
        [self.next_1d(), self.next_1d()]
    }
}

fn emissive(model: MaterialModel, emission: f64) -> Material {
    Material { emission: gray(emission), ..Material::new(String::new(), model) }
}

fn diffuse(albedo: f64) -> MaterialModel {
    MaterialModel::Diffuse { albedo: gray(albedo), roughness: 0.0 }
}

fn metallic_roughness(metallic: f64, roughness: f64) -> MaterialModel {
    let base_color = ColorTexture::Constant(Rgb::new(0.9, 0.5, 0.1));
    MaterialModel::MetallicRoughness { base_color, metallic, roughness }
}

struct Scene {
    world: ShapeList,
    appearance: Appearance,
    /// Area and environment lights.
    lights: Vec<Light>,
}

impl Scene {
    fn new(materials: Vec<Material>, lights: Vec<Light>) -> Self {
        let appearance = Appearance { materials, ..Appearance::default() };
        Self { world: ShapeList::default(), appearance, lights }
    }

    fn light_set(&self) -> LightSet {
        let delta_lights = self.appearance.lights.iter().cloned().map(Light::Delta);
        LightSet::new(self.lights.iter().cloned().chain(delta_lights).collect(), LightSampling::Tree, 1.0)
    }

    fn with(mut self, shape: Shape, material: u32, light: Option<u32>) -> Self {
        self.world.shapes.push((shape, material, light));
        self
    }

    /// Result of [`trace`] for rays that start in air.
    fn trace(&mut self, settings: PathSettings, rays: &[Ray]) -> (Vec<RadianceSample>, ShadingCounts) {
        let (lights, bsdfs) = (self.light_set(), BsdfCache::new(&self.appearance, |_| true));
        let lighting = Lighting { appearance: &self.appearance, lights: &lights, bsdfs: &bsdfs };
        trace(&mut self.world, lighting, settings, &[InteriorList::default()], rays)
    }

    /// The mean over so many paths from a ray, and its standard error.
    fn estimate(&mut self, settings: PathSettings, ray: Ray, paths: u32) -> (f64, f64) {
        mean_and_error(&self.trace(settings, &vec![ray; paths as usize]).0)
    }

    fn assert_shows(&mut self, settings: PathSettings, ray: Ray, truth: f64) {
        let (mean, error) = self.estimate(settings, ray, 20_000);
        let z = (mean - truth) / error.max(1e-9 * truth);
        assert!(z.abs() < 5.0, "{mean} ± {error} is not {truth}: z = {z}");
    }
}

/// Radiance of camera rays in `f64`, each with its own random numbers, and the work of shading in `f32`. The radiance is that of the
/// reference; in `f32`, it has the same bits at all levels. There is one list of media around the camera
/// for all rays, or one for each.
fn trace(
    world: &mut dyn SceneQueries,
    lighting: Lighting<'_>,
    settings: PathSettings,
    camera_media: &[InteriorList],
    rays: &[Ray],
) -> (Vec<RadianceSample>, ShadingCounts) {
    let samplers: Vec<_> = (0..rays.len() as u64).map(|key| Independent { key, dimension: 0 }).collect();
    let spans: Vec<_> = rays.iter().map(|ray| (*ray, Interval::FORWARD)).collect();
    let features = ShadingFeatures::of(lighting.appearance, |_| true);
    let mut radiance_of = |mut paths: PathTracer| {
        let seen = in_streams(&spans, |range, rays, seen| {
            paths.set_camera_media(if camera_media.len() > 1 { &camera_media[range.clone()] } else { camera_media });
            paths.radiance_of_stream(
                &mut SingleQueries::new(world),
                lighting,
                rays,
                &mut samplers[range].to_vec(),
                seen,
            );
        });
        (seen, paths.take_counts())
    };
    let levels = [LaneLevel::avx2(), LaneLevel::best(), None];
    let [in_avx2, (in_f32, counts), (one_by_one, counts_of_one)] = levels.map(|level| {
        let mut paths = PathTracer::new(settings, features);
        paths.set_lanes(level);
        radiance_of(paths)
    });
    assert!(in_avx2 == (in_f32.clone(), counts), "AVX2 differs from the best level");
    assert_eq!(counts.without_lanes(), counts_of_one.without_lanes(), "{settings:?}");
    assert!(counts.lanes_used <= counts.lanes, "{counts:?}");
    assert_same_bits(&in_f32, &one_by_one, &format!("{settings:?}"));
    let (seen, counts_in_f64) = radiance_of(PathTracer::new(settings, features).in_f64());
    assert_close(&seen, &in_f32, 1e-3, 1 + rays.len() / 50, ("f32", settings));
    if !matches!(settings.transport, Transport::Specular | Transport::SpecularWithEmitters) {
        let (air, none) = (InteriorList::default(), ShadingCounts::default());
        let mut reference = ReferencePathTracer { settings, lighting, camera_media: air, counts: none };
        let li = |((ray, sampler), camera_media): ((&Ray, &Independent), &InteriorList)| {
            reference.camera_media.clone_from(camera_media);
            reference.li(world, ray, &mut sampler.clone())
        };
        let expected: Vec<_> = rays.iter().zip(&samplers).zip(camera_media.iter().cycle()).map(li).collect();
        // On a light source, rounding decides whether the source itself reaches a point or one next to it.
        assert_close(&expected, &seen, 1e-9, rays.len() / 500, settings);
        let of_media_and_clamp =
            |counts: &ShadingCounts| [counts.null_interfaces, counts.interior_overflows, counts.clamped];
        assert_eq!(of_media_and_clamp(&counts_in_f64), of_media_and_clamp(&reference.counts), "{settings:?}");
    }
    (seen, counts)
}

/// Mean of the green channel, and its standard error.
fn mean_and_error(seen: &[RadianceSample]) -> (f64, f64) {
    let n = seen.len() as f64;
    let mean = seen.iter().map(|seen| seen.radiance.g).sum::<f64>() / n;
    let spread = seen.iter().map(|seen| (seen.radiance.g - mean) * (seen.radiance.g - mean)).sum::<f64>();
    (mean, (spread / (n * (n - 1.0))).sqrt())
}

const fn paths(max_depth: u32) -> PathSettings {
    PathSettings { max_depth, rr_start_depth: 2, transport: Transport::Full, clamp: Clamp::NONE }
}

const DISTRIBUTED: PathSettings =
    PathSettings { max_depth: 4, rr_start_depth: 9, transport: Transport::Specular, clamp: Clamp::NONE };

fn floor() -> Shape {
    Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Y).expect("a plane"))
}

fn sphere(radius: f64) -> Shape {
    Shape::Sphere(Sphere::new(DVec3::ZERO, radius).expect("a sphere"))
}

/// At a point of the floor, from aside.
fn at_origin() -> Ray {
    Ray::new(DVec3::new(3.0, 1.0, 0.5), DVec3::new(-3.0, -1.0, -0.5))
}

/// In lanes, a black light once got shadow rays.
#[test]
fn a_black_light_gets_no_shadow_rays() {
    let emission = Emission::new(Rgb::BLACK, EmissionSides::Both).expect("black");
    let light = QuadLight::new(DVec3::new(-0.5, 2.0, -0.5), [DVec3::X, DVec3::Z], emission).expect("a light");
    let material = Material::new(String::new(), diffuse(0.8));
    let mut scene = Scene::new(vec![material], vec![Light::Quad(light)]).with(floor(), 0, None);
    let rays = [0.1, 0.2, 0.3].map(|x| Ray::new(DVec3::new(x, 1.0, 0.3), DVec3::new(0.1, -1.0, 0.2)));
    let settings = PathSettings { max_depth: 2, rr_start_depth: 9, transport: Transport::Full, clamp: Clamp::NONE };
    let (seen, counts) = scene.trace(settings, &rays);
    assert!(seen.iter().all(|seen| seen.radiance.is_black()));
    assert_eq!(counts.shadow_rays_skipped, 3);
}

/// Points of a floor at height 0 once were shaded one by one, because the next number after 0 was not found in lanes.
#[test]
fn a_floor_at_height_zero_is_shaded_in_lanes() {
    let emission = Emission::new(Rgb::WHITE, EmissionSides::Both).expect("an emission");
    let light = QuadLight::new(DVec3::new(-0.5, 2.0, -0.5), [DVec3::X, DVec3::Z], emission).expect("a light");
    let materials = vec![Material::new(String::new(), diffuse(0.8))];
    let mut scene = Scene::new(materials, vec![Light::Quad(light)]).with(floor(), 0, None);
    let rays: Vec<_> = (0..40).map(|i| Ray::new(DVec3::new(0.1 * f64::from(i), 1.0, 0.3), DVec3::NEG_Y)).collect();
    let (seen, counts) = scene.trace(paths(0), &rays);
    assert!(seen.iter().all(|seen| !seen.radiance.is_black()));
    assert!((counts.lanes_used, counts.lanes) == (40, 40) || LaneLevel::best().is_none(), "{counts:?}");
}

#[test]
fn glass_neither_makes_nor_loses_light() {
    let inside =
        |ior: f64, absorption: f64| InteriorMedium { absorption: Rgb::gray(absorption), ..InteriorMedium::clear(ior) };
    let glass = |ior, absorption, roughness| {
        let mut material = emissive(MaterialModel::Dielectric { roughness, transmittance: gray(1.0) }, 0.0);
        material.interior = Some(inside(ior, absorption));
        material
    };
    let furnace = |material| {
        let mut scene = Scene::new(vec![material], Vec::new()).with(sphere(1.0), 0, None);
        scene.appearance.background = Background::Constant(Rgb::WHITE);
        scene
    };
    let ray = Ray::new(DVec3::new(0.4, 0.1, 5.0), DVec3::NEG_Z);
    // Without roulette, which ends one path in a thousand and makes the others brighter: too few to tell how wide they spread.
    let unending = PathSettings { rr_start_depth: 500, ..paths(500) };
    furnace(glass(1.5, 0.0, 0.0)).assert_shows(unending, ray, 1.0);
    // Rough surfaces lose what facets pass to each other.
    let (mean, _) = furnace(glass(1.5, 0.0, 0.2)).estimate(paths(500), ray, 20_000);
    assert!(mean > 0.97 && mean < 1.0 + 1e-9, "{mean}");
    // Beer's law along a diameter, through a dielectric that does not bend light.
    let straight = Ray::new(DVec3::Z * 5.0, DVec3::NEG_Z);
    furnace(glass(1.0, 0.5, 0.0)).assert_shows(paths(5), straight, rt_math::transcendental::exp(-1.0));
}

/// Each pane of thin glass was entered as a dielectric and never left. The list of dielectrics was full at last, and further panes
/// were not seen.
#[test]
fn forty_panes_of_thin_glass_each_take_their_part() {
    let thin_glass = MaterialModel::ThinGlass { ior: 1.0, transmittance: gray(0.95) };
    let mut material = emissive(thin_glass, 0.0);
    // Without the mirror of the conversion.
    let transmission = Some(Transmission { coefficient: gray(0.95), fresnel: false });
    material.phong_override = Some(Phong { transmission, ..Phong::BLACK });
    let mut scene = Scene::new(vec![material], Vec::new());
    scene.appearance.background = Background::Constant(Rgb::WHITE);
    for z in 0..40 {
        let plane = Plane::new(DVec3::NEG_Z * f64::from(z), DVec3::Z).expect("a plane");
        scene = scene.with(Shape::Plane(plane), 0, None);
    }
    let unending = PathSettings { rr_start_depth: 100, ..paths(100) };
    let ray = Ray::new(DVec3::Z, DVec3::NEG_Z);
    let (mean, _) = scene.estimate(unending, ray, 4);
    let left = rt_math::transcendental::pow(0.95, 40.0);
    assert!((mean - left).abs() < 1e-12, "{mean} is not {left}");
    let seen = whitted_of(&scene.appearance, 100).radiance(&mut scene.world, &scene.appearance, &ray);
    assert!((seen.radiance.g - left).abs() < 1e-12, "{seen:?} is not {left}");
}

/// Regression: the reference still charged bounces for more than 1024 null interfaces after the next surface; waves did not.
#[test]
fn bounces_charged_for_null_interfaces_end_with_the_ray() {
    let mut sheets = HitFunction(|ray: &Ray, span: Interval| {
        let t = span.min.floor() + 1.0;
        let is_wall = t == 1030.0;
        // Rays enter and leave the medium by turns.
        let against = if (t as u32).is_multiple_of(2) { ray.direction } else { -ray.direction };
        let normal = if is_wall { -ray.direction } else { against }.normalize();
        Some(flat_hit(t, ray.at(t), normal, u32::from(is_wall)))
    });
    let clear = MaterialModel::Dielectric { roughness: 0.0, transmittance: gray(1.0) };
    let clear = Material { interior: Some(InteriorMedium::clear(1.0)), ..emissive(clear, 0.0) };
    let scene = Scene::new(vec![clear, emissive(diffuse(0.5), 1.0)], Vec::new());
    let (lights, bsdfs) = (scene.light_set(), BsdfCache::default());
    let lighting = Lighting { appearance: &scene.appearance, lights: &lights, bsdfs: &bsdfs };
    let settings = PathSettings { rr_start_depth: 100, ..paths(8) };
    let (seen, counts) = trace(&mut sheets, lighting, settings, &[InteriorList::default()], &[at_origin(); 4]);
    // 1, ½, ... of the first four walls. The way to each costs five bounces: four and five more are too many.
    assert_eq!((seen[0].radiance.g, counts.depth_limited), (1.875, 4), "{seen:?}, {counts:?}");
}

#[test]
fn what_is_seen_does_not_depend_on_the_wave() {
    let emission = Emission::new(Rgb::WHITE, EmissionSides::Both).expect("an emission");
    let light = DiskLight::new(DVec3::Y * 2.0, DVec3::NEG_Y, 0.5, 0.0, emission).expect("a light");
    let mut scene =
        Scene::new(vec![emissive(diffuse(0.7), 0.0), emissive(diffuse(0.3), 0.1)], vec![Light::Disk(light)])
            .with(floor(), 0, None)
            .with(sphere(0.5), 1, None);
    let features = ShadingFeatures::of(&scene.appearance, |_| true);
    let ray =
        |i: u32| (Ray::new(DVec3::new(3.0, 1.0, 0.1 * f64::from(i)), DVec3::new(-3.0, -1.0, 0.0)), Interval::FORWARD);
    let rays: Vec<_> = (0..20).map(ray).collect();
    let samplers: Vec<_> = (0..20).map(|key| Independent { key, dimension: 0 }).collect();
    let lights = scene.light_set();
    let lighting = Lighting { appearance: &scene.appearance, lights: &lights, bsdfs: &BsdfCache::default() };
    let mut tracer = PathTracer::new(paths(6), features);
    let mut radiance_of = |range: Range<usize>| {
        in_streams(&rays[range.clone()], |_, rays, seen| {
            let world = &mut SingleQueries::new(&mut scene.world);
            tracer.radiance_of_stream(world, lighting, rays, &mut samplers[range.clone()].to_vec(), seen);
        })
    };
    let together = radiance_of(0..20);
    let one_by_one: Vec<_> = (0..20).flat_map(|at| radiance_of(at..at + 1)).collect();
    assert_eq!(together, one_by_one);
    assert!(together.iter().any(|seen| !seen.radiance.is_black()));
}
