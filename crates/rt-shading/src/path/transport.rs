//! Light transport that path tracing computes.

/// Light transport beyond the first surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// Full light transport: the rendering equation (Kajiya 1986).
    Full,
    /// All light but that of [`LightTracingIntegrator`](crate::LightTracingIntegrator): caustics of sampled lights.
    NonCaustic,
    /// Specular and glossy transport; diffuse surfaces have direct and ambient light only ("Distributed Ray Tracing",
    /// Cook, Porter, Carpenter 1984).
    Specular,
    /// The same in scenes with emitters that are not sampled, such as a torus or a moving sphere. Diffuse surfaces find their
    /// direct light by BSDF samples.
    SpecularWithEmitters,
}
