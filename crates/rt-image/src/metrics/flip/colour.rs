//! The colour spaces of ꟻLIP and the difference of two colours.

use rt_math::{
    DMat3, DVec3,
    transcendental::{cbrt, pow},
};

use crate::metrics::plane::Plane;

/// Chromaticities (x, y) of the primaries of sRGB.
const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];
/// Luminance of each primary in white of the chromaticity (0.31271, 0.32902), D65.
const LUMINANCES: [f64; 3] = [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0];

/// Exponent of the HyAB distance, q_c.
const EXPONENT: f64 = 0.7;
/// The part p_c of the maximum distance that maps to the part p_t of the range. Greater distances share the rest.
const KNEE: [f64; 2] = [0.4, 0.95];

/// Conversions from linear sRGB, and the maximum difference of two colours.
#[derive(Clone, Debug)]
pub(super) struct ColourSpace {
    /// To XYZ in units of white.
    white_relative_from_rgb: DMat3,
    rgb_from_white_relative: DMat3,
    /// HyAB distance of green from blue, to the power of [`EXPONENT`].
    max: f64,
}

impl ColourSpace {
    pub(super) fn new() -> Self {
        let column = |primary: usize| {
            let ([x, y], luminance) = (PRIMARIES[primary], LUMINANCES[primary]);
            DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance
        };
        let xyz_from_rgb = DMat3::from_cols(column(0), column(1), column(2));
        let white = xyz_from_rgb * DVec3::ONE;
        let white_relative_from_rgb = DMat3::from_diagonal(white.recip()) * xyz_from_rgb;
        let rgb_from_white_relative = white_relative_from_rgb.inverse();
        let mut space = Self { white_relative_from_rgb, rgb_from_white_relative, max: 1.0 };
        let [green, blue] = [DVec3::Y, DVec3::Z].map(|rgb| space.lab_of_rgb(rgb));
        space.max = pow(hyab(green, blue), EXPONENT);
        space
    }

    /// Planes of red, green and blue as planes of the opponent space YCxCz: achromatic, red–green, yellow–blue.
    pub(super) fn opponent(&self, [red, green, blue]: &[Plane; 3]) -> [Plane; 3] {
        let mut opponent = [red.clone(), green.clone(), blue.clone()];
        for index in 0..red.values.len() {
            let rgb = DVec3::new(red.values[index], green.values[index], blue.values[index]);
            let [x, y, z] = (self.white_relative_from_rgb * rgb).to_array();
            let values = [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)];
            for (plane, value) in opponent.iter_mut().zip(values) {
                plane.values[index] = value;
            }
        }
        opponent
    }

    /// Luminance in units of white, of an achromatic component.
    pub(super) fn luminance(achromatic: f64) -> f64 {
        (achromatic + 16.0) / 116.0
    }

    /// CIELAB, adjusted after Hunt, of a colour in YCxCz that is brought into the range of the display.
    pub(super) fn lab(&self, [achromatic, red_green, yellow_blue]: [f64; 3]) -> [f64; 3] {
        let y = Self::luminance(achromatic);
        let white_relative = DVec3::new(y + red_green / 500.0, y, y - yellow_blue / 200.0);
        self.lab_of_rgb((self.rgb_from_white_relative * white_relative).clamp(DVec3::ZERO, DVec3::ONE))
    }

    /// Differences of colour are seen less in the dark (Hunt 1952): `a` and `b` are multiplied by L / 100.
    fn lab_of_rgb(&self, rgb: DVec3) -> [f64; 3] {
        let [x, y, z] = (self.white_relative_from_rgb * rgb).to_array().map(lightness);
        let l = 116.0 * y - 16.0;
        [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
    }

    /// Difference of two colours in [`lab`](Self::lab), between 0 and 1: equations 12 and 13 of the paper.
    pub(super) fn difference(&self, a: [f64; 3], b: [f64; 3]) -> f64 {
        let [part, target] = KNEE;
        let distance = pow(hyab(a, b), EXPONENT) / self.max;
        let difference = if distance < part {
            target / part * distance
        } else {
            target + (distance - part) / (1.0 - part) * (1.0 - target)
        };
        // Of two colours on the border of the display's range, rounding may make more than green and blue.
        difference.min(1.0)
    }
}

