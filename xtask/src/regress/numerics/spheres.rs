//! Spheres, and what transforms do to them.

use rt_accel::Accelerator;
use rt_geometry::{InteractionFlags, NoProbe, Shape, ShapeHit, Sphere, TransformedShape};
use rt_math::{DVec3, Interval, Ray, Transform, TransformError, float::UNIT_ROUNDOFF, transcendental::exp2};
use rt_tests::{Draw, ShapeKind, ShapeSet};

use super::{Case, Checks, Conditions, FOUR_U, Fallible, Tolerance, cases, exact::Dyadic, scenes::all_accelerators};

cases! {
    "S01", "a sphere from 1e8 away, halfway to its silhouette",
        "99999999.133974596", "4u",
        |_, checks| root(1.0, [0.5, 0.0, -1e8], [0.0, 0.0, 1.0], 99_999_999.133_974_6, FOUR_U, checks);
    "S02", "8 in front of a sphere of radius 1e8",
        "8", "1e-7 abs",
        |_, checks| root(1e8, [0.0, 0.0, -1e8 - 8.0], [0.0, 0.0, 1.0], 8.0, Tolerance::Absolute(1e-7), checks);
    "S03", "1 in front of a sphere of radius 1e6, aslant", "1.2500003515626977", "1e-9",
        |_, checks| {
            let tolerance = Tolerance::Relative(1e-9);
            root(1e6, [0.0, 0.0, -1_000_001.0], [0.6, 0.0, 0.8], 1.250_000_351_562_697_6, tolerance, checks)
        };
    "S04", "a sphere of radius 1e-6 from 10 away",
        "9.9999991339745962", "4u",
        |_, checks| root(1e-6, [5e-7, 0.0, -10.0], [0.0, 0.0, 1.0], 9.999_999_133_974_596, FOUR_U, checks);
    "S05", "tangents within a step of the silhouette",
        "a hit up to x = 1, the same in all accelerators", "bits", tangents;
    "S06", "directions scaled by 2^k, k = −900…900, all shapes", "t scaled by 2^−k", "bits", scaled_directions;
    "S07", "rays that start on the sphere", "out: nothing; in: the chord 2 cos θ", "1e-12 abs", chords;
    "S08", "a sphere scaled by (1, 1e-6, 1e6) against exact arithmetic",
        "the same rays hit, at the same t", "1e12 u", needle;
    "S09", "shapes under a mirroring transform", "the mirrored hits, normals outwards", "bits", mirrored;
    "S10", "1000 turns by 1e-3 and back", "the identity", "1e-11 abs", turns;
}

fn unit_sphere() -> Result<Sphere, rt_geometry::ShapeError> {
    Sphere::new(DVec3::ZERO, 1.0)
}

fn root(
    radius: f64,
    origin: [f64; 3],
    direction: [f64; 3],
    expected: f64,
    tolerance: Tolerance,
    checks: &mut Checks,
) -> Fallible<()> {
    let sphere = Sphere::new(DVec3::ZERO, radius)?;
    let hit = sphere.intersect(&Ray::new(origin.into(), direction.into()), Interval::FORWARD);
    checks.hit(hit.map(|hit| hit.t), expected, tolerance, "t");
    Ok(())
}

/// Beyond the silhouette nothing may be hit, and all must agree wherever the ray starts.
fn tangents(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let set = ShapeSet::of_shapes([Shape::Sphere(unit_sphere()?)]);
    let accelerators = all_accelerators(&set)?;
    for distance in [0.0, 1.0, 5.0, 1e3, 1e8, 1e15] {
        let mut x = 1.0 - 4.0 * f64::EPSILON;
        while x < 1.0 + 8.0 * f64::EPSILON {
            for turn in 0..3 {
                let axes = |v: [f64; 3]| DVec3::new(v[turn], v[(turn + 1) % 3], v[(turn + 2) % 3]);
                let ray = Ray::new(axes([x, 0.0, -distance]), axes([0.0, 0.0, 1.0]));
                for accelerator in &accelerators {
                    let hit = accelerator.closest(&set, &ray, Interval::FORWARD, &mut NoProbe);
                    // From its closest point the ray meets the sphere at 0 only if it is a tangent.
                    let expected = if x <= 1.0 && (distance > 0.0 || x == 1.0) { Some(true) } else { None };
                    let expected = if distance == 0.0 && x < 1.0 { Some(true) } else { expected };
                    checks.same(hit.map(|_| true), expected, format_args!("{} at {x:?}", accelerator.kind().name()));
                }
            }
            x = x.next_up();
        }
    }
    Ok(())
}

