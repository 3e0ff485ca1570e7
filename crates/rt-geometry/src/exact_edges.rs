//! Exact sides of edges and vertices on which a ray passes.

use rt_math::DVec3;
use rt_math::float::{power_of_two_scale, two_product, two_sum};

/// Most terms of a volume: six products of a number and two sums of two numbers, each the sum of sixteen.
const CAPACITY: usize = 96;

/// Minimum of [`DoubleDouble`] sums, per sum of magnitudes. Their error is less than 2⁻¹⁰² for ten roundings of 2⁻¹⁰⁵, so that sums of
/// at least this are accurate to 2⁻²⁴.
const MIN_DOUBLE_DOUBLE: f64 = 1.0 / (1u128 << 78) as f64;

/// Volumes `d·((p − o) × (q − o))` that the direction `d` of a ray from `o` spans with the edges `(p, q)`. They are positive where the edge
/// turns counterclockwise around the direction.
///
/// Each has the exact sign, and is 0 only when it is exactly 0. Its relative error is less than 2⁻²³, and all have a common positive
/// factor. Shewchuk,
/// "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997. Exact unless the coordinates of the points
/// differ by more than a factor of 10⁹⁰, or those of the direction do.
pub(crate) fn edge_volumes<const N: usize>(origin: DVec3, direction: DVec3, edges: [[DVec3; 2]; N]) -> [f64; N] {
    let size = edges.iter().flatten().fold(origin.abs(), |size, point| size.max(point.abs()));
    let scale = power_of_two_scale(size);
    let (o, d) = (origin * scale, direction * power_of_two_scale(direction));
    edges.map(|[p, q]| {
        let [p, q] = [p, q].map(|point| (point * scale).to_array());
        let [a, b] = [p, q].map(|point| [0, 1, 2].map(|i| DoubleDouble::sum(point[i], -o[i])));
        double_double_volume(d, a, b).unwrap_or_else(|| exact_volume(d, a, b))
    })
}

/// Volume `d·(a × b)` in twice the precision; `None` if its relative error may be more than 2⁻²⁴.
fn double_double_volume(d: DVec3, a: [DoubleDouble; 3], b: [DoubleDouble; 3]) -> Option<f64> {
    let (mut volume, mut magnitude) = (DoubleDouble::default(), 0.0);
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let [first, second] = [a[j].times(b[k]), a[k].times(b[j])];
        volume = volume.plus(first.minus(second).times(DoubleDouble { high: d[i], low: 0.0 }));
        magnitude += d[i].abs() * (first.high.abs() + second.high.abs());
    }
    (volume.high.abs() > MIN_DOUBLE_DOUBLE * magnitude).then_some(volume.high)
}

/// Volume `d·(a × b)`, with the exact sign.
fn exact_volume(d: DVec3, a: [DoubleDouble; 3], b: [DoubleDouble; 3]) -> f64 {
    let mut volume = Expansion::default();
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        for (sign, a, b) in [(1.0, a[j], b[k]), (-1.0, a[k], b[j])] {
            for a in [a.low, a.high] {
                for b in [b.low, b.high] {
                    volume.add_product(sign * d[i], a, b);
                }
            }
        }
    }
    volume.value()
}

/// Number of twice the precision: the sum of two numbers, of which the first is the rounded sum (Dekker 1971).
#[derive(Clone, Copy, Debug, Default)]
struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    /// Exact sum.
    fn sum(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        Self { high, low }
    }

    fn plus(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        Self::sum(sum.high, sum.low + (self.low + other.low))
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Self { high: -other.high, low: -other.low })
    }

    fn times(self, other: Self) -> Self {
        let (high, low) = two_product(self.high, other.high);
        Self::sum(high, low + (self.high * other.low + self.low * other.high))
    }
}

/// Area `(p − o) × d` of two coordinates of a point and the origin and direction of a ray, with the exact sign.
pub(crate) fn point_area(origin: [f64; 2], direction: [f64; 2], point: [f64; 2]) -> f64 {
    let factor = |[x, y]: [f64; 2]| power_of_two_scale(DVec3::new(x, y, 0.0));
    let (of_points, of_direction) = (factor([0, 1].map(|i| origin[i].abs().max(point[i].abs()))), factor(direction));
    let (o, p, d) = (origin.map(|x| x * of_points), point.map(|x| x * of_points), direction.map(|x| x * of_direction));
    scaled_area(o, d, p)
}

/// Weights of the ends of an edge in the point where a ray passes exactly through it, times a common factor. They depend on edge and ray
/// only.
pub(crate) fn edge_weights(origin: DVec3, direction: DVec3, [from, to]: [DVec3; 2]) -> [f64; 2] {
    let scale = power_of_two_scale(origin.abs().max(from.abs()).max(to.abs()));
    let (o, d) = (origin * scale, direction * power_of_two_scale(direction));
    let mut weights = [0.0; 2];
    for (x, y) in [(1, 2), (2, 0), (0, 1)] {
        // The distances of the ends from the ray are to each other like these areas, along any axis.
        let areas = [to, from].map(|end| end * scale).map(|p| scaled_area([o[x], o[y]], [d[x], d[y]], [p[x], p[y]]));
        let areas = areas.map(f64::abs);
        if areas[0] + areas[1] > weights[0] + weights[1] {
            weights = areas;
        }
    }
    weights
}

