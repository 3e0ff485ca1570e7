//! Polygons and patches of one fill.
//!
//! Few opaque polygons become shapes of their own, with corners in f64. More of them become one mesh, with a few dozen bytes
//! per triangle instead of some hundred per node. Its coordinates are rounded to f32, with one digit more than the six of NFF
//! files. Transparent polygons always become one mesh, because together they bound one solid. Corners at one position become
//! one vertex, so that closed surfaces stay closed.

use std::collections::HashMap;
use std::sync::Arc;

use rt_geometry::{Face, InsideRule, MeshData, MeshError, Polygon, PolygonError, Shape, Triangle};
use rt_math::{DVec3, Vec3};

use crate::error::{ErrorInLine, LineError};
use crate::text::tokenizer::{Tokenizer, Word};
use crate::{LoadErrorKind, limits};

/// Maximum number of polygons of a fill that become shapes of their own.
pub(super) const MAX_SHAPES: usize = 16;

/// The polygons, or the patches, of one fill.
#[derive(Debug, Default)]
pub(super) struct FaceList {
    corners: Vec<DVec3>,
    /// One for each corner of patches; empty for polygons.
    normals: Vec<DVec3>,
    /// End of each face in `corners`, and its first line.
    ends: Vec<(usize, usize)>,
}

impl FaceList {
    /// Reads a `p` statement, or `pp` with normals.
    pub(super) fn read(
        &mut self,
        tokens: &mut Tokenizer<'_>,
        line: usize,
        with_normals: bool,
    ) -> Result<(), LineError> {
        let before = (self.corners.len(), self.normals.len());
        let result = self.read_corners(tokens, with_normals);
        match result {
            Ok(()) => self.ends.push((self.corners.len(), line)),
            Err(_) => {
                self.corners.truncate(before.0);
                self.normals.truncate(before.1);
            }
        }
        result
    }

    fn read_corners(&mut self, tokens: &mut Tokenizer<'_>, with_normals: bool) -> Result<(), LineError> {
        let corners = corner_count(tokens)?;
        // No memory is reserved: the count may exceed the size of the file.
        for _ in 0..corners {
            self.corners.push(tokens.numbers("a coordinate of a corner")?.into());
            if with_normals {
                self.normals.push(tokens.numbers("a component of a normal")?.into());
            }
        }
        Ok(())
    }

    /// True without any face.
    pub(super) const fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The faces as shapes of their own, with their lines. What is no flat polygon is left, and so is everything that
    /// is better off in a mesh.
    pub(super) fn take_shapes(&mut self, transparent: bool) -> Vec<(usize, Shape)> {
        let too_many = if transparent { self.ends.len() > 1 } else { self.ends.len() > MAX_SHAPES };
        if too_many || !self.normals.is_empty() {
            return Vec::new();
        }
        let mut shapes = Vec::new();
        let mut rest = Self::default();
        for (outline, line) in self.outlines() {
            match shape(outline) {
                Ok(shape) => shapes.push((line, shape)),
                Err(_) => {
                    rest.corners.extend_from_slice(outline);
                    rest.ends.push((rest.corners.len(), line));
                }
            }
        }
        *self = rest;
        shapes
    }

    fn outlines(&self) -> impl Iterator<Item = (&[DVec3], usize)> {
        let starts = std::iter::once(0).chain(self.ends.iter().map(|(end, _)| *end));
        starts.zip(&self.ends).map(|(start, &(end, line))| (&self.corners[start..end], line))
    }

    /// The arrays of a mesh of all faces, cut into triangles.
    pub(super) fn mesh_data(&self) -> Result<MeshData, MeshError> {
        let mut vertices = UniqueVertices::default();
        let normal = |i: usize| self.normals.get(i).map_or(Vec3::ZERO, |n| n.as_vec3());
        let indices: Vec<u32> =
            self.corners.iter().enumerate().map(|(i, corner)| vertices.index(corner.as_vec3(), normal(i))).collect();
        let starts = std::iter::once(0).chain(self.ends.iter().map(|(end, _)| *end));
        let faces = starts.zip(&self.ends).map(|(start, &(end, _))| Face { outline: &indices[start..end], holes: &[] });
        let data = MeshData::from_polygons(vertices.positions, faces)?;
        let normals = if self.normals.is_empty() { Vec::new() } else { vertices.normals };
        Ok(MeshData { normals, ..data })
    }
}

/// Vertices, each once.
#[derive(Default)]
struct UniqueVertices {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    known: HashMap<[u32; 6], u32>,
}

impl UniqueVertices {
    fn index(&mut self, position: Vec3, normal: Vec3) -> u32 {
        // 0 and −0 are equal.
        let [[x, y, z], [u, v, w]] = [position, normal].map(|v| v.to_array().map(|c| (c + 0.0).to_bits()));
        *self.known.entry([x, y, z, u, v, w]).or_insert_with(|| {
            self.positions.push(position);
            self.normals.push(normal);
            self.positions.len() as u32 - 1
        })
    }
}

