//! The window, on a screen that nobody sees. Where there is no Xvfb, these tests are skipped.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use rt_image::{Development, read_image};

use crate::program::Workplace;
use crate::x_screen::Screen;

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);

/// Symbols of keys.
const ESCAPE: u32 = 0xff1b;
const RIGHT: u32 = 0xff53;
const UP: u32 = 0xff52;

fn letter(letter: char) -> u32 {
    letter.into()
}

/// The camera of [`BALLS`].
const CAMERA: &str = "camera: (look_from: (0, 0, 6), look_at: (0, 0, 0), fov: 40),";

/// Two balls side by side, in front of nothing.
const BALLS: &str = r#"(
    camera: (look_from: (0, 0, 6), look_at: (0, 0, 0), fov: 40),
    film: (size: (96, 64)),
    background: gradient(bottom: gray(0.1), top: rgb(0.2, 0.4, 0.9)),
    lights: [point(position: (-4, 6, 5), intensity: gray(0.8))],
    materials: {
        "red": phong(color: rgb(0.9, 0.1, 0.1), specular: gray(0.3)),
        "mirror": phong(diffuse: gray(0.1), mirror: gray(0.8)),
    },
    nodes: [
        (name: "left ball", shape: sphere(center: (-1.5, 0, 0), radius: 1), material: "red"),
        (name: "right ball", shape: sphere(center: (1.5, 0, 0), radius: 1), material: "mirror"),
    ],
)"#;

