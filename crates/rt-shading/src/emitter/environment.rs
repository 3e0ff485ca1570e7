//! Light from all around: an image on the inside of a sphere that is infinitely large.

use super::distribution::{accumulate, find, probability};
use super::emission::check_radiance;
use super::sample::density;
use super::{EmitterError, EmitterSample};
use rt_math::transcendental::{atan2, sin, sincos};
use rt_math::{DMat3, DQuat, DVec3, Rgb, Transform};
use std::f64::consts::{PI, TAU};

/// An equirectangular image around the scene, looked up bilinearly and sampled by its luminance.
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
/// The cells of the distribution lie *between* the centres of the pixels, where the image is a mixture of four of them: the
/// density is positive wherever there is light. Within a cell, heights `cos θ` are uniform and not the angles θ: the
/// density is constant over the cell, the same solid angle has the same chance, and nothing is divided by the `sin θ`
/// that vanishes at the poles. Otherwise this is the piecewise-constant distribution of PBR 4th ed., section 12.5.2. A
/// constant image is sampled uniformly.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentLight {
    width: usize,
    height: usize,
    /// Row by row from the top.
    pixels: Vec<Rgb>,
    /// Running sums over the `width` cells of each of the `height + 1` rows of cells.
    columns: Vec<f64>,
    /// Running sums over the rows of cells.
    rows: Vec<f64>,
    /// Where rows of cells begin and end: 1 − cos θ and 1 + cos θ, neither of which cancels.
    heights: Vec<[f64; 2]>,
    world_from_local: DMat3,
    /// ∫ L dω, with the radiance of each cell taken as that of its middle.
    integral: Rgb,
}

impl EnvironmentLight {
    /// The image, row by row from the top, turned into the world by `rotation` (of any length).
    ///
    /// # Errors
    /// If the number of pixels is 0 or not `width · height`, a radiance cannot be used, or the rotation is none.
    pub fn new(width: usize, height: usize, pixels: Vec<Rgb>, rotation: DQuat) -> Result<Self, EmitterError> {
        if pixels.is_empty() || width.checked_mul(height) != Some(pixels.len()) {
            return Err(EmitterError::BadImage { width, height, pixels: pixels.len() });
        }
        if let Some(bad) = pixels.iter().position(|&pixel| check_radiance(pixel).is_err()) {
            return Err(EmitterError::BadPixel { column: bad % width, row: bad / width, radiance: pixels[bad] });
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

    /// The same radiance from everywhere.
    ///
    /// # Errors
    /// If a component is NaN, negative, or beyond 1e100.
    pub fn constant(radiance: Rgb) -> Result<Self, EmitterError> {
        check_radiance(radiance)?;
        Self::new(1, 1, vec![radiance], DQuat::IDENTITY)
    }

    /// A direction from which light comes. `None` if the image is black.
    pub fn sample(&self, u: [f64; 2]) -> Option<EmitterSample> {
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
        let sample = EmitterSample {
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

    /// Density, per unit solid angle, with which [`sample`](Self::sample) takes this direction, of any length.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        self.place(direction).map_or(0.0, |(x, y)| {
            let (column, row) = (x as usize % self.width, (y as usize).min(self.height));
            density(self.probability(column, row) / self.cell_solid_angle(row))
        })
    }

    /// Radiance that is seen by looking along `direction`, of any length; black for one that is zero or NaN.
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        self.place(direction).map_or(Rgb::BLACK, |(x, y)| {
            let (column, row) = (x as usize, (y as usize).min(self.height));
            self.mixture(column % self.width, row, [x - column as f64, y - row as f64])
        })
    }

    /// Power that enters a scene within a ball of this radius: π R² ∫ L dω.
    pub fn power(&self, scene_radius: f64) -> Rgb {
        self.integral * (PI * scene_radius * scene_radius)
    }

    /// Fills the running sums.
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

    /// Pixels at the left and at the right of a cell, the upper one first. Columns go around; beyond the poles there is the
    /// last row again.
    fn corners(&self, column: usize, row: usize) -> [[Rgb; 2]; 2] {
        let left = if column == 0 { self.width - 1 } else { column - 1 };
        let rows = [row.saturating_sub(1), row.min(self.height - 1)];
        [left, column].map(|column| rows.map(|row| self.pixels[row * self.width + column]))
    }

    /// What is seen within a cell, at parts of it from the left and from the top.
    fn mixture(&self, column: usize, row: usize, [x, y]: [f64; 2]) -> Rgb {
        let [left, right] = self.corners(column, row);
        left[0].lerp(right[0], x).lerp(left[1].lerp(right[1], x), y)
    }

