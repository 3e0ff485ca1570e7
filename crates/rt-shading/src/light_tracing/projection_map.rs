//! Targets of light paths: specular surfaces.

use crate::light::solid_angle::uniform_sphere;
use core::f64::consts::{PI, TAU};
use rt_math::{DVec3, Frame, transcendental::sincos};

/// Maximum number of separate spheres: the density of a direction tests all of them.
const MAX_SPHERES: usize = 16;

/// Bounding sphere of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetSphere {
    /// World space.
    pub centre: DVec3,
    /// World units.
    pub radius: f64,
}

/// Bounding spheres of specular surfaces: the projection map of Jensen (2001), in closed form.
///
/// A direction is uniform within the cone of a sphere; the sphere is sampled by its solid angle Ω:
///
/// ```text
///   p(ω) = (number of spheres that ω hits) / Σ Ω
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectionMap {
    spheres: Vec<TargetSphere>,
    is_everywhere: bool,
}

/// Sampled value and its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DirectionSample<T> {
    pub(super) at: T,
    pub(super) pdf: f64,
}

impl ProjectionMap {
    /// All directions: some specular surfaces are unbounded.
    pub const EVERYWHERE: Self = Self { spheres: Vec::new(), is_everywhere: true };

    /// Targets within these spheres. More than sixteen become one sphere around all, centred in their bounding box. Non-finite
    /// spheres give [`EVERYWHERE`](Self::EVERYWHERE).
    pub fn new(spheres: Vec<TargetSphere>) -> Self {
        if !spheres.iter().all(|sphere| sphere.centre.is_finite() && sphere.radius.is_finite()) {
            return Self::EVERYWHERE;
        }
        if spheres.len() <= MAX_SPHERES {
            return Self { spheres, is_everywhere: false };
        }
        let reach = |sphere: &TargetSphere| [sphere.centre - sphere.radius, sphere.centre + sphere.radius];
        let around = rt_math::Aabb::from_points(spheres.iter().flat_map(reach));
        let centre = around.centre();
        let radius = spheres.iter().map(|sphere| (sphere.centre - centre).length() + sphere.radius).fold(0.0, f64::max);
        Self { spheres: vec![TargetSphere { centre, radius }], is_everywhere: false }
    }

    /// True if there is no specular surface.
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty() && !self.is_everywhere
    }

    /// True if paths start in all directions.
    pub const fn is_everywhere(&self) -> bool {
        self.is_everywhere
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.spheres.len()
    }

    /// Total cross-section of the spheres.
    pub(super) fn area(&self) -> f64 {
        self.spheres.iter().map(|sphere| PI * sphere.radius * sphere.radius).sum()
    }

    /// Samples a direction from a point, with its density per unit solid angle. `None` inside of a sphere, which all directions
    /// hit, and without spheres.
    pub(super) fn sample_direction(&self, point: DVec3, choice: f64, u: [f64; 2]) -> Option<DirectionSample<DVec3>> {
        if self.is_everywhere || self.spheres.iter().any(|sphere| sphere.one_minus_cos(point).is_none()) {
            return None;
        }
        let width = |sphere: &TargetSphere| sphere.one_minus_cos(point).unwrap_or(0.0);
        let total: f64 = self.spheres.iter().map(width).sum();
        let sphere = select(&self.spheres, choice * total, width)?;
        let direction = within_cone((sphere.centre - point).try_normalize()?, width(sphere), u);
        let is_hit_by = |sphere: &&TargetSphere| sphere.is_hit(point, direction);
        // The sampled sphere counts as hit in spite of rounding.
        let n_hit = self.spheres.iter().filter(is_hit_by).count().max(1);
        Some(DirectionSample { at: direction, pdf: n_hit as f64 / (TAU * total) })
    }

    /// Samples a ray of parallel light in a unit direction: a point on the disk of a sphere, with its density per unit area. `None`
    /// without spheres.
    pub(super) fn sample_disk(&self, direction: DVec3, choice: f64, u: [f64; 2]) -> Option<DirectionSample<DVec3>> {
        let squared = |sphere: &TargetSphere| sphere.radius * sphere.radius;
        let total: f64 = self.spheres.iter().map(squared).sum();
        let sphere = select(&self.spheres, choice * total, squared)?;
        let frame = Frame::from_z(direction);
        let (sin, cos) = sincos(TAU * u[1]);
        let point = sphere.centre + (frame.x * cos + frame.y * sin) * (sphere.radius * u[0].sqrt());
        let n_hit = self
            .spheres
            .iter()
            .filter(|sphere| (sphere.centre - point).cross(direction).length() <= sphere.radius)
            .count();
        Some(DirectionSample { at: point, pdf: n_hit.max(1) as f64 / (PI * total) })
    }
}

impl TargetSphere {
    /// One minus the cosine of half the subtended angle; `None` inside.
    fn one_minus_cos(&self, point: DVec3) -> Option<f64> {
        let distance = (self.centre - point).length();
        let sin = self.radius / distance;
        let cos = ((distance - self.radius) / distance * (1.0 + sin)).sqrt();
        (distance > self.radius).then(|| sin * sin / (1.0 + cos))
    }

