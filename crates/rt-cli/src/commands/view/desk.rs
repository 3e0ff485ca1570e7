//! Where the window leaves what it wants to see, and the painter what it has painted.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use rt_camera::CameraSettings;

/// What the window wants to see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shot {
    pub(super) camera: CameraSettings,
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
}

/// A picture to show.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// Bytes 0, red, green, blue of each pixel, from the highest on, row by row.
    pub(super) pixels: Vec<u32>,
    /// Samples that every pixel has; 0 for a coarse picture.
    pub(super) spp: u32,
    /// True if nothing better follows.
    pub(super) is_refined: bool,
}

/// What the painter has to do next.
#[derive(Debug, PartialEq)]
pub(super) enum Order {
    /// Paint this.
    Paint(Box<Shot>),
    /// Say what this pixel shows.
    Pick([u32; 2]),
    /// Put the brush down.
    Close,
}

#[derive(Debug, Default)]
struct Papers {
    shot: Option<Shot>,
    pick: Option<[u32; 2]>,
    picture: Option<Picture>,
}

/// A desk between two threads. Only the latest of each paper lies on it.
#[derive(Debug, Default)]
pub(super) struct Desk {
    papers: Mutex<Papers>,
    arrived: Condvar,
    /// Set as long as the painter paints something that nobody wants any more.
    outdated: AtomicBool,
    closed: AtomicBool,
}

impl Desk {
    fn papers(&self) -> MutexGuard<'_, Papers> {
        // Papers are replaced as a whole, so that they are sound whoever panicked.
        self.papers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks for a picture in the place of all that was asked for before.
    pub(super) fn ask(&self, shot: Shot) {
        let mut papers = self.papers();
        papers.shot = Some(shot);
        self.outdated.store(true, Ordering::Relaxed);
        self.arrived.notify_all();
    }

    /// Asks what a pixel of the picture shows.
    pub(super) fn ask_for(&self, pixel: [u32; 2]) {
        self.papers().pick = Some(pixel);
        self.arrived.notify_all();
    }

    /// Asks for nothing any more.
    pub(super) fn close(&self) {
        let _papers = self.papers();
        self.closed.store(true, Ordering::Relaxed);
        self.outdated.store(true, Ordering::Relaxed);
        self.arrived.notify_all();
    }

    /// Waits for the next order.
    pub(super) fn next_order(&self) -> Order {
        let mut papers = self.papers();
        loop {
            if self.closed.load(Ordering::Relaxed) {
                return Order::Close;
            }
            if let Some(shot) = papers.shot.take() {
                self.outdated.store(false, Ordering::Relaxed);
                return Order::Paint(Box::new(shot));
            }
            if let Some(pixel) = papers.pick.take() {
                return Order::Pick(pixel);
            }
            papers = self.arrived.wait(papers).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// The pixel that was asked for last, if nobody has answered.
    pub(super) fn take_pick(&self) -> Option<[u32; 2]> {
        self.papers().pick.take()
    }

    /// Set when what is being painted is not wanted any more.
    pub(super) const fn outdated(&self) -> &AtomicBool {
        &self.outdated
    }

    /// Set when nothing is wanted any more.
    pub(super) const fn closed(&self) -> &AtomicBool {
        &self.closed
    }

    /// Hands a picture over in the place of the one before.
    pub(super) fn hand_over(&self, picture: Picture) {
        self.papers().picture = Some(picture);
    }

    /// The latest picture, if it has not been taken.
    pub(super) fn take_picture(&self) -> Option<Picture> {
        self.papers().picture.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    use rt_camera::Projection;
    use rt_math::Transform;

    fn shot(width: u32) -> Shot {
        let camera = CameraSettings::new(Transform::IDENTITY, Projection::Orthographic { height: 1.0 });
        Shot { camera, size: [width, 1] }
    }

    fn is_outdated(desk: &Desk) -> bool {
        desk.outdated().load(Ordering::Relaxed)
    }

    #[test]
    fn only_the_latest_shot_is_painted_and_the_one_before_is_outdated() {
        let desk = Desk::default();
        desk.ask(shot(1));
        desk.ask(shot(2));
        assert!(is_outdated(&desk));
        assert_eq!(desk.next_order(), Order::Paint(Box::new(shot(2))));
        assert!(!is_outdated(&desk));
        desk.ask_for([3, 4]);
        assert!(!is_outdated(&desk), "a question is no reason to paint anew");
        desk.ask(shot(5));
        assert!(is_outdated(&desk));
        assert_eq!((desk.next_order(), desk.next_order()), (Order::Paint(Box::new(shot(5))), Order::Pick([3, 4])));
    }

    #[test]
    fn whoever_waits_is_told() {
        let desk = Desk::default();
        thread::scope(|scope| {
            let painter = scope.spawn(|| [desk.next_order(), desk.next_order()]);
            desk.ask(shot(1));
            while desk.papers().shot.is_some() {
                thread::yield_now();
            }
            desk.close();
            assert_eq!(painter.join().expect("no panic"), [Order::Paint(Box::new(shot(1))), Order::Close]);
        });
        desk.ask(shot(2));
        assert_eq!(desk.next_order(), Order::Close);
        assert!(is_outdated(&desk) && desk.closed().load(Ordering::Relaxed));
    }
}
