//! Known values, areas and rejected input. `tests/geometry/shared_edges.rs` tests shared edges of polygons.

use super::*;
use crate::Triangle;
use crate::strategies::vector;
use proptest::prelude::*;
use rt_math::random;
use rt_math::transcendental::sincos;
use std::f64::consts::TAU;

const RULES: [InsideRule; 3] = [InsideRule::Convex, InsideRule::Winding, InsideRule::EvenOdd];
const NON_CONVEX: [InsideRule; 2] = [InsideRule::Winding, InsideRule::EvenOdd];

/// The concave pentagon of area 10; the fan from its first corner would cover 14.
const DART: [[f64; 2]; 5] = [[0., 0.], [4., 0.], [4., 4.], [2., 1.], [0., 4.]];

fn in_plane(z: f64, points: &[[f64; 2]]) -> Vec<DVec3> {
    points.iter().map(|[x, y]| DVec3::new(*x, *y, z)).collect()
}

fn polygon(points: &[[f64; 2]], rule: InsideRule) -> Polygon {
    Polygon::new(in_plane(0.0, points), Vec::new(), rule).expect("a polygon")
}

fn above(polygon: &Polygon, x: f64, y: f64) -> Option<f64> {
    polygon.intersect(&Ray::new(DVec3::new(x, y, 2.0), DVec3::NEG_Z), Interval::FORWARD).map(|hit| hit.t)
}

fn square(side: f64, corner: f64) -> Vec<[f64; 2]> {
    let far = corner + side;
    vec![[corner, corner], [far, corner], [far, far], [corner, far]]
}

/// Five corners of a circle, each joined to the next but one.
fn pentagram() -> Vec<[f64; 2]> {
    let corner = |i: u32| {
        let (sin, cos) = sincos(TAU * f64::from(2 * i) / 5.0);
        [cos, sin]
    };
    (0..5).map(corner).collect()
}

#[test]
fn a_square_is_hit_from_both_sides_and_shows_its_front() {
    for rule in RULES {
        let square = Polygon::new(in_plane(1.0, &square(2.0, 1.0)), Vec::new(), rule).expect("a polygon");
        assert_eq!((square.normal(), square.rule()), (DVec3::Z, rule));
        assert_eq!(square.bounds(), Aabb::new(DVec3::ONE, DVec3::new(3.0, 3.0, 1.0)));
        for (z, t) in [(3.0, 2.0), (-1.0, 2.0)] {
            let ray = Ray::new(DVec3::new(1.5, 2.5, z), DVec3::new(0.0, 0.0, (1.0 - z) / t));
            let hit = square.intersect(&ray, Interval::FORWARD).expect("a hit");
            let surface = square.surface(&ray, &hit, InteractionFlags::ALL);
            assert_eq!((hit.t, surface.point, surface.uv), (t, DVec3::new(1.5, 2.5, 1.0), [0.25, 0.75]));
            assert_eq!(surface.geometric_normal, DVec3::Z);
            assert_eq!(square.surface(&ray, &hit, InteractionFlags::NONE).uv, [0.0; 2]);
            assert_eq!(square.intersect(&ray, Interval::new(0.0, t.next_down())), None);
        }
        let within = Ray::new(DVec3::new(-1.0, 2.0, 1.0), DVec3::X);
        assert_eq!(square.intersect(&within, Interval::FORWARD), None, "seen edge-on");
    }
}

