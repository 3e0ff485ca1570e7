//! Accuracy against series in integers, special values, and equality of lanes.

mod lanes;
mod truth;

use super::*;
use crate::random::{hash, unit};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use truth::Truth;

/// Random numbers of a test; its seed is printed with the worst argument.
struct Random {
    seed: u64,
    index: u64,
}

impl Random {
    fn new(seed: u64) -> Self {
        Self { seed, index: 0 }
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.index += 1;
        low + (high - low) * unit(hash(&[self.seed, self.index]))
    }

    /// Absolute value with a uniform exponent from `2^low` to `2^high`, and a random sign.
    fn any_size(&mut self, low: f64, high: f64) -> f64 {
        let size = libm::exp2(self.uniform(low, high).trunc()) * self.uniform(1.0, 2.0);
        if self.uniform(0.0, 1.0) < 0.5 { -size } else { size }
    }
}

/// Prints the greatest error in ulp and its argument, and compares it with the bound.
fn check<A: Copy + core::fmt::Debug>(
    name: &str,
    bound: f64,
    seed: u64,
    arguments: impl IntoIterator<Item = A>,
    function: impl Fn(A) -> f64,
    truth: impl Fn(A) -> Truth,
) {
    let (mut worst, mut at, mut count) = (0.0, None, 0);
    for argument in arguments {
        let error = truth(argument).error_in_ulp(function(argument));
        count += 1;
        if error > worst {
            (worst, at) = (error, Some(argument));
        }
    }
    println!("{name}: {worst:.4} ulp at {at:?}, {count} arguments, seed {seed}");
    assert!(worst <= bound, "{name}: {worst} ulp at {at:?}, seed {seed}");
}

/// Arguments of each check; `RT_DENSE` multiplies them.
fn count() -> usize {
    2000 * std::env::var("RT_DENSE").map_or(1, |factor| factor.parse().unwrap())
}

fn numbers(seed: u64, mut draw: impl FnMut(&mut Random) -> f64) -> impl Iterator<Item = f64> {
    let mut random = Random::new(seed);
    (0..count()).map(move |_| draw(&mut random))
}

