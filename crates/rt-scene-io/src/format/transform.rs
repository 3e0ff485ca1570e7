//! Transformations in the file.

use serde::{Deserialize, Serialize};

use super::default_values::up;

/// One step of a transformation. Lists of steps are applied to the object in the order in which they are written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Step {
    /// Moves by x, y, z.
    ///
    /// Example: `translate(1, 0, -2)`.
    Translate(f64, f64, f64),
    /// Rotates about an axis, counter-clockwise seen from its tip.
    Rotate {
        /// The axis, of any length but 0.
        ///
        /// Unit: none.
        axis: [f64; 3],
        /// The angle in degrees.
        ///
        /// Unit: degrees. Example: `degrees: 30`.
        degrees: f64,
    },
    /// Rotates about the x axis by degrees.
    ///
    /// Example: `rotate_x(90)`.
    RotateX(f64),
    /// Rotates about the y axis by degrees.
    ///
    /// Example: `rotate_y(45)`.
    RotateY(f64),
    /// Rotates about the z axis by degrees.
    ///
    /// Example: `rotate_z(30)`.
    RotateZ(f64),
    /// Rotates about the fixed axes x, then y, then z, by degrees.
    ///
    /// Example: `euler(30, 45, 0)`.
    Euler(f64, f64, f64),
    /// Rotates by the quaternion x, y, z, w.
    ///
    /// Example: `quaternion(0, 0, 0, 1)`.
    Quaternion(f64, f64, f64, f64),
    /// Scales all axes by the same factor.
    ///
    /// Example: `scale(2)`.
    Scale(f64),
    /// Scales along x, y and z; negative factors mirror.
    ///
    /// Example: `stretch(1, 2, 1)`.
    Stretch(f64, f64, f64),
    /// Shears: x gains `xy`·y + `xz`·z, and so on.
    Shear {
        /// Factor of y that is added to x.
        ///
        /// Unit: none. Example: `xy: 0.5`.
        #[serde(default)]
        xy: f64,
        /// Factor of z that is added to x.
        ///
        /// Unit: none.
        #[serde(default)]
        xz: f64,
        /// Factor of x that is added to y.
        ///
        /// Unit: none.
        #[serde(default)]
        yx: f64,
        /// Factor of z that is added to y.
        ///
        /// Unit: none.
        #[serde(default)]
        yz: f64,
        /// Factor of x that is added to z.
        ///
        /// Unit: none.
        #[serde(default)]
        zx: f64,
        /// Factor of y that is added to z.
        ///
        /// Unit: none.
        #[serde(default)]
        zy: f64,
    },
    /// Any affine map: the four rows of a matrix that multiplies column vectors; the last is (0, 0, 0, 1).
    ///
    /// Example: `matrix((1, 0, 0, 2), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))`.
    Matrix([f64; 4], [f64; 4], [f64; 4], [f64; 4]),
    /// Moves the origin to `from` and rotates −z towards `at`.
    LookAt {
        /// Position of the object.
        ///
        /// Unit: units of the scene. Example: `from: (0, 1, 5)`.
        from: [f64; 3],
        /// Point in the direction of −z.
        ///
        /// Unit: units of the scene. Example: `at: (0, 0.5, 0)`.
        at: [f64; 3],
        /// The direction that its +y turns to as nearly as possible.
        ///
        /// Unit: none.
        #[serde(default = "up")]
        up: [f64; 3],
    },
}
