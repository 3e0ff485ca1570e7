//! Images around a scene, as lights.

use std::path::Path;

use rt_math::{DQuat, Rgb, transcendental::sincos};
use rt_shading::{Bitmap, emitter::EnvironmentLight};

use crate::{LoadErrorKind, LoadOptions, read_texture};

/// Reads an equirectangular image (PNG, JPEG, HDR or EXR) as the light all around a scene: its radiance is multiplied by
/// `scale`, and it is turned to the left, seen from inside, by `rotation` radians around +y.
///
/// # Errors
/// If the file cannot be read, is no image, holds what is no radiance, or the budget has no room for it.
pub fn read_environment(
    path: &Path,
    scale: Rgb,
    rotation: f64,
    options: &LoadOptions,
) -> Result<EnvironmentLight, LoadErrorKind> {
    let Bitmap { width, height, pixels, .. } = read_texture(path, options)?;
    let what = format_args!("the image {} around the scene", path.display());
    options.memory.keep(what, EnvironmentLight::memory_of(width as usize, height as usize) as u64)?;
    let radiance = pixels.iter().map(|pixel| Rgb::from(pixel.map(f64::from)) * scale).collect();
    let (sin, cos) = sincos(0.5 * rotation);
    EnvironmentLight::new(width as usize, height as usize, radiance, DQuat::from_xyzw(0.0, sin, 0.0, cos))
        .map_err(|error| LoadErrorKind::invalid("the image", error.to_string()))
}
