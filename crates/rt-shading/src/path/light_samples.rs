//! Samples of area and environment lights in lanes.

use super::ray_samples::RaySamples;
use crate::{
    lane_set::LaneSet,
    lanes::{LANES, each_lane},
    light::{Light, LightSet},
};
use rt_math::{DVec3, Real, Vector3};

/// Samples of one of the area and environment lights, one for each lane.
pub(super) struct LightSamples<L: LaneSet> {
    /// Lanes that a light reaches. Other numbers are not valid elsewhere.
    pub(super) lit: u8,
    /// Lanes whose light is at infinity.
    pub(super) infinite: u8,
    /// Unit vectors towards the light.
    pub(super) direction: Vector3<L::D>,
    /// Ends of the shadow rays, or their directions to a light at infinity.
    pub(super) target: Vector3<L::D>,
    /// Radiance divided by the density of the direction.
    pub(super) weighted: Vector3<L::D>,
    /// Densities per unit solid angle.
    pub(super) pdf: L::D,
}

impl<L: LaneSet> LightSamples<L> {
    /// Samples a light for each lane of a mask, from points with normals on the viewer's side. Those of a second mask are lit from both
    /// sides. All lanes that have chosen the same parallelogram are sampled at once, and those of other lights one by one.
    #[inline(always)]
    pub(super) fn new(
        lanes: L,
        lights: &LightSet,
        (from, normal): (Vector3<L::D>, Vector3<L::F>),
        (samples, at): (&RaySamples, usize),
        (mask, rough_glass): (u8, u8),
    ) -> Self {
        let [u, v] = &samples.direct_u;
        let u = [lanes.load_f64(u.vector(at)), lanes.load_f64(v.vector(at))];
        let normal = lanes.widen_vector(normal);
        let choice = lanes.load_f64(samples.direct_uc.vector(at));
        let (mut indices, mut probability) = lanes.choose_lights(lights, from, normal, choice);
        if rough_glass != 0 {
            choose_from_both_sides(lanes, lights, (from, choice), rough_glass, (&mut indices, &mut probability));
        }
        let zero = lanes.splat_f64(0.0);
        let none = Vector3::new(zero, zero, zero);
        let mut all = Self { lit: 0, infinite: 0, direction: none, target: none, weighted: none, pdf: zero };
        let mut waiting = mask;
        while let Some(first) = each_lane(waiting).next() {
            let same = lanes.equal(&indices, indices[first]) & waiting;
            waiting &= !same;
            match lights.sampled_lights().get(indices[first] as usize) {
                Some(Light::Quad(quad)) if !quad.emission().radiance().is_black() => {
                    let sampled = quad.sample_li_lanes(from, u);
                    let pdf = sampled.pdf * probability;
                    let radiance = lanes.splat_point(quad.emission().radiance().to_array().into());
                    let is_same = lanes.mask_f64(same);
                    all.lit |= same & lanes.bits_f64(sampled.is_lit & pdf.gt(zero));
                    all.direction = Vector3::select(is_same, sampled.direction, all.direction);
                    all.target = Vector3::select(is_same, sampled.target, all.target);
                    all.weighted = Vector3::select(is_same, radiance / pdf, all.weighted);
                    all.pdf = Real::select(is_same, pdf, all.pdf);
                }
                Some(light) => all.sample_one_by_one(lanes, light, same, (from, u, probability)),
                None => {}
            }
        }
        all
    }

    /// Samples a light that has been chosen in some lanes, one after the other.
    #[inline(never)]
    fn sample_one_by_one(
        &mut self,
        lanes: L,
        light: &Light,
        chosen: u8,
        (point, [u, v], probability): (Vector3<L::D>, [L::D; 2], L::D),
    ) {
        let point = lanes.store_point(point);
        let [mut of_u, mut of_v, mut probabilities, mut pdfs] = [[0.0; LANES]; 4];
        lanes.store_f64(u, &mut of_u);
        lanes.store_f64(v, &mut of_v);
        lanes.store_f64(probability, &mut probabilities);
        lanes.store_f64(self.pdf, &mut pdfs);
        let mut vectors = [self.direction, self.target, self.weighted].map(|v| lanes.store_point(v));
        for lane in each_lane(chosen) {
            let from = DVec3::from(point.map(|coordinates| coordinates[lane]));
            let Some(sample) = light.sample_li(from, [of_u[lane], of_v[lane]]) else { continue };
            let pdf = sample.pdf * probabilities[lane];
            if !(pdf > 0.0) {
                continue;
            }
            let target = sample.shadow_target();
            self.lit |= 1 << lane;
            self.infinite |= u8::from(target.is_none()) << lane;
            pdfs[lane] = pdf;
            let weighted = sample.radiance / pdf;
            let of_lane = [sample.direction, target.unwrap_or(sample.direction), weighted.to_array().into()];
            for (vector, of_lane) in vectors.iter_mut().zip(of_lane) {
                for (coordinates, coordinate) in vector.iter_mut().zip(of_lane.to_array()) {
                    coordinates[lane] = coordinate;
                }
            }
        }
        self.pdf = lanes.load_f64(&pdfs);
        [self.direction, self.target, self.weighted] = vectors.map(|v| lanes.load_coordinates(&v));
    }
}

/// Replaces the lights that are chosen in some lanes by those for points that are lit from both sides.
#[inline(never)]
fn choose_from_both_sides<L: LaneSet>(
    lanes: L,
    lights: &LightSet,
    (point, choice): (Vector3<L::D>, L::D),
    mask: u8,
    (indices, probability): (&mut [u32; LANES], &mut L::D),
) {
    let point = lanes.store_point(point);
    let [mut choices, mut probabilities] = [[0.0; LANES]; 2];
    lanes.store_f64(choice, &mut choices);
    lanes.store_f64(*probability, &mut probabilities);
    for lane in each_lane(mask) {
        let from = DVec3::from(point.map(|coordinates| coordinates[lane]));
        let chosen = lights.choose(from, None, choices[lane]);
        probabilities[lane] = chosen.map_or(0.0, |light| light.probability);
        indices[lane] = chosen.map_or(0, |light| light.index);
    }
    *probability = lanes.load_f64(&probabilities);
}
