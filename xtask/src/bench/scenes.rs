//! Scenes to measure with: even and uneven, spheres and triangles.

use std::collections::HashMap;

use rt_geometry::{MeshData, Sphere, Spheres, TriangleMesh};
use rt_math::{
    DVec3, Frame, Vec3,
    random::{hash, unit},
    transcendental::{sin, sincos},
};

use super::Scene;
use crate::error::TaskError;

/// Spheres of the report's largest scene.
const HEAP: u64 = 1000;
/// Generations of children: 1 + 9 + 9² + 9³ + 9⁴ = 7381 spheres.
const FLAKE_DEPTH: u32 = 4;
/// Each subdivision makes four triangles of one: 20 · 4⁶ = 81,920.
const SUBDIVISIONS: u32 = 6;

/// A heap of 1000 overlapping spheres in half a ball: even density, as in the report.
pub(super) fn heap() -> Result<Scene<Spheres>, TaskError> {
    let sphere = |index| {
        let random = |dimension| unit(hash(&[index, dimension]));
        let radius = 0.15 + 0.1 * random(0);
        sphere(10.0 * (in_half_ball(index)), radius * 4.0)
    };
    let spheres = (0..HEAP).map(sphere).collect::<Result<_, _>>()?;
    Ok(Scene { name: "heap", primitives: Spheres::new(spheres) })
}

/// A random point of the unit ball with y ≥ 0, by rejection.
fn in_half_ball(index: u64) -> DVec3 {
    let candidate = |attempt: u64| {
        let random = |dimension| unit(hash(&[index, attempt, dimension]));
        DVec3::new(2.0 * random(1) - 1.0, random(2), 2.0 * random(3) - 1.0)
    };
    (0..).map(candidate).find(|point| point.length_squared() <= 1.0).unwrap_or_default()
}

/// Spheres on spheres on spheres (Haines, "A Proposal for Standard Graphics Environments", 1987): very uneven density.
pub(super) fn sphereflake() -> Result<Scene<Spheres>, TaskError> {
    let mut spheres = Vec::new();
    grow(&mut spheres, DVec3::ZERO, 1.0, DVec3::Y, FLAKE_DEPTH)?;
    Ok(Scene { name: "sphereflake", primitives: Spheres::new(spheres) })
}

/// A sphere with nine children of a third of its size: six around its equator, three above.
fn grow(spheres: &mut Vec<Sphere>, centre: DVec3, radius: f64, up: DVec3, generations: u32) -> Result<(), TaskError> {
    spheres.push(sphere(centre, radius)?);
    if generations == 0 {
        return Ok(());
    }
    let frame = Frame::from_z(up);
    for child in 0..9 {
        let (turn, height) =
            if child < 6 { (f64::from(child) / 6.0, 0.0) } else { (f64::from(child) / 3.0 + 1.0 / 12.0, 0.8) };
        let (sin, cos) = sincos(turn * std::f64::consts::TAU);
        let flat: f64 = 1.0 - height * height;
        let direction = frame.from_local(DVec3::new(cos * flat.sqrt(), sin * flat.sqrt(), height)).normalize();
        grow(spheres, centre + direction * (radius * 4.0 / 3.0), radius / 3.0, direction, generations - 1)?;
    }
    Ok(())
}

fn sphere(centre: DVec3, radius: f64) -> Result<Sphere, TaskError> {
    Sphere::new(centre, radius).map_err(|error| TaskError::Other(error.to_string()))
}

/// A subdivided icosahedron with bumps: a closed mesh of small triangles.
pub(super) fn rock() -> Result<Scene<TriangleMesh>, TaskError> {
    let (mut points, mut triangles) = icosahedron();
    for _ in 0..SUBDIVISIONS {
        triangles = subdivide(&mut points, &triangles);
    }
    let positions = points.iter().map(|&point| bumpy(point).as_vec3()).collect::<Vec<Vec3>>();
    let data = MeshData { positions, triangles, ..MeshData::default() };
    let (mesh, _) = TriangleMesh::build(data).map_err(|error| TaskError::Other(error.to_string()))?;
    Ok(Scene { name: "rock", primitives: mesh })
}

/// The point of a sphere moved in and out by waves of two lengths.
fn bumpy(point: DVec3) -> DVec3 {
    let wave = |count: f64| sin(count * point.x) * sin(count * point.y + 1.0) * sin(count * point.z + 2.0);
    point * (1.0 + 0.2 * wave(5.0) + 0.03 * wave(31.0))
}

/// Twelve unit points and twenty triangles, counter-clockwise from outside.
fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        points.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)].map(DVec3::normalize));
    }
    // The faces are the triples at the least distance from each other.
    let edge = 2.1 / (1.0 + golden * golden).sqrt();
    let near = |i: usize, j: usize| points[i].distance(points[j]) < edge;
    let mut triangles = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outwards = (points[j] - points[i]).cross(points[k] - points[i]).dot(points[i]) > 0.0;
                    let [i, j, k] = [i, j, k].map(|index| index as u32);
                    triangles.push(if outwards { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    (points, triangles)
}

/// Cuts each triangle in four at the middles of its edges, which move to the sphere.
fn subdivide(points: &mut Vec<DVec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let mut smaller = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        smaller.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    smaller
}

#[cfg(test)]
mod tests {
    use rt_math::Primitives;

    use super::*;

    #[test]
    fn scenes_have_the_stated_size() {
        assert_eq!(heap().unwrap().primitives.len(), 1000);
        assert_eq!(sphereflake().unwrap().primitives.len(), 7381);
        assert_eq!(rock().unwrap().primitives.len(), 81_920);
    }

    #[test]
    fn the_icosahedron_is_closed() {
        let (points, triangles) = icosahedron();
        assert_eq!((points.len(), triangles.len()), (12, 20));
        let edges: Vec<_> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
    }

    #[test]
    fn children_touch_their_parent() {
        let spheres = sphereflake().unwrap().primitives;
        let [parent, child] = [spheres.as_slice()[0], spheres.as_slice()[1]];
        let gap = parent.centre().distance(child.centre()) - parent.radius() - child.radius();
        assert!(gap.abs() < 1e-12);
    }
}
