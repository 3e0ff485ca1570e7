//! Refused input, validation and memory.

use rt_accel::{
    Aabb, Accelerator, AcceleratorKind, AnyAccelerator, BuildError, DVec3, Hit, Interval, Linear, Primitives, Ray,
    UniformGrid, ValidationError,
};

use super::unit_box;
use crate::soup::accelerators::Accelerators;
use crate::soup::{Solid, Soup};
use rt_tests::Draw;

#[test]
fn bounds_that_are_no_boxes_are_refused_by_index() {
    let good = Aabb::new(DVec3::ZERO, DVec3::ONE);
    let bad = [
        (Aabb::new(DVec3::new(0.0, f64::NAN, 0.0), DVec3::ONE), "NaN"),
        (Aabb::new(DVec3::ZERO, DVec3::NAN), "NaN"),
        (Aabb::new(DVec3::ONE, DVec3::ZERO), "min exceeds max"),
        (Aabb::EMPTY, "min exceeds max"),
        (Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY), "return `None`"),
        (Aabb::new(DVec3::ZERO, DVec3::new(1.0, f64::INFINITY, 1.0)), "return `None`"),
        (Aabb::new(DVec3::ZERO, DVec3::splat(f64::MAX)), "size overflows"),
    ];
    for (bounds, reason) in bad {
        let mut soup = Soup(vec![Solid::Ghost(good); 9]);
        soup.0[7] = Solid::Ghost(bounds);
        soup.0[8] = Solid::Ghost(bounds);
        let of_kinds = AcceleratorKind::ALL.iter().map(|&kind| AnyAccelerator::build(kind, &soup).unwrap_err());
        for error in of_kinds.chain([UniformGrid::with_resolution(&soup, [2; 3]).unwrap_err()]) {
            assert!(matches!(error, BuildError::BadBounds { index: 7, .. }), "{error:?}");
            assert!(error.to_string().contains("primitive 7") && error.to_string().contains(reason), "{error}");
        }
    }
}

#[test]
fn too_many_primitives_or_cells_are_refused() {
    struct Endless;
    impl Primitives for Endless {
        fn len(&self) -> usize {
            u32::MAX as usize
        }
        fn bounds(&self, _: u32) -> Option<Aabb> {
            None
        }
        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }
    let expected = BuildError::TooMany { count: u64::from(u32::MAX), limit: u64::from(u32::MAX - 1) };
    for &kind in AcceleratorKind::ALL {
        assert_eq!(AnyAccelerator::build(kind, &Endless).unwrap_err(), expected, "{}", kind.name());
    }

    let soup = Soup(vec![unit_box(DVec3::ONE); 100]);
    for resolution in [[4096; 3], [u32::MAX; 3], [300; 3]] {
        let error = UniformGrid::with_resolution(&soup, resolution).unwrap_err();
        assert!(matches!(error, BuildError::TooMany { .. }), "{error:?}");
    }
}

#[test]
fn memory_is_what_the_parts_add_up_to() {
    let soup = Soup::spheres(10_000, &mut Draw::new(2));
    let all = Accelerators::build(&soup);
    let (tree, grid) = (all.bvh().build_stats(), all.grid().build_stats());
    assert_eq!(tree.references, 10_000);
    assert_eq!(tree.leaves, tree.nodes + 1);
    let tree_bytes = 64 * tree.nodes + 4 * tree.references;
    assert!((tree_bytes..tree_bytes + 512).contains(&all.bvh().memory()), "{} {tree:?}", all.bvh().memory());
    assert!(all.bvh().memory() < 64 * 10_000);
    let grid_bytes = 4 * (grid.nodes + 1 + grid.references);
    assert!((grid_bytes..grid_bytes + 512).contains(&all.grid().memory()), "{} {grid:?}", all.grid().memory());
    assert!((16 * 10_000..17 * 10_000).contains(&all.linear().memory()), "{}", all.linear().memory());
    let grounds = Soup(vec![Solid::Ground { height: 0.0 }; 1000]);
    assert!(Linear::build(&grounds).unwrap().memory() < 256, "nothing is copied");
}

#[test]
fn accelerators_notice_that_primitives_have_changed() {
    let mut soup = Soup::spheres(300, &mut Draw::new(1));
    let all = Accelerators::build(&soup);
    let verdicts = |soup: &Soup| all.0[1..].iter().map(|accelerator| accelerator.validate(soup)).collect::<Vec<_>>();
    let each = |verdict| vec![verdict; all.0.len() - 1];

    let last = soup.0.pop().unwrap();
    let fewer = ValidationError::Count { built: 300, given: 299 };
    assert_eq!(verdicts(&soup), each(Err(fewer)));
    assert_eq!(all.linear().validate(&soup), Err(fewer));
    soup.0.push(Solid::Ground { height: 0.0 });
    assert_eq!(all.linear().validate(&soup), Err(ValidationError::Outside { primitive: 299 }));
    assert_eq!(verdicts(&soup), each(Err(ValidationError::Misplaced { primitive: 299 })));
    soup.0[299] = Solid::Box(Aabb::new(DVec3::splat(5.0), DVec3::splat(6.0)));
    assert_eq!(verdicts(&soup), each(Err(ValidationError::Outside { primitive: 299 })));
    assert_eq!(all.linear().validate(&soup), Err(ValidationError::Outside { primitive: 299 }));
    soup.0[299] = last;
    assert_eq!(verdicts(&soup), each(Ok(())));
    assert_eq!(all.linear().validate(&soup), Ok(()));
}
