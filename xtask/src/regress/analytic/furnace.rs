//! White furnace: under radiance 1 from all directions, a surface that absorbs nothing has radiance 1.

use std::{f64::consts::TAU, sync::Arc};

use rt_camera::SamplerKind;
use rt_math::{
    DVec3, Rgb, Sampler,
    transcendental::{exp, sin, sincos},
};
use rt_scene_io::{Background, Integrator};
use rt_shading::{bsdf::PhongLobe, light::EnvironmentLight};

use super::{
    Case, Checks, Conditions, Fallible,
    area_light::tuple,
    cases,
    estimate::{Estimate, MAX_Z, hold, mean_of},
    reflectance::{dielectric_fresnel, facets, metal_fresnel, phong, transmission},
    test_image::TestImage,
};

cases! {
    "S58", "the white furnace: each material at seven angles, before a background and in an image of it",
        "1; Phong .75540916 (n = 1, 45°) …; else ∫ f cos θ of published formulas by quadrature", "5 σ", furnace;
    "furnace-ball", "a ball of glass in the white furnace", "1", "5 σ", glass_sphere;
    "S65", "Phong's highlight of exponent 1e6",
        "∫ f cos = 1 along the normal, cos θ aside; nothing infinite", "1e-9 abs; 5 σ", sharp;
    "cosine-lobe", "∫ cosⁿ over the hemisphere, n = 1 to 1000", "2π / (n + 1)", "5 σ", lobes;
}

/// Degrees from the normal.
const ANGLES: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 89.0];

/// Index of refraction of the glass.
const GLASS: f64 = 1.5;

/// Expected radiance of a plane of a material in the furnace, computed without the code under test.
#[derive(Clone, Copy, Debug)]
enum Truth {
    /// All of it. A white base under facets gives back what they keep from it (Kulla and Conty 2017).
    One,
    /// The integral of Phong's lobe of this exponent.
    Phong(f64),
    /// The integral over the facets of gold of this slope.
    Gold(f64),
    /// The integral over facets of this slope that reflect all.
    White(f64),
    /// The integral over the facets of glass of this slope, reflected and refracted.
    Glass(f64),
    /// Fresnel reflection, and the transmitted rest scaled by 1/n².
    Smooth,
    /// Cosine that a narrow lobe of Phong's law loses off the normal.
    Cosine,
}

/// n + ik of gold at 549.1 nm: Johnson and Christy 1972 have .43 + 2.455i at 548.6 nm and .29 + 2.863i at 582.1 nm.
const GOLD: [f64; 2] = [0.428, 2.461];

const MATERIALS: [(&str, Truth); 15] = [
    ("diffuse(albedo: gray(1))", Truth::One),
    ("diffuse(albedo: gray(1), roughness: 0.7)", Truth::One),
    ("phong(diffuse: gray(1), ambient: gray(0))", Truth::One),
    ("mirror()", Truth::One),
    ("thin_glass()", Truth::One),
    ("mix([(0.5, diffuse(albedo: gray(1))), (0.5, mirror())])", Truth::One),
    ("glossy(specular: gray(1), exponent: 1)", Truth::Phong(1.0)),
    ("glossy(specular: gray(1), exponent: 10)", Truth::Phong(10.0)),
    ("glossy(specular: gray(1), exponent: 50)", Truth::Phong(50.0)),
    ("glossy(specular: gray(1), exponent: 1e6)", Truth::Cosine),
    // The slope of facets is the square of the roughness (Burley 2012).
    ("metal(metal: gold, roughness: 0.3)", Truth::Gold(0.09)),
    ("metallic_roughness(metallic: 1, roughness: 0.4)", Truth::White(0.16)),
    ("metallic_roughness(metallic: 0, roughness: 0.4)", Truth::One),
    ("glass()", Truth::Smooth),
    ("glass(roughness: 0.3)", Truth::Glass(0.09)),
];

