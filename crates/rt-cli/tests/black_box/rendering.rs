//! Images, and what options do to them.

#[cfg(target_os = "linux")]
use crate::program::{Run, signal, wait_until};
use crate::program::{SCENE, Workplace};

#[test]
fn three_lines_are_a_scene() {
    let place = Workplace::with("ball.ron", "(nodes: [\n    (shape: sphere()),\n])");
    place.prints("render ball.ron", "wrote ball.png (640x480, ");
    assert_eq!(place.files(), ["ball.png", "ball.ron"]);
    let film = place.film("ball.png");
    let brightness = |x, y| film.pixel(x, y).expect("inside").luminance();
    assert!(brightness(320, 240) > brightness(5, 5) + 0.05, "the ball stands out in the middle");
}

/// Its end is tested in the program, with fewer samples.
#[test]
#[cfg(target_os = "linux")]
fn no_command_renders_the_showcase() {
    let place = Workplace::new();
    let child = place.spawn("");
    // A signal that is handled saves the image as soon as a tile has begun.
    let handles_interrupts = |status: &str| {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or_default();
        u64::from_str_radix(mask.trim(), 16).is_ok_and(|mask| mask & 0b10 != 0)
    };
    let status = format!("/proc/{}/status", child.id());
    wait_until("the render", || std::fs::read_to_string(&status).is_ok_and(|status| handles_interrupts(&status)));
    std::thread::sleep(std::time::Duration::from_millis(300));
    signal(&child, "INT");
    let run = Run::end(child);
    assert_eq!(run.code, Some(130), "{run:?}");
    assert!(run.stdout.starts_with("rendering a built-in scene; --help lists all commands\n"), "{run:?}");
    assert_eq!(place.files(), ["still_life.png"]);
    let film = place.film("still_life.png");
    assert_eq!((film.width(), film.height()), (576, 360));
}

#[test]
fn every_format_is_written() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron -o a.pfm");
    let linear = place.film("a.pfm");
    for name in ["a.exr", "a.hdr", "a.png", "a.jpg"] {
        place.succeed(&format!("render scene.ron -o {name}"));
        let film = place.film(name);
        assert_eq!((film.width(), film.height()), (48, 32), "{name}");
        let exact = film.pixels() == linear.pixels();
        assert_eq!(exact, name == "a.exr", "{name}");
    }
}

#[test]
fn options_override_the_scene() {
    let place = Workplace::with_scene();
    let image = |options: &str| {
        place.succeed(&format!("render scene.ron --size 24x16 -o a.pfm {options}"));
        place.film("a.pfm")
    };
    let plain = image("");
    assert_eq!((plain.width(), plain.height()), (24, 16));
    for changed in [
        "--spp 16",
        "--max-depth 0",
        "--seed 1",
        "--sampler random",
        "--integrator normals",
        "--integrator depth",
        "--integrator uv",
        "--integrator cost",
        "--look-from 1,2,5",
        "--look-at 0,1,0",
        "--up 1,1,0",
        "--fov 50",
        "--background #ff8000",
    ] {
        assert_ne!(image(changed).pixels(), plain.pixels(), "{changed}");
    }
}

#[test]
fn a_camera_is_chosen_by_name() {
    let place = Workplace::new();
    let scene = "(cameras: [(name: \"front\", look_from: (0, 0, 5)), (name: \"side\", look_from: (5, 0, 0))],
        nodes: [(shape: sphere()), (shape: sphere(center: (3, 0, 0)))])";
    place.write("two.ron", scene);
    for (options, name) in [("", "first.pfm"), ("--camera front", "front.pfm"), ("--camera side", "side.pfm")] {
        place.succeed(&format!("render two.ron --size 16x12 --spp 1 {options} -o {name}"));
    }
    assert_eq!(place.read("first.pfm"), place.read("front.pfm"));
    assert_ne!(place.read("first.pfm"), place.read("side.pfm"));
}

#[test]
fn a_scene_without_a_command_is_rendered() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron --spp 4 -o x.png");
    for (arguments, file) in [("scene.ron --spp 4 -o y.png", "y.png"), ("--spp 4 scene.ron", "scene.png")] {
        place.succeed(arguments);
        assert!(place.read(file) == place.read("x.png"), "{arguments}");
    }
    place.fails(3, "missing.ron", "missing.ron: does not exist");
    place.fails(2, "rendr scene.ron", "'render'");
}

#[test]
fn rounded_samples_are_announced() {
    let place = Workplace::with_scene();
    place.prints(
        "render scene.ron --sampler jittered --spp 10",
        "note: 16 samples per pixel instead of 10: the next number that the sampler jittered supports\n",
    );
    let run = place.succeed("render scene.ron --spp 3 --passes 2");
    assert!(run.stdout.contains("note: 4 samples per pixel instead of 3: 2 passes of 2 sobol samples\n"), "{run:?}");
    let run = place.succeed("render scene.ron --sampler jittered --spp 16");
    assert!(!run.stdout.contains("note"), "{run:?}");
}

