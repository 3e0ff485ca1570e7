//! Sequences of images.

use crate::program::{ANIMATED, Run, Workplace, signal, wait_until};

/// A ball that flies past a camera, which is itself on its way, with the shutter open for half a frame.
const FLIGHT: &str = "(
    camera: (look_at: (0, 0, 0), shutter: (0, 0.5), animation: (interpolation: smooth, keys: [
        (time: 0, look_from: (0, 0, 6)), (time: 1, look_from: (1, 0.5, 6)),
    ])),
    film: (size: (24, 16)),
    settings: (spp: 4),
    nodes: [(shape: sphere(), animation: (keys: [(time: 0), (time: 1, transform: [translate(2, 1, 0)])]))],
)";

fn flight() -> Workplace {
    Workplace::with("flight.ron", FLIGHT)
}

#[test]
fn each_frame_is_the_image_of_its_moment() {
    let place = flight();
    let run = place
        .succeed("render flight.ron --frames 2..4 --fps 8 -o out-##.pfm --stats stats-##.json --aov samples=n##.pfm");
    assert!(run.stdout.contains("frame 3 of 2..4, at 0.375 s\n"), "{run:?}");
    let mut expected = vec!["flight.ron".to_owned(), "out-##.pfm.frames.json".to_owned()];
    for name in ["n##.pfm", "out-##.pfm", "stats-##.json"] {
        expected.extend(["02", "03", "04"].map(|number| name.replace("##", number)));
    }
    expected.sort();
    assert_eq!(place.files(), expected);
    for (frame, time) in [(2, 0.25), (3, 0.375), (4, 0.5)] {
        place.succeed(&format!("render flight.ron --at-time {time} --fps 8 -o single.pfm"));
        assert!(place.read("single.pfm") == place.read(&format!("out-0{frame}.pfm")), "frame {frame}");
    }
    assert!(place.read("out-02.pfm") != place.read("out-03.pfm"), "it moves");
    place.succeed("render flight.ron --at-time 0.25 --fps 16 -o single.pfm");
    assert!(place.read("single.pfm") != place.read("out-02.pfm"), "frames of half the time are half as blurred");
    place.succeed("render flight.ron --at-time 0.25 --fps 16 --shutter 0,1 -o single.pfm");
    assert!(place.read("single.pfm") == place.read("out-02.pfm"), "which an open shutter makes up for");
}

#[test]
fn frames_go_to_numbered_files() {
    let place = flight();
    place.succeed("render flight.ron --frames 9..10 --quiet");
    assert_eq!(place.files(), ["flight-####.png.frames.json", "flight-0009.png", "flight-0010.png", "flight.ron"]);
    place.succeed("render flight.ron --frames 24 -o one.png --quiet");
    place.succeed("render flight.ron --at-time 1 -o other.png --quiet");
    assert!(place.read("one.png") == place.read("other.png"), "24 frames make a second");
}

#[test]
fn all_frames_of_an_animation_are_rendered() {
    let place = flight();
    place.succeed("render flight.ron --frames all --fps 4 -o out-#.pfm --spp 1 --quiet");
    let expected = ["flight.ron", "out-#.pfm.frames.json", "out-0.pfm", "out-1.pfm", "out-2.pfm", "out-3.pfm"];
    assert_eq!(place.files(), expected);
    place.write("still.ron", "(nodes: [(shape: sphere())])");
    place.fails(2, "render still.ron --frames all", "nothing in still.ron is animated");
}

/// The length of a model's animation is in its file.
#[test]
fn all_frames_of_a_model_are_rendered() {
    let place = Workplace::with_animated_model();
    place.succeed("render m.gltf --frames all --fps 6 --size 8x8 --spp 1 -o #.png --quiet");
    assert_eq!(place.files(), ["#.png.frames.json", "0.png", "1.png", "2.png", "m.bin", "m.gltf"]);
    let piped =
        place.pipe(ANIMATED.as_bytes(), "render - --frames all --fps 2 --size 8x8 --spp 1 -o piped-#.png --quiet");
    assert!(
        piped.status.success() && place.path("piped-0.png").exists() && !place.path("piped-1.png").exists(),
        "{piped:?}"
    );
}

