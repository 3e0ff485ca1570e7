//! Instanced meshes (EXT_mesh_gpu_instancing).

use gltf::{Document, Node, scene::Transform as Matrix};
use rt_math::Transform;
use serde::Deserialize;

use super::{accessor::read_vectors, buffers::Buffers, node_pose::transform};
use crate::parser_message::plain;
use crate::{LoadError, LoadErrorKind};

pub(super) const NAME: &str = "EXT_mesh_gpu_instancing";

/// The object of the extension at a node.
#[derive(Deserialize)]
struct Instancing {
    attributes: InstanceAttributes,
}

/// Accessors with the transforms of instances; other attributes are ignored.
#[derive(Deserialize)]
#[serde(rename_all = "UPPERCASE")]
struct InstanceAttributes {
    translation: Option<usize>,
    rotation: Option<usize>,
    scale: Option<usize>,
}

/// Transforms of the instances of a node's mesh, in the space of the node, and the number of unusable ones. `None` for a mesh
/// that is not instanced.
pub(super) fn placements(node: &Node<'_>, buffers: &Buffers<'_>) -> Result<Option<(Vec<Transform>, usize)>, LoadError> {
    let Some(object) = node.extension_value(NAME) else { return Ok(None) };
    let fail = |message: String| {
        LoadErrorKind::Syntax(message).at(buffers.path(), format!("nodes[{}].extensions.{NAME}", node.index()))
    };
    let Instancing { attributes } = Instancing::deserialize(object).map_err(|error| fail(plain(&error.to_string())))?;
    let document = buffers.document();
    let translations = read::<3>(attributes.translation, document, buffers, &fail)?;
    let rotations = read::<4>(attributes.rotation, document, buffers, &fail)?;
    let scales = read::<3>(attributes.scale, document, buffers, &fail)?;
    let counts =
        [&translations.as_ref().map(Vec::len), &rotations.as_ref().map(Vec::len), &scales.as_ref().map(Vec::len)];
    let mut counts = counts.into_iter().flatten();
    let Some(&count) = counts.next() else {
        return Err(fail("has none of TRANSLATION, ROTATION and SCALE".to_owned()));
    };
    if let Some(other) = counts.find(|other| **other != count) {
        return Err(fail(format!("the counts of its attributes differ: {count} and {other}")));
    }
    let place = |i: usize| {
        transform(&Matrix::Decomposed {
            translation: translations.as_ref().map_or([0.0; 3], |all| all[i]),
            rotation: rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |all| all[i]),
            scale: scales.as_ref().map_or([1.0; 3], |all| all[i]),
        })
    };
    let places: Vec<Transform> = (0..count).filter_map(|i| place(i).ok()).collect();
    let unusable = count - places.len();
    Ok(Some((places, unusable)))
}

fn read<const N: usize>(
    accessor: Option<usize>,
    document: &Document,
    buffers: &Buffers<'_>,
    fail: impl Fn(String) -> LoadError,
) -> Result<Option<Vec<[f32; N]>>, LoadError> {
    let Some(index) = accessor else { return Ok(None) };
    let accessor = document.accessors().nth(index).ok_or_else(|| fail(format!("there is no accessor {index}")))?;
    read_vectors(&accessor, buffers).map(Some)
}
