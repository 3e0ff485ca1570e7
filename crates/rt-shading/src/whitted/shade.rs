//! What happens where a ray meets a surface.

use super::{Whitted, wave::Path};
use crate::{
    Appearance, Material, Phong, Seen, SurfaceHit,
    interior::Crossing,
    meeting::{FREE_PASSAGES, Meeting},
    optics,
    view::View,
};
use rt_math::{Interval, Ray, Rgb, transcendental::exp};

impl Whitted {
    /// Ends a path at the first surface that shows: notes the light there, and the rays that it depends on. At a surface
    /// that does not show it goes on in the next wave.
    #[inline]
    pub(super) fn shade(
        &mut self,
        appearance: &Appearance,
        mut path: Path,
        ray: &Ray,
        hit: Option<&mut SurfaceHit>,
        seen: &mut Seen,
    ) {
        let Some(hit) = hit else {
            seen.radiance += path.weight * appearance.background.radiance(ray.direction);
            return self.ended.push(path.sample);
        };
        let interior = &mut self.samples[path.sample as usize].interior;
        let Some(meeting) = Meeting::new(&self.needs, &appearance.materials, ray, hit) else {
            seen.hit = true;
            return self.ended.push(path.sample);
        };
        let crossing = meeting.crossing(interior, &appearance.materials, hit);
        let crossing = crossing.as_ref();
        let way = (hit.t - path.start) * meeting.length;
        if !meeting.is_noticed(crossing) {
            return self.pass(hit, ray, crossing, way, path, seen);
        }
        seen.hit = true;
        if self.needs.absorption {
            let interior = &self.samples[path.sample as usize].interior;
            let medium = crossing.map_or_else(|| interior.medium(&appearance.materials), |c| c.before);
            self.absorb(&mut path.weight, medium.absorption, way);
        }
        let Meeting { material, direction, is_inside, .. } = meeting;
        let view = View::new(direction, is_inside, &mut hit.interaction);
        self.light(appearance, material, &view, &path, ray.time);
        self.send_on(appearance, &material.phong, &view, crossing, &path, ray.time);
    }

    /// Goes on along the same ray, through a surface that does nothing to it.
    fn pass(
        &mut self,
        hit: &SurfaceHit,
        ray: &Ray,
        crossing: Option<&Crossing>,
        way: f64,
        mut path: Path,
        seen: &mut Seen,
    ) {
        if let Some(crossing) = crossing {
            if crossing.before.absorption != crossing.after.absorption {
                seen.hit |= self.absorb(&mut path.weight, crossing.before.absorption, way);
                path.start = hit.t;
            }
            self.samples[path.sample as usize].interior.cross(crossing);
        } else {
            self.counts.interior_overflows += 1;
        }
        self.counts.passages += 1;
        path.passages += 1;
        path.depth += u32::from(path.passages > FREE_PASSAGES);
        if path.depth > self.max_depth {
            self.counts.depth_limited += 1;
            return self.ended.push(path.sample);
        }
        self.next.refracted.push(*ray, hit.beyond(ray), path);
    }

    /// Beer's law along a way in world units; whether it took anything.
    fn absorb(&mut self, weight: &mut Rgb, absorption: Rgb, way: f64) -> bool {
        if absorption.is_black() {
            return false;
        }
        self.counts.absorption += 1;
        *weight *= absorption.map(|per_unit| exp(-per_unit * way));
        true
    }

