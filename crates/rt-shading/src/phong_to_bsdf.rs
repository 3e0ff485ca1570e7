//! Conversion of Phong's model to a BSDF; `to_phong.rs` has the reverse.

use crate::{
    Highlight, MaterialEvalContext, Phong, Transmission,
    bsdf::{Bsdf, Dielectric, Lambert, Mirror, PhongLobe, SpecularTransmission},
    lobe_list::LobeList,
};

/// BSDF with the brightness of the Phong model under [`Whitted`](crate::Whitted).
///
/// * The diffuse coefficient kd is the albedo of a Lambertian lobe.
/// * The specular coefficient ks becomes a normalised Phong lobe of albedo 2 ks / (n + 2), so that its peak is ks / π.
/// * The coefficients of mirrored and transmitted light stay, and are weighted by Fresnel's equations where `fresnel` is set.
pub(crate) fn phong_to_bsdf(phong: &Phong, at: &MaterialEvalContext<'_>) -> Bsdf {
    let is_diffuse = phong.specular.is_zero() && phong.mirror.is_zero() && phong.transmission.is_none();
    if is_diffuse && !phong.diffuse.is_zero() {
        return Bsdf::Single(Lambert { albedo: at.reflectance(&phong.diffuse) }.into());
    }
    let mut lobes = LobeList::default();
    lobes.push_scaled(Lambert { albedo: at.reflectance(&phong.diffuse) }.into(), &phong.diffuse);
    let exponent = match phong.highlight {
        Highlight::Phong => phong.exponent,
        // The angle between half vector and normal is half of that to the mirrored direction.
        Highlight::Blinn => 0.25 * phong.exponent,
    };
    let specular = at.reflectance(&phong.specular) * (2.0 / (exponent + 2.0));
    lobes.push_scaled(PhongLobe { reflectance: specular, exponent }.into(), &phong.specular);
    let mirror = at.reflectance(&phong.mirror);
    match &phong.transmission {
        Some(Transmission { coefficient, fresnel: true }) => {
            let transmittance = at.reflectance(coefficient);
            let interface = Dielectric { ior: at.ior, roughness: 0.0, reflectance: mirror, transmittance };
            lobes.push(interface.into());
        }
        Some(Transmission { coefficient, fresnel: false }) => {
            lobes.push_scaled(Mirror { reflectance: mirror }.into(), &phong.mirror);
            let refraction = SpecularTransmission { ior: at.ior, transmittance: at.reflectance(coefficient) };
            lobes.push_scaled(refraction.into(), coefficient);
        }
        None => lobes.push_scaled(Mirror { reflectance: mirror }.into(), &phong.mirror),
    }
    lobes.into_bsdf()
}
