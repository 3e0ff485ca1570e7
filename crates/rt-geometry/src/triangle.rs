//! Single triangles in `f64`, and the watertight kernel that meshes share.

use crate::error::{ShapeError, check_coordinates};
use rt_math::{DVec3, float::cross};

/// A flat triangle; its front is the side from which the vertices run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    pub(crate) vertices: [DVec3; 3],
}

impl Triangle {
    /// The triangle with these vertices.
    ///
    /// # Errors
    /// If it has no area or a number is not finite.
    pub fn new(vertices: [DVec3; 3]) -> Result<Self, ShapeError> {
        check_coordinates(vertices)?;
        let [a, b, c] = vertices;
        if cross(b - a, c - a) == DVec3::ZERO { Err(ShapeError::NoArea(vertices)) } else { Ok(Self { vertices }) }
    }

    /// The vertices in order.
    pub const fn vertices(&self) -> [DVec3; 3] {
        self.vertices
    }
}
