//! All lights with extent of a scene, and the choice among them.

use super::{Choice, Emitter, EmitterPoint, EmitterSample, LightTree, PowerChoice};
use rt_math::{DVec3, Rgb};

/// How one of many lights is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightSampling {
    /// Each as often as any other.
    Uniform,
    /// In proportion to power.
    Power,
    /// By a tree that knows how near lights are and where they shine.
    #[default]
    Tree,
}

impl LightSampling {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::Uniform, Self::Power, Self::Tree];

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Power => "power",
            Self::Tree => "tree",
        }
    }
}

/// What a ray knows of the light that it has met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmitterRef {
    /// Number of the light in its [`EmitterSet`].
    pub index: u32,
    /// The triangle of a light that is a mesh, if the hit tells it.
    pub triangle: Option<u32>,
}

/// A point of a light, and how likely it was to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// The point, with the density of its direction among those to this light alone.
    pub sample: EmitterSample,
    /// Density of the direction among those to all lights.
    pub pdf: f64,
}

#[derive(Clone, Debug)]
enum LightChooser {
    Power(PowerChoice),
    Tree(LightTree),
}

/// The lights with extent of a scene. Their environment, if it has one, is a light as any other.
#[derive(Clone, Debug)]
pub struct EmitterSet {
    emitters: Vec<Emitter>,
    chooser: LightChooser,
    environment: Option<u32>,
}

impl Default for EmitterSet {
    /// No light.
    fn default() -> Self {
        Self::new(Vec::new(), LightSampling::Power, 1.0)
    }
}

impl EmitterSet {
    /// The set of these lights; `scene_radius` (world units) tells how much an environment shines into the scene. Of several
    /// environments the first is that of rays that meet nothing.
    pub fn new(emitters: Vec<Emitter>, sampling: LightSampling, scene_radius: f64) -> Self {
        let power = |emitter: &Emitter| emitter.power(scene_radius);
        let uniform = |emitter: &Emitter| if power(emitter).is_black() { Rgb::BLACK } else { Rgb::WHITE };
        let chooser = match sampling {
            LightSampling::Uniform => LightChooser::Power(PowerChoice::new(emitters.iter().map(uniform))),
            LightSampling::Power => LightChooser::Power(PowerChoice::new(emitters.iter().map(power))),
            LightSampling::Tree => LightChooser::Tree(LightTree::new(&emitters)),
        };
        let environment = emitters.iter().position(|emitter| matches!(emitter, Emitter::Environment(_)));
        Self { environment: environment.and_then(|index| u32::try_from(index).ok()), emitters, chooser }
    }

