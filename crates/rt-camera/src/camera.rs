//! The virtual camera: a pinhole or a thin lens.

mod sample_wi;

use rt_math::{AnimatedTransform, DVec2, DVec3, Ray, Transform, transcendental::tan};

use crate::{
    CameraError, Lens,
    lens::Aperture,
    simd::vectorize,
    view_volume::{Pencil, Rim, ViewVolume},
};

/// Side of the image that the field of view spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    /// The height of the image.
    Vertical,
    /// The width of the image.
    Horizontal,
}

/// Projection of points to the image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a pinhole.
    Perspective {
        /// Full opening angle in radians, in (0, π).
        fov: f64,
        /// The side of the image that it spans.
        axis: FovAxis,
    },
    /// Along parallel rays.
    Orthographic {
        /// Height of the visible part of the world, in world units.
        height: f64,
    },
}

/// Settings of a camera, without the size of its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSettings {
    /// The camera looks along its −z, with +y up and +x to the right.
    pub world_from_camera: Transform,
    /// Pose at time 1, if the camera moves; [`world_from_camera`](Self::world_from_camera) is that at time 0.
    pub moves_to: Option<Transform>,
    /// Times at which the shutter opens and closes, from 0 to 1.
    pub shutter: [f64; 2],
    /// The projection.
    pub projection: Projection,
    /// Shift of the lens, as a part of the image's width and height. (0.5, 0) moves the view by half an image to the
    /// right, (0, 0.5) by half an image up.
    pub lens_shift: DVec2,
    /// Lens for depth of field; a pinhole if `None`.
    pub lens: Option<Lens>,
}

impl CameraSettings {
    /// Static pinhole camera without lens shift. The shutter is open from 0 to 1.
    pub const fn new(world_from_camera: Transform, projection: Projection) -> Self {
        Self { world_from_camera, moves_to: None, shutter: [0.0, 1.0], projection, lens_shift: DVec2::ZERO, lens: None }
    }
}

/// Destination of [`Camera::rays`]: one slice for each coordinate.
#[derive(Debug)]
pub struct RayArrays<'a> {
    /// Coordinates of the origins, in world space.
    pub origin: [&'a mut [f64]; 3],
    /// Coordinates of the directions, in world space; not of unit length.
    pub direction: [&'a mut [f64]; 3],
}

/// A camera and the image that it exposes, ready to cast rays.
///
/// Raster coordinates are in pixels from the image's top left corner, x to the right and y down. Pixel (i, j) covers
/// the square from (i, j) to (i + 1, j + 1). Pixels have the side `s` on the image plane at distance 1 from the
/// pinhole. The principal point `c` is the image's centre, moved against the lens shift. The perspective ray through
/// the raster point `r` is
///
/// ```text
/// direction = −z + s·(r.x − c.x)·x − s·(r.y − c.y)·y,      s = 2·tan(fov / 2) / pixels across
/// ```
///
/// in the camera's axes x, y, z. The component along the view is 1, so **the parameter `t` of a point is its depth**.
/// Depth is the distance from the camera plane (not from the pinhole), in units of the camera's own space. This holds
/// for the orthographic camera as well, whose rays start on the camera plane. Rays of a [`Lens`] start at a point λ of
/// the aperture. They lead to the intersection of the ray through its centre with the plane of focus:
///
/// ```text
/// origin' = origin + λ,      direction' = direction − λ / focus
/// ```
///
/// For each ray, a moving camera is the camera at rest where it is at the ray's time.
///
/// ```
/// use rt_camera::{Camera, CameraSettings, FovAxis, Projection};
/// use rt_math::{DVec2, DVec3, Transform};
///
/// let place = Transform::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y)?;
/// let projection = Projection::Perspective { fov: 90f64.to_radians(), axis: FovAxis::Vertical };
/// let settings = CameraSettings::new(place, projection);
/// let camera = Camera::new(&settings, 640, 480)?;
/// let ray = camera.ray(DVec2::new(320.0, 240.0), 0.0);
/// assert_eq!(ray.at(5.0), DVec3::ZERO);
/// assert_eq!(camera.project(DVec3::ZERO), Some(DVec2::new(320.0, 240.0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    world_from_camera: Transform,
    /// Motion of the camera while the shutter is open.
    motion: Option<AnimatedTransform>,
    shutter: [f64; 2],
    is_perspective: bool,
    /// The camera's −z in world space, as long as the transform makes it.
    forward: DVec3,
    /// One pixel to the right on the image plane, in world space.
    step_right: DVec3,
    /// One pixel down on the image plane, in world space.
    step_down: DVec3,
    /// Side of a pixel on the image plane, in camera space.
    pixel_side: f64,
    /// Principal point: intersection of the view axis with the image, in raster coordinates.
    principal_point: DVec2,
    /// Lens with an aperture above 0.
    lens: Option<Aperture>,
}

