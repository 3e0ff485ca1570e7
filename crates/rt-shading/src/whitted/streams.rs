//! Streams of rays with the numbers of their paths.

use super::ray_tree_path::RayTreePath;
use crate::{
    InteriorList,
    interior_list::{InteriorLists, ListRange},
    lane_set::{Element, LaneSet},
    medium_tracker::RayMedia,
    wavefront::streams::{append, times},
};
use rt_geometry::{RayStream, StreamArray};
use rt_math::{Interval, Ray, Rgb, Vector3};

/// Rays of paths, one array for each number.
#[derive(Clone, Debug, Default)]
pub(super) struct RayTreeStream<E: Element> {
    pub(super) rays: RayStream,
    /// Index of the branch of the ray tree.
    pub(super) branch: StreamArray<u32>,
    /// Bounces so far.
    pub(super) depth: StreamArray<u32>,
    /// Factors of their radiance in the pixel.
    pub(super) throughput: [StreamArray<E>; 3],
    /// Media around the rays. [`push_lanes`](Self::push_lanes) does not write them: without refraction, all rays are in air.
    pub(super) media: StreamArray<RayMedia>,
}

impl<E: Element> RayTreeStream<E> {
    pub(super) const fn len(&self) -> usize {
        self.rays.len()
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    pub(super) const fn clear(&mut self) {
        self.rays.clear();
    }

    /// Replaces the rays by camera rays, each of its own branch. `rays` is an unspecified stream afterwards.
    pub(super) fn start(&mut self, rays: &mut RayStream) {
        core::mem::swap(&mut self.rays, rays);
        for (branch, number) in self.branch.as_mut_slice().iter_mut().zip(0..) {
            *branch = number;
        }
        self.depth.as_mut_slice().fill(0);
        for throughput in &mut self.throughput {
            throughput.as_mut_slice().fill(E::rounded(1.0));
        }
    }

    /// Lets all rays start in these media: one list for all of them, or one for each; none for air.
    pub(super) fn start_in(&mut self, camera_media: &[InteriorList], lists: &mut InteriorLists) {
        match camera_media {
            [] | [_] => {
                let list = camera_media.first().map(|list| lists.push(list)).unwrap_or_default();
                self.media.as_mut_slice().fill(RayMedia::new(list));
            }
            of_rays => {
                for (media, list) in self.media.as_mut_slice().iter_mut().zip(of_rays) {
                    *media = RayMedia::new(lists.push(list));
                }
            }
        }
    }

    /// Interior lists of the rays.
    pub(super) fn interiors(&mut self) -> impl Iterator<Item = &mut ListRange> {
        let len = self.len();
        self.media.as_mut_slice()[..len].iter_mut().map(|media| &mut media.interior)
    }

    /// Appends rays of some lanes, one bounce after those of `paths` from index `at` on, and on the same branches. In scenes without
    /// refraction, that is all.
    #[inline(always)]
    pub(super) fn push_lanes<L: LaneSet<Element = E>>(
        &mut self,
        lanes: L,
        mask: u8,
        rays: [Vector3<L::D>; 2],
        throughput: Vector3<L::F>,
        (paths, at, has_time): (&Self, usize, bool),
    ) {
        let end = self.len();
        let time = times(lanes, &paths.rays, at, has_time);
        append(lanes, &mut self.rays, mask, rays, (lanes.splat_f64(f64::INFINITY), time));
        lanes.compress_vector(throughput, mask, &mut self.throughput, end);
        let mut depth = *paths.depth.vector(at);
        depth.iter_mut().for_each(|depth| *depth = depth.wrapping_add(1));
        lanes.compress_u32(&depth, mask, self.depth.vector_mut(end));
        lanes.compress_u32(paths.branch.vector(at), mask, self.branch.vector_mut(end));
    }

    #[inline(always)]
    pub(super) fn push(&mut self, ray: &Ray, span: Interval, path: &RayTreePath) {
        let at = self.len();
        self.rays.push(ray, span);
        self.branch.set(at, path.branch);
        self.depth.set(at, path.depth);
        self.media.set(at, path.media);
        let ([r, g, b], throughput) = (&mut self.throughput, path.throughput);
        r.set(at, E::rounded(throughput.r));
        g.set(at, E::rounded(throughput.g));
        b.set(at, E::rounded(throughput.b));
    }

    #[inline(always)]
    pub(super) fn get(&self, at: usize) -> RayTreePath {
        let [branch, depth] = [self.branch.get(at), self.depth.get(at)];
        RayTreePath { branch, depth, throughput: self.throughput(at), media: self.media.get(at) }
    }

    #[inline(always)]
    pub(super) fn throughput(&self, at: usize) -> Rgb {
        let [r, g, b] = &self.throughput;
        Rgb::new(r.get(at).into(), g.get(at).into(), b.get(at).into())
    }
}
