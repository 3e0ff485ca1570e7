//! Points, normals and squares of checkerboards of eight hits, in lanes.

use super::lane_phong::LanePhong;
use crate::{
    LazyPlane, LazySurface, TrianglePoint,
    lanes::{LANES, LaneMask, Lanes, Simd},
};
use rt_geometry::{Sphere, interpolate, plane_point, plane_uv, sphere_point, triangle_point};
use rt_math::{Real, Vector3};

/// An expression for each of eight items, with the lane if it is named.
macro_rules! each {
    ($items:expr, |$item:ident| $value:expr) => {
        each!($items, |$item, _lane| $value)
    };
    ($items:expr, |$item:ident, $lane:ident| $value:expr) => {{
        let [a, b, c, d, e, f, g, h] = $items;
        each!(@ $item $lane $value; a 0, b 1, c 2, d 3, e 4, f 5, g 6, h 7)
    }};
    (@ $item:ident $lane:ident $value:expr; $($each:ident $index:literal),*) => {
        [$({
            let ($item, $lane) = ($each, $index);
            $value
        }),*]
    };
}

/// Numbers of eight items, in lanes.
macro_rules! gather {
    ($simd:expr, $items:expr, |$item:ident| $number:expr) => {
        Lanes::load($simd, &each!($items, |$item| $number))
    };
}

/// Vectors of eight items, in lanes.
macro_rules! gather_vector {
    ($simd:expr, $items:expr, |$item:ident| $vector:expr, $x:ident $y:ident $z:ident) => {
        Vector3::new(
            gather!($simd, $items, |$item| $vector.$x),
            gather!($simd, $items, |$item| $vector.$y),
            gather!($simd, $items, |$item| $vector.$z),
        )
    };
}

pub(super) use {each, gather, gather_vector};

/// Points and normals of eight hits, in registers.
pub(super) struct PointLanes<S: Simd> {
    pub(super) point: Vector3<Lanes<S>>,
    pub(super) error: Vector3<Lanes<S>>,
    /// Unit normals on the outside.
    pub(super) outside: Vector3<Lanes<S>>,
    /// True where the normals are unit vectors.
    pub(super) has_normal: LaneMask<S>,
}

/// Shapes whose points are computed in lanes, for hits of rays that are given by origin and direction.
pub(super) trait ShapeLanes: LazySurface + Copy {
    /// Points and normals of hits at the parameters `t`.
    fn points<S: Simd>(simd: S, shapes: [&Self; LANES], ray: [Vector3<Lanes<S>>; 2], t: Lanes<S>) -> PointLanes<S>;

    /// Texture coordinates at these points; `None` for shapes without any.
    fn uv<S: Simd>(simd: S, shapes: [&Self; LANES], ray: [Vector3<Lanes<S>>; 2], t: Lanes<S>) -> Option<[Lanes<S>; 2]>;
}

impl ShapeLanes for Sphere {
    #[inline(always)]
    fn points<S: Simd>(
        simd: S,
        spheres: [&Self; LANES],
        [origin, direction]: [Vector3<Lanes<S>>; 2],
        t: Lanes<S>,
    ) -> PointLanes<S> {
        let centre = gather_vector!(simd, spheres, |sphere| sphere.centre(), x y z);
        let radius = gather!(simd, spheres, |sphere| sphere.radius());
        let (outside, has_normal) = ((origin - centre) + direction * t).try_normalize();
        let (point, error) = sphere_point(centre, radius, outside);
        PointLanes { point, error, outside, has_normal }
    }

    #[inline(always)]
    fn uv<S: Simd>(_: S, _: [&Self; LANES], _: [Vector3<Lanes<S>>; 2], _: Lanes<S>) -> Option<[Lanes<S>; 2]> {
        None
    }
}

