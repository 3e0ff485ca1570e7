//! Shading of a wave in lanes: emission, light samples, and the next rays.

use super::{GatherHits, PathShading, PathStream, PathWave, SpawnedPaths, gathered::Gathered};
use crate::{
    RadianceSample,
    bsdf::cosine_hemisphere_lanes,
    lane_set::{Element, LaneSet},
    lanes::{LANES, each_lane, first_lanes, is_zero},
    light::Light,
    mis::power_heuristic,
    russian_roulette::survival_probability,
    wavefront::{
        delta_lights::{sample_li, shadow_rays},
        gathered_shapes::GatheredShapes,
        hit_points::HitPoints,
        shaded_surface::{ShadedSurface, offset},
        streams::{add_radiance, append},
    },
};
use core::f64::consts::FRAC_1_PI;
use rt_geometry::{HitStream, SmoothPoint};
use rt_math::{DVec3, Interval, Mask, Real, Rgb, Vector3, tangents};

/// Hits of some lanes.
struct Vertices<L: LaneSet> {
    /// Index of the first ray.
    at: usize,
    mask: u8,
    points: HitPoints<L>,
    surface: ShadedSurface<L>,
    /// Unit normals that are shaded with, on the viewer's side.
    normal: Vector3<L::F>,
    /// Lanes in which these are interpolated.
    smooth: u8,
    shadow_origin: Vector3<L::D>,
    albedo: Vector3<L::F>,
    throughput: Vector3<L::F>,
}

/// Samples of one of the area and environment lights, one for each lane.
struct LightSamples<L: LaneSet> {
    /// Lanes that a light reaches. Other numbers are not valid elsewhere.
    lit: u8,
    /// Lanes whose light is at infinity.
    infinite: u8,
    /// Unit vectors towards the light.
    direction: Vector3<L::D>,
    /// Ends of the shadow rays, or their directions to a light at infinity.
    target: Vector3<L::D>,
    /// Radiance divided by the density of the direction.
    weighted: Vector3<L::D>,
    /// Densities per unit solid angle.
    pdf: L::D,
}

impl<E: Element> SpawnedPaths<E> {
    /// Shades the closest hits of a wave.
    #[inline(always)]
    pub(super) fn shade<L: LaneSet<Element = E>>(
        &mut self,
        shade: &PathShading<'_, L>,
        gather: &GatherHits<'_>,
        wave: &PathWave<'_, E>,
        seen: &mut [RadianceSample],
    ) {
        let &PathShading { lanes, features, .. } = shade;
        let &PathWave { paths, hits, .. } = wave;
        let n_rays = paths.rays.len();
        for at in (0..n_rays).step_by(L::N) {
            let used = first_lanes((n_rays - at).min(L::N));
            let missed = lanes.equal(hits.primitive.vector(at), HitStream::NONE) & used;
            if missed != 0 {
                self.add_background(shade, wave, (at, missed), seen);
            }
            let hit = used & !missed;
            if hit == 0 {
                continue;
            }
            if wave.bounces == 0 {
                for lane in each_lane(hit) {
                    seen[paths.sample.get(at + lane) as usize].hit = true;
                }
            }
            gather(at, hit, &mut self.gathered);
            let mask = self.gathered.valid;
            let points = HitPoints::on_shapes(lanes, &self.gathered.shapes, &paths.rays, hits, at);
            let surface = ShadedSurface::new(lanes, &points, mask);
            if features.emission && self.gathered.emissive != 0 {
                self.add_emission(shade, wave, (at, &points, surface.inside), seen);
            }
            if wave.emission_only || mask == 0 {
                continue;
            }
            self.counts.lanes += L::N as u64;
            self.counts.lanes_used += u64::from(mask.count_ones());
            let albedo = lanes.narrow_vector(lanes.load_coordinates(&self.gathered.albedo));
            let throughput = lanes.load_vector(&paths.throughput, at);
            let smooth = mask & self.gathered.shapes.smooth;
            let (normal, shadow_origin) = (surface.normal, surface.near_origin);
            let mut vertices =
                Vertices { at, mask, points, surface, normal, smooth, shadow_origin, albedo, throughput };
            if smooth != 0 {
                vertices.interpolate_normals(lanes, &self.gathered.shapes, hits);
            }
            self.sample_delta_lights(shade, wave, &vertices, seen);
            if !shade.lighting.lights.sampled_lights().is_empty() {
                self.sample_light(shade, wave, &vertices);
            }
            self.scatter(shade, wave, &vertices);
        }
    }

