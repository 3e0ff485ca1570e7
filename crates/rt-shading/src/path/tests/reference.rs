//! Waves in `f64` and the reference integrator return the same radiance, for scenes with all features and all settings.
//!
//! `trace` compares every path of all other tests of path tracing, too.

use super::*;
use crate::{
    Channel, FloatTexture, LayeredBase, LayeredSurface, SurfaceHit, Texture, TextureId, bsdf::ComplexIor,
    light::SphereLight,
};
use core::slice::from_ref;
use rt_geometry::SurfaceInteraction;
use rt_math::DQuat;

/// Camera rays for each of 126 combinations of settings, media around the camera, and lights.
const RAYS: u64 = 1200;

/// Settings that end and weigh paths differently.
fn all_settings() -> impl Iterator<Item = PathSettings> {
    let depths = [(0, 0), (1, 0), (3, 1), (12, 0), (12, 20)];
    let transports = [Transport::Full, Transport::NonCaustic];
    let clamps = [Clamp::NONE, Clamp::new(0.05).expect("positive")];
    depths.into_iter().flat_map(move |(max_depth, rr_start_depth)| {
        transports
            .into_iter()
            .flat_map(move |transport| clamps.map(|clamp| PathSettings { max_depth, rr_start_depth, transport, clamp }))
    })
}

/// Shading normal that varies from point to point, by up to about 30 degrees.
fn tilted_normal(hit: &SurfaceHit) -> DVec3 {
    let SurfaceInteraction { point, shading_normal, .. } = hit.interaction;
    let bend = (point * 3.0 + DVec3::new(0.1, 0.2, 0.3)).fract() - DVec3::splat(0.5);
    (shading_normal + bend * 0.7).normalize()
}

fn solid(model: MaterialModel, interior: InteriorMedium) -> Material {
    Material { interior: Some(interior), ..emissive(model, 0.0) }
}

fn sphere_at(center: [f64; 3], radius: f64) -> Shape {
    Shape::Sphere(Sphere::new(center.into(), radius).expect("a sphere"))
}

fn delta_light(kind: DeltaLightKind, casts_shadows: bool, units: LightUnits) -> DeltaLight {
    DeltaLight { units, casts_shadows, ..DeltaLight::new(kind, Rgb::new(0.9, 0.6, 0.3)) }
}

