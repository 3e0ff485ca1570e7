//! # rt-shading: light and material
//!
//! ```text
//!              light                          radiance towards the viewer (Whitted 1980):
//!               \    normal
//!             wi \    |    / wo               emission + ambient · Ia
//!                 \ θ |   /                 + Σ lights  visible · I · (diffuse · cos θ + specular · cosⁿ α)
//!   mirrored ______\  |  /______            + mirror · L(mirrored ray)
//!                     |   \                 + transmission · L(refracted ray)
//!                     |    \ refracted
//! ```
//!
//! **Owns** materials ([`Material`], [`MaterialModel`]) and their [`bsdf`]s, lights ([`light`]), textures, and reflection and
//! refraction ([`optics`]). It has nested dielectrics ([`InteriorList`]) and the integrators ([`Whitted`], [`PathTracer`],
//! [`LightTracingIntegrator`], [`AovIntegrator`]).
//! **Does not own** shapes (rt-geometry), or the intersection of rays with them: an integrator queries a [`StreamQueries`], or a
//! [`SceneQueries`] ray by ray.
//!
//! **Read first** `reference_path_tracer.rs`: [`ReferencePathTracer`] is a path integrator for one path at a time, as in textbooks.
//!
//! ```
//! use rt_geometry::{Shape, Sphere, SurfaceInteraction, InteractionFlags, RayKind};
//! use rt_math::{DVec3, Interval, Ray, Rgb};
//! use rt_shading::{Appearance, Background, DeltaLight, DeltaLightKind, Falloff, Material, ShadingFeatures, Phong, SurfaceHit, SceneQueries, Whitted};
//!
//! // A world of one sphere, lit from the camera.
//! struct OneSphere(Shape);
//! impl SceneQueries for OneSphere {
//!     fn closest(&mut self, ray: &Ray, span: Interval, _: RayKind, needs: InteractionFlags) -> Option<SurfaceHit> {
//!         let hit = self.0.intersect(ray, span)?;
//!         Some(SurfaceHit::new(hit.t, self.0.surface(ray, &hit, needs), 0, 0))
//!     }
//!     fn occluded(&mut self, ray: &Ray, span: Interval) -> bool {
//!         self.0.intersect(ray, span).is_some()
//!     }
//! }
//!
//! let light = DeltaLightKind::Point { position: DVec3::ZERO, falloff: Falloff::None, shadow_near: 0.0 };
//! let appearance = Appearance {
//!     materials: vec![Material::new("grey".into(), Phong::default())],
//!     textures: vec![],
//!     lights: vec![DeltaLight::new(light, Rgb::WHITE)],
//!     ambient: Rgb::BLACK,
//!     background: Background::Constant(Rgb::BLACK),
//! };
//! let mut world = OneSphere(Shape::Sphere(Sphere::new(DVec3::new(0.0, 0.0, -5.0), 1.0)?));
//! let mut whitted = Whitted::new(5, 0.0, ShadingFeatures::of(&appearance, |_| true));
//! let seen = whitted.radiance(&mut world, &appearance, &Ray::new(DVec3::ZERO, DVec3::NEG_Z));
//! assert!((seen.radiance.r - 0.7).abs() < 1e-12);
//! # Ok::<(), rt_geometry::ShapeError>(())
//! ```

#![forbid(unsafe_code)]
#![cfg_attr(
    not(target_arch = "x86_64"),
    allow(dead_code, unused_imports, unused_variables, unreachable_code, reason = "lanes need AVX2")
)]

mod alpha;
mod ambient_occlusion;
mod aov_integrator;
mod appearance;
pub mod bsdf;
mod bsdf_cache;
mod color_texture;
mod eval_context;
mod float_texture;
mod hit_context;
mod interior_list;
mod lane_set;
mod lanes;
mod layered_surface;
pub mod light;
mod light_tracing;
mod lobe_list;
mod material;
mod material_model;
mod medium;
mod medium_tracker;
mod mis;
mod normal_map;
pub mod optics;
mod path;
mod phong;
mod phong_to_bsdf;
mod ray_kind;
mod reference_path_tracer;
mod russian_roulette;
mod scene_queries;
mod shading_features;
mod shadow_media;
mod stream_queries;
mod surface_features;
#[cfg(test)]
mod test_worlds;
mod texture;
mod to_phong;
mod vertex;
mod viewed_surface;
mod wavefront;
mod whitted;

pub use alpha::{Alpha, AlphaMode};
pub use ambient_occlusion::{AmbientOcclusion, OcclusionWave};
pub use aov_integrator::AovIntegrator;
pub use appearance::{Appearance, Background};
pub use bsdf_cache::BsdfCache;
pub use color_texture::ColorTexture;
pub use eval_context::MaterialEvalContext;
pub use float_texture::{Channel, FloatTexture};
pub use hit_context::MAX_NULL_INTERFACES;
pub use interior_list::{InteriorList, MAX_DIELECTRICS};
pub use lanes::LaneLevel;
pub use layered_surface::{LayeredBase, LayeredSurface};
pub use light::{DeltaLiSample, DeltaLight, DeltaLightKind, Falloff, Light, LightUnits};
pub use light_tracing::{LightSources, LightTracingIntegrator, LightTracingScene, ProjectionMap, TargetSphere};
pub use material::Material;
pub use material_model::MaterialModel;
pub use medium::InteriorMedium;
pub use normal_map::NormalMap;
pub use path::{Clamp, Lighting, PathSettings, PathTracer, Transport};
pub use phong::{Highlight, Phong, Transmission};
pub use reference_path_tracer::ReferencePathTracer;
pub use scene_queries::{RadianceSample, SceneQueries, SurfaceHit};
pub use shading_features::ShadingFeatures;
pub use stream_queries::{SingleQueries, StreamPrimitive, StreamQueries, StreamShape, StreamTriangle};
pub use texture::{Bitmap, Texture, TextureId, TexturePoint, UvMap, Wrap};
pub use wavefront::{
    streams::batch_size,
    surface_points::{SurfacePoint, surface_points},
};
pub use whitted::{ShadingCounts, Whitted};
