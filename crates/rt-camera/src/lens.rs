//! The thin lens: rays start at points of the aperture and converge in the plane of focus.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use rt_math::{DVec2, transcendental::sincos};

use crate::CameraError;

/// Thin lens, which replaces the pinhole (Cook, Porter, Carpenter 1984).
///
/// ```text
///            aperture                 plane of focus
///               │╲                         │
///        radius │  ╲___                    │
///     ──────────┼──────╲───────────────────●──── all rays of a raster point converge here
///               │   ___╱╲___               │
///               │ ╱         ╲___           │
///               0          depth           focus
/// ```
///
/// A point at depth `z` is blurred over a disk whose diameter is `2·radius·|z − focus| / z` as seen in the plane of
/// focus: the circle of confusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the aperture, or of the circle around its corners, in units of the camera's space. 0 is a pinhole.
    pub radius: f64,
    /// Depth of the plane in which all is sharp, along the view axis, in units of the camera's space.
    pub focus: f64,
    /// Number of corners of the aperture, at least 3; `None` for a round aperture.
    pub blades: Option<u32>,
    /// Angle in radians, counter-clockwise seen from behind the camera, by which the aperture is rotated. At 0 the
    /// first corner points up.
    pub rotation: f64,
}

impl Lens {
    /// A point of the aperture, x to the right and y up, in units of the camera's space. Uniform points of the unit square give
    /// uniform points by area.
    ///
    /// The disk is the image of the square under the concentric map (Shirley and Chiu 1997), which keeps neighbours together.
    /// In a polygon, the first coordinate chooses one of the triangles around its centre, and the angle in it.
    pub fn point(&self, on_square: [f64; 2]) -> DVec2 {
        self.point_between(on_square, |corner| self.corner(corner))
    }

    /// Version of [`point`](Self::point) for given corners on the unit circle.
    #[inline(always)]
    fn point_between(&self, [u, v]: [f64; 2], corner: impl Fn(u32) -> DVec2) -> DVec2 {
        let on_unit = match self.blades {
            None => on_disk(DVec2::new(u, v)),
            Some(blades) => {
                let place = u * f64::from(blades);
                let blade = (place as u32).min(blades.saturating_sub(1));
                corner(blade).lerp(corner(blade + 1), place - f64::from(blade)) * v.sqrt()
            }
        };
        on_unit * self.radius
    }

    /// Corner of an aperture with blades, on the unit circle. One turn after the first is the first again, up to rounding.
    fn corner(&self, corner: u32) -> DVec2 {
        let blades = self.blades.map_or(1.0, f64::from);
        let (sin, cos) = sincos(TAU * (f64::from(corner) / blades) + self.rotation);
        DVec2::new(-sin, cos)
    }

    pub(crate) fn check(&self) -> Result<(), CameraError> {
        if !(self.radius >= 0.0 && self.radius.is_finite()) {
            return Err(CameraError::LensRadius(self.radius));
        }
        if !(self.focus > 0.0 && self.focus.is_finite()) {
            return Err(CameraError::Focus(self.focus));
        }
        match self.blades {
            Some(blades @ 0..3) => Err(CameraError::Blades(blades)),
            _ if !self.rotation.is_finite() => Err(CameraError::LensRotation(self.rotation)),
            _ => Ok(()),
        }
    }
}

/// Blades of which an [`Aperture`] stores the corners.
const MAX_STORED_BLADES: usize = 16;

/// A lens with the corners of its aperture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aperture {
    lens: Lens,
    /// The first corners on the unit circle, used if there are at most [`MAX_STORED_BLADES`] blades.
    corners: [DVec2; MAX_STORED_BLADES + 1],
}

impl Aperture {
    pub(crate) fn new(lens: Lens) -> Self {
        let mut corners = [DVec2::ZERO; MAX_STORED_BLADES + 1];
        for (corner, number) in corners.iter_mut().zip(0..) {
            *corner = lens.corner(number);
        }
        Self { lens, corners }
    }

    pub(crate) const fn lens(&self) -> &Lens {
        &self.lens
    }

    /// [`Lens::point`], bit for bit.
    #[inline(always)]
    pub(crate) fn point(&self, on_square: [f64; 2]) -> DVec2 {
        self.lens.point_between(
            on_square,
            #[inline(always)]
            |corner| match self.lens.blades {
                Some(blades) if blades as usize <= MAX_STORED_BLADES => {
                    self.corners[corner as usize % self.corners.len()]
                }
                _ => self.lens.corner(corner),
            },
        )
    }
}