    /// Adds the background to the samples of paths that hit nothing.
    #[inline(never)]
    fn add_background<L>(
        &mut self,
        shade: &PathShading<'_, L>,
        wave: &PathWave<'_, E>,
        (at, missed): (usize, u8),
        seen: &mut [RadianceSample],
    ) {
        let (background, lights) = (&shade.lighting.appearance.background, shade.lighting.lights);
        if background.is_black() {
            return;
        }
        for at in each_lane(missed).map(|lane| at + lane) {
            let (ray, _) = wave.paths.rays.get(at);
            let (throughput, mut weight) = (wave.paths.throughput(at), 1.0);
            if wave.bounces > 0 && lights.environment().is_some() {
                let (point, normal, pdf) = wave.paths.vertex(at);
                weight = power_heuristic(pdf, lights.pdf_li_environment(point, Some(normal), ray.direction));
            }
            let radiance = throughput * weight * background.radiance(ray.direction);
            let radiance = shade.settings.clamp.apply(wave.bounces, radiance, &mut self.counts);
            seen[wave.paths.sample.get(at) as usize].radiance += radiance;
        }
    }

    /// Adds the emission of surfaces.
    #[inline(never)]
    fn add_emission<L: LaneSet>(
        &mut self,
        shade: &PathShading<'_, L>,
        wave: &PathWave<'_, E>,
        (first, points, inside): (usize, &HitPoints<L>, u8),
        seen: &mut [RadianceSample],
    ) {
        let Gathered { emissive, emission, lights, .. } = &self.gathered;
        for lane in each_lane(*emissive) {
            let emitted = emission[lane][usize::from(inside >> lane & 1)];
            if emitted.is_black() {
                continue;
            }
            let at = first + lane;
            let mut weight = 1.0;
            if let Some(light) = lights[lane]
                && wave.bounces > 0
            {
                let (point, normal, pdf) = wave.paths.vertex(at);
                let [on_light, _, light_normal] = points.get(shade.lanes, lane);
                let light_pdf = shade.lighting.lights.pdf_li(point, Some(normal), light, on_light, light_normal);
                weight = power_heuristic(pdf, light_pdf);
            }
            let radiance = wave.paths.throughput(at) * emitted * weight;
            let radiance = shade.settings.clamp.apply(wave.bounces, radiance, &mut self.counts);
            seen[wave.paths.sample.get(at) as usize].radiance += radiance;
        }
    }

    /// Adds the light of all delta lights, or queues their shadow rays.
    #[inline(always)]
    fn sample_delta_lights<L: LaneSet<Element = E>>(
        &mut self,
        shade: &PathShading<'_, L>,
        wave: &PathWave<'_, E>,
        vertices: &Vertices<L>,
        seen: &mut [RadianceSample],
    ) {
        let &PathShading { lanes, lighting, settings, .. } = shade;
        let Vertices { at, mask, points, shadow_origin, albedo, throughput, .. } = vertices;
        let samples = wave.paths.sample.vector(*at);
        for (light, stream) in lighting.lights.delta_lights().zip(&mut self.delta) {
            let zero = lanes.splat(0.0);
            let incident = sample_li(lanes, light, points, *mask);
            let cos = vertices.cosines(lanes, incident.direction);
            // Cancels the 1/π of BSDFs for lights in classical units.
            let factor = FRAC_1_PI * light.units.irradiance_factor();
            let reflected = *albedo * (cos * factor);
            let radiance = reflected.scaled_by(*throughput).scaled_by(incident.strength);
            let lit = lanes.bits(incident.is_lit & cos.gt(zero) & !is_zero(radiance)) & mask;
            if light.casts_shadows {
                let black = lanes.bits(incident.is_lit) & mask & !lit;
                self.counts.shadow_rays_skipped += u64::from(black.count_ones());
                let (direction, end) = shadow_rays(lanes, light, *shadow_origin);
                stream.push(lanes, lit, [*shadow_origin, direction], end, (radiance, samples));
            } else if settings.clamp.applies_after(wave.bounces + 1) {
                let radiance = lanes.store_vector(radiance);
                for lane in each_lane(lit) {
                    let [r, g, b] = [0, 1, 2].map(|c| radiance[c][lane].into());
                    seen[samples[lane] as usize].radiance +=
                        settings.clamp.apply(wave.bounces + 1, Rgb::new(r, g, b), &mut self.counts);
                }
            } else {
                add_radiance(lanes, lit, radiance, true, samples, seen);
            }
        }
    }

