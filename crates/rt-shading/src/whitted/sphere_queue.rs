//! Queue of hits on spheres, which are shaded in lanes.
//!
//! ```text
//!   hits ─▶ surfaces ─▶ media on both sides ─▶ direct light, directions of secondary rays ─▶ rays, hit by hit
//!            lanes             scalar                           lanes
//! ```
//!
//! Results have the bits of [`Whitted::shade`](super::Whitted::shade). Lanes in which a rare case occurs are shaded one by one.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "lanes need AVX2"))]

use super::{uniform_phong::UniformPhong, wave::TreePath};
use crate::{
    DeltaLight, Needs, SphereHit,
    interior_list::MediumInterface,
    lanes::{LANES, LaneArray, LaneLevel, LaneMask, Lanes, Simd, get, is_zero},
    optics,
};
use rt_geometry::{offset_point, sphere_point};
use rt_math::float::is_sign_certain;
use rt_math::{Interval, Mask, Ray, Real, Vector3};

/// Hits on spheres, with what is computed for them. The queue is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct SphereQueue {
    pub(super) hits: Vec<QueuedHit>,
    pub(super) blocks: Vec<SphereBlock>,
    /// Media on both sides by hit; `None` where no light is transmitted. Empty if that is so everywhere.
    pub(super) interfaces: Vec<Option<MediumInterface>>,
    /// Reflected light by block and light.
    lit: Vec<ReflectedLight>,
    n_lights: usize,
}

/// A hit of a ray of the batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueuedHit {
    /// Index of the ray.
    pub(super) ray: u32,
    pub(super) hit: SphereHit,
    pub(super) path: TreePath,
}

/// Surfaces of four hits, and secondary rays from there. Bit `i` of a mask is for lane `i`.
#[derive(Clone, Debug, Default)]
pub(super) struct SphereBlock {
    /// Lanes with valid results; all others are shaded one by one.
    pub(super) valid: u8,
    /// Lanes whose surface is seen from behind: from the inside of the sphere.
    pub(super) inside: u8,
    point: Vector3<LaneArray>,
    point_error: Vector3<LaneArray>,
    /// Unit normals on the outside.
    normal: Vector3<LaneArray>,
    /// Unit directions of the rays.
    pub(super) direction: Vector3<LaneArray>,
    /// Lengths of the directions of the rays.
    pub(super) length: LaneArray,
    /// Index of refraction before the surface divided by that behind it; 1 where no light is transmitted.
    pub(super) eta: LaneArray,
    /// Lanes whose surface transmits light.
    pub(super) transmits: u8,
    /// Lanes whose rays may be followed.
    pub(super) continues: u8,
    /// Origin of shadow rays and mirrored rays.
    pub(super) near_origin: Vector3<LaneArray>,
    pub(super) mirrored: Vector3<LaneArray>,
    /// Reflectance by Fresnel's equations.
    pub(super) reflectance: LaneArray,
    /// Lanes with a refracted ray: no total internal reflection.
    pub(super) refracts: u8,
    pub(super) refracted_origin: Vector3<LaneArray>,
    pub(super) refracted: Vector3<LaneArray>,
}

/// Light from one light that four surfaces reflect.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ReflectedLight {
    /// Lanes that reflect light. All else is valid only there.
    pub(super) lit: u8,
    /// Lanes whose highlight was evaluated.
    pub(super) highlights: u8,
    /// Radiance if the light is not occluded.
    pub(super) reflected: Vector3<LaneArray>,
    shadow_direction: Vector3<LaneArray>,
    shadow_end: LaneArray,
}

impl SphereQueue {
    /// Appends a hit of a ray.
    #[inline(always)]
    pub(super) fn push(&mut self, ray: usize, hit: SphereHit, path: TreePath) {
        self.hits.push(QueuedHit { ray: ray as u32, hit, path });
    }

    /// Removes all hits.
    pub(super) fn clear(&mut self) {
        self.hits.clear();
        self.interfaces.clear();
    }

    /// Light that a block of hits reflects, by light.
    #[inline(always)]
    pub(super) fn lit(&self, at: usize) -> &[ReflectedLight] {
        let first = at / LANES * self.n_lights;
        &self.lit[first..first + self.n_lights]
    }

    /// Computes the surfaces of all hits.
    pub(super) fn compute_surfaces(&mut self, level: LaneLevel, rays: &[(Ray, Interval)]) {
        // Blocks are kept: to clear them for each wave takes as long as to shade some hits.
        let n_blocks = self.hits.len().div_ceil(LANES);
        if self.blocks.len() < n_blocks {
            self.blocks.resize_with(n_blocks, SphereBlock::default);
        }
        match level {
            #[cfg(target_arch = "x86_64")]
            LaneLevel::Avx2(simd) => simd.vectorize(
                #[inline(always)]
                || {
                    for (hits, block) in self.hits.chunks(LANES).zip(&mut self.blocks) {
                        compute_surfaces(simd, four(hits), rays, block);
                    }
                },
            ),
        }
    }

