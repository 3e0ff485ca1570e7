//! Primitives of meshes as arrays of triangles.

use gltf::{
    Primitive, Semantic,
    mesh::Mode,
    texture::{Info, TextureTransform},
};
use rt_geometry::{MeshData, fan, strip};
use rt_math::{Vec3, transcendental::sincos};

use super::{
    accessor::{read_indices, read_vectors},
    buffers::Buffers,
};
use crate::{LoadError, Reason};

/// Where a material's textures are read: a set of texture coordinates, and a map applied to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvSource {
    set: u32,
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
}

impl UvSource {
    /// The source of one texture, with KHR_texture_transform.
    pub(super) fn of(texture: &Info<'_>) -> Self {
        let transform = texture.texture_transform();
        let (offset, rotation, scale) =
            transform.as_ref().map_or(([0.0; 2], 0.0, [1.0; 2]), |t| (t.offset(), t.rotation(), t.scale()));
        let set = transform.as_ref().and_then(TextureTransform::tex_coord).unwrap_or_else(|| texture.tex_coord());
        Self { set, offset, rotation, scale }
    }

    /// Maps coordinates of the file, with v downwards, to ours, with v upwards: first the scale, then the rotation,
    /// counter-clockwise as seen in the image, then the offset.
    fn map(&self, uvs: &[[f32; 2]]) -> Vec<[f32; 2]> {
        let (sin, cos) = sincos(f64::from(self.rotation));
        let [scale_u, scale_v] = self.scale.map(f64::from);
        let [offset_u, offset_v] = self.offset.map(f64::from);
        let map = |uv: &[f32; 2]| {
            let (u, v) = (f64::from(uv[0]) * scale_u, f64::from(uv[1]) * scale_v);
            let (u, v) = (cos * u + sin * v + offset_u, cos * v - sin * u + offset_v);
            [u as f32, (1.0 - v) as f32]
        };
        uvs.iter().map(map).collect()
    }
}

/// What a primitive holds.
pub(super) enum Content {
    /// Triangles, and what was left out of them.
    Triangles(MeshData, Vec<&'static str>),
    /// Points or lines, which have no surface.
    NoSurface,
}

/// Reads the arrays of a primitive; texture coordinates only if a texture asks for them.
pub(super) fn read(
    primitive: &Primitive<'_>,
    uv_source: Option<UvSource>,
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
    let uvs = match uv_source {
        Some(source) => match primitive.get(&Semantic::TexCoords(source.set)) {
            Some(accessor) => source.map(&read_vectors::<2>(&accessor, buffers)?),
            None => {
                notes.push("its texture reads coordinates that the mesh does not have: one point is used everywhere");
                Vec::new()
            }
        },
        None => Vec::new(),
    };
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
    Ok(Content::Triangles(MeshData { positions, triangles, normals, uvs }, notes))
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
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn strips_and_fans_keep_their_orientation() {
        assert_eq!(assemble(Mode::TriangleStrip, &[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(assemble(Mode::TriangleFan, &[9, 1, 2, 3]), [[1, 2, 9], [2, 3, 9]]);
        assert_eq!(assemble(Mode::Triangles, &[0, 1, 2, 3]), [[0, 1, 2]]);
        for mode in [Mode::TriangleStrip, Mode::TriangleFan, Mode::Triangles, Mode::Points] {
            assert_eq!(assemble(mode, &[]), [[0; 3]; 0]);
        }
    }

    #[test]
    fn texture_coordinates_are_scaled_turned_moved_and_flipped() {
        let source = UvSource { set: 0, offset: [0.5, 0.25], rotation: FRAC_PI_2, scale: [2.0, 4.0] };
        // (1, 0) · scale = (2, 0); a quarter turn counter-clockwise, with v downwards, takes it to (0, −2).
        let [u, v] = source.map(&[[1.0, 0.0]])[0];
        assert!((u - 0.5).abs() < 1e-6 && (v - 2.75).abs() < 1e-6, "{u} {v}");
        let plain = UvSource { set: 0, offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] };
        assert_eq!(plain.map(&[[0.25, 0.25]]), [[0.25, 0.75]]);
    }
}
