//! A closed mesh.

use rt_math::DVec3;
use std::collections::HashMap;

/// Vertices and triangles of an icosahedron whose faces were cut in four `levels` times, pushed out to the unit sphere.
/// Its 20·4ˡ triangles share their vertices and close without gaps.
pub fn icosphere(levels: u32) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let mut vertices = icosahedron_vertices();
    let mut triangles = icosahedron_triangles(&vertices);
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a] + vertices[b]).normalize());
                vertices.len() - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (vertices, triangles)
}

/// Corners of three golden rectangles at right angles.
fn icosahedron_vertices() -> Vec<DVec3> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let corners = |(a, b)| [DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)];
    let signs = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)];
    signs.into_iter().flat_map(corners).map(DVec3::normalize).collect()
}

/// All triples of mutual neighbours, counter-clockwise from outside.
fn icosahedron_triangles(vertices: &[DVec3]) -> Vec<[usize; 3]> {
    // Neighbours are at 1.05, the next nearest vertices at 1.70.
    let near = |a: usize, b: usize| vertices[a].distance(vertices[b]) < 1.2;
    let mut triangles = Vec::new();
    for a in 0..vertices.len() {
        for b in a + 1..vertices.len() {
            for c in b + 1..vertices.len() {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outwards = vertices[a].dot((vertices[b] - vertices[a]).cross(vertices[c] - vertices[a])) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_closed_and_faces_outwards() {
        for levels in 0..4 {
            let (vertices, triangles) = icosphere(levels);
            assert_eq!(triangles.len(), 20 << (2 * levels));
            assert_eq!(vertices.len(), triangles.len() / 2 + 2, "Euler's formula for a sphere");
            let mut edges = HashMap::new();
            for [a, b, c] in &triangles {
                let [p, q, r] = [a, b, c].map(|&i| vertices[i]);
                assert!(p.dot((q - p).cross(r - p)) > 0.0);
                for edge in [(a, b), (b, c), (c, a)] {
                    *edges.entry(edge).or_insert(0) += 1;
                }
            }
            assert!(edges.iter().all(|(&(a, b), &count)| count == 1 && edges.get(&(b, a)) == Some(&1)));
        }
    }
}