impl Camera {
    /// A camera that exposes an image of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`CameraError`] if a side is 0, the field of view lies outside (0, π), the orthographic height is not positive,
    /// the lens or the shutter is unusable, the motion of the camera cannot be interpolated, or a number is NaN,
    /// infinite, or so large that rays would not be finite.
    pub fn new(settings: &CameraSettings, width: u32, height: u32) -> Result<Self, CameraError> {
        if width == 0 || height == 0 {
            return Err(CameraError::EmptyImage(width, height));
        }
        if !settings.lens_shift.is_finite() {
            return Err(CameraError::LensShift(settings.lens_shift));
        }
        if let Some(lens) = &settings.lens {
            lens.check()?;
        }
        let [opens, closes] = settings.shutter;
        if !(0.0 <= opens && opens <= closes && closes <= 1.0) {
            return Err(CameraError::Shutter(settings.shutter));
        }
        let size = DVec2::new(f64::from(width), f64::from(height));
        let pixel_side = pixel_side(settings.projection, size)?;
        let motion = match &settings.moves_to {
            Some(end) => Some(AnimatedTransform::new(&settings.world_from_camera, end)?),
            None => None,
        };
        let world_from_camera = motion.map_or(settings.world_from_camera, |motion| motion.at(opens));
        let moving = motion.filter(|motion| opens < closes && motion.start() != motion.end());
        let axes = world_from_camera.linear();
        // Raster y runs down and the camera's y up.
        let towards_lower_left = settings.lens_shift * DVec2::new(-1.0, 1.0);
        let camera = Self {
            world_from_camera,
            motion: moving,
            shutter: settings.shutter,
            is_perspective: matches!(settings.projection, Projection::Perspective { .. }),
            forward: -axes.z_axis,
            step_right: axes.x_axis * pixel_side,
            step_down: axes.y_axis * -pixel_side,
            pixel_side,
            principal_point: (towards_lower_left + 0.5) * size,
            lens: settings.lens.filter(|lens| lens.radius > 0.0).map(Aperture::new),
        };
        let corners = [DVec2::ZERO, DVec2::new(size.x, 0.0), DVec2::new(0.0, size.y), size];
        let times = if moving.is_some() { [opens, closes] } else { [opens; 2] };
        let all_finite = corners
            .into_iter()
            .flat_map(|corner| {
                times.map(|time| [camera.ray(corner, time), camera.generate_ray(corner, [1.0; 2], time)])
            })
            .flatten()
            .all(|ray| ray.origin.is_finite() && ray.direction.is_finite());
        if all_finite { Ok(camera) } else { Err(CameraError::Overflow) }
    }

    /// True if rays start at different points of a lens, so that they take a pair of numbers beyond the raster point.
    pub const fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// True if the camera moves while the shutter is open.
    pub const fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// Time at which the shutter has been open for this part of its interval: 0 when it opens, 1 when it closes.
    pub fn shutter_time(&self, part: f64) -> f64 {
        let [opens, closes] = self.shutter;
        opens + (closes - opens) * part
    }

    /// Times at which the shutter opens and closes, in \[0, 1\].
    pub const fn shutter(&self) -> [f64; 2] {
        self.shutter
    }

    /// The camera at a time.
    fn at(&self, time: f64) -> Self {
        let Some(motion) = &self.motion else { return *self };
        let world_from_camera = motion.at(time);
        let axes = world_from_camera.linear();
        Self {
            world_from_camera,
            motion: None,
            forward: -axes.z_axis,
            step_right: axes.x_axis * self.pixel_side,
            step_down: axes.y_axis * -self.pixel_side,
            ..*self
        }
    }

