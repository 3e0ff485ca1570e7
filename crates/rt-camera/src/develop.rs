//! From linear radiance to bytes.

/// The curve that brings radiance into the displayable range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToneCurve {
    /// Cut at 1.
    Clamp,
    /// `x / (1 + x)` on each component (Reinhard et al. 2002, equation 3).
    Reinhard,
    /// Narkowicz's fit (2015) to the ACES filmic curve.
    Aces,
}

/// How displayable light is encoded in bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoding {
    /// The piecewise sRGB curve (IEC 61966-2-1).
    Srgb,
    /// `x^(1/gamma)`; gamma 1 stores linear light.
    Power(f64),
}

/// Exposure, tone curve and encoding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Exposure in stops: radiance is multiplied by 2^exposure.
    pub exposure: f64,
    /// Tone curve.
    pub tone: ToneCurve,
    /// Encoding.
    pub encoding: Encoding,
}

impl Default for Development {
    fn default() -> Self {
        Self { exposure: 0.0, tone: ToneCurve::Clamp, encoding: Encoding::Srgb }
    }
}
