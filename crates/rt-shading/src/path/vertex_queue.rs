//! Queue of path vertices that are shaded in lanes, on surfaces of one kind.
//!
//! ```text
//!   hits ─▶ push ─▶ draw samples ─▶ surfaces of shapes ─▶ sample lights ─▶ scatter ─▶ shadow rays, next rays
//! ```
//!
//! Lanes in which a rare case occurs are marked, and shaded one by one.

use super::{
    direct_lighting_lanes::sample_lights,
    lane_bsdf::{Diffuse, DiffuseAndPhong},
    vertex_block::{Block, DeltaBlock, FollowedLobes, PhongBlock, ScatteredBlock, ShapeBlock},
    vertex_stages::{compute_surfaces, scatter},
    wave::Path,
};
use crate::{
    LazyHit, SurfaceHit, TrianglePoint,
    bsdf::{
        Bsdf, Coupling, DiffusePhong, LaneSurface, MetallicRoughness, MetallicRoughnessLanes, OrenNayar, PhongLobe,
        WeightedPhong,
    },
    lanes::{LANES, LaneArray, LaneLevel, dispatch, get, get_rgb, set, set_rgb},
    light::LightSet,
    viewed_surface::ViewedSurface,
};
use rt_geometry::{Sphere, SurfaceInteraction};
use rt_math::{DVec3, Ray, Rgb, Sampler};

/// Vertices with their light samples and samples of the next direction.
#[derive(Clone, Debug)]
pub(super) struct VertexQueue<S> {
    vertices: Vec<QueuedVertex>,
    blocks: Vec<Block>,
    /// For each block, light of all delta lights.
    delta: Vec<DeltaBlock>,
    /// Samplers of the paths before this queue drew from them.
    initial_samplers: Vec<S>,
    draws: Draws,
    kind: QueueKind,
}

/// Kind of surface that a queue holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum QueueKind {
    /// A diffuse lobe.
    Diffuse,
    /// A diffuse lobe and a Phong lobe.
    DiffusePhong,
    /// The metallic-roughness model.
    MetallicRoughness,
}

impl QueueKind {
    pub(super) const ALL: [Self; 3] = [Self::Diffuse, Self::DiffusePhong, Self::MetallicRoughness];

    /// Queue for a surface.
    #[inline(always)]
    pub(super) const fn of(surface: &LaneSurface) -> Self {
        match surface {
            LaneSurface::DiffusePhong(DiffusePhong { highlight: None, .. }) => Self::Diffuse,
            LaneSurface::DiffusePhong(_) => Self::DiffusePhong,
            LaneSurface::MetallicRoughness(_) => Self::MetallicRoughness,
        }
    }
}

/// Hit whose surface can be computed in lanes.
#[derive(Clone, Copy, Debug)]
pub(super) enum LazyShapeHit<'h> {
    Triangle(&'h LazyHit<TrianglePoint>),
    Sphere(&'h LazyHit<Sphere>),
}

impl LazyShapeHit<'_> {
    /// Index of the material.
    #[inline(always)]
    pub(super) const fn material(self) -> u32 {
        match self {
            Self::Triangle(hit) => hit.material,
            Self::Sphere(hit) => hit.material,
        }
    }

    /// The surface.
    #[inline(always)]
    pub(super) fn surface(self, ray: &Ray) -> SurfaceHit {
        match self {
            Self::Triangle(hit) => hit.surface(ray),
            Self::Sphere(hit) => hit.surface(ray),
        }
    }
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

/// Light of a delta light at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum SampledDelta {
    /// The light does not reach the vertex.
    Unlit,
    /// The vertex reflects nothing of it.
    Black,
    Lit {
        /// Contribution if the light is not occluded.
        radiance: Rgb,
        /// Shadow ray, for a light that casts shadows, and the parameter at which it ends.
        origin: DVec3,
        direction: DVec3,
        end: f64,
    },
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
    /// True for a direction from the diffuse lobe.
    pub(super) is_diffuse: bool,
}