    /// Ray through a raster point and a point of the lens, given by a point of the unit square. Without a lens,
    /// [`ray`](Self::ray).
    #[inline]
    pub fn generate_ray(&self, raster: DVec2, on_lens: [f64; 2], time: f64) -> Ray {
        let Some(lens) = &self.lens else { return self.ray(raster, time) };
        let here = self.at(time);
        let centre = here.ray(raster, time);
        let aside = here.aside(lens, on_lens);
        Ray { origin: centre.origin + aside, direction: centre.direction - aside / lens.lens().focus, time }
    }

    /// Offset of a point of the lens from its centre, in world space.
    #[inline(always)]
    fn aside(&self, lens: &Aperture, on_lens: [f64; 2]) -> DVec3 {
        let DVec2 { x, y } = lens.point(on_lens);
        self.world_from_camera.vector(DVec3::new(x, y, 0.0))
    }

    /// The ray through a raster point and the pinhole, or the centre of the lens, at a time of the shutter. Points outside
    /// the image are fine.
    #[inline]
    pub fn ray(&self, raster: DVec2, time: f64) -> Ray {
        // Number by number, so that rays travel in registers.
        let [origin, direction] = if self.motion.is_some() {
            let Ray { origin, direction, .. } = self.at(time).ray(raster, time);
            [origin, direction]
        } else {
            let from_centre = raster - self.principal_point;
            let across = self.step_right * from_centre.x + self.step_down * from_centre.y;
            let pinhole = self.world_from_camera.translation();
            if self.is_perspective { [pinhole, self.forward + across] } else { [pinhole + across, self.forward] }
        };
        Ray { origin, direction, time }
    }

    /// [`generate_ray`](Self::generate_ray) for many raster points, given by their offsets from `corner`, and their points of the lens,
    /// when the shutter opens. Bit-identical to rays one by one. Only as many are computed as all slices have numbers; a camera
    /// without a lens needs no points of it.
    pub fn rays(&self, corner: DVec2, offsets: &[[f64; 2]], on_lens: &[[f64; 2]], rays: RayArrays<'_>) {
        let Self { is_perspective, forward, step_right, step_down, principal_point, .. } = *self;
        let pinhole = self.world_from_camera.translation();
        let RayArrays { origin: [x, y, z], direction: [u, v, w] } = rays;
        let offsets = if self.has_lens() { &offsets[..offsets.len().min(on_lens.len())] } else { offsets };
        vectorize(
            #[inline(always)]
            || {
                let ((x, y, z), (u, v, w)) = ((&mut *x, &mut *y, &mut *z), (&mut *u, &mut *v, &mut *w));
                let (origins, directions) = (x.iter_mut().zip(y).zip(z), u.iter_mut().zip(v).zip(w));
                for ((&[i, j], ((x, y), z)), ((u, v), w)) in offsets.iter().zip(origins).zip(directions) {
                    let (i, j) = (corner.x + i - principal_point.x, corner.y + j - principal_point.y);
                    let across = [
                        step_right.x * i + step_down.x * j,
                        step_right.y * i + step_down.y * j,
                        step_right.z * i + step_down.z * j,
                    ];
                    if is_perspective {
                        [*x, *y, *z] = pinhole.to_array();
                        [*u, *v, *w] = [forward.x + across[0], forward.y + across[1], forward.z + across[2]];
                    } else {
                        [*x, *y, *z] = [pinhole.x + across[0], pinhole.y + across[1], pinhole.z + across[2]];
                        [*u, *v, *w] = forward.to_array();
                    }
                }
            },
        );
        let Some(lens) = &self.lens else { return };
        vectorize(
            #[inline(always)]
            || {
                let (origins, directions) = (x.iter_mut().zip(y).zip(z), u.iter_mut().zip(v).zip(w));
                for ((&on_lens, ((x, y), z)), ((u, v), w)) in
                    on_lens.iter().take(offsets.len()).zip(origins).zip(directions)
                {
                    let aside = self.aside(lens, on_lens);
                    let turn = aside / lens.lens().focus;
                    (*x, *y, *z) = (*x + aside.x, *y + aside.y, *z + aside.z);
                    (*u, *v, *w) = (*u - turn.x, *v - turn.y, *w - turn.z);
                }
            },
        );
    }

    /// Depth of a world-space point along the view axis when the shutter opens, in units of the camera's space.
    /// Negative behind the camera.
    pub fn depth(&self, world: DVec3) -> f64 {
        -self.world_from_camera.inverse_point(world).z
    }

