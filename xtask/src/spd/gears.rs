//! Gear wheels of glass that mesh.

use rt_math::{
    DVec3,
    random::{hash, unit},
};

use super::nff::{Fill, Nff, NffView};
use crate::scenes::gears::{CORNERS, LAYER, THICKNESS, outline};

/// A cube of `size`³ gears, each of two faces with 144 corners and as many quadrilaterals around them, above a square.
///
/// The paper gives the numbers of gears and of their polygons; proportions and colours are ours.
pub(super) fn gears(size: u32) -> Nff {
    let side = f64::from(size);
    let middle = DVec3::new(side - 1.0, side - 1.0, (side - 1.0) * LAYER / 2.0);
    let reach = side + 1.0;
    let view = NffView { from: middle + DVec3::new(-1.1, -1.9, 1.6) * (1.25 * reach), at: middle, up: DVec3::Z };
    let lights = [(-2.0, -3.0, 4.0), (3.0, -2.0, 3.0), (0.0, -4.0, 2.0), (-3.0, 2.0, 4.0), (2.0, 3.0, 3.0)]
        .map(|(x, y, z)| middle + DVec3::new(x, y, z) * reach);
    let mut file = Nff::new(&format!("gears, size {size}"), &view, &lights);
    file.fill(&Fill::matte([0.9, 0.8, 0.6], 0.8));
    let floor = |x: f64, y: f64| DVec3::new(middle.x + 4.0 * reach * x, middle.y + 4.0 * reach * y, -LAYER);
    file.polygon(&[floor(1.0, 1.0), floor(-1.0, 1.0), floor(-1.0, -1.0), floor(1.0, -1.0)]);
    for (x, y, z) in (0..size).flat_map(|x| (0..size).flat_map(move |y| (0..size).map(move |z| (x, y, z)))) {
        let colour = [0, 1, 2].map(|part| 0.3 + 0.7 * unit(hash(&[x.into(), y.into(), z.into(), part])));
        file.fill(&Fill { specular: 0.2, shine: 40.0, transmittance: 0.6, ior: 1.1, ..Fill::matte(colour, 0.3) });
        let axis = DVec3::new(2.0 * f64::from(x), 2.0 * f64::from(y), LAYER * f64::from(z));
        // Neighbours are half a tooth apart, so that the teeth of one stand in the gaps of the other.
        gear(&mut file, axis, if (x + y) % 2 == 0 { 0.0 } else { 0.5 });
    }
    file
}

/// A closed wheel, turned by a part of a tooth.
fn gear(file: &mut Nff, axis: DVec3, turn: f64) {
    let ring = |z: f64| (0..CORNERS).map(|i| axis + outline(i, turn) + DVec3::Z * z).collect::<Vec<_>>();
    let (bottom, top) = (ring(0.0), ring(THICKNESS));
    file.polygon(&top);
    file.polygon(&bottom.iter().rev().copied().collect::<Vec<_>>());
    for i in 0..CORNERS as usize {
        let next = (i + 1) % CORNERS as usize;
        file.polygon(&[bottom[i], bottom[next], top[next], top[i]]);
    }
}
