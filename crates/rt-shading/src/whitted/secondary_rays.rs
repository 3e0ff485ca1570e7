//! Mirrored and refracted rays of the hits of a group.

use super::{
    hit_group::{HitGroup, HitSurfaces},
    inputs::TreeInputs,
    ray_tree::TreePath,
    streams::TreeStream,
    wave::SpawnedRays,
};
use crate::{
    lane_set::{Element, LaneSet},
    lanes::{each_lane, is_zero},
    optics,
    wavefront::{
        shaded_surface::{ShadedSurface, offset},
        streams::{append, times},
    },
};
use rt_math::{Interval, Ray, Real, Rgb, Vector3};

impl<E: Element> SpawnedRays<E> {
    /// Spawns the mirrored and the refracted rays. Of two rays, the refracted one is deferred.
    #[inline(always)]
    pub(super) fn spawn_rays<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        group: &HitGroup<'_, L>,
        paths: &TreeStream<E>,
    ) {
        let settings = inputs.settings;
        let &HitGroup {
            phong, surfaces: &HitSurfaces { surface, normals, .. }, at, mask, weight, transmits, eta, ..
        } = group;
        let &ShadedSurface { normal: towards_viewer, direction, near_origin, .. } = surface;
        let normal = normals.normal;
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
            let has_fresnel = phong.transmission.is_some_and(|(_, has_fresnel)| has_fresnel);
            // An index-matched interface does not deflect or reflect the ray.
            let is_null = eta.eq(one);
            if features.fresnel && has_fresnel {
                self.counts.fresnel += count(transmits);
                let reflectance = Real::select(is_null, zero, optics::fresnel(-direction.dot(normal), eta));
                reflected_part = Real::select(lanes.mask(transmits), reflectance, one);
            }
            let passed_part = if has_fresnel { one - reflected_part } else { one };
            let weight = weight.scaled_by(lanes.splat_rgb(phong.transmission_coefficient())) * passed_part;
            let significant = transmits & lanes.bits(is_significant(weight, settings.min_contribution));
            if significant != 0 {
                let sin_i = direction.cross(normal).length();
                let (bent, is_transmitted) = optics::refract_lanes(direction, normal, eta, sin_i);
                let turns_back = bent.dot(-towards_viewer).lt(zero);
                let bent = Vector3::select(turns_back, optics::reflect_lanes(bent, -towards_viewer), bent);
                let bent = Vector3::select(is_null, direction, bent);
                let mask = significant & lanes.bits(is_transmitted | is_null);
                refracted = (mask != 0).then_some((mask, bent, weight));
            }
        }
        let mut mirrored = 0;
        if features.reflection && is_specular && continues != 0 {
            let weight = weight.scaled_by(lanes.splat_rgb(phong.mirror)) * reflected_part;
            mirrored = continues & lanes.bits(is_significant(weight, settings.min_contribution));
            if mirrored != 0 {
                let bent = optics::reflect_lanes(direction, normal);
                let zero = lanes.splat(0.0);
                let turns_back = bent.dot(towards_viewer).lt(zero);
                let bent = Vector3::select(turns_back, optics::reflect_lanes(bent, towards_viewer), bent);
                let next = &mut self.reflected;
                let end = next.len();
                let rays = [near_origin, lanes.widen_vector(bent)];
                let time = times(lanes, &paths.rays, at, inputs.has_time);
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
            self.push_refracted(lanes, group, (mask, mirrored), [bent, weight], paths);
        }
        if features.refraction {
            for lane in each_lane(mask) {
                let sample = paths.sample.get(at + lane);
                self.trees[sample as usize].media.start_ray();
                if (mirrored | refracts) >> lane & 1 == 0 {
                    self.end_path(inputs, sample);
                }
            }
        }
    }

    /// Defers the refracted rays of lanes that have mirrored rays as well, and continues with those of the other lanes.
    #[inline(always)]
    fn push_refracted<L: LaneSet<Element = E>>(
        &mut self,
        lanes: L,
        group: &HitGroup<'_, L>,
        (mask, mirrored): (u8, u8),
        [directions, weights]: [Vector3<L::F>; 2],
        paths: &TreeStream<E>,
    ) {
        let HitSurfaces { points, surface, .. } = group.surfaces;
        let directions = lanes.widen_vector(directions);
        let outwards =
            Vector3::select(directions.dot(points.outside).lt(lanes.splat_f64(0.0)), -points.outside, points.outside);
        let origins = lanes.store_point(offset(lanes, points, (points.point, outwards), mask));
        let weights = lanes.store_point(lanes.widen_vector(weights));
        let directions = lanes.store_point(directions);
        for lane in each_lane(mask) {
            let at = group.at + lane;
            let sample = paths.sample.get(at);
            let tree = &mut self.trees[sample as usize];
            let is_inside = surface.inside >> lane & 1 == 1;
            let event = group.phong.interface.event(&mut tree.media.interior, group.surfaces.body(lane), is_inside);
            let of_lane = |[x, y, z]: &[[f64; 8]; 3]| [x[lane & 7], y[lane & 7], z[lane & 7]];
            let time = paths.rays.time.get(at);
            let ray = Ray { origin: of_lane(&origins).into(), direction: of_lane(&directions).into(), time };
            let weight = of_lane(&weights).into();
            let path = TreePath { sample, depth: paths.depth.get(at) + 1, weight };
            if mirrored >> lane & 1 == 1 {
                tree.defer(ray, &path, event);
            } else {
                tree.media.interior.apply(event);
                self.refracted.push(&ray, Interval::SPAWNED, &path);
            }
        }
    }
}

/// True for weights that are visible in the pixel.
#[inline(always)]
fn is_significant<R: Real>(weight: Vector3<R>, min_contribution: f64) -> R::Mask {
    !weight.x.max(weight.y).max(weight.z).lt(weight.x.splat(min_contribution)) & !is_zero(weight)
}
