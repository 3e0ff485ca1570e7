//! Limits of loading, each with its reason.
//!
//! A limit is far from the size of real files. It bounds the time and memory that a damaged or hostile file can cost.
//! [`MemoryBudget`](crate::MemoryBudget) bounds the memory of all files together.

use std::fmt;

use bytesize::ByteSize;

/// Value of a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// A count.
    Count(u64),
    /// Bytes.
    Bytes(u64),
    /// A quantity, in units that its limit names.
    Quantity(f64),
}

/// A limit, for people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Name of the limited quantity.
    pub what: &'static str,
    /// Maximum.
    pub max: Amount,
    /// Files that the limit applies to.
    pub applies_to: &'static str,
    /// Reason: one or two sentences.
    pub why: &'static str,
    /// The option of the command line that changes it.
    pub flag: Option<&'static str>,
}

/// Makes a constant of each limit, and the list of all, so that neither can be without the other.
macro_rules! limits {
    ($(
        $(#[doc = $why:literal])+
        $name:ident: $type:ty = $max:expr, $kind:ident $what:literal of $applies_to:literal $(changed by $flag:literal)?;
    )*) => {
        $(
            $(#[doc = $why])+
            pub const $name: $type = $max;
        )*

        /// All limits, in the order in which loading checks them.
        pub const ALL: &[Limit] = &[$(Limit {
            what: $what,
            max: Amount::$kind($name as _),
            applies_to: $applies_to,
            why: concat!($($why),+),
            flag: limits!(@flag $($flag)?),
        }),*];
    };
    (@flag) => { None };
    (@flag $flag:literal) => { Some($flag) };
}

limits! {
    /// Offsets of 32 bits reach all of it, and it is read into memory as a whole.
    FILE_BYTES: u64 = 1 << 30, Bytes "size of a file" of "every file" changed by "--max-file-size";
    /// Parsers of nested text call themselves; the stack must hold them all. serde_json has the same limit.
    NESTING: usize = 128, Count "nesting of brackets" of ".ron, .json, .gltf, .glb";
    /// Squares and cubes of coordinates stay far from overflow.
    NUMBER: f64 = 1e60, Quantity "magnitude of a number" of "every scene and model";
    /// Vertices of meshes are stored in single precision, of which this is the largest number. Other numbers have double precision.
    MESH_COORDINATE: f64 = f32::MAX as f64, Quantity "magnitude of a coordinate of a vertex" of "every mesh";
    /// Bounds files that include each other.
    INCLUDE_DEPTH: usize = 16, Count "nesting of included files" of ".pbrt";
    /// Nested repeated includes would take exponential time.
    INCLUDES: usize = 1024, Count "included files" of ".pbrt";
    /// Each scope keeps a copy of the graphics state.
    SCOPES: usize = 1024, Count "nesting of attribute scopes" of ".pbrt";
    /// Real directives have a dozen, and each is compared with the others.
    PARAMETERS: usize = 256, Count "parameters of a directive" of ".pbrt";
    /// Each node inherits its transform from those above; no real tree comes near, and walks of it keep a stack.
    NODE_DEPTH: u64 = 1024, Count "depth of the tree, with expanded instances" of "every scene and model";
    /// Object ids have 32 bits, of which one is reserved.
    OBJECTS: u64 = (1 << 31) - 1, Count "objects, with expanded instances" of ".ron, .json";
    /// Instances of this format become nodes of their own.
    PBRT_NODES: usize = 1 << 18, Count "shapes, with expanded instances" of ".pbrt";
    /// Attributes of instances need no bytes in the file, and each instance becomes a node.
    GLTF_INSTANCES: u64 = 1 << 21, Count "instances of EXT_mesh_gpu_instancing" of ".gltf, .glb";
    /// An accessor without a buffer holds zeros, which take no bytes in the file.
    GLTF_ZEROS: usize = 1 << 22, Count "elements of an accessor without a buffer" of ".gltf, .glb";
    /// Several primitives may read the same zeros, and each takes time.
    GLTF_ALL_ZEROS: u64 = 1 << 24, Count "elements of all accessors without a buffer" of ".gltf, .glb";
    /// Compressed views expand, and several may share the same bytes.
    GLTF_DECODED_BYTES: u64 = 1 << 32, Bytes "size of all decoded views of a model" of ".gltf, .glb";
    /// The header of a stream claims it before there is anything to show for it.
    DRACO_BYTES: u64 = 1 << 31, Bytes "size of a decoded Draco stream" of ".gltf, .glb";
    /// The header of a stream claims it before there is anything to show for it.
    DRACO_FACES: u64 = 1 << 27, Count "faces of a Draco stream" of ".gltf, .glb";
    /// Many primitives may share accessors, and each becomes a mesh of its own.
    GLTF_MESH_BYTES: u64 = 1 << 32, Bytes "size of all meshes of a model" of ".gltf, .glb";
    /// Cutting a polygon into triangles takes time with the square of its corners.
    FACE_CORNERS: usize = rt_geometry::MeshData::MAX_CORNERS, Count "corners of a face" of "every mesh";
    /// All pairs of edges are tested for crossings; larger faces are not tested.
    CROSSING_CORNERS: usize = 512, Count "corners of a face tested for crossing edges" of ".obj";
    /// Smoothing across creases compares all pairs of faces around a vertex. Beyond, each face keeps its own normal there.
    CREASED_FACES: usize = 256, Count "faces at a vertex tested for creases" of ".obj";
    /// Textures are decoded to three numbers of 32 bits for each pixel.
    TEXTURE_PIXELS: u64 = 1 << 28, Count "pixels of a texture" of "every texture";
    /// A header of a few bytes can declare more than fits in memory.
    TEXTURE_BYTES: u64 = 1 << 30, Bytes "size of a decoded texture" of "every texture";
    /// Each image is within its limit, and there may be many.
    MODEL_TEXTURE_BYTES: u64 = 1 << 32, Bytes "size of all textures of a model" of ".gltf, .glb, .obj, .pbrt";
    /// A file that claims to expand further is damaged. The densest compression, that of PNG and ZIP, reaches 1032 : 1;
    /// 16-bit floats double when they are read. A few damaged bytes would cost gigabytes otherwise.
    TEXTURE_EXPANSION: u64 = 4096, Count "decoded bytes per byte of a texture file" of "every texture but .png";
    /// The densest that the data of a PNG can be (Deutsch, RFC 1951: 258 bytes in two bits).
    PNG_EXPANSION: u64 = 1032, Count "decompressed bytes per byte of a texture file" of ".png";
    /// A film of this size takes four gigabytes with coverage, and no screen or printer has more pixels.
    FILM_PIXELS: u64 = rt_image::Image::MAX_PIXELS, Count "pixels of the image" of "every scene and model";
    /// Numbers of samples have 32 bits.
    SAMPLES: u64 = 1 << 31, Count "samples per pixel" of ".ron, .json";
    /// Each pass has a fixed cost, and more passes do not improve the error estimate.
    PASSES: u64 = 1 << 16, Count "passes over the image" of ".ron, .json";
    /// The throughput after this number of bounces is below the precision of an image.
    RAY_DEPTH: u64 = 10_000, Count "bounces of a ray" of ".ron, .json";
    /// The filter reaches three times as far around each pixel.
    FILTER_SIGMA: f64 = 100.0, Quantity "width of a Gaussian filter in pixels" of ".ron, .json";
    /// The highlight is narrower than a pixel by far.
    HIGHLIGHT_EXPONENT: f64 = 1e7, Quantity "exponent of a Phong highlight" of "every scene and model";
    /// More errors than these are rarely independent.
    PROBLEMS: usize = 20, Count "errors that are listed" of "every scene and model";
    /// Reading a file that consists of errors would take long.
    PBRT_ERRORS: usize = 1000, Count "errors that end reading" of ".pbrt";
}

impl fmt::Display for Amount {
    /// `1024`, `2^31 - 1`, `1 GiB`, `1e60`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Quantity(value) if value.abs() >= 1e6 => write!(f, "{value:e}"),
            Self::Quantity(value) => write!(f, "{value}"),
            Self::Count(count) if count <= 100_000 => write!(f, "{count}"),
            Self::Count(count) if count.is_power_of_two() => write!(f, "2^{}", count.trailing_zeros()),
            Self::Count(count) if count < u64::MAX && (count + 1).is_power_of_two() => {
                write!(f, "2^{} - 1", (count + 1).trailing_zeros())
            }
            Self::Count(count) => write!(f, "{count}"),
            Self::Bytes(bytes) => ByteSize(bytes).fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn each_limit_says_what_and_why() {
        let names: HashSet<_> = ALL.iter().map(|limit| (limit.what, limit.applies_to)).collect();
        assert_eq!(names.len(), ALL.len());
        for Limit { what, why, max, .. } in ALL {
            assert!(why.trim().ends_with('.'), "{what}: {why}");
            assert!(!matches!(max, Amount::Count(0) | Amount::Bytes(0)), "{what}");
        }
    }

    #[test]
    fn amounts_are_formatted_for_people() {
        let shown = |amount: Amount| amount.to_string();
        assert_eq!(shown(Amount::Count(1024)), "1024");
        assert_eq!(shown(Amount::Count((1 << 31) - 1)), "2^31 - 1");
        assert_eq!(shown(Amount::Count(1 << 28)), "2^28");
        assert_eq!(shown(Amount::Bytes(1 << 30)), "1.0 GiB");
        assert_eq!(shown(Amount::Quantity(1e60)), "1e60");
    }
}
