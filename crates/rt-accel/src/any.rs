//! Choice of the accelerator at run time.

use core::ops::ControlFlow;

use crate::wide::{BuildParams, Quality, SimdLevel};
use crate::{
    Accelerator, Bih, BspTree, BuildError, BuildStats, Bvh, CylinderTree, KdTree, LazyBih, Linear, RayQuery,
    RegionQuery, SphereTree, UniformGrid, ValidationError, WideBvh,
};
use rt_geometry::{Hit, Primitives, Probe};
use rt_math::{Aabb, Interval, Ray};

/// Generic operation on an accelerator of any type.
pub trait AcceleratorVisitor {
    /// Result of the operation.
    type Output;

    /// Performs the operation.
    fn visit<T: Accelerator>(self, accelerator: &T) -> Self::Output;
}

/// Kind of accelerator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AcceleratorKind {
    /// Brute force.
    Linear,
    /// Uniform grid.
    Grid,
    /// Binary tree of boxes.
    Bvh,
    /// Tree of boxes with eight children per node.
    Wide,
    /// Tree of axis-aligned planes.
    Kd,
    /// Tree of planes of any direction.
    Bsp,
    /// Tree of spheres.
    Spheres,
    /// Tree of cylinders.
    Cylinders,
    /// Bounding interval hierarchy.
    Bih,
    /// Bounding interval hierarchy that is built on demand.
    BihLazy,
}

impl AcceleratorKind {
    /// All kinds.
    pub const ALL: &[Self] = &[
        Self::Linear,
        Self::Grid,
        Self::Bvh,
        Self::Wide,
        Self::Kd,
        Self::Bsp,
        Self::Spheres,
        Self::Cylinders,
        Self::Bih,
        Self::BihLazy,
    ];

    /// Short name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Grid => "grid",
            Self::Bvh => "bvh",
            Self::Wide => "wide",
            Self::Kd => "kd",
            Self::Bsp => "bsp",
            Self::Spheres => "spheres",
            Self::Cylinders => "cylinders",
            Self::Bih => "bih",
            Self::BihLazy => "bih-lazy",
        }
    }
}

/// Accelerator of a kind that is chosen at run time, at the cost of one `match` per query.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AnyAccelerator {
    /// Brute force.
    Linear(Linear),
    /// Uniform grid.
    Grid(UniformGrid),
    /// Binary tree of boxes.
    Bvh(Bvh),
    /// Tree of boxes with eight children per node.
    Wide(WideBvh),
    /// Tree of axis-aligned planes.
    Kd(KdTree),
    /// Tree of planes of any direction.
    Bsp(BspTree),
    /// Tree of spheres.
    Spheres(SphereTree),
    /// Tree of cylinders.
    Cylinders(CylinderTree),
    /// Bounding interval hierarchy.
    Bih(Bih),
    /// Bounding interval hierarchy that is built on demand.
    BihLazy(LazyBih),
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
        Ok(match kind {
            AcceleratorKind::Linear => Self::Linear(Linear::build(primitives)?),
            AcceleratorKind::Grid => Self::Grid(UniformGrid::build(primitives)?),
            AcceleratorKind::Bvh => Self::Bvh(Bvh::build(primitives)?),
            AcceleratorKind::Wide => Self::Wide(WideBvh::build(primitives)?),
            AcceleratorKind::Kd => Self::Kd(KdTree::build(primitives)?),
            AcceleratorKind::Bsp => Self::Bsp(BspTree::build(primitives)?),
            AcceleratorKind::Spheres => Self::Spheres(SphereTree::build(primitives)?),
            AcceleratorKind::Cylinders => Self::Cylinders(CylinderTree::build(primitives)?),
            AcceleratorKind::Bih => Self::Bih(Bih::build(primitives)?),
            AcceleratorKind::BihLazy => Self::BihLazy(LazyBih::build(primitives)?),
        })
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
            other => Self::build(other, primitives),
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

    /// Kind of the accelerator.
    pub const fn kind(&self) -> AcceleratorKind {
        match self {
            Self::Linear(_) => AcceleratorKind::Linear,
            Self::Grid(_) => AcceleratorKind::Grid,
            Self::Bvh(_) => AcceleratorKind::Bvh,
            Self::Wide(_) => AcceleratorKind::Wide,
            Self::Kd(_) => AcceleratorKind::Kd,
            Self::Bsp(_) => AcceleratorKind::Bsp,
            Self::Spheres(_) => AcceleratorKind::Spheres,
            Self::Cylinders(_) => AcceleratorKind::Cylinders,
            Self::Bih(_) => AcceleratorKind::Bih,
            Self::BihLazy(_) => AcceleratorKind::BihLazy,
        }
    }
}

impl Accelerator for AnyAccelerator {
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        dispatch!(self, accelerator => accelerator.traverse_ray(primitives, query, probe))
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        dispatch!(self, accelerator => accelerator.traverse_region(query))
    }

    fn memory(&self) -> usize {
        dispatch!(self, accelerator => accelerator.memory())
    }

    fn build_stats(&self) -> BuildStats {
        dispatch!(self, accelerator => accelerator.build_stats())
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        dispatch!(self, accelerator => accelerator.validate(primitives))
    }

    fn for_each_box(&self, visit: impl FnMut(Aabb, u32)) {
        dispatch!(self, accelerator => accelerator.for_each_box(visit))
    }

    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        dispatch!(self, accelerator => accelerator.closest(primitives, ray, span, probe))
    }

    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        dispatch!(self, accelerator => accelerator.occluded(primitives, ray, span, probe))
    }

    fn closest_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        dispatch!(self, accelerator => accelerator.closest_batch(primitives, rays, hits, probe))
    }

    fn occluded_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        dispatch!(self, accelerator => accelerator.occluded_batch(primitives, rays, occluded, probe))
    }
}
