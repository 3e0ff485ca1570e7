//! Tests of nested dielectrics against paths in closed form.

use super::super::*;
use crate::{
    Background, ColorTexture, InteriorMedium, Material, Phong, Transmission,
    test_worlds::{HitFunction, ShapeList, flat_hit, gray, whitted_of},
};
use rt_geometry::{Cuboid, Plane, Shape, Sphere, Triangle};
use rt_math::{
    DVec3, Rgb,
    transcendental::{asin, cos, exp, sin, sincos, tan},
};

/// World of shapes with materials that records rays.
fn world_of(shapes: &[(Shape, u32)]) -> ShapeList {
    let shapes = shapes.iter().map(|(shape, material)| (shape.clone(), *material, None)).collect();
    ShapeList { shapes, rays: Some(Vec::new()), ..ShapeList::default() }
}

fn sphere(x: f64, y: f64, z: f64, radius: f64) -> Shape {
    Shape::Sphere(Sphere::new(DVec3::new(x, y, z), radius).expect("a sphere"))
}

/// A box 20 units wide between two heights.
fn slab(bottom: f64, top: f64) -> Shape {
    Shape::Cuboid(Cuboid::new(DVec3::new(-10.0, bottom, -10.0), DVec3::new(10.0, top, 10.0)).expect("a box"))
}

const WHITE: ColorTexture = ColorTexture::Constant(Rgb::WHITE);

/// A clear dielectric that lets all light pass, whatever its angle.
fn dielectric(ior: f64, absorption: f64, priority: i32) -> Material {
    let interior = Some(InteriorMedium { ior, absorption: Rgb::gray(absorption), priority });
    Material { interior, ..Material::new(String::new(), clear()) }
}

fn clear() -> Phong {
    Phong { transmission: Some(Transmission { coefficient: WHITE, fresnel: false }), ..Phong::BLACK }
}

/// A clear dielectric of Fresnel's glass.
fn fresnel(ior: f64) -> Material {
    let transmission = Some(Transmission { coefficient: WHITE, fresnel: true });
    Material { model: Phong { mirror: WHITE, transmission, ..Phong::BLACK }.into(), ..dielectric(ior, 0.0, 0) }
}

fn glow(radiance: f64) -> Material {
    Material { emission: gray(radiance), ..Material::new(String::new(), Phong::BLACK) }
}

fn white_walls(materials: &[Material]) -> Appearance {
    Appearance { materials: materials.to_vec(), background: Background::Constant(Rgb::WHITE), ..Appearance::default() }
}

struct Look {
    seen: Rgb,
    rays: Vec<Ray>,
    counts: ShadingCounts,
}

impl Look {
    fn last(&self) -> Ray {
        *self.rays.last().expect("a ray was traced")
    }
}

/// Looks along a ray, with all of shading and with what is needed.
fn look(shapes: &[(Shape, u32)], appearance: &Appearance, depth: u32, ray: &Ray) -> Look {
    let (mut world, mut whitted) = (world_of(shapes), whitted_of(appearance, depth));
    let seen = whitted.radiance(&mut world, appearance, ray);
    let full = Whitted::new(depth, 0.0, ShadingFeatures::ALL).radiance(&mut world_of(shapes), appearance, ray);
    assert_eq!(seen, full, "trimmed and full shading must agree to the bit");
    Look { seen: seen.radiance, rays: world.rays.unwrap_or_default(), counts: whitted.counts() }
}

/// A unit vector that runs down, `degrees` from the vertical towards +x.
fn down(degrees: f64) -> DVec3 {
    let (sin, cos) = sincos(degrees.to_radians());
    DVec3::new(sin, -cos, 0.0)
}

/// Glass from 0 to 1, and water below it from −2 that reaches half a unit into the glass.
#[test]
fn water_that_reaches_into_its_glass_begins_where_the_glass_ends() {
    let (glass, water) = (dielectric(1.5, 0.3, 1), dielectric(1.333, 0.7, 0));
    let ray = Ray::new(DVec3::new(0.0, 1.0, 0.0) - down(45.0), down(45.0));
    let shapes = [(slab(0.0, 1.0), 0), (slab(-2.0, 0.5), 1)];
    let look = look(&shapes, &white_walls(&[glass, water]), 3, &ray);
    // Snell's law at each boundary.
    let in_glass = asin(sin(45f64.to_radians()) / 1.5);
    let in_water = asin(sin(45f64.to_radians()) / 1.333);
    let out = look.last();
    let expected = DVec3::new(tan(in_glass) + 2.0 * tan(in_water), -2.0, 0.0);
    assert!((out.origin - expected).length() < 1e-14, "{}", out.origin);
    assert!((out.direction - ray.direction).length() < 1e-15);
    let tint = exp(-0.3 / cos(in_glass) - 0.7 * 2.0 / cos(in_water));
    assert!((look.seen.r - tint).abs() < 1e-14, "{} not {tint}", look.seen.r);
    assert_eq!(
        (look.counts.null_interfaces, look.counts.refractions),
        (1, 3),
        "the water's surface in the glass is not there"
    );
}

