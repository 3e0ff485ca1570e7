//! Trees of bounding spheres and of bounding cylinders.
//!
//! **The idea**: as [`bvh`](super::bvh), with another shape around each set of primitives. Spheres need few numbers and
//! have no orientation; cylinders are parallel to the x, y or z axis, with the smallest surface of the three.
//!
//! Spheres:
#![doc = include_str!("figures/sphere-tree.html")]
//!
//! Cylinders:
#![doc = include_str!("figures/cylinder-tree.html")]
//!
//! In the left image, blue volumes are the two sides of the first split. Spheres extend far beyond flat contents, and
//! overlap much. A row of objects fits into a horizontal cylinder, a heap into an upright one.
//!
//! **Build**: [`VolumeTree`](crate::VolumeTree) is one tree over any [`BoundingVolume`](crate::BoundingVolume). It uses
//! the surface area heuristic with the area of the volume around all bins of a side.
//!
//! **Traversal**: as in a tree of boxes, nearer volume first. The entry into a sphere takes a square root.
//!
//! **Why it equals brute force**: round volumes are not monotone as boxes are. The computed chord of a larger sphere
//! may begin later than that of a sphere inside it. So radii are widened by more than all rounding together, which
//! depends on the distance of the ray's origin. Volumes enclose padded bounds, not primitives. This is the price of
//! identical results, and one reason why a sphere around a sphere is a loose fit here.
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
//! boxes on our scenes, cylinders 1.1 to 1.2 times. The test of a volume also takes longer than that of a box.
//!
//! **Choose them** to compare volumes, or for a volume that fits your primitives better than boxes. Otherwise take the
//! [`Bvh`](crate::Bvh).
//!
//! **Papers**: Whitted, "An improved illumination model for shaded display", 1980, uses bounding spheres. Weghorst,
//! Hooper and Greenberg, "Improved computational methods for ray tracing", 1984, compare volumes.
