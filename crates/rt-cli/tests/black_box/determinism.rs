//! Options that must not change a bit of the image.

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
