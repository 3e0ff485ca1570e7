//! Singular values of linear maps.

use rt_math::DMat3;

/// Condition number in the 2-norm, σ₁ / σ₃: the possible growth of relative errors on the way to local space. Infinite
/// for a singular matrix.
pub(crate) fn condition(linear: &DMat3) -> f64 {
    let [largest, _, smallest] = singular_values(linear);
    largest / smallest
}

/// Singular values, the largest first, to high relative accuracy. One-sided Jacobi rotations make the columns orthogonal;
/// their lengths are the singular values (Hestenes 1958; Demmel, Veselić 1992).
pub(crate) fn singular_values(linear: &DMat3) -> [f64; 3] {
    /// Far more sweeps than three columns need.
    const MAX_SWEEPS: usize = 40;
    const ORTHOGONAL: f64 = 1e-15;

    let scale = linear.to_cols_array().into_iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    let mut columns = [linear.x_axis / scale, linear.y_axis / scale, linear.z_axis / scale];
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (columns[p], columns[q]);
            let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
            if ab.abs() <= ORTHOGONAL * (aa * bb).sqrt() {
                continue;
            }
            rotated = true;
            let cotangent = (bb - aa) / (2.0 * ab);
            let tangent = 1f64.copysign(cotangent) / (cotangent.abs() + (1.0 + cotangent * cotangent).sqrt());
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            let sine = cosine * tangent;
            (columns[p], columns[q]) = (a * cosine - b * sine, a * sine + b * cosine);
        }
        if !rotated {
            break;
        }
    }
    let mut lengths = columns.map(|column| column.length() * scale);
    for (before, after) in [(0, 1), (1, 2), (0, 1)] {
        if lengths[before].total_cmp(&lengths[after]).is_lt() {
            lengths.swap(before, after);
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::{DVec3, Transform};

    #[test]
    fn singular_values_of_known_matrices() {
        let turn = Transform::rotate(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap().linear();
        let other = Transform::rotate(DVec3::new(-3.0, 1.0, 0.5), 2.1).unwrap().linear();
        let stretched = turn * DMat3::from_diagonal(DVec3::new(1e-3, -2e5, 7.0)) * other;
        let values = singular_values(&stretched);
        for (computed, expected) in values.into_iter().zip([2e5, 7.0, 1e-3]) {
            assert!((computed - expected).abs() < 1e-6 * expected, "{computed} {expected}");
        }
        assert_eq!(singular_values(&DMat3::IDENTITY), [1.0; 3]);
        // A shear by 2: σ² are the roots of x² − 6x + 1, so that their ratio is (3 + √8)².
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(2.0, 1.0, 0.0), DVec3::Z);
        assert!((condition(&shear) - (3.0 + 8f64.sqrt())).abs() < 1e-12);
        let flat = DMat3::from_cols(DVec3::X, DVec3::X, DVec3::Z);
        assert!(condition(&flat) > 1e15);
    }
}
