//! Shading of a wave in lanes: emission, direct light, and secondary rays.

use super::{Shade, Spawned, Wave, streams::TreeStream};
use crate::{
    Background, RadianceSample, SurfaceHit,
    hit_context::{MAX_NULL_INTERFACES, SurfaceTransmission},
    interior_list::{MediumEntry, MediumInterface},
    lane_set::{Element, LaneSet},
    lanes::{each_lane, first_lanes, is_zero},
    medium::absorb,
    optics,
    stream_queries::{StreamPrimitive, StreamQueries},
    wavefront::{
        delta_lights::{sample_li, shadow_rays},
        hit_points::HitPoints,
        shaded_surface::{ShadedSurface, offset},
        streams::{add_radiance, append},
    },
    whitted::{
        hit_block::is_significant,
        lane_phong::UniformPhong,
        wave::{RayTree, TreePath},
    },
};
use rt_geometry::{HitStream, SurfaceInteraction};
use rt_math::{Interval, Ray, Real, Rgb, Vector3};

/// Hits of some lanes on one primitive with one Phong model.
struct Group<'a, L: LaneSet> {
    phong: &'a UniformPhong,
    primitive: &'a StreamPrimitive<'a>,
    points: &'a HitPoints<L>,
    /// Index of the first ray.
    at: usize,
    /// Lanes that hit, and whose surface is visible.
    mask: u8,
    /// Weights of the radiance in the pixel, after absorption.
    weight: Vector3<L::F>,
    /// Lanes whose surface transmits light.
    transmits: u8,
    /// Index of refraction before the surface divided by that behind it; 1 where no light is transmitted.
    eta: L::F,
}

