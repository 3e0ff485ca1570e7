//! Shapes of the file to shapes and meshes of the scene.

use std::sync::Arc;

use rt_geometry::{
    CappedQuadric, Cuboid, Disk, Face, InfiniteQuadric, MeshData, Plane, Polygon, PolygonError, Rectangle, Shape,
    Sphere, Torus, Triangle, TriangleMesh,
};
use rt_math::{DVec3, Vec3};

use crate::build_mesh::build_mesh;
use crate::format;
use crate::{LoadErrorKind, Warning};

/// Shape or mesh of the scene.
pub(super) enum ResolvedShape {
    Shape(Shape),
    /// `None` if no triangle was left.
    Mesh(Option<TriangleMesh>),
}

/// Builds the shape or mesh; `place` locates warnings about repairs.
pub(super) fn resolve_shape(
    shape: &format::Shape,
    place: &str,
    warnings: &mut Vec<Warning>,
) -> Result<ResolvedShape, LoadErrorKind> {
    let mut mesh = |data| checked_mesh(data, place, warnings).map(ResolvedShape::Mesh);
    let point = DVec3::from;
    let shape = match shape {
        format::Shape::Sphere { center, radius } => Shape::Sphere(Sphere::new(point(*center), *radius)?),
        format::Shape::Box { min, max } => Shape::Cuboid(Cuboid::new(point(*min), point(*max))?),
        format::Shape::Plane { point: on, normal } => Shape::Plane(Plane::new(point(*on), point(*normal))?),
        format::Shape::Cylinder { radius, bottom, top, caps } => {
            Shape::Cylinder(CappedQuadric::cylinder(*radius, *bottom, *top, *caps)?)
        }
        format::Shape::InfiniteCylinder { radius } => Shape::InfiniteCylinder(InfiniteQuadric::cylinder(*radius)?),
        format::Shape::DoubleCone { slope } => Shape::DoubleCone(InfiniteQuadric::double_cone(*slope)?),
        format::Shape::Cone { radius, height, caps } => Shape::Cone(CappedQuadric::cone(*radius, *height, *caps)?),
        format::Shape::Frustum { bottom_radius, top_radius, height, caps } => {
            Shape::Frustum(CappedQuadric::frustum(*bottom_radius, *top_radius, *height, *caps)?)
        }
        format::Shape::Disk { radius, inner_radius } => Shape::Disk(Disk::new(*radius, *inner_radius)?),
        format::Shape::Rectangle { width, depth } => Shape::Rectangle(Rectangle::new(*width, *depth)?),
        format::Shape::Torus { radius, tube_radius } => Shape::Torus(Torus::new(*radius, *tube_radius)?),
        format::Shape::Triangle(a, b, c) => Shape::Triangle(Triangle::new([*a, *b, *c].map(DVec3::from))?),
        format::Shape::Quad(a, b, c, d) => {
            return mesh(MeshData {
                positions: [*a, *b, *c, *d].map(Into::into).to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
                ..MeshData::default()
            });
        }
        format::Shape::Polygon { points, holes, rule } => Shape::Polygon(Arc::new(polygon(points, holes, *rule)?)),
        format::Shape::Strip(points) => return mesh(MeshData::from_strip(positions("the strip", points)?).0),
        format::Shape::Fan(points) => return mesh(MeshData::from_fan(positions("the fan", points)?).0),
        format::Shape::Mesh { positions, triangles, faces, normals, uvs } => {
            let faces = faces.iter().map(|outline| Face { outline, holes: &[] });
            let mut data = MeshData::from_polygons(positions.iter().map(|&p| p.into()).collect(), faces)?;
            data.triangles.splice(..0, triangles.iter().copied());
            data.normals = normals.iter().map(|&n| n.into()).collect();
            data.uvs = uvs.clone();
            return mesh(data);
        }
    };
    Ok(ResolvedShape::Shape(shape))
}

fn polygon(points: &[[f64; 3]], holes: &[Vec<[f64; 3]>], rule: format::InsideRule) -> Result<Polygon, PolygonError> {
    let ring = |points: &[[f64; 3]]| points.iter().map(|&p| DVec3::from(p)).collect();
    Polygon::new(ring(points), holes.iter().map(|hole| ring(hole)).collect(), rule.into())
}

/// The points of a strip or fan.
fn positions(what: &str, points: &[[f32; 3]]) -> Result<Vec<Vec3>, LoadErrorKind> {
    if points.len() < 3 {
        let points = match points.len() {
            1 => "1 point".to_owned(),
            count => format!("{count} points"),
        };
        return Err(LoadErrorKind::invalid(what, format!("has {points}; it needs at least 3")));
    }
    Ok(points.iter().map(|&p| p.into()).collect())
}

fn checked_mesh(
    data: MeshData,
    place: &str,
    warnings: &mut Vec<Warning>,
) -> Result<Option<TriangleMesh>, LoadErrorKind> {
    if data.triangles.is_empty() {
        return Err(LoadErrorKind::invalid("the mesh", "has no triangles: give at least one"));
    }
    // Repairs are for model files; in a scene file, such values are errors.
    if let Some((index, vertex)) = data.positions.iter().enumerate().find(|(_, vertex)| !vertex.is_finite()) {
        let [x, y, z] = vertex.to_array();
        let rule = if vertex.is_nan() {
            "must have finite coordinates"
        } else {
            "has a coordinate beyond 3.4e38, the limit of the single precision in which vertices of meshes are stored"
        };
        return Err(LoadErrorKind::invalid(format_args!("vertex {index} at ({x}, {y}, {z})"), rule));
    }
    Ok(build_mesh(data, place, warnings)?)
}