/// Surfaces of all kinds above a checkered floor, two area lights, an image around the scene, and delta lights.
fn exhibition() -> Scene {
    let emission = Emission::new(Rgb::new(7.0, 5.0, 3.0), EmissionSides::Both).expect("an emission");
    let pixels = [0.0, 0.1, 3.0, 0.4, 0.2, 0.0, 0.3, 0.7].map(|value| Rgb::new(value, value * value, 0.2));
    let sky = EnvironmentLight::new(4, 2, pixels.to_vec(), DQuat::IDENTITY).expect("a sky");
    let (corner, edges) = (DVec3::new(-0.7, 4.0, -0.7), [DVec3::X * 1.4, DVec3::Z * 1.4]);
    let quad = QuadLight::new(corner, edges, emission).expect("a light");
    let outline = vec![corner, corner + edges[0], corner + edges[0] + edges[1], corner + edges[1]];
    let square = Polygon::new(outline, Vec::new(), rt_geometry::InsideRule::Convex).expect("a square");
    let bulb = SphereLight::new(DVec3::new(-2.5, 1.5, 1.0), 0.2, emission).expect("a light");
    let lights = vec![Light::Quad(quad), Light::Sphere(bulb), Light::Environment(sky.clone())];

    let clear = || MaterialModel::Dielectric { roughness: 0.0, transmittance: gray(1.0) };
    let rough = MaterialModel::Dielectric { roughness: 0.3, transmittance: gray(0.9) };
    let absorbing = |ior, priority| InteriorMedium { ior, priority, absorption: Rgb::new(0.1, 0.3, 0.6) };
    let base = LayeredBase::MetallicRoughness {
        base_color: gray(0.6),
        metallic: FloatTexture::Constant(0.3),
        roughness: FloatTexture::Constant(0.4),
    };
    let coated = LayeredSurface {
        clearcoat: FloatTexture::Constant(0.7),
        clearcoat_roughness: FloatTexture::textured(&[], TextureId(0), Channel::Red, 0.5),
        ..LayeredSurface::new(base.clone())
    };
    let dispersive = LayeredSurface {
        transmission: FloatTexture::Constant(1.0),
        is_thin: false,
        dispersion: 0.5,
        ..LayeredSurface::new(base)
    };
    let floor = MaterialModel::Diffuse { albedo: ColorTexture::Textured(TextureId(0), Rgb::WHITE), roughness: 0.2 };
    let radiance = ColorTexture::Constant(emission.radiance());
    let materials = vec![
        emissive(floor, 0.0),
        Material { emission: radiance, ..emissive(MaterialModel::Black, 0.0) },
        solid(clear(), absorbing(1.5, 1)),
        solid(clear(), absorbing(1.33, 0)),
        solid(clear(), InteriorMedium { priority: -1, ..InteriorMedium::clear(1.0) }),
        solid(rough, InteriorMedium::clear(1.5)),
        emissive(MaterialModel::Mirror { reflectance: gray(0.9) }, 0.0),
        emissive(MaterialModel::Conductor { ior: ComplexIor::GOLD, roughness: 0.2 }, 0.0),
        emissive(MaterialModel::ThinGlass { ior: 1.5, transmittance: gray(0.8) }, 0.0),
        emissive(MaterialModel::Layered(coated.into()), 0.02),
        solid(MaterialModel::Layered(dispersive.into()), InteriorMedium::clear(1.5)),
        Material::new(String::new(), Phong { specular: gray(0.3), mirror: gray(0.2), ..Phong::default() }),
        emissive(metallic_roughness(0.3, 0.2), 0.02),
        solid(clear(), InteriorMedium::clear(1.1)),
    ];
    let mut scene = Scene::new(materials, lights)
        .with(super::floor(), 0, None)
        .with(Shape::Polygon(square.into()), 1, Some(0))
        .with(sphere_at([-2.5, 1.5, 1.0], 0.2), 1, Some(1));
    // Glass, water that overlaps it, and a bubble in both.
    for (center, radius, material) in [
        ([0.0, 0.8, 0.0], 0.7, 2),
        ([0.5, 0.8, 0.0], 0.6, 3),
        ([0.2, 0.9, 0.1], 0.3, BUBBLE),
        ([1.9, 0.6, 0.3], 0.5, 5),
        ([-1.3, 0.6, -0.6], 0.5, 6),
        ([-1.1, 0.4, 1.0], 0.4, 7),
        ([1.2, 0.35, 1.3], 0.3, 9),
        ([0.1, 0.4, 1.6], 0.4, 10),
        ([2.6, 0.5, -0.9], 0.5, 11),
        ([-2.4, 0.6, -1.0], 0.6, 12),
        // A solid of air around all.
        ([0.0, 0.5, 0.0], 3.6, 4),
    ] {
        scene = scene.with(sphere_at(center, radius), material, None);
    }
    let thin_glass = Plane::new(DVec3::new(0.0, 0.0, -2.5), DVec3::new(0.1, 0.0, 1.0)).expect("a plane");
    scene = scene.with(Shape::Plane(thin_glass), 8, None);
    scene.appearance.textures = vec![Texture::Checker { even: Rgb::WHITE, odd: Rgb::new(0.7, 0.1, 0.1), size: 0.25 }];
    scene.appearance.background = Background::Environment(sky.into());
    let position = DVec3::new(2.0, 3.5, 2.0);
    let point = |falloff| DeltaLightKind::Point { position, falloff, shadow_near: 0.1 };
    scene.appearance.lights = vec![
        delta_light(point(Falloff::InverseSquare), true, LightUnits::Physical),
        delta_light(point(Falloff::None), false, LightUnits::Classical),
        delta_light(DeltaLightKind::Directional { direction: DVec3::new(0.6, -0.8, 0.0) }, true, LightUnits::Classical),
    ];
    scene
}

