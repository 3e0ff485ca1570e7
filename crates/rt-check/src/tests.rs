use super::*;
use crate::fixture::*;
use rt_math::DVec3;

#[test]
fn warnings_of_the_loader_are_reported() {
    let mut scene = empty();
    let message = "triangles without area were dropped: 3 of 12";
    scene.warnings = vec![rt_scene_io::Warning { place: "cube.obj:7".into(), message: message.into() }];
    let finding = only(&scene, Kind::LoadWarning);
    assert_eq!((finding.object.as_str(), finding.message.as_str()), ("cube.obj:7", message));
}

#[test]
fn a_scene_that_cannot_be_rendered_says_why() {
    let mut node = sphere(DVec3::ZERO, 1.0);
    node.material = rt_scene_io::MaterialId(99);
    let scene = scene_with(vec![node]);
    let finding = only(&scene, Kind::CannotRender);
    assert!(finding.message.contains("material index 99"), "{finding:?}");
}

#[test]
fn a_mesh_without_a_name_is_numbered() {
    let mut data = cube_data();
    data.triangles.pop();
    let mut scene = scene_of_mesh(data);
    scene.meshes[0].name.clear();
    assert_eq!(only(&scene, Kind::OpenEdges).object, "mesh number 0");
}

#[test]
fn codes_are_kebab_case_and_unique() {
    let codes: std::collections::BTreeSet<_> = Kind::ALL.iter().map(|kind| kind.code()).collect();
    assert_eq!(codes.len(), Kind::ALL.len());
    for code in codes {
        assert!(code.bytes().all(|b| b.is_ascii_lowercase() || b == b'-') && !code.starts_with('-'), "{code}");
    }
}

#[test]
fn many_findings_of_one_kind_are_counted() {
    let mut scene = empty();
    scene.nodes = (0..140).map(|i| sphere(DVec3::X * f64::from(3 * i), 1.0)).collect();
    for node in &mut scene.nodes {
        node.parent_from_local = rt_math::Transform::scale(DVec3::new(1.0, -1.0, 1.0)).unwrap();
    }
    let report = check(&scene);
    let more = More { severity: Severity::Note, kind: Kind::Mirrored, count: 132 };
    assert_eq!(report.more, [more]);
    assert_eq!(report.count(Severity::Note), 140 + 2, "and two unused materials");
    let text = report.to_string();
    assert!(text.contains("note[mirrored] and 132 more\n"), "{text}");
    assert!(text.ends_with("0 errors, 0 warnings, 142 notes\n"), "{text}");
}
