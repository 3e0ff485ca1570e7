//! Reference of the error measurements: a closed form, an image, or the mean of two renders.

use std::path::Path;

use rt_image::metrics::{
    ErrorMap, Flip, ImagePair, PairError, RELATIVE_EPSILON, bias, mean_squared_error, relative_mean_squared_error,
    signed_error,
};
use rt_image::{Development, Encoding, Image, ImageFileError, image_format, read_image};
use rt_scene_io::KnownMean;
use serde::Serialize;

use super::statistics::Repetitions;
use crate::error::CliError;
use crate::image_file;

#[derive(Debug)]
pub(super) enum Reference {
    /// Exact mean radiance.
    KnownMean(KnownMean),
    Image(ReferenceImage),
}

#[derive(Debug)]
pub(super) struct ReferenceImage {
    pub(super) film: Image,
    /// Origin, for the report.
    pub(super) note: String,
    /// Error of the reference itself, if known.
    pub(super) floor: Option<Floor>,
    /// Tone mapping of the renders, if the reference is a .png or .jpg file.
    displayed: Option<Development>,
}

/// Error of a reference: E \[measured\] = error + floor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Floor {
    /// Mean squared error.
    pub(super) mse: f64,
    /// Relative mean squared error.
    pub(super) relative_mse: f64,
    /// Standard error of the mean radiance.
    pub(super) mean_error: f64,
}

/// Errors of one image, including those of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Errors {
    /// Mean squared error over pixels and channels.
    pub(super) mse: f64,
    /// Mean of squared errors divided by (reference² + 0.01).
    pub(super) relative_mse: f64,
    /// Mean signed error.
    pub(super) bias: f64,
}

impl Reference {
    /// Reference from a file, with unknown error.
    pub(super) fn of_file(path: &Path, size: [u32; 2], development: &Development) -> Result<Self, CliError> {
        let film = read_image(path)?;
        let found = [film.width(), film.height()];
        if found != size {
            let source = PairError::Size { test: size, reference: found };
            return Err(CliError::Pair { test: "the render".into(), reference: path.to_owned(), source });
        }
        if !film.pixels().as_flattened().iter().all(|value| value.is_finite()) {
            let reason = "the reference has NaN or infinite pixels".to_owned();
            return Err(ImageFileError::Decode { path: path.to_owned(), reason }.into());
        }
        let displayed = image_file::is_developed(image_format(path)?).then_some(*development);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let kind = if displayed.is_some() { " (tone-mapped; renders are tone-mapped for the comparison)" } else { "" };
        let note = format!("{name}{kind}; its own error is unknown and not subtracted");
        Ok(Self::Image(ReferenceImage { film, note, floor: None, displayed }))
    }

    /// Mean of two independent renders. Their difference estimates its error: `MSE((A + B) / 2) ≈ mean((A − B)²) / 4`, which is the
    /// mean squared distance of a render from the mean of both.
    pub(super) fn of_halves(a: &Image, b: &Image, note: String) -> Result<Self, PairError> {
        let mut film = Image::new(a.width(), a.height(), false);
        for ((mean, a), b) in film.pixels_mut().iter_mut().zip(a.pixels()).zip(b.pixels()) {
            *mean = core::array::from_fn(|channel| 0.5 * (a[channel] + b[channel]));
        }
        let halves = ImagePair::new(a, &film)?;
        let floor = Floor {
            mse: mean_squared_error(&halves).mean(),
            relative_mse: relative_mean_squared_error(&halves).mean(),
            mean_error: bias(&halves).all.standard_error,
        };
        Ok(Self::Image(ReferenceImage { film, note, floor: Some(floor), displayed: None }))
    }

    pub(super) fn measure(&self, film: &Image) -> Result<Errors, PairError> {
        match self {
            Self::KnownMean(truth) => Ok(errors_of_mean(film, truth)),
            Self::Image(reference) => {
                let developed = reference.developed(film);
                let pair = ImagePair::new(developed.as_ref().unwrap_or(film), &reference.film)?;
                Ok(Errors {
                    mse: mean_squared_error(&pair).mean(),
                    relative_mse: relative_mean_squared_error(&pair).mean(),
                    bias: bias(&pair).all.mean,
                })
            }
        }
    }

    /// Error of the reference itself, if known; a closed form has none.
    pub(super) fn floor(&self) -> Option<Floor> {
        match self {
            Self::KnownMean(_) => None,
            Self::Image(reference) => reference.floor,
        }
    }

    /// Squared error of rounding to `f32`, the precision of images.
    pub(super) fn resolution(&self) -> f64 {
        let rounding = f64::from(f32::EPSILON) / 2.0;
        let squares: f64 = match self {
            Self::KnownMean(truth) => truth.mean.to_array().map(|value| value * value).iter().sum::<f64>() / 3.0,
            Self::Image(reference) => {
                let values = reference.film.pixels().as_flattened();
                values.iter().map(|&value| f64::from(value) * f64::from(value)).sum::<f64>() / values.len() as f64
            }
        };
        squares * rounding * rounding
    }

    /// Combination of the errors of the seeds.
    pub(super) const fn repetitions(&self) -> Repetitions {
        match self {
            Self::KnownMean(_) => Repetitions::Together,
            Self::Image(_) => Repetitions::Each,
        }
    }

