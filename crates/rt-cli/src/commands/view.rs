//! `view`: a scene in the browser.
//!
//! ```text
//!   browser ── HTTP ──> server ──> routes ── views, picks ──> shared state ──> renderer ── RenderPlan
//!      ^                              │                            │
//!      └────── page, images ──────────┴──────── images ───────────┘
//! ```

mod access;
mod camera_controller;
mod camera_text;
mod encoded_images;
mod frame_budget;
mod http;
mod open_browser;
mod pose;
mod render_thread;
mod routes;
mod server;
mod shared_state;

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread;

use rt_camera::{Camera, CameraSettings};
use rt_image::Development;
use rt_render::RenderPlan;
use rt_scene_io::{Scene, format};

use crate::args::{BrowserArgs, ViewArgs};
use crate::console::Console;
use crate::error::{CliError, usage};
use crate::input::{self, Input};
use crate::{memory, settings, signals};

use access::Access;
use camera_controller::CameraController;
use camera_text::fields_without_position;
use encoded_images::EncodedImages;
use frame_budget::FrameBudget;
use render_thread::Renderer;
use routes::Session;
use shared_state::{SharedState, State, View};

pub(super) fn run(args: &BrowserArgs) -> Result<(), CliError> {
    let console = Console { quiet: false };
    refuse_what_is_for_render(args)?;
    let Input { scene, environment, options: loaded, .. } = input::read(&args.input, Some(&args.image), console)?;
    let of_scene = scene.film.development;
    let (mut scene, mut options) =
        settings::resolve(scene, &args.image, None, environment.as_ref(), loaded.memory.limit())?;
    options.progressive = true;
    let mut developments = [of_scene, Development { encoding: of_scene.encoding, ..Development::default() }];
    developments[usize::from(!scene.settings.integrator.follows_light())] = scene.film.development;
    developments.iter_mut().for_each(|development| settings::apply_development(&args.development, development));
    // All pixels are sampled alike, pass after pass.
    (scene.settings.adaptive, scene.settings.passes) = (None, None);
    let mut plan = RenderPlan::compile(&scene, &options).map_err(|error| CliError::plan(&args.input.scene, error))?;
    let size = [scene.film.width, scene.film.height];
    let copies = ("its copies for the page".to_owned(), render_thread::copy_bytes(size, options.transparent));
    let render = ("the render".to_owned(), plan.memory().peak());
    memory::check(options.memory, &args.input.scene, &[render, copies])?;
    input::print_notes(&scene, console)?;

    let named = &scene.cameras[options.camera];
    let controller = CameraController::new(named.settings, distance_to_target(&scene, &named.settings, &plan))
        .ok_or_else(|| {
            CliError::Usage(format!("camera '{}' has no view direction; choose another --camera", named.name))
        })?;
    let (mut integrator, spp) = (scene.settings.integrator, scene.settings.spp);
    let view = View { number: 0, camera: named.settings, size, integrator, max_spp: spp };
    let medium = named.medium.and_then(|medium| scene.appearance.materials.get(medium.0 as usize));
    let medium = medium.map(|medium| medium.name.clone());
    let mut fields =
        camera_fields(&args.image.view, scene.camera_fields.get(options.camera), &named.settings, medium.as_deref());
    // A camera without a shutter is sharp where the common interval begins.
    fields.shutter = fields.shutter.or(scene.shutter_interval.map(|[opens, _]| (opens, opens)));

    let failed = |error: std::io::Error| CliError::Server(SocketAddr::new(args.bind, args.port), error);
    let listener = TcpListener::bind((args.bind, args.port)).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let access = Access::new(address.ip()).map_err(failed)?;
    let url = format!("http://{}{}", SocketAddr::new(reachable(address.ip()), address.port()), access.page());
    let shared = SharedState::new(State::new(view, controller, developments));
    let session = Arc::new(Session {
        access,
        shared,
        files: EncodedImages::default(),
        name: scene.name.clone(),
        medium,
        fields,
        size,
        spp,
    });
    if !address.ip().is_loopback() {
        console.warn(format_args!(
            "--bind {} opens the view to the network: the address alone gives access to scene and render, and \
             nothing is encrypted",
            args.bind
        ));
    }
    signals::end_on_signals();
    console.println(format_args!("view of {} at {url}\nCtrl-C ends it", scene.name))?;
    thread::spawn({
        let session = Arc::clone(&session);
        move || server::serve(&listener, &session)
    });
    if !args.no_open {
        open_browser::open(&url);
    }

    let mut renderer = Renderer {
        shared: &session.shared,
        threads: args.threads.unwrap_or(0).into(),
        memory: options.memory,
        predicted_pixels: u64::from(size[0]) * u64::from(size[1]),
        transparent: options.transparent,
        budget: FrameBudget::default(),
    };
    loop {
        let wanted = renderer.work(plan, integrator);
        let before = core::mem::replace(&mut scene.settings.integrator, wanted);
        match RenderPlan::compile(&scene, &options) {
            Ok(compiled) => (plan, integrator) = (compiled, wanted),
            Err(error) => {
                let message = error.to_string();
                session.shared.change_view(|state| state.view.integrator = before);
                session.shared.show(|state| state.message = Some(message));
                scene.settings.integrator = before;
                plan =
                    RenderPlan::compile(&scene, &options).map_err(|error| CliError::plan(&args.input.scene, error))?;
            }
        }
    }
}

