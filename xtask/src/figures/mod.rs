//! `figures`: the images in the guide of rt-accel, rendered by the real binary, and the plot in docs/CONVERGENCE.md.
//!
//! Each accelerator has two images: its nodes over a still life of a few spheres, and the cost of rays on the
//! sphereflake. An HTML fragment holds both with their bytes: they are part of the crate and shown without a network.

use std::{path::Path, time::Duration};

use base64::{Engine, engine::general_purpose::STANDARD};
use rt_accel::AcceleratorKind;

use crate::{error::TaskError, files, renderer::Renderer, scenes, workspace::Workspace};

mod compact;
mod cornell;
mod scene_file;
mod still_life;
mod wires;

const TIMEOUT: Duration = Duration::from_secs(300);
/// Most bytes of an image.
const LARGEST: usize = 25_000;
/// Spheres of the scene for costs.
const SPHEREFLAKE: usize = 820;

#[derive(Debug, clap::Args)]
pub(crate) struct FiguresOptions {
    #[arg(value_enum, default_value = "guide")]
    what: What,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum What {
    /// Images in the guide of rt-accel.
    Guide,
    /// Error against run time on the Cornell box; takes minutes on an otherwise idle machine.
    Cornell,
}

/// Renders figures and replaces the old ones.
pub(crate) fn run(workspace: &Workspace, options: &FiguresOptions) -> Result<(), TaskError> {
    match options.what {
        What::Guide => guide(workspace),
        What::Cornell => cornell::run(workspace),
    }
}

fn guide(workspace: &Workspace) -> Result<(), TaskError> {
    let renderer = Renderer::new(workspace.build_renderer()?, TIMEOUT);
    let folder = workspace.fresh_folder("figures")?;
    let sphereflake = scenes::sphereflake(SPHEREFLAKE)?;
    let costly = folder.join("balls.ron");
    files::write(&costly, scene_file::of_sphereflake(&sphereflake))?;
    for kind in AcceleratorKind::ALL {
        let name = kind.name();
        let scene = folder.join(format!("{name}.ron"));
        files::write(&scene, scene_file::of_wires(&still_life::wires(*kind)?))?;
        let parts = image(&renderer, &folder, &scene, &format!("{name}.png"), &[])?;
        let costs = ["--integrator", "cost", "--accel", name];
        let costs = image(&renderer, &folder, &costly, &format!("{name}-cost.png"), &costs)?;
        let page = workspace.root.join(format!("crates/rt-accel/src/guide/figures/{name}.html"));
        files::write(&page, fragment(name, &parts, &costs))?;
        println!("{name}: {} and {} bytes", parts.len(), costs.len());
    }
    Ok(())
}

/// Renders a scene to a small PNG file and returns its bytes.
fn image(renderer: &Renderer, folder: &Path, scene: &Path, name: &str, options: &[&str]) -> Result<Vec<u8>, TaskError> {
    renderer.render(folder, scene, name, options.iter().copied())?;
    let path = folder.join(name);
    let image = image::open(&path).map_err(TaskError::file(&path))?;
    let bytes = compact::png(&image.to_rgb8()).map_err(TaskError::file(&path))?;
    files::write(&path, &bytes)?;
    if bytes.len() > LARGEST {
        return Err(TaskError::Other(format!("{}: {} bytes are too many", path.display(), bytes.len())));
    }
    Ok(bytes)
}

fn fragment(name: &str, parts: &[u8], costs: &[u8]) -> String {
    let image = |what: &str, bytes: &[u8]| {
        let data = STANDARD.encode(bytes);
        format!(
            "<img alt=\"{what}\" title=\"{what}\" width=\"320\" height=\"240\" src=\"data:image/png;base64,{data}\">\n"
        )
    };
    let [parts, costs] =
        [image(&format!("Cells or bounds of {name}"), parts), image(&format!("Cost per ray in {name}"), costs)];
    format!("<p>\n{parts}{costs}</p>\n")
}