#[test]
fn a_transparent_background_becomes_alpha() {
    let place = Workplace::with("ball.ron", "(camera: (look_from: (0, 0, 5), fov: 40), nodes: [(shape: sphere())])");
    place.succeed("render ball.ron --size 33x33 --background transparent");
    let film = place.film("ball.png");
    let alpha = film.alpha().expect("an alpha channel");
    assert_eq!((alpha[0], alpha[16 * 33 + 16]), (0.0, 1.0));
    assert!(alpha.iter().any(|&a| 0.0 < a && a < 1.0), "the silhouette is soft");
    place.succeed("render ball.ron --size 33x33");
    assert_eq!(place.film("ball.png").alpha(), None);
}

#[test]
fn quiet_prints_nothing() {
    let place = Workplace::with_scene();
    let run = place.succeed("render scene.ron --quiet --spp 3");
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    assert_eq!(place.files(), ["scene.png", "scene.ron"]);
}

#[test]
fn convert_and_develop_are_quiet_on_demand() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron -o linear.exr --quiet");
    for command in ["convert scene.ron -o copy.json -q", "develop linear.exr -o linear.png --quiet"] {
        let run = place.succeed(command);
        assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""), "{command}");
    }
}

#[test]
fn developing_later_equals_developing_at_once() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron -o linear.exr");
    for (name, options) in [("plain", ""), ("tuned", "--exposure -1.5 --tone aces")] {
        place.succeed(&format!("render scene.ron -o {name}.png {options}"));
        place.succeed(&format!("develop linear.exr -o later.png {options}"));
        assert_eq!(place.read(&format!("{name}.png")), place.read("later.png"), "{name}");
    }
    assert_ne!(place.read("plain.png"), place.read("tuned.png"));
    place.succeed("develop linear.exr -o gamma.png --gamma 2.2");
    assert_ne!(place.read("plain.png"), place.read("gamma.png"));
}

