//! Layered BSDF of glTF with its extensions.

use super::{
    BsdfSample, DispersiveDielectric, Ggx, Scattering, Sheen,
    albedo_table::LayerAlbedo,
    lambert::{cosine_hemisphere, cosine_pdf},
    schlick::{dielectric_fresnel, schlick_weight},
    side::{Side, flip, reflect_dir, seen_from},
};
use crate::optics;
use core::f64::consts::FRAC_1_PI;
use rt_math::{DVec3, Frame, Rgb};

/// The metallic-roughness BSDF under clearcoat and sheen (glTF 2.0 with KHR_materials_clearcoat, _sheen, _specular, _ior,
/// _anisotropy, and _transmission of thin surfaces).
///
/// ```text
///        clearcoat   F·D·G₂ / (4 cos cos), F = 0.04 + 0.96 w                     w = (1 − |wo·m|)⁵
///        sheen       colour · D·V                                              see Sheen
///        specular    (f0 + (f90 − f0) w) · D·G₂ / (4 cos cos)
///   ______________
///        base        diffuse / π, and transmittance · (1 − F) · D·G₂ / (4 cos cos), mirrored at the surface
/// ```
///
/// A layer attenuates those below by its albedo towards `wo` and `wi`. The base is divided by the mean of this attenuation, as
/// in [`MetallicRoughness`](super::MetallicRoughness). A smooth base and a smooth clearcoat have delta lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    /// Albedo of the diffuse lobe.
    pub diffuse: Rgb,
    /// Transmittance of the base of a thin surface.
    pub transmittance: Rgb,
    /// Reflectance of the microfacets at normal incidence.
    pub f0: Rgb,
    /// Reflectance of the microfacets at grazing angles.
    pub f90: Rgb,
    /// Reflectances of the dielectric part, at normal incidence and at grazing angles. They attenuate the base.
    pub dielectric_reflectance: [f64; 2],
    /// Roughness of the microfacets in \[0, 1\], as in [`Ggx::from_roughness`].
    pub roughness: f64,
    /// Strength of the anisotropy along `axis`, in \[0, 1\] (KHR_materials_anisotropy).
    pub anisotropy: f64,
    /// Direction of the anisotropy: a unit vector in the plane of the surface, in shading coordinates.
    pub axis: [f64; 2],
    /// Sheen, if there is one.
    pub sheen: Option<Sheen>,
    /// Strength of the clearcoat, 0 to 1.
    pub clearcoat: f64,
    /// Roughness of the clearcoat.
    pub clearcoat_roughness: f64,
    /// Unit normal of the clearcoat in shading coordinates; not +z if there are normal maps.
    pub clearcoat_normal: DVec3,
    /// Weight and interface of a solid dielectric, if any.
    pub glass: Option<(f64, DispersiveDielectric)>,
}

/// Lobes, in the order in which `sample` chooses.
#[derive(Clone, Copy, PartialEq)]
enum Component {
    Clearcoat,
    Sheen,
    Specular,
    Transmission,
    Diffuse,
}

const COMPONENTS: [Component; 5] =
    [Component::Clearcoat, Component::Sheen, Component::Specular, Component::Transmission, Component::Diffuse];

/// Layers and sampling probabilities for one `wo`.
struct LayeredView<'l> {
    surface: &'l Layered,
    wo: DVec3,
    facets: Option<Ggx>,
    clearcoat: Option<Ggx>,
    /// Shading frame of the clearcoat, if it differs from that of the base.
    clearcoat_frame: Option<Frame>,
    /// Transmittance of the clearcoat towards `wo`.
    clearcoat_transmittance: f64,
    /// Sampling probability of each component.
    probabilities: [f64; 5],
}

impl Layered {
    /// A white diffuse base under a dielectric of index 1.5.
    pub const PLASTIC: Self = Self {
        diffuse: Rgb::WHITE,
        transmittance: Rgb::BLACK,
        f0: Rgb::gray(0.04),
        f90: Rgb::WHITE,
        dielectric_reflectance: [0.04, 1.0],
        roughness: 0.5,
        anisotropy: 0.0,
        axis: [1.0, 0.0],
        sheen: None,
        clearcoat: 0.0,
        clearcoat_roughness: 0.0,
        clearcoat_normal: DVec3::Z,
        glass: None,
    };

