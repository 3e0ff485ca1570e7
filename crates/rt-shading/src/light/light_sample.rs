//! Samples of lights, and conversions of densities.

use super::emission::{Emission, EmissionSides};
use rt_geometry::SurfaceInteraction;
use rt_math::float::gamma;
use rt_math::{DVec3, Real, Rgb, Vector3};

/// Point on an area light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPoint {
    /// World space.
    pub point: DVec3,
    /// Unit normal on the front side, world space.
    pub normal: DVec3,
    /// Index of the triangle of a [`MeshLight`](super::MeshLight); ignored by other lights.
    pub triangle: u32,
}

/// Sampled direction of incident light.
///
/// The estimate of ∫ f(ω) L(ω) dω over the light is `f(direction) · radiance / pdf`, if the light is not occluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightLiSample {
    /// Unit vector towards the light, world space.
    pub direction: DVec3,
    /// Distance to the light; infinite for an environment and a directional light.
    pub distance: f64,
    /// Point on the light, world space; `None` where the distance is infinite.
    pub point: Option<DVec3>,
    /// Bound on the rounding error of `point` per axis; zero if there is no surface.
    pub point_error: DVec3,
    /// Unit normal on the front side of the light; against `direction` if there is no surface.
    pub normal: DVec3,
    /// Incident radiance if the light is not occluded, or incident irradiance of a delta light. Never black.
    pub radiance: Rgb,
    /// Density of `direction` per unit solid angle, positive and finite; 1 for a delta light.
    pub pdf: f64,
}

/// Sample of one of many lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Sample, with its density among the directions to this light only.
    pub sample: LightLiSample,
    /// Density of the direction, the choice of the light included.
    pub pdf: f64,
}

/// Samples of directions to a light, for one number or for lanes; see [`LightLiSample`].
#[derive(Clone, Copy)]
pub(crate) struct LightDirections<R: Real> {
    /// False where the light does not reach the point. All other fields are then not valid.
    pub(crate) is_lit: R::Mask,
    /// Unit vectors towards the light, world space.
    pub(crate) direction: Vector3<R>,
    /// Ends of shadow rays, as by [`LightLiSample::shadow_target`].
    pub(crate) target: Vector3<R>,
    /// Densities of the directions per unit solid angle.
    pub(crate) pdf: R,
}

impl<R: Real> LightDirections<R> {
    /// Directions from `from` to points of a flat light with this unit normal, as by [`LightLiSample::of_surface`].
    #[inline(always)]
    pub(super) fn of_flat(
        (is_lit, on_light, pdf): (R::Mask, Vector3<R>, R),
        from: Vector3<R>,
        normal: DVec3,
        extent: f64,
    ) -> Self {
        let offset = on_light - from;
        let distance = offset.length();
        let direction = offset / distance;
        let (zero, max) = (pdf.splat(0.0), pdf.splat(f64::MAX));
        let is_finite = direction.is_finite() & distance.le(max) & pdf.le(max);
        let normal = Vector3::splat(pdf, normal);
        let target = end_of_shadow_ray(on_light, normal, point_error_of(on_light, extent), offset);
        Self { is_lit: is_lit & is_finite & pdf.gt(zero), direction, target, pdf }
    }
}

/// Point on an area light from which light tracing starts a path.
///
/// The power through a small area and solid angle is `radiance · cos θ · dA · dω`, θ from the normal of `surface`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPointSample {
    /// Point with a normal on an emissive side; origin of rays, world space.
    pub surface: SurfaceInteraction,
    /// Emitted radiance in all directions.
    pub radiance: Rgb,
    /// Density of the point per unit area; over both sides if both emit.
    pub pdf: f64,
}

impl LightLiSample {
    /// Sample of a light's surface from `from`. `None` if the radiance is black, at the very point, and if a number is not
    /// finite. `extent` bounds the size of the light, for the error bound.
    pub(super) fn of_surface(from: DVec3, at: &LightPoint, extent: f64, radiance: Rgb, pdf: f64) -> Option<Self> {
        let offset = at.point - from;
        let distance = offset.length();
        let direction = offset / distance;
        let point_error = point_error(at, extent);
        let sample = Self { direction, distance, point: Some(at.point), point_error, normal: at.normal, radiance, pdf };
        (direction.is_finite() && distance.is_finite() && is_density(pdf) && !radiance.is_black()).then_some(sample)
    }

    /// End of a shadow ray: `point`, offset by its error bound and that of the ray to the visible side of the light. Rounding thus does
    /// not make the ray hit the light itself. `None` if the distance is infinite.
    ///
    /// Pharr, Jakob, Humphreys, PBR 4th ed., section 6.8.6, at the other end of the ray.
    pub fn shadow_target(&self) -> Option<DVec3> {
        let (normal, error) = (self.normal.into(), self.point_error.into());
        let offset = self.direction * self.distance;
        self.point.map(|point| end_of_shadow_ray(point.into(), normal, error, offset.into()).into())
    }
}

