//! Brute force: tests each primitive, in `f64`.
//!
//! Reference of all tests, also for [`Linear`](crate::Linear), which has faster paths:
//!
//! ```
//! use rt_accel::{Aabb, Accelerator, Boxes, DVec3, Interval, NoProbe, Ray, WideBvh, brute_force};
//!
//! let boxes = [Aabb::new(DVec3::ZERO, DVec3::ONE), Aabb::new(DVec3::splat(2.0), DVec3::splat(3.0))];
//! let boxes = Boxes(&boxes);
//! let (ray, span) = (Ray::new(DVec3::splat(4.0), DVec3::NEG_ONE), Interval::FORWARD);
//! let expected = brute_force::closest(&boxes, &ray, span, &mut NoProbe);
//! assert_eq!(WideBvh::build(&boxes)?.closest(&boxes, &ray, span, &mut NoProbe), expected);
//! assert_eq!(expected.map(|hit| hit.primitive), Some(1));
//! # Ok::<(), rt_accel::BuildError>(())
//! ```

use rt_geometry::{Hit, Primitives, Probe};
use rt_math::{Interval, Ray};

use crate::RayQuery;
use crate::ray_query::{AnyHit, Closest};

/// The closest hit within `span`, the smallest by (t, instance, primitive). Tests every primitive.
pub fn closest<P: Primitives, S: Probe>(primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> Option<Hit> {
    let mut query = Closest::new(ray, span);
    for index in 0..primitives.len() as u32 {
        let _ = query.test_primitive(primitives, index, probe);
    }
    query.hit
}

/// True if any primitive is hit within `span`. Tests the primitives up to the first hit.
pub fn occluded<P: Primitives, S: Probe>(primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
    let mut query = AnyHit::new(ray, span);
    (0..primitives.len() as u32).any(|index| query.test_primitive(primitives, index, probe).is_break())
}
