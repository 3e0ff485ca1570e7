//! Boxes and planes.

use rt_accel::Accelerator;
use rt_geometry::{Cuboid, InteractionFlags, NoProbe, Plane, Shape};
use rt_math::{DVec3, Interval, Ray, float::UNIT_ROUNDOFF};
use rt_tests::ShapeSet;

use super::{Case, Checks, Conditions, Fallible, Tolerance, cases, scenes::all_accelerators};

cases! {
    "S11", "the diagonal of a box", "t = 1 on face x, then 2", "bits", diagonal;
    "S12", "rays in the planes of a box's faces, ±0 across", "the box is closed: t = 1, 0, 0.5", "bits", in_face_planes;
    "S13", "boxes of thickness 0 and 1e-300", "t = 1, the normal of the flat side", "bits", flat_boxes;
    "S14", "a plane at a grazing angle of 1e-12", "t = 1e12", "2u", horizon;
    "S15", "two coplanar planes", "the first everywhere", "bits", coplanar;
}

fn unit_box() -> Result<Cuboid, rt_geometry::ShapeError> {
    Cuboid::new(DVec3::ZERO, DVec3::ONE)
}

/// `t` and the normal of the closest hit.
fn seen(solid: &Cuboid, ray: &Ray, span: Interval) -> Option<(f64, DVec3)> {
    let hit = solid.intersect(ray, span)?;
    Some((hit.t, solid.surface(ray, &hit, InteractionFlags::ALL).geometric_normal))
}

fn diagonal(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let solid = unit_box()?;
    let ray = Ray::new(DVec3::NEG_ONE, DVec3::ONE);
    checks.same(seen(&solid, &ray, Interval::FORWARD), Some((1.0, DVec3::NEG_X)), "entry");
    let exit = seen(&solid, &ray, Interval::new(1.5, 9.0));
    checks.same(exit.map(|(t, _)| t), Some(2.0), "exit");
    checks.same(
        seen(&solid, &Ray::new(DVec3::splat(2.0), DVec3::NEG_ONE), Interval::FORWARD).map(|(t, _)| t),
        Some(1.0),
        "from behind",
    );
    Ok(())
}

fn in_face_planes(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let solid = unit_box()?;
    let t = |origin: [f64; 3], direction: [f64; 3]| {
        seen(&solid, &Ray::new(origin.into(), direction.into()), Interval::FORWARD).map(|(t, _)| t)
    };
    for zero in [0.0, -0.0] {
        for y in [0.0, 1.0] {
            checks.same(t([-1.0, y, 0.5], [1.0, zero, 0.0]), Some(1.0), "in a face plane");
            checks.same(t([-1.0, y, y], [1.0, zero, zero]), Some(1.0), "along an edge");
        }
        checks.same(t([-1.0, 1f64.next_up(), 0.5], [1.0, zero, 0.0]), None, "one step beside");
        checks.same(t([-1.0, -5e-324, 0.5], [1.0, zero, 0.0]), None, "one step below");
        checks.same(t([0.0, 0.0, 0.5], [zero, 1.0, 0.0]), Some(0.0), "from the edge");
        checks.same(t([0.5, 0.5, 0.5], [zero, zero, 1.0]), Some(0.5), "from inside");
        checks.same(t([0.5, 0.5, 0.5], [zero, zero, zero]), None, "without a direction");
    }
    Ok(())
}

fn flat_boxes(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for thickness in [0.0, 1e-300] {
        for axis in 0..3 {
            let mut max = DVec3::ONE;
            max[axis] = thickness;
            let solid = Cuboid::new(DVec3::ZERO, max)?;
            let mut origin = DVec3::splat(0.25);
            for side in [1.0, -1.0] {
                origin[axis] = side;
                let mut direction = DVec3::ZERO;
                direction[axis] = -side;
                let mut normal = DVec3::ZERO;
                normal[axis] = side;
                let found = seen(&solid, &Ray::new(origin, direction), Interval::FORWARD);
                checks.same(found, Some((1.0, normal)), format_args!("thickness {thickness:e}"));
            }
        }
    }
    Ok(())
}

fn horizon(_: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let plane = Plane::new(DVec3::ZERO, DVec3::Z)?;
    let ray = Ray::new(DVec3::Z, DVec3::new(1.0, 0.0, -1e-12));
    let t = plane.intersect(&ray, Interval::FORWARD).map(|hit| hit.t);
    checks.hit(t, 1e12, Tolerance::Relative(2.0 * UNIT_ROUNDOFF), "t");
    let within = Ray::new(DVec3::ZERO, DVec3::X);
    checks.same(plane.intersect(&within, Interval::FORWARD), None, "within the plane");
    Ok(())
}

fn coplanar(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let plane = |point: DVec3| Plane::new(point, DVec3::Z).map(Shape::Plane);
    let set = ShapeSet::of_shapes([plane(DVec3::ZERO)?, plane(DVec3::ZERO)?]);
    let accelerators = all_accelerators(&set)?;
    checks.draw_all(conditions.count(20_000, 1_000_000), 15, |draw, checks| {
        let origin = draw.point() * 10.0;
        let ray = Ray::new(origin, DVec3::new(draw.unit(), draw.unit(), -origin.z) * draw.between(0.1, 10.0));
        for accelerator in &accelerators {
            let first = accelerator.closest(&set, &ray, Interval::FORWARD, &mut NoProbe).map(|hit| hit.primitive);
            checks.same(first, Some(0), accelerator.kind().name());
        }
    });
    Ok(())
}
