//! Options of a plan beyond the scene.

use rt_accel::wide::{Quality, SimdLevel};
use rt_math::Rgb;

use crate::Crop;

/// Choices that a plan takes beside the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanOptions {
    /// Which camera of the scene to use.
    pub camera: usize,
    /// Render this part of the image only; its pixels are those of the whole image.
    pub crop: Option<Crop>,
    /// Leave the background out and record coverage in an alpha channel.
    pub transparent: bool,
    /// Radiance shown to camera rays that leave the scene, in place of its background, which goes on lighting the scene.
    /// Views of geometry or cost do without.
    pub backdrop: Option<Rgb>,
    /// Leave nothing out. The picture is the same to the bit; this is how tests prove it.
    pub full: bool,
    /// The instructions that structures use; `None` for the best that the processor has. What it does not have is
    /// replaced by what every processor has. The picture is the same to the bit.
    pub simd: Option<SimdLevel>,
    /// How much time the wide tree may take to be built. The picture is the same to the bit.
    pub quality: Quality,
    /// Most bytes of memory that the render may take. What is predicted to take more is refused before it is built; `None`
    /// for no limit.
    pub memory: Option<u64>,
    /// Whether the render will go on until something ends it, or keep maps of error and samples: more is then kept of each
    /// pixel. It matters for the prediction of memory alone.
    pub progressive: bool,
}
