//! Places of rays in ray trees.

use crate::medium_tracker::RayMedia;
use rt_math::Rgb;

/// Place of a ray in its ray tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreePath {
    /// Index of its branch.
    pub(super) branch: u32,
    /// Bounces so far.
    pub(super) depth: u32,
    /// Weight of its radiance in the pixel.
    pub(super) weight: Rgb,
    /// Media around it.
    pub(super) media: RayMedia,
}
