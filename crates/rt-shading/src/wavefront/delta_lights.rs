//! Light of delta lights in lanes.

use super::{hit_points::HitPoints, is_in_range};
use crate::{
    DeltaLight,
    lane_set::LaneSet,
    light::{DeltaLiLanes, SpotCone},
};
use rt_math::{DVec3, Real, Vector3};

/// Squared distances of lights that are certain not to overflow or underflow in `f32`.
const MIN_SQUARED: f64 = 1e-30;
const MAX_SQUARED: f64 = 1e30;

/// Least range of cosines of the cone of a spot, and of its ramp.
const MIN_COSINE_STEP: f64 = 1e-3;

/// True for a light whose intensity is in range ([`is_in_range`]), and whose cone is wide enough for cosines in `f32`.
pub(crate) fn light_fits_f32(light: &DeltaLight) -> bool {
    let is_wide = |cone: SpotCone| {
        let ramp = cone.cos_inner - cone.cos_outer;
        1.0 - cone.cos_outer >= MIN_COSINE_STEP && (ramp == 0.0 || ramp >= MIN_COSINE_STEP)
    };
    is_in_range(light.intensity) && light.kind.cone().is_none_or(is_wide)
}

/// Light that arrives at the points of a mask.
#[inline(always)]
pub(crate) fn sample_li<L: LaneSet>(
    lanes: L,
    light: &DeltaLight,
    points: &HitPoints<L>,
    mask: u8,
) -> DeltaLiLanes<L::F> {
    let position = light.kind.position().map_or(points.point, |position| lanes.splat_point(position));
    let to_light = lanes.narrow_vector(position - points.point);
    let incident = light.sample_li_from(to_light);
    let squared = to_light.length_squared();
    let fits_f32 = squared.gt(lanes.splat(MIN_SQUARED)) & squared.lt(lanes.splat(MAX_SQUARED));
    if mask & !lanes.bits(fits_f32) == 0 || light.kind.position().is_none() {
        return incident;
    }
    let exact = light.sample_li_lanes(points.point);
    let select = |approximate, exact| Vector3::select(fits_f32, approximate, lanes.narrow_vector(exact));
    let is_lit = lanes.mask(lanes.bits_f64(exact.is_lit));
    DeltaLiLanes {
        direction: select(incident.direction, exact.direction),
        strength: select(incident.strength, exact.strength),
        distance: Real::select(fits_f32, incident.distance, lanes.narrow(exact.distance)),
        is_lit: (fits_f32 & incident.is_lit) | (!fits_f32 & is_lit),
    }
}

/// Directions of shadow rays from these origins, and the parameters at which they end.
#[inline(always)]
pub(crate) fn shadow_rays<L: LaneSet>(lanes: L, light: &DeltaLight, origin: Vector3<L::D>) -> (Vector3<L::D>, L::D) {
    let direction = match light.kind.position() {
        Some(position) => lanes.splat_point(position) - origin,
        None => lanes.splat_point(light.kind.offset_from(DVec3::ZERO)),
    };
    (direction, light.shadow_end(direction))
}
