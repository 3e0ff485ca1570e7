//! Options of a plan beyond the scene.

use rt_accel::wide::{Quality, SimdLevel};
use rt_math::Rgb;

use crate::Crop;

/// Options of a plan beyond those of its scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanOptions {
    /// Index of the camera.
    pub camera: usize,
    /// Render this rectangle only; its pixels are those of the whole image.
    pub crop: Option<Crop>,
    /// Leave the background out and record coverage in an alpha channel.
    pub transparent: bool,
    /// Radiance of camera rays that hit nothing, instead of the background of the scene. The background still lights the scene.
    /// Geometry and cost integrators ignore it.
    pub backdrop: Option<Rgb>,
    /// Do not trim the plan. The image is bit-identical, as tests verify.
    pub full: bool,
    /// Instruction set of accelerators and shading; `None` for the best one of the processor. The best
    /// available one below it replaces one that is not available. The image is bit-identical.
    pub simd: Option<SimdLevel>,
    /// Type of the numbers that surfaces are shaded in.
    pub precision: Precision,
    /// Build quality of the wide BVH. The image is bit-identical.
    pub quality: Quality,
    /// Memory limit in bytes. A larger prediction is an error, before anything is built; `None`
    /// for no limit.
    pub memory: Option<u64>,
    /// True if the render is progressive. More memory is then kept per pixel; only the memory prediction depends on it.
    pub progressive: bool,
    /// True if maps of standard errors and sample counts are kept, as shards of an image do. Only the memory prediction depends
    /// on it.
    pub maps: bool,
}

/// Type of the numbers that surfaces are shaded in. Positions, hits and sums of samples are always `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// `f32` under `whitted` and in path tracing, for common shapes and materials; elsewhere `f64`.
    #[default]
    F32,
    /// `f64`: the reference.
    F64,
}

impl Precision {
    /// All precisions.
    pub const ALL: &[Self] = &[Self::F32, Self::F64];

    /// Lower-case name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}
