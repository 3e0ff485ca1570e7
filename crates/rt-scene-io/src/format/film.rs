//! The image in the file.

use serde::{Deserialize, Serialize};

/// The image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Film {
    /// Width and height in pixels.
    ///
    /// Unit: pixels.
    pub size: (u64, u64),
    /// Point of the pixel on which samples are centred: (0.5, 0.5) is its middle, (0, 0) its upper left corner.
    ///
    /// Unit: pixels.
    pub sample_offset: [f64; 2],
    /// Reconstruction filter of the samples around a pixel.
    ///
    /// Example: `filter: mitchell`.
    pub filter: Filter,
    /// Exposure in stops: 1 doubles the brightness.
    ///
    /// Unit: stops. Example: `exposure: 1`.
    pub exposure: f64,
    /// Tone curve that brings bright light into the range of the display.
    ///
    /// Example: `tone: aces`.
    pub tone: Tone,
    /// Encoding of light in the bytes of the image.
    ///
    /// Example: `encoding: gamma(2.2)`.
    pub encoding: Encoding,
    /// Dither colours where they become bytes, so that gradients show no bands.
    pub dither: bool,
}

impl Default for Film {
    fn default() -> Self {
        Self {
            size: (640, 480),
            sample_offset: [0.5; 2],
            filter: Filter::Box,
            exposure: 0.0,
            tone: Tone::Clamp,
            encoding: Encoding::Srgb,
            dither: true,
        }
    }
}

/// Reconstruction filter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Filter {
    /// The pixel's own square.
    Box,
    /// A pyramid two pixels wide.
    Tent,
    /// A bell of this standard deviation in pixels.
    Gaussian(f64),
    /// Mitchell and Netravali's cubic, four pixels wide: sharp, with negative lobes. Passes of less than four samples blur it.
    Mitchell,
}

/// Tone curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// Cut at 1.
    Clamp,
    /// `x / (1 + x)`.
    Reinhard,
    /// A filmic curve.
    Aces,
}

/// Encoding of displayable light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// The sRGB curve.
    Srgb,
    /// A power law with the exponent 1/γ; `gamma(1)` stores linear light.
    ///
    /// Example: `gamma(2.2)`.
    Gamma(f64),
}
