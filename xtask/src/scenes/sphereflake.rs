//! Spheres on spheres on spheres.

use rt_geometry::{Sphere, Spheres};
use rt_math::{DVec3, Frame, transcendental::sincos};

use super::{Scene, nearest};
use crate::error::TaskError;

/// The sphereflake (Haines, "A Proposal for Standard Graphics Environments", 1987): density is very uneven, and
/// touching spheres cannot be separated by boxes. Each generation has nine times as many spheres as the one before.
pub(crate) fn sphereflake(wanted: usize) -> Result<Scene<Spheres>, TaskError> {
    let generations = nearest(wanted, 0..8, |generations| (0..=generations).map(|g| 9usize.pow(g)).sum());
    let mut spheres = Vec::new();
    grow(&mut spheres, DVec3::ZERO, 1.0, DVec3::Y, generations)?;
    Ok(Scene::whole("balls", Spheres::new(spheres)))
}

/// A sphere with nine children of a third of its size: six around its equator, three above.
fn grow(spheres: &mut Vec<Sphere>, centre: DVec3, radius: f64, up: DVec3, generations: u32) -> Result<(), TaskError> {
    spheres.push(Sphere::new(centre, radius).map_err(TaskError::other)?);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_touch_their_parent() {
        let spheres = sphereflake(10).unwrap().primitives;
        let [parent, child] = [spheres.as_slice()[0], spheres.as_slice()[1]];
        let gap = parent.centre().distance(child.centre()) - parent.radius() - child.radius();
        assert!(gap.abs() < 1e-12);
    }
}
