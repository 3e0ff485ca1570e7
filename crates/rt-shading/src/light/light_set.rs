//! Lights of a scene, and the choice of the one that is sampled.

use super::{DeltaLight, Light, LightPoint, LightSample, LightTree, PowerLightSampler, SampledLight};
use crate::lanes::{LANES, LaneArray, Lanes, Simd, get};
use rt_math::{DVec3, Rgb, Vector3};

/// Distribution from which one of many area and environment lights is sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightSampling {
    /// Equal probability for every light that emits.
    Uniform,
    /// Probability in proportion to power.
    Power,
    /// Light tree: importance by power, distance and orientation.
    #[default]
    Tree,
}

impl LightSampling {
    /// All distributions.
    pub const ALL: [Self; 3] = [Self::Uniform, Self::Power, Self::Tree];

    /// Name in scene files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Power => "power",
            Self::Tree => "tree",
        }
    }
}

/// Identifier of an area light, and of the triangle of a mesh light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightId {
    /// Index into [`LightSet::lights`].
    pub index: u32,
    /// Index into the triangles of a mesh light; `None` if the hit does not give it.
    pub triangle: Option<u32>,
}

#[derive(Clone, Debug)]
enum LightSampler {
    Power(PowerLightSampler),
    Tree(LightTree),
}

/// Lights of a scene.
///
/// Integrators sample every delta light, and one of the other lights: delta lights are few, and their sum has no variance.
///
/// ```text
///   index      0 ········ n − 1                   n ········
///   lights     area and environment lights       delta lights
///   sampled    one of them, by LightSampling     all of them
/// ```
#[derive(Clone, Debug)]
pub struct LightSet {
    lights: Vec<Light>,
    /// Number of lights one of which is sampled. They come first.
    n_sampled: usize,
    sampler: LightSampler,
    environment: Option<u32>,
    pub(crate) is_seen_through_objects: bool,
}

impl Default for LightSet {
    /// Set without lights.
    fn default() -> Self {
        Self::new(Vec::new(), LightSampling::Power, 1.0)
    }
}

impl LightSet {
    /// The set in a scene where an object that casts no shadow may lie before one of the sampled lights. Light samples pass it, and
    /// integrators continue sampled directions to the light behind it.
    #[must_use]
    pub fn seen_through_objects(self) -> Self {
        Self { is_seen_through_objects: true, ..self }
    }

    /// Set of these lights, in their order but for delta lights, which move behind the others.
    ///
    /// `scene_radius` (world units) determines the power of environment lights. Rays that miss the scene hit the first
    /// of them.
    pub fn new(lights: Vec<Light>, sampling: LightSampling, scene_radius: f64) -> Self {
        let (delta, mut lights): (Vec<_>, Vec<_>) = lights.into_iter().partition(Light::is_delta);
        let n_sampled = lights.len();
        lights.extend(delta);
        let sampled = &lights[..n_sampled];
        let power = |light: &Light| light.power(scene_radius);
        let uniform = |light: &Light| if power(light).is_black() { Rgb::BLACK } else { Rgb::WHITE };
        let sampler = match sampling {
            LightSampling::Uniform => LightSampler::Power(PowerLightSampler::new(sampled.iter().map(uniform))),
            LightSampling::Power => LightSampler::Power(PowerLightSampler::new(sampled.iter().map(power))),
            LightSampling::Tree => LightSampler::Tree(LightTree::new(sampled.iter().map(Light::extent))),
        };
        let environment = sampled.iter().position(Light::is_environment);
        let environment = environment.and_then(|index| u32::try_from(index).ok());
        Self { lights, n_sampled, sampler, environment, is_seen_through_objects: false }
    }

    /// All lights, by index.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Area and environment lights, one of which is sampled. Their indices are those in [`lights`](Self::lights).
    pub fn sampled_lights(&self) -> &[Light] {
        &self.lights[..self.n_sampled]
    }

    /// Delta lights, all of which are sampled.
    #[inline]
    pub fn delta_lights(&self) -> impl Iterator<Item = &DeltaLight> {
        self.lights[self.n_sampled..].iter().filter_map(Light::as_delta)
    }

    /// Index of the environment light, if there is one.
    pub const fn environment(&self) -> Option<u32> {
        self.environment
    }

    /// Samples one of the [`sampled_lights`](Self::sampled_lights) from `point`.
    ///
    /// `normal` (unit) restricts lights to the side that it points to; `None` if light from behind counts as well. `choice`
    /// from `[0, 1)` selects the light, `u` from `[0, 1)²` the direction. `None` if the selected light does not reach the
    /// point.
    #[inline]
    pub fn sample_li(&self, point: DVec3, normal: Option<DVec3>, choice: f64, u: [f64; 2]) -> Option<LightSample> {
        let SampledLight { index, probability } = self.choose(point, normal, choice)?;
        let sample = self.lights.get(index as usize)?.sample_li(point, u)?;
        Some(LightSample { pdf: sample.pdf * probability, sample })
    }