    /// Samples one of the area and environment lights, and queues the shadow rays.
    #[inline(always)]
    fn sample_light<L: LaneSet<Element = E>>(
        &mut self,
        shade: &PathShading<'_, L>,
        wave: &PathWave<'_, E>,
        vertices: &Vertices<L>,
    ) {
        let &PathShading { lanes, .. } = shade;
        let Vertices { at, mask, shadow_origin, albedo, throughput, .. } = vertices;
        let LightSamples { lit, infinite, direction, target, weighted, pdf } = LightSamples::new(shade, wave, vertices);
        let zero = lanes.splat(0.0);
        let cos = vertices.cosines(lanes, lanes.narrow_vector(direction));
        let bsdf_pdf = cos * FRAC_1_PI;
        let weight = power_heuristic(lanes.narrow(pdf), bsdf_pdf);
        let reflected = *albedo * (bsdf_pdf * weight);
        let radiance = reflected.scaled_by(*throughput).scaled_by(lanes.narrow_vector(weighted));
        let lit = lanes.bits(cos.gt(zero) & !is_zero(reflected)) & lit & mask;
        self.counts.shadow_rays_skipped += u64::from((mask & !lit).count_ones());
        let (mut to_light, mut end) = (target - *shadow_origin, lanes.splat_f64(Interval::SEGMENT.max));
        if infinite != 0 {
            let infinite = lanes.mask_f64(infinite);
            to_light = Vector3::select(infinite, target, to_light);
            end = Real::select(infinite, lanes.splat_f64(Interval::SPAWNED.max), end);
        }
        let samples = wave.paths.sample.vector(*at);
        self.sampled.push(lanes, lit, [*shadow_origin, to_light], end, (radiance, samples));
    }

    /// Samples the next direction of the paths.
    #[inline(always)]
    fn scatter<L: LaneSet<Element = E>>(
        &mut self,
        shade: &PathShading<'_, L>,
        wave: &PathWave<'_, E>,
        vertices: &Vertices<L>,
    ) {
        let &PathShading { lanes, settings, .. } = shade;
        let &Vertices { at, mask, ref surface, normal, albedo, throughput, .. } = vertices;
        let zero = lanes.splat(0.0);
        let [u, v] = &wave.samples.direction;
        let u = [lanes.load_f64(u.vector(at)), lanes.load_f64(v.vector(at))];
        let local = lanes.narrow_vector(cosine_hemisphere_lanes(u));
        let pdf = local.z * FRAC_1_PI;
        let outside = Vector3::select(lanes.mask(surface.inside), -normal, normal);
        let [tangent, bitangent] = tangents(outside);
        let next = tangent * local.x + bitangent * local.y + normal * local.z;
        let continued = mask & lanes.bits(local.z.gt(zero) & next.dot(surface.normal).gt(zero));
        if wave.bounces >= settings.max_depth && !shade.scene_emits() {
            self.counts.depth_limited += u64::from(continued.count_ones());
            return;
        }
        let mut after = throughput.scaled_by(albedo);
        let mut alive = continued & !lanes.bits(is_zero(after));
        if wave.plays_roulette {
            let survival = survival_probability(after.x.max(after.y).max(after.z), lanes.splat(1.0));
            let u = lanes.load_f64(wave.samples.roulette.vector(at));
            alive &= lanes.bits_f64(u.lt(lanes.widen(survival)));
            after = after / survival;
        }
        let next_paths = &mut self.paths;
        let end = next_paths.rays.len();
        let rays = [surface.near_origin, lanes.widen_vector(next)];
        append(lanes, &mut next_paths.rays, alive, rays, lanes.splat_f64(Interval::SPAWNED.max));
        lanes.compress_vector(after, alive, &mut next_paths.throughput, end);
        lanes.compress(pdf, alive, next_paths.pdf.vector_mut(end));
        lanes.compress_vector(normal, alive, &mut next_paths.normal, end);
        lanes.compress_u32(wave.paths.sample.vector(at), alive, next_paths.sample.vector_mut(end));
    }
}

