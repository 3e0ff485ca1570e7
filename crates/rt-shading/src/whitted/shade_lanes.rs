//! Shading of hits in lanes: groups on one material, emission and direct light.

use super::{
    hit_group::{HitGroup, HitSurfaces},
    inputs::RayTreeInputs,
    lane_phong::LanePhong,
    streams::RayTreeStream,
    wave::{RayTreeWave, ShadeRayTreeHits, SpawnedRays},
};
use crate::{
    Background, RadianceSample,
    lane_set::{Element, LaneSet, LaneStage},
    lanes::{LANES, each_lane, first_lanes, is_zero},
    medium::transmittance_to_light,
    stream_queries::{StreamPrimitive, StreamQueries, StreamShape},
    wavefront::{
        delta_lights::{sample_li, shadow_rays},
        hit_points::HitPoints,
        is_in_range,
        shaded_surface::{ShadedSurface, ShadingNormals},
        streams::{add_radiance, attenuated, times},
    },
};
use rt_geometry::HitStream;
use rt_math::{Real, Rgb};

impl<E: Element> LaneStage<E> for ShadeRayTreeHits<'_, E> {
    #[inline(always)]
    fn run<L: LaneSet<Element = E>>(self, lanes: L) {
        let Self { spawned, inputs, world, wave, radiances } = self;
        spawned.shade((lanes, inputs), world, wave, radiances);
    }
}