fn scaled_directions(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let rays = conditions.count(20, 200);
    let mut draw = Draw::new(6);
    for kind in ShapeKind::ALL {
        let mut hits = 0;
        while hits < rays {
            let Some(shape) = kind.shape(&mut draw) else { continue };
            let origin = draw.point() * 4.0;
            let ray = Ray::new(origin, draw.point() - origin);
            let Some(hit) = shape.intersect(&ray, Interval::FORWARD) else { continue };
            hits += 1;
            for k in -900..=900 {
                let scaled = Ray::new(origin, ray.direction * exp2(f64::from(k)));
                let t = shape.intersect(&scaled, Interval::FORWARD).map(|hit| hit.t);
                let expected = hit.t * exp2(f64::from(-k));
                checks.hit(t, expected, Tolerance::Bits, format_args!("{} at 2^{k}", kind.name));
            }
        }
    }
    Ok(())
}

fn chords(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let sphere = unit_sphere()?;
    checks.draw_all(conditions.count(50_000, 1_000_000), 7, |draw, checks| {
        let arriving = draw.direction() * 3.0;
        let aim = draw.point() * 0.5;
        let ray = Ray::new(arriving, aim - arriving);
        let Some(hit) = sphere.intersect(&ray, Interval::FORWARD) else {
            checks.check(false, || format!("a miss towards {aim}"));
            return;
        };
        let surface = sphere.surface(&ray, &hit, InteractionFlags::ALL);
        let outwards = draw.above(surface.geometric_normal, 1e-6);
        let leaving = sphere.intersect(&surface.spawn_ray(outwards, 0.0), Interval::SPAWNED);
        checks.check(leaving.is_none(), || format!("a self-hit towards {outwards}"));
        // The origin is off the surface by its rounding, which the chord magnifies by 1 / cos θ.
        let inwards = -draw.above(surface.geometric_normal, 1e-2);
        let entering = surface.spawn_ray(inwards, 0.0);
        let chord = -2.0 * surface.geometric_normal.dot(inwards);
        let far = sphere.intersect(&entering, Interval::SPAWNED).map(|hit| hit.t);
        checks.hit(far, chord, Tolerance::Absolute(1e-12), "chord");
    });
    Ok(())
}

/// The quadratic of a ray and the ellipsoid x²/a² + y²/b² + z²/c² = 1, times (abc)², without rounding: `a·t² − 2b·t + c`.
struct ExactQuadratic {
    a: Dyadic,
    b: Dyadic,
    c: Dyadic,
}

impl ExactQuadratic {
    fn new(axes: [f64; 3], ray: &Ray) -> Self {
        let squares = axes.map(|axis| &Dyadic::from(axis) * &Dyadic::from(axis));
        let weights = [0, 1, 2].map(|i| &squares[(i + 1) % 3] * &squares[(i + 2) % 3]);
        let dot = |p: DVec3, q: DVec3| {
            let term = |i: usize| &weights[i] * &(&Dyadic::from(p[i]) * &Dyadic::from(q[i]));
            &(&term(0) + &term(1)) + &term(2)
        };
        let all = &(&squares[0] * &squares[1]) * &squares[2];
        let c = &dot(ray.origin, ray.origin) - &all;
        Self { a: dot(ray.direction, ray.direction), b: dot(ray.origin, -ray.direction), c }
    }

    fn discriminant(&self) -> Dyadic {
        &(&self.b * &self.b) - &(&self.a * &self.c)
    }

