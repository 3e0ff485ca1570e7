//! Queries: the closest hit of a ray, or any hit.
//!
//! The type of the [`Output`] selects between them at compile time: `Option<Hit>` or `bool`.

mod output;
mod packet_results;
mod prim_slot;
mod ray_state;
mod stats;
mod tester;
mod trav_ray;

pub(super) use output::{NO_HIT, Output};
pub(super) use packet_results::PacketResults;
pub(super) use prim_slot::PrimSlot;
pub(super) use ray_state::RayState;
pub(super) use stats::TraversalStats;
pub(super) use tester::{PrimitiveTester, Tester};
pub(super) use trav_ray::TravRay;