impl<L: LaneSet> Vertices<L> {
    /// Replaces the normals of triangles with interpolated normals, and the origins of shadow rays there.
    #[inline(always)]
    fn interpolate_normals(&mut self, lanes: L, shapes: &GatheredShapes, hits: &HitStream) {
        let Self { at, points, surface, .. } = self;
        let SmoothPoint { normal, shadow_point, is_valid, .. } = points.smooth(lanes, shapes, (hits, *at));
        self.smooth &= lanes.bits_f64(is_valid);
        let (zero, is_smooth) = (lanes.splat_f64(0.0), lanes.mask_f64(self.smooth));
        let is_inside = lanes.mask_f64(surface.inside);
        let outwards = Vector3::select(is_inside, -points.outside, points.outside);
        let lift = (shadow_point - points.point).dot(outwards);
        let start = Vector3::select(lift.lt(zero), points.point, shadow_point);
        let origin = offset(lanes, points, (start, outwards), self.smooth);
        self.shadow_origin = Vector3::select(is_smooth, origin, self.shadow_origin);
        let normal = turned_to_viewer(lanes.narrow_vector(Vector3::select(is_inside, -normal, normal)), surface);
        self.normal = Vector3::select(lanes.mask(self.smooth), normal, self.normal);
    }

    /// Cosines of directions to the normals. Where interpolated and geometric normal disagree about the side of a direction, they are 0.
    #[inline(always)]
    fn cosines(&self, lanes: L, direction: Vector3<L::F>) -> L::F {
        let cos = self.normal.dot(direction);
        if self.smooth == 0 {
            return cos;
        }
        let zero = lanes.splat(0.0);
        Real::select(self.surface.normal.dot(direction).gt(zero), cos, zero)
    }
}

/// Unit normals, bent where they face away from the viewer until they are perpendicular to the view, as by
/// [`ViewedSurface`](crate::viewed_surface::ViewedSurface).
#[inline(always)]
fn turned_to_viewer<L: LaneSet>(normal: Vector3<L::F>, surface: &ShadedSurface<L>) -> Vector3<L::F> {
    let wo = -surface.direction;
    let facing = normal.dot(wo);
    let is_away = facing.lt(facing.splat(0.0));
    if !is_away.any() {
        return normal;
    }
    let (bent, has_length) = (normal - wo * facing).try_normalize();
    let bent = Vector3::select(has_length, bent, surface.normal);
    Vector3::select(is_away, bent, normal)
}

