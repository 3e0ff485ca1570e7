//! Surfaces at hits, seen from the side of the viewer.

use super::hit_points::HitPoints;
use crate::{lane_set::LaneSet, lanes::each_lane};
use rt_geometry::{SurfaceInteraction, offset_point};
use rt_math::{DVec3, Mask, Real, Vector3};

/// Surfaces of some hits, for shading.
pub(crate) struct ShadedSurface<L: LaneSet> {
    /// Lanes that see the surface from behind.
    pub(crate) inside: u8,
    /// Origins of shadow rays and mirrored rays.
    pub(crate) near_origin: Vector3<L::D>,
    /// Unit normals on the viewer's side.
    pub(crate) normal: Vector3<L::F>,
    /// Unit directions of the rays.
    pub(crate) direction: Vector3<L::F>,
    /// Lengths of their directions.
    pub(crate) length: L::D,
}

impl<L: LaneSet> ShadedSurface<L> {
    /// Surfaces at points; only those of a mask are valid.
    #[inline(always)]
    pub(crate) fn new(lanes: L, points: &HitPoints<L>, mask: u8) -> Self {
        let length = points.direction.length();
        let mut direction = points.direction / length;
        let is_finite = direction.is_finite();
        if !is_finite.all() {
            // The square of the length is out of range.
            let Vector3 { x, y, z } = points.direction;
            let scaled = points.direction / x.abs().max(y.abs()).max(z.abs());
            direction = Vector3::select(is_finite, direction, scaled / scaled.length());
        }
        let is_inside = direction.dot(points.outside).gt(lanes.splat_f64(0.0));
        let normal = Vector3::select(is_inside, -points.outside, points.outside);
        Self {
            inside: lanes.bits_f64(is_inside),
            near_origin: offset(lanes, points, (points.point, normal), mask),
            normal: lanes.narrow_vector(normal),
            direction: lanes.narrow_vector(direction),
            length,
        }
    }
}

/// Points on the surface, or above it, moved off it by the error bound of `points`, in the direction of the normal or its opposite.
#[inline(always)]
pub(crate) fn offset<L: LaneSet>(
    lanes: L,
    points: &HitPoints<L>,
    (start, outwards): (Vector3<L::D>, Vector3<L::D>),
    mask: u8,
) -> Vector3<L::D> {
    let (moved, is_valid) = offset_point(start, points.error, points.outside, outwards);
    let rare = mask & !lanes.bits_f64(is_valid);
    if rare == 0 { moved } else { offset_rare(lanes, points, [start, moved, outwards], rare) }
}

/// Replaces the offset points of lanes in which a coordinate is tiny or not finite.
#[inline(never)]
fn offset_rare<L: LaneSet>(
    lanes: L,
    points: &HitPoints<L>,
    [start, moved, outwards]: [Vector3<L::D>; 3],
    rare: u8,
) -> Vector3<L::D> {
    let [start, mut numbers, outwards] = [start, moved, outwards].map(|p| lanes.store_point(p));
    for lane in each_lane(rare) {
        let [_, error, normal] = points.get(lanes, lane);
        let start = DVec3::from(start.map(|coordinates| coordinates[lane]));
        let surface = SurfaceInteraction::flat(start, error, normal, [0.0; 2]);
        let origin = surface.spawn_ray(outwards.map(|numbers| numbers[lane]).into(), 0.0).origin;
        for (numbers, coordinate) in numbers.iter_mut().zip(origin.to_array()) {
            numbers[lane] = coordinate;
        }
    }
    let [x, y, z] = &numbers;
    Vector3::new(lanes.load_f64(x), lanes.load_f64(y), lanes.load_f64(z))
}