    /// The lights, by number.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.emitters.is_empty()
    }

    /// The number of the environment, if there is one.
    pub const fn environment(&self) -> Option<u32> {
        self.environment
    }

    /// A point of one of the lights as `point` sees it, where a surface has the unit `normal` if light from behind it does not
    /// matter; `choice` is drawn from `[0, 1)`, and `u` from `[0, 1)²`. `None` if the light that was chosen gives nothing.
    #[inline]
    pub fn sample(&self, point: DVec3, normal: Option<DVec3>, choice: f64, u: [f64; 2]) -> Option<LightSample> {
        let Choice { index, probability } = match &self.emitters[..] {
            [] => return None,
            [_] => Choice { index: 0, probability: 1.0 },
            _ => self.choose(point, normal, choice)?,
        };
        let sample = self.emitters.get(index as usize)?.sample(point, u)?;
        Some(LightSample { pdf: sample.pdf * probability, sample })
    }

    fn choose(&self, point: DVec3, normal: Option<DVec3>, u: f64) -> Option<Choice> {
        match &self.chooser {
            LightChooser::Power(choice) => choice.choose(u),
            LightChooser::Tree(tree) => tree.choose(point, normal, u),
        }
    }

    fn probability(&self, point: DVec3, normal: Option<DVec3>, index: u32) -> f64 {
        match &self.chooser {
            _ if self.emitters.len() == 1 => 1.0,
            LightChooser::Power(choice) => choice.probability(index),
            LightChooser::Tree(tree) => tree.probability(point, normal, index),
        }
    }

    /// Density, per unit solid angle, with which [`sample`](Self::sample) finds the point `on_light`, with its unit normal,
    /// where a ray from `point` has met a light. 0 for a light that is not of the set.
    pub fn pdf(
        &self,
        point: DVec3,
        normal: Option<DVec3>,
        light: EmitterRef,
        on_light: DVec3,
        light_normal: DVec3,
    ) -> f64 {
        let Some(emitter) = self.emitters.get(light.index as usize) else { return 0.0 };
        let pdf = match (emitter, light.triangle) {
            (Emitter::Mesh(mesh), None) => mesh.pdf(point, on_light - point),
            (_, triangle) => {
                let triangle = triangle.unwrap_or_default();
                emitter.pdf_at(point, &EmitterPoint { point: on_light, normal: light_normal, triangle })
            }
        };
        pdf * self.probability(point, normal, light.index)
    }

    /// The same for the environment in a direction; 0 if there is none.
    pub fn environment_pdf(&self, point: DVec3, normal: Option<DVec3>, direction: DVec3) -> f64 {
        let Some(index) = self.environment else { return 0.0 };
        let pdf = self.emitters.get(index as usize).map_or(0.0, |emitter| emitter.pdf(point, direction));
        pdf * self.probability(point, normal, index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emitter::{Emission, EnvironmentLight, QuadLight, Sides, SphereLight};

    fn lights() -> Vec<Emitter> {
        let white = Emission::new(Rgb::WHITE, Sides::Front).expect("white");
        let bright = Emission::new(Rgb::gray(5.0), Sides::Both).expect("bright");
        vec![
            Emitter::Quad(
                QuadLight::new(DVec3::new(-1.0, 3.0, -1.0), [DVec3::X * 2.0, DVec3::Z * 2.0], bright).expect("quad"),
            ),
            Emitter::Sphere(SphereLight::new(DVec3::new(4.0, 2.0, 0.0), 0.5, white).expect("sphere")),
            Emitter::Environment(EnvironmentLight::constant(Rgb::gray(0.3)).expect("sky")),
        ]
    }

    #[test]
    fn samples_have_the_density_that_rays_are_told() {
        let (point, normal) = (DVec3::new(0.3, 0.0, 0.2), Some(DVec3::Y));
        for sampling in LightSampling::ALL {
            let set = EmitterSet::new(lights(), sampling, 10.0);
            let mut found = [0; 3];
            for i in 0..512u32 {
                let choice = (f64::from(i) + 0.5) / 512.0;
                let u = [(f64::from(i) * 0.618_034).fract(), (f64::from(i) * 0.754_878).fract()];
                let Some(LightSample { sample, pdf }) = set.sample(point, normal, choice, u) else { continue };
                let (index, told) = match sample.point {
                    None => (2, set.environment_pdf(point, normal, sample.direction)),
                    Some(on_light) => {
                        let index = u32::from(sample.normal.y.abs() < 0.999_999);
                        let light = EmitterRef { index, triangle: None };
                        (index, set.pdf(point, normal, light, on_light, sample.normal))
                    }
                };
                found[index as usize] += 1;
                assert!((told / pdf - 1.0).abs() < 1e-9, "{sampling:?} {index}: {told} and {pdf}");
            }
            assert!(found.iter().all(|&count| count > 0), "{sampling:?}: {found:?}");
        }
    }

    #[test]
    fn a_set_without_lights_gives_none() {
        let set = EmitterSet::default();
        assert!(set.is_empty() && set.sample(DVec3::ZERO, None, 0.5, [0.5; 2]).is_none());
        assert_eq!(set.environment_pdf(DVec3::ZERO, None, DVec3::Y), 0.0);
        let light = EmitterRef { index: 7, triangle: None };
        assert_eq!(set.pdf(DVec3::ZERO, None, light, DVec3::Y, DVec3::Y), 0.0);
    }
}
