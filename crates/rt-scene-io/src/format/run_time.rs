//! Conversions between enums of scene files and the run-time enums with the same variants.

/// Implements `From` in both directions, variant by variant.
macro_rules! same_variants {
    ($($file:ty, $run_time:ty: $($variant:ident)+;)+) => {$(
        impl From<$file> for $run_time {
            fn from(value: $file) -> Self {
                match value { $(<$file>::$variant => Self::$variant,)+ }
            }
        }

        impl From<$run_time> for $file {
            fn from(value: $run_time) -> Self {
                match value { $(<$run_time>::$variant => Self::$variant,)+ }
            }
        }
    )+};
}

same_variants! {
    super::Falloff, rt_shading::Falloff: None InverseSquare;
    super::FovAxis, rt_camera::FovAxis: Vertical Horizontal;
    super::Highlight, rt_shading::Highlight: Phong Blinn;
    super::InsideRule, rt_geometry::InsideRule: Convex Winding EvenOdd;
    super::Interpolation, rt_math::Interpolation: Step Linear Smooth;
    super::LightSampling, rt_shading::light::LightSampling: Uniform Power Tree;
    super::LightUnits, rt_shading::LightUnits: Classical Physical;
    super::Sampler, rt_camera::SamplerKind:
        Centre Grid Random Jittered HalfJittered MultiJittered Sobol Halton BlueNoise;
    super::EmissionSides, rt_shading::light::EmissionSides: Front Both;
    super::Tone, rt_image::ToneCurve: Clamp Reinhard Aces;
    super::Wrap, rt_shading::Wrap: Repeat Mirror Clamp;
}
