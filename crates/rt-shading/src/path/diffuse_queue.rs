//! Queue of path vertices on diffuse surfaces, which are shaded in lanes.
//!
//! ```text
//!   hits ─▶ push ─▶ draw samples ─▶ surfaces of triangles ─▶ sample lights ─▶ scatter ─▶ shadow rays, next rays
//! ```
//!
//! Each stage reads and writes all blocks. Results have the bits of [`Vertex`](crate::vertex::Vertex) and [`OrenNayar`] for one path.
//! Lanes in which a rare case occurs are marked, and shaded one by one.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "lanes need AVX2"))]

use super::wave::Path;
use crate::{
    TriangleHit,
    bsdf::{HORIZON, OrenNayar, cosine_hemisphere_lanes, oren_nayar_lanes},
    lanes::{LANES, LaneArray, LaneLevel, LaneMask, Lanes, Simd, get, get_rgb, is_zero, set, set_rgb},
    light::{Light, LightSet, QuadLight},
    mis::power_heuristic,
    russian_roulette::survival_probability,
    viewed_surface::{MIN_COSINE, ViewedSurface},
};
use core::f64::consts::FRAC_1_PI;
use rt_geometry::{SurfaceInteraction, offset_point, triangle_point};
use rt_math::{DVec3, Mask, Ray, Real, Rgb, Sampler, Vector3, tangents};

/// Vertices with their light samples and samples of the next direction.
#[derive(Clone, Debug)]
pub(super) struct DiffuseQueue<S> {
    vertices: Vec<QueuedVertex>,
    blocks: Vec<Block>,
    /// Samplers of the paths before this queue drew from them.
    initial_samplers: Vec<S>,
    draws: Draws,
}

/// Buffers for samples that are drawn together.
#[derive(Clone, Debug, Default)]
struct Draws {
    /// Path of each vertex.
    paths: Vec<u32>,
    pairs: Vec<[f64; 2]>,
    numbers: Vec<f64>,
    /// Vertices at which Russian roulette is played.
    roulette: Vec<u32>,
}

/// Path and time of a queued vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueuedVertex {
    /// Index of the path.
    pub(super) path: u32,
    pub(super) time: f64,
}

/// Four vertices: inputs, light samples and results.
#[derive(Clone, Debug, Default)]
struct Block {
    /// Hits on triangles, whose surfaces are computed in lanes.
    triangles: TriangleBlock,
    point: Vector3<LaneArray>,
    point_error: Vector3<LaneArray>,
    shadow_point: Vector3<LaneArray>,
    geometric_normal: Vector3<LaneArray>,
    shading_normal: Vector3<LaneArray>,
    /// Unit directions of the rays.
    direction: Vector3<LaneArray>,
    /// −1 where the surface is seen from behind, 1 elsewhere.
    side: LaneArray,
    albedo: Vector3<LaneArray>,
    /// Roughness in [0, 1], 0 for Lambert's law.
    roughness: LaneArray,
    throughput: Vector3<LaneArray>,
    eta_scale: LaneArray,
    /// Numbers for the choice of a light, a direction to it, and the next direction of the path.
    u_light_choice: LaneArray,
    u_light: [LaneArray; 2],
    u_bsdf: [LaneArray; 2],
    /// Number for Russian roulette; −1 where it is not played.
    u_roulette: LaneArray,
    light: LightBlock,
    scattered: ScatteredBlock,
}

/// Triangles of four hits. Bit `i` of the mask is for lane `i`; the numbers of others are left over.
#[derive(Clone, Debug, Default)]
struct TriangleBlock {
    mask: u8,
    vertices: [Vector3<LaneArray>; 3],
    /// Barycentric weights of the second and third vertex.
    uv: [LaneArray; 2],
    /// Directions of the rays, of any length.
    direction: Vector3<LaneArray>,
}

/// Light samples of four vertices.
#[derive(Clone, Debug, Default)]
struct LightBlock {
    direction: Vector3<LaneArray>,
    /// Vector to the end of the shadow ray, from the origin of space or, for a light at infinity, from the vertex.
    target: Vector3<LaneArray>,
    /// 1 for a light at infinity, 0 elsewhere.
    is_infinite: LaneArray,
    radiance: Vector3<LaneArray>,
    /// Density per unit solid angle; 0 where no light reaches the vertex.
    pdf: LaneArray,
}

