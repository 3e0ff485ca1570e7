//! Colours and coefficients in the file.

#[cfg(feature = "schema")]
use schemars::{Schema, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::default_values::{one, yes};
use super::spelling::{self, Spelled};

/// A colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields, remote = "Self")]
#[cfg_attr(feature = "schema", schemars(transform = add_spellings))]
pub enum Color {
    /// Grey: one linear value for red, green and blue.
    ///
    /// Example: `gray(0.5)`.
    #[serde(alias = "grey")]
    Gray(f64),
    /// Linear red, green and blue.
    ///
    /// Example: `rgb(1, 0.5, 0)`.
    Rgb(f64, f64, f64),
    /// A display colour as web pages write it, in sRGB.
    ///
    /// Example: `hex("#ff8000")`.
    Hex(String),
}

/// A colour, or one that varies over the surface with its texture coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields, remote = "Self")]
#[cfg_attr(feature = "schema", schemars(transform = add_spellings))]
pub enum ColorTexture {
    /// Grey: one linear value for red, green and blue.
    ///
    /// Example: `gray(0.5)`.
    #[serde(alias = "grey")]
    Gray(f64),
    /// Linear red, green and blue.
    ///
    /// Example: `rgb(1, 0.5, 0)`.
    Rgb(f64, f64, f64),
    /// A display colour as web pages write it, in sRGB.
    ///
    /// Example: `hex("#ff8000")`.
    Hex(String),
    /// A checkerboard.
    Checker {
        /// Colour of the square at the origin of the texture coordinates.
        ///
        /// Unit: as the whole. Example: `even: 1`.
        even: Color,
        /// Colour of its neighbours.
        ///
        /// Unit: as the whole. Example: `odd: "#c03020"`.
        odd: Color,
        /// Side of a square in texture coordinates.
        ///
        /// Unit: texture coordinates.
        #[serde(default = "one")]
        size: f64,
    },
    /// An image file: PNG, JPEG, HDR or EXR.
    Image {
        /// Path relative to the directory of the scene file.
        ///
        /// Example: `file: "wood.png"`.
        file: String,
        /// Continuation beyond the edges of the image.
        #[serde(default)]
        wrap: Wrap,
        /// Interpolate between pixels rather than take the nearest.
        #[serde(default = "yes")]
        smooth: bool,
        /// Factor for all pixels.
        ///
        /// Unit: factor. Example: `scale: 0.5`.
        #[serde(default = "white")]
        scale: Color,
    },
}

/// Continuation of an image beyond its edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Wrap {
    /// It repeats.
    #[default]
    Repeat,
    /// It repeats, mirrored every other time.
    Mirror,
    /// The edge pixel is repeated.
    Clamp,
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        // The method of the same name that is derived.
        Self::serialize(self, to)
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        spelling::read(from)
    }
}

impl Spelled for Color {
    fn choice<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(from)
    }

    fn from_number(number: f64) -> Option<Self> {
        Some(Self::Gray(number))
    }

    fn from_numbers([r, g, b]: [f64; 3]) -> Option<Self> {
        Some(Self::Rgb(r, g, b))
    }

    fn from_text(text: &str) -> Option<Self> {
        text.starts_with('#').then(|| Self::Hex(text.to_owned()))
    }
}

impl Serialize for ColorTexture {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, to)
    }
}

impl<'de> Deserialize<'de> for ColorTexture {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        spelling::read(from)
    }
}

impl Spelled for ColorTexture {
    fn choice<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(from)
    }

    fn from_number(number: f64) -> Option<Self> {
        Color::from_number(number).map(Self::from)
    }

    fn from_numbers(numbers: [f64; 3]) -> Option<Self> {
        Color::from_numbers(numbers).map(Self::from)
    }

    fn from_text(text: &str) -> Option<Self> {
        Color::from_text(text).map(Self::from)
    }
}

/// Adds the short spellings of a colour to the schema of its choices.
#[cfg(feature = "schema")]
fn add_spellings(schema: &mut Schema) {
    let Some(choices) = schema.get_mut("oneOf").and_then(|choices| choices.as_array_mut()) else { return };
    let short = [
        json_schema!({ "description": "Grey: one linear value for red, green and blue.\n\nExample: `0.5`.", "type": "number" }),
        json_schema!({
            "description": "Linear red, green and blue; in JSON `[1, 0.5, 0]`.\n\nExample: `(1, 0.5, 0)`.",
            "type": "array",
            "items": { "type": "number" },
            "minItems": 3,
            "maxItems": 3,
        }),
        json_schema!({
            "description": "A display colour as web pages write it, in sRGB; `\"#f80\"` for short.\n\nExample: `\"#ff8000\"`.",
            "type": "string",
            "pattern": "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$",
        }),
    ];
    choices.splice(0..0, short.map(|spelling| spelling.to_value()));
}

impl Color {
    /// The colour in its shortest form.
    pub fn from_rgb([r, g, b]: [f64; 3]) -> Self {
        if r == g && g == b { Self::Gray(r) } else { Self::Rgb(r, g, b) }
    }
}

impl From<Color> for ColorTexture {
    fn from(color: Color) -> Self {
        match color {
            Color::Gray(value) => Self::Gray(value),
            Color::Rgb(r, g, b) => Self::Rgb(r, g, b),
            Color::Hex(digits) => Self::Hex(digits),
        }
    }
}

/// Default of fields, as serde calls it.
pub(super) fn white() -> Color {
    Color::Gray(1.0)
}

/// Default of fields, as serde calls it.
pub(super) fn gray<const PERCENT: u8>() -> ColorTexture {
    ColorTexture::Gray(f64::from(PERCENT) / 100.0)
}
