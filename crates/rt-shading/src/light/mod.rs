//! Lights: the enum [`Light`] with its whole interface, and the lights of a scene, [`LightSet`].
//!
//! ```text
//!            light                     direct light  ∫ f(ω) L(ω) |cos θ| dω  over the directions to the light,
//!           ┌─────┐
//!            ╲ Ω ╱   pdf ≈ 1/Ω         estimated by  f · L · |cos θ| / pdf   at a sampled direction
//!             ╲ ╱
//!       ───────●───────                p(ω) = p(A) · d² / |cos θ'|           from area to solid angle
//! ```
//!
//! | light | sampling | density per solid angle | source |
//! |---|---|---|---|
//! | [`DeltaLight`] | its only direction | 1 by convention | KHR_lights_punctual |
//! | [`QuadLight`] | uniform over the spherical rectangle | 1/Ω, Ω by two triangles | Ureña, Fajardo, King 2013 |
//! | [`DiskLight`] | by area | d² / (A cos θ') | Shirley, Wang, Zimmerman 1996 |
//! | [`SphereLight`] | uniform over the cone | 1 / 2π(1 − cos θ) | Shirley, Wang, Zimmerman 1996 |
//! | [`CylinderLight`] | by visible area | d² / (A cos θ') | |
//! | [`MeshLight`] | triangle by area, direction over the spherical triangle | Aᵢ/(A Ωᵢ) | Arvo 1995; Van Oosterom, Strackee 1983 |
//! | [`EnvironmentLight`] | by luminance · solid angle | P(cell) / Ω(cell) | Pharr, Jakob, Humphreys, PBR 4th ed., 12.5 |
//!
//! All quantities are in world space. Directions lead from the receiver to the light. [`Light::sample_li`] returns `None` if
//! no light arrives: behind a one-sided light, in the plane of a flat one, at NaN. Then [`Light::pdf_li`] is 0 as well.
//! Otherwise `pdf_li` is the density of `sample_li`, so that MIS can weight the two techniques (Veach, Guibas 1995).
//! A hit on the light has the [`LightPoint`]; [`Light::pdf_li_at`] needs no second intersection.
//!
//! [`LightSet`] samples one of many lights by [`PowerLightSampler`] or [`LightTree`].
//!
//! The irradiance of some lights has a closed form: [`polygon_irradiance`], [`sphere_irradiance`], [`disk_irradiance`].
//!
//! **A new kind of light** is a file of this folder and a variant of [`Light`] below. A new delta light is a variant of
//! [`DeltaLightKind`] only, in `delta.rs`.
//!
//! ```
//! use rt_math::{DVec3, Rgb};
//! use rt_shading::light::{DiskLight, Emission, EmissionSides, Light};
//!
//! // A disk of radius 1 above a floor, facing down: its irradiance is π R² / (R² + h²).
//! let emission = Emission::new(Rgb::WHITE, EmissionSides::Front)?;
//! let light = Light::Disk(DiskLight::new(DVec3::new(0.0, 0.0, 2.0), DVec3::NEG_Z, 1.0, 0.0, emission)?);
//! let (point, normal, n) = (DVec3::ZERO, DVec3::Z, 64);
//! let mut irradiance = 0.0;
//! for i in 0..n * n {
//!     let u = [i % n, i / n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
//!     if let Some(sample) = light.sample_li(point, u) {
//!         irradiance += sample.radiance.g * sample.direction.dot(normal) / sample.pdf / f64::from(n * n);
//!     }
//! }
//! assert!((irradiance - std::f64::consts::PI / 5.0).abs() < 1e-4);
//! # Ok::<(), rt_shading::light::LightError>(())
//! ```

mod closed_form;
mod cylinder;
pub(crate) mod delta;
mod disk;
mod emission;
mod environment;
mod light_bounds;
mod light_error;
mod light_sample;
mod light_set;
mod light_tree;
mod mesh;
mod piecewise_constant;
mod power_sampler;
mod quad;
pub(crate) mod solid_angle;
mod sphere;
#[cfg(test)]
mod test_estimate;
#[cfg(test)]
mod tests;