    /// Computes the direct light on all hits, and the directions of secondary rays.
    pub(super) fn shade(
        &mut self,
        level: LaneLevel,
        phongs: &[Option<UniformPhong>],
        lights: &[DeltaLight],
        needs: &Needs,
    ) {
        self.n_lights = lights.len();
        let n_lit = self.hits.len().div_ceil(LANES) * self.n_lights;
        if self.lit.len() < n_lit {
            self.lit.resize(n_lit, ReflectedLight::default());
        }
        match level {
            #[cfg(target_arch = "x86_64")]
            LaneLevel::Avx2(simd) => simd.vectorize(
                #[inline(always)]
                || {
                    for (at, (hits, block)) in self.hits.chunks(LANES).zip(&mut self.blocks).enumerate() {
                        let [a, b, c, d] = four(hits);
                        let phongs = [phong(phongs, a), phong(phongs, b), phong(phongs, c), phong(phongs, d)];
                        let results = &mut self.lit[at * self.n_lights..(at + 1) * self.n_lights];
                        shade_block(simd, block, phongs, (lights, needs), results);
                    }
                },
            ),
        }
    }
}

impl ReflectedLight {
    /// Shadow ray of a lane that reflects light.
    #[inline(always)]
    pub(super) fn shadow_ray(&self, block: &SphereBlock, lane: usize, time: f64) -> (Ray, Interval) {
        let (origin, direction) = (get(&block.near_origin, lane), get(&self.shadow_direction, lane));
        (Ray { origin, direction, time }, Interval { max: self.shadow_end[lane], ..Interval::SPAWNED })
    }
}

/// Hits of a block; the last one repeats in lanes without a hit.
#[inline(always)]
fn four(hits: &[QueuedHit]) -> [&QueuedHit; LANES] {
    let last = hits.len() - 1;
    [&hits[0], &hits[1.min(last)], &hits[2.min(last)], &hits[last]]
}

/// Phong model of a hit. Only hits on uniform materials are queued.
#[inline(always)]
fn phong<'a>(phongs: &'a [Option<UniformPhong>], queued: &QueuedHit) -> &'a UniformPhong {
    phongs.get(queued.hit.material as usize).and_then(Option::as_ref).unwrap_or(&UniformPhong::BLACK)
}

/// Numbers of four items, in lanes.
macro_rules! gather {
    ($simd:expr, $items:expr, |$item:ident| $number:expr) => {{
        let [a, b, c, d] = $items;
        let numbers = [
            {
                let $item = a;
                $number
            },
            {
                let $item = b;
                $number
            },
            {
                let $item = c;
                $number
            },
            {
                let $item = d;
                $number
            },
        ];
        Lanes::load($simd, &numbers)
    }};
}

/// Vectors of four items, in lanes.
macro_rules! gather_vector {
    ($simd:expr, $items:expr, |$item:ident| $vector:expr, $x:ident $y:ident $z:ident) => {
        Vector3::new(
            gather!($simd, $items, |$item| $vector.$x),
            gather!($simd, $items, |$item| $vector.$y),
            gather!($simd, $items, |$item| $vector.$z),
        )
    };
}

#[inline(always)]
fn compute_surfaces<S: Simd>(simd: S, hits: [&QueuedHit; LANES], rays: &[(Ray, Interval)], block: &mut SphereBlock) {
    let [a, b, c, d] = hits;
    let four = [&rays[a.ray as usize].0, &rays[b.ray as usize].0, &rays[c.ray as usize].0, &rays[d.ray as usize].0];
    let origin = gather_vector!(simd, four, |ray| ray.origin, x y z);
    let direction = gather_vector!(simd, four, |ray| ray.direction, x y z);
    let centre = gather_vector!(simd, hits, |queued| queued.hit.sphere.centre(), x y z);
    let radius = gather!(simd, hits, |queued| queued.hit.sphere.radius());
    let t = gather!(simd, hits, |queued| queued.hit.t);
    let (normal, has_normal) = ((origin - centre) + direction * t).try_normalize();
    let (point, point_error) = sphere_point(centre, radius, normal);
    let length = direction.length();
    let direction = direction / length;
    let is_inside = direction.dot(normal).gt(Lanes::splat(simd, 0.0));
    block.valid = has_normal.bits();
    block.inside = is_inside.bits();
    block.point = Lanes::store_vector(point);
    block.point_error = Lanes::store_vector(point_error);
    block.normal = Lanes::store_vector(normal);
    block.direction = Lanes::store_vector(direction);
    block.length = length.store();
    block.eta = [1.0; LANES];
    block.transmits = 0;
    block.continues = 0;
}

