//! Topology of meshes: borders, winding and enclosed volume.

use rt_geometry::TriangleMesh;
use rt_math::DVec3;
use rt_scene_io::NamedMesh;

use crate::finding::{Finding, Findings, Kind};
use crate::welded::{Welded, corners};

/// Counts of the edges of a mesh by their use, and its volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Topology {
    /// Edges of one triangle.
    pub(crate) open: usize,
    /// Edges of two triangles that use it in the same direction: their fronts disagree.
    pub(crate) inconsistent: usize,
    /// Edges of more than two triangles.
    pub(crate) non_manifold: usize,
    /// Edges used more often in one direction than in the other.
    unbalanced: usize,
    /// Sum of signed tetrahedra (divergence theorem): positive for a closed mesh whose front is outside.
    pub(crate) volume: f64,
}

impl Topology {
    pub(crate) fn of(mesh: &TriangleMesh, welded: &Welded) -> Self {
        let mut topology = Self { volume: volume(mesh), ..Self::default() };
        let mut edges = directed_edges(welded);
        edges.sort_unstable();
        for edge in edges.chunk_by(|a, b| a.0 == b.0) {
            let backward = edge.iter().filter(|(_, backward)| *backward).count();
            let forward = edge.len() - backward;
            topology.unbalanced += usize::from(forward != backward);
            match edge.len() {
                1 => topology.open += 1,
                2 => topology.inconsistent += usize::from(forward != backward),
                _ => topology.non_manifold += 1,
            }
        }
        topology
    }

    /// True if the surface separates an inside from an outside, with its front on one side. Its triangles use every
    /// edge equally often in both directions.
    pub(crate) const fn is_closed(&self) -> bool {
        self.unbalanced == 0
    }
}

/// Edge with its lower vertex first, and a flag for the direction from the higher vertex.
type DirectedEdge = ((u32, u32), bool);

/// Bytes per edge of a triangle while the edges of a mesh are counted.
pub(crate) const EDGE_BYTES: usize = size_of::<DirectedEdge>();

/// Directed edges of all triangles. Duplicate triangles count once.
fn directed_edges(welded: &Welded) -> Vec<DirectedEdge> {
    let mut triangles = welded.sorted_keys();
    triangles.dedup();
    let edge = |a: u32, b: u32| if a < b { ((a, b), false) } else { ((b, a), true) };
    let edges = |&[a, b, c, reversed]: &[u32; 4]| {
        let [b, c] = if reversed == 1 { [c, b] } else { [b, c] };
        [edge(a, b), edge(b, c), edge(c, a)]
    };
    triangles.iter().flat_map(edges).collect()
}

/// Signed volume. It is computed relative to the centre of the mesh: a distant origin costs no digits.
fn volume(mesh: &TriangleMesh) -> f64 {
    let middle = mesh.bounds().centre();
    let parallelepiped = |triangle: &[u32; 3]| {
        let [a, b, c]: [DVec3; 3] = corners(mesh, *triangle).map(|corner| corner - middle);
        a.dot(b.cross(c))
    };
    mesh.data().triangles.iter().map(parallelepiped).sum::<f64>() / 6.0
}

pub(crate) fn check(named: &NamedMesh, topology: &Topology, is_glass: bool, findings: &mut Findings) {
    let counted = [
        (Kind::InconsistentWinding, topology.inconsistent, "edges join two triangles of opposite orientation"),
        (Kind::NonManifoldEdges, topology.non_manifold, "edges have more than two triangles"),
        (Kind::OpenEdges, topology.open, "edges have one triangle, so the mesh is open"),
    ];
    for (kind, count, what) in counted.into_iter().filter(|(_, count, _)| *count > 0) {
        let finding = Finding::new(kind, &named.name, &[("count", count as f64)], format!("{what}: {count}"));
        findings.add(finding.warn_if(kind == Kind::InconsistentWinding && is_glass));
    }
    if topology.is_closed() && topology.volume < 0.0 {
        let volume = topology.volume;
        let message = format!("the front is inside (signed volume {volume:.6e})");
        findings.add(Finding::new(Kind::InsideOut, &named.name, &[("volume", volume)], message).warn_if(is_glass));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::*;
    use rt_geometry::MeshData;
    use rt_math::Vec3;

    fn topology(data: MeshData) -> Topology {
        let mesh = TriangleMesh::build(data).unwrap().0;
        Topology::of(&mesh, &Welded::new(mesh.data()))
    }

    #[test]
    fn a_cube_is_closed_at_any_position() {
        let cube = topology(cube_data());
        assert_eq!(cube, Topology { volume: 1.0, ..Topology::default() });
        let mut far = cube_data();
        far.positions.iter_mut().for_each(|p| *p += Vec3::splat(4096.0));
        assert_eq!(topology(far).volume, 1.0);
        assert!(cube.is_closed());
    }

    #[test]
    fn seams_do_not_open_a_mesh() {
        let mut data = cube_data();
        data.positions = data.triangles.iter().flatten().map(|&i| data.positions[i as usize]).collect();
        data.triangles = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        assert!(topology(data).is_closed());
    }

    #[test]
    fn border_winding_and_non_manifold_edges_are_counted() {
        let mut open = cube_data();
        open.triangles.pop();
        assert_eq!(topology(open).open, 3);

        let mut turned = cube_data();
        turned.triangles[0].swap(1, 2);
        let turned = topology(turned);
        assert_eq!((turned.inconsistent, turned.open, turned.is_closed()), (3, 0, false));

        let mut fin = cube_data();
        fin.positions.push(Vec3::splat(-1.0));
        fin.triangles.push([0, 1, 8]);
        let fin = topology(fin);
        assert_eq!((fin.non_manifold, fin.open), (1, 2));

        let mut twice = cube_data();
        twice.triangles.extend_from_within(..);
        assert!(topology(twice).is_closed(), "duplicate triangles have a finding of their own");
    }

    #[test]
    fn severity_depends_on_the_material() {
        let mut data = cube_data();
        data.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        let mut scene = scene_of_mesh(data);
        let finding = only(&scene, Kind::InsideOut);
        assert_eq!((finding.severity, finding.values), (Severity::Note, vec![value("volume", -1.0)]));
        scene.nodes[0].material = GLASS;
        assert_eq!(only(&scene, Kind::InsideOut).severity, Severity::Warning);
    }

    #[test]
    fn findings_name_the_mesh_and_the_count() {
        let mut data = cube_data();
        data.triangles.pop();
        data.triangles[0].swap(1, 2);
        data.positions.push(Vec3::splat(-1.0));
        data.triangles.push([0, 1, 8]);
        let scene = scene_of_mesh(data);
        for (kind, count) in [(Kind::OpenEdges, 5.0), (Kind::InconsistentWinding, 3.0), (Kind::NonManifoldEdges, 1.0)] {
            let finding = only(&scene, kind);
            assert_eq!((finding.object.as_str(), finding.values), ("cube", vec![value("count", count)]), "{kind:?}");
        }
    }
}
