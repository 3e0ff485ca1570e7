//! Surfaces of the hits of several rays.

use super::{
    lane_material::{LaneMaterials, VertexKind},
    path_stream::PathStream,
};
use crate::{
    bsdf::{
        DiffusePhong, GlassBlock, LaneSurface, LayeredBlock, MetalBlock, MetallicRoughnessBlock, MirrorBlock,
        WeightedPhong,
    },
    interior_list::{MediumEntry, MediumInterface},
    lane_set::{Element, LaneSet, set_color},
    lanes::{LANES, LaneArray, each_lane},
    light::LightId,
    stream_queries::StreamQueries,
    wavefront::{gathered_shapes::GatheredShapes, streams::attenuated},
};
use rt_geometry::{HitStream, SurfaceInteraction};
use rt_math::{Rgb, Vector3};

/// Hits of a wave, grouped by the code that shades them.
#[derive(Clone, Debug, Default)]
pub(super) struct HitGroups {
    kinds: Vec<VertexKind>,
    /// Surfaces that are known, in the order of their rays.
    surfaces: Vec<(SurfaceInteraction, LaneSurface)>,
    /// Rays of these, in this order.
    rays: Vec<u32>,
}

impl HitGroups {
    pub(super) fn clear(&mut self) {
        self.kinds.clear();
        self.surfaces.clear();
        self.rays.clear();
    }

    /// Appends the group of the next ray.
    #[inline(always)]
    pub(super) fn push(&mut self, kind: VertexKind) {
        self.kinds.push(kind);
    }

    /// Version of [`push`](Self::push) for a surface that is known.
    pub(super) fn push_surface(&mut self, interaction: &SurfaceInteraction, surface: &LaneSurface) {
        self.rays.push(self.kinds.len() as u32);
        self.kinds.push(VertexKind::of(surface));
        self.surfaces.push((*interaction, *surface));
    }

    /// Appends the same group for all rays that hit a primitive.
    pub(super) fn fill(&mut self, primitives: &[u32], kind: VertexKind) {
        let of_ray = |primitive: &u32| if *primitive == HitStream::NONE { VertexKind::Done } else { kind };
        self.kinds.extend(primitives.iter().map(of_ray));
    }

    /// True if lanes would stay empty, because other rays lie between those that are shaded in lanes.
    pub(super) fn is_sparse(&self) -> bool {
        let is_shaded = |kind: &VertexKind| *kind != VertexKind::Done;
        let in_vector = |kinds: &[VertexKind]| kinds.iter().filter(|kind| is_shaded(kind)).count();
        let counts = self.kinds().chunks(LANES).map(in_vector).filter(|count| *count > 0);
        let (n_vectors, n_rays) = counts.fold((0, 0), |(vectors, rays), count| (vectors + 1, rays + count));
        n_rays < n_vectors * LANES * 3 / 4
    }

    /// Copies the rays that are shaded in lanes with their hits, and leaves out all others.
    pub(super) fn compact<E: Element>(
        &mut self,
        (paths, hits): (&PathStream<E>, &HitStream),
        (dense, dense_hits): &mut (PathStream<E>, HitStream),
    ) {
        dense.rays.clear();
        let mut known = self.rays.iter_mut().peekable();
        for at in 0..self.kinds.len() {
            if self.kinds[at] == VertexKind::Done {
                continue;
            }
            let to = dense.rays.len();
            if let Some(ray) = known.next_if(|ray| **ray == at as u32) {
                *ray = to as u32;
            }
            self.kinds[to] = self.kinds[at];
            dense.push_from(paths, at);
            dense_hits.set(to, hits.get(at).as_ref());
        }
        self.kinds.truncate(dense.rays.len());
    }

    /// Group of each ray.
    pub(super) fn kinds(&self) -> &[VertexKind] {
        &self.kinds
    }

    /// The surface of a ray, if it is known.
    #[inline(always)]
    fn surface(&self, at: usize) -> Option<&(SurfaceInteraction, LaneSurface)> {
        if self.rays.is_empty() {
            return None;
        }
        self.surfaces.get(self.rays.binary_search(&(at as u32)).ok()?)
    }
}

/// Surfaces of hits, one for each lane.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered<E: Element> {
    pub(super) shapes: GatheredShapes,
    /// Lanes whose hits are gathered; all others end their path.
    pub(super) valid: u8,
    /// Those whose path ends after emission.
    pub(super) emission_only: u8,
    /// Lanes of emissive materials, with the radiance of both sides.
    pub(super) emissive: u8,
    pub(super) emission: [[Rgb; 2]; LANES],
    pub(super) lights: [Option<LightId>; LANES],
    pub(super) bsdfs: GatheredBsdfs,
    /// Medium entries of lanes of glass, and the media on both sides of their surfaces, which are found later.
    pub(super) medium_entries: [MediumEntry; LANES],
    pub(super) interfaces: [Option<MediumInterface>; LANES],
    /// Lanes of glass in a medium that absorbs, and the throughput of their paths after absorption.
    pub(super) absorbed: u8,
    pub(super) dimmed: [[E; LANES]; 3],
}

impl<E: Element> Gathered<E> {
    /// Light that the lanes of a mask scatter, attenuated by the media of rough glass. Lanes of `below` are lit through the medium behind
    /// the surface. The end of the medium towards a light at infinity is unknown: such light is not attenuated.
    pub(super) fn attenuated<L: LaneSet<Element = E>>(
        &self,
        lanes: L,
        light: &(Vector3<L::F>, L::D),
        mask: u8,
        below: u8,
    ) -> Vector3<L::F> {
        attenuated(lanes, light, mask, |lane, distance| {
            let Some(interface) = self.interfaces[lane & 7].as_ref().filter(|_| distance.is_finite()) else {
                return Rgb::WHITE;
            };
            let medium = if below >> lane & 1 == 1 { &interface.after } else { &interface.before };
            medium.transmittance(distance)
        })
    }
}

