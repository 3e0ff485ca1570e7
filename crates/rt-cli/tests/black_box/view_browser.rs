//! The view in a real browser: Chromium, led by playwright-core for Node.js. Where these are missing, the test is skipped.
//!
//! Screenshots are left in `target/tmp/view_browser`. `npm install --prefix target/playwright playwright-core` installs the latter.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use rt_image::{Development, read_image};

use crate::program::Workplace;
use crate::view_server::ViewServer;

const CHROMIUM: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// Options of the render whose image is compared.
const OPTIONS: &str = "--integrator path --spp 24 --size 160x160";

/// Path of the first of these programs that is there.
fn program(names: &[&str]) -> Option<PathBuf> {
    let folders: Vec<_> = env::split_paths(&env::var_os("PATH")?).collect();
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

/// Node.js with playwright-core in its search path.
fn node() -> Option<Command> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent()?;
    let own = target.join("playwright/node_modules").into_os_string();
    let inherited = env::var_os("NODE_PATH");
    let path: OsString = env::join_paths([Some(own), inherited].into_iter().flatten()).ok()?;
    let node = || {
        let mut command = Command::new(program(&["node"]).unwrap_or_default());
        command.env("NODE_PATH", &path);
        command
    };
    let resolved = node().args(["-e", "require.resolve('playwright-core')"]).output().ok()?;
    resolved.status.success().then(node)
}

/// Runs a script of the folder `view_browser` with a view and a folder of its own. `None` if the programs for it are missing.
fn run_script(name: &str, start: impl FnOnce() -> ViewServer) -> Option<(ViewServer, PathBuf)> {
    let skip = |reason: &str| {
        rt_tests::skip(reason);
        None
    };
    let Some(chromium) = program(&CHROMIUM) else { return skip("there is no Chromium") };
    let Some(mut node) = node() else { return skip("there is no Node.js with playwright-core") };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view_browser").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    let view = start();
    let script = format!("{}/tests/view_browser/{name}.cjs", env!("CARGO_MANIFEST_DIR"));
    let run = node.arg(script).arg(&view.url).arg(&chromium).arg(&folder).output().expect("it starts");
    let said = String::from_utf8_lossy(&run.stdout).into_owned() + &String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{said}");
    Some((view, folder))
}

/// A ball that renders at once.
const SPHERE: &str =
    "(camera: (look_from: (0, 0, 5)), film: (size: (80, 60)), settings: (spp: 1), nodes: [(shape: sphere())])";

#[test]
fn the_resolution_menu_follows_the_server() {
    run_script("resolution", || ViewServer::start(SPHERE, ""));
}

#[test]
fn keys_work_on_other_keyboard_layouts() {
    run_script("layouts", || ViewServer::start(SPHERE, ""));
}

#[test]
fn a_browser_shows_renders_picks_and_saves() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/lecture/cornell.ron");
    let view = || ViewServer::start_in(Workplace::new(), &format!("{scene} {OPTIONS}"));
    let Some((view, screenshots)) = run_script("view", view) else { return };

    for name in ["expected.png", "expected.exr"] {
        view.place.succeed(&format!("render {scene} {OPTIONS} --time 1h -o {name}"));
    }
    let saved = |name: &str| fs::read(screenshots.join(name)).expect("a file");
    assert!(saved("saved.png") == view.place.read("expected.png"), "the PNG that the browser saved differs");
    assert!(saved("saved.exr") == view.place.read("expected.exr"), "the EXR that the browser saved differs");
    let pixels: serde_json::Value = serde_json::from_slice(&saved("pixels.json")).expect("JSON");
    let shown: Vec<u64> =
        pixels["data"].as_array().expect("bytes").iter().filter_map(serde_json::Value::as_u64).collect();
    let film = read_image(&view.place.path("expected.png")).expect("an image");
    let expected = Development::default().develop(&film).bytes;
    let expected: Vec<u64> =
        expected.chunks(3).flat_map(|rgb| rgb.iter().copied().chain([255])).map(u64::from).collect();
    assert!(shown == expected, "the canvas shows other pixels than the file");
    let picked = String::from_utf8(saved("pick.txt")).expect("text");
    for part in ["Material\nred", "Normal\n−1, 0.0058, 0", "Position", "t\n", "Distance"] {
        assert!(picked.contains(part), "{picked}");
    }

    // The last page has left work without end.
    #[cfg(target_os = "linux")]
    {
        std::thread::sleep(Duration::from_secs(5));
        let before = view.processor_seconds();
        std::thread::sleep(Duration::from_secs(1));
        let work = view.processor_seconds() - before;
        assert!(work < 0.1, "{work} s of work for a page that is closed");
    }
}
