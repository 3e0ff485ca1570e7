//! Polygons.

use rt_geometry::{InsideRule, Polygon, PolygonError};
use rt_math::{DVec3, Interval, Ray, Transform, float::difference_of_products, transcendental::sincos};
use rt_tests::Draw;

use super::{Case, Checks, Conditions, Fallible, cases, exact::Dyadic};

cases! {
    "S28", "the grid of Kettner et al. (2008) along a diagonal",
        "exact signs, one owner for each of 65536 points", "0", kettner;
    "S29", "area of a concave pentagon by stratified rays", "10", "5 σ", area;
    "S30", "the middle of a pentagram", "inside by winding, outside by even-odd", "bits", pentagram;
    "S31", "a square with 1e5 corners along its sides", "the hits of a square", "bits", collinear;
    "S32", "rays at the edge of two polygons", "exactly one owner", "0", shared_edge;
}

const HALF_OPEN: [InsideRule; 2] = [InsideRule::Winding, InsideRule::EvenOdd];

fn simple(corners: &[DVec3], rule: InsideRule) -> Result<Polygon, PolygonError> {
    Polygon::new(corners.to_vec(), Vec::new(), rule)
}

fn owners(polygons: &[Polygon], ray: &Ray) -> usize {
    polygons.iter().filter(|polygon| polygon.intersect(ray, Interval::FORWARD).is_some()).count()
}

