//! Microfacet distribution.

use core::f64::consts::{PI, TAU};
use rt_math::{DVec3, Float64, Vector3, transcendental};

/// Least roughness in lanes: facets of a narrower distribution multiply the rounding error of directions in `f32`.
pub(super) const MIN_LANE_ROUGHNESS: f64 = 0.1;

/// The GGX distribution (Trowbridge, Reitz 1975; Walter et al. 2007) with Smith's masking-shadowing function.
///
/// ```text
/// D(m)  = 1 / (π α² · (cos² θm + sin² θm / α²)²)          microfacets of normal m, per solid angle and area
/// S(w)  = √(cos² θ + α² sin² θ)
/// G₁(w) = 2 cos θ / (cos θ + S)                            masking
/// G₂    = 2 cos cos / (cos θo · S(wi) + cos θi · S(wo))    masking-shadowing on the same side (Heitz 2014)
/// ```
///
/// Directions are above the surface, with a positive cosine. All forms are accurate at grazing angles and for tiny α.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// α along x, at least `alpha_y`.
    alpha_x: f64,
    /// α along y, at least [`Ggx::MIN_ALPHA`].
    alpha_y: f64,
}

impl Ggx {
    /// Minimum α that does not count as smooth. Below it, lobes are narrower than a millionth of a radian, near the
    /// rounding of the half vector.
    pub const MIN_ALPHA: f64 = 1e-6;

    /// Distribution of roughness r in \[0, 1\], α = r² (Burley 2012); `None` if that is smooth, or NaN. Roughness above 1
    /// counts as 1.
    pub fn from_roughness(roughness: f64) -> Option<Self> {
        let roughness = roughness.min(1.0);
        let alpha = roughness * roughness;
        (roughness > 0.0 && alpha >= Self::MIN_ALPHA).then_some(Self { alpha_x: alpha, alpha_y: alpha })
    }

    /// Distribution of this roughness, with an α along x that grows with `anisotropy` in \[0, 1\] to 1
    /// (KHR_materials_anisotropy).
    pub fn anisotropic(roughness: f64, anisotropy: f64) -> Option<Self> {
        let even = Self::from_roughness(roughness)?;
        let strength = anisotropy.clamp(0.0, 1.0);
        Some(Self { alpha_x: even.alpha_y + (1.0 - even.alpha_y) * (strength * strength), ..even })
    }

    /// α across the tangent (`alpha_y`), the smaller of both.
    pub fn alpha(&self) -> f64 {
        self.alpha_y
    }

    /// D(m), per solid angle; 0 for normals that point down.
    pub fn d(&self, m: DVec3) -> f64 {
        if !(m.z > 0.0) {
            return 0.0;
        }
        if self.alpha_x == self.alpha_y {
            return IsotropicGgx { alpha: self.alpha_y }.d(m.into());
        }
        let alpha2 = self.alpha_y * self.alpha_y;
        let q = m.z * m.z + m.x * m.x / (self.alpha_x * self.alpha_x) + m.y * m.y / alpha2;
        1.0 / (PI * self.alpha_y * self.alpha_x * q * q)
    }

    /// S(w), the length of `w` on the surface stretched by α.
    pub fn stretched_length(&self, w: DVec3) -> f64 {
        if self.alpha_x == self.alpha_y {
            return IsotropicGgx { alpha: self.alpha_y }.stretched_length(w.into());
        }
        let alpha2 = self.alpha_y * self.alpha_y;
        (w.z * w.z + self.alpha_x * self.alpha_x * (w.x * w.x) + alpha2 * (w.y * w.y)).sqrt()
    }

    /// Density of [`Ggx::sample`] over normals: the visible normals from `wo` (Heitz 2018, equation 3).
    pub fn pdf(&self, wo: DVec3, m: DVec3) -> f64 {
        2.0 * wo.dot(m).max(0.0) * self.d(m) / (wo.z + self.stretched_length(wo))
    }

