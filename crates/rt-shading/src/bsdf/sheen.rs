//! Sheen of cloth.

use core::f64::consts::{PI, TAU};
use rt_math::{DVec3, Rgb, transcendental};
use std::sync::OnceLock;

/// The sheen of cloth as in KHR_materials_sheen.
///
/// Distribution of Estevez and Kulla ("Production Friendly Microfacet Sheen BRDF", 2017), visibility of Neubelt and
/// Pettineo (2013).
///
/// ```text
/// D(m) = (2 + 1/α) sin^(1/α) θm / 2π        α = roughness²
/// V    = 1 / (4 (cos θo + cos θi − cos θo cos θi))
/// f    = colour · D · V
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheen {
    /// Colour, per channel in \[0, 1\].
    pub color: Rgb,
    /// Roughness in \[0, 1\], raised to [`Sheen::MIN_ROUGHNESS`].
    pub roughness: f64,
}

const COSINES: usize = 32;
const ROUGHNESSES: usize = 32;
/// Directions per axis in the sum of the albedo.
const N_DIRECTIONS: usize = 48;

/// Directional albedo of white sheen of one roughness, by cosine.
type SheenRow = [f64; COSINES];

/// Rows of the table of albedos are integrated when sheen of their roughness is shaded first: all would take a quarter of a second.
static ROWS: [OnceLock<SheenRow>; ROUGHNESSES] = [const { OnceLock::new() }; ROUGHNESSES];

fn albedo_row(row: usize) -> &'static SheenRow {
    ROWS[row].get_or_init(|| {
        let sheen = Sheen { color: Rgb::WHITE, roughness: roughness_of(row) };
        core::array::from_fn(|column| sheen.integrated(column as f64 / (COSINES - 1) as f64))
    })
}

fn roughness_of(row: usize) -> f64 {
    Sheen::MIN_ROUGHNESS + (1.0 - Sheen::MIN_ROUGHNESS) * row as f64 / (ROUGHNESSES - 1) as f64
}

impl Sheen {
    /// Minimum roughness: smoother sheen reflects at grazing angles only.
    pub const MIN_ROUGHNESS: f64 = 0.07;

    /// f for two directions above the surface with half vector `m`.
    pub fn value(&self, wo: DVec3, wi: DVec3, m: DVec3) -> Rgb {
        self.color * self.white(wo, wi, m)
    }

    fn white(&self, wo: DVec3, wi: DVec3, m: DVec3) -> f64 {
        let roughness = self.roughness.clamp(Self::MIN_ROUGHNESS, 1.0);
        let power = 1.0 / (roughness * roughness);
        let sin = ((1.0 - m.z) * (1.0 + m.z)).max(0.0).sqrt();
        let d = (2.0 + power) * transcendental::pow(sin, power) / TAU;
        d / (4.0 * (wo.z + wi.z - wo.z * wi.z))
    }

    /// Directional albedo at a cosine, of the brightest channel.
    pub fn albedo(&self, cos: f64) -> f64 {
        let row = (self.roughness.clamp(Self::MIN_ROUGHNESS, 1.0) - Self::MIN_ROUGHNESS) / (1.0 - Self::MIN_ROUGHNESS);
        let (row, down) = place(row, ROUGHNESSES);
        let (column, right) = place(cos, COSINES);
        let along = |row: &SheenRow| row[column] * (1.0 - right) + row[column + 1] * right;
        let white = along(albedo_row(row)) * (1.0 - down) + along(albedo_row(row + 1)) * down;
        (self.color.max_component() * white).min(1.0)
    }

    /// Transmittance to the layers below.
    pub fn transmittance(&self, cos: f64) -> f64 {
        1.0 - self.albedo(cos)
    }

    /// ∫ f cos dω over directions uniform in the cosine.
    fn integrated(&self, cos: f64) -> f64 {
        // Nothing is visible in the plane of the surface.
        let cos = cos.max(1e-4);
        let wo = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
        let term = |index: usize| {
            let (i, j) = (index % N_DIRECTIONS, index / N_DIRECTIONS);
            let z = (i as f64 + 0.5) / N_DIRECTIONS as f64;
            let (sin_phi, cos_phi) = transcendental::sincos(PI * (j as f64 + 0.5) / N_DIRECTIONS as f64);
            let sin = ((1.0 - z) * (1.0 + z)).sqrt();
            let wi = DVec3::new(sin * cos_phi, sin * sin_phi, z);
            self.white(wo, wi, (wo + wi).normalize_or(DVec3::Z)) * z
        };
        (0..N_DIRECTIONS * N_DIRECTIONS).map(term).sum::<f64>() * TAU / (N_DIRECTIONS * N_DIRECTIONS) as f64
    }
}

/// Entry at or below `x` of \[0, 1\], and the fraction to the next.
fn place(x: f64, count: usize) -> (usize, f64) {
    let at = x.clamp(0.0, 1.0) * (count - 1) as f64;
    // The conversion truncates.
    let below = (at as usize).min(count - 2);
    (below, at - below as f64)
}
