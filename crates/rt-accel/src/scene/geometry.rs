//! Geometry of a scene with its tree.

use std::collections::TryReserveError;

use glam::DVec3;
use rt_geometry::{Hit, HitStream, NoProbe, Primitives, Probe, RayStream, Spheres};
use rt_math::{Aabb, Interval, Ray};

use super::refit_tree::RefitTree;
use super::triangle_mesh::TriangleMesh;
use crate::wide::BuildParams;
use crate::{Accelerator, BuildError, PointHit, WideBvh};

/// Geometry of a scene.
#[derive(Clone, Debug)]
pub enum Geometry<'a> {
    /// Triangles.
    Mesh(TriangleMesh<'a>),
    /// Spheres.
    Spheres(Spheres),
}

impl<'a> From<TriangleMesh<'a>> for Geometry<'a> {
    fn from(mesh: TriangleMesh<'a>) -> Self {
        Self::Mesh(mesh)
    }
}

impl From<Spheres> for Geometry<'_> {
    fn from(spheres: Spheres) -> Self {
        Self::Spheres(spheres)
    }
}

/// Geometry with its tree: the bottom-level acceleration structure.
#[derive(Clone, Debug)]
pub(super) struct Blas<'a> {
    pub(super) geometry: Geometry<'a>,
    tree: RefitTree,
    /// Bounds of all primitives; empty without any.
    pub(super) bounds: Aabb,
}

/// Evaluates an expression for the primitives of either kind.
macro_rules! with_primitives {
    ($geometry:expr, $primitives:ident => $value:expr) => {
        match $geometry {
            Geometry::Mesh($primitives) => $value,
            Geometry::Spheres($primitives) => $value,
        }
    };
}

impl<'a> Blas<'a> {
    pub(super) fn build(geometry: Geometry<'a>, params: &BuildParams) -> Result<Self, BuildError> {
        let (tree, bounds) = with_primitives!(&geometry, primitives => {
            (RefitTree::build(primitives, params)?, bounds_of(primitives))
        });
        Ok(Self { geometry, tree, bounds })
    }

    /// A geometry of as many primitives with a tree that is made of this one.
    pub(super) fn refitted(&self, geometry: Geometry<'a>, params: &BuildParams) -> Result<Self, BuildError> {
        let (tree, bounds) = with_primitives!(&geometry, primitives => {
            (self.tree.clone().refitted(primitives, params)?, bounds_of(primitives))
        });
        Ok(Self { geometry, tree, bounds })
    }

    pub(super) fn memory(&self) -> usize {
        self.tree.bvh.memory()
    }

    #[inline]
    pub(super) fn closest<S: Probe>(&self, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
        with_primitives!(&self.geometry, primitives => self.tree.bvh.closest(primitives, ray, span, probe))
    }

    #[inline]
    pub(super) fn occluded<S: Probe>(&self, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        with_primitives!(&self.geometry, primitives => self.tree.bvh.occluded(primitives, ray, span, probe))
    }

    pub(super) fn closest_stream<S: Probe>(&self, rays: &RayStream, hits: &mut HitStream, probe: &mut S) {
        with_primitives!(&self.geometry, primitives => self.tree.bvh.closest_stream(primitives, rays, hits, probe));
    }

    pub(super) fn occluded_stream<S: Probe>(&self, rays: &RayStream, occluded: &mut [bool], probe: &mut S) {
        with_primitives!(&self.geometry, primitives => self.tree.bvh.occluded_stream(primitives, rays, occluded, probe));
    }

    /// All hits, or an empty list and an error if there is no memory for them.
    pub(super) fn try_all_hits(&self, ray: &Ray, span: Interval, hits: &mut Vec<Hit>) -> Result<(), TryReserveError> {
        with_primitives!(&self.geometry, primitives => {
            self.tree.bvh.collect_hits(primitives, ray, span, hits, &mut NoProbe).try_finish()
        })
    }

    pub(super) fn nearest_point(&self, point: DVec3, radius: f64) -> Option<PointHit> {
        with_primitives!(&self.geometry, primitives => self.tree.bvh.nearest_point(primitives, point, radius))
    }

    pub(super) const fn tree(&self) -> &WideBvh {
        &self.tree.bvh
    }
}

fn bounds_of(primitives: &impl Primitives) -> Aabb {
    (0..primitives.len() as u32).filter_map(|index| primitives.bounds(index)).fold(Aabb::EMPTY, Aabb::union)
}
