//! Rays of ray trees, one by one.

use crate::medium_tracker::RayMedia;
use rt_math::Rgb;

/// State of a ray in its ray tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayTreePath {
    /// Index of its branch.
    pub(super) branch: u32,
    /// Bounces so far.
    pub(super) depth: u32,
    /// Factor of its radiance in the pixel.
    pub(super) throughput: Rgb,
    /// Media around it.
    pub(super) media: RayMedia,
}
