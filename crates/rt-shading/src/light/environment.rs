//! Environment light: an image on the inside of an infinitely large sphere.

#[cfg(test)]
mod tests;

use super::light_error::check_radiance;
use super::light_sample::density;
use super::piecewise_constant::{accumulate, find, probability};
use super::{LightError, LightLiSample};
use rt_math::transcendental::{atan2, sin, sincos};
use rt_math::{DMat3, DQuat, DVec3, Rgb, Transform};
use std::f64::consts::{PI, TAU};

/// Equirectangular image around the scene, interpolated bilinearly and sampled by luminance.
///
/// ```text
///            +y                  column   0 ··· ¼ ··· ½ ··· ¾ ··· 1
///    ┌───────────────┐           towards +z    −x    −z    +x    +z
///    │               │ θ         the middle of the image lies in the direction −z, in which cameras look,
///    │      −z       │ ↓         and is not mirrored
///    └───────────────┘
///            −y                  L(θ, φ),  p(ω) = P(cell) / Ω(cell),  P ∝ luminance · Ω
/// ```
///
/// Cells of the distribution lie *between* the centres of the pixels, where the image is interpolated from four of them. The
/// density is thus positive wherever there is light. Within a cell, heights `cos θ` are uniform, not the angles θ. The density
/// per solid angle is thus constant and needs no division by `sin θ`, which vanishes at the poles. Otherwise this is the
/// piecewise-constant distribution of PBR 4th ed., section 12.5.2. A constant image is sampled uniformly.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentLight {
    width: usize,
    height: usize,
    /// Pixels row by row from the top.
    pixels: Vec<Rgb>,
    /// Cumulative distribution over the `width` cells of each of the `height + 1` rows of cells.
    columns: Vec<f64>,
    /// Cumulative distribution over the rows of cells.
    rows: Vec<f64>,
    /// Boundaries of rows of cells: 1 − cos θ and 1 + cos θ, neither of which cancels.
    heights: Vec<[f64; 2]>,
    world_from_local: DMat3,
    /// ∫ L dω by the radiance in the middle of each cell.
    integral: Rgb,
}

impl EnvironmentLight {
    /// Image, row by row from the top, rotated into world space by `rotation` (of any length).
    ///
    /// # Errors
    /// If the number of pixels is 0 or not `width · height`, a radiance is invalid, or the rotation is zero or not finite.
    pub fn new(width: usize, height: usize, pixels: Vec<Rgb>, rotation: DQuat) -> Result<Self, LightError> {
        if pixels.is_empty() || width.checked_mul(height) != Some(pixels.len()) {
            return Err(LightError::BadImage { width, height, pixels: pixels.len() });
        }
        if let Some(bad) = pixels.iter().position(|&pixel| check_radiance(pixel).is_err()) {
            return Err(LightError::BadPixel { column: bad % width, row: bad / width, radiance: pixels[bad] });
        }
        let world_from_local = Transform::rotate_quaternion(rotation)?.linear();
        let (columns, rows) = (vec![0.0; width * (height + 1)], vec![0.0; height + 1]);
        let polar_angle = |row: usize| PI * ((row as f64 - 0.5) / height as f64).clamp(0.0, 1.0);
        let heights =
            (0..height + 2).map(polar_angle).map(|t| [cos_difference(0.0, t), cos_difference(t, PI)]).collect();
        let integral = Rgb::BLACK;
        let mut light = Self { width, height, pixels, columns, rows, heights, world_from_local, integral };
        light.distribute();
        Ok(light)
    }

    /// Bytes of memory for an image and its distribution.
    pub const fn memory_of(width: usize, height: usize) -> usize {
        let sums = width.saturating_mul(height + 1).saturating_mul(size_of::<f64>());
        width.saturating_mul(height).saturating_mul(size_of::<Rgb>()).saturating_add(sums)
    }

    /// Bytes of memory of this light.
    pub const fn memory(&self) -> usize {
        Self::memory_of(self.width, self.height)
    }

    /// Constant radiance from all directions.
    ///
    /// # Errors
    /// If a component is NaN, negative, or beyond 1e100.
    pub fn constant(radiance: Rgb) -> Result<Self, LightError> {
        check_radiance(radiance)?;
        Self::new(1, 1, vec![radiance], DQuat::IDENTITY)
    }