/// Results of four vertices. Bit `i` of a mask is for lane `i`.
#[derive(Clone, Debug, Default)]
struct ScatteredBlock {
    /// Lanes with valid results; all others are shaded one by one.
    valid: u8,
    /// Lanes with a shadow ray.
    lit: u8,
    /// Lanes whose next direction leaves the surface.
    continued: u8,
    /// Lanes of `continued` whose path survives: it has throughput, and Russian roulette has not ended it.
    alive: u8,
    shadow_origin: Vector3<LaneArray>,
    shadow_direction: Vector3<LaneArray>,
    /// Contributions of unoccluded light.
    direct: Vector3<LaneArray>,
    next_origin: Vector3<LaneArray>,
    next_direction: Vector3<LaneArray>,
    throughput: Vector3<LaneArray>,
    pdf: LaneArray,
}

/// Result for a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattered {
    /// Origin and direction of a shadow ray, and the light if it is not occluded.
    pub(super) direct: Option<(DVec3, DVec3, Rgb)>,
    /// True if the sampled light is infinitely far away.
    pub(super) is_light_infinite: bool,
    /// Next direction of the path, if it leaves the surface.
    pub(super) next: Option<NextRay>,
}

/// Ray of the next direction of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct NextRay {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    /// Density of the direction over solid angle.
    pub(super) pdf: f64,
    /// Throughput of the path, after Russian roulette.
    pub(super) throughput: Rgb,
    /// False if no throughput is left, or Russian roulette has ended the path.
    pub(super) is_alive: bool,
}

impl<S> Default for DiffuseQueue<S> {
    fn default() -> Self {
        Self { vertices: Vec::new(), blocks: Vec::new(), initial_samplers: Vec::new(), draws: Draws::default() }
    }
}

impl<S: Sampler + Clone> DiffuseQueue<S> {
    pub(super) fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    pub(super) fn vertices(&self) -> &[QueuedVertex] {
        &self.vertices
    }

    pub(super) fn clear(&mut self) {
        self.vertices.clear();
    }

