//! Standard input and output as files, by the name `-`.

use std::process::{Command, Output};

use crate::program::{Run, SCENE, Workplace};

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn succeed(place: &Workplace, input: &[u8], arguments: &str) -> Output {
    let output = place.pipe(input, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    output
}

#[test]
fn a_scene_comes_from_standard_input() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron -o file.pfm");
    let json = place.pipe(SCENE.as_bytes(), "convert - -o - --output-format json");
    for (input, options) in [(SCENE.as_bytes(), ""), (SCENE.as_bytes(), "--input-format ron"), (&json.stdout, "")] {
        succeed(&place, input, &format!("render - -o piped.pfm {options}"));
        assert!(place.read("piped.pfm") == place.read("file.pfm"), "{options}");
    }
    // Without a name for the image, it goes by that of its scene.
    succeed(&place, SCENE.as_bytes(), "render - --spp 1");
    assert_eq!(place.files(), ["file.pfm", "piped.pfm", "scene.ron", "stdin.png"]);
    let explained = succeed(&place, SCENE.as_bytes(), "explain -").stdout;
    assert!(String::from_utf8_lossy(&explained).contains("plan for 'stdin'"));
    assert!(
        succeed(&place, SCENE.as_bytes(), "check -").stdout == place.succeed("check scene.ron").stdout.into_bytes()
    );
}

#[test]
fn scenes_from_standard_input_refer_to_the_current_directory() {
    let place = Workplace::new();
    let obj = "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nusemtl red\nf 1 2 3\n";
    place.write("m.obj", obj);
    place.write("m.mtl", "newmtl red\nKd 0.8 0.1 0.1\n");
    place.succeed("render m.obj --size 24x16 -o file.pfm");
    succeed(&place, obj.as_bytes(), "render - --input-format obj --size 24x16 -o piped.pfm");
    assert!(place.read("piped.pfm") == place.read("file.pfm"));
    let scene = "(nodes: [(model: \"m.obj\")], film: (size: (24, 16)))";
    succeed(&place, scene.as_bytes(), "render - -o scene.pfm");
    // All frames are of the same input.
    succeed(&place, scene.as_bytes(), "render - -o frame-#.pfm --frames 0..1");
    assert!(place.read("frame-1.pfm") == place.read("scene.pfm"));
}

