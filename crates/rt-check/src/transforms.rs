//! Conditioning of transforms.

use crate::finding::{Finding, Findings, Kind};
use crate::objects::{Geometry, Object, Objects};
use crate::singular_values::condition;

/// Condition number above which a warning is reported: a ray in local space keeps fewer than ten digits.
const NEAR_SINGULAR: f64 = 1e6;

/// Largest condition number of a map that counts as a similarity.
const ROUND: f64 = 1.001;

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
    if object.world_from_local.flips_handedness() != object.is_left_handed {
        // Relative to the world of a left-handed file.
        let determinant = -linear.determinant().abs();
        findings.add(Finding::new(
            Kind::Mirrored,
            objects.name(object),
            &[("determinant", determinant)],
            format!("the transform is a reflection (determinant {determinant:.6})"),
        ));
    }
    let has_normals = matches!(object.geometry, Geometry::Mesh(_, mesh) if !mesh.data().normals.is_empty());
    if has_normals && condition > ROUND {
        findings.add(Finding::new(
            Kind::StretchedNormals,
            objects.name(object),
            &[("condition", condition)],
            format!("vertex normals under a non-uniform scale, of ratio {condition:.6}"),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_math::{DVec3, Transform};
    use rt_scene_io::SceneNode;

    #[test]
    fn a_product_that_undoes_itself_is_still_a_loss() {
        let mut inner = sphere(DVec3::ZERO, 1.0);
        inner.parent_from_local = Transform::scale(DVec3::new(1e7, 1.0, 1.0)).unwrap();
        let mut outer = sphere(DVec3::X * 3.0, 1.0);
        outer.content = None;
        outer.parent_from_local = inner.parent_from_local.inverse();
        outer.children = vec![inner];
        let finding = only(&scene_with(vec![outer]), Kind::IllConditioned);
        assert_eq!(finding.severity, Severity::Warning);
        assert_eq!(finding.object, "nodes[0].children[0]");
        assert!((finding.values[0].value - 1.0).abs() < 1e-9, "{finding:?}");
        assert!((finding.values[1].value - 1e14).abs() < 1e5, "{finding:?}");
    }

    /// The reflection of the whole world of a pbrt file was noted for each of its objects.
    #[test]
    fn the_reflection_of_a_left_handed_file_is_no_mirror_image() {
        let reflected = |x, children| {
            let reflection = Transform::scale(DVec3::new(x, 1.0, 1.0)).expect("a reflection");
            SceneNode { children, ..SceneNode::empty(String::new(), reflection) }
        };
        let in_file = vec![sphere(DVec3::ZERO, 1.0), reflected(-2.0, vec![sphere(DVec3::X * 4.0, 1.0)])];
        let file = SceneNode { is_left_handed: true, ..reflected(-1.0, in_file) };
        // An object that the file itself reflects is one.
        let finding = only(&scene_with(vec![file.clone()]), Kind::Mirrored);
        assert_eq!(finding.object, "nodes[0].children[1].children[0]");
        assert_eq!(finding.values, [value("determinant", -2.0)]);
        // A scene that reflects the file makes a mirror image of the rest.
        let scene = scene_with(vec![reflected(-1.0, vec![file])]);
        assert_eq!(only(&scene, Kind::Mirrored).object, "nodes[0].children[0].children[0]");
    }

    #[test]
    fn mirrors_and_stretched_normals_are_noted() {
        let mut node = sphere(DVec3::ZERO, 1.0);
        node.parent_from_local = Transform::scale(DVec3::new(-2.0, 2.0, 2.0)).unwrap();
        assert_eq!(only(&scene_with(vec![node]), Kind::Mirrored).values, [value("determinant", -8.0)]);

        let mut data = cube_data();
        data.smooth_normals();
        let mut scene = scene_of_mesh(data);
        scene.nodes[0].parent_from_local = Transform::scale(DVec3::new(1.0, 4.0, 1.0)).unwrap();
        let finding = only(&scene, Kind::StretchedNormals);
        assert_eq!(finding.values, [value("condition", 4.0)]);
        assert_eq!(finding.severity, Severity::Note);
    }
}
