//! Rectangular lights.

use super::light_sample::{by_solid_angle, density};
use super::solid_angle::{self, MIN_SPHERICAL};
use super::{Emission, LightBounds, LightError, LightLiSample, LightPoint};
use rt_geometry::ShapeError;
use rt_math::float::gamma;
use rt_math::transcendental::sincos;
use rt_math::{Aabb, DVec3, Rgb};

/// Edges whose angle differs from a right one by less than this are those of a rectangle.
const RIGHT_ANGLE: f64 = 1e-12;

/// Diagonals from the plane of a light beyond which it is sampled by area.
const FAR: f64 = 2.0;

/// A flat light between a corner and two edges. Its front is the side from which the first edge, then the second one,
/// turn counter-clockwise.
///
/// A rectangle is sampled uniformly by solid angle (Ureña, Fajardo, King, "An Area-Preserving Parametrization for
/// Spherical Rectangles", 2013), so that the estimate of its irradiance varies with the receiver's cosine alone. It is sampled
/// by area where its plane is more than twice its diagonal away, from where all of its points look much alike and an
/// angle costs more than it is worth, where it subtends less than 2⁻¹⁴ sr, and where its edges are not perpendicular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadLight {
    corner: DVec3,
    edges: [DVec3; 2],
    lengths: [f64; 2],
    /// Along the edges, unit.
    axes: [DVec3; 2],
    normal: DVec3,
    area: f64,
    is_rectangle: bool,
    emission: Emission,
}

impl QuadLight {
    /// The light over the parallelogram `corner + s·edges[0] + t·edges[1]`, world space, `s` and `t` from 0 to 1.
    ///
    /// # Errors
    /// If the parallelogram has no area, or a coordinate is not finite.
    pub fn new(corner: DVec3, edges: [DVec3; 2], emission: Emission) -> Result<Self, LightError> {
        // The check of coordinates, collinear corners included, is that of a triangle.
        let corners = [corner, corner + edges[0], corner + edges[1]];
        rt_geometry::Triangle::new(corners)?;
        let axes = edges.map(unit);
        let lengths = [edges[0].dot(axes[0]), edges[1].dot(axes[1])];
        let across = axes[0].cross(axes[1]);
        let area = lengths[0] * lengths[1] * across.length();
        let normal = across.try_normalize().ok_or(ShapeError::NoArea(corners))?;
        let is_rectangle = axes[0].dot(axes[1]).abs() < RIGHT_ANGLE;
        if !(area > 0.0 && area.is_finite()) {
            return Err(LightError::BadArea(area));
        }
        Ok(Self { corner, edges, lengths, axes, normal, area, is_rectangle, emission })
    }

    /// Unit normal on the front side.
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The area of one side.
    pub const fn area(&self) -> f64 {
        self.area
    }

    /// What the surface emits.
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// The solid angle that the light subtends, 0 to 2π; 0 for a point in its plane, and NaN for one on its corner.
    ///
    /// For a rectangle of sides 2a and 2b seen from the distance d above its middle it is
    /// `4 asin(ab / √((a² + d²)(b² + d²)))`.
    pub fn solid_angle(&self, point: DVec3) -> f64 {
        let a = self.corner - point;
        let [b, d] = [a + self.edges[0], a + self.edges[1]];
        let (c, height) = (b + self.edges[1], a.dot(self.normal));
        solid_angle::of_fan([a, b, c, d], height, self.area)
    }

