//! Shading of hits in lanes: emission, direct light, and secondary rays.

use super::{
    inputs::TreeInputs,
    lane_phong::UniformPhong,
    ray_tree::TreePath,
    streams::TreeStream,
    wave::{SpawnedRays, TreeElement, TreeWave},
};
use crate::{
    Background, LaneLevel, RadianceSample, SurfaceHit,
    hit_context::SurfaceTransmission,
    interior_list::{MediumEntry, MediumInterface},
    lane_set::{Element, Float64Lane, LaneSet, OneLane, SimdLanes},
    lanes::{LANES, dispatch, each_lane, first_lanes, is_zero},
    medium::absorb,
    optics,
    stream_queries::{StreamPrimitive, StreamQueries, StreamShape},
    wavefront::{
        delta_lights::{sample_li, shadow_rays},
        hit_points::HitPoints,
        is_in_range,
        shaded_surface::{ShadedSurface, ShadingNormals, offset},
        streams::{add_radiance, append},
    },
};
use fearless_simd::Simd as _;
use rt_geometry::HitStream;
use rt_math::{Interval, Ray, Real, Rgb, Vector3};

/// Hits of some lanes on surfaces with one Phong model.
struct Group<'a, L: LaneSet> {
    phong: &'a UniformPhong,
    material: u32,
    /// Index of the object of each lane.
    objects: &'a [u32; LANES],
    points: &'a HitPoints<L>,
    surface: &'a ShadedSurface<L>,
    normals: &'a ShadingNormals<L>,
    /// Index of the first ray.
    at: usize,
    /// Lanes that hit, and whose surface is visible.
    mask: u8,
    /// Weights of the radiance in the pixel, after absorption.
    weight: Vector3<L::F>,
    /// Lanes whose surface transmits light.
    transmits: u8,
    /// Index of refraction before the surface divided by that behind it; 1 where no light is transmitted.
    eta: L::F,
}

impl TreeElement for f32 {
    fn shade<W: StreamQueries>(
        spawned: &mut SpawnedRays<Self>,
        level: Option<LaneLevel>,
        inputs: &TreeInputs<'_>,
        world: &W,
        wave: TreeWave<'_, Self>,
        seen: &mut [RadianceSample],
    ) {
        match level {
            Some(level) => dispatch!(level, simd => simd.vectorize(
                #[inline(always)]
                || spawned.shade((SimdLanes(simd), inputs), world, wave, seen),
            )),
            None => spawned.shade((OneLane::new(), inputs), world, wave, seen),
        }
    }
}

impl TreeElement for f64 {
    fn shade<W: StreamQueries>(
        spawned: &mut SpawnedRays<Self>,
        _: Option<LaneLevel>,
        inputs: &TreeInputs<'_>,
        world: &W,
        wave: TreeWave<'_, Self>,
        seen: &mut [RadianceSample],
    ) {
        spawned.shade((Float64Lane::new(), inputs), world, wave, seen);
    }
}

