//! Records of a hit.

/// Hit on a primitive, with the data to compute the [`SurfaceInteraction`](crate::SurfaceInteraction) of the
/// closest one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter; the same in every space.
    pub t: f64,
    /// Index of the instance; 0 without instances.
    pub instance: u32,
    /// Index of the primitive within the instance. `u32::MAX` is that of a miss in a [`HitStream`](crate::HitStream): streams
    /// drop such hits.
    pub primitive: u32,
    /// Parameters on the primitive: barycentric weights of the second and third vertex of a triangle, otherwise as
    /// documented by the shape.
    pub uv: [f64; 2],
}

impl Hit {
    /// True if this hit wins over `other`: nearer, or equally near with the lower (instance, primitive). This total order
    /// makes the closest hit independent of the order of tests.
    #[inline]
    pub fn precedes(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && (self.instance, self.primitive) < (other.instance, other.primitive))
    }
}

/// Hit on a single shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// Ray parameter.
    pub t: f64,
    /// Parameters on the surface. Triangles: barycentric weights of the second and third vertex. Boxes and solids with
    /// caps: `[face, 0]`. Tori: `[distance along the ray, 0]`. Unused otherwise.
    pub uv: [f64; 2],
}
