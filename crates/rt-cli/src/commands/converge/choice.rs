//! Which of the things to measure against is taken.

use rt_image::Development;
use rt_scene_io::Scene;

use super::methods::Method;
use super::yardstick::Yardstick;
use crate::args::{Against, ConvergeArgs, PictureArgs};
use crate::error::Failure;

/// What errors are measured against: what was asked for, or the best that there is.
pub(super) fn choose(args: &ConvergeArgs, scene: &Scene, picture: &PictureArgs) -> Result<Against, Failure> {
    let view = &picture.view;
    let is_other_view = picture.crop.is_some()
        || picture.background.is_some()
        || view.camera.is_some()
        || view.look_from.is_some()
        || view.look_at.is_some()
        || view.up.is_some()
        || view.fov.is_some();
    let refuse = |message: &str| Err(Failure::Usage(message.to_owned()));
    match args.against {
        Some(Against::Truth) if scene.truth.is_none() => refuse("--against truth: the scene declares none"),
        Some(Against::Truth) if is_other_view => {
            refuse("--against truth: the scene declares that of its own view, which other options change")
        }
        Some(Against::Reference) if args.reference.is_none() => refuse("--against reference needs --reference FILE"),
        Some(against) => Ok(against),
        None if scene.truth.is_some() && !is_other_view => Ok(Against::Truth),
        None if args.reference.is_some() => Ok(Against::Reference),
        None => Ok(Against::Split),
    }
}

/// What there is to measure against without a render.
pub(super) fn given(
    args: &ConvergeArgs,
    against: Against,
    first: &Method,
    scene: &Scene,
    development: &Development,
) -> Result<Option<Yardstick>, Failure> {
    match (against, &scene.truth, &args.reference) {
        (Against::Truth, Some(truth), _) => Ok(Some(Yardstick::Truth(truth.clone()))),
        (Against::Reference, _, Some(path)) => Yardstick::of_file(path, first.size(), development).map(Some),
        _ => Ok(None),
    }
}