#[test]
fn half_open_polygons_have_their_left_and_lower_edges_and_convex_ones_all() {
    let edges = [[0.0, 0.5], [0.5, 0.0], [1.0, 0.5], [0.5, 1.0]];
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let unit = square(1.0, 0.0);
    let owned = |rule, points: [[f64; 2]; 4]| points.map(|[x, y]| above(&polygon(&unit, rule), x, y).is_some());
    for rule in NON_CONVEX {
        assert_eq!(
            (owned(rule, edges), owned(rule, corners)),
            ([true, true, false, false], [true, false, false, false])
        );
    }
    assert_eq!((owned(InsideRule::Convex, edges), owned(InsideRule::Convex, corners)), ([true; 4], [true; 4]));
    let reversed: Vec<[f64; 2]> = unit.iter().rev().copied().collect();
    assert_eq!(polygon(&reversed, InsideRule::Winding).normal(), DVec3::NEG_Z);
    let beyond = [[-1e-300, 0.5], [0.5, -1e-300], [1f64.next_up(), 0.5], [0.5, 1f64.next_up()]];
    for rule in RULES {
        assert!(beyond.iter().all(|[x, y]| above(&polygon(&reversed, rule), *x, *y).is_none()), "{rule:?}");
    }
}

#[test]
fn a_concave_pentagon_covers_its_area() {
    const ROWS: u32 = 512;
    // Only cells on the two slanted edges are uncertain: twice their length in cells, a variance of 1/4 each.
    let cell = 4.0 / f64::from(ROWS);
    let deviation = cell * cell / 2.0 * (2.0 * 2.0 * 13f64.sqrt() / cell).sqrt();
    let slant = DVec3::new(0.3, -0.2, -1.0);
    for rule in NON_CONVEX {
        let dart = polygon(&DART, rule);
        assert!(above(&dart, 2.0, 0.5).is_some() && above(&dart, 2.0, 2.0).is_none());
        let mut count = 0u32;
        for index in 0..ROWS * ROWS {
            let jitter = |k| random::unit(random::hash(&[u64::from(index), k]));
            let (x, y) = (f64::from(index % ROWS) + jitter(0), f64::from(index / ROWS) + jitter(1));
            let origin = DVec3::new(x * cell, y * cell, 0.0) - slant * 3.0;
            count += u32::from(dart.intersect(&Ray::new(origin, slant), Interval::FORWARD).is_some());
        }
        let area = f64::from(count) * cell * cell;
        assert!((area - 10.0).abs() < 5.0 * deviation, "{rule:?}: {area} ± {deviation}");
    }
}

#[test]
fn the_middle_of_a_pentagram_is_inside_by_winding_and_outside_by_crossings() {
    let [winding, even_odd] = NON_CONVEX.map(|rule| polygon(&pentagram(), rule));
    assert_eq!((above(&winding, 0.0, 0.0), above(&even_odd, 0.0, 0.0)), (Some(2.0), None));
    // In a tip both agree, and outside.
    assert_eq!((above(&winding, 0.9, 0.0), above(&even_odd, 0.9, 0.0)), (Some(2.0), Some(2.0)));
    assert_eq!((above(&winding, -0.9, 0.0), above(&even_odd, -0.9, 0.0)), (None, None));
}

#[test]
fn collinear_corners_change_nothing() {
    const STEPS: u32 = 1 << 15;
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let along = |i: u32| {
        let (side, part) = ((i / STEPS) as usize, f64::from(i % STEPS) / f64::from(STEPS));
        let (a, b) = (corners[side], corners[(side + 1) % 4]);
        [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part]
    };
    let many: Vec<[f64; 2]> = (0..4 * STEPS).map(along).collect();
    for rule in RULES {
        let (plain, crowded) = (polygon(&corners, rule), polygon(&many, rule));
        let mut hits = 0;
        for ray in 0..300 {
            let draw = |k| random::unit(random::hash(&[ray, k])) * 2.0 - 0.5;
            let origin = DVec3::new(draw(0), draw(1), 1.5 + draw(2));
            let ray = Ray::new(origin, DVec3::new(draw(3), draw(4), 0.0) - origin);
            let (a, b) = (plain.intersect(&ray, Interval::FORWARD), crowded.intersect(&ray, Interval::FORWARD));
            assert_eq!(a, b, "{rule:?} {ray:?}");
            let surfaces = |hit| {
                (plain.surface(&ray, &hit, InteractionFlags::ALL), crowded.surface(&ray, &hit, InteractionFlags::ALL))
            };
            if let Some((a, b)) = a.map(surfaces) {
                assert_eq!(a, b);
                hits += 1;
            }
        }
        assert!((50..150).contains(&hits), "{hits}");
    }
}