impl<S: Sampler + Clone> VertexQueue<S> {
    /// Empty queue.
    pub(super) fn new(kind: QueueKind) -> Self {
        let (vertices, blocks, delta, initial_samplers) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { vertices, blocks, delta, initial_samplers, draws: Draws::default(), kind }
    }

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
        bsdf: &LaneSurface,
        time: f64,
        rr_start_depth: u32,
    ) {
        let (block, lane) = self.push_path((id, path), bsdf, time, rr_start_depth);
        let surface = view.surface;
        set(&mut block.point, lane, surface.point);
        set(&mut block.point_error, lane, surface.point_error);
        set(&mut block.shadow_point, lane, surface.shadow_point);
        set(&mut block.geometric_normal, lane, surface.geometric_normal);
        set(&mut block.shading_normal, lane, surface.shading_normal);
        set(&mut block.direction, lane, view.direction);
        block.side[lane] = if view.is_inside { -1.0 } else { 1.0 };
    }

    /// Version of [`push`](Self::push) for a hit of a ray whose surface is computed later.
    #[inline(always)]
    pub(super) fn push_hit(
        &mut self,
        path: (u32, &Path),
        hit: LazyShapeHit<'_>,
        bsdf: &LaneSurface,
        ray: &Ray,
        rr_start_depth: u32,
    ) {
        let (block, lane) = self.push_path(path, bsdf, ray.time, rr_start_depth);
        let ShapeBlock { triangles, spheres, points: [a, b, c], numbers, direction } = &mut block.shapes;
        set(direction, lane, ray.direction);
        match hit {
            LazyShapeHit::Triangle(hit) => {
                *triangles |= 1 << lane;
                set(a, lane, hit.shape.vertices[0]);
                set(b, lane, hit.shape.vertices[1]);
                set(c, lane, hit.shape.vertices[2]);
                set_pair(numbers, lane, hit.shape.uv);
                set(&mut block.geometric_normal, lane, hit.shape.normal);
            }
            LazyShapeHit::Sphere(hit) => {
                *spheres |= 1 << lane;
                set(a, lane, hit.shape.centre());
                set(b, lane, ray.origin);
                set_pair(numbers, lane, [hit.shape.radius(), hit.t]);
            }
        }
    }

    /// Appends a vertex without its surface.
    #[inline(always)]
    fn push_path(
        &mut self,
        (id, path): (u32, &Path),
        bsdf: &LaneSurface,
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
            (block.valid, block.shapes.triangles, block.shapes.spheres) = (!0, 0, 0);
        }
        match bsdf {
            LaneSurface::DiffusePhong(DiffusePhong { diffuse, highlight }) => {
                set_rgb(&mut block.albedo, lane, diffuse.albedo);
                block.roughness[lane] = diffuse.clamped_roughness();
                if let Some(WeightedPhong { lobe, weights, probabilities }) = highlight {
                    let phong = &mut block.phong;
                    set_rgb(&mut phong.reflectance, lane, lobe.reflectance);
                    phong.exponent[lane] = lobe.clamped_exponent();
                    set_pair(&mut phong.weights, lane, *weights);
                    set_pair(&mut phong.probabilities, lane, *probabilities);
                }
            }
            LaneSurface::MetallicRoughness(layer) => {
                set_rgb(&mut block.albedo, lane, layer.surface.base_color);
                block.roughness[lane] = layer.surface.roughness;
                block.layer.set(lane, layer);
            }
        }
        set_rgb(&mut block.throughput, lane, path.throughput);
        block.eta_scale[lane] = path.eta_scale;
        let plays_roulette = path.bounces + 1 > rr_start_depth;
        block.u_roulette[lane] = if plays_roulette { 0.0 } else { -1.0 };
        (block, lane)
    }

    /// Lobes of which the next direction is sampled, if paths follow diffuse surfaces or not.
    pub(super) const fn sampled_lobes(&self, follows_diffuse: bool) -> FollowedLobes {
        match (follows_diffuse, self.kind) {
            (true, _) => FollowedLobes::All,
            (false, QueueKind::DiffusePhong | QueueKind::MetallicRoughness) => FollowedLobes::Specular,
            (false, QueueKind::Diffuse) => FollowedLobes::Nothing,
        }
    }

    /// Draws the samples of all vertices, for one of `n_lights` and for the next direction.
    pub(super) fn draw(&mut self, samplers: &mut [S], n_lights: usize, lobes: FollowedLobes) {
        let Self { vertices, blocks, initial_samplers, draws, kind, .. } = self;
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
            each_number(blocks, numbers, |block| &mut block.u_light_choice);
        }
        if lobes == FollowedLobes::Nothing {
            return;
        }
        S::next_2d_batch(samplers, paths, pairs);
        each_pair(blocks, pairs, |block| &mut block.u_bsdf);
        if *kind != QueueKind::Diffuse {
            S::next_1d_batch(samplers, paths, numbers);
            each_number(blocks, numbers, |block| &mut block.u_lobe);
        }
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

    /// Samples lights and the next direction of each path.
    pub(super) fn shade(&mut self, level: LaneLevel, lights: &LightSet, lobes: FollowedLobes) {
        let blocks = &mut self.blocks[..self.vertices.len().div_ceil(LANES)];
        dispatch!(level, simd => compute_surfaces(simd, blocks));
        if lights.sampled_lights().is_empty() {
            blocks.iter_mut().for_each(|block| block.light.pdf = [0.0; LANES]);
        } else {
            dispatch!(level, simd => sample_lights(simd, blocks, self.vertices.len(), lights));
        }
        let delta = &mut self.delta;
        delta.clear();
        dispatch!(level, simd => match self.kind {
            QueueKind::Diffuse => scatter::<_, Diffuse<_>>(simd, blocks, lights, delta, lobes),
            QueueKind::DiffusePhong => scatter::<_, DiffuseAndPhong<_>>(simd, blocks, lights, delta, lobes),
            QueueKind::MetallicRoughness => {
                scatter::<_, MetallicRoughnessLanes<_>>(simd, blocks, lights, delta, lobes)
            }
        });
    }

    /// Light of the delta light number `number` of `count` at the vertex `at`.
    #[inline(always)]
    pub(super) fn delta_light(&self, at: usize, number: usize, count: usize) -> SampledDelta {
        let (block, lane) = (&self.delta[at / LANES * count + number], at % LANES);
        if block.black >> lane & 1 == 1 {
            return SampledDelta::Black;
        }
        if block.lit >> lane & 1 == 0 {
            return SampledDelta::Unlit;
        }
        SampledDelta::Lit {
            radiance: get_rgb(&block.radiance, lane),
            origin: get(&self.blocks[at / LANES].scattered.shadow_origin, lane),
            direction: get(&block.shadow_direction, lane),
            end: block.shadow_end[lane],
        }
    }

    /// Result for the vertex `at`; `None` if it must be shaded by itself.
    #[inline(always)]
    pub(super) fn scattered(&self, at: usize) -> Option<Scattered> {
        let lane = at % LANES;
        let ScatteredBlock { valid, lit, continued, alive, diffuse, .. } = self.blocks[at / LANES].scattered;
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
                is_diffuse: is(diffuse),
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
    pub(super) fn surface(&self, at: usize) -> (SurfaceInteraction, (DVec3, bool), Bsdf) {
        let (block, lane) = (&self.blocks[at / LANES], at % LANES);
        let (point, error) = (get(&block.point, lane), get(&block.point_error, lane));
        let surface = SurfaceInteraction {
            shadow_point: get(&block.shadow_point, lane),
            shading_normal: get(&block.shading_normal, lane),
            ..SurfaceInteraction::flat(point, error, get(&block.geometric_normal, lane), [0.0; 2])
        };
        let (color, roughness) = (get_rgb(&block.albedo, lane), block.roughness[lane]);
        let highlight = (self.kind == QueueKind::DiffusePhong).then(|| {
            let PhongBlock { reflectance, exponent, weights: [a, b], probabilities: [c, d] } = &block.phong;
            let lobe = PhongLobe { reflectance: get_rgb(reflectance, lane), exponent: exponent[lane] };
            WeightedPhong { lobe, weights: [a[lane], b[lane]], probabilities: [c[lane], d[lane]] }
        });
        let bsdf = match self.kind {
            QueueKind::MetallicRoughness => {
                let (metallic, coupling) = (block.layer.metallic[lane], Coupling::Albedo);
                MetallicRoughness { base_color: color, metallic, roughness, coupling }.into()
            }
            _ => DiffusePhong { diffuse: OrenNayar { albedo: color, roughness }, highlight }.into(),
        };
        (surface, (get(&block.direction, lane), block.side[lane] < 0.0), bsdf)
    }
}

/// Stores numbers in the lanes of a field.
fn each_number(blocks: &mut [Block], numbers: &[f64], field: impl Fn(&mut Block) -> &mut LaneArray) {
    for (block, numbers) in blocks.iter_mut().zip(numbers.chunks(LANES)) {
        field(block)[..numbers.len()].copy_from_slice(numbers);
    }
}

/// Stores pairs of numbers in the lanes of a field.
fn each_pair(blocks: &mut [Block], pairs: &[[f64; 2]], field: impl Fn(&mut Block) -> &mut [LaneArray; 2]) {
    for (block, pairs) in blocks.iter_mut().zip(pairs.chunks(LANES)) {
        let field = field(block);
        for (lane, pair) in pairs.iter().enumerate() {
            set_pair(field, lane, *pair);
        }
    }
}

/// Sets the numbers of one lane.
#[inline(always)]
fn set_pair([a, b]: &mut [LaneArray; 2], lane: usize, pair: [f64; 2]) {
    [a[lane], b[lane]] = pair;
}
