//! Which acceleration structure, and why.

use rt_accel::wide::{Quality, SimdLevel, SmallSet};
use rt_accel::{AcceleratorKind, AnyAccelerator, BuildError};
use rt_geometry::{PrimitiveGeometry, Primitives};
use rt_scene_io::Accel;

/// Up to this many primitives, asking each is faster than walking a tree.
pub(crate) const FEW: usize = 8;

/// The same of primitives that are all spheres, which are asked for many rays at once.
pub(crate) const FEW_SPHERES: usize = SmallSet::CAPACITY;

/// True for primitives of which asking each is faster than walking a tree.
pub(crate) fn are_few<P: Primitives>(primitives: &P, mut indices: impl ExactSizeIterator<Item = u32>) -> bool {
    let is_round = |index| matches!(primitives.geometry(index), PrimitiveGeometry::ExactSphere(_));
    let count = indices.len();
    count <= FEW || count <= FEW_SPHERES && indices.all(is_round)
}

/// What structures are asked for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wanted {
    pub(crate) accel: Accel,
    /// The instructions to use; `None` for the best that the processor has.
    pub(crate) simd: Option<SimdLevel>,
    /// How much time the builder may take.
    pub(crate) quality: Quality,
}

/// Builds what is wanted, or for `Auto` what fits the primitives.
pub(crate) fn build<P: Primitives>(wanted: Wanted, primitives: &P) -> Result<AnyAccelerator, BuildError> {
    let are_few = are_few(primitives, 0..primitives.len() as u32);
    let structure = AnyAccelerator::build_with(choose(wanted.accel, are_few), wanted.quality, primitives)?;
    Ok(match wanted.simd {
        Some(level) => structure.with_level(level),
        None => structure,
    })
}

/// What `accel` asks for; `Auto` is brute force for [few](are_few) primitives and the wide tree of boxes otherwise.
pub(crate) const fn choose(accel: Accel, are_few: bool) -> AcceleratorKind {
    match accel {
        Accel::Auto if are_few => AcceleratorKind::Linear,
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

/// The rule by which [`build`] chooses, and the measures that it looks at, for people.
pub(crate) fn why<P: Primitives>(wanted: Wanted, primitives: &P) -> String {
    let count = primitives.len();
    match wanted.accel {
        Accel::Auto if count <= FEW => format!("up to {FEW}: asking each is faster than walking a tree"),
        Accel::Auto if are_few(primitives, 0..count as u32) => {
            format!("up to {FEW_SPHERES} spheres: asking each, for eight rays at a time, is faster than walking a tree")
        }
        Accel::Auto => {
            format!("more than {FEW}, {}: eight boxes at a time suit all sizes and places", spread(primitives))
        }
        _ => "as asked".to_owned(),
    }
}

/// How different in size the primitives are, by the longest edges of their boxes.
fn spread<P: Primitives>(primitives: &P) -> String {
    let sizes = (0..primitives.len() as u32).filter_map(|index| primitives.bounds(index));
    let sizes = sizes.map(|bounds| bounds.extent().max_element());
    let (least, greatest) = sizes.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), size| (a.min(size), b.max(size)));
    let ratio = greatest / least;
    match ratio {
        _ if least == f64::INFINITY => "none of them bounded".to_owned(),
        0.0..1.5 => "all of about one size".to_owned(),
        1.5..10.0 => format!("sizes spread 1:{ratio:.1}"),
        10.0..1e6 => format!("sizes spread 1:{ratio:.0}"),
        _ => format!("sizes from {least:.1e} to {greatest:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_geometry::{Sphere, Spheres};
    use rt_math::DVec3;

    #[test]
    fn every_structure_can_be_asked_for_by_its_name() {
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
    fn reasons_name_the_rule_and_what_it_looked_at() {
        let auto = Wanted::default();
        let why = |radii: &[f64]| why(auto, &spheres(radii));
        assert_eq!(why(&[1.0; 8]), "up to 8: asking each is faster than walking a tree");
        assert!(why(&[1.0; 16]).starts_with("up to 16 spheres"), "{}", why(&[1.0; 16]));
        let of = |least: f64| why(&[[1.0; 16].as_slice(), &[least]].concat());
        assert_eq!(of(0.025), "more than 8, sizes spread 1:40: eight boxes at a time suit all sizes and places");
        assert!(of(0.9).contains("about one size") && of(0.4).contains("1:2.5"), "{}", of(0.4));
        assert!(of(1e-9).contains("sizes from 2.0e-9 to 2.0e0"), "{}", of(1e-9));
        assert_eq!(super::why(Wanted { accel: Accel::Grid, ..auto }, &spheres(&[1.0])), "as asked");
    }
}
