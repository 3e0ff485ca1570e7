//! Substitute for `display.rs` without the feature `display`.

use rt_image::Image;
use rt_render::{Crop, RenderSnapshot};

use crate::console::Console;
use crate::error::{CliError, usage};

#[derive(Debug)]
pub(crate) enum NoDisplay {}

pub(crate) use NoDisplay as Display;

impl NoDisplay {
    /// # Errors
    /// Always.
    pub(crate) fn connect(address: &str, _: &str, _: Crop, _: bool, _: Console) -> Result<Self, CliError> {
        usage(format!("--display-server {address}: this program is built without the feature `display`"))
    }

    pub(crate) const fn tile_done(&mut self, _: &RenderSnapshot<'_>) {
        match *self {}
    }

    pub(crate) const fn finish(self, _: &Image) {
        match self {}
    }
}
