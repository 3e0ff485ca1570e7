//! The report's heap of spheres.

use rt_geometry::{Sphere, Spheres};
use rt_math::{
    DVec3,
    random::{hash, unit},
    transcendental::cbrt,
};

use super::Scene;
use crate::error::TaskError;

/// Radius of the half sphere that the heap fills.
const HEAP: f64 = 10.0;

/// So many overlapping spheres of similar size in half a sphere, as in the report: as even a density as there is. The
/// more there are the smaller they are, so that all of them together keep their volume.
pub(crate) fn mound(spheres: usize) -> Result<Scene<Spheres>, TaskError> {
    let scale = 10.0 / cbrt(spheres as f64);
    let sphere = |index| {
        let radius = scale * (0.6 + 0.4 * unit(hash(&[index, 0])));
        Sphere::new(HEAP * in_half_sphere(index), radius).map_err(TaskError::other)
    };
    let spheres = (0..spheres as u64).map(sphere).collect::<Result<_, _>>()?;
    Ok(Scene::whole("mound", Spheres::new(spheres)))
}

/// A random point inside the unit sphere with y ≥ 0, by rejection.
fn in_half_sphere(index: u64) -> DVec3 {
    let candidate = |attempt: u64| {
        let random = |dimension| unit(hash(&[index, attempt, dimension]));
        DVec3::new(2.0 * random(1) - 1.0, random(2), 2.0 * random(3) - 1.0)
    };
    (0..).map(candidate).find(|point| point.length_squared() <= 1.0).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mounds_keep_their_volume() {
        let volume = |count| -> f64 {
            let scene = mound(count).unwrap();
            scene.primitives.as_slice().iter().map(|s| s.radius() * s.radius() * s.radius()).sum()
        };
        assert!((volume(200) / volume(5000) - 1.0).abs() < 0.1);
    }
}
