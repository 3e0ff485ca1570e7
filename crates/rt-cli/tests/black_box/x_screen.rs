//! A screen that nobody sees (Xvfb), and hands on its mouse and keyboard.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConfigureWindowAux, ConnectionExt as _, ImageFormat, InputFocus, MapState, Window};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

const KEY_PRESS: u8 = 2;
const KEY_RELEASE: u8 = 3;
const BUTTON_PRESS: u8 = 4;
const BUTTON_RELEASE: u8 = 5;
const MOTION: u8 = 6;

/// A screen of 400×300 pixels, and a connection to it.
pub(crate) struct Screen {
    server: Child,
    pub(crate) display: String,
    connection: RustConnection,
    root: Window,
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Screen {
    /// `None` where there is no Xvfb.
    pub(crate) fn start() -> Option<Self> {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "400x300x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        BufReader::new(server.stdout.take().expect("a pipe")).read_line(&mut number).expect("a number");
        let display = format!(":{}", number.trim());
        let (connection, screen) = x11rb::connect(Some(&display)).expect("a connection");
        let root = connection.setup().roots[screen].root;
        Some(Self { server, display, connection, root })
    }

    /// The largest window that is to be seen.
    pub(crate) fn window(&self) -> Option<Window> {
        let children = self.connection.query_tree(self.root).ok()?.reply().ok()?.children;
        let is_mapped = |window: &Window| {
            let attributes = self.connection.get_window_attributes(*window).ok().and_then(|cookie| cookie.reply().ok());
            attributes.is_some_and(|attributes| attributes.map_state == MapState::VIEWABLE)
        };
        let area =
            |window: &Window| self.size(*window).map_or(0, |[width, height]| u32::from(width) * u32::from(height));
        children.into_iter().filter(is_mapped).max_by_key(area)
    }

    fn size(&self, window: Window) -> Option<[u16; 2]> {
        let geometry = self.connection.get_geometry(window).ok()?.reply().ok()?;
        Some([geometry.width, geometry.height])
    }

    /// Width and height of the window, and red, green and blue of its pixels, row by row.
    pub(crate) fn picture(&self, window: Window) -> ([u16; 2], Vec<u8>) {
        let size = self.size(window).expect("a window");
        let cookie = self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, size[0], size[1], !0);
        let data = cookie.expect("sent").reply().expect("an image").data;
        (size, data.chunks_exact(4).flat_map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect())
    }

    pub(crate) fn resize(&self, window: Window, [width, height]: [u32; 2]) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &size).expect("sent").check().expect("resized");
    }

    /// Gives the keyboard to a window: there is no window manager that does.
    pub(crate) fn focus(&self, window: Window) {
        self.connection.set_input_focus(InputFocus::PARENT, window, 0u32).expect("sent").check().expect("focused");
    }

    fn input(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        let cookie = self.connection.xtest_fake_input(kind, detail, 0, self.root, x, y, 0);
        cookie.expect("sent").check().expect("put in");
    }

    pub(crate) fn press(&self, key: u32) {
        self.input(KEY_PRESS, self.key_code(key), [0; 2]);
    }

    pub(crate) fn release(&self, key: u32) {
        self.input(KEY_RELEASE, self.key_code(key), [0; 2]);
    }

    /// Presses and releases the key of this symbol.
    pub(crate) fn strike(&self, key: u32) {
        self.press(key);
        self.release(key);
    }

    pub(crate) fn move_to(&self, place: [i16; 2]) {
        self.input(MOTION, 0, place);
    }

    pub(crate) fn button(&self, button: u8, is_down: bool) {
        self.input(if is_down { BUTTON_PRESS } else { BUTTON_RELEASE }, button, [0; 2]);
    }

    /// Clicks with the left button.
    pub(crate) fn click(&self, place: [i16; 2]) {
        self.move_to(place);
        self.button(1, true);
        self.button(1, false);
    }

    fn key_code(&self, symbol: u32) -> u8 {
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let mapping =
            self.connection.get_keyboard_mapping(first, last - first + 1).expect("sent").reply().expect("keys");
        let keys = mapping.keysyms.chunks(mapping.keysyms_per_keycode.into());
        first + keys.into_iter().position(|symbols| symbols.contains(&symbol)).expect("a key") as u8
    }
}
