//! Tone curves and encodings.

use rt_math::transcendental::pow;

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

impl ToneCurve {
    /// Displayable light in [0, 1] for exposed light: non-decreasing; negative light and NaN give 0.
    pub fn apply(self, light: f64) -> f64 {
        if light.is_nan() {
            return 0.0;
        }
        // The upper limit keeps the quotients from becoming ∞/∞; both curves round to their limit long before it.
        let x = light.clamp(0.0, 1e100);
        let displayed = match self {
            Self::Clamp => x,
            Self::Reinhard => x / (1.0 + x),
            Self::Aces => (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14),
        };
        displayed.min(1.0)
    }
}

/// Encoding of displayable light in bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoding {
    /// The piecewise sRGB curve (IEC 61966-2-1).
    Srgb,
    /// `x^(1/gamma)`; gamma 1 stores linear light.
    Power(f64),
}

impl Encoding {
    /// Signal in [0, 1] of displayable light in [0, 1].
    pub fn encode(self, light: f64) -> f64 {
        match self {
            Self::Srgb if light <= 0.0031308 => 12.92 * light,
            Self::Srgb => 1.055 * pow(light, 1.0 / 2.4) - 0.055,
            Self::Power(gamma) => pow(light, 1.0 / gamma),
        }
    }

    /// Linear light in [0, 1] of a signal in [0, 1].
    pub fn decode_signal(self, signal: f64) -> f64 {
        match self {
            Self::Srgb if signal <= 0.04045 => signal / 12.92,
            Self::Srgb => pow((signal + 0.055) / 1.055, 2.4),
            Self::Power(gamma) => pow(signal, gamma),
        }
    }

    /// Linear light in [0, 1] of a byte.
    pub fn decode(self, byte: u8) -> f32 {
        self.decode_signal(f64::from(byte) / 255.0) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tone_curves_have_their_known_values() {
        for (tone, light, expected) in [
            (ToneCurve::Clamp, 0.25, 0.25),
            (ToneCurve::Clamp, 7.0, 1.0),
            (ToneCurve::Reinhard, 1.0, 0.5),
            (ToneCurve::Reinhard, 3.0, 0.75),
            (ToneCurve::Reinhard, f64::INFINITY, 1.0),
            (ToneCurve::Aces, 0.0, 0.0),
            (ToneCurve::Aces, 1.0, 2.54 / 3.16),
            (ToneCurve::Aces, 0.18, 0.266_898),
            (ToneCurve::Aces, f64::INFINITY, 1.0),
        ] {
            assert!((tone.apply(light) - expected).abs() < 1e-6, "{tone:?}({light}) = {}", tone.apply(light));
        }
    }
}
