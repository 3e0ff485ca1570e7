//! The sphere of directions in cells that are small where a lobe is sharp, and integrals over them.

use super::*;
use core::f64::consts::{PI, TAU};
use rt_math::Frame;

const RINGS: usize = 24;
const SECTORS: usize = 8;

/// Number of cells of both hemispheres.
pub(super) const CELLS: usize = 2 * RINGS * SECTORS;

/// Rings and sectors around an axis in each hemisphere; rings are narrow near the axis.
pub(super) struct Sphere {
    frames: [Frame; 2],
}

impl Sphere {
    /// Cells for the lobes of a surface of index of refraction `ior`. The axes are the mirrored and refracted directions of
    /// `wo`.
    pub(super) fn around(wo: DVec3, ior: f64) -> Self {
        let mirrored = DVec3::new(-wo.x, -wo.y, wo.z);
        let eta = if wo.z > 0.0 { 1.0 / ior } else { ior };
        let normal = DVec3::Z * wo.z.signum();
        let refracted = crate::optics::refract(-wo, normal, eta).unwrap_or(-normal);
        let axes = if wo.z > 0.0 { [mirrored, refracted] } else { [refracted, mirrored] };
        Self { frames: axes.map(Frame::from_z) }
    }

    /// The cell that a direction lies in.
    pub(super) fn cell(&self, w: DVec3) -> usize {
        let hemisphere = usize::from(w.z < 0.0);
        let local = self.frames[hemisphere].to_local(w);
        let from_axis = transcendental::atan2(transcendental::hypot(local.x, local.y), local.z);
        let azimuth = (transcendental::atan2(local.y, local.x) / TAU).rem_euclid(1.0);
        let ring = (RINGS as f64 * (from_axis / PI).sqrt().sqrt()) as usize;
        let sector = (SECTORS as f64 * azimuth) as usize;
        (hemisphere * RINGS + ring.min(RINGS - 1)) * SECTORS + sector.min(SECTORS - 1)
    }

    /// The integral of `f` over each cell.
    pub(super) fn integrals(&self, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        self.integrals_within(1e-6, 2, f)
    }

    /// The integral of `f` over each cell. Cells are halved `min_depth` times, and on until that changes the integral of a part
    /// by less than `tolerance`.
    pub(super) fn integrals_within(&self, tolerance: f64, min_depth: u32, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        let ring_edge = |ring: usize| {
            let x = ring as f64 / RINGS as f64;
            PI * x * x * x * x
        };
        let integral = |index: usize| {
            let (sector, ring, hemisphere) = (index % SECTORS, index / SECTORS % RINGS, index / (SECTORS * RINGS));
            let integrand = |from_axis: f64, azimuth: f64| {
                let (sin, cos) = transcendental::sincos(from_axis);
                let (sin_phi, cos_phi) = transcendental::sincos(azimuth);
                let w = self.frames[hemisphere].from_local(DVec3::new(sin * cos_phi, sin * sin_phi, cos));
                if (w.z < 0.0) == (hemisphere == 1) { f(w) * sin } else { 0.0 }
            };
            let width = TAU / SECTORS as f64;
            let patch = Patch {
                x: [ring_edge(ring), ring_edge(ring + 1)],
                y: [sector as f64 * width, (sector + 1) as f64 * width],
            };
            patch.integral(&integrand, patch.gauss(&integrand), tolerance, [min_depth, 9])
        };
        (0..CELLS).map(integral).collect()
    }
}

struct Patch {
    x: [f64; 2],
    y: [f64; 2],
}

impl Patch {
    /// `whole` is the integral by one rule; `depths` are the minimum and maximum numbers of times to halve the patch.
    fn integral(&self, f: &impl Fn(f64, f64) -> f64, whole: f64, tolerance: f64, depths: [u32; 2]) -> f64 {
        let quarters = self.quarters();
        let parts = [0, 1, 2, 3].map(|at| quarters[at].gauss(f));
        let sum: f64 = parts.iter().sum();
        let [min, max] = depths;
        if max == 0 || min == 0 && (sum - whole).abs() < tolerance {
            return sum;
        }
        let depths = [min.saturating_sub(1), max - 1];
        quarters.iter().zip(parts).map(|(quarter, part)| quarter.integral(f, part, tolerance, depths)).sum()
    }

    fn quarters(&self) -> [Self; 4] {
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        let halves = |ends: [f64; 2]| [[ends[0], middle(ends)], [middle(ends), ends[1]]];
        let ([left, right], [low, high]) = (halves(self.x), halves(self.y));
        [(left, low), (left, high), (right, low), (right, high)].map(|(x, y)| Self { x, y })
    }

    /// Three by three points of Gauss and Legendre.
    fn gauss(&self, f: &impl Fn(f64, f64) -> f64) -> f64 {
        const POINTS: [(f64, f64); 3] =
            [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
        let half = |[a, b]: [f64; 2]| 0.5 * (b - a);
        let at = |[a, b]: [f64; 2], point: f64| 0.5 * (a + b) + 0.5 * (b - a) * point;
        let mut sum = 0.0;
        for (x, x_weight) in POINTS {
            for (y, y_weight) in POINTS {
                sum += x_weight * y_weight * f(at(self.x, x), at(self.y, y));
            }
        }
        sum * half(self.x) * half(self.y)
    }
}

#[test]
fn cells_cover_the_sphere() {
    for ior in [1.0 / 1.5, 1.5] {
        for degrees in [0.0, 45.0, 89.0, 120.0] {
            let sphere = Sphere::around(at_angle(degrees, 1.0), ior);
            let areas = sphere.integrals(|_| 1.0);
            let total: f64 = areas.iter().sum();
            assert!((total / (4.0 * PI) - 1.0).abs() < 2e-4, "{total}");
            // Directions lie in the cells whose areas were measured, as often as these are large.
            let mut counts = vec![0.0; CELLS];
            let draws = 200_000;
            for index in 0..draws {
                let u = numbers(9, index);
                let (z, (sin, cos)) = (2.0 * u[0] - 1.0, transcendental::sincos(TAU * u[1]));
                let radius = (1.0 - z * z).sqrt();
                counts[sphere.cell(DVec3::new(radius * cos, radius * sin, z))] += 1.0;
            }
            for (count, area) in counts.into_iter().zip(areas) {
                let expected = area / (4.0 * PI) * draws as f64;
                assert!((count - expected).abs() < 6.0 * expected.sqrt() + 5.0, "{count} for {expected}");
            }
        }
    }
}
