//! Streams of rays with the numbers of their paths.

use super::ray_tree::TreePath;
use crate::lane_set::Element;
use rt_geometry::{RayStream, StreamArray};
use rt_math::{Interval, Ray, Rgb};

/// Rays of paths, one array for each number.
#[derive(Clone, Debug, Default)]
pub(super) struct TreeStream<E: Element> {
    pub(super) rays: RayStream,
    /// Index of the camera ray.
    pub(super) sample: StreamArray<u32>,
    /// Bounces so far.
    pub(super) depth: StreamArray<u32>,
    /// Weight of its radiance in the pixel.
    pub(super) weight: [StreamArray<E>; 3],
}

impl<E: Element> TreeStream<E> {
    pub(super) const fn len(&self) -> usize {
        self.rays.len()
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    pub(super) const fn clear(&mut self) {
        self.rays.clear();
    }

    /// Replaces the rays by camera rays, each of its own sample. `rays` is an unspecified stream afterwards.
    pub(super) fn start(&mut self, rays: &mut RayStream) {
        core::mem::swap(&mut self.rays, rays);
        for (sample, number) in self.sample.as_mut_slice().iter_mut().zip(0..) {
            *sample = number;
        }
        self.depth.as_mut_slice().fill(0);
        for weight in &mut self.weight {
            weight.as_mut_slice().fill(E::rounded(1.0));
        }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, ray: &Ray, span: Interval, path: &TreePath) {
        let at = self.len();
        self.rays.push(ray, span);
        self.sample.set(at, path.sample);
        self.depth.set(at, path.depth);
        let ([r, g, b], weight) = (&mut self.weight, path.weight);
        r.set(at, E::rounded(weight.r));
        g.set(at, E::rounded(weight.g));
        b.set(at, E::rounded(weight.b));
    }

    #[inline(always)]
    pub(super) fn get(&self, at: usize) -> TreePath {
        TreePath { sample: self.sample.get(at), depth: self.depth.get(at), weight: self.weight(at) }
    }

    #[inline(always)]
    pub(super) fn weight(&self, at: usize) -> Rgb {
        let [r, g, b] = &self.weight;
        Rgb::new(r.get(at).into(), g.get(at).into(), b.get(at).into())
    }
}