    /// A direction towards the light from `point`. `None` behind a one-sided light, in its plane, and if it is black.
    pub fn sample_li(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        let height = (self.corner - point).dot(self.normal);
        let radiance = self.emission.emitted(height);
        // A point of the light itself sees it edge-on, and rounding must not put it on the side that shines.
        let rounding = self.normal.abs().dot(self.corner.abs() + point.abs()) * gamma(16);
        if radiance.is_black() || height.abs() <= rounding {
            return None;
        }
        let (on_light, pdf) = match self.angle_to_sample(point, height) {
            Some(solid_angle) => (self.spherical_point(point, height, solid_angle, u), 1.0 / solid_angle),
            None => {
                let on_light = self.corner + self.edges[0] * u[0] + self.edges[1] * u[1];
                (on_light, by_solid_angle(1.0 / self.area, on_light - point, height))
            }
        };
        let at = LightPoint { point: on_light, normal: self.normal, triangle: 0 };
        LightLiSample::of_surface(point, &at, self.lengths[0] + self.lengths[1], radiance, pdf)
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) takes the direction from `point` to a point on
    /// the light. 0 where the light is not seen.
    pub fn pdf_li_at(&self, point: DVec3, on_light: DVec3) -> f64 {
        let height = (self.corner - point).dot(self.normal);
        if self.emission.emitted(height).is_black() {
            return 0.0;
        }
        match self.angle_to_sample(point, height) {
            Some(solid_angle) => density(1.0 / solid_angle),
            None => density(by_solid_angle(1.0 / self.area, on_light - point, height)),
        }
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) takes this direction; 0 for one that passes by.
    pub fn pdf_li(&self, point: DVec3, direction: DVec3) -> f64 {
        self.intersect(point, direction).map_or(0.0, |at| self.pdf_li_at(point, at.point))
    }

    /// Where a ray from `point` meets the light, from either side.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<LightPoint> {
        let t = (self.corner - point).dot(self.normal) / direction.dot(self.normal);
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let on_plane = point + direction * t;
        // Coordinates along the edges, from the areas of the parallelograms that the offset spans with the other edge.
        let offset = on_plane - self.corner;
        let s = offset.cross(self.axes[1]).dot(self.normal);
        let t = self.axes[0].cross(offset).dot(self.normal);
        let across = self.axes[0].cross(self.axes[1]).dot(self.normal);
        let is_inside = (0.0..=self.lengths[0] * across).contains(&s) && (0.0..=self.lengths[1] * across).contains(&t);
        is_inside.then_some(LightPoint { point: on_plane, normal: self.normal, triangle: 0 })
    }

    /// A point of the light, uniform over its area, from two numbers in `[0, 1)`; its `normal` is on the front side.
    pub fn sample_area(&self, u: [f64; 2]) -> LightPoint {
        let point = self.corner + self.edges[0] * u[0] + self.edges[1] * u[1];
        LightPoint { point, normal: self.normal, triangle: 0 }
    }

    /// Radiance of the light for one who looks along `direction` at it.
    pub fn le(&self, direction: DVec3, normal: DVec3) -> Rgb {
        self.emission.emitted(direction.dot(normal))
    }

    /// Power of all sides that shine.
    pub fn power(&self) -> Rgb {
        self.emission.power(self.area)
    }

    /// Where the light is and where it shines.
    pub fn bounds(&self) -> LightBounds {
        let [a, b] = self.edges.map(|edge| self.corner + edge);
        let around = Aabb::from_points([self.corner, a, b, a + self.edges[1]]);
        LightBounds::of_flat(around, self.normal, &self.emission, self.area)
    }

    /// The solid angle of the light if it is sampled by that, from a point whose distance to its plane is the `height`.
    #[inline]
    fn angle_to_sample(&self, point: DVec3, height: f64) -> Option<f64> {
        let [a, b] = self.lengths;
        if !self.is_rectangle || height * height > FAR * FAR * (a * a + b * b) {
            return None;
        }
        let solid_angle = self.solid_angle(point);
        (solid_angle >= MIN_SPHERICAL).then_some(solid_angle)
    }

    /// The point at which the unit square's `u` lies on the spherical rectangle.
    ///
    /// In coordinates along the edges, with the plane at z = −h: the first number cuts off a part of the solid angle by a
    /// great circle through x = const, the second takes a part of the arc between the other two edges. Names are those of
    /// the paper; x is found without its detour by the cosine c, whose 1 − c² cancels at grazing angles.
    fn spherical_point(&self, point: DVec3, height: f64, solid_angle: f64, u: [f64; 2]) -> DVec3 {
        let (offset, h) = (self.corner - point, height.abs());
        let [x0, y0] = self.axes.map(|axis| offset.dot(axis));
        let (x1, y1) = (x0 + self.lengths[0], y0 + self.lengths[1]);
        let [r, r0, r1] = [x0, y0, y1].map(|c| (c * c + h * h).sqrt());
        let (b0, b1, n3) = (-y0 / r0, y1 / r1, -x0 / r);
        // The angle that the first number adds to is k = 2π − g₂ − g₃, with inner angles g whose cosines are known.
        let [g2, g3] = [-b1 * n3, -n3 * b0].map(|cos| (((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), cos));
        let (sin_k, cos_k) = (-g2.0 * g3.1 - g2.1 * g3.0, g2.1 * g3.1 - g2.0 * g3.0);
        let (sin, cos) = sincos(u[0] * solid_angle);
        let (sin, cos) = (sin * cos_k + cos * sin_k, cos * cos_k - sin * sin_k);
        let f = (cos * b0 - b1) / sin;
        let c0 = h / r0;
        let x = f.signum() * h / ((f - c0) * (f + c0)).max(0.0).sqrt();
        let x = x.max(x0).min(x1);
        let d = (x * x + h * h).sqrt();
        let [h0, h1] = [y0, y1].map(|y| y / (d * d + y * y).sqrt());
        let hv = h0 + u[1] * (h1 - h0);
        let y = (hv * d / ((1.0 - hv) * (1.0 + hv)).sqrt()).max(y0).min(y1);
        self.corner + self.axes[0] * (x - x0) + self.axes[1] * (y - y0)
    }
}

