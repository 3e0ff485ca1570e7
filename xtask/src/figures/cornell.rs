//! Error against run time on the Cornell box: the plot in docs/CONVERGENCE.md.

use std::{fs, time::Duration};

use crate::{error::TaskError, renderer::Renderer, workspace::Workspace};

const SCENE: &str = "scenes/lecture/cornell.ron";
const TIMEOUT: Duration = Duration::from_secs(3600);
const PLOT: &str = "docs/figures/cornell.svg";

/// On one thread and in one pass, so that samplers are compared and nothing else.
const OPTIONS: &str = "--vary sampler=random,jittered,halton,sobol --spp 1..64 --size 128x128 --passes 1 --threads 1";

/// Lets the release build compare samplers, and keeps the plot.
pub(super) fn run(workspace: &Workspace) -> Result<(), TaskError> {
    let renderer = Renderer::new(workspace.build_release_renderer()?, TIMEOUT);
    let folder = workspace.fresh_folder("figures-cornell")?;
    let scene = workspace.root.join(SCENE);
    let scene = scene.to_string_lossy();
    let args = ["converge", &*scene, "-o", "cornell"].into_iter().chain(OPTIONS.split(' '));
    let run = renderer.run(&folder, args)?;
    run.succeeded()?;
    print!("{}", run.log);
    let (from, to) = (folder.join("cornell/converge.svg"), workspace.root.join(PLOT));
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(TaskError::file(folder))?;
    }
    fs::copy(&from, &to).map_err(TaskError::file(&from))?;
    println!("{PLOT}: made by rt-cli converge {SCENE} {OPTIONS}");
    Ok(())
}
