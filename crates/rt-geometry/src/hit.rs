//! The small record of a hit.

/// Where a ray met a primitive: small, and filled once per candidate. The full geometry of the surface is computed
/// for the winner alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter; the same in every space.
    pub t: f64,
    /// Which object of the upper level; 0 where there is one level only.
    pub instance: u32,
    /// Which primitive within the object.
    pub primitive: u32,
    /// Parameters on the primitive, for the shape to rebuild the surface from: barycentric weights of the second and
    /// third vertex of a triangle, otherwise whatever the shape documents.
    pub uv: [f64; 2],
}

impl Hit {
    /// True if this hit wins over `other`: nearer, or equally near and of the lower (instance, primitive).
    ///
    /// This total order makes the answer independent of the order in which a structure offers primitives.
    #[inline]
    pub fn precedes(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && (self.instance, self.primitive) < (other.instance, other.primitive))
    }
}
