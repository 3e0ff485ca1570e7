//! The sphereflake.

use std::f64::consts::TAU;

use rt_math::{DVec3, transcendental::sincos};

use super::nff::{Fill, Nff, NffView};

const LIGHTS: [DVec3; 3] = [DVec3::new(4.0, 3.0, 2.0), DVec3::new(1.0, -4.0, 4.0), DVec3::new(-3.0, 1.0, 5.0)];

/// A sphere of radius ½ with nine spheres of a third of its size around it, each with nine more, and so on `size`
/// times. With the square below them: (9^(size + 1) − 1) / 8 spheres and a polygon.
pub(super) fn sphereflake(size: u32) -> Nff {
    let view = NffView { from: DVec3::new(2.1, 1.3, 1.7), at: DVec3::ZERO, up: DVec3::Z };
    let mut file = Nff::new(&format!("balls, size {size}"), &view, &LIGHTS);
    file.fill(&Fill::matte([1.0, 0.75, 0.33], 0.8));
    let corner = |x, y| DVec3::new(12.0 * x, 12.0 * y, -0.5);
    file.polygon(&[corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)]);
    let shiny = Fill { specular: 0.5, shine: 3.0827, ..Fill::matte([1.0, 0.9, 0.7], 0.5) };
    file.fill(&shiny);
    flake(&mut file, size, DVec3::ZERO, 0.5, DVec3::Z);
    file
}

fn flake(file: &mut Nff, generations: u32, centre: DVec3, radius: f64, up: DVec3) {
    file.sphere(centre, radius);
    if generations == 0 {
        return;
    }
    for direction in directions() {
        let direction = turned(direction, up);
        flake(file, generations - 1, centre + direction * (radius * 4.0 / 3.0), radius / 3.0, direction);
    }
}

/// Towards the nine children of a sphere that points up: three times one above between two in the plane, a third of a turn on.
fn directions() -> impl Iterator<Item = DVec3> {
    // The one above is as far from the axis as a diagonal of the cube is from its edge.
    let above = 1.0 / 3f64.sqrt();
    let places = [(1.0 / 8.0, above), (1.0 / 24.0, 1.0), (5.0 / 24.0, 1.0)];
    (0..3).flat_map(move |third| places.map(|place| (third, place))).map(|(third, (turn, flat))| {
        let (sin, cos) = sincos((turn + f64::from(third) / 3.0) * TAU);
        DVec3::new(flat * cos, flat * sin, (1.0 - flat * flat).sqrt())
    })
}

/// The vector under the smallest turn that takes +z to the unit vector `up` (Rodrigues).
fn turned(v: DVec3, up: DVec3) -> DVec3 {
    let axis = DVec3::Z.cross(up);
    // Straight down there is no smallest turn: a half turn around y.
    if 1.0 + up.z < 1e-12 {
        return DVec3::new(-v.x, v.y, -v.z);
    }
    v * up.z + axis.cross(v) + axis * (axis.dot(v) / (1.0 + up.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_take_the_axis_to_its_image_and_keep_lengths() {
        for up in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.6, 0.0, -0.8)] {
            assert!((turned(DVec3::Z, up) - up).length() < 1e-15);
            assert!((turned(DVec3::new(1.0, 2.0, 3.0), up).length() - 14f64.sqrt()).abs() < 1e-14);
        }
    }
}
