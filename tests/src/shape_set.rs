//! Sets of shapes of all kinds.

use crate::Draw;
use rt_geometry::{
    CappedQuadric, Cuboid, Disk, Hit, InfiniteQuadric, InsideRule, InteractionFlags, Plane, Polygon, Primitives,
    Rectangle, Shape, ShapeHit, Sphere, SurfaceInteraction, Torus, TransformedShape, Triangle,
};
use rt_math::transcendental::sincos;
use rt_math::{Aabb, DVec3, Interval, Ray, Transform};
use std::f64::consts::TAU;
use std::sync::Arc;

/// TransformedShape shapes as a set of primitives, as a scene has them: in world space where they can be.
#[derive(Clone, Debug, Default)]
pub struct ShapeSet {
    placed: Vec<TransformedShape>,
}

/// A kind of shape, and how to draw one about as large as the unit sphere.
#[derive(Clone, Copy, Debug)]
pub struct ShapeKind {
    /// In lower case.
    pub name: &'static str,
    draw: fn(&mut Draw) -> Option<Shape>,
}

impl ShapeKind {
    /// All kinds, solids also open.
    pub const ALL: &'static [Self] = &[
        Self { name: "sphere", draw: |draw| Sphere::new(DVec3::ZERO, draw.between(0.1, 1.0)).ok().map(Shape::Sphere) },
        Self { name: "box", draw: axis_box },
        Self { name: "plane", draw: |draw| Plane::new(draw.point(), draw.direction()).ok().map(Shape::Plane) },
        Self {
            name: "triangle",
            draw: |draw| Triangle::new([draw.point(), draw.point(), draw.point()]).ok().map(Shape::Triangle),
        },
        Self { name: "cylinder", draw: cylinder },
        Self {
            name: "infinite cylinder",
            draw: |draw| InfiniteQuadric::cylinder(draw.between(0.1, 1.0)).ok().map(Shape::InfiniteCylinder),
        },
        Self {
            name: "double cone",
            draw: |draw| InfiniteQuadric::double_cone(draw.between(0.1, 2.0)).ok().map(Shape::DoubleCone),
        },
        Self {
            name: "cone",
            draw: |draw| {
                CappedQuadric::cone(draw.between(0.1, 1.0), draw.between(0.1, 2.0), draw.one_in(2))
                    .ok()
                    .map(Shape::Cone)
            },
        },
        Self { name: "frustum", draw: frustum },
        Self { name: "disk", draw: disk },
        Self {
            name: "rectangle",
            draw: |draw| Rectangle::new(draw.between(0.1, 2.0), draw.between(0.1, 2.0)).ok().map(Shape::Rectangle),
        },
        Self { name: "torus", draw: torus },
        Self { name: "polygon", draw: polygon },
    ];

    /// A shape of this kind around the origin of its local space.
    pub fn shape(&self, draw: &mut Draw) -> Option<Shape> {
        (self.draw)(draw)
    }
}

fn axis_box(draw: &mut Draw) -> Option<Shape> {
    let corner = draw.point();
    Cuboid::new(corner, corner + draw.point().abs()).ok().map(Shape::Cuboid)
}

fn cylinder(draw: &mut Draw) -> Option<Shape> {
    let bottom = draw.between(-1.0, 0.5);
    let (radius, top) = (draw.between(0.1, 1.0), bottom + draw.between(0.1, 2.0));
    CappedQuadric::cylinder(radius, bottom, top, draw.one_in(2)).ok().map(Shape::Cylinder)
}

fn frustum(draw: &mut Draw) -> Option<Shape> {
    let [bottom, top, height] = [0; 3].map(|_| draw.between(0.1, 1.0));
    CappedQuadric::frustum(bottom, top, height, draw.one_in(2)).ok().map(Shape::Frustum)
}

fn disk(draw: &mut Draw) -> Option<Shape> {
    let radius = draw.between(0.1, 1.0);
    let hole = draw.pick(&[0.0, 0.5]) * radius;
    Disk::new(radius, hole).ok().map(Shape::Disk)
}

fn torus(draw: &mut Draw) -> Option<Shape> {
    let radius = draw.between(0.2, 0.8);
    Torus::new(radius, radius * draw.between(0.1, 0.9)).ok().map(Shape::Torus)
}

/// A star or a convex polygon, under any of the rules that fit it, some with a hole.
fn polygon(draw: &mut Draw) -> Option<Shape> {
    let corners = 3 + draw.below(9);
    let ring = |radius: f64, inner: f64| -> Vec<DVec3> {
        let corner = |i: usize| {
            let (sin, cos) = sincos(TAU * i as f64 / corners as f64);
            DVec3::new(cos, sin, 0.0) * if i % 2 == 1 { inner } else { radius }
        };
        (0..corners).map(corner).collect()
    };
    let polygon = match draw.below(3) {
        0 => Polygon::new(ring(1.0, 1.0), Vec::new(), InsideRule::Convex),
        1 => Polygon::new(ring(1.0, 0.5), vec![ring(0.25, 0.2)], InsideRule::Winding),
        _ => Polygon::new(ring(1.0, 0.5), vec![ring(0.25, 0.2)], InsideRule::EvenOdd),
    };
    polygon.ok().map(|polygon| Shape::Polygon(Arc::new(polygon)))
}

