//! Recommendations.
//!
//! ```text
//!     up to ten primitives? ──────────── yes ─▶ Linear
//!        │ no
//!     of similar size, evenly spread? ── yes ─▶ UniformGrid
//!        │ no
//!     another scene for every image? ─ yes ─▶ Bih, or LazyBih if little of it is seen
//!        │ no
//!     else ────────────────────────────────────▶ WideBvh
//! ```
//!
//! | what you have | take | because |
//! |---|---|---|
//! | no idea | [`WideBvh`](crate::WideBvh) | eight boxes at a time, no bad scenes |
//! | particles, atoms, a heap | [`UniformGrid`](crate::UniformGrid) | a build takes 0.1 to 0.3 of that of `Bvh`; rays take up to 2.2 times as long as in `WideBvh` |
//! | small objects in a large scene | [`WideBvh`](crate::WideBvh) | on *stadium* the grid takes 1700 times the work of `Bvh` |
//! | objects that move a little | [`Bvh`](crate::Bvh) and [`Refit`](crate::Refit) | O(n), keeps the tree |
//! | objects that move at random | [`Bih`](crate::Bih) or [`UniformGrid`](crate::UniformGrid) | builds take a tenth to a third |
//! | the inside of a building | [`Bvh`](crate::Bvh) or [`KdTree`](crate::KdTree) | measure both: parts of the latter never overlap |
//! | little memory | [`Bih`](crate::Bih) | under 20 bytes per primitive |
//! | a volume of your own | [`VolumeTree`](crate::VolumeTree) | one trait to implement |
//! | a test to write | [`brute_force`](crate::brute_force) | it is right by definition |
//!
//! Costs, for 10³ to 10⁵ primitives; `docs/COSTS.md` of the repository lists all measurements:
//!
//! | accelerator | build time, relative to `Bvh` | bytes per primitive |
//! |---|---|---|
//! | [`WideBvh`](crate::WideBvh) | 1 or less | 34 to 58 |
//! | [`Bvh`](crate::Bvh) | 1 | 25 to 45 |
//! | [`Linear`](crate::Linear) | checks and copies | 16 for spheres, 0 for others |
//! | [`UniformGrid`](crate::UniformGrid) | 0.1 to 0.3 | 30 to 100 |
//! | [`KdTree`](crate::KdTree) | 3 to 8 | 45 to 100 |
//! | [`BspTree`](crate::BspTree) | 6 to 30 | 110 to 210 |
//! | [`Bih`](crate::Bih) | 0.1 to 0.3 | under 20 |
//! | [`LazyBih`](crate::LazyBih) | on demand | 40 to 60 |
//! | [`SphereTree`](crate::SphereTree), [`CylinderTree`](crate::CylinderTree) | 0.7 to 1.7, 1.5 to 5 | 15 to 85 |
//!
//! All return identical results, so that the choice never changes an image:
//!
//! ```
//! use rt_accel::{Aabb, Accelerator, AnyAccelerator, Boxes, DVec3, Interval, NoProbe, Ray, AcceleratorKind, brute_force};
//!
//! let boxes: Vec<Aabb> = (0..100)
//!     .map(|i| DVec3::new(f64::from(i % 10), f64::from(i / 10), f64::from(i % 7)))
//!     .map(|corner| Aabb::new(corner, corner + 0.8))
//!     .collect();
//! let boxes = Boxes(&boxes);
//! let ray = Ray::new(DVec3::new(-1.0, 0.3, 0.2), DVec3::new(1.0, 0.2, 0.1));
//! let expected = brute_force::closest(&boxes, &ray, Interval::FORWARD, &mut NoProbe);
//! for kind in AcceleratorKind::ALL {
//!     let accelerator = AnyAccelerator::build(*kind, &boxes)?;
//!     assert_eq!(accelerator.closest(&boxes, &ray, Interval::FORWARD, &mut NoProbe), expected);
//! }
//! # Ok::<(), rt_accel::BuildError>(())
//! ```
//!
//! [`AnyAccelerator`](crate::AnyAccelerator) chooses at run time, for one `match` per query. Measure with your own
//! primitives: [`Counters`](crate::Counters) count nodes and tests, and
//! [`build_stats`](crate::Accelerator::build_stats) describes the result of a build.