#[test]
fn standard_input_that_is_no_scene_is_refused_with_advice() {
    let place = Workplace::with_scene();
    for (input, arguments, code, message) in [
        ("v 0 0 0\n", "render -", 2, "is unknown: add --input-format with one of ron, json"),
        ("", "render -", 3, "standard input: is empty"),
        ("(nodes: [(shape: spere())])", "render -", 3, "stdin.ron:1:18: unknown"),
        (
            SCENE,
            "render - --max-file-size 10",
            3,
            "standard input: has more bytes than the limit of 10; raise --max-file-size",
        ),
        // The limit of memory had no effect on standard input.
        (SCENE, "render - --memory 10", 3, "standard input: has more bytes than the limit of 10; raise --memory"),
        (SCENE, "render scene.ron --input-format ron", 2, "--input-format requires standard input"),
        (SCENE, "render - --env -", 2, "cannot be both the scene and --env"),
        ("v 0 0 0\n", "convert - --input-format obj -o -", 2, "save it to a file first"),
        ("", "compare - -", 2, "standard input cannot be both images"),
        (SCENE, "render scene.ron -o - --stats -", 2, "--output and --stats have the same file"),
        (SCENE, "render scene.ron -o - --frames 0..1", 2, "all frames would be written to -"),
        (SCENE, "render scene.ron -o - --resume", 2, "--resume requires --checkpoint FILE"),
    ] {
        let output = place.pipe(input.as_bytes(), arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {said}");
        assert!(said.contains(message), "{arguments}: {said}");
        assert!(output.stdout.is_empty(), "{arguments}");
    }
    assert_eq!(place.files(), ["scene.ron"]);
}

#[test]
fn images_go_to_standard_output_without_reports() {
    let place = Workplace::with_scene();
    for (format, options) in
        [("png", ""), ("png", "--output-format png"), ("exr", "--output-format exr"), ("jpg", "--output-format jpeg")]
    {
        place.succeed(&format!("render scene.ron -o file.{format}"));
        let piped = succeed(&place, b"", &format!("render scene.ron -o - {options}"));
        assert!(piped.stdout == place.read(&format!("file.{format}")), "{options}");
        assert!(
            stderr(&piped).contains(&format!("wrote {} to standard output (48x32, ", format.to_uppercase())),
            "{}",
            stderr(&piped)
        );
    }
    assert_eq!(place.files(), ["file.exr", "file.jpg", "file.png", "scene.ron"]);
    // --output-format stands for an extension.
    for (options, name) in [("-o odd.name", "odd.name"), ("", "scene.exr"), ("--frames 7", "scene-0007.exr")] {
        place.succeed(&format!("render scene.ron --output-format exr {options}"));
        assert!(place.read(name) == place.read("file.exr"), "{name}");
    }
}

#[test]
#[cfg(unix)]
fn the_null_device_takes_images_and_statistics() {
    let place = Workplace::with_scene();
    for options in ["", "--output-format exr --stats /dev/null"] {
        place.prints(&format!("render scene.ron -o /dev/null {options}"), "wrote /dev/null (48x32, ");
    }
    place.fails(2, "render scene.ron -o /dev/null --resume", "--resume requires --checkpoint FILE");
    assert_eq!(place.files(), ["scene.ron"]);
}

#[test]
#[cfg(unix)]
fn standard_output_and_the_null_device_need_no_temporary_directory() {
    let place = Workplace::with_scene();
    for options in ["-o -", "-o - --shard 1/2", "-o /dev/null", "-o /dev/null --output-format exr --stats -"] {
        let mut command = place.command(&format!("render scene.ron {options}"));
        let output = command.env("TMPDIR", place.path("missing")).output().expect("it starts");
        assert_eq!(output.status.code(), Some(0), "{options}: {}", stderr(&output));
    }
    assert_eq!(place.files(), ["scene.ron"]);
}

#[test]
fn statistics_go_to_standard_output() {
    let place = Workplace::with_scene();
    let piped = succeed(&place, b"", "render scene.ron --stats -");
    let stats: serde_json::Value = serde_json::from_slice(&piped.stdout).expect("JSON and nothing else");
    assert_eq!(stats["settings"]["width"], 48);
    assert!(stats["camera_hits"].as_u64() > Some(0), "{stats}");
    assert!(stderr(&piped).contains("wrote scene.png"), "{}", stderr(&piped));
    assert_eq!(place.files(), ["scene.png", "scene.ron"], "there is no file of the name -");
}

#[test]
fn images_are_developed_compared_merged_and_converted_through_pipes() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron -o linear.exr");
    place.succeed("render scene.ron -o direct.png");
    let linear = place.read("linear.exr");
    let developed = succeed(&place, &linear, "develop - -o -").stdout;
    assert!(developed == place.read("direct.png"));
    for arguments in ["develop - -o small.png --memory 1k", "compare - direct.png --memory 1k"] {
        let refused = place.pipe(&linear, arguments);
        assert_eq!(refused.status.code(), Some(3), "{arguments}: {}", stderr(&refused));
        assert!(stderr(&refused).contains("--memory"), "{arguments}: {}", stderr(&refused));
    }
    succeed(&place, &developed, "compare - direct.png");
    succeed(&place, &developed, "compare direct.png -");
    let other = place.pipe(&developed, "compare linear.exr - --exposure 1");
    assert_eq!(other.status.code(), Some(1), "{}", stderr(&other));
    place.run("compare linear.exr direct.png --exposure 1 --heat-map heat.png");
    let heat = place.pipe(b"", "compare linear.exr direct.png --exposure 1 --heat-map -");
    assert!(heat.stdout == place.read("heat.png") && stderr(&heat).contains("RMSE"), "{}", stderr(&heat));
    let both = place.pipe(b"", "compare linear.exr direct.png --json --heat-map -");
    assert_eq!(both.status.code(), Some(2), "{}", stderr(&both));

    let part = succeed(&place, b"", "render scene.ron --shard 1/2 -o -").stdout;
    place.write("1.part", part);
    place.succeed("render scene.ron --shard 2/2 -o 2.part");
    assert!(succeed(&place, b"", "merge 1.part 2.part -o -").stdout == place.read("direct.png"));

    place.succeed("convert scene.ron -o file.json");
    let converted = succeed(&place, b"", "convert scene.ron -o - --output-format json").stdout;
    assert!(converted == place.read("file.json"));
    let ron = succeed(&place, &converted, "convert - -o -").stdout;
    assert!(ron.starts_with(b"("), "RON by default");

    place.succeed("render scene.ron --env linear.exr --spp 1 -o file.pfm");
    succeed(&place, &linear, "render scene.ron --env - --spp 1 -o piped.pfm");
    assert!(place.read("piped.pfm") == place.read("file.pfm"));
    assert!(!place.path("-").exists());
}

