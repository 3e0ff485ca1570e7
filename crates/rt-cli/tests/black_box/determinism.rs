//! Options that must not change a bit of the image.

use rt_image::Image;

use crate::program::Workplace;

#[test]
fn options_without_influence_change_no_bit() {
    let place = Workplace::with_scene();
    std::fs::create_dir(place.path("dir")).expect("created");
    let image = |options: &str| {
        place.succeed(&format!("render scene.ron -o a.pfm {options}"));
        place.read("a.pfm")
    };
    let plain = image("");
    let threads = ["--threads 1", "--threads 2", "--threads 3", "--threads 8"];
    let accels =
        ["--accel auto", "--accel linear", "--accel grid", "--accel bvh", "--accel bvh8", "--accel sphere-tree"];
    let plans = ["--full-plan", "--accel grid --full-plan", "--stats stats.json", "--build-quality high"];
    let of_scene = ["--spp 4", "--max-depth 3", "--sampler sobol", "--fov 40", "--look-from 0,1,6 --look-at 0,0.5,0"];
    // Older spellings of options and values.
    let older = ["--accel wide", "--accel spheres", "--accel cylinders", "--quality low", "--root .", "--fallback dir"];
    for options in [&threads[..], &accels, &plans, &of_scene, &older].concat() {
        assert!(image(options) == plain, "{options}");
    }
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
