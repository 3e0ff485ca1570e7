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
//! | particles, atoms, a heap | [`UniformGrid`](crate::UniformGrid) | as fast as the best tree, a tenth of its build |
//! | small objects in a large scene | [`WideBvh`](crate::WideBvh) | the grid takes 1700 times its work on *stadium* |
//! | objects that move a little | [`Bvh`](crate::Bvh) and [`Refit`](crate::Refit) | O(n), keeps the tree |
//! | objects that move at random | [`Bih`](crate::Bih) or [`UniformGrid`](crate::UniformGrid) | builds take a tenth to a fifth |
//! | the inside of a building | [`Bvh`](crate::Bvh) or [`KdTree`](crate::KdTree) | measure both: parts of the latter never overlap |
//! | little memory | [`Bih`](crate::Bih) | under 20 bytes per primitive |
//! | a volume of your own | [`VolumeTree`](crate::VolumeTree) | one trait to implement |
//! | a test to write | [`brute_force`](crate::brute_force) | it is right by definition |
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
