//! Table of the directional albedo of a dielectric layer.

use super::{
    Ggx,
    ggx::{IsotropicGgx, visible_normal},
    schlick::schlick_weight,
};
use crate::{
    lane_set::LaneSet,
    lanes::{LANES, LaneArray, LaneLevel, Lanes, Simd, dispatch},
    optics::reflect_lanes,
};
use core::f64::consts::TAU;
use rt_math::{DVec3, Float64, Real, Vector3, transcendental};
use std::sync::OnceLock;

const COSINES: usize = 97;
const ROUGHNESSES: usize = 65;

/// Points of the Fibonacci lattice that integrates one entry, and its generator: two consecutive Fibonacci numbers.
const LATTICE: [u32; 2] = [610, 377];

/// 2⁵²: numbers above it are integers.
const INTEGER: f64 = (1u64 << 52) as f64;

/// Reflectance along the normal of a dielectric of index 1.5.
const F0: f64 = 0.04;

/// A number as its parts for f0 and f90 of Schlick's Fresnel term f0 + (f90 − f0)(1 − cos)⁵, which is linear in both.
type Split = [f64; 2];

/// Row of one roughness of the table of directional albedos E of GGX facets, by the cosine to the normal.
///
/// Entries are closest where cosine and roughness are small: E changes most where the slope of the facets is about the
/// cosine. Between entries, E is within 0.001 of its integral.
struct Row {
    albedo: [Split; COSINES],
    /// Cosine-weighted mean Ē over the hemisphere.
    mean: Split,
}

/// Rows are integrated when a surface of their roughness is shaded first: most scenes need two.
static ROWS: [OnceLock<Row>; ROUGHNESSES] = [const { OnceLock::new() }; ROUGHNESSES];

/// Albedo of a layer of one roughness: a position between two rows of the table.
#[derive(Clone, Copy)]
pub(crate) struct LayerAlbedo {
    rows: [&'static Row; 2],
    fraction: f64,
}

impl core::fmt::Debug for LayerAlbedo {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("LayerAlbedo").field("fraction", &self.fraction).finish_non_exhaustive()
    }
}

impl LayerAlbedo {
    /// Clamps `roughness` to \[0, 1\]; NaN counts as 0.
    pub(super) fn new(roughness: f64) -> Self {
        let (below, fraction) = place(roughness, ROUGHNESSES);
        let row = |index: usize| ROWS[index].get_or_init(|| Row::integrate(entry(index, ROUGHNESSES)));
        Self { rows: [row(below), row(below + 1)], fraction }
    }

    /// Directional albedo E of a dielectric of index 1.5 at a cosine.
    pub(super) fn directional(&self, cos: f64) -> f64 {
        dielectric(self.directional_by_fresnel(cos))
    }

    /// Mean albedo Ē of a dielectric of index 1.5.
    pub(super) fn mean(&self) -> f64 {
        dielectric(self.mean_by_fresnel())
    }

    /// E of facets with other Fresnel terms: f0 times the first number plus f90 times the second.
    pub(super) fn directional_by_fresnel(&self, cos: f64) -> Split {
        let (column, fraction) = place(cos, COSINES);
        let at = |row: usize| between(self.rows[row].albedo[column], self.rows[row].albedo[column + 1], fraction);
        between(at(0), at(1), self.fraction)
    }

    /// Ē in the parts of [`LayerAlbedo::directional_by_fresnel`].
    pub(super) fn mean_by_fresnel(&self) -> Split {
        let [below, above] = self.rows;
        between(below.mean, above.mean, self.fraction)
    }
}

/// Version of [`LayerAlbedo::directional`] for the layers of lanes; not valid where there is none.
#[inline(always)]
pub(super) fn directional_lanes<L: LaneSet>(lanes: L, layers: &[Option<LayerAlbedo>; LANES], cos: L::D) -> L::D {
    let [along, grazing] = directional_by_fresnel_lanes(lanes, layers, cos);
    along * F0 + grazing
}

