//! Transforms from keyframes at a time.

use std::borrow::Cow;

use rt_math::{DVec3, KeyframedTransform, KeyframedTransformError, Keyframes, KeyframesError, Transform};

use super::camera_pose::{DEFAULT_FOV_DEGREES, look_at, opening, place};
use super::shutter::ShutterInterval;
use super::transform::{motion, product, refused_motion, transform};
use super::value::vector;
use crate::LoadErrorKind;
use crate::diagnostics::Diagnostics;
use crate::format::{Camera, CameraAnimation, CameraKey, Interpolation, Node, Step};

/// Transforms of a node when the shutter opens and, if it moves, closes.
pub(super) fn node_places(
    report: &mut Diagnostics,
    path: &str,
    node: &Node,
    shutter: &ShutterInterval,
) -> Option<(Transform, Option<Transform>)> {
    let rest = transform(report, path, &node.transform);
    let Some(animation) = &node.animation else {
        let start = rest?;
        let end = motion(report, path, &start, &node.motion)?;
        return Some(shutter.cut(start, end));
    };
    refuse_motion(report, path, &node.motion)?;
    let path = format!("{path}.animation");
    let timeline = timeline(report, &path, animation.keys.iter().map(|key| key.time), animation.interpolation);
    let keys = moves(report, &path, timeline, animation.keys.iter().map(|key| key.transform.as_slice()));
    let (keys, rest) = (keys?, rest?);
    let shutter = shutter.of_keys(animation.interpolation);
    shutter.places(report, path, |time| Ok(keys.at(time).compose(&rest)))
}

/// Camera at the time at which the shutter opens.
pub(super) struct PosedCamera<'a> {
    /// Camera as a file would describe it without an animation.
    pub(super) camera: Cow<'a, Camera>,
    /// Transform without keys.
    pub(super) rest: Transform,
    pub(super) world_from_camera: Transform,
    /// Transform when the shutter closes, if it moves.
    pub(super) moves_to: Option<Transform>,
}

/// The camera of a file, posed.
pub(super) fn posed_camera<'a>(
    report: &mut Diagnostics,
    path: &str,
    camera: &'a Camera,
    shutter: &ShutterInterval,
) -> Option<PosedCamera<'a>> {
    let Some(animation) = &camera.animation else {
        let rest = place(report, path, camera)?;
        let end = motion(report, path, &rest, &camera.motion)?;
        let (world_from_camera, moves_to) = shutter.cut(rest, end);
        return Some(PosedCamera { camera: Cow::Borrowed(camera), rest, world_from_camera, moves_to });
    };
    refuse_motion(report, path, &camera.motion)?;
    let keys_path = format!("{path}.animation");
    let times = animation.keys.iter().map(|key| key.time);
    let timeline = timeline(report, &keys_path, times, animation.interpolation)?;
    let shutter = shutter.of_keys(animation.interpolation);
    let mut posed = camera.clone();
    if animation.keys.iter().any(|key| key.fov.is_some()) {
        posed.fov = Some(field_of_view(report, &keys_path, camera, animation, &timeline, shutter.opens())?);
    }
    let looks = animation.keys.iter().any(CameraKey::looks);
    let first_move = animation.keys.iter().position(|key| !key.transform.is_empty());
    if let Some(index) = first_move.filter(|_| looks) {
        let rule = "conflicts with `look_from`, `look_at` or `up` of this or another key: use one of them";
        return report.refuse(format_args!("{keys_path}.keys[{index}].transform"), "the transform", rule);
    }
    let (rest, (world_from_camera, moves_to)) = if looks {
        let views = Views::read(report, &keys_path, camera, animation)?;
        let places = shutter.places(report, &keys_path, |time| {
            let [eye, target, up] = views.at(&timeline, time);
            look_at(eye, target, up)
        })?;
        let [eye, target, up] = views.at(&timeline, shutter.opens()).map(|point| point.to_array());
        (posed.look_from, posed.look_at, posed.up) = (Some(eye), Some(target), Some(up));
        (places.0, places)
    } else {
        let rest = match first_move {
            Some(_) if camera.is_unplaced() => Transform::IDENTITY,
            _ => place(report, path, camera)?,
        };
        let steps = animation.keys.iter().map(|key| key.transform.as_slice());
        let keys = moves(report, &keys_path, Some(timeline), steps)?;
        (rest, shutter.places(report, &keys_path, |time| Ok(keys.at(time).compose(&rest)))?)
    };
    Some(PosedCamera { camera: Cow::Owned(posed), rest, world_from_camera, moves_to })
}

