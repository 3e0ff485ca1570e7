//! Rays against a world: where structures and materials meet.

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{
    BatchKernel, Hit, InteractionFlags, PrimitiveGeometry, Primitives, Probe, RayCounts, RayKind, Spheres,
};
use rt_math::{Interval, Ray};
use rt_shading::{SurfaceHit, Tracer, emitter::EmitterRef};

use crate::{pyramid::Outlines, visible::InView, world::Parts};

/// Primitives that know what their surface is made of.
pub(crate) trait Surfaces: Outlines {
    /// The surface at a hit; `None` for a hit that is not of this set. Objects are numbered by their places among the
    /// parts of the upper level.
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceHit>;
}

impl Surfaces for Parts<'_> {
    #[inline]
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceHit> {
        self.surface(ray, hit, needs)
    }
}

/// A world of nothing but spheres: a tight array, and no question what a part is.
#[derive(Debug)]
pub(crate) struct SphereWorld {
    pub(crate) spheres: Spheres,
    /// By sphere: its material.
    pub(crate) materials: Vec<u32>,
    /// By sphere: whether something looks at its texture coordinates.
    pub(crate) textured: Vec<bool>,
    /// By sphere: whether it casts a shadow; empty if all do.
    pub(crate) casts_shadow: Vec<bool>,
    /// By sphere: the light that it is; empty if none is.
    pub(crate) emitters: Vec<Option<u32>>,
}

impl SphereWorld {
    pub(crate) fn casts_shadow(&self, index: u32) -> bool {
        self.casts_shadow.get(index as usize).copied().unwrap_or(true)
    }
}

impl Primitives for SphereWorld {
    fn len(&self) -> usize {
        self.spheres.len()
    }

    #[inline]
    fn bounds(&self, index: u32) -> Option<rt_math::Aabb> {
        self.spheres.bounds(index)
    }

    #[inline(always)]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.spheres.intersect(index, ray, span)
    }

    #[inline(always)]
    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.casts_shadow(index) && self.spheres.occludes(index, ray, span)
    }

    #[inline]
    fn batch_kernel(&self, index: u32) -> BatchKernel {
        self.spheres.batch_kernel(index)
    }

    #[inline]
    fn blocks(&self, index: u32) -> bool {
        self.casts_shadow(index)
    }

    #[inline]
    fn geometry(&self, index: u32) -> PrimitiveGeometry {
        if self.casts_shadow(index) { self.spheres.geometry(index) } else { PrimitiveGeometry::Opaque }
    }
}

impl Surfaces for SphereWorld {
    #[inline(always)]
    fn surface_at(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceHit> {
        let material = *self.materials.get(hit.primitive as usize)?;
        let uv = needs.uv && *self.textured.get(hit.primitive as usize)?;
        let interaction = self.spheres.surface(ray, hit, InteractionFlags { uv, ..needs })?;
        let index = self.emitters.get(hit.primitive as usize).copied().flatten();
        let emitter = index.map(|index| EmitterRef { index, triangle: None });
        Some(SurfaceHit { t: hit.t, interaction, object: hit.primitive, material, emitter })
    }
}

/// Answers an integrator's rays and counts them. Which structure it is, is asked once for each batch: integrators are not
/// compiled anew for each.
pub(crate) struct WorldTracer<'w, W, S> {
    pub(crate) world: &'w W,
    pub(crate) structure: &'w AnyAccelerator,
    /// What camera rays are asked of.
    pub(crate) in_view: InView<'w>,
    /// Rays by kind.
    pub(crate) rays: RayCounts,
    /// Camera rays that were not traced, as there is nothing for them to meet.
    pub(crate) spared: u64,
    /// The structure's work.
    pub(crate) probe: S,
    /// The hits of a batch; empty between batches.
    hits: Vec<Option<Hit>>,
}

impl<'w, W: Surfaces, S: Probe> WorldTracer<'w, W, S> {
    pub(crate) fn new(world: &'w W, structure: &'w AnyAccelerator, in_view: InView<'w>, probe: S) -> Self {
        Self { world, structure, in_view, rays: RayCounts::default(), spared: 0, probe, hits: Vec::new() }
    }

    /// Takes the memory for hits from one that is not used any more.
    pub(crate) fn with_buffer(self, hits: Vec<Option<Hit>>) -> Self {
        Self { hits, ..self }
    }

    /// The memory for hits, for the next one.
    pub(crate) fn into_buffer(self) -> Vec<Option<Hit>> {
        self.hits
    }

    /// What rays of this kind are asked of.
    const fn asked(&self, kind: RayKind) -> InView<'w> {
        if matches!(kind, RayKind::Primary) { self.in_view } else { InView::All(self.structure) }
    }

    /// True for rays that need not be traced. Counts the others.
    fn spares(&mut self, kind: RayKind, rays: usize) -> bool {
        let spares = kind == RayKind::Primary && self.in_view.is_empty();
        if spares {
            self.spared += rays as u64;
        } else {
            self.count(kind, rays);
        }
        spares
    }

    fn count(&mut self, kind: RayKind, rays: usize) {
        for _ in 0..rays {
            self.rays.ray(kind);
            self.probe.ray(kind);
        }
    }
}

impl<W: Surfaces, S: Probe> Tracer for WorldTracer<'_, W, S> {
    fn closest(&mut self, ray: &Ray, span: Interval, kind: RayKind, needs: InteractionFlags) -> Option<SurfaceHit> {
        if self.spares(kind, 1) {
            return None;
        }
        let hit = self.asked(kind).closest(self.world, ray, span, &mut self.probe)?;
        self.world.surface_at(ray, &hit, needs)
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
        needs: InteractionFlags,
        mut met: impl FnMut(usize, Option<&mut SurfaceHit>),
    ) {
        if self.spares(kind, rays.len()) {
            return (0..rays.len()).for_each(|at| met(at, None));
        }
        self.hits.clear();
        self.hits.resize(rays.len(), None);
        self.asked(kind).closest_batch(self.world, rays, &mut self.hits, &mut self.probe);
        for (at, ((ray, _), hit)) in rays.iter().zip(&self.hits).enumerate() {
            match hit {
                Some(hit) => met(at, self.world.surface_at(ray, hit, needs).as_mut()),
                None => met(at, None),
            }
        }
    }

    fn occluded_batch(&mut self, rays: &[(Ray, Interval)], blocked: &mut [bool]) {
        self.count(RayKind::Shadow, rays.len());
        self.structure.occluded_batch(self.world, rays, blocked, &mut self.probe);
    }
}
