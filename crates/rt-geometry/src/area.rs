//! The area vector of a triangle, zero exactly when the triangle has no area.

use rt_math::DVec3;
use rt_math::float::{cross, gamma, two_product};

/// Twice the area times the unit normal, on the side from which the vertices run counter-clockwise. Zero if and only
/// if the vertices are exactly collinear (while nothing over- or underflows).
///
/// The cross product of the two shorter edges answers where its error bound settles the direction; slivers are
/// recomputed without rounding.
pub(crate) fn area_vector(vertices: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = vertices;
    let edges = [b - a, c - b, a - c];
    let squares = edges.map(|e| e.length_squared());
    let longest = if squares[0] >= squares[1] && squares[0] >= squares[2] {
        0
    } else if squares[1] >= squares[2] {
        1
    } else {
        2
    };
    let (e, f) = (edges[(longest + 1) % 3], edges[(longest + 2) % 3]);
    let area = cross(e, f);
    // Every edge component is off by one rounding, every component of the product by at most this.
    let bound = gamma(6) * 2.0 * e.abs().max_element() * f.abs().max_element();
    if area.abs().max_element() > bound { area } else { exact_area_vector(vertices) }
}

/// The unit normal of a triangle; any unit vector for one without area.
pub(crate) fn unit_normal(vertices: [DVec3; 3]) -> DVec3 {
    let area = area_vector(vertices);
    // Scaled first: the square of a small area underflows.
    (area / area.abs().max_element()).try_normalize().unwrap_or(DVec3::Z)
}

/// a×b + b×c + c×a, each component summed without rounding and rounded once.
fn exact_area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    let component = |i: usize, j: usize| {
        let pairs = [(a, b), (b, c), (c, a)];
        let terms = pairs.map(|(p, q)| [two_product(p[i], q[j]), two_product(-p[j], q[i])]);
        exact_sum(terms.as_flattened().iter().flat_map(|&(product, error)| [product, error]))
    };
    DVec3::new(component(1, 2), component(2, 0), component(0, 1))
}

/// The sum of up to twelve numbers with the exact sign: they are held as a list of non-overlapping parts
/// (Shewchuk, "Adaptive Precision Floating-Point Arithmetic", 1997, Grow-Expansion).
fn exact_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let mut parts = [0.0; 12];
    for (count, term) in terms.enumerate().take(12) {
        let mut carry = term;
        for part in &mut parts[..count] {
            (carry, *part) = two_sum(carry, *part);
        }
        parts[count] = carry;
    }
    parts.iter().sum()
}

/// The rounded sum and its exact error (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}
