//! A base under layers: the material of glTF with its extensions.

use super::{
    BsdfSample, DispersiveDielectric, Ggx, Scattering, Sheen,
    lambert::{cosine_hemisphere, cosine_pdf},
    layer::LayerOf,
    metallic_roughness::{dielectric_fresnel, schlick_weight},
    side::{Side, flip, reflect_dir, seen_from},
};
use crate::optics;
use core::f64::consts::FRAC_1_PI;
use rt_math::{DVec3, Frame, Rgb};

/// The metallic-roughness material under a coat of varnish and a sheen of fibres, as the extensions of glTF 2.0 lay them
/// (KHR_materials_clearcoat, _sheen, _specular, _ior, _anisotropy, and _transmission of thin panes).
///
/// ```text
///        coat        F·D·G₂ / (4 cos cos), F = 0.04 + 0.96 w                     w = (1 − |wo·m|)⁵
///        sheen       colour · D·V                                              see Sheen
///        facets      (f0 + (f90 − f0) w) · D·G₂ / (4 cos cos)
///   ______________
///        base        diffuse / π, and behind a pane   passing · (1 − F) · D·G₂ / (4 cos cos), mirrored in the surface
/// ```
///
/// What a layer reflects of the light from a direction and towards one, it keeps from what lies below; of the base, what is
/// lost so on the way in and out comes back in the mean, as in [`Coupling::Albedo`](super::Coupling::Albedo). Smooth facets
/// and a smooth coat reflect into single directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    /// Albedo of the diffuse base.
    pub diffuse: Rgb,
    /// Transmittance of the base, of a pane without thickness.
    pub passing: Rgb,
    /// What facets reflect along their normal.
    pub f0: Rgb,
    /// What facets reflect at grazing angles.
    pub f90: Rgb,
    /// Of these, per unit of what is no metal, by what the base below is dimmed: along the normal and at grazing angles.
    pub dims: [f64; 2],
    /// Roughness of the facets in \[0, 1\], as in [`Ggx::from_roughness`].
    pub roughness: f64,
    /// How much rougher facets are along `axis`, in \[0, 1\] (KHR_materials_anisotropy).
    pub anisotropy: f64,
    /// Unit vector in the surface, in shading coordinates.
    pub axis: [f64; 2],
    /// Sheen, if there is one.
    pub sheen: Option<Sheen>,
    /// How much of the surface the coat covers, 0 to 1.
    pub coat: f64,
    /// Roughness of the coat.
    pub coat_roughness: f64,
    /// Unit normal of the coat in shading coordinates, which a normal map of the base or of the coat leans.
    pub coat_normal: DVec3,
    /// The part of the surface that is glass, and its surface: light that comes through goes on in a body.
    pub glass: Option<(f64, DispersiveDielectric)>,
}

/// The ways in which light is scattered, in the order in which `sample` chooses.
#[derive(Clone, Copy, PartialEq)]
enum Component {
    Coat,
    Sheen,
    Facets,
    Passing,
    Base,
}

const COMPONENTS: [Component; 5] =
    [Component::Coat, Component::Sheen, Component::Facets, Component::Passing, Component::Base];

/// The layers as they are seen along `wo`.
struct Seen<'l> {
    surface: &'l Layered,
    wo: DVec3,
    facets: Option<Ggx>,
    coating: Option<Ggx>,
    /// The coordinates of the coat, if they are others.
    leaning: Option<Frame>,
    /// Part of the light that the coat leaves on one way.
    coat_leaves: f64,
    /// How often each way is chosen.
    chances: [f64; 5],
}

impl Layered {
    /// A diffuse and white base, and facets of the index 1.5.
    pub const PLASTIC: Self = Self {
        diffuse: Rgb::WHITE,
        passing: Rgb::BLACK,
        f0: Rgb::gray(0.04),
        f90: Rgb::WHITE,
        dims: [0.04, 1.0],
        roughness: 0.5,
        anisotropy: 0.0,
        axis: [1.0, 0.0],
        sheen: None,
        coat: 0.0,
        coat_roughness: 0.0,
        coat_normal: DVec3::Z,
        glass: None,
    };

