//! Duplicate triangles, slivers, and triangles of very different sizes.

use rt_geometry::TriangleMesh;
use rt_scene_io::NamedMesh;

use crate::finding::{Finding, Findings, Kind};
use crate::welded::{Welded, corners};

/// Ratio of longest edge to height above which a triangle counts as a sliver: its normal depends on three digits of its `f32`
/// vertices.
const SLIVER: f64 = 1e4;

/// Ratio of the longest or shortest edge to the median one above which a mesh is uneven.
const UNEVEN: f64 = 1e4;

pub(crate) fn check(named: &NamedMesh, welded: &Welded, findings: &mut Findings) {
    duplicates(named, welded, findings);
    slivers(named, findings);
    uneven(named, findings);
}

/// Numbers of triangles that repeat an earlier one: with the same front, and back to back.
fn count_duplicates(welded: &Welded) -> (usize, usize) {
    let keys = welded.sorted_keys();
    let (mut same, mut opposite) = (0, 0);
    for twins in keys.chunk_by(|a, b| a[..3] == b[..3]) {
        let turned = twins.iter().filter(|key| key[3] == 1).count();
        let straight = twins.len() - turned;
        same += straight.saturating_sub(1) + turned.saturating_sub(1);
        opposite += usize::from(turned > 0 && straight > 0);
    }
    (same, opposite)
}

fn duplicates(named: &NamedMesh, welded: &Welded, findings: &mut Findings) {
    let (same, opposite) = count_duplicates(welded);
    if same > 0 {
        findings.add(Finding::new(
            Kind::DuplicateTriangles,
            &named.name,
            &[("count", same as f64)],
            format!("{same} of {} triangles repeat another one", welded.triangles.len()),
        ));
    }
    if opposite > 0 {
        findings.add(Finding::new(
            Kind::OppositeTriangles,
            &named.name,
            &[("count", opposite as f64)],
            format!("triangles are back to back with another one in the same place: {opposite}"),
        ));
    }
}

fn slivers(named: &NamedMesh, findings: &mut Findings) {
    let (mut count, mut worst, mut example) = (0u64, 0.0, 0);
    for (index, &triangle) in named.mesh.data().triangles.iter().enumerate() {
        let aspect = aspect_ratio(&named.mesh, triangle);
        if aspect > SLIVER {
            count += 1;
            if aspect > worst {
                (worst, example) = (aspect, index);
            }
        }
    }
    if count > 0 {
        findings.add(Finding::new(
            Kind::SliverTriangles,
            &named.name,
            &[("count", count as f64), ("worst_aspect_ratio", worst), ("worst_triangle", example as f64)],
            format!(
                "{count} of {} triangles are more than {SLIVER:.0e} times as long as high, triangle {example} \
                 {worst:.3e} times",
                named.mesh.data().triangles.len()
            ),
        ));
    }
}

/// Ratio of the longest edge to the height above it; infinite if the height rounds to 0.
fn aspect_ratio(mesh: &TriangleMesh, triangle: [u32; 3]) -> f64 {
    let [a, b, c] = corners(mesh, triangle);
    let edges = [b - a, c - b, a - c];
    let longest = edges.iter().fold(0.0, |max: f64, edge| max.max(edge.length_squared()));
    let double_area = rt_math::float::cross(edges[0], edges[1]).length();
    longest / double_area
}

fn uneven(named: &NamedMesh, findings: &mut Findings) {
    let mesh = &named.mesh;
    let mut lengths: Vec<f64> = Vec::with_capacity(mesh.data().triangles.len() * 3);
    for &triangle in &mesh.data().triangles {
        let [a, b, c] = corners(mesh, triangle);
        lengths.extend([(b - a).length(), (c - b).length(), (a - c).length()]);
    }
    if lengths.is_empty() {
        return;
    }
    let middle = lengths.len() / 2;
    let (shorter, median, longer) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    let shortest = shorter.iter().copied().fold(median, f64::min);
    let longest = longer.iter().copied().fold(median, f64::max);
    if longest > UNEVEN * median || shortest * UNEVEN < median {
        findings.add(Finding::new(
            Kind::UnevenTriangles,
            &named.name,
            &[("shortest_edge", shortest), ("median_edge", median), ("longest_edge", longest)],
            format!("edges are {shortest:.3e} to {longest:.3e} long, half of them at most {median:.3e}"),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_geometry::MeshData;
    use rt_math::Vec3;

    #[test]
    fn duplicates_are_counted_by_their_front() {
        let mut data = cube_data();
        data.triangles.extend([[3, 0, 2], [0, 2, 3], [0, 3, 2]]);
        let scene = scene_of_mesh(data);
        let same = only(&scene, Kind::DuplicateTriangles);
        assert_eq!((same.values, same.object.as_str()), (vec![value("count", 2.0)], "cube"));
        assert_eq!(of_kind(&scene, Kind::OppositeTriangles)[0].values, [value("count", 1.0)]);
    }

    #[test]
    fn slivers_are_measured() {
        let data = MeshData {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1e-5, 0.0), Vec3::new(0.5, 1e-3, 0.0)],
            triangles: vec![[0, 1, 3], [0, 1, 2]],
            ..MeshData::default()
        };
        let scene = scene_of_mesh(data);
        let finding = only(&scene, Kind::SliverTriangles);
        assert_eq!((finding.values[0].value, finding.values[2].value), (1.0, 1.0));
        assert!((finding.values[1].value - 1.0 / f64::from(1e-5f32)).abs() < 1e-6, "{finding:?}");
    }

    #[test]
    fn a_huge_triangle_among_small_ones_is_noted() {
        let mut data = cube_data();
        let first = data.positions.len() as u32;
        data.positions.extend([Vec3::ZERO, Vec3::X * 1e5, Vec3::Y * 1e5]);
        data.triangles.push([first, first + 1, first + 2]);
        let scene = scene_of_mesh(data);
        let finding = only(&scene, Kind::UnevenTriangles);
        assert_eq!(finding.values[0].value, 1.0);
        assert!((finding.values[2].value - 2e10f64.sqrt()).abs() < 1e-3, "{finding:?}");
    }
}
