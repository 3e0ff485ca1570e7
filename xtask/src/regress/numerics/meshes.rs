//! Triangles and meshes.

use std::{
    f64::consts::TAU,
    sync::atomic::{AtomicU64, Ordering},
};

use rt_accel::{Accelerator, Bvh};
use rt_geometry::{
    Hit, InteractionFlags, MeshData, NoProbe, Primitives, Triangle, TriangleMesh, WatertightRay, intersect_primitive,
};
use rt_math::{Aabb, DVec3, Interval, Ray, SlabRay, Transform, float::UNIT_ROUNDOFF, transcendental::sincos};
use rt_tests::{Draw, icosphere};

use super::{
    Case, Checks, Conditions, Fallible, cases,
    exact::Dyadic,
    scenes::{all_accelerators, key},
};

cases! {
    "S23", "rays from inside closed meshes of 80·4ᵏ triangles, at edges and vertices", "0 misses", "0", closed_meshes;
    "S24", "the same at offsets 0…1e7 and scales 1e-3…1e3, in place and as an instance",
        "0 misses", "0", closed_meshes_elsewhere;
    "S25", "rays at the hub of a fan of 1e6 triangles",
        "the first of those at the least t, in all accelerators", "bits", fan;
    "S26", "a mesh with T-junctions",
        "misses hit what closes the gap, and are within roundings of the edge; there are some", "0; 64u abs", junctions;
    "S27", "slivers of aspect 1e12, edge-on and across", "a hit on itself with a sound normal, or a miss", "–", slivers;
}

/// Triangles in `f64`, with shared corners.
struct Facets {
    vertices: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Facets {
    fn corners(&self, index: u32) -> Option<[DVec3; 3]> {
        self.triangles.get(index as usize).map(|triangle| triangle.map(|vertex| self.vertices[vertex]))
    }

    /// A vertex, a point of an edge or its middle, of some triangle.
    fn aim(&self, draw: &mut Draw) -> DVec3 {
        let triangle = self.triangles[draw.below(self.triangles.len())];
        let corner = draw.below(3);
        let [a, b] = [triangle[corner], triangle[(corner + 1) % 3]].map(|vertex| self.vertices[vertex]);
        match draw.below(4) {
            0 | 1 => a,
            2 => a.midpoint(b),
            _ => a.lerp(b, draw.unit()),
        }
    }
}

impl Primitives for Facets {
    fn len(&self) -> usize {
        self.triangles.len()
    }

    fn bounds(&self, index: u32) -> Option<Aabb> {
        self.corners(index).map(Aabb::from_points)
    }

