//! Scene files as text.

use std::fmt::Write;

use rt_geometry::Spheres;
use rt_math::DVec3;

use super::{
    still_life::SPHERES,
    wires::{Wire, Wires},
};
use crate::scenes::Scene;

/// Colours from the whole to its smallest parts; what is deeper keeps the last.
const COLOURS: [&str; 6] = [
    "rgb(0.02, 0.02, 0.03)",
    "rgb(0.01, 0.08, 0.6)",
    "rgb(0, 0.35, 0.3)",
    "rgb(0.75, 0.3, 0)",
    "rgb(0.75, 0.01, 0.02)",
    "rgb(0.5, 0, 0.5)",
];
/// Half the thickness of the outermost lines. Deeper ones are thinner, to be distinct where they meet.
const HALF: f64 = 0.045;

/// The still life, with lines around parts of it.
pub(super) fn of_wires(wires: &Wires) -> String {
    let mut text = String::from(
        "// The parts of an accelerator.\n(\n    camera: (look_from: (0.3, 9.6, 7.6), look_at: (0.3, 0.3, -0.25), fov: 42),\n    \
         film: (size: (320, 240)),\n    settings: (sampler: grid, spp: 16, max_depth: 0),\n    background: constant(gray(1)),\n    \
         lights: [ambient(gray(1)), directional(direction: (0.4, -1, -0.5), intensity: gray(0.5))],\n    materials: {\n        \
         \"ball\": phong(color: rgb(0.72, 0.74, 0.78), ambient: gray(0.5), diffuse: gray(0.6)),\n        \
         \"table\": phong(ambient: gray(0.8), diffuse: gray(0.3)),\n",
    );
    // Writing to a string cannot fail.
    for (depth, colour) in COLOURS.iter().enumerate() {
        let _ = writeln!(text, "        \"{depth}\": phong(ambient: gray(0), diffuse: gray(0), emission: {colour}),");
    }
    text.push_str("    },\n    nodes: [\n        (shape: plane(), material: \"table\"),\n");
    for (x, z, radius) in SPHERES {
        let _ = writeln!(
            text,
            "        (shape: sphere(center: ({x}, {radius}, {z}), radius: {radius}), material: \"ball\"),"
        );
    }
    for wire in wires {
        write_wire(&mut text, wire);
    }
    text + "    ],\n)\n"
}

fn write_wire(text: &mut String, wire: &Wire) {
    let (Wire::Edge { depth, .. } | Wire::Circle { depth, .. }) = wire;
    let half = HALF * [1.0, 0.85, 0.7, 0.6, 0.5, 0.42][(*depth as usize).min(5)];
    let material = (*depth as usize).min(COLOURS.len() - 1);
    let vector = |v: DVec3| format!("({}, {}, {})", v.x, v.y, v.z);
    let _ = match wire {
        Wire::Edge { ends, .. } => writeln!(
            text,
            "        (shape: box(min: {}, max: {}), material: \"{material}\", casts_shadow: false),",
            vector(ends.min - half),
            vector(ends.max + half)
        ),
        Wire::Circle { axis, centre, radius, .. } => {
            let turn = ["rotate_z(90)", "rotate_y(0)", "rotate_x(90)"][*axis];
            writeln!(
                text,
                "        (shape: torus(radius: {radius}, tube_radius: {half}), transform: [{turn}, translate{}], \
                 material: \"{material}\", casts_shadow: false),",
                vector(*centre)
            )
        }
    };
}

/// Spheres to look at the cost of.
pub(super) fn of_sphereflake(scene: &Scene<Spheres>) -> String {
    let middle = scene.view.centre();
    let eye = middle + DVec3::new(0.4, 0.5, 1.0).normalize() * (1.2 * scene.view.extent().length());
    let mut text = format!(
        "// Spheres on spheres.\n(\n    camera: (look_from: ({}, {}, {}), look_at: ({}, {}, {}), fov: 37),\n    \
         film: (size: (320, 240)),\n    settings: (sampler: centre, spp: 1),\n    nodes: [\n",
        eye.x, eye.y, eye.z, middle.x, middle.y, middle.z
    );
    for sphere in scene.primitives.as_slice() {
        let (centre, radius) = (sphere.centre(), sphere.radius());
        let _ = writeln!(
            text,
            "        (shape: sphere(center: ({}, {}, {}), radius: {radius})),",
            centre.x, centre.y, centre.z
        );
    }
    text + "    ],\n)\n"
}