pub use closed_form::{disk_irradiance, polygon_irradiance, sphere_irradiance};
pub use cylinder::CylinderLight;
pub(crate) use delta::DeltaLiLanes;
pub use delta::{DeltaLiSample, DeltaLight, DeltaLightKind, Falloff, LightUnits, SpotCone};
pub use disk::DiskLight;
pub use emission::{Emission, EmissionSides};
pub use environment::EnvironmentLight;
pub use light_bounds::{LightBounds, LightExtent};
pub use light_error::LightError;
pub use light_sample::{LightLiSample, LightPoint, LightPointSample, LightSample};
pub use light_set::{LightId, LightSampling, LightSet};
pub use light_tree::LightTree;
pub use mesh::MeshLight;
pub use power_sampler::{PowerLightSampler, SampledLight};
pub use quad::QuadLight;
pub use sphere::SphereLight;

use rt_math::{DVec3, Rgb};

/// Light of any kind. Names of methods are those of pbrt-v4.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Point, spot or directional light.
    Delta(DeltaLight),
    /// Area light: a rectangle or parallelogram.
    Quad(QuadLight),
    /// Area light: a disk or ring.
    Disk(DiskLight),
    /// Area light: a sphere.
    Sphere(SphereLight),
    /// Area light: a cylinder with or without caps.
    Cylinder(CylinderLight),
    /// Area light: triangles.
    Mesh(MeshLight),
    /// Image around the scene.
    Environment(EnvironmentLight),
}

impl Light {
    /// True if rays never hit the light: its direction or position is a Dirac delta distribution.
    pub const fn is_delta(&self) -> bool {
        matches!(self, Self::Delta(_))
    }

    /// True for light from infinitely far away in all directions.
    pub const fn is_environment(&self) -> bool {
        matches!(self, Self::Environment(_))
    }

    /// The delta light, if it is one.
    pub const fn as_delta(&self) -> Option<&DeltaLight> {
        match self {
            Self::Delta(light) => Some(light),
            _ => None,
        }
    }

    /// Emission of an area light.
    const fn emission(&self) -> Option<&Emission> {
        match self {
            Self::Delta(_) | Self::Environment(_) => None,
            Self::Quad(light) => Some(light.emission()),
            Self::Disk(light) => Some(light.emission()),
            Self::Sphere(light) => Some(light.emission()),
            Self::Cylinder(light) => Some(light.emission()),
            Self::Mesh(light) => Some(light.emission()),
        }
    }

    /// Area of one side of an area light; 0 of others.
    fn area(&self) -> f64 {
        match self {
            Self::Delta(_) | Self::Environment(_) => 0.0,
            Self::Quad(light) => light.area(),
            Self::Disk(light) => light.area(),
            Self::Sphere(light) => light.area(),
            Self::Cylinder(light) => light.area(),
            Self::Mesh(light) => light.area(),
        }
    }

    /// Samples a direction towards the light from `point`, by two numbers in `[0, 1)`. `None` if no light arrives.
    ///
    /// Delta lights ignore `u`. Their samples contain the irradiance for a BSDF, with the density 1.
    pub fn sample_li(&self, point: DVec3, u: [f64; 2]) -> Option<LightLiSample> {
        match self {
            Self::Delta(light) => light.sample_irradiance(point),
            Self::Quad(light) => light.sample_li(point, u),
            Self::Disk(light) => light.sample_li(point, u),
            Self::Sphere(light) => light.sample_li(point, u),
            Self::Cylinder(light) => light.sample_li(point, u),
            Self::Mesh(light) => light.sample_li(point, u),
            Self::Environment(light) => light.sample_li(u),
        }
    }

    /// Density, per unit solid angle, with which [`sample_li`](Self::sample_li) samples the first point of the light in this
    /// direction. 0 for a direction that misses the light, and for delta lights.
    pub fn pdf_li(&self, point: DVec3, direction: DVec3) -> f64 {
        match self {
            Self::Environment(light) => light.pdf_li(direction),
            _ => self.intersect(point, direction).map_or(0.0, |at| self.pdf_li_at(point, &at)),
        }
    }

