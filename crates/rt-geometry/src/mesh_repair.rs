//! Validation and repair of meshes.

use crate::MeshData;
use crate::area::{area_vector, unit_normal};
use rt_math::{DVec3, Vec3};

/// Error of [`TriangleMesh::build`](crate::TriangleMesh::build): data of which no mesh can be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// A triangle has an invalid vertex index.
    #[error("triangle {triangle}: vertex index {vertex} is out of range: the mesh has {count} {}", if *count == 1 { "vertex" } else { "vertices" })]
    BadIndex {
        /// Index of the triangle.
        triangle: usize,
        /// Vertex index.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A face has an invalid vertex index.
    #[error("face {face}: vertex index {vertex} is out of range: the mesh has {count} {}", if *count == 1 { "vertex" } else { "vertices" })]
    BadCorner {
        /// Index of the face.
        face: usize,
        /// Vertex index.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A face whose outline or one of whose holes has fewer than three corners.
    #[error("face {face} has a ring of {count} corners: it needs at least 3")]
    TooFewCorners {
        /// Index of the face.
        face: usize,
        /// Number of corners of the ring.
        count: usize,
    },
    /// A face with too many corners.
    #[error("face {face} has {count} corners; it may have at most {limit}")]
    TooManyCorners {
        /// Index of the face.
        face: usize,
        /// Number of corners.
        count: usize,
        /// Maximum number.
        limit: usize,
    },
    /// The number of normals, texture coordinates, colours or tangents differs from that of positions.
    #[error("{count} {what} do not match {positions} positions; give one for each")]
    CountMismatch {
        /// "normals", "texture coordinates", "colours" or "tangents".
        what: &'static str,
        /// Actual number.
        count: usize,
        /// Expected number.
        positions: usize,
    },
    /// More than 2³² − 1 vertices or triangles.
    #[error("the mesh has more than 2^32 - 1 vertices or triangles; split it")]
    TooLarge,
}

/// Repairs of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshRepairs {
    /// Triangles without area (repeated or collinear vertices), dropped.
    pub degenerate: usize,
    /// Triangles with a NaN or infinite vertex, dropped.
    pub non_finite: usize,
    /// Zero or non-finite normals, replaced by the normal of a triangle at that vertex.
    pub bad_normals: usize,
    /// NaN or infinite texture coordinates, replaced by (0, 0).
    pub bad_uvs: usize,
    /// Colours with a NaN, infinite or negative part, replaced by opaque white.
    pub bad_colors: usize,
    /// Zero or non-finite tangents, set to zero: the normal map has no effect there.
    pub bad_tangents: usize,
}

/// Rejects arrays of inconsistent lengths, drops triangles that cannot be hit, and normalizes all normals.
pub(crate) fn repair(data: &mut MeshData) -> Result<MeshRepairs, MeshError> {
    check_counts(data)?;
    let mut repairs = MeshRepairs::default();
    drop_bad_triangles(data, &mut repairs);
    repair_normals(data, &mut repairs);
    let uvs = data.uvs.iter_mut().chain(&mut data.second_uvs);
    for uv in uvs.filter(|uv| !(uv[0].is_finite() && uv[1].is_finite())) {
        *uv = [0.0; 2];
        repairs.bad_uvs += 1;
    }
    for color in data.colors.iter_mut().filter(|color| !color.iter().all(|part| *part >= 0.0 && part.is_finite())) {
        *color = [1.0; 4];
        repairs.bad_colors += 1;
    }
    repair_tangents(data, &mut repairs);
    data.triangles.shrink_to_fit();
    Ok(repairs)
}

fn check_counts(data: &MeshData) -> Result<(), MeshError> {
    let count = data.positions.len();
    if u32::try_from(count.max(data.triangles.len())).is_err() {
        return Err(MeshError::TooLarge);
    }
    for (what, length) in [
        ("normals", data.normals.len()),
        ("texture coordinates", data.uvs.len()),
        ("texture coordinates", data.second_uvs.len()),
        ("colours", data.colors.len()),
        ("tangents", data.tangents.len()),
    ] {
        if length != 0 && length != count {
            return Err(MeshError::CountMismatch { what, count: length, positions: count });
        }
    }
    for (triangle, corners) in data.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= count) {
            return Err(MeshError::BadIndex { triangle, vertex, count });
        }
    }
    Ok(())
}

fn drop_bad_triangles(data: &mut MeshData, repairs: &mut MeshRepairs) {
    let positions = &data.positions;
    data.triangles.retain(|triangle| {
        let corners = triangle.map(|i| positions[i as usize]);
        if corners.iter().any(|corner| !corner.is_finite()) {
            repairs.non_finite += 1;
            return false;
        }
        let degenerate = area_vector(corners.map(|corner| corner.as_dvec3())) == DVec3::ZERO;
        repairs.degenerate += usize::from(degenerate);
        !degenerate
    });
}

/// Keeps the normals of unused vertices.
fn repair_normals(data: &mut MeshData, repairs: &mut MeshRepairs) {
    if data.normals.is_empty() {
        return;
    }
    for normal in &mut data.normals {
        *normal = normal.as_dvec3().normalize_or_zero().as_vec3();
    }
    for &triangle in &data.triangles {
        for vertex in triangle {
            let normal = &mut data.normals[vertex as usize];
            if *normal == Vec3::ZERO {
                let corners = triangle.map(|i| data.positions[i as usize].as_dvec3());
                *normal = unit_normal(corners).as_vec3();
                repairs.bad_normals += 1;
            }
        }
    }
}

/// Normalizes them, also those of unused vertices.
fn repair_tangents(data: &mut MeshData, repairs: &mut MeshRepairs) {
    for [x, y, z, side] in &mut data.tangents {
        let unit = Vec3::new(*x, *y, *z).as_dvec3().normalize_or_zero().as_vec3();
        repairs.bad_tangents += usize::from(unit == Vec3::ZERO);
        [*x, *y, *z] = unit.to_array();
        *side = if *side < 0.0 { -1.0 } else { 1.0 };
    }
}
