//! Parts of images, and separable filters of them.
//!
//! A filter reads the neighbours of each pixel. An image is therefore cut into tiles, each of which is filtered
//! with a margin of its surroundings. So the memory does not grow with the image.

use core::ops::Range;

/// A part of an image: columns and rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::metrics) struct Tile {
    pub(in crate::metrics) x: Range<u32>,
    pub(in crate::metrics) y: Range<u32>,
}

impl Tile {
    /// Cuts a part of an image into tiles with at most `side` pixels a side.
    pub(in crate::metrics) fn cut(x: Range<u32>, y: Range<u32>, side: u32) -> impl Iterator<Item = Self> {
        let parts = move |range: Range<u32>| {
            let end = range.end;
            range.step_by(side as usize).map(move |start| start..end.min(start.saturating_add(side)))
        };
        parts(y).flat_map(move |y| parts(x.clone()).map(move |x| Self { x, y: y.clone() }))
    }
}

/// Numbers in rows.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::metrics) struct Plane {
    pub(in crate::metrics) width: usize,
    pub(in crate::metrics) values: Vec<f64>,
}

impl Plane {
    /// The numbers of a tile and of `margin` pixels around it, in an image of the given size. Beyond its border, the image
    /// goes on with the nearest pixel.
    pub(in crate::metrics) fn around(
        tile: &Tile,
        margin: u32,
        size: [u32; 2],
        value: impl Fn(u32, u32) -> f64,
    ) -> Self {
        let [columns, rows] = [(&tile.x, size[0]), (&tile.y, size[1])].map(|(range, size)| {
            let (margin, last) = (i64::from(margin), i64::from(size) - 1);
            let range = i64::from(range.start) - margin..i64::from(range.end) + margin;
            range.map(|coordinate| coordinate.clamp(0, last) as u32).collect::<Vec<_>>()
        });
        let values = rows.iter().flat_map(|&y| columns.iter().map(move |&x| [x, y]));
        Self { width: columns.len(), values: values.map(|[x, y]| value(x, y)).collect() }
    }

    /// The plane weighted with `across[i] · down[j]` around each number that has all of its surroundings in the plane. Both
    /// filters have the same odd length `2 · margin + 1`, by `2 · margin` of which the result is narrower and lower.
    pub(in crate::metrics) fn filtered(&self, across: &[f64], down: &[f64]) -> Self {
        let width = self.width + 1 - across.len();
        let mut narrow = Vec::with_capacity(self.values.len());
        for row in self.values.chunks_exact(self.width) {
            narrow.extend(row.windows(across.len()).map(|window| dot(window, across)));
        }
        let height = narrow.len() / width + 1 - down.len();
        let mut values = vec![0.0; width * height];
        for (row, result) in values.chunks_exact_mut(width).enumerate() {
            for (source, &weight) in narrow.chunks_exact(width).skip(row).zip(down) {
                for (sum, value) in result.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
        }
        Self { width, values }
    }

    /// The plane of `f` of each number.
    pub(in crate::metrics) fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self { width: self.width, values: self.values.iter().map(|&value| f(value)).collect() }
    }

    /// The plane of `f` of the numbers of two planes of one size.
    pub(in crate::metrics) fn combined(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(&a, &b)| f(a, b)).collect();
        Self { width: self.width, values }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        let mut seen = [[0; 7]; 5];
        for tile in Tile::cut(1..7, 0..5, 4) {
            for y in tile.y {
                for x in tile.x.clone() {
                    seen[y as usize][x as usize] += 1;
                }
            }
        }
        assert_eq!(seen, [[0, 1, 1, 1, 1, 1, 1]; 5]);
    }

    #[test]
    fn images_go_on_beyond_their_border() {
        let plane = Plane::around(&Tile { x: 0..1, y: 1..2 }, 2, [3, 2], |x, y| f64::from(10 * y + x));
        assert_eq!(plane.width, 5);
        let upper = [0.0, 0.0, 0.0, 1.0, 2.0];
        let lower = [10.0, 10.0, 10.0, 11.0, 12.0];
        assert_eq!(plane.values, [upper, upper, lower, lower, lower].concat());
    }

    #[test]
    fn filters_weigh_columns_and_rows() {
        let tile = Tile { x: 0..4, y: 0..3 };
        let plane = Plane::around(&tile, 1, [4, 3], |x, y| f64::from(x * x + 100 * y));
        let filtered = plane.filtered(&[-1.0, 0.0, 1.0], &[0.0, 1.0, 0.0]);
        assert_eq!((filtered.width, filtered.values.len()), (4, 12));
        assert_eq!(filtered.values[4..8], [1.0, 4.0, 8.0, 5.0]);
        let down = plane.filtered(&[0.0, 1.0, 0.0], &[-1.0, 0.0, 2.0]);
        assert_eq!(down.values[4..8], [400.0, 401.0, 404.0, 409.0]);
    }
}