    /// Appends a vertex of a path. [`ViewedSurface::new`] must have left the shading normal unchanged: a vertex that is shaded by
    /// itself passes through it again. Russian roulette starts after `rr_start_depth` bounces.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        (id, path): (u32, &Path),
        view: &ViewedSurface<'_>,
        diffuse: &OrenNayar,
        time: f64,
        rr_start_depth: u32,
    ) {
        let (block, lane) = self.push_path((id, path), diffuse, time, rr_start_depth);
        let surface = view.surface;
        set(&mut block.point, lane, surface.point);
        set(&mut block.point_error, lane, surface.point_error);
        set(&mut block.shadow_point, lane, surface.shadow_point);
        set(&mut block.geometric_normal, lane, surface.geometric_normal);
        set(&mut block.shading_normal, lane, surface.shading_normal);
        set(&mut block.direction, lane, view.direction);
        block.side[lane] = if view.is_inside { -1.0 } else { 1.0 };
    }

    /// Version of [`push`](Self::push) for a hit of a ray on a triangle, whose surface is computed later.
    #[inline(always)]
    pub(super) fn push_triangle(
        &mut self,
        path: (u32, &Path),
        hit: &TriangleHit,
        diffuse: &OrenNayar,
        ray: &Ray,
        rr_start_depth: u32,
    ) {
        let (block, lane) = self.push_path(path, diffuse, ray.time, rr_start_depth);
        block.triangles.mask |= 1 << lane;
        let [a, b, c] = &mut block.triangles.vertices;
        set(a, lane, hit.vertices[0]);
        set(b, lane, hit.vertices[1]);
        set(c, lane, hit.vertices[2]);
        let [v, w] = &mut block.triangles.uv;
        [v[lane], w[lane]] = hit.uv;
        set(&mut block.triangles.direction, lane, ray.direction);
        set(&mut block.geometric_normal, lane, hit.normal);
    }

    /// Appends a vertex without its surface.
    #[inline(always)]
    fn push_path(
        &mut self,
        (id, path): (u32, &Path),
        diffuse: &OrenNayar,
        time: f64,
        rr_start_depth: u32,
    ) -> (&mut Block, usize) {
        let (at, lane) = (self.vertices.len() / LANES, self.vertices.len() % LANES);
        if at == self.blocks.len() {
            self.blocks.push(Block::default());
        }
        self.vertices.push(QueuedVertex { path: id, time });
        let block = &mut self.blocks[at];
        if lane == 0 {
            block.triangles.mask = 0;
        }
        set_rgb(&mut block.albedo, lane, diffuse.albedo);
        block.roughness[lane] = diffuse.clamped_roughness();
        set_rgb(&mut block.throughput, lane, path.throughput);
        block.eta_scale[lane] = path.eta_scale;
        let plays_roulette = path.bounces + 1 > rr_start_depth;
        block.u_roulette[lane] = if plays_roulette { 0.0 } else { -1.0 };
        (block, lane)
    }

    /// Draws the samples of all vertices, for one of `n_lights` and, if paths follow diffuse surfaces, for the next direction.
    pub(super) fn draw(&mut self, samplers: &mut [S], n_lights: usize, follows_diffuse: bool) {
        let Self { vertices, blocks, initial_samplers, draws } = self;
        let Draws { paths, pairs, numbers, roulette } = draws;
        paths.clear();
        paths.extend(vertices.iter().map(|vertex| vertex.path));
        initial_samplers.clear();
        initial_samplers.extend(paths.iter().map(|&path| samplers[path as usize].clone()));
        pairs.resize(paths.len(), [0.0; 2]);
        numbers.resize(paths.len(), 0.0);
        if n_lights > 0 {
            S::next_2d_batch(samplers, paths, pairs);
            each_pair(blocks, pairs, |block| &mut block.u_light);
        }
        if n_lights > 1 {
            S::next_1d_batch(samplers, paths, numbers);
            for (at, &number) in numbers.iter().enumerate() {
                blocks[at / LANES].u_light_choice[at % LANES] = number;
            }
        }
        if !follows_diffuse {
            return;
        }
        S::next_2d_batch(samplers, paths, pairs);
        each_pair(blocks, pairs, |block| &mut block.u_bsdf);
        roulette.clear();
        roulette.extend((0..paths.len() as u32).filter(|&at| {
            let at = at as usize;
            blocks[at / LANES].u_roulette[at % LANES] >= 0.0
        }));
        paths.clear();
        paths.extend(roulette.iter().map(|&at| vertices[at as usize].path));
        S::next_1d_batch(samplers, paths, numbers);
        for (&at, &number) in roulette.iter().zip(&*numbers) {
            blocks[at as usize / LANES].u_roulette[at as usize % LANES] = number;
        }
    }

    /// Sampler of the path of a vertex before this queue drew from it.
    pub(super) fn sampler_before(&self, at: usize) -> S {
        self.initial_samplers[at].clone()
    }

    /// Samples lights, and the next direction of each path if it `follows_diffuse` surfaces.
    pub(super) fn shade(&mut self, level: LaneLevel, lights: &LightSet, follows_diffuse: bool) {
        let blocks = &mut self.blocks[..self.vertices.len().div_ceil(LANES)];
        match level {
            #[cfg(target_arch = "x86_64")]
            LaneLevel::Avx2(simd) => compute_surfaces(simd, blocks),
        }
        match lights.sampled_lights() {
            [] => blocks.iter_mut().for_each(|block| block.light.pdf = [0.0; LANES]),
            [Light::Quad(quad)] if !quad.emission().radiance().is_black() => match level {
                #[cfg(target_arch = "x86_64")]
                LaneLevel::Avx2(simd) => sample_quad(simd, blocks, quad),
            },
            _ => sample_lights(blocks, self.vertices.len(), lights),
        }
        match level {
            #[cfg(target_arch = "x86_64")]
            LaneLevel::Avx2(simd) => scatter(simd, blocks, follows_diffuse),
        }
    }

    /// Result for the vertex `at`; `None` if it must be shaded by itself.
    #[inline(always)]
    pub(super) fn scattered(&self, at: usize) -> Option<Scattered> {
        let lane = at % LANES;
        let ScatteredBlock { valid, lit, continued, alive, .. } = self.blocks[at / LANES].scattered;
        let is = |mask: u8| mask >> lane & 1 == 1;
        let results = &self.blocks[at / LANES].scattered;
        is(valid).then(|| Scattered {
            direct: is(lit).then(|| {
                let (origin, direction) = (&results.shadow_origin, &results.shadow_direction);
                (get(origin, lane), get(direction, lane), get_rgb(&results.direct, lane))
            }),
            is_light_infinite: self.blocks[at / LANES].light.is_infinite[lane] > 0.0,
            next: is(continued).then(|| NextRay {
                origin: get(&results.next_origin, lane),
                direction: get(&results.next_direction, lane),
                pdf: results.pdf[lane],
                throughput: get_rgb(&results.throughput, lane),
                is_alive: is(alive),
            }),
        })
    }

    /// Point of a vertex, and its unit shading normal on the viewer's side.
    #[inline(always)]
    pub(super) fn point_and_normal(&self, at: usize) -> (DVec3, DVec3) {
        let (block, lane) = (&self.blocks[at / LANES], at % LANES);
        (get(&block.point, lane), get(&block.shading_normal, lane) * block.side[lane])
    }

    /// Surface of a vertex, the direction from which it is seen, whether from behind, and its BSDF.
    pub(super) fn surface(&self, at: usize) -> (SurfaceInteraction, (DVec3, bool), OrenNayar) {
        let (block, lane) = (&self.blocks[at / LANES], at % LANES);
        let (point, error) = (get(&block.point, lane), get(&block.point_error, lane));
        let surface = SurfaceInteraction {
            shadow_point: get(&block.shadow_point, lane),
            shading_normal: get(&block.shading_normal, lane),
            ..SurfaceInteraction::flat(point, error, get(&block.geometric_normal, lane), [0.0; 2])
        };
        let diffuse = OrenNayar { albedo: get_rgb(&block.albedo, lane), roughness: block.roughness[lane] };
        (surface, (get(&block.direction, lane), block.side[lane] < 0.0), diffuse)
    }
}