    /// Relative distance of the discriminant from 0.
    fn margin(&self) -> f64 {
        self.discriminant().to_f64().abs() / (&self.b * &self.b).to_f64()
    }

    /// Relative distance of `t` from the nearest root, to first order: residual over slope.
    fn error_of(&self, t: f64) -> f64 {
        let t = Dyadic::from(t);
        let at = &self.a * &t;
        let residual = &(&t * &(&at - &(&self.b + &self.b))) + &self.c;
        let slope = &at - &self.b;
        residual.to_f64() / (2.0 * slope.to_f64() * t.to_f64())
    }
}

fn needle(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const AXES: [f64; 3] = [1.0, 1e-6, 1e6];
    const LIMIT: f64 = 1e12 * UNIT_ROUNDOFF;
    let placed = TransformedShape::new(Shape::Sphere(unit_sphere()?), Transform::scale(AXES.into())?);
    checks.draw_all(conditions.count(5_000, 100_000), 8, |draw, checks| {
        let stretch = DVec3::from(AXES);
        let origin = draw.point() * stretch * draw.pick(&[1.5, 3.0, 100.0]);
        // Towards a point within or just outside of the ellipsoid.
        let aim = draw.direction() * stretch * draw.pick(&[0.3, 0.99, 1.0, 1.01, 1.5]);
        let ray = Ray::new(origin, aim - origin);
        let exact = ExactQuadratic::new(AXES, &ray);
        let (starts_outside, leads_towards) = (exact.c.signum() > 0, exact.b.signum() > 0);
        let expected = exact.discriminant().signum() >= 0 && (leads_towards || !starts_outside);
        let hit = placed.intersect(&ray, Interval::FORWARD);
        let undecided = exact.margin() <= LIMIT;
        checks.check(hit.is_some() == expected || undecided, || format!("hit: {}, exactly: {expected}", hit.is_some()));
        if let (Some(ShapeHit { t, .. }), false) = (hit, undecided) {
            checks.limit(exact.error_of(t), LIMIT, format_args!("t = {t:?}"));
        }
    });
    let beyond = Transform::scale(DVec3::new(1.0, 1e-7, 1e6));
    let refused = matches!(beyond, Err(TransformError::Singular(_)));
    checks.check(refused, || "a condition number of 1e13 must be refused".to_owned());
    Ok(())
}

fn mirrored(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let mirror = Transform::scale(DVec3::new(-1.0, 1.0, 1.0))?;
    let flip = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
    checks.of_all(conditions.count(5_000, 100_000), |index, checks| {
        let mut draw = Draw::of(9, index);
        let kind = ShapeKind::ALL[index as usize % ShapeKind::ALL.len()];
        let Some(shape) = kind.shape(&mut draw) else { return };
        let origin = draw.point() * 4.0;
        let ray = Ray::new(origin, draw.point() - origin);
        let reflection = Ray::new(flip(ray.origin), flip(ray.direction));
        let image = TransformedShape::new(shape.clone(), mirror);
        let original = TransformedShape::new(shape, Transform::IDENTITY);
        let [expected, found] = [(&original, &ray), (&image, &reflection)].map(|(placed, ray)| {
            let hit = placed.intersect(ray, Interval::FORWARD)?;
            let surface = placed.surface(ray, &hit, InteractionFlags::ALL);
            Some((hit.t, surface.point, surface.geometric_normal))
        });
        let expected = expected.map(|(t, point, normal)| (t, flip(point), flip(normal)));
        checks.same(found, expected, kind.name);
    });
    Ok(())
}

fn turns(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0)] {
        let turn = Transform::rotate(axis, 1e-3)?;
        let mut all = Transform::IDENTITY;
        for _ in 0..1000 {
            all = all.compose(&turn);
        }
        for _ in 0..1000 {
            all = all.compose(&turn.inverse());
        }
        for unit in DVec3::AXES {
            let error = (all.vector(unit) - unit).length().max((all.inverse_vector(unit) - unit).length());
            checks.limit(error, 1e-11, format_args!("{unit} about {axis}"));
        }
    }
    Ok(())
}
