//! Tracing of a set of rays, monomorphised for each accelerator.

use rayon::prelude::*;
use rt_accel::{Accelerator, AcceleratorVisitor, AnyAccelerator, NoProbe};
use rt_geometry::{Hit, TriangleMesh};
use rt_math::{Interval, Ray};

use super::files::RayRecord;

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

/// Answer of a query, as far as it is kept: made from the first hit, or from whether something blocks the ray.
pub(super) trait Answer: Copy + Send + From<Option<Hit>> + From<bool> {}

impl<A: Copy + Send + From<Option<Hit>> + From<bool>> Answer for A {}

/// Answers `rays[i]` in `answers[i]`, on the threads of the current pool.
pub(super) fn trace<A: Answer>(
    accelerator: &AnyAccelerator,
    mesh: &TriangleMesh,
    method: Method,
    rays: &[RayRecord],
    answers: &mut [A],
) {
    accelerator.accept(Trace { mesh, method, rays, answers });
}

struct Trace<'a, A> {
    mesh: &'a TriangleMesh,
    method: Method,
    rays: &'a [RayRecord],
    answers: &'a mut [A],
}

impl<A: Answer> AcceleratorVisitor for Trace<'_, A> {
    type Output = ();

    fn visit<T: Accelerator>(self, accelerator: &T) {
        let Self { mesh, method, rays, answers } = self;
        let share = method.batch.unwrap_or(SHARE);
        match (method.batch, method.query) {
            (None, Query::Closest) => for_each_share(rays, answers, share, &|(), rays, answers| {
                for (record, answer) in rays.iter().zip(answers) {
                    let (ray, span) = record.widen();
                    *answer = accelerator.closest(mesh, &ray, span, &mut NoProbe).into();
                }
            }),
            (None, Query::Occluded) => for_each_share(rays, answers, share, &|(), rays, answers| {
                for (record, answer) in rays.iter().zip(answers) {
                    let (ray, span) = record.widen();
                    *answer = accelerator.occluded(mesh, &ray, span, &mut NoProbe).into();
                }
            }),
            (Some(_), Query::Closest) => {
                for_each_share(rays, answers, share, &|batch: &mut Batch<_>, rays, answers| {
                    batch.fill(rays, None);
                    accelerator.closest_batch(mesh, &batch.rays, &mut batch.found, &mut NoProbe);
                    batch.store(answers);
                })
            }
            (Some(_), Query::Occluded) => {
                for_each_share(rays, answers, share, &|batch: &mut Batch<_>, rays, answers| {
                    batch.fill(rays, false);
                    accelerator.occluded_batch(mesh, &batch.rays, &mut batch.found, &mut NoProbe);
                    batch.store(answers);
                })
            }
        }
    }
}

/// Work on consecutive rays and their answers, with the state of its thread.
type ShareWork<'w, S, A> = dyn Fn(&mut S, &[RayRecord], &mut [A]) + Sync + 'w;

/// Does the work on all rays, `share` at a time. Compiled once for all accelerators, unlike the work.
fn for_each_share<S: Default, A: Send>(
    rays: &[RayRecord],
    answers: &mut [A],
    share: usize,
    work: &ShareWork<'_, S, A>,
) {
    let shares = rays.par_chunks(share).zip(answers.par_chunks_mut(share));
    shares.for_each_init(S::default, |state, (rays, answers)| work(state, rays, answers));
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

    fn store<A: From<F>>(&self, answers: &mut [A]) {
        for (to, found) in answers.iter_mut().zip(&self.found) {
            *to = (*found).into();
        }
    }
}