/// The unit vector along an edge, whose square may underflow; zero for an edge of length zero.
fn unit(edge: DVec3) -> DVec3 {
    (edge / edge.abs().max_element()).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::super::test_estimate::{
        assert_samples_and_pdf_agree, integral_of_pdf, irradiance, irradiance_by, irradiance_by_rays, white,
    };
    use super::super::{EmissionSides, Light, polygon_irradiance};
    use super::*;
    use rt_math::transcendental::asin;

    /// A unit square at z = 1 that shines downwards.
    fn square(sides: EmissionSides) -> QuadLight {
        QuadLight::new(DVec3::new(-0.5, -0.5, 1.0), [DVec3::Y, DVec3::X], white(sides)).expect("a light")
    }

    /// A lamp that also reflects drew itself: rounding put points of its back in front of it, and light leaked out behind.
    #[test]
    fn the_light_is_not_seen_from_its_own_plane_as_rounding_leaves_it() {
        let corner = DVec3::new(-0.24, 1.98, 0.16);
        let light = QuadLight::new(corner, [DVec3::NEG_Z * 0.38, DVec3::X * 0.47], white(EmissionSides::Front))
            .expect("a light");
        for y in [1.98f64.next_down().next_down(), 1.98f64.next_down(), 1.98, 1.98f64.next_up()] {
            assert_eq!(light.sample_li(DVec3::new(0.1, y, -0.1), [0.3, 0.6]), None, "{y}");
        }
        let faces_down = light.normal().y < 0.0;
        let span_after = DVec3::new(0.1, 1.98 + if faces_down { -1e-9 } else { 1e-9 }, -0.1);
        assert!(light.sample_li(span_after, [0.3, 0.6]).is_some());
    }

    fn corners(light: &QuadLight) -> [DVec3; 4] {
        let [a, b] = light.edges;
        [light.corner, light.corner + a, light.corner + a + b, light.corner + b]
    }

    /// From above the middle and the corner, near, far, next to the plane, aside, and from receivers whose horizon cuts it.
    fn receivers() -> Vec<[DVec3; 2]> {
        let tilted = DVec3::new(1.0, 0.3, 0.2).normalize();
        vec![
            [DVec3::ZERO, DVec3::Z],
            [DVec3::new(0.5, 0.5, 0.0), DVec3::Z],
            [DVec3::new(0.1, 0.2, 0.999), DVec3::Z],
            [DVec3::new(0.1, 0.2, 1.0 - 1e-6), tilted],
            [DVec3::new(0.0, 0.0, -99.0), DVec3::Z],
            [DVec3::new(0.0, 0.0, -1e6), DVec3::Z],
            [DVec3::new(3.0, 1.0, 0.9), DVec3::NEG_X],
            [DVec3::new(-3.0, 0.0, 0.999), tilted],
            [DVec3::new(0.6, 0.2, 1.0 - 1e-9), DVec3::new(-1.0, 0.0, 1.0).normalize()],
            [DVec3::new(0.3, -0.2, 0.5), tilted],
            [DVec3::new(-2.0, -5.0, -7.0), DVec3::new(0.2, 0.9, 0.3).normalize()],
        ]
    }

    #[test]
    fn irradiance_is_lamberts() {
        let light = square(EmissionSides::Front);
        let emitter = Light::Quad(light);
        for at in receivers() {
            let truth = polygon_irradiance(&corners(&light), at[0], at[1]);
            irradiance(&emitter, at, 100_000).assert(&format!("square from {}", at[0]), truth);
        }
    }

    #[test]
    fn irradiance_of_thin_large_and_sheared_lights_is_lamberts() {
        let (point, normal) = (DVec3::new(0.2, 0.1, -0.7), DVec3::new(0.1, -0.3, 1.0).normalize());
        for edges in [
            [DVec3::Y * 1e-3, DVec3::X * 10.0],
            [DVec3::Y * 1e3, DVec3::X * 1e3],
            [DVec3::Y, DVec3::new(1.0, 0.5, 0.0)],
        ] {
            let light =
                QuadLight::new(DVec3::new(-0.5, -0.5, 1.0), edges, white(EmissionSides::Front)).expect("a light");
            let truth = polygon_irradiance(&corners(&light), point, normal);
            irradiance(&Light::Quad(light), [point, normal], 100_000).assert(&format!("{edges:?}"), truth);
            assert_samples_and_pdf_agree(&Light::Quad(light), point, 1e-8);
        }
    }

    /// Lambert's formula loses the digits of lights that are this small; A cos θ cos θ′ / d² does not.
    #[test]
    fn irradiance_of_tiny_lights_is_that_of_points() {
        let (point, normal) = (DVec3::new(0.2, 0.1, -0.7), DVec3::new(0.1, -0.3, 1.0).normalize());
        for size in [1e-7, 1e-14] {
            let edges = [DVec3::Y * size, DVec3::X * size];
            let light =
                QuadLight::new(DVec3::new(-0.5, -0.5, 1.0), edges, white(EmissionSides::Front)).expect("a light");
            let offset = light.corner + (edges[0] + edges[1]) / 2.0 - point;
            let square = offset.length_squared();
            let truth = light.area() * offset.dot(normal) * offset.z / (square * square);
            irradiance(&Light::Quad(light), [point, normal], 1000).assert(&format!("size {size}"), truth);
        }
    }

    #[test]
    fn solid_angle_is_that_of_the_closed_form() {
        let light = square(EmissionSides::Front);
        assert!((light.solid_angle(DVec3::ZERO) - 4.0 * asin(0.2)).abs() < 1e-15);
        for (d, tolerance) in [(1e-6, 1e-9), (0.3, 1e-14), (40.0, 1e-14), (1e6, 1e-12)] {
            let truth = 4.0 * asin(0.25 / (0.25 + d * d));
            let computed = light.solid_angle(DVec3::Z * (1.0 - d));
            assert!((computed / truth - 1.0).abs() < tolerance, "from {d}: {computed}, truth {truth}");
        }
        let quarter = light.solid_angle(DVec3::new(0.5, 0.5, 0.0));
        assert!((quarter - asin(0.5)).abs() < 1e-15, "a quarter of a square of side 2: {quarter}");
        assert_eq!(light.solid_angle(DVec3::new(3.0, 0.0, 1.0)), 0.0, "in the plane");
    }

    #[test]
    fn densities_agree_and_integrate_to_one() {
        for sides in [EmissionSides::Front, EmissionSides::Both] {
            let emitter = Light::Quad(square(sides));
            for [point, _] in receivers() {
                assert_samples_and_pdf_agree(&emitter, point, 1e-6);
                if point.z > -10.0 && point.z < 0.99 {
                    integral_of_pdf(&emitter, point, 200_000).assert(&format!("pdf from {point}"), 1.0);
                }
            }
        }
    }

    /// The mapping has equal areas: a quarter of the unit square comes to a quarter of the solid angle.
    #[test]
    fn directions_are_uniform() {
        let light = square(EmissionSides::Front);
        let point = DVec3::new(1.2, 0.4, 0.7);
        let at = [point, (DVec3::new(-0.2, 0.1, 1.0) - point).normalize()];
        let rays = irradiance_by_rays(&Light::Quad(light), at, 400_000);
        rays.assert("square by rays", polygon_irradiance(&corners(&light), at[0], at[1]));
        for (part, half) in [(0, 0.5), (1, 0.5), (0, 0.1), (1, 0.9)] {
            let count = 100;
            let inner = (0..count).map(|i| {
                let mut u = [0.0; 2];
                u[part] = half;
                u[1 - part] = (f64::from(i) + 0.5) / f64::from(count);
                light.sample_li(point, u).expect("a sample").point.expect("a point")
            });
            // All lie on one great circle for the first number; for the second they part each arc in equal heights.
            let points: Vec<_> = inner.map(|p| (p - point).normalize()).collect();
            if part == 0 {
                let circle = points[0].cross(points[99]).normalize();
                assert!(points.iter().all(|p| p.dot(circle).abs() < 1e-12));
                let x =
                    light.sample_li(point, [half, 0.0]).expect("a sample").point.expect("a point").dot(light.axes[0]);
                let x0 = light.corner.dot(light.axes[0]);
                let edges = [light.axes[0] * (x - x0), light.edges[1]];
                let cut = QuadLight::new(light.corner, edges, white(EmissionSides::Front)).expect("a light");
                assert!((cut.solid_angle(point) / light.solid_angle(point) - half).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_wrong_density_is_caught() {
        let emitter = Light::Quad(square(EmissionSides::Front));
        for at in [[DVec3::ZERO, DVec3::Z], [DVec3::new(0.0, 0.0, -999.0), DVec3::Z]] {
            let truth = polygon_irradiance(&corners(&square(EmissionSides::Front)), at[0], at[1]);
            assert!(irradiance_by(&emitter, at, 100_000, |s| s.pdf * 1.01).z(truth) > 5.0, "1 % too dense");
            let by_area = |s: &LightLiSample| s.distance * s.distance;
            assert!(irradiance_by(&emitter, at, 100_000, by_area).z(truth) > 5.0, "the light's cosine forgotten");
        }
    }

    #[test]
    fn nothing_comes_from_behind_or_from_a_plane() {
        let (front, both) = (Light::Quad(square(EmissionSides::Front)), Light::Quad(square(EmissionSides::Both)));
        let behind = DVec3::new(0.1, 0.1, 2.0);
        assert_eq!((front.sample_li(behind, [0.5; 2]), front.pdf_li(behind, DVec3::NEG_Z)), (None, 0.0));
        assert!(both.sample_li(behind, [0.5; 2]).is_some() && both.pdf_li(behind, DVec3::NEG_Z) > 0.0);
        assert_eq!(
            (front.le(DVec3::NEG_Z, DVec3::NEG_Z), both.le(DVec3::NEG_Z, DVec3::NEG_Z)),
            (Rgb::BLACK, Rgb::WHITE)
        );
        for point in [
            DVec3::new(0.1, 0.1, 1.0),
            DVec3::new(-0.5, -0.5, 1.0),
            DVec3::new(5.0, 0.0, 1.0),
            DVec3::NAN,
            DVec3::INFINITY,
        ] {
            for light in [&front, &both] {
                assert_eq!(light.sample_li(point, [0.5; 2]), None, "{point}");
                assert_eq!(light.pdf_li(point, DVec3::Z), 0.0, "{point}");
            }
        }
        for u in [[f64::NAN; 2], [-1.0, 2.0], [1.0, 1.0], [f64::INFINITY; 2]] {
            let _ = front.sample_li(DVec3::ZERO, u);
        }
        assert_eq!(front.pdf_li(DVec3::ZERO, DVec3::ZERO), 0.0);
        assert_eq!(front.pdf_li(DVec3::ZERO, DVec3::NAN), 0.0);
        assert_eq!(both.power(0.0), front.power(0.0) * 2.0);
    }

    #[test]
    fn lights_without_area_are_refused_and_black_ones_give_nothing() {
        for edges in
            [[DVec3::X, DVec3::X], [DVec3::X, DVec3::ZERO], [DVec3::X, DVec3::NAN], [DVec3::X * 1e200, DVec3::Y]]
        {
            assert!(QuadLight::new(DVec3::ZERO, edges, white(EmissionSides::Both)).is_err(), "{edges:?}");
        }
        let black = Emission::new(Rgb::BLACK, EmissionSides::Both).expect("an emission");
        let light = QuadLight::new(DVec3::Z, [DVec3::X, DVec3::Y], black).expect("a light");
        assert_eq!((light.sample_li(DVec3::ZERO, [0.5; 2]), light.pdf_li(DVec3::ZERO, DVec3::Z)), (None, 0.0));
    }
}
