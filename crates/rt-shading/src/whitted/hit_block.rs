//! Blocks of eight hits on shapes of one kind, and what is computed for them in lanes.

use super::{
    hit_queue::{QueuedHit, eight},
    lane_phong::{LanePhong, UniformPhong},
    point_lanes::{PointLanes, ShapeLanes, each, gather, gather_vector, odd_squares},
    wave::TreePath,
};
use crate::{
    DeltaLight, ShadingFeatures,
    lanes::{LANES, LaneArray, LaneMask, Lanes, Simd, first_lanes, get, is_zero},
    optics,
};
use rt_geometry::offset_point;
use rt_math::float::is_sign_certain;
use rt_math::{Interval, Mask, Ray, Real, Vector3};

/// Eight hits: surfaces, and media on both sides. Bit `i` of a mask is for lane `i`.
pub(super) struct HitBlock<S: Simd> {
    /// Lanes with valid results; all others are shaded one by one.
    pub(super) valid: u8,
    /// Lanes whose surface is seen from behind: from the inside of a sphere.
    pub(super) inside: u8,
    /// Lanes on an odd square of a checkerboard.
    pub(super) odd: u8,
    /// Lanes whose rays may be followed.
    pub(super) continues: u8,
    /// Indices of the camera rays.
    pub(super) samples: [u32; LANES],
    /// Times of the rays.
    pub(super) times: LaneArray,
    /// Weights of the radiance in the pixel, after absorption.
    pub(super) weight: Vector3<LaneArray>,
    /// Lengths of the directions of the rays.
    pub(super) length: LaneArray,
    /// Lanes whose weight a medium has reduced.
    pub(super) absorbed: u8,
    /// Lanes whose surface transmits light.
    pub(super) transmits: u8,
    /// Index of refraction before the surface divided by that behind it; 1 where no light is transmitted.
    pub(super) eta: LaneArray,
    surface: SurfaceLanes<S>,
}

/// Surfaces of eight hits, in registers.
struct SurfaceLanes<S: Simd> {
    point: Vector3<Lanes<S>>,
    error: Vector3<Lanes<S>>,
    /// Unit normals on the outside.
    outside: Vector3<Lanes<S>>,
    /// Unit normals on the viewer's side.
    normal: Vector3<Lanes<S>>,
    /// Unit directions of the rays.
    direction: Vector3<Lanes<S>>,
    is_inside: LaneMask<S>,
    /// Origins of shadow rays and mirrored rays.
    near_origin: Vector3<Lanes<S>>,
}

/// Secondary rays of eight hits.
#[derive(Default)]
pub(super) struct SecondaryRays {
    pub(super) mirrored: RayBlock,
    pub(super) refracted: RayBlock,
    /// Lanes with a material that reflects or transmits in one direction, whether or not rays are followed.
    pub(super) is_specular: u8,
    /// Lanes for which Fresnel's equations were evaluated.
    pub(super) fresnel: u8,
}

/// Rays from eight hits.
#[derive(Default)]
pub(super) struct RayBlock {
    /// Lanes with a ray.
    pub(super) mask: u8,
    pub(super) origin: Vector3<LaneArray>,
    pub(super) direction: Vector3<LaneArray>,
    /// Weights of their radiance in the pixel.
    pub(super) weight: Vector3<LaneArray>,
}

/// Light from one light that eight surfaces reflect, in registers. Bit `i` of a mask is for lane `i`.
pub(super) struct ReflectedLanes<S: Simd> {
    /// Valid lanes that reflect light. All else holds only there.
    pub(super) lit: u8,
    /// Valid lanes whose highlight was evaluated.
    pub(super) highlights: u8,
    /// Radiance if the light is not occluded.
    pub(super) radiance: Vector3<Lanes<S>>,
    pub(super) shadow_direction: Vector3<Lanes<S>>,
    pub(super) shadow_end: Lanes<S>,
}

