//! When the shutter is open, and what moves meanwhile.
//!
//! ```text
//!   frame                 next frame
//!     0 ───o═══════c────────── 1          parts of a frame, as `shutter` and `motion` have them
//!          │       │
//!   t + o·h    t + c·h                    seconds, as `animation` has them; h is the time of a frame
//! ```

use std::fmt::Display;

use rt_math::{AnimatedTransform, Transform};

use super::camera::listed;
use super::transform::refused_motion;
use super::value::vector;
use crate::diagnostics::Diagnostics;
use crate::format::{Camera, Node, SceneFile};
use crate::{LoadErrorKind, LoadOptions};

/// What is seen of an animation in one picture.
///
/// Places of what moves are told for the opening and the closing of the shutter. Where cameras differ, that is the time in
/// which any of them is open, and each takes its part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShutterInterval {
    /// When the shutter opens and closes, in seconds.
    moments: [f64; 2],
    /// When it does, in parts of a frame; `None` if that has no meaning, as nothing is animated or no camera has a shutter.
    /// Motions take all of their time then, and animations stand still.
    part: Option<[f64; 2]>,
}

impl ShutterInterval {
    /// How long the cameras of a file take in the scene.
    pub(super) fn new(file: &SceneFile, cameras: &[(String, Camera)], options: &LoadOptions) -> Self {
        let is_timed = options.at_time.is_some() || is_animated(file);
        let is_sound = |[opens, closes]: &[f64; 2]| 0.0 <= *opens && opens <= closes && *closes <= 1.0;
        let shutters = cameras.iter().filter_map(|(_, camera)| camera.shutter.map(|(opens, closes)| [opens, closes]));
        let all = shutters.filter(is_sound).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        let part = all.filter(|_| is_timed);
        let of_part = LoadOptions { at_time: options.at_time.or(Some(0.0)), shutter: part, ..options.clone() };
        Self { moments: of_part.shutter_interval().unwrap_or_default(), part }
    }

    /// When the shutter opens, in seconds.
    pub(super) const fn opens(&self) -> f64 {
        self.moments[0]
    }

    /// Options that pose models alike.
    pub(super) fn for_models(&self, options: &LoadOptions) -> LoadOptions {
        LoadOptions { shutter: self.part, ..options.clone() }
    }

    /// The shutter of a camera as a part of this exposure. Without one of its own it takes what it sees first.
    pub(super) fn relative(&self, given: Option<(f64, f64)>) -> [f64; 2] {
        match (self.part, given) {
            (None, None) => [0.0, 1.0],
            (None, Some((opens, closes))) => [opens, closes],
            (Some([first, last]), Some(given)) if first < last => {
                [given.0, given.1].map(|moment| (moment - first) / (last - first))
            }
            (Some(_), _) => [0.0; 2],
        }
    }

    /// What remains of a motion: where it begins and, if it moves, ends.
    pub(super) fn cut(&self, start: Transform, end: Option<Transform>) -> (Transform, Option<Transform>) {
        let (Some([first, last]), Some(end)) = (self.part, end) else { return (start, end) };
        match AnimatedTransform::new(&start, &end) {
            Ok(motion) => (motion.at(first), (first < last).then(|| motion.at(last))),
            Err(_) => (start, Some(end)),
        }
    }

    /// Where something is when the shutter opens and, if that differs, closes, by its places at moments in seconds.
    pub(super) fn places(
        &self,
        report: &mut Diagnostics,
        path: impl Display,
        at: impl Fn(f64) -> Result<Transform, LoadErrorKind>,
    ) -> Option<(Transform, Option<Transform>)> {
        let sound = |moment: f64| {
            let place = at(moment)?;
            // Ways may lead through places that keys do not have.
            Transform::from_linear(place.linear(), place.translation())?;
            vector(place.translation().to_array()).map(|_| place)
        };
        let [opens, closes] = self.moments;
        let start = report.check(&path, sound(opens))?;
        let end = if closes > opens { report.check(&path, sound(closes))? } else { start };
        if end == start {
            return Some((start, None));
        }
        report.check(path, AnimatedTransform::new(&start, &end).map_err(refused_motion)).map(|_| (start, Some(end)))
    }
}

/// True if the file says of anything where it is at some moment.
pub(super) fn is_animated(file: &SceneFile) -> bool {
    key_times(file).next().is_some()
}

/// The times of all keys of a file, in seconds, in no order.
pub(super) fn key_times(file: &SceneFile) -> impl Iterator<Item = f64> {
    let mut open: Vec<&Node> = file.groups.values().flatten().chain(&file.nodes).collect();
    let nodes = core::iter::from_fn(move || {
        let node = open.pop()?;
        open.extend(&node.children);
        Some(node)
    });
    let of_nodes = nodes.filter_map(|node| node.animation.as_ref()).flat_map(|animation| &animation.keys);
    let of_cameras =
        listed(file).filter_map(|(_, camera)| camera.animation.as_ref()).flat_map(|animation| &animation.keys);
    of_nodes.map(|key| key.time).chain(of_cameras.map(|key| key.time))
}
