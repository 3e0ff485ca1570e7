//! Hits that wait to be shaded in lanes.

use crate::{LazyHit, LazyPlane, LazySurface, SurfaceHit, TrianglePoint, interior_list::MediumEntry, lanes::LANES};
use rt_geometry::Sphere;
use rt_math::Ray;

/// A hit of a ray of the batch on a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueuedHit<T> {
    /// Index of the ray.
    pub(super) ray: u32,
    pub(super) body: MediumEntry,
    pub(super) t: f64,
    pub(super) shape: T,
}

/// Hits that wait to be shaded in lanes, by the kind of shape.
#[derive(Clone, Debug, Default)]
pub(super) struct HitQueue {
    pub(super) spheres: Vec<QueuedHit<Sphere>>,
    pub(super) triangles: Vec<QueuedHit<TrianglePoint>>,
    pub(super) planes: Vec<QueuedHit<LazyPlane>>,
}

impl HitQueue {
    /// Appends a hit of the ray with this index.
    #[inline(always)]
    pub(super) fn push_sphere(&mut self, ray: usize, hit: &LazyHit<Sphere>) {
        self.spheres.push(QueuedHit::new(ray, hit));
    }

    /// Version of [`push_sphere`](Self::push_sphere) for a triangle.
    #[inline(always)]
    pub(super) fn push_triangle(&mut self, ray: usize, hit: &LazyHit<TrianglePoint>) {
        self.triangles.push(QueuedHit::new(ray, hit));
    }

    /// Version of [`push_sphere`](Self::push_sphere) for a plane.
    #[inline(always)]
    pub(super) fn push_plane(&mut self, ray: usize, hit: &LazyHit<LazyPlane>) {
        self.planes.push(QueuedHit::new(ray, hit));
    }
}

impl<T: Copy> QueuedHit<T> {
    #[inline(always)]
    const fn new(ray: usize, hit: &LazyHit<T>) -> Self {
        let body = MediumEntry { object: hit.object, material: hit.material };
        Self { ray: ray as u32, body, t: hit.t, shape: hit.shape }
    }

    /// The hit with its surface, for shading that samples no area lights.
    pub(super) fn surface(&self, ray: &Ray) -> SurfaceHit
    where
        T: LazySurface,
    {
        let Self { t, body: MediumEntry { object, material }, shape, .. } = *self;
        LazyHit { t, shape, object, material, light: None }.surface(ray)
    }
}

/// Items of all lanes; the last one repeats in lanes without an item.
#[inline(always)]
pub(super) fn eight<T>(items: &[T]) -> [&T; LANES] {
    let last = items.len() - 1;
    let at = |lane: usize| &items[lane.min(last)];
    [at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)]
}
