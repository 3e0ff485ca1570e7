//! Spawned rays neither hit their own surface by rounding nor pass over nearby surfaces.

use proptest::prelude::*;
use rt_geometry::{
    CappedQuadric, Cuboid, Disk, InfiniteQuadric, InsideRule, InteractionFlags, Plane, Polygon, Rectangle, Shape,
    Sphere, SurfaceInteraction, Torus, TransformedShape, Triangle,
};
use rt_math::transcendental::{pow, sincos};
use rt_math::{DVec3, Frame, Interval, Ray, Transform, random};
use std::f64::consts::TAU;
use std::sync::Arc;

fn draw(ray: u64, k: u64) -> f64 {
    random::unit(random::hash(&[ray, k]))
}

/// A direction with a cosine to the normal of at least 1e-3.
fn upwards(normal: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let cosine = 1e-3 + (1.0 - 1e-3) * cosine;
    let (sin, cos) = sincos(TAU * turn);
    let ring = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    Frame::from_z(normal).from_local(DVec3::new(ring * cos, ring * sin, cosine))
}

/// One shape of each kind. They are convex or flat: no ray that leaves on the outside meets its shape again.
fn shapes(scale: f64, offset: f64) -> [Shape; 5] {
    let centre = DVec3::splat(offset);
    let sphere = Sphere::new(centre, scale).expect("a sphere");
    let solid = Cuboid::new(centre - scale, centre + scale).expect("a box");
    let plane = Plane::new(centre, DVec3::new(0.6, 0.48, 0.64)).expect("a plane");
    let corners = [DVec3::X, DVec3::Y, DVec3::Z].map(|v| centre + v * scale);
    let triangle = Triangle::new(corners).expect("a triangle");
    let corners = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.5, -1.0, 1.5)].map(|v| centre + v * scale).to_vec();
    let polygon = Arc::new(Polygon::new(corners, Vec::new(), InsideRule::EvenOdd).expect("a polygon"));
    let [sphere, solid] = [Shape::Sphere(sphere), Shape::Cuboid(solid)];
    [sphere, solid, Shape::Plane(plane), Shape::Triangle(triangle), Shape::Polygon(polygon)]
}

/// Shapes around the y axis that no ray which leaves on the outside hits again.
fn convex_around_the_axis(scale: f64) -> Vec<Shape> {
    let mut shapes = vec![
        Shape::InfiniteCylinder(InfiniteQuadric::cylinder(scale).expect("a cylinder")),
        Shape::Disk(Disk::new(scale, 0.3 * scale).expect("a ring")),
        Shape::Rectangle(Rectangle::new(2.0 * scale, scale).expect("a rectangle")),
        Shape::Cone(CappedQuadric::cone(scale, 0.01 * scale, false).expect("a flat cone")),
    ];
    for caps in [true, false] {
        shapes.extend([
            Shape::Cylinder(CappedQuadric::cylinder(scale, -scale, scale, caps).expect("a cylinder")),
            Shape::Cone(CappedQuadric::cone(scale, 1.5 * scale, caps).expect("a cone")),
            Shape::Frustum(CappedQuadric::frustum(0.7 * scale, scale, scale, caps).expect("a frustum")),
        ]);
    }
    shapes
}

fn vector() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(DVec3::from)
}

/// Transforms that move, turn, stretch and mirror.
fn transform() -> impl Strategy<Value = Transform> {
    (vector(), vector(), 0.0..TAU, vector(), -2.0..4.0f64).prop_filter_map(
        "flat",
        |(offset, axis, angle, factors, far)| {
            let turn = Transform::rotate(axis, angle).ok()?;
            let scale = Transform::scale(factors).ok()?;
            let all = Transform::translate(offset * pow(10.0, far)).compose(&turn).compose(&scale).compose(&turn);
            (factors.abs().min_element() > 1e-3).then_some(all)
        },
    )
}

