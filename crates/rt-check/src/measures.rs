//! Measures of a scene as a whole: size, detail and distance from the origin.

use std::fmt;

use rt_math::Aabb;

use crate::camera::CameraMeasures;
use crate::finding::{Finding, Findings, Kind};
use crate::number::short_number;
use crate::objects::{Geometry, Objects};
use crate::singular_values::{condition, singular_values};
use crate::welded::corners;

/// Ratio of largest to smallest length above which an info is reported: it exceeds the precision of `f32`.
const WIDE_RANGE: f64 = 1e7;

/// Ratio of largest to smallest length above which a warning is reported: positions keep fewer than four digits of the
/// smallest.
const EXTREME_RANGE: f64 = 1e12;

/// Ratio of distance from the origin to extent above which an info is reported.
const FAR: f64 = 1e6;

/// Ratio of distance from the origin to extent above which a warning is reported: positions keep fewer than six digits.
const VERY_FAR: f64 = 1e10;

/// Ratio of the spacing of `f32` numbers to the extent of a mesh above which a warning is reported.
const COARSE: f64 = 1e-4;

/// Size, detail and precision of a scene. Lengths are in world units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Shapes and meshes; those of a group once per instance.
    pub objects: u64,
    /// Infinite objects, which are left out of all lengths.
    pub infinite_objects: u64,
    /// Triangles of meshes, once per instance.
    pub triangles: u64,
    /// Box around all finite objects, if there are any.
    pub bounds: Option<Aabb>,
    /// Longest side of the box; 0 without one.
    pub extent: f64,
    /// Diameter of the smallest shape, or the shortest edge of a mesh if that is shorter; 0 without any.
    pub smallest: f64,
    /// Ratio of extent to smallest; 0 without objects.
    pub dynamic_range: f64,
    /// Ratio of the distance of the centre of the box from the origin to the extent; 0 without a box.
    pub origin_distance: f64,
    /// Worst condition number of the transform of an object, at least 1.
    pub condition: f64,
    /// View and precision of each camera.
    pub cameras: Vec<CameraMeasures>,
}

impl Measures {
    pub(crate) fn of(objects: &Objects<'_>) -> Self {
        let shortest: Vec<f64> = objects.scene.meshes.iter().map(|named| shortest_edge(&named.mesh)).collect();
        let mut measures = Self { condition: 1.0, smallest: f64::INFINITY, ..Self::default() };
        for object in &objects.list {
            let linear = object.world_from_local.linear();
            measures.objects += 1;
            measures.condition = measures.condition.max(condition(&linear));
            let Some(bounds) = object.bounds else {
                measures.infinite_objects += 1;
                continue;
            };
            let size = match object.geometry {
                Geometry::Shape(_) => bounds.extent().max_element(),
                Geometry::Mesh(index, mesh) => {
                    measures.triangles += mesh.data().triangles.len() as u64;
                    let [.., min_stretch] = singular_values(&linear);
                    shortest[index] * min_stretch
                }
            };
            measures.smallest = measures.smallest.min(size);
        }
        let bounds = objects.bounds();
        if bounds.is_empty() {
            measures.smallest = 0.0;
            return measures;
        }
        measures.extent = bounds.extent().max_element();
        measures.dynamic_range = measures.extent / measures.smallest;
        measures.origin_distance = bounds.centre().length() / measures.extent;
        measures.bounds = Some(bounds);
        measures
    }
}

impl fmt::Display for Measures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "objects          {} ({} infinite), {} triangles in meshes",
            self.objects, self.infinite_objects, self.triangles
        )?;
        if let Some(Aabb { min, max }) = self.bounds {
            writeln!(
                f,
                "bounds           ({:.6}, {:.6}, {:.6}) to ({:.6}, {:.6}, {:.6})",
                min.x, min.y, min.z, max.x, max.y, max.z
            )?;
            writeln!(f, "extent           {}", short_number(self.extent, 6))?;
            writeln!(
                f,
                "smallest         {} (range {})",
                short_number(self.smallest, 6),
                short_number(self.dynamic_range, 4)
            )?;
            writeln!(f, "origin distance  {} of the extent", short_number(self.origin_distance, 4))?;
        }
        writeln!(f, "condition number {} (largest of all transforms)", short_number(self.condition, 4))?;
        self.cameras.iter().try_for_each(|camera| write!(f, "{camera}"))
    }
}

