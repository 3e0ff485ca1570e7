//! Instances of geometries as primitives of the top level.

use std::sync::Arc;

use rt_geometry::{Hit, HitStream, NoProbe, PacketKernel, Primitives, Probe, RayStream, with_local_rays};
use rt_math::{Aabb, Interval, Ray, Transform};

use super::geometry::Blas;

/// A placed geometry.
#[derive(Clone, Debug)]
pub(super) struct Instance {
    /// Index of the instance in hits; instances are sorted by it.
    pub(super) id: u32,
    /// Index of its geometry.
    pub(super) geometry: u32,
    /// `None` for the identity.
    pub(super) world_from_local: Option<Box<Transform>>,
    /// World space.
    pub(super) bounds: Aabb,
}

impl Instance {
    /// The ray in the space of the geometry, with the same `t`.
    #[inline]
    pub(super) fn local_ray(&self, ray: &Ray) -> Ray {
        self.world_from_local.as_ref().map_or(*ray, |transform| transform.inverse_ray(ray))
    }
}

/// Instances with their geometries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instances<'s, 'a> {
    pub(super) instances: &'s [Instance],
    pub(super) geometries: &'s [Option<Arc<Blas<'a>>>],
}

impl<'s, 'a> Instances<'s, 'a> {
    /// Instance at an index, which is at most its number, and its geometry.
    #[inline]
    pub(super) fn get(&self, index: u32) -> Option<(&'s Instance, &'s Blas<'a>)> {
        let instance = self.instances.get(index as usize)?;
        Some((instance, self.geometries.get(instance.geometry as usize)?.as_deref()?))
    }
}

impl Primitives for Instances<'_, '_> {
    fn len(&self) -> usize {
        self.instances.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.instances.get(index as usize).map(|instance| instance.bounds)
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        self.intersect_with_stats(index, ray, span, &mut NoProbe)
    }

    fn occludes(&self, index: u32, ray: &Ray, span: Interval) -> bool {
        self.occludes_with_stats(index, ray, span, &mut NoProbe)
    }

    #[inline]
    fn intersect_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
        let (instance, geometry) = self.get(index)?;
        let hit = geometry.closest(&instance.local_ray(ray), span, probe)?;
        Some(Hit { instance: instance.id, ..hit })
    }

    #[inline]
    fn occludes_with_stats<S: Probe>(&self, index: u32, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        self.get(index).is_some_and(|(instance, geometry)| geometry.occluded(&instance.local_ray(ray), span, probe))
    }

    fn packet_kernel(&self, _: u32) -> PacketKernel {
        PacketKernel::Instance
    }

    fn intersect_stream<S: Probe>(&self, index: u32, rays: &RayStream, hits: &mut HitStream, probe: &mut S) {
        let Some((instance, geometry)) = self.get(index) else {
            return (0..rays.len()).for_each(|at| hits.set(at, None));
        };
        with_local_rays(rays, instance.world_from_local.as_deref(), &mut |rays| {
            geometry.closest_stream(rays, hits, probe)
        });
        hits.instance.as_mut_slice()[..rays.len()].fill(instance.id);
    }

    fn occludes_stream<S: Probe>(&self, index: u32, rays: &RayStream, occluded: &mut [bool], probe: &mut S) {
        let n = rays.len().min(occluded.len());
        let Some((instance, geometry)) = self.get(index) else { return occluded[..n].fill(false) };
        with_local_rays(rays, instance.world_from_local.as_deref(), &mut |rays| {
            geometry.occluded_stream(rays, occluded, probe)
        });
    }
}
