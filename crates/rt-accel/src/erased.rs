//! Queries and primitives behind dynamic calls. Traversals and builders that use them are compiled once, and not for each
//! type of primitives, query and probe.
//!
//! A traversal makes one dynamic call per leaf. A builder makes a few per primitive.

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{Hit, PacketKernel, PrimitiveGeometry, Primitives, Probe};
use rt_math::{Aabb, Interval, Ray, SlabRay};

use crate::ray_query::ray_and_span;
use crate::{RayQuery, RegionQuery};

/// Primitives of any type, without statistics.
pub(crate) struct DynPrimitives<'p>(&'p dyn ErasedPrimitives);

impl<'p> DynPrimitives<'p> {
    pub(crate) const fn new<P: Primitives>(primitives: &'p P) -> Self {
        Self(primitives)
    }
}

/// Methods of [`Primitives`] that builders call.
trait ErasedPrimitives: Sync {
    fn len(&self) -> usize;
    fn bounds(&self, index: u32) -> Option<Aabb>;
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit>;
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool;
    fn packet_kernel(&self, index: u32) -> PacketKernel;
    fn hit_ids(&self, index: u32) -> [u32; 2];
    fn casts_shadow(&self, index: u32) -> bool;
    fn geometry(&self, index: u32) -> PrimitiveGeometry;
}

/// Implements a trait for primitives by calls of the methods of another one.
macro_rules! forward_primitives {
    ($primitives:ident => $value:expr) => {
        fn len(&self) -> usize {
            let $primitives = self;
            $value.len()
        }

        fn bounds(&self, index: u32) -> Option<Aabb> {
            let $primitives = self;
            $value.bounds(index)
        }

        fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
            let $primitives = self;
            $value.intersect(index, ray, span)
        }

        fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
            let $primitives = self;
            $value.occludes(index, ray, span)
        }

        fn packet_kernel(&self, index: u32) -> PacketKernel {
            let $primitives = self;
            $value.packet_kernel(index)
        }

        fn hit_ids(&self, index: u32) -> [u32; 2] {
            let $primitives = self;
            $value.hit_ids(index)
        }

        fn casts_shadow(&self, index: u32) -> bool {
            let $primitives = self;
            $value.casts_shadow(index)
        }

        fn geometry(&self, index: u32) -> PrimitiveGeometry {
            let $primitives = self;
            $value.geometry(index)
        }
    };
}

impl<P: Primitives> ErasedPrimitives for P {
    forward_primitives!(primitives => primitives);
}

impl Primitives for DynPrimitives<'_> {
    forward_primitives!(primitives => primitives.0);
}

/// Tests a leaf. Returns the flow and the new end of the span.
type LeafCall<'q> = &'q mut dyn FnMut(&[u32]) -> (ControlFlow<()>, f64);

/// Query along a ray whose tests are a dynamic call per leaf. It ignores the primitives and the probe that a traversal passes to
/// it: the call tests those of the caller.
pub(crate) struct DynRayQuery<'q> {
    ray: SlabRay,
    span: Interval,
    test: LeafCall<'q>,
}

impl RayQuery for DynRayQuery<'_> {
    ray_and_span!();

    #[inline]
    fn test_primitive<P: Primitives, S: Probe>(
        &mut self,
        primitives: &P,
        index: u32,
        probe: &mut S,
    ) -> ControlFlow<()> {
        self.test_leaf(primitives, &[index], probe)
    }

    #[inline]
    fn test_leaf<P: Primitives, S: Probe>(&mut self, _: &P, indices: &[u32], _: &mut S) -> ControlFlow<()> {
        let flow;
        (flow, self.span.max) = (self.test)(indices);
        flow
    }
}

/// Number of nodes that a traversal visits.
#[derive(Default)]
pub(crate) struct NodeCount(u64);

impl Probe for NodeCount {
    #[inline]
    fn node(&mut self) {
        self.0 += 1;
    }
}

/// Runs a traversal of dynamic queries for a query of a caller.
#[inline]
pub(crate) fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
    primitives: &P,
    query: &mut Q,
    probe: &mut S,
    traversal: impl FnOnce(&DynPrimitives<'_>, &mut DynRayQuery<'_>, &mut NodeCount) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let (ray, span) = (*query.ray(), query.span());
    let mut test = |indices: &[u32]| {
        let flow = query.test_leaf(primitives, indices, probe);
        (flow, query.span().max)
    };
    let mut nodes = NodeCount::default();
    let mut erased = DynRayQuery { ray, span, test: &mut test };
    let flow = traversal(&DynPrimitives::new(primitives), &mut erased, &mut nodes);
    probe.work(nodes.0, 0, 0);
    flow
}

/// Query in a region behind a dynamic call for each method.
pub(crate) struct DynRegionQuery<'q>(&'q mut dyn ErasedRegionQuery);

impl<'q> DynRegionQuery<'q> {
    pub(crate) const fn new<Q: RegionQuery>(query: &'q mut Q) -> Self {
        Self(query)
    }
}

/// Methods of [`RegionQuery`].
trait ErasedRegionQuery {
    fn bounds(&self) -> Aabb;
    fn query_point(&self) -> DVec3;
    fn distance_to(&self, aabb: &Aabb) -> Option<f64>;
    fn test_primitive(&mut self, index: u32, is_owner: &mut dyn FnMut(DVec3) -> bool) -> ControlFlow<()>;
    fn test_leaf(&mut self, indices: &[u32]) -> ControlFlow<()>;
}

impl<Q: RegionQuery> ErasedRegionQuery for Q {
    fn bounds(&self) -> Aabb {
        self.bounds()
    }

    fn query_point(&self) -> DVec3 {
        self.query_point()
    }

    fn distance_to(&self, aabb: &Aabb) -> Option<f64> {
        self.distance_to(aabb)
    }

    fn test_primitive(&mut self, index: u32, is_owner: &mut dyn FnMut(DVec3) -> bool) -> ControlFlow<()> {
        self.test_primitive(index, is_owner)
    }

    fn test_leaf(&mut self, indices: &[u32]) -> ControlFlow<()> {
        self.test_leaf(indices)
    }
}

impl RegionQuery for DynRegionQuery<'_> {
    fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    fn query_point(&self) -> DVec3 {
        self.0.query_point()
    }

    fn distance_to(&self, aabb: &Aabb) -> Option<f64> {
        self.0.distance_to(aabb)
    }

    fn test_primitive(&mut self, index: u32, is_owner: impl FnOnce(DVec3) -> bool) -> ControlFlow<()> {
        let mut is_owner = Some(is_owner);
        let mut owns_once = |point| is_owner.take().is_some_and(|is_owner| is_owner(point));
        self.0.test_primitive(index, &mut owns_once)
    }

    fn test_leaf(&mut self, indices: &[u32]) -> ControlFlow<()> {
        self.0.test_leaf(indices)
    }
}