/// Phong models of eight hits, in registers.
pub(super) struct PhongLanes<'a, S: Simd> {
    pub(super) models: [&'a UniformPhong; LANES],
    diffuse: Vector3<Lanes<S>>,
    specular: Vector3<Lanes<S>>,
    has_highlight: LaneMask<S>,
}

impl<S: Simd> HitBlock<S> {
    /// Computes the surfaces of one to eight hits of rays. Rays may be followed for up to `max_depth` bounces.
    #[inline(always)]
    pub(super) fn new<T: ShapeLanes>(
        simd: S,
        (hits, phongs): (&[QueuedHit<T>], [&LanePhong; LANES]),
        (rays, paths): (&[(Ray, Interval)], &[TreePath]),
        max_depth: u32,
    ) -> Self {
        let hit_lanes = first_lanes(hits.len());
        let hits = eight(hits);
        let shapes = each!(hits, |hit| &hit.shape);
        let paths = each!(hits, |hit| &paths[hit.ray as usize]);
        let rays = each!(hits, |hit| &rays[hit.ray as usize].0);
        let origin = gather_vector!(simd, rays, |ray| ray.origin, x y z);
        let direction = gather_vector!(simd, rays, |ray| ray.direction, x y z);
        let t = gather!(simd, hits, |queued| queued.t);
        let (odd, has_colours) = odd_squares(simd, shapes, phongs, [origin, direction], t);
        let PointLanes { point, error, outside, has_normal } = T::points(simd, shapes, [origin, direction], t);
        let length = direction.length();
        let direction = direction / length;
        let is_inside = direction.dot(outside).gt(Lanes::splat(simd, 0.0));
        let normal = Vector3::select(is_inside, -outside, outside);
        let (near_origin, is_offset) = offset_point(point, error, outside, normal);
        let [a, b, c, d, e, f, g, h] = each!(paths, |path, lane| u8::from(path.depth < max_depth) << lane);
        Self {
            valid: hit_lanes & has_colours & (has_normal & is_offset).bits(),
            inside: is_inside.bits(),
            odd,
            continues: a | b | c | d | e | f | g | h,
            samples: each!(paths, |path| path.sample),
            times: each!(rays, |ray| ray.time),
            weight: Lanes::store_vector(gather_vector!(simd, paths, |path| path.weight, r g b)),
            length: length.store(),
            absorbed: 0,
            transmits: 0,
            eta: [1.0; LANES],
            surface: SurfaceLanes { point, error, outside, normal, direction, is_inside, near_origin },
        }
    }

