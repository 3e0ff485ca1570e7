//! Tests of whole renders.

mod left_out;
mod one_picture;
mod radiance;
mod refusals;
mod support;
