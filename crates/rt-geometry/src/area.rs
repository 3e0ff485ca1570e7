//! Area vectors of triangles and polygons, zero exactly for those without area.

use rt_math::float::{two_product, two_sum};
use rt_math::{DVec3, Real, Vector3};

/// Sine of the smallest angle below which a triangle counts as a sliver. A plain cross product would keep fewer than
/// twelve digits of its normal.
const SLIVER: f64 = 1e-3;

/// Twice the area times the unit normal, on the side from which the vertices run counter-clockwise. Zero if and only
/// if the vertices are exactly collinear (while nothing over- or underflows).
///
/// Multiplies the two shorter edges; slivers are computed without rounding.
#[inline]
pub(crate) fn area_vector(vertices: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = vertices;
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let (ab_squared, bc_squared, ca_squared) = (ab.length_squared(), bc.length_squared(), ca.length_squared());
    let (e, f) = if ab_squared >= bc_squared && ab_squared >= ca_squared {
        (bc, ca)
    } else if bc_squared >= ca_squared {
        (ca, ab)
    } else {
        (ab, bc)
    };
    let area = e.cross(f);
    let sliver = SLIVER * SLIVER * e.length_squared() * f.length_squared();
    if area.length_squared() > sliver { area } else { exact_area_vector(vertices) }
}

/// Upper bound of the relative error of [`area_vector`].
const AREA_ERROR: f64 = 1e-12;

/// Newell's normal: twice the area enclosed by a polygon times its unit normal, on the side from which it runs
/// counter-clockwise. Defined for concave and bent polygons as well (Tampieri, Graphics Gems III, 1992). `None` if
/// rounding could make it zero.
///
/// Sums over the fan of triangles from the first corner, each of which is computed without cancellation.
pub(crate) fn polygon_area_vector(vertices: &[DVec3]) -> Option<DVec3> {
    let (hub, rim) = vertices.split_first()?;
    let (mut sum, mut magnitude) = (DVec3::ZERO, 0.0);
    for pair in rim.windows(2) {
        let area = area_vector([*hub, pair[0], pair[1]]);
        sum += area;
        magnitude += area.abs().max_element();
    }
    (sum.abs().max_element() > AREA_ERROR * magnitude).then_some(sum)
}

/// The unit normal of a triangle, on the side from which the vertices run counter-clockwise; any unit vector for one without area.
#[inline]
pub fn unit_normal(vertices: [DVec3; 3]) -> DVec3 {
    let area = area_vector(vertices);
    // Scaled first: the square of a small area underflows.
    (area / area.abs().max_element()).try_normalize().unwrap_or(DVec3::Z)
}

/// Version of [`unit_normal`] for lanes. The mask is false for slivers, whose normals are not valid.
#[inline(always)]
pub fn unit_normal_lanes<R: Real>([a, b, c]: [Vector3<R>; 3]) -> (Vector3<R>, R::Mask) {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let (ab_squared, bc_squared, ca_squared) = (ab.length_squared(), bc.length_squared(), ca.length_squared());
    let is_ab = ab_squared.ge(bc_squared) & ab_squared.ge(ca_squared);
    let is_bc = bc_squared.ge(ca_squared);
    let e = Vector3::select(is_ab, bc, Vector3::select(is_bc, ca, ab));
    let f = Vector3::select(is_ab, ca, Vector3::select(is_bc, ab, bc));
    let area = e.cross(f);
    let sliver = area.x.splat(SLIVER * SLIVER) * e.length_squared() * f.length_squared();
    let (normal, has_length) = (area / area.x.abs().max(area.y.abs()).max(area.z.abs())).try_normalize();
    (normal, area.length_squared().gt(sliver) & has_length)
}

/// a×b + b×c + c×a, each component summed without rounding and rounded once.
#[cold]
fn exact_area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    let component = |i: usize, j: usize| {
        let pairs = [(a, b), (b, c), (c, a)];
        let terms = pairs.map(|(p, q)| [two_product(p[i], q[j]), two_product(-p[j], q[i])]);
        exact_sum(terms.as_flattened().iter().flat_map(|&(product, error)| [product, error]))
    };
    DVec3::new(component(1, 2), component(2, 0), component(0, 1))
}

