//! One small object with much detail among few huge ones far away.

use std::f64::consts::TAU;

use rt_geometry::{MeshData, TriangleMesh};
use rt_math::{Aabb, DVec3, transcendental::sincos};

use super::{Scene, mesh, rock};
use crate::error::TaskError;

/// Radius of the field, where that of the rock is 1.
const FIELD: f64 = 800.0;
const SECTORS: u32 = 16;
/// Corners of a profile of six tiers; each is as high as it is wide.
const RINGS: u32 = 12;
const TIER: f64 = 60.0;

/// A rock in the centre of a stadium a thousand times its size, too small for the cells of a uniform grid. It is "the
/// teapot in the stadium" of Haines, "Spline surface rendering, and what's wrong with octrees", 1988. The camera looks
/// at the rock; only the number of its triangles grows.
pub(crate) fn stadium(wanted: usize) -> Result<Scene<TriangleMesh>, TaskError> {
    let mut data = rock::data(wanted);
    let view = Aabb::from_points(data.positions.iter().map(|point| point.as_dvec3()));
    stands(&mut data, view.min.y);
    Ok(Scene { name: "stadium", primitives: mesh(data)?, view })
}

/// Adds the field at this height and the stands around it.
fn stands(data: &mut MeshData, ground: f64) {
    let middle = data.positions.len() as u32;
    data.positions.push((DVec3::Y * ground).as_vec3());
    for ring in 0..RINGS {
        let radius = FIELD + TIER * f64::from(ring / 2);
        let height = ground + TIER * f64::from(ring.div_ceil(2));
        data.positions.extend((0..SECTORS).map(|sector| {
            let (sin, cos) = sincos(f64::from(sector) / f64::from(SECTORS) * TAU);
            DVec3::new(radius * cos, height, radius * sin).as_vec3()
        }));
    }
    let at = |ring: u32, sector: u32| middle + 1 + ring * SECTORS + sector % SECTORS;
    for sector in 0..SECTORS {
        data.triangles.push([middle, at(0, sector + 1), at(0, sector)]);
        for ring in 1..RINGS {
            let [a, b] = [sector, sector + 1].map(|sector| at(ring - 1, sector));
            let [c, d] = [sector, sector + 1].map(|sector| at(ring, sector));
            data.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stadium_is_a_thousand_times_as_large_as_what_is_looked_at() {
        let Scene { primitives, view, .. } = stadium(1280).unwrap();
        let extent = |aabb: Aabb| aabb.extent().max_element();
        let ratio = extent(primitives.bounds()) / extent(view);
        assert!((500.0..1500.0).contains(&ratio), "{ratio}");
    }
}
