//! Hits of rays that graze a triangle, compared with integer arithmetic from the same numbers.

use num_bigint::{BigInt, Sign};
use rt_geometry::{ShapeHit, WatertightRay};
use rt_math::{DVec3, Interval, Ray, random};

/// Binary digits of fixed-point numbers behind the point.
const FRACTION: i64 = 160;

/// Fixed-point number of `x`, without rounding.
fn fixed(x: f64) -> BigInt {
    let bits = x.to_bits();
    let (biased, fraction) = ((bits >> 52 & 0x7ff) as i64, (bits & ((1 << 52) - 1)) as i64);
    if biased == 0 && fraction == 0 {
        return BigInt::from(0);
    }
    let (mantissa, shift) = (fraction | 1 << 52, biased - 1075 + FRACTION);
    assert!(biased > 0 && shift >= 0, "{x} has digits behind the last one");
    BigInt::from(if x < 0.0 { -mantissa } else { mantissa }) << shift as u64
}

type Vector = [BigInt; 3];

fn vector(v: DVec3) -> Vector {
    v.to_array().map(fixed)
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Parameter of the plane as a quotient of positive divisor; `None` unless the line of the ray crosses the closed triangle.
fn exact_crossing(triangle: [DVec3; 3], ray: &Ray) -> Option<[BigInt; 2]> {
    let (o, d) = (vector(ray.origin), vector(ray.direction));
    let [a, b, c] = triangle.map(|vertex| minus(&vector(vertex), &o));
    let signs = [(&c, &b), (&a, &c), (&b, &a)].map(|(p, q)| dot(&d, &cross(p, q)).sign());
    if signs.contains(&Sign::Minus) && signs.contains(&Sign::Plus) {
        return None;
    }
    let normal = cross(&minus(&b, &a), &minus(&c, &a));
    let (numerator, divisor) = (dot(&a, &normal), dot(&d, &normal));
    match divisor.sign() {
        Sign::NoSign => None,
        Sign::Plus => Some([numerator, divisor]),
        Sign::Minus => Some([-numerator, -divisor]),
    }
}

fn hit(triangle: [DVec3; 3], ray: &Ray, span: Interval) -> Option<ShapeHit> {
    WatertightRay::new(ray).intersect(triangle, span)
}

/// Compares a hit with integers. Returns 1 if the ray hits.
fn check(context: u64, triangle: [DVec3; 3], ray: &Ray, accuracy: f64) -> usize {
    let expected = exact_crossing(triangle, ray).filter(|[numerator, _]| numerator.sign() != Sign::Minus);
    let found = hit(triangle, ray, Interval::FORWARD);
    assert_eq!(found.is_some(), expected.is_some(), "{context}: {found:?} of {ray:?}, {triangle:?}");
    let Some((ShapeHit { t, .. }, [numerator, divisor])) = found.zip(expected) else { return 0 };
    // An error of t is that of the product with the divisor.
    let reach = triangle.map(|vertex| (vertex - ray.origin).abs().max_element()).into_iter().fold(0.0, f64::max);
    let error = (fixed(t.max(1e-30)) * &divisor - (numerator << FRACTION as u64)).magnitude().clone();
    let bound = (fixed(accuracy * reach / ray.direction.abs().max_element()) * divisor).magnitude().clone();
    assert!(error <= bound, "{context}: {t} of {ray:?}, {triangle:?}");
    1
}

fn draw(seed: u64, k: u64) -> f64 {
    2.0 * random::unit(random::hash(&[seed, k])) - 1.0
}

fn draw_vector(seed: u64, k: u64) -> DVec3 {
    DVec3::new(draw(seed, k), draw(seed, k + 1), draw(seed, k + 2))
}

/// Ray that starts near a point of a triangle and makes this angle with its plane.
fn grazing_ray([a, b, c]: [DVec3; 3], tilt: f64, seed: u64) -> Ray {
    let [v, w] = [20, 21].map(|k| 0.5 + 0.5 * draw(seed, k));
    let [v, w] = if v + w > 1.0 { [1.0 - v, 1.0 - w] } else { [v, w] };
    let point = a + (b - a) * v + (c - a) * w;
    let normal = (b - a).cross(c - a).normalize();
    let along = ((b - a) * draw(seed, 22) + (c - a) * draw(seed, 23)).normalize();
    let direction = along + normal * (tilt * draw(seed, 24).signum());
    Ray::new(point - direction * (draw(seed, 25) * 0.2), direction)
}

/// Regression: areas that hardly exceeded their error bound were weights, so that `t` had the wrong sign.
#[test]
fn a_grazing_ray_that_starts_before_the_plane_hits_and_one_beyond_it_misses() {
    let lost = [
        DVec3::new(-0.6012751874207243, 0.3996386679688386, -0.8352188634409667),
        DVec3::new(-0.30653398750083793, -0.6256844242723978, 0.15223384436512978),
        DVec3::new(-0.5703663308185756, -0.1961646399573449, 0.9405887139785873),
    ];
    let ray = Ray::new(
        DVec3::new(-0.4681471573589128, -0.2432612265654471, 0.2265188929032565),
        DVec3::new(-0.22385098070238, 0.7436742093213375, -0.6299519099335013),
    );
    assert_eq!(check(0, lost, &ray, 1e-5), 1);
    let invented = [
        DVec3::new(0.1830636413144633, -0.8026623858894875, -0.3922307680588495),
        DVec3::new(0.32444287308198794, 0.1620673542527118, -0.7041616054768947),
        DVec3::new(-0.44603452552495604, -0.7126284554816487, 0.2643790810897442),
    ];
    let ray = Ray::new(
        DVec3::new(-0.03998584734874347, -0.4118609086639502, -0.21931603317331527),
        DVec3::new(0.47480694260112793, 0.6320869421043919, -0.6123924108599714),
    );
    assert_eq!(check(1, invented, &ray, 1e-5), 0);
}

/// Regression: one in a thousand rays at 10⁻¹⁴ to a plane was on its wrong side. `t` was off by the size of the triangle.
#[test]
fn grazing_rays_have_the_exact_sides_of_planes_and_accurate_parameters() {
    for tilt in [1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-8] {
        let mut n_hits = 0;
        for seed in 0..3_000 {
            let triangle = [0, 3, 6].map(|k| draw_vector(seed, k));
            n_hits += check(seed, triangle, &grazing_ray(triangle, tilt, seed), 1.0 / (1 << 16) as f64);
        }
        assert!(n_hits > 300, "{n_hits} hits at {tilt}");
    }
}

/// Regression: the same of needles.
#[test]
fn rays_at_needles_have_the_exact_sides_of_planes() {
    for width in [1e-15, 1e-14, 1e-13, 1e-12, 1e-11] {
        let mut n_hits = 0;
        for seed in 0..3_000 {
            let (a, b) = (draw_vector(seed, 0), draw_vector(seed, 3));
            let triangle = [a, b, a.lerp(b, 0.3 + 0.2 * draw(seed, 9)) + draw_vector(seed, 6) * width];
            n_hits += check(seed, triangle, &grazing_ray(triangle, 0.01, seed), 1.0 / (1 << 16) as f64);
        }
        assert!(n_hits > 30, "{n_hits} hits at {width}");
    }
}

/// Regression: the weights of the ends of an edge were rounded coordinates across the ray, all of whose digits were noise.
#[test]
fn a_ray_through_an_edge_that_runs_along_it_within_rounding_hits_it_at_the_right_place() {
    let triangle = [[0.2, 0.0, -0.1], [-0.30000000000000004, 0.0, 0.1], [0.0, 0.30000000000000004, 0.1]];
    let triangle = triangle.map(DVec3::from_array);
    let ray = Ray::new(DVec3::new(0.7000000000000001, 0.0, -0.30000000000000004), DVec3::new(-0.5, 0.0, 0.2));
    let found = hit(triangle, &ray, Interval::FORWARD).expect("a hit");
    assert!((found.t - 1.25).abs() < 1e-15, "{found:?}");
    assert_eq!(check(0, triangle, &ray, 1e-15), 1);
    assert!(hit(triangle, &ray, Interval::new(0.0, 1.9)).is_some());

    let (ulp, mut n_hits) = (1.0 / (1u64 << 50) as f64, 0);
    for seed in 0..6_000 {
        let integer = |k: u64, largest: u64| (random::hash(&[seed, k]) % (2 * largest + 1)) as f64 - largest as f64;
        let integers =
            |k: u64, largest: u64| DVec3::new(integer(k, largest), integer(k + 1, largest), integer(k + 2, largest));
        // Exact numbers: the ends are next to the ray, on opposite sides in one plane with it.
        let (origin, direction, aside) = (integers(0, 1), integers(3, 2), integers(6, 3) * ulp);
        let start = 0.25 * (1.0 + (random::hash(&[seed, 9]) % 4) as f64);
        let a = origin + direction * start + aside * (1.0 + integer(10, 3).abs());
        let b = origin + direction * (start + 0.75) - aside * (1.0 + integer(11, 3).abs());
        let ray = Ray::new(origin, direction);
        let hits = [12, 15, 18].map(|k| {
            let third = draw_vector(seed, k);
            exact_crossing([a, b, third], &ray)?;
            n_hits += check(seed, [a, b, third], &ray, 4e-15);
            let [one, other] = [[a, b, third], [b, third, a]].map(|corners| hit(corners, &ray, Interval::FORWARD));
            assert_eq!(one.map(|hit| hit.t), other.map(|hit| hit.t), "{seed}");
            one.map(|hit| hit.t)
        });
        let mut all = hits.into_iter().flatten();
        let first = all.next();
        assert!(all.all(|other| Some(other) == first), "{seed}: {hits:?}");
    }
    assert!(n_hits > 10_000, "{n_hits}");
}
