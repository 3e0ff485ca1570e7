//! The structures that are measured.

use rt_accel::{Accelerator, BuildError, Bvh, Linear, NoProbe, Primitives, UniformGrid};

use super::rays::RaySet;

/// What to build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Linear,
    Grid,
    Bvh,
}

impl Kind {
    pub(super) const ALL: [Self; 3] = [Self::Linear, Self::Grid, Self::Bvh];

    /// The name that `--accel` has for it.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Grid => "grid",
            Self::Bvh => "bvh",
        }
    }
}

/// A structure that was built.
#[derive(Debug)]
pub(super) enum Structure {
    Linear(Linear),
    Grid(UniformGrid),
    Bvh(Bvh),
}

impl Structure {
    pub(super) fn build<P: Primitives>(kind: Kind, primitives: &P) -> Result<Self, BuildError> {
        Ok(match kind {
            Kind::Linear => Self::Linear(Linear::build(primitives)?),
            Kind::Grid => Self::Grid(UniformGrid::build(primitives)?),
            Kind::Bvh => Self::Bvh(Bvh::build(primitives)?),
        })
    }

    /// Bytes held.
    pub(super) fn memory(&self) -> usize {
        match self {
            Self::Linear(structure) => structure.memory(),
            Self::Grid(structure) => structure.memory(),
            Self::Bvh(structure) => structure.memory(),
        }
    }

    /// Traces the first `count` rays one by one and counts those that hit.
    pub(super) fn trace<P: Primitives>(&self, primitives: &P, rays: &RaySet, count: usize) -> u64 {
        match self {
            Self::Linear(structure) => trace(structure, primitives, rays, count),
            Self::Grid(structure) => trace(structure, primitives, rays, count),
            Self::Bvh(structure) => trace(structure, primitives, rays, count),
        }
    }
}

fn trace<A: Accelerator, P: Primitives>(structure: &A, primitives: &P, rays: &RaySet, count: usize) -> u64 {
    let rays_in = rays.rays.iter().take(count);
    let hits = if rays.any {
        rays_in.filter(|(ray, span)| structure.occluded(primitives, ray, *span, &mut NoProbe)).count()
    } else {
        rays_in.filter(|(ray, span)| structure.closest(primitives, ray, *span, &mut NoProbe).is_some()).count()
    };
    hits as u64
}