    /// Samples a direction of incident light. `None` if the image is black.
    pub fn sample_li(&self, u: [f64; 2]) -> Option<LightLiSample> {
        let (row, down) = find(&self.rows, u[1])?;
        let (column, right) = find(self.row_of_cells(row), u[0])?;
        // cos θ runs from the top of the cell to its bottom; sin²θ is the product of its distances to both poles.
        let band = self.band(row);
        let [below_north, above_south] =
            [self.heights[row][0] + band * down, self.heights[row + 1][1] + band * (1.0 - down)];
        let sin_theta = (below_north * above_south).max(0.0).sqrt();
        let cos_theta = if below_north < above_south { 1.0 - below_north } else { above_south - 1.0 };
        let (sin_phi, cos_phi) = sincos((column as f64 - 0.5 + right) / self.width as f64 * TAU);
        let local = DVec3::new(-sin_theta * sin_phi, cos_theta, sin_theta * cos_phi);
        let direction = self.world_from_local * local;
        let pdf = density(self.probability(column, row) / self.cell_solid_angle(row));
        let lower_part = (self.rows_from_top(sin_theta, cos_theta) - row as f64).clamp(0.0, 1.0);
        let radiance = self.mixture(column, row, [right, lower_part]);
        let sample = LightLiSample {
            direction,
            distance: f64::INFINITY,
            point: None,
            point_error: DVec3::ZERO,
            normal: -direction,
            radiance,
            pdf,
        };
        (pdf > 0.0 && !radiance.is_black()).then_some(sample)
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) samples this direction, of any length.
    pub fn pdf_li(&self, direction: DVec3) -> f64 {
        self.place(direction).map_or(0.0, |(x, y)| {
            let (column, row) = (x as usize % self.width, (y as usize).min(self.height));
            density(self.probability(column, row) / self.cell_solid_angle(row))
        })
    }

    /// Radiance against the viewing `direction`, of any length; black if it is zero or NaN.
    pub fn le(&self, direction: DVec3) -> Rgb {
        self.place(direction).map_or(Rgb::BLACK, |(x, y)| {
            let (column, row) = (x as usize, (y as usize).min(self.height));
            self.mixture(column % self.width, row, [x - column as f64, y - row as f64])
        })
    }

    /// Power that enters a scene within a sphere of this radius: π R² ∫ L dω.
    pub fn power(&self, scene_radius: f64) -> Rgb {
        self.integral * (PI * scene_radius * scene_radius)
    }

    /// Fills the distributions.
    fn distribute(&mut self) {
        for row in 0..=self.height {
            let solid_angle = self.cell_solid_angle(row);
            for column in 0..self.width {
                let [left, right] = self.corners(column, row);
                let mean = (left[0] + left[1] + right[0] + right[1]) / 4.0;
                self.integral += mean * solid_angle;
                self.columns[row * self.width + column] = weight(mean);
            }
            let cells = row * self.width..(row + 1) * self.width;
            self.rows[row] = accumulate(&mut self.columns[cells]) * solid_angle;
        }
        accumulate(&mut self.rows);
    }

    /// Pixels at the left and at the right of a cell, the upper one first. Columns wrap around; beyond the poles the last row
    /// repeats.
    fn corners(&self, column: usize, row: usize) -> [[Rgb; 2]; 2] {
        let left = if column == 0 { self.width - 1 } else { column - 1 };
        let rows = [row.saturating_sub(1), row.min(self.height - 1)];
        [left, column].map(|column| rows.map(|row| self.pixels[row * self.width + column]))
    }

    /// Interpolated radiance within a cell, at fractions from the left and from the top.
    fn mixture(&self, column: usize, row: usize, [x, y]: [f64; 2]) -> Rgb {
        let [left, right] = self.corners(column, row);
        left[0].lerp(right[0], x).lerp(left[1].lerp(right[1], x), y)
    }

    /// Position of a direction, in cells from the left and from the top.
    fn place(&self, direction: DVec3) -> Option<(f64, f64)> {
        let local = self.world_from_local.transpose() * direction;
        let across = (local.x * local.x + local.z * local.z).sqrt();
        if !(local.is_finite() && local != DVec3::ZERO) {
            return None;
        }
        let turn = atan2(-local.x, local.z) / TAU;
        let turn = if turn < 0.0 { turn + 1.0 } else { turn };
        Some((turn * self.width as f64 + 0.5, self.rows_from_top(across, local.y)))
    }

    /// Polar angle in rows of cells. Rows at the poles are half as high: they start half a cell before the image.
    fn rows_from_top(&self, sin: f64, cos: f64) -> f64 {
        atan2(sin, cos) / PI * self.height as f64 + 0.5
    }

    /// Height cos θ of a row of cells.
    fn band(&self, row: usize) -> f64 {
        let [top, bottom] = [self.heights[row], self.heights[row + 1]];
        // The difference of the smaller numbers is exact to more digits.
        if bottom[0] < top[1] { bottom[0] - top[0] } else { top[1] - bottom[1] }
    }

    fn cell_solid_angle(&self, row: usize) -> f64 {
        TAU / self.width as f64 * self.band(row)
    }

    fn row_of_cells(&self, row: usize) -> &[f64] {
        &self.columns[row * self.width..(row + 1) * self.width]
    }

    fn probability(&self, column: usize, row: usize) -> f64 {
        probability(&self.rows, row) * probability(self.row_of_cells(row), column)
    }
}

/// Sampling weight of a radiance: its luminance, but positive where that underflows.
fn weight(radiance: Rgb) -> f64 {
    if radiance.is_black() { 0.0 } else { radiance.luminance().max(f64::MIN_POSITIVE) }
}

/// cos a − cos b without cancellation.
fn cos_difference(a: f64, b: f64) -> f64 {
    2.0 * sin(0.5 * (a + b)) * sin(0.5 * (b - a))
}
