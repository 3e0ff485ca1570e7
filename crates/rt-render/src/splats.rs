//! Splats of light paths in integers, so that the sum is independent of their order.

use rt_camera::Filter;
use rt_math::{DVec2, Rgb};

use crate::Crop;

/// Fixed-point scale of radiance: contributions are rounded to 2⁻⁸⁶, so that those of dim lights keep their digits. Sums saturate at 2⁴¹.
const SCALE: f64 = (1u128 << 86) as f64;

/// Contribution to a pixel: its index in the crop, and its radiance in units of 2⁻⁸⁶, never negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Splat {
    pixel: usize,
    light: [i128; 3],
    /// True in a negative lobe of the filter.
    is_negative: bool,
}

/// Image of light paths with saturating sums.
#[derive(Clone, Debug)]
pub(crate) struct SplatImage {
    /// Sums row by row, for positive and negative lobes of the filter; the second is empty if it has none.
    lobes: [Vec<[i128; 3]>; 2],
}

impl SplatImage {
    /// A black image.
    pub(crate) fn new(crop: Crop, filter: Filter) -> Self {
        let pixels = crop.width as usize * crop.height as usize;
        let lobe = |is_there: bool| vec![[0; 3]; if is_there { pixels } else { 0 }];
        Self { lobes: [true, filter.has_negative_lobes()].map(lobe) }
    }

    pub(crate) fn add(&mut self, splat: &Splat) {
        // Saturating sums of non-negative numbers are independent of the order.
        if let Some(sums) = self.lobes[usize::from(splat.is_negative)].get_mut(splat.pixel) {
            sums.iter_mut().zip(splat.light).for_each(|(sum, light)| *sum = sum.saturating_add(light));
        }
    }

    /// Radiance of a pixel, by its index in the crop.
    pub(crate) fn radiance(&self, pixel: usize) -> Rgb {
        let [positive, negative] = &self.lobes;
        let of = |lobe: &Vec<[i128; 3]>| {
            lobe.get(pixel).map_or(Rgb::BLACK, |sums| Rgb::from(sums.map(|sum| sum as f64 / SCALE)))
        };
        of(positive) - of(negative)
    }

    /// True if a sum has reached the bound, so that light is missing from this pixel.
    pub(crate) fn is_saturated(&self, pixel: usize) -> bool {
        self.lobes.iter().filter_map(|lobe| lobe.get(pixel)).flatten().any(|&sum| sum == i128::MAX)
    }

    /// Bytes of an image with this number of pixels.
    pub(crate) const fn memory(pixels: usize, filter: Filter) -> usize {
        pixels * size_of::<[i128; 3]>() * if filter.has_negative_lobes() { 2 } else { 1 }
    }
}

/// Distributes light at a raster position among the pixels of a crop whose filter covers it. Pixel centres
/// lie `offset` from their upper left corners.
pub(crate) fn splat(filter: Filter, crop: Crop, offset: DVec2, raster: DVec2, light: Rgb, mut add: impl FnMut(Splat)) {
    let (radius, centre) = (filter.radius(), raster - offset);
    let rows = within(centre.y, radius, crop.y, crop.height);
    let columns = within(centre.x, radius, crop.x, crop.width);
    for y in rows {
        for x in columns.clone() {
            let weight = filter.value(centre - DVec2::new(f64::from(x), f64::from(y)));
            if weight != 0.0 {
                let pixel = (y - crop.y) as usize * crop.width as usize + (x - crop.x) as usize;
                // The conversion saturates.
                let light = (light * weight.abs()).to_array().map(|c| (c * SCALE).round() as i128);
                add(Splat { pixel, light, is_negative: weight < 0.0 });
            }
        }
    }
}

/// Integers of `first..first + count` within `radius` of `centre`.
fn within(centre: f64, radius: f64, first: u32, count: u32) -> core::ops::Range<u32> {
    let clamped = |x: f64| x.clamp(f64::from(first), f64::from(first + count)) as u32;
    clamped((centre - radius).ceil())..clamped((centre + radius).floor() + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CROP: Crop = Crop { x: 3, y: 5, width: 7, height: 6 };

    fn image_of(filter: Filter, splats: &[(DVec2, Rgb)]) -> SplatImage {
        let mut image = SplatImage::new(CROP, filter);
        for (raster, light) in splats {
            splat(filter, CROP, DVec2::splat(0.5), *raster, *light, |splat| image.add(&splat));
        }
        image
    }

    /// The sum of the filter over pixels is 1 on average.
    #[test]
    fn splats_conserve_energy() {
        for filter in [Filter::Box, Filter::Tent, Filter::Gaussian { sigma: 0.5 }, Filter::Mitchell] {
            // A grid of points in the middle pixel: the support of the filter stays within the crop.
            let grid =
                (0..64).map(|i| DVec2::new(f64::from(i % 8), f64::from(i / 8)) / 8.0 + DVec2::new(6.0625, 7.5625));
            let splats: Vec<_> = grid.map(|raster| (raster, Rgb::new(1.0, 2.0, 4.0))).collect();
            let image = image_of(filter, &splats);
            let sum = (0..42).fold(Rgb::BLACK, |sum, pixel| sum + image.radiance(pixel)) / 64.0;
            assert!((sum.r - 1.0).abs() < 0.01 && (sum.b - 4.0 * sum.r).abs() < 1e-8, "{filter:?}: {sum:?}");
        }
    }

    /// Regression: contributions of light sources of an intensity of 10⁻⁷ were rounded to nothing.
    #[test]
    fn sums_are_in_proportion_to_the_light() {
        let splats = |light: f64| {
            (1..400).map(move |i| (DVec2::new(4.0 + f64::from(i) / 400.0, 6.5), Rgb::gray(light / f64::from(i))))
        };
        let sum = |light: f64| image_of(Filter::Box, &splats(light).collect::<Vec<_>>()).radiance(8).g;
        let (bright, dim) = (sum(1.0), sum(1e-12));
        assert!((1e12 * dim / bright - 1.0).abs() < 1e-9, "{bright}, {dim}");
    }

    #[test]
    fn light_falls_on_its_own_pixel() {
        let image = image_of(Filter::Box, &[(DVec2::new(4.25, 6.75), Rgb::WHITE), (DVec2::new(2.9, 6.0), Rgb::WHITE)]);
        let lit: Vec<_> = (0..42).filter(|pixel| !image.radiance(*pixel).is_black()).collect();
        assert_eq!((lit, image.radiance(8)), (vec![8], Rgb::WHITE));
    }

    #[test]
    fn order_changes_no_bit() {
        let splat = |i: u32| {
            let raster = DVec2::new(f64::from(i % 17) * 0.5 + 3.0, f64::from(i % 13) * 0.5 + 5.0);
            (raster, Rgb::new(1e-3, 0.1, 2e13) * f64::from(i))
        };
        let forwards: Vec<_> = (0..400).map(splat).collect();
        let backwards: Vec<_> = (0..400).rev().map(splat).collect();
        for filter in [Filter::Box, Filter::Mitchell] {
            let (a, b) = (image_of(filter, &forwards), image_of(filter, &backwards));
            assert_eq!(a.lobes, b.lobes);
        }
        let image = image_of(Filter::Box, &forwards);
        assert_eq!(image.radiance(0).b, i128::MAX as f64 / SCALE, "capped");
        assert!(image.is_saturated(0) && !image_of(Filter::Box, &forwards[..1]).is_saturated(0));
    }
}