    /// As [`super::Bsdf::eval`].
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        match &self.glass {
            None => self.eval_layers(wo, wi),
            Some((share, glass)) => self.eval_layers(wo, wi) * (1.0 - share) + glass.eval(wo, wi) * *share,
        }
    }

    fn eval_layers(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let is_above = wo.z > 0.0;
        let Some((wo, wi)) = seen_from(self.turned(wo), self.turned(wi)) else { return Rgb::BLACK };
        Seen::new(self, wo, is_above).value(wi)
    }

    /// As [`super::Bsdf::pdf`].
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        match &self.glass {
            None => self.pdf_of_layers(wo, wi),
            Some((share, glass)) => self.pdf_of_layers(wo, wi) * (1.0 - share) + glass.pdf(wo, wi) * share,
        }
    }

    fn pdf_of_layers(&self, wo: DVec3, wi: DVec3) -> f64 {
        let is_above = wo.z > 0.0;
        let Some((wo, wi)) = seen_from(self.turned(wo), self.turned(wi)) else { return 0.0 };
        Seen::new(self, wo, is_above).density(wi)
    }

    /// As [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let Some((share, glass)) = &self.glass else { return self.sample_layers(wo, u) };
        Side::of(wo, u)?;
        let (sample, chance) = if u[0] < *share {
            (glass.sample(wo, [(u[0] / share).min(1.0), u[1], u[2]])?, *share)
        } else {
            let within = ((u[0] - share) / (1.0 - share)).clamp(0.0, 1.0);
            (self.sample_layers(wo, [within, u[1], u[2]])?, 1.0 - share)
        };
        let (value, pdf) = if sample.is_delta {
            (sample.value * chance, sample.pdf * chance)
        } else {
            (self.eval(wo, sample.wi), self.pdf(wo, sample.wi))
        };
        BsdfSample { value, pdf, ..sample }.if_finite()
    }

    fn sample_layers(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let is_above = wo.z > 0.0;
        let (wo, side) = Side::of(self.turned(wo), u)?;
        let sample = Seen::new(self, wo, is_above).sample(u)?;
        BsdfSample { wi: self.turned_back(side.restore(sample.wi)), ..sample }.if_finite()
    }

    /// True if light may pass to the other side.
    pub fn transmits(&self) -> bool {
        !self.passing.is_black() || self.glass.is_some_and(|(share, _)| share > 0.0)
    }

    /// True if all light goes into single directions.
    pub fn is_delta(&self) -> bool {
        let is_all_glass = self.glass.is_some_and(|(share, _)| share >= 1.0);
        self.glass.is_none_or(|(_, glass)| glass.is_smooth()) && (is_all_glass || self.layers_are_delta())
    }

    fn layers_are_delta(&self) -> bool {
        let is_smooth = |roughness| Ggx::from_roughness(roughness).is_none();
        self.diffuse.is_black()
            && self.sheen.is_none()
            && is_smooth(self.roughness)
            && (self.coat == 0.0 || is_smooth(self.coat_roughness))
    }

    /// A direction in coordinates of which x is the axis.
    fn turned(&self, w: DVec3) -> DVec3 {
        let [cos, sin] = self.axis;
        DVec3::new(w.x * cos + w.y * sin, w.y * cos - w.x * sin, w.z)
    }

    fn turned_back(&self, w: DVec3) -> DVec3 {
        let [cos, sin] = self.axis;
        DVec3::new(w.x * cos - w.y * sin, w.y * cos + w.x * sin, w.z)
    }

    /// What facets of this normal reflect.
    fn fresnel(&self, cos: f64) -> Rgb {
        let w = schlick_weight(cos);
        self.f0 * (1.0 - w) + self.f90 * w
    }

    /// Part of the light that facets keep from the base, at one of them.
    fn kept(&self, cos: f64) -> f64 {
        let w = schlick_weight(cos);
        self.dims[0] * (1.0 - w) + self.dims[1] * w
    }

    /// Part of the light at the angle of the cosine that passes the facets on its way in or out.
    fn enters(&self, layer: &LayerOf, cos: f64) -> f64 {
        let [along, grazing] = layer.reflects_split(cos);
        1.0 - (self.dims[0] * along + self.dims[1] * grazing)
    }

    /// The same of light from everywhere.
    fn enters_on_average(&self, layer: &LayerOf) -> f64 {
        let [along, grazing] = layer.reflects_split_on_average();
        1.0 - (self.dims[0] * along + self.dims[1] * grazing)
    }

    /// Part of the light at the angle of the cosine that the coat leaves.
    fn coat_leaves(&self, cos: f64) -> f64 {
        if self.coat == 0.0 { 1.0 } else { 1.0 - self.coat * LayerOf::roughness(self.coat_roughness).reflects(cos) }
    }

    /// Part of the light that the sheen leaves, on its way in and out.
    fn sheen_leaves(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.sheen.map_or(1.0, |sheen| sheen.leaves(wo.z).min(sheen.leaves(wi.z.abs())))
    }
}

