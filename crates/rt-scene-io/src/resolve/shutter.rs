//! Time interval of the shutter.
//!
//! ```text
//!   frame                 next frame
//!     0 ───o═══════c────────── 1          parts of a frame, as `shutter` and `motion` have them
//!          │       │
//!   t + o·h    t + c·h                    seconds, as `animation` has them; h is the time of a frame
//! ```

use std::fmt::Display;

use rt_math::{AnimatedTransform, Transform};

use super::camera_pose::listed;
use super::transform::refused_motion;
use super::value::vector;
use crate::diagnostics::Diagnostics;
use crate::format::{Camera, Interpolation, Node, SceneFile};
use crate::{LoadErrorKind, LoadOptions};

/// Time interval of one image, as a part of an animation.
///
/// Transforms of moving objects are evaluated at both ends. Where the shutters of cameras differ, it encloses all of them, and
/// each camera uses its part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShutterInterval {
    /// Start and end, in seconds.
    times: [f64; 2],
    /// Interval in parts of a frame; `None` if the scene is not animated or no camera has a shutter. Motions then take all of
    /// their time, and animations are frozen.
    part: Option<[f64; 2]>,
}

impl ShutterInterval {
    /// Interval that encloses the shutters of all cameras.
    pub(super) fn new(file: &SceneFile, cameras: &[(String, Camera)], options: &LoadOptions) -> Self {
        let is_timed = options.at_time.is_some() || is_animated(file);
        let is_sound = |[opens, closes]: &[f64; 2]| 0.0 <= *opens && opens <= closes && *closes <= 1.0;
        let shutters = cameras.iter().filter_map(|(_, camera)| camera.shutter.map(|(opens, closes)| [opens, closes]));
        let all = shutters.filter(is_sound).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        let part = all.filter(|_| is_timed);
        let of_part = LoadOptions { at_time: options.at_time.or(Some(0.0)), shutter: part, ..options.clone() };
        Self { times: of_part.shutter_interval().unwrap_or_default(), part }
    }

    /// Time at which the shutter opens, in seconds.
    pub(super) const fn opens(&self) -> f64 {
        self.times[0]
    }

    /// Interval in parts of a frame; `None` if motions take all of it.
    pub(super) const fn part(&self) -> Option<[f64; 2]> {
        self.part
    }

    /// Options that pose models at the same times.
    pub(super) fn for_models(&self, options: &LoadOptions) -> LoadOptions {
        LoadOptions { shutter: self.part, ..options.clone() }
    }

    /// Shutter of a camera relative to this interval. A camera without a shutter is sharp at its start.
    pub(super) fn relative(&self, given: Option<(f64, f64)>) -> [f64; 2] {
        match (self.part, given) {
            (None, None) => [0.0, 1.0],
            (None, Some((opens, closes))) => [opens, closes],
            (Some([first, last]), Some(given)) if first < last => {
                [given.0, given.1].map(|time| (time - first) / (last - first))
            }
            (Some(_), _) => [0.0; 2],
        }
    }

    /// Interval in which keys are evaluated. Steps hold the value of the opening: a step to the next key is no motion.
    pub(super) const fn of_keys(self, interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::Step => Self { times: [self.times[0]; 2], ..self },
            Interpolation::Linear | Interpolation::Smooth => self,
        }
    }

    /// Part of a motion in the interval: its start and, if it moves, its end.
    pub(super) fn cut(&self, start: Transform, end: Option<Transform>) -> (Transform, Option<Transform>) {
        let (Some([first, last]), Some(end)) = (self.part, end) else { return (start, end) };
        match AnimatedTransform::new(&start, &end) {
            Ok(motion) => (motion.at(first), (first < last).then(|| motion.at(last))),
            Err(_) => (start, Some(end)),
        }
    }

    /// Transforms when the shutter opens and, if different, closes. `at` evaluates a time in seconds.
    pub(super) fn places(
        &self,
        report: &mut Diagnostics,
        path: impl Display,
        at: impl Fn(f64) -> Result<Transform, LoadErrorKind>,
    ) -> Option<(Transform, Option<Transform>)> {
        let sound = |time: f64| {
            let place = at(time)?;
            // Interpolated transforms may be invalid where keys are not.
            Transform::from_linear(place.linear(), place.translation())?;
            vector(place.translation().to_array()).map(|_| place)
        };
        let [opens, closes] = self.times;
        let start = report.check(&path, sound(opens))?;
        let end = if closes > opens { report.check(&path, sound(closes))? } else { start };
        if end == start {
            return Some((start, None));
        }
        report.check(path, AnimatedTransform::new(&start, &end).map_err(refused_motion)).map(|_| (start, Some(end)))
    }
}

/// True if a node or camera has an animation.
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