#[test]
fn names_that_frames_would_share_are_refused() {
    let place = flight();
    for (options, name) in [
        ("-o out.png", "out.png"),
        ("-o out-#.png --stats stats.json", "stats.json"),
        ("-o out-#.png --aov samples=n.pfm", "n.pfm"),
    ] {
        let run = place.run(&format!("render flight.ron --frames 0..1 {options}"));
        let message = format!("all frames would be written to {name}: put #### in place of the frame number");
        assert!(run.code == Some(2) && run.stderr.contains(&message), "{run:?}");
    }
    for options in
        ["--frames 0..1 --at-time 1", "--frames 2..1", "--frames x", "--frames 1 --fps 0", "--animation walk"]
    {
        assert_eq!(place.run(&format!("render flight.ron {options}")).code, Some(2), "{options}");
    }
    assert_eq!(place.files(), ["flight.ron"]);
}

#[test]
fn a_frame_that_fails_is_named_and_those_before_it_are_kept() {
    // It flies through what it looks at.
    let place =
        Workplace::with("a.ron", FLIGHT.replace("(1, 0.5, 6)", "(0, 0, -6)").replace("interpolation: smooth,", ""));
    place.fails(
        3,
        "render a.ron --frames 0..3 --fps 4 -o #.png",
        "error: frame 2: a.ron:2:53: camera.animation: look_from and look_at are both",
    );
    assert_eq!(place.files(), ["#.png.frames.json", "0.png", "1.png", "a.ron"]);
}

#[test]
fn frames_that_are_done_are_not_rendered_again_and_never_mixed_with_others() {
    let place = flight();
    let render = |options: &str| place.run(&format!("render flight.ron -o out-#.pfm --fps 8 {options}"));
    let done = |run: &Run| -> Vec<bool> {
        let frames = run.stdout.lines().filter(|line| line.starts_with("frame "));
        frames.map(|line| line.ends_with("exists already")).collect()
    };
    assert_eq!(done(&render("--frames 1..2")), [false, false]);
    let first = place.read("out-1.pfm");
    assert_eq!(done(&render("--frames 0..3 --resume")), [false, true, true, false]);
    // What is gone is made again, with the same bits.
    std::fs::remove_file(place.path("out-1.pfm")).expect("removed");
    assert_eq!(done(&render("--frames 0..3 --resume --threads 1")), [true, false, true, true]);
    assert!(place.read("out-1.pfm") == first);
    for other in ["--seed 7", "--shutter 0,1", "--size 8x8", "--target-error 50%", "--exposure 1"] {
        let run = render(&format!("--frames 0..3 --resume {other}"));
        assert_eq!(run.code, Some(3), "{other}: {run:?}");
        assert!(run.stderr.contains("out-#.pfm.frames.json: is of another image"), "{run:?}");
    }
    assert!(place.read("out-1.pfm") == first, "nothing was touched");
    assert_eq!(done(&render("--frames 0..3 --seed 7 --restart")), [false; 4]);
    assert!(place.read("out-1.pfm") != first);
    // New outputs are written; frames of other runs stay in the log.
    assert_eq!(done(&render("--frames 2..3 --seed 7 --resume --aov samples=n-#.pfm")), [false; 2]);
    assert_eq!(done(&render("--frames 2..3 --seed 7 --resume --aov samples=n-#.pfm")), [true; 2]);
    assert_eq!(done(&render("--frames 4..5 --seed 7")), [false; 2]);
    assert_eq!(done(&render("--frames 0..5 --seed 7 --resume")), [true; 6]);
    place.write("out-#.pfm.frames.json", "{");
    assert_eq!(render("--frames 0..3 --resume").code, Some(3));
}

#[test]
fn a_frame_whose_image_was_replaced_is_rendered_again() {
    let place = flight();
    place.succeed("render flight.ron -o out-#.pfm --frames 0..1");
    let first = place.read("out-1.pfm");
    place.succeed("render flight.ron -o out-#.pfm --frames 1 --size 8x8 --integrator normals");
    assert!(place.read("out-1.pfm") != first);
    let run = place.succeed("render flight.ron -o out-#.pfm --frames 0..1 --resume");
    assert!(run.stdout.contains("frame 0 of 0..1 exists already\nframe 1 of 0..1, at "), "{run:?}");
    assert!(place.read("out-1.pfm") == first);
    // Logs of earlier versions have no hashes of files.
    let mut log = place.json("out-#.pfm.frames.json");
    log.as_object_mut().expect("an object").remove("files").expect("hashes");
    place.write("out-#.pfm.frames.json", log.to_string());
    let run = place.succeed("render flight.ron -o out-#.pfm --frames 0..1 --resume");
    assert_eq!(run.stdout.matches(" exists already").count(), 2, "{run:?}");
}

