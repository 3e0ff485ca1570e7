//! Affine transforms with their inverses.

use core::fmt;

use crate::{
    Aabb, Ray,
    float::{gamma, power_of_two_scale},
    transcendental::sincos,
};
use glam::{DMat3, DQuat, DVec3};

/// Maximum condition number of a transform: beyond 10¹², a ray in local space keeps fewer than four digits. In the
/// Frobenius norm, which is used here, it may be up to three times as much.
const MAX_CONDITION: f64 = 3e12;

/// Invertible affine map `p ↦ L·p + T`, stored with the inverse of `L`.
///
/// Named target-from-source: `world_from_local.point(p)` takes a local point to the world. The inverse subtracts the
/// translation *before* it multiplies, which is exact for nearby points and keeps scenes far from the origin sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    linear: DMat3,
    linear_inverse: DMat3,
    translation: DVec3,
}

/// Error of the constructors of [`Transform`]: a matrix that is no usable transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransformError {
    /// A component is NaN or infinite.
    NonFinite,
    /// The map is singular: its determinant is 0, or its condition number (the value, which may be NaN) exceeds 3·10¹².
    Singular(f64),
    /// The last row of a 4×4 matrix is not (0, 0, 0, 1).
    NotAffine,
    /// The view direction or the rotation axis is zero, or the view direction is parallel to the up vector.
    DegenerateDirection,
}

impl fmt::Display for TransformError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite => f.write_str("the transform has a NaN or infinite component"),
            Self::Singular(condition) if condition.is_nan() => f.write_str("the transform is singular"),
            Self::Singular(condition) => write!(
                f,
                "the transform is singular (condition number {condition:.3e}, at most {MAX_CONDITION:.0e} is accepted)"
            ),
            Self::NotAffine => f.write_str("the last row of the matrix must be (0, 0, 0, 1)"),
            Self::DegenerateDirection => {
                f.write_str("a direction is zero, or the view direction is parallel to the up vector")
            }
        }
    }
}

impl core::error::Error for TransformError {}

impl Transform {
    /// Identity.
    pub const IDENTITY: Self =
        Self { linear: DMat3::IDENTITY, linear_inverse: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// Moves by `offset`.
    pub const fn translate(offset: DVec3) -> Self {
        Self { translation: offset, ..Self::IDENTITY }
    }

    /// Rotates by `angle` radians about `axis` (any non-zero length), counter-clockwise seen from its tip.
    ///
    /// # Errors
    /// [`TransformError::DegenerateDirection`] for a zero axis, [`TransformError::NonFinite`] for a NaN.
    pub fn rotate(axis: DVec3, angle: f64) -> Result<Self, TransformError> {
        if !(axis.is_finite() && angle.is_finite()) {
            return Err(TransformError::NonFinite);
        }
        let axis = axis.try_normalize().ok_or(TransformError::DegenerateDirection)?;
        let (sin, cos) = sincos(angle);
        // Rodrigues' formula, column by column.
        let turn = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
        Ok(Self::rotation(DMat3::from_cols(turn(DVec3::X), turn(DVec3::Y), turn(DVec3::Z))))
    }

    /// Rotates about x, then y, then z (fixed axes), by `angles` radians.
    ///
    /// # Errors
    /// [`TransformError::NonFinite`] for a NaN or infinite angle.
    pub fn rotate_euler(angles: DVec3) -> Result<Self, TransformError> {
        let about_x = Self::rotate(DVec3::X, angles.x)?;
        let about_y = Self::rotate(DVec3::Y, angles.y)?;
        let about_z = Self::rotate(DVec3::Z, angles.z)?;
        Ok(about_z.compose(&about_y).compose(&about_x))
    }

    /// Rotates by a quaternion of any non-zero length.
    ///
    /// # Errors
    /// [`TransformError::DegenerateDirection`] for a zero quaternion, [`TransformError::NonFinite`] for a NaN.
    pub fn rotate_quaternion(quaternion: DQuat) -> Result<Self, TransformError> {
        if !quaternion.is_finite() {
            return Err(TransformError::NonFinite);
        }
        let length = quaternion.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(TransformError::DegenerateDirection);
        }
        Ok(Self::rotation(DMat3::from_quat(DQuat::from_vec4(glam::DVec4::from(quaternion) / length))))
    }