/// Infinite for a mesh without triangles.
fn shortest_edge(mesh: &rt_geometry::TriangleMesh) -> f64 {
    mesh.data().triangles.iter().fold(f64::INFINITY, |shortest, &triangle| {
        let [a, b, c] = corners(mesh, triangle);
        let squares = [(b - a).length_squared(), (c - b).length_squared(), (a - c).length_squared()];
        shortest.min(squares.into_iter().fold(f64::INFINITY, f64::min).sqrt())
    })
}

pub(crate) fn check(objects: &Objects<'_>, measures: &Measures, findings: &mut Findings) {
    let mut add = |kind, name, number, limits: [f64; 2], message| {
        if number > limits[0] {
            let values = [(name, number), ("extent", measures.extent)];
            findings.add(Finding::new(kind, &objects.scene.name, &values, message).warn_if(number > limits[1]));
        }
    };
    let (range, distance) = (measures.dynamic_range, measures.origin_distance);
    let message = format!("the largest length is {range:.3e} times the smallest ({:.3e})", measures.smallest);
    add(Kind::DynamicRange, "dynamic_range", range, [WIDE_RANGE, EXTREME_RANGE], message);
    let message = format!("is {distance:.3e} times its extent away from the origin");
    add(Kind::FarFromOrigin, "origin_distance", distance, [FAR, VERY_FAR], message);
    for named in objects.meshes() {
        findings.extend(coarse_vertices(&named));
    }
}

fn coarse_vertices(named: &rt_scene_io::NamedMesh) -> Option<Finding> {
    let bounds = named.mesh.bounds();
    let extent = bounds.extent().max_element();
    let farthest = bounds.max_abs() as f32;
    let spacing = f64::from(farthest.next_up() - farthest);
    (extent > 0.0 && spacing > COARSE * extent).then(|| Finding::new(Kind::CoarseVertices, &named.name, &[("spacing", spacing), ("extent", extent)], format!(
            "vertices are up to {farthest:.3e} from the mesh's own origin, where 32-bit numbers are {spacing:.3e} apart; \
             the mesh is {extent:.3e} large"
        )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_math::{DVec3, Transform, Vec3};

    #[test]
    fn lengths_are_those_of_the_world() {
        let mut scene = scene_of_mesh(cube_data());
        scene.nodes[0].parent_from_local = Transform::scale(DVec3::new(2.0, 8.0, 0.5)).unwrap();
        scene.nodes.extend([floor(-1.0), sphere(DVec3::new(0.0, 8.0, 0.0), 4.0)]);
        let measures = crate::check(&scene).measures;
        assert_eq!((measures.objects, measures.infinite_objects, measures.triangles), (3, 1, 12));
        assert!((measures.extent - 12.0).abs() < 1e-9);
        assert!((measures.smallest - 0.5).abs() < 1e-12);
        assert!((measures.dynamic_range - 24.0).abs() < 1e-9);
        assert!((measures.condition - 16.0).abs() < 1e-12);
        // The box runs from (−4, 0, −4) to (4, 12, 4).
        assert!((measures.origin_distance - 0.5).abs() < 1e-9, "{measures:?}");
        assert_eq!(crate::check(&empty()).measures, Measures { condition: 1.0, ..Measures::default() });
    }

    #[test]
    fn specks_and_distance_are_found() {
        let mut scene = scene_with(vec![sphere(DVec3::ZERO, 1.0), sphere(DVec3::Y * 2.0, 1e-8)]);
        let finding = only(&scene, Kind::DynamicRange);
        assert_eq!(finding.severity, Severity::Note);
        assert!((finding.values[0].value - 1.5e8).abs() < 1e3, "{finding:?}");
        scene.nodes[1] = sphere(DVec3::Y * 2.0, 1e-13);
        assert_eq!(only(&scene, Kind::DynamicRange).severity, Severity::Warning);

        scene.nodes = vec![sphere(DVec3::X * 4e7, 1.0)];
        let finding = only(&scene, Kind::FarFromOrigin);
        assert_eq!(finding.severity, Severity::Note);
        assert!((finding.values[0].value - 2e7).abs() < 1.0, "{finding:?}");
        scene.nodes = vec![sphere(DVec3::X * 4e10, 1.0)];
        assert_eq!(only(&scene, Kind::FarFromOrigin).severity, Severity::Warning);
    }

    #[test]
    fn meshes_far_from_their_own_origin_are_coarse() {
        let mut data = cube_data();
        data.positions.iter_mut().for_each(|p| *p += Vec3::splat(65536.0));
        let scene = scene_of_mesh(data);
        let finding = only(&scene, Kind::CoarseVertices);
        assert_eq!(finding.values, [value("spacing", 1.0 / 128.0), value("extent", 1.0)]);
    }
}