/// Version of [`LayerAlbedo::directional_by_fresnel`] for the layers of lanes; not valid where there is none.
#[inline(always)]
pub(super) fn directional_by_fresnel_lanes<L: LaneSet>(
    lanes: L,
    layers: &[Option<LayerAlbedo>; LANES],
    cos: L::D,
) -> [L::D; 2] {
    let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
    let last = (COSINES - 1) as f64;
    let x = Real::select(cos.gt(zero), cos.min(one), zero);
    // The addition rounds to an integer.
    let root = x.sqrt() * last;
    let rounded = root + INTEGER - INTEGER;
    let below = Real::select(rounded.gt(root), rounded - 1.0, rounded).min(lanes.splat_f64(last - 1.0));
    let (from, to) = (below / lanes.splat_f64(last), (below + 1.0) / lanes.splat_f64(last));
    let (from, to) = (from * from, to * to);
    let fraction = (x - from) / (to - from);
    let mut columns = [0.0; LANES];
    lanes.store_f64(below, &mut columns);
    // By row, column and part.
    let mut cells = [[[LaneArray::default(); 2]; 2]; 2];
    let mut between_rows = [0.0; LANES];
    for lane in 0..L::N {
        let (Some(layer), column) = (&layers[lane], columns[lane] as usize) else { continue };
        for (cells, row) in cells.iter_mut().zip(&layer.rows) {
            let Some(splits) = row.albedo.get(column..column + 2) else { continue };
            for (cell, [along, grazing]) in cells.iter_mut().zip(splits) {
                (cell[0][lane], cell[1][lane]) = (*along, *grazing);
            }
        }
        between_rows[lane] = layer.fraction;
    }
    let between_rows = lanes.load_f64(&between_rows);
    let mut split = [zero; 2];
    for part in 0..2 {
        let mut of_rows = [zero; 2];
        for row in 0..2 {
            let [from, to] = &cells[row];
            let (from, to) = (lanes.load_f64(&from[part]), lanes.load_f64(&to[part]));
            of_rows[row] = from + (to - from) * fraction;
        }
        split[part] = of_rows[0] + (of_rows[1] - of_rows[0]) * between_rows;
    }
    split
}

fn dielectric([along, grazing]: Split) -> f64 {
    F0 * along + grazing
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

fn between(a: Split, b: Split, fraction: f64) -> Split {
    [a[0] + (b[0] - a[0]) * fraction, a[1] + (b[1] - a[1]) * fraction]
}

impl Row {
    fn integrate(roughness: f64) -> Self {
        let lattice = lattice();
        let albedo: [Split; COSINES] =
            core::array::from_fn(|column| directional_albedo(entry(column, COSINES), roughness, &lattice));
        // ∫ E · 2 cos d cos, where E is a line a + b · cos between two entries.
        let mean = [0, 1].map(|part| {
            let segment = |column: usize| {
                let (from, to) = (entry(column, COSINES), entry(column + 1, COSINES));
                let b = (albedo[column + 1][part] - albedo[column][part]) / (to - from);
                let a = albedo[column][part] - b * from;
                let integral = |cos: f64| (a + 2.0 / 3.0 * b * cos) * cos * cos;
                integral(to) - integral(from)
            };
            (0..COSINES - 1).map(segment).sum()
        });
        Self { albedo, mean }
    }
}

/// Sine and cosine of the azimuth, and the second coordinate, of a point of the lattice.
type LatticePoint = [f64; 3];

/// Points of the lattice.
///
/// The integrand is even in the azimuth, so that half of the azimuths suffice. A lattice, unlike a grid, has no lines of
/// points along the edge beyond which facets reflect into the surface.
fn lattice() -> Vec<LatticePoint> {
    let [points, generator] = LATTICE;
    let point = |index: u32| {
        let azimuth = f64::from(index * generator % points) / f64::from(points);
        let (sin, cos) = transcendental::sincos(TAU * (0.5 * azimuth));
        [sin, cos, (f64::from(index) + 0.5) / f64::from(points)]
    };
    (0..points).map(point).collect()
}

/// ∫ f cos dω: mean weight of samples of the visible normals.
fn directional_albedo(cos: f64, roughness: f64, lattice: &[LatticePoint]) -> Split {
    let Some(facets) = Ggx::from_roughness(roughness) else {
        let w = schlick_weight(cos);
        return [1.0 - w, w];
    };
    // The limit towards 90°: at 90° itself no facet is visible.
    let cos = cos.max(1e-6);
    let wo = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
    let sum = match LaneLevel::best() {
        Some(level) => dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || weight_in_lanes(simd, facets.alpha(), wo, lattice),
        )),
        None => weight_of_points(facets.alpha(), wo, lattice),
    };
    sum.map(|sum| sum / lattice.len() as f64)
}

/// Sum of the weights of samples, in the order of the points.
fn weight_of_points(alpha: f64, wo: DVec3, lattice: &[LatticePoint]) -> Split {
    let mut sum = [0.0; 2];
    for &point in lattice {
        let weight = sample_weight(IsotropicGgx { alpha }, wo.into(), point);
        sum = [sum[0] + weight[0], sum[1] + weight[1]];
    }
    sum
}

