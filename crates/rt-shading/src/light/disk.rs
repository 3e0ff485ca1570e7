//! Disk and ring lights.

use super::light_sample::{by_solid_angle, density};
use super::{Emission, LightBounds, LightError, LightLiSample, LightPoint};
use rt_math::transcendental::sincos;
use rt_math::{Aabb, DVec3, Frame, Vector3};
use std::f64::consts::{PI, TAU};

/// Disk or ring, sampled uniformly by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskLight {
    centre: DVec3,
    /// Its z is the normal.
    frame: Frame,
    radius: f64,
    inner_radius: f64,
    area: f64,
    emission: Emission,
}

impl DiskLight {
    /// Light around `centre` (world space) whose front faces along `normal`, of any length. A ring has an inner radius
    /// greater than 0.
    ///
    /// # Errors
    /// If the normal is zero, the radius is not positive, the inner radius is negative or not less, or a number is not
    /// finite.
    pub fn new(
        centre: DVec3,
        normal: DVec3,
        radius: f64,
        inner_radius: f64,
        emission: Emission,
    ) -> Result<Self, LightError> {
        rt_geometry::Disk::new(radius, inner_radius)?;
        let normal = rt_geometry::Plane::new(centre, normal)?.normal();
        let area = PI * (radius - inner_radius) * (radius + inner_radius);
        if !(area > 0.0 && area.is_finite()) {
            return Err(LightError::BadArea(area));
        }
        Ok(Self { centre, frame: Frame::from_z(normal), radius, inner_radius, area, emission })
    }

    /// Area of one side.
    pub const fn area(&self) -> f64 {
        self.area
    }

    /// Emission of the surface.
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// Samples a direction towards the light from `point`. `None` behind a one-sided light, in its plane, and if it is black.
    pub fn sample_li(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        let height = (self.centre - point).dot(self.frame.z);
        let at = self.sample_area(u);
        LightLiSample::of_surface(
            point,
            &at,
            self.radius,
            self.emission.emitted(height),
            self.pdf_li_at(point, at.point),
        )
    }

    /// Samples a point uniformly by area, by two numbers in `[0, 1)`. Its `normal` is on the front side.
    pub fn sample_area(&self, u: [f64; 2]) -> LightPoint {
        let (sin, cos) = sincos(TAU * u[0]);
        let (r, r0) = (self.radius, self.inner_radius);
        let from_centre = (r0 * r0 + u[1] * (r - r0) * (r + r0)).sqrt();
        let point = self.centre + (self.frame.x * cos + self.frame.y * sin) * from_centre;
        LightPoint { point, normal: self.frame.z, triangle: 0 }
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) samples the direction from `point` to a point on
    /// the light. 0 where the light is invisible.
    pub fn pdf_li_at(&self, point: DVec3, on_light: DVec3) -> f64 {
        let height = (self.centre - point).dot(self.frame.z);
        if self.emission.emitted(height).is_black() {
            return 0.0;
        }
        density(by_solid_angle(1.0 / self.area, Vector3::from(on_light - point), height))
    }

