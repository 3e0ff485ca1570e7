//! Shading of hits one by one: local illumination and secondary rays.

use super::{inputs::RayTreeInputs, ray_tree_path::RayTreePath, wave::SpawnedRays};
use crate::{
    InteriorList, Material, Phong, RadianceSample, SurfaceHit, hit_context::HitContext, interior_list::MediumInterface,
    lane_set::Element, medium::transmittance_to_light, medium_tracker::RayMedia, optics, viewed_surface::ViewedSurface,
};
use rt_math::{Interval, Ray, Rgb};

impl<E: Element> SpawnedRays<E> {
    /// Shades the hit of a path and spawns its secondary rays. At a null interface the path continues in the next wave.
    pub(super) fn shade_hit(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        mut path: RayTreePath,
        ray: &Ray,
        hit: &mut SurfaceHit,
        radiance_sample: &mut RadianceSample,
    ) {
        let (features, materials) = (&inputs.settings.features, &inputs.appearance.materials);
        let Some(context) = HitContext::new(features, materials, ray, hit) else {
            radiance_sample.hit = true;
            return;
        };
        self.media.resume(&self.lists, path.media);
        let interface = context.interface(&mut self.media.interior, materials, hit.medium_entry());
        let interface = interface.as_ref();
        if !context.is_visible(interface) {
            return self.skip_interface(inputs, (ray, path), hit, (interface, context.length), radiance_sample);
        }
        radiance_sample.hit = true;
        let mut absorption = Rgb::BLACK;
        if features.absorption {
            absorption = self.media.absorb(materials, interface, hit.t, context.length, &mut path.throughput);
            self.counts.absorption += u64::from(!absorption.is_black());
        }
        let HitContext { material, direction, is_inside, .. } = context;
        let view = ViewedSurface::new(direction, is_inside, &mut hit.interaction);
        let phong = &material.to_phong();
        let mut interior = None;
        if inputs.phongs.has_shadow_media {
            interior = interface.map(|_| self.media.interior.clone());
            absorption = Rgb::BLACK;
        }
        let near = (absorption, interior.as_ref());
        self.shade_direct(inputs, (material, phong), (&view, near), (&path, ray.time), radiance_sample);
        let interface = interface.filter(|_| phong.transmission.is_some());
        self.spawn_secondary_rays(inputs, phong, (&view, interface), (&path, ray.time));
    }

    /// Continues the ray of a path in [`media`](Self::media) behind a null interface. `length` is world units per unit of the ray parameter.
    pub(super) fn skip_interface(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        (ray, mut path): (&Ray, RayTreePath),
        hit: &SurfaceHit,
        (interface, length): (Option<&MediumInterface>, f64),
        radiance_sample: &mut RadianceSample,
    ) {
        let media = &mut self.media;
        let is_dimmed = media.skip_interface(interface, hit, length, &mut path.throughput, &mut self.counts);
        self.counts.absorption += u64::from(is_dimmed);
        radiance_sample.hit |= is_dimmed;
        path.depth += u32::from(media.null_limit_exceeded());
        if path.depth > inputs.settings.max_depth {
            self.counts.depth_limited += 1;
            return;
        }
        path.media = self.media.suspend(&mut self.lists);
        self.refracted.push(ray, hit.span_after(ray), &path);
    }

