//! Requests to responses: the page, its images, and commands to camera and renderer.

use std::fmt::Display;
use std::sync::mpsc::channel;
use std::time::Duration;

use rt_camera::FilmSettings;
use rt_image::ImageFormat;
use rt_scene_io::{Integrator, format, limits};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::access::Access;
use super::camera_controller::CameraCommand;
use super::camera_text::{camera_text, file_camera_text};
use super::encoded_images::{EncodedImages, FileKey};
use super::http::{Request, Response, Status};
use super::shared_state::{SharedState, State};
use crate::args::{TONE_CURVES, tone_name, tone_of_name};

/// Longest wait of a page for a new image.
const FRAME_WAIT: Duration = Duration::from_secs(1);

/// Longest wait for the renderer's answer to a pick.
const PICK_WAIT: Duration = Duration::from_secs(30);

/// Most pixels of an image whose size a page chooses.
const MAX_PIXELS: u64 = 3840 * 2160;

/// A scene that is viewed. Size and samples per pixel are those of scene and command line.
#[derive(Debug)]
pub(super) struct Session {
    pub(super) access: Access,
    pub(super) shared: SharedState,
    pub(super) files: EncodedImages,
    pub(super) name: String,
    /// Name of the medium around the camera.
    pub(super) medium: Option<String>,
    /// Fields of the camera in the scene file. They have no position if it is not known exactly.
    pub(super) fields: format::Camera,
    pub(super) size: [u32; 2],
    pub(super) spp: u32,
}

/// Settings that a page changes; the others stay.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsUpdate {
    integrator: Option<String>,
    exposure: Option<f64>,
    tone: Option<String>,
    spp: Option<u32>,
    size: Option<[u32; 2]>,
}

impl Session {
    pub(super) fn respond(&self, request: &Request) -> Response {
        let path = match self.access.check(request) {
            Ok(path) => path,
            Err(status) => return Response::refusal(status, "403 Forbidden: open the address that rt-cli has printed"),
        };
        self.shared.see_client();
        let response = match (request.method.as_str(), path) {
            ("GET", "") => Ok(Response::new("text/html; charset=utf-8", include_bytes!("page/index.html"))),
            ("GET", "view.css") => Ok(Response::new("text/css; charset=utf-8", include_bytes!("page/view.css"))),
            ("GET", "view.js") => Ok(Response::new("text/javascript; charset=utf-8", include_bytes!("page/view.js"))),
            ("GET", "plot.js") => Ok(Response::new("text/javascript; charset=utf-8", include_bytes!("page/plot.js"))),
            ("GET", "session") => Ok(response(&self.description())),
            ("GET", "frame") => self.frame(request),
            ("GET", "camera") => Ok(Response::new("text/plain; charset=utf-8", self.camera().into_bytes())),
            ("GET", "image.png") => self.image(ImageFormat::Png, "image/png"),
            ("GET", "image.exr") => self.image(ImageFormat::Exr, "image/x-exr"),
            ("POST", "camera") => parsed(request).map(|command: CameraCommand| {
                self.shared.change_view(|state| {
                    state.controller.apply(&command);
                    state.view.camera = *state.controller.camera();
                });
                response(&Value::Null)
            }),
            ("POST", "settings") => parsed(request)
                .and_then(|settings| self.shared.change_view(|state| self.update(&settings, state)))
                .map(|()| response(&Value::Null)),
            ("POST", "pick") => parsed(request).and_then(|pixel| self.pick(pixel)),
            ("GET" | "POST", _) => Err(Response::refusal(Status::NOT_FOUND, "")),
            _ => Err(Response::refusal(Status::METHOD, "")),
        };
        response.unwrap_or_else(|refusal| refusal)
    }

    /// Scene, and choices for settings.
    fn description(&self) -> Value {
        let integrator = |it: Integrator| json!({ "name": it.name(), "follows_light": it.follows_light() });
        json!({
            "name": self.name,
            "size": self.size,
            "spp": self.spp,
            "integrators": Integrator::ALL.map(integrator),
            "tones": TONE_CURVES.map(tone_name),
        })
    }

    fn camera(&self) -> String {
        let controller = self.shared.lock().controller;
        if controller.is_at_home() && self.fields.is_placed() {
            return file_camera_text(&self.fields);
        }
        camera_text(controller.pose(), controller.camera(), self.medium.as_deref(), self.fields.shutter)
    }

