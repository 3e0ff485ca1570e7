//! The BSP tree: space divided by planes of any direction.
//!
//! **The idea**: as [`kd`](super::kd), but planes come from the geometry. Two walls at an odd angle are separated by a
//! wall, not by an axis-aligned plane.
#![doc = include_str!("figures/bsp.html")]
//!
//! In the left image, axis-aligned planes were the best for most splits of so round and distant objects. Parts at
//! slanted planes are drawn as their boxes, which overlap although the parts do not.
//!
//! **Build**: some primitives propose planes. Triangles propose their own plane, spheres planes that face another
//! sphere, through their centre and on either side of their padded bounds. Every primitive proposes the faces of its
//! padded bounds. The surface area heuristic compares them. The parts are not boxes, and their areas are expensive. So
//! sample points estimate their sizes, and a sample of the other primitives their contents.
//!
//! **Traversal**: as in a kd-tree, with a dot product for each plane.
//!
//! **Why it equals brute force**: the height of a point above a slanted plane has a rounding error with a known bound.
//! Both sides are visited if the ray is nearer to the plane than that. A primitive is listed on both sides if its
//! padded bounds are as near. Primitives are never split, as this would move their edges.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 14 + 4 | 18 + 3 | 17 + 4 | 53 + 12 |
//! | nodes + tests of a diffuse ray | 28 + 13 | 37 + 10 | 40 + 16 | 44 + 12 |
//!
//! About 110 to 210 bytes per primitive, and 2 to 5 times the build of a kd-tree. On our scenes that freedom does not
//! pay: padded bounds are axis-aligned, so that slanted planes separate them less well than the primitives.
//!
//! **Choose it** for long walls at odd angles with empty space between them, or to see which planes fit a scene.
//! Otherwise a [`KdTree`](crate::KdTree) is smaller, built sooner, and traversed faster.
//!
//! **Papers**: Fuchs, Kedem and Naylor, "On visible surface generation by a priori tree structures", 1980. Ize, Wald
//! and Parker, "Ray Tracing with the BSP Tree", 2008.