impl<'l> Seen<'l> {
    fn new(surface: &'l Layered, wo: DVec3, is_above: bool) -> Self {
        let facets = Ggx::stretched_along_x(surface.roughness, surface.anisotropy);
        let coating = Ggx::from_roughness(surface.coat_roughness).filter(|_| surface.coat > 0.0);
        let leaning = (surface.coat > 0.0 && surface.coat_normal != DVec3::Z).then(|| {
            let normal = surface.turned(surface.coat_normal);
            // From below, the back of the coat is seen in the mirror that turns the surface over.
            Frame::from_z(if is_above { normal } else { reflect_dir(normal) })
        });
        let coat_leaves = surface.coat_leaves(to_coat(leaning.as_ref(), wo).z.abs());
        let layer = LayerOf::roughness(surface.roughness);
        let [along, grazing] = layer.reflects_split(wo.z);
        let enters = surface.enters(&layer, wo.z);
        let below = coat_leaves * surface.sheen.map_or(1.0, |sheen| sheen.leaves(wo.z));
        let mut chances = [
            1.0 - coat_leaves,
            coat_leaves * surface.sheen.map_or(0.0, |sheen| sheen.albedo(wo.z)),
            below * (surface.f0 * along + surface.f90 * grazing).max_component(),
            below * enters * surface.passing.max_component(),
            below * enters * surface.diffuse.max_component(),
        ];
        let sum: f64 = chances.iter().sum();
        if sum > 0.0 {
            chances = chances.map(|chance| chance / sum);
        }
        Self { surface, wo, facets, coating, leaning, coat_leaves, chances }
    }

    fn chance(&self, way: Component) -> f64 {
        self.chances[way as usize]
    }

    fn value(&self, wi: DVec3) -> Rgb {
        let (surface, wo) = (self.surface, self.wo);
        let leaves = self.coat_leaves * surface.coat_leaves(self.to_coat(wi).z.abs());
        let below = leaves * surface.sheen_leaves(wo, wi);
        if wi.z < 0.0 {
            let wi = flip(wi);
            let m = half(wo, wi);
            let facets = self.facets.map_or(0.0, |facets| facets.reflection(wo, wi, m));
            return surface.passing * (below * (1.0 - surface.kept(wo.dot(m))) * facets);
        }
        let m = half(wo, wi);
        let mut value = Rgb::BLACK;
        if !surface.diffuse.is_black() {
            let layer = LayerOf::roughness(surface.roughness);
            let enters =
                surface.enters(&layer, wo.z) * surface.enters(&layer, wi.z) / surface.enters_on_average(&layer);
            value += surface.diffuse * (below * enters * FRAC_1_PI);
        }
        if let Some(facets) = self.facets {
            value += surface.fresnel(wo.dot(m)) * (below * facets.reflection(wo, wi, m));
        }
        if let Some(sheen) = surface.sheen {
            value += sheen.value(wo, wi, m) * leaves;
        }
        if let Some(coating) = self.coating {
            let fresnel = surface.coat * dielectric_fresnel(wo.dot(m));
            let reflection = if self.leaning.is_none() {
                coating.reflection(wo, wi, m)
            } else {
                let [out, into, facet] = [wo, wi, m].map(|w| self.to_coat(w));
                // The angle to the coat counts, and not that to the base, by whose cosine callers multiply.
                let is_seen = out.z > 0.0 && into.z > 0.0;
                if is_seen { coating.reflection(out, into, facet) * (into.z / wi.z) } else { 0.0 }
            };
            value += Rgb::gray(fresnel * reflection);
        }
        value
    }

