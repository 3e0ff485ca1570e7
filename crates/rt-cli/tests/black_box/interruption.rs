//! Killed runs and broken pipes.

use std::time::Duration;

use crate::program::Workplace;

#[test]
fn a_kill_leaves_the_older_picture_and_nothing_else() {
    let place = Workplace::with_scene();
    place.write("scene.png", "older");
    for milliseconds in [20, 100, 400] {
        let mut child = place.command("render scene.ron --size 4000x4000 --spp 64 --quiet").spawn().expect("it starts");
        std::thread::sleep(Duration::from_millis(milliseconds));
        child.kill().expect("it runs");
        child.wait().expect("it ended");
        assert_eq!(place.files(), ["scene.png", "scene.ron"]);
        assert_eq!(place.read("scene.png"), b"older");
    }
}

#[test]
fn a_reader_that_leaves_costs_no_picture() {
    let place = Workplace::with_scene();
    let mut child = place.spawn("render scene.ron");
    drop(child.stdout.take());
    assert_eq!(child.wait().expect("it ended").code(), Some(0));
    assert_eq!(place.files(), ["scene.png", "scene.ron"]);
}

#[test]
fn long_text_stops_quietly_when_its_reader_leaves() {
    let place = Workplace::new();
    let mut child = place.spawn("schema");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ended");
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), [].as_slice()));
}