    /// Scales by a factor for each axis; negative factors mirror.
    ///
    /// # Errors
    /// [`TransformError::Singular`] for a zero factor, or factors more than 10¹² apart.
    pub fn scale(factors: DVec3) -> Result<Self, TransformError> {
        Self::from_linear(DMat3::from_diagonal(factors), DVec3::ZERO)
    }

    /// Shears: `x` gains `xy·y + xz·z`, `y` gains `yx·x + yz·z`, `z` gains `zx·x + zy·y`.
    ///
    /// # Errors
    /// [`TransformError::Singular`] if the matrix of the six factors is singular.
    pub fn shear([xy, xz, yx, yz, zx, zy]: [f64; 6]) -> Result<Self, TransformError> {
        let linear = DMat3::from_cols(DVec3::new(1.0, yx, zx), DVec3::new(xy, 1.0, zy), DVec3::new(xz, yz, 1.0));
        Self::from_linear(linear, DVec3::ZERO)
    }

    /// World from camera: a camera at `eye` that looks along its −z towards `target`, with +y as near to `up` as
    /// possible. The result is `world_from_observer`.
    ///
    /// # Errors
    /// [`TransformError::DegenerateDirection`] if `eye` equals `target` or the view is parallel to `up`.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Result<Self, TransformError> {
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err(TransformError::NonFinite);
        }
        let degenerate = TransformError::DegenerateDirection;
        let back = (eye - target).try_normalize().ok_or(degenerate)?;
        let up = up.try_normalize().ok_or(degenerate)?;
        let right = crate::float::cross(up, back);
        // Below this the sideways direction is rounding noise.
        if right.length() < 1e-12 {
            return Err(degenerate);
        }
        let right = right.normalize();
        let linear = DMat3::from_cols(right, back.cross(right), back);
        Ok(Self { translation: eye, ..Self::rotation(linear) })
    }

    /// The affine map of a 4×4 matrix given by rows.
    ///
    /// # Errors
    /// [`TransformError::NotAffine`], [`TransformError::NonFinite`] or [`TransformError::Singular`].
    pub fn from_rows(rows: [[f64; 4]; 4]) -> Result<Self, TransformError> {
        if rows.iter().flatten().any(|v| !v.is_finite()) {
            return Err(TransformError::NonFinite);
        }
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(TransformError::NotAffine);
        }
        let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
        Self::from_linear(DMat3::from_cols(column(0), column(1), column(2)), column(3))
    }

    /// The map `p ↦ linear·p + translation`.
    ///
    /// # Errors
    /// [`TransformError::NonFinite`] or [`TransformError::Singular`].
    pub fn from_linear(linear: DMat3, translation: DVec3) -> Result<Self, TransformError> {
        if !(linear.is_finite() && translation.is_finite()) {
            return Err(TransformError::NonFinite);
        }
        // Products of three coordinates neither overflow nor underflow.
        let factor = scale_to_one(&linear);
        let scaled = linear * factor;
        let linear_inverse = scaled.inverse() * factor;
        let condition = frobenius(&linear) * frobenius(&linear_inverse);
        if !(scaled.determinant() != 0.0 && condition <= MAX_CONDITION && linear_inverse.is_finite()) {
            return Err(TransformError::Singular(condition));
        }
        Ok(Self { linear, linear_inverse, translation })
    }

    /// Transform of a linear part, its inverse, and a translation, which the caller has checked.
    pub(crate) const fn from_parts(linear: DMat3, linear_inverse: DMat3, translation: DVec3) -> Self {
        Self { linear, linear_inverse, translation }
    }

    /// An orthonormal matrix: its inverse is its transpose.
    fn rotation(linear: DMat3) -> Self {
        Self { linear, linear_inverse: linear.transpose(), translation: DVec3::ZERO }
    }

    /// Product that applies `first` and then this one: `a_from_b.compose(&b_from_c)` is `a_from_c`.
    pub fn compose(&self, first: &Self) -> Self {
        Self {
            linear: self.linear * first.linear,
            linear_inverse: first.linear_inverse * self.linear_inverse,
            translation: self.point(first.translation),
        }
    }

    /// Inverse map: source and target change places.
    pub fn inverse(&self) -> Self {
        Self {
            linear: self.linear_inverse,
            linear_inverse: self.linear,
            translation: -(self.linear_inverse * self.translation),
        }
    }

    /// The linear part `L`.
    pub const fn linear(&self) -> DMat3 {
        self.linear
    }

    /// The translation `T`: the image of the source's origin.
    pub const fn translation(&self) -> DVec3 {
        self.translation
    }

    /// True if this is exactly the identity.
    #[inline]
    pub fn is_identity(&self) -> bool {
        *self == Self::IDENTITY
    }

    /// True if the map mirrors, so that the handedness of a frame (and the winding of a triangle) flips.
    pub fn flips_handedness(&self) -> bool {
        (self.linear * scale_to_one(&self.linear)).determinant() < 0.0
    }

    /// Uniform scale factor, if lengths scale equally in all directions (to 10⁻¹²).
    pub fn uniform_scale(&self) -> Option<f64> {
        // Squares neither overflow nor underflow.
        let factor = scale_to_one(&self.linear);
        let linear = self.linear * factor;
        let gram = linear.transpose() * linear;
        let square = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
        let deviation = gram - DMat3::from_diagonal(DVec3::splat(square));
        (frobenius(&deviation) <= 1e-12 * square).then(|| square.sqrt() / factor)
    }

    /// Condition number of the linear part in the Frobenius norm, at least 3.
    pub fn condition(&self) -> f64 {
        frobenius(&self.linear) * frobenius(&self.linear_inverse)
    }

    /// Transforms a point from source to target space.
    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.linear * p + self.translation
    }

    /// Transforms a vector (a difference of points) from source to target space.
    #[inline]
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.linear * v
    }

    /// Transforms a normal from source to target space by the inverse transpose; not normalised. It keeps its side of the
    /// surface even under a mirroring map.
    #[inline]
    pub fn normal(&self, n: DVec3) -> DVec3 {
        self.linear_inverse.transpose() * n
    }

    /// Transforms a ray from source to target space; `t` stays the same.
    #[inline]
    pub fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.point(ray.origin), direction: self.vector(ray.direction), time: ray.time }
    }

    /// Bounds of a box, transformed from source to target space and widened by the rounding error of its corners. Empty stays empty.
    pub fn aabb(&self, aabb: &Aabb) -> Aabb {
        if aabb.is_empty() {
            return Aabb::EMPTY;
        }
        aabb.corners().into_iter().fold(Aabb::EMPTY, |sum, corner| {
            let (point, error) = self.point_with_error(corner, DVec3::ZERO);
            sum.include(point - error).include(point + error)
        })
    }

    /// Transforms a point, known up to `error` per axis, from source to target space. Also returns the bound on the result's error.
    #[inline]
    pub fn point_with_error(&self, p: DVec3, error: DVec3) -> (DVec3, DVec3) {
        let magnitude = absolute(&self.linear);
        let rounding = (magnitude * p.abs() + self.translation.abs()) * gamma(4);
        (self.point(p), rounding + magnitude * error * (1.0 + gamma(4)))
    }

    /// Transforms a point from target to source space.
    #[inline]
    pub fn inverse_point(&self, p: DVec3) -> DVec3 {
        self.linear_inverse * (p - self.translation)
    }

    /// Transforms a vector from target to source space.
    #[inline]
    pub fn inverse_vector(&self, v: DVec3) -> DVec3 {
        self.linear_inverse * v
    }

    /// Transforms a ray from target to source space; `t` stays the same.
    #[inline]
    pub fn inverse_ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.inverse_point(ray.origin), direction: self.inverse_vector(ray.direction), time: ray.time }
    }
}

