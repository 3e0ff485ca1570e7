//! Rules for the accessors of primitives (glTF 2.0, section 3.7.2.1).

use gltf::json::{
    Index, Root,
    accessor::{Accessor, ComponentType, Type},
    mesh::{Mesh, Primitive, Semantic},
    validation::Checked,
};

use super::draco;
use crate::{LoadErrorKind, Warning};

/// Checks all primitives of a document with valid references. Each error has its location.
pub(super) fn check(root: &Root, warnings: &mut Vec<Warning>) -> Vec<(String, LoadErrorKind)> {
    let mut problems = Vec::new();
    for (m, mesh) in root.meshes.iter().enumerate() {
        let counts = target_counts(mesh);
        let weights = mesh.weights.as_ref().map(Vec::len);
        if counts.iter().chain(&weights).any(|count| Some(count) != counts.first()) {
            let message = unpaired_targets(&counts, weights.unwrap_or(0));
            warnings.push(Warning { place: format!("meshes[{m}]"), message });
        }
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("meshes[{m}].primitives[{p}]");
            let mut check = Check { root, primitive, place: &place, problems: &mut problems };
            check.attributes();
            check.indices();
            check.targets();
            if let Some(message) = unpaired_joints(primitive) {
                warnings.push(Warning { place, message });
            }
        }
    }
    for (n, node) in root.nodes.iter().enumerate() {
        let message = node.weights.as_ref().and_then(|weights| unpaired_weights(root, n, weights.len()));
        warnings.extend(message.map(|message| Warning { place: format!("nodes[{n}]"), message }));
    }
    problems
}

/// Message about weights of a node, at rest or in an animation, that are not as many as the morph targets of its mesh.
pub(super) fn unpaired_weights(root: &Root, node: usize, weights: usize) -> Option<String> {
    let mesh = root.nodes.get(node)?.mesh.as_ref()?;
    let counts = target_counts(root.meshes.get(mesh.value())?);
    counts.iter().any(|count| *count != weights).then(|| unpaired_targets(&counts, weights))
}

fn unpaired_targets(counts: &[usize], weights: usize) -> String {
    format!("has {counts:?} morph targets and {weights} weights; what has no partner is left out")
}

/// Number of morph targets of each primitive.
fn target_counts(mesh: &Mesh) -> Vec<usize> {
    mesh.primitives.iter().map(|primitive| primitive.targets.as_ref().map_or(0, Vec::len)).collect()
}

struct Check<'a> {
    root: &'a Root,
    primitive: &'a Primitive,
    place: &'a str,
    problems: &'a mut Vec<(String, LoadErrorKind)>,
}

impl Check<'_> {
    fn report(&mut self, path: &str, reason: LoadErrorKind) {
        self.problems.push((format!("{}.{path}", self.place), reason));
    }

    /// The number of vertices; `None` if there are no positions, which is refused elsewhere.
    fn count(&self) -> Option<u64> {
        let positions = self.primitive.attributes.get(&Checked::Valid(Semantic::Positions))?;
        Some(accessor(self.root, positions)?.count.0)
    }

    fn attributes(&mut self) {
        let primitive = self.primitive;
        for (semantic, index) in &primitive.attributes {
            let (Checked::Valid(semantic), Some(accessor)) = (semantic, accessor(self.root, index)) else { continue };
            let path = format!("attributes.{}", semantic.to_string());
            if let Some(rule) = broken_rule(semantic, accessor) {
                self.report(&path, LoadErrorKind::Syntax(format!("accessors[{}] {rule}", index.value())));
            }
            self.check_count(&path, accessor);
        }
    }

    /// The stream of a compressed primitive has counts of its own.
    fn check_count(&mut self, path: &str, accessor: &Accessor) {
        let compressed = self.primitive.extensions.as_ref().is_some_and(|all| all.others.contains_key(draco::NAME));
        let Some(count) = self.count().filter(|count| *count != accessor.count.0 && !compressed) else { return };
        self.report(path, LoadErrorKind::invalid(accessor.count.0, format!("elements do not fit {count} positions")));
    }

    fn indices(&mut self) {
        let Some(accessor) = self.primitive.indices.as_ref().and_then(|index| accessor(self.root, index)) else {
            return;
        };
        let unsigned = [ComponentType::U8, ComponentType::U16, ComponentType::U32];
        let is_fine = is_one_of(accessor, &[Type::Scalar]) && has_component(accessor, &unsigned);
        if !is_fine {
            self.report(
                "indices",
                LoadErrorKind::Syntax("the accessor of indices must hold unsigned scalars".to_owned()),
            );
        }
    }

    fn targets(&mut self) {
        let primitive = self.primitive;
        for (t, target) in primitive.targets.iter().flatten().enumerate() {
            let deltas = [("POSITION", &target.positions), ("NORMAL", &target.normals), ("TANGENT", &target.tangents)];
            for (name, index) in deltas {
                let Some(accessor) = index.as_ref().and_then(|index| accessor(self.root, index)) else { continue };
                let path = format!("targets[{t}].{name}");
                if !is_one_of(accessor, &[Type::Vec3]) {
                    self.report(
                        &path,
                        LoadErrorKind::Syntax("the differences of a morph target must be VEC3".to_owned()),
                    );
                }
                self.check_count(&path, accessor);
            }
        }
    }
}

