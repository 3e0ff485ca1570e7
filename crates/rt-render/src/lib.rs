//! # rt-render: render plan and render loop
//!
//! ```text
//!   Scene ──compile──> RenderPlan ──render──> Image
//!                          │
//!                          └─ explain: used and omitted features, with reasons
//! ```
//!
//! **Owns** the plan ([`RenderPlan`]), the two-level world, the loop over tiles and samples, the film and the statistics. Below
//! it, no crate depends on both accelerators *and* materials. **Does not own** files, arguments or progress bars; it prints
//! nothing.
//!
//! Motion blur: each sample has a random time, which all of its rays share. Scenes without motion use no time
//! samples.
//!
//! The image is a pure function of scene, settings and seed: bit-identical for all thread counts, tile orders and accelerators.
//!
//! ```
//! use rt_render::{PlanOptions, RenderPlan, RunOptions};
//! # use rt_camera::{CameraSettings, FilmSettings, FovAxis, Projection};
//! # use rt_geometry::{Shape, Sphere};
//! # use rt_math::{DVec3, Rgb, Transform};
//! # use rt_scene_io::{Content, MaterialId, NamedCamera, SceneNode, Scene, RenderSettings};
//! # use rt_shading::{Appearance, Background, Falloff, DeltaLight, DeltaLightKind, Material, Phong};
//! # let camera = CameraSettings::new(
//! #     Transform::translate(DVec3::Z * 4.0),
//! #     Projection::Perspective { fov: 0.7, axis: FovAxis::Vertical },
//! # );
//! # let lamp = DeltaLightKind::Point { position: DVec3::ONE * 5.0, falloff: Falloff::None, shadow_near: 0.0 };
//! # let scene = Scene {
//! #     cameras: vec![NamedCamera { name: "main".into(), settings: camera, medium: None }],
//! #     film: FilmSettings { width: 32, height: 24, ..FilmSettings::default() },
//! #     appearance: Appearance {
//! #         materials: vec![Material::new("grey".into(), Phong::default())],
//! #         lights: vec![DeltaLight::new(lamp, Rgb::WHITE)],
//! #         ..Appearance::default()
//! #     },
//! #     nodes: vec![SceneNode::new(Content::Shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)?)), MaterialId(0))],
//! #     ..Scene::empty("one sphere")
//! # };
//! let plan = RenderPlan::compile(&scene, &PlanOptions::default())?;
//! println!("{}", plan.explain());
//! let rendering = plan.render(&RunOptions::default(), |_| {})?;
//! assert_eq!(rendering.film.pixels().len(), 32 * 24);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod accel_choice;
mod alpha_mesh;
mod area_lights;
mod camera_medium;
mod checkpoint;
mod clamping;
mod compiled_scene;
mod content_checks;
mod cost_view;
mod crop;
mod error;
mod error_estimate;
mod explain;
mod film;
mod first_hit_layers;
mod flatten;
mod forecast;
mod frame;
mod frustum_cull;
mod inlined_triangle;
mod instance;
mod instance_streams;
mod integrator;
mod layer_pass;
mod light_pass;
mod light_set;
mod light_sources;
mod memory;
mod mesh_blas;
mod object_space_aa;
mod observer;
mod parallel_for;
mod pass_state;
mod passes;
mod pick;
mod plan;
mod plan_options;
mod primary_rays;
mod primitive_form;
mod progressive;
mod render;
mod render_space;
mod render_tile;
mod rendering;
mod scene_geometry;
mod shard;
mod shard_spec;
mod splats;
mod statistics;
mod stop;
mod target_error;
mod tile;
mod tile_job;
mod tile_layers;
mod tile_scheduler;
mod tracer;
mod work_probe;
mod world;

pub use checkpoint::{Checkpoint, UncheckedCheckpoint};
pub use clamping::Clamping;
pub use compiled_scene::has_light;
pub use content_checks::ContentError;
pub use crop::Crop;
pub use error::RenderError;
pub use error_estimate::ErrorEstimate;
pub use explain::{Explanation, LeftOut};
pub use first_hit_layers::{FAR_DEPTH, FilmLayers, FirstHitLayer, LayerValues, MAX_LAYER_SAMPLES};
pub use memory::MemoryPrediction;
pub use observer::{CheckpointRef, Observer, RenderSnapshot};
pub use passes::default_passes;
pub use pick::PickResult;
pub use plan::RenderPlan;
pub use plan_options::{PlanOptions, Precision};
pub use render_space::RenderSpace;
pub use rendering::{ErrorProgress, PassProgress, Progress, Rendering, RunOptions, SampleRange};
pub use rt_accel::wide::{Quality, SimdLevel};
pub use rt_geometry::{Counters, RayKind, RayStats};
pub use rt_shading::{MAX_DIELECTRICS, MAX_NULL_INTERFACES, ShadingCounts};
pub use scene_geometry::SceneGeometry;
pub use shard::{MergeError, Shard, UncheckedShard};
pub use shard_spec::ShardSpec;
pub use statistics::Statistics;
pub use stop::{Criterion, StopRule, Stopped, TargetError};