fn absolute(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

/// Power of two that scales the largest component to about 1, if it is extreme.
fn scale_to_one(DMat3 { x_axis, y_axis, z_axis }: &DMat3) -> f64 {
    power_of_two_scale(x_axis.abs().max(y_axis.abs()).max(z_axis.abs()))
}

fn frobenius(m: &DMat3) -> f64 {
    let factor = scale_to_one(m);
    let scaled = *m * factor;
    (scaled.x_axis.length_squared() + scaled.y_axis.length_squared() + scaled.z_axis.length_squared()).sqrt() / factor
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = DVec3> {
        (-10.0..10.0f64, -10.0..10.0f64, -10.0..10.0f64).prop_map(DVec3::from)
    }

    fn transform() -> impl Strategy<Value = Transform> {
        (vector(), vector(), -7.0..7.0f64, vector(), -0.4..0.4f64).prop_filter_map(
            "singular",
            |(offset, axis, angle, factors, shear)| {
                let rotate = Transform::rotate(axis, angle).ok()?;
                let scale = Transform::scale(factors).ok()?;
                let shear = Transform::shear([shear, 0.2, 0.0, shear, 0.1, -shear]).ok()?;
                let all = Transform::translate(offset).compose(&rotate).compose(&scale).compose(&shear);
                (all.condition() < 1e4).then_some(all)
            },
        )
    }

    proptest! {
        #[test]
        fn inverse_undoes(t in transform(), p in vector()) {
            prop_assert!((t.inverse_point(t.point(p)) - p).length() < 1e-9);
            prop_assert!((t.inverse().point(t.point(p)) - p).length() < 1e-9);
            prop_assert!((t.inverse_vector(t.vector(p)) - p).length() < 1e-9);
        }

        #[test]
        fn normals_stay_perpendicular(t in transform(), n in vector(), v in vector()) {
            let tangent = n.cross(v);
            let (normal, image) = (t.normal(n), t.vector(tangent));
            prop_assert!(normal.dot(image).abs() <= 1e-9 * normal.length() * image.length());
            prop_assert!((t.inverse().normal(normal) - n).length() < 1e-9);
        }

        #[test]
        fn composition_applies_the_right_map_first(a in transform(), b in transform(), p in vector()) {
            let both = a.compose(&b);
            prop_assert!((both.point(p) - a.point(b.point(p))).length() < 1e-8);
        }

        #[test]
        fn boxes_contain_the_image_of_their_points(t in transform(), a in vector(), b in vector(), f in 0.0..1.0f64) {
            let inside = a + (b - a) * f;
            prop_assert!(t.aabb(&Aabb::from_points([a, b])).contains(t.point(inside)));
        }

        #[test]
        fn errors_are_bounded(t in transform(), p in vector()) {
            // A point moved by its error lands within the bound around the image. By a little less than the error, as
            // the move rounds as well.
            let (image, bound) = t.point_with_error(p, DVec3::splat(1e-6));
            let moved = t.point(p + DVec3::splat(0.999_999e-6));
            prop_assert!((moved - image).abs().cmple(bound).all());
        }

        #[test]
        fn the_parameter_t_is_the_same_in_both_spaces(t in transform(), o in vector(), d in vector(), at in 0.0..10.0f64) {
            let ray = Ray::new(o, d);
            prop_assert!((t.point(t.inverse_ray(&ray).at(at)) - ray.at(at)).length() < 1e-8);
        }
    }

    /// The product of their factors is no finite number, or zero.
    #[test]
    fn extreme_scales_have_an_inverse() {
        for factor in [1e-300, 1e-107, 1e-50, 1e50, 1e103, 1e300] {
            let mirrored = DVec3::new(-factor, factor, 2.0 * factor);
            let scale = Transform::scale(mirrored).expect("factors of one magnitude");
            assert!((scale.inverse_point(scale.point(DVec3::ONE)) - DVec3::ONE).length() < 1e-15, "{factor}");
            assert!(scale.flips_handedness() && scale.inverse().flips_handedness(), "{factor}");
            assert!((scale.condition() - 13.5f64.sqrt()).abs() < 1e-12, "{factor}");
        }
        assert!(matches!(Transform::scale(DVec3::splat(5e-324)), Err(TransformError::Singular(_))));
    }

    #[test]
    fn rotations_are_counter_clockwise() {
        let quarter = core::f64::consts::FRAC_PI_2;
        let about_z = Transform::rotate(DVec3::Z * 5.0, quarter).expect("an axis");
        assert!((about_z.vector(DVec3::X) - DVec3::Y).length() < 1e-15);
        let euler = Transform::rotate_euler(DVec3::new(quarter, 0.0, quarter)).expect("finite");
        // About x first: y to z, which the turn about z leaves alone.
        assert!((euler.vector(DVec3::Y) - DVec3::Z).length() < 1e-15);
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let quaternion = Transform::rotate_quaternion(DQuat::from_xyzw(0.0, 0.0, 2.0 * half, 2.0 * half));
        assert!((quaternion.expect("not zero").vector(DVec3::X) - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn observer_looks_along_negative_z() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let world_from_camera = Transform::look_at(eye, DVec3::new(1.0, 2.0, -7.0), DVec3::Y).expect("a view");
        assert_eq!(world_from_camera.point(DVec3::ZERO), eye);
        assert_eq!(world_from_camera.vector(DVec3::NEG_Z), DVec3::NEG_Z);
        assert_eq!(world_from_camera.vector(DVec3::X), DVec3::X);
    }

    #[test]
    fn a_condition_of_a_trillion_is_accepted() {
        let needle = Transform::scale(DVec3::new(1.0, 1e-6, 1e6)).expect("regular");
        assert!((needle.inverse_vector(DVec3::new(1.0, 1e-6, 1e6)) - DVec3::ONE).length() < 1e-15);
        assert!(matches!(Transform::scale(DVec3::new(1.0, 1e-6, 4e6)), Err(TransformError::Singular(_))));
    }

    #[test]
    fn useless_maps_are_refused() {
        assert!(matches!(Transform::scale(DVec3::new(1.0, 0.0, 1.0)), Err(TransformError::Singular(_))));
        let message = Transform::from_rows([[0.0; 4], [0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0]])
            .map_err(|error| error.to_string());
        assert_eq!(message, Err("the transform is singular".to_owned()));
        assert!(matches!(Transform::scale(DVec3::new(1.0, 1e-13, 1.0)), Err(TransformError::Singular(_))));
        assert_eq!(Transform::scale(DVec3::NAN), Err(TransformError::NonFinite));
        assert_eq!(Transform::rotate(DVec3::ZERO, 1.0), Err(TransformError::DegenerateDirection));
        let eye = DVec3::splat(3.0);
        assert_eq!(Transform::look_at(eye, eye, DVec3::Y), Err(TransformError::DegenerateDirection));
        assert_eq!(Transform::look_at(eye, eye + DVec3::Y, DVec3::Y), Err(TransformError::DegenerateDirection));
        let mut rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        assert_eq!(Transform::from_rows(rows), Ok(Transform::IDENTITY));
        rows[3][0] = 0.5;
        assert_eq!(Transform::from_rows(rows), Err(TransformError::NotAffine));
    }

    #[test]
    fn a_thousand_nested_turns_and_their_inverses_come_home() {
        let turn = Transform::rotate(DVec3::new(1.0, 2.0, 3.0), 1e-3).expect("an axis");
        let step = Transform::translate(DVec3::new(0.1, 0.2, 0.3)).compose(&turn);
        let mut all = Transform::IDENTITY;
        for _ in 0..1000 {
            all = all.compose(&step);
        }
        for _ in 0..1000 {
            all = all.compose(&step.inverse());
        }
        let p = DVec3::new(1.0, -2.0, 3.0);
        assert!((all.point(p) - p).length() < 1e-11 * 100.0);
    }

    #[test]
    fn uniform_scale_is_recognised() {
        let turn = Transform::rotate(DVec3::ONE, 0.7).expect("an axis");
        let doubled = turn.compose(&Transform::scale(DVec3::splat(2.0)).expect("regular"));
        assert!((doubled.uniform_scale().expect("uniform") - 2.0).abs() < 1e-12);
        let stretched = turn.compose(&Transform::scale(DVec3::new(1.0, 1.0, 1.001)).expect("regular"));
        assert_eq!(stretched.uniform_scale(), None);
    }

    #[test]
    fn uniform_scales_of_any_size_are_recognised() {
        let scale = |x, y, z| Transform::scale(DVec3::new(x, y, z)).expect("regular").uniform_scale();
        assert_eq!(scale(1e-90, 1e-90, 2e-90), None, "the squares underflow");
        for size in [1e-90, 1e90] {
            assert!((scale(size, size, -size).expect("uniform") / size - 1.0).abs() < 1e-12);
        }
    }
}
