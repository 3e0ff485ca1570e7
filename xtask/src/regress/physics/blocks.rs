//! Means over blocks of pixels, by which two renderers are compared.

use rt_image::Image;

/// Means over square blocks of pixels; those at the right and lower edge may be smaller.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Blocks {
    pub rows: usize,
    pub columns: usize,
    /// By row, column and channel.
    pub means: Vec<f64>,
    /// Brightest channel of a pixel.
    pub brightest: f64,
}

impl Blocks {
    /// Blocks of `side`×`side` pixels of an image of this width.
    pub(super) fn of(pixels: &[[f32; 3]], width: usize, side: usize) -> Self {
        let height = pixels.len().checked_div(width).unwrap_or(0);
        let (width_in_blocks, height_in_blocks) = (width.div_ceil(side.max(1)), height.div_ceil(side.max(1)));
        let mut sums = vec![[0.0; 3]; width_in_blocks * height_in_blocks];
        let mut counts = vec![0_u32; sums.len()];
        for (index, pixel) in pixels.iter().enumerate() {
            let block = index / width / side * width_in_blocks + index % width / side;
            counts[block] += 1;
            for (sum, value) in sums[block].iter_mut().zip(pixel) {
                *sum += f64::from(*value);
            }
        }
        let means = sums.iter().zip(&counts).flat_map(|(sum, count)| sum.map(|sum| sum / f64::from(*count)));
        let brightest = pixels.iter().flatten().fold(0.0, |most: f64, value| most.max(f64::from(*value)));
        Self { rows: height_in_blocks, columns: width_in_blocks, means: means.collect(), brightest }
    }

    pub(super) fn of_film(film: &Image, side: usize) -> Self {
        Self::of(film.pixels(), film.width() as usize, side)
    }

    pub(super) fn image_mean(&self, channel: usize) -> f64 {
        self.means.iter().skip(channel).step_by(3).sum::<f64>() / (self.rows * self.columns) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_go_by_rows_and_the_rest_is_smaller() {
        let pixels: Vec<[f32; 3]> = (0_u8..15).map(|i| [f32::from(i), 1.0, 0.0]).collect();
        let blocks = Blocks::of(&pixels, 5, 2);
        assert_eq!((blocks.rows, blocks.columns, blocks.brightest), (2, 3, 14.0));
        let red: Vec<f64> = blocks.means.iter().step_by(3).copied().collect();
        assert_eq!(red, [3.0, 5.0, 6.5, 10.5, 12.5, 14.0]);
        assert_eq!([0, 1, 2].map(|channel| blocks.image_mean(channel)), [51.5 / 6.0, 1.0, 0.0]);
    }
}
