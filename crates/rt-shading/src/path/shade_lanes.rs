//! Shading of hits in lanes: emission, light samples, and the next rays.

use super::{
    gathered::Gathered,
    inputs::PathInputs,
    lane_bsdf::{BsdfLanes, SampledLanes},
    light_samples::LightSamples,
    path_stream::PathStream,
    ray_samples::RaySamples,
    wave::{GatherHits, PathWave, ShadeHits, SpawnedPaths},
};
use crate::{
    RadianceSample,
    bsdf::Scattering,
    lane_set::{Element, LaneSet, LaneStage},
    lanes::{LANES, each_lane, first_lanes, is_zero},
    optics,
    russian_roulette::survival_probability,
    wavefront::{
        delta_lights::{sample_li, shadow_rays},
        hit_points::HitPoints,
        shaded_surface::{ShadedSurface, ShadingNormals, offset, shadow_origins},
        streams::{add_radiance, append, times},
    },
};
use rt_math::{DVec3, Interval, Real, Rgb, Vector3};

/// Hits of some lanes.
struct Vertices<L: LaneSet> {
    /// Index of the first ray.
    at: usize,
    mask: u8,
    /// Those whose lobes are all delta distributions: light is not sampled.
    delta: u8,
    /// Those of rough glass, which light reaches from both sides.
    rough_glass: u8,
    points: HitPoints<L>,
    surface: ShadedSurface<L>,
    normals: ShadingNormals<L>,
    throughput: Vector3<L::F>,
    /// Times of the rays; `None` if all are 0.
    time: Option<L::D>,
}

/// Next rays of paths, without their origins.
struct NextRays<L: LaneSet> {
    direction: Vector3<L::D>,
    throughput: Vector3<L::F>,
    pdf: L::F,
    /// Normal for the sampling of lights at the vertex.
    normal: Vector3<L::F>,
    time: Option<L::D>,
}

impl<E: Element> LaneStage<E> for ShadeHits<'_, E> {
    #[inline(always)]
    fn run<L: LaneSet<Element = E>>(self, lanes: L) {
        let Self { spawned, inputs, gather, wave, samples, radiances } = self;
        spawned.shade((lanes, inputs), gather, (wave, samples), radiances);
    }
}

impl<E: Element> SpawnedPaths<E> {
    /// Shades those closest hits of a wave that are shaded in lanes.
    #[inline(always)]
    fn shade<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &PathInputs<'_>),
        gather: &GatherHits<'_, E>,
        (wave, samples): (&PathWave<'_, E>, &RaySamples),
        radiances: &mut [RadianceSample],
    ) {
        let &PathWave { paths, hits, bounces } = wave;
        let n_rays = paths.rays.len();
        let mut lobes = None;
        for at in (0..n_rays).step_by(L::N) {
            let used = first_lanes((n_rays - at).min(L::N));
            gather(at, used, &mut self.gathered);
            let mask = self.gathered.valid;
            if mask == 0 {
                continue;
            }
            if bounces == 0 {
                for lane in each_lane(mask) {
                    radiances[paths.sample.get(at + lane) as usize].hit = true;
                }
            }
            let points = HitPoints::on_shapes(lanes, &self.gathered.shapes, &paths.rays, hits, at);
            let surface = ShadedSurface::new(lanes, &points, mask);
            if inputs.features.emission && self.gathered.emissive != 0 {
                self.add_emission((lanes, inputs), wave, (at, &points, surface.inside), radiances);
            }
            let mut mask = mask & !self.gathered.emission_only;
            if mask == 0 {
                continue;
            }
            self.counts.lanes += L::N as u64;
            self.counts.lanes_used += u64::from(mask.count_ones());
            let mut throughput = lanes.load_vector(&paths.throughput, at);
            let glass = mask & self.gathered.bsdfs.glass.all;
            if glass != 0 {
                let (mut t, mut length) = ([0.0; LANES], [0.0; LANES]);
                lanes.store_f64(points.t, &mut t);
                lanes.store_f64(surface.length, &mut length);
                let hits = (&points, &t, &length);
                let visible = self.find_interfaces((lanes, inputs), wave, (at, glass, surface.inside), hits, radiances);
                mask = (mask & !glass) | visible;
                if mask == 0 {
                    continue;
                }
                let Gathered { absorbed, dimmed: [r, g, b], .. } = &self.gathered;
                if *absorbed != 0 {
                    let dimmed = Vector3::new(lanes.load(r), lanes.load(g), lanes.load(b));
                    throughput = Vector3::select(lanes.mask(*absorbed), dimmed, throughput);
                }
            }
            let smooth = mask & (self.gathered.shapes.smooth | self.gathered.shapes.surfaces);
            let mut normals = ShadingNormals::flat(&points, &surface);
            if smooth != 0 {
                normals.interpolate(lanes, (&points, &surface), &self.gathered.shapes, (hits, at), smooth);
            }
            let time = times(lanes, &paths.rays, at, inputs.has_time);
            let delta = mask & self.gathered.bsdfs.delta();
            let rough_glass = mask & self.gathered.bsdfs.glass.rough;
            let vertices = Vertices { at, mask, delta, rough_glass, points, surface, normals, throughput, time };
            let side = (vertices.normals.normal, vertices.surface.inside);
            let direction = vertices.surface.direction;
            let lobes = (inputs.follows_specular_only(), &mut lobes);
            let bsdf = BsdfLanes::new(lanes, &self.gathered.bsdfs, side, direction, lobes);
            if delta != mask {
                self.reflect_delta_lights((lanes, inputs), wave, (&vertices, &bsdf), radiances);
                if !inputs.lighting.lights.sampled_lights().is_empty() {
                    self.reflect_light((lanes, inputs), (wave, samples), (&vertices, &bsdf));
                }
            }
            self.scatter((lanes, inputs), (wave, samples), (&vertices, &bsdf));
        }
    }