    /// Implements [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let (layers, layers_pdf) = self.eval_layers_with_pdf(wo, wi);
        let Some((share, glass)) = &self.glass else { return (layers, layers_pdf) };
        let (glass, glass_pdf) = glass.eval_with_pdf(wo, wi);
        (layers * (1.0 - share) + glass * *share, layers_pdf * (1.0 - share) + glass_pdf * share)
    }

    fn eval_layers_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let is_above = wo.z > 0.0;
        let Some((wo, wi)) = seen_from(self.turned(wo), self.turned(wi)) else { return (Rgb::BLACK, 0.0) };
        let view = LayeredView::new(self, wo, is_above);
        (view.value(wi), view.density(wi))
    }

    /// Implements [`super::Bsdf::sample_along`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3], throughput: Rgb) -> Option<BsdfSample> {
        let Some((share, glass)) = &self.glass else { return self.sample_layers(wo, u) };
        Side::of(wo, u)?;
        let (sample, probability) = if u[0] < *share {
            (glass.sample(wo, [(u[0] / share).min(1.0), u[1], u[2]], throughput)?, *share)
        } else {
            let within = ((u[0] - share) / (1.0 - share)).clamp(0.0, 1.0);
            (self.sample_layers(wo, [within, u[1], u[2]])?, 1.0 - share)
        };
        let (value, pdf) = if sample.is_delta {
            (sample.value * probability, sample.pdf * probability)
        } else {
            self.eval_with_pdf(wo, sample.wi)
        };
        BsdfSample { value, pdf, ..sample }.if_finite()
    }

    fn sample_layers(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let is_above = wo.z > 0.0;
        let (wo, side) = Side::of(self.turned(wo), u)?;
        let sample = LayeredView::new(self, wo, is_above).sample(u)?;
        BsdfSample { wi: self.turned_back(side.restore(sample.wi)), ..sample }.if_finite()
    }

    /// True if light may pass to the other side.
    pub fn transmits(&self) -> bool {
        !self.transmittance.is_black() || self.glass.is_some_and(|(share, _)| share > 0.0)
    }

    /// True if all lobes are delta distributions.
    pub fn is_delta(&self) -> bool {
        let is_all_glass = self.glass.is_some_and(|(share, _)| share >= 1.0);
        self.glass.is_none_or(|(_, glass)| glass.is_smooth()) && (is_all_glass || self.layers_are_delta())
    }

    fn layers_are_delta(&self) -> bool {
        let is_smooth = |roughness| Ggx::from_roughness(roughness).is_none();
        self.diffuse.is_black()
            && self.sheen.is_none()
            && is_smooth(self.roughness)
            && (self.clearcoat == 0.0 || is_smooth(self.clearcoat_roughness))
    }

    /// Direction in coordinates with x along the anisotropy.
    fn turned(&self, w: DVec3) -> DVec3 {
        let [cos, sin] = self.axis;
        DVec3::new(w.x * cos + w.y * sin, w.y * cos - w.x * sin, w.z)
    }

    fn turned_back(&self, w: DVec3) -> DVec3 {
        let [cos, sin] = self.axis;
        DVec3::new(w.x * cos - w.y * sin, w.y * cos + w.x * sin, w.z)
    }

    /// Reflectance of the microfacets at a cosine.
    fn fresnel(&self, cos: f64) -> Rgb {
        let w = schlick_weight(cos);
        self.f0 * (1.0 - w) + self.f90 * w
    }

    /// Reflectance of the dielectric part at a cosine.
    fn dielectric_fresnel_term(&self, cos: f64) -> f64 {
        let w = schlick_weight(cos);
        self.dielectric_reflectance[0] * (1.0 - w) + self.dielectric_reflectance[1] * w
    }

    /// Share of light that the dielectric part leaves to the diffuse part. The albedos of facets are for
    /// reflectance 1 along the normal, and for reflectance 1 at grazing angles.
    fn dielectric_transmittance(&self, [along, grazing]: [f64; 2]) -> f64 {
        1.0 - (self.dielectric_reflectance[0] * along + self.dielectric_reflectance[1] * grazing)
    }

    /// Share of light that passes the clearcoat in a direction with this cosine to its normal.
    pub(crate) fn clearcoat_transmittance(&self, cos: f64) -> f64 {
        if self.clearcoat == 0.0 {
            1.0
        } else {
            1.0 - self.clearcoat * LayerAlbedo::new(self.clearcoat_roughness).directional(cos)
        }
    }

    fn sheen_transmittance(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.sheen.map_or(1.0, |sheen| sheen.transmittance(wo.z).min(sheen.transmittance(wi.z.abs())))
    }
}