/// Sum of up to twelve numbers with the exact sign, as a list of non-overlapping parts (Shewchuk, "Adaptive Precision
/// Floating-Point Arithmetic", 1997, Grow-Expansion).
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn exact(vertices: [[i64; 3]; 3]) -> [i128; 3] {
        let [a, b, c] = vertices.map(|v| v.map(i128::from));
        let (e, f) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]
    }

    proptest! {
        /// Slivers along a line, moved off it by a few units in the last place. 46-bit integers keep `i128` exact.
        #[test]
        fn nearly_collinear_vertices_are_distinguished(
            start in prop::array::uniform3(-(1i64 << 44)..1i64 << 44), step in prop::array::uniform3(-(1i64 << 20)..1i64 << 20),
            j in 1i64..1 << 20, k in 1i64..1 << 20, nudge in prop::array::uniform3(-1i64..2),
        ) {
            let vertices = [0, j, k].map(|n| [0, 1, 2].map(|i| start[i] + n * step[i]));
            let vertices = [vertices[0], vertices[1], [0, 1, 2].map(|i| vertices[2][i] + nudge[i])];
            let expected = DVec3::from(exact(vertices).map(|x| x as f64));
            let computed = area_vector(vertices.map(|v| DVec3::from(v.map(|x| x as f64))));
            prop_assert!((computed - expected).length() <= 1e-12 * expected.length(), "{computed} {expected}");
            prop_assert_eq!(computed == DVec3::ZERO, expected == DVec3::ZERO);
        }
    }

    #[test]
    fn an_area_that_the_edges_round_away_is_found() {
        // b − a and c − a lose the 1 of a. Exactly: (2⁶⁰ − 1)·2⁶¹ − 2⁶⁰·(2⁶¹ − 1) = −2⁶⁰.
        let big = (1u64 << 60) as f64;
        let vertices = [DVec3::X, DVec3::new(big, big, 0.0), DVec3::new(2.0 * big, 2.0 * big, 0.0)];
        assert_eq!(area_vector(vertices), DVec3::new(0.0, 0.0, -big));
        assert_eq!(unit_normal(vertices), DVec3::NEG_Z);
    }

    #[test]
    fn lanes_give_the_same_normals_and_leave_out_slivers() {
        let corner = |key: u64| {
            let number = |axis: u64| rt_math::random::unit(rt_math::random::hash(&[key, axis])) - 0.5;
            DVec3::new(number(0), number(1), number(2))
        };
        let mut slivers = 0;
        for key in 0..1000 {
            let [a, b] = [corner(3 * key), corner(3 * key + 1)];
            let c = if key % 4 == 0 { a + (b - a) * 0.3 + corner(3 * key + 2) * 1e-6 } else { corner(3 * key + 2) };
            let (normal, is_valid) = unit_normal_lanes([a.into(), b.into(), c.into()]);
            slivers += u32::from(!is_valid);
            assert!(!is_valid || DVec3::from(normal) == unit_normal([a, b, c]), "{a} {b} {c}");
        }
        assert_eq!(slivers, 250);
    }

    /// The grid of Kettner et al., "Classroom Examples of Robustness Problems in Geometric Computations", 2008. In
    /// units of 2⁻⁵³ all coordinates are integers.
    #[test]
    fn no_orientation_on_the_kettner_grid_is_wrong() {
        let half = 1i64 << 52;
        let unit = 1.0 / (1i64 << 53) as f64;
        let mut wrong_if_rounded = 0;
        for i in 0..256 {
            for j in 0..256 {
                let integers = [[half + i, half + j, 0], [24 * half, 24 * half, 0], [48 * half, 48 * half, 0]];
                let expected = exact(integers)[2].signum() as f64;
                let [a, b, c] = integers.map(|v| DVec3::from(v.map(|x| x as f64 * unit)));
                let sign = area_vector([a, b, c]).z;
                assert_eq!(if sign == 0.0 { 0.0 } else { sign.signum() }, expected, "{i} {j}");
                let rounded = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
                wrong_if_rounded += u32::from(rounded.partial_cmp(&0.0) != expected.partial_cmp(&0.0));
            }
        }
        assert_eq!(wrong_if_rounded, 11_972, "the grid is hard");
    }

    #[test]
    fn tiny_triangles_have_a_normal() {
        let vertices = [DVec3::ZERO, DVec3::X * 1e-60, DVec3::Y * 1e-60];
        assert_eq!(unit_normal(vertices), DVec3::Z);
        let tiny = [DVec3::ZERO, DVec3::X * 1e-100, DVec3::Y * 1e-100];
        assert_eq!(unit_normal(tiny), DVec3::Z);
    }
}
