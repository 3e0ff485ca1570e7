//! The window: events in, pictures out.

use std::collections::HashSet;
use std::num::NonZeroU32;
use std::rc::Rc;
use std::time::{Duration, Instant};

use rt_math::{DVec2, DVec3};
use rt_render::PickResult;
use softbuffer::{Context, SoftBufferError, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, OwnedDisplayHandle};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{Window, WindowId};

use super::camera_text::camera_text;
use super::desk::{Desk, Picture, Shot};
use super::explorer::{Drag, Explorer};
use super::keys::{HELP, Press, flight, press};
use super::painter::News;
use super::report::picked_text;
use crate::console::Console;
use crate::error::CliError;

/// Time between two steps of flight.
const TICK: Duration = Duration::from_millis(16);

/// A button that is released within so many pixels of where it was pressed has clicked.
const CLICK: f64 = 3.0;

/// Pixels of a touchpad that count as a notch of a wheel.
const PIXELS_PER_NOTCH: f64 = 40.0;

/// Smallest window, in pixels.
const SMALLEST: u32 = 16;

/// What is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Subject<'a> {
    /// Name of the scene.
    pub(super) name: &'a str,
    /// Name of the medium that the camera stands in, if it says so.
    pub(super) medium: Option<&'a str>,
    /// Size of the window at first.
    pub(super) size: [u32; 2],
    /// Samples of each pixel of a refined picture.
    pub(super) spp: u32,
}

/// A window on a scene.
pub(super) struct Viewer<'a> {
    desk: &'a Desk,
    console: Console,
    subject: Subject<'a>,
    explorer: Explorer,
    hands: Hands,
    picked: Option<PickResult>,
    screen: Option<Screen>,
    picture: Option<Picture>,
    /// Why the window was closed, if not by the user.
    failure: Option<CliError>,
}

/// What the user holds.
#[derive(Debug, Default)]
struct Hands {
    cursor: DVec2,
    /// What the button that is down does, and where it was pressed.
    drag: Option<(Drag, DVec2)>,
    keys: HashSet<KeyCode>,
    hurries: bool,
    /// When the last step of flight was.
    flown: Option<Instant>,
}

impl Hands {
    /// Where the keys that are held fly to.
    fn flight(&self) -> DVec3 {
        self.keys.iter().filter_map(|key| flight(*key)).sum()
    }
}

/// A window and its pixels.
struct Screen {
    window: Rc<Window>,
    surface: Surface<OwnedDisplayHandle, Rc<Window>>,
}

impl<'a> Viewer<'a> {
    pub(super) fn new(desk: &'a Desk, console: Console, subject: Subject<'a>, explorer: Explorer) -> Self {
        Self {
            desk,
            console,
            subject,
            explorer,
            hands: Hands::default(),
            picked: None,
            screen: None,
            picture: None,
            failure: None,
        }
    }

    /// How it ended.
    pub(super) fn into_result(self) -> Result<(), CliError> {
        self.failure.map_or(Ok(()), Err)
    }

    fn end(&mut self, event_loop: &ActiveEventLoop, failure: CliError) {
        self.failure.get_or_insert(failure);
        event_loop.exit();
    }

    fn println(&mut self, event_loop: &ActiveEventLoop, text: &str) {
        if let Err(failure) = self.console.println(text) {
            self.end(event_loop, failure);
        }
    }

    /// Asks for a picture of what the camera sees now.
    fn ask(&self) {
        let Some(screen) = &self.screen else { return };
        let PhysicalSize { width, height } = screen.window.inner_size();
        if width > 0 && height > 0 {
            self.desk.ask(Shot { camera: *self.explorer.camera(), size: [width, height] });
        }
    }

