//! Lights with extent, as one point of the scene sees them.
//!
//! ```text
//!            light                     direct light  ∫ f(ω) L(ω) |cos θ| dω  over the directions to the light,
//!           ┌─────┐
//!            ╲ Ω ╱   pdf ≈ 1/Ω         estimated by  f · L · |cos θ| / pdf   at a direction drawn from it
//!             ╲ ╱
//!       ───────●───────                p(ω) = p(A) · d² / |cos θ'|           what is drawn by area, by solid angle
//! ```
//!
//! | light | drawn | density per solid angle | after |
//! |---|---|---|---|
//! | [`QuadLight`] | uniform over the spherical rectangle | 1/Ω, Ω by two triangles | Ureña, Fajardo, King 2013 |
//! | [`DiskLight`] | by area | d² / (A cos θ') | Shirley, Wang, Zimmerman 1996 |
//! | [`SphereLight`] | uniform over the cone | 1 / 2π(1 − cos θ) | Shirley, Wang, Zimmerman 1996 |
//! | [`CylinderLight`] | by the area that is seen | d² / (A cos θ') | |
//! | [`MeshLight`] | a triangle by its area, a direction over the spherical triangle | Aᵢ/(A Ωᵢ) | Arvo 1995; Van Oosterom, Strackee 1983 |
//! | [`EnvironmentLight`] | by luminance · solid angle | P(cell) / Ω(cell) | Pharr, Jakob, Humphreys, PBR 4th ed., 12.5 |
//!
//! Which of many lights is drawn from at all is said by [`PowerChoice`] or [`LightTree`]; an [`EmitterSet`] holds all lights of a
//! scene and the choice.
//!
//! All is in world space. Directions lead from the point that looks to the light. `sample` gives `None` where the light
//! gives nothing: behind a one-sided one, in the plane of a flat one, at numbers that are NaN. Then `pdf` is 0 as well.
//! Otherwise `pdf` is the density with which `sample` draws, so that the two can be weighted against other ways to find the
//! same direction (Veach, Guibas 1995). A ray that hit the light knows the [`EmitterPoint`]; [`Emitter::pdf_at`] needs no
//! second intersection.
//!
//! Of some lights the irradiance has a closed form: [`polygon_irradiance`], [`sphere_irradiance`], [`disk_irradiance`].
//!
//! ```
//! use rt_math::{DVec3, Rgb};
//! use rt_shading::emitter::{DiskLight, Emission, Emitter, Sides};
//!
//! // A disk of radius 1 above a floor, facing down: its irradiance is π R² / (R² + h²).
//! let emission = Emission::new(Rgb::WHITE, Sides::Front)?;
//! let light = Emitter::Disk(DiskLight::new(DVec3::new(0.0, 0.0, 2.0), DVec3::NEG_Z, 1.0, 0.0, emission)?);
//! let (point, normal, n) = (DVec3::ZERO, DVec3::Z, 64);
//! let mut irradiance = 0.0;
//! for i in 0..n * n {
//!     let u = [i % n, i / n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
//!     if let Some(sample) = light.sample(point, u) {
//!         irradiance += sample.radiance.g * sample.direction.dot(normal) / sample.pdf / f64::from(n * n);
//!     }
//! }
//! assert!((irradiance - std::f64::consts::PI / 5.0).abs() < 1e-4);
//! # Ok::<(), rt_shading::emitter::EmitterError>(())
//! ```

mod bounds;
mod choice;
mod closed_form;
mod cylinder;
mod disk;
mod emission;
mod environment;
mod le_sample;
mod light_tree;
mod mesh;
mod piecewise_constant;
mod quad;
mod sample;
mod set;
pub(crate) mod solid_angle;
mod sphere;
#[cfg(test)]
mod test_estimate;
#[cfg(test)]
mod tests;

pub use bounds::EmitterBounds;
pub use choice::{Choice, PowerChoice};
pub use closed_form::{disk_irradiance, polygon_irradiance, sphere_irradiance};
pub use cylinder::CylinderLight;
pub use disk::DiskLight;
pub use emission::{Emission, EmitterError, Sides};
pub use environment::EnvironmentLight;
pub use le_sample::EmitterLeSample;
pub use light_tree::LightTree;
pub use mesh::MeshLight;
pub use quad::QuadLight;
pub use sample::{EmitterPoint, EmitterSample};
pub use set::{EmitterRef, EmitterSet, LightSample, LightSampling};
pub use sphere::SphereLight;