#[inline(always)]
fn shade_block<S: Simd>(
    simd: S,
    block: &mut SphereBlock,
    phongs: [&UniformPhong; LANES],
    (lights, needs): (&[DeltaLight], &Needs),
    lit: &mut [ReflectedLight],
) {
    let zero = Lanes::splat(simd, 0.0);
    let (point, error) = (Lanes::load_vector(simd, &block.point), Lanes::load_vector(simd, &block.point_error));
    let outside = Lanes::load_vector(simd, &block.normal);
    let direction = Lanes::load_vector(simd, &block.direction);
    let is_inside = LaneMask::from_bits(simd, block.inside);
    let normal = Vector3::select(is_inside, -outside, outside);

    let (near_origin, is_offset) = offset_point(point, error, outside, normal);
    block.near_origin = Lanes::store_vector(near_origin);
    let mut valid = block.valid & is_offset.bits();

    let diffuse = gather_vector!(simd, phongs, |phong| phong.diffuse, r g b);
    let specular = gather_vector!(simd, phongs, |phong| phong.specular, r g b);
    let has_highlight = !is_zero(specular);
    for (light, lit) in lights.iter().zip(lit) {
        (lit.lit, lit.highlights) = (0, 0);
        let is_behind = light.is_behind(point, normal);
        if is_behind.all() {
            continue;
        }
        let incident = light.sample_li_lanes(point);
        let wi = incident.direction;
        let cos = normal.dot(wi);
        let faces = !is_behind & incident.is_lit & cos.gt(zero);
        let mut reflectance = diffuse * cos;
        if needs.highlights && (has_highlight & faces).any() {
            let strength = highlight_strength(simd, phongs, [normal, -direction, wi]);
            reflectance = Vector3::select(has_highlight, reflectance + specular * strength, reflectance);
            lit.highlights = (has_highlight & faces).bits();
        }
        let reflected = reflectance.scaled_by(incident.strength) * zero.splat(light.units.classical_factor());
        let is_lit = faces & !is_zero(reflected);
        lit.lit = is_lit.bits();
        lit.reflected = Lanes::store_vector(reflected);
        let shadow_direction = match light.kind.position() {
            None => wi,
            Some(position) => {
                let position = Vector3::splat(zero, position);
                // The sign of the cosine may differ from that of the unit direction.
                let is_above = (position - point).dot(normal).gt(zero);
                valid &= (is_above | !is_lit).bits();
                position - near_origin
            }
        };
        lit.shadow_direction = Lanes::store_vector(shadow_direction);
        lit.shadow_end = light.shadow_end(shadow_direction).store();
    }
    if needs.reflection && block.continues != 0 {
        let mirrored = optics::reflect_lanes(direction, normal);
        let mirrored =
            Vector3::select(mirrored.dot(normal).lt(zero), optics::reflect_lanes(mirrored, normal), mirrored);
        block.mirrored = Lanes::store_vector(mirrored);
        // The ray starts where shadow rays do if its sign is that of the normal.
        let leaves_behind = mirrored.dot(outside).lt(zero);
        valid &= ((leaves_behind & is_inside) | (!leaves_behind & !is_inside)).bits();
    }
    if block.transmits & block.continues != 0 {
        let transmits = block.transmits;
        let eta = Lanes::load(simd, &block.eta);
        let cos_i = -direction.dot(normal);
        block.reflectance = optics::fresnel(cos_i, eta).store();
        let (sin_i, is_certain) = sine(direction, normal);
        let (refracted, is_transmitted) = optics::refract_lanes(direction, normal, eta, sin_i);
        let turns_back = refracted.dot(-normal).lt(zero);
        let refracted = Vector3::select(turns_back, optics::reflect_lanes(refracted, -normal), refracted);
        // An index-matched interface does not deflect the ray.
        let is_null = eta.eq(zero.splat(1.0));
        let refracted = Vector3::select(is_null, direction, refracted);
        let outwards = Vector3::select(refracted.dot(outside).lt(zero), -outside, outside);
        let (origin, is_offset) = offset_point(point, error, outside, outwards);
        block.refracts = (is_transmitted | is_null).bits();
        block.refracted = Lanes::store_vector(refracted);
        block.refracted_origin = Lanes::store_vector(origin);
        valid &= !transmits | (is_certain & is_offset).bits();
    }
    block.valid = valid;
}

/// Strength of the highlights of four surfaces; the vectors are those of [`Highlight::strength`](crate::Highlight::strength).
#[inline(always)]
fn highlight_strength<S: Simd>(simd: S, phongs: [&UniformPhong; LANES], vectors: [Vector3<Lanes<S>>; 3]) -> Lanes<S> {
    let mut strength = phongs[0].highlight_strength(vectors);
    for lane in 1..LANES {
        if phongs[lane].highlight() != phongs[0].highlight() {
            let other = phongs[lane].highlight_strength(vectors);
            strength = Real::select(LaneMask::from_bits(simd, 1 << lane), other, strength);
        }
    }
    strength
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