/// The distance of Abasi, Amani Tehran and Fairchild 2020: lightness apart from hue and chroma.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [l, x, y] = core::array::from_fn(|component| a[component] - b[component]);
    l.abs() + (x * x + y * y).sqrt()
}

/// The curve of CIELAB: a cube root, with a straight piece near black.
fn lightness(relative: f64) -> f64 {
    const DELTA: f64 = 6.0 / 29.0;
    if relative > DELTA * DELTA * DELTA { cbrt(relative) } else { relative / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_primaries_make_white() {
        let luminance: f64 = LUMINANCES.iter().sum();
        assert!((luminance - 1.0).abs() < 1e-15);
        let space = ColourSpace::new();
        assert!((space.white_relative_from_rgb * DVec3::ONE - DVec3::ONE).abs().max_element() < 1e-15);
        // X and Z of the white, as sums over the primaries.
        let x: f64 = PRIMARIES.iter().zip(LUMINANCES).map(|([x, y], l)| l * x / y).sum();
        let z: f64 = PRIMARIES.iter().zip(LUMINANCES).map(|([x, y], l)| l * (1.0 - x - y) / y).sum();
        assert!((x - 0.31271 / 0.32902).abs() < 1e-7 && (z - (1.0 - 0.31271 - 0.32902) / 0.32902).abs() < 1e-7);
    }

    #[test]
    fn lab_has_its_known_values() {
        let space = ColourSpace::new();
        for (rgb, lab) in [
            (DVec3::ONE, [100.0, 0.0, 0.0]),
            (DVec3::ZERO, [0.0, 0.0, 0.0]),
            (DVec3::splat(0.184_186_5), [50.0, 0.0, 0.0]),
            // Red: L 53.24, a 80.09, b 67.20, before Hunt's adjustment.
            (DVec3::X, [53.24, 0.5324 * 80.09, 0.5324 * 67.20]),
        ] {
            let found = space.lab_of_rgb(rgb);
            assert!(found.iter().zip(lab).all(|(a, b)| (a - b).abs() < 0.02), "{rgb}: {found:?}");
        }
    }

    #[test]
    fn opponent_colours_lead_back_to_their_light() {
        let space = ColourSpace::new();
        let rgb = [0.25, 0.5, 0.125];
        let planes = rgb.map(|value| Plane { width: 1, values: vec![value] });
        let [y, cx, cz] = space.opponent(&planes).map(|plane| plane.values[0]);
        let (there, direct) = (space.lab([y, cx, cz]), space.lab_of_rgb(rgb.into()));
        assert!(there.iter().zip(direct).all(|(a, b)| (a - b).abs() < 1e-12), "{there:?} {direct:?}");
    }

    #[test]
    fn green_and_blue_are_farthest_apart() {
        let space = ColourSpace::new();
        let corners = (0..8u32).map(|bits| space.lab_of_rgb(DVec3::from([0, 1, 2].map(|c| f64::from(bits >> c & 1)))));
        let corners: Vec<_> = corners.collect();
        for (i, &a) in corners.iter().enumerate() {
            for (j, &b) in corners.iter().enumerate() {
                let difference = space.difference(a, b);
                assert_eq!(difference == 1.0, [i, j] == [2, 4] || [i, j] == [4, 2], "{i} {j} {difference}");
                assert_eq!(difference == 0.0, i == j);
            }
        }
    }

    #[test]
    fn the_scale_bends_at_its_knee() {
        let space = ColourSpace::new();
        let at = |part: f64| space.difference([pow(part * space.max, 1.0 / EXPONENT), 0.0, 0.0], [0.0; 3]);
        for (part, difference) in [(0.2, 0.475), (0.4, 0.95), (0.7, 0.975), (1.0, 1.0)] {
            assert!((at(part) - difference).abs() < 1e-12, "{part}: {}", at(part));
        }
    }
}