#[test]
fn the_greater_priority_carves_the_other_dielectric_from_both_sides() {
    // The same dielectrics with the water above the glass: it begins at 0.5.
    let shapes = [(slab(0.0, 1.0), 0), (slab(-2.0, 0.5), 1)];
    let appearance = white_walls(&[dielectric(1.5, 0.3, -1), dielectric(1.333, 0.7, 0)]);
    let expected = exp(-0.3 * 0.5 - 0.7 * 2.5);
    for (y, direction) in [(3.0, DVec3::NEG_Y), (-3.0, DVec3::Y)] {
        let Look { seen, counts, .. } = look(&shapes, &appearance, 3, &Ray::new(DVec3::Y * y, direction));
        assert!((seen.r - expected).abs() < 1e-15, "{} not {expected}", seen.r);
        assert_eq!(counts.null_interfaces, 1);
    }
}

#[test]
fn the_outer_tint_is_remembered_when_an_inner_dielectric_is_left() {
    let shapes = [(sphere(0.0, 0.0, 0.0, 2.0), 0), (sphere(0.3, 0.0, 0.0, 1.0), 1)];
    let appearance = white_walls(&[dielectric(1.5, 0.25, 0), dielectric(1.7, 0.5, 0)]);
    let Look { seen, .. } = look(&shapes, &appearance, 9, &Ray::new(DVec3::X * 5.0, DVec3::NEG_X));
    let expected = exp(-(0.25 * 2.0 + 0.5 * 2.0));
    assert!((seen.r - expected).abs() < 1e-14, "{} not {expected}", seen.r);
}

#[test]
fn a_bubble_in_glass_bends_light_as_air_does() {
    // 20° in glass is asin(1.5 sin 20°) in the bubble, a slab of air; nothing is absorbed in it.
    let shapes = [(slab(-1.0, 1.0), 0), (slab(-0.25, 0.25), 1)];
    let appearance = white_walls(&[dielectric(1.5, 0.4, 0), dielectric(1.0, 0.0, 1)]);
    let outside = asin(1.5 * sin(20f64.to_radians())).to_degrees();
    let ray = Ray::new(DVec3::Y - down(outside), down(outside));
    let Look { seen, rays, .. } = look(&shapes, &appearance, 9, &ray);
    let expected = exp(-0.4 * 1.5 / cos(20f64.to_radians()));
    assert!((seen.r - expected).abs() < 1e-14, "{} not {expected}", seen.r);
    assert!((rays[2].direction - ray.direction).length() < 1e-15);
}

#[test]
fn only_what_the_index_of_refraction_does_vanishes_where_it_is_the_same() {
    let half = gray(0.5);
    let with = |phong: Phong, ior: f64| Material { model: phong.into(), ..dielectric(ior, 0.0, 0) };
    let film = Transmission { coefficient: half, fresnel: false };
    let painted = with(Phong { mirror: half, transmission: Some(film), ..Phong::BLACK }, 1.0);
    let shapes = [(sphere(0.0, 0.0, 0.0, 1.0), 0)];
    let ray = Ray::new(DVec3::Z * 3.0, DVec3::NEG_Z);
    // Half is mirrored at the front, a quarter passes both surfaces, and what the back mirrors is cut off.
    let Look { seen, .. } = look(&shapes, &white_walls(std::slice::from_ref(&painted)), 2, &ray);
    assert_eq!(seen, Rgb::gray(0.75));
    assert!(!painted.is_clear() && fresnel(1.0).is_air() && !fresnel(1.1).is_air());
    let smoke = dielectric(1.0, 0.1, 0);
    assert!(smoke.is_clear() && !smoke.is_air());
    assert!(!Phong { specular: half, ..clear() }.is_clear());
    assert!(Phong { specular: half, ..*fresnel(1.0).to_phong() }.is_clear());
}

