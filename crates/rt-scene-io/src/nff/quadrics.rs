//! Spheres, cylinders and cones.

use rt_geometry::{CappedQuadric, Shape, ShapeError, Sphere};
use rt_math::{DMat3, DVec3, Frame, Transform};

use crate::error::{ErrorInLine, LineError};
use crate::text::tokenizer::Tokenizer;

/// A shape and where it stands.
pub(super) struct PlacedShape {
    pub(super) shape: Shape,
    pub(super) world_from_local: Transform,
    /// The file shows only its inside.
    pub(super) inside_out: bool,
}

/// Reads an `s` statement: centre and radius.
pub(super) fn sphere(tokens: &mut Tokenizer<'_>, line: usize) -> Result<PlacedShape, LineError> {
    let centre = DVec3::from(tokens.numbers("a coordinate of the centre")?);
    let radius = tokens.number("the radius of a sphere")?;
    let sphere = Sphere::new(centre, radius.abs()).in_line(line)?;
    Ok(PlacedShape { shape: Shape::Sphere(sphere), world_from_local: Transform::IDENTITY, inside_out: radius < 0.0 })
}

/// Reads a `c` statement: centre and radius of the base, then those of the apex. There are no caps.
pub(super) fn cone(tokens: &mut Tokenizer<'_>, line: usize) -> Result<PlacedShape, LineError> {
    let base = DVec3::from(tokens.numbers("a coordinate of the base")?);
    let base_radius = tokens.number("the radius of the base")?;
    let apex = DVec3::from(tokens.numbers("a coordinate of the apex")?);
    let apex_radius = tokens.number("the radius of the apex")?;
    let error = |value: String, rule: &str| Err(LineError::new(line, value, rule));
    let inside_out = base_radius < 0.0 || apex_radius < 0.0;
    if inside_out && (base_radius > 0.0 || apex_radius > 0.0) {
        let rule = "are the radii of one cone: both must have the same sign";
        return error(format!("{base_radius} and {apex_radius}"), rule);
    }
    if base_radius == 0.0 && apex_radius == 0.0 {
        return error("0 and 0".to_owned(), "are the radii of one cone: one of them must not be 0");
    }
    let [base_radius, apex_radius] = [base_radius, apex_radius].map(f64::abs);
    // A cone of our own has its tip above.
    let (bottom, top, bottom_radius, top_radius) = if base_radius == 0.0 {
        (apex, base, apex_radius, base_radius)
    } else {
        (base, apex, base_radius, apex_radius)
    };
    let axis = top - bottom;
    let Some(up) = axis.try_normalize() else {
        return error(format!("{bottom}"), "is the middle of both ends of a cone: move one of them");
    };
    let shape = upright(bottom_radius, top_radius, axis.length()).in_line(line)?;
    // The columns are where x, y and z of the cone point: y along its axis.
    let frame = Frame::from_z(up);
    let place = Transform::from_linear(DMat3::from_cols(frame.y, up, frame.x), bottom);
    let world_from_local = place.in_line(line)?;
    Ok(PlacedShape { shape, world_from_local, inside_out })
}

/// The side of a cylinder, cone or frustum with its base in the plane y = 0.
fn upright(bottom: f64, top: f64, height: f64) -> Result<Shape, ShapeError> {
    Ok(if bottom == top {
        Shape::Cylinder(CappedQuadric::cylinder(bottom, 0.0, height, false)?)
    } else if top == 0.0 {
        Shape::Cone(CappedQuadric::cone(bottom, height, false)?)
    } else {
        Shape::Frustum(CappedQuadric::frustum(bottom, top, height, false)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::Aabb;

    fn read(text: &str) -> Result<PlacedShape, String> {
        cone(&mut Tokenizer::words(text), 1).map_err(|error| error.kind.to_string())
    }

    fn bounds(solid: &PlacedShape) -> Aabb {
        solid.world_from_local.aabb(&Shape::bounds(&solid.shape).expect("bounded"))
    }

    #[test]
    fn ends_stand_where_the_file_says() {
        for (text, kind) in [("1 0 0 0.5 4 0 0 0.5", "Cylinder"), ("1 0 0 0.5 4 0 0 0.25", "Frustum")] {
            let solid = read(text).expect("a cone");
            assert!(format!("{:?}", solid.shape).starts_with(kind), "{:?}", solid.shape);
            let around = bounds(&solid);
            assert!((around.min - DVec3::new(1.0, -0.5, -0.5)).length() < 1e-9, "{around:?}");
            assert!((around.max - DVec3::new(4.0, 0.5, 0.5)).length() < 1e-9, "{around:?}");
        }
        // The end of the greater radius may come second.
        let solid = read("0 0 0 0  0 0 -2 1").expect("a cone");
        assert!(matches!(solid.shape, Shape::Cone(_)));
        assert!((solid.world_from_local.point(DVec3::new(0.0, 2.0, 0.0))).length() < 1e-12, "the tip");
    }

    #[test]
    fn radii_and_ends_are_checked() {
        assert!(read("0 0 0 -1 0 1 0 -1").expect("a tube").inside_out);
        assert!(read("0 0 0 -1 0 1 0 0").expect("a cone").inside_out);
        assert_eq!(
            read("0 0 0 -1 0 1 0 2").err().unwrap(),
            "-1 and 2 are the radii of one cone: both must have the same sign"
        );
        assert!(read("0 0 0 0 0 1 0 0").err().unwrap().starts_with("0 and 0"));
        assert_eq!(
            read("1 2 3 1 1 2 3 1").err().unwrap(),
            "[1, 2, 3] is the middle of both ends of a cone: move one of them"
        );
    }
}
