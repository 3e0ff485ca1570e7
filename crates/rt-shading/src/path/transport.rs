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
}