#[test]
fn bad_samples_warn_and_are_an_error_under_strict() {
    let place = Workplace::new();
    // Two mirrors that brighten what they show, face to face: the radiance overflows.
    let scene =
        "(film: (size: (16, 12)), camera: (look_from: (0, 1, 3)), settings: (integrator: whitted, max_depth: 8),
        materials: {\"glare\": phong(emission: gray(1), mirror: gray(1e60))},
        nodes: [
            (shape: plane(), material: \"glare\"),
            (shape: plane(point: (0, 2, 0), normal: (0, -1, 0)), material: \"glare\"),
        ])";
    place.write("glare.ron", scene);
    let run = place.succeed("render glare.ron");
    assert!(run.stderr.contains("samples were NaN, infinite or negative"), "{run:?}");
    let lenient = place.read("glare.png");
    let run = place.run("render glare.ron --strict -o strict.png");
    assert_eq!(run.code, Some(5), "{run:?}");
    assert_eq!(place.read("strict.png"), lenient, "the image is worth keeping");
}

#[test]
fn notes_on_a_placed_camera_claim_no_more_than_options_leave() {
    let place = Workplace::with("sphere.ron", "(nodes: [(shape: sphere())])");
    let notes = |options: &str| {
        let run = place.succeed(&format!("render sphere.ron --size 8x8 {options}"));
        run.stdout.lines().filter(|line| line.contains("camera")).map(str::to_owned).collect::<Vec<_>>()
    };
    let note = "note: The camera has no position: it looks from [2.163, 1.731, 4.327] at [0, 0, 0]";
    assert_eq!(notes(""), [format!("{note}, and shows the whole scene.")]);
    assert_eq!(notes("--fov 10"), [format!("{note}.")]);
    assert!(notes("--look-from 0,0,5 --look-at 0,0,0").is_empty());
}

#[test]
fn light_of_caustics_beyond_the_largest_radiance_is_reported() {
    let scene = |radiance: &str| {
        format!(
            "(nodes: [(shape: sphere(), material: glass()), (shape: plane(point: (0, -1, 0)))],
            lights: [sphere(center: (0, 3, 0), radius: 0.1, radiance: {radiance})],
            settings: (integrator: path_caustics), camera: (look_from: (0, 3, 5)))"
        )
    };
    let place = Workplace::with("bright.ron", scene("1e16"));
    place.write("dim.ron", scene("10"));
    let arguments = "--size 24x18 --spp 16 --stats stats.json";
    for threads in [1, 3] {
        let run = place.succeed(&format!("render bright.ron -o bright.exr --threads {threads} {arguments}"));
        let warning = "warning: the light of caustics was cut off at a radiance of 2^41 in ";
        assert_eq!(run.stderr.matches(warning).count(), 1, "{run:?}");
        let pixels = &place.json("stats.json")["saturated_pixels"];
        assert!(pixels.as_u64() > Some(0) && run.stderr.contains(&format!("in {pixels} pixels")), "{pixels}: {run:?}");
    }
    place.fails(
        5,
        &format!("render bright.ron -o strict.exr --strict {arguments}"),
        "the image was written to strict.exr",
    );
    let run = place.succeed(&format!("render dim.ron {arguments}"));
    assert!(run.stderr.is_empty() && place.json("stats.json")["saturated_pixels"] == 0, "{run:?}");
}

#[test]
fn views_of_geometry_do_not_depend_on_the_exposure_of_the_scene() {
    let place = Workplace::with_scene();
    place.write("sunlit.ron", SCENE.replace("film: (", "film: (exposure: -16, tone: aces, "));
    let view = |scene: &str, options: &str| {
        place.succeed(&format!("render {scene} -o a.png --integrator normals {options}"));
        place.read("a.png")
    };
    let plain = view("scene.ron", "");
    assert!(view("sunlit.ron", "") == plain);
    assert!(view("sunlit.ron", "--exposure -16") != plain, "unless it is asked for");
}

#[test]
fn older_spellings_of_options_and_values_are_accepted() {
    let place = Workplace::with_scene();
    let image = |options: &str| {
        place.succeed(&format!("render scene.ron -o a.pfm {options}"));
        place.read("a.pfm")
    };
    for (base, new, old) in [
        ("", "--max-depth 1", "--depth 1"),
        ("--spp 16", "--adaptive object-space --min-spp 2", "--adaptive object-space --least 2"),
        ("", "--integrator path-caustics", "--integrator caustics"),
        ("", "--background #f00", "--background #ff0000"),
        ("", "--background 0.5", "--background 0.5,0.5,0.5"),
    ] {
        let [plain, new_image, old_image] = [base, &format!("{base} {new}"), &format!("{base} {old}")].map(image);
        assert!(new_image == old_image && new_image != plain, "{new} and {old}");
    }
    for name in ["stderr", "variance"] {
        place.succeed(&format!("render scene.ron --spp 16 --passes 4 --aov {name}={name}.pfm"));
    }
    assert!(place.read("stderr.pfm") == place.read("variance.pfm"));
}

#[test]
fn options_without_effect_are_noted() {
    let place = Workplace::with_scene();
    place.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (arguments, note) in [
        ("scene.ron --at-time 1", "the time of --at-time or --frames has no effect: nothing in scene.ron is animated."),
        ("m.obj --frames 3", "the time of --at-time or --frames has no effect: nothing in m.obj is animated."),
        ("scene.ron --fps 12", "--fps has no effect: no animation is shown; --frames and --at-time choose a time."),
        ("m.obj --variant blue", "--variant has no effect: m.obj has no glTF model."),
        ("scene.ron --ground", "--ground has no effect on scene files."),
        ("scene.ron --shutter 0,1", "--shutter has no effect: nothing in scene.ron moves while it is open."),
        ("scene.ron --build-quality low --accel kd", "--build-quality has no effect on kd: only bvh8 has it."),
        (
            "scene.ron --light-sampling power",
            "--light-sampling has no effect: the scene has no area light and no environment image.",
        ),
    ] {
        let run = place.succeed(&format!("render {arguments} --size 8x8 --spp 1 -o out.png"));
        assert!(run.stdout.contains(&format!("note: {note}\n")), "{arguments}: {run:?}");
    }
    let animated = Workplace::with_animated_model();
    for arguments in ["m.gltf --at-time 0.25", "m.gltf --at-time 0.25 --fps 12 --shutter 0,0.5"] {
        let run = animated.succeed(&format!("render {arguments} --size 8x8 --spp 1 -o out.png"));
        assert!(!run.stdout.contains("no effect"), "{arguments}: {run:?}");
    }
}

#[test]
fn a_missing_error_estimate_is_explained_once() {
    let run = Workplace::with_scene().succeed("render scene.ron --verbose");
    assert_eq!(run.stdout.matches("no error estimate: needs at least two passes").count(), 1, "{run:?}");
}

#[test]
fn a_directory_in_place_of_the_scene_is_named_as_one() {
    let place = Workplace::new();
    for scene in [".", "..", "/"] {
        place.fails(3, &format!("render {scene}"), &format!("error: {scene}: is a directory"));
    }
    place.fails(3, "render missing/..", "error: missing/..: ");
    assert!(place.files().is_empty());
}