/// Checks that a ray spawned on the outside of a convex surface misses it. Its origin must have moved by a tiny part of
/// the size of the scene.
fn leaves(
    surface: &SurfaceInteraction,
    direction: DVec3,
    extent: f64,
    hits: impl Fn(&Ray) -> bool,
) -> Result<(), TestCaseError> {
    let ray = surface.spawn_ray(direction, 0.0);
    prop_assert!(!hits(&ray), "self-hit");
    prop_assert!((ray.origin - surface.point).length() <= 1e-12 * extent, "moved too far");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_shape_is_hit_by_the_rays_that_leave_it(
        log_scale in -6.0..6.0f64, log_distance in -3.0..7.0f64, from in vector(), to in vector(),
        cosine in 0.0..1.0f64, turn in 0.0..1.0f64,
    ) {
        let (scale, offset) = (pow(10.0, log_scale), pow(10.0, log_scale + log_distance));
        for shape in shapes(scale, offset) {
            let origin = DVec3::splat(offset) + from * (scale * 10.0);
            let ray = Ray::new(origin, DVec3::splat(offset) + to * scale - origin);
            let Some(hit) = shape.intersect(&ray, Interval::FORWARD) else { continue };
            let surface = shape.surface(&ray, &hit, InteractionFlags::ALL);
            let direction = upwards(surface.geometric_normal, cosine, turn);
            let hits = |ray: &Ray| shape.intersect(ray, Interval::FORWARD).is_some();
            leaves(&surface, direction, offset + surface.point.length() + scale, hits)?;
        }
    }

    #[test]
    fn no_placed_shape_is_hit_by_the_rays_that_leave_it(
        map in transform(), from in vector(), to in vector(), cosine in 0.0..1.0f64, turn in 0.0..1.0f64,
    ) {
        for shape in shapes(1.0, 0.25).into_iter().chain(convex_around_the_axis(1.0)) {
            let placed = TransformedShape::new(shape, map);
            let ray = map.ray(&Ray::new(from * 10.0, to - from * 10.0));
            let Some(hit) = placed.intersect(&ray, Interval::FORWARD) else { continue };
            let surface = placed.surface(&ray, &hit, InteractionFlags::ALL);
            let direction = upwards(surface.geometric_normal, cosine, turn);
            let hits = |ray: &Ray| placed.intersect(ray, Interval::FORWARD).is_some();
            let extent = map.condition() * (map.translation().length() + surface.point.length() + 1.0);
            leaves(&surface, direction, extent, hits)?;
        }
    }
}

/// The inner of two concentric spheres is seen through a gap that a fixed offset would swallow.
#[test]
fn a_gap_of_a_billionth_is_crossed() {
    let outer = Sphere::new(DVec3::ZERO, 1.0).expect("a sphere");
    let inner = Sphere::new(DVec3::ZERO, 1.0 - 1e-9).expect("a sphere");
    for ray in 0..10_000 {
        let towards = upwards(DVec3::Z, draw(ray, 0), draw(ray, 1));
        let arriving = Ray::new(towards * 3.0, -towards);
        let hit = outer.intersect(&arriving, Interval::FORWARD).expect("a hit");
        let surface = outer.surface(&arriving, &hit, InteractionFlags::ALL);
        let entering = surface.spawn_ray(-towards, 0.0);
        let gap = inner.intersect(&entering, Interval::FORWARD).expect("the inner sphere").t;
        assert!((gap - 1e-9).abs() < 1e-14, "{gap}");
    }
}

/// The inverse of a transform is rounded apart from the transform. Where both are composed of several maps, a point
/// that goes there and back is off by more than the two steps account for.
#[test]
fn a_composed_transform_does_not_bring_spawned_rays_back_to_their_plane() {
    let [_, _, plane, ..] = shapes(1.0, 0.25);
    let vector = |ray: u64, k: u64| DVec3::new(draw(ray, k), draw(ray, k + 1), draw(ray, k + 2)) * 2.0 - 1.0;
    for ray in 0..100_000 {
        let turn = Transform::rotate(vector(ray, 0), TAU * draw(ray, 3)).expect("an axis");
        let squeeze = Transform::scale(DVec3::new(1.0, 0.05, 0.5)).expect("regular");
        let map = turn.compose(&squeeze).compose(&turn);
        let placed = TransformedShape::new(plane.clone(), map);
        let local = Ray::new(vector(ray, 4) * 10.0, vector(ray, 7));
        let arriving = map.ray(&local);
        let Some(hit) = placed.intersect(&arriving, Interval::FORWARD) else { continue };
        let surface = placed.surface(&arriving, &hit, InteractionFlags::ALL);
        let leaving = surface.spawn_ray(upwards(surface.geometric_normal, draw(ray, 10), draw(ray, 11)), 0.0);
        assert_eq!(placed.intersect(&leaving, Interval::FORWARD), None, "ray {ray}");
    }
}

/// A shape, whether it is convex, and for a closed one what encloses it at a distance of a thousandth of its size.
struct Curved {
    shape: Shape,
    is_convex: bool,
    enclosure: Option<TransformedShape>,
}

