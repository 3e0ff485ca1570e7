//! Polygons and triangles that share edges leave no gap between them, and where they should not, no overlap.

use rt_geometry::{InsideRule, Polygon, Triangle};
use rt_math::transcendental::sincos;
use rt_math::{DVec3, Interval, Ray, Transform, random};
use std::f64::consts::TAU;

const RULES: [InsideRule; 3] = [InsideRule::Convex, InsideRule::Winding, InsideRule::EvenOdd];
const HALF_OPEN: [InsideRule; 2] = [InsideRule::Winding, InsideRule::EvenOdd];

fn draw(ray: u64, k: u64) -> f64 {
    random::unit(random::hash(&[ray, k]))
}

fn polygon(corners: &[DVec3], rule: InsideRule) -> Polygon {
    Polygon::new(corners.to_vec(), Vec::new(), rule).expect("a polygon")
}

fn owners(polygons: &[Polygon], ray: &Ray) -> usize {
    polygons.iter().filter(|polygon| polygon.intersect(ray, Interval::FORWARD).is_some()).count()
}

/// Four polygons in a tilted plane around a corner, which fill the centre of the image: two of them concave.
fn tiles(rule: impl Fn(usize) -> InsideRule, offset: f64) -> ([Polygon; 4], [DVec3; 3]) {
    let tilt = Transform::rotate(DVec3::new(1.0, 0.4, -0.3), 0.7).expect("an axis");
    let place = |x: f64, y: f64| tilt.point(DVec3::new(x, y, 0.0)) + DVec3::new(offset, -offset, 0.7 * offset);
    let [hub, notch, rim] = [place(0.1, 0.2), place(-0.3, 0.9), place(1.1, -0.2)];
    let [a, b, c, d] = [place(-7.0, -6.0), place(8.0, -7.0), place(7.0, 6.0), place(-6.0, 8.0)];
    let foot = place(0.3, -7.3);
    let rings = [vec![hub, a, foot], vec![hub, foot, b, rim], vec![hub, rim, b, c, d, notch], vec![hub, notch, d, a]];
    let mut index = 0;
    let polygons = rings.map(|ring| {
        index += 1;
        polygon(&ring, rule(index - 1))
    });
    (polygons, [hub, notch, rim])
}

#[test]
fn a_ray_at_a_shared_edge_or_corner_in_a_plane_has_exactly_one_owner() {
    let mixed = |index: usize| HALF_OPEN[index % 2];
    for offset in [0.0, 100.0, 1e4] {
        let all =
            [tiles(|_| InsideRule::Winding, offset), tiles(|_| InsideRule::EvenOdd, offset), tiles(mixed, offset)];
        for (polygons, [hub, notch, rim]) in all {
            for ray in 0..15_000 {
                let end = if ray % 2 == 0 { notch } else { rim };
                let aim = if ray % 5 == 0 { hub } else { hub.lerp(end, draw(ray, 0)) };
                let origin = hub + (DVec3::new(draw(ray, 1), draw(ray, 2), draw(ray, 3)) - 0.5) * 4.0;
                let ray = Ray::new(origin, aim - origin);
                if ray.direction.dot(polygons[0].normal()).abs() > 1e-3 * ray.direction.length() {
                    assert_eq!(owners(&polygons, &ray), 1, "{ray:?}");
                }
            }
        }
    }
}

/// Grid of the points nearest to a diagonal that two polygons share. Source: Kettner et al., "Classroom Examples of
/// Robustness Problems in Geometric Computations", 2008.
#[test]
fn each_point_of_the_kettner_grid_has_exactly_one_owner() {
    let ulp = f64::EPSILON / 2.0;
    let [near, far] = [12.0, 24.0].map(|x| DVec3::new(x, x, 0.0));
    let start = DVec3::new(-2.0, -2.0, 0.0);
    let [below, above] = [DVec3::new(30.0, -5.0, 0.0), DVec3::new(-5.0, 30.0, 0.0)];
    for rule in HALF_OPEN {
        let pair = [polygon(&[start, below, far, near], rule), polygon(&[start, near, far, above], rule)];
        for index in 0..65_536u32 {
            let [x, y] = [index % 256, index / 256].map(|i| 0.5 + f64::from(i) * ulp);
            assert_eq!(owners(&pair, &Ray::new(DVec3::new(x, y, 1.0), DVec3::NEG_Z)), 1, "{x} {y}");
        }
    }
}

/// A closed solid: a prism over a concave outline, tilted. Caps are polygons, walls alternately polygons and pairs of
/// triangles.
struct DispersiveDielectric {
    caps: [Vec<DVec3>; 2],
    centre: DVec3,
    scale: f64,
    polygons: Vec<Polygon>,
    triangles: Vec<Triangle>,
}

