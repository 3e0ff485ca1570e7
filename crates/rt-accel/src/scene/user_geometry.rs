//! Primitives that are boxes and a closure.

use rt_geometry::{Hit, Primitives};
use rt_math::{Aabb, Interval, Ray};

/// The caller's own primitives, intersected by a closure, without an implementation of [`Primitives`].
///
/// The closure returns the `t` of the first hit of primitive `index` within the interval. It follows the contract of
/// [`Primitives::intersect`]; in particular, its hits lie within the bounds.
///
/// ```
/// use rt_accel::{Aabb, Accelerator, Bvh, DVec3, Interval, NoProbe, Ray, UserGeometry};
///
/// // Floors of one square metre, one metre apart.
/// let floor = |i: u32| Aabb::new(DVec3::new(0.0, 0.0, i.into()), DVec3::new(1.0, 1.0, i.into()));
/// let bounds: Vec<Aabb> = (0..10).map(floor).collect();
/// let floors = UserGeometry::new(&bounds, |index, ray, span| {
///     let t = (f64::from(index) - ray.origin.z) / ray.direction.z;
///     let point = ray.at(t);
///     (span.contains(t) && (0.0..=1.0).contains(&point.x) && (0.0..=1.0).contains(&point.y)).then_some(t)
/// });
/// let bvh = Bvh::build(&floors)?;
/// let ray = Ray::new(DVec3::new(0.5, 0.5, 20.0), DVec3::NEG_Z);
/// let hit = bvh.closest(&floors, &ray, Interval::FORWARD, &mut NoProbe);
/// assert_eq!(hit.map(|hit| (hit.t, hit.primitive)), Some((11.0, 9)));
/// # Ok::<(), rt_accel::BuildError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct UserGeometry<'a, F> {
    bounds: &'a [Aabb],
    intersect: F,
}

impl<'a, F: Fn(u32, &Ray, Interval) -> Option<f64> + Sync> UserGeometry<'a, F> {
    /// Primitives with these bounds and this intersection.
    pub const fn new(bounds: &'a [Aabb], intersect: F) -> Self {
        Self { bounds, intersect }
    }
}

impl<F: Fn(u32, &Ray, Interval) -> Option<f64> + Sync> Primitives for UserGeometry<'_, F> {
    fn len(&self) -> usize {
        self.bounds.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.bounds.get(index as usize).copied()
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let t = (self.intersect)(index, ray, span)?;
        Some(Hit { t, instance: 0, primitive: index, uv: [0.0; 2] })
    }
}
