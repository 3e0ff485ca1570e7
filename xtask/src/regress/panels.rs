//! Images of differences, for people to look at.

use image::{Rgba, RgbaImage, imageops};

use super::compare::max_difference;

/// Pixels between panels.
const GAP: u32 = 4;
const MARGIN: Rgba<u8> = Rgba([255, 255, 255, 255]);

/// Three panels side by side: expected | difference | actual.
///
/// The difference is black where the images agree; the least difference is lifted to a clear grey. Images of
/// different size are shown without a difference between them.
pub(crate) fn three_panels(expected: &RgbaImage, actual: &RgbaImage) -> RgbaImage {
    let middle = if expected.dimensions() == actual.dimensions() {
        difference(expected, actual)
    } else {
        RgbaImage::from_pixel(expected.width().max(actual.width()), expected.height().max(actual.height()), MARGIN)
    };
    let panels = [expected, &middle, actual];
    let width = panels.iter().map(|panel| panel.width()).sum::<u32>() + 2 * GAP;
    let height = panels.iter().map(|panel| panel.height()).max().unwrap_or(0);
    let mut image = RgbaImage::from_pixel(width, height, MARGIN);
    let mut left = 0;
    for panel in panels {
        imageops::replace(&mut image, panel, i64::from(left), 0);
        left += panel.width() + GAP;
    }
    image
}

fn difference(expected: &RgbaImage, actual: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(expected.width(), expected.height(), |x, y| {
        let lifted = match max_difference(expected.get_pixel(x, y), actual.get_pixel(x, y)) {
            0 => 0,
            by => 64_u8.saturating_add(by.saturating_mul(4)),
        };
        Rgba([lifted, lifted, lifted, 255])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_panel_shows_where_images_differ() {
        let expected = RgbaImage::from_pixel(5, 2, Rgba([9, 9, 9, 255]));
        let mut actual = expected.clone();
        actual.put_pixel(3, 1, Rgba([9, 10, 9, 255]));
        let image = three_panels(&expected, &actual);
        assert_eq!(image.dimensions(), (3 * 5 + 2 * GAP, 2));
        let middle = |x, y| image.get_pixel(5 + GAP + x, y).0[0];
        assert_eq!((middle(3, 1), middle(2, 1), middle(3, 0)), (68, 0, 0));
        assert_eq!(image.get_pixel(2 * (5 + GAP) + 3, 1), &Rgba([9, 10, 9, 255]));
    }

    #[test]
    fn images_of_different_size_stand_side_by_side() {
        let image = three_panels(&RgbaImage::new(2, 3), &RgbaImage::new(4, 1));
        assert_eq!(image.dimensions(), (2 + 4 + 4 + 2 * GAP, 3));
    }
}