impl<E: Element> SpawnedRays<E> {
    /// Shades those closest hits of a wave that are shaded in lanes, and adds the background to the samples of rays without a hit.
    #[inline(always)]
    fn shade<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &RayTreeInputs<'_>),
        world: &dyn StreamQueries,
        (paths, hits): RayTreeWave<'_, E>,
        radiances: &mut [RadianceSample],
    ) {
        for at in (0..paths.len()).step_by(L::N) {
            let used = first_lanes((paths.len() - at).min(L::N));
            let [instances, indices] = [hits.instance.vector(at), hits.primitive.vector(at)];
            let missed = lanes.equal(indices, HitStream::NONE) & used;
            if missed != 0 {
                leave_scene((lanes, inputs), missed, (paths, at), radiances);
            }
            let mut rest = self.in_lanes.bits(at) & used & !missed;
            while let Some(first) = each_lane(rest).next() {
                let primitive = world.primitive(hits, at + first);
                let model = primitive.and_then(|primitive| inputs.phongs.get(primitive.material));
                let (Some(primitive), Some(model)) = (primitive, model) else {
                    // A world that contradicts itself.
                    rest &= !(1 << first);
                    continue;
                };
                let StreamPrimitive { shape, object, material, .. } = primitive;
                let mask = lanes.equal(indices, indices[first]) & lanes.equal(instances, instances[first]) & rest;
                let points = match shape {
                    StreamShape::Sphere(sphere) if mask == rest => {
                        HitPoints::on_sphere(lanes, sphere, (&paths.rays, hits), at)
                    }
                    StreamShape::Plane(plane) | StreamShape::Polygon(plane) => {
                        HitPoints::on_plane(lanes, plane, (&paths.rays, hits), at)
                    }
                    StreamShape::Sphere(_) | StreamShape::Triangle(_) | StreamShape::MeshTriangle(..) => {
                        rest &= !self.shade_gathered(
                            (lanes, inputs),
                            world,
                            (paths, hits),
                            (at, rest),
                            (model, material),
                            radiances,
                        );
                        continue;
                    }
                };
                rest &= !mask;
                let uv = match shape {
                    StreamShape::Plane(plane) if model.is_checkered() => Some(points.uv_on_plane(lanes, plane)),
                    _ => None,
                };
                let surface = &ShadedSurface::new(lanes, &points, mask);
                let (normals, objects) = (&ShadingNormals::flat(&points, surface), &[object; LANES]);
                let surfaces = &HitSurfaces { points: &points, surface, normals, uv, objects, material };
                self.shade_by_cell((lanes, inputs), model, surfaces, (paths, at, mask), radiances);
            }
        }
    }

    /// Shades the hits of some lanes, from index `at` on, on spheres and triangles of a material. Returns their lanes.
    #[inline(never)]
    fn shade_gathered<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &RayTreeInputs<'_>),
        world: &dyn StreamQueries,
        (paths, hits): RayTreeWave<'_, E>,
        (at, mask): (usize, u8),
        (model, material): (&LanePhong, u32),
        radiances: &mut [RadianceSample],
    ) -> u8 {
        lanes.vectorize(
            #[inline(always)]
            || {
                let mut objects = [0; LANES];
                let has_uv = model.is_checkered();
                let mask = self.gather(world, (hits, at, mask), (material, has_uv), &mut objects);
                let points = &HitPoints::on_shapes(lanes, &self.gathered, &paths.rays, hits, at);
                let surface = &ShadedSurface::new(lanes, points, mask);
                let mut normals = ShadingNormals::flat(points, surface);
                let smooth = mask & self.gathered.smooth;
                if smooth != 0 {
                    normals.interpolate(lanes, (points, surface), &self.gathered, (hits, at), smooth);
                }
                let uv = if has_uv { Some(HitPoints::uv_on_triangles(lanes, &self.gathered, hits, at)) } else { None };
                let surfaces = &HitSurfaces { points, surface, normals: &normals, uv, objects: &objects, material };
                self.shade_by_cell((lanes, inputs), model, surfaces, (paths, at, mask), radiances);
                mask
            },
        )
    }

    /// Gathers the spheres and triangles of a material that the rays of a mask have hit, from index `at` on, and returns their lanes.
    #[inline(never)]
    fn gather(
        &mut self,
        world: &dyn StreamQueries,
        (hits, at, mask): (&HitStream, usize, u8),
        (material, has_uv): (u32, bool),
        objects: &mut [u32; LANES],
    ) -> u8 {
        self.gathered.clear();
        let [instances, indices] = [hits.instance.vector(at), hits.primitive.vector(at)];
        let (mut rest, mut gathered) = (mask, 0);
        while let Some(first) = each_lane(rest).next() {
            let mut same = 0;
            for lane in each_lane(rest) {
                same |= u8::from(indices[lane] == indices[first] && instances[lane] == instances[first]) << lane;
            }
            rest &= !same;
            let Some(primitive) = world.primitive(hits, at + first) else { continue };
            let StreamPrimitive { shape, object, .. } = primitive;
            let is_flat = matches!(shape, StreamShape::Plane(_) | StreamShape::Polygon(_));
            if !is_flat && primitive.material == material {
                let vertex_uvs = if has_uv { world.vertex_uvs(hits, at + first) } else { [[0.0; 2]; 3] };
                for lane in each_lane(same) {
                    self.gathered.set(lane, &shape);
                    if has_uv {
                        self.gathered.set_uvs(lane, vertex_uvs);
                    }
                    objects[lane % LANES] = object;
                }
                gathered |= same;
            }
        }
        gathered
    }

    /// Shades the hits of some lanes, from index `at` on, on surfaces of a material. Those of a checkerboard have texture coordinates.
    #[inline(always)]
    fn shade_by_cell<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &RayTreeInputs<'_>),
        model: &LanePhong,
        surfaces: &HitSurfaces<'_, L>,
        (paths, at, mask): (&RayTreeStream<E>, usize, u8),
        radiances: &mut [RadianceSample],
    ) {
        let mut odd = 0;
        if let Some(uv) = surfaces.uv {
            odd = mask & model.odd_cells(lanes, uv);
        }
        for (mask, cell) in [(mask & !odd, 0), (odd, 1)] {
            if mask != 0 {
                let (throughput, eta) = (lanes.load_vector(&paths.throughput, at), lanes.splat(1.0));
                let phong = model.cell(cell);
                let group = HitGroup { phong, surfaces, at, mask, throughput, transmits: 0, eta, absorbed: 0 };
                self.shade_group((lanes, inputs), group, paths, radiances);
            }
        }
    }

    #[inline(always)]
    fn shade_group<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &RayTreeInputs<'_>),
        mut group: HitGroup<'_, L>,
        paths: &RayTreeStream<E>,
        radiances: &mut [RadianceSample],
    ) {
        if inputs.settings.features.refraction {
            self.find_interfaces((lanes, inputs), &mut group, paths, radiances);
            if group.mask == 0 {
                return;
            }
        }
        self.counts.lanes += L::N as u64;
        self.counts.lanes_used += u64::from(group.mask.count_ones());
        self.add_emission(lanes, &group, paths, radiances);
        self.sample_lights((lanes, inputs), &group, paths, radiances);
        self.spawn_rays((lanes, inputs), &group, paths);
    }

    /// Adds emission and reflected ambient light.
    #[inline(always)]
    fn add_emission<L: LaneSet<Element = E>>(
        &self,
        lanes: L,
        group: &HitGroup<'_, L>,
        paths: &RayTreeStream<E>,
        radiances: &mut [RadianceSample],
    ) {
        let inside = group.surfaces.surface.inside;
        for (mask, side) in [(group.mask & !inside, 0), (group.mask & inside, 1)] {
            if mask != 0 {
                let radiance = group.phong.radiance_from(side);
                add_radiance(
                    lanes,
                    mask,
                    lanes.splat_rgb(radiance).scaled_by(group.throughput),
                    true,
                    paths.branch.vector(group.at),
                    radiances,
                );
            }
        }
    }

    /// Adds the light of all delta lights, or queues their shadow rays.
    #[inline(always)]
    fn sample_lights<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &RayTreeInputs<'_>),
        group: &HitGroup<'_, L>,
        paths: &RayTreeStream<E>,
        radiances: &mut [RadianceSample],
    ) {
        let &RayTreeInputs { settings, appearance, .. } = inputs;
        let &HitGroup { phong, surfaces: &HitSurfaces { points, surface, normals, .. }, at, mask, .. } = group;
        let (direction, &ShadingNormals { normal, shadow_origin, .. }) = (surface.direction, normals);
        let zero = lanes.splat(0.0);
        let has_highlight = phong.specular != Rgb::BLACK;
        for (stream, lights) in
            self.lights.streams.iter_mut().zip(appearance.lights.chunks(self.lights.lights_per_stream))
        {
            for light in lights {
                let shadowed = settings.features.shadows && light.casts_shadows;
                let incident = sample_li(lanes, light, points, mask);
                let wi = incident.direction;
                let cos = normal.dot(wi);
                let faces = incident.is_lit & cos.gt(zero);
                let faced = lanes.bits(faces) & mask;
                if faced == 0 {
                    self.counts.shadow_rays_skipped += if shadowed { u64::from(mask.count_ones()) } else { 0 };
                    continue;
                }
                let mut reflectance = lanes.splat_rgb(phong.diffuse) * cos;
                if has_highlight {
                    self.counts.highlights += u64::from(faced.count_ones());
                    let strength = phong.highlight_strength([normal, -direction, wi]);
                    reflectance = reflectance + lanes.splat_rgb(phong.specular) * strength;
                }
                let radiance = reflectance.scaled_by(incident.strength) * lanes.splat(light.units.classical_factor());
                let lit = faced & !lanes.bits(is_zero(radiance));
                let radiance = radiance.scaled_by(group.throughput);
                if !shadowed {
                    add_radiance(lanes, lit, radiance, true, paths.branch.vector(at), radiances);
                    continue;
                }
                let mut radiance = radiance;
                if group.absorbed != 0 && !inputs.phongs.has_shadow_media {
                    // The medium before the surface fills the whole way.
                    let of_lane = |lane: usize, distance| transmittance_to_light(self.absorption[lane & 7], distance);
                    let distance = lanes.widen(incident.distance);
                    radiance = attenuated(lanes, &(radiance, distance), group.absorbed, of_lane);
                }
                self.counts.shadow_rays_skipped += u64::from((mask & !lit).count_ones());
                let (direction, end) = shadow_rays(lanes, light, shadow_origin);
                let time = times(lanes, &paths.rays, at, inputs.has_time);
                stream.push(lanes, lit, [shadow_origin, direction], (end, time), (radiance, paths.branch.vector(at)));
            }
        }
    }
}

/// Adds the background to the samples of paths that hit nothing.
#[inline(always)]
fn leave_scene<E: Element, L: LaneSet<Element = E>>(
    (lanes, inputs): (L, &RayTreeInputs<'_>),
    missed: u8,
    (paths, at): (&RayTreeStream<E>, usize),
    radiances: &mut [RadianceSample],
) {
    match inputs.appearance.background {
        Background::Constant(radiance) if is_in_range(radiance) => {
            let radiance = lanes.splat_rgb(radiance).scaled_by(lanes.load_vector(&paths.throughput, at));
            add_radiance(lanes, missed, radiance, false, paths.branch.vector(at), radiances);
        }
        ref background => {
            for lane in each_lane(missed) {
                let (ray, _) = paths.rays.get(at + lane);
                let radiance = paths.throughput(at + lane) * background.radiance(ray.direction);
                radiances[paths.branch.get(at + lane) as usize].radiance += radiance;
            }
        }
    }
}
