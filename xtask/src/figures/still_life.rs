//! A few spheres of three sizes on a table, and the nodes of accelerators over them.

use rt_accel::{Accelerator, AcceleratorKind, AnyAccelerator, CylinderTree, Interval, NoProbe, Ray, SphereTree};
use rt_geometry::{Sphere, Spheres};
use rt_math::DVec3;

use super::wires::{Wires, around_box, around_cylinder, around_sphere};
use crate::error::TaskError;

/// x, z and radius of spheres that stand on the plane y = 0: two large ones, four of middle size, a heap of small ones.
pub(super) const SPHERES: [(f64, f64, f64); 13] = [
    (-3.0, -0.9, 1.2),
    (2.5, -1.6, 1.0),
    (-0.4, -2.1, 0.6),
    (0.2, 0.8, 0.5),
    (-1.7, 1.9, 0.55),
    (3.9, 0.6, 0.5),
    (1.6, 1.5, 0.2),
    (2.1, 1.4, 0.2),
    (2.6, 1.7, 0.2),
    (1.8, 2.0, 0.2),
    (2.3, 2.2, 0.2),
    (1.6, 2.5, 0.2),
    (2.7, 2.6, 0.2),
];

/// The lines around the parts of an accelerator of this kind.
pub(super) fn wires(kind: AcceleratorKind) -> Result<Wires, TaskError> {
    let sphere = |&(x, z, radius): &(f64, f64, f64)| Sphere::new(DVec3::new(x, radius, z), radius);
    let spheres = SPHERES.iter().map(sphere).collect::<Result<_, _>>().map_err(TaskError::other)?;
    let primitives = Spheres::new(spheres);
    let mut wires = Wires::default();
    match kind {
        AcceleratorKind::Spheres => SphereTree::build(&primitives)
            .map_err(TaskError::other)?
            .for_each_volume(|volume, depth| around_sphere(volume.centre(), volume.radius(), depth, &mut wires)),
        AcceleratorKind::Cylinders => {
            CylinderTree::build(&primitives).map_err(TaskError::other)?.for_each_volume(|volume, depth| {
                around_cylinder(volume.axis(), volume.centre(), volume.radius(), volume.caps(), depth, &mut wires);
            })
        }
        _ => {
            let accelerator = AnyAccelerator::build(kind, &primitives).map_err(TaskError::other)?;
            // What is lazy shows what one ray has made of it, which falls on the large sphere on the left.
            let (x, z, _) = SPHERES[0];
            let ray = Ray::new(DVec3::new(x, 5.0, z), DVec3::NEG_Y);
            accelerator.closest(&primitives, &ray, Interval::FORWARD, &mut NoProbe);
            accelerator.for_each_box(|aabb, depth| around_box(&aabb, depth, &mut wires));
        }
    }
    Ok(wires)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_accelerator_but_brute_force_has_parts_to_show() {
        for kind in AcceleratorKind::ALL {
            assert_eq!(wires(*kind).unwrap().is_empty(), *kind == AcceleratorKind::Linear, "{kind:?}");
        }
    }

    #[test]
    fn a_lazy_accelerator_shows_less_than_a_full_one() {
        let [lazy, full] = [AcceleratorKind::BihLazy, AcceleratorKind::Bih].map(|kind| wires(kind).unwrap().len());
        assert!(lazy < full, "{lazy} of {full}");
    }
}
