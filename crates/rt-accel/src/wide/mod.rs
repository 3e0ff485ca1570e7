//! Bounding volume hierarchy with eight children per node, tested eight boxes at a time.
//!
//! From the lowest layer to the highest:
//!
//! * `simd`: eight numbers at a time on any processor; `f64x8`: one number of eight rays
//! * `node`, `leaf`, `triangle_list`, `wide_bvh`: the tree; `stack`, `huge_pages`: memory
//! * `ray`, `ray_f64`, `ray_soa`, `ray_packet`, `packet_slabs`, `t_range`: rays prepared for filters, with the proofs
//! * `stream_rays`, `coherence`, `frustum`: streams and bundles of rays
//! * `exact_triangle`, `packet_triangles`, `packet_spheres`: exact tests in SIMD lanes
//! * `scalar`: traversal in `f64`, outside the range of the filters
//! * `filter`: conservative tests of leaves; `entry_points`: culling of ray bundles
//! * `query`: closest-hit and any-hit queries, and exact tests of the caller's primitives
//! * `single_ray`, `packet`, `stream_traversal`: traversal; `list_filter`, `list_traversal`: rays of any directions in small trees;
//!   `tree_query`: its entry points; `all_candidates`: traversal for all hits
//! * `small_set`, `sphere_list`: primitives without a tree
//! * `build`: binned SAH, reinsertion, and collapse of a binary tree into wide nodes; `sah`
//! * `accelerator`, `refit`, `validate`: the interface
//!
//! This is the only module with `unsafe`. It serves instructions chosen at run time, unchecked loads of validated data,
//! and memory that is written before it is read. Builders and loaders validate these data.
#![allow(unsafe_code, reason = "instructions chosen at run time, and unchecked loads of validated data")]

mod accelerator;
mod all_candidates;
mod build;
mod coherence;
mod entry_points;
mod exact_packet;
mod exact_triangle;
mod f64x8;
#[cfg(test)]
mod facets;
mod filter;
mod frustum;
mod huge_pages;
mod leaf;
mod list_filter;
mod list_traversal;
mod node;
mod packet;
mod packet_planes;
mod packet_quadrilaterals;
mod packet_slabs;
mod packet_spheres;
mod packet_triangles;
mod predicted_child;
mod query;
mod ray;
mod ray_f64;
mod ray_packet;
mod ray_soa;
mod refit;
mod sah;
mod scalar;
mod simd;
mod single_ray;
mod small_set;
mod sphere_list;
mod stack;
mod stream_rays;
mod stream_traversal;
mod t_range;
mod tree_query;
mod triangle_list;
mod validate;
mod wide_bvh;

pub use build::{BuildParams, Quality};
pub use simd::SimdLevel;
pub use small_set::SmallSet;
pub(crate) use sphere_list::SphereList;
pub use wide_bvh::WideBvh;
