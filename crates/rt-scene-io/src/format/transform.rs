//! Transformations in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One step of a transformation. Lists of steps are applied to the object in the order in which they are written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Step {
    /// Moves by x, y, z.
    Translate(f64, f64, f64),
    /// Turns about an axis, counter-clockwise seen from its tip.
    Rotate {
        /// The axis, of any length but 0.
        axis: [f64; 3],
        /// The angle in degrees.
        degrees: f64,
    },
    /// Turns about the x axis by degrees.
    RotateX(f64),
    /// Turns about the y axis by degrees.
    RotateY(f64),
    /// Turns about the z axis by degrees.
    RotateZ(f64),
    /// Turns about the x axis, then y, then z (which stay fixed), by degrees.
    Euler(f64, f64, f64),
    /// Turns by the quaternion x, y, z, w.
    Quaternion(f64, f64, f64, f64),
    /// Scales in all directions alike.
    Scale(f64),
    /// Scales along x, y and z; negative factors mirror.
    Stretch(f64, f64, f64),
    /// Shears: x gains `xy`·y + `xz`·z, and so on.
    Shear {
        /// What x gains of y.
        #[serde(default)]
        xy: f64,
        /// What x gains of z.
        #[serde(default)]
        xz: f64,
        /// What y gains of x.
        #[serde(default)]
        yx: f64,
        /// What y gains of z.
        #[serde(default)]
        yz: f64,
        /// What z gains of x.
        #[serde(default)]
        zx: f64,
        /// What z gains of y.
        #[serde(default)]
        zy: f64,
    },
    /// Any affine map: the four rows of a matrix that multiplies column vectors; the last is (0, 0, 0, 1).
    Matrix([f64; 4], [f64; 4], [f64; 4], [f64; 4]),
    /// Puts an object that looks along −z at `from` and turns it towards `at`.
    LookAt {
        /// Where it stands.
        from: [f64; 3],
        /// What it looks at.
        at: [f64; 3],
        /// The direction that its +y turns to as nearly as possible; +y by default.
        #[serde(default = "up")]
        up: [f64; 3],
    },
}

fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
