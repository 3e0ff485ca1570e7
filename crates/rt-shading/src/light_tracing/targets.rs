//! Where light is sent: to what mirrors or refracts sharply, and not past it.

use crate::light::solid_angle::uniform_sphere;
use core::f64::consts::{PI, TAU};
use rt_math::{DVec3, Frame, transcendental::sincos};

/// Most balls that are told apart: the density of a direction takes a look at all of them.
const MOST: usize = 16;

/// A ball around something that light is to be sent to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// World space.
    pub centre: DVec3,
    /// World units.
    pub radius: f64,
}

/// The surfaces that light paths begin at, as balls around them: the projection map of Jensen (2001), in closed form.
///
/// A direction is drawn uniformly from the cones in which a point sees the balls, a ball by its solid angle Ω:
///
/// ```text
///   p(ω) = (number of balls that ω leads to) / Σ Ω
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Targets {
    balls: Vec<Ball>,
    is_everywhere: bool,
}

/// A choice and the density of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DirectionSample<T> {
    pub(super) at: T,
    pub(super) pdf: f64,
}

impl Targets {
    /// Everywhere: some of the surfaces have no bounds.
    pub const EVERYWHERE: Self = Self { balls: Vec::new(), is_everywhere: true };

    /// Balls around all of the surfaces; of more than sixteen the smallest ball around them that has its centre in the middle
    /// of theirs. Those that are not finite are everywhere.
    pub fn new(balls: Vec<Ball>) -> Self {
        if !balls.iter().all(|ball| ball.centre.is_finite() && ball.radius.is_finite()) {
            return Self::EVERYWHERE;
        }
        if balls.len() <= MOST {
            return Self { balls, is_everywhere: false };
        }
        let reach = |ball: &Ball| [ball.centre - ball.radius, ball.centre + ball.radius];
        let around = rt_math::Aabb::from_points(balls.iter().flat_map(reach));
        let centre = around.centre();
        let radius = balls.iter().map(|ball| (ball.centre - centre).length() + ball.radius).fold(0.0, f64::max);
        Self { balls: vec![Ball { centre, radius }], is_everywhere: false }
    }

    /// True if there is nothing to send light to.
    pub fn is_empty(&self) -> bool {
        self.balls.is_empty() && !self.is_everywhere
    }

    /// True if light is sent in all directions.
    pub const fn is_everywhere(&self) -> bool {
        self.is_everywhere
    }

    /// The number of balls.
    pub fn len(&self) -> usize {
        self.balls.len()
    }

    /// The area that all balls take of parallel light.
    pub(super) fn area(&self) -> f64 {
        self.balls.iter().map(|ball| PI * ball.radius * ball.radius).sum()
    }

    /// A direction from a point, with its density over solid angle. `None` within a ball, where all directions lead to it, and
    /// if there are none.
    pub(super) fn sample_direction(&self, point: DVec3, choice: f64, u: [f64; 2]) -> Option<DirectionSample<DVec3>> {
        if self.is_everywhere || self.balls.iter().any(|ball| ball.one_minus_cos(point).is_none()) {
            return None;
        }
        let width = |ball: &Ball| ball.one_minus_cos(point).unwrap_or(0.0);
        let total: f64 = self.balls.iter().map(width).sum();
        let ball = chosen(&self.balls, choice * total, width)?;
        let direction = within_cone((ball.centre - point).try_normalize()?, width(ball), u);
        let leads_to = |ball: &&Ball| ball.is_met(point, direction);
        // The ball that was chosen is met, whatever rounding says.
        let met = self.balls.iter().filter(leads_to).count().max(1);
        Some(DirectionSample { at: direction, pdf: met as f64 / (TAU * total) })
    }

    /// A point that parallel light in a unit direction goes through on its way to a ball, with its density over the area across
    /// the light. `None` if there are none, or they are everywhere.
    pub(super) fn sample_disk(&self, direction: DVec3, choice: f64, u: [f64; 2]) -> Option<DirectionSample<DVec3>> {
        let squared = |ball: &Ball| ball.radius * ball.radius;
        let total: f64 = self.balls.iter().map(squared).sum();
        let ball = chosen(&self.balls, choice * total, squared)?;
        let frame = Frame::from_z(direction);
        let (sin, cos) = sincos(TAU * u[1]);
        let point = ball.centre + (frame.x * cos + frame.y * sin) * (ball.radius * u[0].sqrt());
        let met =
            self.balls.iter().filter(|ball| (ball.centre - point).cross(direction).length() <= ball.radius).count();
        Some(DirectionSample { at: point, pdf: met.max(1) as f64 / (PI * total) })
    }
}

impl Ball {
    /// One less the cosine of half the angle in which the ball is seen; `None` from within.
    fn one_minus_cos(&self, point: DVec3) -> Option<f64> {
        let distance = (self.centre - point).length();
        let sin = self.radius / distance;
        let cos = ((distance - self.radius) / distance * (1.0 + sin)).sqrt();
        (distance > self.radius).then(|| sin * sin / (1.0 + cos))
    }

