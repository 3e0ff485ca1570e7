//! The BSP tree: space cut by planes of any direction.
//!
//! **The idea**: as [`kd`](super::kd), but planes come from the geometry. What separates two walls at an odd angle is
//! a wall, not a plane along an axis.
#![doc = include_str!("figures/bsp.html")]
//!
//! On the left, planes along the axes were the best for most cuts of things so round and so far apart. Where a plane is
//! slanted, the picture has the boxes around the parts, which overlap as the parts do not.
//!
//! **Build**: some primitives are asked for planes. Triangles suggest the one that they lie in, spheres such as face
//! another sphere, through their centre and on either side of their own box; everything suggests the faces of its own
//! box. The surface area heuristic compares them. The parts are no boxes, and their areas would be costly to know, so
//! a sample of points tells how large they are, and a sample of the other primitives where these lie.
//!
//! **Walk**: as in a kd-tree, with a dot product for each plane.
//!
//! **Why it equals brute force**: the height of a point over a slanted plane has a rounding error, for which there is
//! a bound. Where the ray is nearer to the plane than that, both sides are visited; a primitive is listed on both
//! sides if its own box comes as near. Primitives are never cut in pieces, as this would move their edges.
//!
//! # Cost
//!
//! | | mound | balls | rock | stadium |
//! |---|---|---|---|---|
//! | nodes + tests of a primary ray | 14 + 4 | 18 + 3 | 17 + 4 | 53 + 12 |
//! | nodes + tests of a diffuse ray | 28 + 13 | 37 + 10 | 40 + 16 | 44 + 12 |
//!
//! About 110 to 210 bytes per primitive, and 2 to 5 times the build of a kd-tree. On our scenes that freedom does not
//! pay: own boxes are along the axes, so that slanted planes separate them less well than they would the primitives.
//!
//! **Choose it** where long walls stand at odd angles with emptiness between them, or to see which planes fit a scene.
//! Otherwise a [`KdTree`](crate::KdTree) is smaller, built sooner, and walked faster.
//!
//! **Papers**: Fuchs, Kedem and Naylor, "On visible surface generation by a priori tree structures", 1980; Ize, Wald
//! and Parker, "Ray Tracing with the BSP Tree", 2008.