    /// Where a direction lies, in cells from the left and from the top.
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

    /// The polar angle in rows of cells. Those at the poles are half as high, so they begin half a cell before the image.
    fn rows_from_top(&self, sin: f64, cos: f64) -> f64 {
        atan2(sin, cos) / PI * self.height as f64 + 0.5
    }

    /// The height cos θ of a row of cells.
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

/// What a colour counts in the choice: its luminance, and something for light that is too faint to have one.
fn weight(radiance: Rgb) -> f64 {
    if radiance.is_black() { 0.0 } else { radiance.luminance().max(f64::MIN_POSITIVE) }
}

/// cos a − cos b without cancellation.
fn cos_difference(a: f64, b: f64) -> f64 {
    2.0 * sin(0.5 * (a + b)) * sin(0.5 * (b - a))
}

#[cfg(test)]
mod tests {
    use super::super::Emitter;
    use super::super::estimate::{Estimate, integral_of_pdf, irradiance, irradiance_by};
    use super::*;
    use rt_math::random::{hash, unit};

    const WIDTH: usize = 12;
    const HEIGHT: usize = 7;

    fn turned() -> DQuat {
        DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8)
    }

    /// An image that is black but for the pixels given.
    fn image(lit: &[(usize, usize, f64)], rotation: DQuat) -> EnvironmentLight {
        let mut pixels = vec![Rgb::BLACK; WIDTH * HEIGHT];
        for &(column, row, radiance) in lit {
            pixels[row * WIDTH + column] = Rgb::new(radiance, 2.0 * radiance, 0.5 * radiance);
        }
        EnvironmentLight::new(WIDTH, HEIGHT, pixels, rotation).expect("an environment")
    }

    /// Bright and faint pixels at the poles, at the seam and elsewhere, black rows between.
    fn images() -> Vec<EnvironmentLight> {
        let noise = (0..WIDTH * HEIGHT).map(|i| (i % WIDTH, i / WIDTH, unit(hash(&[i as u64])))).collect::<Vec<_>>();
        vec![
            image(&[(4, 3, 1.0)], turned()),
            image(&[(0, 0, 2.0)], DQuat::IDENTITY),
            image(&[(11, 6, 1.0), (0, 6, 1e-6)], turned()),
            image(&[(0, 3, 5.0), (6, 5, 1e4), (7, 5, 1e-3)], turned()),
            image(&noise, turned()),
        ]
    }

    fn draw(i: u64) -> [f64; 2] {
        [unit(hash(&[i, 0, 5])), unit(hash(&[i, 1, 5]))]
    }

    #[test]
    fn pixels_lie_where_they_are_seen() {
        let sky = |column, row| image(&[(column, row, 1.0)], DQuat::IDENTITY);
        let height = DVec3::Y * sincos(PI / 7.0).0 / sincos(PI / 7.0).1;
        let column = |turn: f64| DVec3::new(-sincos(turn * TAU).0, 0.0, sincos(turn * TAU).1);
        // The middle of column 8 is 8.5 of 12 parts around from +z, over −x and −z.
        for (light, direction) in [(sky(8, 3), column(8.5 / 12.0)), (sky(3, 2), column(3.5 / 12.0) + height)] {
            assert!((light.radiance(direction * 7.0) - Rgb::new(1.0, 2.0, 0.5)).max_component().abs() < 1e-12);
        }
        assert!(sky(5, 3).radiance(DVec3::NEG_Z).g > 0.9 && sky(6, 3).radiance(DVec3::NEG_Z).g > 0.9, "the middle");
        assert!(sky(8, 3).radiance(DVec3::X).g > 0.9 && sky(2, 3).radiance(DVec3::NEG_X).g > 0.9, "right and left");
        assert!(sky(4, 0).radiance(column(4.5 / 12.0) + DVec3::Y * 1e3).g > 1.9, "above");
    }

    #[test]
    fn a_turned_image_is_seen_turned() {
        let (plain, light) =
            (image(&[(4, 2, 1.0), (7, 5, 3.0)], DQuat::IDENTITY), image(&[(4, 2, 1.0), (7, 5, 3.0)], turned()));
        let rotation = turned().normalize();
        for i in 0..100 {
            let [x, y] = draw(i);
            let direction = DVec3::new(x - 0.5, y - 0.5, draw(i + 1000)[0] - 0.5);
            assert!((light.radiance(rotation * direction) - plain.radiance(direction)).max_component().abs() < 1e-12);
            assert!((light.pdf(rotation * direction) - plain.pdf(direction)).abs() <= 1e-12 * plain.pdf(direction));
        }
    }

