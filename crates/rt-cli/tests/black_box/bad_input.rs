//! Whatever is wrong: one clear message, the right exit code, and no file is touched.

use std::fmt::Write;

use crate::program::{SCENE, Workplace};

/// Runs each case in a folder of its own, and collects what the program says.
fn messages(code: i32, cases: &[(&str, &str, &str)]) -> String {
    let mut said = String::new();
    for (case, scene, arguments) in cases {
        let place = Workplace::with("scene.ron", scene);
        place.write("older.png", "older");
        place.write("locked.png", "locked");
        lock(&place.path("locked.png"));
        std::fs::create_dir(place.path("folder.png")).expect("created");
        let before = place.files();
        let run = place.run(arguments);
        assert_eq!(run.code, Some(code), "{case}: {run:?}");
        assert_eq!(run.stdout, "", "{case}");
        assert_eq!(place.files(), before, "{case}");
        assert_eq!(place.read("older.png"), b"older", "{case}");
        assert_eq!(place.read("scene.ron"), scene.as_bytes(), "{case}");
        if code != 2 {
            // The lines below a message show the place in the file.
            let messages = run.stderr.lines().filter(|line| !line.starts_with(' '));
            assert_eq!(messages.count(), 1, "{case}: {run:?}");
        }
        let message = run.stderr.split("\n\nUsage").next().unwrap_or_default();
        writeln!(said, "# {case}\n{}\n", message.trim_end()).expect("memory");
    }
    said
}