/// The rule for an attribute that its accessor breaks.
fn broken_rule(semantic: &Semantic, accessor: &Accessor) -> Option<&'static str> {
    let whole = [ComponentType::U8, ComponentType::U16];
    match semantic {
        Semantic::Positions | Semantic::Normals => (!is_one_of(accessor, &[Type::Vec3])).then_some("must be VEC3"),
        Semantic::Tangents | Semantic::Weights(_) => (!is_one_of(accessor, &[Type::Vec4])).then_some("must be VEC4"),
        Semantic::TexCoords(_) => (!is_one_of(accessor, &[Type::Vec2])).then_some("must be VEC2"),
        Semantic::Colors(_) => (!is_one_of(accessor, &[Type::Vec3, Type::Vec4])).then_some("must be VEC3 or VEC4"),
        Semantic::Joints(_) => (!(is_one_of(accessor, &[Type::Vec4]) && has_component(accessor, &whole)))
            .then_some("must be VEC4 of unsigned bytes or shorts"),
        Semantic::Extras(_) => None,
    }
}

/// Message about unequal numbers of joint and weight sets.
fn unpaired_joints(primitive: &Primitive) -> Option<String> {
    let sets = |is: fn(&Semantic) -> bool| {
        primitive.attributes.keys().filter(|semantic| matches!(semantic, Checked::Valid(s) if is(s))).count()
    };
    let joints = sets(|semantic| matches!(semantic, Semantic::Joints(_)));
    let weights = sets(|semantic| matches!(semantic, Semantic::Weights(_)));
    (joints != weights)
        .then(|| format!("has {joints} sets of joints and {weights} of weights; those without a partner are left out"))
}

fn is_one_of(accessor: &Accessor, kinds: &[Type]) -> bool {
    matches!(accessor.type_, Checked::Valid(kind) if kinds.contains(&kind))
}

fn has_component(accessor: &Accessor, kinds: &[ComponentType]) -> bool {
    matches!(accessor.component_type, Checked::Valid(kind) if kinds.contains(&kind.0))
}