    /// Projection of a world point through the pinhole or the centre of the lens when the shutter opens, in raster
    /// coordinates; possibly outside the image. `None` for a point behind the camera plane, for one on the plane of a pinhole
    /// camera, and for one whose image is not finite.
    pub fn project(&self, world: DVec3) -> Option<DVec2> {
        let point = self.world_from_camera.inverse_point(world);
        let depth = -point.z;
        let on_plane = if self.is_perspective && depth > 0.0 {
            DVec2::new(point.x, -point.y) / depth
        } else if !self.is_perspective && depth >= 0.0 {
            DVec2::new(point.x, -point.y)
        } else {
            return None;
        };
        let raster = self.principal_point + on_plane / self.pixel_side;
        raster.is_finite().then_some(raster)
    }

    /// Volume of the rays through the raster points from `min` to `max` and any points of the lens, when the shutter
    /// opens. Points outside the image are valid. For all rays of an image, widen it by the sample offset and the
    /// filter's radius.
    pub fn view_volume(&self, min: DVec2, max: DVec2) -> ViewVolume {
        ViewVolume::new(&Pencil {
            origin: self.world_from_camera.translation(),
            forward: self.forward,
            right: self.step_right,
            down: self.step_down,
            min: min - self.principal_point,
            max: max - self.principal_point,
            is_perspective: self.is_perspective,
            rim: self.lens.map(|lens| {
                let Lens { radius, focus, .. } = *lens.lens();
                Rim { steps: radius / self.pixel_side, focus }
            }),
        })
    }

    /// The direction of view at a time of the shutter: a unit vector in world space.
    pub fn view_axis_at(&self, time: f64) -> DVec3 {
        self.at(time).view_axis()
    }

    /// The direction of view when the shutter opens: a unit vector in world space.
    pub fn view_axis(&self) -> DVec3 {
        // Scaled first, since the square of a very long or short axis leaves the range of f64.
        (self.forward / self.forward.abs().max_element()).normalize_or(DVec3::NEG_Z)
    }
}

