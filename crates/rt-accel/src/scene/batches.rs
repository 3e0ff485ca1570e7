//! Queries for many rays: structures of arrays in, structures of arrays out.
//!
//! Rays are gathered in streams, which are traced one after the other, and their hits written to the
//! caller's arrays. The functions with the prefix `par_` share the rays among the threads of the current rayon pool,
//! with identical results.

use core::ops::Range;
use std::collections::TryReserveError;

use rt_geometry::{Hit, HitStream, NoProbe, RayStream, STREAM_CAPACITY};

use super::ray_queries::Scene;
use crate::Accelerator;
use crate::batch::{BatchError, HitBatch, RayBatch};
#[cfg(feature = "parallel")]
use crate::parallel_for::{parallel_for_each, parallel_map};

/// Rays that a thread takes at a time.
#[cfg(feature = "parallel")]
const RAYS_PER_TASK: usize = 64 * STREAM_CAPACITY;

/// Rays with all their hits that a thread takes at a time.
#[cfg(feature = "parallel")]
const RAYS_OF_LISTS: usize = 4 * STREAM_CAPACITY;

/// All hits of many rays: those of ray `i` are `hits[offsets[i]..offsets[i + 1]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct HitLists {
    /// One more than there are rays; the first is 0.
    pub offsets: Vec<usize>,
    /// The hits of all rays, one ray after the other, in the order of [`Scene::all_hits`].
    pub hits: Vec<Hit>,
}

impl HitLists {
    /// Lists of no rays yet, with room for the offsets of `n_rays`.
    fn with_capacity(n_rays: usize) -> Result<Self, TryReserveError> {
        let mut offsets = Vec::new();
        offsets.try_reserve_exact(n_rays.saturating_add(1))?;
        offsets.push(0);
        Ok(Self { offsets, hits: Vec::new() })
    }

    /// Appends the list of one ray.
    fn push(&mut self, hits: &[Hit]) -> Result<(), TryReserveError> {
        self.hits.try_reserve(hits.len())?;
        self.hits.extend_from_slice(hits);
        self.offsets.push(self.hits.len());
        Ok(())
    }

    /// Appends the lists of other rays.
    #[cfg(feature = "parallel")]
    fn append(&mut self, other: &Self) {
        let first = self.hits.len();
        self.offsets.extend(other.offsets.iter().skip(1).map(|offset| first + offset));
        self.hits.extend_from_slice(&other.hits);
    }
}

/// Calls `trace` with the rays of a range in one stream after the other, and the place of the first ray in the range.
fn for_each_stream(rays: &RayBatch<'_>, range: Range<usize>, mut trace: impl FnMut(usize, &RayStream)) {
    let mut stream = RayStream::default();
    for first in range.clone().step_by(STREAM_CAPACITY) {
        stream.clear();
        for index in first..range.end.min(first + STREAM_CAPACITY) {
            let (ray, span) = rays.get(index);
            stream.push(&ray, span);
        }
        trace(first - range.start, &stream);
    }
}

impl Scene<'_> {
    /// [`closest`](Self::closest) for many rays, on this thread.
    ///
    /// # Errors
    ///
    /// [`BatchError::Length`] if an array of `hits` does not hold one entry for each ray.
    pub fn closest_batch(&self, rays: &RayBatch<'_>, hits: &mut HitBatch<'_>) -> Result<(), BatchError> {
        hits.check(rays.len())?;
        self.closest_range(rays, 0..rays.len(), hits);
        Ok(())
    }

    /// [`occluded`](Self::occluded) for many rays, on this thread.
    ///
    /// # Errors
    ///
    /// [`BatchError::Length`] if `occluded` does not hold one entry for each ray.
    pub fn occluded_batch(&self, rays: &RayBatch<'_>, occluded: &mut [bool]) -> Result<(), BatchError> {
        check_length("truth values", occluded.len(), rays)?;
        self.occluded_range(rays, 0..rays.len(), occluded);
        Ok(())
    }

    /// [`all_hits`](Self::all_hits) for many rays, on this thread.
    ///
    /// # Errors
    ///
    /// [`BatchError::Memory`] if there is no memory for the hits.
    pub fn all_hits_batch(&self, rays: &RayBatch<'_>) -> Result<HitLists, BatchError> {
        Ok(self.all_hits_range(rays, 0..rays.len())?)
    }

    /// Number of [`all_hits`](Self::all_hits) of each ray, on this thread.
    ///
    /// # Errors
    ///
    /// [`BatchError::Length`] if `counts` does not hold one entry for each ray. [`BatchError::Memory`] if there is no memory
    /// for the hits of one ray, of which some are found twice.
    pub fn count_hits_batch(&self, rays: &RayBatch<'_>, counts: &mut [u32]) -> Result<(), BatchError> {
        check_length("counts", counts.len(), rays)?;
        Ok(self.count_range(rays, 0, counts)?)
    }

    fn closest_range(&self, rays: &RayBatch<'_>, range: Range<usize>, hits: &mut HitBatch<'_>) {
        let mut of_stream = HitStream::default();
        for_each_stream(rays, range, |first, rays| {
            match self.single() {
                Some(geometry) => geometry.closest_stream(rays, &mut of_stream, &mut NoProbe),
                None => self.tree.bvh.closest_stream(&self.top_level(), rays, &mut of_stream, &mut NoProbe),
            }
            (0..rays.len()).for_each(|at| hits.set(first + at, of_stream.get(at).as_ref()));
        });
    }

    fn occluded_range(&self, rays: &RayBatch<'_>, range: Range<usize>, occluded: &mut [bool]) {
        for_each_stream(rays, range, |first, rays| {
            let occluded = &mut occluded[first..first + rays.len()];
            match self.single() {
                Some(geometry) => geometry.occluded_stream(rays, occluded, &mut NoProbe),
                None => self.tree.bvh.occluded_stream(&self.top_level(), rays, occluded, &mut NoProbe),
            }
        });
    }

    fn all_hits_range(&self, rays: &RayBatch<'_>, range: Range<usize>) -> Result<HitLists, TryReserveError> {
        let mut lists = HitLists::with_capacity(range.len())?;
        let mut of_one = Vec::new();
        for index in range {
            let (ray, span) = rays.get(index);
            self.try_all_hits(&ray, span, &mut of_one)?;
            lists.push(&of_one)?;
        }
        Ok(lists)
    }

    fn count_range(&self, rays: &RayBatch<'_>, first: usize, counts: &mut [u32]) -> Result<(), TryReserveError> {
        let mut hits = Vec::new();
        for (i, count) in counts.iter_mut().enumerate() {
            let (ray, span) = rays.get(first + i);
            self.try_all_hits(&ray, span, &mut hits)?;
            *count = hits.len() as u32;
        }
        Ok(())
    }
}