    fn intersect(&self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        let hit = WatertightRay::new(ray).intersect(self.corners(index)?, span)?;
        Some(Hit { t: hit.t, instance: 0, primitive: index, uv: hit.uv })
    }
}

fn closed_meshes(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const LEVELS: [u32; 5] = [1, 2, 3, 4, 5];
    let rays = conditions.count(100_000, 2_000_000);
    for levels in LEVELS {
        let (vertices, triangles) = icosphere(levels);
        misses(&Facets { vertices, triangles }, DVec3::ZERO, 1.0, rays, checks)?;
    }
    Ok(())
}

/// Rays from around the centre that miss all triangles.
fn misses(mesh: &Facets, centre: DVec3, scale: f64, rays: u64, checks: &mut Checks) -> Fallible<()> {
    let accelerator = Bvh::build(mesh)?;
    checks.draw_all(rays, 23, |draw, checks| {
        let origin = centre + draw.point() * (0.4 * scale);
        let ray = Ray::new(origin, mesh.aim(draw) - origin);
        let hit = accelerator.closest(mesh, &ray, Interval::FORWARD, &mut NoProbe);
        checks.check(hit.is_some(), || format!("centre {centre}, scale {scale:e}: {ray:?}"));
    });
    Ok(())
}

fn closed_meshes_elsewhere(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    const OFFSETS: [f64; 6] = [0.0, 1.0, 1e2, 1e4, 1e6, 1e7];
    const SCALES: [f64; 3] = [1e-3, 1.0, 1e3];
    let rays = conditions.count(10_000, 300_000);
    let (sphere, triangles) = icosphere(2);
    for offset in OFFSETS {
        for scale in SCALES {
            let centre = DVec3::new(offset, offset * 0.75, -offset);
            let vertices = sphere.iter().map(|vertex| *vertex * scale + centre).collect();
            misses(&Facets { vertices, triangles: triangles.clone() }, centre, scale, rays, checks)?;
            let scaling = Transform::scale(DVec3::splat(scale))?;
            let turn = Transform::rotate(DVec3::new(0.3, 1.0, 0.6), 0.9)?;
            let place = Transform::translate(centre).compose(&turn).compose(&scaling);
            misses_of_instance(&sphere, &triangles, &place, rays, checks)?;
        }
    }
    Ok(())
}

/// Counts [`misses`] of a mesh with `f32` vertices under a transform, as in a scene.
fn misses_of_instance(
    sphere: &[DVec3],
    triangles: &[[usize; 3]],
    place: &Transform,
    rays: u64,
    checks: &mut Checks,
) -> Fallible<()> {
    let data = MeshData {
        positions: sphere.iter().map(|vertex| vertex.as_vec3()).collect(),
        triangles: triangles.iter().map(|triangle| triangle.map(|vertex| vertex as u32)).collect(),
        ..MeshData::default()
    };
    let (mesh, _) = TriangleMesh::build(data)?;
    let accelerator = Bvh::build(&mesh)?;
    let vertices = mesh.data().positions.iter().map(|vertex| place.point(vertex.as_dvec3())).collect();
    let world = Facets { vertices, triangles: triangles.to_vec() };
    checks.draw_all(rays, 24, |draw, checks| {
        let origin = place.point(draw.point() * 0.4);
        let ray = Ray::new(origin, world.aim(draw) - origin);
        let hit = accelerator.closest(&mesh, &place.inverse_ray(&ray), Interval::FORWARD, &mut NoProbe);
        checks.check(hit.is_some(), || format!("instance at {}: {ray:?}", place.translation()));
    });
    Ok(())
}

fn fan(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let count = conditions.count(20_000, 1_000_000) as usize;
    let rim = |i: usize| {
        let (sin, cos) = sincos(TAU * i as f64 / count as f64);
        DVec3::new(cos, sin, 0.2 * (i % 2) as f64)
    };
    let hub = DVec3::new(0.01, -0.02, 0.1);
    let mesh = Facets {
        vertices: (0..count).map(rim).chain([hub]).collect(),
        triangles: (0..count).map(|i| [count, i, (i + 1) % count]).collect(),
    };
    let accelerators = all_accelerators(&mesh)?;
    let mut tied = 0;
    for index in 0..conditions.count(20, 40) {
        let mut draw = Draw::of(25, index);
        let origin = hub + draw.above(DVec3::Z, 0.3) * 2.0;
        let ray = Ray::new(origin, hub - origin);
        let slab = SlabRay::new(&ray);
        let hits: Vec<Hit> = (0..count as u32)
            .filter_map(|i| intersect_primitive(&mesh, i, &slab, Interval::FORWARD, &mut NoProbe))
            .collect();
        let min = hits.iter().map(|hit| hit.t).fold(f64::INFINITY, f64::min);
        let mut nearest = hits.iter().filter(|hit| hit.t == min);
        let first = nearest.next().copied();
        tied += nearest.count();
        checks.check(first.is_some(), || format!("a miss from {origin}"));
        for accelerator in &accelerators {
            let found = accelerator.closest(&mesh, &ray, Interval::FORWARD, &mut NoProbe);
            checks.same(key(found), key(first), accelerator.kind().name());
        }
    }
    checks.note(format!("{count} triangles; {tied} further hits at the same t"));
    Ok(())
}

/// A square of three triangles below a triangle, with a corner in the middle of the edge that they share, off the line by
/// rounding.
struct Junction {
    mesh: Facets,
    /// Triangle that closes the gap that rounding leaves: both ends of the edge, and the corner between them.
    gap: [DVec3; 3],
}

impl Junction {
    /// Moves the corner away from the edge by `crack` in addition, which the gap does not include.
    fn new(crack: f64) -> Fallible<Self> {
        let turn = Transform::rotate(DVec3::new(1.0, 0.4, -0.3), 0.7)?;
        let place = |x: f64, y: f64| turn.point(DVec3::new(x, y, 0.0));
        let [a, b] = [place(-1.0, 0.0), place(1.0, 0.0)];
        let middle = a.lerp(b, 0.6);
        let corner = if crack == 0.0 { middle } else { middle + (place(0.0, -crack) - place(0.0, 0.0)) };
        let vertices = vec![a, b, corner, place(0.0, 2.0), place(-1.0, -1.0), place(1.0, -1.0)];
        let mesh = Facets { vertices, triangles: vec![[0, 1, 3], [0, 4, 2], [2, 4, 5], [2, 5, 1]] };
        Ok(Self { mesh, gap: [a, b, middle] })
    }

