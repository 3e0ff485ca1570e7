//! Emission of area lights.

use super::light_error::{LightError, check_radiance};
use rt_math::{Real, Rgb};
use std::f64::consts::PI;

/// Sides of a surface that emit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionSides {
    /// Side that the normal points to: the outside of closed shapes.
    Front,
    /// Both sides.
    Both,
}

/// Constant radiance from every point of a surface in all directions: a Lambertian (diffuse) emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    radiance: Rgb,
    sides: EmissionSides,
}

impl Emission {
    /// Emission of `radiance` (power per unit area and solid angle).
    ///
    /// # Errors
    /// If a component is NaN, negative, or greater than 1e100. Black is valid.
    pub fn new(radiance: Rgb, sides: EmissionSides) -> Result<Self, LightError> {
        check_radiance(radiance)?;
        Ok(Self { radiance, sides })
    }

    /// Radiance of an emissive side.
    pub const fn radiance(&self) -> Rgb {
        self.radiance
    }

    /// Emissive sides.
    pub const fn sides(&self) -> EmissionSides {
        self.sides
    }

    /// Radiance against a viewing direction whose product with the normal is `along_normal`. Only its sign counts.
    /// Negative is towards the front. Black behind a one-sided light, exactly edge-on, and for NaN.
    #[inline]
    pub fn emitted(&self, along_normal: f64) -> Rgb {
        if self.emits(along_normal) { self.radiance } else { Rgb::BLACK }
    }

    /// True where a side emits, for one number or for lanes; see [`emitted`](Self::emitted).
    #[inline(always)]
    pub(crate) fn emits<R: Real>(&self, along_normal: R) -> R::Mask {
        let zero = along_normal.splat(0.0);
        match self.sides {
            EmissionSides::Front => along_normal.lt(zero),
            EmissionSides::Both => along_normal.lt(zero) | zero.lt(along_normal),
        }
    }

    /// Power of a surface of the given area: π · A · L for each emissive side.
    pub fn power(&self, area: f64) -> Rgb {
        let sides = match self.sides {
            EmissionSides::Front => 1.0,
            EmissionSides::Both => 2.0,
        };
        self.radiance * (sides * PI * area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_that_do_not_emit_are_black() {
        let front = Emission::new(Rgb::WHITE, EmissionSides::Front).expect("an emission");
        let both = Emission::new(Rgb::WHITE, EmissionSides::Both).expect("an emission");
        for (along_normal, from_front, from_any) in
            [(-1e-300, 1.0, 1.0), (0.5, 0.0, 1.0), (0.0, 0.0, 0.0), (f64::NAN, 0.0, 0.0)]
        {
            assert_eq!(front.emitted(along_normal), Rgb::gray(from_front), "{along_normal}");
            assert_eq!(both.emitted(along_normal), Rgb::gray(from_any), "{along_normal}");
        }
        assert_eq!(both.power(2.0), front.power(4.0));
    }

    #[test]
    fn bad_radiance_is_refused() {
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            let radiance = Rgb::new(1.0, bad, 0.0);
            assert!(matches!(Emission::new(radiance, EmissionSides::Front), Err(LightError::BadRadiance(_))), "{bad}");
        }
    }
}