fn corner_count(tokens: &mut Tokenizer<'_>) -> Result<usize, LineError> {
    let line = tokens.peek_word().map_or(0, |Word { line, .. }| line);
    let count = tokens.number("the number of corners")?;
    if count.fract() != 0.0 || count < 3.0 {
        return Err(LineError::new(line, count, "is not a number of corners: a polygon has 3 or more"));
    }
    // The conversion saturates beyond the range of u64.
    let (what, limit) = ("the number of corners of a polygon", limits::FACE_CORNERS as u64);
    LoadErrorKind::check_limit(what, count as u64, limit).in_line(line)?;
    Ok(count as usize)
}

fn shape(outline: &[DVec3]) -> Result<Shape, PolygonError> {
    if let [a, b, c] = *outline {
        return Ok(Shape::Triangle(Triangle::new([a, b, c])?));
    }
    let polygon = |rule| Polygon::new(outline.to_vec(), Vec::new(), rule);
    let polygon = match polygon(InsideRule::Convex) {
        Err(PolygonError::NotConvex { .. }) => polygon(InsideRule::Winding),
        other => other,
    };
    Ok(Shape::Polygon(Arc::new(polygon?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces(texts: &[&str], with_normals: bool) -> FaceList {
        let mut faces = FaceList::default();
        for (i, text) in texts.iter().enumerate() {
            faces.read(&mut Tokenizer::words(text), i + 1, with_normals).map_err(|error| error.kind).expect("a face");
        }
        faces
    }

    #[test]
    fn few_faces_are_shapes_and_bent_ones_go_to_a_mesh() {
        let square = "4  0 0 0  1 0 0  1 1 0  0 1 0";
        let dart = "4  0 0 0  2 0 0  0.5 0.5 0  0 2 0";
        let bent = "4  0 0 0  1 0 0  1 1 0.1  0 1 0";
        let mut few = faces(&[square, dart, bent, "3 0 0 0 1 0 0 0 1 0"], false);
        let shapes = few.take_shapes(false);
        let lines: Vec<_> = shapes.iter().map(|(line, _)| *line).collect();
        assert_eq!(lines, [1, 2, 4]);
        let rule = |shape: &Shape| if let Shape::Polygon(polygon) = shape { Some(polygon.rule()) } else { None };
        let rules: Vec<_> = shapes.iter().map(|(_, shape)| rule(shape)).collect();
        assert_eq!(rules, [Some(InsideRule::Convex), Some(InsideRule::Winding), None]);
        assert_eq!(few.mesh_data().expect("a mesh").triangles.len(), 2);
        assert_eq!(few.outlines().map(|(_, line)| line).collect::<Vec<_>>(), [3]);

        assert!(faces(&[square; MAX_SHAPES + 1], false).take_shapes(false).is_empty());
        assert!(faces(&[square; 2], false).take_shapes(true).is_empty(), "the walls of one body");
        assert_eq!(faces(&[square], false).take_shapes(true).len(), 1);
    }

    #[test]
    fn corners_at_one_place_are_one_vertex() {
        let data = faces(&["3 0 0 0 1 0 0 0 1 0", "3 1 0 -0 0 1 0 1 1 0"], false).mesh_data().expect("a mesh");
        assert_eq!((data.positions.len(), data.normals.len()), (4, 0));
        let smooth =
            faces(&["3 0 0 0 0 0 1  1 0 0 0 0 1  0 1 0 0 0 1", "3 1 0 0 1 0 0  0 1 0 0 0 1  1 1 0 0 0 1"], true);
        let data = smooth.mesh_data().expect("a mesh");
        assert_eq!((data.positions.len(), data.normals.len()), (5, 5), "(1, 0, 0) has two normals");
        assert_eq!(data.normals[3], Vec3::X);
    }

    #[test]
    fn numbers_of_corners_are_checked_before_anything_is_allocated() {
        let refused = |text: &str| {
            let mut faces = FaceList::default();
            let error = faces.read(&mut Tokenizer::words(text), 1, false).expect_err("refused");
            assert!(faces.is_empty() && faces.corners.is_empty());
            error.kind.to_string()
        };
        assert_eq!(refused("2 0 0 0 1 1 1"), "2 is not a number of corners: a polygon has 3 or more");
        assert_eq!(refused("3.5"), "3.5 is not a number of corners: a polygon has 3 or more");
        assert!(refused("4000000000 0 0 0").ends_with("is 4000000000, above the limit of 100000"));
        assert!(refused("99999 0 0 0 1").contains("the end of the file comes before a coordinate of a corner"));
    }
}
