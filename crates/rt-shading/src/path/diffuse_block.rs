//! Blocks of four path vertices, and the stages that shade them in lanes.
//!
//! Each stage reads and writes all blocks. Results have the bits of [`Vertex`](crate::vertex::Vertex) and
//! [`OrenNayar`](crate::bsdf::OrenNayar) for one path.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "lanes need AVX2"))]

use crate::{
    bsdf::{HORIZON, cosine_hemisphere_lanes, oren_nayar_lanes},
    lanes::{LANES, LaneArray, LaneMask, Lanes, Simd, get, is_zero, set, set_rgb},
    light::{LightSet, QuadLight},
    mis::power_heuristic,
    russian_roulette::survival_probability,
    viewed_surface::MIN_COSINE,
};
use core::f64::consts::FRAC_1_PI;
use rt_geometry::{offset_point, triangle_point};
use rt_math::{Mask, Real, Rgb, Vector3, tangents};

/// Four vertices: inputs, light samples and results.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    /// Hits on triangles, whose surfaces are computed in lanes.
    pub(super) triangles: TriangleBlock,
    pub(super) point: Vector3<LaneArray>,
    pub(super) point_error: Vector3<LaneArray>,
    pub(super) shadow_point: Vector3<LaneArray>,
    pub(super) geometric_normal: Vector3<LaneArray>,
    pub(super) shading_normal: Vector3<LaneArray>,
    /// Unit directions of the rays.
    pub(super) direction: Vector3<LaneArray>,
    /// −1 where the surface is seen from behind, 1 elsewhere.
    pub(super) side: LaneArray,
    pub(super) albedo: Vector3<LaneArray>,
    /// Roughness in [0, 1], 0 for Lambert's law.
    pub(super) roughness: LaneArray,
    pub(super) throughput: Vector3<LaneArray>,
    pub(super) eta_scale: LaneArray,
    /// Numbers for the choice of a light, a direction to it, and the next direction of the path.
    pub(super) u_light_choice: LaneArray,
    pub(super) u_light: [LaneArray; 2],
    pub(super) u_bsdf: [LaneArray; 2],
    /// Number for Russian roulette; −1 where it is not played.
    pub(super) u_roulette: LaneArray,
    pub(super) light: LightBlock,
    pub(super) scattered: ScatteredBlock,
}

/// Triangles of four hits. Bit `i` of the mask is for lane `i`; the numbers of others are left over.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleBlock {
    pub(super) mask: u8,
    pub(super) vertices: [Vector3<LaneArray>; 3],
    /// Barycentric weights of the second and third vertex.
    pub(super) uv: [LaneArray; 2],
    /// Directions of the rays, of any length.
    pub(super) direction: Vector3<LaneArray>,
}

/// Light samples of four vertices.
#[derive(Clone, Debug, Default)]
pub(super) struct LightBlock {
    pub(super) direction: Vector3<LaneArray>,
    /// Vector to the end of the shadow ray, from the origin of space or, for a light at infinity, from the vertex.
    pub(super) target: Vector3<LaneArray>,
    /// 1 for a light at infinity, 0 elsewhere.
    pub(super) is_infinite: LaneArray,
    pub(super) radiance: Vector3<LaneArray>,
    /// Density per unit solid angle; 0 where no light reaches the vertex.
    pub(super) pdf: LaneArray,
}

/// Results of four vertices. Bit `i` of a mask is for lane `i`.
#[derive(Clone, Debug, Default)]
pub(super) struct ScatteredBlock {
    /// Lanes with valid results; all others are shaded one by one.
    pub(super) valid: u8,
    /// Lanes with a shadow ray.
    pub(super) lit: u8,
    /// Lanes whose next direction leaves the surface.
    pub(super) continued: u8,
    /// Lanes of `continued` whose path survives: it has throughput, and Russian roulette has not ended it.
    pub(super) alive: u8,
    pub(super) shadow_origin: Vector3<LaneArray>,
    pub(super) shadow_direction: Vector3<LaneArray>,
    /// Contributions of unoccluded light.
    pub(super) direct: Vector3<LaneArray>,
    pub(super) next_origin: Vector3<LaneArray>,
    pub(super) next_direction: Vector3<LaneArray>,
    pub(super) throughput: Vector3<LaneArray>,
    pub(super) pdf: LaneArray,
}

/// Computes the surfaces of triangles.
pub(super) fn compute_surfaces<S: Simd>(simd: S, blocks: &mut [Block]) {
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
    let (point, error) = triangle_point(vertices, [Lanes::load(simd, v), Lanes::load(simd, w)]);
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
pub(super) fn sample_lights(blocks: &mut [Block], n_vertices: usize, lights: &LightSet) {
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
pub(super) fn sample_quad<S: Simd>(simd: S, blocks: &mut [Block], quad: &QuadLight) {
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
pub(super) fn scatter<S: Simd>(simd: S, blocks: &mut [Block], follows_diffuse: bool) {
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
