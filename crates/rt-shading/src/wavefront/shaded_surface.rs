//! Surfaces at hits, seen from the side of the viewer.

use super::{gathered_shapes::GatheredShapes, hit_points::HitPoints};
use crate::{lane_set::LaneSet, lanes::each_lane};
use rt_geometry::{HitStream, SmoothPoint, SurfaceInteraction, offset_point};
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

/// Normals that hits are shaded with, and the points that shadow rays start from.
pub(crate) struct ShadingNormals<L: LaneSet> {
    /// Unit normals on the viewer's side.
    pub(crate) normal: Vector3<L::F>,
    /// Lanes in which these are interpolated.
    pub(crate) smooth: u8,
    pub(crate) shadow_origin: Vector3<L::D>,
    /// Points on the smooth surface, or on the surface itself.
    pub(crate) shadow_point: Vector3<L::D>,
}

impl<L: LaneSet> ShadingNormals<L> {
    /// Normals of the surfaces themselves.
    #[inline(always)]
    pub(crate) const fn flat(points: &HitPoints<L>, surface: &ShadedSurface<L>) -> Self {
        let &ShadedSurface { normal, near_origin, .. } = surface;
        Self { normal, smooth: 0, shadow_origin: near_origin, shadow_point: points.point }
    }

    /// Replaces the normals of lanes whose normals are interpolated, and the points for shadow rays there.
    #[inline(always)]
    pub(crate) fn interpolate(
        &mut self,
        lanes: L,
        (points, surface): (&HitPoints<L>, &ShadedSurface<L>),
        shapes: &GatheredShapes,
        (hits, at): (&HitStream, usize),
        smooth: u8,
    ) {
        let SmoothPoint { normal, shadow_point, is_valid, .. } = points.smooth(lanes, shapes, (hits, at));
        self.smooth = smooth & lanes.bits_f64(is_valid);
        let is_smooth = lanes.mask_f64(self.smooth);
        let is_inside = lanes.mask_f64(surface.inside);
        let outwards = Vector3::select(is_inside, -points.outside, points.outside);
        let origin = shadow_origins(lanes, points, (shadow_point, outwards), self.smooth);
        self.shadow_point = Vector3::select(is_smooth, shadow_point, self.shadow_point);
        self.shadow_origin = Vector3::select(is_smooth, origin, self.shadow_origin);
        let normal = turned_to_viewer(lanes.narrow_vector(Vector3::select(is_inside, -normal, normal)), surface);
        self.normal = Vector3::select(lanes.mask(self.smooth), normal, self.normal);
    }
}

/// Origins of shadow rays on the side of `outwards`, the normal of the surface itself or its opposite, given points on the smooth surface.
#[inline(always)]
pub(crate) fn shadow_origins<L: LaneSet>(
    lanes: L,
    points: &HitPoints<L>,
    (shadow_point, outwards): (Vector3<L::D>, Vector3<L::D>),
    mask: u8,
) -> Vector3<L::D> {
    let lift = (shadow_point - points.point).dot(outwards);
    let start = Vector3::select(lift.lt(lanes.splat_f64(0.0)), points.point, shadow_point);
    offset(lanes, points, (start, outwards), mask)
}

/// Unit normals, turned where they face away from the viewer until they are perpendicular to the view, as by
/// [`ViewedSurface`](crate::viewed_surface::ViewedSurface).
#[inline(always)]
fn turned_to_viewer<L: LaneSet>(normal: Vector3<L::F>, surface: &ShadedSurface<L>) -> Vector3<L::F> {
    let wo = -surface.direction;
    let facing = normal.dot(wo);
    let is_away = facing.lt(facing.splat(0.0));
    if !is_away.any() {
        return normal;
    }
    let (turned, has_length) = (normal - wo * facing).try_normalize();
    let turned = Vector3::select(has_length, turned, surface.normal);
    Vector3::select(is_away, turned, normal)
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
