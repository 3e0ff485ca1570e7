//! Conditioning of transforms.

use rt_math::DMat3;

use crate::objects::{Geometry, Object, Objects};
use crate::report::{Finding, Findings, Kind};

/// Condition number above which a warning is reported: a ray in local space keeps fewer than ten digits.
const NEAR_SINGULAR: f64 = 1e6;

/// Largest condition number of a map that counts as a similarity.
const ROUND: f64 = 1.001;

/// Condition number in the 2-norm, σ₁ / σ₃: the maximum growth of relative errors in local space. Infinite for a singular
/// matrix.
pub(crate) fn condition(linear: &DMat3) -> f64 {
    let [largest, _, smallest] = singular_values(linear);
    largest / smallest
}

/// Singular values, the largest first, to high relative accuracy. One-sided Jacobi rotations make the columns orthogonal;
/// their lengths are the singular values (Hestenes 1958; Demmel, Veselić 1992).
pub(crate) fn singular_values(linear: &DMat3) -> [f64; 3] {
    /// Maximum number of sweeps, far more than three columns need.
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
    lengths.sort_by(|a, b| b.total_cmp(a));
    lengths
}

pub(crate) fn check(objects: &Objects<'_>, findings: &mut Findings) {
    for object in &objects.list {
        check_object(objects, object, findings);
    }
}

fn check_object(objects: &Objects<'_>, object: &Object<'_>, findings: &mut Findings) {
    let linear = object.world_from_local.linear();
    let condition = condition(&linear);
    let worst = condition.max(object.chain_condition);
    if worst > NEAR_SINGULAR {
        findings.add(Finding::new(
            Kind::IllConditioned,
            objects.name(object),
            &[("condition", condition), ("chain_condition", object.chain_condition)],
            format!(
                "the transform has condition number {condition:.3e} (product over the nodes above: {:.3e}), so that \
                 positions lose up to {:.0} of 16 digits",
                object.chain_condition,
                rt_math::transcendental::log2(worst) * std::f64::consts::LOG10_2
            ),
        ));
    }
    if object.world_from_local.flips_handedness() {
        findings.add(Finding::new(
            Kind::Mirrored,
            objects.name(object),
            &[("determinant", linear.determinant())],
            format!("the transform mirrors (determinant {:.6})", linear.determinant()),
        ));
    }
    let has_normals = matches!(object.geometry, Geometry::Mesh(_, mesh) if !mesh.data().normals.is_empty());
    if has_normals && condition > ROUND {
        findings.add(Finding::new(
            Kind::StretchedNormals,
            objects.name(object),
            &[("condition", condition)],
            format!("smooth normals under a transform that stretches by {condition:.6}"),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
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

    #[test]
    fn a_product_that_undoes_itself_is_still_a_loss() {
        let mut scene = empty();
        let mut inner = sphere(DVec3::ZERO, 1.0);
        inner.parent_from_local = Transform::scale(DVec3::new(1e7, 1.0, 1.0)).unwrap();
        let mut outer = sphere(DVec3::X * 3.0, 1.0);
        outer.content = None;
        outer.parent_from_local = inner.parent_from_local.inverse();
        outer.children = vec![inner];
        scene.nodes = vec![outer];
        let finding = only(&scene, Kind::IllConditioned);
        assert_eq!(finding.severity, Severity::Warning);
        assert_eq!(finding.object, "nodes[0].children[0]");
        assert!((finding.values[0].value - 1.0).abs() < 1e-9, "{finding:?}");
        assert!((finding.values[1].value - 1e14).abs() < 1e5, "{finding:?}");
    }

    #[test]
    fn mirrors_and_stretched_normals_are_noted() {
        let mut scene = empty();
        let mut node = sphere(DVec3::ZERO, 1.0);
        node.parent_from_local = Transform::scale(DVec3::new(-2.0, 2.0, 2.0)).unwrap();
        scene.nodes = vec![node];
        assert_eq!(only(&scene, Kind::Mirrored).values, [value("determinant", -8.0)]);

        let mut data = cube_data();
        data.smooth_normals();
        let mut node = add_mesh(&mut scene, data);
        node.parent_from_local = Transform::scale(DVec3::new(1.0, 4.0, 1.0)).unwrap();
        scene.nodes = vec![node];
        let finding = only(&scene, Kind::StretchedNormals);
        assert_eq!(finding.values, [value("condition", 4.0)]);
        assert_eq!(finding.severity, Severity::Info);
    }
}
