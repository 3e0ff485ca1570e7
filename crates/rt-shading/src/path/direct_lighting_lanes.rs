//! Next-event estimation in lanes: light samples at blocks of path vertices, with MIS weights, and their shadow rays.
//!
//! Results have the bits of [`LightSet::sample_li`] and [`DeltaLight::sample_li`] for one vertex.

use super::lane_bsdf::LaneBsdf;
use super::vertex_block::{Block, DeltaBlock, FollowedLobes, FrameLanes, IncidentLanes, ScatteredBlock, replace};
use crate::{
    DeltaLight,
    lanes::{LANES, LaneMask, Lanes, Simd, each_lane, first_lanes, get, is_zero, set, set_rgb},
    light::{Light, LightSet, QuadLight},
};
use rt_math::{Real, Rgb, Vector3};

/// Samples one of the area and environment lights for each vertex.
pub(super) fn sample_lights<S: Simd>(simd: S, blocks: &mut [Block], n_vertices: usize, lights: &LightSet) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (at, block) in blocks.iter_mut().enumerate() {
                let n_used = (n_vertices - at * LANES).min(LANES);
                sample_light(simd, block, first_lanes(n_used), lights);
            }
        },
    );
}

/// Samples a light for each of the lanes: for all lanes that have chosen the same parallelogram at once, and for others one by one.
#[inline(always)]
fn sample_light<S: Simd>(simd: S, block: &mut Block, lanes: u8, lights: &LightSet) {
    let point = Lanes::load_vector(simd, &block.point);
    let normal = Lanes::load_vector(simd, &block.shading_normal) * Lanes::load(simd, &block.side);
    let choice = Lanes::load(simd, &block.u_light_choice);
    let (indices, probability) = lights.choose_lanes(simd, point, normal, choice);
    block.light.pdf = [0.0; LANES];
    let mut waiting = lanes;
    while let Some(first) = each_lane(waiting).next() {
        let mut same = 0;
        for lane in each_lane(waiting) {
            same |= u8::from(indices[lane] == indices[first]) << lane;
        }
        waiting &= !same;
        match lights.sampled_lights().get(indices[first] as usize) {
            Some(Light::Quad(quad)) if !quad.emission().radiance().is_black() => {
                sample_quad(simd, block, (same, probability), quad);
            }
            Some(light) => {
                let probability = probability.store();
                for lane in each_lane(same) {
                    sample_one(block, lane, probability[lane], light);
                }
            }
            None => {}
        }
    }
}

/// Samples a light that has been chosen for one vertex.
fn sample_one(block: &mut Block, lane: usize, probability: f64, chosen: &Light) {
    let [u, v] = &block.u_light;
    let Some(sample) = chosen.sample_li(get(&block.point, lane), [u[lane], v[lane]]) else { return };
    let light = &mut block.light;
    let target = sample.shadow_target();
    set(&mut light.direction, lane, sample.direction);
    set(&mut light.target, lane, target.unwrap_or(sample.direction));
    light.is_infinite[lane] = if target.is_none() { 1.0 } else { 0.0 };
    set_rgb(&mut light.radiance, lane, sample.radiance);
    light.pdf[lane] = sample.pdf * probability;
}

/// Samples a parallelogram that has been chosen in these lanes.
#[inline(always)]
fn sample_quad<S: Simd>(simd: S, block: &mut Block, (lanes, probability): (u8, Lanes<S>), quad: &QuadLight) {
    let point = Lanes::load_vector(simd, &block.point);
    let [u, v] = &block.u_light;
    let sampled = quad.sample_li_lanes(point, [Lanes::load(simd, u), Lanes::load(simd, v)]);
    let Rgb { r, g, b } = quad.emission().radiance();
    let radiance = Vector3::new(Lanes::splat(simd, r), Lanes::splat(simd, g), Lanes::splat(simd, b));
    let (light, is_chosen) = (&mut block.light, LaneMask::from_bits(simd, lanes));
    replace(simd, &mut light.direction, is_chosen, sampled.direction);
    replace(simd, &mut light.target, is_chosen, sampled.target);
    replace(simd, &mut light.radiance, is_chosen, radiance);
    let (is_infinite, pdf) = (Lanes::load(simd, &light.is_infinite), Lanes::load(simd, &light.pdf));
    light.is_infinite = Real::select(is_chosen, Lanes::splat(simd, 0.0), is_infinite).store();
    light.pdf = Real::select(is_chosen & sampled.is_lit, sampled.pdf * probability, pdf).store();
}

