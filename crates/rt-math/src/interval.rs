//! Closed intervals of the ray parameter.

/// The closed interval `[min, max]` of ray parameters in which a hit counts. Empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Least parameter that counts.
    pub min: f64,
    /// Greatest parameter that counts.
    pub max: f64,
}

impl Interval {
    /// Everything in front of the origin: `[0, ∞]`.
    pub const FORWARD: Self = Self { min: 0.0, max: f64::INFINITY };

    /// From the origin of a shadow ray to its target: `[0, 1]`, as its direction is `target - origin`.
    pub const SEGMENT: Self = Self { min: 0.0, max: 1.0 };

    /// The interval `[min, max]`.
    pub const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// True if `t` lies in the interval; false for NaN.
    pub fn contains(&self, t: f64) -> bool {
        self.min <= t && t <= self.max
    }

    /// The smallest of two ordered candidates (`near <= far`) that lies in the interval.
    ///
    /// Which candidate is chosen depends on `max` only through "is it still in": shrinking `max` never reveals
    /// another hit. The equality of all acceleration structures rests on this.
    pub fn first(&self, near: f64, far: f64) -> Option<f64> {
        let t = if near >= self.min { near } else { far };
        self.contains(t).then_some(t)
    }
}
