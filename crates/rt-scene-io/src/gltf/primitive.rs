//! Primitives of meshes as arrays of triangles.

use std::sync::Arc;

use gltf::{Accessor, Primitive, Semantic, mesh::Mode};
use rt_geometry::{MeshData, fan, strip};
use rt_math::{DVec3, Vec3};

use super::{
    accessor::read_vectors,
    attributes::Attributes,
    buffers::Buffers,
    node_pose::Affine,
    skin::{self, Deformed, Influences},
};
use crate::error::ErrorAt;
use crate::{LoadError, LoadErrorKind, tangents};

/// Attributes that a material requires, apart from positions and normals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RequiredAttributes {
    /// Sets of texture coordinates (TEXCOORD_n) for the two slots of a mesh; `None` for an unused slot.
    pub(super) uv_sets: [Option<u32>; 2],
    /// Vertex colours.
    pub(super) colors: bool,
    /// Set of texture coordinates along which tangents are generated where a file has none; `None` if it needs no tangents.
    pub(super) tangents: Option<u32>,
}

pub(super) struct Deformation<'a> {
    /// Weights of the morph targets.
    pub(super) weights: &'a [f32],
    /// The joints that take it to the world, if it follows some.
    pub(super) joints: Option<Arc<[Affine]>>,
    /// True if a node mirrors a skinned mesh: its triangles are reversed.
    pub(super) mirrored: bool,
}

/// Triangles of a primitive.
pub(super) struct PrimitiveContent {
    pub(super) data: MeshData,
    /// Origin of a mesh that joints took to the world, in world space; `None` for a mesh in the space of its node.
    pub(super) skinned_at: Option<DVec3>,
    /// Messages about omissions and repairs.
    pub(super) notes: Vec<String>,
}

/// Reads the arrays of a primitive, and applies morph targets and skins. Missing tangents are generated if the material
/// needs them. `None` for points and lines, which have no surface.
pub(super) fn read(
    primitive: &Primitive<'_>,
    required_attributes: &RequiredAttributes,
    deformation: &Deformation<'_>,
    buffers: &Buffers<'_>,
    place: &str,
) -> Result<Option<PrimitiveContent>, LoadError> {
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        return Ok(None);
    }
    let mut notes = Vec::new();
    // The origin of a mesh that joints move depends on all of its vertices.
    let is_deformed = deformation.joints.is_some() || primitive.morph_targets().len() > 0;
    let attributes = Attributes::of(primitive, buffers, place, is_deformed)?;
    let mut data = read_vertices(&attributes, required_attributes, &mut notes)?
        .ok_or_else(|| LoadErrorKind::Syntax("has no POSITION".to_owned()).at(buffers.path(), place))?;
    let order = attributes.order(data.positions.len())?;
    if primitive.mode() == Mode::Triangles && order.len() % 3 != 0 {
        notes.push("the number of vertices is not a multiple of three; the last ones are left out".to_owned());
    }
    data.triangles = assemble(primitive.mode(), &order);
    check_counts(&data).at(buffers.path(), place)?;
    morph(&mut data, primitive, deformation.weights, buffers, place)?;
    let skinned_at = match &deformation.joints {
        Some(joints) => {
            apply_skin(&mut data, &attributes, joints, &mut notes).map_err(|apply_skin| match apply_skin {
                SkinError::Read(error) => error,
                SkinError::Deform(reason) => reason.at(buffers.path(), place),
            })?
        }
        None => None,
    };
    if skinned_at.is_some() && deformation.mirrored {
        data.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    if let Some(set) = required_attributes.tangents {
        complete_tangents(&mut data, set, required_attributes, &attributes, &mut notes)?;
    }
    Ok(Some(PrimitiveContent { data, skinned_at, notes }))
}

/// The arrays that have an element for each vertex; `None` without positions.
fn read_vertices(
    attributes: &Attributes<'_>,
    required_attributes: &RequiredAttributes,
    notes: &mut Vec<String>,
) -> Result<Option<MeshData>, LoadError> {
    let vectors = |list: Vec<[f32; 3]>| list.into_iter().map(Vec3::from).collect::<Vec<_>>();
    let Some(positions) = attributes.vectors::<3>(&Semantic::Positions)? else { return Ok(None) };
    let normals = attributes.vectors::<3>(&Semantic::Normals)?.map_or(Vec::new(), vectors);
    let mut sets = [Vec::new(), Vec::new()];
    for (set, slot) in required_attributes.uv_sets.iter().zip(&mut sets) {
        let Some(set) = *set else { continue };
        match attributes.vectors::<2>(&Semantic::TexCoords(set))? {
            Some(uvs) => *slot = upwards(uvs),
            None => notes
                .push(format!("its texture needs TEXCOORD_{set}, which is missing: the texture is read at one point")),
        }
    }
    // Flat triangles have normals of their own, which the tangents of a file do not fit.
    let tangents = if required_attributes.tangents.is_some() && !normals.is_empty() {
        attributes.vectors::<4>(&Semantic::Tangents)?.unwrap_or_default()
    } else {
        Vec::new()
    };
    let colors = if required_attributes.colors { attributes.colours()? } else { Vec::new() };
    let [uvs, second_uvs] = sets;
    let positions = vectors(positions);
    Ok(Some(MeshData { positions, triangles: Vec::new(), normals, uvs, second_uvs, colors, tangents }))
}