    fn open(&self, event_loop: &ActiveEventLoop) -> Result<Screen, CliError> {
        let [width, height] = self.subject.size;
        let attributes = Window::default_attributes()
            .with_title(self.subject.name)
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(SMALLEST, SMALLEST));
        let window = Rc::new(event_loop.create_window(attributes).map_err(|error| CliError::window(&error))?);
        let context = Context::new(event_loop.owned_display_handle()).map_err(|error| CliError::window(&error))?;
        let surface = Surface::new(&context, Rc::clone(&window)).map_err(|error| CliError::window(&error))?;
        Ok(Screen { window, surface })
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, event: &KeyEvent) {
        if let PhysicalKey::Code(code) = event.physical_key
            && flight(code).is_some()
        {
            match event.state {
                ElementState::Pressed => self.hands.keys.insert(code),
                ElementState::Released => self.hands.keys.remove(&code),
            };
            return;
        }
        let Some(meaning) = press(&event.logical_key).filter(|_| event.state.is_pressed()) else { return };
        match meaning {
            Press::Quit => event_loop.exit(),
            Press::Help if !event.repeat => self.println(event_loop, HELP),
            Press::PrintCamera if !event.repeat => {
                let text = camera_text(self.explorer.pose(), self.explorer.camera(), self.subject.medium);
                self.println(event_loop, &text);
            }
            Press::Help | Press::PrintCamera => {}
            Press::Reset => {
                self.explorer.reset();
                self.ask();
            }
            Press::LookAtPicked => {
                if let Some(picked) = &self.picked {
                    self.explorer.look_at(picked.point);
                    self.ask();
                }
            }
            Press::Orbit(right, up) => {
                self.explorer.orbit(right, up);
                self.ask();
            }
        }
    }

    fn button(&mut self, button: MouseButton, state: ElementState) {
        let cursor = self.hands.cursor;
        let drag = match button {
            MouseButton::Left => Drag::Orbit,
            MouseButton::Right => Drag::Look,
            MouseButton::Middle => Drag::Shift,
            _ => return,
        };
        match (state, self.hands.drag) {
            (ElementState::Pressed, None) => self.hands.drag = Some((drag, cursor)),
            (ElementState::Released, Some((held, from))) if held == drag => {
                self.hands.drag = None;
                if drag == Drag::Orbit && from.distance(cursor) <= CLICK {
                    self.desk.ask_for([cursor.x as u32, cursor.y as u32]);
                }
            }
            _ => {}
        }
    }

    fn cursor(&mut self, position: PhysicalPosition<f64>) {
        let before = core::mem::replace(&mut self.hands.cursor, DVec2::new(position.x, position.y));
        let Some(((drag, from), screen)) = self.hands.drag.zip(self.screen.as_ref()) else { return };
        // The first pixels may become a click.
        if from.distance(self.hands.cursor) <= CLICK && from.distance(before) <= CLICK {
            return;
        }
        let start = if from.distance(before) <= CLICK { from } else { before };
        let height = f64::from(screen.window.inner_size().height.max(1));
        self.explorer.drag(drag, (self.hands.cursor - start) / height);
        self.ask();
    }

    /// Flies on, if keys are held.
    fn fly(&mut self, event_loop: &ActiveEventLoop) {
        let way = self.hands.flight();
        if way == DVec3::ZERO {
            self.hands.flown = None;
            event_loop.set_control_flow(ControlFlow::Wait);
            return;
        }
        let now = Instant::now();
        let since = self.hands.flown.map_or(TICK, |flown| now - flown);
        if since >= TICK {
            self.hands.flown = Some(now);
            self.explorer.fly(way, self.hands.hurries, since);
            self.ask();
        }
        let next = self.hands.flown.unwrap_or(now) + TICK;
        event_loop.set_control_flow(ControlFlow::WaitUntil(next));
    }

    /// Takes the latest picture from the desk.
    fn take(&mut self) {
        let (Some(picture), Some(screen)) = (self.desk.take_picture(), &self.screen) else { return };
        let Subject { name, spp, .. } = self.subject;
        let title = format!("{name} – {} of {spp} samples per pixel", picture.spp);
        screen.window.set_title(&title);
        screen.window.request_redraw();
        self.picture = Some(picture);
    }

    /// Brings the picture to the screen, and says so once it is refined.
    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        let (Some(picture), Some(screen)) = (&mut self.picture, &mut self.screen) else { return };
        if let Err(error) = screen.draw(picture) {
            return self.end(event_loop, CliError::window(&error));
        }
        if core::mem::take(&mut picture.is_refined) {
            let text = format!("refined: {} samples per pixel", picture.spp);
            self.println(event_loop, &text);
        }
    }
}

impl Screen {
    /// Shows a picture in the upper left corner; one of another size is on its way when the window has been resized.
    fn draw(&mut self, picture: &Picture) -> Result<(), SoftBufferError> {
        let PhysicalSize { width, height } = self.window.inner_size();
        let (Some(columns), Some(rows)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else { return Ok(()) };
        self.surface.resize(columns, rows)?;
        let mut buffer = self.surface.buffer_mut()?;
        let stride = picture.size[0] as usize;
        let shared = stride.min(width as usize);
        for (y, row) in buffer.chunks_mut(width as usize).enumerate() {
            row.fill(0);
            if let Some(pixels) = picture.pixels.get(y * stride..y * stride + shared) {
                row[..shared].copy_from_slice(pixels);
            }
        }
        self.window.pre_present_notify();
        buffer.present()
    }
}

impl ApplicationHandler<News> for Viewer<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        match self.open(event_loop) {
            Ok(screen) => {
                self.screen = Some(screen);
                self.ask();
            }
            Err(failure) => self.end(event_loop, failure),
        }
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, _: StartCause) {
        self.fly(event_loop);
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, news: News) {
        match news {
            News::Painted => self.take(),
            News::PickResult(picked) => {
                self.println(event_loop, &picked_text(picked.as_deref()));
                self.picked = picked.map(|picked| *picked);
            }
            News::Refused(error) => self.console.warn(error),
            News::Gone => event_loop.exit(),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(_) => {
                self.ask();
                self.draw(event_loop);
            }
            WindowEvent::RedrawRequested => self.draw(event_loop),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(event_loop, &event),
            WindowEvent::ModifiersChanged(modifiers) => self.hands.hurries = modifiers.state().shift_key(),
            // Whoever has the keyboard now is told of the release of keys.
            WindowEvent::Focused(false) => self.hands.keys.clear(),
            WindowEvent::CursorMoved { position, .. } => self.cursor(position),
            WindowEvent::MouseInput { state, button, .. } => self.button(button, state),
            WindowEvent::MouseWheel { delta, .. } => {
                self.explorer.wheel(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_PER_NOTCH,
                });
                self.ask();
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.fly(event_loop);
    }
}