/// BSDFs of hits, one for each lane. Lanes of no mask have a Lambertian lobe.
#[derive(Clone, Debug, Default)]
pub(super) struct GatheredBsdfs {
    /// Lanes of each kind.
    pub(super) rough: u8,
    pub(super) glossy: u8,
    /// Mirrors of some glossy surfaces.
    pub(super) mirrors: MirrorBlock,
    pub(super) metallic_roughness: u8,
    /// Albedo of the diffuse lobe, or base colour.
    pub(super) albedo: [LaneArray; 3],
    /// Roughness; that of a diffuse lobe is in [0, 1].
    pub(super) roughness: LaneArray,
    /// Phong lobes, with the weights and probabilities of [`WeightedPhong`].
    pub(super) reflectance: [LaneArray; 3],
    pub(super) exponent: LaneArray,
    pub(super) weights: [LaneArray; 2],
    pub(super) probabilities: [LaneArray; 2],
    /// Further parameters of metallic-roughness surfaces.
    pub(super) layers: MetallicRoughnessBlock,
    pub(super) layered: LayeredBlock,
    pub(super) metals: MetalBlock,
    pub(super) glass: GlassBlock,
}

impl GatheredBsdfs {
    const fn clear(&mut self) {
        (self.rough, self.glossy, self.metallic_roughness) = (0, 0, 0);
        self.mirrors.all = 0;
        self.layered.clear();
        self.metals.clear();
        self.glass.clear();
    }

    /// Lanes whose lobes are delta distributions.
    pub(super) const fn delta(&self) -> u8 {
        self.metals.delta | (self.glass.all & !self.glass.rough)
    }

    /// Lanes of BSDFs that are not Lambertian.
    pub(super) const fn others(&self) -> u8 {
        self.rough | self.glossy | self.metallic_roughness | self.layered.all | self.metals.all | self.glass.all
    }

    /// Sets the BSDF of a lane, once.
    #[inline(always)]
    fn set(&mut self, lane: usize, surface: &LaneSurface) {
        let lane = lane % LANES;
        match surface {
            LaneSurface::DiffusePhong(lobes) => self.set_diffuse_phong(lane, lobes),
            LaneSurface::MirrorMix(mix) => {
                self.set_diffuse_phong(lane, &mix.lobes);
                self.mirrors.set(lane, mix);
            }
            LaneSurface::MetallicRoughness(layer) => {
                self.metallic_roughness |= 1 << lane;
                set_color(&mut self.albedo, lane, layer.surface.base_color);
                self.roughness[lane] = layer.surface.roughness;
                self.layers.set(lane, layer);
            }
            LaneSurface::Layered(surface) => self.layered.set(lane, surface),
            LaneSurface::Conductor(conductor) => self.metals.set_conductor(lane, conductor),
            LaneSurface::Mirror(mirror) => self.metals.set_mirror(lane, mirror),
            LaneSurface::Glass(surface) => self.glass.set(lane, surface),
        }
    }

    /// Sets a diffuse lobe, and a Phong lobe if there is one, in one lane.
    #[inline(always)]
    fn set_diffuse_phong(&mut self, lane: usize, DiffusePhong { diffuse, highlight }: &DiffusePhong) {
        set_color(&mut self.albedo, lane, diffuse.albedo);
        if highlight.is_none() && !(diffuse.roughness > 0.0) {
            return;
        }
        self.roughness[lane] = diffuse.clamped_roughness();
        let Some(WeightedPhong { lobe, weights, probabilities }) = highlight else {
            self.rough |= 1 << lane;
            return;
        };
        self.glossy |= 1 << lane;
        set_color(&mut self.reflectance, lane, lobe.reflectance);
        self.exponent[lane] = lobe.clamped_exponent();
        for part in 0..2 {
            self.weights[part][lane] = weights[part];
            self.probabilities[part][lane] = probabilities[part];
        }
    }
}

/// Gathers the surfaces of the hits of a mask, from index `at` on.
pub(super) fn gather<E: Element>(
    world: &dyn StreamQueries,
    materials: &LaneMaterials,
    (hits, groups, first): (&HitStream, &HitGroups, usize),
    mask: u8,
    gathered: &mut Gathered<E>,
) {
    let Gathered { shapes, valid, emission_only, emissive, emission, lights, bsdfs, medium_entries, .. } = gathered;
    shapes.clear();
    bsdfs.clear();
    (*valid, *emission_only, *emissive) = (0, 0, 0);
    for lane in each_lane(mask) {
        let (lane, at) = (lane % LANES, first + lane);
        let kind = groups.kinds.get(at).copied().unwrap_or_default();
        if kind == VertexKind::Done {
            continue;
        }
        if let Some((interaction, surface)) = groups.surface(at) {
            shapes.set_surface(lane, interaction);
            bsdfs.set(lane, surface);
        } else {
            let Some(primitive) = world.primitive(hits, at) else { continue };
            let Some(material) = materials.get(primitive.material) else { continue };
            shapes.set(lane, &primitive.shape);
            bsdfs.set(lane, &material.surface);
            if matches!(kind, VertexKind::Glass | VertexKind::RoughGlass) {
                medium_entries[lane] = MediumEntry { object: primitive.object, material: primitive.material };
            }
            if !material.emission[0].is_black() {
                *emissive |= 1 << lane;
                (emission[lane], lights[lane]) = (material.emission, primitive.light);
            }
        }
        *valid |= 1 << lane;
        if kind == VertexKind::EmissionOnly {
            *emission_only |= 1 << lane;
        }
    }
}