/// Material of a bubble in glass and water.
const BUBBLE: u32 = 13;

/// The exhibition with clouds of smoke that overlap each other, glass and a light. The bubble is of air.
fn smoky_exhibition() -> Scene {
    let mut scene = exhibition();
    let clear = MaterialModel::Dielectric { roughness: 0.0, transmittance: gray(1.0) };
    let smoke = |absorption: Rgb, priority| solid(clear.clone(), InteriorMedium { ior: 1.0, absorption, priority });
    let first = scene.appearance.materials.len() as u32;
    scene.appearance.materials.extend([smoke(Rgb::new(0.3, 0.2, 0.4), 0), smoke(Rgb::new(0.1, 0.9, 0.2), 2)]);
    scene.appearance.materials[BUBBLE as usize] = solid(clear.clone(), InteriorMedium::clear(1.0));
    scene.world.shadowless = vec![first, first + 1, BUBBLE];
    for (center, radius, material) in [([-1.5, 1.0, 0.6], 1.1, 0), ([0.0, 3.0, 0.3], 1.3, 1), ([1.6, 0.7, 0.6], 1.2, 1)]
    {
        scene = scene.with(sphere_at(center, radius), first + material, None);
    }
    scene
}

/// Rays through the exhibition, with directions of other lengths than 1.
fn views(count: u64) -> Vec<Ray> {
    let number = |index, dimension| random::unit(random::hash(&[41, index, dimension]));
    let ray = |index| {
        let target =
            DVec3::new(6.0 * number(index, 0) - 3.0, 2.5 * number(index, 1) - 0.3, 4.0 * number(index, 2) - 2.0);
        let origin = DVec3::new(4.0 * number(index, 3) - 2.0, 1.5, 6.0);
        Ray { time: number(index, 4), ..Ray::new(origin, (target - origin) * (0.2 + number(index, 5))) }
    };
    (0..count).map(ray).collect()
}

#[test]
fn every_path_has_the_radiance_of_the_reference() {
    let mut scene = exhibition();
    scene.world.shading_normal = Some(Box::new(tilted_normal));
    let lights = scene.light_set();
    let bsdfs = BsdfCache::new(&scene.appearance, |_| true);
    assert!(bsdfs.count().0 > 4, "{:?}", bsdfs.count());
    let lighting = Lighting { appearance: &scene.appearance, lights: &lights, bsdfs: &bsdfs };
    let (air, water) = (InteriorList::default(), InteriorList::filled_with(3));
    let mixed: Vec<_> = (0..RAYS).map(|at| if at % 2 == 0 { air.clone() } else { water.clone() }).collect();
    for settings in all_settings() {
        for camera_media in [from_ref(&air), from_ref(&water), &mixed] {
            let (seen, counts) = trace(&mut scene.world, lighting, settings, camera_media, &views(RAYS));
            // The scene has what is compared. In water, the sphere of air hides what is inside from many rays.
            let lit = seen.iter().filter(|seen| seen.hit && !seen.radiance.is_black()).count();
            let (min_lit, min_null_interfaces) =
                if camera_media == from_ref(&air) { (RAYS as usize / 2, RAYS / 3) } else { (RAYS as usize / 20, 0) };
            assert!(
                lit > min_lit && counts.null_interfaces >= min_null_interfaces,
                "{lit} of {RAYS}, {settings:?}: {counts:?}"
            );
            let may_clamp = settings.clamp != Clamp::NONE && settings.max_depth > 0;
            assert_eq!(counts.clamped > RAYS / 30, may_clamp, "{settings:?}: {counts:?}");
        }
    }
}

