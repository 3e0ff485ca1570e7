//! BSDFs of several path vertices in lanes.
//!
//! Lambertian lobes are computed in the numbers for shading. All other lobes are computed in `f64`, in the shading frame, where their
//! elementary functions are exact. These functions are not inlined, and called only for vectors that have such a lobe.

use super::gathered::GatheredBsdfs;
use crate::{
    bsdf::{
        DiffusePhongLanes, GlassLanes, GlassSample, LaneSample, LayeredLanes, MetalLanes, MetallicRoughnessLanes,
        MirrorLanes, cosine_hemisphere_lanes,
    },
    lane_set::LaneSet,
    lanes::ALL_LANES,
    mis::power_heuristic,
    viewed_surface::MIN_COSINE,
};
use core::f64::consts::{FRAC_1_PI, PI};
use rt_math::{Real, Vector3, tangents};

/// Shading frames: normals on the viewer's side, and tangents.
#[derive(Clone, Copy)]
struct FrameLanes<L: LaneSet> {
    normal: Vector3<L::F>,
    tangents: [Vector3<L::F>; 2],
}

/// BSDFs of the hits of some lanes.
pub(super) struct BsdfLanes<'a, L: LaneSet> {
    lanes: L,
    frame: FrameLanes<L>,
    /// Albedos of Lambertian lobes.
    albedo: Vector3<L::F>,
    /// Other lobes, if there are any.
    lobes: Option<&'a LobeLanes<L>>,
    /// True if directions of diffuse lobes are sampled only below layers.
    follows_specular_only: bool,
}

/// Lobes that are not Lambertian.
pub(super) struct LobeLanes<L: LaneSet> {
    lanes: L,
    frame: FrameLanes<L>,
    /// To the viewer, in the shading frame.
    wo: Vector3<L::D>,
    /// Lanes of rough diffuse lobes, and of diffuse lobes with a Phong lobe.
    rough: u8,
    glossy: u8,
    diffuse_phong: DiffusePhongLanes<L::D>,
    /// Mirrors of some glossy surfaces.
    mirrors: Option<MirrorLanes<L>>,
    /// Lobes of other kinds, with their lanes.
    metallic_roughness: Option<(u8, MetallicRoughnessLanes<L>)>,
    layered: Option<(u8, LayeredLanes<L>)>,
    metals: Option<(u8, MetalLanes<L>)>,
    /// Glass, with the lanes of smooth and of rough glass.
    glass: Option<([u8; 2], GlassLanes<L>)>,
    follows_specular_only: bool,
}

/// Directions sampled from BSDFs.
pub(super) struct SampledLanes<L: LaneSet> {
    /// In the shading frame.
    local: Vector3<L::F>,
    /// BSDF times cosine divided by density.
    pub(super) weight: Vector3<L::F>,
    pub(super) pdf: L::F,
    /// Lanes whose sample is valid.
    pub(super) valid: u8,
    /// Lanes that have sampled a diffuse lobe.
    pub(super) diffuse: u8,
    /// Lanes that have sampled a delta lobe.
    pub(super) delta: u8,
    /// Lanes that have sampled transmission.
    pub(super) transmitted: u8,
    /// Index of refraction on the side of the direction, divided by that on the viewer's side.
    pub(super) eta: L::F,
}

impl<L: LaneSet> FrameLanes<L> {
    /// Direction in the frame, given its cosine to the normal.
    #[inline(always)]
    fn local(&self, lanes: L, direction: Vector3<L::F>, cos: L::F) -> Vector3<L::D> {
        let [tangent, bitangent] = self.tangents;
        lanes.widen_vector(Vector3::new(direction.dot(tangent), direction.dot(bitangent), cos))
    }
}