    #[inline(never)]
    fn add_emission<L: LaneSet>(
        &mut self,
        (lanes, inputs): (L, &PathInputs<'_>),
        wave: &PathWave<'_, E>,
        (first, points, inside): (usize, &HitPoints<L>, u8),
        radiances: &mut [RadianceSample],
    ) {
        for lane in each_lane(self.gathered.emissive) {
            let Gathered { emission, lights, .. } = &self.gathered;
            let (emitted, light) = (emission[lane][usize::from(inside >> lane & 1)], lights[lane]);
            let at = first + lane;
            if emitted.is_black() || self.is_caustic(inputs, wave, at, light.is_some()) {
                continue;
            }
            let [on_light, _, light_normal] = points.get(lanes, lane);
            let weight = self.mis_weight_area(inputs, wave, at, light, (on_light, light_normal));
            let radiance = wave.paths.throughput(at) * emitted * weight;
            let radiance = inputs.settings.clamp.apply(wave.bounces, radiance, &mut self.counts);
            radiances[wave.paths.sample.get(at) as usize].radiance += radiance;
        }
    }

    /// Adds the light of all delta lights, or queues their shadow rays.
    #[inline(always)]
    fn reflect_delta_lights<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &PathInputs<'_>),
        wave: &PathWave<'_, E>,
        (vertices, bsdf): (&Vertices<L>, &BsdfLanes<'_, L>),
        radiances: &mut [RadianceSample],
    ) {
        let clamp = inputs.settings.clamp;
        let Vertices { at, points, throughput, time, .. } = vertices;
        let mask = vertices.mask & !vertices.delta;
        let samples = wave.paths.sample.vector(*at);
        let mut lights = inputs.lighting.lights.delta_lights();
        for stream in &mut self.delta.streams {
            for light in lights.by_ref().take(self.delta.lights_per_stream) {
                let zero = lanes.splat(0.0);
                let incident = sample_li(lanes, light, points, mask);
                let cos = vertices.cosines(lanes, incident.direction);
                // Cancels the 1/π of BSDFs for lights in classical units.
                let reflected = bsdf.reflected(incident.direction, cos, light.units.irradiance_factor());
                let mut radiance = reflected.scaled_by(*throughput).scaled_by(incident.strength);
                let lit =
                    lanes.bits(incident.is_lit & vertices.height(lanes, cos).gt(zero) & !is_zero(radiance)) & mask;
                let (shadow_origin, below) = vertices.shadow_origins(lanes, lit, cos);
                if light.casts_shadows {
                    let black = lanes.bits(incident.is_lit) & mask & !lit;
                    self.counts.shadow_rays_skipped += u64::from(black.count_ones());
                    if vertices.rough_glass & lit != 0 && inputs.features.absorption {
                        let distance = lanes.widen(incident.distance);
                        radiance =
                            self.gathered.attenuated(lanes, &(radiance, distance), vertices.rough_glass & lit, below);
                    }
                    let (direction, end) = shadow_rays(lanes, light, shadow_origin);
                    stream.push(lanes, lit, [shadow_origin, direction], (end, *time), (radiance, samples));
                } else if clamp.applies_after(wave.bounces + 1) {
                    let radiance = lanes.store_vector(radiance);
                    for lane in each_lane(lit) {
                        let [r, g, b] = [0, 1, 2].map(|c| radiance[c][lane].into());
                        radiances[samples[lane] as usize].radiance +=
                            clamp.apply(wave.bounces + 1, Rgb::new(r, g, b), &mut self.counts);
                    }
                } else {
                    add_radiance(lanes, lit, radiance, true, samples, radiances);
                }
            }
        }
    }

    /// Samples one of the area and environment lights, and queues the shadow rays.
    #[inline(always)]
    fn reflect_light<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &PathInputs<'_>),
        (wave, samples): (&PathWave<'_, E>, &RaySamples),
        (vertices, bsdf): (&Vertices<L>, &BsdfLanes<'_, L>),
    ) {
        let &Vertices { at, throughput, time, .. } = vertices;
        let mask = vertices.mask & !vertices.delta;
        // The origin of the next ray: its hit is weighted for this point.
        let from = (vertices.surface.near_origin, vertices.normals.normal);
        let LightSamples { lit, infinite, direction, target, weighted, pdf } =
            LightSamples::new(lanes, inputs.lighting.lights, from, (samples, at), (mask, vertices.rough_glass));
        let zero = lanes.splat(0.0);
        let direction = lanes.narrow_vector(direction);
        let cos = vertices.cosines(lanes, direction);
        let reflected = bsdf.reflected_mis(direction, cos, lanes.narrow(pdf));
        let mut radiance = reflected.scaled_by(throughput).scaled_by(lanes.narrow_vector(weighted));
        let lit = lanes.bits(vertices.height(lanes, cos).gt(zero) & !is_zero(reflected)) & lit & mask;
        self.counts.shadow_rays_skipped += u64::from((mask & !lit).count_ones());
        let (shadow_origin, below) = vertices.shadow_origins(lanes, lit, cos);
        let rough_glass = vertices.rough_glass & lit;
        if rough_glass != 0 && inputs.features.absorption {
            let distance = (target - vertices.points.point).length();
            radiance = self.gathered.attenuated(lanes, &(radiance, distance), rough_glass & !infinite, below);
        }
        let (mut to_light, mut end) = (target - shadow_origin, lanes.splat_f64(Interval::SEGMENT.max));
        if infinite != 0 {
            let infinite = lanes.mask_f64(infinite);
            to_light = Vector3::select(infinite, target, to_light);
            end = Real::select(infinite, lanes.splat_f64(Interval::SPAWNED.max), end);
        }
        let of_rays = wave.paths.sample.vector(at);
        self.sampled.push(lanes, lit, [shadow_origin, to_light], (end, time), (radiance, of_rays));
    }

    /// Samples the next direction of the paths.
    #[inline(always)]
    fn scatter<L: LaneSet<Element = E>>(
        &mut self,
        (lanes, inputs): (L, &PathInputs<'_>),
        (wave, samples): (&PathWave<'_, E>, &RaySamples),
        (vertices, bsdf): (&Vertices<L>, &BsdfLanes<'_, L>),
    ) {
        let &Vertices { at, mask, rough_glass, ref surface, ref normals, throughput, time, .. } = vertices;
        let mut normal = normals.normal;
        let [u, v] = &samples.indirect_u;
        let u = [lanes.load_f64(u.vector(at)), lanes.load_f64(v.vector(at))];
        let sampled = bsdf.sample(lanes.load_f64(samples.indirect_uc.vector(at)), u);
        let (mut direction, above) = bsdf.direction(&sampled);
        let SampledLanes { weight, mut pdf, valid, diffuse, delta, transmitted, eta, .. } = sampled;
        let zero = lanes.splat(0.0);
        let outside = direction.dot(surface.normal);
        let mut on_side = lanes.bits(outside.gt(zero));
        // In `f32`, the density must not be rounded to that of a delta direction.
        pdf = pdf.max(lanes.splat(f64::from(f32::MIN_POSITIVE)));
        if transmitted != 0 {
            on_side = (on_side & !transmitted) | (lanes.bits(outside.lt(zero)) & transmitted);
        }
        if delta & mask != 0 {
            pdf = Real::select(lanes.mask(delta), zero, pdf);
            let kept = self.specular_paths((wave, at), delta & mask & !on_side);
            if kept != 0 {
                let mirrored = optics::reflect_lanes(direction, surface.normal);
                direction = Vector3::select(lanes.mask(kept), mirrored, direction);
                on_side |= kept;
            }
        }
        let mut continued = mask & valid & above & on_side;
        let mut ends = if inputs.follows_specular_only() { diffuse } else { 0 };
        if wave.bounces >= inputs.settings.max_depth {
            ends = !0;
        }
        if !inputs.scene_emits() {
            self.counts.depth_limited += u64::from((continued & ends).count_ones());
            continued &= !ends;
        }
        if continued == 0 {
            return;
        }
        let mut after = throughput.scaled_by(weight);
        let mut alive = continued & !lanes.bits(is_zero(after));
        if inputs.uses_russian_roulette(wave.bounces) {
            let mut eta_scale = self.eta_scales(lanes, inputs, (wave, at), mask);
            if transmitted != 0 {
                eta_scale = eta_scale * (eta * eta);
            }
            let survival = survival_probability(after.x.max(after.y).max(after.z), eta_scale);
            let u = lanes.load_f64(samples.indirect_rr.vector(at));
            alive &= lanes.bits_f64(u.lt(lanes.widen(survival)));
            after = after / survival;
        }
        let direction = lanes.widen_vector(direction);
        let of_rays = wave.paths.sample.vector(at);
        if rough_glass != 0 {
            normal = Vector3::select(lanes.mask(rough_glass), Vector3::new(zero, zero, zero), normal);
        }
        let rays = &NextRays { direction, throughput: after, pdf, normal, time };
        let (origin, reflected) = (surface.near_origin, alive & !diffuse & !transmitted);
        for (mask, next) in [(alive & diffuse, &mut self.paths.diffuse), (reflected, &mut self.paths.reflected)] {
            if mask != 0 {
                next.push_lanes(lanes, mask, origin, rays, of_rays);
            }
        }
        if alive & transmitted != 0 {
            let points = &vertices.points;
            let is_inside = lanes.mask_f64(surface.inside);
            let behind = Vector3::select(is_inside, points.outside, -points.outside);
            let mask = alive & transmitted;
            let origin = offset(lanes, points, (points.point, behind), mask);
            self.paths.refracted.push_lanes(lanes, mask, origin, rays, of_rays);
        }
        if inputs.materials.track_states {
            let mut etas = [E::rounded(1.0); LANES];
            if transmitted != 0 {
                lanes.store(eta, &mut etas);
            }
            self.update_states(alive, [ends, delta, transmitted], (of_rays, &etas), wave.bounces);
            let behind = alive & transmitted & rough_glass;
            if behind != 0 {
                // The rays start behind the points from which lights were sampled.
                let points = lanes.store_point(surface.near_origin);
                for lane in each_lane(behind) {
                    let point = DVec3::new(points[0][lane], points[1][lane], points[2][lane]);
                    self.states[of_rays[lane] as usize].vertex = Some(point);
                }
            }
        }
    }

    /// Lanes of a mask whose paths keep a delta direction on its side of the surface: their first bounce was specular, or is this one. See [`ViewedSurface::continued`](crate::viewed_surface::ViewedSurface::continued).
    fn specular_paths(&self, (wave, at): (&PathWave<'_, E>, usize), mask: u8) -> u8 {
        let mut specular = 0;
        for lane in each_lane(mask) {
            let state = &self.states[wave.paths.sample.get(at + lane) as usize];
            specular |= u8::from(!state.first_bounce_nonspecular) << lane;
        }
        specular
    }

    /// Squared relative indices of refraction that the paths of some lanes have collected.
    #[inline(always)]
    fn eta_scales<L: LaneSet<Element = E>>(
        &self,
        lanes: L,
        inputs: &PathInputs<'_>,
        (wave, at): (&PathWave<'_, E>, usize),
        mask: u8,
    ) -> L::F {
        if !inputs.materials.track_states {
            return lanes.splat(1.0);
        }
        let mut scales = [E::rounded(1.0); LANES];
        for lane in each_lane(mask) {
            scales[lane] = E::rounded(self.states[wave.paths.sample.get(at + lane) as usize].eta_scale);
        }
        lanes.load(&scales)
    }

    /// Updates the states of paths that a reflection has continued.
    #[inline(never)]
    fn update_states(
        &mut self,
        alive: u8,
        [ends, delta, transmitted]: [u8; 3],
        (samples, etas): (&[u32; LANES], &[E; LANES]),
        bounces: u32,
    ) {
        for lane in each_lane(alive) {
            let state = &mut self.states[samples[lane] as usize];
            state.first_bounce_nonspecular |= bounces == 0 && delta >> lane & 1 == 0;
            state.emission_only = ends >> lane & 1 == 1;
            state.vertex = None;
            if transmitted >> lane & 1 == 1 {
                let eta: f64 = etas[lane].into();
                state.eta_scale *= eta * eta;
                state.medium_tracker.scatter(self.gathered.interfaces[lane].as_ref(), Scattering::Transmission);
            } else {
                state.medium_tracker.scatter(None, Scattering::Reflection);
            }
        }
    }
}

impl<E: Element> PathStream<E> {
    /// Appends the next rays of some lanes, with the samples of all lanes.
    #[inline(always)]
    fn push_lanes<L: LaneSet<Element = E>>(
        &mut self,
        lanes: L,
        mask: u8,
        origin: Vector3<L::D>,
        next: &NextRays<L>,
        samples: &[u32; LANES],
    ) {
        let end = self.rays.len();
        let rays = [origin, next.direction];
        append(lanes, &mut self.rays, mask, rays, (lanes.splat_f64(Interval::SPAWNED.max), next.time));
        lanes.compress_vector(next.throughput, mask, &mut self.throughput, end);
        lanes.compress(next.pdf, mask, self.pdf.vector_mut(end));
        lanes.compress_vector(next.normal, mask, &mut self.normal, end);
        lanes.compress_u32(samples, mask, self.sample.vector_mut(end));
    }
}

impl<L: LaneSet> Vertices<L> {
    /// Cosines of directions to the normals. Where interpolated and geometric normal disagree about the side of a direction, they are 0.
    #[inline(always)]
    fn cosines(&self, lanes: L, direction: Vector3<L::F>) -> L::F {
        let cos = self.normals.normal.dot(direction);
        if self.normals.smooth == 0 {
            return cos;
        }
        let zero = lanes.splat(0.0);
        let outside = self.surface.normal.dot(direction);
        let mut agrees = outside.gt(zero);
        if self.rough_glass != 0 {
            let agrees_on_side = (agrees & !cos.lt(zero)) | (outside.lt(zero) & cos.lt(zero));
            agrees = (lanes.mask(self.rough_glass) & agrees_on_side) | (agrees & !lanes.mask(self.rough_glass));
        }
        Real::select(agrees, cos, zero)
    }

    /// Origins of shadow rays to lights in directions with these cosines. They lie behind the surface in the lanes that are returned.
    #[inline(always)]
    fn shadow_origins(&self, lanes: L, lit: u8, cos: L::F) -> (Vector3<L::D>, u8) {
        let in_front = self.normals.shadow_origin;
        if self.rough_glass & lit == 0 {
            return (in_front, 0);
        }
        let behind = self.rough_glass & lit & lanes.bits(cos.lt(lanes.splat(0.0)));
        if behind == 0 {
            return (in_front, 0);
        }
        let of_points = &[self.normals.shadow_point, in_front];
        (shadow_origins_behind(lanes, &self.points, of_points, (self.surface.inside, behind)), behind)
    }

    /// Cosines, without their sign where light comes from both sides.
    #[inline(always)]
    fn height(&self, lanes: L, cos: L::F) -> L::F {
        if self.rough_glass == 0 { cos } else { Real::select(lanes.mask(self.rough_glass), cos.abs(), cos) }
    }
}

/// Origins of shadow rays, which start behind the surface in the lanes of a mask. Given are points on the smooth surface and the origins on
/// the viewer's side.
#[inline(never)]
fn shadow_origins_behind<L: LaneSet>(
    lanes: L,
    points: &HitPoints<L>,
    [shadow_point, in_front]: &[Vector3<L::D>; 2],
    (inside, behind): (u8, u8),
) -> Vector3<L::D> {
    lanes.vectorize(
        #[inline(always)]
        || {
            let is_inside = lanes.mask_f64(inside);
            let outwards = Vector3::select(is_inside, points.outside, -points.outside);
            let origin = shadow_origins(lanes, points, (*shadow_point, outwards), behind);
            Vector3::select(lanes.mask_f64(behind), origin, *in_front)
        },
    )
}
