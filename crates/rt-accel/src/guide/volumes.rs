//! Trees of bounding spheres and of bounding cylinders.
//!
//! **The idea**: as [`bvh`](super::bvh), with another shape around each set of primitives. Spheres need few numbers
//! and are the same from all sides; cylinders stand along the x, y or z axis, whichever makes the smallest surface.
//!
//! Spheres:
#![doc = include_str!("figures/spheres.html")]
//!
//! Cylinders:
#![doc = include_str!("figures/cylinders.html")]
//!
//! On the left, blue volumes are the two sides of the first cut. Spheres reach far beyond what they hold, as things on
//! a table are flat and spheres are not, and overlap much. A row of things fits into a cylinder that lies, a heap into
//! one that stands.
//!
//! **Build**: [`VolumeTree`](crate::VolumeTree) is one tree over any [`BoundingVolume`](crate::BoundingVolume). It is
//! cut by the surface area heuristic with the area of the volume at hand, which for every border of bins is that of
//! the volume around all of the bins.
//!
//! **Walk**: as in a tree of boxes, nearer volume first. The entry into a sphere takes a square root.
//!
//! **Why it equals brute force**: round volumes are not monotone as boxes are. The chord of a larger sphere, computed,
//! may begin later than that of a sphere inside it. So radii are widened by more than all rounding together, which
//! depends on how far away the ray starts. Volumes are around own boxes, not around primitives: this is the price of
//! equal bits, and one reason why a sphere around a sphere is a loose fit here.
//!
//! # Cost
//!
//! | nodes + tests | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | spheres, a primary ray | 16 + 4 | 11 + 2 | 14 + 3 | 26 + 17 |
//! | spheres, a diffuse ray | 45 + 14 | 35 + 8 | 37 + 11 | 28 + 18 |
//! | cylinders, a primary ray | 11 + 2 | 9 + 1 | 10 + 2 | 21 + 7 |
//! | cylinders, a diffuse ray | 28 + 8 | 27 + 4 | 27 + 7 | 21 + 9 |
//!
//! Some 15 to 50 bytes per primitive for spheres and 45 to 85 for cylinders. Spheres take 1.4 to 2.7 times the work of
//! boxes on our scenes, cylinders 1.1 to 1.2 times; each volume also takes longer to look at than a box.
//!
//! **Choose them** to compare volumes, or for a volume of your own that fits your primitives better than boxes do.
//! Otherwise take the [`Bvh`](crate::Bvh).
//!
//! **Papers**: Whitted, "An improved illumination model for shaded display", 1980, put spheres around things; Weghorst,
//! Hooper and Greenberg, "Improved computational methods for ray tracing", 1984, compare volumes.
