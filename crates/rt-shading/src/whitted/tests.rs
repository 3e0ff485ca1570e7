//! Tests of the integrator in worlds that are known in closed form.

use super::*;
use crate::{
    Background, DeltaLight, DeltaLightKind, Falloff, InteriorMedium, Material, Phong, SurfaceHit, Transmission,
    test_worlds::{HitFunction, flat_hit, gray, whitted_of},
};
use rt_geometry::{InteractionFlags, RayKind};
use rt_math::{DVec3, Rgb, transcendental::exp};

/// A world in which every ray meets the surface `material` at distance 2 from either side, `bounces` times over,
/// and then leaves. It turns its normal against the ray, or along it for rays that come from inside.
struct Echo {
    bounces: u32,
    traced: Vec<RayKind>,
    shadow_rays: u32,
    shadowed: bool,
}

impl Echo {
    fn new(bounces: u32) -> Self {
        Self { bounces, traced: vec![], shadow_rays: 0, shadowed: false }
    }
}

impl SceneQueries for Echo {
    fn closest(&mut self, ray: &Ray, _: Interval, kind: RayKind, _: InteractionFlags) -> Option<SurfaceHit> {
        self.traced.push(kind);
        if self.traced.len() as u32 > self.bounces {
            return None;
        }
        let against = -ray.direction.normalize();
        let normal = if kind == RayKind::Refraction { -against } else { against };
        let t = 2.0 / ray.direction.length();
        Some(flat_hit(t, ray.at(t), normal, 0))
    }

    fn occluded(&mut self, _: &Ray, _: Interval) -> bool {
        self.shadow_rays += 1;
        self.shadowed
    }
}

fn white_walls(phong: Phong) -> Appearance {
    walls_of(Material::new("only".into(), phong))
}

/// A white room with a dielectric.
fn white_walls_with(phong: Phong, interior: InteriorMedium) -> Appearance {
    walls_of(Material { interior: Some(interior), ..Material::new("only".into(), phong) })
}

fn walls_of(material: Material) -> Appearance {
    Appearance { materials: vec![material], background: Background::Constant(Rgb::WHITE), ..Appearance::default() }
}

fn look(world: &mut Echo, appearance: &Appearance, depth: u32) -> (f64, ShadingCounts) {
    let mut whitted = whitted_of(appearance, depth);
    let ray = Ray::new(DVec3::ZERO, DVec3::new(0.0, 0.0, -3.0));
    let trimmed = whitted.radiance(world, appearance, &ray).radiance;
    let mut again = Echo { traced: vec![], shadow_rays: 0, ..*world };
    let full = Whitted::new(depth, 0.0, ShadingFeatures::ALL).radiance(&mut again, appearance, &ray).radiance;
    assert_eq!(trimmed, full, "trimmed and full shading must agree to the bit");
    (trimmed.r, whitted.counts())
}

fn glowing_mirror() -> Appearance {
    let mirror = Material::new("only".into(), Phong { mirror: gray(0.5), ..Phong::BLACK });
    walls_of(Material { emission: gray(1.0), ..mirror })
}

#[test]
fn depth_counts_bounces_after_the_first_hit() {
    let glowing_mirror = glowing_mirror();
    for (depth, expected) in [(0, 1.0), (1, 1.5), (2, 1.75), (5, 1.96875)] {
        let (seen, _) = look(&mut Echo::new(u32::MAX), &glowing_mirror, depth);
        assert_eq!(seen, expected, "depth {depth}");
    }
}

#[test]
fn faint_rays_are_not_followed() {
    let appearance = glowing_mirror();
    let mut world = Echo::new(u32::MAX);
    let mut whitted = Whitted::new(1000, 0.1, ShadingFeatures::ALL);
    let seen = whitted.radiance(&mut world, &appearance, &Ray::new(DVec3::ZERO, DVec3::NEG_Z));
    assert_eq!(seen.radiance.r, 1.875);
    assert_eq!(world.traced.len(), 4);
}

#[test]
fn fresnels_equations_share_light_without_loss() {
    let glass = Transmission { coefficient: gray(1.0), fresnel: true };
    let inside = InteriorMedium::clear(1.5);
    let appearance = white_walls_with(Phong { mirror: gray(1.0), transmission: Some(glass), ..Phong::BLACK }, inside);
    let mut world = Echo::new(1);
    let (seen, counts) = look(&mut world, &appearance, 1);
    assert_eq!(world.traced, [RayKind::Primary, RayKind::Reflection, RayKind::Refraction]);
    assert!((seen - 1.0).abs() < 1e-14, "reflected and refracted parts add up: {seen}");
    assert_eq!(counts.fresnel, 1);
    // Without what is mirrored, the reflectance at right angles, 0.04, is missing.
    let clear = white_walls_with(Phong { transmission: Some(glass), ..Phong::BLACK }, inside);
    let (seen, _) = look(&mut Echo::new(1), &clear, 1);
    assert!((seen - 0.96).abs() < 1e-14, "{seen}");
}