/// Refuses arrays that do not fit together, before they are changed element by element.
fn check_counts(data: &MeshData) -> Result<(), LoadErrorKind> {
    let count = data.positions.len();
    let lengths = [data.normals.len(), data.uvs.len(), data.second_uvs.len(), data.colors.len(), data.tangents.len()];
    if let Some(length) = lengths.into_iter().find(|length| *length != 0 && *length != count) {
        return Err(LoadErrorKind::invalid(length, format!("elements of an attribute do not fit {count} positions")));
    }
    match data.triangles.iter().flatten().find(|vertex| **vertex as usize >= count) {
        Some(vertex) => Err(LoadErrorKind::invalid(vertex, format!("is an index, but there are {count} vertices"))),
        None => Ok(()),
    }
}

/// Adds the morph targets (glTF 2.0, section 3.7.2.2).
fn morph(
    data: &mut MeshData,
    primitive: &Primitive<'_>,
    weights: &[f32],
    buffers: &Buffers<'_>,
    place: &str,
) -> Result<(), LoadError> {
    let count = data.positions.len();
    let deltas = |accessor: Option<Accessor<'_>>, wanted: bool| {
        let Some(accessor) = accessor.filter(|_| wanted) else { return Ok(Vec::new()) };
        let deltas = read_vectors::<3>(&accessor, buffers)?;
        if deltas.len() != count {
            let rule = format!("elements of a morph target do not fit {count} positions");
            return Err(LoadErrorKind::invalid(deltas.len(), rule).at(buffers.path(), format!("{place}.targets")));
        }
        Ok(deltas)
    };
    for (target, &weight) in primitive.morph_targets().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        for (position, delta) in data.positions.iter_mut().zip(deltas(target.positions(), true)?) {
            *position += Vec3::from(delta) * weight;
        }
        let normals = deltas(target.normals(), !data.normals.is_empty())?;
        for (normal, delta) in data.normals.iter_mut().zip(normals) {
            *normal += Vec3::from(delta) * weight;
        }
        let tangents = deltas(target.tangents(), !data.tangents.is_empty())?;
        for (tangent, delta) in data.tangents.iter_mut().zip(tangents) {
            (0..3).for_each(|k| tangent[k] += delta[k] * weight);
        }
    }
    Ok(())
}

enum SkinError {
    Read(LoadError),
    Deform(LoadErrorKind),
}

/// Takes the mesh to the world by its joints, and returns its origin there; `None`, with a note, if it names none.
fn apply_skin(
    data: &mut MeshData,
    attributes: &Attributes<'_>,
    joints: &[Affine],
    notes: &mut Vec<String>,
) -> Result<Option<DVec3>, SkinError> {
    let mut sets = Vec::new();
    for set in 0.. {
        let joints = attributes.vectors::<4>(&Semantic::Joints(set)).map_err(SkinError::Read)?;
        let weights = attributes.vectors::<4>(&Semantic::Weights(set)).map_err(SkinError::Read)?;
        let (Some(joints), Some(weights)) = (joints, weights) else { break };
        if joints.len() != data.positions.len() || weights.len() != data.positions.len() {
            let rule =
                format!("and {} joints and weights do not fit {} positions", weights.len(), data.positions.len());
            return Err(SkinError::Deform(LoadErrorKind::invalid(joints.len(), rule)));
        }
        sets.push(Influences { joints, weights });
    }
    if sets.is_empty() {
        notes.push("its node has a skin, but it has no joints and weights; the skin is ignored".to_owned());
        return Ok(None);
    }
    let Deformed { origin, unnormalised } = skin::deform(data, &sets, joints).map_err(SkinError::Deform)?;
    if unnormalised > 0 {
        notes.push(format!("the weights of {unnormalised} vertices do not have the sum 1; they were scaled"));
    }
    Ok(Some(origin))
}

/// Texture coordinates with v upwards; in the file it runs downwards.
fn upwards(uvs: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    uvs.into_iter().map(|[u, v]| [u, 1.0 - v]).collect()
}

/// Makes tangents along a set of texture coordinates where the file has none.
fn complete_tangents(
    data: &mut MeshData,
    set: u32,
    required_attributes: &RequiredAttributes,
    attributes: &Attributes<'_>,
    notes: &mut Vec<String>,
) -> Result<(), LoadError> {
    if !data.tangents.is_empty() {
        return Ok(());
    }
    let uvs = match required_attributes.uv_sets.iter().position(|slot| *slot == Some(set)) {
        Some(0) => data.uvs.clone(),
        Some(_) => data.second_uvs.clone(),
        // No texture reads the set.
        None => attributes.vectors::<2>(&Semantic::TexCoords(set))?.map(upwards).unwrap_or_default(),
    };
    if uvs.len() == data.positions.len() {
        tangents::generate(data, &uvs);
    } else {
        notes.push(format!("its normal map or anisotropy needs tangents or TEXCOORD_{set}: it is left out"));
    }
    Ok(())
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
