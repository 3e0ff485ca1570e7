//! Classical recursive ray tracing.

mod view;

use crate::{Appearance, Material, Needs, Phong, Seen, SurfaceHit, Tracer, optics};
use rt_math::{Ray, RayKind, Rgb, transcendental::exp};
use view::View;

/// Work of shading, for statistics and to prove that what is left out is really absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadingCounts {
    /// Shadow rays that were not traced, because the light could not contribute: it stands behind the surface, or the
    /// surface reflects none of it.
    pub shadow_rays_spared: u64,
    /// Highlights evaluated.
    pub highlights: u64,
    /// Mirror directions considered.
    pub mirrors: u64,
    /// Refractions considered.
    pub refractions: u64,
    /// Evaluations of Fresnel's equations.
    pub fresnel: u64,
    /// Evaluations of Beer's law.
    pub absorption: u64,
}

impl core::ops::AddAssign for ShadingCounts {
    fn add_assign(&mut self, o: Self) {
        self.shadow_rays_spared += o.shadow_rays_spared;
        self.highlights += o.highlights;
        self.mirrors += o.mirrors;
        self.refractions += o.refractions;
        self.fresnel += o.fresnel;
        self.absorption += o.absorption;
    }
}

/// A ray still to be followed.
#[derive(Clone, Copy, Debug)]
struct Pending {
    ray: Ray,
    kind: RayKind,
    /// Bounces so far.
    depth: u32,
    /// Part of its radiance that reaches the camera.
    weight: Rgb,
    /// Absorption per world unit of what it travels through.
    medium: Rgb,
}

/// Whitted's integrator (1980): local Phong shading with shadow rays, mirror reflection and refraction.
///
/// The tree of rays is walked with a stack of its own, so depth is limited by `max_depth` and not by the machine's
/// stack. Keep one instance per thread: the stack is reused from ray to ray.
#[derive(Clone, Debug)]
pub struct Whitted {
    max_depth: u32,
    min_contribution: f64,
    needs: Needs,
    pending: Vec<Pending>,
    counts: ShadingCounts,
}

impl Whitted {
    /// Follows up to `max_depth` bounces after the first hit, and none whose weight in the pixel is below
    /// `min_contribution` in all components. Computes only what `needs` names.
    pub fn new(max_depth: u32, min_contribution: f64, needs: Needs) -> Self {
        Self { max_depth, min_contribution, needs, pending: Vec::new(), counts: ShadingCounts::default() }
    }

    /// Work done so far.
    pub const fn counts(&self) -> ShadingCounts {
        self.counts
    }

    /// Radiance that a camera ray sees. Infinite or NaN if the scene is; the caller decides about such samples.
    pub fn radiance(&mut self, world: &mut impl Tracer, appearance: &Appearance, ray: &Ray) -> Seen {
        let mut seen = Seen { radiance: Rgb::BLACK, hit: false };
        let first = Pending { ray: *ray, kind: RayKind::Primary, depth: 0, weight: Rgb::WHITE, medium: Rgb::BLACK };
        let mut next = Some(first);
        while let Some(path) = next {
            match world.closest(&path.ray, path.kind, self.needs.surface()) {
                None => seen.radiance += path.weight * appearance.background.radiance(path.ray.direction),
                Some(hit) => {
                    seen.hit |= path.depth == 0;
                    seen.radiance += self.shade(world, appearance, &path, &hit);
                }
            }
            next = self.pending.pop();
        }
        seen
    }

    /// Light that leaves the hit point by itself, weighted; puts the rays that it depends on aside.
    fn shade(&mut self, world: &mut impl Tracer, appearance: &Appearance, path: &Pending, hit: &SurfaceHit) -> Rgb {
        let Some(Material { phong, .. }) = appearance.materials.get(hit.material as usize) else {
            return Rgb::BLACK;
        };
        let length = path.ray.direction.length();
        let view = View::new(path.ray.direction / length, &hit.interaction);
        // A body knows of itself what it is filled with; for what stands inside it, the ray remembers.
        let medium = match phong.transmission {
            Some(transmission) if view.inside => transmission.absorption,
            _ => path.medium,
        };
        let mut weight = path.weight;
        if self.needs.absorption && !medium.is_black() {
            self.counts.absorption += 1;
            // Beer's law.
            let distance = hit.t * length;
            weight *= medium.map(|per_unit| exp(-per_unit * distance));
        }
        let local = self.emitted_and_reflected(world, appearance, phong, &view, path.ray.time);
        if path.depth < self.max_depth {
            self.follow(appearance, phong, &view, &Pending { weight, medium, ..*path });
        }
        weight * local
    }

