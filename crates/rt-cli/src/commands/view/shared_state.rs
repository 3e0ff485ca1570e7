//! State that the server's threads and the renderer share.
//!
//! ```text
//!   server ── wanted view, picks ──> shared state ── next_task ──> renderer
//!     ^                                   │
//!     └──── image, status <─────────────┴──── show <───────────────┘
//! ```

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rt_camera::CameraSettings;
use rt_image::{Development, Image};
use rt_render::PickResult;
use rt_scene_io::Integrator;

use super::camera_controller::CameraController;

/// Time without a request after which no page counts as open.
pub(super) const ABSENCE: Duration = Duration::from_secs(4);

/// Image that a page wants to see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    /// Number of changes before it; images of an older view are outdated.
    pub(super) number: u64,
    pub(super) camera: CameraSettings,
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    pub(super) integrator: Integrator,
    /// Most samples of a pixel.
    pub(super) max_spp: u32,
}

/// Estimated error after a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ErrorPoint {
    pub(super) spp: u32,
    /// Relative root mean square error, and its interval of 95 % confidence.
    pub(super) rmse: f64,
    pub(super) interval: [f64; 2],
}

/// Image of a view, and the work that it took.
#[derive(Clone, Debug, Default)]
pub(super) struct ViewImage {
    pub(super) view: u64,
    /// `None` before the first one.
    pub(super) film: Option<Arc<Image>>,
    /// Width and height of the image in pixels, and the side of a pixel of the film in these. The side is more than 1 in a
    /// coarse preview, whose last row and column may stand out.
    pub(super) size: [u32; 2],
    pub(super) pixel_side: u32,
    /// Samples that every pixel has; 0 for a coarse preview.
    pub(super) spp: u32,
    pub(super) mega_rays_per_second: f64,
    pub(super) seconds: f64,
    /// True if no better image follows.
    pub(super) is_finished: bool,
    pub(super) errors: Vec<ErrorPoint>,
}

/// State shared by the threads. `developments` are those of light and of views of geometry or cost.
#[derive(Debug)]
pub(super) struct State {
    pub(super) view: View,
    pub(super) controller: CameraController,
    pub(super) developments: [Development; 2],
    pub(super) image: ViewImage,
    /// Message to the user of the page.
    pub(super) message: Option<String>,
    /// Number of changes that a page can see.
    pub(super) version: u64,
    /// The renderer has not taken the view.
    is_pending: bool,
    picks: Vec<Pick>,
    last_request: Option<Instant>,
}

/// Pixel to be picked, and the channel for the id of the view and the picked object.
pub(super) type Pick = ([u32; 2], Sender<(u64, Option<PickResult>)>);

/// Next work of the renderer.
#[derive(Debug)]
pub(super) enum Task {
    Render(Box<View>),
    /// Compile the scene for the integrator of the view.
    Compile(Integrator),
    /// Answer these in the view of this number, which was rendered last.
    Pick(u64, Vec<Pick>),
}

impl State {
    pub(super) fn new(view: View, controller: CameraController, developments: [Development; 2]) -> Self {
        Self {
            view,
            controller,
            developments,
            image: ViewImage::default(),
            message: None,
            version: 0,
            is_pending: true,
            picks: Vec::new(),
            last_request: None,
        }
    }

    /// Development for an integrator. Views of geometry or cost are not exposed as light is.
    pub(super) const fn development(&mut self, integrator: Integrator) -> &mut Development {
        let [light, other] = &mut self.developments;
        if integrator.follows_light() { light } else { other }
    }

    fn has_client(&self) -> bool {
        self.last_request.is_some_and(|last| last.elapsed() < ABSENCE)
    }
}

/// [`State`] behind a lock. Each change is made as a whole, so that it is sound whichever thread panicked.
#[derive(Debug)]
pub(super) struct SharedState {
    state: Mutex<State>,
    changed: Condvar,
    /// Set while a render is outdated, or no page is open.
    interrupt: AtomicBool,
}