#[test]
fn every_path_through_smoke_has_the_radiance_of_the_reference() {
    assert!(!exhibition().appearance.has_shadow_media(&ShadingFeatures::ALL));
    let mut scene = smoky_exhibition();
    assert!(scene.appearance.has_shadow_media(&ShadingFeatures::ALL));
    let lights = scene.light_set();
    let bsdfs = BsdfCache::new(&scene.appearance, |_| true);
    let lighting = Lighting { appearance: &scene.appearance, lights: &lights, bsdfs: &bsdfs };
    let (air, water) = (InteriorList::default(), InteriorList::filled_with(3));
    for settings in all_settings().step_by(3) {
        for (camera_media, is_air) in [(&air, true), (&water, false)] {
            let (seen, counts) = trace(&mut scene.world, lighting, settings, from_ref(camera_media), &views(RAYS));
            let lit = seen.iter().filter(|seen| seen.hit && !seen.radiance.is_black()).count();
            assert!(
                lit > RAYS as usize / 20 && counts.null_interfaces > RAYS / 2,
                "{lit} of {RAYS}, {settings:?}: {counts:?}"
            );
            let in_lanes = counts.lanes_used > 0 || settings.max_depth == 0 || LaneLevel::best().is_none();
            assert!(in_lanes || !is_air, "{settings:?}: {counts:?}");
        }
    }
}

/// Triangles and spheres of all materials, some of which emit light, above a plane; a quad is the light.
fn triangles_and_spheres() -> Scene {
    let number = |at, dimension| random::unit(random::hash(&[43, at, dimension]));
    let vector = |at, first| DVec3::new(number(at, first), number(at, first + 1), number(at, first + 2)) - 0.5;
    let emission = Emission::new(Rgb::new(7.0, 5.0, 3.0), EmissionSides::Both).expect("an emission");
    let quad =
        QuadLight::new(DVec3::new(-0.7, 3.0, -0.7), [DVec3::X * 1.4, DVec3::Z * 1.4], emission).expect("a light");
    let rough = MaterialModel::Diffuse { albedo: gray(0.8), roughness: 0.5 };
    let mirror = MaterialModel::Mirror { reflectance: gray(0.9) };
    let materials = vec![
        emissive(diffuse(0.6), 0.0),
        emissive(rough, 0.0),
        emissive(diffuse(0.3), 0.5),
        emissive(mirror, 0.0),
        emissive(diffuse(0.0), 0.0),
        emissive(MaterialModel::ThinGlass { ior: 1.5, transmittance: gray(0.8) }, 0.0),
        Material::new(String::new(), Phong { specular: gray(0.6), exponent: 30.0, ..Phong::default() }),
        emissive(MaterialModel::Glossy { diffuse: gray(0.5), specular: gray(0.4), exponent: 2e4 }, 0.0),
        Material::new(
            String::new(),
            Phong { specular: gray(0.8), diffuse: gray(1e-3), exponent: 0.0, ..Phong::default() },
        ),
        emissive(metallic_roughness(0.0, 0.3), 0.0),
        emissive(metallic_roughness(1.0, 0.1), 0.0),
        emissive(metallic_roughness(0.4, 1.0), 0.3),
    ];
    let mut scene = Scene::new(materials, vec![Light::Quad(quad)]).with(floor(), 6, None);
    scene.appearance.ambient = Rgb::gray(0.1);
    for at in 0..36 {
        let corner = vector(at, 0) * DVec3::new(5.0, 2.0, 3.0) + DVec3::Y;
        let vertices = [corner, corner + vector(at, 3) * 2.0, corner + vector(at, 6) * 2.0];
        let triangle = rt_geometry::Triangle::new(vertices).expect("a triangle");
        scene = scene.with(Shape::Triangle(triangle), (at % 12) as u32, None);
        let center = vector(at + 36, 0) * DVec3::new(5.0, 2.0, 3.0) + DVec3::Y;
        scene = scene.with(sphere_at(center.to_array(), 0.1 + 0.2 * number(at, 9)), (at % 12) as u32, None);
    }
    // Rays from there start where a coordinate is too small for lanes.
    let wall = [DVec3::new(-3.0, 0.0, 0.0), DVec3::new(3.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];
    let wall = wall.map(|vertex| vertex + DVec3::Z * 1e-290);
    scene.with(Shape::Triangle(rt_geometry::Triangle::new(wall).expect("a triangle")), 0, None)
}

/// The light of the scene, a second one, one that faces up, a black one, and a disk.
fn several_lights(scene: &Scene) -> Vec<Light> {
    let quad = |corner: [f64; 3], edges, radiance, sides| {
        let emission = Emission::new(Rgb::gray(radiance), sides).expect("an emission");
        Light::Quad(QuadLight::new(corner.into(), edges, emission).expect("a light"))
    };
    let edges = [DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.1, 0.0, 0.4)];
    let emission = Emission::new(Rgb::new(2.0, 1.0, 3.0), EmissionSides::Both).expect("an emission");
    let disk = DiskLight::new(DVec3::new(0.0, 2.0, 3.0), DVec3::Z, 0.3, 0.1, emission).expect("a light");
    let others = [
        quad([2.0, 2.0, 0.0], edges, 9.0, EmissionSides::Both),
        quad([-2.0, 0.5, 0.0], edges, 20.0, EmissionSides::Front),
        quad([1.0, 1.5, 0.0], edges, 0.0, EmissionSides::Both),
        Light::Disk(disk),
    ];
    scene.lights.iter().cloned().chain(others).collect()
}

