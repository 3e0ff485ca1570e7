//! Rays that leave a surface neither meet it again by rounding nor jump over what is close to it.

use rt_tests::{SPAWN_SETUPS, Spawned};

#[test]
fn a_triangle_of_any_size_anywhere_has_neither_acne_nor_leaks() {
    for setup in SPAWN_SETUPS {
        let result = setup.spawn(0..50_000).expect("a triangle");
        assert!(result.spawned > 49_500, "{setup:?}: {result:?}");
        assert_eq!(result, Spawned { spawned: result.spawned, acne: 0, leaks: 0 }, "{setup:?}");
    }
}
