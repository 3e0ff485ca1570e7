//! Cylinder lights.

use super::light_sample::{by_solid_angle, density};
use super::{Emission, EmissionSides, LightBounds, LightError, LightLiSample, LightPoint};
use rt_geometry::{CappedQuadric, InteractionFlags, Shape, TransformedShape};
use rt_math::transcendental::{acos, atan2, sincos};
use rt_math::{DMat3, DVec3, Frame, Interval, Ray, Transform, Vector3};
use std::f64::consts::{PI, TAU};

/// Cylinder with or without caps, sampled uniformly by its visible area.
///
/// ```text
///     from above:   _                 visible: of the side the arc of ±α, α = acos(r/ρ),
///                 /   \  α            of the caps the one that faces the point
///                |  ·──|────● point
///                 \ _ /  ρ
/// ```
///
/// All of the area is sampled where the inside is visible and emits. Both hold everywhere for a two-sided open cylinder, and
/// inside of a two-sided closed one.
#[derive(Clone, Debug, PartialEq)]
pub struct CylinderLight {
    placed: TransformedShape,
    base: DVec3,
    /// Its z runs from the base to the top.
    frame: Frame,
    radius: f64,
    length: f64,
    has_caps: bool,
    emission: Emission,
}

/// Visible part of a cylinder.
#[derive(Clone, Copy, Debug)]
struct Visible {
    /// Angle around the axis of the middle of the arc.
    towards: f64,
    /// Half of the angle of the arc; 0 if the side is invisible.
    half_arc: f64,
    /// True for each visible cap: bottom, top.
    caps: [bool; 2],
    /// True if surfaces that face away are visible as well.
    is_inside_seen: bool,
}

impl CylinderLight {
    /// Light around the line from `base` to `top` (world space), with disks at both ends if it `has_caps`. Its front is
    /// outside.
    ///
    /// # Errors
    /// If base and top coincide, the radius is not positive, or a number is not finite.
    pub fn new(base: DVec3, top: DVec3, radius: f64, has_caps: bool, emission: Emission) -> Result<Self, LightError> {
        let axis = rt_geometry::Plane::new(base, top - base)?.normal();
        let length = (top - base).dot(axis);
        let cylinder = CappedQuadric::cylinder(radius, 0.0, length, has_caps)?;
        let frame = Frame::from_z(axis);
        let world_from_local = Transform::from_linear(DMat3::from_cols(frame.y, frame.z, frame.x), base)?;
        let placed = TransformedShape::new(Shape::Cylinder(cylinder), world_from_local);
        Ok(Self { placed, base, frame, radius, length, has_caps, emission })
    }

    /// Area of one side, caps included.
    pub fn area(&self) -> f64 {
        let caps = if self.has_caps { TAU * self.radius * self.radius } else { 0.0 };
        TAU * self.radius * self.length + caps
    }

    /// Emission of the surface.
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// True if emissive parts may lie behind others: those of an open tube that emits on both sides.
    pub fn may_hide_itself(&self) -> bool {
        !self.has_caps && self.emission.sides() == EmissionSides::Both
    }

    /// Samples a direction towards the light from `point`. `None` where the light is invisible, on the light, and if it is black.
    pub fn sample_li(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        let visible = self.visible(point);
        let at = self.point_on(&visible, u);
        let along_normal = (at.point - point).dot(at.normal);
        let pdf = self.pdf_of(&visible, point, at.point, at.normal);
        let extent = self.radius + self.length;
        LightLiSample::of_surface(point, &at, extent, self.emission.emitted(along_normal), pdf)
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) samples the direction from `point` to a point on
    /// the light with the given normal. 0 where the light is invisible.
    pub fn pdf_li_at(&self, point: DVec3, on_light: DVec3, normal: DVec3) -> f64 {
        self.pdf_of(&self.visible(point), point, on_light, normal)
    }

