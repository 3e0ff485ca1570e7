//! Choice of the acceleration structure.

use rt_accel::wide::{Quality, SimdLevel, SmallSet};
use rt_accel::{AcceleratorKind, AnyAccelerator, BuildError};
use rt_geometry::{PrimitiveGeometry, Primitives};
use rt_scene_io::{Accel, Scene};
use rt_shading::LaneLevel;

use crate::plan_options::PlanOptions;

/// Largest number of primitives for which brute force is faster than a tree.
pub(crate) const MAX_LINEAR: usize = 8;

/// Largest number of spheres for brute force; many rays are tested at once.
pub(crate) const MAX_LINEAR_SPHERES: usize = SmallSet::CAPACITY;

/// True if brute force over the primitives is faster than a tree.
pub(crate) fn is_small<P: Primitives>(primitives: &P, mut indices: impl ExactSizeIterator<Item = u32>) -> bool {
    let is_round = |index| matches!(primitives.geometry(index), PrimitiveGeometry::ExactSphere(_));
    let count = indices.len();
    count <= MAX_LINEAR || count <= MAX_LINEAR_SPHERES && indices.all(is_round)
}

/// Requested acceleration structure.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AccelOptions {
    pub(crate) accel: Accel,
    /// Instruction set; `None` for the best one of the processor.
    pub(crate) simd: Option<SimdLevel>,
    pub(crate) quality: Quality,
}

impl AccelOptions {
    pub(crate) const fn new(scene: &Scene, options: &PlanOptions) -> Self {
        Self { accel: scene.settings.accel, simd: options.simd, quality: options.quality }
    }

    /// Instructions for shading in lanes; `None` for one hit at a time.
    pub(crate) fn lane_level(self) -> Option<LaneLevel> {
        match self.simd {
            Some(SimdLevel::Portable) => None,
            Some(SimdLevel::Avx2) => LaneLevel::avx2(),
            Some(SimdLevel::Avx512) | None => LaneLevel::best(),
        }
    }
}

/// Builds the requested accelerator; `Auto` selects one for the primitives.
pub(crate) fn build<P: Primitives>(accel_options: AccelOptions, primitives: &P) -> Result<AnyAccelerator, BuildError> {
    let is_small = is_small(primitives, 0..primitives.len() as u32);
    let accelerator =
        AnyAccelerator::build_with(choose(accel_options.accel, is_small), accel_options.quality, primitives)?;
    Ok(match accel_options.simd {
        Some(level) => accelerator.with_level(level),
        None => accelerator,
    })
}

/// Kind for an option; `Auto` is brute force for a [small](is_small) set of primitives and the 8-wide BVH otherwise.
pub(crate) const fn choose(accel: Accel, is_small: bool) -> AcceleratorKind {
    match accel {
        Accel::Auto if is_small => AcceleratorKind::Linear,
        Accel::Auto | Accel::Wide => AcceleratorKind::Wide,
        Accel::Bvh => AcceleratorKind::Bvh,
        Accel::Linear => AcceleratorKind::Linear,
        Accel::Grid => AcceleratorKind::Grid,
        Accel::Spheres => AcceleratorKind::Spheres,
        Accel::Cylinders => AcceleratorKind::Cylinders,
        Accel::Kd => AcceleratorKind::Kd,
        Accel::Bsp => AcceleratorKind::Bsp,
        Accel::Bih => AcceleratorKind::Bih,
        Accel::BihLazy => AcceleratorKind::BihLazy,
    }
}

/// Describes the rule by which [`build`] chooses.
pub(crate) fn reason<P: Primitives>(accel_options: AccelOptions, primitives: &P) -> String {
    let count = primitives.len();
    match accel_options.accel {
        Accel::Auto if count <= MAX_LINEAR => format!("at most {MAX_LINEAR}: brute force is faster than a tree"),
        Accel::Auto if is_small(primitives, 0..count as u32) => {
            format!("at most {MAX_LINEAR_SPHERES} spheres: brute force with 8 rays at a time is faster than a tree")
        }
        Accel::Auto => {
            format!("default for more than {MAX_LINEAR}; {}", size_spread(primitives))
        }
        _ => "as requested".to_owned(),
    }
}

/// Describes the range of sizes of primitives, by the longest edges of their bounds.
fn size_spread<P: Primitives>(primitives: &P) -> String {
    let sizes = (0..primitives.len() as u32).filter_map(|index| primitives.bounds(index));
    let sizes = sizes.map(|bounds| bounds.extent().max_element());
    let (min, max) = sizes.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), size| (a.min(size), b.max(size)));
    let ratio = max / min;
    match ratio {
        _ if min == f64::INFINITY => "all unbounded".to_owned(),
        0.0..1.5 => "all of similar size".to_owned(),
        1.5..10.0 => format!("the largest is {ratio:.1} times the size of the smallest"),
        10.0..1e6 => format!("the largest is {ratio:.0} times the size of the smallest"),
        _ => format!("sizes from {min:.1e} to {max:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_geometry::{Sphere, Spheres};
    use rt_math::DVec3;

    #[test]
    fn every_accelerator_is_selected_by_its_name() {
        let named = |accel: &Accel| choose(*accel, true).name();
        for accel in Accel::ALL.iter().filter(|accel| **accel != Accel::Auto) {
            assert_eq!(named(accel), accel.name());
        }
        assert_eq!(Accel::ALL.len(), AcceleratorKind::ALL.len() + 1);
    }

    fn spheres(radii: &[f64]) -> Spheres {
        Spheres::new(radii.iter().map(|&radius| Sphere::new(DVec3::ZERO, radius).expect("a sphere")).collect())
    }

    #[test]
    fn reasons_name_the_rule_and_its_input() {
        let auto = AccelOptions::default();
        let reason = |radii: &[f64]| reason(auto, &spheres(radii));
        assert_eq!(reason(&[1.0; 8]), "at most 8: brute force is faster than a tree");
        assert!(reason(&[1.0; 16]).starts_with("at most 16 spheres"), "{}", reason(&[1.0; 16]));
        let of = |radius: f64| reason(&[[1.0; 16].as_slice(), &[radius]].concat());
        assert_eq!(of(0.025), "default for more than 8; the largest is 40 times the size of the smallest");
        assert!(of(0.9).contains("similar size") && of(0.4).contains("2.5 times"), "{}", of(0.4));
        assert!(of(1e-9).contains("sizes from 2.0e-9 to 2.0e0"), "{}", of(1e-9));
        assert_eq!(super::reason(AccelOptions { accel: Accel::Grid, ..auto }, &spheres(&[1.0])), "as requested");
    }
}
