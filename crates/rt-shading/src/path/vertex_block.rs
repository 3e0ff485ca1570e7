//! Blocks of eight path vertices, and their shading frames in lanes.

use crate::{
    bsdf::{DiffusePhongLanes, HORIZON, MetallicRoughnessBlock},
    lanes::{LaneArray, LaneMask, Lanes, Simd},
    viewed_surface::MIN_COSINE,
};
use rt_geometry::offset_point;
use rt_math::{Real, Vector3, tangents};

/// Eight vertices: inputs, light samples and results.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    /// Lanes without a rare case so far; all others are shaded one by one.
    pub(super) valid: u8,
    /// Shapes whose surfaces are computed in lanes.
    pub(super) shapes: ShapeBlock,
    pub(super) point: Vector3<LaneArray>,
    pub(super) point_error: Vector3<LaneArray>,
    pub(super) shadow_point: Vector3<LaneArray>,
    pub(super) geometric_normal: Vector3<LaneArray>,
    pub(super) shading_normal: Vector3<LaneArray>,
    /// Unit directions of the rays.
    pub(super) direction: Vector3<LaneArray>,
    /// −1 where the surface is seen from behind, 1 elsewhere.
    pub(super) side: LaneArray,
    /// Albedo of the diffuse lobe, or base colour.
    pub(super) albedo: Vector3<LaneArray>,
    /// Roughness: of a diffuse lobe in [0, 1], 0 for Lambert's law.
    pub(super) roughness: LaneArray,
    /// Phong lobes, in queues of surfaces that have them.
    pub(super) phong: PhongBlock,
    /// Further parameters, in queues of metallic-roughness surfaces.
    pub(super) layer: MetallicRoughnessBlock,
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

/// Shapes of eight hits. Bit `i` of a mask is for lane `i`; the numbers of lanes in no mask are left over.
#[derive(Clone, Debug, Default)]
pub(super) struct ShapeBlock {
    /// Lanes with a triangle, and with a sphere.
    pub(super) triangles: u8,
    pub(super) spheres: u8,
    /// Vertices of a triangle, or centre of a sphere and origin of the ray.
    pub(super) points: [Vector3<LaneArray>; 3],
    /// Barycentric weights of the second and third vertex, or radius and ray parameter.
    pub(super) numbers: [LaneArray; 2],
    /// Directions of the rays, of any length.
    pub(super) direction: Vector3<LaneArray>,
}

/// Phong lobes of eight vertices, with the weights and probabilities of [`WeightedPhong`](crate::bsdf::WeightedPhong).
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
    /// Lobes that are not diffuse, and diffuse ones below a layer. The latter end the path.
    Specular,
    /// All lobes of the surface.
    All,
}

/// Light samples of eight vertices.
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

/// Light of one delta light at eight vertices. Bit `i` of a mask is for lane `i`.
#[derive(Clone, Debug, Default)]
pub(super) struct DeltaBlock {
    /// Lanes that reflect light.
    pub(super) lit: u8,
    /// Lanes that the light reaches, but that reflect nothing.
    pub(super) black: u8,
    /// Contributions of unoccluded light.
    pub(super) radiance: Vector3<LaneArray>,
    /// Directions of shadow rays, and the parameters at which they end, for a light that casts shadows.
    pub(super) shadow_direction: Vector3<LaneArray>,
    pub(super) shadow_end: LaneArray,
}

/// Results of eight vertices. Bit `i` of a mask is for lane `i`.
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

/// Shading frames of eight vertices, in registers.
pub(super) struct FrameLanes<S: Simd> {
    pub(super) point: Vector3<Lanes<S>>,
    pub(super) point_error: Vector3<Lanes<S>>,
    pub(super) geometric_normal: Vector3<Lanes<S>>,
    pub(super) shading_normal: Vector3<Lanes<S>>,
    pub(super) tangents: [Vector3<Lanes<S>>; 2],
    /// Directions to the viewer, above the surface.
    pub(super) wo: Vector3<Lanes<S>>,
    /// Geometric normals on the viewer's side.
    pub(super) towards_viewer: Vector3<Lanes<S>>,
    /// True where the viewer is on the side of the shading normal.
    pub(super) is_above: LaneMask<S>,
    /// True where directions and normals are finite.
    pub(super) is_finite: LaneMask<S>,
    /// Negative behind the surface.
    side: Lanes<S>,
}

/// Directions of light from eight points, in registers.
pub(super) struct IncidentLanes<S: Simd> {
    /// In the shading frame, above the surface if `is_reflected`.
    pub(super) local: Vector3<Lanes<S>>,
    /// Absolute cosines to the shading normal.
    pub(super) cos: Lanes<S>,
    /// True where light arrives on the viewer's side of both normals.
    pub(super) is_reflected: LaneMask<S>,
}

