//! Meshes from the arrays of model files, with a warning for each kind of repair.

use rt_geometry::{MeshData, MeshError, TriangleMesh};
use rt_math::Vec3;

use crate::Warning;

/// Ratio of the largest coordinate of a mesh to its size above which rounding may flatten its smaller triangles. There, numbers of 24
/// bits resolve a ten-thousandth of the size.
const COARSE: f32 = 1e3;

/// Likely cause of a repair, by the vertices of the mesh; empty for none.
type Cause = fn(&[Vec3]) -> &'static str;

/// Builds a mesh; `None`, with a warning, if no triangle is left.
pub(crate) fn build_mesh(
    data: MeshData,
    place: &str,
    warnings: &mut Vec<Warning>,
) -> Result<Option<TriangleMesh>, MeshError> {
    let total = data.triangles.len();
    let (mesh, repairs) = TriangleMesh::build(data)?;
    let triangles: [(usize, &str, Cause); 2] = [
        (repairs.degenerate, "triangles without area were dropped", note_of_rounding),
        (repairs.non_finite, "triangles with a NaN or infinite vertex were dropped", note_of_infinity),
    ];
    let attributes = [
        (repairs.bad_normals, "normals that are zero or not finite were replaced by those of a triangle"),
        (repairs.bad_uvs, "texture coordinates that are not finite were set to zero"),
        (repairs.bad_colors, "vertex colours that are negative or not finite were set to white"),
        (repairs.bad_tangents, "tangents that are zero or not finite were ignored"),
    ];
    let mut warn = |message| warnings.push(Warning { place: place.to_owned(), message });
    for (count, what, note) in triangles.into_iter().filter(|(count, ..)| *count > 0) {
        warn(format!("{what}: {count} of {total}{}", note(&mesh.data().positions)));
    }
    for (count, what) in attributes.into_iter().filter(|(count, _)| *count > 0) {
        warn(format!("{what}: {count}"));
    }
    if mesh.data().triangles.is_empty() {
        warn("no triangles are left; the mesh is left out".to_owned());
        return Ok(None);
    }
    Ok(Some(mesh))
}

/// Cause of infinite vertices, if there are any.
fn note_of_infinity(positions: &[Vec3]) -> &'static str {
    let is_infinite = |vertex: &Vec3| vertex.to_array().into_iter().any(f32::is_infinite);
    if positions.iter().any(is_infinite) {
        "; vertices of meshes are stored in single precision, and numbers above 3.4e38 count as infinite"
    } else {
        ""
    }
}

/// Likely cause of triangles without area in a mesh that lies far from its origin.
fn note_of_rounding(positions: &[Vec3]) -> &'static str {
    let finite = positions.iter().copied().filter(|vertex| vertex.is_finite());
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (min, max) = finite.fold(start, |(min, max), vertex| (min.min(vertex), max.max(vertex)));
    let (size, farthest) = ((max - min).max_element(), min.abs().max(max.abs()).max_element());
    // All vertices of a mesh that is farther away may have become one point.
    let is_far = if size > 0.0 { farthest > COARSE * size } else { size == 0.0 && farthest > COARSE };
    if is_far {
        "; rounding may be the cause: vertices of meshes are stored in single precision, and these are far from the origin"
    } else {
        ""
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warnings(positions: Vec<Vec3>) -> Vec<String> {
        let triangles = vec![[0, 1, 2], [0, 1, 3]];
        let mut warnings = Vec::new();
        build_mesh(MeshData { positions, triangles, ..MeshData::default() }, "m", &mut warnings).expect("a mesh");
        warnings.into_iter().map(|warning| warning.message).collect()
    }

    #[test]
    fn vertices_beyond_single_precision_are_explained() {
        let with = |x| warnings(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(x, 1.0, 0.0)]);
        let dropped = "triangles with a NaN or infinite vertex were dropped: 1 of 2";
        assert_eq!(with(f32::NAN), [dropped]);
        let cause = "; vertices of meshes are stored in single precision, and numbers above 3.4e38 count as infinite";
        assert_eq!(with(1e39_f64 as f32), [format!("{dropped}{cause}")]);
    }

    #[test]
    fn rounding_is_named_as_the_cause_of_triangles_without_area_only_far_from_the_origin() {
        let at =
            |x: f32| warnings([0.0, 1.0, 2.0, 3.0].map(|i: f32| Vec3::new(x + i, (i - 2.0).max(0.0), 0.0)).to_vec());
        let dropped = "triangles without area were dropped: 1 of 2";
        assert_eq!(at(0.0), [dropped]);
        let cause = "; rounding may be the cause: vertices of meshes are stored in single precision, and these are far from the \
                     origin";
        assert_eq!(at(1e5), [format!("{dropped}{cause}")]);
    }
}
