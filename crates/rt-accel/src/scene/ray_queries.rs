//! Scenes and their queries along a ray.

use core::ops::ControlFlow;
use std::collections::TryReserveError;
use std::sync::Arc;

use rt_geometry::{Hit, NoProbe};
use rt_math::{Interval, Ray};

use super::geometry::Blas;
use super::instances::{Instance, Instances};
use super::refit_tree::RefitTree;
use crate::Accelerator;
use crate::ray_query::{abort_without_memory, is_same, sort_hits};
use crate::wide::BuildParams;

/// Meshes and spheres that rays are traced against: two levels of [`WideBvh`](crate::WideBvh).
///
/// In a [`Hit`], `primitive` is the index of the triangle or sphere in its geometry, and `instance` that of the placed
/// geometry. Edges and vertices belong to all of their triangles. Of hits at equal `t`, the one with the lowest
/// (instance, primitive) is the closest.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    pub(super) params: BuildParams,
    /// By [`GeometryId`](super::GeometryId); `None` for removed ones.
    pub(super) geometries: Vec<Option<Arc<Blas<'a>>>>,
    /// Sorted by index.
    pub(super) instances: Vec<Instance>,
    /// Over the instances.
    pub(super) tree: RefitTree,
}

impl<'a> Scene<'a> {
    /// Number of instances.
    pub fn n_instances(&self) -> usize {
        self.instances.len()
    }

    /// Size of all trees in bytes, without the arrays of the geometries.
    pub fn memory(&self) -> usize {
        self.tree.bvh.memory() + self.geometries.iter().flatten().map(|geometry| geometry.memory()).sum::<usize>()
    }

    /// The closest hit within `span`.
    #[inline]
    pub fn closest(&self, ray: &Ray, span: Interval) -> Option<Hit> {
        match self.single() {
            Some(geometry) => geometry.closest(ray, span, &mut NoProbe),
            None => self.tree.bvh.closest(&self.top_level(), ray, span, &mut NoProbe),
        }
    }

    /// True if anything is hit within `span`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, span: Interval) -> bool {
        match self.single() {
            Some(geometry) => geometry.occluded(ray, span, &mut NoProbe),
            None => self.tree.bvh.occluded(&self.top_level(), ray, span, &mut NoProbe),
        }
    }

    /// All hits within `span`, each once, in order of (t, instance, primitive); clears `hits` first. A sphere reports both
    /// of its hits.
    pub fn all_hits(&self, ray: &Ray, span: Interval, hits: &mut Vec<Hit>) {
        self.try_all_hits(ray, span, hits).unwrap_or_else(|_| abort_without_memory());
    }

    /// [`all_hits`](Self::all_hits), or an empty list and an error if there is no memory for them.
    pub(super) fn try_all_hits(&self, ray: &Ray, span: Interval, hits: &mut Vec<Hit>) -> Result<(), TryReserveError> {
        if let Some(geometry) = self.single() {
            return geometry.try_all_hits(ray, span, hits);
        }
        hits.clear();
        let (mut of_one, mut failure) = (Vec::new(), None);
        let visit = |index: u32, inside: Interval| {
            let Some((instance, geometry)) = self.top_level().get(index) else {
                return ControlFlow::Continue(f64::INFINITY);
            };
            let found = geometry.try_all_hits(&instance.local_ray(ray), span, &mut of_one);
            if let Err(error) = found.and_then(|()| hits.try_reserve(of_one.len())) {
                failure = Some(error);
                return ControlFlow::Break(());
            }
            // As the closest hit: not before the entry into the bounds.
            let placed = |hit: &Hit| Hit { t: hit.t.max(inside.min), instance: instance.id, ..*hit };
            hits.extend(of_one.iter().map(placed));
            ControlFlow::Continue(f64::INFINITY)
        };
        self.tree.bvh.visit_candidates(&self.top_level(), ray, span, visit, &mut NoProbe);
        if let Some(error) = failure {
            hits.clear();
            return Err(error);
        }
        sort_hits(hits);
        hits.dedup_by(|a, b| is_same(a, b));
        Ok(())
    }

    /// The geometry, if instance 0 is the only one and not transformed: rays skip the top level.
    #[inline]
    pub(super) fn single(&self) -> Option<&Blas<'a>> {
        match self.instances.as_slice() {
            [Instance { id: 0, geometry, world_from_local: None, .. }] => {
                self.geometries.get(*geometry as usize)?.as_deref()
            }
            _ => None,
        }
    }

    #[inline]
    pub(super) fn top_level(&self) -> Instances<'_, 'a> {
        Instances { instances: &self.instances, geometries: &self.geometries }
    }
}
