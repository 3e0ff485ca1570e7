//! Ray trees, and their deferred rays.

use crate::{
    InteriorList,
    interior_list::{InterfaceEvent, InteriorListStack},
    medium_tracker::MediumTracker,
};
use rt_math::{Ray, Rgb};

/// Current path in a ray tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreePath {
    /// Index of its camera ray.
    pub(super) sample: u32,
    /// Bounces so far.
    pub(super) depth: u32,
    /// Weight of its radiance in the pixel.
    pub(super) weight: Rgb,
}

/// Refracted ray that is traced after the tree of the mirrored one.
#[derive(Clone, Copy, Debug)]
struct DeferredRay {
    ray: Ray,
    path: TreePath,
    /// Length of its list of enclosing dielectrics.
    bodies: u32,
}

/// State of the ray tree of a camera ray between waves. The tree is traversed depth first, and each wave holds one path of it. The
/// order of sums thus does not depend on the rest of the wave.
#[derive(Clone, Debug, Default)]
pub(super) struct RayTree {
    deferred: Vec<DeferredRay>,
    /// Media around the rays in `deferred`.
    interiors: InteriorListStack,
    /// Media along the current path.
    pub(super) media: MediumTracker,
}

impl RayTree {
    /// Defers a ray that crosses a surface.
    #[inline(always)]
    pub(super) fn defer(&mut self, ray: Ray, path: &TreePath, event: InterfaceEvent) {
        let bodies = self.interiors.push(&self.media.interior, event);
        self.deferred.push(DeferredRay { ray, path: *path, bodies });
    }

    /// Removes the ray that was deferred last, if there is one, and makes it the current path.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<(Ray, TreePath)> {
        let DeferredRay { ray, path, bodies } = self.deferred.pop()?;
        self.interiors.pop(&mut self.media.interior, bodies);
        self.media.start_ray();
        Some((ray, path))
    }

    /// Restarts the tree with a camera ray in these media.
    pub(super) fn restart(&mut self, surroundings: &InteriorList) {
        self.deferred.clear();
        self.interiors.clear();
        self.media.restart(surroundings);
    }
}
