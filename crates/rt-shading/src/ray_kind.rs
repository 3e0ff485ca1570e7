//! Kinds of rays that surfaces scatter.

use crate::bsdf::{BsdfSample, Scattering};
use rt_geometry::RayKind;

/// Kind of a ray that a light has emitted, or that a surface has scattered.
#[inline(always)]
pub(crate) fn kind_of(sample: Option<&BsdfSample>) -> RayKind {
    match sample {
        Some(BsdfSample { kind: Scattering::Transmission, .. }) => RayKind::Refraction,
        Some(BsdfSample { is_diffuse: false, .. }) => RayKind::Reflection,
        _ => RayKind::Diffuse,
    }
}
