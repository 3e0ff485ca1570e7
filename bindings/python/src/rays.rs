//! Rays of a call as batches, slice by slice, on the threads of the call.

use pyo3::prelude::*;
use rt_accel::RayBatch;

use crate::arrays::{Gathered, Parameters, ParametersView, Rows, RowsView};
use crate::error::value_error;
use crate::threads::Threads;

/// Rays that a thread takes at a time. Few enough that the arrays of their results stay in the cache.
const RAYS_PER_THREAD: usize = 1 << 16;

/// Rays below which a call stays on one thread, as few as queries of rt-accel give to one.
const MIN_RAYS_TO_SHARE: usize = 1 << 14;

/// Threads beyond which slices do not grow, so that intermediate results take tens of megabytes.
const MAX_THREADS_PER_SLICE: usize = 16;

/// Rays of a call.
pub(crate) struct Rays<'py> {
    origins: Rows<'py>,
    directions: Rows<'py>,
    t_min: Parameters<'py>,
    t_max: Parameters<'py>,
}

impl<'py> Rays<'py> {
    /// Rays between two parameters, each a number or an array.
    pub(crate) fn extract([origins, directions, t_min, t_max]: [&Bound<'py, PyAny>; 4]) -> PyResult<Self> {
        Ok(Self {
            origins: Rows::extract("origins", origins)?,
            directions: Rows::extract("directions", directions)?,
            t_min: Parameters::extract("t_min", t_min)?,
            t_max: Parameters::extract("t_max", t_max)?,
        })
    }

    /// Rays from their origins on, without end.
    pub(crate) fn extract_endless([origins, directions]: [&Bound<'py, PyAny>; 2]) -> PyResult<Self> {
        Ok(Self {
            origins: Rows::extract("origins", origins)?,
            directions: Rows::extract("directions", directions)?,
            t_min: Parameters::Same(0.0),
            t_max: Parameters::Same(f64::INFINITY),
        })
    }

    /// The rays as views; one origin serves all directions, and one direction all origins.
    pub(crate) fn view(&self) -> PyResult<RaysView<'_>> {
        let len = match (self.origins.len(), self.directions.len()) {
            (1, n) | (n, 1) => n,
            (n, m) if n == m => n,
            (n, m) => return Err(value_error(format!("there are {n} origins for {m} directions"))),
        };
        let (origins, directions) = (self.origins.view(), self.directions.view());
        Ok(RaysView { origins, directions, t_min: self.t_min.view()?, t_max: self.t_max.view()?, len })
    }
}

/// Rays of a call as views.
pub(crate) struct RaysView<'a> {
    origins: RowsView<'a>,
    directions: RowsView<'a>,
    t_min: ParametersView<'a>,
    t_max: ParametersView<'a>,
    pub(crate) len: usize,
}

impl RaysView<'_> {
    /// Threads of the call: the given number, or one for few rays.
    pub(crate) fn threads(&self, py: Python<'_>, threads: usize) -> PyResult<Threads> {
        Threads::new(py, threads, self.len.div_ceil(MIN_RAYS_TO_SHARE))
    }

    /// Calls `trace` with one slice of rays after the other, and the index of its first ray, for results that are written
    /// in place.
    pub(crate) fn for_each_slice(
        &self,
        is_parallel: bool,
        trace: impl FnMut(usize, &RayBatch<'_>) -> PyResult<()>,
    ) -> PyResult<()> {
        let in_place = self.origins.is_contiguous() && self.directions.is_contiguous();
        self.for_each_slice_of(
            if is_parallel && in_place { self.len } else { slice_len(is_parallel) },
            is_parallel,
            trace,
        )
    }

    /// [`for_each_slice`](Self::for_each_slice) for intermediate results of each slice: slices are small.
    pub(crate) fn for_each_small_slice(
        &self,
        is_parallel: bool,
        trace: impl FnMut(usize, &RayBatch<'_>) -> PyResult<()>,
    ) -> PyResult<()> {
        self.for_each_slice_of(slice_len(is_parallel), is_parallel, trace)
    }

    fn for_each_slice_of(
        &self,
        step: usize,
        is_parallel: bool,
        mut trace: impl FnMut(usize, &RayBatch<'_>) -> PyResult<()>,
    ) -> PyResult<()> {
        let (mut origins, mut directions) = (Gathered::default(), Gathered::default());
        for first in (0..self.len).step_by(step.max(1)) {
            let n = step.min(self.len - first);
            // Just before the rays are traced, so that the numbers are read from memory once.
            for (what, rows) in [("origins", self.origins), ("directions", self.directions)] {
                if let Some(row) = rows.first_non_finite(first, n, is_parallel) {
                    return Err(value_error(format!("row {row} of {what} holds a number that is not finite")));
                }
            }
            for (what, limits) in [("t_min", self.t_min), ("t_max", self.t_max)] {
                if let Some(row) = limits.first_nan(first, n) {
                    return Err(value_error(format!("row {row} of {what} is not a number")));
                }
            }
            let vectors =
                self.origins.vectors(first, n, &mut origins).zip(self.directions.vectors(first, n, &mut directions));
            let limits = self.t_min.scalars(first, n).zip(self.t_max.scalars(first, n));
            let Some(((origins, directions), (t_min, t_max))) = vectors.zip(limits) else {
                let message = format!("t_min and t_max must be numbers, or arrays of {} numbers", self.len);
                return Err(value_error(message));
            };
            let rays = RayBatch::new(origins, directions).and_then(|rays| rays.with_t_range(t_min, t_max));
            trace(first, &rays.map_err(value_error)?)?;
        }
        Ok(())
    }
}

fn slice_len(is_parallel: bool) -> usize {
    let threads = if is_parallel { rayon::current_num_threads().min(MAX_THREADS_PER_SLICE) } else { 1 };
    RAYS_PER_THREAD * threads
}
