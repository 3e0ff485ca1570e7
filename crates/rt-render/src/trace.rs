//! Rays against a world: where structures and materials meet.

use rt_accel::AnyStructure;
use rt_geometry::{Spheres, SurfaceInteraction, SurfaceNeeds};
use rt_math::{Accelerator, Hit, Interval, Primitives, Probe, Ray, RayCounts, RayKind};
use rt_shading::{SurfaceHit, Tracer};

use crate::{visible::Visible, world::Parts};

/// Primitives that know what their surface is made of.
pub(crate) trait Surfaces: Primitives {
    /// The surface at a hit, and its material; `None` for a hit that is not of this set.
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: SurfaceNeeds) -> Option<(SurfaceInteraction, u32)>;

    /// Number of the object that a hit lies on: its place among the parts of the upper level.
    fn object_at(&self, hit: &Hit) -> u32;
}

impl Surfaces for Parts<'_> {
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: SurfaceNeeds) -> Option<(SurfaceInteraction, u32)> {
        self.surface(hit.instance, ray, hit, needs)
    }

    fn object_at(&self, hit: &Hit) -> u32 {
        hit.instance
    }
}

/// A world of nothing but spheres, all of which cast shadows: a tight array, and no question what a part is.
#[derive(Debug)]
pub(crate) struct SphereWorld {
    pub(crate) spheres: Spheres,
    pub(crate) materials: Vec<u32>,
}

impl Primitives for SphereWorld {
    fn len(&self) -> usize {
        self.spheres.len()
    }

    fn bounds(&self, index: u32) -> Option<rt_math::Aabb> {
        self.spheres.bounds(index)
    }

    #[inline(always)]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.spheres.intersect(index, ray, span)
    }

    fn leaf_layout(&self, index: u32) -> rt_math::LeafLayout {
        self.spheres.leaf_layout(index)
    }
}

impl Surfaces for SphereWorld {
    #[inline]
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: SurfaceNeeds) -> Option<(SurfaceInteraction, u32)> {
        Some((self.spheres.surface(ray, hit, needs)?, *self.materials.get(hit.primitive as usize)?))
    }

    fn object_at(&self, hit: &Hit) -> u32 {
        hit.primitive
    }
}

/// Answers an integrator's rays and counts them. Which structure it is, is asked once for each batch: integrators are not
/// compiled anew for each.
pub(crate) struct WorldTracer<'w, W, S> {
    pub(crate) world: &'w W,
    pub(crate) structure: &'w AnyStructure,
    /// What camera rays are asked of instead, if that is less.
    pub(crate) visible: Option<&'w Visible>,
    /// Rays by kind.
    pub(crate) rays: RayCounts,
    /// The structure's work.
    pub(crate) probe: S,
    /// The hits of a batch; empty between batches.
    hits: Vec<Option<Hit>>,
}

impl<'w, W: Surfaces, S: Probe> WorldTracer<'w, W, S> {
    pub(crate) fn new(world: &'w W, structure: &'w AnyStructure, visible: Option<&'w Visible>, probe: S) -> Self {
        Self { world, structure, visible, rays: RayCounts::default(), probe, hits: Vec::new() }
    }

    /// Takes the memory for hits from one that is not used any more.
    pub(crate) fn with_buffer(self, hits: Vec<Option<Hit>>) -> Self {
        Self { hits, ..self }
    }

    /// The memory for hits, for the next one.
    pub(crate) fn into_buffer(self) -> Vec<Option<Hit>> {
        self.hits
    }

    fn count(&mut self, kind: RayKind, rays: usize) {
        for _ in 0..rays {
            self.rays.ray(kind);
            self.probe.ray(kind);
        }
    }

    #[inline]
    fn surface(&self, ray: &Ray, hit: &Hit, needs: SurfaceNeeds) -> Option<SurfaceHit> {
        let (interaction, material) = self.world.surface_at(ray, hit, needs)?;
        Some(SurfaceHit { t: hit.t, interaction, object: self.world.object_at(hit), material })
    }
}

impl<W: Surfaces, S: Probe> Tracer for WorldTracer<'_, W, S> {
    fn closest(&mut self, ray: &Ray, span: Interval, kind: RayKind, needs: SurfaceNeeds) -> Option<SurfaceHit> {
        self.count(kind, 1);
        let hit = match (kind, self.visible) {
            (RayKind::Primary, Some(visible)) => visible.closest(self.world, ray, span, &mut self.probe),
            _ => self.structure.closest(self.world, ray, span, &mut self.probe),
        }?;
        self.surface(ray, &hit, needs)
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        self.count(RayKind::Shadow, 1);
        self.structure.occluded(self.world, ray, span, &mut self.probe)
    }

    #[inline]
    fn closest_batch(
        &mut self,
        rays: &[(Ray, Interval)],
        kind: RayKind,
        needs: SurfaceNeeds,
        mut met: impl FnMut(usize, Option<SurfaceHit>),
    ) {
        self.count(kind, rays.len());
        self.hits.clear();
        self.hits.resize(rays.len(), None);
        match (kind, self.visible) {
            (RayKind::Primary, Some(visible)) => {
                visible.closest_batch(self.world, rays, &mut self.hits, &mut self.probe);
            }
            _ => self.structure.closest_batch(self.world, rays, &mut self.hits, &mut self.probe),
        }
        for (at, ((ray, _), hit)) in rays.iter().zip(&self.hits).enumerate() {
            met(at, hit.as_ref().and_then(|hit| self.surface(ray, hit, needs)));
        }
    }

    fn occluded_batch(&mut self, rays: &[(Ray, Interval)], blocked: &mut [bool]) {
        self.count(RayKind::Shadow, rays.len());
        self.structure.occluded_batch(self.world, rays, blocked, &mut self.probe);
    }
}
