//! A scene to measure with, and its surfaces.

use std::ops::Range;

use rt_geometry::{
    Hit, InteractionFlags, MeshData, Primitives, ShapeHit, Spheres, SurfaceInteraction, TransformedShape, TriangleMesh,
};
use rt_math::{Aabb, Interval, Ray};

use crate::error::TaskError;

/// Primitives under a name.
#[derive(Debug)]
pub(crate) struct Scene<P> {
    pub name: &'static str,
    pub primitives: P,
    /// Bounds of the part in view.
    pub view: Aabb,
}

impl<P: Primitives> Scene<P> {
    /// A scene that is looked at as a whole.
    pub(super) fn whole(name: &'static str, primitives: P) -> Self {
        let boxes = (0..primitives.len() as u32).filter_map(|index| primitives.bounds(index));
        let view = boxes.fold(Aabb::EMPTY, Aabb::union);
        Self { name, primitives, view }
    }
}

/// Primitives that rays can go on from.
pub(crate) trait Surfaces: Primitives {
    /// The surface at a hit of this ray.
    fn surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfaceInteraction>;
}

impl Surfaces for Spheres {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfaceInteraction> {
        self.surface(ray, hit, InteractionFlags::ALL)
    }
}

impl Surfaces for TriangleMesh {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfaceInteraction> {
        self.surface(ray, hit, InteractionFlags::ALL)
    }
}

/// Solids of several kinds.
#[derive(Debug)]
pub(crate) struct Solids(pub(super) Vec<TransformedShape>);

impl Primitives for Solids {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.0.get(index as usize)?.bounds()
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let ShapeHit { t, uv } = self.0.get(index as usize)?.intersect(ray, span)?;
        Some(Hit { t, instance: 0, primitive: index, uv })
    }
}

impl Surfaces for Solids {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfaceInteraction> {
        let solid = self.0.get(hit.primitive as usize)?;
        Some(solid.surface(ray, &ShapeHit { t: hit.t, uv: hit.uv }, InteractionFlags::ALL))
    }
}

/// The member of a series of scenes whose size is nearest to `wanted`, by ratio.
pub(super) fn nearest(wanted: usize, members: Range<u32>, size: impl Fn(u32) -> usize) -> u32 {
    let ratio = |member: &u32| {
        let (a, b) = (size(*member) as f64, wanted as f64);
        (a / b).max(b / a)
    };
    members.min_by(|a, b| ratio(a).total_cmp(&ratio(b))).unwrap_or_default()
}

pub(super) fn mesh(data: MeshData) -> Result<TriangleMesh, TaskError> {
    TriangleMesh::build(data).map(|(mesh, _)| mesh).map_err(other)
}

pub(super) fn other(error: impl std::fmt::Display) -> TaskError {
    TaskError::Other(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_member_is_nearest_by_ratio() {
        assert_eq!(nearest(30, 0..5, |n| 10usize.pow(n)), 1);
        assert_eq!(nearest(40, 0..5, |n| 10usize.pow(n)), 2);
        assert_eq!(nearest(1, 1..5, |n| 10usize.pow(n)), 1);
    }
}
