//! Errors of textures.

/// Error of [`decode_texture`](crate::decode_texture): an image that cannot be a texture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The bytes are no PNG, JPEG, HDR or EXR image.
    #[error("is not a PNG, JPEG, HDR or EXR image; convert it to one of these formats")]
    UnknownFormat,
    /// The image is damaged, or uses a part of its format that is not supported.
    #[error("cannot be decoded: {0}")]
    Damaged(String),
    /// More than 2²⁸ pixels or more than 1 GiB as linear `f32`.
    #[error("has {0} x {1} pixels; at most 2^28 pixels and 1 GiB are supported; scale it down")]
    TooLarge(u32, u32),
    /// No pixels.
    #[error("has {0} x {1} pixels; it must have at least one")]
    NoPixels(u32, u32),
    /// A pixel that is NaN or infinite.
    #[error("has {0} pixels that are NaN or infinite")]
    NonFinite(usize),
}
