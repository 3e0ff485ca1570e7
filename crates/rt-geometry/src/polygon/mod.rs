//! Flat polygons with any number of corners and holes.

mod inside;
mod outline;
#[cfg(test)]
mod tests;

pub use inside::InsideRule;
pub use outline::PolygonError;

use crate::{InteractionFlags, Plane, ShapeHit, SurfaceInteraction, WatertightRay, area::polygon_area_vector};
use outline::Flatness;
use rt_math::{Aabb, DVec3, Frame, Interval, Ray, Transform};

/// A flat polygon: an outline and holes in it. Its front is the side from which the outline runs counter-clockwise.
///
/// The intersection with the plane of the polygon gives `t`. The inside test does not use that rounded point, but the
/// ray. All corners are mapped as [`WatertightRay`] maps those of triangles. The [`InsideRule`] locates the origin of
/// the image with exact signs. Polygons and triangles with common corners in one space share their image. So no ray
/// passes between them, at edges or at corners, for any tilt.
///
/// Corners may lie off the plane by a millionth of the diameter. They are projected on it for `t` and the surface, but
/// not for the inside test, which avoids gaps to the neighbours.
///
/// The texture coordinates run from 0 to 1 along the tangents of [`Frame::from_z`] of the normal: x and y for a polygon
/// that faces +z. They cover the smallest box with such sides around the outline and holes.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    vertices: Box<[DVec3]>,
    /// End of each ring in `vertices`: the outline, then the holes.
    ring_ends: Box<[usize]>,
    rule: InsideRule,
    plane: Plane,
    /// True if corners lie off the plane by more than rounding.
    bent: bool,
    bounds: Aabb,
    uv_min: [f64; 2],
    uv_size: [f64; 2],
}

impl Polygon {
    /// The polygon with this outline and these holes. Rings are closed: the last corner is joined to the first.
    ///
    /// Outline and holes may have either orientation and may cross themselves where the rule allows it. Under
    /// [`InsideRule::Winding`] each hole is oriented against the outline, so that it is left out.
    ///
    /// # Errors
    /// If a ring has fewer than three corners, a number is not finite or too large, the outline has no area, a corner
    /// lies off the plane by more than a millionth of the diameter (that of the box of all corners), or the polygon is
    /// concave or has holes under [`InsideRule::Convex`].
    pub fn new(outline: Vec<DVec3>, holes: Vec<Vec<DVec3>>, rule: InsideRule) -> Result<Self, PolygonError> {
        outline::check_rings(&outline, &holes)?;
        let area = polygon_area_vector(&outline).ok_or(PolygonError::NoArea)?;
        // Scaled first: the square of a small area underflows.
        let plane = Plane::new(outline[0], area / area.abs().max_element())?;
        let (mut vertices, mut ring_ends) = (outline, Vec::with_capacity(1 + holes.len()));
        ring_ends.push(vertices.len());
        if rule == InsideRule::Convex {
            outline::check_convex(&vertices, &holes, plane.normal())?;
        }
        for mut hole in holes {
            if rule == InsideRule::Winding && polygon_area_vector(&hole).is_some_and(|hole| hole.dot(area) > 0.0) {
                hole.reverse();
            }
            vertices.extend(hole);
            ring_ends.push(vertices.len());
        }
        let bent = outline::flatness(&vertices, &plane)? == Flatness::Bent;
        let (uv_min, uv_size) = extent_along_tangents(&vertices, &plane);
        let (vertices, ring_ends) = (vertices.into(), ring_ends.into());
        let mut polygon = Self { vertices, ring_ends, rule, plane, bent, bounds: Aabb::EMPTY, uv_min, uv_size };
        polygon.bounds = Aabb::from_points(polygon.extremes());
        Ok(polygon)
    }

    /// The corners of the outline, then those of each hole, as they were given but for the direction of holes.
    pub fn rings(&self) -> impl Iterator<Item = &[DVec3]> {
        let starts = std::iter::once(0).chain(self.ring_ends.iter().copied());
        starts.zip(&self.ring_ends).map(|(start, &end)| &self.vertices[start..end])
    }

    /// Inside rule.
    pub const fn rule(&self) -> InsideRule {
        self.rule
    }

    /// The unit normal.
    pub const fn normal(&self) -> DVec3 {
        self.plane.normal()
    }

    /// The smallest box around the corners and, where they lie off the plane by more than rounding, their projections.
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Size in bytes.
    pub fn memory(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.vertices) + size_of_val(&*self.ring_ends)
    }

    /// Polygon under a map, with the image of its front; `None` if rounding bends it.
    pub(crate) fn mapped(&self, map: &Transform) -> Option<Self> {
        let mut rings = self.rings().map(|ring| {
            let mut ring: Vec<DVec3> = ring.iter().map(|v| map.point(*v)).collect();
            if map.flips_handedness() {
                ring.reverse();
            }
            ring
        });
        Self::new(rings.next()?, rings.collect(), self.rule).ok()
    }

    /// Support function: the largest dot product of a direction with a point of the polygon.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.extremes().map(|v| v.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Points whose convex hull contains all hits.
    fn extremes(&self) -> impl Iterator<Item = DVec3> {
        let Self { plane, bent, .. } = self;
        let foot = |v: &DVec3| *v - plane.normal() * plane.normal().dot(*v - plane.point());
        let feet = self.vertices.iter().filter(|_| *bent).map(foot);
        self.vertices.iter().copied().chain(feet)
    }

    /// Intersection from either side; `None` on a miss, for rays parallel to the plane, and for rays without a
    /// direction. Takes linear time in the number of corners.
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let hit = self.plane.intersect(ray, span)?;
        self.rule.is_inside(self.rings(), &WatertightRay::new(ray)).then_some(hit)
    }

    /// Corners of a flat polygon of four under [`InsideRule::Convex`]; `None` for all others. A ray that crosses the
    /// [plane](Self::plane), and passes all edges on the same side, is inside.
    pub fn convex_quadrilateral(&self) -> Option<[DVec3; 4]> {
        let is_flat_and_convex = self.rule == InsideRule::Convex && !self.bent;
        self.vertices[..].try_into().ok().filter(|_| is_flat_and_convex)
    }

    /// Plane of the polygon: the surface at its hits is that of the plane, but for texture coordinates.
    pub const fn plane(&self) -> &Plane {
        &self.plane
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let surface = self.plane.surface(ray, hit, needs);
        let uv = |k: usize| (surface.uv[k] - self.uv_min[k]) / self.uv_size[k];
        if needs.uv { SurfaceInteraction { uv: [uv(0), uv(1)], ..surface } } else { surface }
    }
}

/// Minimum and extent of the corners along the tangents of the plane, relative to its point.
fn extent_along_tangents(vertices: &[DVec3], plane: &Plane) -> ([f64; 2], [f64; 2]) {
    let frame = Frame::from_z(plane.normal());
    let local = Aabb::from_points(vertices.iter().map(|v| frame.to_local(*v - plane.point())));
    let size = local.extent();
    ([local.min.x, local.min.y], [size.x, size.y])
}
