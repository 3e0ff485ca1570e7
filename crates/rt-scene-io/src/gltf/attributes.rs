//! The attributes of a primitive: from accessors, or from a compressed stream.

use gltf::{Primitive, Semantic};

use super::{
    accessor::{read_indices, read_some_vectors, read_vectors},
    buffers::Buffers,
    draco::DecodedPrimitive,
    used_vertices::UsedVertices,
};
use crate::error::ErrorAt;
use crate::{LoadError, LoadErrorKind};

/// Source of the attributes of a primitive.
pub(super) struct Attributes<'a> {
    primitive: &'a Primitive<'a>,
    buffers: &'a Buffers<'a>,
    place: &'a str,
    stream: Option<DecodedPrimitive>,
    /// `None` if all vertices are read.
    used: Option<UsedVertices>,
}

impl<'a> Attributes<'a> {
    /// Decodes the stream of a compressed primitive, unless it also has uncompressed positions. `is_deformed` primitives have all
    /// of their vertices.
    pub(super) fn of(
        primitive: &'a Primitive<'a>,
        buffers: &'a Buffers<'a>,
        place: &'a str,
        is_deformed: bool,
    ) -> Result<Self, LoadError> {
        let is_plain = |accessor: gltf::Accessor<'_>| accessor.view().is_some() || accessor.sparse().is_some();
        let plain = primitive.get(&Semantic::Positions).is_some_and(is_plain);
        let stream = if plain { None } else { DecodedPrimitive::of(primitive, buffers, place)? };
        let used = if plain && !is_deformed { UsedVertices::of(primitive, buffers) } else { None };
        Ok(Self { primitive, buffers, place, stream, used })
    }

    /// Vectors of `N` components; `None` if the primitive does not have the attribute.
    pub(super) fn vectors<const N: usize>(&self, semantic: &Semantic) -> Result<Option<Vec<[f32; N]>>, LoadError> {
        let Some(accessor) = self.primitive.get(semantic) else { return Ok(None) };
        if let Some(stream) = &self.stream {
            let name = semantic.to_string();
            let found = stream.vectors(&name, accessor.normalized(), self.buffers.path(), self.place)?;
            if found.is_some() {
                return Ok(found);
            }
        }
        let Some(used) = &self.used else { return read_vectors(&accessor, self.buffers).map(Some) };
        if accessor.count() != used.all {
            let rule = format!("elements of an attribute do not fit {} positions", used.all);
            return Err(LoadErrorKind::invalid(accessor.count(), rule).at(self.buffers.path(), self.place));
        }
        read_some_vectors(&accessor, Some(&used.vertices), self.buffers).map(Some)
    }

    /// Colours with alpha, which is 1 where the file has none.
    pub(super) fn colours(&self) -> Result<Vec<[f32; 4]>, LoadError> {
        let semantic = Semantic::Colors(0);
        let Some(accessor) = self.primitive.get(&semantic) else { return Ok(Vec::new()) };
        let in_stream = self.stream.as_ref().and_then(|stream| stream.components(&semantic.to_string()));
        if in_stream.unwrap_or_else(|| accessor.dimensions().multiplicity()) == 3 {
            let colours = self.vectors::<3>(&semantic)?.unwrap_or_default();
            return Ok(colours.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect());
        }
        Ok(self.vectors::<4>(&semantic)?.unwrap_or_default())
    }

    /// Vertex indices of the primitive, which has `count` vertices.
    pub(super) fn order(&self, count: usize) -> Result<Vec<u32>, LoadError> {
        if let Some(used) = &self.used {
            return Ok(used.order.clone());
        }
        match (&self.stream, self.primitive.indices()) {
            (Some(stream), _) => Ok(stream.indices()),
            (None, Some(accessor)) => read_indices(&accessor, self.buffers),
            (None, None) => {
                let checked = LoadErrorKind::check_limit("the number of vertices", count as u64, u32::MAX.into());
                checked.at(self.buffers.path(), self.place)?;
                Ok((0..count as u32).collect())
            }
        }
    }
}