    fn emitted_and_reflected(
        &mut self,
        world: &mut impl Tracer,
        appearance: &Appearance,
        phong: &Phong,
        view: &View,
        time: f64,
    ) -> Rgb {
        let surface = &view.surface;
        let textures = &appearance.textures;
        let mut sum = Rgb::BLACK;
        if self.needs.emission {
            sum += phong.emission.at(textures, surface.uv);
        }
        if self.needs.ambient {
            sum += phong.ambient.at(textures, surface.uv) * appearance.ambient;
        }
        let diffuse = phong.diffuse.at(textures, surface.uv);
        let specular = if self.needs.highlights { phong.specular.at(textures, surface.uv) } else { Rgb::BLACK };
        for light in &appearance.lights {
            let lit = light.illuminate(surface.point).filter(|lit| view.normal.dot(lit.direction) > 0.0);
            let reflected = lit.map_or(Rgb::BLACK, |lit| {
                let mut reflectance = diffuse * view.normal.dot(lit.direction);
                if self.needs.highlights && !specular.is_black() {
                    self.counts.highlights += 1;
                    let strength =
                        phong.highlight.strength(view.normal, -view.direction, lit.direction, phong.exponent);
                    reflectance += specular * strength;
                }
                reflectance * lit.strength
            });
            let shadowed = self.needs.shadows && light.casts_shadows;
            match lit {
                Some(lit) if !reflected.is_black() => {
                    let (ray, span) = light.shadow_ray(surface, &lit, time);
                    if !(shadowed && world.occluded(&ray, span)) {
                        sum += reflected;
                    }
                }
                _ => self.counts.shadow_rays_spared += u64::from(shadowed),
            }
        }
        sum
    }

    /// Puts the mirrored and the refracted ray aside, the mirrored one on top.
    fn follow(&mut self, appearance: &Appearance, phong: &Phong, view: &View, path: &Pending) {
        let surface = &view.surface;
        let mut reflected_part = 1.0;
        if self.needs.refraction
            && let Some(transmission) = &phong.transmission
        {
            self.counts.refractions += 1;
            let eta = if view.inside { transmission.ior } else { 1.0 / transmission.ior };
            if self.needs.fresnel && transmission.fresnel {
                self.counts.fresnel += 1;
                reflected_part = optics::fresnel(-view.direction.dot(view.normal), eta);
            }
            let passed_part = if transmission.fresnel { 1.0 - reflected_part } else { 1.0 };
            let weight = path.weight * transmission.coefficient.at(&appearance.textures, surface.uv) * passed_part;
            // Whatever lies outside of a body is taken to be clear.
            let medium = if view.inside { Rgb::BLACK } else { transmission.absorption };
            if let Some(direction) = view.refracted(eta) {
                let ray = || surface.spawn_ray(direction, path.ray.time);
                self.put_aside(&Pending { weight, medium, ..*path }, RayKind::Refraction, ray);
            }
        }
        if self.needs.reflection {
            self.counts.mirrors += 1;
            let weight = path.weight * phong.mirror.at(&appearance.textures, surface.uv) * reflected_part;
            let ray = || surface.spawn_ray(view.mirrored(), path.ray.time);
            self.put_aside(&Pending { weight, ..*path }, RayKind::Reflection, ray);
        }
    }

    /// Puts aside what goes on from `path` along `ray`, if its weight matters.
    fn put_aside(&mut self, path: &Pending, kind: RayKind, ray: impl FnOnce() -> Ray) {
        if !path.weight.is_black() && !(path.weight.max_component() < self.min_contribution) {
            self.pending.push(Pending { ray: ray(), kind, depth: path.depth + 1, ..*path });
        }
    }
}

