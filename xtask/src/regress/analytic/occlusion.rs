//! Visible part of the sky from a point of the ground.

use rt_scene_io::Integrator;

use super::{Case, Checks, Conditions, Fallible, cases, test_image::TestImage};

cases! {
    "ambient-occlusion", "open ground, beside a sphere that rests on it, in a corner of walls",
        "1; 1 − s² cos θ = 0.2844582472, 0.6464466094, 0.9105572809; 1/2", "5 σ", occlusion;
}

const SPHERE: &str = "(shape: sphere(center: (0, 0, 1), radius: 1))";
const WALL: &str = "(shape: plane(normal: (1, 0, 0)))";

fn occlusion(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    let effort = [conditions.count(64, 512), conditions.count(64, 256)];
    // The sphere is seen at s = cos θ = 1 / √(1 + d²).
    let next_to_sphere = |d: f64| {
        let squared = 1.0 + d * d;
        1.0 - 1.0 / (squared * squared.sqrt())
    };
    for (what, next_to_wall, distance, truth) in [
        ("open ground", "", 0.0, 1.0),
        ("½ from the sphere", SPHERE, 0.5, next_to_sphere(0.5)),
        ("1 from the sphere", SPHERE, 1.0, next_to_sphere(1.0)),
        ("2 from the sphere", SPHERE, 2.0, next_to_sphere(2.0)),
        ("1 from the wall", WALL, 1.0, 0.5),
        ("1e-6 from the wall", WALL, 1e-6, 0.5),
    ] {
        let image = TestImage::of(&format!(
            "camera: (
                    look_from: ({distance:?}, 0, 0.05), look_at: ({distance:?}, 0, 0), orthographic: 1e-9,
                ),
                lights: [],
                nodes: [(shape: plane(normal: (0, 0, 1))), {next_to_wall}],"
        ))?;
        image.hold(checks, what, truth, (Integrator::AmbientOcclusion, 1.0), effort)?;
    }
    Ok(())
}