/// `rt-cli ... | head -c 10` ends quietly, and leaves its files.
#[test]
fn a_broken_pipe_is_no_failure_for_texts() {
    let place = Workplace::with_scene();
    for arguments in
        ["render scene.ron --stats - --quiet", "render scene.ron -o report.png", "convert scene.ron -o -", "schema"]
    {
        let mut child = place.spawn(arguments);
        drop(child.stdout.take());
        let run = Run::end(child);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{arguments}");
    }
    assert_eq!(place.files(), ["report.png", "scene.png", "scene.ron"]);
}

#[test]
#[cfg(unix)]
fn an_image_that_a_broken_pipe_loses_goes_to_the_fallback() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron -o file.png --size 160x120");
    place.succeed("render scene.ron -o file.part --size 160x120 --shard 1/2");
    for (file, options) in [("file.png", ""), ("file.part", "--shard 1/2")] {
        std::fs::create_dir(place.path("refuge")).expect("created");
        let command = "render scene.ron -o - --size 160x120 --checkpoint kept --checkpoint-every 1ms";
        let mut child = place.spawn(&format!("{command} --fallback-dir refuge {options}"));
        drop(child.stdout.take());
        let run = Run::end(child);
        assert_eq!(run.code, Some(4), "{options}: {run:?}");
        let message = "cannot write `standard output`: Broken pipe (os error 32); it was saved as `refuge/rt-cli-";
        assert!(run.stderr.contains(message) && !run.stderr.contains("wrote "), "{options}: {run:?}");
        let saved = std::fs::read_dir(place.path("refuge")).expect("there").next().expect("saved").expect("a file");
        assert!(saved.path().extension().is_some_and(|extension| file.ends_with(extension.to_str().expect("text"))));
        if options.is_empty() {
            assert!(std::fs::read(saved.path()).expect("there") == place.read(file));
        }
        std::fs::remove_file(place.path("kept")).expect("the checkpoint stays");
        std::fs::remove_dir_all(place.path("refuge")).expect("removed");
    }
    let mut child = place.spawn("develop file.png -o -");
    drop(child.stdout.take());
    assert_eq!(Run::end(child).code, Some(4));
}

#[test]
fn images_are_not_written_to_a_terminal() {
    let place = Workplace::with_scene();
    let program = env!("CARGO_BIN_EXE_rt-cli");
    let script = format!("{program} render scene.ron -o -");
    let run = Command::new("script").args(["-qec", &script, "/dev/null"]).current_dir(place.path("")).output();
    let Ok(run) = run else {
        return rt_tests::skip("there is no `script` to make a terminal with");
    };
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    assert!(String::from_utf8_lossy(&run.stdout).contains("standard output is a terminal"), "{run:?}");
}

#[cfg(unix)]
#[test]
fn links_to_pipes_are_not_replaced() {
    use std::os::unix::fs::symlink;

    let place = Workplace::with_scene();
    // The link to a pipe that /dev/stdout is.
    symlink("/proc/self/fd/1", place.path("pipe.json")).expect("a link");
    let run = place.pipe(b"", "render scene.ron --stats pipe.json");
    assert_eq!(run.status.code(), Some(4), "{}", stderr(&run));
    assert!(stderr(&run).contains("is not a regular file; choose another name, or `-`"), "{}", stderr(&run));
    assert!(place.path("pipe.json").is_symlink());
    // A loop of links exists, but is no file of another kind.
    symlink("b.json", place.path("a.json")).expect("a link");
    symlink("a.json", place.path("b.json")).expect("a link");
    place.fails(
        4,
        "render scene.ron --stats a.json",
        "`a.json`: it is a symbolic link to a link that leads to no file",
    );
    // A link to a file that does not exist yet is written through.
    symlink("later.json", place.path("link.json")).expect("a link");
    place.succeed("render scene.ron --stats link.json");
    assert!(place.path("link.json").is_symlink() && !place.read("later.json").is_empty());
}
