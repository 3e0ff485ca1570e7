//! Description of a golden case: `case.toml`.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::{error::TaskError, files};

/// A golden case as written. Everything has a default.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct GoldenCase {
    /// The scene, relative to the case's folder or else to the workspace; by default `scene.ron`.
    pub scene: Option<PathBuf>,
    /// Arguments for `render` after the scene.
    pub args: Vec<String>,
    /// Allowed difference of a channel, of 255.
    pub tolerance: u8,
    /// Number of pixels that may differ by more.
    pub max_outliers: u64,
    /// Reason of a known failure. It is an error if the case passes.
    pub known_failure: Option<String>,
    /// Mean radiance in closed form.
    pub truth: Option<KnownMean>,
    /// Another program's image of the same scene.
    pub reference: Option<GoldenReference>,
}

/// Closed form of the mean radiance over all pixels.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KnownMean {
    /// Linear red, green, blue.
    pub mean: [f64; 3],
    /// Maximum absolute deviation of a component.
    pub tolerance: f64,
    /// Source of the value.
    pub note: String,
}

/// An independent image of the scene, with tolerances.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GoldenReference {
    /// The file, relative to the case's folder or else to the workspace.
    pub image: PathBuf,
    /// Maximum RMSE, of 1.
    pub max_rmse: f64,
    /// A pixel is an outlier if a channel differs by more than this, of 255.
    pub tolerance: u8,
    /// Maximum share of outliers, of 1.
    pub max_outlier_share: f64,
}

impl GoldenCase {
    /// Reads `case.toml` in `folder`.
    pub(crate) fn load(folder: &Path) -> Result<Self, TaskError> {
        let path = folder.join("case.toml");
        toml::from_str(&files::read(&path)?).map_err(TaskError::file(&path))
    }

    pub(crate) fn scene_path(&self, folder: &Path, root: &Path) -> PathBuf {
        locate(self.scene.as_deref().unwrap_or(Path::new("scene.ron")), folder, root)
    }
}

/// `path` in `folder` if it is there, else in `root`.
pub(crate) fn locate(path: &Path, folder: &Path, root: &Path) -> PathBuf {
    let in_folder = folder.join(path);
    if in_folder.exists() { in_folder } else { root.join(path) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_file_requires_equality() {
        let case: GoldenCase = toml::from_str("").unwrap();
        assert_eq!((case.tolerance, case.max_outliers, case.known_failure), (0, 0, None));
    }

    #[test]
    fn a_misspelt_key_is_an_error() {
        assert!(toml::from_str::<GoldenCase>("tolerence = 3").is_err());
    }

    #[test]
    fn all_keys_are_read() {
        let case: GoldenCase = toml::from_str(
            r#"
            scene = "a.ron"
            args = ["--spp", "4"]
            tolerance = 1
            max_outliers = 2
            known_failure = "why"
            truth = { mean = [1.0, 2.0, 3.0], tolerance = 1e-3, note = "paper" }
            reference = { image = "b.png", max_rmse = 0.01, tolerance = 8, max_outlier_share = 0.005 }
            "#,
        )
        .unwrap();
        assert_eq!(case.args, ["--spp", "4"]);
        assert_eq!(case.truth.unwrap().mean, [1.0, 2.0, 3.0]);
        assert_eq!(case.reference.unwrap().max_outlier_share, 0.005);
    }
}