impl<E: Element> Spawned<E> {
    /// Shades the closest hits of a stream.
    #[inline(always)]
    pub(super) fn shade<W: StreamQueries, L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        world: &W,
        (paths, hits): Wave<'_, E>,
        seen: &mut [RadianceSample],
    ) {
        let &Shade { lanes, settings, .. } = shade;
        for at in (0..paths.len()).step_by(L::N) {
            let used = first_lanes((paths.len() - at).min(L::N));
            let [instances, indices] = [hits.instance.vector(at), hits.primitive.vector(at)];
            let missed = lanes.equal(indices, HitStream::NONE) & used;
            if missed != 0 {
                self.leave_scene(shade, missed, (paths, at), seen);
            }
            let mut rest = used & !missed;
            while let Some(first) = each_lane(rest).next() {
                let index = indices[first];
                let mask = lanes.equal(indices, index) & lanes.equal(instances, instances[first]) & rest;
                rest &= !mask;
                let Some(primitive) = &world.primitive(hits, at + first) else { continue };
                let points = &HitPoints::new(lanes, &primitive.shape, &paths.rays, hits, at);
                let Some(Some(model)) = settings.phongs.get(primitive.material as usize) else {
                    self.end_without_material(mask, (paths, at), seen);
                    continue;
                };
                let mut odd = 0;
                if model.is_checkered() {
                    let vertex_uvs = || world.vertex_uvs(hits, at + first);
                    odd = mask & points.odd_squares(lanes, (&primitive.shape, vertex_uvs), (hits, at), model.side);
                }
                for (mask, square) in [(mask & !odd, 0), (odd, 1)] {
                    if mask != 0 {
                        let phong = model.square(square);
                        let (weight, eta) = (lanes.load_vector(&paths.weight, at), lanes.splat(1.0));
                        let group = Group { phong, primitive, points, at, mask, weight, transmits: 0, eta };
                        self.shade_group(shade, group, paths, seen);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn shade_group<L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        mut group: Group<'_, L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        let &Shade { lanes, settings, .. } = shade;
        let surface = ShadedSurface::new(lanes, group.points, group.mask);
        if settings.features.refraction {
            self.find_interfaces(shade, &mut group, &surface, paths, seen);
            if group.mask == 0 {
                return;
            }
        }
        self.counts.lanes += L::N as u64;
        self.counts.lanes_used += u64::from(group.mask.count_ones());
        self.add_emission(lanes, &group, &surface, paths, seen);
        self.sample_lights(shade, &group, &surface, paths, seen);
        self.spawn_rays(shade, &group, &surface, paths);
    }

    /// Adds the background to the samples of paths that hit nothing, and ends the paths.
    #[inline(always)]
    fn leave_scene<L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        missed: u8,
        (paths, at): (&TreeStream<E>, usize),
        seen: &mut [RadianceSample],
    ) {
        let &Shade { lanes, appearance, .. } = shade;
        if let Background::Constant(radiance) = appearance.background {
            let radiance = lanes.splat_rgb(radiance).scaled_by(lanes.load_vector(&paths.weight, at));
            add_radiance(lanes, missed, radiance, false, paths.sample.vector(at), seen);
        } else {
            for lane in each_lane(missed) {
                let (ray, _) = paths.rays.get(at + lane);
                let radiance = paths.weight(at + lane) * appearance.background.radiance(ray.direction);
                seen[paths.sample.get(at + lane) as usize].radiance += radiance;
            }
        }
        if !self.trees.is_empty() {
            self.ended.extend(each_lane(missed).map(|lane| paths.sample.get(at + lane)));
        }
    }

    /// Ends paths on a surface without material.
    #[inline(never)]
    fn end_without_material(&mut self, mask: u8, (paths, at): (&TreeStream<E>, usize), seen: &mut [RadianceSample]) {
        for lane in each_lane(mask) {
            let sample = paths.sample.get(at + lane);
            seen[sample as usize].hit = true;
            self.end_path(sample);
        }
    }

    #[inline(always)]
    fn end_path(&mut self, sample: u32) {
        if !self.trees.is_empty() {
            self.ended.push(sample);
        }
    }

    /// Finds the media on both sides of hits, and applies absorption. At invisible interfaces, paths go on behind the surface.
    #[inline(always)]
    fn find_interfaces<L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        group: &mut Group<'_, L>,
        surface: &ShadedSurface<L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        let &Shade { lanes, settings, appearance, .. } = shade;
        let transmission = group.phong.interface;
        if transmission == SurfaceTransmission::None && !settings.features.absorption {
            return;
        }
        let (materials, body) = (&appearance.materials, group.body());
        let Some(material) = materials.get(body.material as usize) else { return };
        let (mut t, mut length) = ([0.0; 8], [0.0; 8]);
        lanes.store_f64(group.points.t, &mut t);
        lanes.store_f64(surface.length, &mut length);
        let (mut eta, mut weight) = ([E::rounded(1.0); 8], [[E::default(); 8]; 3]);
        let mut is_absorbed = false;
        for lane in each_lane(group.mask) {
            let at = group.at + lane;
            let tree = &mut self.trees[paths.sample.get(at) as usize];
            if transmission == SurfaceTransmission::None && tree.interior.is_empty() {
                continue;
            }
            let is_inside = surface.inside >> lane & 1 == 1;
            let interface = transmission.interface(&mut tree.interior, materials, body, is_inside);
            let interface = interface.as_ref();
            let way = (t[lane] - tree.start) * length[lane];
            if !transmission.is_visible(material, interface) {
                group.mask &= !(1 << lane);
                self.skip_interface(shade, (group, lane, t[lane]), interface, way, paths, seen);
                continue;
            }
            if settings.features.absorption {
                let around = interface.map_or_else(|| tree.interior.medium(materials), |c| c.before);
                let mut absorbed = paths.weight(at);
                if absorb(&mut absorbed, around.absorption, way) {
                    self.counts.absorption += 1;
                    if !core::mem::replace(&mut is_absorbed, true) {
                        lanes.store(group.weight.x, &mut weight[0]);
                        lanes.store(group.weight.y, &mut weight[1]);
                        lanes.store(group.weight.z, &mut weight[2]);
                    }
                    for (weight, absorbed) in weight.iter_mut().zip(absorbed.to_array()) {
                        weight[lane] = E::rounded(absorbed);
                    }
                }
            }
            if let Some(interface) = interface.filter(|_| group.phong.transmission.is_some()) {
                eta[lane] = E::rounded(interface.before.ior / interface.after.ior);
                group.transmits |= 1 << lane;
            }
        }
        group.eta = lanes.load(&eta);
        if is_absorbed {
            let [r, g, b] = &weight;
            group.weight = Vector3::new(lanes.load(r), lanes.load(g), lanes.load(b));
        }
    }

    /// Continues the ray of a lane behind a null interface.
    fn skip_interface<L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        (group, lane, t): (&Group<'_, L>, usize, f64),
        interface: Option<&MediumInterface>,
        way: f64,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        let &Shade { lanes, settings, .. } = shade;
        let at = group.at + lane;
        let sample = paths.sample.get(at);
        let tree = &mut self.trees[sample as usize];
        let mut weight = paths.weight(at);
        if let Some(interface) = interface {
            if interface.before.absorption != interface.after.absorption {
                let absorbs = absorb(&mut weight, interface.before.absorption, way);
                self.counts.absorption += u64::from(absorbs);
                seen[sample as usize].hit |= absorbs;
                tree.start = t;
            }
            tree.interior.cross(interface);
        } else {
            self.counts.interior_overflows += 1;
        }
        self.counts.passages += 1;
        tree.passages += 1;
        let depth = paths.depth.get(at) + u32::from(tree.passages > MAX_NULL_INTERFACES);
        if depth > settings.max_depth {
            self.counts.depth_limited += 1;
            return self.end_path(sample);
        }
        let [point, error, normal] = group.points.get(lanes, lane);
        let interaction = SurfaceInteraction::flat(point, error, normal, [0.0; 2]);
        let MediumEntry { object, material } = group.body();
        let (ray, _) = paths.rays.get(at);
        let span = SurfaceHit { t, interaction, object, material, light: None }.span_after(&ray);
        let path = TreePath { sample, depth, passages: 0, weight, start: 0.0 };
        self.refracted.push(&ray, span, &path);
    }

    /// Adds emission and reflected ambient light.
    #[inline(always)]
    fn add_emission<L: LaneSet<Element = E>>(
        &self,
        lanes: L,
        group: &Group<'_, L>,
        surface: &ShadedSurface<L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        for (mask, side) in [(group.mask & !surface.inside, 0), (group.mask & surface.inside, 1)] {
            if mask != 0 {
                let radiance = group.phong.radiance_from(side);
                add_radiance(
                    lanes,
                    mask,
                    lanes.splat_rgb(radiance).scaled_by(group.weight),
                    true,
                    paths.sample.vector(group.at),
                    seen,
                );
            }
        }
    }

    /// Adds the light of all delta lights, or queues their shadow rays.
    #[inline(always)]
    fn sample_lights<L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        group: &Group<'_, L>,
        surface: &ShadedSurface<L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        let &Shade { lanes, settings, appearance, .. } = shade;
        let &Group { phong, points, at, mask, .. } = group;
        let &ShadedSurface { normal, direction, near_origin, .. } = surface;
        let zero = lanes.splat(0.0);
        let has_highlight = phong.specular != Rgb::BLACK;
        for (light, stream) in appearance.lights.iter().zip(&mut self.lights) {
            let shadowed = settings.features.shadows && light.casts_shadows;
            let incident = sample_li(lanes, light, points, mask);
            let wi = incident.direction;
            let cos = normal.dot(wi);
            let faces = incident.is_lit & cos.gt(zero);
            let faced = lanes.bits(faces) & mask;
            if faced == 0 {
                self.counts.shadow_rays_skipped += if shadowed { u64::from(mask.count_ones()) } else { 0 };
                continue;
            }
            let mut reflectance = lanes.splat_rgb(phong.diffuse) * cos;
            if has_highlight {
                self.counts.highlights += u64::from(faced.count_ones());
                let strength = phong.highlight_strength([normal, -direction, wi]);
                reflectance = reflectance + lanes.splat_rgb(phong.specular) * strength;
            }
            let radiance = reflectance.scaled_by(incident.strength) * lanes.splat(light.units.classical_factor());
            let lit = faced & !lanes.bits(is_zero(radiance));
            let radiance = radiance.scaled_by(group.weight);
            if !shadowed {
                add_radiance(lanes, lit, radiance, true, paths.sample.vector(at), seen);
                continue;
            }
            self.counts.shadow_rays_skipped += u64::from((mask & !lit).count_ones());
            let (direction, end) = shadow_rays(lanes, light, near_origin);
            let time = shade.times(paths, at);
            stream.push(lanes, lit, [near_origin, direction], (end, time), (radiance, paths.sample.vector(at)));
        }
    }

    /// Spawns the mirrored and the refracted rays. Of two rays, the refracted one is deferred.
    #[inline(always)]
    fn spawn_rays<L: LaneSet<Element = E>>(
        &mut self,
        shade: &Shade<'_, L>,
        group: &Group<'_, L>,
        surface: &ShadedSurface<L>,
        paths: &TreeStream<E>,
    ) {
        let &Shade { lanes, settings, .. } = shade;
        let &Group { phong, at, mask, weight, transmits, eta, .. } = group;
        let &ShadedSurface { normal, direction, near_origin, .. } = surface;
        let features = &settings.features;
        let count = |mask: u8| u64::from(mask.count_ones());
        let is_specular = phong.mirror != Rgb::BLACK;
        let mut continues = 0;
        for (lane, depth) in paths.depth.vector(at).iter().enumerate() {
            continues |= u8::from(*depth < settings.max_depth) << lane;
        }
        let continues = continues & mask;
        self.counts.depth_limited += count(if is_specular { mask & !continues } else { transmits & mask & !continues });
        self.counts.mirrors += if features.reflection { count(continues) } else { 0 };
        let transmits = transmits & continues;
        let mut reflected_part = lanes.splat(1.0);
        let mut refracted = None;
        if transmits != 0 {
            self.counts.refractions += count(transmits);
            let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
            let has_fresnel = phong.fresnel_bit(0) != 0;
            // An index-matched interface does not deflect or reflect the ray.
            let is_null = eta.eq(one);
            if features.fresnel && has_fresnel {
                self.counts.fresnel += count(transmits);
                let reflectance = Real::select(is_null, zero, optics::fresnel(-direction.dot(normal), eta));
                reflected_part = Real::select(lanes.mask(transmits), reflectance, one);
            }
            let passed_part = if has_fresnel { one - reflected_part } else { one };
            let weight = weight.scaled_by(lanes.splat_rgb(phong.transmission_coefficient())) * passed_part;
            let significant = transmits & lanes.bits(is_significant(weight, settings.min_contribution).0);
            if significant != 0 {
                let sin_i = direction.cross(normal).length();
                let (bent, is_transmitted) = optics::refract_lanes(direction, normal, eta, sin_i);
                let turns_back = bent.dot(-normal).lt(zero);
                let bent = Vector3::select(turns_back, optics::reflect_lanes(bent, -normal), bent);
                let bent = Vector3::select(is_null, direction, bent);
                let mask = significant & lanes.bits(is_transmitted | is_null);
                refracted = (mask != 0).then_some((mask, bent, weight));
            }
        }
        let mut mirrored = 0;
        if features.reflection && is_specular && continues != 0 {
            let weight = weight.scaled_by(lanes.splat_rgb(phong.mirror)) * reflected_part;
            mirrored = continues & lanes.bits(is_significant(weight, settings.min_contribution).0);
            if mirrored != 0 {
                let bent = optics::reflect_lanes(direction, normal);
                let zero = lanes.splat(0.0);
                let bent = Vector3::select(bent.dot(normal).lt(zero), optics::reflect_lanes(bent, normal), bent);
                let next = &mut self.reflected;
                let end = next.len();
                let rays = [near_origin, lanes.widen_vector(bent)];
                let time = shade.times(paths, at);
                append(lanes, &mut next.rays, mirrored, rays, (lanes.splat_f64(f64::INFINITY), time));
                lanes.compress_vector(weight, mirrored, &mut next.weight, end);
                let mut depth = *paths.depth.vector(at);
                depth.iter_mut().for_each(|depth| *depth = depth.wrapping_add(1));
                lanes.compress_u32(&depth, mirrored, next.depth.vector_mut(end));
                lanes.compress_u32(paths.sample.vector(at), mirrored, next.sample.vector_mut(end));
            }
        }
        let mut refracts = 0;
        if let Some((mask, bent, weight)) = refracted {
            refracts = mask;
            self.push_refracted(lanes, group, surface, (mask, mirrored), [bent, weight], paths);
        }
        if features.refraction {
            for lane in each_lane(mask) {
                let sample = paths.sample.get(at + lane);
                let tree = &mut self.trees[sample as usize];
                (tree.passages, tree.start) = (0, 0.0);
                if (mirrored | refracts) >> lane & 1 == 0 {
                    self.end_path(sample);
                }
            }
        }
    }

    /// Defers the refracted rays of lanes that have mirrored rays as well, and continues with those of the other lanes.
    #[inline(always)]
    fn push_refracted<L: LaneSet<Element = E>>(
        &mut self,
        lanes: L,
        group: &Group<'_, L>,
        surface: &ShadedSurface<L>,
        (mask, mirrored): (u8, u8),
        [directions, weights]: [Vector3<L::F>; 2],
        paths: &TreeStream<E>,
    ) {
        let points = group.points;
        let directions = lanes.widen_vector(directions);
        let outwards =
            Vector3::select(directions.dot(points.outside).lt(lanes.splat_f64(0.0)), -points.outside, points.outside);
        let origins = lanes.store_point(offset(lanes, points, (points.point, outwards), mask));
        let weights = lanes.store_point(lanes.widen_vector(weights));
        let directions = lanes.store_point(directions);
        for lane in each_lane(mask) {
            let at = group.at + lane;
            let sample = paths.sample.get(at);
            let tree: &mut RayTree = &mut self.trees[sample as usize];
            let is_inside = surface.inside >> lane & 1 == 1;
            let event = group.phong.interface.event(&mut tree.interior, group.body(), is_inside);
            let of_lane = |[x, y, z]: &[[f64; 8]; 3]| [x[lane & 7], y[lane & 7], z[lane & 7]];
            let time = paths.rays.time.get(at);
            let ray = Ray { origin: of_lane(&origins).into(), direction: of_lane(&directions).into(), time };
            let weight = of_lane(&weights).into();
            let path = TreePath { sample, depth: paths.depth.get(at) + 1, passages: 0, weight, start: 0.0 };
            if mirrored >> lane & 1 == 1 {
                tree.defer(ray, &path, event);
            } else {
                tree.interior.apply(event);
                self.refracted.push(&ray, Interval::SPAWNED, &path);
            }
        }
    }
}

impl<L: LaneSet> Shade<'_, L> {
    /// Times of rays; `None` if all are 0.
    #[inline(always)]
    fn times<E: Element>(&self, paths: &TreeStream<E>, at: usize) -> Option<L::D> {
        if self.has_time { Some(self.lanes.load_f64(paths.rays.time.vector(at))) } else { None }
    }
}

impl<L: LaneSet> Group<'_, L> {
    const fn body(&self) -> MediumEntry {
        MediumEntry { object: self.primitive.object, material: self.primitive.material }
    }
}