    /// Version of [`pdf_li`](Self::pdf_li) for a point on the light that a ray from `point` has hit. For an environment,
    /// `at.point` is any point in the direction.
    pub fn pdf_li_at(&self, point: DVec3, at: &LightPoint) -> f64 {
        match self {
            Self::Delta(_) => 0.0,
            Self::Quad(light) => light.pdf_li_at(point, at.point),
            Self::Disk(light) => light.pdf_li_at(point, at.point),
            Self::Sphere(light) => light.pdf_li_at(point),
            Self::Cylinder(light) => light.pdf_li_at(point, at.point, at.normal),
            Self::Mesh(light) => light.pdf_li_at(point, at.point, at.triangle),
            Self::Environment(light) => light.pdf_li(at.point - point),
        }
    }

    /// First hit of a ray from `point` with the light. `None` for a miss, an environment, and delta lights.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<LightPoint> {
        match self {
            Self::Delta(_) | Self::Environment(_) => None,
            Self::Quad(light) => light.intersect(point, direction),
            Self::Disk(light) => light.intersect(point, direction),
            Self::Sphere(light) => light.intersect(point, direction),
            Self::Cylinder(light) => light.intersect(point, direction),
            Self::Mesh(light) => light.intersect(point, direction),
        }
    }

    /// Radiance (pbrt: L of area lights, Le of infinite ones) against the viewing `direction`, of any length. `normal` faces
    /// the front at the point of an area light; environments ignore it. Black for delta lights.
    pub fn le(&self, direction: DVec3, normal: DVec3) -> Rgb {
        match self {
            Self::Environment(light) => light.le(direction),
            _ => self.emission().map_or(Rgb::BLACK, |emission| emission.emitted(direction.dot(normal))),
        }
    }

    /// Samples a point from which light leaves, uniformly over the emissive area, by two numbers and one that selects the
    /// side, all in `[0, 1)`. `None` if the light is black.
    ///
    /// Light tracing starts paths of environments nowhere, and those of delta lights from their set of rays: `None` for both.
    pub fn sample_point(&self, u: [f64; 2], side: f64) -> Option<LightPointSample> {
        let at = match self {
            Self::Delta(_) | Self::Environment(_) => return None,
            Self::Quad(light) => light.sample_area(u),
            Self::Disk(light) => light.sample_area(u),
            Self::Sphere(light) => light.sample_area(u),
            Self::Cylinder(light) => light.sample_area(u),
            Self::Mesh(light) => light.sample_area(u)?,
        };
        let extent = self.bounds()?.around().extent().max_element();
        LightPointSample::of_surface(&at, self.emission()?, side, self.area(), extent)
    }

    /// Power (pbrt: Φ). Light from infinitely far away counts if it enters a bounding sphere of radius `scene_radius`;
    /// other lights ignore it.
    pub fn power(&self, scene_radius: f64) -> Rgb {
        match self {
            Self::Delta(light) => light.power(scene_radius),
            Self::Environment(light) => light.power(scene_radius),
            _ => self.emission().map_or(Rgb::BLACK, |emission| emission.power(self.area())),
        }
    }

    /// Bounds of positions and directions; `None` for an environment and directional light.
    pub fn bounds(&self) -> Option<LightBounds> {
        match self {
            Self::Delta(light) => light.bounds(),
            Self::Quad(light) => Some(light.bounds()),
            Self::Disk(light) => Some(light.bounds()),
            Self::Sphere(light) => Some(light.bounds()),
            Self::Cylinder(light) => light.bounds(),
            Self::Mesh(light) => light.bounds(),
            Self::Environment(_) => None,
        }
    }

    /// Extent for a [`LightTree`].
    pub fn extent(&self) -> LightExtent {
        if self.power(1.0).is_black() {
            return LightExtent::Black;
        }
        self.bounds().map_or(LightExtent::Unbounded, LightExtent::Bounded)
    }
}