    /// A ray towards a point of the edge.
    fn ray(&self, index: u64) -> Ray {
        let mut draw = Draw::of(26, index);
        let aim = self.gap[0].lerp(self.gap[1], draw.between(0.05, 0.95));
        let origin = DVec3::new(draw.unit(), draw.unit(), 3.0 + draw.unit());
        Ray::new(origin, aim - origin)
    }

    /// Checks that each ray hits the mesh or the triangle that closes it. Together they have no T-junction, and so no
    /// leak, if signs at shared edges are equal from both sides. Rays through the gap must be within roundings of the
    /// edge, by exact arithmetic, and there must be some.
    fn hold(&self, rays: u64, checks: &mut Checks) {
        let slipped = AtomicU64::new(0);
        checks.of_all(rays, |index, checks| {
            let ray = self.ray(index);
            if (0..self.mesh.len() as u32).any(|i| self.mesh.intersect(i, &ray, Interval::FORWARD).is_some()) {
                return checks.check(true, String::new);
            }
            slipped.fetch_add(1, Ordering::Relaxed);
            let is_closed = WatertightRay::new(&ray).intersect(self.gap, Interval::FORWARD).is_some();
            checks.check(is_closed, || format!("{ray:?} misses the mesh, and what closes it as well"));
            checks.limit(distance(&ray, [self.gap[0], self.gap[1]]), ROUNDINGS, format_args!("{ray:?} from the edge"));
        });
        let slipped = slipped.into_inner();
        checks.check(slipped > 0, || "the gap lets nothing through".to_owned());
        checks.note(format!("{slipped} of {rays} rays at the edge slipped through a gap that rounding left"));
    }
}

/// Rounding errors of coordinates up to 8: of the corners, of the ray, and of the corners in ray space.
const ROUNDINGS: f64 = 8.0 * 8.0 * UNIT_ROUNDOFF;

/// Distance of two lines: exact volume of the parallelepiped of both directions and a connection, divided by the area
/// of one side.
fn distance(ray: &Ray, [a, b]: [DVec3; 2]) -> f64 {
    let exact = |v: DVec3| v.to_array().map(Dyadic::from);
    let [origin, direction, a_exact, b_exact] = [ray.origin, ray.direction, a, b].map(exact);
    let minus = |p: &[Dyadic; 3], q: &[Dyadic; 3]| [&p[0] - &q[0], &p[1] - &q[1], &p[2] - &q[2]];
    let (p, q) = (minus(&a_exact, &origin), minus(&b_exact, &a_exact));
    let x = &(&p[1] * &q[2]) - &(&p[2] * &q[1]);
    let y = &(&p[2] * &q[0]) - &(&p[0] * &q[2]);
    let z = &(&p[0] * &q[1]) - &(&p[1] * &q[0]);
    let volume = &(&(&direction[0] * &x) + &(&direction[1] * &y)) + &(&direction[2] * &z);
    volume.to_f64().abs() / ray.direction.cross(b - a).length()
}

fn junctions(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    Junction::new(0.0)?.hold(conditions.count(100_000, 10_000_000), checks);
    Ok(())
}

fn slivers(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let sliver = |length: f64, width: f64, turn: &Transform| -> Fallible<Triangle> {
        let corners = [DVec3::ZERO, DVec3::X * length, DVec3::new(0.5 * length, width, 0.0)];
        Ok(Triangle::new(corners.map(|corner| turn.point(corner)))?)
    };
    for (length, width) in [(1e6, 1e-6), (1.0, 1e-12), (1e-3, 1e-15), (1e12, 1.0)] {
        let turn = Transform::rotate(DVec3::new(0.2, -0.5, 0.9), 0.6)?;
        for place in [Transform::IDENTITY, turn] {
            let triangle = sliver(length, width, &place)?;
            let slack = DVec3::splat(1e-12 * length);
            let around = Aabb::new(triangle.bounds().min - slack, triangle.bounds().max + slack);
            checks.draw_all(conditions.count(2_000, 100_000), 27, |draw, checks| {
                let aim = DVec3::new(draw.unit() * length, draw.between(-0.5, 1.5) * width, 0.0);
                let from = match draw.below(3) {
                    // In the plane, nearly in it, and from anywhere.
                    0 => DVec3::new(draw.between(-1.0, 2.0) * length, draw.between(-1.0, 1.0) * length, 0.0),
                    1 => DVec3::new(draw.between(-1.0, 2.0) * length, length, width * draw.between(-1.0, 1.0)),
                    _ => draw.point() * length,
                };
                let [aim, origin] = [aim, from].map(|point| place.point(point));
                let ray = Ray::new(origin, aim - origin);
                let sound = triangle.intersect(&ray, Interval::FORWARD).is_none_or(|hit| {
                    let surface = triangle.surface(&ray, &hit, InteractionFlags::ALL);
                    let is_unit = (surface.geometric_normal.length() - 1.0).abs() < 1e-14;
                    hit.t.is_finite() && around.contains(surface.point) && is_unit
                });
                checks.check(sound, || format!("{:?} for {ray:?}", triangle.intersect(&ray, Interval::FORWARD)));
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: rays through the gap were counted, and any number of them passed.
    #[test]
    fn a_crack_at_a_t_junction_is_found() {
        let held = |junction: Junction| {
            let mut checks = Checks::default();
            junction.hold(20_000, &mut checks);
            checks
        };
        let sound = held(Junction::new(0.0).unwrap());
        assert_eq!(sound.failed, 0, "{:?}", sound.problems);
        for crack in [1e-13, 1e-9] {
            let cracked = held(Junction::new(crack).unwrap());
            assert!(cracked.failed > 1000, "{crack}: {} failed", cracked.failed);
        }
        // Without a gap, nothing would be tried.
        let mut closed = Junction::new(0.0).unwrap();
        closed.mesh.triangles.push([0, 1, 2]);
        assert_eq!(held(closed).problems, ["the gap lets nothing through"]);
    }

    #[test]
    fn distances_of_lines_are_exact() {
        let down = |y: f64| Ray::new(DVec3::new(0.25, y, 1.0), DVec3::NEG_Z * 3.0);
        let edge = [DVec3::ZERO, DVec3::X * 2.0];
        for y in [0.0, 1.0, -1e-30, 5e-300] {
            assert_eq!(distance(&down(y), edge), y.abs());
        }
        assert_eq!(distance(&Ray::new(DVec3::splat(0.1), DVec3::ONE), [DVec3::ZERO, DVec3::X]), 0.0);
    }
}
