//! Stages that shade blocks of path vertices in lanes.
//!
//! Each stage reads and writes all blocks. Results have the bits of [`Vertex`](crate::vertex::Vertex) and
//! [`Bsdf`](crate::bsdf::Bsdf) for one path.

use super::direct_lighting_lanes::{reflect_sampled_light, sample_delta_light};
use super::lane_bsdf::{LaneBsdf, SampledLanes};
use super::vertex_block::{Block, DeltaBlock, FollowedLobes, FrameLanes, ScatteredBlock, ShapeBlock, replace};
use crate::{
    bsdf::HORIZON,
    lanes::{LaneMask, Lanes, Simd, is_zero},
    light::LightSet,
    russian_roulette::survival_probability,
};
use rt_geometry::{offset_point, sphere_point, triangle_point};
use rt_math::{DVec3, Mask, Real, Vector3};

/// Computes the surfaces of shapes.
pub(super) fn compute_surfaces<S: Simd>(simd: S, blocks: &mut [Block]) {
    simd.vectorize(
        #[inline(always)]
        || {
            for block in blocks {
                if block.shapes.triangles != 0 {
                    compute_triangles(simd, block);
                }
                if block.shapes.spheres != 0 {
                    compute_spheres(simd, block);
                }
            }
        },
    );
}

#[inline(always)]
fn compute_triangles<S: Simd>(simd: S, block: &mut Block) {
    let ShapeBlock { triangles, points: [a, b, c], numbers: [v, w], .. } = &block.shapes;
    let vertices = [Lanes::load_vector(simd, a), Lanes::load_vector(simd, b), Lanes::load_vector(simd, c)];
    let (point, error) = triangle_point(vertices, [Lanes::load(simd, v), Lanes::load(simd, w)]);
    let normal = Lanes::load_vector(simd, &block.geometric_normal);
    let is_triangle = LaneMask::from_bits(simd, *triangles);
    replace_surface(simd, block, is_triangle, [point, error, normal]);
}

/// Computes the surfaces of spheres as [`Sphere::surface`](rt_geometry::Sphere::surface).
#[inline(always)]
fn compute_spheres<S: Simd>(simd: S, block: &mut Block) {
    let ShapeBlock { spheres, points: [centre, origin, _], numbers: [radius, t], direction, .. } = &block.shapes;
    let (centre, origin) = (Lanes::load_vector(simd, centre), Lanes::load_vector(simd, origin));
    let direction = Lanes::load_vector(simd, direction);
    let (mut normal, has_normal) = ((origin - centre) + direction * Lanes::load(simd, t)).try_normalize();
    if !has_normal.all() {
        let (unit, has_length) = direction.try_normalize();
        let unit = Vector3::select(has_length, unit, Vector3::splat(direction.x, DVec3::Y));
        normal = Vector3::select(has_normal, normal, -unit);
    }
    let is_sphere = LaneMask::from_bits(simd, *spheres);
    let (point, error) = sphere_point(centre, Lanes::load(simd, radius), normal);
    replace(simd, &mut block.geometric_normal, is_sphere, normal);
    replace_surface(simd, block, is_sphere, [point, error, normal]);
}

/// Replaces flat surfaces where the mask is true, by points, their errors and unit normals.
#[inline(always)]
fn replace_surface<S: Simd>(
    simd: S,
    block: &mut Block,
    mask: LaneMask<S>,
    [point, error, normal]: [Vector3<Lanes<S>>; 3],
) {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let direction = Lanes::load_vector(simd, &block.shapes.direction);
    let direction = direction / direction.length();
    let side = Real::select(direction.dot(normal).gt(zero), -one, one);
    replace(simd, &mut block.point, mask, point);
    replace(simd, &mut block.point_error, mask, error);
    replace(simd, &mut block.shadow_point, mask, point);
    replace(simd, &mut block.shading_normal, mask, normal);
    replace(simd, &mut block.direction, mask, direction);
    block.side = Real::select(mask, side, Lanes::load(simd, &block.side)).store();
}

/// Evaluates the BSDF for all delta lights and for the sampled light, and samples the next direction. Appends one block of results
/// for each block and delta light.
pub(super) fn scatter<S: Simd, B: LaneBsdf<S>>(
    simd: S,
    blocks: &mut [Block],
    lights: &LightSet,
    delta: &mut Vec<DeltaBlock>,
    lobes: FollowedLobes,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            for block in blocks {
                let frame = FrameLanes::new(simd, block);
                let bsdf = B::load(simd, block, frame.wo);
                for light in lights.delta_lights() {
                    delta.push(sample_delta_light(simd, block, (&frame, &bsdf), light));
                }
                block.scattered = scatter_block(simd, block, (&frame, &bsdf), lobes);
            }
        },
    );
}

#[inline(always)]
fn scatter_block<S: Simd, B: LaneBsdf<S>>(
    simd: S,
    block: &Block,
    (frame, bsdf): (&FrameLanes<S>, &B),
    lobes: FollowedLobes,
) -> ScatteredBlock {
    let valid = frame.is_finite & LaneMask::from_bits(simd, block.valid);
    let (mut scattered, mut valid) = reflect_sampled_light(simd, block, (frame, bsdf), (lobes, valid));
    scattered.valid = valid.bits();
    if lobes == FollowedLobes::Nothing {
        return scattered;
    }

    // Next direction.
    let (zero, horizon) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, HORIZON));
    let throughput = Lanes::load_vector(simd, &block.throughput);
    let [u, v] = &block.u_bsdf;
    let u = [Lanes::load(simd, u), Lanes::load(simd, v)];
    let SampledLanes { local, value, pdf, is_valid, diffuse } = bsdf.sample(Lanes::load(simd, &block.u_lobe), u, lobes);
    scattered.diffuse = diffuse;
    let height = Real::select(frame.is_above, local.z, -local.z);
    let [tangent, bitangent] = frame.tangents;
    let next = tangent * local.x + bitangent * local.y + frame.shading_normal * height;
    let continued = is_valid & local.z.gt(horizon) & next.dot(frame.towards_viewer).gt(zero);
    let after = throughput.scaled_by(value * (local.z / pdf));
    let geometric_normal = frame.geometric_normal;
    let outwards = Vector3::select(next.dot(geometric_normal).lt(zero), -geometric_normal, geometric_normal);
    let (next_origin, is_offset) = offset_point(frame.point, frame.point_error, geometric_normal, outwards);
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
