//! Orthonormal frames.

use crate::{Real, Vector3};
use glam::DVec3;

/// A right-handed orthonormal basis `(x, y, z)`, usually with `z` along a surface normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: DVec3,
    /// Second tangent.
    pub y: DVec3,
    /// Axis that the frame was built from.
    pub z: DVec3,
}

impl Frame {
    /// Frame with this unit vector as `z`; see [`tangents`].
    #[inline]
    pub fn from_z(z: DVec3) -> Self {
        let [x, y] = tangents(Vector3::from(z)).map(DVec3::from);
        Self { x, y, z }
    }

    /// Coordinates in the frame of a vector given outside it.
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// The vector with coordinates `v` in the frame.
    pub fn from_local(&self, v: DVec3) -> DVec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// Larger than rounding errors of a component that is 0, also far from the origin, and smaller than intended slopes.
const TURN: f64 = 1.0 / (1 << 20) as f64;

/// Two unit vectors that form a right-handed frame with the unit vector `z`, without a branch on its direction. They change
/// continuously with `z`, except at `z.z` = −2⁻²⁰. The jump is not at 0, so that rounding does not flip the tangents of upright walls.
///
/// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017, with the jump at 0.
#[inline(always)]
pub fn tangents<R: Real>(z: Vector3<R>) -> [Vector3<R>; 2] {
    let one = z.z.splat(1.0);
    let sign = one.copysign(z.z + TURN);
    let a = -one / (sign + z.z);
    let b = z.x * z.y * a;
    [Vector3::new(one + sign * z.x * z.x * a, sign * b, -sign * z.x), Vector3::new(b, sign + z.y * z.y * a, -z.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn frames_are_orthonormal_and_right_handed(x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64) {
            let v = DVec3::new(x, y, z);
            prop_assume!(v.length() > 1e-3);
            let f = Frame::from_z(v.normalize());
            for (a, b) in [(f.x, f.y), (f.y, f.z), (f.z, f.x)] {
                prop_assert!(a.dot(b).abs() < 1e-14);
            }
            prop_assert!((f.x.cross(f.y) - f.z).length() < 1e-14);
            prop_assert!((f.from_local(f.to_local(v)) - v).length() < 1e-14);
        }
    }

    #[test]
    fn frames_of_upright_walls_do_not_hang_on_the_sign_of_zero() {
        for z in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::new(0.6, -0.8, 0.0)] {
            let f = Frame::from_z(z);
            for off in [-0.0, 1e-17, -1e-17, 1e-10, -1e-10] {
                let g = Frame::from_z(DVec3 { z: off, ..z });
                assert!((f.x - g.x).length() < 1e-9 && (f.y - g.y).length() < 1e-9, "{z:?}, {off}");
            }
        }
    }

    #[test]
    fn both_poles_are_ordinary() {
        for z in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.0, 0.0, -0.0) + DVec3::NEG_Z] {
            let f = Frame::from_z(z);
            assert!((f.x.length() - 1.0).abs() < 1e-15 && (f.y.length() - 1.0).abs() < 1e-15);
        }
    }
}