impl ShapeSet {
    /// The set of these; the index of a primitive is its place in the list. Shapes that stay what they are under their
    /// transform are taken to world space.
    pub fn new(placed: impl IntoIterator<Item = TransformedShape>) -> Self {
        let bake = |placed: TransformedShape| match placed.bake_transform() {
            Some(shape) => TransformedShape::new(shape, Transform::IDENTITY),
            None => placed,
        };
        Self { placed: placed.into_iter().map(bake).collect() }
    }

    /// Shapes where they stand.
    pub fn of_shapes(shapes: impl IntoIterator<Item = Shape>) -> Self {
        Self { placed: shapes.into_iter().map(|shape| TransformedShape::new(shape, Transform::IDENTITY)).collect() }
    }

    /// `count` shapes of the given kinds in turn, turned and stretched at will, within about one unit of the origin,
    /// then taken elsewhere by `world_from_set`. One in eight is an exact copy of an earlier one, where the lower index
    /// has to win.
    pub fn scattered(kinds: &[ShapeKind], count: usize, world_from_set: &Transform, draw: &mut Draw) -> Self {
        let mut placed: Vec<TransformedShape> = Vec::with_capacity(count);
        for index in 0..count {
            if index > 0 && draw.one_in(8) {
                placed.push(placed[draw.below(index)].clone());
                continue;
            }
            let shape = std::iter::repeat_with(|| kinds[index % kinds.len()].shape(draw)).flatten().next();
            let place = place(draw);
            placed.extend(shape.map(|shape| TransformedShape::new(shape, world_from_set.compose(&place))));
        }
        Self::new(placed)
    }

    /// The shapes in order.
    pub fn placed(&self) -> &[TransformedShape] {
        &self.placed
    }

    /// The corners of all triangles and polygons, in world space.
    pub fn corners(&self) -> Vec<DVec3> {
        let corners = |placed: &TransformedShape| -> Vec<DVec3> {
            let local = match placed.shape() {
                Shape::Triangle(triangle) => triangle.vertices().to_vec(),
                Shape::Polygon(polygon) => polygon.rings().flatten().copied().collect(),
                _ => Vec::new(),
            };
            local.into_iter().map(|corner| placed.world_from_local().point(corner)).collect()
        };
        self.placed.iter().flat_map(corners).collect()
    }

    /// The surface at a hit of this set with this ray; `None` for a hit on a primitive that it does not have.
    pub fn surface(&self, ray: &Ray, hit: &Hit, needs: InteractionFlags) -> Option<SurfaceInteraction> {
        let placed = self.placed.get(hit.primitive as usize)?;
        Some(placed.surface(ray, &ShapeHit { t: hit.t, uv: hit.uv }, needs))
    }
}

/// Somewhere in the unit cube, in a quarter of all cases without a turn, so that faces lie along the axes.
fn place(draw: &mut Draw) -> Transform {
    let size = draw.between(0.05, 0.3);
    let stretch = if draw.one_in(2) { DVec3::ONE } else { draw.point() + draw.point().signum() * 0.2 };
    let scale = Transform::scale(stretch * size).unwrap_or(Transform::IDENTITY);
    let turn = if draw.one_in(4) { None } else { Transform::rotate(draw.direction(), draw.between(0.0, TAU)).ok() };
    Transform::translate(draw.point()).compose(&turn.unwrap_or(Transform::IDENTITY)).compose(&scale)
}

impl Primitives for ShapeSet {
    fn len(&self) -> usize {
        self.placed.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.placed.get(index as usize)?.bounds()
    }

    #[inline]
    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let ShapeHit { t, uv } = self.placed.get(index as usize)?.intersect(ray, span)?;
        Some(Hit { t, instance: 0, primitive: index, uv })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_can_be_drawn_and_is_what_it_is_called() {
        let mut draw = Draw::new(3);
        for kind in ShapeKind::ALL {
            let shape = kind.shape(&mut draw).expect("a shape");
            let name = format!("{shape:?}").split_once('(').expect("a variant").0.to_lowercase();
            assert!(name.contains(&kind.name.replace(' ', "").replace("box", "cuboid")), "{name}");
        }
        let set = ShapeSet::scattered(ShapeKind::ALL, 100, &Transform::IDENTITY, &mut draw);
        assert_eq!(set.len(), 100);
    }
}