#[test]
fn holes_are_left_out_whichever_way_they_run() {
    let outline = in_plane(0.0, &square(4.0, 0.0));
    let hole = in_plane(0.0, &square(1.0, 1.0));
    let reversed: Vec<DVec3> = hole.iter().rev().copied().collect();
    for rule in NON_CONVEX {
        for hole in [&hole, &reversed] {
            let frame = Polygon::new(outline.clone(), vec![hole.clone()], rule).expect("a polygon");
            assert_eq!((above(&frame, 1.5, 1.5), above(&frame, 2.5, 1.5)), (None, Some(2.0)));
            assert_eq!((above(&frame, 1.0, 1.5), above(&frame, 2.0, 1.5)), (None, Some(2.0)), "edges of the hole");
            assert_eq!(frame.rings().map(<[DVec3]>::len).collect::<Vec<_>>(), [4, 4]);
        }
    }
}

#[test]
fn bad_polygons_are_refused() {
    let new = |points: &[[f64; 2]], rule| Polygon::new(in_plane(0.0, points), Vec::new(), rule).expect_err("bad");
    let convex = |points: &[[f64; 2]]| new(points, InsideRule::Convex);
    assert_eq!(convex(&[[0., 0.], [1., 0.]]), PolygonError::TooFewVertices { ring: 0, count: 2 });
    assert_eq!(convex(&[]), PolygonError::TooFewVertices { ring: 0, count: 0 });
    assert!(matches!(convex(&[[0., 0.], [1., f64::NAN], [1., 1.]]), PolygonError::Shape(_)));
    assert_eq!(convex(&DART), PolygonError::NotConvex { vertex: 3 });
    assert_eq!(convex(&pentagram()), PolygonError::NotConvex { vertex: 3 });
    assert_eq!(convex(&[[0., 0.], [2., 0.], [1., 0.], [1., 1.]]), PolygonError::NotConvex { vertex: 2 });
    for rule in RULES {
        assert_eq!(new(&[[0., 0.], [1., 1.], [2., 2.], [5., 5.]], rule), PolygonError::NoArea);
        assert_eq!(new(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]], rule), PolygonError::NoArea, "a figure of eight");
    }
    let hole = vec![in_plane(0.0, &square(0.5, 0.25))];
    let outline = in_plane(0.0, &square(1.0, 0.0));
    let with_hole = Polygon::new(outline.clone(), hole, InsideRule::Convex);
    assert_eq!(with_hole, Err(PolygonError::ConvexWithHoles(1)));
    let short_hole = Polygon::new(outline, vec![vec![DVec3::ZERO]], InsideRule::Winding);
    assert_eq!(short_hole, Err(PolygonError::TooFewVertices { ring: 1, count: 1 }));
}

#[test]
fn a_corner_may_lie_off_the_plane_by_a_millionth_of_the_diameter() {
    let lifted = |height: f64| {
        let mut corners = in_plane(0.0, &[[0., 0.], [3., 0.], [6., 0.], [6., 4.], [0., 4.]]);
        corners[1].z = height;
        Polygon::new(corners, Vec::new(), InsideRule::EvenOdd)
    };
    let Err(PolygonError::NotFlat { vertex, distance, diameter }) = lifted(0.02) else { panic!("not refused") };
    assert_eq!(vertex, DVec3::new(3.0, 0.0, 0.02));
    assert!((distance - 0.02).abs() < 1e-3 && (diameter - 52f64.sqrt()).abs() < 1e-3, "{distance} {diameter}");
    let bent = lifted(5e-6).expect("flat enough");
    let ray = Ray::new(DVec3::new(3.0, 1e-3, 2.0), DVec3::NEG_Z);
    let hit = bent.intersect(&ray, Interval::FORWARD).expect("a hit");
    let surface = bent.surface(&ray, &hit, InteractionFlags::ALL);
    assert!(surface.point.z < 4e-6, "on the plane, not at the corner");
    assert!(bent.bounds().contains(surface.point) && bent.bounds().max.z == 5e-6);
}

