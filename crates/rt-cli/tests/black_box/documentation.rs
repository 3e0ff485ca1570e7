//! Texts that the program holds about itself.

use crate::program::Workplace;

#[test]
fn help() {
    let place = Workplace::new();
    for command in
        ["", "render", "view", "explain", "check", "convert", "develop", "compare", "converge", "completions", "man"]
    {
        let name = if command.is_empty() { "help" } else { command };
        let text = place.succeed(&format!("{command} --help")).stdout;
        insta::assert_snapshot!(format!("help_{name}"), text);
    }
}

#[test]
fn help_is_a_command_as_well() {
    let place = Workplace::new();
    for command in ["render", "explain"] {
        let help = place.succeed(&format!("{command} --help")).stdout;
        assert_eq!(place.succeed(&format!("help {command}")).stdout, help);
        // Hidden older spellings are not shown.
        for old in ["--least", "--quality", "--root", "--fallback <", "variance=", "caustics,", "wide,"] {
            assert!(!help.contains(&format!(" {old}")), "{old}");
        }
    }
    assert_eq!(place.succeed("help").stdout, place.succeed("--help").stdout);
    assert_eq!(place.run("help rendr").code, Some(2));
}

#[test]
fn a_plan_is_explained() {
    let place = Workplace::with_scene();
    let run = place.prints("explain scene.ron --accel grid", "plan for 'scene': integrator whitted");
    assert!(run.stdout.contains("accelerator: grid over"), "{run:?}");
    assert!(run.stdout.contains("\nleft out\n  triangles: the scene has none\n"), "{run:?}");
    assert_eq!(place.files(), ["scene.ron"]);
}

#[test]
fn the_schema_describes_scenes() {
    let text = Workplace::new().succeed("schema").stdout;
    let schema: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(schema["title"], "Scene");
    for field in ["camera", "film", "settings", "lights", "materials", "nodes"] {
        assert!(schema["properties"][field].is_object(), "{field}");
    }
}

#[test]
fn every_shell_gets_completions() {
    let place = Workplace::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = place.succeed(&format!("completions {shell}")).stdout;
        assert!(script.contains("integrator") && script.contains("look-from"), "{shell}");
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let place = Workplace::new();
    std::fs::create_dir(place.path("pages")).expect("created");
    place.succeed("man -o pages");
    let all = place.succeed("man").stdout;
    for page in [
        "",
        "-render",
        "-view",
        "-explain",
        "-check",
        "-convert",
        "-develop",
        "-compare",
        "-converge",
        "-schema",
        "-completions",
        "-man",
    ] {
        let text = String::from_utf8(place.read(&format!("pages/rt-cli{page}.1"))).expect("text");
        assert!(text.contains(&format!(".TH rt-cli{page} 1")), "{text}");
        assert!(all.contains(&text), "{page}");
    }
    assert!(all.contains("\n.SH SYNOPSIS\nrt\\-cli SCENE [OPTIONS]\n.br\nrt\\-cli COMMAND ...\n.br\n"), "{all}");
}
