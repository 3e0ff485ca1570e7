//! How much light a layer of dielectric over a diffuse base reflects, from any angle.

use super::Ggx;
use crate::optics;
use rt_math::DVec3;
use std::sync::LazyLock;

const COSINES: usize = 33;
const ROUGHNESSES: usize = 33;
/// Numbers per axis of the square that facets are chosen by.
const NUMBERS: usize = 20;

/// The directional albedo E of facets with the Fresnel term of a dielectric of glTF, and its mean Ē over the hemisphere by
/// the cosine. It is a table that is made at first use, in some hundredths of a second.
///
/// Entries are closest where cosine and roughness are small: E changes most where the slope of the facets is about the
/// cosine. Towards smooth facets E is a convex function of the cosine, so that lines between entries make no light.
struct Layer {
    albedo: [[f64; COSINES]; ROUGHNESSES],
    mean: [f64; ROUGHNESSES],
}

static LAYER: LazyLock<Layer> = LazyLock::new(|| Layer::measure(super::metallic_roughness::dielectric_fresnel));

/// Facets that reflect all light.
static FACETS: LazyLock<Layer> = LazyLock::new(|| Layer::measure(|_| 1.0));

/// Reflectance along the normal of the layer in the table.
const F0: f64 = 0.04;

/// The layer of roughness `roughness`: between two rows of the table.
pub(super) struct LayerOf {
    row: usize,
    fraction: f64,
}

impl LayerOf {
    /// `roughness` is taken for the nearer end of \[0, 1\], NaN for 0.
    pub(super) fn roughness(roughness: f64) -> Self {
        let (row, fraction) = place(roughness, ROUGHNESSES);
        Self { row, fraction }
    }

    /// Part of the light under the angle of the cosine that is reflected: E.
    pub(super) fn reflects(&self, cos: f64) -> f64 {
        self.directional(&LAYER, cos)
    }

    /// Part of light from everywhere that is reflected: Ē.
    pub(super) fn reflects_on_average(&self) -> f64 {
        self.mean(&LAYER)
    }

    /// E of facets with other Fresnel terms f0 + (f90 − f0)(1 − cos)⁵: it is f0 times the first number and f90 times the
    /// second.
    pub(super) fn reflects_split(&self, cos: f64) -> [f64; 2] {
        split(self.reflects(cos), self.directional(&FACETS, cos))
    }

    /// Ē in the same parts.
    pub(super) fn reflects_split_on_average(&self) -> [f64; 2] {
        split(self.reflects_on_average(), self.mean(&FACETS))
    }

    fn directional(&self, table: &Layer, cos: f64) -> f64 {
        let (column, fraction) = place(cos, COSINES);
        let along = |row: usize| between(table.albedo[row][column], table.albedo[row][column + 1], fraction);
        between(along(self.row), along(self.row + 1), self.fraction)
    }

    fn mean(&self, table: &Layer) -> f64 {
        between(table.mean[self.row], table.mean[self.row + 1], self.fraction)
    }
}

/// What reflects `layer` with f0 = 0.04 and f90 = 1, and `whole` with both 1, in the parts of f0 and f90.
fn split(layer: f64, whole: f64) -> [f64; 2] {
    let along = (whole - layer) / (1.0 - F0);
    [along, whole - along]
}

/// The entry at or below `x`, taken for the nearer end of \[0, 1\], NaN for 0, and the way to the next.
fn place(x: f64, count: usize) -> (usize, f64) {
    let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
    // The conversion cuts the fraction off.
    let below = ((x.sqrt() * (count - 1) as f64) as usize).min(count - 2);
    let (from, to) = (entry(below, count), entry(below + 1, count));
    (below, (x - from) / (to - from))
}

/// What the table holds an entry for: squares of evenly spaced numbers from 0 to 1.
fn entry(index: usize, count: usize) -> f64 {
    let root = index as f64 / (count - 1) as f64;
    root * root
}

fn between(a: f64, b: f64, fraction: f64) -> f64 {
    a + (b - a) * fraction
}

impl Layer {
    fn measure(fresnel: impl Fn(f64) -> f64) -> Self {
        let albedo: [[f64; COSINES]; ROUGHNESSES] = core::array::from_fn(|row| {
            let roughness = entry(row, ROUGHNESSES);
            core::array::from_fn(|column| directional_albedo(entry(column, COSINES), roughness, &fresnel))
        });
        // ∫ E · 2 cos d cos, where E is a line a + b · cos between two entries.
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

/// ∫ f cos dω: the mean of the weights of well-spread samples.
fn directional_albedo(cos: f64, roughness: f64, fresnel: impl Fn(f64) -> f64) -> f64 {
    let Some(facets) = Ggx::from_roughness(roughness) else {
        return fresnel(cos);
    };
    // In the plane of the surface itself there is nothing to see.
    let cos = cos.max(1e-6);
    let wo = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
    let at = |index: usize| (index as f64 + 0.5) / NUMBERS as f64;
    let weight = |index: usize| {
        let m = facets.sample(wo, [at(index % NUMBERS), at(index / NUMBERS)]);
        let wi = optics::reflect(-wo, m);
        if !(wi.z > 0.0) {
            return 0.0;
        }
        fresnel(wo.dot(m)) * facets.reflection(wo, wi, m) * wi.z / facets.reflection_pdf(wo, m)
    };
    (0..NUMBERS * NUMBERS).map(weight).sum::<f64>() / (NUMBERS * NUMBERS) as f64
}