/// It rendered the finished frames again, up to the unfinished one.
#[test]
#[cfg(unix)]
fn an_animation_with_an_unfinished_frame_is_refused_before_its_first_frame() {
    let place = flight();
    let command = "render flight.ron -o out-#.pfm --frames 0..2 --size 160x120 --spp 128 --threads 1";
    place.interrupt(&format!("{command} --checkpoint-every 1ms"), "out-1.pfm.checkpoint");
    let message = "frame 1: out-1.pfm.checkpoint is the checkpoint of an unfinished render: continue with --resume";
    let run = place.fails(2, command, message);
    assert_eq!(run.stdout, "");
    place.prints(&format!("{command} --resume"), "frame 0 of 0..2 exists already\n");
}

/// It ended without a message while it read the scene of a later frame.
#[test]
#[cfg(unix)]
fn an_interrupt_between_frames_has_a_message() {
    let place =
        Workplace::with("slow.ron", "(film: (size: (4, 4)), settings: (spp: 1), nodes: [(model: \"slow.obj\")])");
    // Its frames take longer to read than to render.
    place.write("slow.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned() + &"v 0.25 0.5 0.75\n".repeat(300_000));
    for name in ["TERM", "INT"] {
        let child = place.spawn("render slow.ron -o out-#.pfm --frames 0..99 --restart");
        wait_until("a finished frame", || place.path("out-#.pfm.frames.json").exists());
        signal(&child, name);
        let run = Run::end(child);
        assert_eq!(run.code, Some(130), "{run:?}");
        let end = "; --resume continues the frames that are not finished\n";
        assert!(run.stderr.starts_with("error: frame ") && run.stderr.ends_with(end), "{name}: {run:?}");
        std::fs::remove_file(place.path("out-#.pfm.frames.json")).expect("it exists");
    }
}

#[test]
fn machines_share_frames_out() {
    let place = flight();
    place.succeed("render flight.ron -o all-#.pfm --frames 1..5 --quiet");
    for shard in 1..=3 {
        place.succeed(&format!("render flight.ron -o out-#.pfm --frames 1..5 --quiet --shard {shard}/3"));
        if shard == 2 {
            assert!(place.path("out-1.pfm").exists() && place.path("out-4.pfm").exists());
            assert!(!place.path("out-2.pfm").exists() && !place.path("out-5.pfm").exists());
        }
    }
    for frame in 1..=5 {
        assert!(place.read(&format!("all-{frame}.pfm")) == place.read(&format!("out-{frame}.pfm")), "frame {frame}");
    }
    assert!(place.path("out-#.pfm.frames.2-of-3.json").exists());
    let run = place.succeed("render flight.ron -o out-#.pfm --frames 1..5 --shard 2/3 --resume");
    assert_eq!(run.stdout, "frame 1 of 1..5 exists already\nframe 4 of 1..5 exists already\n");
    // Each frame is a whole image, so that it can be one that stops by its error; a single frame is one machine's as well.
    place.succeed("render flight.ron -o rule-#.pfm --frames 1..2 --quiet --shard 1/2 --target-error 50%");
    assert!(place.path("rule-1.pfm").exists() != place.path("rule-2.pfm").exists());
    for shard in 1..=2 {
        place.succeed(&format!("render flight.ron -o single-{shard}.pfm --frames 3 --quiet --shard {shard}/2"));
    }
    assert!(place.path("single-1.pfm").exists() != place.path("single-2.pfm").exists());
}

#[test]
fn a_share_without_frames_is_noted() {
    let place = Workplace::with_animated_model();
    let run = place.succeed("render m.gltf --frames 0..2 --shard 4/8 -o out-##.png");
    assert_eq!(run.stdout, "note: shard 4 of 8 has none of the frames 0..2\n");
    assert_eq!(place.files(), ["m.bin", "m.gltf"]);
}

/// The message was that `--shard` is missing.
#[test]
fn shards_of_frames_are_no_part_files() {
    let place = flight();
    let message = "is a .part file: with --frames, images are written, also by each shard";
    place.fails(2, "render flight.ron --frames 0..3 --shard 1/2 -o x-####.part", message);
    place.fails(2, "render flight.ron --frames 0 --shard 1/2 -o x.part", message);
    assert_eq!(
        place.succeed("render flight.ron --frames 5 --shard 3/8").stdout,
        "note: shard 3 of 8 does not have frame 5\n"
    );
}

/// The interval was 0 to 1 whatever the shutter was.
#[test]
fn the_plan_names_the_interval_of_the_shutter() {
    let place = flight();
    for (option, interval) in [("", "from 0 to 0.5"), ("--shutter 0.25,0.75", "from 0.25 to 0.75")] {
        let text = place.succeed(&format!("explain flight.ron {option}")).stdout;
        let line = format!("each sample has its own time, {interval} in fractions of a frame");
        assert!(text.contains(&line), "{option}: {text}");
    }
}