fn curved(scale: f64) -> Vec<Curved> {
    let larger = Transform::scale(DVec3::splat(1.002)).expect("regular");
    let larger = Transform::translate(DVec3::NEG_Y * (0.001 * scale)).compose(&larger);
    let convex = convex_around_the_axis(scale).into_iter().map(|shape| {
        let is_closed = match &shape {
            Shape::Cylinder(quadric) | Shape::Cone(quadric) | Shape::Frustum(quadric) => quadric.has_caps(),
            _ => false,
        };
        let enclosure = is_closed.then(|| TransformedShape::new(shape.clone(), larger));
        Curved { shape, is_convex: true, enclosure }
    });
    let torus = |minor: f64| Shape::Torus(Torus::new(scale, minor * scale).expect("a torus"));
    let tori = [0.4, 0.01].map(|minor| {
        let enclosure = TransformedShape::new(torus(minor + 0.001), Transform::IDENTITY);
        Curved { shape: torus(minor), is_convex: false, enclosure: Some(enclosure) }
    });
    let cone = Shape::DoubleCone(InfiniteQuadric::double_cone(0.7).expect("a cone"));
    convex.chain(tori).chain([Curved { shape: cone, is_convex: false, enclosure: None }]).collect()
}

/// Counts rays spawned outwards from a shape that hit it again at their origin, or miss its enclosure. Also counts rays
/// spawned inwards that miss the opposite wall. The shape has different sizes before and after the map.
fn acne_and_leaks_of(curved: &Curved, map: Transform, [size, extent]: [f64; 2]) -> [usize; 3] {
    let placed = TransformedShape::new(curved.shape.clone(), map);
    let enclosure =
        curved.enclosure.as_ref().map(|e| TransformedShape::new(e.shape().clone(), map.compose(e.world_from_local())));
    let (mut acne, mut outside, mut inside, mut spawned) = (0, 0, 0, 0);
    for ray in 0..4_000 {
        let point = |k: u64| DVec3::new(draw(ray, k), draw(ray, k + 1), draw(ray, k + 2)) * 2.0 - 1.0;
        let from = point(0).normalize_or(DVec3::X) * 3.0;
        let arriving = map.ray(&Ray::new(from * size, (point(3) - from) * size));
        let Some(hit) = placed.intersect(&arriving, Interval::FORWARD) else { continue };
        spawned += 1;
        let surface = placed.surface(&arriving, &hit, InteractionFlags::ALL);
        let towards = upwards(surface.geometric_normal, draw(ray, 6), draw(ray, 7));
        let leaving = surface.spawn_ray(towards, 0.0);
        // A concave shape is hit again, but not at the origin of the ray.
        let again = placed.intersect(&leaving, Interval::FORWARD);
        acne += usize::from(again.is_some_and(|hit| curved.is_convex || hit.t < 1e-7 * extent));
        if let Some(enclosure) = &enclosure {
            outside += usize::from(enclosure.intersect(&leaving, Interval::FORWARD).is_none());
            let entering = surface.spawn_ray(-towards, 0.0);
            inside += usize::from(placed.intersect(&entering, Interval::FORWARD).is_none());
        }
    }
    assert!(spawned > 50, "{spawned}");
    [acne, outside, inside]
}

#[test]
fn curved_shapes_of_any_size_anywhere_have_neither_acne_nor_leaks() {
    let at_origin = [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6].map(|scale| (scale, 0.0));
    let far_away = [1e2, 1e4, 1e5, 1e7].map(|offset| (1.0, offset));
    let turn = Transform::rotate(DVec3::new(1.0, 2.0, -0.5), 0.8).expect("an axis");
    for (scale, offset) in at_origin.into_iter().chain(far_away) {
        let moved = Transform::translate(DVec3::splat(offset));
        let scaled = moved.compose(&turn).compose(&Transform::scale(DVec3::splat(scale)).expect("regular"));
        for (size, map) in [(scale, moved), (scale, moved.compose(&turn)), (1.0, scaled)] {
            for curved in curved(size) {
                let found = acne_and_leaks_of(&curved, map, [size, scale]);
                assert_eq!(found, [0; 3], "{:?}, scale {scale}, offset {offset}", curved.shape);
            }
        }
    }
}

/// The errors of a transform are not there to cover up for those of the shape.
#[test]
fn curved_shapes_in_their_own_space_have_no_acne() {
    for scale in [1e-6, 1.0, 1e6] {
        for shape in convex_around_the_axis(scale) {
            for ray in 0..20_000 {
                let point = |k: u64| DVec3::new(draw(ray, k), draw(ray, k + 1), draw(ray, k + 2)) * 2.0 - 1.0;
                let from = point(0).normalize_or(DVec3::X) * 3.0;
                let arriving = Ray::new(from * scale, (point(3) - from) * scale);
                let Some(hit) = shape.intersect(&arriving, Interval::FORWARD) else { continue };
                let surface = shape.surface(&arriving, &hit, InteractionFlags::ALL);
                let leaving = surface.spawn_ray(upwards(surface.geometric_normal, draw(ray, 6), draw(ray, 7)), 0.0);
                assert_eq!(shape.intersect(&leaving, Interval::FORWARD), None, "{shape:?}, ray {ray}");
            }
        }
    }
}
