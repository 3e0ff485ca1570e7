//! Sphere lights.

use super::light_sample::density;
use super::solid_angle::uniform_sphere;
use super::{Emission, EmissionSides, LightBounds, LightError, LightLiSample, LightPoint};
use rt_geometry::Sphere;
use rt_math::transcendental::sincos;
use rt_math::{DVec3, Frame, Interval, Ray};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Sphere, sampled uniformly within the cone that it subtends (Shirley, Wang, Zimmerman, "Monte Carlo Techniques for
/// Direct Lighting Calculations", 1996).
///
/// ```text
///   sin²θ = r²/d²     1 − cos θ = sin²θ / (1 + cos θ)     Ω = 2π (1 − cos θ)
/// ```
///
/// No cancellation: far away, `1 − cos θ` is not a difference of two numbers near 1; near the surface, `cos²θ` is
/// `(d − r)(d + r)/d²`. From inside, sampling is uniform over all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    sphere: Sphere,
    emission: Emission,
}

/// Position of a point relative to a sphere.
enum SphereView {
    Outside(Subtended),
    /// Inside or on the surface.
    Within,
    /// Distance overflows or is NaN.
    Nowhere,
}

/// Cone that a sphere subtends from outside.
struct Subtended {
    /// Unit vector towards the centre.
    axis: DVec3,
    /// Sine of half the angle.
    sin: f64,
    /// One minus the cosine of half the angle.
    one_minus_cos: f64,
}

impl SphereLight {
    /// Light of the given radius around `centre`, world space. Its front is outside.
    ///
    /// # Errors
    /// If the radius is not positive, or a number is not finite.
    pub fn new(centre: DVec3, radius: f64, emission: Emission) -> Result<Self, LightError> {
        Ok(Self { sphere: Sphere::new(centre, radius)?, emission })
    }

    /// Area of one side.
    pub fn area(&self) -> f64 {
        4.0 * PI * self.sphere.radius() * self.sphere.radius()
    }

    /// Emission of the surface.
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// Solid angle that the light subtends: that of the cone from outside. Inside and on the surface it is 4π for a two-sided
    /// light and 0 for a one-sided one.
    pub fn solid_angle(&self, point: DVec3) -> f64 {
        match (self.view_from(point), self.emission.sides()) {
            (SphereView::Outside(cone), _) => TAU * cone.one_minus_cos,
            (SphereView::Within, EmissionSides::Both) => 4.0 * PI,
            (SphereView::Within, EmissionSides::Front) | (SphereView::Nowhere, _) => 0.0,
        }
    }

    /// Samples a direction towards the light from `point`; `None` if the light is black. Outside, directions are in the cone
    /// that the light subtends. Inside and on the surface of a one-sided light the result is `None`. For a two-sided light,
    /// directions are then uniform over the sphere; on its surface, those that leave it give `None`.
    pub fn sample_li(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        match (self.view_from(point), self.emission.sides()) {
            (SphereView::Outside(cone), _) => self.sample_outside(point, &cone, u),
            (SphereView::Within, EmissionSides::Both) => self.sample_within(point, u),
            (SphereView::Within, EmissionSides::Front) | (SphereView::Nowhere, _) => None,
        }
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) samples any direction that hits the light.
    pub fn pdf_li_at(&self, point: DVec3) -> f64 {
        if self.emission.radiance().is_black() { 0.0 } else { density(1.0 / self.solid_angle(point)) }
    }

