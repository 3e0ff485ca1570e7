//! BSDFs in lanes have the values and samples of the BSDFs themselves.

use super::*;
use crate::lane_set::Float64Lane;

fn layered_surfaces() -> Vec<Layered> {
    let plain = Layered { diffuse: Rgb::new(0.7, 0.2, 0.4), roughness: 0.3, ..Layered::PLASTIC };
    let metal = Layered { diffuse: Rgb::BLACK, f0: Rgb::new(0.9, 0.7, 0.3), ..plain };
    let black = Layered { diffuse: Rgb::BLACK, f0: Rgb::BLACK, f90: Rgb::BLACK, ..plain };
    let coated = |surface, clearcoat, clearcoat_roughness| Layered { clearcoat, clearcoat_roughness, ..surface };
    let sheen =
        |surface, roughness| Layered { sheen: Some(Sheen { color: Rgb::new(0.2, 0.9, 0.5), roughness }), ..surface };
    vec![
        plain,
        metal,
        black,
        Layered { roughness: 2.0, f90: Rgb::gray(0.5), dielectric_reflectance: [0.2, 0.5], ..plain },
        coated(plain, 1.0, 0.0),
        coated(metal, 0.3, 1.0),
        coated(black, 0.5, 0.0),
        coated(black, 0.5, 0.5),
        sheen(plain, 0.0),
        sheen(black, 0.5),
        sheen(coated(metal, 0.9, 0.2), 1.0),
        sheen(coated(plain, 0.9, 0.0), 3.0),
    ]
}

/// BSDFs with their versions for lanes, and indices of refraction behind them.
fn surfaces() -> Vec<(Bsdf, LaneSurface, f64)> {
    let colored =
        |metallic, roughness| MetallicRoughness { base_color: Rgb::new(0.9, 0.5, 0.1), ..gltf(metallic, roughness) };
    let plastics =
        [(0.0, 0.3), (1.0, 0.1), (0.4, 1.0)].map(|(metallic, roughness)| colored(metallic, roughness).into());
    let metals = [0.0, 0.1, 1.0].map(|roughness| metal(roughness).into());
    let opaque = layered_surfaces().into_iter().map(Bsdf::from).chain(plastics).chain(metals);
    let opaque = opaque.map(|bsdf| (bsdf, bsdf.as_lane_surface().expect("a surface for lanes"), 1.0));
    let glass =
        [(0.1, 1.5, Rgb::WHITE), (0.5, 0.6, Rgb::new(0.9, 0.2, 0.5)), (1.0, 2.4, Rgb::WHITE), (0.3, 1.2, Rgb::BLACK)];
    let glass = glass.map(|(roughness, ior, transmittance)| {
        let in_lanes = GlassSurface::new(transmittance, roughness, ior).expect("a surface for lanes");
        let bsdf = Dielectric { transmittance, ..Dielectric::clear(ior, roughness) };
        (bsdf.into(), LaneSurface::Glass(in_lanes), ior)
    });
    opaque.chain(glass).collect()
}

/// Value and density for a direction, and a sample.
fn in_lanes(
    (surface, ior): (&LaneSurface, f64),
    [wo, wi]: [DVec3; 2],
    [uc, u, v]: [f64; 3],
) -> ((Vector3<f64>, f64), GlassSample<Float64Lane>) {
    let (lanes, wo, wi, uv) = (Float64Lane::new(), wo.into(), wi.into(), [u, v]);
    let opaque = |sample| GlassSample { sample, transmitted: 0, eta: 1.0 };
    match surface {
        LaneSurface::Layered(parameters) => {
            let mut block = LayeredBlock::default();
            block.set(0, parameters);
            let view = LayeredLanes::new(lanes, &block, wo);
            (view.eval_with_pdf(&wi), opaque(view.sample(&uc, &uv)))
        }
        LaneSurface::MetallicRoughness(layer) => {
            let mut block = MetallicRoughnessBlock::default();
            block.set(0, layer);
            let MetallicRoughness { base_color: Rgb { r, g, b }, roughness, .. } = layer.surface;
            let view = MetallicRoughnessLanes::new(lanes, &block, Vector3::new(r, g, b), roughness, wo);
            (view.eval_with_pdf(wi), opaque(view.sample(uc, uv)))
        }
        LaneSurface::Conductor(conductor) => {
            let mut block = MetalBlock::default();
            block.set_conductor(0, conductor);
            let view = MetalLanes::new(lanes, &block, wo);
            (view.eval_with_pdf(wi), opaque(view.sample(uv)))
        }
        LaneSurface::Glass(glass) => {
            let mut block = GlassBlock::default();
            block.set(0, glass);
            block.set_eta(0, ior);
            let view = GlassLanes::new(lanes, &block, wo);
            (view.eval_with_pdf(&wi), view.sample_rough(&uc, &uv))
        }
        _ => panic!("{surface:?} is not in the list"),
    }
}

#[test]
fn lanes_have_the_values_and_samples_of_the_bsdf() {
    let (mut n_below, mut n_samples) = (0, [0; 5]);
    for (bsdf, surface, ior) in surfaces() {
        for (at, degrees) in [0.0, 30.0, 60.0, 85.0, 89.99].into_iter().enumerate() {
            let wo = at_angle(degrees, 1.0 + at as f64);
            for index in 0..400 {
                let [mut uc, u, v] = numbers(at as u64, index);
                // Rounding of the last number must not choose a lobe that is absent.
                if index == 0 {
                    uc = 1.0;
                }
                let case = format!("{bsdf:?} {wo} {uc} {u} {v}");
                let wi = at_angle(if bsdf.transmits() { 180.0 } else { 89.9 } * u, 7.0 * v);
                let ((value, pdf), found) = in_lanes((&surface, ior), [wo, wi], [uc, u, v]);
                if !bsdf.is_delta() {
                    let (expected, expected_pdf) = bsdf.eval_with_pdf(wo, wi);
                    let is_same = all_close(value, expected) && is_close(pdf, expected_pdf);
                    assert!(is_same, "{case}: {expected:?} {expected_pdf}");
                    n_below += usize::from(wi.z < 0.0 && !expected.is_black());
                }
                let GlassSample { sample: found, transmitted, eta } = found;
                let LaneSample { wi, weight, pdf, valid, diffuse, delta } = found;
                let wi = DVec3::from(wi);
                let is_on_side = if transmitted == 1 { wi.z < 0.0 } else { wi.z > 0.0 };
                let is_sound = pdf > 0.0 && pdf.is_finite() && weight.is_finite();
                let is_valid = valid & 1 == 1 && is_on_side && is_sound;
                let Some(sample) = bsdf.sample(wo, [uc, u, v]) else {
                    assert!(!is_valid, "{case}: {wi} {pdf}");
                    n_samples[4] += 1;
                    continue;
                };
                let is_same = all_close(weight, sample.weight())
                    && is_close(pdf, sample.pdf)
                    && (wi - sample.wi).length() < 1e-9
                    && eta == sample.eta;
                assert!(is_valid && is_same, "{case}: {sample:?}, {wi} {pdf}");
                let kinds = [delta & 1 == 1, diffuse & 1 == 1, transmitted == 1];
                let expected = [sample.is_delta, sample.is_diffuse, sample.kind == Scattering::Transmission];
                assert_eq!(kinds, expected, "{case}");
                n_samples[kinds.iter().position(|is_of_kind| *is_of_kind).unwrap_or(3)] += 1;
            }
        }
    }
    assert!(n_below > 300 && n_samples.iter().all(|count| *count > 300), "{n_below}, {n_samples:?}");
}
