//! # rt-fuzz: what the fuzz targets have in common
//!
//! ```text
//!   bytes ──> a file in memory ──> load ──> RenderPlan::compile ──> explain
//! ```
//!
//! **Owns** the budget of a run, the files that inputs may refer to, and the proof that what a loader accepts can be used.
//! **Does not own** the limits on memory and on time as the clock shows it, which the command line of a target sets.

#![forbid(unsafe_code)]

use std::{cell::OnceCell, fs, path::Path, time::Duration};

use cpu_time::ProcessTime;
use rt_render::{Checkpoint, PlanOptions, RenderPlan, RunOptions, StopRule};
use rt_scene_io::{Content, Group, LoadOptions, Scene, SceneNode, load};
use tempfile::TempDir;

/// Processor time that one input may take. Sanitizers and checks of overflow make the program several times as slow as it
/// is for its users. What takes a second for them takes longer than this.
const BUDGET: Duration = Duration::from_secs(5);

/// Plans are made of scenes with at most as many objects, each instance counted, and as many triangles. The loaders are
/// under test, and not the builders of trees.
const MAX_PLANNED: u64 = 10_000;

/// Runs `work` and panics if it takes more processor time than it may. The clock on the wall would find fault with a busy
/// machine.
pub fn within_budget(work: impl FnOnce()) {
    let started = ProcessTime::now();
    work();
    let taken = started.elapsed();
    assert!(taken < BUDGET, "took {taken:?} of processor time");
}

/// Writes `bytes` to a file of this name, and passes its path on. The folder is one for the whole process, among the
/// temporary files. It also has an image `t.png`, a library `a.mtl` and a buffer `a.bin` that the file may name.
pub fn with_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path)) {
    thread_local!(static FOLDER: OnceCell<TempDir> = const { OnceCell::new() });
    FOLDER.with(|folder| {
        let path = folder.get_or_init(neighbours).path().join(name);
        fs::write(&path, bytes).expect("a folder to write to");
        within_budget(|| read(&path));
    });
}

fn neighbours() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let place = |name: &str| folder.path().join(name);
    image::RgbImage::from_pixel(2, 2, image::Rgb([200, 100, 50])).save(place("t.png")).expect("an image");
    fs::write(place("a.mtl"), "newmtl m\nKd 0.5 0.2 0.1\nmap_Kd t.png\nPr 0.3\nPm 1\n").expect("a library");
    fs::write(place("a.bin"), [0_u8; 1024]).expect("a buffer");
    folder
}

/// Loads a file and proves that what is accepted can be used.
pub fn load_and_plan(path: &Path) {
    let options = LoadOptions { size: Some([8, 6]), ..LoadOptions::default() };
    if let Ok(scene) = load(path, &options) {
        plan(&scene);
    }
}

/// Makes a plan of a scene and describes it. An error is an answer as well.
pub fn plan(scene: &Scene) {
    let _ = scene.bounds();
    let triangles: u64 = scene.meshes.iter().map(|mesh| mesh.mesh.data().triangles.len() as u64).sum();
    if triangles > MAX_PLANNED || placed_objects(scene) > MAX_PLANNED {
        return;
    }
    if let Ok(plan) = RenderPlan::compile(scene, &PlanOptions::default()) {
        assert!(!plan.explain().to_string().is_empty());
    }
}

/// The number of objects, instances unfolded.
fn placed_objects(scene: &Scene) -> u64 {
    let mut groups = Vec::new();
    for Group { nodes, .. } in &scene.groups {
        groups.push(count(nodes, &groups));
    }
    count(&scene.nodes, &groups)
}

fn count(nodes: &[SceneNode], groups: &[u64]) -> u64 {
    let mut open: Vec<&SceneNode> = nodes.iter().collect();
    let mut total = 0_u64;
    while let Some(node) = open.pop() {
        total = total.saturating_add(match node.content {
            Some(Content::Instance(group)) => groups.get(group.0 as usize).copied().unwrap_or(0),
            _ => 1,
        });
        open.extend(&node.children);
    }
    total
}

/// Resumes a checkpoint, tile by tile and pass by pass. The scene has an image of 17 by 3 pixels, as that of the seeds.
pub fn go_on(checkpoint: &Checkpoint) {
    const SCENE: &str = "(film: (size: (17, 3)), settings: (spp: 2), nodes: [(shape: sphere())])";
    thread_local!(static LOADED: OnceCell<Scene> = const { OnceCell::new() });
    LOADED.with(|scene| {
        let scene = scene.get_or_init(|| {
            let folder = tempfile::tempdir().expect("a folder for temporary files");
            let path = folder.path().join("s.ron");
            fs::write(&path, SCENE).expect("written");
            load(&path, &LoadOptions::default()).expect("a scene")
        });
        let plan = RenderPlan::compile(scene, &PlanOptions::default()).expect("compiles");
        let growing = StopRule { max_spp: 4, ..StopRule::default() };
        for maps in [false, true] {
            let run = RunOptions { threads: 1, maps, ..RunOptions::default() };
            for rule in [None, Some(&growing)] {
                if let Ok(shard) = plan.render_shard(&run, rule, Some(checkpoint.clone()), |_| {}) {
                    let rendering = shard.into_rendering();
                    assert!(rendering.statistics.samples >= checkpoint.samples(), "counts never fall");
                }
            }
        }
    });
}
