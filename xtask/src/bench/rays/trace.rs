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
        let Self { mesh, method: Method { query, batch }, rays, answers } = self;
        for_each_share(rays, answers, batch.unwrap_or(SHARE), &|scratch, records, answers| match (batch, query) {
            (None, Query::Closest) => {
                for (record, answer) in records.iter().zip(answers) {
                    let (ray, span) = record.widen();
                    *answer = accelerator.closest(mesh, &ray, span, &mut NoProbe).into();
                }
            }
            (None, Query::Occluded) => {
                for (record, answer) in records.iter().zip(answers) {
                    let (ray, span) = record.widen();
                    *answer = accelerator.occluded(mesh, &ray, span, &mut NoProbe).into();
                }
            }
            (Some(_), Query::Closest) => {
                scratch.widen(records);
                scratch.hits.clear();
                scratch.hits.resize(records.len(), None);
                accelerator.closest_batch(mesh, &scratch.rays, &mut scratch.hits, &mut NoProbe);
                store(&scratch.hits, answers);
            }
            (Some(_), Query::Occluded) => {
                scratch.widen(records);
                scratch.occluded.clear();
                scratch.occluded.resize(records.len(), false);
                accelerator.occluded_batch(mesh, &scratch.rays, &mut scratch.occluded, &mut NoProbe);
                store(&scratch.occluded, answers);
            }
        });
    }
}

/// Work on consecutive rays and their answers, with the scratch arrays of its thread.
type ShareWork<'w, A> = dyn Fn(&mut Batch, &[RayRecord], &mut [A]) + Sync + 'w;

/// Does the work on all rays, `share` at a time. Compiled once for all accelerators, unlike the work.
fn for_each_share<A: Send>(rays: &[RayRecord], answers: &mut [A], share: usize, work: &ShareWork<'_, A>) {
    let shares = rays.par_chunks(share).zip(answers.par_chunks_mut(share));
    shares.for_each_init(Batch::default, |batch, (rays, answers)| work(batch, rays, answers));
}

/// Scratch arrays for the rays of a batch and their hits, reused by each thread.
#[derive(Default)]
struct Batch {
    rays: Vec<(Ray, Interval)>,
    hits: Vec<Option<Hit>>,
    occluded: Vec<bool>,
}

impl Batch {
    fn widen(&mut self, records: &[RayRecord]) {
        self.rays.clear();
        self.rays.extend(records.iter().map(RayRecord::widen));
    }
}

fn store<F: Copy, A: From<F>>(found: &[F], answers: &mut [A]) {
    for (answer, found) in answers.iter_mut().zip(found) {
        *answer = (*found).into();
    }
}
