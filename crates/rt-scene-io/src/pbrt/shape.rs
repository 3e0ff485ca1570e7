//! Shapes in their own space, +z up for those of revolution.
//!
//! ```text
//! sphere disk cylinder           exact shapes, turned so that our +y is the file's +z and `u` begins at its +x
//! trianglemesh plymesh           meshes
//! bilinearmesh loopsubdiv        meshes of the corners: two triangles for each patch, and the control mesh
//! ```

use std::sync::Arc;

use rt_geometry::{CappedQuadric, Disk, MeshData, Shape, Sphere};
use rt_math::{DMat3, DVec3, Transform, Vec3};

use super::file_scope::FileScope;
use super::parameters::{Parameters, unknown};
use crate::error::{ErrorInLine, LineError};
use crate::unshare::unshare;
use crate::{LoadError, LoadErrorKind, ply, resolve_path};

/// Known kinds of shapes.
const KINDS: [&str; 8] =
    ["sphere", "disk", "cylinder", "trianglemesh", "plymesh", "bilinearmesh", "loopsubdiv", "curve"];

/// Object of the scene.
#[derive(Debug)]
pub(super) enum PbrtShape {
    /// A shape, and its transform to the space of the file.
    Exact(Shape, Transform),
    Mesh(MeshData),
    /// A shape that only other programs have.
    Unsupported,
}

/// Error of a directive: in its line, or in a file that it refers to.
#[derive(Debug)]
pub(super) enum DirectiveError {
    Line(LineError),
    File(LoadError),
}

impl From<LineError> for DirectiveError {
    fn from(error: LineError) -> Self {
        Self::Line(error)
    }
}

/// Reads a shape of this kind, with its front on the other side if it is `reversed`. A mesh without texture coordinates
/// gets those of pbrt-v4 if it `needs_uvs`.
pub(super) fn read(
    kind: &str,
    parameters: &Parameters,
    reversed: bool,
    needs_uvs: bool,
    files: FileScope<'_>,
    warnings: &mut Vec<String>,
) -> Result<PbrtShape, DirectiveError> {
    let mut data = match kind {
        "sphere" | "disk" | "cylinder" => return Ok(exact(kind, parameters, reversed, warnings)?),
        "trianglemesh" => triangles(parameters, needs_uvs)?,
        "loopsubdiv" => {
            parameters.pass_over(&["levels"]);
            warnings.push("a subdivision surface is not smoothed: its control mesh is seen".to_owned());
            triangles(parameters, needs_uvs)?
        }
        "bilinearmesh" => patches(parameters, needs_uvs, warnings)?,
        "plymesh" => return ply_mesh(parameters, reversed, needs_uvs, files, warnings),
        "curve" => return Ok(PbrtShape::Unsupported),
        other => return Err(unknown("shape", other, parameters.line, KINDS).into()),
    };
    face(&mut data, reversed);
    Ok(PbrtShape::Mesh(data))
}

fn exact(kind: &str, p: &Parameters, reversed: bool, warnings: &mut Vec<String>) -> Result<PbrtShape, LineError> {
    let turned = |offset| Transform::from_linear(turn(), offset).unwrap_or(Transform::IDENTITY);
    if p.float("phimax", 360.0)? != 360.0 {
        warnings.push(format!("the {kind} is closed all around, without regard to \"phimax\""));
    }
    let radius = p.positive("radius", 1.0)?;
    if reversed && kind != "disk" {
        warnings.push(format!("the {kind} faces outwards, without regard to `ReverseOrientation`"));
    }
    match kind {
        "sphere" => {
            if p.float("zmin", -radius)? > -radius || p.float("zmax", radius)? < radius {
                warnings.push("the sphere is whole, without regard to \"zmin\" and \"zmax\"".to_owned());
            }
            let sphere = Sphere::new(DVec3::ZERO, radius).in_line(p.line)?;
            Ok(PbrtShape::Exact(Shape::Sphere(sphere), turned(DVec3::ZERO)))
        }
        "disk" => {
            let disk = Disk::new(radius, p.not_negative("innerradius", 0.0)?).in_line(p.line)?;
            let place = turned(DVec3::Z * p.float("height", 0.0)?);
            // A half turn around x.
            let over = Transform::from_linear(DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)), DVec3::ZERO);
            let place = if reversed { place.compose(&over.unwrap_or(Transform::IDENTITY)) } else { place };
            Ok(PbrtShape::Exact(Shape::Disk(disk), place))
        }
        _ => {
            let (bottom, top) = (p.float("zmin", -1.0)?, p.float("zmax", 1.0)?);
            let cylinder = CappedQuadric::cylinder(radius, bottom.min(top), bottom.max(top), false).in_line(p.line)?;
            Ok(PbrtShape::Exact(Shape::Cylinder(cylinder), turned(DVec3::ZERO)))
        }
    }
}

/// Axes of shapes in the file: `u` of spheres begins at −z here and goes on to −x.
const fn turn() -> DMat3 {
    DMat3::from_cols(DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X)
}

/// Texture coordinates of the corners of a triangle without any.
const TRIANGLE_UVS: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];

/// Texture coordinates of the corners of a patch without any.
const PATCH_UVS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];

fn triangles(parameters: &Parameters, needs_uvs: bool) -> Result<MeshData, LineError> {
    let mut data = vertices(parameters)?;
    let indices = parameters.indices("indices", data.positions.len())?;
    // A single triangle needs no indices.
    let mut indices = if indices.is_empty() && data.positions.len() == 3 { vec![0, 1, 2] } else { indices };
    if indices.is_empty() || !indices.len().is_multiple_of(3) {
        let rule = "must be three for each triangle, and for one at least";
        return Err(LineError::new(parameters.line, format_args!("{} indices", indices.len()), rule));
    }
    if needs_uvs && data.uvs.is_empty() {
        lay_uvs(&mut data, &mut indices, TRIANGLE_UVS);
    }
    data.triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    Ok(data)
}

