//! Sierpiński's pyramid.

use rt_math::DVec3;

use super::nff::{Fill, Nff, NffView};

/// A tetrahedron of half its size in each corner of a tetrahedron, and so on: 4^size triangles.
pub(super) fn tetra(size: u32) -> Nff {
    let view = NffView {
        from: DVec3::new(1.02285, -3.17715, -2.17451),
        at: DVec3::new(-0.004103, -0.004103, 0.216539),
        up: DVec3::new(-0.816497, -0.816497, 0.816497),
    };
    let mut file = Nff::new(&format!("tetra, size {size}"), &view, &[DVec3::new(2.0, -18.0, -5.0)]);
    file.fill(&Fill::matte([1.0, 0.2, 0.2], 1.0));
    pyramid(&mut file, size.saturating_sub(1), DVec3::ZERO, 1.0);
    file
}

/// Every other corner of a cube.
const CORNERS: [DVec3; 4] =
    [DVec3::new(-1.0, -1.0, 1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(1.0, -1.0, -1.0), DVec3::new(1.0, 1.0, 1.0)];

/// The tetrahedron in a cube of this half side.
fn pyramid(file: &mut Nff, divisions: u32, centre: DVec3, half: f64) {
    if divisions > 0 {
        for corner in CORNERS {
            pyramid(file, divisions - 1, centre + corner * (half / 2.0), half / 2.0);
        }
        return;
    }
    let [a, b, c, d] = CORNERS.map(|corner| centre + corner * half);
    for face in [[a, b, c], [d, c, b], [c, d, a], [b, a, d]] {
        file.polygon(&face);
    }
}
