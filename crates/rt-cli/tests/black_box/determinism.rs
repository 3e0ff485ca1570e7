//! Options that must not change a bit of the image.

use rt_image::Image;

use crate::program::Workplace;

fn all_equal(options: &[&str]) {
    let place = Workplace::with_scene();
    let pictures: Vec<_> = options
        .iter()
        .map(|options| {
            place.succeed(&format!("render scene.ron -o a.pfm {options}"));
            place.read("a.pfm")
        })
        .collect();
    for (picture, options) in pictures.iter().zip(options) {
        assert!(*picture == pictures[0], "{options}");
    }
}

#[test]
fn threads_change_nothing() {
    all_equal(&["--threads 1", "--threads 2", "--threads 3", "--threads 8", ""]);
}

#[test]
fn structures_change_nothing() {
    all_equal(&["--accel auto", "--accel linear", "--accel grid", "--accel bvh"]);
}

#[test]
fn leaving_out_changes_nothing() {
    all_equal(&["", "--full-plan", "--accel grid --full-plan"]);
}

#[test]
fn counting_changes_nothing() {
    all_equal(&["", "--stats stats.json"]);
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron -o whole.exr --background transparent");
    place.succeed("render scene.ron -o part.exr --background transparent --crop 13,5,20,11");
    let (whole, part) = (place.film("whole.exr"), place.film("part.exr"));
    assert_eq!((part.width(), part.height()), (20, 11));
    let alpha = |film: &Image, x: u32, y: u32| film.alpha().expect("alpha")[(y * film.width() + x) as usize];
    for y in 0..11 {
        for x in 0..20 {
            assert_eq!(part.pixel(x, y), whole.pixel(13 + x, 5 + y), "{x} {y}");
            assert_eq!(alpha(&part, x, y), alpha(&whole, 13 + x, 5 + y), "{x} {y}");
        }
    }
}
