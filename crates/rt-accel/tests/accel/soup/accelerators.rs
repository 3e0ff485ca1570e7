//! All accelerators over the same primitives.

use rt_accel::{
    Accelerator, AcceleratorKind, AnyAccelerator, Bvh, Counters, Hit, Interval, Linear, NoProbe, Primitives, Ray,
    UniformGrid, brute_force,
};

/// One of each kind, brute force first.
pub(crate) struct Accelerators(pub(crate) Vec<AnyAccelerator>);

impl Accelerators {
    /// Builds and validates all of them.
    pub(crate) fn build<P: Primitives>(primitives: &P) -> Self {
        let build = |&kind: &AcceleratorKind| {
            let accelerator = AnyAccelerator::build(kind, primitives).expect("an accelerator");
            assert_eq!(accelerator.validate(primitives), Ok(()), "{}", kind.name());
            accelerator
        };
        Self(AcceleratorKind::ALL.iter().map(build).collect())
    }

    pub(crate) fn linear(&self) -> &Linear {
        self.0.iter().find_map(|s| if let AnyAccelerator::Linear(s) = s { Some(s) } else { None }).expect("a list")
    }

    pub(crate) fn grid(&self) -> &UniformGrid {
        self.0.iter().find_map(|s| if let AnyAccelerator::Grid(s) = s { Some(s) } else { None }).expect("a grid")
    }

    pub(crate) fn bvh(&self) -> &Bvh {
        self.0.iter().find_map(|s| if let AnyAccelerator::Bvh(s) = s { Some(s) } else { None }).expect("a tree")
    }

    /// The answer of brute force, which all of them agree with.
    pub(crate) fn closest<P: Primitives>(&self, primitives: &P, ray: &Ray, span: Interval) -> Option<Hit> {
        let expected = brute_force::closest(primitives, ray, span, &mut NoProbe);
        for accelerator in &self.0 {
            let name = accelerator.kind().name();
            let found = accelerator.closest(primitives, ray, span, &mut NoProbe);
            let key = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.instance, hit.primitive));
            assert_eq!(key(found), key(expected), "{name}: {ray:?} {span:?}");
            let occluded = accelerator.occluded(primitives, ray, span, &mut NoProbe);
            assert_eq!(occluded, expected.is_some(), "{name}, occluded: {ray:?} {span:?}");
        }
        expected
    }
}

/// Primitives tested per ray.
pub(crate) fn tests_per_ray<A: Accelerator, P: Primitives>(accelerator: &A, primitives: &P, rays: &[Ray]) -> f64 {
    let mut counters = Counters::default();
    for ray in rays {
        accelerator.closest(primitives, ray, Interval::FORWARD, &mut counters);
    }
    counters.total().tests as f64 / rays.len() as f64
}
