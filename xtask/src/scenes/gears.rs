//! Gear wheels that mesh.

use std::f64::consts::TAU;

use rt_geometry::{MeshData, TriangleMesh};
use rt_math::{DVec3, transcendental::sincos};

use super::{Scene, mesh, nearest};
use crate::error::TaskError;

const TEETH: u32 = 36;
/// Corners of the outline: four for each tooth.
pub(crate) const CORNERS: u32 = 4 * TEETH;
/// A face is a fan of triangles around its middle, a side of the outline is a rectangle of two.
const TRIANGLES: usize = 2 * CORNERS as usize + 2 * CORNERS as usize;
/// From the axis to the foot and to the end of a tooth; axes are a distance of 2 apart.
const FOOT: f64 = 0.95;
const END: f64 = 1.03;
pub(crate) const THICKNESS: f64 = 0.4;
/// From one layer to the next.
pub(crate) const LAYER: f64 = 0.6;

/// A cube of gear wheels after Haines, "A Proposal for Standard Graphics Environments", 1987. Polygons with many sides
/// give long thin triangles, evenly spread and aligned with the axes.
pub(crate) fn gears(wanted: usize) -> Result<Scene<TriangleMesh>, TaskError> {
    let side = nearest(wanted, 1..20, |side| TRIANGLES * (side as usize * side as usize * side as usize));
    let mut data = MeshData::default();
    for (x, y, z) in (0..side).flat_map(|x| (0..side).flat_map(move |y| (0..side).map(move |z| (x, y, z)))) {
        let axis = DVec3::new(2.0 * f64::from(x), 2.0 * f64::from(y), LAYER * f64::from(z));
        // Neighbours are half a tooth apart, so that the teeth of one stand in the gaps of the other.
        gear(&mut data, axis, if (x + y) % 2 == 0 { 0.0 } else { 0.5 });
    }
    Ok(Scene::whole("gears", mesh(data)?))
}

/// Adds a closed wheel, turned by a part of a tooth.
fn gear(data: &mut MeshData, axis: DVec3, turn: f64) {
    let first = data.positions.len() as u32;
    for z in [0.0, THICKNESS] {
        data.positions.push((axis + DVec3::Z * z).as_vec3());
        data.positions.extend((0..CORNERS).map(|corner| (axis + DVec3::Z * z + outline(corner, turn)).as_vec3()));
    }
    let at = |face: u32, corner: u32| first + face * (CORNERS + 1) + 1 + corner % CORNERS;
    let middle = |face: u32| first + face * (CORNERS + 1);
    for corner in 0..CORNERS {
        let [a, b] = [corner, corner + 1].map(|corner| at(0, corner));
        let [c, d] = [corner, corner + 1].map(|corner| at(1, corner));
        data.triangles.extend([[middle(0), b, a], [middle(1), c, d], [a, b, d], [a, d, c]]);
    }
}

/// Corner of the outline around the z axis, counter-clockwise: a tooth rises, ends, falls, and is followed by a gap.
pub(crate) fn outline(corner: u32, turn: f64) -> DVec3 {
    const PLACES: [(f64, f64); 4] = [(-0.27, FOOT), (-0.15, END), (0.15, END), (0.27, FOOT)];
    let (along, radius) = PLACES[(corner % 4) as usize];
    let (sin, cos) = sincos((f64::from(corner / 4) + along + turn) / f64::from(TEETH) * TAU);
    DVec3::new(cos, sin, 0.0) * radius
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use rt_geometry::Primitives;

    use super::*;

    #[test]
    fn wheels_are_closed_and_have_the_stated_size() {
        let mut data = MeshData::default();
        gear(&mut data, DVec3::ZERO, 0.25);
        assert_eq!(data.triangles.len(), TRIANGLES);
        let edges: HashSet<_> = data.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert_eq!(edges.len(), 3 * TRIANGLES, "each edge once in each direction");
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
        assert_eq!(gears(8 * TRIANGLES).unwrap().primitives.len(), 8 * TRIANGLES);
    }

    #[test]
    fn wheels_face_outwards() {
        let mut data = MeshData::default();
        gear(&mut data, DVec3::ZERO, 0.0);
        let volume: f64 = data
            .triangles
            .iter()
            .map(|triangle| triangle.map(|corner| data.positions[corner as usize].as_dvec3()))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        assert!((volume / (TAU / 2.0 * THICKNESS) - 1.0).abs() < 0.1, "{volume}");
    }
}
