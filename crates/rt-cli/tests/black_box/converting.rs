//! Models and scenes to scene files.

use crate::program::Workplace;

const MODEL: &str = "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0.5\nusemtl red\nf 1 2 3\nf 1 3 4\n";

fn place_with_model() -> Workplace {
    let place = Workplace::with("m.obj", MODEL);
    place.write("m.mtl", "newmtl red\nKd 0.8 0.1 0.1\n");
    place
}

#[test]
fn a_converted_model_renders_to_the_same_image() {
    let place = place_with_model();
    place.succeed("render m.obj --size 24x16 --ground -o model.pfm");
    for scene in ["m.ron", "m.json"] {
        place.succeed(&format!("convert m.obj --ground -o {scene}"));
        place.succeed(&format!("render {scene} --size 24x16 -o scene.pfm"));
        assert_eq!(place.read("scene.pfm"), place.read("model.pfm"), "{scene}");
    }
}

#[test]
fn a_bare_model_says_what_was_chosen_for_it() {
    let run = place_with_model().succeed("render m.obj --size 8x8");
    assert!(run.stdout.starts_with("note: "), "{run:?}");
}

#[test]
fn notes_of_a_conversion_to_standard_output_are_on_standard_error() {
    let run = place_with_model().succeed("convert m.obj -o -");
    assert!(!run.stdout.contains("note: ") && run.stderr.starts_with("note: "), "{run:?}");
}

/// `convert` ignored options that only a render can follow.
#[test]
fn options_without_effect_on_a_conversion_are_refused() {
    let place = place_with_model();
    place.write("scene.ron", "(nodes: [(model: \"m.obj\")])");
    for arguments in [
        "m.obj --at-time 1",
        "m.obj --at-time 1 --animation walk",
        "m.obj --shutter 0,0.5",
        "m.obj --variant red",
        "scene.ron --lights none",
    ] {
        let message = "a converted scene does not depend on --";
        place.fails(2, &format!("convert {arguments} -o converted.ron"), message);
        assert!(!place.path("converted.ron").exists(), "{arguments}");
    }
    let both = "does not depend on --at-time, --animation: ";
    place.fails(2, "convert m.obj --animation walk --at-time 1 -o converted.ron", both);
    let converted = place.succeed("convert m.obj --lights none -o converted.ron");
    assert!(converted.stdout.contains("wrote converted.ron"), "{}", converted.stdout);
}

#[test]
fn a_conversion_replaces_no_input_and_leaves_nothing_on_failure() {
    let place = Workplace::with_scene();
    let before = place.read("scene.ron");
    assert_eq!(place.run("convert scene.ron -o ./scene.ron").code, Some(4));
    assert_eq!(place.run("convert scene.ron -o scene.txt").code, Some(2));
    assert_eq!(place.run("convert scene.ron -o missing/scene.json").code, Some(4));
    assert_eq!(place.run("convert missing.obj -o new.ron").code, Some(3));
    assert_eq!(place.files(), ["scene.ron"]);
    assert_eq!(place.read("scene.ron"), before);
}

/// The scene named `a/b.obj`, which does not exist.
#[cfg(unix)]
#[test]
fn a_model_with_a_backslash_in_its_name_is_not_converted() {
    let place = Workplace::with("a\\b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    place.succeed("render a\\b.obj --size 8x8 -o model.pfm");
    place.write("converted.ron", "an earlier scene");
    place.fails(3, "convert a\\b.obj -o converted.ron", "contains a backslash");
    assert_eq!(place.read("converted.ron"), b"an earlier scene");
}