impl<E: Element> SpawnedRays<E> {
    /// Shades those closest hits of a wave that are shaded in lanes, and adds the background to the samples of rays without a hit.
    #[inline(always)]
    fn shade<W: StreamQueries, L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        world: &W,
        (paths, hits): TreeWave<'_, E>,
        seen: &mut [RadianceSample],
    ) {
        for at in (0..paths.len()).step_by(L::N) {
            let used = first_lanes((paths.len() - at).min(L::N));
            let [instances, indices] = [hits.instance.vector(at), hits.primitive.vector(at)];
            let missed = lanes.equal(indices, HitStream::NONE) & used;
            if missed != 0 {
                self.leave_scene((lanes, inputs), missed, (paths, at), seen);
            }
            let mut rest = self.in_lanes.bits(at) & used & !missed;
            while let Some(first) = each_lane(rest).next() {
                let Some(primitive) = world.primitive(hits, at + first) else { break };
                let Some(model) = inputs.phongs.get(primitive.material) else { break };
                let is_triangle = matches!(primitive.shape, StreamShape::Triangle(_) | StreamShape::MeshTriangle(..));
                if is_triangle && !model.is_checkered() {
                    let phong = (model.square(0), primitive.material);
                    rest &= !self.shade_triangles((lanes, inputs), world, (paths, hits), (at, rest), phong, seen);
                    continue;
                }
                let mask = lanes.equal(indices, indices[first]) & lanes.equal(instances, instances[first]) & rest;
                rest &= !mask;
                let points = &HitPoints::new(lanes, &primitive.shape, &paths.rays, hits, at);
                let surface = &ShadedSurface::new(lanes, points, mask);
                let normals = &ShadingNormals::flat(surface);
                let mut odd = 0;
                if model.is_checkered() {
                    let vertex_uvs = || world.vertex_uvs(hits, at + first);
                    odd = mask & points.odd_squares(lanes, (&primitive.shape, vertex_uvs), (hits, at), model.side);
                }
                for (mask, square) in [(mask & !odd, 0), (odd, 1)] {
                    if mask != 0 {
                        let phong = (model.square(square), primitive.material);
                        let objects = &[primitive.object; LANES];
                        let group = Group::new(lanes, phong, (points, surface, normals), objects, (paths, at, mask));
                        self.shade_group((lanes, inputs), group, paths, seen);
                    }
                }
            }
        }
    }

    /// Shades the hits of some lanes, from index `at` on, on triangles of a material with this model. Returns their lanes.
    #[inline(never)]
    fn shade_triangles<W: StreamQueries, L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        world: &W,
        (paths, hits): TreeWave<'_, E>,
        (at, mask): (usize, u8),
        (phong, material): (&UniformPhong, u32),
        seen: &mut [RadianceSample],
    ) -> u8 {
        lanes.vectorize(
            #[inline(always)]
            || {
                let mut objects = [0; LANES];
                let mask = self.gather_triangles(world, (hits, at, mask), material, &mut objects);
                let points = &HitPoints::on_shapes(lanes, &self.gathered, &paths.rays, hits, at);
                let surface = &ShadedSurface::new(lanes, points, mask);
                let mut normals = ShadingNormals::flat(surface);
                let smooth = mask & self.gathered.smooth;
                if smooth != 0 {
                    normals.interpolate(lanes, (points, surface), &self.gathered, (hits, at), smooth);
                }
                let surfaces = (points, surface, &normals);
                let group = Group::new(lanes, (phong, material), surfaces, &objects, (paths, at, mask));
                self.shade_group((lanes, inputs), group, paths, seen);
                mask
            },
        )
    }

    /// Gathers the triangles of a material that the rays of a mask have hit, from index `at` on, and returns their lanes.
    #[inline(never)]
    fn gather_triangles<W: StreamQueries>(
        &mut self,
        world: &W,
        (hits, at, mask): (&HitStream, usize, u8),
        material: u32,
        objects: &mut [u32; LANES],
    ) -> u8 {
        self.gathered.clear();
        let mut gathered = 0;
        for lane in each_lane(mask) {
            let Some(primitive) = world.primitive(hits, at + lane) else { continue };
            let StreamPrimitive { shape, object, .. } = primitive;
            let is_triangle = matches!(shape, StreamShape::Triangle(_) | StreamShape::MeshTriangle(..));
            if is_triangle && primitive.material == material {
                self.gathered.set(lane, &shape);
                objects[lane % LANES] = object;
                gathered |= 1 << lane;
            }
        }
        gathered
    }

    #[inline(always)]
    fn shade_group<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        mut group: Group<'_, L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        if inputs.settings.features.refraction {
            self.find_interfaces((lanes, inputs), &mut group, paths, seen);
            if group.mask == 0 {
                return;
            }
        }
        self.counts.lanes += L::N as u64;
        self.counts.lanes_used += u64::from(group.mask.count_ones());
        self.add_emission(lanes, &group, paths, seen);
        self.sample_lights((lanes, inputs), &group, paths, seen);
        self.spawn_rays((lanes, inputs), &group, paths);
    }

    /// Adds the background to the samples of paths that hit nothing, and ends the paths.
    #[inline(always)]
    fn leave_scene<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        missed: u8,
        (paths, at): (&TreeStream<E>, usize),
        seen: &mut [RadianceSample],
    ) {
        match inputs.appearance.background {
            Background::Constant(radiance) if is_in_range(radiance) => {
                let radiance = lanes.splat_rgb(radiance).scaled_by(lanes.load_vector(&paths.weight, at));
                add_radiance(lanes, missed, radiance, false, paths.sample.vector(at), seen);
            }
            ref background => {
                for lane in each_lane(missed) {
                    let (ray, _) = paths.rays.get(at + lane);
                    let radiance = paths.weight(at + lane) * background.radiance(ray.direction);
                    seen[paths.sample.get(at + lane) as usize].radiance += radiance;
                }
            }
        }
        if inputs.settings.features.refraction {
            for lane in each_lane(missed) {
                self.ended.push(paths.sample.get(at + lane));
            }
        }
    }

    /// Finds the media on both sides of hits, and applies absorption. At invisible interfaces, paths go on behind the surface.
    #[inline(always)]
    fn find_interfaces<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        group: &mut Group<'_, L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        let &TreeInputs { settings, appearance, .. } = inputs;
        let transmission = group.phong.interface;
        if transmission == SurfaceTransmission::None && !settings.features.absorption {
            return;
        }
        let (materials, surface) = (&appearance.materials, group.surface);
        let Some(material) = materials.get(group.material as usize) else { return };
        let (mut t, mut length) = ([0.0; 8], [0.0; 8]);
        lanes.store_f64(group.points.t, &mut t);
        lanes.store_f64(surface.length, &mut length);
        let (mut eta, mut weight) = ([E::rounded(1.0); 8], [[E::default(); 8]; 3]);
        let mut is_absorbed = false;
        for lane in each_lane(group.mask) {
            let at = group.at + lane;
            let tree = &mut self.trees[paths.sample.get(at) as usize];
            if transmission == SurfaceTransmission::None && tree.interior.is_empty() {
                continue;
            }
            let is_inside = surface.inside >> lane & 1 == 1;
            let interface = transmission.interface(&mut tree.interior, materials, group.body(lane), is_inside);
            let interface = interface.as_ref();
            let way = (t[lane] - tree.start) * length[lane];
            if !transmission.is_visible(material, interface) {
                group.mask &= !(1 << lane);
                let (at, body) = (group.at + lane, group.body(lane));
                let interaction = group.points.surface(lanes, lane);
                let hit =
                    SurfaceHit { t: t[lane], interaction, object: body.object, material: body.material, light: None };
                self.skip_interface_of_ray(inputs, (paths, at), &hit, (interface, way), seen);
                continue;
            }
            if settings.features.absorption {
                let around = interface.map_or_else(|| tree.interior.medium(materials), |c| c.before);
                let mut absorbed = paths.weight(at);
                if absorb(&mut absorbed, around.absorption, way) {
                    self.counts.absorption += 1;
                    if !core::mem::replace(&mut is_absorbed, true) {
                        lanes.store(group.weight.x, &mut weight[0]);
                        lanes.store(group.weight.y, &mut weight[1]);
                        lanes.store(group.weight.z, &mut weight[2]);
                    }
                    for (weight, absorbed) in weight.iter_mut().zip(absorbed.to_array()) {
                        weight[lane] = E::rounded(absorbed);
                    }
                }
            }
            if let Some(interface) = interface.filter(|_| group.phong.transmission.is_some()) {
                eta[lane] = E::rounded(interface.before.ior / interface.after.ior);
                group.transmits |= 1 << lane;
            }
        }
        group.eta = lanes.load(&eta);
        if is_absorbed {
            let [r, g, b] = &weight;
            group.weight = Vector3::new(lanes.load(r), lanes.load(g), lanes.load(b));
        }
    }

    /// Continues a ray of a stream behind a null interface.
    #[inline(never)]
    fn skip_interface_of_ray(
        &mut self,
        inputs: &TreeInputs<'_>,
        (paths, at): (&TreeStream<E>, usize),
        hit: &SurfaceHit,
        interface: (Option<&MediumInterface>, f64),
        seen: &mut [RadianceSample],
    ) {
        let (path, (ray, _)) = (paths.get(at), paths.rays.get(at));
        let seen = &mut seen[path.sample as usize];
        self.skip_interface(inputs, (&ray, path), hit, interface, seen);
    }

    /// Adds emission and reflected ambient light.
    #[inline(always)]
    fn add_emission<L: LaneSet<Element = E>>(
        &self,
        lanes: L,
        group: &Group<'_, L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        let inside = group.surface.inside;
        for (mask, side) in [(group.mask & !inside, 0), (group.mask & inside, 1)] {
            if mask != 0 {
                let radiance = group.phong.radiance_from(side);
                add_radiance(
                    lanes,
                    mask,
                    lanes.splat_rgb(radiance).scaled_by(group.weight),
                    true,
                    paths.sample.vector(group.at),
                    seen,
                );
            }
        }
    }

    /// Adds the light of all delta lights, or queues their shadow rays.
    #[inline(always)]
    fn sample_lights<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        group: &Group<'_, L>,
        paths: &TreeStream<E>,
        seen: &mut [RadianceSample],
    ) {
        let &TreeInputs { settings, appearance, .. } = inputs;
        let &Group { phong, points, surface, normals, at, mask, .. } = group;
        let (direction, &ShadingNormals { normal, shadow_origin, .. }) = (surface.direction, normals);
        let zero = lanes.splat(0.0);
        let has_highlight = phong.specular != Rgb::BLACK;
        for (light, stream) in appearance.lights.iter().zip(&mut self.lights) {
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
            let radiance = radiance.scaled_by(group.weight);
            if !shadowed {
                add_radiance(lanes, lit, radiance, true, paths.sample.vector(at), seen);
                continue;
            }
            self.counts.shadow_rays_skipped += u64::from((mask & !lit).count_ones());
            let (direction, end) = shadow_rays(lanes, light, shadow_origin);
            let time = inputs.times(lanes, paths, at);
            stream.push(lanes, lit, [shadow_origin, direction], (end, time), (radiance, paths.sample.vector(at)));
        }
    }

    /// Spawns the mirrored and the refracted rays. Of two rays, the refracted one is deferred.
    #[inline(always)]
    fn spawn_rays<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &TreeInputs<'_>),
        group: &Group<'_, L>,
        paths: &TreeStream<E>,
    ) {
        let settings = inputs.settings;
        let &Group { phong, surface, normals, at, mask, weight, transmits, eta, .. } = group;
        let &ShadedSurface { normal: towards_viewer, direction, near_origin, .. } = surface;
        let normal = normals.normal;
        let features = &settings.features;
        let count = |mask: u8| u64::from(mask.count_ones());
        let is_specular = phong.mirror != Rgb::BLACK;
        let mut continues = 0;
        for (lane, depth) in paths.depth.vector(at).iter().enumerate() {
            continues |= u8::from(*depth < settings.max_depth) << lane;
        }
        let continues = continues & mask;
        self.counts.depth_limited += count(if is_specular { mask & !continues } else { transmits & mask & !continues });
        self.counts.mirrors += if features.reflection { count(continues) } else { 0 };
        let transmits = transmits & continues;
        let mut reflected_part = lanes.splat(1.0);
        let mut refracted = None;
        if transmits != 0 {
            self.counts.refractions += count(transmits);
            let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
            let has_fresnel = phong.transmission.is_some_and(|(_, has_fresnel)| has_fresnel);
            // An index-matched interface does not deflect or reflect the ray.
            let is_null = eta.eq(one);
            if features.fresnel && has_fresnel {
                self.counts.fresnel += count(transmits);
                let reflectance = Real::select(is_null, zero, optics::fresnel(-direction.dot(normal), eta));
                reflected_part = Real::select(lanes.mask(transmits), reflectance, one);
            }
            let passed_part = if has_fresnel { one - reflected_part } else { one };
            let weight = weight.scaled_by(lanes.splat_rgb(phong.transmission_coefficient())) * passed_part;
            let significant = transmits & lanes.bits(is_significant(weight, settings.min_contribution));
            if significant != 0 {
                let sin_i = direction.cross(normal).length();
                let (bent, is_transmitted) = optics::refract_lanes(direction, normal, eta, sin_i);
                let turns_back = bent.dot(-towards_viewer).lt(zero);
                let bent = Vector3::select(turns_back, optics::reflect_lanes(bent, -towards_viewer), bent);
                let bent = Vector3::select(is_null, direction, bent);
                let mask = significant & lanes.bits(is_transmitted | is_null);
                refracted = (mask != 0).then_some((mask, bent, weight));
            }
        }
        let mut mirrored = 0;
        if features.reflection && is_specular && continues != 0 {
            let weight = weight.scaled_by(lanes.splat_rgb(phong.mirror)) * reflected_part;
            mirrored = continues & lanes.bits(is_significant(weight, settings.min_contribution));
            if mirrored != 0 {
                let bent = optics::reflect_lanes(direction, normal);
                let zero = lanes.splat(0.0);
                let turns_back = bent.dot(towards_viewer).lt(zero);
                let bent = Vector3::select(turns_back, optics::reflect_lanes(bent, towards_viewer), bent);
                let next = &mut self.reflected;
                let end = next.len();
                let rays = [near_origin, lanes.widen_vector(bent)];
                let time = inputs.times(lanes, paths, at);
                append(lanes, &mut next.rays, mirrored, rays, (lanes.splat_f64(f64::INFINITY), time));
                lanes.compress_vector(weight, mirrored, &mut next.weight, end);
                let mut depth = *paths.depth.vector(at);
                depth.iter_mut().for_each(|depth| *depth = depth.wrapping_add(1));
                lanes.compress_u32(&depth, mirrored, next.depth.vector_mut(end));
                lanes.compress_u32(paths.sample.vector(at), mirrored, next.sample.vector_mut(end));
            }
        }
        let mut refracts = 0;
        if let Some((mask, bent, weight)) = refracted {
            refracts = mask;
            self.push_refracted(lanes, group, (mask, mirrored), [bent, weight], paths);
        }
        if features.refraction {
            for lane in each_lane(mask) {
                let sample = paths.sample.get(at + lane);
                let tree = &mut self.trees[sample as usize];
                tree.bounce();
                if (mirrored | refracts) >> lane & 1 == 0 {
                    self.end_path(inputs, sample);
                }
            }
        }
    }

    /// Defers the refracted rays of lanes that have mirrored rays as well, and continues with those of the other lanes.
    #[inline(always)]
    fn push_refracted<L: LaneSet<Element = E>>(
        &mut self,
        lanes: L,
        group: &Group<'_, L>,
        (mask, mirrored): (u8, u8),
        [directions, weights]: [Vector3<L::F>; 2],
        paths: &TreeStream<E>,
    ) {
        let points = group.points;
        let directions = lanes.widen_vector(directions);
        let outwards =
            Vector3::select(directions.dot(points.outside).lt(lanes.splat_f64(0.0)), -points.outside, points.outside);
        let origins = lanes.store_point(offset(lanes, points, (points.point, outwards), mask));
        let weights = lanes.store_point(lanes.widen_vector(weights));
        let directions = lanes.store_point(directions);
        for lane in each_lane(mask) {
            let at = group.at + lane;
            let sample = paths.sample.get(at);
            let tree = &mut self.trees[sample as usize];
            let is_inside = group.surface.inside >> lane & 1 == 1;
            let event = group.phong.interface.event(&mut tree.interior, group.body(lane), is_inside);
            let of_lane = |[x, y, z]: &[[f64; 8]; 3]| [x[lane & 7], y[lane & 7], z[lane & 7]];
            let time = paths.rays.time.get(at);
            let ray = Ray { origin: of_lane(&origins).into(), direction: of_lane(&directions).into(), time };
            let weight = of_lane(&weights).into();
            let path = TreePath { sample, depth: paths.depth.get(at) + 1, weight };
            if mirrored >> lane & 1 == 1 {
                tree.defer(ray, &path, event);
            } else {
                tree.interior.apply(event);
                self.refracted.push(&ray, Interval::SPAWNED, &path);
            }
        }
    }
}