/// A program with a window, on a screen of its own.
struct Viewer {
    place: Workplace,
    screen: Screen,
    program: Child,
    lines: Receiver<String>,
    window: u32,
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

impl Viewer {
    /// Looks at a scene until it is refined; `None` where there is no screen.
    fn open(scene: &str, options: &str) -> Option<Self> {
        let Some(screen) = Screen::start() else {
            rt_tests::skip("there is no Xvfb to open a window on");
            return None;
        };
        let place = Workplace::new();
        place.write("scene.ron", scene);
        let mut command = place.command(&format!("view scene.ron {options}"));
        command.env("DISPLAY", &screen.display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        let mut program = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let output = BufReader::new(program.stdout.take().expect("a pipe"));
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || output.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        let mut viewer = Self { place, screen, program, lines, window: 0 };
        viewer.wait_for("refined: ");
        viewer.window = viewer.screen.window().expect("a window");
        viewer.screen.focus(viewer.window);
        Some(viewer)
    }

    /// The next line that begins so.
    fn wait_for(&self, beginning: &str) -> String {
        loop {
            let line = self.lines.recv_timeout(PATIENCE).unwrap_or_else(|error| panic!("{beginning:?}: {error}"));
            if line.starts_with(beginning) {
                return line;
            }
        }
    }

    /// What `P` prints.
    fn print_camera(&self) -> String {
        self.screen.strike(letter('p'));
        let mut text = vec![self.wait_for("camera: (")];
        while text.last().is_some_and(|line| line != "),") {
            text.push(self.lines.recv_timeout(PATIENCE).expect("the end of the camera"));
        }
        text.join("\n")
    }

    /// The window shows what `render` writes of the scene with this camera, to the bit.
    fn assert_shows(&self, scene: &str, camera: &str, options: &str) {
        assert!(scene.contains(CAMERA));
        self.place.write("pasted.ron", scene.replace(CAMERA, camera));
        self.place.succeed(&format!("render pasted.ron {options} --time 1h -o pasted.png"));
        let film = read_image(&self.place.path("pasted.png")).expect("a picture");
        let expected = Development::default().develop(&film);
        let deadline = Instant::now() + Duration::from_secs(10);
        loop {
            let (size, bytes) = self.screen.picture(self.window);
            if (size.map(u32::from), &bytes) == ([expected.width, expected.height], &expected.bytes) {
                return;
            }
            let wrong = bytes.iter().zip(&expected.bytes).filter(|(a, b)| a != b).count();
            assert!(Instant::now() < deadline, "{options}: {wrong} of {} bytes differ, {size:?}", bytes.len());
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Closes the window with the keyboard.
    fn quit(mut self) {
        self.screen.strike(ESCAPE);
        assert_eq!(self.program.wait().expect("it ended").code(), Some(0));
    }
}

#[test]
fn the_window_shows_what_render_writes() {
    for options in ["--spp 6", "--spp 4 --integrator path --exposure 1 --look-from 2,1,5 --threads 2"] {
        let Some(viewer) = Viewer::open(BALLS, options) else { return };
        viewer.assert_shows(BALLS, CAMERA, options);
        viewer.quit();
    }
}

#[test]
fn keys_and_mouse_lead_the_camera_and_the_printed_one_shows_the_same() {
    let Some(viewer) = Viewer::open(BALLS, "--spp 4") else { return };
    let screen = &viewer.screen;
    let unmoved = viewer.print_camera();
    assert!(unmoved.contains("look_from: (0.0, 0.0, 6.0)") && unmoved.contains("fov: 40.0"), "{unmoved}");
    let mut cameras = vec![unmoved];
    let mut is_elsewhere = |what: &str| {
        viewer.wait_for("refined: 4 samples per pixel");
        // Keys that are held, and the wheel, refine more than once.
        thread::sleep(Duration::from_millis(300));
        let camera = viewer.print_camera();
        assert!(!cameras.contains(&camera), "{what}: {camera}");
        viewer.assert_shows(BALLS, &camera, "--spp 4");
        cameras.push(camera);
    };
    screen.strike(RIGHT);
    screen.strike(UP);
    is_elsewhere("arrows");
    screen.press(letter('w'));
    thread::sleep(Duration::from_millis(200));
    screen.release(letter('w'));
    is_elsewhere("flight");
    for (button, what) in [(1, "orbit"), (2, "shift"), (3, "look")] {
        screen.move_to([40, 30]);
        screen.button(button, true);
        screen.move_to([48, 27]);
        screen.move_to([50, 26]);
        screen.button(button, false);
        is_elsewhere(what);
    }
    screen.button(4, true);
    screen.button(4, false);
    is_elsewhere("wheel");
    screen.strike(letter('r'));
    viewer.wait_for("refined: ");
    assert_eq!(viewer.print_camera(), cameras[0]);
    viewer.assert_shows(BALLS, CAMERA, "--spp 4");
    viewer.quit();
}

#[test]
fn a_click_tells_what_is_there() {
    let Some(viewer) = Viewer::open(BALLS, "--spp 1") else { return };
    // A distance of 6 and 40 degrees across 64 pixels: the balls' centres are 22 pixels from the middle.
    viewer.screen.click([26, 32]);
    let line = viewer.wait_for("picked ");
    assert!(line.starts_with("picked 'left ball', material 'red', distance 5."), "{line}");
    let numbers: Vec<f64> =
        line.split(|c: char| !(c.is_ascii_digit() || "-.".contains(c))).filter_map(|n| n.parse().ok()).collect();
    let [distance, x, y, z] = numbers[..] else { panic!("{line}") };
    assert!(((x + 1.5) * (x + 1.5) + y * y + z * z - 1.0).abs() < 1e-5, "not on the ball: {line}");
    assert!((x * x + y * y + (z - 6.0) * (z - 6.0) - distance * distance).abs() < 1e-4, "{line}");
    viewer.screen.click([70, 32]);
    assert!(viewer.wait_for("picked ").starts_with("picked 'right ball', material 'mirror'"));
    viewer.screen.strike(letter('f'));
    viewer.wait_for("refined: ");
    viewer.screen.click([48, 32]);
    assert!(viewer.wait_for("picked ").starts_with("picked 'right ball'"), "F turns to what was picked");
    viewer.screen.click([0, 0]);
    assert_eq!(viewer.wait_for("picked "), "picked the background");
    viewer.screen.strike(letter('h'));
    assert!(viewer.wait_for("left button").contains("orbit"));
    viewer.quit();
}

#[test]
fn a_window_of_another_size_shows_a_picture_of_that_size() {
    let Some(viewer) = Viewer::open(BALLS, "--spp 2") else { return };
    for size in [[120, 80], [33, 47]] {
        viewer.screen.resize(viewer.window, size);
        viewer.wait_for("refined: ");
        viewer.assert_shows(BALLS, CAMERA, &format!("--spp 2 --size {}x{}", size[0], size[1]));
    }
    viewer.quit();
}

#[test]
fn without_a_screen_there_is_a_message_and_no_panic() {
    let place = Workplace::with_scene();
    let mut command = place.command("view scene.ron");
    command.env("DISPLAY", ":59999").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let output = command.output().expect("it starts");
    let stderr = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(
        stderr.starts_with("error: no window can be opened: ") && stderr.contains("`render` needs none"),
        "{stderr}"
    );
    assert!(!stderr.contains(".rs:"), "the place in a library helps no user: {stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

#[test]
fn options_that_mean_nothing_to_a_window_are_refused() {
    let place = Workplace::with_scene();
    for option in ["--crop 0,0,8,8", "--passes 2", "--adaptive object-space", "--min-spp 1"] {
        let run = place.run(&format!("view scene.ron {option}"));
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains("is for `render`"), "{run:?}");
    }
}