impl LightPointSample {
    /// Sample at a point that is uniform over the `area` of one side. `side` from `[0, 1)` selects the side of a two-sided
    /// light. `None` if the emission is black. `extent` bounds the size of the light, for the error bound.
    pub(super) fn of_surface(at: &LightPoint, emission: &Emission, side: f64, area: f64, extent: f64) -> Option<Self> {
        let is_behind = emission.sides() == EmissionSides::Both && side >= 0.5;
        let sides = if emission.sides() == EmissionSides::Both { 2.0 } else { 1.0 };
        let normal = if is_behind { -at.normal } else { at.normal };
        let surface = SurfaceInteraction::flat(at.point, point_error(at, extent), normal, [0.0; 2]);
        let sample = Self { surface, radiance: emission.radiance(), pdf: 1.0 / (sides * area) };
        (!sample.radiance.is_black()).then_some(sample)
    }
}

/// Point on a light with this unit normal, moved to the side from which it is seen. `offset` leads to it from the other end of the shadow
/// ray. The direction of the ray is rounded, and so is the parameter of a hit on the light, in proportion to its length.
#[inline(always)]
fn end_of_shadow_ray<R: Real>(
    point: Vector3<R>,
    normal: Vector3<R>,
    point_error: Vector3<R>,
    offset: Vector3<R>,
) -> Vector3<R> {
    let error = point_error + offset.abs() * point.x.splat(gamma(16));
    let off = normal * normal.abs().dot(error);
    point + Vector3::select(offset.dot(normal).lt(point.x.splat(0.0)), off, -off)
}

/// Bound on the rounding error of a point on a light of the size `extent`, per axis.
fn point_error(at: &LightPoint, extent: f64) -> DVec3 {
    point_error_of(at.point.into(), extent).into()
}

/// Version of [`point_error`] for lanes.
#[inline(always)]
fn point_error_of<R: Real>(point: Vector3<R>, extent: f64) -> Vector3<R> {
    let Vector3 { x, y, z } = point.abs();
    Vector3::new((x + extent) * gamma(16), (y + extent) * gamma(16), (z + extent) * gamma(16))
}

/// True for a valid divisor: a positive and finite density.
#[inline]
pub(super) fn is_density(pdf: f64) -> bool {
    pdf > 0.0 && pdf.is_finite()
}

/// Density, or 0 if the number is not one.
#[inline]
pub(super) fn density(pdf: f64) -> f64 {
    if is_density(pdf) { pdf } else { 0.0 }
}

/// Converts a density per unit area to one per unit solid angle: `by_area · d² / |cos θ|`, θ between the normal and `offset`.
///
/// `offset` leads to the sampled point, `height` is the distance of the tangent plane.
#[inline(always)]
pub(super) fn by_solid_angle<R: Real>(by_area: f64, offset: Vector3<R>, height: R) -> R {
    let squared = offset.length_squared();
    squared * by_area * squared.sqrt() / height.abs()
}

#[cfg(test)]
mod tests {
    use super::super::test_estimate::white;
    use super::super::{CylinderLight, DiskLight, EnvironmentLight, Light, MeshLight, QuadLight, SphereLight};
    use super::*;
    use rt_geometry::{InsideRule, Polygon, Shape, Sphere, Triangle};
    use rt_math::random::{hash, unit};
    use rt_math::{Interval, Ray};
    use std::f64::consts::PI;

    fn lights(sides: EmissionSides) -> Vec<Light> {
        let (white, centre) = (white(sides), DVec3::new(0.3, -1.0, 2.0));
        let triangles = [[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::X, DVec3::new(3.0, 0.0, 1.0), DVec3::Y]];
        vec![
            Light::Quad(QuadLight::new(centre, [DVec3::X * 2.0, DVec3::new(0.5, 1.0, 0.0)], white).expect("a light")),
            Light::Disk(DiskLight::new(centre, DVec3::new(1.0, 1.0, 0.3), 0.7, 0.2, white).expect("a light")),
            Light::Sphere(SphereLight::new(centre, 0.6, white).expect("a light")),
            Light::Cylinder(CylinderLight::new(centre, DVec3::Y, 0.4, true, white).expect("a light")),
            Light::Cylinder(CylinderLight::new(centre, DVec3::Y, 0.4, false, white).expect("a light")),
            Light::Mesh(MeshLight::new(triangles, white).expect("a light")),
        ]
    }

    fn numbers() -> impl Iterator<Item = [f64; 3]> {
        (0..4000).map(|i| [0, 1, 2].map(|dimension| unit(hash(&[11, i, dimension]))))
    }

    #[test]
    fn the_power_that_leaves_is_that_of_the_light() {
        for sides in [EmissionSides::Front, EmissionSides::Both] {
            for light in lights(sides) {
                let departs: Vec<_> = numbers().filter_map(|[u, v, side]| light.sample_point([u, v], side)).collect();
                let power = departs.iter().map(|from| PI * from.radiance.r / from.pdf).sum::<f64>() / 4000.0;
                assert!((power / light.power(1.0).r - 1.0).abs() < 1e-12, "{power} from {light:?}");
                let fronts = departs.iter().filter(|from| is_front(&light, from)).count();
                let expected = if sides == EmissionSides::Both { 1850..2150 } else { 4000..4001 };
                assert!(expected.contains(&fronts), "{fronts} of 4000 from the front of {light:?}");
            }
        }
    }