impl ShapeLanes for TrianglePoint {
    #[inline(always)]
    fn points<S: Simd>(simd: S, triangles: [&Self; LANES], _: [Vector3<Lanes<S>>; 2], _: Lanes<S>) -> PointLanes<S> {
        let a = gather_vector!(simd, triangles, |triangle| triangle.vertices[0], x y z);
        let b = gather_vector!(simd, triangles, |triangle| triangle.vertices[1], x y z);
        let c = gather_vector!(simd, triangles, |triangle| triangle.vertices[2], x y z);
        let v = gather!(simd, triangles, |triangle| triangle.uv[0]);
        let w = gather!(simd, triangles, |triangle| triangle.uv[1]);
        let (point, error) = triangle_point([a, b, c], [v, w]);
        let outside = gather_vector!(simd, triangles, |triangle| triangle.normal, x y z);
        PointLanes { point, error, outside, has_normal: LaneMask::from_bits(simd, !0) }
    }

    #[inline(always)]
    fn uv<S: Simd>(
        simd: S,
        triangles: [&Self; LANES],
        _: [Vector3<Lanes<S>>; 2],
        _: Lanes<S>,
    ) -> Option<[Lanes<S>; 2]> {
        let weights =
            [gather!(simd, triangles, |triangle| triangle.uv[0]), gather!(simd, triangles, |triangle| triangle.uv[1])];
        let us = [
            gather!(simd, triangles, |triangle| f64::from(triangle.vertex_uvs[0][0])),
            gather!(simd, triangles, |triangle| f64::from(triangle.vertex_uvs[1][0])),
            gather!(simd, triangles, |triangle| f64::from(triangle.vertex_uvs[2][0])),
        ];
        let vs = [
            gather!(simd, triangles, |triangle| f64::from(triangle.vertex_uvs[0][1])),
            gather!(simd, triangles, |triangle| f64::from(triangle.vertex_uvs[1][1])),
            gather!(simd, triangles, |triangle| f64::from(triangle.vertex_uvs[2][1])),
        ];
        Some([interpolate(us, weights), interpolate(vs, weights)])
    }
}

impl ShapeLanes for LazyPlane {
    #[inline(always)]
    fn points<S: Simd>(
        simd: S,
        planes: [&Self; LANES],
        [origin, direction]: [Vector3<Lanes<S>>; 2],
        t: Lanes<S>,
    ) -> PointLanes<S> {
        let on_plane = gather_vector!(simd, planes, |lazy| lazy.plane.point(), x y z);
        let outside = gather_vector!(simd, planes, |lazy| lazy.plane.normal(), x y z);
        let (point, error) = plane_point(on_plane, outside, origin + direction * t);
        PointLanes { point, error, outside, has_normal: LaneMask::from_bits(simd, !0) }
    }

    #[inline(always)]
    fn uv<S: Simd>(simd: S, planes: [&Self; LANES], ray: [Vector3<Lanes<S>>; 2], t: Lanes<S>) -> Option<[Lanes<S>; 2]> {
        let on_plane = gather_vector!(simd, planes, |lazy| lazy.plane.point(), x y z);
        let normal = gather_vector!(simd, planes, |lazy| lazy.plane.normal(), x y z);
        let zero = Lanes::splat(simd, 0.0);
        let needs_uv = gather!(simd, planes, |lazy| f64::from(lazy.needs_uv)).gt(zero);
        let [u, v] = plane_uv(on_plane, normal, ray, t);
        Some([Real::select(needs_uv, u, zero), Real::select(needs_uv, v, zero)])
    }
}

/// Lanes on an odd square of a checkerboard, and lanes whose colours are those of a square.
#[inline(always)]
pub(super) fn odd_squares<S: Simd, T: ShapeLanes>(
    simd: S,
    shapes: [&T; LANES],
    phongs: [&LanePhong; LANES],
    ray: [Vector3<Lanes<S>>; 2],
    t: Lanes<S>,
) -> (u8, u8) {
    if !phongs.iter().any(|phong| phong.is_checkered()) {
        return (0, !0);
    }
    let Some([u, v]) = T::uv(simd, shapes, ray, t) else { return (0, !0) };
    let side = gather!(simd, phongs, |phong| phong.side);
    let half = ((u / side).floor() + (v / side).floor()) * 0.5;
    let is_even = (half - half.floor()).eq(Lanes::splat(simd, 0.0));
    ((!is_even).bits(), Vector3::new(u, v, u).is_finite().bits())
}
