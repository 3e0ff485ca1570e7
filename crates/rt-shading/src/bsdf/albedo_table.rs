//! Table of the directional albedo of a dielectric layer.

use super::Ggx;
use crate::optics;
use rt_math::DVec3;
use std::sync::LazyLock;

const COSINES: usize = 33;
const ROUGHNESSES: usize = 33;
/// Stratified samples per axis of the square from which normals are sampled.
const N_SAMPLES: usize = 20;

/// Directional albedo E of GGX microfacets, and its cosine-weighted mean Ē over the hemisphere. Computed at first use, in
/// hundredths of a second.
///
/// Entries are closest where cosine and roughness are small, since E changes most where α is near the cosine. For smooth
/// surfaces E is a convex function of the cosine, so that linear interpolation gains no energy.
struct AlbedoTable {
    albedo: [[f64; COSINES]; ROUGHNESSES],
    mean: [f64; ROUGHNESSES],
}

/// Microfacets with the Fresnel term of a dielectric of index 1.5.
static DIELECTRIC: LazyLock<AlbedoTable> = LazyLock::new(|| AlbedoTable::compute(super::schlick::dielectric_fresnel));

/// Microfacets that reflect all light.
static WHITE: LazyLock<AlbedoTable> = LazyLock::new(|| AlbedoTable::compute(|_| 1.0));

/// Reflectance of the dielectric at normal incidence.
const F0: f64 = 0.04;

/// Albedo of a layer of one roughness: a position between two rows of the table.
pub(super) struct LayerAlbedo {
    row: usize,
    fraction: f64,
}

impl LayerAlbedo {
    /// Clamps `roughness` to \[0, 1\]; NaN counts as 0.
    pub(super) fn new(roughness: f64) -> Self {
        let (row, fraction) = place(roughness, ROUGHNESSES);
        Self { row, fraction }
    }

    /// Directional albedo E of a dielectric at a cosine.
    pub(super) fn directional(&self, cos: f64) -> f64 {
        self.interpolate(&DIELECTRIC, cos)
    }

    /// Mean albedo Ē of a dielectric.
    pub(super) fn mean(&self) -> f64 {
        self.interpolate_mean(&DIELECTRIC)
    }

    /// E for a Fresnel term f0 + (f90 − f0)(1 − cos)⁵: f0 times the first number plus f90 times the second.
    pub(super) fn directional_by_fresnel(&self, cos: f64) -> [f64; 2] {
        split(self.directional(cos), self.interpolate(&WHITE, cos))
    }

    /// Ē for the Fresnel term of [`directional_by_fresnel`](Self::directional_by_fresnel).
    pub(super) fn mean_by_fresnel(&self) -> [f64; 2] {
        split(self.mean(), self.interpolate_mean(&WHITE))
    }

    fn interpolate(&self, table: &AlbedoTable, cos: f64) -> f64 {
        let (column, fraction) = place(cos, COSINES);
        let along = |row: usize| between(table.albedo[row][column], table.albedo[row][column + 1], fraction);
        between(along(self.row), along(self.row + 1), self.fraction)
    }

    fn interpolate_mean(&self, table: &AlbedoTable) -> f64 {
        between(table.mean[self.row], table.mean[self.row + 1], self.fraction)
    }
}

/// Factors of f0 and f90, where the albedo is `layer` for f0 = 0.04 and f90 = 1, and `whole` for both 1.
fn split(layer: f64, whole: f64) -> [f64; 2] {
    let along = (whole - layer) / (1.0 - F0);
    [along, whole - along]
}

/// Entry at or below `x`, clamped to \[0, 1\], and the fraction to the next; NaN counts as 0.
fn place(x: f64, count: usize) -> (usize, f64) {
    let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
    // The conversion truncates.
    let below = ((x.sqrt() * (count - 1) as f64) as usize).min(count - 2);
    let (from, to) = (entry(below, count), entry(below + 1, count));
    (below, (x - from) / (to - from))
}

/// Argument of an entry: the square of evenly spaced numbers from 0 to 1.
fn entry(index: usize, count: usize) -> f64 {
    let root = index as f64 / (count - 1) as f64;
    root * root
}

fn between(a: f64, b: f64, fraction: f64) -> f64 {
    a + (b - a) * fraction
}

impl AlbedoTable {
    fn compute(fresnel: impl Fn(f64) -> f64) -> Self {
        let albedo: [[f64; COSINES]; ROUGHNESSES] = core::array::from_fn(|row| {
            let roughness = entry(row, ROUGHNESSES);
            core::array::from_fn(|column| directional_albedo(entry(column, COSINES), roughness, &fresnel))
        });
        // ∫ E · 2 cos d cos, with E = a + b · cos between two entries.
        let mean = albedo.map(|row| {
            let part = |column: usize| {
                let (from, to) = (entry(column, COSINES), entry(column + 1, COSINES));
                let b = (row[column + 1] - row[column]) / (to - from);
                let a = row[column] - b * from;
                let integral = |cos: f64| (a + 2.0 / 3.0 * b * cos) * cos * cos;
                integral(to) - integral(from)
            };
            (0..COSINES - 1).map(part).sum()
        });
        Self { albedo, mean }
    }
}

/// ∫ f cos dω: mean of the weights of stratified samples.
fn directional_albedo(cos: f64, roughness: f64, fresnel: impl Fn(f64) -> f64) -> f64 {
    let Some(facets) = Ggx::from_roughness(roughness) else {
        return fresnel(cos);
    };
    // Nothing is visible in the plane of the surface.
    let cos = cos.max(1e-6);
    let wo = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
    let at = |index: usize| (index as f64 + 0.5) / N_SAMPLES as f64;
    let weight = |index: usize| {
        let m = facets.sample(wo, [at(index % N_SAMPLES), at(index / N_SAMPLES)]);
        let wi = optics::reflect(-wo, m);
        if !(wi.z > 0.0) {
            return 0.0;
        }
        fresnel(wo.dot(m)) * facets.reflection(wo, wi, m) * wi.z / facets.reflection_pdf(wo, m)
    };
    (0..N_SAMPLES * N_SAMPLES).map(weight).sum::<f64>() / (N_SAMPLES * N_SAMPLES) as f64
}