impl SharedState {
    pub(super) const fn new(state: State) -> Self {
        Self { state: Mutex::new(state), changed: Condvar::new(), interrupt: AtomicBool::new(false) }
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State>, time: Duration) -> MutexGuard<'a, State> {
        self.changed.wait_timeout(state, time).unwrap_or_else(PoisonError::into_inner).0
    }

    /// Interrupt flag of renders.
    pub(super) const fn interrupt(&self) -> &AtomicBool {
        &self.interrupt
    }

    /// Notes that a page is open.
    pub(super) fn see_client(&self) {
        self.lock().last_request = Some(Instant::now());
        self.changed.notify_all();
    }

    /// Restarts the render if the change affects the view. Pages receive the new state with the next image.
    pub(super) fn change_view<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        let mut state = self.lock();
        let before = state.view;
        let result = change(&mut state);
        if state.view != before {
            state.view.number = before.number + 1;
            (state.is_pending, state.message) = (true, None);
            self.interrupt.store(true, Ordering::Relaxed);
        }
        self.changed.notify_all();
        result
    }

    /// Queues a pixel to be picked.
    pub(super) fn pick(&self, pick: Pick) {
        self.lock().picks.push(pick);
        self.changed.notify_all();
    }

    /// Takes the picks. While the view that is being rendered is outdated there are none: they wait for the next one.
    pub(super) fn take_picks(&self) -> Vec<Pick> {
        let mut state = self.lock();
        if state.is_pending { Vec::new() } else { core::mem::take(&mut state.picks) }
    }

    /// Waits until a later version is published, or for the given time.
    pub(super) fn wait_for_version(&self, version: u64, time: Duration) -> MutexGuard<'_, State> {
        let deadline = Instant::now() + time;
        let mut state = self.lock();
        while state.version == version && Instant::now() < deadline {
            state = self.wait(state, deadline.saturating_duration_since(Instant::now()));
        }
        state
    }

    /// Waits for work with a plan for this integrator. No image is rendered while no page is open.
    pub(super) fn next_task(&self, integrator: Integrator) -> Task {
        let mut state = self.lock();
        loop {
            if !state.is_pending && !state.picks.is_empty() {
                return Task::Pick(state.view.number, core::mem::take(&mut state.picks));
            }
            if state.is_pending && state.has_client() {
                if state.view.integrator != integrator {
                    return Task::Compile(state.view.integrator);
                }
                state.is_pending = false;
                self.interrupt.store(false, Ordering::Relaxed);
                return Task::Render(Box::new(state.view));
            }
            state = self.wait(state, ABSENCE);
        }
    }

    /// True if the view that is being rendered is outdated.
    pub(super) fn is_outdated(&self) -> bool {
        self.lock().is_pending
    }

    /// Interrupts the render if no page is open.
    pub(super) fn pause_without_client(&self) {
        if !self.lock().has_client() {
            self.interrupt.store(true, Ordering::Relaxed);
        }
    }

    /// Waits until a page is open again. False if the view is outdated then.
    pub(super) fn wait_for_client(&self) -> bool {
        let mut state = self.lock();
        while !state.is_pending && !state.has_client() {
            state = self.wait(state, ABSENCE);
        }
        self.interrupt.store(state.is_pending, Ordering::Relaxed);
        !state.is_pending
    }

    /// Changes the published state.
    pub(super) fn show(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.lock();
        change(&mut state);
        state.version += 1;
        self.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::thread;

    use rt_camera::Projection;
    use rt_math::{DVec3, Transform};

    fn shared() -> SharedState {
        let place = Transform::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y).expect("a view");
        let camera = CameraSettings::new(place, Projection::Orthographic { height: 1.0 });
        let view = View { number: 0, camera, size: [4, 3], integrator: Integrator::Path, max_spp: 1 };
        let controller = CameraController::new(camera, 1.0).expect("a pose");
        SharedState::new(State::new(view, controller, [Development::default(); 2]))
    }

    fn render(shared: &SharedState, integrator: Integrator) -> View {
        match shared.next_task(integrator) {
            Task::Render(view) => *view,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_latest_view_is_rendered_and_the_one_before_is_outdated() {
        let shared = shared();
        shared.see_client();
        assert_eq!(render(&shared, Integrator::Path).number, 0);
        shared.change_view(|state| state.message = Some("no other view".to_owned()));
        assert!(!shared.is_outdated() && !shared.interrupt().load(Ordering::Relaxed));
        shared.change_view(|state| state.view.max_spp = 2);
        shared.change_view(|state| state.view.max_spp = 3);
        assert!(shared.is_outdated() && shared.interrupt().load(Ordering::Relaxed) && shared.lock().message.is_none());
        let view = render(&shared, Integrator::Path);
        assert_eq!((view.number, view.max_spp, shared.is_outdated()), (2, 3, false));
        shared.change_view(|state| state.view.integrator = Integrator::Depth);
        assert!(matches!(shared.next_task(Integrator::Path), Task::Compile(Integrator::Depth)));
        assert_eq!(render(&shared, Integrator::Depth).number, 3);
        shared.pick(([1, 2], channel().0));
        assert!(matches!(shared.next_task(Integrator::Depth), Task::Pick(3, picks) if picks[0].0 == [1, 2]));
    }

    #[test]
    fn picks_wait_for_the_view_that_replaces_an_outdated_one() {
        let shared = shared();
        shared.see_client();
        render(&shared, Integrator::Path);
        shared.change_view(|state| state.view.max_spp = 2);
        shared.pick(([1, 2], channel().0));
        assert!(shared.take_picks().is_empty(), "the renderer still has the outdated view");
        assert_eq!(render(&shared, Integrator::Path).number, 1);
        assert_eq!(shared.take_picks().len(), 1);
    }

    #[test]
    fn nothing_is_rendered_without_a_page() {
        let shared = shared();
        thread::scope(|scope| {
            let renderer = scope.spawn(|| render(&shared, Integrator::Path));
            thread::sleep(Duration::from_millis(50));
            assert!(!renderer.is_finished());
            shared.see_client();
            renderer.join().expect("no panic");
        });
        shared.pause_without_client();
        assert!(!shared.interrupt().load(Ordering::Relaxed));
        shared.lock().last_request = Instant::now().checked_sub(ABSENCE);
        shared.pause_without_client();
        assert!(shared.interrupt().load(Ordering::Relaxed));
        shared.see_client();
        assert!(shared.wait_for_client() && !shared.interrupt().load(Ordering::Relaxed));
        shared.change_view(|state| state.view.max_spp = 2);
        assert!(!shared.wait_for_client());
    }

    #[test]
    fn pages_wait_for_changes() {
        let shared = shared();
        thread::scope(|scope| {
            let page = scope.spawn(|| shared.wait_for_version(0, Duration::from_secs(60)).version);
            shared.show(|state| state.image = ViewImage::default());
            assert_eq!(page.join().expect("no panic"), 1);
        });
        assert_eq!(shared.wait_for_version(1, Duration::ZERO).version, 1);
    }
}
