//! Colour that varies over a surface.

use rt_math::Rgb;

/// Index of a texture in [`Appearance::textures`](crate::Appearance::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// What happens beyond the edge of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// It repeats.
    Repeat,
    /// It repeats, mirrored every other time.
    Mirror,
    /// The edge goes on.
    Clamp,
}

/// Linear pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// Linear colour of each pixel; `width · height` of them.
    pub pixels: Vec<[f32; 3]>,
}

/// A colour as a function of texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// A checkerboard with squares of side `size` in texture space; the square at the origin is `even`.
    Checker {
        /// Colour of the squares whose coordinates add up to an even number.
        even: Rgb,
        /// Colour of the others.
        odd: Rgb,
        /// Side of a square.
        size: f64,
    },
    /// An image; (0, 0) is its lower left corner, (1, 1) its upper right.
    Image {
        /// The pixels.
        bitmap: Bitmap,
        /// Beyond the edge, along u and v.
        wrap: [Wrap; 2],
        /// Interpolate between pixels rather than take the nearest.
        smooth: bool,
    },
}
