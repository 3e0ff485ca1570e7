//! Errors as colours.

use super::ErrorMap;
use crate::{Bitmap8, Encoding, Image};

/// Colours of an [`ErrorMap`] between two limits, beyond which the colour stays the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourScale {
    /// From `−limit` (blue: too dark) over 0 (white) to `limit` (red: too bright). Five colours of ColorBrewer's RdBu
    /// (Harrower and Brewer 2003), interpolated linearly in sRGB.
    Signed,
    /// From 0 (black) over violet and orange to `limit` (pale yellow). Nine colours of magma (Smith and van der Walt
    /// 2015), interpolated linearly in sRGB.
    Magnitude,
}

/// Bytes from the least value to the greatest.
const BLUE_WHITE_RED: [[u8; 3]; 5] = [[5, 113, 176], [146, 197, 222], [247, 247, 247], [244, 165, 130], [202, 0, 32]];
const MAGMA: [[u8; 3]; 9] = [
    [0, 0, 4],
    [29, 17, 71],
    [81, 18, 124],
    [130, 38, 129],
    [182, 54, 121],
    [230, 81, 100],
    [251, 136, 97],
    [254, 194, 135],
    [252, 253, 191],
];

impl ColourScale {
    /// The colour, in sRGB bytes, of pixels without an error: green, which neither scale has.
    pub const MISSING: [u8; 3] = [0, 255, 0];

    /// The sRGB bytes of an error. A limit that is not positive shows the sign only.
    pub fn colour(self, error: f64, limit: f64) -> [u8; 3] {
        if error.is_nan() {
            return Self::MISSING;
        }
        let part = if error == 0.0 { 0.0 } else { error / limit.max(0.0) };
        match self {
            Self::Signed => between(&BLUE_WHITE_RED, 0.5 + 0.5 * part),
            Self::Magnitude => between(&MAGMA, part),
        }
    }
}

/// The colour at a part of the way from the first to the last.
fn between(colours: &[[u8; 3]], part: f64) -> [u8; 3] {
    let position = part.clamp(0.0, 1.0) * (colours.len() - 1) as f64;
    let index = (position as usize).min(colours.len() - 2);
    let fraction = position - index as f64;
    core::array::from_fn(|channel| {
        let [low, high] = [colours[index], colours[index + 1]].map(|colour| f64::from(colour[channel]));
        (low + fraction * (high - low)).round() as u8
    })
}

/// An image of the errors, which the standard [`Development`](crate::Development) brings to the bytes of
/// [`ColourScale::colour`].
pub fn heat_map(map: &ErrorMap, scale: ColourScale, limit: f64) -> Image {
    let bytes = map.values().iter().flat_map(|&error| scale.colour(f64::from(error), limit)).collect();
    Bitmap8 { width: map.width(), height: map.height(), channels: 3, bytes }.decode(Encoding::Srgb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{ImagePair, signed_error};
    use crate::{Development, test_images::film};

    #[test]
    fn scales_run_from_end_to_end() {
        let signed = |error: f64| ColourScale::Signed.colour(error, 2.0);
        assert_eq!(
            [-9.0, -2.0, 0.0, 2.0, f64::INFINITY].map(signed),
            [[5, 113, 176], [5, 113, 176], [247, 247, 247], [202, 0, 32], [202, 0, 32]]
        );
        assert_eq!(signed(0.5), [246, 206, 189]);
        let magnitude = |error: f64| ColourScale::Magnitude.colour(error, 1.0);
        assert_eq!([0.0, 0.5, 1.0, 2.0].map(magnitude), [[0, 0, 4], [182, 54, 121], [252, 253, 191], [252, 253, 191]]);
        assert_eq!(magnitude(f64::NAN), ColourScale::MISSING);
    }

    #[test]
    fn without_a_limit_the_sign_is_shown() {
        let signed = |error: f64| ColourScale::Signed.colour(error, 0.0);
        assert_eq!([-1e-300, 0.0, 1e-300].map(signed), [[5, 113, 176], [247, 247, 247], [202, 0, 32]]);
    }

    #[test]
    fn developed_maps_have_the_colours_of_the_scale() {
        let test = film(3, 1, &[[0.0, -1.0, 0.0], [0.0; 3], [f32::NAN; 3]]);
        let reference = film(3, 1, &[[0.0; 3]; 3]);
        let map = signed_error(&ImagePair::new(&test, &reference).expect("alike"));
        let bitmap = Development::default().develop(&heat_map(&map, ColourScale::Signed, 1.0));
        assert_eq!(bitmap.bytes, [5, 113, 176, 247, 247, 247, 0, 255, 0]);
    }
}