    fn is_hit(&self, point: DVec3, direction: DVec3) -> bool {
        let offset = self.centre - point;
        offset.dot(direction) > 0.0 && offset.cross(direction).length() <= self.radius
    }
}

/// Sphere whose part of the cumulative sum of widths contains `at`, or the last.
fn select(spheres: &[TargetSphere], at: f64, width: impl Fn(&TargetSphere) -> f64) -> Option<&TargetSphere> {
    let mut rest = at;
    spheres
        .iter()
        .find(|sphere| {
            rest -= width(sphere);
            rest < 0.0
        })
        .or(spheres.last())
}

/// Uniform direction within a cone around a unit axis, given one minus the cosine of half its angle.
pub(super) fn within_cone(axis: DVec3, one_minus_cos: f64, u: [f64; 2]) -> DVec3 {
    if one_minus_cos >= 2.0 {
        return uniform_sphere(u);
    }
    let below = u[0] * one_minus_cos;
    let sin = (below * (2.0 - below)).sqrt();
    let (sin_phi, cos_phi) = sincos(TAU * u[1]);
    Frame::from_z(axis).from_local(DVec3::new(sin * cos_phi, sin * sin_phi, 1.0 - below))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};

    fn spheres() -> ProjectionMap {
        let sphere = |x: f64, radius: f64| TargetSphere { centre: DVec3::new(x, 0.0, 0.0), radius };
        ProjectionMap::new(vec![sphere(4.0, 1.0), sphere(5.0, 1.5), sphere(-9.0, 0.5)])
    }

    fn numbers(count: u64) -> impl Iterator<Item = [f64; 3]> {
        (0..count).map(|i| [0, 1, 2].map(|dimension| unit(hash(&[i, dimension]))))
    }

    /// The mean of 1 / p over samples is the measure of the domain: two cones, one within the other, and a third.
    #[test]
    fn directions_have_the_returned_density() {
        let (targets, point) = (spheres(), DVec3::new(0.0, 0.3, 0.0));
        let aims: Vec<_> = numbers(20_000).filter_map(|[c, u, v]| targets.sample_direction(point, c, [u, v])).collect();
        let mean = aims.iter().map(|sample| 1.0 / sample.pdf).sum::<f64>() / aims.len() as f64;
        let inside = numbers(400_000).filter(|[_, u, v]| {
            let direction = uniform_sphere([*u, *v]);
            targets.spheres.iter().any(|sphere| sphere.is_hit(point, direction))
        });
        let truth = 4.0 * PI * inside.count() as f64 / 400_000.0;
        assert_eq!(aims.len(), 20_000);
        assert!((mean / truth - 1.0).abs() < 0.02, "{mean} is not {truth}");
    }

    #[test]
    fn parallel_light_covers_the_union_of_disks() {
        let targets = spheres();
        let direction = DVec3::NEG_Z;
        let aims: Vec<_> = numbers(20_000).filter_map(|[c, u, v]| targets.sample_disk(direction, c, [u, v])).collect();
        let mean = aims.iter().map(|sample| 1.0 / sample.pdf).sum::<f64>() / aims.len() as f64;
        // The union of two circles of radius 1 and 1.5 at the distance 1, and one of radius 0.5: by quadrature.
        let side = 2000;
        let cell = 24.0 / f64::from(side);
        let covered = |i: i32| {
            let at =
                DVec3::new((f64::from(i % side) + 0.5) * cell - 12.0, (f64::from(i / side) + 0.5) * cell - 12.0, 0.0);
            targets.spheres.iter().any(|sphere| (sphere.centre - at).length() <= sphere.radius)
        };
        let truth = (0..side * side).filter(|i| covered(*i)).count() as f64 * cell * cell;
        assert!((mean / truth - 1.0).abs() < 0.01, "{mean} is not {truth}");
    }

    #[test]
    fn from_within_and_to_everywhere_no_direction_is_better_than_others() {
        assert_eq!(spheres().sample_direction(DVec3::X * 4.5, 0.5, [0.5; 2]), None);
        assert_eq!(ProjectionMap::EVERYWHERE.sample_direction(DVec3::ZERO, 0.5, [0.5; 2]), None);
        assert!(ProjectionMap::new(vec![TargetSphere { centre: DVec3::ZERO, radius: f64::INFINITY }]).is_everywhere());
        assert!(ProjectionMap::new(vec![]).is_empty() && !spheres().is_empty());
    }

    #[test]
    fn many_balls_become_one_around_them() {
        let many: Vec<_> = (0..40).map(|i| TargetSphere { centre: DVec3::X * f64::from(i), radius: 0.5 }).collect();
        assert_eq!(ProjectionMap::new(many).spheres, [TargetSphere { centre: DVec3::X * 19.5, radius: 20.0 }]);
    }
}
