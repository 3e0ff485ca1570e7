//! The part of the sky that a point of the ground sees.

use rt_camera::SamplerKind;
use rt_scene_io::Integrator;

use super::{Case, Conditions, Found, Tally, cases, estimate::hold, picture::Picture};

cases! {
    "ambient-occlusion", "open ground, beside a sphere that rests on it, in a corner of walls",
        "1; 1 − s² cos θ = 0.2844582472, 0.6464466094, 0.9105572809; 1/2", "5 σ", occlusion;
}

const SPHERE: &str = "(shape: sphere(center: (0, 0, 1), radius: 1))";
const WALL: &str = "(shape: plane(normal: (1, 0, 0)))";

fn occlusion(conditions: &Conditions) -> Found {
    let seeds = conditions.count(64, 512);
    let spp = conditions.count(64, 256) as u32;
    // The sphere is seen at s = cos θ = 1 / √(1 + d²).
    let beside = |d: f64| {
        let squared = 1.0 + d * d;
        1.0 - 1.0 / (squared * squared.sqrt())
    };
    let mut tally = Tally::default();
    for (what, beside_what, distance, truth) in [
        ("open ground", "", 0.0, 1.0),
        ("½ from the sphere", SPHERE, 0.5, beside(0.5)),
        ("1 from the sphere", SPHERE, 1.0, beside(1.0)),
        ("2 from the sphere", SPHERE, 2.0, beside(2.0)),
        ("1 from the wall", WALL, 1.0, 0.5),
        ("1e-6 from the wall", WALL, 1e-6, 0.5),
    ] {
        let picture = Picture::of(&format!(
            "(
                camera: (
                    look_from: ({distance:?}, 0, 0.05), look_at: ({distance:?}, 0, 0), orthographic: 1e-9,
                ),
                film: (size: (1, 1)),
                lights: [],
                nodes: [(shape: plane(normal: (0, 0, 1))), {beside_what}],
            )"
        ))?;
        let mean = |pattern: SamplerKind, seed| picture.mean(Integrator::AmbientOcclusion, pattern, spp, seed);
        hold(&mut tally, what, truth, seeds, mean)?;
    }
    Ok(tally)
}