fn pairs(seed: u64, mut draw: impl FnMut(&mut Random) -> (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
    let mut random = Random::new(seed);
    (0..count()).map(move |_| draw(&mut random))
}

/// Multiples of `step` and the numbers around them.
fn near_multiples(step: f64, count: i32) -> impl Iterator<Item = f64> {
    (1..=count).flat_map(move |k| {
        let x = step * f64::from(k);
        [x.next_down().next_down(), x.next_down(), x, x.next_up(), x.next_up().next_up()]
    })
}

#[test]
fn sine_and_cosine_are_within_their_bounds() {
    for (seed, size) in [(1, FRAC_PI_4), (2, 2.0 * PI), (3, 1e3), (4, 1e4), (5, 1e9)] {
        check("sin", 0.85, seed, numbers(seed, |r| r.uniform(-size, size)), sin, Truth::sin);
        check("cos", 0.85, seed, numbers(seed, |r| r.uniform(-size, size)), cos, Truth::cos);
    }
    check("sin", 0.85, 6, numbers(6, |r| r.any_size(-60.0, 14.0)), sin, Truth::sin);
    check("cos", 0.85, 6, numbers(6, |r| r.any_size(-60.0, 14.0)), cos, Truth::cos);
    check("sin near multiples of π/4", 0.85, 0, near_multiples(FRAC_PI_4, 13_000), sin, Truth::sin);
    check("cos near multiples of π/4", 0.85, 0, near_multiples(FRAC_PI_4, 13_000), cos, Truth::cos);
}

#[test]
fn inverse_functions_are_within_their_bounds() {
    for (seed, low, high) in [(11, -1.0, 1.0), (12, 0.3, 0.6), (13, 1.0, 3.0), (14, 3.0, 100.0)] {
        check("atan", 0.8, seed, numbers(seed, |r| r.uniform(low, high)), atan, Truth::atan);
    }
    check("atan", 0.8, 15, numbers(15, |r| r.any_size(-60.0, 80.0)), atan, Truth::atan);
    let atan2 = |(y, x): (f64, f64)| atan2(y, x);
    let true_atan2 = |(y, x): (f64, f64)| Truth::atan2(y, x);
    let square = |r: &mut Random| (r.uniform(-1.0, 1.0), r.uniform(-1.0, 1.0));
    check("atan2", 0.8, 16, pairs(16, square), atan2, true_atan2);
    let any_size = |r: &mut Random| {
        let size = r.any_size(-300.0, 300.0);
        (size * r.any_size(-40.0, 1.0), size * r.any_size(-40.0, 1.0))
    };
    check("atan2", 0.8, 17, pairs(17, any_size), atan2, true_atan2);
    let near_breaks = |r: &mut Random| {
        let x = r.uniform(1.0, 2.0);
        (x * r.uniform(0.41, 0.42), x)
    };
    check("atan2 near tan(π/8)", 0.8, 18, pairs(18, near_breaks), atan2, true_atan2);

    for (seed, low, high) in
        [(21, -1.0, 1.0), (22, 0.45, 0.55), (23, -0.55, -0.45), (24, 0.999, 1.0), (25, -1.0, -0.999)]
    {
        check("asin", 0.8, seed, numbers(seed, |r| r.uniform(low, high)), asin, Truth::asin);
        check("acos", 0.8, seed, numbers(seed, |r| r.uniform(low, high)), acos, Truth::acos);
    }
    check("asin", 0.8, 26, numbers(26, |r| r.any_size(-60.0, -1.0)), asin, Truth::asin);
    check("acos", 0.8, 26, numbers(26, |r| r.any_size(-60.0, -1.0)), acos, Truth::acos);
    let near_one = |r: &mut Random| 1.0 - r.any_size(-53.0, -10.0).abs();
    check("asin near 1", 0.8, 27, numbers(27, near_one), asin, Truth::asin);
    check("acos near 1", 0.8, 27, numbers(27, near_one), acos, Truth::acos);
}

#[test]
fn exponential_functions_are_within_their_bounds() {
    for (seed, size) in [(31, 0.35), (32, 1.0), (33, 20.0), (34, 708.0)] {
        check("exp", 0.8, seed, numbers(seed, |r| r.uniform(-size, size)), exp, Truth::exp);
        check("exp2", 0.8, seed, numbers(seed, |r| r.uniform(-size, size)), exp2, Truth::exp2);
    }
    check("exp", 0.8, 35, numbers(35, |r| r.any_size(-70.0, 9.0)), exp, Truth::exp);
    check("exp2", 0.8, 35, numbers(35, |r| r.any_size(-70.0, 9.0)), exp2, Truth::exp2);
    check("exp, subnormal", 1.0, 36, numbers(36, |r| r.uniform(-745.1, -708.4)), exp, Truth::exp);
    check("exp2, subnormal", 1.0, 36, numbers(36, |r| r.uniform(-1075.0, -1022.0)), exp2, Truth::exp2);
    check("exp, large", 0.8, 37, numbers(37, |r| r.uniform(700.0, 709.78)), exp, Truth::exp);
    check(
        "exp near multiples of ln 2 / 2",
        0.8,
        0,
        near_multiples(core::f64::consts::LN_2 / 2.0, 1000),
        exp,
        Truth::exp,
    );
}

#[test]
fn logarithms_are_within_their_bounds() {
    for (seed, low, high) in [(41, 0.7, 1.5), (42, 0.99, 1.01), (43, 1.3, 1.45), (44, 0.0, 1.0), (45, 0.0, 1e6)] {
        check("log", 0.9, seed, numbers(seed, |r| r.uniform(low, high)), log, Truth::log);
        check("log2", 0.85, seed, numbers(seed, |r| r.uniform(low, high)), log2, Truth::log2);
    }
    check("log", 0.9, 46, numbers(46, |r| r.any_size(-1022.0, 1024.0).abs()), log, Truth::log);
    check("log2", 0.85, 46, numbers(46, |r| r.any_size(-1022.0, 1024.0).abs()), log2, Truth::log2);
    check("log near 1", 0.9, 47, numbers(47, |r| 1.0 + r.any_size(-52.0, -5.0)), log, Truth::log);
    check("log2 near 1", 0.85, 47, numbers(47, |r| 1.0 + r.any_size(-52.0, -5.0)), log2, Truth::log2);
    check("log, subnormal", 0.9, 48, numbers(48, |r| r.any_size(-1074.0, -1022.0).abs()), log, Truth::log);
    check("log2, subnormal", 0.85, 48, numbers(48, |r| r.any_size(-1074.0, -1022.0).abs()), log2, Truth::log2);
}

#[test]
fn powers_are_within_their_bounds() {
    let pow = |(x, y): (f64, f64)| pow(x, y);
    let truth = |(x, y): (f64, f64)| Truth::pow(x, y);
    let ranges = [(51, 1.0, 3.0), (52, 2.0, 20.0), (53, 1e3, 1.0), (54, 1.0, 1000.0), (55, 10.0, 300.0)];
    for (seed, base, exponent) in ranges {
        let draw = |r: &mut Random| (r.uniform(1e-3, base), r.uniform(-exponent, exponent));
        let is_normal = |&(x, y): &(f64, f64)| libm::pow(x, y).is_normal();
        check("pow", 0.8, seed, pairs(seed, draw).filter(is_normal), pow, truth);
    }
    // Results over the whole range: x to the power of t / log₂ x.
    let wide = |r: &mut Random| {
        let x = r.any_size(-1022.0, 1024.0).abs();
        (x, r.uniform(-1021.0, 1023.0) / libm::log2(x))
    };
    let is_possible = |&(_, y): &(f64, f64)| y.is_finite();
    check("pow, wide", 0.8, 56, pairs(56, wide).filter(is_possible), pow, truth);
    let near_one = |r: &mut Random| {
        let x = 1.0 + r.any_size(-50.0, -8.0);
        (x, r.uniform(-1021.0, 1023.0) / libm::log2(x))
    };
    check("pow near 1", 0.8, 57, pairs(57, near_one).filter(is_possible), pow, truth);
    let subnormal = |r: &mut Random| {
        let x = r.uniform(0.1, 0.9);
        (x, r.uniform(-1074.0, -1022.0) / libm::log2(x))
    };
    check("pow, subnormal", 1.0, 58, pairs(58, subnormal), pow, truth);
    let gamma = |r: &mut Random| {
        (r.uniform(0.0, 1.0), [2.4, 1.0 / 2.4, 2.2, 1.0 / 2.2, 0.5, 1.5][r.uniform(0.0, 6.0) as usize])
    };
    check("pow, tone curves", 0.8, 59, pairs(59, gamma), pow, truth);
}

/// Finite and other numbers at the edges of all domains.
fn special_values() -> Vec<f64> {
    let positive = [
        0.0,
        5e-324,
        1e-310,
        f64::MIN_POSITIVE,
        1e-300,
        1e-160,
        1e-20,
        0.5,
        0.5f64.next_down(),
        1.0f64.next_down(),
        1.0,
        1.0f64.next_up(),
        1.5,
        2.0,
        3.0,
        FRAC_PI_4,
        FRAC_PI_2,
        PI,
        1e4,
        1e4f64.next_up(),
        1e6,
        1e15,
        1e17,
        1e20,
        1e22,
        709.0,
        710.0,
        745.0,
        746.0,
        1023.0,
        1024.0,
        1074.0,
        1075.0,
        1e160,
        1e300,
        f64::MAX,
        f64::INFINITY,
        f64::NAN,
    ];
    positive.iter().flat_map(|&x| [x, -x]).collect()
}

/// Same value, for zeros of the same sign, or both NaN; or finite numbers up to two steps apart.
fn is_close(a: f64, b: f64) -> bool {
    let steps = (a.to_bits() as i64).wrapping_sub(b.to_bits() as i64).unsigned_abs();
    a.to_bits() == b.to_bits()
        || (a.is_nan() && b.is_nan())
        || (a.is_finite() && b.is_finite() && a != 0.0 && steps <= 2)
}

#[test]
fn special_values_give_those_of_libm() {
    type Function = fn(f64) -> f64;
    let functions: [(&str, Function, Function); 10] = [
        ("sin", sin, libm::sin),
        ("cos", cos, libm::cos),
        ("atan", atan, libm::atan),
        ("asin", asin, libm::asin),
        ("acos", acos, libm::acos),
        ("exp", exp, libm::exp),
        ("exp2", exp2, libm::exp2),
        ("log", log, libm::log),
        ("log2", log2, libm::log2),
        ("sincos", |x| sincos(x).1, libm::cos),
    ];
    for (name, ours, theirs) in functions {
        for x in special_values() {
            assert!(is_close(ours(x), theirs(x)), "{name}({x:?}): {:?}, {:?}", ours(x), theirs(x));
        }
    }
    for x in special_values() {
        for y in special_values() {
            assert!(is_close(atan2(y, x), libm::atan2(y, x)), "atan2({y:?}, {x:?}): {:?}", atan2(y, x));
            assert!(is_close(pow(x, y), libm::pow(x, y)), "pow({x:?}, {y:?}): {:?}", pow(x, y));
        }
    }
}

#[test]
fn random_values_are_near_those_of_libm() {
    let mut random = Random::new(61);
    for _ in 0..100_000 {
        let (x, y) = (random.any_size(-30.0, 30.0), random.any_size(-30.0, 30.0));
        let unit = random.uniform(-1.0, 1.0);
        for (name, ours, theirs) in [
            ("sin", sin(x), libm::sin(x)),
            ("cos", cos(x), libm::cos(x)),
            ("atan", atan(x), libm::atan(x)),
            ("atan2", atan2(y, x), libm::atan2(y, x)),
            ("asin", asin(unit), libm::asin(unit)),
            ("acos", acos(unit), libm::acos(unit)),
            ("exp", exp(x), libm::exp(x)),
            ("exp2", exp2(x), libm::exp2(x)),
            ("log", log(x), libm::log(x)),
            ("log2", log2(x), libm::log2(x)),
            ("pow", pow(x.abs(), unit), libm::pow(x.abs(), unit)),
        ] {
            assert!(is_close(ours, theirs), "{name}, {x:?}, {y:?}, {unit:?}: {ours:?}, {theirs:?}");
        }
    }
}

#[test]
fn exact_values_are_exact() {
    let same = |a: f64, b: f64| assert_eq!(a.to_bits(), b.to_bits(), "{a:?}, {b:?}");
    for zero in [0.0, -0.0] {
        same(sin(zero), zero);
        same(cos(zero), 1.0);
        same(atan(zero), zero);
        same(asin(zero), zero);
        same(exp(zero), 1.0);
        same(exp2(zero), 1.0);
        same(atan2(zero, 1.0), zero);
        same(atan2(zero, -1.0), PI.copysign(zero));
        same(atan2(1.0, zero), FRAC_PI_2);
        same(atan2(-1.0, zero), -FRAC_PI_2);
    }
    same(acos(1.0), 0.0);
    same(acos(-1.0), PI);
    same(acos(0.0), FRAC_PI_2);
    same(asin(1.0), FRAC_PI_2);
    same(asin(-1.0), -FRAC_PI_2);
    same(atan(1.0), FRAC_PI_4);
    same(atan2(1.0, -1.0), 3.0 * FRAC_PI_4);
    same(log(1.0), 0.0);
    same(log2(1.0), 0.0);
    for n in -1074..=1023 {
        let power = libm::ldexp(1.0, n);
        same(exp2(f64::from(n)), power);
        same(log2(power), f64::from(n));
        same(pow(2.0, f64::from(n)), power);
    }
}

#[test]
fn powers_that_are_numbers_are_exact() {
    let mut random = Random::new(71);
    for _ in 0..20_000 {
        let x = random.any_size(-300.0, 300.0).abs();
        assert_eq!((pow(x, 0.0), pow(x, 1.0), pow(1.0, x)), (1.0, x, 1.0));
        // Squares, cubes and fourth powers of numbers of 13 bits, and roots of squares.
        let short = f64::from_bits((x.to_bits() >> 40) << 40);
        for (y, power) in [(2.0, short * short), (3.0, short * short * short), (4.0, (short * short) * (short * short))]
        {
            assert_eq!(pow(short, y), power, "{short:?}, seed {}", random.seed);
        }
        assert_eq!(pow(short * short, 0.5), short);
    }
    for (x, n) in [(10.0, 22), (3.0, 33), (5.0, 22), (7.0, 18), (0.5, 1022)] {
        let mut power = 1.0;
        for n in 0..=n {
            assert_eq!(pow(x, f64::from(n)), power);
            assert_eq!(pow(-x, f64::from(n)), if n % 2 == 0 { power } else { -power });
            power *= x;
        }
    }
}

#[test]
fn functions_are_odd_or_even() {
    let mut random = Random::new(81);
    for _ in 0..20_000 {
        let (x, y) = (random.any_size(-40.0, 40.0), random.any_size(-40.0, 40.0));
        assert_eq!((sin(-x), cos(-x), atan(-x)), (-sin(x), cos(x), -atan(x)));
        assert_eq!(sincos(x), (sin(x), cos(x)));
        assert_eq!(atan2(-y, x), -atan2(y, x));
        let unit = random.uniform(-1.0, 1.0);
        assert_eq!(asin(-unit), -asin(unit));
    }
}
