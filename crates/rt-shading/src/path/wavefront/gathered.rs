//! Surfaces of the hits of several rays.

use super::diffuse_material::DiffuseMaterial;
use crate::{
    lanes::{LANES, each_lane},
    light::LightId,
    stream_queries::StreamQueries,
    wavefront::gathered_shapes::GatheredShapes,
};
use rt_geometry::HitStream;
use rt_math::Rgb;

/// Surfaces of hits, one for each lane.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered {
    pub(super) shapes: GatheredShapes,
    pub(super) albedo: [[f64; LANES]; 3],
    /// Lanes with a material; all others end their path.
    pub(super) valid: u8,
    /// Lanes of emissive materials, with the radiance of both sides.
    pub(super) emissive: u8,
    pub(super) emission: [[Rgb; 2]; LANES],
    pub(super) lights: [Option<LightId>; LANES],
}

/// Gathers the surfaces of the hits of a mask, from index `at` on.
pub(super) fn gather<W: StreamQueries>(
    world: &W,
    materials: &[Option<DiffuseMaterial>],
    (hits, at): (&HitStream, usize),
    mask: u8,
    gathered: &mut Gathered,
) {
    let Gathered { shapes, albedo: [r, g, b], valid, emissive, emission, lights } = gathered;
    shapes.clear();
    (*valid, *emissive) = (0, 0);
    for lane in each_lane(mask) {
        let Some(primitive) = world.primitive(hits.primitive.get(at + lane)) else { continue };
        let Some(Some(material)) = materials.get(primitive.material as usize) else { continue };
        let lane = lane % LANES;
        shapes.set(lane, &primitive.shape);
        let DiffuseMaterial { albedo, emission: radiance } = material;
        (r[lane], g[lane], b[lane]) = (albedo.r, albedo.g, albedo.b);
        *valid |= 1 << lane;
        if !radiance[0].is_black() {
            *emissive |= 1 << lane;
            (emission[lane], lights[lane]) = (*radiance, primitive.light);
        }
    }
}
