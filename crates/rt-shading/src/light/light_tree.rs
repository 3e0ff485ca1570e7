//! Light tree: samples one of many lights by its importance for a point.

mod split;

use super::light_bounds::{LightBounds, LightExtent};
use super::piecewise_constant::BELOW_ONE;
use super::power_sampler::SampledLight;
use crate::lanes::{ALL_LANES, LANES, LaneMask, Lanes, Simd, each_lane};
use rt_math::{DVec3, Real, Vector3};
use split::split;

/// Binary tree of [`LightBounds`] (Conty Estevez, Kulla 2018). Sampling descends from the root, into each child with a
/// probability in proportion to its importance for the point.
///
/// Unbounded lights, as environments, have equal probabilities. The tree as a whole counts as one of them.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTree {
    nodes: Vec<Node>,
    unbounded: Vec<u32>,
    slots: Vec<LightSlot>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: LightBounds,
    /// Index of the parent; 0 at the root.
    parent: u32,
    content: Content,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Light(u32),
    /// First of two adjacent children.
    Halves(u32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum LightSlot {
    Leaf(u32),
    Unbounded,
    /// Black: not in the tree.
    Absent,
}

impl LightTree {
    /// Tree over lights, given by their extents. Black lights are never sampled.
    pub fn new(lights: impl IntoIterator<Item = LightExtent>) -> Self {
        let lights: Vec<_> = lights.into_iter().collect();
        let mut tree = Self { nodes: Vec::new(), unbounded: Vec::new(), slots: vec![LightSlot::Absent; lights.len()] };
        let mut bounded = Vec::new();
        for ((light, slot), index) in lights.into_iter().zip(&mut tree.slots).zip(0u32..) {
            match light {
                LightExtent::Bounded(bounds) if bounds.power() > 0.0 => bounded.push((bounds, index)),
                LightExtent::Unbounded => {
                    *slot = LightSlot::Unbounded;
                    tree.unbounded.push(index);
                }
                LightExtent::Bounded(_) | LightExtent::Black => {}
            }
        }
        tree.grow(&mut bounded);
        tree
    }

    /// Samples a light for a point by `u` in `[0, 1)`. The unit `normal` restricts lights to the side that it points to. `None` if
    /// there is no light.
    pub fn sample(&self, point: DVec3, normal: Option<DVec3>, u: f64) -> Option<SampledLight> {
        let u = if u >= 0.0 { u.min(BELOW_ONE) } else { 0.0 };
        let unbounded = self.probability_of_unbounded();
        let unbounded_light = self.unbounded.get((u / unbounded) as usize);
        // The quotient may round to the number of lights.
        if let Some(&index) = unbounded_light.or(if self.nodes.is_empty() { self.unbounded.last() } else { None }) {
            return Some(SampledLight { index, probability: unbounded });
        }
        let mut node = self.nodes.first()?;
        let mut probability = self.probability_of_tree();
        let mut u = ((u - (1.0 - probability)) / probability).clamp(0.0, BELOW_ONE);
        loop {
            let first = match node.content {
                Content::Light(index) => return Some(SampledLight { index, probability }),
                Content::Halves(first) => first as usize,
            };
            let pair = self.probabilities_of_pair(first, point.into(), normal.map(Vector3::from));
            let half = usize::from(u >= pair[0]);
            u = ((if half == 0 { u } else { u - pair[0] }) / pair[half]).min(BELOW_ONE);
            probability *= pair[half];
            node = self.nodes.get(first + half)?;
        }
    }

    /// True if there are lights, all of them with bounds.
    pub(super) const fn is_bounded(&self) -> bool {
        self.unbounded.is_empty() && !self.nodes.is_empty()
    }

    /// Version of [`sample`](Self::sample) for lanes: indices of lights, and their probabilities. The tree must be
    /// [bounded](Self::is_bounded).
    #[inline(always)]
    pub(super) fn sample_lanes<S: Simd>(
        &self,
        simd: S,
        point: Vector3<Lanes<S>>,
        normal: Vector3<Lanes<S>>,
        u: Lanes<S>,
    ) -> ([u32; LANES], Lanes<S>) {
        let (zero, below_one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, BELOW_ONE));
        // One node after the other, for all lanes that have arrived there.
        let (mut at, mut lights) = ([0usize; LANES], [0u32; LANES]);
        let mut u = zero.max(u.min(below_one));
        let mut probability = Lanes::splat(simd, 1.0);
        let mut waiting = ALL_LANES;
        while let Some(lane) = each_lane(waiting).next() {
            let mut here = 0;
            for other in each_lane(waiting) {
                here |= u8::from(at[other] == at[lane]) << other;
            }
            match self.nodes[at[lane]].content {
                Content::Light(index) => {
                    waiting &= !here;
                    for lane in each_lane(here) {
                        lights[lane] = index;
                    }
                }
                Content::Halves(first) => {
                    let first = first as usize;
                    let [a, b] = self.probabilities_of_pair(first, point, Some(normal));
                    let (is_here, is_second) = (LaneMask::from_bits(simd, here), u.ge(a));
                    let chosen = Real::select(is_second, b, a);
                    let within = (Real::select(is_second, u - a, u) / chosen).min(below_one);
                    u = Real::select(is_here, within, u);
                    probability = Real::select(is_here, probability * chosen, probability);
                    let seconds = is_second.bits();
                    for lane in each_lane(here) {
                        at[lane] = first + usize::from(seconds >> lane & 1);
                    }
                }
            }
        }
        (lights, probability)
    }

    /// Probability with which [`sample`](Self::sample) selects a light for this point. It is 0 for an index out of range and
    /// for a light that does not reach the point.
    pub fn pmf(&self, point: DVec3, normal: Option<DVec3>, index: u32) -> f64 {
        let mut node_index = match self.slots.get(index as usize) {
            Some(LightSlot::Unbounded) => return self.probability_of_unbounded(),
            Some(&LightSlot::Leaf(leaf)) => leaf,
            _ => return 0.0,
        };
        let mut probability = self.probability_of_tree();
        while let Some(node) = self.nodes.get(node_index as usize).filter(|_| node_index > 0) {
            // Pairs begin at odd numbers, behind the root.
            let first = (node_index - 1) | 1;
            let pair = self.probabilities_of_pair(first as usize, point.into(), normal.map(Vector3::from));
            probability *= pair[usize::from(node_index > first)];
            node_index = node.parent;
        }
        probability
    }

    /// Number of lights that are not black.
    pub fn len(&self) -> usize {
        self.unbounded.len() + self.nodes.len().div_ceil(2)
    }

    /// True if all lights are black.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn probability_of_unbounded(&self) -> f64 {
        let sharing = self.unbounded.len() + usize::from(!self.nodes.is_empty());
        1.0 / sharing.max(1) as f64
    }

    fn probability_of_tree(&self) -> f64 {
        if self.nodes.is_empty() { 0.0 } else { self.probability_of_unbounded() }
    }

    /// Probabilities of two siblings. If neither can light the point, both are 1/2, so that the probabilities of all lights sum to
    /// 1. Each is a quotient, since the difference from 1 may round to 0.
    #[inline(always)]
    fn probabilities_of_pair<R: Real>(&self, first: usize, point: Vector3<R>, normal: Option<Vector3<R>>) -> [R; 2] {
        let (zero, half) = (point.x.splat(0.0), point.x.splat(0.5));
        let [a, b] = match self.nodes.get(first..first + 2) {
            Some([a, b]) => [a.bounds.importance_lanes(point, normal), b.bounds.importance_lanes(point, normal)],
            _ => [zero; 2],
        };
        let is_lit = (a + b).gt(zero);
        [R::select(is_lit, a / (a + b), half), R::select(is_lit, b / (a + b), half)]
    }

    /// Builds the nodes, from the root down.
    fn grow(&mut self, lights: &mut [(LightBounds, u32)]) {
        let mut waiting = Vec::new();
        if let Some(bounds) = union(lights) {
            self.nodes.push(Node { bounds, parent: 0, content: Content::Halves(0) });
            waiting.push((0u32, 0..lights.len()));
        }
        while let Some((node_index, range)) = waiting.pop() {
            let node = node_index as usize;
            if let [(_, light)] = lights[range.clone()] {
                self.nodes[node].content = Content::Light(light);
                self.slots[light as usize] = LightSlot::Leaf(node_index);
                continue;
            }
            let middle = range.start + split(&self.nodes[node].bounds, &mut lights[range.clone()]);
            let first = self.nodes.len() as u32;
            self.nodes[node].content = Content::Halves(first);
            for (node_index, half) in [(first, range.start..middle), (first + 1, middle..range.end)] {
                let bounds = union(&lights[half.clone()]).unwrap_or(self.nodes[node].bounds);
                self.nodes.push(Node { bounds, parent: node as u32, content: Content::Halves(0) });
                waiting.push((node_index, half));
            }
        }
    }
}