#[cfg(test)]
mod interpolated;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Background, Coefficient, Falloff, Light, LightKind, Transmission};
    use rt_geometry::{SurfaceInteraction, SurfaceNeeds};
    use rt_math::{DVec3, Interval};

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

    impl Tracer for Echo {
        fn closest(&mut self, ray: &Ray, kind: RayKind, _: SurfaceNeeds) -> Option<SurfaceHit> {
            self.traced.push(kind);
            if self.traced.len() as u32 > self.bounces {
                return None;
            }
            let against = -ray.direction.normalize();
            let normal = if kind == RayKind::Refraction { -against } else { against };
            let point = ray.at(2.0 / ray.direction.length());
            let interaction = SurfaceInteraction {
                point,
                point_error: DVec3::ZERO,
                shadow_point: point,
                geometric_normal: normal,
                shading_normal: normal,
                uv: [0.0; 2],
            };
            Some(SurfaceHit { t: 2.0 / ray.direction.length(), interaction, material: 0 })
        }

        fn occluded(&mut self, _: &Ray, _: Interval) -> bool {
            self.shadow_rays += 1;
            self.shadowed
        }
    }

    const BARE: Phong = Phong {
        ambient: Coefficient::ZERO,
        diffuse: Coefficient::ZERO,
        specular: Coefficient::ZERO,
        exponent: 1.0,
        highlight: crate::Highlight::Phong,
        emission: Coefficient::ZERO,
        mirror: Coefficient::ZERO,
        transmission: None,
    };

    fn gray(value: f64) -> Coefficient {
        Coefficient::Constant(Rgb::gray(value))
    }

    fn white_room(phong: Phong) -> Appearance {
        Appearance {
            materials: vec![Material { name: "only".into(), phong }],
            background: Background::Constant(Rgb::WHITE),
            ..Appearance::default()
        }
    }

    fn look(world: &mut Echo, appearance: &Appearance, depth: u32) -> (f64, ShadingCounts) {
        let needs = Needs::of(appearance, |_| true);
        let mut whitted = Whitted::new(depth, 0.0, needs);
        let ray = Ray::new(DVec3::ZERO, DVec3::new(0.0, 0.0, -3.0));
        let trimmed = whitted.radiance(world, appearance, &ray).radiance;
        let mut again = Echo { traced: vec![], shadow_rays: 0, ..*world };
        let full = Whitted::new(depth, 0.0, Needs::ALL).radiance(&mut again, appearance, &ray).radiance;
        assert_eq!(trimmed, full, "trimmed and full shading must agree to the bit");
        (trimmed.r, whitted.counts())
    }

    #[test]
    fn a_thousand_mirrors_multiply_exactly_that_often() {
        let mirrors = white_room(Phong { mirror: gray(0.999), ..BARE });
        let (seen, _) = look(&mut Echo::new(1000), &mirrors, 1000);
        assert!((seen - 0.367_695_424_8).abs() < 1e-10, "{seen}");
        let (cut, _) = look(&mut Echo::new(1000), &mirrors, 999);
        assert_eq!(cut, 0.0, "one bounce short of the light");
    }

    #[test]
    fn depth_counts_bounces_after_the_first_hit() {
        let glowing_mirror = white_room(Phong { mirror: gray(0.5), emission: gray(1.0), ..BARE });
        for (depth, expected) in [(0, 1.0), (1, 1.5), (2, 1.75), (5, 1.96875)] {
            let (seen, _) = look(&mut Echo::new(u32::MAX), &glowing_mirror, depth);
            assert_eq!(seen, expected, "depth {depth}");
        }
    }

    #[test]
    fn faint_rays_are_not_followed() {
        let appearance = white_room(Phong { mirror: gray(0.5), emission: gray(1.0), ..BARE });
        let mut world = Echo::new(u32::MAX);
        let mut whitted = Whitted::new(1000, 0.1, Needs::ALL);
        let seen = whitted.radiance(&mut world, &appearance, &Ray::new(DVec3::ZERO, DVec3::NEG_Z));
        assert_eq!(seen.radiance.r, 1.875);
        assert_eq!(world.traced.len(), 4);
    }

    #[test]
    fn light_through_glass_is_split_by_fresnel_and_dimmed_inside() {
        let glass = Transmission { coefficient: gray(1.0), ior: 1.5, fresnel: true, absorption: Rgb::gray(0.25) };
        let appearance = white_room(Phong { mirror: gray(1.0), transmission: Some(glass), ..BARE });
        // In, and out again after 2 units: depth 2 leaves out all but reflection, and transmission twice.
        let (seen, counts) = look(&mut Echo::new(1), &appearance, 1);
        assert!((seen - 1.0).abs() < 1e-14, "reflected and refracted parts add up: {seen}");
        assert_eq!(counts.fresnel, 1);
        let mut world = Echo::new(2);
        let (seen, counts) = look(&mut world, &appearance, 2);
        // The mirrored ray of the first hit is traced first and uses up the second bounce of this world.
        assert_eq!(world.traced[..2], [RayKind::Primary, RayKind::Reflection]);
        assert_eq!(counts.absorption, 0, "nothing was seen from inside");
        assert!((seen - 1.0).abs() < 1e-14);
    }

    #[test]
    fn absorption_follows_beers_law() {
        let tinted =
            Transmission { coefficient: gray(1.0), ior: 1.0, fresnel: false, absorption: Rgb::new(0.5, 0.0, 1.0) };
        let appearance = white_room(Phong { transmission: Some(tinted), ..BARE });
        let mut whitted = Whitted::new(2, 0.0, Needs::of(&appearance, |_| true));
        let ray = Ray::new(DVec3::ZERO, DVec3::NEG_Z);
        let seen = whitted.radiance(&mut Echo::new(2), &appearance, &ray).radiance;
        let expected = Rgb::new(exp(-1.0), 1.0, exp(-2.0));
        assert!((seen - expected).map(f64::abs).max_component() < 1e-14, "{seen:?}");
    }

    #[test]
    fn what_stands_inside_glass_is_seen_through_it() {
        // Into tinted glass, 2 units to an opaque glowing body in it, which is met from its outside.
        let tinted =
            Transmission { coefficient: gray(1.0), ior: 1.0, fresnel: false, absorption: Rgb::new(0.5, 0.0, 1.0) };
        let mut appearance = white_room(Phong { transmission: Some(tinted), ..BARE });
        let core = Phong { emission: gray(1.0), mirror: gray(1.0), ..BARE };
        appearance.materials.push(Material { name: "core".into(), phong: core });
        struct Paperweight(u32);
        impl Tracer for Paperweight {
            fn closest(&mut self, ray: &Ray, _: RayKind, _: SurfaceNeeds) -> Option<SurfaceHit> {
                self.0 += 1;
                // The glass, the core, and the glass again from inside.
                let (normal, material) = match self.0 {
                    1 => (-ray.direction, 0),
                    2 => (-ray.direction, 1),
                    3 => (ray.direction, 0),
                    _ => return None,
                };
                let point = ray.at(2.0);
                let interaction = SurfaceInteraction {
                    point,
                    point_error: DVec3::ZERO,
                    shadow_point: point,
                    geometric_normal: normal,
                    shading_normal: normal,
                    uv: [0.0; 2],
                };
                Some(SurfaceHit { t: 2.0, interaction, material })
            }
            fn occluded(&mut self, _: &Ray, _: Interval) -> bool {
                false
            }
        }
        let mut whitted = Whitted::new(9, 0.0, Needs::of(&appearance, |_| true));
        let seen = whitted.radiance(&mut Paperweight(0), &appearance, &Ray::new(DVec3::ZERO, DVec3::NEG_Z)).radiance;
        // The core's own light goes 2 units through the glass, the mirrored room's goes 4.
        let expected = Rgb::new(exp(-1.0) + exp(-2.0), 2.0, exp(-2.0) + exp(-4.0));
        assert!((seen - expected).map(f64::abs).max_component() < 1e-14, "{seen:?}");
    }

    #[test]
    fn totally_reflected_light_is_dropped_when_mixed_by_constants() {
        // A ray that grazes a denser outside: the shading normal is tilted, so that Snell has no solution.
        let thin = Transmission { coefficient: gray(0.85), ior: 0.2, fresnel: false, absorption: Rgb::BLACK };
        let appearance = white_room(Phong { transmission: Some(thin), mirror: gray(0.2), ..BARE });
        struct Tilted(u32);
        impl Tracer for Tilted {
            fn closest(&mut self, _: &Ray, _: RayKind, _: SurfaceNeeds) -> Option<SurfaceHit> {
                self.0 += 1;
                let normal = DVec3::new(0.8, 0.0, 0.6);
                let interaction = SurfaceInteraction {
                    point: DVec3::ZERO,
                    point_error: DVec3::ZERO,
                    shadow_point: DVec3::ZERO,
                    geometric_normal: normal,
                    shading_normal: normal,
                    uv: [0.0; 2],
                };
                (self.0 == 1).then_some(SurfaceHit { t: 1.0, interaction, material: 0 })
            }
            fn occluded(&mut self, _: &Ray, _: Interval) -> bool {
                false
            }
        }
        let mut whitted = Whitted::new(3, 0.0, Needs::of(&appearance, |_| true));
        let seen = whitted.radiance(&mut Tilted(0), &appearance, &Ray::new(DVec3::Z, DVec3::NEG_Z));
        assert_eq!(seen.radiance, Rgb::gray(0.2), "the mirrored part alone");
    }

    #[test]
    fn local_light_is_phongs_sum() {
        let light = |casts_shadows| Light {
            name: String::new(),
            kind: LightKind::Point { position: DVec3::ZERO, falloff: Falloff::None, lamp_radius: 0.0 },
            intensity: Rgb::gray(2.0),
            casts_shadows,
        };
        let phong = Phong {
            ambient: gray(0.1),
            diffuse: gray(0.5),
            specular: gray(0.25),
            exponent: 3.0,
            emission: gray(0.01),
            ..BARE
        };
        let mut appearance = white_room(phong);
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
        let kind = LightKind::Point { position: DVec3::Z * -9.0, falloff: Falloff::None, lamp_radius: 0.0 };
        let mut appearance = white_room(Phong { diffuse: gray(1.0), ..BARE });
        appearance.lights = vec![Light { name: String::new(), kind, intensity: Rgb::WHITE, casts_shadows: true }];
        let mut world = Echo::new(1);
        let (seen, counts) = look(&mut world, &appearance, 0);
        assert_eq!((seen, world.shadow_rays, counts.shadow_rays_spared), (0.0, 0, 1));
    }

    #[test]
    fn unknown_materials_are_black() {
        let mut appearance = white_room(BARE);
        appearance.materials.clear();
        assert_eq!(look(&mut Echo::new(1), &appearance, 3).0, 0.0);
    }
}