#[test]
fn smoke_is_seen_though_its_surface_is_not() {
    let appearance = white_walls(&[dielectric(1.0, 0.5, 0)]);
    let (mut world, ray) = (world_of(&[(sphere(0.0, 0.0, 0.0, 1.0), 0)]), Ray::new(DVec3::Z * 3.0, DVec3::NEG_Z));
    let seen = whitted_of(&appearance, 0).radiance(&mut world, &appearance, &ray);
    assert!(seen.hit && (seen.radiance.r - exp(-1.0)).abs() < 1e-15);
    let air = white_walls(&[dielectric(1.0, 0.0, 0)]);
    assert!(!whitted_of(&air, 0).radiance(&mut world, &air, &ray).hit);
}

#[test]
fn a_dielectric_a_billionth_under_the_glass_is_seen_through_it() {
    let shapes = [(sphere(0.0, 0.0, 0.0, 1.0), 0), (sphere(0.0, 0.0, 0.0, 1.0 - 1e-9), 1)];
    let appearance = white_walls(&[dielectric(1.5, 0.0, 0), glow(0.25)]);
    for i in 0..10_000 {
        // Offsets up to 0.9999 of the radius, all around.
        let (sin, cos) = sincos(f64::from(i) * 2.4);
        let distance = 0.9999 * (f64::from(i) / 1e4).sqrt();
        let ray = Ray::new(DVec3::new(cos * distance, sin * distance, 7.0), DVec3::NEG_Z);
        let seen = whitted_of(&appearance, 5).radiance(&mut world_of(&shapes), &appearance, &ray);
        assert_eq!(seen.radiance, Rgb::gray(0.25), "ray {i}");
    }
}

#[test]
fn a_dielectric_that_was_never_entered_is_left_as_if_it_had_been() {
    // From the middle of a slab that the ray never entered: Snell's law and Beer's on the way out.
    let ray = Ray::new(DVec3::ZERO, down(30.0));
    let out = look(&[(slab(-1.0, 1.0), 0)], &white_walls(&[dielectric(1.5, 0.5, 0)]), 5, &ray);
    assert!((out.last().direction.x - 0.75).abs() < 1e-15);
    assert!((out.seen.r - exp(-0.5 / cos(30f64.to_radians()))).abs() < 1e-15);
    // Mirrored inside, it goes on inside.
    let steep = Ray::new(DVec3::ZERO, down(60.0));
    let mirrors = Material { model: Phong { mirror: WHITE, ..clear() }.into(), ..dielectric(1.5, 0.5, 0) };
    let Look { seen, .. } = look(&[(slab(-1.0, 1.0), 0)], &white_walls(&[mirrors]), 1, &steep);
    assert_eq!(seen, Rgb::BLACK, "totally reflected, and met by the other face with no bounces left");
}

#[test]
fn camera_media_that_are_known_carve_what_the_camera_stands_in() {
    // In water 0.5 above the bottom of a glass: the ray goes through the water, the glass, and out.
    let shapes = [(slab(-1.0, 1.0), 0), (slab(-9.0, 0.0), 1)];
    let appearance = white_walls(&[dielectric(1.33, 0.5, 0), dielectric(1.5, 0.25, 1)]);
    let mut world = world_of(&shapes);
    let mut interior = InteriorList::default();
    let ray = Ray::new(DVec3::Y * 0.5, down(20.0));
    interior.find_enclosing_media(&mut world, &appearance.materials, &Ray::new(ray.origin, DVec3::new(0.1, 0.9, 0.2)));
    assert!(!interior.is_empty());
    for camera_media in [&interior, &InteriorList::filled_with(0)] {
        let mut whitted = whitted_of(&appearance, 5);
        whitted.set_camera_media(core::slice::from_ref(camera_media));
        let seen = whitted.radiance(&mut world, &appearance, &ray).radiance;
        let in_glass = asin(sin(20f64.to_radians()) * 1.33 / 1.5);
        let expected = exp(-0.5 * 0.5 / cos(20f64.to_radians()) - 0.25 * 9.0 / cos(in_glass));
        assert!((seen.r - expected).abs() < 1e-14, "{} not {expected}", seen.r);
        assert_eq!(whitted.counts().null_interfaces, 1, "the water ends within the glass");
    }
}

