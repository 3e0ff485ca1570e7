//! Properties of all models, tested on the same list of surfaces.

mod agreement;
mod chi_square;
mod degenerate;
mod furnace;
mod lanes;
mod laws;
mod shading_normals;
mod sphere;

use super::*;
use rt_math::{Vector3, random, transcendental};

/// Angles of incidence in degrees, up to grazing.
pub(super) const ANGLES: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 89.0];

/// A unit vector at so many degrees from the normal.
pub(super) fn at_angle(degrees: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = transcendental::sincos(degrees.to_radians());
    let (sin_phi, cos_phi) = transcendental::sincos(azimuth);
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Numbers for the sample `index` of the stream `seed`.
pub(super) fn numbers(seed: u64, index: u64) -> [f64; 3] {
    [0, 1, 2].map(|dimension| random::unit(random::hash(&[seed, index, dimension])))
}

/// A surface with what its tests need to know.
pub(super) struct Surface {
    pub(super) name: &'static str,
    pub(super) bsdf: Bsdf,
}

fn surface(name: &'static str, bsdf: impl Into<Bsdf>) -> Surface {
    Surface { name, bsdf: bsdf.into() }
}

/// True for numbers that agree up to rounding.
pub(super) fn is_close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + a.abs().max(b.abs()))
}

/// True for colours whose components [agree](is_close).
pub(super) fn all_close(a: Vector3<f64>, b: Rgb) -> bool {
    DVec3::from(a).to_array().into_iter().zip(b.to_array()).all(|(a, b)| is_close(a, b))
}

pub(super) fn metal(roughness: f64) -> Conductor {
    Conductor { ior: ComplexIor::GOLD, roughness }
}

/// A surface of glTF, white, so that its albedo is the greatest.
pub(super) fn gltf(metallic: f64, roughness: f64) -> MetallicRoughness {
    MetallicRoughness { base_color: Rgb::WHITE, metallic, roughness }
}

pub(super) fn eon(roughness: f64) -> OrenNayar {
    OrenNayar { albedo: Rgb::WHITE, roughness }
}

pub(super) fn phong(exponent: f64) -> PhongLobe {
    PhongLobe { reflectance: Rgb::WHITE, exponent }
}

pub(super) fn thin_glass() -> ThinGlass {
    ThinGlass { ior: 1.5, transmittance: Rgb::WHITE }
}

/// Diffuse, glossy, rough glass and a mirror, sharing the light.
pub(super) fn blend() -> Mix {
    Mix::new(&[
        (0.4, Lambert { albedo: Rgb::WHITE }.into()),
        (0.3, phong(20.0).into()),
        (0.2, Dielectric::clear(1.5, 0.6).into()),
        (0.1, Mirror { reflectance: Rgb::WHITE }.into()),
    ])
    .expect("a sound mix")
}

/// A highlight over a coloured base: weights of 1, of which the colours leave less than all.
pub(super) fn layers() -> Mix {
    let highlight = PhongLobe { reflectance: Rgb::gray(0.3), exponent: 80.0 };
    Mix::new(&[(1.0, Lambert { albedo: Rgb::new(0.1, 0.5, 0.6) }.into()), (1.0, highlight.into())])
        .expect("a sound mix")
}

/// Metal, brushed across an axis that is not one of the coordinates.
pub(super) fn brushed() -> Layered {
    let (diffuse, f0, axis) = (Rgb::BLACK, Rgb::new(1.0, 0.8, 0.3), [0.6, 0.8]);
    Layered { diffuse, f0, roughness: 0.3, anisotropy: 0.7, axis, ..Layered::PLASTIC }
}

pub(super) fn cloth() -> Layered {
    let sheen = Some(Sheen { color: Rgb::new(0.9, 0.8, 1.0), roughness: 0.4 });
    Layered { sheen, ..Layered::PLASTIC }
}

fn prism(iors: [f64; 3], roughness: f64) -> DispersiveDielectric {
    DispersiveDielectric { iors, roughness, transmittance: Rgb::WHITE }
}