    /// The surface's own light, and what it reflects of each lamp.
    #[inline]
    fn light(&mut self, appearance: &Appearance, material: &Material, view: &View, path: &Path, time: f64) {
        let phong = &material.phong;
        let surface = view.surface;
        let textures = &appearance.textures;
        let mut radiance = Rgb::BLACK;
        if self.needs.emission {
            radiance += material.emission(textures, surface, view.is_inside);
        }
        if self.needs.ambient {
            radiance += material.ambient(textures, surface) * appearance.ambient;
        }
        let diffuse = phong.diffuse.at(textures, surface);
        let specular = if self.needs.highlights { phong.specular.at(textures, surface) } else { Rgb::BLACK };
        let shadow_rays = surface.shadow_rays(view.is_inside);
        for (number, light) in appearance.lights.iter().enumerate() {
            let shadowed = self.needs.shadows && light.casts_shadows;
            if light.is_behind(surface.point, view.normal) {
                self.counts.shadow_rays_spared += u64::from(shadowed);
                continue;
            }
            let lit = light.illuminate(surface.point).filter(|lit| view.normal.dot(lit.direction) > 0.0);
            let reflected = lit.map_or(Rgb::BLACK, |lit| {
                let mut reflectance = diffuse * view.normal.dot(lit.direction);
                if self.needs.highlights && !specular.is_black() {
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
                        self.lights.push_shadowed(number, reflected, ray, span);
                    } else {
                        self.lights.push(reflected);
                    }
                }
                _ => self.counts.shadow_rays_spared += u64::from(shadowed),
            }
        }
        self.lights.end_surface(path, radiance);
    }

    /// Goes on with the mirrored ray, and has the refracted one wait for it; with the refracted one where nothing is
    /// mirrored.
    #[inline]
    fn send_on(
        &mut self,
        appearance: &Appearance,
        phong: &Phong,
        view: &View,
        crossing: Option<&Crossing>,
        path: &Path,
        time: f64,
    ) {
        if path.depth >= self.max_depth {
            self.counts.depth_limited += u64::from(crossing.is_some() || !phong.mirror.is_zero());
            return self.ended.push(path.sample);
        }
        let surface = view.surface;
        let textures = &appearance.textures;
        let bounced = |weight| Path { depth: path.depth + 1, passages: 0, start: 0.0, weight, ..*path };
        let mut reflected_part = 1.0;
        let mut refracted = None;
        if let (Some(crossing), Some(transmission)) = (crossing, &phong.transmission) {
            self.counts.refractions += 1;
            let eta = crossing.before.ior / crossing.after.ior;
            if self.needs.fresnel && transmission.fresnel {
                self.counts.fresnel += 1;
                reflected_part =
                    if crossing.is_null() { 0.0 } else { optics::fresnel(-view.direction.dot(view.normal), eta) };
            }
            let passed_part = if transmission.fresnel { 1.0 - reflected_part } else { 1.0 };
            let weight = path.weight * transmission.coefficient.at(textures, surface) * passed_part;
            if self.matters(weight) {
                let direction = if crossing.is_null() { Some(view.direction) } else { view.refracted(eta) };
                refracted = direction.map(|direction| (crossing, direction, bounced(weight)));
            }
        }
        let mirrored = self.needs.reflection.then(|| {
            self.counts.mirrors += 1;
            path.weight * phong.mirror.at(textures, surface) * reflected_part
        });
        let mirrored = mirrored.filter(|weight| self.matters(*weight));
        let sample = &mut self.samples[path.sample as usize];
        if let Some((crossing, direction, beyond)) = refracted {
            let ray = surface.spawn_ray(direction, time);
            if mirrored.is_some() {
                sample.wait(ray, &beyond, crossing);
            } else {
                sample.interior.cross(crossing);
                self.next.refracted.push(ray, Interval::SPAWNED, beyond);
            }
        }
        match mirrored {
            Some(weight) => {
                let ray = surface.spawn_ray(view.mirrored(), time);
                self.next.reflected.push(ray, Interval::SPAWNED, bounced(weight));
            }
            None if refracted.is_none() => self.ended.push(path.sample),
            None => {}
        }
    }

    /// False for what cannot be seen in the pixel.
    fn matters(&self, weight: Rgb) -> bool {
        !(weight.is_black() || weight.max_component() < self.min_contribution)
    }
}