#[test]
fn too_many_dielectrics_within_each_other_are_counted() {
    let shapes: Vec<_> = (0..40).map(|i| (sphere(0.0, 0.0, 0.0, 50.0 - f64::from(i)), 0)).collect();
    let ray = Ray::new(DVec3::Z * 60.0, DVec3::NEG_Z);
    let Look { seen, counts, .. } = look(&shapes, &white_walls(&[dielectric(1.5, 0.0, 0)]), 99, &ray);
    assert_eq!(seen, Rgb::WHITE);
    // Eight too many are not entered. Leaving them empties the list early, and the last are left as if they had been
    // around from the start.
    assert_eq!(counts.interior_overflows, 8);
}

#[test]
fn dielectrics_that_touch_are_met_as_one_surface() {
    let shapes = [(slab(0.0, 1.0), 0), (slab(-1.0, 0.0), 1)];
    let appearance = white_walls(&[dielectric(1.5, 0.5, 0), dielectric(1.333, 0.25, 0)]);
    let Look { seen, counts, .. } = look(&shapes, &appearance, 9, &Ray::new(DVec3::Y * 3.0, DVec3::NEG_Y));
    // The glass's side of it is met alone; the water is found out about when it is left.
    assert!((seen.r - exp(-0.5 - 0.25)).abs() < 1e-14, "{}", seen.r);
    assert_eq!(counts.refractions, 3);
}

#[test]
fn a_dielectric_may_be_closed_by_several_objects_of_its_material() {
    let plane = |y: f64, normal: DVec3| (Shape::Plane(Plane::new(DVec3::Y * y, normal).expect("a plane")), 0);
    let sides = [plane(1.0, DVec3::Y), plane(0.0, DVec3::NEG_Y)];
    let appearance = white_walls(&[dielectric(1.5, 0.3, 0)]);
    let ray = Ray::new(DVec3::new(-2.0, 3.0, 0.5), down(45.0));
    let (whole, parts) = (look(&[(slab(0.0, 1.0), 0)], &appearance, 9, &ray), look(&sides, &appearance, 9, &ray));
    assert!((whole.seen.r - parts.seen.r).abs() < 1e-15);
    assert_eq!(whole.counts, parts.counts);
}

/// The ray goes on along itself, and would meet the second triangle a rounding error behind the first.
#[test]
fn an_edge_that_two_triangles_share_is_entered_once() {
    let corners = [[0.1, 1.7, 0.3], [1.3, 0.9, -0.2], [0.2, 1.1, 1.6], [-1.1, 1.3, 0.4]].map(DVec3::from);
    let face = |[a, b, c]: [usize; 3]| {
        let upwards = (corners[b] - corners[a]).cross(corners[c] - corners[a]).y > 0.0;
        let order = if upwards { [a, b, c] } else { [a, c, b] };
        (Shape::Triangle(Triangle::new(order.map(|i| corners[i])).expect("a triangle")), 0)
    };
    let shapes = [face([0, 1, 2]), face([0, 2, 3])];
    let appearance = white_walls(&[dielectric(1.0, 0.0, 0)]);
    for i in 1..2000 {
        let target = corners[0].lerp(corners[2], f64::from(i) / 2000.0);
        let origin = DVec3::new(0.37, 5.1, -0.83);
        let Look { counts, .. } = look(&shapes, &appearance, 0, &Ray::new(origin, target - origin));
        assert_eq!(counts.null_interfaces, 1, "point {i} of the edge");
    }
}

#[test]
fn a_ray_through_endlessly_many_surfaces_ends() {
    let appearance = white_walls(&[dielectric(1.0, 0.0, 0)]);
    let (mut whitted, mut n_rays) = (whitted_of(&appearance, 7), 0u32);
    let mut sheets = HitFunction(|ray: &Ray, span: Interval| {
        n_rays += 1;
        let t = span.min.floor() + 1.0;
        Some(flat_hit(t, ray.at(t), if n_rays.is_multiple_of(2) { DVec3::Z } else { DVec3::NEG_Z }, 0))
    });
    let seen = whitted.radiance(&mut sheets, &appearance, &Ray::new(DVec3::ZERO, DVec3::NEG_Z));
    assert_eq!((seen.radiance, whitted.counts().depth_limited), (Rgb::BLACK, 1));
    assert_eq!(n_rays, crate::hit_context::MAX_NULL_INTERFACES + 8);
}
