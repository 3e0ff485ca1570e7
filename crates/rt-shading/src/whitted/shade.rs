//! Shading of hits: local illumination and secondary rays.

use super::{Whitted, wave::TreePath};
use crate::{
    Appearance, Material, Phong, RadianceSample, SurfaceHit,
    hit_context::{HitContext, MAX_NULL_INTERFACES},
    interior_list::MediumInterface,
    medium, optics,
    viewed_surface::ViewedSurface,
};
use rt_math::{Interval, Ray, Rgb};

impl Whitted {
    /// Shades the hit of a path and spawns its secondary rays. At a null interface the path continues in the next wave.
    #[inline]
    pub(super) fn shade(
        &mut self,
        appearance: &Appearance,
        mut path: TreePath,
        ray: &Ray,
        hit: &mut SurfaceHit,
        seen: &mut RadianceSample,
    ) {
        let interior = &mut self.samples[path.sample as usize].interior;
        let Some(context) = HitContext::new(&self.features, &appearance.materials, ray, hit) else {
            seen.hit = true;
            return self.ended.push(path.sample);
        };
        let interface = context.interface(interior, &appearance.materials, hit.body());
        let interface = interface.as_ref();
        let way = (hit.t - path.start) * context.length;
        if !context.is_visible(interface) {
            return self.skip_interface(hit, ray, interface, way, path, seen);
        }
        seen.hit = true;
        if self.features.absorption {
            let interior = &self.samples[path.sample as usize].interior;
            let medium = interface.map_or_else(|| interior.medium(&appearance.materials), |c| c.before);
            self.absorb(&mut path.weight, medium.absorption, way);
        }
        let HitContext { material, direction, is_inside, .. } = context;
        let view = ViewedSurface::new(direction, is_inside, &mut hit.interaction);
        let phong = &material.to_phong();
        self.shade_direct(appearance, material, phong, &view, &path, ray.time);
        let interface = interface.filter(|_| phong.transmission.is_some());
        self.spawn_secondary_rays(appearance, phong, &view, interface, &path, ray.time);
    }

    /// Adds the background to the radiance of a path that hits nothing, and ends the path.
    #[inline(always)]
    pub(super) fn leave_scene(
        &mut self,
        appearance: &Appearance,
        path: &TreePath,
        ray: &Ray,
        seen: &mut RadianceSample,
    ) {
        seen.radiance += path.weight * appearance.background.radiance(ray.direction);
        self.ended.push(path.sample);
    }

    /// Continues the same ray behind a null interface.
    fn skip_interface(
        &mut self,
        hit: &SurfaceHit,
        ray: &Ray,
        interface: Option<&MediumInterface>,
        way: f64,
        mut path: TreePath,
        seen: &mut RadianceSample,
    ) {
        if let Some(interface) = interface {
            if interface.before.absorption != interface.after.absorption {
                seen.hit |= self.absorb(&mut path.weight, interface.before.absorption, way);
                path.start = hit.t;
            }
            self.samples[path.sample as usize].interior.cross(interface);
        } else {
            self.counts.interior_overflows += 1;
        }
        self.counts.passages += 1;
        path.passages += 1;
        path.depth += u32::from(path.passages > MAX_NULL_INTERFACES);
        if path.depth > self.max_depth {
            self.counts.depth_limited += 1;
            return self.ended.push(path.sample);
        }
        self.next.refracted.push(*ray, hit.span_after(ray), path);
    }

    /// Beer's law over a distance in world units; true if the medium absorbs.
    fn absorb(&mut self, weight: &mut Rgb, absorption: Rgb, way: f64) -> bool {
        let absorbs = medium::absorb(weight, absorption, way);
        self.counts.absorption += u64::from(absorbs);
        absorbs
    }

