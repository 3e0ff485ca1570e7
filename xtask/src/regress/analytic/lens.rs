//! Defocus blur of a lens.

use rt_scene_io::Integrator;

use super::{
    Case, Checks, Conditions, Fallible, cases,
    closed_form::cut_disk,
    test_image::{DARK, TestImage},
};

cases! {
    "S64", "an edge at 4 m, seen by 50 mm at f/2 that are focused at 2 m",
        "a circle of confusion of 0.3205128205 mm", "5 σ", depth_of_field;
}

/// The maximum part of the circle of confusion that the footprint of the pixel takes.
const FOOTPRINT: f64 = 1e-5;

/// A pixel much smaller than its circle of confusion shows the part of the circle next to the edge. The closed form is
/// the area of a segment.
fn depth_of_field(conditions: &Conditions, checks: &mut Checks) -> Fallible<()> {
    // On film: the aperture times |z − z_f| / z times f / (z_f − f); the film lies f z_f / (z_f − f) behind the lens.
    let (focal_length, f_stop, focus, depth) = (0.05, 2.0, 2.0, 4.0);
    let confusion = focal_length / f_stop * (depth - focus) / depth * focal_length / (focus - focal_length);
    let film = focal_length * focus / (focus - focal_length);
    let fov = 2.0 * (FOOTPRINT * confusion / film / 2.0).to_degrees();
    checks.limit(confusion * 1e3 - 0.320_512_820_5, 1e-10, "the circle of confusion in mm");
    for part in [-0.6, 0.0, 0.25, 0.5, 0.9f64] {
        // Of the circle as it is at the depth of the edge.
        let edge = part * confusion / 2.0 / film * depth;
        let image = TestImage::of(&format!(
            "camera: (
                    look_from: (0, 0, 0), look_at: (0, 0, -1), fov: {fov:?},
                    lens: (focal_length: {focal_length:?}, f_stop: {f_stop:?}, focus: {focus:?}),
                ),
                {DARK},
                materials: {{\"lamp\": light(radiance: gray(1), emission_sides: both)}},
                nodes: [(
                    shape: polygon(points: [({edge:?}, -9, -{depth:?}), ({edge:?}, 9, -{depth:?}), (9, 0, -{depth:?})]),
                    material: \"lamp\",
                )],"
        ))?;
        let what = format_args!("edge at {part} of the radius");
        image.hold_by(
            &[Integrator::Distributed, Integrator::Path],
            checks,
            what,
            cut_disk(part),
            1.0,
            conditions.effort(),
        )?;
    }
    Ok(())
}
