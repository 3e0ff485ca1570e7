//! Streams of rays through instances: in the space of meshes and groups, they are traced together.

use rt_accel::Accelerator;
use rt_geometry::{HitStream, Probe, RayStream, with_local_rays, with_stream_buffers};

use crate::instance::{Animated, InstanceGeometry, Instances};

/// Calls `trace` with the rays in the space of animated geometry, each at its own time.
fn trace_animated(rays: &RayStream, animated: &Animated, trace: &mut dyn FnMut(&RayStream)) {
    with_stream_buffers(&mut |buffers| {
        buffers.rays.set_mapped(rays, |ray| animated.aggregate_from_local.at(ray.time).inverse_ray(ray));
        trace(&buffers.rays);
    });
}

impl Instances<'_> {
    /// Version of [`closest_on`](Self::closest_on) for a stream.
    pub(crate) fn closest_stream_on<S: Probe>(
        &self,
        (index, geometry): (u32, &InstanceGeometry),
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        match geometry {
            InstanceGeometry::Mesh(level, transform) => {
                let mesh = &self.levels.meshes[*level as usize];
                let trace = &mut |rays: &RayStream| mesh.closest_stream(&self.levels.textures, rays, hits, probe);
                with_local_rays(rays, transform.as_deref(), trace);
                hits.instance.as_mut_slice()[..rays.len()].fill(index);
            }
            InstanceGeometry::Group(level, transform) => {
                let group = &self.levels.groups[*level as usize];
                let inner = group.set(self.levels);
                let trace = &mut |rays: &RayStream| group.accelerator.closest_stream(&inner, rays, hits, probe);
                with_local_rays(rays, transform.as_deref(), trace);
                for at in 0..rays.len() {
                    if let Some(hit) = hits.get(at) {
                        hits.set(at, Some(&group.with_instance(hit, index)));
                    }
                }
            }
            InstanceGeometry::Animated(animated) => {
                let geometry = &animated.geometry;
                trace_animated(rays, animated, &mut |rays| {
                    self.closest_stream_on((index, geometry), rays, hits, probe)
                });
            }
            InstanceGeometry::Shape(_) | InstanceGeometry::TransformedShape(_) | InstanceGeometry::Triangle(_) => {
                for at in 0..rays.len() {
                    let (ray, span) = rays.get(at);
                    hits.set(at, self.closest_on((index, geometry), &ray, span, probe).as_ref());
                }
            }
        }
    }

    /// Version of [`occluded_by`](Self::occluded_by) for a stream.
    pub(crate) fn occluded_stream_by<S: Probe>(
        &self,
        geometry: &InstanceGeometry,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        match geometry {
            InstanceGeometry::Mesh(level, transform) => {
                let mesh = &self.levels.meshes[*level as usize];
                let trace = &mut |rays: &RayStream| mesh.occluded_stream(&self.levels.textures, rays, occluded, probe);
                with_local_rays(rays, transform.as_deref(), trace);
            }
            InstanceGeometry::Group(level, transform) => {
                let group = &self.levels.groups[*level as usize];
                let inner = group.set(self.levels);
                let trace = &mut |rays: &RayStream| group.accelerator.occluded_stream(&inner, rays, occluded, probe);
                with_local_rays(rays, transform.as_deref(), trace);
            }
            InstanceGeometry::Animated(animated) => {
                let geometry = &animated.geometry;
                trace_animated(rays, animated, &mut |rays| self.occluded_stream_by(geometry, rays, occluded, probe));
            }
            InstanceGeometry::Shape(_) | InstanceGeometry::TransformedShape(_) | InstanceGeometry::Triangle(_) => {
                for (at, occluded) in occluded.iter_mut().enumerate().take(rays.len()) {
                    let (ray, span) = rays.get(at);
                    *occluded = self.occluded_by(geometry, &ray, span, probe);
                }
            }
        }
    }
}