    pub(super) fn image(&self) -> Option<&ReferenceImage> {
        match self {
            Self::KnownMean(_) => None,
            Self::Image(reference) => Some(reference),
        }
    }
}

impl ReferenceImage {
    /// Mean ꟻLIP.
    pub(super) fn flip(&self, film: &Image, development: &Development) -> Result<f64, PairError> {
        let developed = self.developed(film);
        let pair = ImagePair::new(developed.as_ref().unwrap_or(film), &self.film)?;
        let shown = if self.displayed.is_some() { Development::default() } else { *development };
        Ok(Flip::default().ldr(&pair, &shown).mean())
    }

    pub(super) fn error_map(&self, film: &Image) -> Result<ErrorMap, PairError> {
        let developed = self.developed(film);
        Ok(signed_error(&ImagePair::new(developed.as_ref().unwrap_or(film), &self.film)?))
    }

    /// Tone mapping of the reference for display.
    pub(super) fn development(&self, of_images: &Development) -> Development {
        if self.displayed.is_some() { Development::default() } else { *of_images }
    }

    /// Image as stored in bytes, if the reference is.
    fn developed(&self, film: &Image) -> Option<Image> {
        self.displayed.map(|development| development.develop_over_black(film).decode(Encoding::Srgb))
    }
}

fn errors_of_mean(film: &Image, truth: &KnownMean) -> Errors {
    let mut sum = [0.0; 3];
    for pixel in film.pixels() {
        for (sum, &value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(value);
        }
    }
    let count = film.pixels().len() as f64;
    let truth = truth.mean.to_array();
    let error: [f64; 3] = core::array::from_fn(|channel| sum[channel] / count - truth[channel]);
    let mean = |of: fn(f64, f64) -> f64| error.iter().zip(truth).map(|(&e, r)| of(e, r)).sum::<f64>() / 3.0;
    Errors {
        mse: mean(|e, _| e * e),
        relative_mse: mean(|e, r| e * e / (r * r + RELATIVE_EPSILON)),
        bias: mean(|e, _| e),
    }
}

#[cfg(test)]
mod tests {
    use rt_math::Rgb;
    use rt_math::random::{hash, unit};

    use super::*;

    /// Gray image with uniform noise of mean square `amplitude² / 3`.
    fn noisy(amplitude: f64, seed: u64) -> Image {
        let mut film = Image::new(100, 100, false);
        for (index, value) in (0..).zip(film.pixels_mut().as_flattened_mut()) {
            *value = (0.5 + amplitude * (2.0 * unit(hash(&[seed, index])) - 1.0)) as f32;
        }
        film
    }

    #[test]
    fn the_halves_of_a_reference_estimate_its_error() {
        let (a, b) = (noisy(0.2, 1), noisy(0.2, 2));
        let reference = Reference::of_halves(&a, &b, String::new()).expect("alike");
        let floor = reference.floor().expect("known");
        let expected = 0.2 * 0.2 / 3.0 / 2.0;
        assert!((floor.mse / expected - 1.0).abs() < 0.03, "{floor:?}");
        assert!((floor.relative_mse / (expected / 0.26) - 1.0).abs() < 0.1, "{floor:?}");
        // Compare the estimate with the true error.
        let film = &reference.image().expect("an image").film;
        let mut grey = Image::new(100, 100, false);
        grey.pixels_mut().fill([0.5; 3]);
        let real = mean_squared_error(&ImagePair::new(film, &grey).expect("alike")).mean();
        assert!((floor.mse / real - 1.0).abs() < 0.05, "{} {real}", floor.mse);
    }

    #[test]
    fn measured_errors_include_the_floor() {
        let reference = Reference::of_halves(&noisy(0.2, 1), &noisy(0.2, 2), String::new()).expect("alike");
        let errors = reference.measure(&noisy(0.3, 3)).expect("alike");
        let subtracted = errors.mse - reference.floor().expect("known").mse;
        assert!((subtracted / (0.3 * 0.3 / 3.0) - 1.0).abs() < 0.03, "{subtracted}");
        let error = reference.floor().expect("known").mean_error;
        assert!(errors.bias.abs() < 4.0 * (error + 0.3 / 300.0), "{errors:?} {error}");
    }

    #[test]
    fn a_truth_is_of_the_mean_over_the_image() {
        let mut film = Image::new(2, 1, false);
        film.pixels_mut().copy_from_slice(&[[1.0, 0.0, 0.0], [3.0, 0.0, 0.5]]);
        let truth = KnownMean { mean: Rgb::new(1.5, 0.0, 0.0), note: String::new(), size: [1; 2] };
        let errors = Reference::KnownMean(truth).measure(&film).expect("any");
        let expected = Errors {
            mse: (0.25 + 0.0625) / 3.0,
            relative_mse: (0.25 / 2.26 + 0.0625 / 0.01) / 3.0,
            bias: (0.5 + 0.25) / 3.0,
        };
        assert!((errors.relative_mse - expected.relative_mse).abs() < 1e-15, "{errors:?}");
        assert_eq!((errors.mse, errors.bias), (expected.mse, expected.bias));
    }
}
