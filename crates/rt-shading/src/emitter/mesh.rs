//! Meshes that shine.

use super::distribution::{accumulate, find, probability};
use super::sample::{by_solid_angle, density};
use super::solid_angle::{self, MIN_SPHERICAL};
use super::{Emission, EmitterBounds, EmitterError, EmitterPoint, EmitterSample, Sides};
use rt_geometry::{ShapeError, Triangle};
use rt_math::{Aabb, DVec3, Interval, Ray, Rgb, ShearedRay};

/// A set of triangles. One of them is chosen in proportion to its area; within it, directions are uniform by solid angle
/// (Arvo 1995), or points by area where the triangle subtends less than 2⁻¹⁴ sr.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshLight {
    faces: Vec<Face>,
    /// Running sums of the areas of the faces.
    areas: Vec<f64>,
    area: f64,
    around: Aabb,
    emission: Emission,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    vertices: [DVec3; 3],
    /// Unit normal, and zero without area.
    normal: DVec3,
    area: f64,
}

impl MeshLight {
    /// The light over triangles in world space, whose fronts are where their vertices run counter-clockwise. Triangles
    /// without area are kept, so that numbers stay, and are never chosen.
    ///
    /// # Errors
    /// If all of them have no area together, or a coordinate is not finite.
    pub fn new(triangles: impl IntoIterator<Item = [DVec3; 3]>, emission: Emission) -> Result<Self, EmitterError> {
        let faces = triangles.into_iter().map(Face::new).collect::<Result<Vec<_>, _>>()?;
        let mut areas: Vec<f64> = faces.iter().map(|face| face.area).collect();
        let area = accumulate(&mut areas);
        if area == 0.0 {
            return Err(EmitterError::BadArea(faces.iter().map(|face| face.area).sum()));
        }
        let around = Aabb::from_points(faces.iter().flat_map(|face| face.vertices));
        Ok(Self { faces, areas, area, around, emission })
    }

    /// The area of one side of all triangles.
    pub const fn area(&self) -> f64 {
        self.area
    }

    /// What the surface emits.
    pub const fn emission(&self) -> &Emission {
        &self.emission
    }

    /// A direction towards a point of the mesh. `None` if its triangle is seen from behind or edge-on. The mesh may hide the
    /// point from itself, as anything else may.
    pub fn sample(&self, point: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let (index, rest) = find(&self.areas, u[0])?;
        let face = self.faces.get(index)?;
        let height = (face.vertices[0] - point).dot(face.normal);
        let radiance = self.emission.seen(height);
        if radiance.is_black() {
            return None;
        }
        let on_light = face.sample(point, height, [rest, u[1]]);
        let at = EmitterPoint { point: on_light, normal: face.normal, triangle: u32::try_from(index).ok()? };
        let extent = self.around.extent().max_element();
        EmitterSample::of_surface(point, &at, extent, radiance, self.pdf_at(point, on_light, at.triangle))
    }

    /// Density, per unit solid angle, with which [`sample`](Self::sample) takes the direction from `point` to a point of the
    /// given triangle. 0 where that is not seen, and for triangles that are not there.
    pub fn pdf_at(&self, point: DVec3, on_light: DVec3, triangle: u32) -> f64 {
        let Some(face) = self.faces.get(triangle as usize) else { return 0.0 };
        let height = (face.vertices[0] - point).dot(face.normal);
        if self.emission.seen(height).is_black() {
            return 0.0;
        }
        density(probability(&self.areas, triangle as usize) * face.pdf(point, height, on_light))
    }

    /// Density, per unit solid angle, with which [`sample`](Self::sample) takes the point that is first met in this
    /// direction; 0 for one that passes by. All triangles are tested: whoever has the hit calls [`pdf_at`](Self::pdf_at).
    pub fn pdf(&self, point: DVec3, direction: DVec3) -> f64 {
        self.intersect(point, direction).map_or(0.0, |at| self.pdf_at(point, at.point, at.triangle))
    }

    /// Where a ray from `point` meets the mesh first, from either side. All triangles are tested.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<EmitterPoint> {
        let ray = ShearedRay::new(&Ray::new(point, direction));
        let mut nearest = None;
        let mut span = Interval::SPAWNED;
        for (face, triangle) in self.faces.iter().zip(0u32..) {
            let Some(hit) = ray.intersect(face.vertices, span) else { continue };
            if face.area > 0.0 && (nearest.is_none() || hit.t < span.max) {
                span.max = hit.t;
                nearest = Some(EmitterPoint { point: point + direction * hit.t, normal: face.normal, triangle });
            }
        }
        nearest
    }

    /// Radiance of the light for one who looks along `direction` at it.
    pub fn radiance(&self, direction: DVec3, normal: DVec3) -> Rgb {
        self.emission.seen(direction.dot(normal))
    }

    /// Power of all sides that shine.
    pub fn power(&self) -> Rgb {
        self.emission.power(self.area)
    }

    /// Where the light is and where it shines.
    pub fn bounds(&self) -> Option<EmitterBounds> {
        if self.emission.sides() == Sides::Both {
            return Some(EmitterBounds::all_around(self.around, self.power()));
        }
        let shining = self.faces.iter().filter(|face| face.area > 0.0);
        let bounds = |face: &Face| {
            let around = Aabb::from_points(face.vertices);
            EmitterBounds::of_flat(around, face.normal, &self.emission, face.area)
        };
        shining.map(bounds).reduce(|a, b| a.union(&b))
    }
}

impl Face {
    fn new(vertices: [DVec3; 3]) -> Result<Self, ShapeError> {
        match Triangle::new(vertices) {
            Ok(_) => {}
            Err(ShapeError::NoArea(_)) => return Ok(Self { vertices, normal: DVec3::ZERO, area: 0.0 }),
            Err(error) => return Err(error),
        }
        let [a, b, c] = vertices;
        let area = (b - a).cross(c - a);
        // Scaled first: the square of a small area underflows.
        let scale = area.abs().max_element();
        let normal = (area / scale).normalize_or_zero();
        let area = if normal == DVec3::ZERO { 0.0 } else { 0.5 * area.dot(normal) };
        Ok(Self { vertices, normal, area })
    }

    fn solid_angle(&self, point: DVec3, height: f64) -> f64 {
        solid_angle::of_triangle(self.vertices.map(|vertex| vertex - point), height, 2.0 * self.area)
    }

    fn sample(&self, point: DVec3, height: f64, u: [f64; 2]) -> DVec3 {
        let corners = self.vertices.map(|vertex| vertex - point);
        let solid_angle = self.solid_angle(point, height);
        let [a, b, c] = self.vertices;
        let (mut v, mut w) = if solid_angle >= MIN_SPHERICAL {
            let direction = solid_angle::sample_triangle(corners, solid_angle, u);
            let offset = direction * (height / direction.dot(self.normal)) - corners[0];
            let across = 0.5 / self.area * self.normal;
            (offset.cross(c - a).dot(across), (b - a).cross(offset).dot(across))
        } else {
            let root = u[0].sqrt();
            (root * (1.0 - u[1]), root * u[1])
        };
        // Rounding may put a point next to an edge beyond it.
        v = v.clamp(0.0, 1.0);
        w = w.max(0.0).min(1.0 - v);
        a + (b - a) * v + (c - a) * w
    }

    fn pdf(&self, point: DVec3, height: f64, on_light: DVec3) -> f64 {
        let solid_angle = self.solid_angle(point, height);
        if solid_angle >= MIN_SPHERICAL {
            return 1.0 / solid_angle;
        }
        by_solid_angle(1.0 / self.area, on_light - point, height)
    }
}
