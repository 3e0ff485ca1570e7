//! Images around a scene, as lights.

use std::path::Path;

use rt_math::{DQuat, Rgb, transcendental::sincos};
use rt_shading::{Bitmap, light::EnvironmentLight};

use crate::{LoadErrorKind, LoadOptions, read_texture};

/// Reads an equirectangular image (PNG, JPEG, HDR or EXR) as environment light.
///
/// Its radiance is multiplied by `scale`. It is rotated by `rotation` radians around +y: to the left, seen from inside.
///
/// # Errors
/// An unreadable file, a file that is no image, invalid radiance, or a budget that is too small.
pub fn read_environment(
    path: &Path,
    scale: Rgb,
    rotation: f64,
    options: &LoadOptions,
) -> Result<EnvironmentLight, LoadErrorKind> {
    let Bitmap { width, height, pixels, .. } = read_texture(path, options)?;
    let what = format_args!("the environment image {}", path.display());
    options.memory.keep(what, EnvironmentLight::memory_of(width as usize, height as usize) as u64)?;
    let radiance = pixels.iter().map(|pixel| Rgb::from(pixel.map(f64::from)) * scale).collect();
    let (sin, cos) = sincos(0.5 * rotation);
    EnvironmentLight::new(width as usize, height as usize, radiance, DQuat::from_xyzw(0.0, sin, 0.0, cos))
        .map_err(|error| LoadErrorKind::invalid("cannot be used:", error.to_string()))
}