    /// Normal that is visible from `wo` (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023).
    pub fn sample(&self, wo: DVec3, u: [f64; 2]) -> DVec3 {
        visible_normal([self.alpha_x, self.alpha_y], wo.into(), transcendental::sincos(TAU * u[0]), u[1]).into()
    }

    /// D·G₂ / (4 cos cos): the BRDF of perfectly reflecting microfacets for two directions with half vector `m`.
    pub fn reflection(&self, wo: DVec3, wi: DVec3, m: DVec3) -> f64 {
        self.d(m) / (2.0 * (wo.z * self.stretched_length(wi) + wi.z * self.stretched_length(wo)))
    }

    /// Density over solid angle of reflections at normals of [`Ggx::sample`], where `m` is the half vector. The weight
    /// f · cos / pdf of perfectly reflecting microfacets is G₂/G₁, at most 1.
    pub fn reflection_pdf(&self, wo: DVec3, m: DVec3) -> f64 {
        self.d(m) / (2.0 * (wo.z + self.stretched_length(wo)))
    }
}

/// [`Ggx`] with the same α in all directions, for one number or for lanes.
#[derive(Clone, Copy)]
pub(super) struct IsotropicGgx<R: Float64> {
    pub(super) alpha: R,
}

impl<R: Float64> IsotropicGgx<R> {
    /// Version of [`Ggx::d`].
    #[inline(always)]
    pub(super) fn d(self, m: Vector3<R>) -> R {
        let (zero, one) = (m.z.splat(0.0), m.z.splat(1.0));
        let alpha2 = self.alpha * self.alpha;
        let q = m.z * m.z + (m.x * m.x + m.y * m.y) / alpha2;
        R::select(m.z.gt(zero), one / (alpha2 * PI * q * q), zero)
    }

    /// Version of [`Ggx::stretched_length`].
    #[inline(always)]
    pub(super) fn stretched_length(self, w: Vector3<R>) -> R {
        (w.z * w.z + self.alpha * self.alpha * (w.x * w.x + w.y * w.y)).sqrt()
    }

    /// Versions of [`Ggx::reflection`] and [`Ggx::reflection_pdf`], given S(wo).
    #[inline(always)]
    pub(super) fn reflection_with_pdf(self, (wo, stretched): (Vector3<R>, R), wi: Vector3<R>, m: Vector3<R>) -> (R, R) {
        let d = self.d(m);
        let reflection = d / ((wo.z * self.stretched_length(wi) + wi.z * stretched) * 2.0);
        (reflection, d / ((wo.z + stretched) * 2.0))
    }

    /// Version of [`Ggx::sample`].
    #[inline(always)]
    pub(super) fn sample(self, wo: Vector3<R>, [u, v]: [R; 2]) -> Vector3<R> {
        visible_normal([self.alpha; 2], wo, transcendental::sincos(u * TAU), v)
    }
}

/// Normal that is visible from `wo`, given α along x and y, sine and cosine of the azimuth, and a number in \[0, 1\].
#[inline(always)]
pub(super) fn visible_normal<R: Float64>(
    alpha: [R; 2],
    wo: Vector3<R>,
    (sin_phi, cos_phi): (R, R),
    u: R,
) -> Vector3<R> {
    let (zero, one) = (u.splat(0.0), u.splat(1.0));
    // The stretched surface is a hemisphere, of which the visible normals reflect to a spherical cap.
    let wo = normalize_or_up(Vector3::new(alpha[0] * wo.x, alpha[1] * wo.y, wo.z));
    let height = (one - u) * (one + wo.z);
    let z = height - wo.z;
    let sin = zero.max((one - z) * (one + z)).sqrt();
    let half = Vector3::new(sin * cos_phi + wo.x, sin * sin_phi + wo.y, height);
    normalize_or_up(Vector3::new(alpha[0] * half.x, alpha[1] * half.y, half.z))
}

/// Unit vector of the same direction; z if there is none.
#[inline(always)]
pub(super) fn normalize_or_up<R: Float64>(v: Vector3<R>) -> Vector3<R> {
    let (unit, is_valid) = v.try_normalize();
    Vector3::select(is_valid, unit, Vector3::splat(v.x, DVec3::Z))
}
