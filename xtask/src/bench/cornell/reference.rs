//! The image that errors are measured against.

use rt_image::Image;

/// Radiance above which a pixel sees the light.
const LIGHT: f32 = 1.0;
/// Added to squared radiance, so that relative errors of black pixels are finite.
const DARK: f64 = 0.01;

/// Reference image. Pixels that see the light are left out with their neighbours: their error would be that of its
/// edge.
#[derive(Debug)]
pub(super) struct ReferenceImage {
    reference: Image,
    is_kept: Vec<bool>,
    /// The mean squared error of the reference itself.
    variance: f64,
}

/// Errors of an image, over all channels of the pixels that are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    /// Without the reference's own; it may be negative if the image is as good.
    pub mse: f64,
    /// The mean of squared errors by the squared reference + 0.01.
    pub relative_mse: f64,
    /// The image's mean by that of the reference.
    pub mean_ratio: f64,
}

impl ReferenceImage {
    /// `noise` is the root of the mean squared error of the reference itself.
    pub(super) fn new(reference: Image, noise: f64) -> Self {
        let (width, height) = (reference.width(), reference.height());
        let is_light = |x: u32, y: u32| reference.pixel(x, y).is_some_and(|rgb| rgb.max_component() > f64::from(LIGHT));
        let near = |x: u32, end: u32| x.saturating_sub(1)..(x + 2).min(end);
        let sees_light = |x: u32, y: u32| near(y, height).any(|y| near(x, width).any(|x| is_light(x, y)));
        let is_kept =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| !sees_light(x, y)).collect();
        Self { reference, is_kept, variance: noise * noise }
    }

    /// `None` if the image has another size, or nothing is kept.
    pub(super) fn measure(&self, image: &Image) -> Option<Errors> {
        let reference = &self.reference;
        if (image.width(), image.height()) != (reference.width(), reference.height()) {
            return None;
        }
        let (mut count, mut squares, mut relative, mut sum, mut reference_sum) = (0_u32, 0.0, 0.0, 0.0, 0.0);
        let pairs = image.pixels().iter().zip(reference.pixels()).zip(&self.is_kept).filter(|(_, is_kept)| **is_kept);
        for (value, truth) in pairs.flat_map(|((pixel, truth), _)| pixel.iter().zip(truth)) {
            let (value, truth) = (f64::from(*value), f64::from(*truth));
            let square = (value - truth) * (value - truth) - self.variance;
            count += 1;
            squares += square;
            relative += square / (truth * truth + DARK);
            sum += value;
            reference_sum += truth;
        }
        let count = f64::from(count);
        (count > 0.0).then(|| Errors {
            mse: squares / count,
            relative_mse: relative / count,
            mean_ratio: sum / reference_sum,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grey image with a bright light at one pixel, if any.
    fn grey(width: u32, height: u32, level: f32, lamp: Option<usize>) -> Image {
        let mut film = Image::new(width, height, false);
        film.pixels_mut().fill([level; 3]);
        if let Some(index) = lamp {
            film.pixels_mut()[index] = [0.0, 2.0, 0.0];
        }
        film
    }

    #[test]
    fn the_lamp_and_its_neighbours_are_left_out() {
        let reference = ReferenceImage::new(grey(5, 4, 0.5, Some(6)), 0.0);
        let kept: Vec<u8> = reference.is_kept.iter().map(|&is_kept| u8::from(is_kept)).collect();
        assert_eq!(kept, [0, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1]);
        let mut image = grey(5, 4, 0.5, None);
        image.pixels_mut()[12] = [9.0; 3];
        assert_eq!(reference.measure(&image), Some(Errors { mse: 0.0, relative_mse: 0.0, mean_ratio: 1.0 }));
    }

    #[test]
    fn errors_are_means_without_the_noise_of_the_reference() {
        let reference = ReferenceImage::new(grey(2, 2, 0.5, None), 0.25);
        let mut image = grey(2, 2, 0.5, None);
        image.pixels_mut()[0] = [1.0, 0.5, 0.5];
        let errors = reference.measure(&image).unwrap();
        let mse = 0.25 / 12.0 - 0.0625;
        assert!((errors.mse - mse).abs() < 1e-15 && (errors.relative_mse - mse / 0.26).abs() < 1e-14, "{errors:?}");
        assert!((errors.mean_ratio - 6.5 / 6.0).abs() < 1e-15, "{errors:?}");
    }

    #[test]
    fn other_sizes_and_lamps_alone_have_no_error() {
        assert_eq!(ReferenceImage::new(grey(2, 2, 0.5, None), 0.0).measure(&grey(4, 1, 0.5, None)), None);
        assert_eq!(ReferenceImage::new(grey(2, 2, 0.5, Some(0)), 0.0).measure(&grey(2, 2, 0.5, None)), None);
    }
}