    /// Hit of a ray from `point` with the light, from either side.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<LightPoint> {
        let normal = self.frame.z;
        let t = (self.centre - point).dot(normal) / direction.dot(normal);
        let on_plane = point + direction * t;
        let from_centre = (on_plane - self.centre).length();
        let is_inside = (self.inner_radius..=self.radius).contains(&from_centre);
        (t > 0.0 && is_inside).then_some(LightPoint { point: on_plane, normal, triangle: 0 })
    }

    /// Bounds of positions and directions.
    pub fn bounds(&self) -> LightBounds {
        // A disk reaches r·√(1 − n²) along an axis, without the cancellation: the length of what is across.
        let reach =
            DVec3::from([0, 1, 2].map(|i| (self.frame.x[i], self.frame.y[i])).map(|(x, y)| (x * x + y * y).sqrt()));
        let around = Aabb::new(self.centre - reach * self.radius, self.centre + reach * self.radius);
        LightBounds::of_flat(around, self.frame.z, &self.emission, self.area)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_estimate::{
        assert_rays_agree, assert_samples_and_pdf_agree, integral_of_pdf, irradiance, irradiance_by, white,
    };
    use super::super::{EmissionSides, Light, disk_irradiance};
    use super::*;

    /// Disk around the origin that emits towards +z.
    fn disk(radius: f64, inner_radius: f64, sides: EmissionSides) -> Light {
        Light::Disk(DiskLight::new(DVec3::ZERO, DVec3::Z * 3.0, radius, inner_radius, white(sides)).expect("a light"))
    }

    #[test]
    fn irradiance_is_that_of_the_closed_form() {
        for (h, d) in [(1.0, 0.0), (2.0, 0.0), (1.0, 1.0), (2.0, 3.0), (0.05, 0.3), (1e-3, 4.0), (1e6, 0.0), (1e6, 1e6)]
        {
            let at = [DVec3::new(0.6 * d, -0.8 * d, h), DVec3::NEG_Z];
            let estimate = irradiance(&disk(1.0, 0.0, EmissionSides::Front), at, 400_000);
            estimate.assert(&format!("disk from height {h}, off {d}"), disk_irradiance(1.0, h, d));
        }
    }

    #[test]
    fn a_ring_is_a_disk_less_its_hole() {
        for (h, d) in [(1.0, 0.0), (0.4, 0.7)] {
            let at = [DVec3::new(d, 0.0, h), DVec3::NEG_Z];
            let hole = disk_irradiance(0.5, h, d);
            irradiance(&disk(1.0, 0.5, EmissionSides::Front), at, 200_000)
                .assert("ring", disk_irradiance(1.0, h, d) - hole);
        }
    }

    #[test]
    fn densities_agree_and_integrate_to_one() {
        let light = disk(1.0, 0.25, EmissionSides::Both);
        for point in [DVec3::new(0.1, 0.2, 0.7), DVec3::new(0.9, 0.9, -0.3), DVec3::new(0.0, 30.0, 20.0)] {
            assert_samples_and_pdf_agree(&light, point, 1e-10);
            integral_of_pdf(&light, point, 200_000).assert(&format!("pdf from {point}"), 1.0);
            let at = [point, (DVec3::new(0.5, 0.0, 0.0) - point).normalize()];
            assert_rays_agree(&light, at, 200_000);
        }
    }

    #[test]
    fn a_wrong_density_is_caught() {
        let (light, at) = (disk(1.0, 0.0, EmissionSides::Front), [DVec3::Z, DVec3::NEG_Z]);
        assert!(irradiance_by(&light, at, 100_000, |s| s.pdf * 1.01).z(disk_irradiance(1.0, 1.0, 0.0)) > 5.0);
    }

    #[test]
    fn nothing_comes_from_behind_or_from_the_plane() {
        let front = disk(1.0, 0.0, EmissionSides::Front);
        assert_eq!((front.sample_li(DVec3::NEG_Z, [0.5; 2]), front.pdf_li(DVec3::NEG_Z, DVec3::Z)), (None, 0.0));
        for point in [DVec3::ZERO, DVec3::X * 4.0] {
            assert_eq!(disk(1.0, 0.0, EmissionSides::Both).sample_li(point, [0.5; 2]), None, "{point}");
            assert_eq!(front.pdf_li(point, DVec3::Z), 0.0);
        }
        let make =
            |radius, inner, normal| DiskLight::new(DVec3::ZERO, normal, radius, inner, white(EmissionSides::Front));
        for (radius, inner, normal) in
            [(0.0, 0.0, DVec3::Z), (1.0, 1.0, DVec3::Z), (1.0, 0.0, DVec3::ZERO), (f64::NAN, 0.0, DVec3::Z)]
        {
            assert!(make(radius, inner, normal).is_err());
        }
    }

    #[test]
    fn bounds_are_tight() {
        let normal = DVec3::new(1.0, 0.0, 1.0);
        let light = DiskLight::new(DVec3::X, normal, 2.0, 0.0, white(EmissionSides::Front)).expect("a light");
        let expected = DVec3::new(2.0f64.sqrt(), 2.0, 2.0f64.sqrt());
        assert!((light.bounds().around().extent() - 2.0 * expected).length() < 1e-14);
    }
}