/// Gives each corner of the faces a vertex of its own, at the texture coordinates of this corner.
fn lay_uvs<const N: usize>(data: &mut MeshData, indices: &mut [u32], face_uvs: [[f32; 2]; N]) {
    unshare(data, indices);
    data.uvs = face_uvs.into_iter().cycle().take(indices.len()).collect();
    for (index, vertex) in indices.iter_mut().zip(0..) {
        *index = vertex;
    }
}

/// Two triangles for each patch, whose corners are at [`PATCH_UVS`].
fn patches(parameters: &Parameters, needs_uvs: bool, warnings: &mut Vec<String>) -> Result<MeshData, LineError> {
    let mut data = vertices(parameters)?;
    let indices = parameters.indices("indices", data.positions.len())?;
    let mut indices = if indices.is_empty() && data.positions.len() == 4 { vec![0, 1, 2, 3] } else { indices };
    if indices.is_empty() || !indices.len().is_multiple_of(4) {
        let rule = "must be four for each patch, and for one at least";
        return Err(LineError::new(parameters.line, format_args!("{} indices", indices.len()), rule));
    }
    // A single patch needs no further vertices.
    let is_single = indices.len() == 4 && data.positions.len() == 4;
    if (needs_uvs || is_single) && data.uvs.is_empty() {
        lay_uvs(&mut data, &mut indices, PATCH_UVS);
    }
    let mut bent = 0;
    for patch in indices.chunks_exact(4) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| data.positions[patch[i] as usize].as_dvec3());
        let volume = (b - a).dot((c - a).cross(d - a));
        let size = (b - a).length() * (c - a).length() * (d - a).length();
        bent += usize::from(volume.abs() > FLATNESS * size);
        let [a, b, c, d] = [patch[0], patch[1], patch[2], patch[3]];
        data.triangles.extend([[a, b, d], [a, d, c]]);
    }
    if bent > 0 {
        warnings.push(format!("{bent} bent patches became two flat triangles each"));
    }
    Ok(data)
}

/// The part of a cube that the corners of a patch may span before it is called bent: what rounding to `f32` brings.
const FLATNESS: f64 = 1e-5;

fn vertices(parameters: &Parameters) -> Result<MeshData, LineError> {
    let vectors = |triples: Vec<[f64; 3]>| triples.into_iter().map(|[x, y, z]| Vec3::new(x as f32, y as f32, z as f32));
    let positions: Vec<_> = vectors(parameters.triples("P", &["point3", "point"])?).collect();
    if positions.is_empty() {
        return Err(LineError::new(parameters.line, "a mesh", "has no \"point3 P\": add its vertices"));
    }
    let normals: Vec<_> = vectors(parameters.triples("N", &["normal", "normal3", "vector3"])?).collect();
    let uvs = parameters.numbers("uv", &["point2", "vector2", "float"])?;
    let uvs: Vec<_> = uvs.chunks_exact(2).map(|uv| [uv[0] as f32, uv[1] as f32]).collect();
    for (name, count) in [("N", normals.len()), ("uv", uvs.len())] {
        if count != 0 && count != positions.len() {
            let rule = format!("must be one for each of the {} vertices", positions.len());
            return Err(LineError::new(parameters.line, format_args!("{count} values of \"{name}\""), rule));
        }
    }
    Ok(MeshData { positions, normals, uvs, ..MeshData::default() })
}

/// Turns the triangles so that their fronts are where the format has them. Normals of the vertices decide, or else the
/// order of the corners, unless the orientation is reversed.
fn face(data: &mut MeshData, reversed: bool) {
    if reversed {
        data.normals.iter_mut().for_each(|normal| *normal = -*normal);
    }
    for triangle in &mut data.triangles {
        let [a, b, c] = triangle.map(|i| data.positions.get(i as usize).copied().unwrap_or_default());
        let normal = (b - a).cross(c - a);
        let along: f32 = triangle.iter().filter_map(|i| data.normals.get(*i as usize)).map(|n| n.dot(normal)).sum();
        let is_back = if data.normals.is_empty() { reversed } else { along < 0.0 };
        if is_back {
            triangle.swap(1, 2);
        }
    }
}

/// The mesh of a PLY file; its colours are not used.
fn ply_mesh(
    p: &Parameters,
    reversed: bool,
    needs_uvs: bool,
    files: FileScope<'_>,
    warnings: &mut Vec<String>,
) -> Result<PbrtShape, DirectiveError> {
    let Some(file) = p.word("filename", "string")? else {
        return Err(LineError::new(p.line, "a mesh of a PLY file", "has no \"string filename\": add it").into());
    };
    if !file.to_ascii_lowercase().ends_with(".ply") {
        let kind = LoadErrorKind::Unsupported(format!("`{file}`, which does not end in .ply,"));
        return Err(LineError { line: p.line, kind }.into());
    }
    let path = resolve_path(file, files.root_file, files.options).in_line(p.line)?;
    let load = if needs_uvs { ply::load_with_face_uvs } else { ply::load };
    let model = load(&path, files.options).map_err(DirectiveError::File)?;
    warnings.extend(model.warnings.into_iter().map(|warning| format!("{}: {}", warning.place, warning.message)));
    let Some(mesh) = model.meshes.into_iter().next() else { return Ok(PbrtShape::Unsupported) };
    let mut data = Arc::unwrap_or_clone(mesh.mesh).data().clone();
    data.colors = Vec::new();
    face(&mut data, reversed);
    Ok(PbrtShape::Mesh(data))
}
