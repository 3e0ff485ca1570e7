//! The graphics state: attributes of the shapes that follow.

use std::collections::HashMap;

use rt_math::{DVec3, Rgb, Transform};

use super::parameters::Parameters;
use super::view;
use crate::error::{ErrorInLine, LineError};
use crate::text::tokenizer::Tokenizer;

/// Light that a surface gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Emission {
    pub(super) radiance: Rgb,
    pub(super) both_sides: bool,
}

/// Graphics state, saved by `AttributeBegin`.
#[derive(Clone, Debug)]
pub(super) struct GraphicsState {
    /// From the space of shapes to the world; before the world begins, from the world to the camera.
    pub(super) matrix: Transform,
    /// True while transforms apply only to the end of a motion, which is not supported.
    pub(super) at_end_time: bool,
    pub(super) reversed: bool,
    /// Index in the list of surfaces.
    pub(super) surface: usize,
    pub(super) emission: Option<Emission>,
    /// Parameters that hold for all directives of a kind.
    pub(super) attributes: HashMap<String, Parameters>,
}

impl Default for GraphicsState {
    fn default() -> Self {
        let (matrix, attributes) = (Transform::IDENTITY, HashMap::new());
        Self { matrix, at_end_time: false, reversed: false, surface: 0, emission: None, attributes }
    }
}

/// Directives that change the matrix.
pub(super) const TRANSFORMS: [&str; 7] =
    ["Identity", "Translate", "Scale", "Rotate", "LookAt", "Transform", "ConcatTransform"];

/// The matrix after one of [`TRANSFORMS`].
pub(super) fn transformed(
    matrix: &Transform,
    directive: &str,
    line: usize,
    tokens: &mut Tokenizer<'_>,
) -> Result<Transform, LineError> {
    let first = match directive {
        "Identity" => return Ok(Transform::IDENTITY),
        "Translate" => Transform::translate(DVec3::from(tokens.numbers("a part of the translation")?)),
        "Scale" => Transform::scale(DVec3::from(tokens.numbers("a factor")?)).in_line(line)?,
        "Rotate" => {
            let [degrees, x, y, z] = tokens.numbers("an angle in degrees or a component of the axis")?;
            Transform::rotate(DVec3::new(x, y, z), degrees.to_radians()).in_line(line)?
        }
        "LookAt" => view::look_at(line, tokens.numbers("a coordinate of the view")?)?,
        replaces_or_adds => {
            // Column by column.
            let m: [f64; 16] = tokens.numbers("an element of the matrix")?;
            let rows = [0, 1, 2, 3].map(|row| [m[row], m[row + 4], m[row + 8], m[row + 12]]);
            let given = Transform::from_rows(rows).in_line(line)?;
            if replaces_or_adds == "Transform" {
                return Ok(given);
            }
            given
        }
    };
    let sum = matrix.compose(&first);
    // Factors that are small one by one may flatten space together.
    Transform::from_linear(sum.linear(), sum.translation()).in_line(line)
}