/// Stores pairs of numbers in the lanes of a field.
fn each_pair(blocks: &mut [Block], pairs: &[[f64; 2]], field: impl Fn(&mut Block) -> &mut [LaneArray; 2]) {
    for (block, pairs) in blocks.iter_mut().zip(pairs.chunks(LANES)) {
        let [u, v] = field(block);
        for (lane, pair) in pairs.iter().enumerate() {
            [u[lane], v[lane]] = *pair;
        }
    }
}

/// Computes the surfaces of triangles.
fn compute_surfaces<S: Simd>(simd: S, blocks: &mut [Block]) {
    simd.vectorize(
        #[inline(always)]
        || {
            for block in blocks.iter_mut().filter(|block| block.triangles.mask != 0) {
                compute_surface(simd, block);
            }
        },
    );
}

#[inline(always)]
fn compute_surface<S: Simd>(simd: S, block: &mut Block) {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let TriangleBlock { mask, vertices: [a, b, c], uv: [v, w], direction } = &block.triangles;
    let vertices = [Lanes::load_vector(simd, a), Lanes::load_vector(simd, b), Lanes::load_vector(simd, c)];
    let (v, w) = (Lanes::load(simd, v), Lanes::load(simd, w));
    let (point, error) = triangle_point(vertices, [one - v - w, v, w]);
    let direction = Lanes::load_vector(simd, direction);
    let direction = direction / direction.length();
    let normal = Lanes::load_vector(simd, &block.geometric_normal);
    let side = Real::select(direction.dot(normal).gt(zero), -one, one);
    let is_triangle = LaneMask::from_bits(simd, *mask);
    replace(simd, &mut block.point, is_triangle, point);
    replace(simd, &mut block.point_error, is_triangle, error);
    replace(simd, &mut block.shadow_point, is_triangle, point);
    replace(simd, &mut block.shading_normal, is_triangle, normal);
    replace(simd, &mut block.direction, is_triangle, direction);
    block.side = Real::select(is_triangle, side, Lanes::load(simd, &block.side)).store();
}

/// Replaces vectors where the mask is true.
#[inline(always)]
fn replace<S: Simd>(simd: S, lanes: &mut Vector3<LaneArray>, mask: LaneMask<S>, computed: Vector3<Lanes<S>>) {
    *lanes = Lanes::store_vector(Vector3::select(mask, computed, Lanes::load_vector(simd, lanes)));
}