/// Refuses options of `render` that have no meaning here.
fn refuse_what_is_for_render(args: &BrowserArgs) -> Result<(), CliError> {
    let image = &args.image;
    let given = [
        ("--crop", image.crop.is_some()),
        ("--passes", image.passes.is_some()),
        ("--adaptive", image.adaptive.is_some()),
        ("--min-spp", image.min_spp.is_some()),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => usage(format!("{option} is not supported by `view`; remove it, or use `render`")),
        None => Ok(()),
    }
}

/// Fields that describe the camera in a scene file, with the options applied. They have no position if it is not known exactly.
fn camera_fields(
    args: &ViewArgs,
    of_scene: Option<&format::Camera>,
    settings: &CameraSettings,
    medium: Option<&str>,
) -> format::Camera {
    let mut fields = of_scene.cloned().unwrap_or_default();
    if args.look_from.is_some() || args.look_at.is_some() || args.up.is_some() {
        return format::Camera {
            look_from: args.look_at.map(|_| settings.world_from_camera.translation().to_array()),
            look_at: args.look_at.map(|target| target.to_array()),
            up: args.look_at.and(args.up).map(|up| up.to_array()),
            ..fields_without_position(settings, medium, fields.shutter)
        };
    }
    if args.fov.is_some() {
        fields.fov = args.fov;
        fields.animation.iter_mut().flat_map(|animation| &mut animation.keys).for_each(|key| key.fov = None);
    }
    fields
}

/// Distance of the camera's target in world units. The target is the surface in the middle of the image, or else the middle of the
/// scene. 1 for a scene without one, or one behind the camera.
fn distance_to_target(scene: &Scene, settings: &CameraSettings, plan: &RenderPlan<'_>) -> f64 {
    let (width, height) = (scene.film.width, scene.film.height);
    if let Some(picked) = plan.pick(width / 2, height / 2) {
        return picked.distance;
    }
    let forward = Camera::new(settings, width, height).map(|camera| camera.view_axis()).unwrap_or_default();
    let distance = (scene.bounds().centre() - settings.world_from_camera.translation()).dot(forward);
    Some(distance).filter(|distance| distance.is_finite() && *distance > 0.0).unwrap_or(1.0)
}

/// Address by which this machine reaches a server that listens on the given one.
const fn reachable(address: IpAddr) -> IpAddr {
    match address {
        IpAddr::V4(Ipv4Addr::UNSPECIFIED) => IpAddr::V4(Ipv4Addr::LOCALHOST),
        IpAddr::V6(Ipv6Addr::UNSPECIFIED) => IpAddr::V6(Ipv6Addr::LOCALHOST),
        other => other,
    }
}