    #[test]
    fn a_constant_environment_is_sampled_uniformly() {
        let constant = EnvironmentLight::constant(Rgb::gray(3.0)).expect("an environment");
        let sky = EnvironmentLight::new(5, 4, vec![Rgb::gray(3.0); 20], turned()).expect("an environment");
        for light in [constant, sky] {
            for i in 0..1000 {
                let sample = light.sample(draw(i)).expect("a sample");
                assert!((sample.pdf * 4.0 * PI - 1.0).abs() < 1e-12 && (sample.radiance.r - 3.0).abs() < 1e-12);
            }
            assert!((light.power(2.0).g / (3.0 * 16.0 * PI * PI) - 1.0).abs() < 1e-12);
            let at = [DVec3::ONE, DVec3::new(0.6, 0.0, -0.8)];
            irradiance(&Emitter::Environment(light), at, 200_000).assert("hemisphere", 3.0 * PI);
        }
    }

    /// χ² of directions in boxes of their own, which divide the cells, against the density.
    #[test]
    fn samples_fall_as_densely_as_the_density_says() {
        let (columns, rows, count) = (2 * WIDTH, 2 * HEIGHT, 200_000u64);
        for light in images() {
            let mut found = vec![0.0; columns * rows];
            for i in 0..count {
                let local = light.world_from_local.transpose() * light.sample(draw(i)).expect("a sample").direction;
                let turn = (atan2(-local.x, local.z) / TAU).rem_euclid(1.0);
                let down = atan2((1.0 - local.y * local.y).max(0.0).sqrt(), local.y) / PI;
                let cell = [turn * columns as f64, down * rows as f64].map(|x| x as usize);
                found[cell[1].min(rows - 1) * columns + cell[0].min(columns - 1)] += 1.0;
            }
            let (mut chi2, mut freedom) = (0.0, -1.0);
            for (i, found) in found.iter().enumerate() {
                let [turn, down] = [(i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5];
                let (sin, cos) = sincos(PI * down / rows as f64);
                let (s, c) = sincos(TAU * turn / columns as f64);
                let middle = light.world_from_local * DVec3::new(-sin * s, cos, sin * c);
                let [top, bottom] = [down - 0.5, down + 0.5].map(|y| PI * y / rows as f64);
                let solid_angle = TAU / columns as f64 * cos_difference(top, bottom);
                let expected = light.pdf(middle) * solid_angle * count as f64;
                if expected < 5.0 {
                    assert!(*found <= expected + 5.0 * expected.sqrt() + if expected > 0.0 { 3.0 } else { 0.0 });
                    continue;
                }
                chi2 += (found - expected) * (found - expected) / expected;
                freedom += 1.0;
            }
            println!("χ² = {chi2:.1} of {freedom} degrees");
            let limit = freedom + 5.0 * f64::sqrt(2.0 * freedom) + 10.0;
            assert!(chi2 < limit, "χ² = {chi2} of {freedom} degrees of freedom");
        }
    }

    #[test]
    fn densities_agree_and_integrate_to_one() {
        for light in images() {
            let emitter = Emitter::Environment(light.clone());
            integral_of_pdf(&emitter, DVec3::ZERO, 200_000).assert("pdf", 1.0);
            let cells = (0..=HEIGHT).flat_map(|row| (0..WIDTH).map(move |column| (column, row)));
            let sum: f64 = cells.map(|(column, row)| light.probability(column, row)).sum();
            assert!((sum - 1.0).abs() < 1e-14);
            for i in 0..20_000 {
                let sample = light.sample(draw(i)).expect("a sample");
                assert!((sample.direction.length() - 1.0).abs() < 1e-14, "{sample:?}");
                assert_eq!((sample.point, sample.distance, sample.shadow_target()), (None, f64::INFINITY, None));
                let pdf = light.pdf(sample.direction);
                assert!((pdf / sample.pdf - 1.0).abs() < 1e-12, "{pdf} for {sample:?}");
            }
        }
    }

    /// Where there is light there is density, also between the last lit pixel and its black neighbour.
    #[test]
    fn light_is_never_without_density() {
        for light in images() {
            for i in 0..50_000 {
                let [a, b] = draw(i);
                let (sin, cos) = sincos(TAU * a);
                let r = (1.0 - (2.0 * b - 1.0) * (2.0 * b - 1.0)).sqrt();
                let direction = DVec3::new(r * cos, r * sin, 2.0 * b - 1.0);
                assert_eq!(light.radiance(direction).is_black(), light.pdf(direction) == 0.0);
            }
        }
    }

    #[test]
    fn irradiance_is_that_of_uniform_directions() {
        let normal = DVec3::new(0.48, 0.6, -0.64);
        for (light, peak) in images().into_iter().zip([0.5, 0.5, 0.5, 0.5, 1.5]) {
            let uniform = Estimate::of(200_000, |u| {
                let (z, (sin, cos)) = (2.0 * u[0] - 1.0, sincos(TAU * u[1]));
                let direction = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
                4.0 * PI * light.radiance(direction).g * direction.dot(normal).max(0.0)
            });
            let emitter = Emitter::Environment(light);
            let at = [DVec3::ZERO, normal];
            let sampled = irradiance(&emitter, at, 200_000);
            let z = |a: Estimate, b: Estimate| {
                let square = a.standard_error * a.standard_error + b.standard_error * b.standard_error;
                (a.mean - b.mean).abs() / (square + f64::MIN_POSITIVE).sqrt()
            };
            println!("irradiance {:.6} ± {:.1e}, z = {:.2}", sampled.mean, sampled.standard_error, z(sampled, uniform));
            assert!(z(sampled, uniform) < 5.0, "{sampled:?}, uniform {uniform:?}");
            assert!(sampled.standard_error <= peak * uniform.standard_error, "importance does not pay");
        }
        let emitter = Emitter::Environment(EnvironmentLight::constant(Rgb::WHITE).expect("an environment"));
        assert!(
            irradiance_by(&emitter, [DVec3::ZERO, normal], 200_000, |s| s.pdf * 1.02).z(PI) > 5.0,
            "a wrong density"
        );
    }

    #[test]
    fn poles_are_ordinary() {
        for light in [image(&[(3, 0, 1.0), (8, 6, 1.0)], DQuat::IDENTITY), image(&[(3, 0, 1.0), (8, 6, 1.0)], turned())]
        {
            for pole in [DVec3::Y, DVec3::NEG_Y, DVec3::new(1e-300, 1.0, -1e-300), DVec3::new(-0.0, -1.0, 0.0)] {
                let (pdf, radiance) = (light.pdf(pole), light.radiance(pole));
                assert!(pdf.is_finite() && radiance.is_finite(), "{pole}: {pdf}, {radiance:?}");
            }
            for u in [[0.0, 0.0], [0.999_999, 0.0], [0.5, 1.0], [0.5, 0.999_999_999_999], [0.2, 1e-300]] {
                // A corner of a cell may be the black middle of a pixel.
                let sample = light.sample(u);
                assert!(sample.is_none_or(|s| s.pdf.is_finite() && s.direction.is_finite()), "{sample:?}");
            }
        }
    }

    #[test]
    fn odd_images_and_numbers_are_refused_and_never_panic() {
        let grey = |count| vec![Rgb::WHITE; count];
        for (width, height, pixels) in [(0, 0, grey(0)), (2, 2, grey(3)), (usize::MAX, 2, grey(2)), (0, 4, grey(4))] {
            let refused = EnvironmentLight::new(width, height, pixels, DQuat::IDENTITY);
            assert!(matches!(refused, Err(EmitterError::BadImage { .. })));
        }
        let bad = vec![Rgb::WHITE, Rgb::WHITE, Rgb::new(0.0, f64::NAN, 0.0), Rgb::WHITE];
        let refused = EnvironmentLight::new(2, 2, bad, DQuat::IDENTITY);
        assert!(matches!(refused, Err(EmitterError::BadPixel { column: 0, row: 1, .. })));
        assert!(EnvironmentLight::new(1, 1, grey(1), DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)).is_err());
        assert!(EnvironmentLight::constant(Rgb::gray(-1.0)).is_err());
        let black = EnvironmentLight::constant(Rgb::BLACK).expect("an environment");
        assert_eq!((black.sample([0.5; 2]), black.pdf(DVec3::X)), (None, 0.0));
        let light = image(&[(1, 1, 1.0)], turned());
        for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::X * 1e-300, DVec3::X * 1e200] {
            assert!(light.pdf(direction).is_finite() && light.radiance(direction).is_finite(), "{direction}");
        }
        for u in [[f64::NAN; 2], [-1.0; 2], [2.0; 2]] {
            assert!(light.sample(u).is_none_or(|s| s.direction.is_finite()));
        }
    }
}
