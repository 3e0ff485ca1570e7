//! Models by the extension of their file.

use std::path::Path;

use crate::{LoadError, LoadErrorKind, LoadOptions, Model};

/// Extensions of supported models, for messages.
pub(crate) const KNOWN_EXTENSIONS: &str = ".obj, .gltf, .glb, .nff, .pbrt, .ply, .stl";

/// Loads a model by its file extension.
///
/// `options.root` bounds the files that the model may refer to.
///
/// # Errors
/// An unreadable file, an invalid model, or a feature that is unsupported or not compiled in.
#[cfg_attr(
    not(any(feature = "obj", feature = "gltf", feature = "nff", feature = "pbrt", feature = "ply", feature = "stl")),
    expect(unused_variables, reason = "without a loader there are no references to follow")
)]
pub fn load_model(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let options = options.rooted_at(path);
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        #[cfg(feature = "obj")]
        "obj" => crate::obj::load(path, &options),
        #[cfg(feature = "gltf")]
        "gltf" | "glb" => crate::gltf::load(path, &options),
        #[cfg(feature = "nff")]
        "nff" => crate::nff::load(path, &options),
        #[cfg(feature = "pbrt")]
        "pbrt" => crate::pbrt::load(path, &options),
        #[cfg(feature = "ply")]
        "ply" => crate::ply::load(path, &options),
        #[cfg(feature = "stl")]
        "stl" => crate::stl::load(path, &options),
        _ => Err(LoadErrorKind::UnknownFormat { known: KNOWN_EXTENSIONS }.at(path, "")),
    }
}