#[test]
fn every_path_between_triangles_and_spheres_has_the_radiance_of_the_reference() {
    let mut scene = triangles_and_spheres();
    let point = |x, shadow_near| {
        let position = DVec3::new(x, 2.5, 1.5);
        DeltaLightKind::Point { position, falloff: Falloff::InverseSquare, shadow_near }
    };
    let spot = DeltaLightKind::Spot {
        position: DVec3::new(0.0, 3.0, 3.0),
        direction: DVec3::new(0.0, -0.6, -0.8),
        cos_inner: 0.95,
        cos_outer: 0.8,
        falloff: Falloff::None,
    };
    let sun = DeltaLightKind::Directional { direction: DVec3::new(0.6, -0.8, 0.0) };
    let delta_lights = vec![
        delta_light(point(2.0, 0.5), true, LightUnits::Physical),
        delta_light(point(-2.0, 0.0), false, LightUnits::Classical),
        delta_light(spot, true, LightUnits::Classical),
        delta_light(sun, true, LightUnits::Classical),
    ];
    for (delta_lights, area_lights) in
        [(Vec::new(), scene.lights.clone()), (delta_lights.clone(), Vec::new()), (delta_lights, several_lights(&scene))]
    {
        (scene.appearance.lights, scene.lights) = (delta_lights, area_lights);
        let distributed = [0, 4].map(|max_depth| PathSettings { max_depth, ..DISTRIBUTED });
        for settings in all_settings().chain(distributed) {
            let (seen, counts) = scene.trace(settings, &views(RAYS + 1));
            let lit = seen.iter().filter(|seen| seen.hit && !seen.radiance.is_black()).count();
            assert!(lit > RAYS as usize / 6, "{lit} of {RAYS}, {settings:?}");
            // Rays hit the floor, which has a highlight, more often than all else.
            assert!(counts.lanes_used > RAYS / 2 || LaneLevel::best().is_none(), "{counts:?}");
        }
    }
}