    /// True if the point is on the front side; a ray towards it hits the light on an emissive side.
    fn is_front(light: &Light, from: &LightPointSample) -> bool {
        let LightPointSample { surface, .. } = from;
        let outside = surface.point + surface.geometric_normal * 1e-3;
        let at = light.intersect(outside, -surface.geometric_normal).expect("the point is on the light");
        assert!((at.point - surface.point).length() < 1e-9, "{light:?}");
        assert_eq!(light.le(-surface.geometric_normal, at.normal), Rgb::WHITE);
        at.normal.dot(surface.geometric_normal) > 0.0
    }

    /// Points are uniform by area: their mean and spread along an axis are those of the surface.
    #[test]
    fn points_are_uniform_over_the_surface() {
        let closed =
            CylinderLight::new(DVec3::ZERO, DVec3::Z * 3.0, 1.0, true, white(EmissionSides::Front)).expect("a light");
        let sphere = SphereLight::new(DVec3::ZERO, 2.0, white(EmissionSides::Front)).expect("a light");
        let part = |light: &Light, is_in: &dyn Fn(DVec3) -> bool| {
            let points = numbers().filter_map(|[u, v, side]| light.sample_point([u, v], side));
            points.filter(|from| is_in(from.surface.point)).count() as f64 / 4000.0
        };
        // A cap is π of 8π; slices of a sphere of equal height have equal areas.
        let caps = part(&Light::Cylinder(closed), &|point| point.z == 3.0);
        let slice = part(&Light::Sphere(sphere), &|point| point.z.abs() < 0.5);
        assert!((caps - 0.125).abs() < 0.025 && (slice - 0.25).abs() < 0.03, "{caps}, {slice}");
    }

    /// Regression: the end of a shadow ray was offset by the error bound of the point alone. The ray rounds its direction, and the light
    /// its hit, in proportion to the distance, so that small lights near a coordinate plane shadowed themselves.
    #[test]
    fn shadow_rays_do_not_hit_the_small_or_distant_light_that_they_end_on() {
        let emission = white(EmissionSides::Both);
        let of_triangle = |vertices| {
            let light = MeshLight::new([vertices], emission).expect("a light");
            (Light::Mesh(light), Shape::Triangle(Triangle::new(vertices).expect("a triangle")))
        };
        let (mut count, mut hits) = (0, Vec::new());
        for (size, distance) in [1.0, 0.1, 0.01, 1e-4].into_iter().flat_map(|s| [1.0, 10.0, 1e3, 1e6].map(|d| (s, d))) {
            for [u, v, w] in numbers().take(400) {
                // The light lies in the plane x = 0, or its centre near that.
                let centre = DVec3::new(0.0, 3.0 * u, w) * distance.min(10.0);
                let [y, z] = [DVec3::Y, DVec3::Z].map(|axis| axis * size);
                let corners = [centre, centre + y, centre + y + z, centre + z];
                let polygon = Polygon::new(corners.to_vec(), Vec::new(), InsideRule::Convex).expect("a square");
                let triangle = [corners[0], corners[1], corners[3]];
                let needle = [centre, centre + y * 1000.0, centre + z];
                let lights = [
                    (
                        Light::Quad(QuadLight::new(centre, [y, z], emission).expect("a light")),
                        Shape::Polygon(polygon.into()),
                    ),
                    (
                        Light::Sphere(SphereLight::new(centre, size, emission).expect("a light")),
                        Shape::Sphere(Sphere::new(centre, size).expect("a sphere")),
                    ),
                    of_triangle(triangle),
                    of_triangle(needle),
                ];
                let from = centre + (DVec3::new(v, w, u) - 0.5).normalize() * (size + distance);
                for (light, shape) in lights {
                    let Some(sample) = light.sample_li(from, [v, w]) else { continue };
                    let target = sample.shadow_target().expect("a point");
                    count += 1;
                    let ray = Ray::new(from, target - from);
                    if let Some(hit) = shape.intersect(&ray, Interval::SEGMENT) {
                        hits.push((size, distance, hit.t - 1.0, shape));
                    }
                }
            }
        }
        assert!(count > 15_000 && hits.is_empty(), "{} of {count}: {:?}", hits.len(), hits.first());
    }

    #[test]
    fn nothing_leaves_an_environment_or_a_black_light() {
        let black = Emission::new(Rgb::BLACK, EmissionSides::Both).expect("black");
        let sphere = SphereLight::new(DVec3::ZERO, 2.0, black).expect("a light");
        assert_eq!(Light::Sphere(sphere).sample_point([0.5; 2], 0.5), None);
        let sky = EnvironmentLight::constant(Rgb::WHITE).expect("a light");
        assert_eq!(Light::Environment(sky).sample_point([0.5; 2], 0.5), None);
    }
}