impl DispersiveDielectric {
    fn new(rule: InsideRule, offset: f64, scale: f64) -> Self {
        let n = 11;
        let centre = DVec3::new(offset, offset * 0.75, -offset);
        let tilt = Transform::rotate(DVec3::new(0.3, 1.0, 0.6), 0.9).expect("an axis");
        let corner = |i: usize, z: f64| {
            let (sin, cos) = sincos(TAU * i as f64 / n as f64);
            let radius = if i % 3 == 1 && rule != InsideRule::Convex { 0.5 } else { 1.0 };
            tilt.point(DVec3::new(cos * radius, sin * radius, z)) * scale + centre
        };
        let caps = [-0.5, 0.5].map(|z| (0..n).map(|i| corner(i, z)).collect::<Vec<_>>());
        // Far away, walls and caps are bent by rounding.
        let flat = |ring: &[DVec3]| Polygon::new(ring.to_vec(), Vec::new(), rule);
        let mut polygons: Vec<Polygon> = caps.iter().map(|cap| flat(cap).expect("a cap")).collect();
        let mut triangles = Vec::new();
        for i in 0..n {
            let wall = [caps[0][i], caps[0][(i + 1) % n], caps[1][(i + 1) % n], caps[1][i]];
            if i % 2 == 0 {
                polygons.push(flat(&wall).expect("a wall"));
            } else {
                let [a, b, c, d] = wall;
                triangles.extend([[a, b, c], [a, c, d]].map(|corners| Triangle::new(corners).expect("a triangle")));
            }
        }
        Self { caps, centre, scale, polygons, triangles }
    }

    /// Rays from inside, aimed at points of edges and at corners, that hit nothing.
    fn leaks(&self, rays: u64) -> usize {
        let leaks = |ray: &u64| {
            let cap = &self.caps[(ray % 2) as usize];
            let i = (draw(*ray, 0) * cap.len() as f64) as usize;
            let end = match ray % 3 {
                0 => cap[i],
                1 => cap[(i + 1) % cap.len()],
                _ => self.caps[(1 - ray % 2) as usize][i],
            };
            let aim = cap[i].lerp(end, draw(*ray, 1));
            let inside = (DVec3::new(draw(*ray, 2), draw(*ray, 3), draw(*ray, 4)) - 0.5) * 0.5;
            let origin = self.centre + inside * self.scale;
            let ray = Ray::new(origin, aim - origin);
            owners(&self.polygons, &ray) == 0
                && !self.triangles.iter().any(|triangle| triangle.intersect(&ray, Interval::FORWARD).is_some())
        };
        (0..rays).filter(leaks).count()
    }
}

#[test]
fn no_ray_leaves_a_closed_solid_of_polygons_and_triangles() {
    let small = 1.0 / 1024.0;
    for rule in RULES {
        for (offset, scale) in [(0.0, 1.0), (100.0, 1.0), (1e4, 1.0), (0.0, 1e-6), (1e7, 1000.0), (1e3, small)] {
            // The corners of a convex polygon must be convex as they stand: a wall that rounding bent may not be.
            assert_eq!(
                DispersiveDielectric::new(rule, offset, scale).leaks(20_000),
                0,
                "{rule:?} at offset {offset}, scale {scale}"
            );
        }
    }
}

/// An edge of a polygon with the two triangles beyond it, which meet at a corner in the middle of the edge.
fn misses_at_a_junction(corner_in_edge: bool, rule: InsideRule) -> usize {
    let tilt = Transform::rotate(DVec3::new(1.0, 0.4, -0.3), 0.7).expect("an axis");
    let place = |x: f64, y: f64| tilt.point(DVec3::new(x, y, 0.0));
    let [a, b, middle] = [place(-1.0, 0.0), place(1.0, 0.0), place(0.0, 0.0).lerp(place(0.25, 0.0), 0.7)];
    let (left, right, top) = (place(-1.0, -1.0), place(1.0, -1.0), place(0.0, -1.5));
    let mut corners = vec![b, place(1.0, 1.0), place(-1.0, 1.0), a];
    if corner_in_edge {
        corners.push(middle);
    }
    let polygon = polygon(&corners, rule);
    let beyond = [[a, left, middle], [middle, left, top], [middle, top, right], [middle, right, b]]
        .map(|corners| Triangle::new(corners).expect("a triangle"));
    let missed = |ray: &u64| {
        let aim = a.lerp(b, 0.1 + 0.8 * draw(*ray, 0));
        let origin = DVec3::new(draw(*ray, 1), draw(*ray, 2), 3.0 + draw(*ray, 3));
        let ray = Ray::new(origin, aim - origin);
        polygon.intersect(&ray, Interval::FORWARD).is_none()
            && !beyond.iter().any(|triangle| triangle.intersect(&ray, Interval::FORWARD).is_some())
    };
    (0..50_000).filter(missed).count()
}

/// A corner on an edge is a gap as wide as its rounding, unless the edge has that corner as well.
#[test]
fn a_junction_is_tight_if_the_edge_has_its_corner() {
    for rule in HALF_OPEN {
        assert!(misses_at_a_junction(false, rule) > 0, "{rule:?}: rays find the gap");
        assert_eq!(misses_at_a_junction(true, rule), 0, "{rule:?}");
    }
}

/// Rounding dents the image of a straight edge with many corners, so that half-planes alone would cut off too much.
#[test]
fn convex_polygons_with_corners_on_a_straight_edge_have_no_gap() {
    let (along, across) = (DVec3::new(1.0, 2.0, 1.0), DVec3::new(3.0, -1.0, 2.0));
    let edge: Vec<DVec3> = (0..=8).map(|k| along * f64::from(k)).collect();
    let side = |sign: f64| {
        let corners = [&edge[..], &[edge[8] + across * sign, edge[0] + across * sign]].concat();
        polygon(&corners, InsideRule::Convex)
    };
    let pair = [side(5.0), side(-5.0)];
    for ray in 0..100_000 {
        let aim = along * (8.0 * draw(ray, 0));
        let origin = DVec3::new(draw(ray, 1), draw(ray, 2), draw(ray, 3)) * 40.0 - 20.0;
        assert_ne!(owners(&pair, &Ray::new(origin, aim - origin)), 0, "ray {ray}");
    }
}