fn accessor<'a>(root: &'a Root, index: &Index<Accessor>) -> Option<&'a Accessor> {
    root.accessors.get(index.value())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The problems and warnings of a mesh over these accessors.
    fn checked(accessors: &[&str], mesh: &str) -> (Vec<String>, Vec<Warning>) {
        let accessors: Vec<String> = accessors.iter().map(|fields| format!("{{{fields}}}")).collect();
        let json =
            format!(r#"{{"asset": {{"version": "2.0"}}, "accessors": [{}], "meshes": [{mesh}]}}"#, accessors.join(","));
        let root = Root::from_str(&json).expect("good JSON");
        let mut warnings = Vec::new();
        let problems = check(&root, &mut warnings).into_iter().map(|(place, reason)| format!("{place}: {reason}"));
        (problems.collect(), warnings)
    }

    const POSITIONS: &str = r#""componentType": 5126, "count": 3, "type": "VEC3""#;
    const COLOURS: &str = r#""componentType": 5121, "count": 3, "type": "VEC4", "normalized": true"#;

    fn primitive(fields: &str) -> String {
        format!(r#"{{"primitives": [{{"attributes": {{"POSITION": 0, {fields}}}]}}"#)
    }

    #[test]
    fn attributes_that_fit_are_fine() {
        let mesh = primitive(
            r#""NORMAL": 0, "COLOR_0": 1, "JOINTS_0": 2, "WEIGHTS_0": 1, "_OWN": 3}, "indices": 3, "targets": [{"NORMAL": 0}]"#,
        );
        let mesh = mesh.replace("]}]}", "]}], \"weights\": [0]}");
        let joints = r#""componentType": 5123, "count": 3, "type": "VEC4""#;
        let indices = r#""componentType": 5125, "count": 3, "type": "SCALAR""#;
        let found = checked(&[POSITIONS, COLOURS, joints, indices], &mesh);
        assert_eq!(found, (Vec::new(), Vec::new()));
    }

    #[test]
    fn each_broken_rule_is_named() {
        let (floats, two) = (COLOURS.replace("5121", "5126"), COLOURS.replace("\"count\": 3", "\"count\": 2"));
        for (accessor, fields, problem) in [
            (COLOURS, r#""NORMAL": 1}"#, "attributes.NORMAL: accessors[1] must be VEC3"),
            (COLOURS, r#""TEXCOORD_1": 1}"#, "attributes.TEXCOORD_1: accessors[1] must be VEC2"),
            (
                &floats,
                r#""JOINTS_0": 1}"#,
                "attributes.JOINTS_0: accessors[1] must be VEC4 of unsigned bytes or shorts",
            ),
            (&two, r#""COLOR_0": 1}"#, "attributes.COLOR_0: 2 elements do not fit 3 positions"),
            (COLOURS, r#""_X": 1}, "indices": 1"#, "indices: the accessor of indices must hold unsigned scalars"),
            (
                COLOURS,
                r#""_X": 1}, "targets": [{"TANGENT": 1}]"#,
                "targets[0].TANGENT: the differences of a morph target must be VEC3",
            ),
        ] {
            let (problems, _) = checked(&[POSITIONS, accessor], &primitive(fields));
            assert_eq!(problems, [format!("meshes[0].primitives[0].{problem}")]);
        }
    }

    #[test]
    fn what_has_no_partner_is_a_warning() {
        let joints = r#""componentType": 5121, "count": 3, "type": "VEC4""#;
        let (problems, warnings) = checked(&[POSITIONS, joints], &primitive(r#""JOINTS_0": 1}"#));
        assert!(
            problems.is_empty() && warnings[0].message.contains("1 sets of joints and 0 of weights"),
            "{warnings:?}"
        );
        let mesh = primitive(r#""_X": 0}, "targets": [{"POSITION": 0}]"#).replace("]}]}", "]}], \"weights\": [0, 1]}");
        let (problems, warnings) = checked(&[POSITIONS], &mesh);
        assert!(problems.is_empty() && warnings[0].message.contains("[1] morph targets and 2 weights"), "{warnings:?}");
    }

    /// Only the weights of meshes caused the warning.
    #[test]
    fn weights_of_nodes_without_targets_are_a_warning() {
        let checked = |weights: &str| {
            let mesh = primitive(r#""_X": 0}, "targets": [{"POSITION": 0}, {"POSITION": 0}]"#);
            let (problems, warnings) =
                checked(&[POSITIONS], &format!(r#"{mesh}], "nodes": [{{"mesh": 0, "weights": [{weights}]}}"#));
            assert!(problems.is_empty(), "{problems:?}");
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let expected = "nodes[0]: has [2] morph targets and 4 weights; what has no partner is left out";
        assert_eq!((checked("1, 0, 0, 1"), checked("0, 1")), (vec![expected.to_owned()], Vec::new()));
    }
}