/// Light of the sampled light that the vertices reflect, with its MIS weight, and its shadow rays; all other results are empty.
/// Returns the lanes of `valid` in which no rare case occurs.
#[inline(always)]
pub(super) fn reflect_sampled_light<S: Simd, B: LaneBsdf<S>>(
    simd: S,
    block: &Block,
    (frame, bsdf): (&FrameLanes<S>, &B),
    (lobes, valid): (FollowedLobes, LaneMask<S>),
) -> (ScatteredBlock, LaneMask<S>) {
    let zero = Lanes::splat(simd, 0.0);
    let light = &block.light;
    let (wi, target) = (Lanes::load_vector(simd, &light.direction), Lanes::load_vector(simd, &light.target));
    let light_pdf = Lanes::load(simd, &light.pdf);
    let is_infinite = Lanes::load(simd, &light.is_infinite).gt(zero);
    let IncidentLanes { local, cos, is_reflected } = frame.incident(simd, wi);
    let reflected = bsdf.eval_mis(local, light_pdf, lobes) * cos;
    let lit = light_pdf.gt(zero) & is_reflected & !is_zero(reflected);
    let (throughput, radiance) =
        (Lanes::load_vector(simd, &block.throughput), Lanes::load_vector(simd, &light.radiance));
    let direct = throughput.scaled_by(reflected).scaled_by(radiance) / light_pdf;

    let (shadow_origin, is_offset) = frame.shadow_origin(simd, block);
    let to_light = Vector3::select(is_infinite, target, target - frame.point);
    let valid = valid & (!lit | (is_offset & frame.starts_near(simd, to_light)));
    let shadow_direction = Vector3::select(is_infinite, target, target - shadow_origin);
    let scattered = ScatteredBlock {
        lit: lit.bits(),
        shadow_origin: Lanes::store_vector(shadow_origin),
        shadow_direction: Lanes::store_vector(shadow_direction),
        direct: Lanes::store_vector(direct),
        ..ScatteredBlock::default()
    };
    (scattered, valid)
}

/// Light of a delta light that the vertices reflect, and its shadow rays.
#[inline(always)]
pub(super) fn sample_delta_light<S: Simd, B: LaneBsdf<S>>(
    simd: S,
    block: &mut Block,
    (frame, bsdf): (&FrameLanes<S>, &B),
    light: &DeltaLight,
) -> DeltaBlock {
    let sample = light.sample_li_lanes(frame.point);
    let IncidentLanes { local, cos, is_reflected } = frame.incident(simd, sample.direction);
    let value = bsdf.eval(local);
    // Cancels the 1/π of BSDFs for lights in classical units.
    let factor = Lanes::splat(simd, light.units.irradiance_factor());
    let throughput = Lanes::load_vector(simd, &block.throughput);
    let radiance = throughput.scaled_by(value * cos).scaled_by(sample.strength) * factor;
    let lit = sample.is_lit & is_reflected & !is_zero(radiance);
    let mut result = DeltaBlock {
        lit: lit.bits(),
        black: (sample.is_lit & !lit).bits(),
        radiance: Lanes::store_vector(radiance),
        ..DeltaBlock::default()
    };
    if light.casts_shadows {
        let (origin, is_offset) = frame.shadow_origin(simd, block);
        let (to_light, direction) = match light.kind.position() {
            None => (sample.direction, sample.direction),
            Some(position) => {
                let position = Vector3::splat(cos, position);
                (position - frame.point, position - origin)
            }
        };
        block.valid &= (!lit | (is_offset & frame.starts_near(simd, to_light))).bits();
        result.shadow_direction = Lanes::store_vector(direction);
        result.shadow_end = light.shadow_end(direction).store();
    }
    result
}
