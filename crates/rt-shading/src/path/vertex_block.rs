//! Blocks of four path vertices, and the stages that shade them in lanes.
//!
//! Each stage reads and writes all blocks. Results have the bits of [`Vertex`](crate::vertex::Vertex) and
//! [`Bsdf`](crate::bsdf::Bsdf) for one path.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "lanes need AVX2"))]

use crate::{
    bsdf::{DiffusePhongLanes, HORIZON, cosine_hemisphere_lanes},
    lanes::{LANES, LaneArray, LaneMask, Lanes, Simd, get, is_zero, set, set_rgb},
    light::{LightSet, QuadLight},
    mis::power_heuristic,
    russian_roulette::survival_probability,
    viewed_surface::MIN_COSINE,
};
use core::f64::consts::FRAC_1_PI;
use rt_geometry::{offset_point, triangle_point};
use rt_math::{Real, Rgb, Vector3, tangents};

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
    /// Phong lobes, in queues of surfaces that have them.
    pub(super) phong: PhongBlock,
    pub(super) throughput: Vector3<LaneArray>,
    pub(super) eta_scale: LaneArray,
    /// Numbers for the choice of a light, a direction to it, and the next direction of the path.
    pub(super) u_light_choice: LaneArray,
    pub(super) u_light: [LaneArray; 2],
    pub(super) u_bsdf: [LaneArray; 2],
    /// Number for the choice of a lobe.
    pub(super) u_lobe: LaneArray,
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

/// Phong lobes of four vertices, with the weights and probabilities of [`WeightedPhong`](crate::bsdf::WeightedPhong).
#[derive(Clone, Debug, Default)]
pub(super) struct PhongBlock {
    pub(super) reflectance: Vector3<LaneArray>,
    pub(super) exponent: LaneArray,
    pub(super) weights: [LaneArray; 2],
    pub(super) probabilities: [LaneArray; 2],
}

/// Lobes of which the next direction is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FollowedLobes {
    /// None: the path ends.
    Nothing,
    /// The Phong lobe of surfaces that have one.
    Phong,
    All,
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
    /// Lanes whose next direction is from the diffuse lobe.
    pub(super) diffuse: u8,
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

/// Evaluates the BSDF for the sampled light, and samples the next direction. With `PHONG`, surfaces have Phong lobes.
pub(super) fn scatter<S: Simd, const PHONG: bool>(simd: S, blocks: &mut [Block], lobes: FollowedLobes) {
    simd.vectorize(
        #[inline(always)]
        || {
            for block in blocks {
                block.scattered = scatter_block::<S, PHONG>(simd, block, lobes);
            }
        },
    );
}

#[inline(always)]
fn scatter_block<S: Simd, const PHONG: bool>(simd: S, block: &Block, lobes: FollowedLobes) -> ScatteredBlock {
    let (zero, horizon) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, HORIZON));
    let direction = Lanes::load_vector(simd, &block.direction);
    let (geometric, shading) =
        (Lanes::load_vector(simd, &block.geometric_normal), Lanes::load_vector(simd, &block.shading_normal));
    let (point, error) = (Lanes::load_vector(simd, &block.point), Lanes::load_vector(simd, &block.point_error));
    let throughput = Lanes::load_vector(simd, &block.throughput);
    let bsdf = load_bsdf(simd, block, PHONG);
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
    let local = Vector3::new(wi.dot(tangent), wi.dot(bitangent), cos_above);
    let weighted = if PHONG {
        let values = bsdf.values(wo, local);
        let all = values.diffuse + values.phong;
        if lobes == FollowedLobes::All {
            all * power_heuristic(light_pdf, bsdf.pdf(&values))
        } else {
            let one = Lanes::splat(simd, 1.0);
            all - values.phong * (one - power_heuristic(light_pdf, values.phong_pdf))
        }
    } else {
        let value = bsdf.diffuse_value(wo, local);
        if lobes == FollowedLobes::All { value * power_heuristic(light_pdf, cos_above * FRAC_1_PI) } else { value }
    };
    let reflected = weighted * cos.abs();
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
    if lobes == FollowedLobes::Nothing {
        return scattered;
    }

    // Next direction.
    let [u, v] = &block.u_bsdf;
    let u = [Lanes::load(simd, u), Lanes::load(simd, v)];
    let (local, value, pdf, is_sampled) = if PHONG {
        let samples_diffuse = lobes == FollowedLobes::All;
        let is_diffuse = if samples_diffuse {
            bsdf.chooses_diffuse(Lanes::load(simd, &block.u_lobe))
        } else {
            LaneMask::from_bits(simd, 0)
        };
        scattered.diffuse = is_diffuse.bits();
        let local = bsdf.sample(wo, is_diffuse, u);
        let values = bsdf.values(wo, local);
        let own_pdf = Real::select(is_diffuse, values.diffuse_pdf, values.phong_pdf);
        let (value, pdf) = if samples_diffuse {
            (values.diffuse + values.phong, bsdf.pdf(&values))
        } else {
            (values.phong, values.phong_pdf)
        };
        let is_finite = pdf.le(Lanes::splat(simd, f64::MAX)) & value.is_finite();
        (local, value, pdf, own_pdf.gt(zero) & pdf.gt(zero) & is_finite)
    } else {
        scattered.diffuse = !0;
        let local = cosine_hemisphere_lanes(u);
        let pdf = local.z * FRAC_1_PI;
        (local, bsdf.diffuse_value(wo, local), pdf, pdf.gt(zero))
    };
    let height = Real::select(is_above, local.z, -local.z);
    let next = tangent * local.x + bitangent * local.y + shading * height;
    let continued = is_sampled & local.z.gt(horizon) & next.dot(towards_viewer).gt(zero);
    let after = throughput.scaled_by(value * (local.z / pdf));
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

/// Loads the BSDFs; without `has_phong` only their diffuse lobes.
#[inline(always)]
fn load_bsdf<S: Simd>(simd: S, block: &Block, has_phong: bool) -> DiffusePhongLanes<Lanes<S>> {
    let zero = Lanes::splat(simd, 0.0);
    let mut bsdf = DiffusePhongLanes {
        albedo: Lanes::load_vector(simd, &block.albedo),
        roughness: Lanes::load(simd, &block.roughness),
        reflectance: Vector3::new(zero, zero, zero),
        exponent: zero,
        weights: [zero; 2],
        probabilities: [zero; 2],
    };
    if has_phong {
        let PhongBlock { reflectance, exponent, weights: [a, b], probabilities: [c, d] } = &block.phong;
        bsdf.reflectance = Lanes::load_vector(simd, reflectance);
        bsdf.exponent = Lanes::load(simd, exponent);
        bsdf.weights = [Lanes::load(simd, a), Lanes::load(simd, b)];
        bsdf.probabilities = [Lanes::load(simd, c), Lanes::load(simd, d)];
    }
    bsdf
}
