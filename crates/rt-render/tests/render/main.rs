//! Tests of whole renders.

mod caustics;
mod culling;
mod invariance;
mod left_out;
mod lens;
mod motion;
mod nested;
mod one_picture;
mod passes;
mod pyramid;
mod radiance;
mod refusals;
mod support;
