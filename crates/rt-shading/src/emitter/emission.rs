//! What leaves the surface of a light, and what can be wrong with a light.

use rt_geometry::ShapeError;
use rt_math::{Rgb, TransformError};
use std::f64::consts::PI;

/// Largest component of a radiance: sums over images and areas stay far from overflow.
const MAX_RADIANCE: f64 = 1e100;

/// Which sides of a surface shine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// The side that the normal points to: outside of closed shapes.
    Front,
    /// Both.
    Both,
}

/// Light that leaves every point of a surface with the same radiance in all directions: a Lambertian emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    radiance: Rgb,
    sides: Sides,
}

impl Emission {
    /// Emission of `radiance` (power per unit area and solid angle).
    ///
    /// # Errors
    /// If a component is NaN, negative, or beyond 1e100. Black is a light that gives nothing.
    pub fn new(radiance: Rgb, sides: Sides) -> Result<Self, EmitterError> {
        check_radiance(radiance)?;
        Ok(Self { radiance, sides })
    }

    /// The radiance of a side that shines.
    pub const fn radiance(&self) -> Rgb {
        self.radiance
    }

    /// Which sides shine.
    pub const fn sides(&self) -> Sides {
        self.sides
    }

    /// What is seen by looking along a direction whose product with the normal is `along_normal`: only its sign counts.
    /// Negative is towards the front. Black from behind a one-sided light, exactly edge-on, and for NaN.
    #[inline]
    pub fn seen(&self, along_normal: f64) -> Rgb {
        let shines = match self.sides {
            Sides::Front => along_normal < 0.0,
            Sides::Both => along_normal != 0.0 && !along_normal.is_nan(),
        };
        if shines { self.radiance } else { Rgb::BLACK }
    }

    /// Power of a surface of the given area: π · A · L for each side that shines.
    pub fn power(&self, area: f64) -> Rgb {
        let sides = match self.sides {
            Sides::Front => 1.0,
            Sides::Both => 2.0,
        };
        self.radiance * (sides * PI * area)
    }
}

/// Checks that a radiance can be summed and sampled.
pub(super) fn check_radiance(radiance: Rgb) -> Result<(), EmitterError> {
    let is_usable = |x: f64| (0.0..=MAX_RADIANCE).contains(&x);
    if radiance.to_array().into_iter().all(is_usable) { Ok(()) } else { Err(EmitterError::BadRadiance(radiance)) }
}

/// Why a light cannot be made. Each variant holds the offending value.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EmitterError {
    /// A radiance that is not a number, negative, or too great to be summed.
    #[error("radiance {0:?} must have components from 0 to 1e100")]
    BadRadiance(Rgb),
    /// A pixel of an image whose radiance cannot be used.
    #[error("pixel ({column}, {row}) has the radiance {radiance:?}; components must be from 0 to 1e100")]
    BadPixel {
        /// Column, from the left.
        column: usize,
        /// Row, from the top.
        row: usize,
        /// What it holds.
        radiance: Rgb,
    },
    /// An image without pixels, or with another number of them than its size says.
    #[error("an image of {width}×{height} pixels cannot have {pixels} of them")]
    BadImage {
        /// Pixels from left to right.
        width: usize,
        /// Pixels from top to bottom.
        height: usize,
        /// How many pixels there are.
        pixels: usize,
    },
    /// An area that is zero or not finite, so that there is nothing to sample.
    #[error("the area {0} of the light must be positive")]
    BadArea(f64),
    /// A shape that cannot be made.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A rotation that cannot be made.
    #[error(transparent)]
    Rotation(#[from] TransformError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_that_do_not_shine_are_black() {
        let front = Emission::new(Rgb::WHITE, Sides::Front).expect("an emission");
        let both = Emission::new(Rgb::WHITE, Sides::Both).expect("an emission");
        for (along_normal, from_front, from_any) in
            [(-1e-300, 1.0, 1.0), (0.5, 0.0, 1.0), (0.0, 0.0, 0.0), (f64::NAN, 0.0, 0.0)]
        {
            assert_eq!(front.seen(along_normal), Rgb::gray(from_front), "{along_normal}");
            assert_eq!(both.seen(along_normal), Rgb::gray(from_any), "{along_normal}");
        }
        assert_eq!(both.power(2.0), front.power(4.0));
    }

    #[test]
    fn bad_radiance_is_refused() {
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            let radiance = Rgb::new(1.0, bad, 0.0);
            assert!(matches!(Emission::new(radiance, Sides::Front), Err(EmitterError::BadRadiance(_))), "{bad}");
        }
    }
}