    /// First hit of a ray from `point` with the light.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<LightPoint> {
        let ray = Ray::new(point, direction);
        let hit = self.sphere.intersect(&ray, Interval::SPAWNED)?;
        let normal = (ray.at(hit.t) - self.sphere.centre()).try_normalize()?;
        Some(self.on_surface(normal))
    }

    /// Samples a point uniformly by area, by two numbers in `[0, 1)`. Its `normal` is on the front side.
    pub fn sample_area(&self, u: [f64; 2]) -> LightPoint {
        self.on_surface(uniform_sphere(u))
    }

    /// Bounds of positions; directions are unrestricted.
    pub fn bounds(&self) -> LightBounds {
        LightBounds::all_around(self.sphere.bounds(), self.emission.power(self.area()))
    }

    fn view_from(&self, point: DVec3) -> SphereView {
        let (towards, radius) = (self.sphere.centre() - point, self.sphere.radius());
        let distance = towards.length();
        if distance <= radius {
            return SphereView::Within;
        }
        if !distance.is_finite() {
            return SphereView::Nowhere;
        }
        let sin = radius / distance;
        let cos = ((distance - radius) / distance * (1.0 + sin)).sqrt();
        SphereView::Outside(Subtended { axis: towards / distance, sin, one_minus_cos: sin * sin / (1.0 + cos) })
    }

    fn on_surface(&self, normal: DVec3) -> LightPoint {
        LightPoint { point: self.sphere.centre() + normal * self.sphere.radius(), normal, triangle: 0 }
    }

    /// Sample from outside. The angle at the centre turns directions into points, as in PBR 4th ed., section 6.2.4. The point is
    /// thus on the sphere to the last digits, even far away from a small one.
    fn sample_outside(&self, point: DVec3, cone: &Subtended, u: [f64; 2]) -> Option<LightLiSample> {
        let one_minus_cos = u[0].clamp(0.0, 1.0) * cone.one_minus_cos;
        let sin2 = one_minus_cos * (2.0 - one_minus_cos);
        // Half the chord in units of the radius: √(1 − sin²θ/sin²θmax).
        let ratio2 = (sin2 / (cone.sin * cone.sin)).min(1.0);
        let half_chord = (1.0 - ratio2).sqrt();
        let cos_centre = sin2 / cone.sin + (1.0 - one_minus_cos) * half_chord;
        let (sin, cos) = (sin2.sqrt(), 1.0 - one_minus_cos);
        let sin_centre = sin * (cos / cone.sin - half_chord);
        let (sin_phi, cos_phi) = sincos(TAU * u[1]);
        let frame = Frame::from_z(-cone.axis);
        let normal = frame.from_local(DVec3::new(sin_centre * cos_phi, sin_centre * sin_phi, cos_centre));
        let direction = frame.from_local(DVec3::new(sin * cos_phi, sin * sin_phi, -cos));
        let pdf = 1.0 / (TAU * cone.one_minus_cos);
        let (at, radiance) = (self.on_surface(normal), self.emission.radiance());
        let sample = LightLiSample::of_surface(point, &at, self.sphere.radius(), radiance, pdf)?;
        // Next to the surface the direction to the point has fewer digits than the sampled direction.
        Some(LightLiSample { direction, ..sample })
    }

    /// True for a direction that leaves the sphere from a point of its surface. Rounding puts half of these points inside, where
    /// every direction hits the sphere.
    fn leaves(&self, point: DVec3, direction: DVec3) -> bool {
        /// Error of a hit point, in units of the largest number that it is computed from.
        const ROUNDING: f64 = 64.0 * f64::EPSILON;
        let (outwards, radius) = (point - self.sphere.centre(), self.sphere.radius());
        let error = ROUNDING * (self.sphere.centre().length() + radius);
        outwards.length() >= radius - error && outwards.dot(direction) >= 0.0
    }

    fn sample_within(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        let direction = uniform_sphere(u);
        if self.leaves(point, direction) {
            return None;
        }
        let at = self.intersect(point, direction)?;
        let radiance = self.emission.radiance();
        LightLiSample::of_surface(point, &at, self.sphere.radius(), radiance, 0.25 * FRAC_1_PI)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Light;
    use super::super::sphere_irradiance;
    use super::super::test_estimate::{
        assert_samples_and_pdf_agree, integral_of_pdf, irradiance, irradiance_by, white,
    };
    use super::*;
    use rt_math::Rgb;

    fn sphere(radius: f64, sides: EmissionSides) -> Light {
        Light::Sphere(SphereLight::new(DVec3::ZERO, radius, white(sides)).expect("a light"))
    }

    /// A receiver at a distance in an odd direction, whose normal is at an angle to the direction of the centre.
    fn receiver(distance: f64, theta: f64) -> [DVec3; 2] {
        let away = DVec3::new(0.48, -0.6, 0.64);
        let (sin, cos) = sincos(theta);
        [away * distance, Frame::from_z(-away).from_local(DVec3::new(sin, 0.0, cos))]
    }

    #[test]
    fn a_two_sided_sphere_does_not_light_its_own_outside() {
        let centre = DVec3::new(0.3, 1.0, -0.7);
        let light = SphereLight::new(centre, 0.5, white(EmissionSides::Both)).expect("a light");
        for i in 0..64_u8 {
            let normal = uniform_sphere([f64::from(i) / 64.0, f64::from(i) * 0.618 % 1.0]);
            // A hit point as rounding may leave it: on, above or below the surface.
            let point = centre + normal * (0.5 * (1.0 + 2e-16 * (f64::from(i % 5) - 2.0)));
            for j in 0..64_u8 {
                let u = [f64::from(j) / 64.0, f64::from(j) * 0.618 % 1.0];
                if let Some(sample) = light.sample_li(point, u) {
                    let cos = sample.direction.dot(normal);
                    assert!(cos < 1e-6, "light from {cos} above the surface at {point:?}");
                }
            }
        }
    }

    #[test]
    fn irradiance_is_that_of_the_closed_form() {
        for (distance, degrees) in [
            (3.0, 0.0f64),
            (3.0, 60.0),
            (3.0, 90.0),
            (2.0, 80.0),
            (2.0, 100.0),
            (1.0 + 1e-6, 0.0),
            (1.0 + 1e-6, 70.0),
            (1.0 + 1e-12, 30.0),
            (1e6, 45.0),
            (1e12, 10.0),
        ] {
            let theta = degrees.to_radians();
            let estimate = irradiance(&sphere(1.0, EmissionSides::Front), receiver(distance, theta), 200_000);
            estimate.assert(&format!("sphere from {distance} at {degrees}°"), sphere_irradiance(1.0 / distance, theta));
        }
    }

    #[test]
    fn irradiance_within_is_that_of_a_hemisphere() {
        let light = sphere(2.0, EmissionSides::Both);
        for (point, degrees) in [(0.0, 0.0f64), (1.0, 40.0), (1.999_999, 0.0), (1.999_999, 180.0)] {
            let at = receiver(point, degrees.to_radians());
            irradiance(&light, at, 200_000).assert(&format!("from within at {point}"), PI);
            integral_of_pdf(&light, at[0], 1000).assert("pdf from within", 1.0);
            assert_eq!(sphere(2.0, EmissionSides::Front).sample_li(at[0], [0.3, 0.6]), None);
            assert_eq!(sphere(2.0, EmissionSides::Front).pdf_li(at[0], DVec3::Z), 0.0);
        }
    }

    #[test]
    fn solid_angle_keeps_its_digits() {
        let light = SphereLight::new(DVec3::ZERO, 1.0, white(EmissionSides::Front)).expect("a light");
        assert!((light.solid_angle(DVec3::X * 2.0) - 0.8417872145).abs() < 1e-10);
        for distance in [1e4, 1e8, 1e20] {
            let flat = PI / (distance * distance);
            assert!((light.solid_angle(DVec3::Y * distance) / flat - 1.0).abs() < 0.3 / (distance * distance) + 1e-15);
        }
        // At height h the cosine of half the angle is √(h (2 + h)) / (1 + h).
        let h = 1.0 / (1u64 << 40) as f64;
        let near = TAU * (1.0 - (h * (2.0 + h)).sqrt() / (1.0 + h));
        assert!((light.solid_angle(DVec3::Z * (1.0 + h)) / near - 1.0).abs() < 1e-15);
    }

    #[test]
    fn densities_agree_and_integrate_to_one() {
        for distance in [1.0 + 1e-6, 1.5, 10.0, 1e4] {
            for sides in [EmissionSides::Front, EmissionSides::Both] {
                let light = sphere(1.0, sides);
                let [point, _] = receiver(distance, 0.0);
                assert_samples_and_pdf_agree(&light, point, 1e-12);
                integral_of_pdf(&light, point, 100_000).assert(&format!("pdf from {distance}"), 1.0);
            }
        }
        assert_samples_and_pdf_agree(&sphere(1.0, EmissionSides::Both), DVec3::new(0.1, 0.5, -0.3), 1e-12);
    }

    /// Points lie on the sphere even where it is small and far away.
    #[test]
    fn points_lie_on_the_sphere() {
        let light = sphere(1.0, EmissionSides::Front);
        for distance in [1.0 + 1e-9, 2.0, 1e7, 1e14] {
            for u in [[0.0, 0.0], [0.3, 0.9], [0.999_999, 0.5], [1.0, 0.25]] {
                let sample = light.sample_li(DVec3::X * distance, u).expect("a sample");
                let off = (sample.point.expect("a point").length() - 1.0).abs();
                assert!(off < 1e-15, "{off} from {distance}");
            }
        }
    }

    #[test]
    fn a_wrong_density_is_caught() {
        let (light, at) = (sphere(1.0, EmissionSides::Front), receiver(2.0, 0.5));
        let truth = sphere_irradiance(0.5, 0.5);
        assert!(irradiance_by(&light, at, 100_000, |s| s.pdf * 1.01).z(truth) > 5.0);
        let by_area = |s: &LightLiSample| s.distance * s.distance / (-s.direction.dot(s.normal) * TAU);
        assert!(irradiance_by(&light, at, 100_000, by_area).z(truth) > 5.0);
    }

    #[test]
    fn odd_numbers_are_refused_and_black_spheres_give_nothing() {
        assert_eq!(sphere(1.0, EmissionSides::Front).sample_li(DVec3::X, [0.5; 2]), None, "on the light");
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(SphereLight::new(DVec3::ZERO, radius, white(EmissionSides::Front)).is_err());
        }
        let black = Emission::new(Rgb::BLACK, EmissionSides::Both).expect("an emission");
        let black = SphereLight::new(DVec3::ZERO, 1.0, black).expect("a light");
        assert_eq!((black.sample_li(DVec3::X * 2.0, [0.5; 2]), black.pdf_li_at(DVec3::X * 2.0)), (None, 0.0));
    }
}
