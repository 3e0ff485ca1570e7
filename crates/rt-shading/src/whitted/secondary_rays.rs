//! Mirrored and refracted rays of the hits of a group.

use super::{
    hit_group::{HitGroup, HitSurfaces},
    inputs::RayTreeInputs,
    streams::RayTreeStream,
    wave::SpawnedRays,
};
use crate::{
    lane_set::{Element, LaneSet},
    lanes::{each_lane, is_zero},
    medium_tracker::RayMedia,
    optics,
    wavefront::shaded_surface::{ShadedSurface, offset},
};
use rt_math::{Real, Rgb, Vector3};

impl<E: Element> SpawnedRays<E> {
    /// Spawns the mirrored and the refracted rays. Of two rays, the refracted one starts a branch.
    #[inline(always)]
    pub(super) fn spawn_rays<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &RayTreeInputs<'_>),
        group: &HitGroup<'_, L>,
        paths: &RayTreeStream<E>,
    ) {
        let settings = inputs.settings;
        let &HitGroup {
            phong,
            surfaces: &HitSurfaces { points: surface_points, surface, normals, .. },
            at,
            mask,
            throughput,
            transmits,
            eta,
            ..
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
            let transmitted_part = if has_fresnel { one - reflected_part } else { one };
            let throughput = throughput.scaled_by(lanes.splat_rgb(phong.transmission_coefficient())) * transmitted_part;
            let significant = transmits & lanes.bits(is_significant(throughput, settings.min_contribution));
            if significant != 0 {
                let sin_i = direction.cross(normal).length();
                let (refracted_direction, is_transmitted) = optics::refract_lanes(direction, normal, eta, sin_i);
                let turns_back = refracted_direction.dot(-towards_viewer).lt(zero);
                let refracted_direction = Vector3::select(
                    turns_back,
                    optics::reflect_lanes(refracted_direction, -towards_viewer),
                    refracted_direction,
                );
                let refracted_direction = Vector3::select(is_null, direction, refracted_direction);
                let mask = significant & lanes.bits(is_transmitted | is_null);
                refracted = (mask != 0).then_some((mask, refracted_direction, throughput));
            }
        }
        let mut mirrored = 0;
        if features.reflection && is_specular && continues != 0 {
            let throughput = throughput.scaled_by(lanes.splat_rgb(phong.mirror)) * reflected_part;
            mirrored = continues & lanes.bits(is_significant(throughput, settings.min_contribution));
            if mirrored != 0 {
                let mirrored_direction = optics::reflect_lanes(direction, normal);
                let zero = lanes.splat(0.0);
                let turns_back = mirrored_direction.dot(towards_viewer).lt(zero);
                let mirrored_direction = Vector3::select(
                    turns_back,
                    optics::reflect_lanes(mirrored_direction, towards_viewer),
                    mirrored_direction,
                );
                let end = self.reflected.len();
                let rays = [near_origin, lanes.widen_vector(mirrored_direction)];
                self.reflected.push_lanes(lanes, mirrored, rays, throughput, (paths, at, inputs.has_time));
                if features.refraction {
                    for (to, lane) in (end..).zip(each_lane(mirrored)) {
                        self.reflected.media.set(to, RayMedia::new(self.sides[lane & 7][0]));
                    }
                }
            }
        }
        if let Some((mask, refracted_direction, throughput)) = refracted {
            let directions = lanes.widen_vector(refracted_direction);
            let outside = surface_points.outside;
            let outwards = Vector3::select(directions.dot(outside).lt(lanes.splat_f64(0.0)), -outside, outside);
            let origins = offset(lanes, surface_points, (surface_points.point, outwards), mask);
            let end = self.refracted.len();
            self.refracted.push_lanes(lanes, mask, [origins, directions], throughput, (paths, at, inputs.has_time));
            for (to, lane) in (end..).zip(each_lane(mask)) {
                self.refracted.media.set(to, RayMedia::new(self.sides[lane & 7][1]));
                if mirrored >> lane & 1 == 1 {
                    let branch = self.start_branch(paths.branch.get(at + lane));
                    self.refracted.branch.set(to, branch);
                }
            }
        }
    }
}

/// True for throughputs that are visible in the pixel.
#[inline(always)]
fn is_significant<R: Real>(throughput: Vector3<R>, min_contribution: f64) -> R::Mask {
    !throughput.x.max(throughput.y).max(throughput.z).lt(throughput.x.splat(min_contribution)) & !is_zero(throughput)
}