/// Version of [`weight_of_points`] for lanes: the same sum.
#[inline(always)]
fn weight_in_lanes<S: Simd>(simd: S, alpha: f64, wo: DVec3, lattice: &[LatticePoint]) -> Split {
    let alpha = Lanes::splat(simd, alpha);
    let wo = Vector3::splat(alpha, wo);
    let mut sum = [0.0; 2];
    for points in lattice.chunks(LANES) {
        let mut block = [LaneArray::default(); 3];
        for (lane, &[sin, cos, second]) in points.iter().enumerate() {
            block[0][lane] = sin;
            block[1][lane] = cos;
            block[2][lane] = second;
        }
        let point = [Lanes::load(simd, &block[0]), Lanes::load(simd, &block[1]), Lanes::load(simd, &block[2])];
        let [along, grazing] = sample_weight(IsotropicGgx { alpha }, wo, point);
        let (along, grazing) = (along.store(), grazing.store());
        for lane in 0..points.len() {
            sum = [sum[0] + along[lane], sum[1] + grazing[lane]];
        }
    }
    sum
}

/// Weight f cos / pdf of a sample of the visible normals, 0 below the surface.
#[inline(always)]
fn sample_weight<R: Float64>(facets: IsotropicGgx<R>, wo: Vector3<R>, [sin, cos, second]: [R; 3]) -> [R; 2] {
    let m = visible_normal([facets.alpha; 2], wo, (sin, cos), second);
    let wi = reflect_lanes(-wo, m);
    let (reflection, pdf) = facets.reflection_with_pdf((wo, facets.stretched_length(wo)), wi, m);
    let zero = second.splat(0.0);
    let weight = R::select(wi.z.gt(zero), reflection * wi.z / pdf, zero);
    let w = schlick_weight(wo.dot(m));
    [weight * (second.splat(1.0) - w), weight * w]
}

#[cfg(test)]
mod tests {
    use super::{super::schlick::dielectric_fresnel, *};
    use crate::optics;

    /// Midpoint rule on a grid that is finer by far than the lattice.
    fn albedo_by_grid(cos: f64, roughness: f64, steps: u32) -> f64 {
        let facets = Ggx::from_roughness(roughness).unwrap();
        let wo = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
        let at = |index: u32| (f64::from(index) + 0.5) / f64::from(steps);
        let weight = |index: u32| {
            let m = facets.sample(wo, [at(index % steps), at(index / steps)]);
            let wi = optics::reflect(-wo, m);
            // f · cos / pdf of perfectly reflecting facets is G₂/G₁.
            let shadowing = (wo.z + facets.stretched_length(wo)) * wi.z
                / (wo.z * facets.stretched_length(wi) + wi.z * facets.stretched_length(wo));
            if wi.z > 0.0 { dielectric_fresnel(wo.dot(m)) * shadowing } else { 0.0 }
        };
        (0..steps * steps).map(weight).sum::<f64>() / f64::from(steps * steps)
    }

    #[test]
    fn lanes_integrate_the_same_bits() {
        for (cos, roughness) in [(0.0, 0.1), (0.01, 1.0), (0.3, 0.05), (1.0, 0.6)] {
            let (lattice, alpha) = (lattice(), Ggx::from_roughness(roughness).expect("rough").alpha());
            let cos = f64::max(cos, 1e-6);
            let wo = DVec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
            let sum = weight_of_points(alpha, wo, &lattice).map(|sum| (sum / lattice.len() as f64).to_bits());
            assert_eq!(directional_albedo(cos, roughness, &lattice).map(f64::to_bits), sum, "{cos} {roughness}");
        }
    }

    /// White plastic of roughness 0.4 at 89° was 0.33 % too dark: entries were sums over a grid of 20² points.
    #[test]
    fn the_albedo_of_a_layer_is_its_integral_at_grazing_angles() {
        for roughness in [0.1, 0.2, 0.3, 0.4, 0.55, 0.75, 1.0] {
            for degrees in [0.0f64, 45.0, 60.0, 75.0, 85.0, 89.0, 89.5, 89.9] {
                let cos = transcendental::cos(degrees.to_radians());
                let expected = albedo_by_grid(cos, roughness, 150);
                let found = LayerAlbedo::new(roughness).directional(cos);
                assert!(
                    (found - expected).abs() < 1e-3,
                    "roughness {roughness}, {degrees}°: {found:.5} instead of {expected:.5}"
                );
            }
        }
    }
}