impl TreeInputs<'_> {
    /// Times of rays; `None` if all are 0.
    #[inline(always)]
    fn times<L: LaneSet>(&self, lanes: L, paths: &TreeStream<L::Element>, at: usize) -> Option<L::D> {
        if self.has_time { Some(lanes.load_f64(paths.rays.time.vector(at))) } else { None }
    }
}

impl<'a, L: LaneSet> Group<'a, L> {
    /// Hits of a mask of lanes, from the ray `at` on.
    #[inline(always)]
    fn new(
        lanes: L,
        (phong, material): (&'a UniformPhong, u32),
        (points, surface, normals): (&'a HitPoints<L>, &'a ShadedSurface<L>, &'a ShadingNormals<L>),
        objects: &'a [u32; LANES],
        (paths, at, mask): (&TreeStream<L::Element>, usize, u8),
    ) -> Self {
        let (weight, eta) = (lanes.load_vector(&paths.weight, at), lanes.splat(1.0));
        Self { phong, material, objects, points, surface, normals, at, mask, weight, transmits: 0, eta }
    }

    const fn body(&self, lane: usize) -> MediumEntry {
        MediumEntry { object: self.objects[lane % LANES], material: self.material }
    }
}

/// True for weights that are visible in the pixel.
#[inline(always)]
fn is_significant<R: Real>(weight: Vector3<R>, min_contribution: f64) -> R::Mask {
    !weight.x.max(weight.y).max(weight.z).lt(weight.x.splat(min_contribution)) & !is_zero(weight)
}
