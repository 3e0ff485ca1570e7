//! Prediction of the memory of a render from counts, before any of it is allocated.
//!
//! ```text
//!   peak = textures + geometry + accelerators + max(building, film)
//! ```
//!
//! The scene is held throughout. Acceleration structures are built one after the other, each with temporary memory; the film is
//! allocated afterwards. Factors are upper estimates: `docs/MEMORY.md` compares them with measured peaks. The memory of the
//! program without a scene is not included.

mod survey;

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use bytesize::ByteSize;
use rt_scene_io::{Background, Integrator, MemoryError, Scene};
use rt_shading::Texture;

use crate::{Crop, RenderError, accel_choice::AccelOptions, film::pixel_estimate::PixelEstimate, splats::SplatImage};
use survey::{LargestItem, Survey};

/// Maximum number of instances of an aggregate: some gigabytes. Nested groups multiply, so that a few lines of a file can
/// exceed any memory.
const MAX_INSTANCES: u64 = 1 << 24;

/// Predicted bytes of memory of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryPrediction {
    /// Film and image, with all data per pixel.
    pub film: u64,
    /// Images of textures and of the environment.
    pub textures: u64,
    /// Nodes, shapes, meshes and instances.
    pub geometry: u64,
    /// Acceleration structures.
    pub accelerators: u64,
    /// Temporary memory of the largest accelerator while it is built.
    pub building: u64,
}

/// Data kept per pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PerPixel {
    /// Rendered rectangle of the image.
    pub(crate) crop: Crop,
    /// True for an alpha channel.
    pub(crate) transparent: bool,
    /// True if passes are accumulated per pixel.
    pub(crate) progressive: bool,
    /// True if maps of standard errors and sample counts are kept.
    pub(crate) maps: bool,
    /// True if accelerators are built for the objects in view.
    pub(crate) culls: bool,
}

impl MemoryPrediction {
    /// Largest amount held at any time.
    pub const fn peak(&self) -> u64 {
        let Self { film, textures, geometry, accelerators, building } = *self;
        let passing = if film > building { film } else { building };
        textures.saturating_add(geometry).saturating_add(accelerators).saturating_add(passing)
    }

    /// Named parts of the prediction.
    pub const fn parts(&self) -> [(&'static str, u64); 5] {
        [
            ("film", self.film),
            ("textures", self.textures),
            ("geometry", self.geometry),
            ("accelerators", self.accelerators),
            ("building", self.building),
        ]
    }

    /// Prediction for a scene without an image; an error if it exceeds the budget.
    ///
    /// # Errors
    /// [`RenderError::Memory`], [`RenderError::TooManyParts`], or if the tree is nested too deeply or an index points nowhere.
    pub fn of_scene(scene: &Scene, budget: Option<u64>) -> Result<Self, RenderError> {
        let crop = Crop { x: 0, y: 0, width: 0, height: 0 };
        let kept = PerPixel { crop, transparent: false, progressive: false, maps: false, culls: false };
        let (prediction, largest) = Self::of(scene, AccelOptions::default(), &kept)?;
        prediction.check(budget, largest)?;
        Ok(prediction)
    }

    /// Prediction for a scene, and its largest item.
    pub(crate) fn of(
        scene: &Scene,
        accel_options: AccelOptions,
        kept: &PerPixel,
    ) -> Result<(Self, LargestItem), RenderError> {
        let mut largest = LargestItem::default();
        let survey = Survey::of(scene, accel_options, kept.culls, &mut largest)?;
        let prediction = Self {
            film: film(scene, kept),
            textures: textures(scene),
            geometry: survey.geometry,
            accelerators: survey.accelerators,
            building: survey.building,
        };
        let Crop { width, height, .. } = kept.crop;
        largest.update(prediction.film, || format!("the image of {width} x {height} pixels"));
        largest.update(prediction.textures, || "textures".to_owned());
        Ok((prediction, largest))
    }

    /// Error if the prediction exceeds the budget, or an aggregate has too many instances.
    pub(crate) fn check(&self, budget: Option<u64>, largest: LargestItem) -> Result<(), RenderError> {
        let LargestItem { bytes, what, instances } = largest;
        match budget {
            Some(budget) if self.peak() > budget => {
                Err(MemoryError { predicted: self.peak(), budget, largest: what, most: bytes }.into())
            }
            _ if instances > MAX_INSTANCES => Err(RenderError::TooManyParts { count: instances, limit: MAX_INSTANCES }),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for MemoryPrediction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { film, textures, geometry, accelerators, building } = *self;
        let [film, textures, geometry, accelerators, building] =
            [film, textures, geometry, accelerators, building].map(ByteSize);
        write!(f, "film {film}, textures {textures}, geometry {geometry}, accelerators {accelerators}, ")?;
        write!(f, "building them {building}: peak {}", ByteSize(self.peak()))
    }
}

/// Bytes of the film and the image, each with its alpha channel.
///
/// Renders pass by pass add pixel accumulators, maps of standard errors and sample counts, and the splats of light paths.
fn film(scene: &Scene, kept: &PerPixel) -> u64 {
    let pixels = u64::from(kept.crop.width) * u64::from(kept.crop.height);
    let image = if kept.transparent { 16 } else { 12 };
    let caustics = scene.settings.integrator == Integrator::Caustics;
    let accumulates = kept.progressive || caustics;
    let estimate = if accumulates { size_of::<PixelEstimate>() as u64 } else { 0 };
    let maps = if accumulates || kept.maps { 2 * 12 } else { 0 };
    let splats = if caustics { SplatImage::memory(1, scene.film.filter) as u64 } else { 0 };
    pixels.saturating_mul(2 * image + estimate + maps + splats)
}

/// Bytes of texture images, shared ones counted once.
fn textures(scene: &Scene) -> u64 {
    let images = scene.appearance.textures.iter().filter_map(Texture::bitmap);
    let unique: HashMap<_, _> = images.map(|bitmap| (Arc::as_ptr(bitmap), bitmap.memory() as u64)).collect();
    let environment = match &scene.appearance.background {
        Background::Environment(light) => light.memory() as u64,
        _ => 0,
    };
    unique.values().sum::<u64>().saturating_add(environment)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_film_is_allocated_after_accelerators_are_built() {
        let prediction = MemoryPrediction { film: 5, textures: 1, geometry: 2, accelerators: 3, building: 7 };
        assert_eq!(prediction.peak(), 13);
        assert_eq!(MemoryPrediction { film: 9, ..prediction }.peak(), 15);
        assert_eq!(MemoryPrediction { film: u64::MAX, ..prediction }.peak(), u64::MAX);
        let expected = "film 5 B, textures 1 B, geometry 2 B, accelerators 3 B, building them 7 B: peak 13 B";
        assert_eq!(prediction.to_string(), expected);
    }

    #[test]
    fn predictions_above_the_budget_are_errors() {
        let prediction = MemoryPrediction { film: 100, ..MemoryPrediction::default() };
        let mut largest = LargestItem::default();
        largest.update(60, || "a".to_owned());
        largest.update(40, || "b".to_owned());
        assert!(
            prediction.check(None, LargestItem::default()).is_ok()
                && prediction.check(Some(100), LargestItem::default()).is_ok()
        );
        let error = prediction.check(Some(99), largest).expect_err("one byte too many");
        let RenderError::Memory(MemoryError { predicted, budget, largest, most }) = error else { panic!("{error}") };
        assert_eq!((predicted, budget, largest.as_str(), most), (100, 99, "a", 60));
    }
}
