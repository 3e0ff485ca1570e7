//! Gradients in images of 8 bits.

use rt_image::Development;

use crate::program::Workplace;

/// A sky that changes by about two levels from the top of the image to its bottom.
const SKY: &str = "(
    camera: (look_from: (0, 0, 5), fov: 20), film: (size: (96, 96)),
    background: gradient(bottom: gray(0.2), top: gray(0.23)),
    nodes: [(shape: sphere(center: (0, 0, 100)))],
)";

fn sky() -> Workplace {
    Workplace::with("sky.ron", SKY)
}

#[test]
fn gradients_show_no_bands() {
    let place = sky();
    place.succeed("render sky.ron -o sky.pfm");
    place.succeed("render sky.ron -o sky.png");
    place.succeed("render sky.ron --dither off -o banded.png");
    let development = Development::default();
    let (linear, dithered, banded) = (place.film("sky.pfm"), place.film("sky.png"), place.film("banded.png"));
    // Means over blocks, in levels.
    let mean = |film: &rt_image::Image, block: usize| {
        let inside =
            (0..16 * 16).map(|index| film.pixels()[(block / 6 * 16 + index / 16) * 96 + block % 6 * 16 + index % 16]);
        inside.map(|pixel| 255.0 * development.signal(pixel[1])).sum::<f64>() / 256.0
    };
    let worst = |film| (0..36).map(|block| (mean(film, block) - mean(&linear, block)).abs()).fold(0.0, f64::max);
    assert!(worst(&dithered) < 0.04, "{}", worst(&dithered));
    assert!(worst(&banded) > 0.3, "{}", worst(&banded));
    // Each pixel is one of the two nearest levels.
    for (a, b) in linear.pixels().as_flattened().iter().zip(dithered.pixels().as_flattened()) {
        let [exact, stored] = [a, b].map(|&value| 255.0 * development.signal(value));
        assert!((exact - stored).abs() < 1.0, "{exact} {stored}");
    }
}

#[test]
fn dithering_knows_nothing_but_the_place_in_the_image() {
    let place = sky();
    place.succeed("render sky.ron -o whole.png");
    place.succeed("render sky.ron --threads 1 --accel bvh -o again.png");
    assert!(place.read("whole.png") == place.read("again.png"));
    place.succeed("render sky.ron --crop 21,13,40,30 -o crop.png");
    let (whole, crop) = (place.film("whole.png"), place.film("crop.png"));
    for y in 0..30 {
        assert_eq!(crop.pixels()[y * 40..][..40], whole.pixels()[(y + 13) * 96 + 21..][..40], "row {y}");
    }
    for part in 1..=2 {
        place.succeed(&format!("render sky.ron --shard {part}/2 -o {part}.part"));
        place.succeed(&format!("render sky.ron --crop 21,13,40,30 --shard {part}/2 -o crop-{part}.part"));
    }
    place.succeed("merge 1.part 2.part -o merged.png");
    assert!(place.read("merged.png") == place.read("whole.png"));
    place.succeed("merge crop-1.part crop-2.part -o merged.png");
    assert!(place.read("merged.png") == place.read("crop.png"));
    place.succeed("render sky.ron -o linear.exr");
    place.succeed("develop linear.exr -o later.png");
    assert!(place.read("later.png") == place.read("whole.png"));
    place.succeed("compare linear.exr whole.png");
}

#[test]
fn dithering_is_left_out_where_the_scene_or_the_user_says_so() {
    let place = sky();
    place.write("plain.ron", SKY.replace("film: (", "film: (dither: false, "));
    let render = |options: &str| {
        place.succeed(&format!("render {options} -o a.png"));
        place.read("a.png")
    };
    let (dithered, plain) = (render("sky.ron"), render("sky.ron --dither none"));
    assert!(dithered != plain);
    assert!(render("plain.ron") == plain && render("plain.ron --dither on") == dithered);
    place.succeed("render sky.ron -o linear.exr");
    place.succeed("develop linear.exr --dither none -o later.png");
    assert!(place.read("later.png") == plain);
}