impl<L: LaneSet> LightSamples<L> {
    /// Samples a light for each lane: for all lanes that have chosen the same parallelogram at once, and for others one by one.
    #[inline(always)]
    fn new(shade: &PathShading<'_, L>, wave: &PathWave<'_, L::Element>, vertices: &Vertices<L>) -> Self {
        let &PathShading { lanes, lighting, .. } = shade;
        let Vertices { at, mask, surface, normal, .. } = vertices;
        // The origin of the next ray: its hit is weighted for this point.
        let from = surface.near_origin;
        let [u, v] = &wave.samples.light;
        let u = [lanes.load_f64(u.vector(*at)), lanes.load_f64(v.vector(*at))];
        let normal = lanes.widen_vector(*normal);
        let choice = lanes.load_f64(wave.samples.choice.vector(*at));
        let (indices, probability) = lanes.choose_lights(lighting.lights, from, normal, choice);
        let zero = lanes.splat_f64(0.0);
        let none = Vector3::new(zero, zero, zero);
        let mut all = Self { lit: 0, infinite: 0, direction: none, target: none, weighted: none, pdf: zero };
        let mut waiting = *mask;
        while let Some(first) = each_lane(waiting).next() {
            let same = lanes.equal(&indices, indices[first]) & waiting;
            waiting &= !same;
            match lighting.lights.sampled_lights().get(indices[first] as usize) {
                Some(Light::Quad(quad)) if !quad.emission().radiance().is_black() => {
                    let sampled = quad.sample_li_lanes(from, u);
                    let pdf = sampled.pdf * probability;
                    let radiance = lanes.splat_point(quad.emission().radiance().to_array().into());
                    let is_same = lanes.mask_f64(same);
                    all.lit |= same & lanes.bits_f64(sampled.is_lit & pdf.gt(zero));
                    all.direction = Vector3::select(is_same, sampled.direction, all.direction);
                    all.target = Vector3::select(is_same, sampled.target, all.target);
                    all.weighted = Vector3::select(is_same, radiance / pdf, all.weighted);
                    all.pdf = Real::select(is_same, pdf, all.pdf);
                }
                Some(light) => all.sample_one_by_one(lanes, light, same, (from, u, probability)),
                None => {}
            }
        }
        all
    }

    /// Samples a light that has been chosen in some lanes, one after the other.
    #[inline(never)]
    fn sample_one_by_one(
        &mut self,
        lanes: L,
        light: &Light,
        chosen: u8,
        (point, [u, v], probability): (Vector3<L::D>, [L::D; 2], L::D),
    ) {
        let point = lanes.store_point(point);
        let [mut of_u, mut of_v, mut probabilities, mut pdfs] = [[0.0; LANES]; 4];
        lanes.store_f64(u, &mut of_u);
        lanes.store_f64(v, &mut of_v);
        lanes.store_f64(probability, &mut probabilities);
        lanes.store_f64(self.pdf, &mut pdfs);
        let mut vectors = [self.direction, self.target, self.weighted].map(|v| lanes.store_point(v));
        for lane in each_lane(chosen) {
            let from = DVec3::from(point.map(|coordinates| coordinates[lane]));
            let Some(sample) = light.sample_li(from, [of_u[lane], of_v[lane]]) else { continue };
            let pdf = sample.pdf * probabilities[lane];
            if !(pdf > 0.0) {
                continue;
            }
            let target = sample.shadow_target();
            self.lit |= 1 << lane;
            self.infinite |= u8::from(target.is_none()) << lane;
            pdfs[lane] = pdf;
            let weighted = sample.radiance / pdf;
            let of_lane = [sample.direction, target.unwrap_or(sample.direction), weighted.to_array().into()];
            for (vector, of_lane) in vectors.iter_mut().zip(of_lane) {
                for (coordinates, coordinate) in vector.iter_mut().zip(of_lane.to_array()) {
                    coordinates[lane] = coordinate;
                }
            }
        }
        self.pdf = lanes.load_f64(&pdfs);
        [self.direction, self.target, self.weighted] = vectors.map(|v| lanes.load_coordinates(&v));
    }
}

impl<L> PathShading<'_, L> {
    /// True if the emission of the next surface or the background may contribute.
    fn scene_emits(&self) -> bool {
        self.features.emission || !self.lighting.appearance.background.is_black()
    }
}

impl<E: Element> PathStream<E> {
    /// Previous vertex of a path: a point next to it, its unit normal, and the density of the direction.
    fn vertex(&self, at: usize) -> (DVec3, DVec3, f64) {
        let (ray, _) = self.rays.get(at);
        let [x, y, z] = &self.normal;
        (ray.origin, DVec3::new(x.get(at).into(), y.get(at).into(), z.get(at).into()), self.pdf.get(at).into())
    }
}
