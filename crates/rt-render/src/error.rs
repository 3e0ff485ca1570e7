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
    #[error("the scene has {count} cameras, so there is no camera number {index}")]
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
    #[error("crop {x},{y} {width}x{height} does not lie within the {film_width}x{film_height} image")]
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
    #[error("object '{0}' lies in a group that contains itself, or groups and nodes are nested more than 1024 deep")]
    Nesting(String),
    /// An index in the scene points nowhere.
    #[error("object '{object}' refers to {what} number {index}, but there are {count}")]
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
    #[error("a group that is placed more than once has more than 2^32 - 1 shapes and triangles")]
    TooManyObjects,
    /// A level has more objects than its limit.
    #[error(
        "{count} objects stand on one level, at most {limit} may; place groups that hold many objects more than once, and \
         not within other groups"
    )]
    TooManyParts {
        /// Number of objects, or 2⁶⁴ − 1 for more.
        count: u64,
        /// Limit.
        limit: u64,
    },
    /// Samples per pixel must be at least 1.
    #[error("at least 1 sample per pixel is needed")]
    NoSamples,
    /// Passes must be at least 1.
    #[error("at least 1 pass over the image is needed")]
    NoPasses,
    /// The bound of indirect light is not a positive number.
    #[error("the bound of indirect light (clamp) is {0}; it must be a finite number above 0")]
    Clamp(f64),
    /// The target error is not a positive number.
    #[error("the error to reach is {0}; it must be a finite number above 0")]
    TargetError(f64),
    /// The fraction of pixels to converge is not in (0, 1].
    #[error("a share of pixels of {0} is not above 0 and at most 1")]
    TargetShare(f64),
    /// A target error, but all passes are equal.
    #[error(
        "the error of a picture cannot be told where all passes are the same, as with the samples of this pattern: {0}"
    )]
    SamePasses(&'static str),
    /// Adaptive sampling in object space with an integrator other than `whitted`.
    #[error(
        "adaptive sampling in object space knows the edges that 'whitted' shows; for '{0}', let the error decide \
         (--target-error)"
    )]
    Adaptive(&'static str),
    /// Adaptive sampling in object space with a lens.
    #[error(
        "adaptive sampling in object space looks for edges, of which a lens leaves none sharp; let the error decide \
         (--target-error)"
    )]
    AdaptiveLens,
    /// Adaptive sampling in object space with motion.
    #[error(
        "adaptive sampling in object space looks for edges at one moment, and the camera or an object moves; let the error \
         decide (--target-error)"
    )]
    AdaptiveMotion,
    /// An animated emissive object with an integrator that finds sampled lights only.
    #[error(
        "object '{0}' shines and moves: lamps that move are found by rays in all directions, which 'distributed' does not \
         follow; use 'path', 'direct' or 'caustics', or let it stand still"
    )]
    MovingLight(String),
    /// Adaptive sampling in object space in a progressive render.
    #[error(
        "adaptive sampling in object space shares out a fixed number of samples; it goes with no time and no error to reach"
    )]
    AdaptiveUntil,
    /// A share of the tiles with a stop rule.
    #[error(
        "a share of the tiles takes a fixed number of samples: when to stop would depend on the clock of the machine, or on pixels \
         that other machines have"
    )]
    SharedUntil,
    /// The checkpoint belongs to a render of another size, share, rule or options.
    #[error("the checkpoint is of another picture, or of one that was made with other options")]
    Checkpoint,
    /// More memory would be needed than the budget allows.
    #[error(transparent)]
    Memory(#[from] rt_scene_io::MemoryError),
    /// The threads could not be started.
    #[error("worker threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
