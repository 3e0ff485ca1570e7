//! The world that rays are traced against.

use rt_math::Aabb;

use crate::instance::{Aggregate, BottomLevel, Instance, Instances};

/// Objects of the scene on two levels.
#[derive(Debug)]
pub(crate) struct World {
    pub(crate) top: Aggregate,
    pub(crate) levels: BottomLevel,
}

impl World {
    /// Objects of the top level as primitives.
    pub(crate) fn instances(&self) -> Instances<'_> {
        self.top.set(&self.levels)
    }

    /// True if an object moves.
    pub(crate) fn has_motion(&self) -> bool {
        self.top.all_instances(&self.levels).any(Instance::has_motion)
    }

    /// Box around all bounded objects.
    pub(crate) fn bounds(&self) -> Aabb {
        self.top.instances.iter().filter_map(|instance| instance.bounds).fold(Aabb::EMPTY, Aabb::union)
    }
}