#[test]
fn what_stands_inside_glass_is_seen_through_it() {
    // Into tinted glass, 2 units to an opaque glowing object in it, which is met from its outside.
    let clear = Transmission { coefficient: gray(1.0), fresnel: false };
    let tinted = InteriorMedium { absorption: Rgb::new(0.5, 0.0, 1.0), ..InteriorMedium::clear(1.5) };
    let mut appearance = white_walls_with(Phong { transmission: Some(clear), ..Phong::BLACK }, tinted);
    let core = Material::new("core".into(), Phong { mirror: gray(1.0), ..Phong::BLACK });
    appearance.materials.push(Material { emission: gray(1.0), ..core });
    // The glass, the core, and the glass again from inside.
    let mut surfaces = [(-1.0, 0), (-1.0, 1), (1.0, 0)].into_iter();
    let mut paperweight = HitFunction(|ray: &Ray, _| {
        let (side, material) = surfaces.next()?;
        Some(flat_hit(2.0, ray.at(2.0), ray.direction * side, material))
    });
    let ray = Ray::new(DVec3::ZERO, DVec3::NEG_Z);
    let seen = whitted_of(&appearance, 9).radiance(&mut paperweight, &appearance, &ray).radiance;
    // The core's own light goes 2 units through the glass, the mirrored room's goes 4.
    let expected = Rgb::new(exp(-1.0) + exp(-2.0), 2.0, exp(-2.0) + exp(-4.0));
    assert!((seen - expected).map(f64::abs).max_component() < 1e-14, "{seen:?}");
}

#[test]
fn totally_reflected_light_is_dropped_when_mixed_by_constants() {
    // A ray that grazes a denser outside: the shading normal is tilted, so that Snell has no solution.
    let thin = Transmission { coefficient: gray(0.85), fresnel: false };
    let phong = Phong { transmission: Some(thin), mirror: gray(0.2), ..Phong::BLACK };
    let appearance = white_walls_with(phong, InteriorMedium::clear(0.2));
    let mut surface = Some(flat_hit(1.0, DVec3::ZERO, DVec3::new(0.8, 0.0, 0.6), 0));
    let mut tilted = HitFunction(|_: &Ray, _| surface.take());
    let seen = whitted_of(&appearance, 3).radiance(&mut tilted, &appearance, &Ray::new(DVec3::Z, DVec3::NEG_Z));
    assert_eq!(seen.radiance, Rgb::gray(0.2), "the mirrored part alone");
}

#[test]
fn local_light_is_phongs_sum() {
    let light = |casts_shadows| DeltaLight {
        casts_shadows,
        ..DeltaLight::new(
            DeltaLightKind::Point { position: DVec3::ZERO, falloff: Falloff::None, shadow_near: 0.0 },
            Rgb::gray(2.0),
        )
    };
    let phong = Phong { ambient: gray(0.1), diffuse: gray(0.5), specular: gray(0.25), exponent: 3.0, ..Phong::BLACK };
    let mut appearance = white_walls(phong);
    appearance.materials[0].emission = gray(0.01);
    appearance.ambient = Rgb::gray(0.5);
    appearance.lights = vec![light(true), light(false)];
    let mut world = Echo::new(1);
    let (seen, counts) = look(&mut world, &appearance, 0);
    let each = 2.0 * (0.5 + 0.25);
    assert!((seen - (0.01 + 0.05 + 2.0 * each)).abs() < 1e-14, "{seen}");
    assert_eq!((world.shadow_rays, counts.highlights), (1, 2), "one of the lights casts shadows");
    world = Echo { shadowed: true, ..Echo::new(1) };
    let (seen, _) = look(&mut world, &appearance, 0);
    assert!((seen - (0.01 + 0.05 + each)).abs() < 1e-14, "{seen}");
}

#[test]
fn lights_behind_the_surface_cost_no_shadow_ray() {
    let kind = DeltaLightKind::Point { position: DVec3::Z * -9.0, falloff: Falloff::None, shadow_near: 0.0 };
    let mut appearance = white_walls(Phong { diffuse: gray(1.0), ..Phong::BLACK });
    appearance.lights = vec![DeltaLight::new(kind, Rgb::WHITE)];
    let mut world = Echo::new(1);
    let (seen, counts) = look(&mut world, &appearance, 0);
    assert_eq!((seen, world.shadow_rays, counts.shadow_rays_skipped), (0.0, 0, 1));
}

#[test]
fn unknown_materials_are_black() {
    let mut appearance = white_walls(Phong::BLACK);
    appearance.materials.clear();
    assert_eq!(look(&mut Echo::new(1), &appearance, 3).0, 0.0);
}

pub(super) mod lanes;
mod nested_dielectrics;
mod shading_normals;