    /// Chooses one of the lights as [`sample_li`](Self::sample_li) does; `None` if there is none.
    #[inline]
    pub(crate) fn choose(&self, point: DVec3, normal: Option<DVec3>, choice: f64) -> Option<SampledLight> {
        match self.sampled_lights() {
            [] => None,
            [_] => Some(SampledLight { index: 0, probability: 1.0 }),
            _ => self.sample(point, normal, choice),
        }
    }

    /// Density per unit solid angle at `point` with which [`sample_li`](Self::sample_li) samples the point `on_light`, whose unit normal is
    /// `light_normal`. 0 for an index that is not in the set.
    pub fn pdf_li(
        &self,
        point: DVec3,
        normal: Option<DVec3>,
        light: LightId,
        on_light: DVec3,
        light_normal: DVec3,
    ) -> f64 {
        let LightId { index, triangle } = light;
        let Some(light) = self.lights.get(index as usize) else { return 0.0 };
        let pdf = match (light, triangle) {
            (Light::Mesh(_), None) => light.pdf_li(point, on_light - point),
            (_, triangle) => {
                let triangle = triangle.unwrap_or_default();
                light.pdf_li_at(point, &LightPoint { point: on_light, normal: light_normal, triangle })
            }
        };
        pdf * self.pmf(point, normal, index)
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) finds a direction to the environment; 0 without
    /// one.
    pub fn pdf_li_environment(&self, point: DVec3, normal: Option<DVec3>, direction: DVec3) -> f64 {
        let Some(index) = self.environment else { return 0.0 };
        let pdf = self.lights.get(index as usize).map_or(0.0, |light| light.pdf_li(point, direction));
        pdf * self.pmf(point, normal, index)
    }

    /// Chooses one of the lights as [`sample_li`](Self::sample_li) does, for lanes: indices, and probabilities, which are 0 where
    /// there is none.
    #[inline(always)]
    pub(crate) fn choose_lanes<S: Simd>(
        &self,
        simd: S,
        point: Vector3<Lanes<S>>,
        normal: Vector3<Lanes<S>>,
        choice: Lanes<S>,
    ) -> ([u32; LANES], Lanes<S>) {
        match &self.sampler {
            _ if self.n_sampled == 1 => ([0; LANES], Lanes::splat(simd, 1.0)),
            LightSampler::Tree(tree) if tree.is_bounded() => tree.sample_lanes(simd, point, normal, choice),
            _ => {
                let vectors = [Lanes::store_vector(point), Lanes::store_vector(normal)];
                let (lights, probabilities) = self.choose_each(&vectors, &choice.store());
                (lights, Lanes::load(simd, &probabilities))
            }
        }
    }

