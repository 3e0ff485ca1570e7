//! Tests of whole renders.

mod caustics;
mod clamping;
mod crafted;
mod culling;
mod determinism;
mod invariance;
mod layers;
mod left_out;
mod lens;
mod motion;
mod nested;
mod object_space_aa;
mod passes;
mod picking;
mod radiance;
mod refusals;
mod replaced_camera;
mod shards;
mod support;
mod thin_dielectrics;
mod unsampled_emitters;
