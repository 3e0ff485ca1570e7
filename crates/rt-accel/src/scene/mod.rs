//! Ready-made geometry: meshes and spheres with their trees, placed once or many times.
//!
//! From the lowest layer to the highest: `error`, `triangle_mesh`, `user_geometry`; `geometry` with its tree; `instances`
//! as primitives of the top level; this file with the queries along a ray; `builder`; `points` with queries at a point;
//! `batches` with queries for many rays.

mod batches;
mod builder;
mod error;
mod geometry;
mod instances;
mod points;
mod triangle_mesh;
mod user_geometry;

use core::ops::ControlFlow;

use rt_geometry::{Hit, NoProbe};
use rt_math::{Interval, Ray};

pub use batches::HitLists;
pub use builder::{GeometryId, SceneBuilder};
pub use error::{MeshError, SceneError};
use geometry::Blas;
pub use geometry::Geometry;
use instances::{Instance, Instances};
pub use triangle_mesh::{TriangleMesh, Vertices};
pub use user_geometry::UserGeometry;

use crate::wide::BuildParams;
use crate::{Accelerator, WideBvh};

/// Meshes and spheres that rays are traced against: two levels of [`WideBvh`].
///
/// In a [`Hit`], `primitive` is the number of the triangle or sphere in its geometry, and `instance` that of the placed
/// geometry. Edges and vertices belong to all of their triangles. Of hits at equal `t`, the one with the lowest
/// (instance, primitive) is the closest.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    geometries: Vec<Blas<'a>>,
    instances: Vec<Instance>,
    tree: WideBvh,
}

impl<'a> Scene<'a> {
    /// A scene of a single geometry, with default parameters.
    ///
    /// # Errors
    ///
    /// [`SceneError::Geometry`] if no tree can be built.
    pub fn new(geometry: impl Into<Geometry<'a>>) -> Result<Self, SceneError> {
        let mut builder = SceneBuilder::new(BuildParams::default());
        let geometry = builder.add(geometry)?;
        builder.place(geometry)?;
        builder.build()
    }

    /// Number of instances.
    pub fn n_instances(&self) -> usize {
        self.instances.len()
    }

    /// Number of triangles and spheres, those of each geometry once.
    pub fn n_primitives(&self) -> usize {
        self.geometries.iter().map(Blas::len).sum()
    }

    /// Size of all trees in bytes, without the arrays of the geometries.
    pub fn memory(&self) -> usize {
        self.tree.memory() + self.geometries.iter().map(Blas::memory).sum::<usize>()
    }

    /// The closest hit within `span`.
    #[inline]
    pub fn closest(&self, ray: &Ray, span: Interval) -> Option<Hit> {
        match self.single() {
            Some(geometry) => geometry.closest(ray, span, &mut NoProbe),
            None => self.tree.closest(&self.top_level(), ray, span, &mut NoProbe),
        }
    }

    /// True if anything is hit within `span`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, span: Interval) -> bool {
        match self.single() {
            Some(geometry) => geometry.occluded(ray, span, &mut NoProbe),
            None => self.tree.occluded(&self.top_level(), ray, span, &mut NoProbe),
        }
    }

    /// All hits within `span`, each once, in order of (t, instance, primitive); clears `hits` first. A sphere reports both
    /// of its hits.
    pub fn all_hits(&self, ray: &Ray, span: Interval, hits: &mut Vec<Hit>) {
        if let Some(geometry) = self.single() {
            return geometry.all_hits(ray, span, hits, &mut NoProbe);
        }
        hits.clear();
        let mut of_one = Vec::new();
        let visit = |index: u32, inside: Interval| {
            let instance = &self.instances[index as usize];
            let geometry = &self.geometries[instance.geometry as usize];
            geometry.all_hits(&instance.local_ray(ray), span, &mut of_one, &mut NoProbe);
            // As the closest hit: not before the entry into the bounds.
            let placed = |hit: &Hit| Hit { t: hit.t.max(inside.min), instance: index, ..*hit };
            hits.extend(of_one.iter().map(placed));
            ControlFlow::<(), f64>::Continue(f64::INFINITY)
        };
        self.tree.visit_candidates(&self.top_level(), ray, span, visit, &mut NoProbe);
        hits.sort_unstable_by(|a, b| {
            a.t.total_cmp(&b.t).then((a.instance, a.primitive).cmp(&(b.instance, b.primitive)))
        });
    }

    /// The geometry, if there is a single one that is not transformed: rays skip the top level.
    #[inline]
    fn single(&self) -> Option<&Blas<'a>> {
        match self.instances.as_slice() {
            [Instance { geometry, world_from_local: None, .. }] => self.geometries.get(*geometry as usize),
            _ => None,
        }
    }

    #[inline]
    fn top_level(&self) -> Instances<'_, 'a> {
        Instances { instances: &self.instances, geometries: &self.geometries }
    }
}