    fn to_coat(&self, w: DVec3) -> DVec3 {
        to_coat(self.leaning.as_ref(), w)
    }

    /// Where the coat reflects to, and whether that is the only direction; `None` if its back is seen.
    fn reflected_by_coat(&self, u: [f64; 2]) -> Option<(DVec3, bool)> {
        let wo = self.to_coat(self.wo);
        if !(wo.z > 0.0) {
            return None;
        }
        let (wi, is_delta) = match self.coating {
            Some(coating) => (optics::reflect(-wo, coating.sample(wo, u)), false),
            None => (reflect_dir(wo), true),
        };
        Some((self.leaning.as_ref().map_or(wi, |frame| frame.from_local(wi)), is_delta))
    }

    fn density_of_coat(&self, m: DVec3) -> f64 {
        let wo = self.to_coat(self.wo);
        self.coating.filter(|_| wo.z > 0.0).map_or(0.0, |coating| coating.reflection_pdf(wo, self.to_coat(m)))
    }

    fn density(&self, wi: DVec3) -> f64 {
        let wo = self.wo;
        let of_facets = |facets: Option<Ggx>, m| facets.map_or(0.0, |facets| facets.reflection_pdf(wo, m));
        if wi.z < 0.0 {
            return self.chance(Component::Passing) * of_facets(self.facets, half(wo, flip(wi)));
        }
        let m = half(wo, wi);
        self.chance(Component::Coat) * self.density_of_coat(m)
            + self.chance(Component::Facets) * of_facets(self.facets, m)
            + (self.chance(Component::Sheen) + self.chance(Component::Base)) * cosine_pdf(wi)
    }

    fn sample(&self, u: [f64; 3]) -> Option<BsdfSample> {
        let wo = self.wo;
        let way = self.choose(u[0])?;
        let reflected = |facets: Option<Ggx>| match facets {
            Some(facets) => (optics::reflect(-wo, facets.sample(wo, [u[1], u[2]])), false),
            None => (reflect_dir(wo), true),
        };
        let (wi, is_delta) = match way {
            Component::Coat => self.reflected_by_coat([u[1], u[2]])?,
            Component::Facets | Component::Passing => reflected(self.facets),
            Component::Sheen | Component::Base => (cosine_hemisphere([u[1], u[2]]), false),
        };
        if !(wi.z > 0.0) {
            return None;
        }
        let (wi, kind) = match way {
            Component::Passing => (flip(wi), Scattering::Transmission),
            _ => (wi, Scattering::Reflection),
        };
        let (value, pdf) = if is_delta {
            (self.share(way) / wi.z.abs(), self.chance(way))
        } else {
            (self.value(wi), self.density(wi))
        };
        let is_diffuse = matches!(way, Component::Sheen | Component::Base);
        Some(BsdfSample { wi, value, pdf, kind, is_delta, is_diffuse, eta: 1.0 })
    }

    /// Part of the light that goes into the single direction of this way.
    fn share(&self, way: Component) -> Rgb {
        let (surface, cos) = (self.surface, self.wo.z);
        if way == Component::Coat {
            return Rgb::gray(surface.coat * dielectric_fresnel(self.to_coat(self.wo).z));
        }
        let below = self.coat_leaves * self.coat_leaves * surface.sheen_leaves(self.wo, self.wo);
        let share =
            if way == Component::Passing { surface.passing * (1.0 - surface.kept(cos)) } else { surface.fresnel(cos) };
        share * below
    }

    fn choose(&self, u: f64) -> Option<Component> {
        let mut below = 0.0;
        let mut last = None;
        for (way, chance) in COMPONENTS.into_iter().zip(self.chances).filter(|(_, chance)| *chance > 0.0) {
            below += chance;
            last = Some(way);
            if u < below {
                break;
            }
        }
        last
    }
}

/// A direction in the coordinates of a coat that leans.
fn to_coat(leaning: Option<&Frame>, w: DVec3) -> DVec3 {
    leaning.map_or(w, |frame| frame.to_local(w))
}

fn half(wo: DVec3, wi: DVec3) -> DVec3 {
    (wo + wi).normalize_or(DVec3::Z)
}
