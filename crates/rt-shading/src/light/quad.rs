//! Rectangle and parallelogram lights.

use super::light_sample::{LightDirections, by_solid_angle, density};
use super::solid_angle::{self, MIN_SPHERICAL};
use super::{Emission, LightBounds, LightError, LightLiSample, LightPoint};
use rt_geometry::ShapeError;
use rt_math::float::gamma;
use rt_math::{Aabb, DVec3, Float64, Mask, Vector3, transcendental};

/// Greatest deviation from a right angle of a rectangle, in radians.
const RIGHT_ANGLE: f64 = 1e-12;

/// Distance to the plane, in diagonals, beyond which a light is sampled by area.
const FAR: f64 = 2.0;

/// Parallelogram between a corner and two edges. On its front side the edges turn counter-clockwise.
///
/// A rectangle is sampled uniformly by solid angle (Ureña, Fajardo, King, "An Area-Preserving Parametrization for Spherical
/// Rectangles", 2013). The estimate of its irradiance thus varies only with the receiver's cosine.
///
/// Sampling is by area if the edges are not perpendicular, or if the light subtends less than 2⁻¹⁴ sr. So it is, too, if the plane
/// is more than twice the diagonal away: there, solid angle reduces variance little.
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
    /// Light over the parallelogram `corner + s·edges[0] + t·edges[1]`, world space, `s` and `t` from 0 to 1.
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

    /// Area of one side.
    pub const fn area(&self) -> f64 {
        self.area
    }

    /// Emission of the surface.
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// Solid angle that the light subtends, 0 to 2π; 0 for a point in its plane, and NaN for one on its corner.
    ///
    /// For a rectangle of sides 2a and 2b seen from the distance d above its middle it is
    /// `4 asin(ab / √((a² + d²)(b² + d²)))`.
    pub fn solid_angle(&self, point: DVec3) -> f64 {
        self.solid_angle_of(Vector3::from(self.corner - point))
    }

    /// Solid angle, given the offset to the corner.
    #[inline(always)]
    fn solid_angle_of<R: Float64>(&self, a: Vector3<R>) -> R {
        let [edge, other] = splat_both(a.x, self.edges);
        let [b, d] = [a + edge, a + other];
        let (c, height) = (b + other, a.dot(Vector3::splat(a.x, self.normal)));
        solid_angle::of_fan([a, b, c, d], height, self.area)
    }

    /// Samples a direction towards the light from `point`. `None` behind a one-sided light, in its plane, and if it is black.
    pub fn sample_li(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        if self.emission.radiance().is_black() {
            return None;
        }
        let (is_lit, on_light, pdf) = self.sample_point(point.into(), u);
        if !is_lit {
            return None;
        }
        let at = LightPoint { point: on_light.into(), normal: self.normal, triangle: 0 };
        LightLiSample::of_surface(point, &at, self.extent(), self.emission.radiance(), pdf)
    }

    /// Version of [`sample_li`](Self::sample_li) for lanes. The radiance is that of the [`emission`](Self::emission).
    #[inline(always)]
    pub(crate) fn sample_li_lanes<R: Float64>(&self, point: Vector3<R>, u: [R; 2]) -> LightDirections<R> {
        LightDirections::of_flat(self.sample_point(point, u), point, self.normal, self.extent())
    }

    /// Samples points on the light, with densities per unit solid angle, for one number or for lanes.
    ///
    /// The mask is false where `point` is behind a one-sided light or in its plane. All other results are then not valid.
    #[inline(always)]
    fn sample_point<R: Float64>(&self, point: Vector3<R>, u: [R; 2]) -> (R::Mask, Vector3<R>, R) {
        let corner = Vector3::splat(u[0], self.corner);
        let normal = Vector3::splat(u[0], self.normal);
        let offset = corner - point;
        let height = offset.dot(normal);
        // Rounding must not put a point of the light itself on the emissive side.
        let rounding = normal.abs().dot(corner.abs() + point.abs()) * gamma(16);
        let is_lit = self.emission.emits(height) & !height.abs().le(rounding);
        if !is_lit.any() {
            return (is_lit, corner, height);
        }
        let (is_spherical, solid_angle) = self.angle_to_sample(offset, height);
        let [edge, other] = splat_both(u[0], self.edges);
        let (mut on_light, mut pdf) = (corner + edge * u[0] + other * u[1], solid_angle.recip());
        if !is_spherical.all() {
            let by_area = by_solid_angle(1.0 / self.area, on_light - point, height);
            pdf = R::select(is_spherical, pdf, by_area);
        }
        if is_spherical.any() {
            let spherical = self.spherical_point(offset, height, solid_angle, u);
            on_light = Vector3::select(is_spherical, spherical, on_light);
        }
        (is_lit, on_light, pdf)
    }

    /// Bound on the size, for error bounds of points.
    fn extent(&self) -> f64 {
        self.lengths[0] + self.lengths[1]
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) samples the direction from `point` to a point on
    /// the light. 0 where the light is invisible.
    pub fn pdf_li_at(&self, point: DVec3, on_light: DVec3) -> f64 {
        let height = (self.corner - point).dot(self.normal);
        if self.emission.emitted(height).is_black() {
            return 0.0;
        }
        match self.angle_to_sample(Vector3::from(self.corner - point), height) {
            (true, solid_angle) => density(1.0 / solid_angle),
            (false, _) => density(by_solid_angle(1.0 / self.area, Vector3::from(on_light - point), height)),
        }
    }

    /// Hit of a ray from `point` with the light, from either side.
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

    /// Samples a point uniformly by area, by two numbers in `[0, 1)`. Its `normal` is on the front side.
    pub fn sample_area(&self, u: [f64; 2]) -> LightPoint {
        let point = self.corner + self.edges[0] * u[0] + self.edges[1] * u[1];
        LightPoint { point, normal: self.normal, triangle: 0 }
    }

    /// Bounds of positions and directions.
    pub fn bounds(&self) -> LightBounds {
        let [a, b] = self.edges.map(|edge| self.corner + edge);
        let around = Aabb::from_points([self.corner, a, b, a + self.edges[1]]);
        LightBounds::of_flat(around, self.normal, &self.emission, self.area)
    }

    /// True where the light is sampled by solid angle, and this angle from a point at `height` above the plane. `offset` leads to the
    /// corner. Where false, the number is not valid.
    #[inline(always)]
    fn angle_to_sample<R: Float64>(&self, offset: Vector3<R>, height: R) -> (R::Mask, R) {
        let [a, b] = self.lengths;
        let is_near = !height.splat(FAR * FAR * (a * a + b * b)).lt(height * height);
        if !self.is_rectangle || !is_near.any() {
            return (height.lt(height), height);
        }
        let solid_angle = self.solid_angle_of(offset);
        (is_near & solid_angle.ge(height.splat(MIN_SPHERICAL)), solid_angle)
    }

    /// Maps `u` of the unit square to the spherical rectangle, and returns the point on the light.
    ///
    /// Coordinates are along the edges, with the plane at z = −h. The first number selects a part of the solid angle, bounded by
    /// a great circle through x = const. The second selects a part of the arc between the other two edges. Names are those of
    /// the paper. Here x is computed without the cosine c, whose 1 − c² cancels at grazing angles.
    #[inline(always)]
    fn spherical_point<R: Float64>(&self, offset: Vector3<R>, height: R, solid_angle: R, u: [R; 2]) -> Vector3<R> {
        let (zero, one) = (height.splat(0.0), height.splat(1.0));
        let [x_axis, y_axis] = splat_both(height, self.axes);
        let h = height.abs();
        let (x0, y0) = (offset.dot(x_axis), offset.dot(y_axis));
        let (x1, y1) = (x0 + self.lengths[0], y0 + self.lengths[1]);
        let (r, r0, r1) = ((x0 * x0 + h * h).sqrt(), (y0 * y0 + h * h).sqrt(), (y1 * y1 + h * h).sqrt());
        let (b0, b1, n3) = (-y0 / r0, y1 / r1, -x0 / r);
        // The angle that the first number adds to is k = 2π − g₂ − g₃, with inner angles g whose cosines are known.
        let (cos_2, cos_3) = (-b1 * n3, -n3 * b0);
        let sin_2 = zero.max((one - cos_2) * (one + cos_2)).sqrt();
        let sin_3 = zero.max((one - cos_3) * (one + cos_3)).sqrt();
        let (sin_k, cos_k) = (-sin_2 * cos_3 - cos_2 * sin_3, cos_2 * cos_3 - sin_2 * sin_3);
        let (sin, cos) = transcendental::sincos(u[0] * solid_angle);
        let (sin, cos) = (sin * cos_k + cos * sin_k, cos * cos_k - sin * sin_k);
        let f = (cos * b0 - b1) / sin;
        let c0 = h / r0;
        // NaN, whose sign differs between platforms, counts as negative.
        let sign = one.copysign(R::select(f.eq(f), f, -one));
        let x = sign * h / zero.max((f - c0) * (f + c0)).sqrt();
        let x = x0.max(x).min(x1);
        let d = (x * x + h * h).sqrt();
        let (h0, h1) = (y0 / (d * d + y0 * y0).sqrt(), y1 / (d * d + y1 * y1).sqrt());
        let hv = h0 + u[1] * (h1 - h0);
        let y = y0.max(hv * d / ((one - hv) * (one + hv)).sqrt()).min(y1);
        Vector3::splat(height, self.corner) + x_axis * (x - x0) + y_axis * (y - y0)
    }
}

/// Two vectors in all lanes.
#[inline(always)]
fn splat_both<R: Float64>(like: R, [a, b]: [DVec3; 2]) -> [Vector3<R>; 2] {
    [Vector3::splat(like, a), Vector3::splat(like, b)]
}

/// Unit vector along an edge, whose square may underflow; zero for an edge of length zero.
fn unit(edge: DVec3) -> DVec3 {
    (edge / edge.abs().max_element()).normalize_or_zero()
}

#[cfg(test)]
mod tests;
