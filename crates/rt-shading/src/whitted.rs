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
mod tests;