    /// First hit of a ray from `point` with the light.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<LightPoint> {
        let ray = Ray::new(point, direction);
        let hit = self.placed.intersect(&ray, Interval::SPAWNED)?;
        let surface = self.placed.surface(&ray, &hit, InteractionFlags::NONE);
        Some(LightPoint { point: surface.point, normal: surface.geometric_normal, triangle: 0 })
    }

    /// Samples a point uniformly by area, by two numbers in `[0, 1)`. Its `normal` is on the front side.
    pub fn sample_area(&self, u: [f64; 2]) -> LightPoint {
        self.point_on(&self.everything(), u)
    }

    /// Bounds of positions; directions are unrestricted.
    pub fn bounds(&self) -> Option<LightBounds> {
        Some(LightBounds::all_around(self.placed.bounds()?, self.emission.power(self.area())))
    }

    fn everything(&self) -> Visible {
        Visible { towards: 0.0, half_arc: PI, caps: [self.has_caps; 2], is_inside_seen: true }
    }

    fn visible(&self, point: DVec3) -> Visible {
        let local = self.frame.to_local(point - self.base);
        let from_axis = (local.x * local.x + local.y * local.y).sqrt();
        let is_beyond = [local.z < 0.0, local.z > self.length];
        let is_outside = from_axis > self.radius || is_beyond[0] || is_beyond[1];
        if self.emission.sides() == EmissionSides::Both && !(self.has_caps && is_outside) {
            return self.everything();
        }
        let half_arc = if from_axis > self.radius { acos(self.radius / from_axis) } else { 0.0 };
        let caps = is_beyond.map(|is_beyond| is_beyond && self.has_caps);
        Visible { towards: atan2(local.y, local.x), half_arc, caps, is_inside_seen: false }
    }

    /// Visible areas of bottom, top and side.
    fn areas(&self, visible: &Visible) -> [f64; 3] {
        let [bottom, top] = visible.caps.map(|is_seen| if is_seen { PI * self.radius * self.radius } else { 0.0 });
        [bottom, top, 2.0 * visible.half_arc * self.radius * self.length]
    }

    fn pdf_of(&self, visible: &Visible, point: DVec3, on_light: DVec3, normal: DVec3) -> f64 {
        let offset = on_light - point;
        let along_normal = offset.dot(normal);
        let is_seen = along_normal < 0.0 || visible.is_inside_seen;
        if !is_seen || self.emission.emitted(along_normal).is_black() {
            return 0.0;
        }
        let area: f64 = self.areas(visible).iter().sum();
        density(by_solid_angle(1.0 / area, Vector3::from(offset), along_normal))
    }

    /// Point by two numbers. The first selects the part, and its remainder the angle.
    fn point_on(&self, visible: &Visible, u: [f64; 2]) -> LightPoint {
        let [bottom, top, side] = self.areas(visible);
        let area = u[0] * (bottom + top + side);
        let (angle, from_axis, height, along_axis) = if area < bottom {
            (TAU * (area / bottom), self.radius * u[1].sqrt(), 0.0, -1.0)
        } else if area < bottom + top {
            (TAU * ((area - bottom) / top), self.radius * u[1].sqrt(), self.length, 1.0)
        } else {
            let along_arc = (area - bottom - top) / side;
            (visible.towards + visible.half_arc * (2.0 * along_arc - 1.0), self.radius, u[1] * self.length, 0.0)
        };
        let (sin, cos) = sincos(angle);
        let outwards = self.frame.x * cos + self.frame.y * sin;
        let normal = if along_axis == 0.0 { outwards } else { self.frame.z * along_axis };
        let point = self.base + outwards * from_axis + self.frame.z * height;
        LightPoint { point, normal, triangle: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Light;
    use super::super::test_estimate::{
        assert_rays_agree, assert_samples_and_pdf_agree, integral_of_pdf, irradiance, irradiance_by, white,
    };
    use super::*;

    const BASE: DVec3 = DVec3::new(1.0, -2.0, 0.5);
    const AXIS: DVec3 = DVec3::new(0.48, 0.6, 0.64);

    /// A cylinder of length 2 along an odd direction.
    fn cylinder(radius: f64, has_caps: bool, sides: EmissionSides) -> Light {
        let light = CylinderLight::new(BASE, BASE + AXIS * 2.0, radius, has_caps, white(sides));
        Light::Cylinder(light.expect("a light"))
    }

    /// A receiver at a height and a distance from the axis, that faces the middle.
    fn receiver(height: f64, from_axis: f64) -> [DVec3; 2] {
        let point = BASE + AXIS * height + Frame::from_z(AXIS).x * from_axis;
        [point, (BASE + AXIS - point).normalize()]
    }

    #[test]
    fn irradiance_within_is_that_of_the_closed_form() {
        // In the middle of the base, all but the disk at the other end emits; caps close that as well.
        let at = [BASE, AXIS];
        let (r, l) = (0.7, 2.0);
        irradiance(&cylinder(r, false, EmissionSides::Both), at, 200_000)
            .assert("open tube", PI * l * l / (l * l + r * r));
        let inside = [BASE + AXIS * 0.9, DVec3::Y];
        irradiance(&cylinder(r, true, EmissionSides::Both), inside, 200_000).assert("closed tube", PI);
        assert_eq!(cylinder(r, true, EmissionSides::Front).sample_li(inside[0], [0.5; 2]), None);
    }

    /// From far away, a cylinder is its silhouette: 2 r l sin φ + π r² |cos φ|.
    #[test]
    fn irradiance_from_afar_is_that_of_the_silhouette() {
        let (r, d) = (0.3, 1e6);
        for degrees in [90.0f64, 30.0, 5.0, 150.0] {
            let (sin, cos) = sincos(degrees.to_radians());
            let away = AXIS * cos + Frame::from_z(AXIS).y * sin;
            let at = [BASE + AXIS + away * d, -away];
            let silhouette = 2.0 * r * 2.0 * sin + PI * r * r * cos.abs();
            let estimate = irradiance(&cylinder(r, true, EmissionSides::Front), at, 200_000);
            estimate.assert(&format!("cylinder from {degrees}°"), silhouette / (d * d));
        }
    }

    #[test]
    fn densities_agree_and_integrate_to_one() {
        for (height, from_axis) in [(1.0, 1.0), (0.5, 0.301), (3.0, 0.1), (-1.0, 2.0), (2.2, 0.3), (7.0, 20.0)] {
            let at = receiver(height, from_axis);
            let mut lights = vec![cylinder(0.3, true, EmissionSides::Front), cylinder(0.3, true, EmissionSides::Both)];
            // Open tubes hide a part of what is sampled of them where one looks in.
            if (0.0..=2.0).contains(&height) {
                lights.push(cylinder(0.3, false, EmissionSides::Front));
            }
            for light in lights {
                assert_samples_and_pdf_agree(&light, at[0], 1e-6);
                integral_of_pdf(&light, at[0], 50_000).assert(&format!("pdf from {height}, {from_axis}"), 1.0);
                assert_rays_agree(&light, at, 50_000);
            }
        }
        let inside = receiver(0.4, 0.2);
        integral_of_pdf(&cylinder(0.3, true, EmissionSides::Both), inside[0], 50_000).assert("pdf from within", 1.0);
        assert_samples_and_pdf_agree(&cylinder(0.3, true, EmissionSides::Both), inside[0], 1e-6);
    }

    #[test]
    fn a_wrong_density_is_caught() {
        let (light, at) = (cylinder(0.7, true, EmissionSides::Both), [BASE + AXIS * 0.9, DVec3::Y]);
        assert!(irradiance_by(&light, at, 400_000, |s| s.pdf * 1.03).z(PI) > 5.0);
    }

    #[test]
    fn odd_numbers_are_refused() {
        let make = |top, radius| CylinderLight::new(DVec3::ZERO, top, radius, true, white(EmissionSides::Front));
        for (top, radius) in [(DVec3::ZERO, 1.0), (DVec3::X, 0.0), (DVec3::NAN, 1.0), (DVec3::X, f64::NAN)] {
            assert!(make(top, radius).is_err());
        }
    }
}
