//! Steps to a transform.

use std::fmt::Display;

use rt_math::{AnimatedTransform, AnimatedTransformError, DQuat, DVec3, Transform, TransformError};

use super::value::vector;
use crate::LoadErrorKind;
use crate::diagnostics::Diagnostics;
use crate::format::Step;

/// The `transform` at a path.
pub(super) fn transform(report: &mut Diagnostics, path: impl Display, steps: &[Step]) -> Option<Transform> {
    product(report, format_args!("{path}.transform"), steps)
}

/// End transform of the `motion` at a path, if any. It must be possible to interpolate it from the start.
pub(super) fn motion(
    report: &mut Diagnostics,
    path: impl Display,
    start: &Transform,
    steps: &[Step],
) -> Option<Option<Transform>> {
    if steps.is_empty() {
        return Some(None);
    }
    let path = format!("{path}.motion");
    let end = product(report, &path, steps)?;
    report.check(&path, AnimatedTransform::new(start, &end).map_err(refused_motion)).map(|_| Some(end))
}

/// Error of a motion that cannot be interpolated.
pub(super) fn refused_motion(error: AnimatedTransformError) -> LoadErrorKind {
    match error {
        AnimatedTransformError::Mirrors => {
            LoadErrorKind::invalid("the motion", "mirrors one end only, and is singular in between: mirror both ends")
        }
        AnimatedTransformError::Decomposition => {
            LoadErrorKind::invalid("the motion", "has numbers that are too large, too small or too different")
        }
    }
}

/// The steps as one map; each is applied after those before it.
pub(super) fn product(report: &mut Diagnostics, path: impl Display, steps: &[Step]) -> Option<Transform> {
    if steps.is_empty() {
        return Some(Transform::IDENTITY);
    }
    let mut all = Transform::IDENTITY;
    for (i, step) in steps.iter().enumerate() {
        let step = report.check(format_args!("{path}[{i}]"), single(step))?;
        all = step.compose(&all);
    }
    // Steps may each be sound and yet flatten space, or leave the range of numbers, together.
    let product = Transform::from_linear(all.linear(), all.translation()).map_err(LoadErrorKind::from);
    let checked = product.and_then(|_| vector(all.translation().to_array()));
    report.check(path, checked).map(|_| all)
}

fn single(step: &Step) -> Result<Transform, LoadErrorKind> {
    let angle = f64::to_radians;
    let transform = match *step {
        Step::Translate(x, y, z) => Ok(Transform::translate(vector([x, y, z])?)),
        Step::Rotate { axis, degrees } => Transform::rotate(axis.into(), angle(degrees)),
        Step::RotateX(degrees) => Transform::rotate(DVec3::X, angle(degrees)),
        Step::RotateY(degrees) => Transform::rotate(DVec3::Y, angle(degrees)),
        Step::RotateZ(degrees) => Transform::rotate(DVec3::Z, angle(degrees)),
        Step::Euler(x, y, z) => Transform::rotate_euler(DVec3::new(angle(x), angle(y), angle(z))),
        Step::Quaternion(x, y, z, w) => Transform::rotate_quaternion(DQuat::from_xyzw(x, y, z, w)),
        Step::Scale(factor) => Transform::scale(DVec3::splat(factor)),
        Step::Stretch(x, y, z) => Transform::scale(DVec3::new(x, y, z)),
        Step::Shear { xy, xz, yx, yz, zx, zy } => Transform::shear([xy, xz, yx, yz, zx, zy]),
        Step::Matrix(a, b, c, d) => Transform::from_rows([a, b, c, d]),
        Step::LookAt { from, at, up } => Transform::look_at(vector(from)?, vector(at)?, up.into()),
    };
    transform.map_err(|error| {
        let rule = match error {
            TransformError::NonFinite => "has a NaN or infinite number",
            TransformError::Singular(_) if matches!(step, Step::Scale(_)) => "is singular: the factor must not be 0",
            TransformError::Singular(_) => "is singular: no factor may be 0, nor 1e12 times another",
            TransformError::NotAffine => "is not affine: the last row must be (0, 0, 0, 1)",
            TransformError::DegenerateDirection => no_direction(step),
        };
        LoadErrorKind::invalid(ron::to_string(step).unwrap_or_default(), rule)
    })
}

/// Rule that a step without a direction breaks.
fn no_direction(step: &Step) -> &'static str {
    match step {
        Step::Quaternion(..) => "has no direction: the quaternion must not be 0",
        Step::LookAt { from, at, .. } if from == at => "has no direction: `from` and `at` must differ",
        Step::LookAt { .. } => "has no direction: `up` must not be 0 nor parallel to the view",
        _ => "has no direction: the axis must not be 0",
    }
}
