//! Batches of rays and of hits as structures of arrays, in the caller's memory.

mod vectors;

use std::collections::TryReserveError;

use rt_geometry::Hit;
use rt_math::{Interval, Ray};

pub use vectors::{Scalars, Vectors};

/// Error of batches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// Two arrays describe different numbers of rays.
    #[error("there are {found} {what} for {expected} rays")]
    Length {
        /// Content of the array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of rays.
        expected: usize,
    },
    /// Lists of hits do not fit into memory.
    #[error("there is no memory for the hits of all rays; trace fewer rays at a time")]
    Memory,
}

impl From<TryReserveError> for BatchError {
    fn from(_: TryReserveError) -> Self {
        Self::Memory
    }
}

/// Rays as a structure of arrays.
///
/// One origin serves any number of directions, and one direction any number of origins. Rays that hold a NaN
/// miss everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayBatch<'a> {
    origins: Vectors<'a>,
    directions: Vectors<'a>,
    t_min: Scalars<'a>,
    t_max: Scalars<'a>,
    len: usize,
}

impl<'a> RayBatch<'a> {
    /// Rays from their origins on, without end.
    ///
    /// # Errors
    ///
    /// [`BatchError::Length`] if there are neither as many origins as directions nor one of either.
    pub fn new(origins: impl Into<Vectors<'a>>, directions: impl Into<Vectors<'a>>) -> Result<Self, BatchError> {
        let (origins, directions) = (origins.into(), directions.into());
        let len = match (origins.len(), directions.len()) {
            (1, n) | (n, 1) => n,
            (n, m) if n == m => n,
            (found, expected) => return Err(BatchError::Length { what: "origins", found, expected }),
        };
        Ok(Self { origins, directions, t_min: Scalars::Same(0.0), t_max: Scalars::Same(f64::INFINITY), len })
    }

    /// These rays, limited to the parameters from `t_min` to `t_max`, both inclusive.
    ///
    /// # Errors
    ///
    /// [`BatchError::Length`] if an array does not hold one number for each ray.
    pub fn with_t_range(
        self,
        t_min: impl Into<Scalars<'a>>,
        t_max: impl Into<Scalars<'a>>,
    ) -> Result<Self, BatchError> {
        let (t_min, t_max) = (t_min.into(), t_max.into());
        for (what, values) in [("values of t_min", t_min), ("values of t_max", t_max)] {
            if let Some(found) = values.len().filter(|found| *found != self.len) {
                return Err(BatchError::Length { what, found, expected: self.len });
            }
        }
        Ok(Self { t_min, t_max, ..self })
    }

    /// Number of rays.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// True if there are none.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Ray `index` with its interval.
    #[inline]
    pub fn get(&self, index: usize) -> (Ray, Interval) {
        let ray = Ray::new(self.origins.get(index), self.directions.get(index));
        (ray, Interval::new(self.t_min.get(index), self.t_max.get(index)))
    }
}

/// Closest hits as a structure of arrays: entry `i` belongs to ray `i` and is overwritten.
///
/// A miss has `t` ∞, `primitive` and `instance` [`MISS`](Self::MISS), and `uv` 0.
#[derive(Debug)]
pub struct HitBatch<'a> {
    /// Ray parameters.
    pub t: &'a mut [f64],
    /// Indices of the primitives in their geometries.
    pub primitive: &'a mut [u32],
    /// Indices of the instances, if requested.
    pub instance: Option<&'a mut [u32]>,
    /// Barycentric weights of the second and third vertex, if requested.
    pub uv: Option<&'a mut [[f64; 2]]>,
}

impl HitBatch<'_> {
    /// Index of the primitive and of the instance of a miss: -1 in two's complement.
    pub const MISS: u32 = u32::MAX;

    /// Checks that there is one entry for each ray.
    pub(crate) fn check(&self, n_rays: usize) -> Result<(), BatchError> {
        let lengths = [
            ("values of t", Some(self.t.len())),
            ("numbers of primitives", Some(self.primitive.len())),
            ("numbers of instances", self.instance.as_ref().map(|ids| ids.len())),
            ("barycentric coordinates", self.uv.as_ref().map(|uv| uv.len())),
        ];
        for (what, found) in lengths {
            if let Some(found) = found.filter(|found| *found != n_rays) {
                return Err(BatchError::Length { what, found, expected: n_rays });
            }
        }
        Ok(())
    }

    /// The first `n` entries, at most all, and the rest.
    #[cfg_attr(not(feature = "parallel"), expect(dead_code, reason = "batches are split among threads"))]
    pub(crate) fn split_at(&mut self, n: usize) -> (HitBatch<'_>, HitBatch<'_>) {
        let n = n.min(self.t.len());
        let (t, t_rest) = self.t.split_at_mut(n);
        let (primitive, primitive_rest) = self.primitive.split_at_mut(n);
        let (instance, instance_rest) = self.instance.as_mut().map(|ids| ids.split_at_mut(n)).unzip();
        let (uv, uv_rest) = self.uv.as_mut().map(|uv| uv.split_at_mut(n)).unzip();
        (
            HitBatch { t, primitive, instance, uv },
            HitBatch { t: t_rest, primitive: primitive_rest, instance: instance_rest, uv: uv_rest },
        )
    }

    /// Writes the entry of a ray.
    #[inline]
    pub(crate) fn set(&mut self, index: usize, hit: Option<&Hit>) {
        let (t, primitive, instance, uv) = match hit {
            Some(hit) => (hit.t, hit.primitive, hit.instance, hit.uv),
            None => (f64::INFINITY, Self::MISS, Self::MISS, [0.0; 2]),
        };
        self.t[index] = t;
        self.primitive[index] = primitive;
        if let Some(ids) = &mut self.instance {
            ids[index] = instance;
        }
        if let Some(all) = &mut self.uv {
            all[index] = uv;
        }
    }
}
