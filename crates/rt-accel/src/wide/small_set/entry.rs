//! Primitives of a small set.

use rt_geometry::{PacketKernel, Primitives, padded_bounds};
use rt_math::Aabb;

/// A primitive of the set.
#[derive(Clone, Copy)]
pub(super) struct SetEntry {
    pub(super) index: u32,
    /// Instance and primitive of its hits.
    pub(super) hit_ids: [u32; 2],
    pub(super) casts_shadow: bool,
    pub(super) kernel: PacketKernel,
    /// Padded bounds of an instance, of a quadrilateral, or of a primitive that is intersected ray by ray; `None` if it is unbounded.
    pub(super) bounds: Option<Aabb>,
}

impl SetEntry {
    pub(super) const NONE: Self =
        Self { index: 0, hit_ids: [0; 2], casts_shadow: false, kernel: PacketKernel::Single, bounds: None };

    pub(super) fn new<P: Primitives>(primitives: &P, index: u32) -> Self {
        let kernel = primitives.packet_kernel(index);
        Self {
            index,
            hit_ids: primitives.hit_ids(index),
            casts_shadow: primitives.casts_shadow(index),
            kernel,
            bounds: match kernel {
                PacketKernel::Single | PacketKernel::Instance | PacketKernel::Quadrilateral(..) => {
                    padded_bounds(primitives, index)
                }
                _ => None,
            },
        }
    }

    pub(super) const fn is_instance(&self) -> bool {
        matches!(self.kernel, PacketKernel::Instance)
    }

    /// True if its tests with eight rays at once use their inverse.
    pub(super) const fn needs_inverse(&self) -> bool {
        !matches!(self.kernel, PacketKernel::Sphere(_) | PacketKernel::Plane(_))
    }

    /// True if it is intersected with eight rays at once.
    pub(super) fn has_kernel(&self) -> bool {
        !self.is_instance() && (self.bounds.is_some() || self.kernel != PacketKernel::Single)
    }
}