    /// A line of JSON, and the bytes of a PNG if there is a later version than `after`. Of the errors, the page has `errors` if
    /// its image shows `view`.
    fn frame(&self, request: &Request) -> Result<Response, Response> {
        let after = request.number("after").unwrap_or(0);
        let mut state = self.shared.wait_for_version(after, FRAME_WAIT);
        let view = state.view;
        let mut development = *state.development(view.integrator);
        let (version, image) = (state.version, state.image.clone());
        let is_finished = image.is_finished && image.view == view.number;
        let is_same_view = request.number("view") == Some(image.view);
        let first_error = request.number("errors").filter(|_| is_same_view).map_or(0, |first| first as usize);
        let errors = image.errors.iter().skip(first_error);
        let status = json!({
            "version": version,
            "view": image.view,
            "spp": image.spp,
            "max_spp": view.max_spp,
            "wanted_size": view.size,
            "mega_rays_per_second": image.mega_rays_per_second,
            "seconds": image.seconds,
            "is_finished": is_finished,
            "size": image.size,
            "pixel_side": image.pixel_side,
            "integrator": view.integrator.name(),
            "exposure": development.exposure,
            "tone": tone_name(development.tone),
            "message": state.message,
            "first_error": first_error,
            "errors": errors.map(|error| (error.spp, error.rmse, error.interval[0], error.interval[1])).collect::<Vec<_>>(),
        });
        drop(state);
        let mut body = status.to_string().into_bytes();
        body.push(b'\n');
        let file = match image.film.filter(|_| version != after) {
            Some(film) => {
                // Without dithering, images on their way to the final one are much smaller.
                development.dither = development.dither.filter(|_| is_finished);
                Some(self.files.file(FileKey { version, development, format: ImageFormat::Png }, &film)?)
            }
            None => None,
        };
        Ok(Response { file, ..Response::new("application/octet-stream", body) })
    }

    fn image(&self, format: ImageFormat, content_type: &'static str) -> Result<Response, Response> {
        let mut state = self.shared.lock();
        let integrator = state.view.integrator;
        let (version, film, development) = (state.version, state.image.film.clone(), *state.development(integrator));
        drop(state);
        let film = film.ok_or_else(|| Response::refusal(Status::NOT_FOUND, "no image is rendered yet"))?;
        let file = Some(self.files.file(FileKey { version, development, format }, &film)?);
        let stem = self.name.replace(|c: char| !c.is_ascii_alphanumeric() && !"-_.".contains(c), "_");
        let extension = format.extensions().first().copied().unwrap_or_default();
        Ok(Response { file_name: Some(format!("{stem}.{extension}")), file, ..Response::new(content_type, &[]) })
    }

    /// Applies settings, all or none of them.
    fn update(&self, update: &SettingsUpdate, state: &mut State) -> Result<(), Response> {
        let mut view = state.view;
        if let Some(name) = &update.integrator {
            let known = Integrator::ALL.into_iter().find(|integrator| integrator.name() == name);
            view.integrator = known.ok_or_else(|| bad("unknown integrator"))?;
        }
        view.max_spp = update.spp.unwrap_or(view.max_spp);
        if !(1..=limits::SAMPLES).contains(&view.max_spp.into()) {
            return Err(bad(format!("the number of samples per pixel must be from 1 to {}", limits::SAMPLES)));
        }
        if let Some([width, height]) = update.size.filter(|size| *size != self.size) {
            FilmSettings { width, height, ..FilmSettings::default() }.validate().map_err(bad)?;
            if u64::from(width) * u64::from(height) > MAX_PIXELS {
                return Err(bad(format!("the image may have at most {MAX_PIXELS} pixels")));
            }
        }
        view.size = update.size.unwrap_or(view.size);
        let mut development = *state.development(view.integrator);
        development.exposure = update.exposure.unwrap_or(development.exposure);
        if let Some(name) = &update.tone {
            development.tone = tone_of_name(name).ok_or_else(|| bad("unknown tone curve"))?;
        }
        development.validate().map_err(bad)?;
        if core::mem::replace(state.development(view.integrator), development) != development {
            state.version += 1;
        }
        state.view = view;
        Ok(())
    }

    /// Hit of a pixel, null for the background and outside of the image, and the number of the view.
    fn pick(&self, pixel: [u32; 2]) -> Result<Response, Response> {
        let size = self.shared.lock().view.size;
        let is_inside = pixel.iter().zip(size).all(|(&at, side)| at < side);
        let (sender, answer) = channel();
        self.shared.pick((pixel, sender));
        let answer = answer.recv_timeout(PICK_WAIT);
        let (view, picked) = answer.map_err(|_| Response::refusal(Status::BUSY, "the renderer is busy"))?;
        let hit = picked.filter(|_| is_inside).map_or(Value::Null, |picked| {
            json!({
                "object": picked.object,
                "material": picked.material,
                "t": picked.t,
                "distance": picked.distance,
                "position": picked.point.to_array(),
                "normal": picked.normal.to_array(),
            })
        });
        Ok(response(&json!({ "view": view, "hit": hit })))
    }
}

fn response(value: &Value) -> Response {
    Response::new("application/json", value.to_string().into_bytes())
}

fn parsed<T: DeserializeOwned>(request: &Request) -> Result<T, Response> {
    serde_json::from_slice(&request.body).map_err(bad)
}

fn bad(reason: impl Display) -> Response {
    Response::refusal(Status::BAD_REQUEST, &reason.to_string())
}
