//! The closed set of shapes.

use crate::{
    CappedQuadric, Cuboid, Disk, InfiniteQuadric, InteractionFlags, Plane, Polygon, Rectangle, ShapeHit, Sphere,
    SurfaceInteraction, Torus, Triangle,
};
use rt_math::{Aabb, DVec3, Interval, Ray};
use std::sync::Arc;

/// Any single shape, in its own local space.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// An axis-aligned box.
    Cuboid(Cuboid),
    /// An infinite plane.
    Plane(Plane),
    /// A triangle.
    Triangle(Triangle),
    /// A flat polygon.
    Polygon(Arc<Polygon>),
    /// A finite cylinder, with caps or open.
    Cylinder(CappedQuadric),
    /// An infinite cylinder.
    InfiniteCylinder(InfiniteQuadric),
    /// An infinite double cone.
    DoubleCone(InfiniteQuadric),
    /// A finite cone, with a cap or open.
    Cone(CappedQuadric),
    /// A cone without its tip, with caps or open.
    Frustum(CappedQuadric),
    /// A disk or a ring.
    Disk(Disk),
    /// A finite plane.
    Rectangle(Rectangle),
    /// A torus.
    Torus(Torus),
}

/// Evaluates an expression for the shape at hand.
macro_rules! dispatch {
    ($any:expr, $shape:ident => $value:expr) => {
        match $any {
            Shape::Sphere($shape) => $value,
            Shape::Cuboid($shape) => $value,
            Shape::Plane($shape) => $value,
            Shape::Triangle($shape) => $value,
            Shape::Polygon($shape) => $value,
            Shape::Cylinder($shape) | Shape::Cone($shape) | Shape::Frustum($shape) => $value,
            Shape::InfiniteCylinder($shape) | Shape::DoubleCone($shape) => $value,
            Shape::Disk($shape) => $value,
            Shape::Rectangle($shape) => $value,
            Shape::Torus($shape) => $value,
        }
    };
}

impl Shape {
    /// A box around the shape; `None` for the infinite ones: planes, infinite cylinders and double cones.
    pub fn bounds(&self) -> Option<Aabb> {
        match self {
            Self::Sphere(sphere) => Some(sphere.bounds()),
            Self::Cuboid(axis_box) => Some(axis_box.bounds()),
            Self::Plane(_) | Self::InfiniteCylinder(_) | Self::DoubleCone(_) => None,
            Self::Triangle(triangle) => Some(triangle.bounds()),
            Self::Polygon(polygon) => Some(polygon.bounds()),
            Self::Cylinder(quadric) | Self::Cone(quadric) | Self::Frustum(quadric) => Some(quadric.bounds()),
            Self::Disk(disk) => Some(disk.bounds()),
            Self::Rectangle(rectangle) => Some(rectangle.bounds()),
            Self::Torus(torus) => Some(torus.bounds()),
        }
    }

    /// The support function: the largest dot product of a direction with a point of the shape, up to rounding;
    /// `None` for infinite shapes.
    pub(crate) fn support(&self, direction: DVec3) -> Option<f64> {
        match self {
            Self::Sphere(sphere) => Some(sphere.centre().dot(direction) + sphere.radius() * direction.length()),
            Self::Cuboid(axis_box) => {
                let Aabb { min, max } = axis_box.bounds();
                Some((min * direction).max(max * direction).element_sum())
            }
            Self::Plane(_) | Self::InfiniteCylinder(_) | Self::DoubleCone(_) => None,
            Self::Triangle(triangle) => {
                Some(triangle.vertices().map(|v| v.dot(direction)).into_iter().fold(f64::NEG_INFINITY, f64::max))
            }
            Self::Polygon(polygon) => Some(polygon.support(direction)),
            Self::Cylinder(quadric) | Self::Cone(quadric) | Self::Frustum(quadric) => Some(quadric.support(direction)),
            Self::Disk(disk) => Some(disk.support(direction)),
            Self::Rectangle(rectangle) => Some(rectangle.support(direction)),
            Self::Torus(torus) => Some(torus.support(direction)),
        }
    }