/// Samples one of several lights for each vertex, one vertex at a time.
fn sample_lights(blocks: &mut [Block], n_vertices: usize, lights: &LightSet) {
    for at in 0..n_vertices {
        let (block, lane) = (&mut blocks[at / LANES], at % LANES);
        let normal = get(&block.shading_normal, lane) * block.side[lane];
        let [u, v] = &block.u_light;
        let sampled =
            lights.sample_li(get(&block.point, lane), Some(normal), block.u_light_choice[lane], [u[lane], v[lane]]);
        let light = &mut block.light;
        light.pdf[lane] = 0.0;
        let Some(sampled) = sampled else { continue };
        let target = sampled.sample.shadow_target();
        set(&mut light.direction, lane, sampled.sample.direction);
        set(&mut light.target, lane, target.unwrap_or(sampled.sample.direction));
        light.is_infinite[lane] = if target.is_none() { 1.0 } else { 0.0 };
        set_rgb(&mut light.radiance, lane, sampled.sample.radiance);
        light.pdf[lane] = sampled.pdf;
    }
}

/// Samples the only light of a scene, a parallelogram.
fn sample_quad<S: Simd>(simd: S, blocks: &mut [Block], quad: &QuadLight) {
    let Rgb { r, g, b } = quad.emission().radiance();
    simd.vectorize(
        #[inline(always)]
        || {
            let zero = Lanes::splat(simd, 0.0);
            for block in blocks {
                let point = Lanes::load_vector(simd, &block.point);
                let [u, v] = &block.u_light;
                let sampled = quad.sample_li_lanes(point, [Lanes::load(simd, u), Lanes::load(simd, v)]);
                block.light = LightBlock {
                    direction: Lanes::store_vector(sampled.direction),
                    target: Lanes::store_vector(sampled.target),
                    is_infinite: [0.0; LANES],
                    radiance: Vector3::new([r; LANES], [g; LANES], [b; LANES]),
                    pdf: Real::select(sampled.is_lit, sampled.pdf, zero).store(),
                };
            }
        },
    );
}

/// Evaluates the BSDF for the sampled light, and samples the next direction.
fn scatter<S: Simd>(simd: S, blocks: &mut [Block], follows_diffuse: bool) {
    simd.vectorize(
        #[inline(always)]
        || {
            for block in blocks {
                block.scattered = scatter_block(simd, block, follows_diffuse);
            }
        },
    );
}