fn union(lights: &[(LightBounds, u32)]) -> Option<LightBounds> {
    lights.iter().map(|(bounds, _)| *bounds).reduce(|a, b| a.union(&b))
}

#[cfg(test)]
mod tests {
    use super::super::test_estimate::{Estimate, white};
    use super::super::{
        DiskLight, Emission, EmissionSides, EnvironmentLight, Light, PowerLightSampler, QuadLight, SphereLight,
    };
    use super::*;
    use rt_math::Rgb;
    use rt_math::random::{hash, unit};

    fn tree_of(lights: &[Light]) -> LightTree {
        LightTree::new(lights.iter().map(Light::extent))
    }

    fn draw(i: u64, dimension: u64) -> f64 {
        unit(hash(&[i, dimension, 9]))
    }

    fn vector(i: u64, dimension: u64) -> DVec3 {
        DVec3::from([0, 1, 2].map(|axis| 2.0 * draw(i, dimension + axis) - 1.0))
    }

    /// Small lights of all kinds and strengths in a cube of side 20, some of them black.
    fn lights(count: u64) -> Vec<Light> {
        let light = |i: u64| {
            let (at, along) = (vector(i, 0) * 10.0, vector(i, 3));
            let strength = if i % 17 == 5 { 0.0 } else { 0.1 + draw(i, 6) * draw(i, 7) * 10.0 };
            let sides = if i.is_multiple_of(2) { EmissionSides::Front } else { EmissionSides::Both };
            let emission = Emission::new(Rgb::new(strength, strength, 0.0), sides).expect("an emission");
            match i % 3 {
                0 => {
                    let edges = [
                        along.any_orthogonal_vector().normalize() * 0.3,
                        along.normalize().any_orthonormal_vector().cross(along) * 0.2,
                    ];
                    Light::Quad(QuadLight::new(at, edges, emission).expect("a light"))
                }
                1 => Light::Disk(DiskLight::new(at, along, 0.2, 0.0, emission).expect("a light")),
                _ => Light::Sphere(SphereLight::new(at, 0.1 + 0.1 * draw(i, 8), emission).expect("a light")),
            }
        };
        (0..count).map(light).collect()
    }