    fn is_met(&self, point: DVec3, direction: DVec3) -> bool {
        let offset = self.centre - point;
        offset.dot(direction) > 0.0 && offset.cross(direction).length() <= self.radius
    }
}

/// The ball whose part of the sum of all widths `at` lies in, or the last.
fn chosen(balls: &[Ball], at: f64, width: impl Fn(&Ball) -> f64) -> Option<&Ball> {
    let mut rest = at;
    balls
        .iter()
        .find(|ball| {
            rest -= width(ball);
            rest < 0.0
        })
        .or(balls.last())
}

/// A direction uniform over the cone around a unit axis, given one less the cosine of half its angle.
pub(super) fn within_cone(axis: DVec3, one_minus_cos: f64, u: [f64; 2]) -> DVec3 {
    if one_minus_cos >= 2.0 {
        return uniform_sphere(u);
    }
    let below = u[0] * one_minus_cos;
    let sin = (below * (2.0 - below)).sqrt();
    let (sin_phi, cos_phi) = sincos(TAU * u[1]);
    Frame::from_z(axis).from_local(DVec3::new(sin * cos_phi, sin * sin_phi, 1.0 - below))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};

    fn balls() -> Targets {
        let ball = |x: f64, radius: f64| Ball { centre: DVec3::new(x, 0.0, 0.0), radius };
        Targets::new(vec![ball(4.0, 1.0), ball(5.0, 1.5), ball(-9.0, 0.5)])
    }

    fn numbers(count: u64) -> impl Iterator<Item = [f64; 3]> {
        (0..count).map(|i| [0, 1, 2].map(|dimension| unit(hash(&[i, dimension]))))
    }

    /// The mean of 1 / p over samples is the measure of what is sampled: here of two cones, one of which lies in the other, and
    /// a third.
    #[test]
    fn directions_have_the_density_that_is_said() {
        let (targets, point) = (balls(), DVec3::new(0.0, 0.3, 0.0));
        let aims: Vec<_> = numbers(20_000).filter_map(|[c, u, v]| targets.sample_direction(point, c, [u, v])).collect();
        let mean = aims.iter().map(|sample| 1.0 / sample.pdf).sum::<f64>() / aims.len() as f64;
        let inside = numbers(400_000).filter(|[_, u, v]| {
            let direction = uniform_sphere([*u, *v]);
            targets.balls.iter().any(|ball| ball.is_met(point, direction))
        });
        let truth = 4.0 * PI * inside.count() as f64 / 400_000.0;
        assert_eq!(aims.len(), 20_000);
        assert!((mean / truth - 1.0).abs() < 0.02, "{mean} is not {truth}");
    }

    #[test]
    fn parallel_light_covers_what_stands_in_it() {
        let targets = balls();
        let direction = DVec3::NEG_Z;
        let aims: Vec<_> = numbers(20_000).filter_map(|[c, u, v]| targets.sample_disk(direction, c, [u, v])).collect();
        let mean = aims.iter().map(|sample| 1.0 / sample.pdf).sum::<f64>() / aims.len() as f64;
        // The union of two circles of radius 1 and 1.5 at the distance 1, and one of radius 0.5: by quadrature.
        let side = 2000;
        let cell = 24.0 / f64::from(side);
        let covered = |i: i32| {
            let at =
                DVec3::new((f64::from(i % side) + 0.5) * cell - 12.0, (f64::from(i / side) + 0.5) * cell - 12.0, 0.0);
            targets.balls.iter().any(|ball| (ball.centre - at).length() <= ball.radius)
        };
        let truth = (0..side * side).filter(|i| covered(*i)).count() as f64 * cell * cell;
        assert!((mean / truth - 1.0).abs() < 0.01, "{mean} is not {truth}");
    }

    #[test]
    fn from_within_and_to_everywhere_no_direction_is_better_than_others() {
        assert_eq!(balls().sample_direction(DVec3::X * 4.5, 0.5, [0.5; 2]), None);
        assert_eq!(Targets::EVERYWHERE.sample_direction(DVec3::ZERO, 0.5, [0.5; 2]), None);
        assert!(Targets::new(vec![Ball { centre: DVec3::ZERO, radius: f64::INFINITY }]).is_everywhere());
        assert!(Targets::new(vec![]).is_empty() && !balls().is_empty());
    }

    #[test]
    fn many_balls_become_one_around_them() {
        let many: Vec<_> = (0..40).map(|i| Ball { centre: DVec3::X * f64::from(i), radius: 0.5 }).collect();
        assert_eq!(Targets::new(many).balls, [Ball { centre: DVec3::X * 19.5, radius: 20.0 }]);
    }
}
