//! Closed intervals of the ray parameter.

/// The closed interval `[min, max]` of ray parameters in which a hit counts. Empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Minimum parameter.
    pub min: f64,
    /// Maximum parameter.
    pub max: f64,
}

impl Interval {
    /// All parameters from the origin on: `[0, ∞]`.
    pub const FORWARD: Self = Self { min: 0.0, max: f64::INFINITY };

    /// All parameters in front of the origin of a spawned ray, from 2⁻⁹⁷⁰ on.
    ///
    /// The least is not 0. Its products with numbers from 2⁻⁵² on are not subnormal: one that is takes a hundred cycles on
    /// Intel processors.
    pub const SPAWNED: Self = Self { min: f64::MIN_POSITIVE / f64::EPSILON, max: f64::INFINITY };

    /// From the origin of a shadow ray to its target: up to 1, as its direction is `target - origin`, and otherwise as
    /// [`SPAWNED`](Self::SPAWNED).
    pub const SEGMENT: Self = Self { max: 1.0, ..Self::SPAWNED };

    /// The interval `[min, max]`.
    #[inline]
    pub const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// True if `t` lies in the interval; false for NaN.
    #[inline]
    pub fn contains(&self, t: f64) -> bool {
        self.min <= t && t <= self.max
    }

    /// The smallest of two ordered candidates (`near <= far`) that lies in the interval.
    ///
    /// `max` only decides if the chosen candidate is still in the interval: shrinking it never reveals another hit. The
    /// equality of all accelerators depends on this.
    #[inline]
    pub fn first(&self, near: f64, far: f64) -> Option<f64> {
        let t = if near >= self.min { near } else { far };
        self.contains(t).then_some(t)
    }
}
