//! Ray queries of integrators against the world.

use rt_accel::{Accelerator, AnyAccelerator};
use rt_geometry::{HitStream, InteractionFlags, Probe, RayCounts, RayKind, RayStream};
use rt_math::{Interval, Ray};
use rt_shading::{SceneQueries, StreamPrimitive, StreamQueries, SurfaceHit};

use crate::{frustum_cull::PrimaryTarget, instance::Instances, tile_layers::TileLayers, work_probe::WorkProbe};

/// Traces and counts the rays of an integrator. The accelerator is dispatched once per stream, so that integrators are not
/// compiled for each accelerator.
pub(crate) struct SceneTracer<'w> {
    pub(crate) world: &'w Instances<'w>,
    pub(crate) accelerator: &'w AnyAccelerator,
    /// Objects that camera rays are tested against.
    pub(crate) primary_target: PrimaryTarget<'w>,
    pub(crate) rays: RayCounts,
    /// Camera rays skipped because nothing is in view.
    pub(crate) skipped: u64,
    pub(crate) probe: WorkProbe,
    /// Layers that camera rays are added to.
    pub(crate) layers: Option<TileLayers<'w>>,
}

impl<'w> SceneTracer<'w> {
    pub(crate) fn new(
        world: &'w Instances<'w>,
        accelerator: &'w AnyAccelerator,
        primary_target: PrimaryTarget<'w>,
        probe: WorkProbe,
    ) -> Self {
        Self { world, accelerator, primary_target, rays: RayCounts::default(), skipped: 0, probe, layers: None }
    }

    /// Objects that rays of this kind are tested against.
    const fn target(&self, kind: RayKind) -> PrimaryTarget<'w> {
        if matches!(kind, RayKind::Primary) { self.primary_target } else { PrimaryTarget::All(self.accelerator) }
    }

    /// True for rays that cannot hit anything. Counts these as skipped and others as traced.
    fn can_skip(&mut self, kind: RayKind, rays: usize) -> bool {
        let can_skip = kind == RayKind::Primary && self.primary_target.is_empty();
        if can_skip {
            self.skipped += rays as u64;
        } else {
            self.count(kind, rays);
        }
        can_skip
    }

    fn count(&mut self, kind: RayKind, rays: usize) {
        for _ in 0..rays {
            self.rays.ray(kind);
            self.probe.ray(kind);
        }
    }
}

impl SceneQueries for SceneTracer<'_> {
    fn closest(&mut self, ray: &Ray, span: Interval, kind: RayKind, needs: InteractionFlags) -> Option<SurfaceHit> {
        if self.can_skip(kind, 1) {
            return None;
        }
        let hit = self.target(kind).closest(self.world, ray, span, &mut self.probe);
        if let (Some(layers), RayKind::Primary) = (&mut self.layers, kind) {
            layers.add(self.world, ray, hit.as_ref());
        }
        self.world.surface(ray, &hit?, needs)
    }

    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
        self.count(RayKind::Shadow, 1);
        self.accelerator.occluded(self.world, ray, span, &mut self.probe)
    }
}

impl StreamQueries for SceneTracer<'_> {
    fn closest_stream(&mut self, rays: &RayStream, kind: RayKind, hits: &mut HitStream) {
        if self.can_skip(kind, rays.len()) {
            return (0..rays.len()).for_each(|at| hits.set(at, None));
        }
        let (world, probe) = (self.world, &mut self.probe);
        match kind {
            RayKind::Primary => self.primary_target.closest_stream(world, rays, hits, probe),
            _ => self.accelerator.closest_stream(world, rays, hits, probe),
        }
        if let (Some(layers), RayKind::Primary) = (&mut self.layers, kind) {
            layers.add_stream(world, rays, hits);
        }
    }

    fn occluded_stream(&mut self, rays: &RayStream, occluded: &mut [bool]) {
        self.count(RayKind::Shadow, rays.len());
        self.accelerator.occluded_stream(self.world, rays, occluded, &mut self.probe);
    }

    #[inline(always)]
    fn primitive(&self, hits: &HitStream, at: usize) -> Option<StreamPrimitive<'_>> {
        self.world.stream_primitive([hits.instance.get(at), hits.primitive.get(at)])
    }

    fn has_only_primitives(&self) -> bool {
        self.world.has_only_primitives
    }

    fn surface(&self, ray: &Ray, hits: &HitStream, at: usize, needs: InteractionFlags) -> Option<SurfaceHit> {
        self.world.surface(ray, &hits.get(at)?, needs)
    }

    fn vertex_uvs(&self, hits: &HitStream, at: usize) -> [[f32; 2]; 3] {
        self.world.vertex_uvs([hits.instance.get(at), hits.primitive.get(at)]).unwrap_or_default()
    }
}