/// Area `(p − o) × d` of numbers whose products do not overflow, with the exact sign.
fn scaled_area(o: [f64; 2], d: [f64; 2], p: [f64; 2]) -> f64 {
    let mut area = Expansion::default();
    for (a, b) in [(p[0], d[1]), (-p[1], d[0]), (-o[0], d[1]), (o[1], d[0])] {
        area.add_product(a, b, 1.0);
    }
    area.value()
}

/// Exact sum: terms of rising magnitude that do not overlap, none of which is 0.
struct Expansion {
    terms: [f64; CAPACITY],
    len: usize,
}

impl Default for Expansion {
    fn default() -> Self {
        Self { terms: [0.0; CAPACITY], len: 0 }
    }
}

impl Expansion {
    /// Adds a number (Shewchuk 1997, figure 6).
    fn add(&mut self, number: f64) {
        let (mut sum, mut kept) = (number, 0);
        for i in 0..self.len {
            let error;
            (sum, error) = two_sum(sum, self.terms[i]);
            if error != 0.0 {
                self.terms[kept] = error;
                kept += 1;
            }
        }
        if sum != 0.0 && kept < CAPACITY {
            self.terms[kept] = sum;
            kept += 1;
        }
        self.len = kept;
    }

    /// Adds the product of three numbers.
    fn add_product(&mut self, a: f64, b: f64, c: f64) {
        if a == 0.0 || b == 0.0 || c == 0.0 {
            return;
        }
        let (high, low) = two_product(a, b);
        for part in [low, high] {
            let (product, error) = two_product(part, c);
            self.add(error);
            self.add(product);
        }
    }

    /// Rounded sum with the exact sign.
    fn value(&self) -> f64 {
        self.terms[..self.len].iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::{random::hash, transcendental::exp2};

    /// Integers of this many bits, with their sign.
    fn integer(seed: u64, index: u64, bits: u32) -> i128 {
        i128::from(hash(&[seed, index]) as i64 >> (63 - bits))
    }

    fn volume([o, d, p, q]: [[i128; 3]; 4]) -> i128 {
        let [a, b] = [p, q].map(|v| [v[0] - o[0], v[1] - o[1], v[2] - o[2]]);
        d[0] * (a[1] * b[2] - a[2] * b[1]) + d[1] * (a[2] * b[0] - a[0] * b[2]) + d[2] * (a[0] * b[1] - a[1] * b[0])
    }

    #[test]
    fn signs_of_areas_are_those_of_integers() {
        let mut n_zero = 0;
        for seed in 0..4_000 {
            let [o, d] = [0, 1].map(|k| [0, 1].map(|axis| integer(seed, 2 * k + axis, 50)));
            let factor = integer(seed, 90, 2);
            let p = [0, 1]
                .map(|axis| o[axis] + factor * d[axis] + integer(seed, 91 + axis as u64, 1) / (1 + seed as i128 % 2));
            let expected = (p[0] - o[0]) * d[1] - (p[1] - o[1]) * d[0];
            let [o, d, p] = [o, d, p].map(|v| v.map(|number| number as f64));
            let found = point_area(o, d, p);
            assert_eq!(found.partial_cmp(&0.0).map(|order| order as i128), Some(expected.signum()), "seed {seed}");
            n_zero += usize::from(expected == 0);
        }
        assert!(n_zero > 400, "{n_zero}");
    }

    /// Differences and products of integers, which `i128` checks; a third of the edges are hit exactly or almost.
    #[test]
    fn signs_are_those_of_integers() {
        let mut n_zero = 0;
        for seed in 0..6_000 {
            let vector = |k: u64, bits: u32| [0, 1, 2].map(|axis| integer(seed, 3 * k + axis, bits));
            let (o, p, d) = (vector(0, 38), vector(1, 38), vector(2, 38));
            // A point on the line through o + d and p, or next to it.
            let factor = integer(seed, 90, 2);
            let near = [0, 1, 2].map(|axis| p[axis] + factor * (o[axis] + d[axis] - p[axis]));
            let moved = [0, 1, 2].map(|axis| near[axis] + integer(seed, 91 + axis as u64, 1));
            let q = [vector(3, 38), near, moved][seed as usize % 3];
            let expected = volume([o, d, p, q]);
            let float = |v: [i128; 3]| DVec3::from_array(v.map(|number| number as f64));
            for scale in [1.0, exp2(-600.0), exp2(500.0)] {
                let edge = [float(p) * scale, float(q) * scale];
                let [found, turned, _] =
                    edge_volumes(float(o) * scale, float(d) * scale, [edge, [edge[1], edge[0]], edge]);
                assert_eq!(found.partial_cmp(&0.0).map(|order| order as i128), Some(expected.signum()), "seed {seed}");
                assert_eq!(turned, -found);
                if scale == 1.0 {
                    let rounded = expected as f64;
                    assert!((found - rounded).abs() <= 1e-15 * rounded.abs(), "seed {seed}: {found}, {expected}");
                }
            }
            n_zero += usize::from(expected == 0);
        }
        assert!(n_zero > 1000, "{n_zero}");
    }
}