/// A plane of a material, seen under an angle in the furnace.
fn plane(material: &str, degrees: f64) -> Fallible<TestImage> {
    let (sin, cos) = sincos(degrees.to_radians());
    TestImage::of(&format!(
        "camera: (look_from: {}, look_at: (0, 0, 0), up: (0, 1, 0), orthographic: 1e-9),
            settings: (max_depth: 4),
            lights: [],
            background: constant(gray(1)),
            materials: {{\"it\": {material}}},
            nodes: [(shape: plane(normal: (0, 0, 1)), material: \"it\")],",
        tuple(DVec3::new(sin, 0.0, cos)),
    ))
}

impl Truth {
    fn at(self, degrees: f64) -> f64 {
        let (_, cos) = sincos(degrees.to_radians());
        match self {
            Self::One => 1.0,
            Self::Phong(exponent) => phong(exponent, degrees),
            Self::Gold(slope) => facets(slope, degrees, |cos| metal_fresnel(cos, GOLD[0], GOLD[1])),
            Self::White(slope) => facets(slope, degrees, |_| 1.0),
            Self::Glass(slope) => {
                facets(slope, degrees, |cos| dielectric_fresnel(cos, GLASS)) + transmission(slope, degrees, GLASS)
            }
            Self::Smooth => {
                let reflected = dielectric_fresnel(cos, GLASS);
                reflected + (1.0 - reflected) / (GLASS * GLASS)
            }
            Self::Cosine => cos,
        }
    }
}

fn furnace(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let [seeds, spp] = conditions.effort();
    let around = Background::Environment(Arc::new(EnvironmentLight::constant(Rgb::WHITE)?));
    for (material, truth) in MATERIALS {
        let mut note = format!("{material}: z");
        for (step, degrees) in ANGLES.into_iter().enumerate() {
            let plain = plane(material, degrees)?;
            let truth = truth.at(degrees);
            let mut image = plain.clone();
            image.scene.appearance.background = around.clone();
            note.push_str(&format!(" | {degrees}° {truth:.5}:"));
            for (turn, (target, what, integrator)) in [
                (&plain, "background", Integrator::Path),
                (&plain, "background", Integrator::Direct),
                (&image, "image", Integrator::Path),
                // To it, a background is no light that diffuse surfaces show.
                (&image, "image", Integrator::Distributed),
            ]
            .into_iter()
            .enumerate()
            {
                // At the next angle, each integrator takes the other pattern.
                let pattern = [SamplerKind::Random, SamplerKind::Sobol][(step + turn) % 2];
                let how = format!("{}, {}", integrator.name(), pattern.name());
                let name = format!("{material} at {degrees}° in a {what}, {how}");
                let mean = |seed| target.mean(integrator, pattern, spp as u32, seed);
                let found = Estimate::of_seeds(&name, seeds, mean)?;
                let z = found.z(truth);
                note.push_str(&format!(" {z:+.1}"));
                checks.limit(z, MAX_Z, format_args!("{name}: {found:?} instead of {truth}"));
            }
        }
        checks.note(note);
    }
    Ok(())
}

/// Every ray that goes into it comes out of it. Roulette would end one path in many thousands, and make the mean of few seeds
/// lopsided.
fn glass_sphere(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for degrees in ANGLES {
        let aside = sin(degrees.to_radians());
        let target = TestImage::of(&format!(
            "camera: (look_from: ({aside:?}, 0, 2), look_at: ({aside:?}, 0, 0), orthographic: 1e-9),
                settings: (max_depth: 400, rr_start_depth: 400),
                lights: [],
                background: constant(gray(1)),
                materials: {{\"it\": glass(ior: {GLASS:?})}},
                nodes: [(shape: sphere(radius: 1), material: \"it\")],"
        ))?;
        target.hold(checks, format_args!("{degrees}°"), 1.0, (Integrator::Path, 1.0), conditions.effort())?;
    }
    Ok(())
}

const SHARP: PhongLobe = PhongLobe { reflectance: Rgb::WHITE, exponent: 1e6 };

fn sharp(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let integral = sharp_integral();
    checks.limit(integral - 1.0, 1e-9, format_args!("∫ f cos θ = {integral:?}"));
    for degrees in ANGLES {
        let (sin, cos) = sincos(degrees.to_radians());
        let wo = DVec3::new(sin, 0.0, cos);
        for index in 0..1000 {
            let u = [0.5, f64::from(index) / 1000.0, 0.25];
            // The lowest numbers are directions below the surface.
            let Some(sample) = SHARP.sample(wo, u) else { continue };
            let weight = sample.weight().g;
            checks.check(weight.is_finite() && (0.0..=1.1).contains(&weight), || {
                format!("{degrees}°, u = {u:?}: a weight of {weight}")
            });
            let (value, pdf) = SHARP.eval_with_pdf(wo, sample.wi);
            checks.check(value.is_finite() && pdf.is_finite(), || format!("{degrees}°, u = {u:?}: {value:?} / {pdf}"));
        }
        let (behind, _) = SHARP.eval_with_pdf(wo, DVec3::new(sin, 0.0, cos));
        checks.check(degrees == 0.0 || behind.g < 1e-100, || format!("{behind:?} towards the viewer at {degrees}°"));
    }
    Ok(())
}

/// ∫ f cos θ dω along the normal by Simpson's rule, over s = −(n + 2) ln cos θ: the integrand is e⁻ˢ.
fn sharp_integral() -> f64 {
    const STEPS: u32 = 4000;
    const END: f64 = 40.0;
    let power = SHARP.exponent + 2.0;
    let step = END / f64::from(STEPS);
    let value = |i: u32| {
        let cos = exp(-f64::from(i) * step / power);
        let wi = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
        SHARP.eval_with_pdf(DVec3::Z, wi).0.g * cos * cos * TAU / power
    };
    let weight = |i: u32| if i == 0 || i == STEPS { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=STEPS).map(|i| weight(i) * value(i)).sum::<f64>() * step / 3.0
}

/// By directions that are uniform, and by those of the lobe itself.
fn lobes(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let seeds = conditions.count(64, 512);
    let spp = conditions.count(1024, 4096) as u32;
    for exponent in [1.0, 10.0, 100.0, 1000.0] {
        let lobe = PhongLobe { reflectance: Rgb::WHITE, exponent };
        // f is the power of the cosine, but for its factor.
        let power = |wi: DVec3| lobe.eval_with_pdf(DVec3::Z, wi).0.g * TAU / (exponent + 2.0);
        let truth = TAU / (exponent + 1.0);
        hold(checks, format_args!("n = {exponent}, uniform"), truth, seeds, |pattern, seed| {
            Ok(mean_of(pattern, spp, seed, |sample| {
                let [height, turn] = sample.next_2d();
                let radius = ((1.0 - height) * (1.0 + height)).sqrt();
                let (sin, cos) = sincos(TAU * turn);
                TAU * power(DVec3::new(radius * cos, radius * sin, height))
            }))
        })?;
        hold(checks, format_args!("n = {exponent}, its own"), truth, seeds, |pattern, seed| {
            Ok(mean_of(pattern, spp, seed, |sample| {
                let [u, v] = sample.next_2d();
                lobe.sample(DVec3::Z, [0.5, u, v]).map_or(0.0, |found| power(found.wi) / found.pdf)
            }))
        })?;
    }
    Ok(())
}
