//! Linear colour.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

/// Linear light in the primaries of Rec. 709 / sRGB: radiance, or a dimensionless reflectance.
///
/// Linear until the film is developed. Components may be negative or infinite; nothing is clamped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

impl Rgb {
    /// No light.
    pub const BLACK: Self = Self::gray(0.0);
    /// One unit of each component.
    pub const WHITE: Self = Self::gray(1.0);

    /// A colour from its components.
    #[inline]
    pub const fn new(r: f64, g: f64, b: f64) -> Self {
        Self { r, g, b }
    }

    /// Gray: `value` in all components.
    #[inline]
    pub const fn gray(value: f64) -> Self {
        Self::new(value, value, value)
    }

    /// The components in order.
    #[inline]
    pub const fn to_array(self) -> [f64; 3] {
        [self.r, self.g, self.b]
    }

    /// Applies `f` to each component.
    #[inline]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self::new(f(self.r), f(self.g), f(self.b))
    }

    /// Relative luminance (Rec. 709 weights).
    pub fn luminance(self) -> f64 {
        0.2126 * self.r + 0.7152 * self.g + 0.0722 * self.b
    }

    /// Maximum component.
    #[inline]
    pub fn max_component(self) -> f64 {
        self.r.max(self.g).max(self.b)
    }

    /// True if all components are zero.
    #[inline]
    pub fn is_black(self) -> bool {
        self == Self::BLACK
    }

    /// True if no component is NaN or infinite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// `(1 - f) · self + f · other`.
    pub fn lerp(self, other: Self, f: f64) -> Self {
        self * (1.0 - f) + other * f
    }
}

impl From<[f64; 3]> for Rgb {
    #[inline]
    fn from([r, g, b]: [f64; 3]) -> Self {
        Self::new(r, g, b)
    }
}

impl Add for Rgb {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl AddAssign for Rgb {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Rgb {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self::new(self.r - o.r, self.g - o.g, self.b - o.b)
    }
}

impl Mul for Rgb {
    type Output = Self;
    /// Component by component: light filtered by a surface.
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl MulAssign for Rgb {
    #[inline]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, s: f64) -> Self {
        Self::new(self.r * s, self.g * s, self.b * s)
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    #[inline]
    fn div(self, s: f64) -> Self {
        Self::new(self.r / s, self.g / s, self.b / s)
    }
}
