//! A scene to measure with, and its surfaces.

use std::ops::Range;

use rt_geometry::{Hit, InteractionFlags, MeshData, Primitives, Spheres, SurfaceInteraction, TriangleMesh};
use rt_math::{Aabb, Ray};
use rt_tests::ShapeSet;

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

impl Surfaces for ShapeSet {
    fn surface(&self, ray: &Ray, hit: &Hit) -> Option<SurfaceInteraction> {
        self.surface(ray, hit, InteractionFlags::ALL)
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
    TriangleMesh::build(data).map(|(mesh, _)| mesh).map_err(TaskError::other)
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