    /// Emission of a surface, and the direct light that it reflects. The medium before it absorbs on the whole way, or shadow rays start
    /// in these media.
    fn shade_direct(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        (material, phong): (&Material, &Phong),
        (view, (absorption, interior)): (&ViewedSurface<'_>, (Rgb, Option<&InteriorList>)),
        (path, time): (&RayTreePath, f64),
        radiance_sample: &mut RadianceSample,
    ) {
        let &RayTreeInputs { appearance, settings, .. } = inputs;
        let (features, surface, textures) = (&settings.features, view.surface, &appearance.textures);
        let mut radiance = Rgb::BLACK;
        if features.emission {
            radiance += material.emitted_radiance(textures, surface, view.is_inside);
        }
        if features.ambient {
            radiance += material.ambient(phong, textures, surface) * appearance.ambient;
        }
        radiance_sample.radiance += path.throughput * radiance;
        let diffuse = phong.diffuse.at(textures, surface);
        let specular = if features.highlights { phong.specular.at(textures, surface) } else { Rgb::BLACK };
        let shadow_rays = surface.shadow_rays(view.is_inside);
        for (stream, lights) in
            self.lights.streams.iter_mut().zip(appearance.lights.chunks(self.lights.lights_per_stream))
        {
            for light in lights {
                let shadowed = features.shadows && light.casts_shadows;
                if light.is_behind(surface.point.into(), view.normal.into()) {
                    self.counts.shadow_rays_skipped += u64::from(shadowed);
                    continue;
                }
                let lit = light.sample_li(surface.point).filter(|lit| view.normal.dot(lit.direction) > 0.0);
                let reflected = lit.map_or(Rgb::BLACK, |lit| {
                    let mut reflectance = diffuse * view.normal.dot(lit.direction);
                    if features.highlights && !specular.is_black() {
                        self.counts.highlights += 1;
                        let strength =
                            phong.highlight.strength(view.normal, -view.direction, lit.direction, phong.exponent);
                        reflectance += specular * strength;
                    }
                    reflectance * lit.strength * light.units.classical_factor()
                });
                match lit {
                    Some(lit) if !reflected.is_black() => {
                        let radiance = path.throughput * reflected;
                        if shadowed {
                            let radiance = radiance * transmittance_to_light(absorption, lit.distance);
                            stream.push_ray(light.shadow_ray(&shadow_rays, &lit, time), path.branch, radiance);
                            if let Some(interior) = interior {
                                stream.start_in(interior.clone());
                            }
                        } else {
                            radiance_sample.radiance += radiance;
                        }
                    }
                    _ => self.counts.shadow_rays_skipped += u64::from(shadowed),
                }
            }
        }
    }

    /// Spawns the mirrored and the refracted ray of a surface with media on both sides.
    fn spawn_secondary_rays(
        &mut self,
        inputs: &RayTreeInputs<'_>,
        phong: &Phong,
        (view, interface): (&ViewedSurface<'_>, Option<&MediumInterface>),
        (path, time): (&RayTreePath, f64),
    ) {
        let features = &inputs.settings.features;
        if path.depth >= inputs.settings.max_depth {
            self.counts.depth_limited += u64::from(interface.is_some() || !phong.mirror.is_zero());
            return;
        }
        let surface = view.surface;
        let textures = &inputs.appearance.textures;
        let bounced = |throughput| RayTreePath { depth: path.depth + 1, throughput, ..*path };
        let mut reflected_part = 1.0;
        let mut refracted = None;
        if let (Some(interface), Some(transmission)) = (interface, &phong.transmission) {
            self.counts.refractions += 1;
            let eta = interface.before.ior / interface.after.ior;
            if features.fresnel && transmission.fresnel {
                self.counts.fresnel += 1;
                reflected_part =
                    if interface.is_null() { 0.0 } else { optics::fresnel(-view.direction.dot(view.normal), eta) };
            }
            let transmitted_part = if transmission.fresnel { 1.0 - reflected_part } else { 1.0 };
            let throughput = path.throughput * transmission.coefficient.at(textures, surface) * transmitted_part;
            if inputs.is_significant(throughput) {
                let direction = if interface.is_null() { Some(view.direction) } else { view.refracted(eta) };
                refracted = direction.map(|direction| (interface, direction, bounced(throughput)));
            }
        }
        let mirrored = features.reflection.then(|| {
            self.counts.mirrors += 1;
            path.throughput * phong.mirror.at(textures, surface) * reflected_part
        });
        let mirrored = mirrored.filter(|throughput| inputs.is_significant(*throughput));
        let mirrored = mirrored.map(|throughput| (surface.spawn_ray(view.mirrored(), time), bounced(throughput)));
        let refracted =
            refracted.map(|(interface, direction, path)| (surface.spawn_ray(direction, time), path, interface));
        // Of two rays, the refracted one starts a branch.
        let interior = &self.media.interior;
        let before = self.lists.push_changed(interior, path.media.interior);
        if let Some((ray, mut path, interface)) = refracted {
            path.media = RayMedia::new(self.lists.push_behind(interior, interface.event));
            if mirrored.is_some() {
                path.branch = self.start_branch(path.branch);
            }
            self.refracted.push(&ray, Interval::SPAWNED, &path);
        }
        if let Some((ray, mut path)) = mirrored {
            path.media = RayMedia::new(before);
            self.reflected.push(&ray, Interval::SPAWNED, &path);
        }
    }
}
