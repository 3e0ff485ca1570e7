//! Tests of interpolated normals: rays start on the side of the facet that they belong to.

use super::super::*;
use crate::{
    Background, ColorTexture, DeltaLight, DeltaLightKind, InteriorMedium, Material, Phong, SurfaceHit, Transmission,
    optics, test_worlds::whitted_of,
};
use rt_geometry::{InteractionFlags, RayKind, SurfaceInteraction};
use rt_math::{DVec3, Interval, Rgb};

/// A floor at height 0 whose shading normal is not its own. The first ray meets it at the origin; later ones leave.
struct Facet {
    shading_normal: DVec3,
    later: Vec<(RayKind, Ray)>,
    shadow_rays: Vec<Ray>,
    met: bool,
}

impl SceneQueries for Facet {
    fn closest(&mut self, ray: &Ray, _: Interval, kind: RayKind, _: InteractionFlags) -> Option<SurfaceHit> {
        if self.met {
            self.later.push((kind, *ray));
            return None;
        }
        self.met = true;
        let interaction = SurfaceInteraction {
            shading_normal: self.shading_normal,
            ..SurfaceInteraction::flat(DVec3::ZERO, DVec3::splat(1e-12), DVec3::Y, [0.0; 2])
        };
        Some(SurfaceHit::new(1.0, interaction, 0, 0))
    }

    fn occluded(&mut self, ray: &Ray, _: Interval) -> bool {
        self.shadow_rays.push(*ray);
        // The facet itself blocks what starts on the other side of it.
        ray.origin.y * ray.direction.y < 0.0
    }
}

/// Radiance of the facet along `direction`.
fn look(direction: DVec3, shading_normal: DVec3, phong: Phong, lights: Vec<DeltaLight>) -> (Rgb, Facet) {
    let appearance = Appearance {
        materials: vec![Material {
            interior: phong.transmission.map(|_| InteriorMedium::clear(1.5)),
            ..Material::new("facet".into(), phong)
        }],
        lights,
        background: Background::Constant(Rgb::BLACK),
        ..Appearance::default()
    };
    let mut world = Facet { shading_normal, later: vec![], shadow_rays: vec![], met: false };
    let seen = whitted_of(&appearance, 1).radiance(&mut world, &appearance, &Ray::new(-direction, direction));
    (seen.radiance, world)
}

/// A unit vector in the xy-plane, `degrees` from +y towards +x.
fn tilted(degrees: f64) -> DVec3 {
    let (sin, cos) = rt_math::transcendental::sincos(degrees.to_radians());
    DVec3::new(sin, cos, 0.0)
}

const WHITE: ColorTexture = ColorTexture::Constant(Rgb::WHITE);

#[test]
fn mirrored_rays_start_and_stay_on_the_viewers_side() {
    let mut n_turned_back = 0;
    for (from, tilt) in (91..180).flat_map(|from| (-85..86).map(move |tilt| (from, tilt))) {
        let (direction, normal) = (tilted(f64::from(from)), tilted(f64::from(tilt)));
        let (_, world) = look(direction, normal, Phong { mirror: WHITE, ..Phong::BLACK }, vec![]);
        let [(RayKind::Reflection, ray)] = world.later[..] else { panic!("{:?}", world.later) };
        assert!(ray.origin.y > 0.0 && ray.direction.y >= 0.0, "view {from}°, normal {tilt}°: {ray:?}");
        n_turned_back += usize::from(optics::reflect(direction, normal).y < 0.0);
    }
    assert!(n_turned_back > 1000, "{n_turned_back}");
}

#[test]
fn refracted_rays_start_and_stay_on_the_far_side() {
    let glass = Transmission { coefficient: WHITE, fresnel: false };
    let phong = Phong { transmission: Some(glass), ..Phong::BLACK };
    // From inside, where the floor's normal points along the ray.
    let mut n_turned_back = 0;
    for (towards, tilt) in (0..90).flat_map(|towards| (-85..86).map(move |tilt| (towards, tilt))) {
        let (direction, normal) = (tilted(f64::from(towards)), tilted(f64::from(tilt)));
        let (_, world) = look(direction, normal, phong, vec![]);
        let Some((RayKind::Refraction, ray)) = world.later.first() else { continue };
        assert!(ray.origin.y > 0.0 && ray.direction.y >= 0.0, "view {towards}°, normal {tilt}°: {ray:?}");
        n_turned_back += usize::from(
            normal.dot(direction) > 0.0
                && optics::refract(direction, -normal, 1.5).is_some_and(|refracted| refracted.y < 0.0),
        );
    }
    assert!(n_turned_back > 100, "{n_turned_back}");
}

/// Directional light on the front side of the facet.
fn sun_from(towards: DVec3) -> DeltaLight {
    let kind = DeltaLightKind::Directional { direction: -towards };
    DeltaLight::new(kind, Rgb::WHITE)
}

#[test]
fn where_a_normal_is_turned_shadow_rays_start_on_its_side() {
    // The shading normal faces away from the viewer, and from the light; the facet faces both, and so does the normal
    // that is perpendicular to the view, 70° from the light.
    let phong = Phong { diffuse: WHITE, ..Phong::BLACK };
    let (seen, world) = look(tilted(-100.0), tilted(-80.0), phong, vec![sun_from(tilted(60.0))]);
    assert!(world.shadow_rays[0].origin.y > 0.0, "{:?}", world.shadow_rays);
    assert!((seen.r - rt_math::transcendental::cos(70f64.to_radians())).abs() < 1e-12, "{seen:?}");
}

#[test]
fn shading_does_not_jump_where_an_interpolated_normal_turns_away() {
    let phong = Phong { diffuse: WHITE, ..Phong::BLACK };
    let lit = |tilt: f64| look(tilted(-100.0), tilted(tilt), phong, vec![sun_from(tilted(20.0))]).0.r;
    // Perpendicular to the view at −10°.
    let values: Vec<f64> = (0..3000).map(|i| lit(10.0 - f64::from(i) * 0.01)).collect();
    let steepest = values.windows(2).fold(0.0, |most: f64, pair| most.max((pair[0] - pair[1]).abs()));
    assert!(values[0] > values[2000] && steepest < 2e-4, "{steepest}");
}
