//! Sheen of cloth.

use crate::{
    lane_set::LaneSet,
    lanes::{LANES, LaneArray},
};
use core::f64::consts::{PI, TAU};
use rt_math::{DVec3, Float64, Real, Rgb, transcendental};
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

/// Albedo of sheen of one roughness: a position between two rows of the table.
#[derive(Clone, Copy)]
pub(super) struct SheenAlbedo {
    rows: [&'static SheenRow; 2],
    fraction: f64,
}

impl core::fmt::Debug for SheenAlbedo {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("SheenAlbedo").field("fraction", &self.fraction).finish_non_exhaustive()
    }
}

impl SheenAlbedo {
    /// Clamps `roughness` as [`Sheen`] does.
    pub(super) fn new(roughness: f64) -> Self {
        let row = (roughness.clamp(Sheen::MIN_ROUGHNESS, 1.0) - Sheen::MIN_ROUGHNESS) / (1.0 - Sheen::MIN_ROUGHNESS);
        let (row, fraction) = place(row, ROUGHNESSES);
        Self { rows: [albedo_row(row), albedo_row(row + 1)], fraction }
    }

    /// Directional albedo of white sheen at a cosine.
    fn white(&self, cos: f64) -> f64 {
        let (column, right) = place(cos, COSINES);
        let along = |row: &SheenRow| row[column] * (1.0 - right) + row[column + 1] * right;
        along(self.rows[0]) * (1.0 - self.fraction) + along(self.rows[1]) * self.fraction
    }
}

/// Version of [`Sheen::albedo`] for lanes, given the brightest channels of the colours; not valid where there is no sheen.
#[inline(always)]
pub(super) fn sheen_albedo_lanes<L: LaneSet>(
    lanes: L,
    albedos: &[Option<SheenAlbedo>; LANES],
    color: L::D,
    cos: L::D,
) -> L::D {
    let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
    let at = cos.max(zero).min(one) * (COSINES - 1) as f64;
    let column = lanes.floor_f64(at).min(lanes.splat_f64((COSINES - 2) as f64));
    let right = at - column;
    let (mut columns, mut fractions) = ([0.0; LANES], [0.0; LANES]);
    lanes.store_f64(column, &mut columns);
    // By row and column.
    let mut cells = [[LaneArray::default(); 2]; 2];
    for lane in 0..L::N {
        let (Some(albedo), column) = (&albedos[lane], columns[lane] as usize) else { continue };
        for (cells, row) in cells.iter_mut().zip(albedo.rows) {
            let Some(&[from, to]) = row.get(column..column + 2) else { continue };
            (cells[0][lane], cells[1][lane]) = (from, to);
        }
        fractions[lane] = albedo.fraction;
    }
    let down = lanes.load_f64(&fractions);
    let mut rows = [zero; 2];
    for row in 0..2 {
        let [from, to] = &cells[row];
        rows[row] = lanes.load_f64(from) * (one - right) + lanes.load_f64(to) * right;
    }
    (color * (rows[0] * (one - down) + rows[1] * down)).min(one)
}

/// f of white sheen with this exponent, given the cosines of both directions and of the half vector, for one number or for lanes.
#[inline(always)]
pub(super) fn white_sheen<R: Float64>(power: R, [cos_o, cos_i]: [R; 2], cos_m: R) -> R {
    let (zero, one) = (power.splat(0.0), power.splat(1.0));
    let sin = zero.max((one - cos_m) * (one + cos_m)).sqrt();
    let d = (power + 2.0) * transcendental::pow(sin, power) / power.splat(TAU);
    d / ((cos_o + cos_i - cos_o * cos_i) * 4.0)
}

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
        white_sheen(self.power(), [wo.z, wi.z], m.z)
    }

    /// Exponent 1/α of the distribution.
    pub(super) fn power(&self) -> f64 {
        let roughness = self.roughness.clamp(Self::MIN_ROUGHNESS, 1.0);
        1.0 / (roughness * roughness)
    }

    /// Directional albedo at a cosine, of the brightest channel.
    pub fn albedo(&self, cos: f64) -> f64 {
        (self.color.max_component() * SheenAlbedo::new(self.roughness).white(cos)).min(1.0)
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