    fn receivers() -> Vec<(DVec3, Option<DVec3>)> {
        let normal = |i: u64| (!i.is_multiple_of(4)).then(|| vector(i, 30).normalize());
        let near = (0..40).map(|i| (vector(i, 20) * 12.0, normal(i)));
        near.chain([(DVec3::X * 1e6, Some(DVec3::NEG_X)), (DVec3::Y * 1e9, None)]).collect()
    }

    fn sum(tree: &LightTree, count: u32, point: DVec3, normal: Option<DVec3>) -> f64 {
        (0..count).map(|index| tree.pmf(point, normal, index)).sum()
    }

    #[test]
    fn probabilities_add_up_to_one() {
        for count in [1, 2, 3, 10, 300] {
            let mut lights = lights(count);
            for environments in 0..3 {
                let tree = tree_of(&lights);
                for (point, normal) in receivers() {
                    let sum = sum(&tree, lights.len() as u32, point, normal);
                    assert!((sum - 1.0).abs() < 1e-12, "{count} lights and {environments} around from {point}: {sum}");
                }
                lights.push(Light::Environment(EnvironmentLight::constant(Rgb::WHITE).expect("a light")));
            }
        }
    }

    #[test]
    fn choices_are_as_likely_as_they_say() {
        let mut lights = lights(40);
        lights.insert(7, Light::Environment(EnvironmentLight::constant(Rgb::WHITE).expect("a light")));
        let tree = tree_of(&lights);
        let count = 8_000u32;
        for (point, normal) in receivers() {
            let mut found = vec![0.0; lights.len()];
            for i in 0..count {
                let choice = tree.sample(point, normal, (f64::from(i) + 0.5) / f64::from(count)).expect("a light");
                let probability = tree.pmf(point, normal, choice.index);
                assert!((choice.probability / probability - 1.0).abs() < 1e-12, "{choice:?}, again {probability}");
                found[choice.index as usize] += 1.0;
            }
            // Numbers at equal distances are found in each interval to one, and each light has one interval.
            for (found, index) in found.iter().zip(0..) {
                let expected = f64::from(count) * tree.pmf(point, normal, index);
                assert!(
                    (found - expected).abs() <= 1.0 + 1e-6,
                    "light {index} from {point}: {found}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn lights_that_arrive_may_be_chosen() {
        let lights = lights(300);
        let tree = tree_of(&lights);
        let (mut arriving, mut never) = (0, 0);
        for (point, normal) in receivers() {
            for (light, index) in lights.iter().zip(0u32..) {
                let mut samples = (0..16).filter_map(|i| light.sample_li(point, [draw(i, 40), draw(i, 41)]));
                let arrives = samples.any(|s| normal.is_none_or(|normal| s.direction.dot(normal) > 0.0));
                let probability = tree.pmf(point, normal, index);
                assert!(!arrives || probability > 0.0, "light {index} from {point}, normal {normal:?}");
                arriving += u32::from(arrives);
                never += u32::from(probability == 0.0);
            }
        }
        println!("{arriving} lights arrive, {never} are never chosen");
        assert!(arriving > 1000 && never > 500);
    }

    /// Lights at the very edge of being seen: at the horizon of the receiver, and edge-on.
    #[test]
    fn lights_at_the_horizon_may_be_chosen() {
        for tilt in [1e-3, 1e-8, 1e-12, 1e-16] {
            let edges = [DVec3::new(1e-9, 0.0, 1e-9 * tilt), DVec3::Y * 1e-9];
            let low = QuadLight::new(DVec3::new(1.0, 0.0, tilt), edges, white(EmissionSides::Both)).expect("a light");
            let high = SphereLight::new(DVec3::Z, 0.1, white(EmissionSides::Front)).expect("a light");
            let tree = tree_of(&[Light::Quad(low), Light::Sphere(high)]);
            assert!(tree.pmf(DVec3::ZERO, Some(DVec3::Z), 0) > 0.0, "{tilt}");
            let faces = QuadLight::new(
                DVec3::new(1.0, 0.0, 0.5),
                [DVec3::new(tilt, 0.0, 1.0), DVec3::NEG_Y],
                white(EmissionSides::Front),
            );
            let tree = tree_of(&[Light::Quad(faces.expect("a light")), Light::Sphere(high)]);
            assert!(tree.pmf(DVec3::new(1.0, 2.0, 0.0), Some(DVec3::Z), 0) > 0.0, "{tilt}");
        }
    }

    /// Irradiance by one light that was chosen.
    fn irradiance(
        lights: &[Light],
        point: DVec3,
        normal: DVec3,
        choose: impl Fn(f64) -> Option<SampledLight>,
    ) -> Estimate {
        let index = std::cell::Cell::new(0);
        Estimate::of(40_000, |u| {
            index.set(index.get() + 1);
            let Some(choice) = choose(draw(index.get(), 50)) else { return 0.0 };
            let sample = lights[choice.index as usize].sample_li(point, u);
            sample.map_or(0.0, |s| s.radiance.g * s.direction.dot(normal).max(0.0) / (s.pdf * choice.probability))
        })
    }

    #[test]
    fn both_ways_to_choose_give_the_sum_of_all_lights_and_the_tree_with_less_noise() {
        let lights = lights(300);
        let (tree, power) = (tree_of(&lights), PowerLightSampler::new(lights.iter().map(|light| light.power(1.0))));
        let mut gain = 1.0;
        for i in 0..8 {
            let (point, normal) = (vector(i, 60) * 9.0, vector(i, 63).normalize());
            let truth: f64 = lights
                .iter()
                .map(|light| super::super::test_estimate::irradiance(light, [point, normal], 2000).mean)
                .sum();
            let by_power = irradiance(&lights, point, normal, |u| power.sample(u));
            let by_tree = irradiance(&lights, point, normal, |u| tree.sample(point, Some(normal), u));
            by_power.assert(&format!("by power at {point}"), truth);
            by_tree.assert(&format!("by tree at {point}"), truth);
            gain *= by_power.standard_error / by_tree.standard_error;
            let wrong = |u| {
                let choice = tree.sample(point, Some(normal), u)?;
                Some(SampledLight { probability: 1.25 * choice.probability, ..choice })
            };
            assert!(irradiance(&lights, point, normal, wrong).z(truth) > 5.0, "a wrong probability is caught");
        }
        let gain = gain.sqrt().sqrt().sqrt();
        println!("standard errors by power are {gain:.2} times those by the tree");
        assert!(gain > 2.0);
    }

    #[test]
    fn odd_lights_and_points_never_panic() {
        let empty = tree_of(&[]);
        assert_eq!((empty.sample(DVec3::ZERO, None, 0.5), empty.len(), empty.is_empty()), (None, 0, true));
        let black = EnvironmentLight::constant(Rgb::BLACK).expect("a light");
        assert_eq!(tree_of(&[Light::Environment(black)]).sample(DVec3::ZERO, None, 0.5), None);
        let strong = |x: f64, power: f64| {
            let emission = Emission::new(Rgb::gray(power), EmissionSides::Front).expect("an emission");
            Light::Sphere(SphereLight::new(DVec3::X * x, 1.0, emission).expect("a light"))
        };
        let sets = [
            vec![strong(0.0, 1e-30), strong(5.0, 1e30)],
            vec![strong(0.0, 1.0); 100],
            vec![strong(1e60, 1e100), strong(-1e60, 1e100)],
            (0..200).map(|i| strong(f64::from(1u32 << (i % 31)), 1.0)).collect(),
        ];
        for lights in sets {
            let tree = tree_of(&lights);
            assert_eq!(tree.len(), lights.len());
            for point in [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::INFINITY, DVec3::MAX, DVec3::X * 1e60] {
                for normal in [None, Some(DVec3::X), Some(DVec3::ZERO), Some(DVec3::NAN)] {
                    let sum = sum(&tree, lights.len() as u32, point, normal);
                    assert!((sum - 1.0).abs() < 1e-9, "from {point}, {normal:?}: {sum}");
                    for u in [0.0, 0.3, 1.0, -1.0, f64::NAN, 7.0] {
                        let choice = tree.sample(point, normal, u).expect("a light");
                        assert!(choice.probability > 0.0 && choice.probability <= 1.0, "{choice:?}");
                    }
                }
            }
        }
    }
}
