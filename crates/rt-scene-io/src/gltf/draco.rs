//! Primitives that Draco has compressed (KHR_draco_mesh_compression).

use std::{collections::BTreeMap, path::Path};

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, draco_types::DataType, geometry_indices::PointIndex};
use gltf::Primitive;
use serde::Deserialize;

use super::{
    accessor::{normalised, unit_integer},
    buffers::Buffers,
};
use crate::parser_message::plain;
use crate::{LoadError, LoadErrorKind, limits};

pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// The object of the extension at a primitive.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct DracoExtension {
    buffer_view: usize,
    /// Ids within the stream, by the names of attributes.
    attributes: BTreeMap<String, u32>,
}

pub(super) struct DecodedPrimitive {
    mesh: Mesh,
    ids: BTreeMap<String, u32>,
}

impl DecodedPrimitive {
    /// Decodes a primitive; `None` if it is not compressed.
    pub(super) fn of(primitive: &Primitive<'_>, buffers: &Buffers<'_>, place: &str) -> Result<Option<Self>, LoadError> {
        let Some(object) = primitive.extension_value(NAME) else { return Ok(None) };
        let fail = |message: String| fail(message, buffers.path(), place);
        let DracoExtension { buffer_view, attributes: ids } =
            DracoExtension::deserialize(object).map_err(|error| fail(plain(&error.to_string())))?;
        let view = buffers.document().views().nth(buffer_view);
        let view = view.ok_or_else(|| fail(format!("there is no bufferView {buffer_view}")))?;
        let limits =
            DecodeLimits::default().with_max_faces(limits::DRACO_FACES).with_max_decoded_bytes(limits::DRACO_BYTES);
        let mut stream = DecoderBuffer::new(buffers.view(&view)?).with_limits(limits);
        let mut mesh = Mesh::new();
        MeshDecoder::new().decode(&mut stream, &mut mesh).map_err(|error| fail(error.to_string()))?;
        Ok(Some(Self { mesh, ids }))
    }

    /// Vertices of all triangles, one triangle after the other.
    pub(super) fn indices(&self) -> Vec<u32> {
        self.mesh.faces().iter().flatten().map(|PointIndex(vertex)| *vertex).collect()
    }

    /// An attribute; `None` if it is not in the stream. Integers are normalised if `normalized`.
    pub(super) fn vectors<const N: usize>(
        &self,
        semantic: &str,
        normalized: bool,
        path: &Path,
        place: &str,
    ) -> Result<Option<Vec<[f32; N]>>, LoadError> {
        let Some(id) = self.ids.get(semantic) else { return Ok(None) };
        let fail = |message: String| fail(message, path, place);
        let attribute = self.mesh.attribute_by_unique_id(*id);
        let attribute = attribute.ok_or_else(|| fail(format!("{semantic}: the stream has no attribute {id}")))?;
        let components = usize::from(attribute.num_components());
        if components != N {
            return Err(fail(format!("{semantic} has {components} components, where {N} are needed")));
        }
        let mut values = attribute.read_f32s(self.mesh.num_points(), N);
        if let Some(unit) = unit_integer_of(attribute.data_type()).filter(|_| normalized) {
            values.iter_mut().for_each(|value| *value = normalised(*value, unit));
        }
        Ok(Some(values.as_chunks().0.to_vec()))
    }

    /// Components of an attribute in the stream.
    pub(super) fn components(&self, semantic: &str) -> Option<usize> {
        let attribute = self.mesh.attribute_by_unique_id(*self.ids.get(semantic)?)?;
        Some(usize::from(attribute.num_components()))
    }
}

/// Maximum of a normalised integer, which represents 1.
fn unit_integer_of(kind: DataType) -> Option<f32> {
    use gltf::accessor::DataType as Kind;
    match kind {
        DataType::Int8 => unit_integer(Kind::I8),
        DataType::Uint8 | DataType::Bool => unit_integer(Kind::U8),
        DataType::Int16 => unit_integer(Kind::I16),
        DataType::Uint16 => unit_integer(Kind::U16),
        DataType::Uint32 => unit_integer(Kind::U32),
        _ => None,
    }
}

fn fail(message: String, path: &Path, place: &str) -> LoadError {
    LoadErrorKind::Syntax(message).at(path, format!("{place}.extensions.{NAME}"))
}
