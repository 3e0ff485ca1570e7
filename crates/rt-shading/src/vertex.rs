//! Vertex of a path.

use crate::{
    Appearance, Material, MaterialEvalContext,
    bsdf::{Bsdf, BsdfSample},
    interior_list::MediumInterface,
    mis::power_heuristic,
    viewed_surface::ViewedSurface,
};
use rt_math::{DVec3, Frame, Rgb};

/// BSDF at a hit. The interface of a solid gives the media on both sides.
pub(crate) fn bsdf_at(
    appearance: &Appearance,
    material: &Material,
    view: &ViewedSurface<'_>,
    interface: Option<&MediumInterface>,
) -> Bsdf {
    let ior = interface.map_or(1.0, |interface| {
        let (before, after) = (interface.before.ior, interface.after.ior);
        if view.is_inside { before / after } else { after / before }
    });
    material.bsdf(&MaterialEvalContext { textures: &appearance.textures, surface: view.surface, ior })
}

/// Vertex of a path: a surface with its BSDF and shading frame.
pub(crate) struct Vertex<'a> {
    pub(crate) view: ViewedSurface<'a>,
    pub(crate) bsdf: &'a Bsdf,
    sampled: SampledLobes<'a>,
    /// Shading coordinates: z is the shading normal, on the outside.
    pub(crate) frame: Frame,
    /// To the viewer, in the frame.
    pub(crate) wo: DVec3,
    /// Normal for the sampling of lights: on the viewer's side, `None` if the surface transmits light.
    pub(crate) normal: Option<DVec3>,
    pub(crate) time: f64,
}

/// Sampled lobes of a BSDF.
enum SampledLobes<'a> {
    All,
    Some(&'a Bsdf),
    Nothing,
}

impl<'a> Vertex<'a> {
    /// Vertex with all lobes sampled.
    #[inline]
    pub(crate) fn new(view: ViewedSurface<'a>, bsdf: &'a Bsdf, time: f64) -> Self {
        let (frame, wo) = view.shading_coordinates();
        let normal = (!bsdf.transmits()).then_some(view.normal);
        Self { view, bsdf, sampled: SampledLobes::All, frame, wo, normal, time }
    }

    /// Restricts sampling to a part of the BSDF.
    pub(crate) fn with_sampled_lobes(self, sampled: Option<&'a Bsdf>) -> Self {
        Self { sampled: sampled.map_or(SampledLobes::Nothing, SampledLobes::Some), ..self }
    }

    pub(crate) fn sampled_lobes(&self) -> Option<&Bsdf> {
        match self.sampled {
            SampledLobes::All => Some(self.bsdf),
            SampledLobes::Some(sampled) => Some(sampled),
            SampledLobes::Nothing => None,
        }
    }

    /// Next direction of a camera path with this sample, world space; `None` if the path ends. See [`ViewedSurface::continued`].
    #[inline]
    pub(crate) fn continued(&self, sample: &BsdfSample, keeps_single: bool) -> Option<DVec3> {
        self.view.continued(sample, self.frame.from_local(sample.wi), keeps_single)
    }

    /// Direction in the frame; `None` if it lies on different sides of the interpolated and the geometric normal.
    #[inline]
    pub(crate) fn local(&self, wi: DVec3) -> Option<DVec3> {
        let local = self.frame.to_local(wi);
        let agree = (local.z > 0.0) == (wi.dot(self.view.surface.geometric_normal) > 0.0);
        agree.then_some(local)
    }

    /// BSDF times cosine for light from `wi` (world space).
    #[inline]
    pub(crate) fn eval(&self, wi: DVec3) -> Rgb {
        self.local(wi).map_or(Rgb::BLACK, |local| self.bsdf.eval(self.wo, local) * local.z.abs())
    }

    /// BSDF times cosine and MIS weight for light sampled with density `pdf`.
    #[inline]
    pub(crate) fn eval_mis(&self, wi: DVec3, pdf: f64) -> Rgb {
        let Some(local) = self.local(wi) else { return Rgb::BLACK };
        let (all, other) = match self.sampled {
            SampledLobes::All => self.bsdf.eval_with_pdf(self.wo, local),
            _ => (self.bsdf.eval(self.wo, local), 0.0),
        };
        if all.is_black() {
            return all;
        }
        let weighted = match self.sampled {
            SampledLobes::All => all * power_heuristic(pdf, other),
            SampledLobes::Nothing => all,
            SampledLobes::Some(sampled) => {
                let (sampled, other) = sampled.eval_with_pdf(self.wo, local);
                all - sampled * (1.0 - power_heuristic(pdf, other))
            }
        };
        weighted * local.z.abs()
    }
}
