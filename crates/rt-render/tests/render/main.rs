//! Tests of whole renders.

mod left_out;
mod one_picture;
mod refusals;
mod support;
