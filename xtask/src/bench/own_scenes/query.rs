//! Queries to measure.

use rt_accel::{AcceleratorQueries, AcceleratorVisitor, AnyAccelerator, NoProbe, Primitives};

use crate::scenes::rays::RaySet;

/// Traces the first `count` rays one by one and counts those that hit.
pub(super) fn count_hits<P: Primitives>(
    structure: &AnyAccelerator,
    primitives: &P,
    rays: &RaySet,
    count: usize,
) -> u64 {
    structure.accept(Trace { primitives, rays, count })
}

struct Trace<'a, P> {
    primitives: &'a P,
    rays: &'a RaySet,
    count: usize,
}

impl<P: Primitives> AcceleratorVisitor for Trace<'_, P> {
    type Output = u64;

    fn visit<T: AcceleratorQueries>(self, structure: &T) -> u64 {
        let Self { primitives, rays, count } = self;
        let rays_in = rays.rays.iter().take(count);
        let hits = if rays.any {
            rays_in.filter(|(ray, span)| structure.occluded(primitives, ray, *span, &mut NoProbe)).count()
        } else {
            rays_in.filter(|(ray, span)| structure.closest(primitives, ray, *span, &mut NoProbe).is_some()).count()
        };
        hits as u64
    }
}