    /// Chooses a light for each lane, one after the other, given points and normals.
    fn choose_each(
        &self,
        [points, normals]: &[Vector3<LaneArray>; 2],
        choices: &LaneArray,
    ) -> ([u32; LANES], LaneArray) {
        let (mut lights, mut probabilities) = ([0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            if let Some(sampled) = self.sample(get(points, lane), Some(get(normals, lane)), choices[lane]) {
                (lights[lane], probabilities[lane]) = (sampled.index, sampled.probability);
            }
        }
        (lights, probabilities)
    }

    fn sample(&self, point: DVec3, normal: Option<DVec3>, u: f64) -> Option<SampledLight> {
        match &self.sampler {
            LightSampler::Power(sampler) => sampler.sample(u),
            LightSampler::Tree(tree) => tree.sample(point, normal, u),
        }
    }

    fn pmf(&self, point: DVec3, normal: Option<DVec3>, index: u32) -> f64 {
        match &self.sampler {
            _ if self.n_sampled == 1 => 1.0,
            LightSampler::Power(sampler) => sampler.pmf(index),
            LightSampler::Tree(tree) => tree.pmf(point, normal, index),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane_set::{LaneSet as _, SimdLanes};
    use crate::light::{
        DeltaLightKind, Emission, EmissionSides, EnvironmentLight, Falloff, LightUnits, QuadLight, SphereLight,
    };

    fn lights() -> Vec<Light> {
        let white = Emission::new(Rgb::WHITE, EmissionSides::Front).expect("white");
        let bright = Emission::new(Rgb::gray(5.0), EmissionSides::Both).expect("bright");
        vec![
            Light::Quad(
                QuadLight::new(DVec3::new(-1.0, 3.0, -1.0), [DVec3::X * 2.0, DVec3::Z * 2.0], bright).expect("quad"),
            ),
            Light::Sphere(SphereLight::new(DVec3::new(4.0, 2.0, 0.0), 0.5, white).expect("sphere")),
            Light::Environment(EnvironmentLight::constant(Rgb::gray(0.3)).expect("sky")),
        ]
    }

    #[test]
    fn sampled_densities_equal_those_of_rays() {
        let (point, normal) = (DVec3::new(0.3, 0.0, 0.2), Some(DVec3::Y));
        for sampling in LightSampling::ALL {
            let set = LightSet::new(lights(), sampling, 10.0);
            let mut found = [0; 3];
            for i in 0..512u32 {
                let choice = (f64::from(i) + 0.5) / 512.0;
                let u = [(f64::from(i) * 0.618_034).fract(), (f64::from(i) * 0.754_878).fract()];
                let Some(LightSample { sample, pdf }) = set.sample_li(point, normal, choice, u) else { continue };
                let (index, pdf_of_ray) = match sample.point {
                    None => (2, set.pdf_li_environment(point, normal, sample.direction)),
                    Some(on_light) => {
                        let index = u32::from(sample.normal.y.abs() < 0.999_999);
                        let light = LightId { index, triangle: None };
                        (index, set.pdf_li(point, normal, light, on_light, sample.normal))
                    }
                };
                found[index as usize] += 1;
                assert!((pdf_of_ray / pdf - 1.0).abs() < 1e-9, "{sampling:?} {index}: {pdf_of_ray} and {pdf}");
            }
            assert!(found.iter().all(|&count| count > 0), "{sampling:?}: {found:?}");
        }
    }

    #[test]
    fn a_set_without_lights_gives_none() {
        let set = LightSet::default();
        assert!(set.lights().is_empty() && set.sample_li(DVec3::ZERO, None, 0.5, [0.5; 2]).is_none());
        assert_eq!(set.pdf_li_environment(DVec3::ZERO, None, DVec3::Y), 0.0);
        let light = LightId { index: 7, triangle: None };
        assert_eq!(set.pdf_li(DVec3::ZERO, None, light, DVec3::Y, DVec3::Y), 0.0);
    }

    #[test]
    fn delta_lights_do_not_change_indices_or_densities() {
        let kind = DeltaLightKind::Point { position: DVec3::Y, falloff: Falloff::None, shadow_near: 0.0 };
        let intensity = Rgb::gray(9.0);
        let delta = DeltaLight { units: LightUnits::Physical, ..DeltaLight::new(kind, intensity) };
        for sampling in LightSampling::ALL {
            let plain = LightSet::new(lights(), sampling, 10.0);
            let mut mixed = lights();
            mixed.insert(1, Light::Delta(delta.clone()));
            mixed.push(Light::Delta(delta.clone()));
            let mixed = LightSet::new(mixed, sampling, 10.0);
            assert_eq!((mixed.lights().len(), mixed.sampled_lights()), (5, plain.sampled_lights()));
            assert_eq!((mixed.environment(), mixed.delta_lights().count()), (plain.environment(), 2));
            for i in 0..64 {
                let choice = (f64::from(i) + 0.5) / 64.0;
                let sample = |set: &LightSet| set.sample_li(DVec3::ZERO, Some(DVec3::Y), choice, [0.3, 0.6]);
                assert_eq!(sample(&plain), sample(&mixed), "{sampling:?}");
            }
        }
    }

    #[test]
    fn lanes_choose_the_lights_of_scalars() {
        let Some(level) = crate::lanes::LaneLevel::best() else { return };
        crate::lanes::dispatch!(level, simd => assert_lanes_choose_the_lights_of_scalars(simd));
    }

    fn assert_lanes_choose_the_lights_of_scalars<S: Simd>(simd: S) {
        let number = |at, dimension| rt_math::random::unit(rt_math::random::hash(&[51, at, dimension]));
        let vector = |at, first| DVec3::from([0, 1, 2].map(|axis| number(at, first + axis) - 0.5));
        let quads = (0..40).map(|at| {
            let sides = if at % 3 == 0 { EmissionSides::Both } else { EmissionSides::Front };
            let emission =
                Emission::new(Rgb::gray(number(at, 0) * f64::from(at % 5 != 0)), sides).expect("an emission");
            let corner = vector(at, 1) * 9.0;
            Light::Quad(QuadLight::new(corner, [vector(at, 4), vector(at, 7)], emission).expect("a light"))
        });
        let quads: Vec<_> = quads.collect();
        let sets = [quads[1..2].to_vec(), quads[1..4].to_vec(), quads[..1].to_vec(), quads.clone(), lights()];
        for (sampling, lights) in LightSampling::ALL.into_iter().flat_map(|kind| sets.clone().map(|set| (kind, set))) {
            let set = LightSet::new(lights, sampling, 10.0);
            for at in 0..500 {
                let points = core::array::from_fn(|lane| vector(at, 20 + lane as u64) * 12.0);
                let normals = core::array::from_fn(|lane| vector(at, 30 + lane as u64).normalize());
                let choices = core::array::from_fn(|lane| number(at, 40 + lane as u64));
                let lanes = |v: &[DVec3; LANES]| {
                    SimdLanes(simd).load_coordinates(&[v.map(|v| v.x), v.map(|v| v.y), v.map(|v| v.z)])
                };
                let choice = Lanes::load(simd, &choices);
                let (found, probabilities) = set.choose_lanes(simd, lanes(&points), lanes(&normals), choice);
                let probabilities = probabilities.store();
                for lane in 0..LANES {
                    let expected = set.choose(points[lane], Some(normals[lane]), choices[lane]);
                    let is_found = probabilities[lane] > 0.0;
                    let found =
                        is_found.then_some(SampledLight { index: found[lane], probability: probabilities[lane] });
                    assert_eq!(found, expected, "{sampling:?}, point {at}, lane {lane}");
                }
            }
        }
    }
}
