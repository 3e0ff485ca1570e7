//! The closed set of acceleration structures: one `match` for each axis of choice.

use rt_accel::{Accelerator, BuildError, BuildStats, Bvh, Linear, UniformGrid};
use rt_math::{Hit, Interval, Primitives, Probe, Ray};
use rt_scene_io::Accel;

/// Up to this many primitives, asking each is faster than walking a tree.
const FEW: usize = 8;

/// A built structure over some set of primitives.
#[derive(Debug)]
pub(crate) enum Structure {
    Linear(Linear),
    Grid(UniformGrid),
    Bvh(Bvh),
}

impl Structure {
    /// Builds what `accel` asks for; `Auto` is brute force for a few primitives and a hierarchy otherwise.
    pub(crate) fn build<P: Primitives>(accel: Accel, primitives: &P) -> Result<Self, BuildError> {
        Ok(match accel {
            Accel::Linear => Self::Linear(Linear::build(primitives)?),
            Accel::Grid => Self::Grid(UniformGrid::build(primitives)?),
            Accel::Bvh => Self::Bvh(Bvh::build(primitives)?),
            Accel::Auto if primitives.len() <= FEW => Self::Linear(Linear::build(primitives)?),
            Accel::Auto => Self::Bvh(Bvh::build(primitives)?),
        })
    }

    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Linear(_) => "linear",
            Self::Grid(_) => "grid",
            Self::Bvh(_) => "bvh",
        }
    }

    pub(crate) fn memory(&self) -> usize {
        match self {
            Self::Linear(s) => s.memory(),
            Self::Grid(s) => s.memory(),
            Self::Bvh(s) => s.memory(),
        }
    }

    pub(crate) fn build_stats(&self) -> BuildStats {
        match self {
            Self::Linear(s) => s.build_stats(),
            Self::Grid(s) => s.build_stats(),
            Self::Bvh(s) => s.build_stats(),
        }
    }
}

impl Accelerator for Structure {
    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        match self {
            Self::Linear(s) => s.closest(primitives, ray, span, probe),
            Self::Grid(s) => s.closest(primitives, ray, span, probe),
            Self::Bvh(s) => s.closest(primitives, ray, span, probe),
        }
    }

    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        match self {
            Self::Linear(s) => s.occluded(primitives, ray, span, probe),
            Self::Grid(s) => s.occluded(primitives, ray, span, probe),
            Self::Bvh(s) => s.occluded(primitives, ray, span, probe),
        }
    }
}