impl<'l> LayeredView<'l> {
    fn new(surface: &'l Layered, wo: DVec3, is_above: bool) -> Self {
        let facets = Ggx::anisotropic(surface.roughness, surface.anisotropy);
        let clearcoat = Ggx::from_roughness(surface.clearcoat_roughness).filter(|_| surface.clearcoat > 0.0);
        let clearcoat_frame = (surface.clearcoat > 0.0 && surface.clearcoat_normal != DVec3::Z).then(|| {
            let normal = surface.turned(surface.clearcoat_normal);
            // `wo` below the surface was mirrored at its plane.
            Frame::from_z(if is_above { normal } else { reflect_dir(normal) })
        });
        let clearcoat_transmittance =
            surface.clearcoat_transmittance(to_clearcoat_frame(clearcoat_frame.as_ref(), wo).z.abs());
        let layer = LayerAlbedo::new(surface.roughness);
        let [along, grazing] = layer.directional_by_fresnel(wo.z);
        let dielectric_transmittance = surface.dielectric_transmittance([along, grazing]);
        let below = clearcoat_transmittance * surface.sheen.map_or(1.0, |sheen| sheen.transmittance(wo.z));
        let mut probabilities = [
            1.0 - clearcoat_transmittance,
            clearcoat_transmittance * surface.sheen.map_or(0.0, |sheen| sheen.albedo(wo.z)),
            below * (surface.f0 * along + surface.f90 * grazing).max_component(),
            below * dielectric_transmittance * surface.transmittance.max_component(),
            below * dielectric_transmittance * surface.diffuse.max_component(),
        ];
        let sum: f64 = probabilities.iter().sum();
        if sum > 0.0 {
            probabilities = probabilities.map(|probability| probability / sum);
        }
        Self { surface, wo, facets, clearcoat, clearcoat_frame, clearcoat_transmittance, probabilities }
    }

    fn probability(&self, component: Component) -> f64 {
        self.probabilities[component as usize]
    }

    fn value(&self, wi: DVec3) -> Rgb {
        let (surface, wo) = (self.surface, self.wo);
        let transmittance =
            self.clearcoat_transmittance * surface.clearcoat_transmittance(self.to_clearcoat_frame(wi).z.abs());
        let below = transmittance * surface.sheen_transmittance(wo, wi);
        if wi.z < 0.0 {
            let wi = flip(wi);
            let m = half(wo, wi);
            let facets = self.facets.map_or(0.0, |facets| facets.reflection(wo, wi, m));
            return surface.transmittance * (below * (1.0 - surface.dielectric_fresnel_term(wo.dot(m))) * facets);
        }
        let m = half(wo, wi);
        let mut value = Rgb::BLACK;
        if !surface.diffuse.is_black() {
            let layer = LayerAlbedo::new(surface.roughness);
            let dielectric_transmittance = surface.dielectric_transmittance(layer.directional_by_fresnel(wo.z))
                * surface.dielectric_transmittance(layer.directional_by_fresnel(wi.z))
                / surface.dielectric_transmittance(layer.mean_by_fresnel());
            value += surface.diffuse * (below * dielectric_transmittance * FRAC_1_PI);
        }
        if let Some(facets) = self.facets {
            value += surface.fresnel(wo.dot(m)) * (below * facets.reflection(wo, wi, m));
        }
        if let Some(sheen) = surface.sheen {
            value += sheen.value(wo, wi, m) * transmittance;
        }
        if let Some(clearcoat) = self.clearcoat {
            let fresnel = surface.clearcoat * dielectric_fresnel(wo.dot(m));
            let reflection = if self.clearcoat_frame.is_none() {
                clearcoat.reflection(wo, wi, m)
            } else {
                let [out, into, facet] = [wo, wi, m].map(|w| self.to_clearcoat_frame(w));
                // Callers multiply by the cosine to the base, not to the clearcoat.
                let is_seen = out.z > 0.0 && into.z > 0.0;
                if is_seen { clearcoat.reflection(out, into, facet) * (into.z / wi.z) } else { 0.0 }
            };
            value += Rgb::gray(fresnel * reflection);
        }
        value
    }

    fn to_clearcoat_frame(&self, w: DVec3) -> DVec3 {
        to_clearcoat_frame(self.clearcoat_frame.as_ref(), w)
    }