    /// The first hit at or after `span.min`, if it is not after `span.max`. `None` on a miss and for rays with a NaN or
    /// without a direction.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        dispatch!(self, shape => shape.intersect(ray, span))
    }

    /// Surface at a hit of this shape with this ray.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        dispatch!(self, shape => shape.surface(ray, hit, needs))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{InsideRule, ShapeError};
    use proptest::prelude::*;
    use rt_math::DVec3;

    fn shapes() -> Vec<Shape> {
        let [closed, open] = [true, false];
        let polygon = Polygon::new(vec![DVec3::X, DVec3::Y, DVec3::Z], Vec::new(), InsideRule::EvenOdd);
        vec![
            Shape::Sphere(Sphere::new(DVec3::X, 1.0).expect("a sphere")),
            Shape::Cuboid(Cuboid::new(DVec3::NEG_ONE, DVec3::ONE).expect("a box")),
            Shape::Plane(Plane::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)).expect("a plane")),
            Shape::Triangle(Triangle::new([DVec3::X, DVec3::Y, DVec3::Z]).expect("a triangle")),
            Shape::Polygon(Arc::new(polygon.expect("a polygon"))),
            Shape::Cylinder(CappedQuadric::cylinder(1.0, -0.5, 1.5, closed).expect("a cylinder")),
            Shape::Cylinder(CappedQuadric::cylinder(1.0, -0.5, 1.5, open).expect("a cylinder")),
            Shape::InfiniteCylinder(InfiniteQuadric::cylinder(1.0).expect("a cylinder")),
            Shape::DoubleCone(InfiniteQuadric::double_cone(1.0).expect("a cone")),
            Shape::Cone(CappedQuadric::cone(1.0, 1.5, closed).expect("a cone")),
            Shape::Cone(CappedQuadric::cone(1.0, 1.5, open).expect("a cone")),
            Shape::Frustum(CappedQuadric::frustum(1.0, 0.5, 1.0, closed).expect("a frustum")),
            Shape::Frustum(CappedQuadric::frustum(0.5, 1.0, 1.0, open).expect("a frustum")),
            Shape::Disk(Disk::new(1.0, 0.5).expect("a ring")),
            Shape::Rectangle(Rectangle::new(1.0, 2.0).expect("a rectangle")),
            Shape::Torus(Torus::new(1.0, 0.5).expect("a torus")),
        ]
    }

    /// Numbers of all magnitudes, zeros, subnormals, infinities and NaN, and plain ones, so that some rays hit.
    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![any::<f64>(), -2.0..2.0f64, Just(0.0), Just(-0.0)]
    }

    fn any_ray() -> impl Strategy<Value = Ray> {
        prop::array::uniform6(number())
            .prop_map(|[a, b, c, d, e, f]| Ray::new(DVec3::new(a, b, c), DVec3::new(d, e, f)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        #[test]
        fn any_ray_is_answered(ray in any_ray(), min in number(), max in number()) {
            let span = Interval::new(min, max);
            for shape in shapes() {
                let Some(hit) = shape.intersect(&ray, span) else { continue };
                prop_assert!(hit.t.is_finite() && span.contains(hit.t), "{shape:?}");
                prop_assert!(!ray.origin.is_nan() && !ray.direction.is_nan() && ray.direction != DVec3::ZERO, "{shape:?}");
            }
        }

        /// Shrinking the span from above drops hits and reveals none.
        #[test]
        fn a_shorter_span_reveals_nothing(ray in any_ray(), min in -3.0..3.0f64, max in -3.0..9.0f64) {
            for shape in shapes() {
                let long = shape.intersect(&ray, Interval::new(min, f64::INFINITY));
                let short = shape.intersect(&ray, Interval::new(min, max));
                prop_assert_eq!(short, long.filter(|hit| hit.t <= max), "{:?}", shape);
            }
        }
    }

    #[test]
    fn rays_with_a_nan_or_without_a_direction_miss() {
        let places = [[0.0; 3], [0.5; 3], [0.25, 0.25, 3.0], [0.1, 0.1, 1.0], [0.0, 1.0, 0.0], [2.0, -1.5, 2.0]];
        let pairs = places.iter().flat_map(|from| places.map(|to| (DVec3::from(*from), DVec3::from(to))));
        for ((origin, to), shape) in pairs.flat_map(|pair| shapes().into_iter().map(move |shape| (pair, shape))) {
            let misses = |origin: DVec3, direction: DVec3| {
                assert_eq!(
                    shape.intersect(&Ray::new(origin, direction), Interval::FORWARD),
                    None,
                    "{shape:?} {origin}"
                );
            };
            misses(origin, DVec3::ZERO);
            misses(origin, DVec3::new(0.0, -0.0, 0.0));
            for axis in 0..3 {
                let broken = |mut vector: DVec3| {
                    vector[axis] = f64::NAN;
                    vector
                };
                misses(broken(origin), to - origin);
                misses(origin, broken(to - origin));
            }
        }
    }

    #[test]
    fn bad_numbers_are_refused() {
        use ShapeError::{
            BadCoordinate, BadInnerRadius, BadLength, BadRadius, ClosedHole, InvertedBox, NoArea, NoHeight,
        };
        let (nan, infinite) = (f64::NAN, f64::INFINITY);
        let line = [DVec3::ZERO, DVec3::ONE, DVec3::ONE * 3.0];
        let sphere = |centre: f64, radius| Sphere::new(DVec3::splat(centre), radius).err();
        let cylinder = |radius, bottom, top| CappedQuadric::cylinder(radius, bottom, top, true).err();
        let cone = |radius, height| CappedQuadric::cone(radius, height, true).err();
        let frustum = |bottom, top, height| CappedQuadric::frustum(bottom, top, height, true).err();
        let infinite_cylinder = |radius| InfiniteQuadric::cylinder(radius).err();
        let double_cone = |slope| InfiniteQuadric::double_cone(slope).err();
        let disk = |radius, inner| Disk::new(radius, inner).err();
        let rectangle = |width, depth| Rectangle::new(width, depth).err();
        let torus = |radius, tube_radius| Torus::new(radius, tube_radius).err();
        let inverted = Cuboid::new(DVec3::new(0.0, 2.0, 0.0), DVec3::ONE).err();
        let cases = [
            ("sphere, negative", sphere(0.0, -1.0), BadRadius(-1.0)),
            ("sphere, zero", sphere(0.0, 0.0), BadRadius(0.0)),
            ("sphere, NaN", sphere(0.0, nan), BadRadius(nan)),
            ("sphere, far", sphere(1e61, 1.0), BadCoordinate(1e61)),
            ("box", inverted, InvertedBox { axis: 1, min: 2.0, max: 1.0 }),
            ("plane", Plane::new(DVec3::ONE, DVec3::ZERO).err(), ShapeError::ZeroNormal),
            ("triangle, flat", Triangle::new(line).err(), NoArea(line)),
            ("triangle, NaN", Triangle::new([DVec3::NAN; 3]).err(), BadCoordinate(nan)),
            ("cylinder, radius", cylinder(0.0, 0.0, 1.0), BadRadius(0.0)),
            ("cylinder, height", cylinder(1.0, 1.0, 1.0), NoHeight { bottom: 1.0, top: 1.0 }),
            ("cylinder, NaN radius", cylinder(nan, 0.0, 1.0), BadRadius(nan)),
            ("cylinder, NaN bottom", cylinder(1.0, nan, 1.0), BadCoordinate(nan)),
            ("cylinder, infinite top", cylinder(1.0, 0.0, infinite), BadCoordinate(infinite)),
            ("cone, radius", cone(0.0, 1.0), BadRadius(0.0)),
            ("cone, height", cone(1.0, -1.0), BadLength("height", -1.0)),
            ("cone, NaN height", cone(1.0, nan), BadLength("height", nan)),
            ("frustum, bottom", frustum(0.0, 1.0, 1.0), BadRadius(0.0)),
            ("frustum, top", frustum(1.0, -1.0, 1.0), BadRadius(-1.0)),
            ("frustum, height", frustum(1.0, 1.0, 0.0), BadLength("height", 0.0)),
            ("frustum, NaN top", frustum(1.0, nan, 1.0), BadRadius(nan)),
            ("infinite cylinder", infinite_cylinder(-2.0), BadRadius(-2.0)),
            ("infinite cylinder, NaN", infinite_cylinder(nan), BadRadius(nan)),
            ("double cone", double_cone(0.0), BadLength("slope", 0.0)),
            ("double cone, infinite", double_cone(infinite), BadLength("slope", infinite)),
            ("disk, radius", disk(0.0, 0.0), BadRadius(0.0)),
            ("disk, hole", disk(1.0, 1.0), BadInnerRadius { inner: 1.0, outer: 1.0 }),
            ("disk, negative hole", disk(1.0, -0.5), BadInnerRadius { inner: -0.5, outer: 1.0 }),
            ("disk, NaN hole", disk(1.0, nan), BadCoordinate(nan)),
            ("rectangle, width", rectangle(0.0, 1.0), BadLength("width", 0.0)),
            ("rectangle, depth", rectangle(1.0, -1.0), BadLength("depth", -1.0)),
            ("rectangle, infinite", rectangle(infinite, 1.0), BadLength("width", infinite)),
            ("torus, radius", torus(0.0, 0.0), BadRadius(0.0)),
            ("torus, tube", torus(1.0, -0.5), BadRadius(-0.5)),
            ("torus, hole", torus(1.0, 1.0), ClosedHole { radius: 1.0, tube_radius: 1.0 }),
            ("torus, NaN", torus(1.0, nan), BadRadius(nan)),
        ];
        // As text, in which NaN equals itself.
        for (name, error, expected) in cases {
            assert_eq!(format!("{error:?}"), format!("{:?}", Some(expected)), "{name}");
        }
    }

    #[test]
    fn only_infinite_shapes_are_unbounded() {
        for shape in shapes() {
            let is_infinite = matches!(shape, Shape::Plane(_) | Shape::InfiniteCylinder(_) | Shape::DoubleCone(_));
            assert_eq!(shape.bounds().is_none(), is_infinite, "{shape:?}");
            assert_eq!(shape.support(DVec3::Y).is_none(), is_infinite, "{shape:?}");
        }
    }

    #[test]
    fn the_support_along_the_axes_is_the_box() {
        for shape in shapes() {
            let Some(bounds) = shape.bounds() else { continue };
            for (axis, unit) in DVec3::AXES.into_iter().enumerate() {
                let [above, below] = [unit, -unit].map(|direction| shape.support(direction).expect("bounded"));
                assert!((above - bounds.max[axis]).abs() < 1e-15, "{shape:?}");
                assert!((below + bounds.min[axis]).abs() < 1e-15, "{shape:?}");
            }
        }
    }
}
