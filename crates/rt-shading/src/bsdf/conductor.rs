//! Conductors: metals.

use super::{
    BsdfSample, Ggx, mirror,
    side::{Side, same_side},
};
use crate::optics;
use rt_math::{DVec3, Real, Rgb};

/// Complex index of refraction n + ik per channel.
///
/// The constants are measurements, interpolated at the dominant wavelengths of the primaries of sRGB: 611.4, 549.1 and
/// 464.2 nm. Tables: Johnson and Christy, Phys. Rev. B 6, 4370 (1972) and 9, 5056 (1974); Rakić, Appl. Opt. 34, 4755
/// (1995) for aluminium; as in the public domain data base refractiveindex.info.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexIor {
    /// Real part n, relative to the medium outside.
    pub n: Rgb,
    /// Imaginary part k, at least 0.
    pub k: Rgb,
}

impl ComplexIor {
    /// Aluminium (Rakić 1995).
    pub const ALUMINIUM: Self = Self { n: Rgb::new(1.322, 1.011, 0.683), k: Rgb::new(7.311, 6.617, 5.625) };
    /// Chromium (Johnson, Christy 1974).
    pub const CHROMIUM: Self = Self { n: Rgb::new(3.178, 3.180, 2.449), k: Rgb::new(3.300, 3.330, 3.206) };
    /// Copper (Johnson, Christy 1972).
    pub const COPPER: Self = Self { n: Rgb::new(0.362, 1.015, 1.246), k: Rgb::new(3.127, 2.579, 2.453) };
    /// Gold (Johnson, Christy 1972).
    pub const GOLD: Self = Self { n: Rgb::new(0.222, 0.428, 1.335), k: Rgb::new(3.208, 2.461, 1.872) };
    /// Iron (Johnson, Christy 1974).
    pub const IRON: Self = Self { n: Rgb::new(2.890, 2.950, 2.643), k: Rgb::new(3.040, 2.930, 2.803) };
    /// Silver (Johnson, Christy 1972).
    pub const SILVER: Self = Self { n: Rgb::new(0.058, 0.060, 0.046), k: Rgb::new(4.106, 3.590, 2.795) };
    /// Titanium (Johnson, Christy 1974).
    pub const TITANIUM: Self = Self { n: Rgb::new(2.659, 2.540, 2.303), k: Rgb::new(3.698, 3.430, 3.080) };

    /// Reflectance for unpolarised light, per channel, by [`conductor_fresnel`].
    pub fn fresnel(&self, cos_i: f64) -> Rgb {
        let channel = |n, k| conductor_fresnel(cos_i, n, k);
        Rgb::new(channel(self.n.r, self.k.r), channel(self.n.g, self.k.g), channel(self.n.b, self.k.b))
    }
}

/// Reflectance of a smooth conductor of index n + ik for unpolarised light, at the cosine `cos_i` of the angle of incidence.
///
/// Fresnel's equations with a complex index (Born and Wolf, 14.4). With k = 0 it is [`optics::fresnel`] for 1/n. Let
/// a + ib = √((n + ik)² − sin²). Rs is |cos − a − ib|² / |cos + a + ib|², and Rp is Rs · |a + ib − sin·tan|² /
/// |a + ib + sin·tan|².
#[inline(always)]
pub fn conductor_fresnel<R: Real>(cos_i: R, n: R, k: R) -> R {
    let (zero, one) = (n.splat(0.0), n.splat(1.0));
    let cos = cos_i.max(zero).min(one);
    let cos2 = cos * cos;
    let sin2 = one - cos2;
    let real = (n - k) * (n + k) - sin2;
    let size = (real * real + n * n * k * k * 4.0).sqrt();
    let a = ((size + real) * 0.5).max(zero).sqrt();
    let across = a * cos2.sqrt() * 2.0;
    let perpendicular = ratio(size + cos2, across);
    let parallel = perpendicular * ratio(cos2 * size + sin2 * sin2, across * sin2);
    (perpendicular + parallel) * 0.5
}

/// (a − b) / (a + b) for a ≥ b, never negative by rounding; 1 if both are 0, as at the horizon.
#[inline(always)]
fn ratio<R: Real>(a: R, b: R) -> R {
    let (sum, one) = (a + b, a.splat(1.0));
    R::select(sum.gt(a.splat(0.0)), ((a - b) / sum).max(a.splat(0.0)), one)
}

/// Smooth or rough metal: f = F·D·G₂ / (4 cos cos) with microfacets of [`Ggx`] (Cook, Torrance 1982).
///
/// Visible normals are sampled (Heitz 2018). Multiple scattering between microfacets is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Index of refraction of the metal.
    pub ior: ComplexIor,
    /// Roughness in \[0, 1\], as in [`Ggx::from_roughness`].
    pub roughness: f64,
}

impl Conductor {
    /// True if it is a delta lobe.
    pub fn is_smooth(&self) -> bool {
        Ggx::from_roughness(self.roughness).is_none()
    }

    /// Implements [`super::Bsdf::eval_with_pdf`]. Reflections below the surface are missing from the density.
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let Some((facets, (wo, wi))) = Ggx::from_roughness(self.roughness).zip(same_side(wo, wi)) else {
            return (Rgb::BLACK, 0.0);
        };
        let m = (wo + wi).normalize_or(DVec3::Z);
        (self.ior.fresnel(wo.dot(m)) * facets.reflection(wo, wi, m), facets.reflection_pdf(wo, m))
    }

    /// Implements [`super::Bsdf::sample`]; the weight is at most 1.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let Some(facets) = Ggx::from_roughness(self.roughness) else {
            return mirror::reflection(wo, side, self.ior.fresnel(wo.z), 1.0);
        };
        let m = facets.sample(wo, [u[1], u[2]]);
        let wi = optics::reflect(-wo, m);
        if !(wi.z > 0.0) {
            return None;
        }
        BsdfSample::new(
            side.restore(wi),
            self.ior.fresnel(wo.dot(m)) * facets.reflection(wo, wi, m),
            facets.reflection_pdf(wo, m),
        )
        .if_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: a channel of n = 1 and k = 0 was negative by rounding, and made whole samples black.
    #[test]
    fn channels_that_reflect_nothing_are_not_negative() {
        for index in 0..=10_000 {
            let cos = f64::from(index) / 10_000.0;
            let reflected = conductor_fresnel(cos, 1.0, 0.0);
            assert!((0.0..1e-7).contains(&reflected) || cos == 0.0, "{cos}: {reflected}");
        }
    }
}