/// Half of what enters passes, in a colour.
pub(super) fn tinted_thin_glass(roughness: f64) -> Layered {
    Layered { diffuse: Rgb::gray(0.5), transmittance: Rgb::new(0.5, 0.4, 0.1), roughness, ..Layered::PLASTIC }
}

/// True if channels have indices of their own: rough ones scatter to one direction with as many factors of n².
pub(super) fn disperses(bsdf: &Bsdf) -> bool {
    matches!(bsdf, Bsdf::Layered(Layered { glass: Some((_, glass)), .. }) if !glass.is_plain())
}

/// Varnish on a surface whose normal a map has turned, smooth and rough. It reflects by its own normal, so that it looks different
/// from where light comes: no law holds light and eye against each other there.
pub(super) fn leaning() -> [Surface; 2] {
    let varnish = Layered { clearcoat: 0.8, clearcoat_normal: DVec3::new(0.48, -0.36, 0.8), ..brushed() };
    [
        surface("leaning varnish", varnish),
        surface("leaning rough varnish", Layered { clearcoat_roughness: 0.4, ..varnish }),
    ]
}

/// One of each model, and rough ones smooth to rough. White where that is possible: that is where energy shows.
pub(super) fn surfaces() -> Vec<Surface> {
    let tinted = Dielectric {
        reflectance: Rgb::new(0.2, 0.5, 0.4),
        transmittance: Rgb::new(0.9, 0.1, 0.3),
        ..Dielectric::clear(1.3, 0.5)
    };
    vec![
        surface("lambert", Lambert { albedo: Rgb::WHITE }),
        surface("oren-nayar .5", eon(0.5)),
        surface("oren-nayar 1", eon(1.0)),
        surface("phong 1", phong(1.0)),
        surface("phong 50", phong(50.0)),
        surface("phong 5000", phong(5000.0)),
        surface("mirror", Mirror { reflectance: Rgb::WHITE }),
        surface("glass", Dielectric::clear(1.5, 0.0)),
        surface("glass .05", Dielectric::clear(1.5, 0.05)),
        surface("glass .3", Dielectric::clear(1.5, 0.3)),
        surface("glass 1", Dielectric::clear(1.5, 1.0)),
        surface("air bubble .4", Dielectric::clear(1.0 / 1.5, 0.4)),
        surface("almost air .7", Dielectric::clear(1.01, 0.7)),
        surface("tinted glass .5", tinted),
        surface("gold", metal(0.0)),
        surface("gold .05", metal(0.05)),
        surface("gold .3", metal(0.3)),
        surface("gold 1", metal(1.0)),
        surface("glTF metal .4", gltf(1.0, 0.4)),
        surface("glTF smooth", gltf(0.5, 0.0)),
        surface("glTF plastic 0", gltf(0.0, 0.0)),
        surface("glTF plastic .1", gltf(0.0, 0.1)),
        surface("glTF plastic .23", gltf(0.0, 0.23)),
        surface("glTF plastic .6", gltf(0.0, 0.6)),
        surface("glTF plastic 1", gltf(0.0, 1.0)),
        surface("pane", thin_glass()),
        surface("mix", blend()),
        surface("layers", layers()),
        surface("layered .3", Layered { roughness: 0.3, ..Layered::PLASTIC }),
        surface("layered smooth", Layered { roughness: 0.0, ..Layered::PLASTIC }),
        surface("brushed", brushed()),
        surface("cloth", cloth()),
        surface("varnish", Layered { clearcoat: 1.0, ..cloth() }),
        surface("rough varnish", Layered { clearcoat: 0.7, clearcoat_roughness: 0.4, ..brushed() }),
        surface("tinted pane .3", tinted_thin_glass(0.3)),
        surface("tinted pane", tinted_thin_glass(0.0)),
        surface("half glass", Layered { glass: Some((0.5, prism([1.5; 3], 0.0))), roughness: 0.2, ..Layered::PLASTIC }),
        surface("prism", Layered { glass: Some((1.0, prism([1.4, 1.5, 1.7], 0.0))), ..Layered::PLASTIC }),
        surface("prism .4", Layered { glass: Some((0.8, prism([1.4, 1.5, 1.7], 0.4))), ..cloth() }),
    ]
}
