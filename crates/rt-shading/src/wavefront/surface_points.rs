//! Points and normals of hits, for layers.

use super::{gathered_shapes::GatheredShapes, hit_points::HitPoints};
use crate::{
    lane_set::{Element, LaneSet, LaneStage},
    lanes::{LANES, LaneLevel},
    stream_queries::StreamShape,
};
use core::ops::Range;
use rt_geometry::{HitStream, RayStream};
use rt_math::{DVec3, Vector3};

/// Surface that a ray hits, without texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// World space.
    pub point: DVec3,
    /// Unit normal on the outside.
    pub geometric_normal: DVec3,
    /// Unit normal on the outside, interpolated where the shape has normals of vertices.
    pub shading_normal: DVec3,
}

/// Computes the surfaces of hits in lanes, for a range of rays. `shape` returns the hit shape of a ray. `found` is called for all rays in
/// order, with the surface of those that have a shape. All levels have the same results.
pub fn surface_points<'w>(
    level: Option<LaneLevel>,
    (rays, hits): (&RayStream, &HitStream),
    range: Range<usize>,
    shape: impl FnMut(usize) -> Option<StreamShape<'w>>,
    found: impl FnMut(usize, Option<&SurfacePoint>),
) {
    <f32 as Element>::run(level, FindSurfaces { rays, hits, range, shape, found });
}

struct FindSurfaces<'a, S, F> {
    rays: &'a RayStream,
    hits: &'a HitStream,
    range: Range<usize>,
    shape: S,
    found: F,
}

impl<'w, E, S, F> LaneStage<E> for FindSurfaces<'_, S, F>
where
    E: Element,
    S: FnMut(usize) -> Option<StreamShape<'w>>,
    F: FnMut(usize, Option<&SurfacePoint>),
{
    #[inline(always)]
    fn run<L: LaneSet<Element = E>>(mut self, lanes: L) {
        let mut shapes = GatheredShapes::default();
        for at in self.range.clone().step_by(L::N) {
            let count = (self.range.end - at).min(L::N);
            shapes.clear();
            let mut mask = 0u8;
            for lane in 0..count {
                if let Some(shape) = (self.shape)(at + lane) {
                    mask |= 1 << lane;
                    shapes.set(lane, &shape);
                }
            }
            if mask == 0 {
                (at..at + count).for_each(|at| (self.found)(at, None));
                continue;
            }
            let points = HitPoints::on_shapes(lanes, &shapes, self.rays, self.hits, at);
            let mut shading = points.outside;
            if shapes.smooth != 0 {
                let smooth = points.smooth(lanes, &shapes, (self.hits, at));
                let is_smooth = lanes.mask_f64(shapes.smooth) & smooth.is_valid;
                shading = Vector3::select(is_smooth, smooth.normal, shading);
            }
            let (point, outside) = (lanes.store_point(points.point), lanes.store_point(points.outside));
            let shading = lanes.store_point(shading);
            for lane in 0..count {
                let surface = SurfacePoint {
                    point: at_lane(&point, lane),
                    geometric_normal: at_lane(&outside, lane),
                    shading_normal: at_lane(&shading, lane),
                };
                (self.found)(at + lane, (mask >> lane & 1 == 1).then_some(&surface));
            }
        }
    }
}

#[inline(always)]
fn at_lane([x, y, z]: &[[f64; LANES]; 3], lane: usize) -> DVec3 {
    let lane = lane % LANES;
    DVec3::new(x[lane], y[lane], z[lane])
}
