//! Closed rooms with infinite interreflection.

use rt_math::DVec3;
use rt_scene_io::Integrator;

use super::{Case, Checks, Conditions, Fallible, area_light::tuple, cases, test_image::TestImage};

cases! {
    "S59", "a closed sphere and cubes of radiance 1 that reflect .5, .8 and .99",
        "1 / (1 − ρ) = 2, 5, 100", "5 σ", closed;
    "S60", "a closed cube that reflects .5, cut after each number of bounces",
        "(1 − ρⁿ⁺¹) / (1 − ρ), with n = depth + 1: 1.96875 for n = 5", "5 σ", truncated;
    "lit-sphere", "a diffuse sphere with a point light in its middle", "ρ / (1 − ρ) = 1 for ρ = ½", "5 σ", lit_sphere;
}

/// Path tracing, compared as radiance.
const PATH: (Integrator, f64) = (Integrator::Path, 1.0);

/// Walls, all of the material "wall".
#[derive(Clone, Copy, Debug)]
pub(super) enum Enclosure {
    /// One light.
    Sphere,
    /// One light of twelve triangles.
    Cube,
    /// Six lights that face inwards.
    Quads,
}

impl Enclosure {
    const ALL: [Self; 3] = [Self::Sphere, Self::Cube, Self::Quads];

    fn nodes(self) -> String {
        match self {
            Self::Sphere => "(shape: sphere(radius: 1), material: \"wall\")".to_owned(),
            Self::Cube => "(shape: box(min: (-1, -1, -1), max: (1, 1, 1)), material: \"wall\")".to_owned(),
            Self::Quads => {
                let axes = [DVec3::X, DVec3::Y, DVec3::Z];
                let quad = |axis: usize, side: f64| {
                    let [out, u, v] = [axes[axis] * side, axes[(axis + 1) % 3], axes[(axis + 2) % 3] * side];
                    // Clockwise seen from outside.
                    let corners = [out - u - v, out - u + v, out + u + v, out + u - v].map(tuple).join(", ");
                    format!("(shape: polygon(points: [{corners}]), material: \"wall\")")
                };
                let quads: Vec<String> = (0..6).map(|i| quad(i / 2, if i % 2 == 0 { -1.0 } else { 1.0 })).collect();
                quads.join(", ")
            }
        }
    }

    /// The room seen from within, with walls of a material.
    fn image(self, wall: &str, lights: &str, depth: u32) -> Fallible<TestImage> {
        TestImage::of(&format!(
            "camera: (look_from: (0.3, -0.2, 0.1), look_at: (-0.3, 0.4, 1), fov: 60),
                settings: (max_depth: {depth}),
                lights: [{lights}],
                background: constant(gray(0)),
                materials: {{\"wall\": {wall}}},
                nodes: [{}],",
            self.nodes()
        ))
    }

    /// The room with walls of radiance 1 that reflect a part of the light.
    pub(super) fn emissive(self, reflected: f64, depth: u32) -> Fallible<TestImage> {
        let sides = if matches!(self, Self::Quads) { "front" } else { "both" };
        let wall = format!(
            "mix([(1, diffuse(albedo: gray({reflected}))), (1, light(radiance: gray(1), emission_sides: {sides}))])"
        );
        self.image(&wall, "", depth)
    }
}

fn closed(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    for enclosure in Enclosure::ALL {
        for (reflected, spp, depth) in [(0.5, [16, 256], 100), (0.8, [16, 256], 300), (0.99, [4, 64], 4000)] {
            let effort = [conditions.count(64, 256), conditions.count(spp[0], spp[1])];
            let (what, truth) = (format!("{enclosure:?} of {reflected}"), 1.0 / (1.0 - reflected));
            enclosure.emissive(reflected, depth)?.hold(checks, what, truth, PATH, effort)?;
        }
    }
    Ok(())
}

/// The light that is sampled at the last surface adds one bounce.
fn truncated(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let effort = conditions.effort();
    let mut truth = 1.0;
    for depth in 0..=4 {
        truth = 1.0 + 0.5 * truth;
        for enclosure in [Enclosure::Cube, Enclosure::Quads] {
            let what = format!("{enclosure:?}, depth {depth}");
            enclosure.emissive(0.5, depth)?.hold(checks, what, truth, PATH, effort)?;
        }
    }
    // These two stop after one bounce of diffuse light, however deep they may go.
    let direct = [Integrator::Direct, Integrator::Distributed];
    Enclosure::Cube.emissive(0.5, 7)?.hold_by(&direct, checks, "cube", 1.5, 1.0, effort)
}

/// The intensity of a classical light counts π times: I = π.
fn lit_sphere(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let area_light = "point(position: (0, 0, 0), falloff: inverse_square)";
    for reflected in [0.5, 0.8] {
        for wall in ["phong(ambient: gray(0), diffuse", "diffuse(albedo"] {
            let image = Enclosure::Sphere.image(&format!("{wall}: gray({reflected}))"), area_light, 200)?;
            let kind = wall.split('(').next().unwrap_or_default();
            let (what, truth) = (format!("{kind} of {reflected}"), reflected / (1.0 - reflected));
            image.hold(checks, what, truth, PATH, conditions.effort())?;
        }
    }
    Ok(())
}
