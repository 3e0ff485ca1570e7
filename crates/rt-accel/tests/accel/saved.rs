//! Accelerators survive being saved; what was tampered with is refused, or answers without panicking.

use crate::soup::{Solid, Soup};
use rt_accel::{
    Aabb, Accelerator, AcceleratorKind, AnyAccelerator, Bih, BuildError, Bvh, CylinderTree, DVec3, Interval, LazyBih,
    Linear, NoProbe, Ray, SphereTree, SplitMethod,
};
use rt_tests::Draw;
use serde::Serialize;
use serde::de::DeserializeOwned;

fn scene() -> Soup {
    let mut soup = Soup(Soup::mixed(&mut Draw::new(1)).0.into_iter().take(60).collect());
    soup.0.push(Solid::Ground { height: -0.5 });
    soup
}

fn rays() -> Vec<Ray> {
    let mut draw = Draw::new(2);
    (0..200).map(|_| Ray::new(draw.point() * 2.0, draw.point())).collect()
}

/// Changes numbers of the saved text, one at a time.
fn mutations(text: &str) -> impl Iterator<Item = String> {
    let digits: Vec<_> = text.char_indices().filter(|(_, c)| c.is_ascii_digit()).map(|(at, _)| at).collect();
    let step = (digits.len() / 400).max(1);
    let replacements = ["9", "-1", "4294967295", "1e300", "0"];
    digits.into_iter().step_by(step).zip(replacements.into_iter().cycle()).map(move |(at, with)| {
        let mut changed = text.to_owned();
        changed.replace_range(at..=at, with);
        changed
    })
}

fn check<S: Accelerator + Serialize + DeserializeOwned + PartialEq + core::fmt::Debug>(accelerator: &S, soup: &Soup) {
    let text = serde_json::to_string(accelerator).unwrap();
    let loaded: S = serde_json::from_str(&text).unwrap();
    assert_eq!(&loaded, accelerator);
    assert_eq!(loaded.validate(soup), Ok(()));
    let (mut n_refused, mut n_harmless) = (0, 0);
    for changed in mutations(&text) {
        let Ok(loaded) = serde_json::from_str::<S>(&changed) else {
            n_refused += 1;
            continue;
        };
        // One for more primitives than there are belongs to others.
        if loaded.build_stats().primitives > soup.0.len() {
            n_refused += 1;
            continue;
        }
        // It may well miss things, but it must not fall over or run forever.
        for ray in rays() {
            loaded.closest(soup, &ray, Interval::FORWARD, &mut NoProbe);
            loaded.occluded(soup, &ray, Interval::FORWARD, &mut NoProbe);
        }
        loaded.nearest_point(soup, DVec3::ZERO, 1.0);
        n_harmless += 1;
    }
    println!("{n_refused} changes refused, {n_harmless} harmless");
    assert!(n_refused > 0);
}

#[test]
fn every_accelerator_can_be_saved() {
    for &kind in AcceleratorKind::ALL {
        check(&AnyAccelerator::build(kind, &scene()).unwrap(), &scene());
    }
}

#[test]
fn lists_of_spheres_can_be_saved() {
    let spheres = Soup::spheres(21, &mut Draw::new(4));
    let linear = Linear::build(&spheres).unwrap();
    assert!(linear.memory() > 16 * 21);
    check(&linear, &spheres);
    // An invalid sphere would be tested by its index.
    let text = serde_json::to_string(&linear).unwrap();
    let with_another = text.replacen(&serde_json::to_string(&f32::MIN).unwrap(), "1.0", 1);
    assert_ne!(with_another, text);
    assert!(serde_json::from_str::<Linear>(&with_another).is_err());
}

#[test]
fn trees_of_all_methods_can_be_saved() {
    check(&Bvh::build_with(&scene(), SplitMethod::Median).unwrap(), &scene());
    let sticks = Soup::sticks(60, &mut Draw::new(3));
    let cut = Bvh::build_with(&sticks, SplitMethod::Spatial).unwrap();
    assert!(cut.build_stats().references > 60);
    check(&cut, &sticks);
    let nothing = Soup(vec![]);
    check(&Bvh::build(&nothing).unwrap(), &nothing);
}

#[test]
fn a_tree_is_saved_as_far_as_it_has_been_split() {
    let soup = scene();
    let lazy = LazyBih::build(&soup).unwrap();
    for ray in &rays()[..3] {
        lazy.closest(&soup, ray, Interval::FORWARD, &mut NoProbe);
    }
    let part = lazy.build_stats();
    check(&lazy, &soup);
    assert_eq!(lazy.build_stats(), part, "saving splits nothing");
    lazy.complete();
    assert!(part.nodes > 0 && part.nodes < lazy.build_stats().nodes, "{part:?}");
    check(&lazy, &soup);
}

#[test]
fn trees_of_nothing_and_of_extreme_numbers_can_be_saved() {
    fn check<S: Serialize + DeserializeOwned + PartialEq + core::fmt::Debug>(accelerator: Result<S, BuildError>) {
        let accelerator = accelerator.unwrap();
        let text = serde_json::to_string(&accelerator).unwrap();
        assert_eq!(serde_json::from_str::<S>(&text).unwrap(), accelerator);
    }
    for &kind in AcceleratorKind::ALL {
        check(AnyAccelerator::build(kind, &Soup(vec![])));
    }
    let huge = Aabb::new(DVec3::splat(-1e300), DVec3::splat(1e300));
    for soup in [Soup(vec![]), Soup(vec![Solid::Ghost(huge); 20])] {
        check(SphereTree::build(&soup));
        check(CylinderTree::build(&soup));
        check(Bih::build(&soup));
        check(LazyBih::build(&soup));
    }
}
