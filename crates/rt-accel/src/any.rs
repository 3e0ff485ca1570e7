//! Choice of the accelerator at run time.

use core::ops::ControlFlow;

use crate::accelerator::{closest_one_by_one, occluded_one_by_one};
use crate::erased::{self, DynPrimitives, DynRayQuery, DynRegionQuery, NodeCount};
use crate::ray_query::{AnyHit, Closest};
use crate::wide::{BuildParams, Quality, SimdLevel};
use crate::{
    Accelerator, Bih, BspTree, BuildError, BuildStats, Bvh, CylinderTree, KdTree, LazyBih, Linear, RayQuery,
    RegionQuery, SphereTree, UniformGrid, ValidationError, WideBvh,
};
use rt_geometry::{Hit, HitStream, Primitives, Probe, RayStream};
use rt_math::{Aabb, Interval, Ray};

/// Generic operation on an accelerator of any type.
pub trait AcceleratorVisitor {
    /// Result of the operation.
    type Output;

    /// Performs the operation.
    fn visit<T: Accelerator>(self, accelerator: &T) -> Self::Output;
}

/// Defines the enums over all kinds from one list.
macro_rules! accelerators {
    ($($(#[$doc:meta])* $name:ident($accelerator:ty) = $text:literal,)+) => {
        /// Kind of accelerator.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum AcceleratorKind {
            $($(#[$doc])* $name,)+
        }

        impl AcceleratorKind {
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$name),+];

            /// Short name in lower case.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)+
                }
            }
        }

        /// Accelerator of a kind that is chosen at run time, at the cost of one `match` per query.
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum AnyAccelerator {
            $($(#[$doc])* $name($accelerator),)+
        }

        impl AnyAccelerator {
            fn build_erased(kind: AcceleratorKind, primitives: &DynPrimitives<'_>) -> Result<Self, BuildError> {
                Ok(match kind {
                    $(AcceleratorKind::$name => Self::$name(<$accelerator>::build(primitives)?),)+
                })
            }

            /// Kind of the accelerator.
            pub const fn kind(&self) -> AcceleratorKind {
                match self {
                    $(Self::$name(_) => AcceleratorKind::$name,)+
                }
            }
        }
    };
}

accelerators! {
    /// Brute force.
    Linear(Linear) = "linear",
    /// Uniform grid.
    Grid(UniformGrid) = "grid",
    /// Binary tree of boxes.
    Bvh(Bvh) = "bvh",
    /// Tree of boxes with eight children per node.
    Wide(WideBvh) = "bvh8",
    /// Tree of axis-aligned planes.
    Kd(KdTree) = "kd",
    /// Tree of planes of any direction.
    Bsp(BspTree) = "bsp",
    /// Tree of spheres.
    Spheres(SphereTree) = "sphere-tree",
    /// Tree of cylinders.
    Cylinders(CylinderTree) = "cylinder-tree",
    /// Bounding interval hierarchy.
    Bih(Bih) = "bih",
    /// Bounding interval hierarchy that is built on demand.
    BihLazy(LazyBih) = "bih-lazy",
}

/// Evaluates an expression for the accelerator of the kind at hand.
macro_rules! dispatch {
    ($any:expr, $accelerator:ident => $value:expr) => {
        match $any {
            AnyAccelerator::Linear($accelerator) => $value,
            AnyAccelerator::Grid($accelerator) => $value,
            AnyAccelerator::Bvh($accelerator) => $value,
            AnyAccelerator::Wide($accelerator) => $value,
            AnyAccelerator::Kd($accelerator) => $value,
            AnyAccelerator::Bsp($accelerator) => $value,
            AnyAccelerator::Spheres($accelerator) => $value,
            AnyAccelerator::Cylinders($accelerator) => $value,
            AnyAccelerator::Bih($accelerator) => $value,
            AnyAccelerator::BihLazy($accelerator) => $value,
        }
    };
}

impl AnyAccelerator {
    /// Builds an accelerator with the defaults of its kind.
    ///
    /// # Errors
    ///
    /// Those of the builder of that kind.
    pub fn build<P: Primitives>(kind: AcceleratorKind, primitives: &P) -> Result<Self, BuildError> {
        Self::build_with(kind, Quality::default(), primitives)
    }

    /// Builds an accelerator of a given quality. Affects [`WideBvh`] only; other kinds use their defaults.
    ///
    /// # Errors
    ///
    /// Those of the builder of that kind.
    pub fn build_with<P: Primitives>(
        kind: AcceleratorKind,
        quality: Quality,
        primitives: &P,
    ) -> Result<Self, BuildError> {
        match kind {
            AcceleratorKind::Wide => {
                let params = BuildParams { quality, ..BuildParams::default() };
                Ok(Self::Wide(WideBvh::build_with(primitives, &params)?))
            }
            other => Self::build_erased(other, &DynPrimitives::new(primitives)),
        }
    }

    /// Sets the instruction set of a [`Linear`] or [`WideBvh`], without effect on results.
    #[must_use]
    pub fn with_level(self, level: SimdLevel) -> Self {
        match self {
            Self::Linear(linear) => Self::Linear(linear.with_level(level)),
            Self::Wide(wide) => Self::Wide(wide.with_level(level)),
            other => other,
        }
    }

    /// Passes the concrete accelerator to a visitor: one `match` for many queries.
    pub fn accept<V: AcceleratorVisitor>(&self, visitor: V) -> V::Output {
        dispatch!(self, accelerator => visitor.visit(accelerator))
    }
}

/// Traversals, compiled once for all queries.
impl AnyAccelerator {
    fn traverse_ray_erased(
        &self,
        primitives: &DynPrimitives<'_>,
        query: &mut DynRayQuery<'_>,
        probe: &mut NodeCount,
    ) -> ControlFlow<()> {
        dispatch!(self, accelerator => accelerator.traverse_ray(primitives, query, probe))
    }

    fn traverse_region_erased(&self, query: &mut DynRegionQuery<'_>) -> ControlFlow<()> {
        dispatch!(self, accelerator => accelerator.traverse_region(query))
    }

    fn validate_erased(&self, primitives: &DynPrimitives<'_>) -> Result<(), ValidationError> {
        dispatch!(self, accelerator => accelerator.validate(primitives))
    }

    fn for_each_box_erased(&self, visit: &mut dyn FnMut(Aabb, u32)) {
        dispatch!(self, accelerator => accelerator.for_each_box(visit))
    }
}

/// Queries of [`Linear`] and [`WideBvh`] are compiled for each type of primitives. Those of other accelerators make a dynamic call
/// per leaf; [`accept`](AnyAccelerator::accept) passes the accelerator to a visitor instead.
impl Accelerator for AnyAccelerator {
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        erased::traverse_ray(primitives, query, probe, |primitives, query, probe| {
            self.traverse_ray_erased(primitives, query, probe)
        })
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        self.traverse_region_erased(&mut DynRegionQuery::new(query))
    }

    fn memory(&self) -> usize {
        dispatch!(self, accelerator => accelerator.memory())
    }

    fn build_stats(&self) -> BuildStats {
        dispatch!(self, accelerator => accelerator.build_stats())
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.validate_erased(&DynPrimitives::new(primitives))
    }

    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        self.for_each_box_erased(&mut visit);
    }

    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        match self {
            Self::Linear(linear) => linear.closest(primitives, ray, span, probe),
            Self::Wide(wide) => wide.closest(primitives, ray, span, probe),
            other => {
                let mut query = Closest::new(ray, span);
                let _ = other.traverse_ray(primitives, &mut query, probe);
                query.hit
            }
        }
    }

    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        match self {
            Self::Linear(linear) => linear.occluded(primitives, ray, span, probe),
            Self::Wide(wide) => wide.occluded(primitives, ray, span, probe),
            other => other.traverse_ray(primitives, &mut AnyHit::new(ray, span), probe).is_break(),
        }
    }

    fn closest_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        match self {
            Self::Linear(linear) => linear.closest_stream(primitives, rays, hits, probe),
            Self::Wide(wide) => wide.closest_stream(primitives, rays, hits, probe),
            other => closest_one_by_one(other, primitives, rays, hits, probe),
        }
    }

    fn occluded_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        match self {
            Self::Linear(linear) => linear.occluded_stream(primitives, rays, occluded, probe),
            Self::Wide(wide) => wide.occluded_stream(primitives, rays, occluded, probe),
            other => occluded_one_by_one(other, primitives, rays, occluded, probe),
        }
    }
}

#[cfg(all(test, feature = "parallel"))]
mod tests {
    use glam::DVec3;
    use rt_math::Aabb;
    use rt_math::random::{hash, unit};

    use super::{AcceleratorKind, AnyAccelerator};
    use crate::Boxes;

    /// Small boxes, enough of them for every builder to fork.
    fn boxes(count: u64) -> Vec<Aabb> {
        let vector = |i, k| DVec3::new(unit(hash(&[i, k])), unit(hash(&[i, k + 1])), unit(hash(&[i, k + 2])));
        let corners = |i| (vector(i, 0), vector(i, 3) * 0.02 * unit(hash(&[i, 6])));
        (0..count).map(corners).map(|(centre, half)| Aabb::new(centre - half, centre + half)).collect()
    }

    #[test]
    fn every_accelerator_is_independent_of_the_number_of_threads() {
        let boxes = boxes(20_000);
        for &kind in AcceleratorKind::ALL {
            let on = |n_threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool");
                pool.install(|| AnyAccelerator::build(kind, &Boxes(&boxes)).expect("boxes"))
            };
            assert!(on(7) == on(1), "{}", kind.name());
        }
    }
}
