//! Where paths begin that start at a light.

use super::{Emission, Emitter, EmitterPoint, Sides};
use rt_geometry::SurfaceInteraction;
use rt_math::float::gamma;
use rt_math::{DVec3, Rgb};

/// A point of a light from which light is followed.
///
/// Its power through a small area and solid angle is `radiance · cos θ · dA · dω`, θ from `normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterLeSample {
    /// The point, with a normal on the side that shines, to start rays from; world space.
    pub surface: SurfaceInteraction,
    /// Radiance that leaves in all directions.
    pub radiance: Rgb,
    /// Density of the point per unit area, of both sides if both shine.
    pub pdf: f64,
}

impl Emitter {
    /// A point from which light leaves, uniform over the area that shines, from two numbers and one that chooses the side,
    /// all in `[0, 1)`. `None` for an environment, which has none, and for a light that is black.
    pub fn sample_le(&self, u: [f64; 2], side: f64) -> Option<EmitterLeSample> {
        let (at, area, emission) = match self {
            Self::Quad(light) => (light.sample_area(u), light.area(), light.emission()),
            Self::Disk(light) => (light.sample_area(u), light.area(), light.emission()),
            Self::Sphere(light) => (light.sample_area(u), light.area(), light.emission()),
            Self::Cylinder(light) => (light.sample_area(u), light.area(), light.emission()),
            Self::Mesh(light) => (light.sample_area(u)?, light.area(), light.emission()),
            Self::Environment(_) => return None,
        };
        let extent = self.bounds()?.around().extent().max_element();
        (!emission.radiance().is_black()).then(|| departure(&at, emission, side, area, extent))
    }
}

fn departure(at: &EmitterPoint, emission: &Emission, side: f64, area: f64, extent: f64) -> EmitterLeSample {
    let is_behind = emission.sides() == Sides::Both && side >= 0.5;
    let sides = if emission.sides() == Sides::Both { 2.0 } else { 1.0 };
    let normal = if is_behind { -at.normal } else { at.normal };
    let point_error = (at.point.abs() + DVec3::splat(extent)) * gamma(16);
    let surface = SurfaceInteraction::flat(at.point, point_error, normal, [0.0; 2]);
    EmitterLeSample { surface, radiance: emission.radiance(), pdf: 1.0 / (sides * area) }
}

#[cfg(test)]
mod tests {
    use super::super::test_estimate::white;
    use super::super::{CylinderLight, DiskLight, EnvironmentLight, MeshLight, QuadLight, SphereLight};
    use super::*;
    use rt_math::random::{hash, unit};
    use std::f64::consts::PI;

    fn lights(sides: Sides) -> Vec<Emitter> {
        let (white, centre) = (white(sides), DVec3::new(0.3, -1.0, 2.0));
        let triangles = [[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::X, DVec3::new(3.0, 0.0, 1.0), DVec3::Y]];
        vec![
            Emitter::Quad(QuadLight::new(centre, [DVec3::X * 2.0, DVec3::new(0.5, 1.0, 0.0)], white).expect("a light")),
            Emitter::Disk(DiskLight::new(centre, DVec3::new(1.0, 1.0, 0.3), 0.7, 0.2, white).expect("a light")),
            Emitter::Sphere(SphereLight::new(centre, 0.6, white).expect("a light")),
            Emitter::Cylinder(CylinderLight::new(centre, DVec3::Y, 0.4, true, white).expect("a light")),
            Emitter::Cylinder(CylinderLight::new(centre, DVec3::Y, 0.4, false, white).expect("a light")),
            Emitter::Mesh(MeshLight::new(triangles, white).expect("a light")),
        ]
    }

    fn numbers() -> impl Iterator<Item = [f64; 3]> {
        (0..4000).map(|i| [0, 1, 2].map(|dimension| unit(hash(&[11, i, dimension]))))
    }

    #[test]
    fn the_power_that_leaves_is_that_of_the_light() {
        for sides in [Sides::Front, Sides::Both] {
            for light in lights(sides) {
                let departs: Vec<_> = numbers().filter_map(|[u, v, side]| light.sample_le([u, v], side)).collect();
                let power = departs.iter().map(|from| PI * from.radiance.r / from.pdf).sum::<f64>() / 4000.0;
                assert!((power / light.power(1.0).r - 1.0).abs() < 1e-12, "{power} from {light:?}");
                let fronts = departs.iter().filter(|from| is_front(&light, from)).count();
                let expected = if sides == Sides::Both { 1850..2150 } else { 4000..4001 };
                assert!(expected.contains(&fronts), "{fronts} of 4000 from the front of {light:?}");
            }
        }
    }

    /// A ray that comes towards the point meets the light there, and sees the side that shines.
    fn is_front(light: &Emitter, from: &EmitterLeSample) -> bool {
        let EmitterLeSample { surface, .. } = from;
        let outside = surface.point + surface.geometric_normal * 1e-3;
        let at = light.intersect(outside, -surface.geometric_normal).expect("the point is on the light");
        assert!((at.point - surface.point).length() < 1e-9, "{light:?}");
        assert_eq!(light.radiance(-surface.geometric_normal, at.normal), Rgb::WHITE);
        at.normal.dot(surface.geometric_normal) > 0.0
    }

    /// Points are uniform by area: their mean and spread along an axis are those of the surface.
    #[test]
    fn points_are_uniform_over_the_surface() {
        let closed = CylinderLight::new(DVec3::ZERO, DVec3::Z * 3.0, 1.0, true, white(Sides::Front)).expect("a light");
        let ball = SphereLight::new(DVec3::ZERO, 2.0, white(Sides::Front)).expect("a light");
        let part = |light: &Emitter, is_in: &dyn Fn(DVec3) -> bool| {
            let points = numbers().filter_map(|[u, v, side]| light.sample_le([u, v], side));
            points.filter(|from| is_in(from.surface.point)).count() as f64 / 4000.0
        };
        // A cap is π of 8π; of a ball each slice of equal height is the same part.
        let caps = part(&Emitter::Cylinder(closed), &|point| point.z == 3.0);
        let slice = part(&Emitter::Sphere(ball), &|point| point.z.abs() < 0.5);
        assert!((caps - 0.125).abs() < 0.025 && (slice - 0.25).abs() < 0.03, "{caps}, {slice}");
    }

    #[test]
    fn nothing_leaves_an_environment_or_a_black_light() {
        let black = Emission::new(Rgb::BLACK, Sides::Both).expect("black");
        let ball = SphereLight::new(DVec3::ZERO, 2.0, black).expect("a light");
        assert_eq!(Emitter::Sphere(ball).sample_le([0.5; 2], 0.5), None);
        let sky = EnvironmentLight::constant(Rgb::WHITE).expect("a light");
        assert_eq!(Emitter::Environment(sky).sample_le([0.5; 2], 0.5), None);
    }
}