impl Block {
    /// Loads the BSDFs; without `has_phong` only their diffuse lobes.
    #[inline(always)]
    pub(super) fn load_bsdf<S: Simd>(&self, simd: S, has_phong: bool) -> DiffusePhongLanes<Lanes<S>> {
        let zero = Lanes::splat(simd, 0.0);
        let mut bsdf = DiffusePhongLanes {
            albedo: Lanes::load_vector(simd, &self.albedo),
            roughness: Lanes::load(simd, &self.roughness),
            reflectance: Vector3::new(zero, zero, zero),
            exponent: zero,
            weights: [zero; 2],
            probabilities: [zero; 2],
        };
        if has_phong {
            let PhongBlock { reflectance, exponent, weights: [a, b], probabilities: [c, d] } = &self.phong;
            bsdf.reflectance = Lanes::load_vector(simd, reflectance);
            bsdf.exponent = Lanes::load(simd, exponent);
            bsdf.weights = [Lanes::load(simd, a), Lanes::load(simd, b)];
            bsdf.probabilities = [Lanes::load(simd, c), Lanes::load(simd, d)];
        }
        bsdf
    }
}

impl<S: Simd> FrameLanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, block: &Block) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let direction = Lanes::load_vector(simd, &block.direction);
        let geometric_normal = Lanes::load_vector(simd, &block.geometric_normal);
        let shading_normal = Lanes::load_vector(simd, &block.shading_normal);
        let side = Lanes::load(simd, &block.side);
        let [tangent, bitangent] = tangents(shading_normal);
        let cos_view = (-direction).dot(shading_normal);
        let min = side * MIN_COSINE;
        let cos_view = Real::select((cos_view * side).lt(zero + MIN_COSINE), min, cos_view);
        Self {
            point: Lanes::load_vector(simd, &block.point),
            point_error: Lanes::load_vector(simd, &block.point_error),
            geometric_normal,
            shading_normal,
            tangents: [tangent, bitangent],
            wo: Vector3::new((-direction).dot(tangent), (-direction).dot(bitangent), cos_view.abs()),
            towards_viewer: Vector3::select(side.lt(zero), -geometric_normal, geometric_normal),
            is_above: cos_view.gt(zero),
            is_finite: direction.is_finite() & shading_normal.is_finite(),
            side,
        }
    }

    /// Light from these directions.
    #[inline(always)]
    pub(super) fn incident(&self, simd: S, wi: Vector3<Lanes<S>>) -> IncidentLanes<S> {
        let zero = Lanes::splat(simd, 0.0);
        let cos = wi.dot(self.shading_normal);
        let cos_above = Real::select(self.is_above, cos, -cos);
        let (is_up, is_geometrically_up) = (cos.gt(zero), wi.dot(self.geometric_normal).gt(zero));
        let sides_agree = (is_up & is_geometrically_up) | (!is_up & !is_geometrically_up);
        let [tangent, bitangent] = self.tangents;
        IncidentLanes {
            local: Vector3::new(wi.dot(tangent), wi.dot(bitangent), cos_above),
            cos: cos.abs(),
            is_reflected: sides_agree & cos_above.gt(Lanes::splat(simd, HORIZON)),
        }
    }

    /// Origins of shadow rays on the viewer's side, and a mask that is false where they are not valid.
    #[inline(always)]
    pub(super) fn shadow_origin(&self, simd: S, block: &Block) -> (Vector3<Lanes<S>>, LaneMask<S>) {
        let shadow_point = Lanes::load_vector(simd, &block.shadow_point);
        let lift = (shadow_point - self.point).dot(self.geometric_normal);
        let start = Vector3::select((lift * self.side).lt(Lanes::splat(simd, 0.0)), self.point, shadow_point);
        offset_point(start, self.point_error, self.geometric_normal, self.towards_viewer)
    }

    /// True where shadow rays in these directions start on the viewer's side. Those to the far side are rare, and start elsewhere.
    #[inline(always)]
    pub(super) fn starts_near(&self, simd: S, direction: Vector3<Lanes<S>>) -> LaneMask<S> {
        let zero = Lanes::splat(simd, 0.0);
        let (leaves_behind, is_behind) = (direction.dot(self.shading_normal).lt(zero), self.side.lt(zero));
        (leaves_behind & is_behind) | (!leaves_behind & !is_behind)
    }
}

/// Replaces vectors where the mask is true.
#[inline(always)]
pub(super) fn replace<S: Simd>(
    simd: S,
    lanes: &mut Vector3<LaneArray>,
    mask: LaneMask<S>,
    computed: Vector3<Lanes<S>>,
) {
    *lanes = Lanes::store_vector(Vector3::select(mask, computed, Lanes::load_vector(simd, lanes)));
}
