//! Colours and coefficients in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Color {
    /// The same value for red, green and blue: `gray(0.5)`. Linear.
    #[serde(alias = "grey")]
    Gray(f64),
    /// Linear red, green and blue: `rgb(1, 0.5, 0)`.
    Rgb(f64, f64, f64),
    /// A display colour as web pages write it: `hex("#ff8000")`.
    Hex(String),
}

/// A colour, or one that varies over the surface with its texture coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Coefficient {
    /// The same value for red, green and blue: `gray(0.5)`. Linear.
    #[serde(alias = "grey")]
    Gray(f64),
    /// Linear red, green and blue: `rgb(1, 0.5, 0)`.
    Rgb(f64, f64, f64),
    /// A display colour as web pages write it: `hex("#ff8000")`.
    Hex(String),
    /// A checkerboard.
    Checker {
        /// Colour of the square at the origin of the texture coordinates.
        even: Color,
        /// Colour of its neighbours.
        odd: Color,
        /// Side of a square in texture coordinates.
        #[serde(default = "one")]
        size: f64,
    },
    /// An image file: PNG, JPEG, HDR or EXR.
    Image {
        /// Path relative to the folder of the scene file.
        file: String,
        /// Beyond the edges of the image.
        #[serde(default)]
        wrap: Wrap,
        /// Interpolate between pixels rather than take the nearest.
        #[serde(default = "yes")]
        smooth: bool,
        /// Factor for all pixels.
        #[serde(default = "white")]
        scale: Color,
    },
}

/// What happens beyond the edge of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wrap {
    /// It repeats.
    #[default]
    Repeat,
    /// It repeats, mirrored every other time.
    Mirror,
    /// The edge goes on.
    Clamp,
}

impl Color {
    /// The colour in its shortest form.
    pub fn from_rgb([r, g, b]: [f64; 3]) -> Self {
        if r == g && g == b { Self::Gray(r) } else { Self::Rgb(r, g, b) }
    }
}

impl From<Color> for Coefficient {
    fn from(color: Color) -> Self {
        match color {
            Color::Gray(value) => Self::Gray(value),
            Color::Rgb(r, g, b) => Self::Rgb(r, g, b),
            Color::Hex(digits) => Self::Hex(digits),
        }
    }
}

fn one() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

fn white() -> Color {
    Color::Gray(1.0)
}
