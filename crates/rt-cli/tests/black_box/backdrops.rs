//! Scenes that are lit by an image and shown before something else.

use rt_image::Image;

use crate::program::Workplace;

/// A grey ball, lit by a sky that is bright above and dark below.
fn place() -> Workplace {
    let place = Workplace::with(
        "ball.ron",
        "(camera: (look_from: (0, 0, 5), fov: 40), film: (size: (33, 33)), settings: (spp: 16), lights: [],
          materials: {\"grey\": phong(color: gray(0.5))}, nodes: [(shape: sphere(), material: \"grey\")])",
    );
    let mut sky = Image::new(16, 8, false);
    for (index, pixel) in sky.pixels_mut().iter_mut().enumerate() {
        *pixel = if index < 64 { [2.0, 2.0, 1.0] } else { [0.1, 0.1, 0.2] };
    }
    place.save("sky.exr", &sky);
    place
}

const CORNER: usize = 0;
const MIDDLE: usize = 16 * 33 + 16;

#[test]
fn an_image_lights_a_scene_before_a_colour_or_nothing() {
    let place = place();
    for integrator in ["path", "direct", "whitted", "distributed"] {
        let render = |options: &str| {
            place.succeed(&format!("render ball.ron --env sky.exr --integrator {integrator} -o a.exr {options}"));
            place.film("a.exr")
        };
        let (plain, flat, clear) =
            (render(""), render("--background 0.25,0.5,0.75"), render("--background transparent"));
        assert_eq!(flat.pixels()[CORNER], [0.25, 0.5, 0.75], "{integrator}");
        assert_eq!(plain.pixels()[CORNER], [2.0, 2.0, 1.0], "{integrator}");
        assert_eq!(
            (clear.alpha().map(|alpha| [alpha[CORNER], alpha[MIDDLE]]), clear.pixels()[CORNER]),
            (Some([0.0, 1.0]), [0.0; 3])
        );
        // The ball is lit by the image all the same.
        for film in [&flat, &clear] {
            assert_eq!(film.pixels()[MIDDLE], plain.pixels()[MIDDLE], "{integrator}");
        }
        if matches!(integrator, "path" | "direct") {
            assert!(plain.pixels()[MIDDLE][0] > 0.1, "{integrator}: {:?}", plain.pixels()[MIDDLE]);
        }
    }
}

#[test]
fn mirrors_show_the_image_and_not_the_backdrop() {
    let place = place();
    place.write(
        "mirror.ron",
        "(camera: (look_from: (0, 0, 5), fov: 40), film: (size: (33, 33)), lights: [],
          materials: {\"mirror\": phong(diffuse: gray(0), mirror: gray(1))}, nodes: [(shape: sphere(), material: \"mirror\")])",
    );
    place.succeed("render mirror.ron --env sky.exr --background white -o a.exr");
    let film = place.film("a.exr");
    assert_eq!(film.pixels()[CORNER], [1.0; 3]);
    assert!(
        film.pixels()[12 * 33 + 16][2] < 1.01 && film.pixels()[12 * 33 + 16][0] > 1.5,
        "{:?}",
        film.pixels()[12 * 33 + 16]
    );
    let text = place.succeed("explain mirror.ron --env sky.exr --background white").stdout;
    assert!(text.contains("\n  backdrop: "), "{text}");
}