/// Metallic-roughness surfaces alone, textured and not, of all roughnesses, in a scene where nothing else emits light.
#[test]
fn metallic_roughness_in_lanes_has_the_radiance_of_the_reference() {
    for (at, roughness) in [0.0, 0.02, 0.1, 0.5, 0.98, 1.0, 3.0, f64::NAN].into_iter().enumerate() {
        let metallic = [0.0, 0.5, 1.0][at % 3];
        let base = LayeredBase::MetallicRoughness {
            base_color: ColorTexture::Textured(TextureId(0), Rgb::new(0.9, 0.8, 0.2)),
            metallic: FloatTexture::Constant(1.0 - metallic),
            roughness: FloatTexture::Constant(roughness),
        };
        let textured = MaterialModel::Layered(LayeredSurface::new(base).into());
        let materials = vec![emissive(metallic_roughness(metallic, roughness), 0.0), emissive(textured, 0.0)];
        let mut scene = Scene::new(materials, triangles_and_spheres().lights).with(floor(), 0, None);
        for x in [-1.5, 0.0, 1.5] {
            scene = scene.with(sphere_at([x, 0.7, 0.2], 0.7), 1, None);
        }
        scene.appearance.textures = vec![Texture::Checker { even: Rgb::WHITE, odd: Rgb::BLACK, size: 0.25 }];
        scene.appearance.ambient = Rgb::gray(0.1);
        for settings in [paths(0), paths(4), DISTRIBUTED] {
            let (_, counts) = scene.trace(settings, &views(1001));
            let is_rough = roughness >= 0.1;
            assert!(!is_rough || counts.lanes_used > 700 || LaneLevel::best().is_none(), "{settings:?}: {counts:?}");
        }
    }
}

/// Spheres that are so small and far away that rounding puts hits on their centres, and a path within a sphere.
#[test]
fn stiff_spheres_have_the_radiance_of_the_reference() {
    let materials = vec![emissive(diffuse(0.8), 0.0)];
    let mut scene = Scene::new(materials, triangles_and_spheres().lights);
    for x in 0..8 {
        scene = scene.with(sphere_at([f64::from(x), 0.0, 0.0], 1e-3), 0, None);
    }
    scene = scene.with(sphere_at([0.0, 0.0, -3e20], 1e20), 0, None);
    scene.appearance.background = Background::Constant(Rgb::WHITE);
    let on_centres = |x: f64| Ray::new(DVec3::new(x, 0.0, 1e17), DVec3::NEG_Z * 1e3);
    let within = |x: f64| Ray::new(DVec3::new(x, 0.0, -3e20), DVec3::new(0.1 * x, 1.0, 0.3) * 1e-280);
    let rays: Vec<_> = (0..8).map(f64::from).flat_map(|x| [on_centres(x), within(x)]).collect();
    let (seen, counts) = scene.trace(paths(5), &rays);
    assert!(seen.iter().all(|seen| seen.hit));
    assert!(counts.lanes > 15 || LaneLevel::best().is_none(), "{counts:?}");
}

/// Null interfaces: more than a ray may pass without a bounce, and more solids within each other than a list holds.
#[test]
fn a_path_through_many_null_interfaces_has_the_radiance_of_the_reference() {
    let air = solid(MaterialModel::Dielectric { roughness: 0.0, transmittance: gray(1.0) }, InteriorMedium::clear(1.0));
    let mut scene = Scene::new(vec![air, emissive(diffuse(0.5), 0.3)], Vec::new());
    scene.appearance.background = Background::Constant(Rgb::WHITE);
    for z in 0..1100 {
        let plane = Plane::new(DVec3::NEG_Z * f64::from(z), DVec3::Z).expect("a plane");
        scene = scene.with(Shape::Plane(plane), 0, None);
    }
    for (max_depth, is_behind_seen) in [(0, false), (75, false), (76, true), (200, true)] {
        let (seen, counts) = scene.trace(paths(max_depth), &[Ray::new(DVec3::Z, DVec3::NEG_Z)]);
        assert_eq!(!seen[0].radiance.is_black(), is_behind_seen, "{max_depth}: {seen:?}");
        assert!(counts.interior_overflows > 900, "{counts:?}");
    }
    // A surface among them, from which the path goes back.
    let wall = Plane::new(DVec3::NEG_Z * 550.5, DVec3::Z).expect("a plane");
    let mut scene = scene.with(Shape::Plane(wall), 1, None);
    let (seen, _) = scene.trace(paths(1), &[Ray::new(DVec3::Z, DVec3::new(0.0, 0.3, -1.0)); 20]);
    assert!(seen.iter().any(|seen| seen.radiance.g > 0.31), "{seen:?}");
}