/// Refuses `motion` together with `animation`.
fn refuse_motion(report: &mut Diagnostics, path: &str, motion: &[Step]) -> Option<()> {
    if motion.is_empty() {
        return Some(());
    }
    report.refuse(format_args!("{path}.motion"), "the motion", "conflicts with `animation`: remove one of them")
}

fn timeline(
    report: &mut Diagnostics,
    path: &str,
    times: impl Iterator<Item = f64>,
    interpolation: Interpolation,
) -> Option<Keyframes> {
    let times: Vec<f64> = times.collect();
    match Keyframes::new(times.clone(), interpolation.into()) {
        Ok(timeline) => Some(timeline),
        Err(KeyframesError::Empty) => {
            let rule = "has no keys: give one, or remove the animation";
            report.refuse(format_args!("{path}.keys"), "the animation", rule)
        }
        Err(KeyframesError::Time(index)) => {
            let rule = "is not a time in seconds of magnitude at most 1e60";
            report.refuse(format_args!("{path}.keys[{index}].time"), times[index], rule)
        }
        Err(KeyframesError::Order(index)) => {
            let rule =
                format!("does not come after {}, the time of the key before: order keys by time", times[index - 1]);
            report.refuse(format_args!("{path}.keys[{index}].time"), times[index], rule)
        }
    }
}

/// The moves of keys. All that is wrong with them is reported, also if there is no timeline.
fn moves<'a>(
    report: &mut Diagnostics,
    path: &str,
    timeline: Option<Keyframes>,
    keys: impl Iterator<Item = &'a [Step]>,
) -> Option<KeyframedTransform> {
    let places = keys.enumerate().map(|(i, steps)| product(report, format_args!("{path}.keys[{i}].transform"), steps));
    let places: Option<Vec<Transform>> = places.collect::<Vec<_>>().into_iter().collect();
    match KeyframedTransform::new(timeline?, places?) {
        Ok(keys) => Some(keys),
        Err(KeyframedTransformError::AnimatedTransform(index, error)) => {
            report.check(format_args!("{path}.keys[{index}].transform"), Err(refused_motion(error)))
        }
        Err(error @ KeyframedTransformError::Count(..)) => {
            report.check(path, Err(LoadErrorKind::Syntax(error.to_string())))
        }
    }
}

/// Field of view of a camera at a time, in degrees.
fn field_of_view(
    report: &mut Diagnostics,
    path: &str,
    camera: &Camera,
    animation: &CameraAnimation,
    timeline: &Keyframes,
    time: f64,
) -> Option<f64> {
    let mut angles = Vec::with_capacity(animation.keys.len());
    for (i, key) in animation.keys.iter().enumerate() {
        let degrees = key.fov.or(camera.fov).unwrap_or(DEFAULT_FOV_DEGREES);
        report.check(format_args!("{path}.keys[{i}].fov"), opening(degrees))?;
        angles.push(degrees);
    }
    Some(timeline.number(&angles, time))
}

/// Position, target and up vector of a camera at each key.
struct Views {
    eyes: Vec<DVec3>,
    targets: Vec<DVec3>,
    ups: Vec<DVec3>,
}

impl Views {
    fn read(report: &mut Diagnostics, path: &str, camera: &Camera, animation: &CameraAnimation) -> Option<Self> {
        if !camera.transform.is_empty() {
            let rule = "conflicts with `look_from`, `look_at` or `up` of its keys: remove one of them";
            return report.refuse(format_args!("{path}.keys"), "the transform of the camera", rule);
        }
        let mut views = Self { eyes: Vec::new(), targets: Vec::new(), ups: Vec::new() };
        for (i, key) in animation.keys.iter().enumerate() {
            let path = format!("{path}.keys[{i}]");
            let eye = key.look_from.or(camera.look_from).ok_or_else(|| {
                LoadErrorKind::invalid("`look_from`", "is needed here, because neither the key nor the camera has it")
            });
            views.eyes.push(report.check(format_args!("{path}.look_from"), eye.and_then(vector))?);
            let target = key.look_at.or(camera.look_at).unwrap_or_default();
            views.targets.push(report.check(format_args!("{path}.look_at"), vector(target))?);
            let up = key.up.or(camera.up).unwrap_or([0.0, 1.0, 0.0]);
            views.ups.push(report.check(format_args!("{path}.up"), vector(up))?);
            report.check(path, look_at(views.eyes[i], views.targets[i], views.ups[i]))?;
        }
        Some(views)
    }

    fn at(&self, timeline: &Keyframes, time: f64) -> [DVec3; 3] {
        [&self.eyes, &self.targets, &self.ups].map(|points| timeline.point(points, time))
    }
}
