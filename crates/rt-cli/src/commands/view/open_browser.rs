//! The browser of the desktop.

use std::env;
use std::process::{Command, Stdio};
use std::thread;

/// Opens an address, if there is a desktop on this machine. The address is printed as well, so that failures do no harm.
pub(super) fn open(url: &str) {
    let is_remote = env::var_os("SSH_CONNECTION").is_some();
    let has_screen = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| env::var_os(name).is_some());
    let mut command = if cfg!(windows) {
        let mut command = Command::new("cmd");
        command.args(["/C", "start", ""]);
        command
    } else if cfg!(target_os = "macos") {
        Command::new("open")
    } else if has_screen {
        Command::new("xdg-open")
    } else {
        return;
    };
    if is_remote {
        return;
    }
    command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if let Ok(mut child) = command.spawn() {
        thread::spawn(move || child.wait());
    }
}