fn flat(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

fn kettner(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let [near, far] = [12.0, 24.0].map(|x| flat(x, x));
    let [start, below, above] = [flat(-2.0, -2.0), flat(30.0, -5.0), flat(-5.0, 30.0)];
    let mut plain_wrong = 0;
    for rule in HALF_OPEN {
        let pair = [simple(&[start, below, far, near], rule)?, simple(&[start, near, far, above], rule)?];
        for index in 0..65_536u32 {
            let [x, y] = [index % 256, index / 256].map(|i| 0.5 + f64::from(i) * f64::EPSILON / 2.0);
            let ray = Ray::new(DVec3::new(x, y, 1.0), DVec3::NEG_Z);
            checks.same(owners(&pair, &ray), 1, format_args!("owners of ({x:?}, {y:?})"));
            let (q, r) = (near - flat(x, y), far - flat(x, y));
            let exact = |a: f64, b: f64| &Dyadic::from(a) * &Dyadic::from(b);
            let expected = (&exact(q.x, r.y) - &exact(q.y, r.x)).signum();
            let sign = |value: f64| value.partial_cmp(&0.0).map_or(9, |order| order as i32);
            checks.same(sign(difference_of_products(q.x, r.y, q.y, r.x)), expected, "sign");
            plain_wrong += u32::from(sign(q.x * r.y - q.y * r.x) != expected);
        }
    }
    checks.note(format!("the plain expression has {plain_wrong} wrong signs of 131072"));
    Ok(())
}

/// Two random points in each cell of a grid: their difference gives the variance of the sum without bias.
fn area(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let corners = [flat(0.0, 0.0), flat(4.0, 0.0), flat(4.0, 4.0), flat(2.0, 1.0), flat(0.0, 4.0)];
    let side = conditions.count(200, 708);
    for rule in HALF_OPEN {
        let polygon = simple(&corners, rule)?;
        let cell = 4.0 / side as f64;
        let (mut hits, mut split) = (0.0, 0.0);
        for index in 0..side * side {
            let mut draw = Draw::of(29, index);
            let [left, lower] = [index % side, index / side].map(|i| i as f64 * cell);
            let [first, second] = [(); 2].map(|()| {
                let origin = DVec3::new(left + draw.unit() * cell, lower + draw.unit() * cell, 1.0);
                polygon.intersect(&Ray::new(origin, DVec3::NEG_Z), Interval::FORWARD).is_some()
            });
            hits += f64::from(u8::from(first)) + f64::from(u8::from(second));
            split += f64::from(u8::from(first != second));
        }
        let (area, error) = (hits * cell * cell / 2.0, split.sqrt() * cell * cell / 2.0);
        checks.limit((area - 10.0) / error, 5.0, format_args!("{rule:?}: area {area} ± {error}"));
        checks.tried += 2 * side * side - 1;
    }
    let polygon = simple(&corners, InsideRule::Winding)?;
    for (x, y, inside) in [(2.0, 0.5, true), (2.0, 2.0, false), (0.5, 3.0, true), (3.9, 3.7, true), (-1.0, 1.0, false)]
    {
        let ray = Ray::new(DVec3::new(x, y, 1.0), DVec3::NEG_Z);
        checks.same(polygon.intersect(&ray, Interval::FORWARD).is_some(), inside, format_args!("({x}, {y})"));
    }
    Ok(())
}

fn pentagram(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let tip = |k: u32| {
        let (sin, cos) = sincos(std::f64::consts::TAU * f64::from(2 * k % 5) / 5.0);
        flat(cos, sin)
    };
    let tips: Vec<DVec3> = (0..5).map(tip).collect();
    for (rule, middle) in [(InsideRule::Winding, Some(1.0)), (InsideRule::EvenOdd, None)] {
        let star = simple(&tips, rule)?;
        let t = |p: DVec3| star.intersect(&Ray::new(p + DVec3::Z, DVec3::NEG_Z), Interval::FORWARD).map(|hit| hit.t);
        checks.same(t(DVec3::ZERO), middle, format_args!("{rule:?}: middle"));
        for tip in &tips {
            checks.same(t(*tip * 0.6), Some(1.0), format_args!("{rule:?}: arm"));
            checks.same(t(*tip * -0.6), None, format_args!("{rule:?}: between arms"));
            checks.same(t(*tip * -0.3), middle, format_args!("{rule:?}: inner pentagon"));
        }
    }
    let refused = simple(&tips, InsideRule::Convex).is_err();
    checks.check(refused, || "a pentagram passes for convex".to_owned());
    Ok(())
}

fn collinear(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const PER_SIDE: u32 = 25_000;
    let square = [flat(0.0, 0.0), flat(1.0, 0.0), flat(1.0, 1.0), flat(0.0, 1.0)];
    // Multiples of 1/32768 keep to the sides exactly.
    let side = |k: usize| {
        let (from, to) = (square[k], square[(k + 1) % 4]);
        (0..PER_SIDE).map(move |i| from + (to - from) * (f64::from(i) / 32_768.0))
    };
    let crowded: Vec<DVec3> = (0..4).flat_map(side).collect();
    for rule in [InsideRule::Convex, InsideRule::Winding, InsideRule::EvenOdd] {
        let (plain, crowded) = (simple(&square, rule)?, simple(&crowded, rule)?);
        checks.draw_all(conditions.count(600, 20_000), 31, |draw, checks| {
            let on_side = draw.one_in(2);
            let x = if on_side { draw.pick(&[0.0, 1.0, 0.5, 1.0 / 32_768.0]) } else { draw.between(-0.1, 1.1) };
            let aim = DVec3::new(x, draw.between(-0.1, 1.1), 0.0);
            let aim = if draw.one_in(2) { DVec3::new(aim.y, aim.x, 0.0) } else { aim };
            // Straight down, corners of a side stay on a line in the image as well.
            let ray = Ray::new(aim + DVec3::Z, DVec3::NEG_Z);
            let [expected, found] = [&plain, &crowded].map(|p| p.intersect(&ray, Interval::FORWARD).map(|hit| hit.t));
            checks.same(found, expected, format_args!("{rule:?} at {aim}"));
        });
    }
    Ok(())
}

/// In a tilted plane, at offsets up to 1e4.
fn shared_edge(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let turn = Transform::rotate(DVec3::new(1.0, 0.4, -0.3), 0.7)?;
    let rays = conditions.count(40_000, 1_700_000);
    for offset in [0.0, 100.0, 1e4] {
        for rules in [HALF_OPEN, [InsideRule::Winding; 2]] {
            let place = |x: f64, y: f64| turn.point(flat(x, y)) + DVec3::new(offset, -offset, 0.7 * offset);
            let [a, b] = [place(-0.3, -2.1), place(0.4, 1.9)];
            let left = simple(&[b, place(-2.0, 3.0), place(-1.0, 0.1), place(-3.0, -3.0), a], rules[0])?;
            let right = simple(&[a, place(2.0, -3.0), place(3.0, 2.5), b], rules[1])?;
            let pair = [left, right];
            checks.draw_all(rays, 32, |draw, checks| {
                let aim = a.lerp(b, draw.between(0.01, 0.99));
                let origin = aim + turn.vector(draw.above(DVec3::Z, 0.1)) * draw.pick(&[0.5, 2.0, 30.0]);
                let ray = Ray::new(origin, aim - origin);
                checks.same(owners(&pair, &ray), 1, format_args!("{ray:?}"));
            });
        }
    }
    Ok(())
}