const fn check_length(what: &'static str, found: usize, rays: &RayBatch<'_>) -> Result<(), BatchError> {
    if found == rays.len() { Ok(()) } else { Err(BatchError::Length { what, found, expected: rays.len() }) }
}

#[cfg(feature = "parallel")]
impl Scene<'_> {
    /// [`closest_batch`](Self::closest_batch) on the threads of the current rayon pool.
    ///
    /// # Errors
    ///
    /// Those of [`closest_batch`](Self::closest_batch).
    pub fn par_closest_batch(&self, rays: &RayBatch<'_>, hits: &mut HitBatch<'_>) -> Result<(), BatchError> {
        hits.check(rays.len())?;
        self.par_closest_range(rays, 0..rays.len(), hits);
        Ok(())
    }

    fn par_closest_range(&self, rays: &RayBatch<'_>, range: Range<usize>, hits: &mut HitBatch<'_>) {
        if range.len() <= RAYS_PER_TASK {
            return self.closest_range(rays, range, hits);
        }
        let n = range.len() / 2;
        let middle = range.start + n;
        let (left, right) = hits.split_at(n);
        let tasks = vec![(range.start..middle, left), (middle..range.end, right)];
        parallel_for_each(tasks, |(range, mut hits)| self.par_closest_range(rays, range, &mut hits));
    }

    /// [`occluded_batch`](Self::occluded_batch) on the threads of the current rayon pool.
    ///
    /// # Errors
    ///
    /// Those of [`occluded_batch`](Self::occluded_batch).
    pub fn par_occluded_batch(&self, rays: &RayBatch<'_>, occluded: &mut [bool]) -> Result<(), BatchError> {
        check_length("truth values", occluded.len(), rays)?;
        parallel_for_each(occluded.chunks_mut(RAYS_PER_TASK).enumerate().collect(), |(i, occluded)| {
            let first = i * RAYS_PER_TASK;
            self.occluded_range(rays, first..first + occluded.len(), occluded);
        });
        Ok(())
    }

    /// [`all_hits_batch`](Self::all_hits_batch) on the threads of the current rayon pool.
    ///
    /// # Errors
    ///
    /// Those of [`all_hits_batch`](Self::all_hits_batch).
    pub fn par_all_hits_batch(&self, rays: &RayBatch<'_>) -> Result<HitLists, BatchError> {
        let mut lists = HitLists::with_capacity(rays.len())?;
        let n_tasks = rays.len().div_ceil(RAYS_OF_LISTS);
        let task = |i: usize| self.all_hits_range(rays, i * RAYS_OF_LISTS..rays.len().min((i + 1) * RAYS_OF_LISTS));
        let parts = parallel_map(n_tasks, task).into_iter().collect::<Result<Vec<_>, _>>()?;
        lists.hits.try_reserve_exact(parts.iter().map(|part| part.hits.len()).sum())?;
        // Each part is freed once it is copied.
        parts.into_iter().for_each(|part| lists.append(&part));
        Ok(lists)
    }

    /// [`count_hits_batch`](Self::count_hits_batch) on the threads of the current rayon pool.
    ///
    /// # Errors
    ///
    /// Those of [`count_hits_batch`](Self::count_hits_batch).
    pub fn par_count_hits_batch(&self, rays: &RayBatch<'_>, counts: &mut [u32]) -> Result<(), BatchError> {
        check_length("counts", counts.len(), rays)?;
        let mut tasks: Vec<_> = counts.chunks_mut(RAYS_OF_LISTS).map(|counts| (counts, Ok(()))).collect();
        parallel_for_each(tasks.iter_mut().enumerate().collect(), |(i, (counts, counted))| {
            *counted = self.count_range(rays, i * RAYS_OF_LISTS, counts);
        });
        Ok(tasks.into_iter().try_for_each(|(_, counted)| counted)?)
    }
}
