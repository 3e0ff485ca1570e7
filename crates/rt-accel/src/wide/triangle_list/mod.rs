//! The triangles of a small tree as a list, for streams of rays of any directions.

mod entry;
mod list;

pub(super) use entry::{FilterPair, FilterTriangle, ListOther, ListTriangle, NORMAL_ERROR};
pub(super) use list::{MAX_TRIANGLES, TriangleList};
