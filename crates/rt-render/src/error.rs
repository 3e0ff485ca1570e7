//! Errors of compiling and rendering a scene.

/// Reason that a scene cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The camera is unusable.
    #[error("camera '{name}': {source}")]
    Camera {
        /// Name of the camera.
        name: String,
        /// Cause.
        source: rt_camera::CameraError,
    },
    /// The scene has no camera, or none of that index.
    #[error("camera index {index} is out of range: the scene has {count} cameras")]
    NoCamera {
        /// Requested index.
        index: usize,
        /// Number of cameras.
        count: usize,
    },
    /// The image is unusable.
    #[error("film: {0}")]
    Film(#[from] rt_camera::FilmError),
    /// The crop is empty or outside of the image.
    #[error("the crop of {width}x{height} pixels at {x},{y} exceeds the image of {film_width}x{film_height} pixels")]
    Crop {
        /// Left edge in pixels.
        x: u32,
        /// Upper edge in pixels.
        y: u32,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Width of the image.
        film_width: u32,
        /// Height of the image.
        film_height: u32,
    },
    /// An acceleration structure cannot be built.
    #[error("object '{object}': {source}")]
    Build {
        /// Name of the offending object.
        object: String,
        /// Cause.
        source: rt_accel::BuildError,
    },
    /// A group contains itself, or the tree is nested too deeply; with the name of the deepest object.
    #[error("object '{0}': its group contains itself, or groups and nodes are nested more than 1024 deep")]
    Nesting(String),
    /// An index in the scene points nowhere.
    #[error("object '{object}': {what} index {index} is out of range: there are {count}")]
    Dangling {
        /// Name of the object.
        object: String,
        /// "material", "mesh" or "group".
        what: &'static str,
        /// The index.
        index: u32,
        /// Number of entries.
        count: usize,
    },
    /// A product of transforms is singular.
    #[error("object '{object}': {source}")]
    Transform {
        /// Name of the object.
        object: String,
        /// Cause.
        source: rt_math::TransformError,
    },
    /// The animated transform of an object is invalid.
    #[error("object '{object}': {source}")]
    AnimatedTransform {
        /// Name of the object.
        object: String,
        /// Cause.
        source: rt_math::AnimatedTransformError,
    },
    /// A group has more primitives than indices.
    #[error("a group with several instances has more than 2^32 - 1 shapes and triangles; split it")]
    TooManyObjects,
    /// A level has more objects than its limit.
    #[error(
        "{count} objects on one level of the scene exceed the limit of {limit}; use instances of larger groups, and do not \
         nest them in other groups"
    )]
    TooManyParts {
        /// Number of objects, or 2⁶⁴ − 1 for more.
        count: u64,
        /// Limit.
        limit: u64,
    },
    /// Samples per pixel must be at least 1.
    #[error("the number of samples per pixel is 0; it must be at least 1")]
    NoSamples,
    /// Passes must be at least 1.
    #[error("the number of passes is 0; it must be at least 1")]
    NoPasses,
    /// The bound of indirect light is not a positive number.
    #[error("the clamp of indirect light is {0}; it must be a finite number above 0")]
    Clamp(f64),
    /// The target error is not a positive number.
    #[error("the target error is {0}; it must be a finite number above 0")]
    TargetError(f64),
    /// The fraction of pixels to converge is not in (0, 1].
    #[error("the share of pixels to converge is {0}; it must be above 0 and at most 1")]
    TargetShare(f64),
    /// A target error, but all passes are equal.
    #[error(
        "the error cannot be estimated: all passes of the sampler `{0}` are equal; choose a random sampler, such as `sobol`"
    )]
    SamePasses(&'static str),
    /// Adaptive sampling in object space with an integrator other than `whitted`.
    #[error(
        "adaptive sampling in object space (--adaptive) supports the integrator `whitted` only; for `{0}`, use a target \
         error (--target-error)"
    )]
    Adaptive(&'static str),
    /// Adaptive sampling in object space with a lens.
    #[error(
        "adaptive sampling in object space does not support depth of field; remove the lens, or use a target error \
         (--target-error)"
    )]
    AdaptiveLens,
    /// Adaptive sampling in object space with motion.
    #[error(
        "adaptive sampling in object space does not support motion blur; remove the motion, or use a target error \
         (--target-error)"
    )]
    AdaptiveMotion,
    /// Adaptive sampling in object space in a progressive render.
    #[error(
        "adaptive sampling in object space needs a fixed number of samples; remove the time limit and the target error"
    )]
    AdaptiveUntil,
    /// A shard with a stop rule.
    #[error("a shard needs a fixed number of samples; remove the time limit and the target error")]
    ShardWithStopRule,
    /// The checkpoint belongs to a render of another size, shard, rule or options.
    #[error("the checkpoint is of another image, or was made with other options; use those options, or start over")]
    Checkpoint,
    /// More memory would be needed than the budget allows.
    #[error(transparent)]
    Memory(#[from] rt_scene_io::MemoryError),
    /// A defect of this crate lost the layers of this number of tiles.
    #[error("the layers lack {0} tiles because of a defect of this program; please report it")]
    LostTiles(usize),
}
