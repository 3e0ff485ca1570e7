//! Hits that are shaded together.

use super::lane_phong::UniformPhong;
use crate::{
    interior_list::MediumEntry,
    lane_set::LaneSet,
    lanes::LANES,
    wavefront::{
        hit_points::HitPoints,
        shaded_surface::{ShadedSurface, ShadingNormals},
    },
};
use rt_math::Vector3;

/// Surfaces that the rays of some lanes have hit.
pub(super) struct HitSurfaces<'a, L: LaneSet> {
    pub(super) points: &'a HitPoints<L>,
    pub(super) surface: &'a ShadedSurface<L>,
    pub(super) normals: &'a ShadingNormals<L>,
    /// Texture coordinates, if they are needed.
    pub(super) uv: Option<[L::D; 2]>,
    /// Index of the object of each lane.
    pub(super) objects: &'a [u32; LANES],
    /// Index of the material of all lanes.
    pub(super) material: u32,
}

/// Hits of some lanes on surfaces with one Phong model.
pub(super) struct HitGroup<'a, L: LaneSet> {
    pub(super) phong: &'a UniformPhong,
    pub(super) surfaces: &'a HitSurfaces<'a, L>,
    /// Index of the first ray.
    pub(super) at: usize,
    /// Lanes that hit, and whose surface is visible.
    pub(super) mask: u8,
    /// Factors of the radiance in the pixel, after absorption.
    pub(super) throughput: Vector3<L::F>,
    /// Lanes whose surface transmits light.
    pub(super) transmits: u8,
    /// Index of refraction before the surface divided by that behind it; 1 where no light is transmitted.
    pub(super) eta: L::F,
    /// Lanes with a medium before the surface that absorbs.
    pub(super) absorbed: u8,
}

impl<L: LaneSet> HitSurfaces<'_, L> {
    /// Object and material of a lane.
    pub(super) const fn medium_entry(&self, lane: usize) -> MediumEntry {
        MediumEntry { object: self.objects[lane % LANES], material: self.material }
    }
}
