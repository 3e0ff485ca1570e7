//! All structures over the same primitives.

use rt_accel::{Accelerator, Bvh, Counters, Hit, Interval, Linear, NoProbe, Primitives, Ray, UniformGrid};

pub(crate) struct Structures {
    pub(crate) linear: Linear,
    pub(crate) grid: UniformGrid,
    pub(crate) bvh: Bvh,
}

impl Structures {
    /// Builds and validates all of them.
    pub(crate) fn build<P: Primitives>(primitives: &P) -> Self {
        let all = Self {
            linear: Linear::build(primitives).expect("a list"),
            grid: UniformGrid::build(primitives).expect("a grid"),
            bvh: Bvh::build(primitives).expect("a tree"),
        };
        assert_eq!(all.linear.validate(primitives), Ok(()));
        assert_eq!(all.grid.validate(primitives), Ok(()));
        assert_eq!(all.bvh.validate(primitives), Ok(()));
        all
    }

    /// The answer that all of them agree on.
    pub(crate) fn closest<P: Primitives>(&self, primitives: &P, ray: &Ray, span: Interval) -> Option<Hit> {
        let expected = self.linear.closest(primitives, ray, span, &mut NoProbe);
        for (name, found, blocked) in [
            ("linear", expected, self.linear.occluded(primitives, ray, span, &mut NoProbe)),
            ("grid", ask(&self.grid, primitives, ray, span), self.grid.occluded(primitives, ray, span, &mut NoProbe)),
            ("bvh", ask(&self.bvh, primitives, ray, span), self.bvh.occluded(primitives, ray, span, &mut NoProbe)),
        ] {
            let key = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.instance, hit.primitive));
            assert_eq!(key(found), key(expected), "{name}: {ray:?} {span:?}");
            assert_eq!(blocked, expected.is_some(), "{name}, occluded: {ray:?} {span:?}");
        }
        expected
    }
}

fn ask<A: Accelerator, P: Primitives>(structure: &A, primitives: &P, ray: &Ray, span: Interval) -> Option<Hit> {
    structure.closest(primitives, ray, span, &mut NoProbe)
}

/// Primitives offered per ray.
pub(crate) fn tests_per_ray<A: Accelerator, P: Primitives>(structure: &A, primitives: &P, rays: &[Ray]) -> f64 {
    let mut counters = Counters::default();
    for ray in rays {
        structure.closest(primitives, ray, Interval::FORWARD, &mut counters);
    }
    counters.total().tests as f64 / rays.len() as f64
}