    /// Computes the mirrored and refracted rays. Rays that weigh less than `min_contribution` in all components are left out.
    #[inline(always)]
    pub(super) fn secondary_rays(
        &mut self,
        simd: S,
        phongs: [&UniformPhong; LANES],
        (features, min_contribution): (&ShadingFeatures, f64),
    ) -> SecondaryRays {
        let &SurfaceLanes { point, error, outside, normal, direction, is_inside, near_origin } = &self.surface;
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        let weight = Lanes::load_vector(simd, &self.weight);
        let mut rays = SecondaryRays::default();
        let mut reflected_part = one;
        let transmits = self.transmits;
        if transmits & self.continues != 0 {
            let eta = Lanes::load(simd, &self.eta);
            // An index-matched interface does not deflect or reflect the ray.
            let is_null = eta.eq(one);
            let [a, b, c, d, e, f, g, h] = each!(phongs, |phong, lane| phong.fresnel_bit(lane));
            let has_fresnel = transmits & (a | b | c | d | e | f | g | h);
            let is_fresnel = LaneMask::from_bits(simd, has_fresnel);
            if features.fresnel && has_fresnel != 0 {
                rays.fresnel = has_fresnel;
                let reflectance = Real::select(is_null, zero, optics::fresnel(-direction.dot(normal), eta));
                reflected_part = Real::select(is_fresnel, reflectance, one);
            }
            let passed_part = Real::select(is_fresnel, one - reflected_part, one);
            let coefficient = gather_vector!(simd, phongs, |phong| phong.transmission_coefficient(), r g b);
            let weight = weight.scaled_by(coefficient) * passed_part;
            let (is_significant, is_known) = is_significant(weight, min_contribution);
            let (sin_i, is_certain) = sine(direction, normal);
            let (refracted, is_transmitted) = optics::refract_lanes(direction, normal, eta, sin_i);
            let turns_back = refracted.dot(-normal).lt(zero);
            let refracted = Vector3::select(turns_back, optics::reflect_lanes(refracted, -normal), refracted);
            let refracted = Vector3::select(is_null, direction, refracted);
            let outwards = Vector3::select(refracted.dot(outside).lt(zero), -outside, outside);
            let (origin, is_offset) = offset_point(point, error, outside, outwards);
            let mask = transmits & (is_significant & (is_transmitted | is_null)).bits();
            rays.refracted = RayBlock::new(mask, [origin, refracted, weight]);
            self.valid &= !transmits | (is_certain & is_offset & is_known).bits();
        }
        let mirror = gather_vector!(simd, phongs, |phong| phong.mirror, r g b);
        rays.is_specular = transmits | (!is_zero(mirror)).bits();
        if features.reflection && self.continues != 0 {
            let weight = weight.scaled_by(mirror) * reflected_part;
            let (is_significant, is_known) = is_significant(weight, min_contribution);
            let mirrored = optics::reflect_lanes(direction, normal);
            let mirrored =
                Vector3::select(mirrored.dot(normal).lt(zero), optics::reflect_lanes(mirrored, normal), mirrored);
            // The ray starts where shadow rays do if its sign is that of the normal.
            let leaves_behind = mirrored.dot(outside).lt(zero);
            let is_near = (leaves_behind & is_inside) | (!leaves_behind & !is_inside);
            rays.mirrored = RayBlock::new(is_significant.bits(), [near_origin, mirrored, weight]);
            self.valid &= (is_near & is_known).bits();
        }
        rays
    }

    /// Excludes lanes on whose tangent plane a light is, up to rounding: the sign of its cosine is uncertain.
    #[inline(always)]
    pub(super) fn exclude_grazing_lights(&mut self, simd: S, lights: &[DeltaLight]) {
        let &SurfaceLanes { point, normal, .. } = &self.surface;
        let zero = Lanes::splat(simd, 0.0);
        for light in lights {
            if let Some(position) = light.kind.position() {
                let is_above = (Vector3::splat(zero, position) - point).dot(normal).gt(zero);
                self.valid &= (is_above | light.is_behind(point, normal)).bits();
            }
        }
    }

    /// Computes the light that the surfaces reflect from one light, if it is not occluded.
    #[inline(always)]
    pub(super) fn reflect(&self, simd: S, light: &DeltaLight, phongs: &PhongLanes<'_, S>) -> ReflectedLanes<S> {
        let &SurfaceLanes { point, normal, direction, near_origin, .. } = &self.surface;
        let zero = Lanes::splat(simd, 0.0);
        let black = Vector3::new(zero, zero, zero);
        let is_behind = light.is_behind(point, normal);
        if is_behind.all() {
            return ReflectedLanes {
                lit: 0,
                highlights: 0,
                radiance: black,
                shadow_direction: black,
                shadow_end: zero,
            };
        }
        let incident = light.sample_li_lanes(point);
        let wi = incident.direction;
        let cos = normal.dot(wi);
        let faces = !is_behind & incident.is_lit & cos.gt(zero);
        let mut reflectance = phongs.diffuse * cos;
        let highlights = phongs.has_highlight & faces;
        if highlights.any() {
            let shiny = reflectance + phongs.specular * phongs.highlight_strength(simd, [normal, -direction, wi]);
            reflectance = Vector3::select(phongs.has_highlight, shiny, reflectance);
        }
        let radiance = reflectance.scaled_by(incident.strength) * zero.splat(light.units.classical_factor());
        let shadow_direction = match light.kind.position() {
            None => wi,
            Some(position) => Vector3::splat(zero, position) - near_origin,
        };
        ReflectedLanes {
            lit: self.valid & (faces & !is_zero(radiance)).bits(),
            highlights: self.valid & highlights.bits(),
            radiance,
            shadow_direction,
            shadow_end: light.shadow_end(shadow_direction),
        }
    }