/// Squares around the centre become circles around it.
fn on_disk(square: DVec2) -> DVec2 {
    let DVec2 { x, y } = square * 2.0 - 1.0;
    if x == 0.0 && y == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    let (sin, cos) = sincos(angle);
    DVec2::new(cos, sin) * radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, CameraSettings, FovAxis, Projection};
    use proptest::prelude::*;
    use rt_math::{
        DVec3, Transform,
        random::{hash, unit},
        transcendental::{acos, atan2, cos, tan},
    };

    const DRAWS: u64 = 100_000;

    fn square(index: u64) -> [f64; 2] {
        [0, 1].map(|axis| unit(hash(&[7, index, axis])))
    }

    fn lens(blades: Option<u32>) -> Lens {
        Lens { radius: 0.25, focus: 3.0, blades, rotation: 0.4 }
    }

    fn camera(projection: Projection, lens: Option<Lens>) -> Camera {
        let place = Transform::look_at(DVec3::new(2.0, -1.0, 5.0), DVec3::ZERO, DVec3::Y).expect("a view");
        let place = place.compose(&Transform::scale(DVec3::splat(2.0)).expect("a scale"));
        Camera::new(&CameraSettings { lens, ..CameraSettings::new(place, projection) }, 120, 90).expect("a camera")
    }

    const PINHOLE: Projection = Projection::Perspective { fov: 0.8, axis: FovAxis::Vertical };
    const PARALLEL: Projection = Projection::Orthographic { height: 6.0 };

    /// Counts of draws in cells of equal area: rings of the disk, times sectors; like triangles around the centre of a polygon.
    fn chi_square(lens: &Lens) -> f64 {
        const RINGS: usize = 10;
        let sectors = lens.blades.map_or(8, |blades| blades as usize);
        let mut counts = vec![0u32; RINGS * 2 * sectors];
        for index in 0..DRAWS {
            let point = lens.point(square(index)) / lens.radius;
            let angle = atan2(-point.x, point.y) - lens.rotation;
            let turns = angle.rem_euclid(TAU) / TAU * sectors as f64;
            let sector = (turns as usize).min(sectors - 1);
            // The distance from the centre as a part of that to the edge.
            let off_middle = (turns - sector as f64 - 0.5) * TAU / sectors as f64;
            let half = TAU / 2.0 / sectors as f64;
            let edge = if lens.blades.is_some() { cos(half) / cos(off_middle) } else { 1.0 };
            let out = point.length() / edge;
            let ring = (out * out * RINGS as f64) as usize;
            assert!(point.length() <= edge * (1.0 + 1e-12), "{point} lies outside");
            let side = usize::from(off_middle > 0.0);
            counts[(ring.min(RINGS - 1) * sectors + sector) * 2 + side] += 1;
        }
        let expected = DRAWS as f64 / counts.len() as f64;
        let degrees = counts.len() as f64 - 1.0;
        let chi: f64 =
            counts.iter().map(|&count| (f64::from(count) - expected) * (f64::from(count) - expected) / expected).sum();
        (chi - degrees) / (2.0 * degrees).sqrt()
    }

    #[test]
    fn stored_corners_have_the_points_of_computed_ones() {
        for blades in [None, Some(3), Some(5), Some(16), Some(17), Some(u32::MAX)] {
            let lens = lens(blades);
            let aperture = Aperture::new(lens);
            let ends = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.5], [0.999_999_999_999, 1.0]];
            for on_square in ends.into_iter().chain((0..200).map(square)) {
                let bits = |point: DVec2| point.to_array().map(f64::to_bits);
                assert_eq!(bits(aperture.point(on_square)), bits(lens.point(on_square)), "{blades:?}, {on_square:?}");
            }
        }
    }

    #[test]
    fn points_are_uniform_by_area() {
        for blades in [None, Some(3), Some(4), Some(5), Some(6), Some(9)] {
            let z = chi_square(&lens(blades));
            assert!(z.abs() < 4.0, "{blades:?}: {z}");
        }
    }

    #[test]
    fn the_first_corner_points_up() {
        let upright = Lens { rotation: 0.0, ..lens(Some(5)) };
        assert!((upright.point([0.0, 1.0]) - DVec2::new(0.0, 0.25)).length() < 1e-15);
        let turned = Lens { rotation: FRAC_PI_2, ..lens(Some(5)) };
        assert!((turned.point([0.0, 1.0]) - DVec2::new(-0.25, 0.0)).length() < 1e-15);
        assert!(lens(Some(5)).point([1.0, 1.0]).length() <= 0.25, "the closed end of the square");
    }

    #[test]
    fn bad_lenses_are_refused() {
        let refuse = |lens: Lens| {
            let settings = CameraSettings { lens: Some(lens), ..CameraSettings::new(Transform::IDENTITY, PINHOLE) };
            Camera::new(&settings, 4, 4).expect_err("refused")
        };
        let sound = lens(None);
        assert_eq!(refuse(Lens { radius: -0.1, ..sound }), CameraError::LensRadius(-0.1));
        assert!(matches!(refuse(Lens { radius: f64::NAN, ..sound }), CameraError::LensRadius(_)));
        assert_eq!(refuse(Lens { focus: 0.0, ..sound }), CameraError::Focus(0.0));
        assert_eq!(refuse(Lens { focus: f64::INFINITY, ..sound }), CameraError::Focus(f64::INFINITY));
        assert_eq!(refuse(Lens { blades: Some(2), ..sound }), CameraError::Blades(2));
        assert!(matches!(refuse(Lens { rotation: f64::NAN, ..sound }), CameraError::LensRotation(_)));
        assert_eq!(refuse(Lens { radius: 1e300, focus: 1e-300, ..sound }), CameraError::Overflow);
    }

    #[test]
    fn a_lens_of_no_size_is_a_pinhole() {
        for projection in [PINHOLE, PARALLEL] {
            let (sharp, tiny) =
                (camera(projection, None), camera(projection, Some(Lens { radius: 0.0, ..lens(Some(6)) })));
            assert!(!tiny.has_lens());
            let raster = DVec2::new(17.25, 80.5);
            assert_eq!(sharp.ray(raster, 0.5), tiny.generate_ray(raster, [0.9, 0.3], 0.5));
        }
    }

    /// numerics: f = 50 mm at f/2, focused at 2 m, and a point 4 m away. The image of a plane at distance 1 is that on the
    /// film, enlarged by the distance of the film, `f·zf / (zf − f)`.
    #[test]
    fn the_circle_of_confusion_is_that_of_the_thin_lens() {
        let (focal_length, focus, depth) = (0.05, 2.0, 4.0);
        let lens = Lens { radius: focal_length / (2.0 * 2.0), focus, blades: None, rotation: 0.0 };
        let settings = CameraSettings { lens: Some(lens), ..CameraSettings::new(Transform::IDENTITY, PINHOLE) };
        let camera = Camera::new(&settings, 100, 100).expect("a camera");
        let side = 2.0 * tan(0.4) / 100.0;
        let film = focal_length * focus / (focus - focal_length);
        let middle = DVec2::splat(50.0);
        // Raster points from which rays through the left and right ends of the lens meet the point on the axis.
        let raster = |end: [f64; 2]| middle.x - camera.generate_ray(middle, end, 0.0).at(depth).x / (side * depth);
        let confusion = (raster([1.0, 0.5]) - raster([0.0, 0.5])).abs() * side * film;
        assert!((confusion * 1e3 - 0.320_512_820_5).abs() < 1e-10, "{confusion}");
    }

    /// An edge at 4 m hides everything to its left. It cuts the circle of confusion of a raster point at half of its
    /// radius. The visible part is the area of a segment of the circle.
    #[test]
    fn an_edge_out_of_focus_is_seen_by_its_part_of_the_lens() {
        let lens = Lens { radius: 0.0125, focus: 2.0, blades: None, rotation: 0.0 };
        let settings = CameraSettings { lens: Some(lens), ..CameraSettings::new(Transform::IDENTITY, PINHOLE) };
        let camera = Camera::new(&settings, 100, 100).expect("a camera");
        // At twice the distance of focus, the cone of rays is as wide as the lens.
        let edge = 0.5 * lens.radius;
        let seen =
            (0..DRAWS).filter(|&index| camera.generate_ray(DVec2::splat(50.0), square(index), 0.0).at(4.0).x > edge);
        let expected = (acos(0.5) - 0.5 * (0.75f64).sqrt()) / core::f64::consts::PI;
        let deviation = (expected * (1.0 - expected) / DRAWS as f64).sqrt();
        let z = (seen.count() as f64 / DRAWS as f64 - expected) / deviation;
        assert!(z.abs() < 5.0, "{z}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn rays_of_a_raster_point_meet_in_the_plane_of_focus(
            x in -10.0..130.0f64, y in -10.0..100.0f64, u in 0.0..1.0f64, v in 0.0..1.0f64, round: bool, parallel: bool,
        ) {
            let projection = if parallel { PARALLEL } else { PINHOLE };
            let camera = camera(projection, Some(lens(if round { None } else { Some(7) })));
            let raster = DVec2::new(x, y);
            let (straight, refracted) = (camera.ray(raster, 0.0), camera.generate_ray(raster, [u, v], 0.0));
            prop_assert!((straight.at(3.0) - refracted.at(3.0)).length() < 1e-14 * 30.0);
        }

        #[test]
        fn the_parameter_is_the_depth_through_a_lens(
            x in 0.0..120.0f64, y in 0.0..90.0f64, u in 0.0..1.0f64, v in 0.0..1.0f64, t in 0.0..50.0f64,
        ) {
            let camera = camera(PINHOLE, Some(lens(None)));
            let point = camera.generate_ray(DVec2::new(x, y), [u, v], 0.0).at(t);
            let axis = camera.view_axis();
            let depth = (point - DVec3::new(2.0, -1.0, 5.0)).dot(axis) / 2.0;
            prop_assert!((depth - t).abs() < 1e-12 * (1.0 + t));
        }
    }
}
