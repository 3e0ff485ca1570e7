//! Images that are rendered for their mean alone.

use std::{fmt::Display, path::Path};

use rt_camera::SamplerKind;
use rt_render::{PlanOptions, RenderPlan};
use rt_scene_io::{Integrator, LoadOptions, RenderSettings, Scene, format::parse_ron, resolve};

use super::{Checks, Fallible, estimate::hold};

/// Fields of a scene without delta lights before black.
pub(super) const DARK: &str = "lights: [], background: constant(gray(0))";

/// A scene, and how it is sampled.
#[derive(Clone, Debug)]
pub(super) struct TestImage {
    pub scene: Scene,
}

impl TestImage {
    /// A scene of one pixel with these fields of a scene file. All samples are one pattern.
    pub(super) fn of(fields: &str) -> Fallible<Self> {
        let name = Path::new("analytic.ron");
        let text = format!("(film: (size: (1, 1)), {fields})");
        let mut scene = resolve(&parse_ron(&text, name)?, name, &LoadOptions::default())?;
        scene.settings.passes = Some(1);
        Ok(Self { scene })
    }

    /// The scene with these settings.
    pub(super) fn sampled(&self, integrator: Integrator, pattern: SamplerKind, seed: u64) -> Scene {
        let mut scene = self.scene.clone();
        scene.settings = RenderSettings { integrator, pattern, seed, ..scene.settings };
        scene
    }

    /// The mean radiance over all pixels, in green, as it is before the film rounds it.
    pub(super) fn mean(&self, integrator: Integrator, pattern: SamplerKind, spp: u32, seed: u64) -> Fallible<f64> {
        let mut scene = self.sampled(integrator, pattern, seed);
        scene.settings.spp = spp;
        let plan = RenderPlan::compile(&scene, &PlanOptions::default())?;
        let (width, height) = (scene.film.width, scene.film.height);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let sum: f64 = pixels.filter_map(|(x, y)| plan.pixel(x, y)).map(|radiance| radiance.g).sum();
        Ok(sum / f64::from(width * height))
    }

    /// Compares the mean radiance, times `scale`, with the truth for all unbiased patterns. `effort` is the number of seeds
    /// and of samples.
    pub(super) fn hold(
        &self,
        checks: &mut Checks,
        what: impl Display,
        truth: f64,
        (integrator, scale): (Integrator, f64),
        [seeds, spp]: [u64; 2],
    ) -> Fallible<()> {
        hold(checks, what, truth, seeds, |pattern, seed| Ok(self.mean(integrator, pattern, spp as u32, seed)? * scale))
    }

    /// [`hold`](Self::hold) by each of these integrators.
    pub(super) fn hold_by(
        &self,
        integrators: &[Integrator],
        checks: &mut Checks,
        what: impl Display,
        truth: f64,
        scale: f64,
        effort: [u64; 2],
    ) -> Fallible<()> {
        integrators.iter().try_for_each(|&integrator| {
            self.hold(checks, format_args!("{what}, {}", integrator.name()), truth, (integrator, scale), effort)
        })
    }
}
