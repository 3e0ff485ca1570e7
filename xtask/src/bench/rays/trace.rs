//! Tracing of a set of rays, monomorphised for each accelerator.

use rayon::prelude::*;
use rt_accel::{Accelerator, AcceleratorVisitor, AnyAccelerator, NoProbe};
use rt_geometry::{Hit, TriangleMesh};
use rt_math::{Interval, Ray};

use super::files::{HitRecord, RayRecord};
use crate::costs::RayAnswer;

/// Consecutive rays that a thread takes at a time, unless batches have a size of their own.
const SHARE: usize = 4096;

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Query {
    /// The first hit.
    Closest,
    /// Any hit.
    Occluded,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Method {
    pub query: Query,
    /// Rays of a batch; `None` traces them one by one.
    pub batch: Option<usize>,
}

/// Answer of a query, as far as it is kept.
pub(super) trait Answer: Copy + Send {
    fn closest(hit: Option<Hit>) -> Self;
    fn occluded(is_blocked: bool) -> Self;
}

impl Answer for HitRecord {
    #[inline]
    fn closest(hit: Option<Hit>) -> Self {
        hit.into()
    }

    #[inline]
    fn occluded(is_blocked: bool) -> Self {
        if is_blocked { Self::BLOCKED } else { Self::MISS }
    }
}

impl Answer for RayAnswer {
    fn closest(hit: Option<Hit>) -> Self {
        Self::of_closest(hit)
    }

    fn occluded(is_blocked: bool) -> Self {
        Self::of_occluded(is_blocked)
    }
}

/// Answers `rays[i]` in `answers[i]`, on the threads of the current pool.
pub(super) fn trace<A: Answer>(
    structure: &AnyAccelerator,
    mesh: &TriangleMesh,
    method: Method,
    rays: &[RayRecord],
    answers: &mut [A],
) {
    structure.accept(Trace { mesh, method, rays, answers });
}

struct Trace<'a, A> {
    mesh: &'a TriangleMesh,
    method: Method,
    rays: &'a [RayRecord],
    answers: &'a mut [A],
}

impl<A: Answer> AcceleratorVisitor for Trace<'_, A> {
    type Output = ();

    fn visit<T: Accelerator>(self, structure: &T) {
        let Self { mesh, method, rays, answers } = self;
        let share = method.batch.unwrap_or(SHARE);
        let shares = rays.par_chunks(share).zip(answers.par_chunks_mut(share));
        match (method.batch, method.query) {
            (None, Query::Closest) => shares.for_each(|(rays, answers)| {
                for (record, answer) in rays.iter().zip(answers) {
                    let (ray, span) = record.widen();
                    *answer = A::closest(structure.closest(mesh, &ray, span, &mut NoProbe));
                }
            }),
            (None, Query::Occluded) => shares.for_each(|(rays, answers)| {
                for (record, answer) in rays.iter().zip(answers) {
                    let (ray, span) = record.widen();
                    *answer = A::occluded(structure.occluded(mesh, &ray, span, &mut NoProbe));
                }
            }),
            (Some(_), Query::Closest) => shares.for_each_init(Batch::default, |batch, (rays, answers)| {
                batch.fill(rays, None);
                structure.closest_batch(mesh, &batch.rays, &mut batch.found, &mut NoProbe);
                batch.store(answers, A::closest);
            }),
            (Some(_), Query::Occluded) => shares.for_each_init(Batch::default, |batch, (rays, answers)| {
                batch.fill(rays, false);
                structure.occluded_batch(mesh, &batch.rays, &mut batch.found, &mut NoProbe);
                batch.store(answers, A::occluded);
            }),
        }
    }
}

/// Scratch arrays for the rays of a batch and their hits, reused by each thread.
struct Batch<F> {
    rays: Vec<(Ray, Interval)>,
    found: Vec<F>,
}

impl<F> Default for Batch<F> {
    fn default() -> Self {
        Self { rays: Vec::new(), found: Vec::new() }
    }
}

impl<F: Copy> Batch<F> {
    fn fill(&mut self, records: &[RayRecord], nothing: F) {
        self.rays.clear();
        self.rays.extend(records.iter().map(RayRecord::widen));
        self.found.clear();
        self.found.resize(records.len(), nothing);
    }

    fn store<A>(&self, answers: &mut [A], answer: impl Fn(F) -> A) {
        for (to, found) in answers.iter_mut().zip(&self.found) {
            *to = answer(*found);
        }
    }
}