#[test]
fn a_sliver_gives_a_hit_on_itself_or_a_clean_miss() {
    for rule in RULES {
        let sliver = polygon(&[[0., 0.], [1e6, 0.], [1e6, 1e-6], [0., 1e-6]], rule);
        for i in -50..50 {
            let origin = DVec3::new(f64::from(i) * 1e4, -1.0, f64::from(i) * 1e-8);
            let ray = Ray::new(origin, DVec3::new(3e5, 1.0, 0.0));
            if let Some(hit) = sliver.intersect(&ray, Interval::FORWARD) {
                let surface = sliver.surface(&ray, &hit, InteractionFlags::ALL);
                assert!(sliver.bounds().padded().contains(surface.point));
            }
        }
        assert!(above(&sliver, 5e5, 5e-7).is_some());
    }
}

proptest! {
    #[test]
    fn a_polygon_of_three_corners_is_a_triangle(
        a in vector(1.0), b in vector(1.0), c in vector(1.0), from in vector(1.0), to in vector(1.0),
    ) {
        let normal = (b - a).cross(c - a);
        prop_assume!(normal.length() > 0.05);
        let triangle = Triangle::new([a, b, c]).expect("a triangle");
        let ray = Ray::new(from * 4.0, to - from * 4.0);
        prop_assume!(ray.direction.dot(normal).abs() > 1e-3);
        let expected = triangle.intersect(&ray, Interval::FORWARD);
        for rule in RULES {
            let polygon = Polygon::new(vec![a, b, c], Vec::new(), rule).expect("a polygon");
            let found = polygon.intersect(&ray, Interval::FORWARD);
            prop_assert_eq!(found.is_some(), expected.is_some(), "{:?}", rule);
            let (Some(found), Some(expected)) = (found, expected) else { continue };
            prop_assert!((found.t - expected.t).abs() < 1e-11);
            let [polygon, triangle] = [
                polygon.surface(&ray, &found, InteractionFlags::ALL),
                triangle.surface(&ray, &expected, InteractionFlags::ALL),
            ];
            prop_assert!((polygon.point - triangle.point).length() < 1e-11);
            prop_assert!((polygon.geometric_normal - triangle.geometric_normal).length() < 1e-12);
        }
    }

    /// A star-shaped polygon is the union of the triangles from its centre.
    #[test]
    fn both_rules_agree_with_triangles_on_stars(
        radii in prop::collection::vec(0.2..1.0f64, 3..12), x in -1.0..1.0f64, y in -1.0..1.0f64, slant in vector(1.0),
    ) {
        let corner = |i: usize| {
            let (sin, cos) = sincos(TAU * i as f64 / radii.len() as f64);
            DVec3::new(cos, sin, 0.0) * radii[i % radii.len()]
        };
        let corners: Vec<DVec3> = (0..radii.len()).map(corner).collect();
        let direction = DVec3::new(slant.x, slant.y, -1.0);
        let ray = Ray::new(DVec3::new(x, y, 0.0) - direction, direction);
        let triangles = (0..radii.len()).filter_map(|i| Triangle::new([DVec3::ZERO, corner(i), corner(i + 1)]).ok());
        let expected = triangles.filter(|t| t.intersect(&ray, Interval::FORWARD).is_some()).count() > 0;
        for rule in NON_CONVEX {
            let star = Polygon::new(corners.clone(), Vec::new(), rule).expect("a polygon");
            prop_assert_eq!(star.intersect(&ray, Interval::FORWARD).is_some(), expected, "{:?}", rule);
        }
    }
}
