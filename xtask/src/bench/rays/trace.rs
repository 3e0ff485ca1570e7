//! Tracing of a set of rays, monomorphised for each accelerator.

use rayon::prelude::*;
use rt_accel::{Accelerator, AcceleratorVisitor, AnyAccelerator, NoProbe};
use rt_geometry::{Hit, STREAM_CAPACITY, StreamBuffers, TriangleMesh};

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
        for_each_share(rays, answers, batch.unwrap_or(SHARE), &|buffers, records, answers| match (batch, query) {
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
            (Some(_), Query::Closest) => for_each_stream(buffers, records, answers, |buffers, answers| {
                accelerator.closest_stream(mesh, &buffers.rays, &mut buffers.hits, &mut NoProbe);
                answers.iter_mut().enumerate().for_each(|(at, answer)| *answer = buffers.hits.get(at).into());
            }),
            (Some(_), Query::Occluded) => for_each_stream(buffers, records, answers, |buffers, answers| {
                accelerator.occluded_stream(mesh, &buffers.rays, buffers.occluded.as_mut_slice(), &mut NoProbe);
                answers.iter_mut().enumerate().for_each(|(at, answer)| *answer = buffers.occluded.get(at).into());
            }),
        });
    }
}

/// Calls `trace` with the rays in one stream after the other, and their answers.
fn for_each_stream<A>(
    buffers: &mut StreamBuffers,
    records: &[RayRecord],
    answers: &mut [A],
    mut trace: impl FnMut(&mut StreamBuffers, &mut [A]),
) {
    for (records, answers) in records.chunks(STREAM_CAPACITY).zip(answers.chunks_mut(STREAM_CAPACITY)) {
        buffers.rays.clear();
        for (ray, span) in records.iter().map(RayRecord::widen) {
            buffers.rays.push(&ray, span);
        }
        trace(buffers, answers);
    }
}

/// Work on consecutive rays and their answers, with the buffers of its thread.
type ShareWork<'w, A> = dyn Fn(&mut StreamBuffers, &[RayRecord], &mut [A]) + Sync + 'w;

/// Does the work on all rays, `share` at a time. Compiled once for all accelerators, unlike the work.
fn for_each_share<A: Send>(rays: &[RayRecord], answers: &mut [A], share: usize, work: &ShareWork<'_, A>) {
    let shares = rays.par_chunks(share).zip(answers.par_chunks_mut(share));
    shares.for_each_init(StreamBuffers::default, |buffers, (rays, answers)| work(buffers, rays, answers));
}