impl<'a, L: LaneSet> BsdfLanes<'a, L> {
    /// BSDFs of surfaces with normals on the viewer's side, seen along unit directions. Those of `inside` are seen from behind. `lobes` is
    /// storage: large structures are not moved.
    #[inline(always)]
    pub(super) fn new(
        lanes: L,
        bsdfs: &GatheredBsdfs,
        (normal, inside): (Vector3<L::F>, u8),
        direction: Vector3<L::F>,
        (follows_specular_only, lobes): (bool, &'a mut Option<LobeLanes<L>>),
    ) -> Self {
        let outside = Vector3::select(lanes.mask(inside), -normal, normal);
        let frame = FrameLanes { normal, tangents: tangents(outside) };
        let albedo = lanes.narrow_vector(lanes.load_coordinates(&bsdfs.albedo));
        let mut of_lobes = None;
        if bsdfs.others() != 0 {
            of_lobes = Some(&*LobeLanes::set(lobes, lanes, bsdfs, (&frame, &direction, follows_specular_only)));
        }
        Self { lanes, frame, albedo, lobes: of_lobes, follows_specular_only }
    }

    /// BSDF times cosine times a factor, for directions with these cosines to the normal. Those below the surface are valid for rough
    /// glass.
    #[inline(always)]
    pub(super) fn reflected(&self, direction: Vector3<L::F>, cos: L::F, factor: f64) -> Vector3<L::F> {
        let reflected = self.albedo * (cos * (FRAC_1_PI * factor));
        match &self.lobes {
            Some(lobes) => lobes.reflected(&reflected, (&direction, &cos), factor),
            None => reflected,
        }
    }

    /// Version of [`reflected`](Self::reflected) with the MIS weight of light sampled with the density `pdf`.
    #[inline(always)]
    pub(super) fn reflected_mis(&self, direction: Vector3<L::F>, cos: L::F, pdf: L::F) -> Vector3<L::F> {
        let bsdf_pdf = cos * FRAC_1_PI;
        let weight = if self.follows_specular_only { self.lanes.splat(1.0) } else { power_heuristic(pdf, bsdf_pdf) };
        let reflected = self.albedo * (bsdf_pdf * weight);
        match &self.lobes {
            Some(lobes) => lobes.reflected_mis(&reflected, (&direction, &cos), &pdf),
            None => reflected,
        }
    }

    /// Samples directions, by numbers for the choice of a lobe and for the direction.
    #[inline(always)]
    pub(super) fn sample(&self, u_lobe: L::D, u: [L::D; 2]) -> SampledLanes<L> {
        let lanes = self.lanes;
        let local = lanes.narrow_vector(cosine_hemisphere_lanes(u));
        let valid = if self.follows_specular_only { 0 } else { ALL_LANES };
        let (pdf, eta) = (local.z * FRAC_1_PI, lanes.splat(1.0));
        let (weight, diffuse) = (self.albedo, ALL_LANES);
        let sampled = SampledLanes { local, weight, pdf, valid, diffuse, delta: 0, transmitted: 0, eta };
        match &self.lobes {
            Some(lobes) => lobes.sample(&sampled, &u_lobe, &u),
            None => sampled,
        }
    }

    /// Sampled directions in space, and the lanes in which they are on the side of the shading surface that they are sampled for.
    #[inline(always)]
    pub(super) fn direction(&self, sampled: &SampledLanes<L>) -> (Vector3<L::F>, u8) {
        let &SampledLanes { local, transmitted, .. } = sampled;
        let FrameLanes { normal, tangents: [tangent, bitangent] } = self.frame;
        let zero = self.lanes.splat(0.0);
        let mut on_side = self.lanes.bits(local.z.gt(zero));
        if transmitted != 0 {
            on_side = (on_side & !transmitted) | (self.lanes.bits(local.z.lt(zero)) & transmitted);
        }
        (tangent * local.x + bitangent * local.y + normal * local.z, on_side)
    }
}

impl<L: LaneSet> LobeLanes<L> {
    /// Lobes, in their storage.
    #[inline(never)]
    fn set<'a>(
        storage: &'a mut Option<Self>,
        lanes: L,
        bsdfs: &GatheredBsdfs,
        (frame, direction, follows_specular_only): (&FrameLanes<L>, &Vector3<L::F>, bool),
    ) -> &'a mut Self {
        lanes.vectorize(
            #[inline(always)]
            || {
                let &GatheredBsdfs { rough, glossy, .. } = bsdfs;
                let cos = (-*direction).dot(frame.normal).max(lanes.splat(MIN_COSINE));
                let wo = frame.local(lanes, -*direction, cos);
                let (color, roughness) = (lanes.load_coordinates(&bsdfs.albedo), lanes.load_f64(&bsdfs.roughness));
                let diffuse_phong = DiffusePhongLanes {
                    albedo: color,
                    roughness,
                    reflectance: lanes.load_coordinates(&bsdfs.reflectance),
                    exponent: lanes.load_f64(&bsdfs.exponent),
                    weights: [lanes.load_f64(&bsdfs.weights[0]), lanes.load_f64(&bsdfs.weights[1])],
                    probabilities: [lanes.load_f64(&bsdfs.probabilities[0]), lanes.load_f64(&bsdfs.probabilities[1])],
                };
                let all = storage.insert(Self {
                    lanes,
                    frame: *frame,
                    wo,
                    rough,
                    glossy,
                    diffuse_phong,
                    mirrors: None,
                    metallic_roughness: None,
                    layered: None,
                    metals: None,
                    glass: None,
                    follows_specular_only,
                });
                // Large structures are written where they stay.
                if bsdfs.mirrors.all != 0 {
                    all.mirrors = Some(MirrorLanes::new(lanes, &bsdfs.mirrors));
                }
                if bsdfs.metallic_roughness != 0 {
                    let lobes = MetallicRoughnessLanes::new(lanes, &bsdfs.layers, color, roughness, wo);
                    all.metallic_roughness = Some((bsdfs.metallic_roughness, lobes));
                }
                if bsdfs.layered.all != 0 {
                    all.layered = Some((bsdfs.layered.all, LayeredLanes::new(lanes, &bsdfs.layered, wo)));
                }
                if bsdfs.metals.all != 0 {
                    all.metals = Some((bsdfs.metals.all, MetalLanes::new(lanes, &bsdfs.metals, wo)));
                }
                if bsdfs.glass.all != 0 {
                    let kinds = [bsdfs.glass.all & !bsdfs.glass.rough, bsdfs.glass.rough];
                    all.glass = Some((kinds, GlassLanes::new(lanes, &bsdfs.glass, wo)));
                }
                all
            },
        )
    }

    /// Version of [`BsdfLanes::reflected`] that replaces the numbers of the lanes of these lobes.
    #[inline(never)]
    fn reflected(
        &self,
        reflected: &Vector3<L::F>,
        (direction, cos): (&Vector3<L::F>, &L::F),
        factor: f64,
    ) -> Vector3<L::F> {
        self.lanes.vectorize(
            #[inline(always)]
            || {
                let wi = self.frame.local(self.lanes, *direction, *cos);
                let (mut reflected, scale) = (*reflected, wi.z * factor);
                if self.rough != 0 {
                    let value = self.diffuse_phong.diffuse_value(self.wo, wi);
                    reflected = self.replaced(reflected, self.rough, value * scale);
                }
                if self.glossy != 0 {
                    let values = self.diffuse_phong.values(self.wo, wi);
                    reflected = self.replaced(reflected, self.glossy, (values.diffuse + values.phong) * scale);
                }
                if let Some((mask, lobes)) = &self.metallic_roughness {
                    reflected = self.replaced(reflected, *mask, lobes.eval_with_pdf(wi).0 * scale);
                }
                if let Some((mask, lobes)) = &self.layered {
                    reflected = self.replaced(reflected, *mask, lobes.eval_with_pdf(&wi).0 * scale);
                }
                if let Some((mask, lobes)) = &self.metals {
                    reflected = self.replaced(reflected, *mask, lobes.eval_with_pdf(wi).0 * scale);
                }
                if let Some(([_, rough], lobes)) = &self.glass
                    && *rough != 0
                {
                    reflected = self.replaced(reflected, *rough, lobes.eval_with_pdf(&wi).0 * scale.abs());
                }
                reflected
            },
        )
    }

    /// Version of [`BsdfLanes::reflected_mis`] that replaces the numbers of the lanes of these lobes.
    #[inline(never)]
    fn reflected_mis(
        &self,
        reflected: &Vector3<L::F>,
        (direction, cos): (&Vector3<L::F>, &L::F),
        pdf: &L::F,
    ) -> Vector3<L::F> {
        let &Self { lanes, wo, rough, glossy, follows_specular_only, .. } = self;
        lanes.vectorize(
            #[inline(always)]
            || {
                let wi = self.frame.local(lanes, *direction, *cos);
                let (mut reflected, pdf, one) = (*reflected, lanes.widen(*pdf), lanes.splat_f64(1.0));
                let lobes = &self.diffuse_phong;
                if rough != 0 {
                    let weight = if follows_specular_only { one } else { power_heuristic(pdf, wi.z * FRAC_1_PI) };
                    reflected = self.replaced(reflected, rough, lobes.diffuse_value(wo, wi) * (wi.z * weight));
                }
                if glossy != 0 {
                    let values = lobes.values(wo, wi);
                    let all = values.diffuse + values.phong;
                    let value = if follows_specular_only {
                        let mut own_pdf = values.phong_pdf;
                        if let Some(mirrors) = &self.mirrors {
                            own_pdf = mirrors.phong_probability(lobes) * own_pdf;
                        }
                        all - values.phong * (one - power_heuristic(pdf, own_pdf))
                    } else {
                        all * power_heuristic(pdf, lobes.pdf(&values))
                    };
                    reflected = self.replaced(reflected, glossy, value * wi.z);
                }
                if let Some((mask, lobes)) = &self.metallic_roughness {
                    let (value, own_pdf) = lobes.eval_with_pdf(wi);
                    reflected = self.replaced(reflected, *mask, value * (wi.z * power_heuristic(pdf, own_pdf)));
                }
                if let Some((mask, lobes)) = &self.layered {
                    let (value, own_pdf) = lobes.eval_with_pdf(&wi);
                    reflected = self.replaced(reflected, *mask, value * (wi.z * power_heuristic(pdf, own_pdf)));
                }
                if let Some((mask, lobes)) = &self.metals {
                    let (value, own_pdf) = lobes.eval_with_pdf(wi);
                    reflected = self.replaced(reflected, *mask, value * (wi.z * power_heuristic(pdf, own_pdf)));
                }
                if let Some(([_, rough], lobes)) = &self.glass
                    && *rough != 0
                {
                    let (value, own_pdf) = lobes.eval_with_pdf(&wi);
                    let weight = wi.z.abs() * power_heuristic(pdf, own_pdf);
                    reflected = self.replaced(reflected, *rough, value * weight);
                }
                reflected
            },
        )
    }

    /// Version of [`BsdfLanes::sample`] that replaces the samples of the lanes of these lobes.
    #[inline(never)]
    fn sample(&self, lambertian: &SampledLanes<L>, u_lobe: &L::D, u: &[L::D; 2]) -> SampledLanes<L> {
        let &Self { lanes, wo, rough, glossy, follows_specular_only, .. } = self;
        lanes.vectorize(
            #[inline(always)]
            || {
                let mut sampled = SampledLanes { ..*lambertian };
                let lobes = &self.diffuse_phong;
                if rough != 0 && !follows_specular_only {
                    let value = lobes.diffuse_value(wo, lanes.widen_vector(sampled.local));
                    sampled.weight = self.replaced(sampled.weight, rough, value * lanes.splat_f64(PI));
                }
                if glossy != 0 {
                    let mut is_diffuse = lanes.mask_f64(0);
                    if !follows_specular_only {
                        is_diffuse = lobes.chooses_diffuse(*u_lobe);
                    }
                    let wi = lobes.sample(wo, is_diffuse, *u);
                    let values = lobes.values(wo, wi);
                    let mut phong_probability = None;
                    if let (Some(mirrors), true) = (&self.mirrors, follows_specular_only) {
                        phong_probability = Some(mirrors.phong_probability(lobes));
                    }
                    let (value, pdf) = if let Some(probability) = phong_probability {
                        (values.phong, probability * values.phong_pdf)
                    } else if follows_specular_only {
                        (values.phong, values.phong_pdf)
                    } else {
                        (values.diffuse + values.phong, lobes.pdf(&values))
                    };
                    let own_pdf = Real::select(is_diffuse, values.diffuse_pdf, values.phong_pdf);
                    let valid = lanes.bits_f64(own_pdf.gt(lanes.splat_f64(0.0)));
                    let (weight, diffuse) = (value * (wi.z / pdf), lanes.bits_f64(is_diffuse));
                    let mut sample = LaneSample { wi, weight, pdf, valid, diffuse, delta: 0 };
                    if let Some(mirrors) = &self.mirrors {
                        mirrors.replace((lobes, wo), *u_lobe, phong_probability, &mut sample);
                    }
                    sampled.replace(lanes, glossy, sample);
                }
                if let Some((mask, lobes)) = &self.metallic_roughness {
                    sampled.replace(lanes, *mask, lobes.sample(*u_lobe, *u));
                }
                if let Some((mask, lobes)) = &self.layered {
                    sampled.replace(lanes, *mask, lobes.sample(u_lobe, u));
                }
                if let Some((mask, lobes)) = &self.metals {
                    sampled.replace(lanes, *mask, lobes.sample(*u));
                }
                if let Some(([smooth, rough], lobes)) = &self.glass {
                    if *smooth != 0 {
                        sampled.replace_glass(lanes, *smooth, lobes.sample(*u_lobe));
                    }
                    if *rough != 0 {
                        sampled.replace_glass(lanes, *rough, lobes.sample_rough(u_lobe, u));
                    }
                }
                sampled
            },
        )
    }

    /// Colours, with others in the lanes of a mask.
    #[inline(always)]
    fn replaced(&self, colors: Vector3<L::F>, mask: u8, others: Vector3<L::D>) -> Vector3<L::F> {
        Vector3::select(self.lanes.mask(mask), self.lanes.narrow_vector(others), colors)
    }
}

