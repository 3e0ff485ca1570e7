//! `view`: a window on a scene.
//!
//! ```text
//!   window ── camera, size ──> desk ── latest ──> painter ── RenderPlan::look_through, render
//!      ^                                            │
//!      └────────────── pictures, news ──────────────┘
//! ```

mod camera_text;
mod desk;
mod explorer;
mod keys;
mod pace;
mod painter;
mod pose;
mod report;
mod window;

use std::panic;
use std::thread;

use rt_camera::{Camera, CameraSettings};
use rt_render::RenderPlan;
use rt_scene_io::Scene;
use winit::event_loop::{EventLoop, EventLoopProxy};

use crate::args::WindowArgs;
use crate::console::Console;
use crate::error::CliError;
use crate::input::{self, Input};
use crate::settings::{self, Overrides};

use desk::Desk;
use explorer::Explorer;
use pace::Pace;
use painter::{News, Painter};
use window::{Subject, Viewer};

pub(super) fn run(args: &WindowArgs) -> Result<(), CliError> {
    let console = Console { quiet: false };
    refuse_what_is_for_render(args)?;
    let Input { scene, environment, options: loaded, .. } = input::read(&args.input, Some(&args.picture), console)?;
    let overrides = Overrides {
        picture: &args.picture,
        development: Some(&args.development),
        environment: environment.as_ref(),
        memory: loaded.memory.limit(),
        progressive: true,
    };
    let (mut scene, options) = settings::resolve(scene, overrides)?;
    // The window samples all pixels alike, pass after pass.
    (scene.settings.adaptive, scene.settings.passes) = (None, None);
    let plan = RenderPlan::compile(&scene, &options).map_err(|error| CliError::plan(&args.input.scene, error))?;
    input::print_notes(&scene, console)?;

    let named = &scene.cameras[options.camera];
    let explorer = Explorer::new(named.settings, distance_of_interest(&scene, &named.settings, &plan))
        .ok_or_else(|| CliError::Usage(format!("nobody can be led around with camera '{}'", named.name)))?;
    let medium = named.medium.and_then(|medium| scene.appearance.materials.get(medium.0 as usize));
    let event_loop = event_loop()?;
    let desk = Desk::default();
    let subject = Subject {
        name: &scene.name,
        medium: medium.map(|medium| medium.name.as_str()),
        size: [scene.film.width, scene.film.height],
        spp: scene.settings.spp,
    };
    let mut viewer = Viewer::new(&desk, console, subject, explorer);
    console.println("press H in the window for the keys")?;
    let proxy = event_loop.create_proxy();
    let mut painter = Painter {
        plan,
        desk: &desk,
        threads: args.threads.unwrap_or(0).into(),
        spp: subject.spp,
        development: scene.film.development,
        pace: Pace::default(),
        // The window may be gone already.
        tell: |news| drop(proxy.send_event(news)),
    };
    let farewell = Farewell(event_loop.create_proxy());
    let shown = thread::scope(|scope| {
        scope.spawn(move || {
            let _farewell = farewell;
            painter.work();
        });
        let shown = event_loop.run_app(&mut viewer);
        desk.close();
        shown
    });
    shown.map_err(|error| CliError::window(&error))?;
    viewer.into_result()
}

/// Options of `render` that a window has no use for.
fn refuse_what_is_for_render(args: &WindowArgs) -> Result<(), CliError> {
    let picture = &args.picture;
    let given = [
        ("--crop", picture.crop.is_some()),
        ("--passes", picture.passes.is_some()),
        ("--adaptive", picture.adaptive.is_some()),
        ("--min-spp", picture.min_spp.is_some()),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => {
            Err(CliError::Usage(format!("{option} is for `render`: a window shows the whole image, all pixels alike")))
        }
        None => Ok(()),
    }
}

/// How far away the camera's point of interest is, in world units: what the middle of the image shows, or else the middle of the
/// scene; 1 for a scene without one, or one behind the camera.
fn distance_of_interest(scene: &Scene, settings: &CameraSettings, plan: &RenderPlan<'_>) -> f64 {
    let (width, height) = (scene.film.width, scene.film.height);
    if let Some(picked) = plan.pick(width / 2, height / 2) {
        return picked.distance;
    }
    let forward = Camera::new(settings, width, height).map(|camera| camera.view_axis()).unwrap_or_default();
    let distance = (scene.bounds().centre() - settings.world_from_camera.translation()).dot(forward);
    Some(distance).filter(|distance| distance.is_finite() && *distance > 0.0).unwrap_or(1.0)
}

/// Connects to the window system. Without one, and without its libraries, that fails.
fn event_loop() -> Result<EventLoop<News>, CliError> {
    // The window library panics where it misses a library of the system.
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let built = panic::catch_unwind(|| EventLoop::with_user_event().build());
    panic::set_hook(hook);
    match built {
        Ok(built) => built.map_err(|error| CliError::window(&error)),
        Err(panicked) => {
            let text = panicked.downcast_ref::<String>().map(String::as_str);
            let text = text.or(panicked.downcast_ref::<&str>().copied());
            Err(CliError::window(&text.unwrap_or("the window system cannot be used")))
        }
    }
}

/// Tells the window that the painter is gone, even if it panicked.
struct Farewell(EventLoopProxy<News>);

impl Drop for Farewell {
    fn drop(&mut self) {
        // The window may be gone already.
        let _ = self.0.send_event(News::Gone);
    }
}
