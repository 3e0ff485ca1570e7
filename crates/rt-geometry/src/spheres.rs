//! Sets of spheres.

use crate::{Hit, InteractionFlags, PrimitiveGeometry, Primitives, ShapeHit, Sphere, SurfaceInteraction};
use rt_math::{Aabb, Interval, Ray};

/// Set of spheres in one space, for scenes without other objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spheres(Vec<Sphere>);

impl Spheres {
    /// Set of these spheres; primitive indices are positions in the list.
    pub const fn new(spheres: Vec<Sphere>) -> Self {
        Self(spheres)
    }

    /// The spheres in order.
    pub fn as_slice(&self) -> &[Sphere] {
        &self.0
    }

    /// Surface at a hit of this set with this ray; `None` for an invalid primitive index.
    // Inlined: returning a surface through memory would copy it before it is complete.
    #[inline(always)]
    pub fn surface(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceInteraction> {
        let sphere = self.0.get(hit.primitive as usize)?;
        Some(sphere.surface(ray, &ShapeHit { t: hit.t, uv: hit.uv }, needs))
    }
}

impl Primitives for Spheres {
    fn len(&self) -> usize {
        self.0.len()
    }

    #[inline]
    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.0.get(index as usize).map(Sphere::bounds)
    }

    #[inline(always)]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let ShapeHit { t, uv } = self.0.get(index as usize)?.intersect(ray, span)?;
        Some(Hit { t, instance: 0, primitive: index, uv })
    }

    #[inline]
    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        self.0
            .get(index as usize)
            .map_or(PrimitiveGeometry::Opaque, |sphere| PrimitiveGeometry::ExactSphere(sphere.kernel()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::DVec3;

    #[test]
    fn a_set_answers_as_its_spheres_do() {
        let sphere = |x: f64| Sphere::new(DVec3::X * x, 1.0).expect("a sphere");
        let set = Spheres::new(vec![sphere(0.0), sphere(3.0)]);
        let ray = Ray::new(DVec3::new(3.2, 0.1, 5.0), DVec3::NEG_Z);
        assert_eq!(set.intersect(0, &ray, Interval::FORWARD), None);
        let hit = set.intersect(1, &ray, Interval::FORWARD).expect("a hit");
        let alone = sphere(3.0).intersect(&ray, Interval::FORWARD).expect("a hit");
        assert_eq!((hit.t, hit.instance, hit.primitive), (alone.t, 0, 1));
        let needs = InteractionFlags::ALL;
        assert_eq!(set.surface(&ray, &hit, needs), Some(sphere(3.0).surface(&ray, &alone, needs)));
        assert_eq!(set.surface(&ray, &Hit { primitive: 2, ..hit }, needs), None);
        assert_eq!((set.len(), set.bounds(1)), (2, Some(sphere(3.0).bounds())));
        assert_eq!(set.geometry(1), PrimitiveGeometry::ExactSphere(sphere(3.0).kernel()));
        assert_eq!((set.bounds(2), set.intersect(2, &ray, Interval::FORWARD)), (None, None), "not there");
    }
}