impl<L: LaneSet> SampledLanes<L> {
    /// Replaces the samples of the lanes of a mask.
    #[inline(always)]
    fn replace(&mut self, lanes: L, mask: u8, sample: LaneSample<L>) {
        let LaneSample { wi, weight, pdf, valid, diffuse, delta } = sample;
        let is_finite = is_density(pdf) & weight.is_finite() & wi.is_finite();
        self.valid = (self.valid & !mask) | (mask & valid & lanes.bits_f64(is_finite));
        self.diffuse = (self.diffuse & !mask) | (mask & diffuse);
        self.delta |= mask & delta;
        let is_replaced = lanes.mask(mask);
        self.local = Vector3::select(is_replaced, lanes.narrow_vector(wi), self.local);
        self.weight = Vector3::select(is_replaced, lanes.narrow_vector(weight), self.weight);
        self.pdf = Real::select(is_replaced, lanes.narrow(pdf), self.pdf);
    }

    /// Version of [`replace`](Self::replace) for glass.
    #[inline(always)]
    fn replace_glass(&mut self, lanes: L, mask: u8, sample: GlassSample<L>) {
        let GlassSample { sample, transmitted, eta } = sample;
        self.transmitted |= mask & transmitted;
        self.eta = Real::select(lanes.mask(mask), lanes.narrow(eta), self.eta);
        self.replace(lanes, mask, sample);
    }
}

/// True for a positive and finite density.
#[inline(always)]
fn is_density<R: Real>(pdf: R) -> R::Mask {
    pdf.gt(pdf.splat(0.0)) & pdf.le(pdf.splat(f64::MAX))
}
