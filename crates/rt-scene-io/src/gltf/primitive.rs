//! Primitives of meshes as arrays of triangles.

use gltf::{Primitive, Semantic, mesh::Mode};
use rt_geometry::{MeshData, fan, strip};
use rt_math::Vec3;

use super::{
    accessor::{read_indices, read_vectors},
    buffers::Buffers,
};
use crate::{LoadError, Reason};

/// What a material asks of the meshes that have it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wants {
    /// Which of the document's sets of texture coordinates the first and the second of a mesh hold; `None` for neither.
    pub(super) uv_sets: [Option<u32>; 2],
    /// Whether it shows the colours of vertices.
    pub(super) colors: bool,
    /// Whether it has a map that is laid along tangents.
    pub(super) tangents: bool,
}

/// What a primitive holds.
pub(super) enum Content {
    /// Triangles, and what was left out of them.
    Triangles(MeshData, Vec<&'static str>),
    /// Points or lines, which have no surface.
    NoSurface,
}

/// Reads the arrays of a primitive that its material wants.
pub(super) fn read(
    primitive: &Primitive<'_>,
    wants: &Wants,
    buffers: &Buffers<'_>,
    place: &str,
) -> Result<Content, LoadError> {
    let mut notes = Vec::new();
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        return Ok(Content::NoSurface);
    }
    let missing = |what: String| Reason::Syntax(format!("has no {what}")).at(buffers.path(), place);
    let positions = primitive.get(&Semantic::Positions).ok_or_else(|| missing("POSITION".to_owned()))?;
    let positions: Vec<Vec3> = read_vectors::<3>(&positions, buffers)?.into_iter().map(Vec3::from).collect();
    let normals = match primitive.get(&Semantic::Normals) {
        Some(accessor) => read_vectors::<3>(&accessor, buffers)?.into_iter().map(Vec3::from).collect(),
        None => Vec::new(),
    };
    let [uvs, second_uvs] = wants.uv_sets.map(|set| match set {
        Some(set) => match primitive.get(&Semantic::TexCoords(set)) {
            Some(accessor) => {
                Ok(read_vectors::<2>(&accessor, buffers)?.into_iter().map(|[u, v]| [u, 1.0 - v]).collect())
            }
            None => {
                notes.push("its texture reads coordinates that the mesh does not have: one point is used everywhere");
                Ok(Vec::new())
            }
        },
        None => Ok(Vec::new()),
    });
    let (uvs, second_uvs) = (uvs?, second_uvs?);
    let order = match primitive.indices() {
        Some(accessor) => read_indices(&accessor, buffers)?,
        None => (0..u32::try_from(positions.len()).unwrap_or(u32::MAX)).collect(),
    };
    if primitive.mode() == Mode::Triangles && order.len() % 3 != 0 {
        notes.push("the number of vertices is no multiple of three; the last ones are left out");
    }
    if primitive.get(&Semantic::Colors(0)).is_some() {
        notes.push("vertex colours are not followed");
    }
    if primitive.morph_targets().len() > 0 {
        notes.push("morph targets are not followed");
    }
    let triangles = assemble(primitive.mode(), &order);
    Ok(Content::Triangles(MeshData { positions, triangles, normals, uvs, second_uvs, ..MeshData::default() }, notes))
}

/// Triangles from a list of vertices (glTF 2.0, section 3.7.2.1). All keep the orientation of the first.
fn assemble(mode: Mode, order: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::Triangles => order.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        Mode::TriangleStrip => strip(order).collect(),
        Mode::TriangleFan => fan(order).collect(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_orientation() {
        assert_eq!(assemble(Mode::TriangleStrip, &[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(assemble(Mode::TriangleFan, &[9, 1, 2, 3]), [[1, 2, 9], [2, 3, 9]]);
        assert_eq!(assemble(Mode::Triangles, &[0, 1, 2, 3]), [[0, 1, 2]]);
        for mode in [Mode::TriangleStrip, Mode::TriangleFan, Mode::Triangles, Mode::Points] {
            assert_eq!(assemble(mode, &[]), [[0; 3]; 0]);
        }
    }
}