/// Side of a square pixel, on the image plane at distance 1 (perspective) or in world units (orthographic).
fn pixel_side(projection: Projection, size: DVec2) -> Result<f64, CameraError> {
    let (side, refusal) = match projection {
        Projection::Perspective { fov, axis } => {
            let pixels_across = match axis {
                FovAxis::Vertical => size.y,
                FovAxis::Horizontal => size.x,
            };
            let inside = fov > 0.0 && fov < core::f64::consts::PI;
            let tangent = if inside { tan(fov / 2.0) } else { f64::NAN };
            (2.0 * tangent / pixels_across, CameraError::FieldOfView(fov))
        }
        Projection::Orthographic { height } => (height / size.y, CameraError::Height(height)),
    };
    // Subnormal sides would lose the digits that tell neighbouring pixels apart.
    if side.is_normal() && side > 0.0 { Ok(side) } else { Err(refusal) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};
    use proptest::prelude::*;

    fn perspective(fov: f64, axis: FovAxis) -> CameraSettings {
        CameraSettings::new(Transform::IDENTITY, Projection::Perspective { fov, axis })
    }

    fn orthographic(height: f64) -> CameraSettings {
        CameraSettings { projection: Projection::Orthographic { height }, ..perspective(1.0, FovAxis::Vertical) }
    }

    #[test]
    fn rays_of_many_raster_points_are_those_one_by_one() {
        let place =
            Transform::look_at(DVec3::new(2.0, -1.0, 5.0), DVec3::new(0.1, 0.2, 0.3), DVec3::Y).expect("a view");
        let lens = |blades| Some(Lens { radius: 0.2, focus: 3.0, blades, rotation: 0.3 });
        let lenses = [None, lens(None), lens(Some(3)), lens(Some(16)), lens(Some(17)), lens(Some(u32::MAX))];
        let projections = [perspective(0.7, FovAxis::Horizontal), orthographic(3.0)];
        for settings in
            projections.into_iter().flat_map(|settings| lenses.map(|lens| CameraSettings { lens, ..settings }))
        {
            let settings = CameraSettings { world_from_camera: place, lens_shift: DVec2::new(0.3, -0.1), ..settings };
            let camera = Camera::new(&settings, 64, 48).expect("a camera");
            let offsets: [_; 37] = core::array::from_fn(|at| [at as f64 * 0.13 - 0.5, 0.7 - (at * at) as f64 * 0.01]);
            let on_lens: [_; 37] = core::array::from_fn(|at| [at as f64 / 36.0, (at * at % 37) as f64 / 36.0]);
            let corner = DVec2::new(17.0, 31.0);
            let (mut origin, mut direction) = ([[0.0; 37]; 3], [[0.0; 37]; 3]);
            camera.rays(
                corner,
                &offsets,
                if settings.lens.is_some() { &on_lens } else { &[] },
                RayArrays {
                    origin: origin.each_mut().map(<[_; 37]>::as_mut_slice),
                    direction: direction.each_mut().map(<[_; 37]>::as_mut_slice),
                },
            );
            for (at, offset) in offsets.into_iter().enumerate() {
                let ray = camera.generate_ray(corner + DVec2::from_array(offset), on_lens[at], 0.0);
                for (expected, found) in [(ray.origin, &origin), (ray.direction, &direction)] {
                    let found = found.map(|numbers| numbers[at]);
                    assert_eq!(expected.to_array().map(f64::to_bits), found.map(f64::to_bits), "{settings:?}");
                }
            }
        }
    }

    #[test]
    fn edges_of_the_image_see_half_the_field_of_view() {
        let vertical = Camera::new(&perspective(FRAC_PI_2, FovAxis::Vertical), 200, 100).expect("a camera");
        let top = vertical.ray(DVec2::new(100.0, 0.0), 0.25);
        assert!((top.direction - DVec3::new(0.0, 1.0, -1.0)).length() < 1e-15);
        assert_eq!(top.time, 0.25);
        let left = vertical.ray(DVec2::new(0.0, 50.0), 0.0);
        assert!((left.direction - DVec3::new(-2.0, 0.0, -1.0)).length() < 1e-15);

        let horizontal = Camera::new(&perspective(FRAC_PI_3, FovAxis::Horizontal), 200, 100).expect("a camera");
        let right = horizontal.ray(DVec2::new(200.0, 50.0), 0.0).direction;
        assert!((right.normalize().dot(horizontal.view_axis()) - (3f64).sqrt() / 2.0).abs() < 1e-15);
    }

    #[test]
    fn orthographic_rays_are_parallel_and_start_on_the_camera_plane() {
        let mut settings = orthographic(4.0);
        settings.world_from_camera = Transform::look_at(DVec3::X * 7.0, DVec3::ZERO, DVec3::Y).expect("a view");
        let camera = Camera::new(&settings, 20, 10).expect("a camera");
        let corner = camera.ray(DVec2::ZERO, 0.0);
        assert!((corner.origin - DVec3::new(7.0, 2.0, 4.0)).length() < 1e-14);
        assert!((corner.direction - DVec3::NEG_X).length() < 1e-15);
        assert_eq!(camera.ray(DVec2::splat(3.0), 0.0).direction, corner.direction);
    }

    #[test]
    fn lens_shift_moves_the_view_and_keeps_the_axis() {
        let plain = Camera::new(&perspective(1.0, FovAxis::Vertical), 60, 40).expect("a camera");
        let shifted_settings =
            CameraSettings { lens_shift: DVec2::new(0.5, 0.25), ..perspective(1.0, FovAxis::Vertical) };
        let shifted = Camera::new(&shifted_settings, 60, 40).expect("a camera");
        // Half a width to the right is raster x + 30, a quarter of the height up is raster y − 10.
        let (a, b) = (shifted.ray(DVec2::new(12.0, 20.0), 0.0), plain.ray(DVec2::new(42.0, 10.0), 0.0));
        assert!((a.direction - b.direction).length() < 1e-15);
        assert_eq!(plain.view_axis(), shifted.view_axis());
    }

    #[test]
    fn mirrored_raster_points_give_mirrored_rays_to_the_bit() {
        let camera = Camera::new(&perspective(0.7, FovAxis::Vertical), 64, 48).expect("a camera");
        let (left, right) = (camera.ray(DVec2::new(10.25, 7.0), 0.0), camera.ray(DVec2::new(53.75, 7.0), 0.0));
        assert_eq!(left.direction * DVec3::new(-1.0, 1.0, 1.0), right.direction);
    }

    #[test]
    fn points_behind_the_camera_have_no_image() {
        let pinhole = Camera::new(&perspective(1.0, FovAxis::Vertical), 8, 8).expect("a camera");
        assert_eq!(pinhole.project(DVec3::Z), None);
        assert_eq!(pinhole.project(DVec3::X), None);
        assert_eq!(pinhole.project(DVec3::NAN), None);
        let parallel = Camera::new(&orthographic(8.0), 8, 8).expect("a camera");
        assert_eq!(parallel.project(DVec3::Z), None);
        assert_eq!(parallel.project(DVec3::X), Some(DVec2::new(5.0, 4.0)));
    }

    #[test]
    fn useless_settings_are_refused() {
        let refuse = |settings: CameraSettings| Camera::new(&settings, 4, 4).expect_err("refused");
        for fov in [0.0, -1.0, PI, 4.0, f64::INFINITY, 5e-324] {
            assert_eq!(refuse(perspective(fov, FovAxis::Vertical)), CameraError::FieldOfView(fov));
        }
        assert!(matches!(refuse(perspective(f64::NAN, FovAxis::Vertical)), CameraError::FieldOfView(f) if f.is_nan()));
        for height in [0.0, -2.0, f64::INFINITY] {
            assert_eq!(refuse(orthographic(height)), CameraError::Height(height));
        }
        assert!(matches!(refuse(orthographic(f64::NAN)), CameraError::Height(h) if h.is_nan()));
        let shift = DVec2::new(f64::INFINITY, 0.0);
        assert_eq!(refuse(CameraSettings { lens_shift: shift, ..orthographic(1.0) }), CameraError::LensShift(shift));
        let far = CameraSettings { lens_shift: DVec2::splat(1e308), ..orthographic(100.0) };
        assert_eq!(refuse(far), CameraError::Overflow);
        let sound = perspective(1.0, FovAxis::Vertical);
        assert_eq!(Camera::new(&sound, 0, 4).expect_err("refused"), CameraError::EmptyImage(0, 4));
        assert_eq!(Camera::new(&sound, 4, 0).expect_err("refused"), CameraError::EmptyImage(4, 0));
    }

    #[test]
    fn widest_and_narrowest_views_are_finite() {
        for fov in [1e-9, PI - 1e-9] {
            let camera = Camera::new(&perspective(fov, FovAxis::Vertical), 3, 3).expect("a camera");
            assert!(camera.ray(DVec2::ZERO, 0.0).direction.is_finite());
        }
    }

    fn any_settings() -> impl Strategy<Value = CameraSettings> {
        let vector = || (-10.0..10.0f64, -10.0..10.0f64, -10.0..10.0f64).prop_map(DVec3::from);
        let projection = prop_oneof![
            (0.05..3.0f64).prop_map(|fov| Projection::Perspective { fov, axis: FovAxis::Vertical }),
            (0.05..3.0f64).prop_map(|fov| Projection::Perspective { fov, axis: FovAxis::Horizontal }),
            (0.1..50.0f64).prop_map(|height| Projection::Orthographic { height }),
        ];
        (vector(), vector(), 0.1..5.0f64, projection, -1.0..1.0f64, -1.0..1.0f64).prop_filter_map(
            "degenerate view",
            |(eye, target, scale, projection, shift_x, shift_y)| {
                let view = Transform::look_at(eye, target, DVec3::Y).ok()?;
                let world_from_camera = view.compose(&Transform::scale(DVec3::splat(scale)).ok()?);
                let lens_shift = DVec2::new(shift_x, shift_y);
                Some(CameraSettings { lens_shift, ..CameraSettings::new(world_from_camera, projection) })
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]
        #[test]
        fn projecting_a_point_of_a_ray_returns_to_the_raster(
            settings in any_settings(), x in -50.0..150.0f64, y in -50.0..150.0f64, depth in 0.5..100.0f64,
        ) {
            let camera = Camera::new(&settings, 120, 90).expect("sound settings");
            let raster = DVec2::new(x, y);
            let back = camera.project(camera.ray(raster, 0.0).at(depth)).expect("in front of the camera");
            prop_assert!((back - raster).length() < 1e-7, "{back}");
        }

        #[test]
        fn the_parameter_is_the_depth(settings in any_settings(), x in 0.0..120.0f64, y in 0.0..90.0f64, t in 0.0..50.0f64) {
            let camera = Camera::new(&settings, 120, 90).expect("sound settings");
            let point = settings.world_from_camera.inverse_point(camera.ray(DVec2::new(x, y), 0.0).at(t));
            prop_assert!((-point.z - t).abs() < 1e-9 * (1.0 + t));
        }
    }
}
