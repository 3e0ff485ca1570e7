//! Exact tests of primitives behind a dynamic call, so that traversal kernels do not depend on the primitives' type.

use rt_geometry::{
    Hit, HitStream, PacketKernel, PrimitiveGeometry, Primitives, Probe, RayStream, SphereKernel,
    intersect_primitive_stream, intersect_primitive_uncounted, occludes_primitive_stream, occludes_primitive_uncounted,
};
use rt_math::{Interval, Ray};

use super::Output;
use crate::ray_query::{AnyHit, Closest};
use crate::{RayQuery, brute_force, wide::WideBvh};

/// Exact tests of the caller's primitives.
pub(crate) trait PrimitiveTester<O: Output>: PrimitiveKinds {
    /// Tests one primitive; the caller counts the test.
    fn test(&mut self, index: u32, ray: &Ray, span: Interval) -> O;

    /// Tests one primitive with the rays of a stream. The caller counts the tests.
    fn test_stream(&mut self, index: u32, rays: &RayStream, outputs: &mut O::OfStream);

    /// Tests all listed primitives and counts the tests.
    fn test_all(&mut self, indices: &[u32], ray: &Ray, span: Interval) -> O;

    /// Tests all primitives of the set as [`brute_force`](crate::brute_force) does, and counts the tests.
    fn brute_force(&mut self, ray: &Ray, span: Interval) -> O;

    /// Traverses the bounded primitives in `f64`, for rays outside the range of the filters.
    fn traverse_f64(&mut self, tree: &WideBvh, ray: &Ray, span: Interval) -> O;
}

/// Kinds of primitives that packets test in other ways.
pub(crate) trait PrimitiveKinds {
    /// The sphere, if the accelerator may intersect it from its own copy.
    fn exact_sphere(&self, index: u32) -> Option<SphereKernel>;

    /// Exact test of the primitive with several rays.
    fn packet_kernel(&self, index: u32) -> PacketKernel;

    /// True if the primitive occludes rays that hit it.
    fn casts_shadow(&self, index: u32) -> bool;
}

/// The caller's primitives and statistics.
pub(crate) struct Tester<'a, P, S> {
    pub(crate) primitives: &'a P,
    pub(crate) probe: &'a mut S,
}

impl<P: Primitives, S: Probe> PrimitiveKinds for Tester<'_, P, S> {
    fn exact_sphere(&self, index: u32) -> Option<SphereKernel> {
        if let PrimitiveGeometry::ExactSphere(sphere) = self.primitives.geometry(index) { Some(sphere) } else { None }
    }

    fn packet_kernel(&self, index: u32) -> PacketKernel {
        self.primitives.packet_kernel(index)
    }

    fn casts_shadow(&self, index: u32) -> bool {
        self.primitives.casts_shadow(index)
    }
}

impl<P: Primitives, S: Probe> PrimitiveTester<Option<Hit>> for Tester<'_, P, S> {
    fn test(&mut self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        intersect_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }

    fn test_stream(&mut self, index: u32, rays: &RayStream, hits: &mut HitStream) {
        intersect_primitive_stream(self.primitives, index, rays, hits, self.probe);
    }

    fn test_all(&mut self, indices: &[u32], ray: &Ray, span: Interval) -> Option<Hit> {
        let mut query = Closest::new(ray, span);
        let _ = query.test_leaf(self.primitives, indices, self.probe);
        query.hit
    }

    fn brute_force(&mut self, ray: &Ray, span: Interval) -> Option<Hit> {
        brute_force::closest(self.primitives, ray, span, self.probe)
    }

    fn traverse_f64(&mut self, tree: &WideBvh, ray: &Ray, span: Interval) -> Option<Hit> {
        let mut query = Closest::new(ray, span);
        let _ = tree.walk_bounded_erased(self.primitives, &mut query, self.probe);
        query.hit
    }
}

impl<P: Primitives, S: Probe> PrimitiveTester<bool> for Tester<'_, P, S> {
    fn test(&mut self, index: u32, ray: &Ray, span: Interval) -> bool {
        occludes_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }

    fn test_stream(&mut self, index: u32, rays: &RayStream, occluded: &mut [bool]) {
        occludes_primitive_stream(self.primitives, index, rays, occluded, self.probe);
    }

    fn test_all(&mut self, indices: &[u32], ray: &Ray, span: Interval) -> bool {
        AnyHit::new(ray, span).test_leaf(self.primitives, indices, self.probe).is_break()
    }

    fn brute_force(&mut self, ray: &Ray, span: Interval) -> bool {
        brute_force::occluded(self.primitives, ray, span, self.probe)
    }

    fn traverse_f64(&mut self, tree: &WideBvh, ray: &Ray, span: Interval) -> bool {
        tree.walk_bounded_erased(self.primitives, &mut AnyHit::new(ray, span), self.probe).is_break()
    }
}