    /// Emission of a surface, and the direct light that it reflects.
    #[inline]
    fn shade_direct(
        &mut self,
        appearance: &Appearance,
        material: &Material,
        phong: &Phong,
        view: &ViewedSurface,
        path: &TreePath,
        time: f64,
    ) {
        let surface = view.surface;
        let textures = &appearance.textures;
        let mut radiance = Rgb::BLACK;
        if self.features.emission {
            radiance += material.emitted_radiance(textures, surface, view.is_inside);
        }
        if self.features.ambient {
            radiance += material.ambient(phong, textures, surface) * appearance.ambient;
        }
        let diffuse = phong.diffuse.at(textures, surface);
        let specular = if self.features.highlights { phong.specular.at(textures, surface) } else { Rgb::BLACK };
        let shadow_rays = surface.shadow_rays(view.is_inside);
        for (number, light) in appearance.lights.iter().enumerate() {
            let shadowed = self.features.shadows && light.casts_shadows;
            if light.is_behind(surface.point.into(), view.normal.into()) {
                self.counts.shadow_rays_skipped += u64::from(shadowed);
                continue;
            }
            let lit = light.sample_li(surface.point).filter(|lit| view.normal.dot(lit.direction) > 0.0);
            let reflected = lit.map_or(Rgb::BLACK, |lit| {
                let mut reflectance = diffuse * view.normal.dot(lit.direction);
                if self.features.highlights && !specular.is_black() {
                    self.counts.highlights += 1;
                    let strength =
                        phong.highlight.strength(view.normal, -view.direction, lit.direction, phong.exponent);
                    reflectance += specular * strength;
                }
                reflectance * lit.strength * light.units.classical_factor()
            });
            match lit {
                Some(lit) if !reflected.is_black() => {
                    if shadowed {
                        let (ray, span) = light.shadow_ray(&shadow_rays, &lit, time);
                        self.direct_lighting.push_shadowed(number, reflected, ray, span);
                    } else {
                        self.direct_lighting.push(reflected);
                    }
                }
                _ => self.counts.shadow_rays_skipped += u64::from(shadowed),
            }
        }
        self.direct_lighting.end_surface(path, radiance);
    }

    /// Spawns the mirrored and the refracted ray of a surface.
    #[inline]
    fn spawn_secondary_rays(
        &mut self,
        appearance: &Appearance,
        phong: &Phong,
        view: &ViewedSurface,
        interface: Option<&MediumInterface>,
        path: &TreePath,
        time: f64,
    ) {
        if path.depth >= self.max_depth {
            self.counts.depth_limited += u64::from(interface.is_some() || !phong.mirror.is_zero());
            return self.ended.push(path.sample);
        }
        let surface = view.surface;
        let textures = &appearance.textures;
        let bounced = |weight| TreePath { depth: path.depth + 1, passages: 0, start: 0.0, weight, ..*path };
        let mut reflected_part = 1.0;
        let mut refracted = None;
        if let (Some(interface), Some(transmission)) = (interface, &phong.transmission) {
            self.counts.refractions += 1;
            let eta = interface.before.ior / interface.after.ior;
            if self.features.fresnel && transmission.fresnel {
                self.counts.fresnel += 1;
                reflected_part =
                    if interface.is_null() { 0.0 } else { optics::fresnel(-view.direction.dot(view.normal), eta) };
            }
            let passed_part = if transmission.fresnel { 1.0 - reflected_part } else { 1.0 };
            let weight = path.weight * transmission.coefficient.at(textures, surface) * passed_part;
            if self.is_significant(weight) {
                let direction = if interface.is_null() { Some(view.direction) } else { view.refracted(eta) };
                refracted = direction.map(|direction| (interface, direction, bounced(weight)));
            }
        }
        let mirrored = self.features.reflection.then(|| {
            self.counts.mirrors += 1;
            path.weight * phong.mirror.at(textures, surface) * reflected_part
        });
        let mirrored = mirrored.filter(|weight| self.is_significant(*weight));
        let mirrored = mirrored.map(|weight| (surface.spawn_ray(view.mirrored(), time), bounced(weight)));
        let refracted =
            refracted.map(|(interface, direction, path)| (surface.spawn_ray(direction, time), path, interface));
        self.push_secondary_rays(path.sample, mirrored, refracted);
    }

    /// Continues with the mirrored ray and defers the refracted one. Without a mirrored ray it continues with the refracted one.
    #[inline(always)]
    fn push_secondary_rays(
        &mut self,
        sample: u32,
        mirrored: Option<(Ray, TreePath)>,
        refracted: Option<(Ray, TreePath, &MediumInterface)>,
    ) {
        let state = &mut self.samples[sample as usize];
        let ends = mirrored.is_none() && refracted.is_none();
        if let Some((ray, path, interface)) = refracted {
            if mirrored.is_some() {
                state.defer(ray, &path, interface.event);
            } else {
                state.interior.cross(interface);
                self.next.refracted.push(ray, Interval::SPAWNED, path);
            }
        }
        if let Some((ray, path)) = mirrored {
            self.next.reflected.push(ray, Interval::SPAWNED, path);
        }
        if ends {
            self.ended.push(sample);
        }
    }

    /// False for a weight that is invisible in the pixel.
    fn is_significant(&self, weight: Rgb) -> bool {
        !(weight.is_black() || weight.max_component() < self.min_contribution)
    }
}
