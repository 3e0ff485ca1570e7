//! [`SceneFile`] to text.

use ron::ser::PrettyConfig;

use super::{SceneFile, ron_options::ron_options};

impl SceneFile {
    /// The scene in RON, laid out to be edited. What was left open stays so, except in `film` and `settings`.
    pub fn to_ron(&self) -> String {
        // Below this depth nodes and materials stay on their line.
        let layout = PrettyConfig::new().depth_limit(3).new_line("\n").compact_structs(false);
        let mut text = ron_options().to_string_pretty(self, layout).unwrap_or_default();
        text.push('\n');
        text
    }

    /// The scene in JSON.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }
}