use rt_math::{DVec3, Rgb};

/// A light with extent. All methods do what those of the variants do.
#[derive(Clone, Debug, PartialEq)]
pub enum Emitter {
    /// A rectangle or parallelogram.
    Quad(QuadLight),
    /// A disk or ring.
    Disk(DiskLight),
    /// A sphere.
    Sphere(SphereLight),
    /// A tube, open or closed.
    Cylinder(CylinderLight),
    /// Triangles.
    Mesh(MeshLight),
    /// An image around the scene.
    Environment(EnvironmentLight),
}

impl Emitter {
    /// A direction towards the light from `point`, for two numbers in `[0, 1)`. `None` where the light gives nothing.
    pub fn sample(&self, point: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        match self {
            Self::Quad(light) => light.sample(point, u),
            Self::Disk(light) => light.sample(point, u),
            Self::Sphere(light) => light.sample(point, u),
            Self::Cylinder(light) => light.sample(point, u),
            Self::Mesh(light) => light.sample(point, u),
            Self::Environment(light) => light.sample(u),
        }
    }

    /// Density, per unit solid angle, with which [`sample`](Self::sample) takes the point of the light that is met first in
    /// this direction; 0 if none is.
    pub fn pdf(&self, point: DVec3, direction: DVec3) -> f64 {
        match self {
            Self::Quad(light) => light.pdf(point, direction),
            Self::Disk(light) => light.pdf(point, direction),
            Self::Sphere(light) => light.pdf(point, direction),
            Self::Cylinder(light) => light.pdf(point, direction),
            Self::Mesh(light) => light.pdf(point, direction),
            Self::Environment(light) => light.pdf(direction),
        }
    }

    /// The same for a point on the light, as a ray from `point` has met it. For an environment, `at.point` is any point in
    /// the direction that is asked for.
    pub fn pdf_at(&self, point: DVec3, at: &EmitterPoint) -> f64 {
        match self {
            Self::Quad(light) => light.pdf_at(point, at.point),
            Self::Disk(light) => light.pdf_at(point, at.point),
            Self::Sphere(light) => light.pdf_at(point),
            Self::Cylinder(light) => light.pdf_at(point, at.point, at.normal),
            Self::Mesh(light) => light.pdf_at(point, at.point, at.triangle),
            Self::Environment(light) => light.pdf(at.point - point),
        }
    }

    /// Where a ray from `point` meets the light first; `None` for one that passes by, and for an environment.
    pub fn intersect(&self, point: DVec3, direction: DVec3) -> Option<EmitterPoint> {
        match self {
            Self::Quad(light) => light.intersect(point, direction),
            Self::Disk(light) => light.intersect(point, direction),
            Self::Sphere(light) => light.intersect(point, direction),
            Self::Cylinder(light) => light.intersect(point, direction),
            Self::Mesh(light) => light.intersect(point, direction),
            Self::Environment(_) => None,
        }
    }

    /// Radiance that is seen by looking along `direction` (of any length) at a point of the light whose front faces along
    /// `normal`, which does not matter to an environment.
    pub fn radiance(&self, direction: DVec3, normal: DVec3) -> Rgb {
        match self {
            Self::Quad(light) => light.radiance(direction, normal),
            Self::Disk(light) => light.radiance(direction, normal),
            Self::Sphere(light) => light.radiance(direction, normal),
            Self::Cylinder(light) => light.radiance(direction, normal),
            Self::Mesh(light) => light.radiance(direction, normal),
            Self::Environment(light) => light.radiance(direction),
        }
    }

    /// Power of the light. Of an environment it is what enters a scene within a ball of `scene_radius`, which does not
    /// matter to others.
    pub fn power(&self, scene_radius: f64) -> Rgb {
        match self {
            Self::Quad(light) => light.power(),
            Self::Disk(light) => light.power(),
            Self::Sphere(light) => light.power(),
            Self::Cylinder(light) => light.power(),
            Self::Mesh(light) => light.power(),
            Self::Environment(light) => light.power(scene_radius),
        }
    }

    /// Where the light is and where it shines; `None` for an environment.
    pub fn bounds(&self) -> Option<EmitterBounds> {
        match self {
            Self::Quad(light) => Some(light.bounds()),
            Self::Disk(light) => Some(light.bounds()),
            Self::Sphere(light) => Some(light.bounds()),
            Self::Cylinder(light) => light.bounds(),
            Self::Mesh(light) => light.bounds(),
            Self::Environment(_) => None,
        }
    }
}
