//! The view of an NFF file.

use rt_camera::{CameraSettings, FovAxis, Projection};
use rt_math::{DVec3, Transform};

use crate::NamedCamera;
use crate::error::LineError;
use crate::text;
use crate::text::tokenizer::{Tokenizer, Word};

/// The words that parts of the statement begin with.
pub(super) const PARTS: [&str; 6] = ["from", "at", "up", "angle", "hither", "resolution"];

/// Camera and image size.
pub(super) struct NffView {
    pub(super) camera: NamedCamera,
    pub(super) size: [u32; 2],
}

/// Fields of a `v` statement. The hither plane is read and dropped.
#[derive(Default)]
struct ViewFields {
    from: Option<DVec3>,
    at: Option<DVec3>,
    up: Option<DVec3>,
    angle: Option<f64>,
    resolution: Option<[u32; 2]>,
}

impl NffView {
    /// Reads the parts of a `v` statement after `line`, in any order.
    pub(super) fn read(tokens: &mut Tokenizer<'_>, line: usize) -> Result<Self, LineError> {
        let mut parts = ViewFields::default();
        while let Some(Word { line, text }) = tokens.peek_word() {
            if !PARTS.contains(&text) {
                break;
            }
            tokens.take_word();
            match text {
                "from" => parts.from = Some(tokens.numbers("a coordinate of the eye")?.into()),
                "at" => parts.at = Some(tokens.numbers("a coordinate of `at`")?.into()),
                "up" => parts.up = Some(tokens.numbers("a component of `up`")?.into()),
                "angle" => parts.angle = Some(angle(tokens, line)?),
                "hither" => drop(tokens.number("the distance of the hither plane")?),
                _ => parts.resolution = Some(resolution(tokens, line)?),
            }
        }
        let missing = |part: &str| LineError::new(line, "the view", format!("has no `{part}`: add it"));
        let [eye, target, up] = [(parts.from, "from"), (parts.at, "at"), (parts.up, "up")]
            .map(|(part, name)| part.ok_or_else(|| missing(name)));
        let (eye, target, up) = (eye?, target?, up?);
        let world_from_camera = Transform::look_at(eye, target, up).map_err(|_| {
            let rule = "has no direction: `from` and `at` must differ, and `up` must not be 0 or along the view";
            LineError::new(line, format_args!("the view from {eye} at {target}, with {up} up,"), rule)
        })?;
        let fov = parts.angle.ok_or_else(|| missing("angle"))?.to_radians();
        let projection = Projection::Perspective { fov, axis: FovAxis::Vertical };
        let settings = CameraSettings::new(world_from_camera, projection);
        let size = parts.resolution.ok_or_else(|| missing("resolution"))?;
        Ok(Self { camera: NamedCamera { name: "view".to_owned(), settings, medium: None }, size })
    }
}

/// Degrees from the top to the bottom of the image.
fn angle(tokens: &mut Tokenizer<'_>, line: usize) -> Result<f64, LineError> {
    let degrees = tokens.number("the angle of the view")?;
    if degrees > 0.0 && degrees < 180.0 {
        Ok(degrees)
    } else {
        Err(LineError::new(line, degrees, "degrees: the angle of the view must lie between 0 and 180"))
    }
}

fn resolution(tokens: &mut Tokenizer<'_>, line: usize) -> Result<[u32; 2], LineError> {
    let [width, height] = tokens.numbers("the resolution")?;
    text::resolution(line, width, height)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "from 0 0 5 at 0 0 0 up 0 1 0 angle 45 hither 1 resolution 64 48";

    fn read(text: &str) -> Result<NffView, String> {
        NffView::read(&mut Tokenizer::words(text), 1).map_err(|error| error.kind.to_string())
    }

    #[test]
    fn the_camera_stands_where_the_view_says() {
        let NffView { camera, size } = read(WHOLE).expect("a view");
        assert_eq!(size, [64, 48]);
        assert_eq!(camera.settings.world_from_camera.translation(), DVec3::new(0.0, 0.0, 5.0));
        let fov = 45f64.to_radians();
        assert_eq!(camera.settings.projection, Projection::Perspective { fov, axis: FovAxis::Vertical });
    }

    #[test]
    fn every_part_is_needed_but_the_hither_plane() {
        assert!(read(&WHOLE.replace("hither 1", "")).is_ok());
        for part in ["from 0 0 5", "at 0 0 0", "up 0 1 0", "angle 45", "resolution 64 48"] {
            let name = part.split_once(' ').expect("words").0;
            assert_eq!(read(&WHOLE.replace(part, "")).err().unwrap(), format!("the view has no `{name}`: add it"));
        }
    }

    #[test]
    fn values_that_make_no_camera_are_refused() {
        for (good, bad) in [
            ("angle 45", "angle 180"),
            ("64 48", "64 0"),
            ("64 48", "1.5 48"),
            ("64 48", "20000 20000"),
            ("up 0 1 0", "up 0 0 2"),
            ("at 0 0 0", "at 0 0 5"),
        ] {
            assert!(read(&WHOLE.replace(good, bad)).is_err(), "{bad}");
        }
    }
}