#[inline(always)]
fn scatter_block<S: Simd>(simd: S, block: &Block, follows_diffuse: bool) -> ScatteredBlock {
    let (zero, horizon) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, HORIZON));
    let direction = Lanes::load_vector(simd, &block.direction);
    let (geometric, shading) =
        (Lanes::load_vector(simd, &block.geometric_normal), Lanes::load_vector(simd, &block.shading_normal));
    let (point, error) = (Lanes::load_vector(simd, &block.point), Lanes::load_vector(simd, &block.point_error));
    let throughput = Lanes::load_vector(simd, &block.throughput);
    let albedo = Lanes::load_vector(simd, &block.albedo);
    let roughness = Lanes::load(simd, &block.roughness);
    let side = Lanes::load(simd, &block.side);
    let is_behind = side.lt(zero);

    // Shading coordinates.
    let mut valid = direction.is_finite() & shading.is_finite();
    let [tangent, bitangent] = tangents(shading);
    let cos_view = (-direction).dot(shading);
    let min = side * MIN_COSINE;
    let cos_view = Real::select((cos_view * side).lt(zero + MIN_COSINE), min, cos_view);
    let is_above = cos_view.gt(zero);
    let wo = Vector3::new((-direction).dot(tangent), (-direction).dot(bitangent), cos_view.abs());
    let towards_viewer = Vector3::select(is_behind, -geometric, geometric);

    // Light that the sampled light sends to the viewer, with its MIS weight.
    let light = &block.light;
    let (wi, target) = (Lanes::load_vector(simd, &light.direction), Lanes::load_vector(simd, &light.target));
    let light_pdf = Lanes::load(simd, &light.pdf);
    let is_infinite = Lanes::load(simd, &light.is_infinite).gt(zero);
    let cos = wi.dot(shading);
    let cos_above = Real::select(is_above, cos, -cos);
    let (is_up, is_geometrically_up) = (cos.gt(zero), wi.dot(geometric).gt(zero));
    let sides_agree = (is_up & is_geometrically_up) | (!is_up & !is_geometrically_up);
    let weight =
        if follows_diffuse { power_heuristic(light_pdf, cos_above * FRAC_1_PI) } else { Lanes::splat(simd, 1.0) };
    let local = Vector3::new(wi.dot(tangent), wi.dot(bitangent), cos_above);
    let reflected = diffuse_value(albedo, roughness, wo, local) * weight * cos.abs();
    let is_black = is_zero(reflected);
    let lit = light_pdf.gt(zero) & sides_agree & cos_above.gt(horizon) & !is_black;
    let radiance = Lanes::load_vector(simd, &light.radiance);
    let direct = throughput.scaled_by(reflected).scaled_by(radiance) / light_pdf;

    // Shadow ray. Those to the far side are rare, and start elsewhere.
    let shadow_point = Lanes::load_vector(simd, &block.shadow_point);
    let lift = (shadow_point - point).dot(geometric);
    let start = Vector3::select((lift * side).lt(zero), point, shadow_point);
    let (shadow_origin, is_offset) = offset_point(start, error, geometric, towards_viewer);
    let to_light = Vector3::select(is_infinite, target, target - point);
    let leaves_behind = to_light.dot(shading).lt(zero);
    let same_side = (leaves_behind & is_behind) | (!leaves_behind & !is_behind);
    valid = valid & (!lit | (is_offset & same_side));
    let shadow_direction = Vector3::select(is_infinite, target, target - shadow_origin);
    let mut scattered = ScatteredBlock {
        valid: valid.bits(),
        lit: lit.bits(),
        shadow_origin: Lanes::store_vector(shadow_origin),
        shadow_direction: Lanes::store_vector(shadow_direction),
        direct: Lanes::store_vector(direct),
        ..ScatteredBlock::default()
    };
    if !follows_diffuse {
        return scattered;
    }

    // Next direction.
    let [u, v] = &block.u_bsdf;
    let local = cosine_hemisphere_lanes([Lanes::load(simd, u), Lanes::load(simd, v)]);
    let pdf = local.z * FRAC_1_PI;
    let height = Real::select(is_above, local.z, -local.z);
    let next = tangent * local.x + bitangent * local.y + shading * height;
    let continued = local.z.gt(horizon) & next.dot(towards_viewer).gt(zero);
    let scale = local.z / pdf;
    let after = throughput.scaled_by(diffuse_value(albedo, roughness, wo, local) * scale);
    let outwards = Vector3::select(next.dot(geometric).lt(zero), -geometric, geometric);
    let (next_origin, is_offset) = offset_point(point, error, geometric, outwards);
    valid = valid & (!continued | (is_offset & after.is_finite()));

    // Russian roulette.
    let u_roulette = Lanes::load(simd, &block.u_roulette);
    let max = after.x.max(after.y).max(after.z);
    let survival = survival_probability(max, Lanes::load(simd, &block.eta_scale));
    let plays = u_roulette.ge(zero);
    let alive = continued & !is_zero(after) & (!plays | u_roulette.lt(survival));
    let after = Vector3::select(plays, after / survival, after);
    scattered.valid = valid.bits();
    scattered.continued = continued.bits();
    scattered.alive = alive.bits();
    scattered.next_origin = Lanes::store_vector(next_origin);
    scattered.next_direction = Lanes::store_vector(next);
    scattered.throughput = Lanes::store_vector(after);
    scattered.pdf = pdf.store();
    scattered
}

/// f for directions above the surface. Blocks without roughness skip what is then 0.
#[inline(always)]
fn diffuse_value<R: Real>(albedo: Vector3<R>, roughness: R, wo: Vector3<R>, wi: Vector3<R>) -> Vector3<R> {
    if roughness.gt(roughness.splat(0.0)).any() {
        oren_nayar_lanes(albedo, roughness, wo, wi)
    } else {
        albedo * roughness.splat(FRAC_1_PI)
    }
}
