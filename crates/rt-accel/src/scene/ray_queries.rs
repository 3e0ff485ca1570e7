//! Scenes and their queries along a ray.

use core::ops::ControlFlow;

use rt_geometry::{Hit, NoProbe};
use rt_math::{Interval, Ray};

use super::geometry::Blas;
use super::instances::{Instance, Instances};
use crate::{Accelerator, WideBvh};

/// Meshes and spheres that rays are traced against: two levels of [`WideBvh`].
///
/// In a [`Hit`], `primitive` is the number of the triangle or sphere in its geometry, and `instance` that of the placed
/// geometry. Edges and vertices belong to all of their triangles. Of hits at equal `t`, the one with the lowest
/// (instance, primitive) is the closest.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    pub(super) geometries: Vec<Blas<'a>>,
    pub(super) instances: Vec<Instance>,
    pub(super) tree: WideBvh,
}

impl<'a> Scene<'a> {
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
    pub(super) fn single(&self) -> Option<&Blas<'a>> {
        match self.instances.as_slice() {
            [Instance { geometry, world_from_local: None, .. }] => self.geometries.get(*geometry as usize),
            _ => None,
        }
    }

    #[inline]
    pub(super) fn top_level(&self) -> Instances<'_, 'a> {
        Instances { instances: &self.instances, geometries: &self.geometries }
    }
}