fn lock(path: &std::path::Path) {
    let mut permissions = std::fs::metadata(path).expect("there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(path, permissions).expect("set");
}

const GOOD: &str = "(film: (size: (8, 8)), nodes: [(shape: sphere())])";

/// The test `bad_inputs` has the kinds of bad scenes; these are about what else is given or there.
#[test]
fn bad_scenes_end_with_code_3() {
    let render = "render scene.ron -o older.png";
    let textured = "(materials: {\"wood\": phong(color: image(file: \"older.png\"))}, nodes: [(shape: sphere(), material: \"wood\")])";
    let said = messages(
        3,
        &[
            ("missing file", GOOD, "render missing.ron -o older.png"),
            ("no ending that is known", GOOD, "render older.png"),
            ("negative radius", "(nodes: [(shape: sphere()), (name: \"moon\", shape: sphere(radius: -1))])", render),
            ("shutter", "(camera: (shutter: (0.5, 0.25)), nodes: [(shape: sphere())])", render),
            ("motion through a mirror", "(nodes: [(shape: sphere(), motion: [stretch(-1, 1, 1)])])", render),
            ("missing texture", &textured.replace("older", "wood"), render),
            ("broken texture", textured, "render scene.ron -o new.png"),
            ("missing image", GOOD, "develop missing.exr -o older.png"),
            ("broken image", GOOD, "develop older.png -o new.png"),
        ],
    );
    insta::assert_snapshot!(said);
}

#[test]
fn unwritable_output_ends_with_code_4() {
    let said = messages(
        4,
        &[
            ("missing folder", GOOD, "render scene.ron -o missing/a.png"),
            ("below a file", GOOD, "render scene.ron -o older.png/a.png"),
            ("a folder", GOOD, "render scene.ron -o folder.png"),
            ("a protected file", GOOD, "render scene.ron -o locked.png"),
            ("statistics in a missing folder", GOOD, "render scene.ron -o older.png --stats missing/a.json"),
            ("statistics over the scene", GOOD, "render scene.ron -o older.png --stats scene.ron"),
            ("manual in a missing folder", GOOD, "man -o missing"),
        ],
    );
    insta::assert_snapshot!(said);
}

#[test]
fn files_that_the_scene_refers_to_are_not_overwritten() {
    let place = Workplace::with("ball.ron", GOOD);
    place.succeed("render ball.ron -o wood.png");
    let before = place.read("wood.png");
    // By default the image would be named like the texture.
    let scene = "(materials: {\"wood\": phong(color: image(file: \"wood.png\"))},
        nodes: [(shape: sphere(), material: \"wood\")])";
    place.write("wood.ron", scene);
    let run = place.run("render wood.ron");
    assert_eq!(run.code, Some(4), "{run:?}");
    assert_eq!(run.stderr, "error: cannot write `wood.png`: it is an input; choose another name\n");
    assert_eq!(place.read("wood.png"), before);
    place.succeed("render wood.ron --size 8x8 -o other.png");
}

#[test]
fn wrong_usage_ends_with_code_2() {
    let flat = "(camera: (look_from: (0, 0, 5), orthographic: 3), nodes: [(shape: sphere())])";
    let said = messages(
        2,
        &[
            ("no scene", GOOD, "render"),
            ("no such command", GOOD, "rendr scene.ron"),
            ("no such option", GOOD, "render scene.ron --sise 8x8"),
            ("no such integrator", GOOD, "render scene.ron --integrator psth"),
            ("empty size", GOOD, "render scene.ron --size 0x8"),
            ("no samples", GOOD, "render scene.ron --spp 0"),
            ("no time", GOOD, "render scene.ron --time 0s"),
            ("negative time", GOOD, "render scene.ron --time -1s"),
            ("time without a unit", GOOD, "render scene.ron --time 10"),
            ("no error", GOOD, "render scene.ron --target-error 0%"),
            ("NaN error", GOOD, "render scene.ron --target-error nan%"),
            ("error without a unit", GOOD, "render scene.ron --target-error 0.01"),
            ("error of a fixed pattern", GOOD, "render scene.ron --target-error 1% --sampler centre"),
            ("edges of a random image", GOOD, "render scene.ron --adaptive object-space --integrator path"),
            ("edges until it is time", GOOD, "render scene.ron --adaptive object-space --time 10s"),
            ("minimum without adaptive sampling", GOOD, "render scene.ron --min-spp 4"),
            ("stages without an error", GOOD, "render scene.ron --two-stage"),
            ("no passes", GOOD, "render scene.ron --passes 0"),
            ("no such AOV", GOOD, "render scene.ron --aov beauty=a.exr"),
            ("standard error of one pass", GOOD, "render scene.ron --aov stderr=a.exr"),
            ("two AOVs in one", GOOD, "render scene.ron --aov samples=a.exr --aov samples=./a.exr"),
            ("NaN", GOOD, "render scene.ron --look-from 0,nan,0"),
            ("along up", GOOD, "render scene.ron --look-from 0,5,0 --look-at 0,0,0"),
            ("no such color", GOOD, "render scene.ron --background blakc"),
            ("no color", GOOD, "render scene.ron --background #12"),
            ("animation without a time", GOOD, "render scene.ron --animation walk"),
            ("no such camera", GOOD, "render scene.ron --camera camara"),
            ("no field of view", flat, "render scene.ron --fov 30"),
            ("crop outside", GOOD, "render scene.ron --crop 4,4,5,4"),
            ("large crop outside", GOOD, "render scene.ron --crop 0,0,4000000000,1000000"),
            ("no such format", GOOD, "render scene.ron -o a.tiff"),
            ("no alpha", GOOD, "render scene.ron -o older.jpg --background transparent"),
            ("two in one", GOOD, "render scene.ron -o older.png --stats ./older.png"),
            ("no such root", GOOD, "render scene.ron --asset-root missing"),
            ("developed twice", GOOD, "develop older.png -o a.exr"),
            ("two formats", GOOD, "render scene.ron -o a.png --output-format exr"),
            ("two formats of a scene", GOOD, "convert scene.ron -o a.ron --output-format json"),
            ("format of a part", GOOD, "render scene.ron --shard 1/2 --output-format exr"),
            ("huge exposure", GOOD, "render scene.ron --exposure 1e308"),
        ],
    );
    insta::assert_snapshot!(said);
}

/// They were taken for unknown options, with a tip that did not work either.
#[test]
fn negative_values_are_refused_as_values() {
    let place = Workplace::with_scene();
    for (option, rule) in [
        ("--memory -5", "expected a size greater than 0"),
        ("--memory -5%", "expected a percentage greater than 0"),
        ("--max-file-size -5M", "expected a size greater than 0"),
        ("--frames -1", "expected the first and last frame"),
        ("--frames -1..2", "expected the first and last frame"),
        ("--background -1", "none negative"),
        ("--background -1,0,0", "none negative"),
        ("--checkpoint-every -1s", "expected a time greater than 0"),
    ] {
        let run = place.fails(2, &format!("render scene.ron {option}"), rule);
        assert!(run.stderr.starts_with("error: invalid value '-") && !run.stderr.contains("tip:"), "{option}: {run:?}");
    }
}

#[test]
fn warnings_are_errors_under_strict() {
    // The second face has a corner twice, and is left out.
    let place = Workplace::with("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n");
    let lenient = place.succeed("render m.obj --size 8x8");
    assert!(lenient.stderr.starts_with("warning: m.obj"), "{lenient:?}");
    place.fails(3, "render m.obj --size 8x8 --strict -o strict.png", "error: m.obj: 1 warning; fix the scene");
    for (command, output) in [("explain m.obj", ""), ("convert m.obj", " -o m.ron")] {
        let strict = place.run(&format!("{command} --strict{output}"));
        assert_eq!((strict.code, strict.stdout.as_str()), (Some(3), ""), "{strict:?}");
        assert!(
            strict.stderr.contains("warning: m.obj") && strict.stderr.contains("error: m.obj: 1 warning"),
            "{strict:?}"
        );
        assert_eq!(place.files(), ["m.obj", "m.png"], "{command}");
        let lenient = place.succeed(&format!("{command}{output}"));
        assert!(lenient.stderr.starts_with("warning: m.obj"), "{lenient:?}");
    }
    place.write("scene.ron", SCENE);
    let sound = place.succeed("convert scene.ron --strict -o sound.json");
    assert_eq!(sound.stderr, "", "a conversion that mends nothing");
}

/// The file was checked before the options overrode it, and its own conflict was wrong usage.
#[test]
fn options_override_adaptive_sampling_of_the_file() {
    let place = Workplace::new();
    let node = "film: (size: (8, 8)), nodes: [(shape: sphere())]";
    place.write("many.ron", format!("(settings: (adaptive: object_space(min_spp: 32)), {node})"));
    place.fails(3, "render many.ron", "many.ron:1:36: settings.adaptive.min_spp: 32 must lie between 1 and 16");
    for options in ["--spp 64", "--min-spp 8", "--adaptive off"] {
        place.succeed(&format!("render many.ron {options} -o a.png"));
    }
    place.write("path.ron", format!("(settings: (integrator: path, adaptive: object_space()), {node})"));
    let message = "path.ron:1:31: settings.adaptive: object_space supports the integrator `whitted` only, not `path`";
    place.fails(3, "render path.ron", message);
    place.fails(3, "check path.ron", message);
    place.succeed("render path.ron --integrator whitted -o a.png");
    place.write("edges.ron", format!("(settings: (integrator: whitted, adaptive: object_space()), {node})"));
    place.fails(2, "render edges.ron --integrator path -o a.png", "or turn it off by --adaptive off");
    place.succeed("render edges.ron --integrator path --adaptive off -o a.png");
}

#[test]
fn an_empty_image_is_called_empty() {
    let place = Workplace::with("a.exr", "");
    place.fails(3, "develop a.exr -o a.png", "error: a.exr: is empty (0 bytes)\n");
    place.fails(3, "compare a.exr a.exr", "error: a.exr: is empty (0 bytes)\n");
}

/// It ended with code 0.
#[test]
#[cfg(target_os = "linux")]
fn help_that_cannot_be_written_ends_with_code_4() {
    for arguments in [&["--help"][..], &["render", "--help"], &["--version"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rt-cli"));
        let output = command.args(arguments).stdout(full).output().expect("it starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{arguments:?}: {message}");
        assert!(message.starts_with("error: standard output cannot be written: "), "{message}");
    }
}
