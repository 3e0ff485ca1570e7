//! The laws of reflection and refraction, and Fresnel's equations.

use rt_math::{DVec3, Mask, Real, Vector3, float::cross};

/// Mirrors `direction` at a surface with unit `normal`; keeps its length.
#[inline]
pub fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    reflect_lanes(direction.into(), normal.into()).into()
}

/// Version of [`reflect`] for lanes.
#[inline(always)]
pub(crate) fn reflect_lanes<R: Real>(direction: Vector3<R>, normal: Vector3<R>) -> Vector3<R> {
    direction - normal * (direction.dot(normal) * 2.0)
}

/// Refracts the unit vector `direction` at a surface whose unit `normal` points against it. Unit result; `None` on total
/// internal reflection.
///
/// `eta` is the index of refraction on the side of the normal divided by that behind it.
///
/// Snell's law. The sine comes from the cross product: near the normal, `√(1 − cos²)` would lose half its digits.
#[inline(always)]
pub fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let sin_i = cross(direction, normal).length();
    let (refracted, is_transmitted) = refract_lanes(direction.into(), normal.into(), eta, sin_i);
    is_transmitted.then(|| refracted.into())
}

/// Version of [`refract`] for lanes, given the sine of the angle of incidence; not valid where the mask is false, on total internal
/// reflection.
#[inline(always)]
pub(crate) fn refract_lanes<R: Real>(
    direction: Vector3<R>,
    normal: Vector3<R>,
    eta: R,
    sin_i: R,
) -> (Vector3<R>, R::Mask) {
    let cos_i = -direction.dot(normal);
    let cos2_t = square_of_transmitted_cosine(eta * sin_i);
    let is_transmitted = !cos2_t.lt(eta.splat(0.0));
    // Along the normal, the sum of a very large `eta` cancels to nothing.
    let (refracted, has_direction) = (direction * eta + normal * (eta * cos_i - cos2_t.sqrt())).try_normalize();
    (Vector3::select(has_direction, refracted, -normal), is_transmitted)
}

/// 1 − sin², negative on total internal reflection.
#[inline(always)]
fn square_of_transmitted_cosine<R: Real>(sin_t: R) -> R {
    let one = sin_t.splat(1.0);
    (one - sin_t) * (one + sin_t)
}

/// Reflectance of a smooth dielectric for unpolarised light (Fresnel 1823); 1 on total internal reflection.
///
/// `cos_i` is the cosine of the angle of incidence, in [0, 1], and `eta` as in [`refract`].
#[inline]
pub fn fresnel<R: Real>(cos_i: R, eta: R) -> R {
    let [perpendicular, parallel] = polarised_fresnel(cos_i, eta);
    (perpendicular + parallel) * 0.5
}

/// Version of [`fresnel`] for light polarised perpendicular and parallel to the plane of incidence.
#[inline(always)]
pub fn polarised_fresnel<R: Real>(cos_i: R, eta: R) -> [R; 2] {
    let (zero, one) = (eta.splat(0.0), eta.splat(1.0));
    let cos_i = cos_i.max(zero).min(one);
    let cos2_t = square_of_transmitted_cosine(eta * ((one - cos_i) * (one + cos_i)).sqrt());
    let is_total = cos2_t.le(zero);
    if is_total.all() {
        return [one; 2];
    }
    let cos_t = cos2_t.sqrt();
    let perpendicular = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let parallel = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let square = |amplitude: R| R::select(is_total, one, amplitude * amplitude);
    [square(perpendicular), square(parallel)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rt_math::transcendental::{cos, sin};

    fn incident(angle: f64) -> DVec3 {
        DVec3::new(sin(angle), -cos(angle), 0.0)
    }

    #[test]
    fn light_along_the_normal_goes_straight_on_at_any_density() {
        for eta in [1e-300, 1e-17, 1.0, 1e17, 1e60] {
            assert_eq!(refract(DVec3::NEG_Y, DVec3::Y, eta), Some(DVec3::NEG_Y), "{eta}");
        }
    }

    proptest! {
        #[test]
        fn refraction_obeys_snell(angle in 0.0..1.57f64, eta in 0.2..5.0f64) {
            if let Some(t) = refract(incident(angle), DVec3::Y, eta) {
                prop_assert!((t.x - eta * sin(angle)).abs() < 1e-12);
                prop_assert!(t.y <= 0.0 && (t.length() - 1.0).abs() < 1e-14);
            } else {
                prop_assert!(eta * sin(angle) > 1.0 - 1e-12);
            }
        }

        #[test]
        fn reflection_twice_is_nothing(x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64) {
            let d = DVec3::new(x, y, z);
            let n = DVec3::new(1.0, 2.0, -2.0) / 3.0;
            prop_assert!((reflect(reflect(d, n), n) - d).length() < 1e-14);
        }

        #[test]
        fn fresnel_is_the_same_in_both_directions(angle in 0.0..1.5f64, eta in 0.3..3.0f64) {
            let t = refract(incident(angle), DVec3::Y, eta);
            prop_assume!(t.is_some());
            let cos_t = -t.expect("assumed").y;
            let there = fresnel(cos(angle), eta);
            let back = fresnel(cos_t, 1.0 / eta);
            prop_assert!((there - back).abs() < 1e-9, "{there} {back}");
        }
    }
}
