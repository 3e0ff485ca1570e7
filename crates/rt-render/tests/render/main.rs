//! Tests of whole renders.

mod caustics;
mod clamping;
mod crafted;
mod culling;
mod invariance;
mod left_out;
mod lens;
mod motion;
mod nested;
mod one_picture;
mod outlook;
mod parts;
mod passes;
mod picking;
mod pyramid;
mod radiance;
mod refusals;
mod support;