    /// Direction reflected by the clearcoat, and true if it is a delta lobe. `None` if `wo` is behind the clearcoat.
    fn reflected_by_clearcoat(&self, u: [f64; 2]) -> Option<(DVec3, bool)> {
        let wo = self.to_clearcoat_frame(self.wo);
        if !(wo.z > 0.0) {
            return None;
        }
        let (wi, is_delta) = match self.clearcoat {
            Some(clearcoat) => (optics::reflect(-wo, clearcoat.sample(wo, u)), false),
            None => (reflect_dir(wo), true),
        };
        Some((self.clearcoat_frame.as_ref().map_or(wi, |frame| frame.from_local(wi)), is_delta))
    }

    fn clearcoat_pdf(&self, m: DVec3) -> f64 {
        let wo = self.to_clearcoat_frame(self.wo);
        self.clearcoat
            .filter(|_| wo.z > 0.0)
            .map_or(0.0, |clearcoat| clearcoat.reflection_pdf(wo, self.to_clearcoat_frame(m)))
    }

    fn density(&self, wi: DVec3) -> f64 {
        let wo = self.wo;
        let of_facets = |facets: Option<Ggx>, m| facets.map_or(0.0, |facets| facets.reflection_pdf(wo, m));
        if wi.z < 0.0 {
            return self.probability(Component::Transmission) * of_facets(self.facets, half(wo, flip(wi)));
        }
        let m = half(wo, wi);
        self.probability(Component::Clearcoat) * self.clearcoat_pdf(m)
            + self.probability(Component::Specular) * of_facets(self.facets, m)
            + (self.probability(Component::Sheen) + self.probability(Component::Diffuse)) * cosine_pdf(wi)
    }

    fn sample(&self, u: [f64; 3]) -> Option<BsdfSample> {
        let wo = self.wo;
        let component = self.choose(u[0])?;
        let reflected = |facets: Option<Ggx>| match facets {
            Some(facets) => (optics::reflect(-wo, facets.sample(wo, [u[1], u[2]])), false),
            None => (reflect_dir(wo), true),
        };
        let (wi, is_delta) = match component {
            Component::Clearcoat => self.reflected_by_clearcoat([u[1], u[2]])?,
            Component::Specular | Component::Transmission => reflected(self.facets),
            Component::Sheen | Component::Diffuse => (cosine_hemisphere([u[1], u[2]]), false),
        };
        if !(wi.z > 0.0) {
            return None;
        }
        let (wi, kind) = match component {
            Component::Transmission => (flip(wi), Scattering::Transmission),
            _ => (wi, Scattering::Reflection),
        };
        let (value, pdf) = if is_delta {
            (self.share(component) / wi.z.abs(), self.probability(component))
        } else {
            (self.value(wi), self.density(wi))
        };
        let is_diffuse = matches!(component, Component::Sheen | Component::Diffuse);
        Some(BsdfSample { wi, value, pdf, kind, is_delta, is_diffuse, eta: 1.0 })
    }

    /// Reflectance or transmittance of the delta lobe of a component.
    fn share(&self, component: Component) -> Rgb {
        let (surface, cos) = (self.surface, self.wo.z);
        if component == Component::Clearcoat {
            return Rgb::gray(surface.clearcoat * dielectric_fresnel(self.to_clearcoat_frame(self.wo).z));
        }
        let below =
            self.clearcoat_transmittance * self.clearcoat_transmittance * surface.sheen_transmittance(self.wo, self.wo);
        let share = if component == Component::Transmission {
            surface.transmittance * (1.0 - surface.dielectric_fresnel_term(cos))
        } else {
            surface.fresnel(cos)
        };
        share * below
    }

    fn choose(&self, u: f64) -> Option<Component> {
        let mut below = 0.0;
        let mut last = None;
        for (component, probability) in
            COMPONENTS.into_iter().zip(self.probabilities).filter(|(_, probability)| *probability > 0.0)
        {
            below += probability;
            last = Some(component);
            if u < below {
                break;
            }
        }
        last
    }
}

fn to_clearcoat_frame(clearcoat_frame: Option<&Frame>, w: DVec3) -> DVec3 {
    clearcoat_frame.map_or(w, |frame| frame.to_local(w))
}

fn half(wo: DVec3, wi: DVec3) -> DVec3 {
    (wo + wi).normalize_or(DVec3::Z)
}