    /// Origins of shadow rays and mirrored rays.
    #[inline(always)]
    pub(super) fn near_origin(&self) -> Vector3<LaneArray> {
        Lanes::store_vector(self.surface.near_origin)
    }

    /// Emission and reflected ambient light.
    #[inline(always)]
    pub(super) fn radiance(&self, simd: S, phongs: [&UniformPhong; LANES]) -> Vector3<Lanes<S>> {
        let radiance = each!(phongs, |phong, lane| phong.radiance_from(self.inside >> lane));
        gather_vector!(simd, radiance, |radiance| radiance, r g b)
    }
}

impl RayBlock {
    #[inline(always)]
    fn new<S: Simd>(mask: u8, [origin, direction, weight]: [Vector3<Lanes<S>>; 3]) -> Self {
        let (origin, direction) = (Lanes::store_vector(origin), Lanes::store_vector(direction));
        Self { mask, origin, direction, weight: Lanes::store_vector(weight) }
    }

    /// Ray of a lane.
    #[inline(always)]
    pub(super) fn ray(&self, lane: usize, time: f64) -> Ray {
        Ray { origin: get(&self.origin, lane), direction: get(&self.direction, lane), time }
    }
}

impl<'a, S: Simd> PhongLanes<'a, S> {
    /// Loads the models of eight hits.
    #[inline(always)]
    pub(super) fn new(simd: S, models: [&'a UniformPhong; LANES]) -> Self {
        let diffuse = gather_vector!(simd, models, |phong| phong.diffuse, r g b);
        let specular = gather_vector!(simd, models, |phong| phong.specular, r g b);
        Self { models, diffuse, specular, has_highlight: !is_zero(specular) }
    }

    /// Version of [`Highlight::strength`](crate::Highlight::strength) for eight models, given the normal, `wo` and `wi`.
    #[inline(always)]
    fn highlight_strength(&self, simd: S, vectors: [Vector3<Lanes<S>>; 3]) -> Lanes<S> {
        let first = self.models[0];
        let mut strength = first.highlight_strength(vectors);
        for lane in 1..LANES {
            let model = self.models[lane];
            if model.highlight() != first.highlight() {
                let other = model.highlight_strength(vectors);
                strength = Real::select(LaneMask::from_bits(simd, 1 << lane), other, strength);
            }
        }
        strength
    }
}

/// Version of [`Whitted::is_significant`](super::Whitted::is_significant) for eight weights, and true where its result holds: for
/// numbers.
#[inline(always)]
pub(super) fn is_significant<R: Real>(weight: Vector3<R>, min_contribution: f64) -> (R::Mask, R::Mask) {
    let sum = weight.x + weight.y + weight.z;
    let is_large = !weight.x.max(weight.y).max(weight.z).lt(sum.splat(min_contribution));
    (is_large & !is_zero(weight), sum.eq(sum))
}

/// Sine of the angle between two unit vectors, and true where it has the bits of that from [`cross`](rt_math::float::cross).
#[inline(always)]
fn sine<R: Real>(a: Vector3<R>, b: Vector3<R>) -> (R, R::Mask) {
    let products = [[a.y * b.z, a.z * b.y], [a.z * b.x, a.x * b.z], [a.x * b.y, a.y * b.x]];
    let [[x, x1], [y, y1], [z, z1]] = products;
    let cross = Vector3::new(x - x1, y - y1, z - z1);
    let is_certain =
        is_sign_certain(cross.x, x, x1) & is_sign_certain(cross.y, y, y1) & is_sign_certain(cross.z, z, z1);
    (cross.length(), is_certain)
}
