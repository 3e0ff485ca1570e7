//! Interrupted, killed and resumed renders, and unwritable outputs.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::program::{Run, Workplace, signal, wait_until};

/// Render of a second, which many processors do not shorten.
const LONG: &str = "render scene.ron --integrator path --size 160x120 --spp 24 --threads 2 -o scene.exr";

/// Endless render of slow tiles.
const ENDLESS: &str = "render scene.ron --integrator path --spp 2000000 --threads 1 -o scene.exr";

/// Folder of an interrupted render, and its checkpoint.
fn interrupted_place() -> (Workplace, Vec<u8>) {
    let place = Workplace::with_scene();
    place.interrupt(&format!("{LONG} --checkpoint-every 1ms"), "scene.exr.checkpoint");
    let kept = place.read("scene.exr.checkpoint");
    (place, kept)
}

#[test]
#[cfg(unix)]
fn the_first_signal_saves_and_resume_is_bit_identical() {
    for options in ["", "--passes 7", "--aov samples=samples.pfm --aov stderr=variance.exr --passes 3"] {
        let place = Workplace::with_scene();
        let run = place.interrupt(&format!("{LONG} --checkpoint-every 1ms {options}"), "scene.exr.checkpoint");
        assert!(run.stderr.contains("interrupted after"), "{run:?}");
        assert!(
            run.stderr.contains("the image was written to scene.exr; --resume continues from scene.exr.checkpoint")
        );
        assert_eq!(place.film("scene.exr").width(), 160);
        place.prints(&format!("{LONG} --resume {options}"), "note: continues from scene.exr.checkpoint, with");
        assert!(!place.path("scene.exr.checkpoint").exists());
        let reference = Workplace::with_scene();
        reference.succeed(&format!("{LONG} {options}"));
        for file in reference.files() {
            assert_eq!(place.read(&file), reference.read(&file), "{file} with {options}");
        }
        assert_eq!(place.files(), reference.files());
    }
}

#[test]
#[cfg(unix)]
fn sigterm_interrupts_as_well() {
    let place = Workplace::with_scene();
    let child = place.spawn(&format!("{LONG} --checkpoint-every 1ms --target-error 0.5%"));
    wait_until("a checkpoint", || place.path("scene.exr.checkpoint").exists());
    signal(&child, "TERM");
    let run = Run::end(child);
    assert_eq!(run.code, Some(130), "{run:?}");
    // A stop rule knows no total.
    assert!(run.stderr.contains(" samples per pixel; the image was written to scene.exr"), "{run:?}");
    assert_eq!(place.files(), ["scene.exr", "scene.exr.checkpoint", "scene.ron"]);
}

#[test]
#[cfg(unix)]
fn a_signal_while_the_scene_is_read_has_the_exit_code_of_interrupts() {
    let place = Workplace::new();
    for (name, options) in
        [("TERM", "-o a.png"), ("INT", "-o a.png"), ("HUP", "-o a.png"), ("INT", "--frames 0..3 -o a-####.png")]
    {
        let mut command = Command::new("env");
        command.arg("--default-signal=HUP").arg(env!("CARGO_BIN_EXE_rt-cli")).args(["render", "-"]);
        command.args(options.split(' '));
        command.current_dir(place.path("")).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        // More than a pipe holds, so that the program has begun to read. It waits for the rest.
        let mut stdin = child.stdin.take().expect("a pipe");
        stdin.write_all(&[b' '; 1 << 20]).expect("written");
        signal(&child, name);
        let run = Run::end(child);
        let message = "error: interrupted while the scene was loaded: no image was written; run the command again\n";
        assert_eq!((run.code, run.stderr.as_str()), (Some(130), message), "{name} {options}");
        drop(stdin);
    }
    assert!(place.files().is_empty());
}

#[test]
#[cfg(unix)]
fn the_second_signal_stops_at_once() {
    let place = Workplace::with_scene();
    let mut child = place.spawn(ENDLESS);
    std::thread::sleep(Duration::from_millis(500));
    signal(&child, "INT");
    std::thread::sleep(Duration::from_millis(600));
    assert!(child.try_wait().expect("it lives").is_none(), "tiles that are begun are finished first");
    signal(&child, "INT");
    assert_eq!(Run::end(child).code, Some(130));
    assert_eq!(place.files(), ["scene.ron"]);
}

#[test]
#[cfg(unix)]
fn an_interrupt_before_the_first_tile_keeps_older_images() {
    let place = Workplace::with_scene();
    let outputs = "--aov normal=normal.exr --stats stats.json";
    place.succeed(&format!("render scene.ron -o scene.exr {outputs}"));
    let older = ["scene.exr", "normal.exr", "stats.json"].map(|file| (file, place.read(file)));
    let child = place.spawn(&format!("{ENDLESS} {outputs}"));
    std::thread::sleep(Duration::from_millis(700));
    signal(&child, "INT");
    let run = Run::end(child);
    assert_eq!(run.code, Some(130), "{run:?}");
    let message = "error: interrupted before the first tile was finished: no image was written, and older files are \
                   unchanged; --resume continues from scene.exr.checkpoint; with --time, passes are finished sooner\n";
    assert_eq!(run.stderr, message);
    for (file, content) in older {
        assert!(place.read(file) == content, "{file}");
    }
    assert!(place.path("scene.exr.checkpoint").exists());
}

/// The message did not say that there is no checkpoint.
#[test]
#[cfg(unix)]
fn an_interrupt_without_a_checkpoint_says_so() {
    let place = Workplace::with_scene();
    let child = place.spawn("render scene.ron --integrator path --spp 2000000 --threads 1 -o -");
    std::thread::sleep(Duration::from_millis(700));
    signal(&child, "INT");
    let run = Run::end(child);
    assert_eq!(run.code, Some(130), "{run:?}");
    assert!(run.stderr.contains("; it cannot be resumed, because it has no checkpoint"), "{run:?}");
}

/// Sends signals by a shell command, in which `$1` is the process, and waits for the end.
#[cfg(unix)]
fn signalled(words: &str) -> (Workplace, Run) {
    use std::os::unix::process::CommandExt;
    // Tiles take long enough for a second signal.
    let spp = if words.contains("sleep") { 1500 } else { 400 };
    let slow = format!("render scene.ron --integrator path --spp {spp} --threads 2 -o scene.exr");
    let place = Workplace::with_scene();
    // The parent of the tests may ignore SIGHUP.
    let mut command = Command::new("env");
    command.arg("--default-signal=HUP").arg(env!("CARGO_BIN_EXE_rt-cli")).args(slow.split_whitespace());
    command.args(["--checkpoint-every", "1ms"]).current_dir(place.path("")).process_group(0);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    wait_until("a checkpoint", || place.path("scene.exr.checkpoint").exists());
    let sent = Command::new("bash").args(["-c", words, "bash", &child.id().to_string()]).status().expect("a shell");
    assert!(sent.success(), "{words}");
    (place, Run::end(child))
}

#[test]
#[cfg(unix)]
fn repeated_signals_save_the_image() {
    for words in [
        "kill -INT $1 $1",
        "kill -TERM $1 $1 $1",
        // As `timeout` does: to the program, and to its group.
        "kill -TERM $1 -$1",
        "kill -INT $1 -$1",
        "kill -TERM $1; kill -INT $1; kill -HUP $1",
        "kill -TERM $1; sleep 0.6; kill -TERM $1",
        "kill -HUP $1",
        "kill -HUP $1 $1",
    ] {
        let (place, run) = signalled(words);
        assert_eq!(run.code, Some(130), "{words}: {run:?}");
        assert!(run.stderr.contains("the image was written to scene.exr; --resume continues"), "{words}: {run:?}");
        assert_eq!(place.files(), ["scene.exr", "scene.exr.checkpoint", "scene.ron"], "{words}");
        assert_eq!(place.film("scene.exr").width(), 48, "{words}");
    }
}

/// Runs the program with a limit of its files, in units of 512 bytes or of 1024 in some shells.
#[cfg(unix)]
fn with_file_size_limit(place: &Workplace, units: u32, arguments: &str) -> Run {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -f {units}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_rt-cli")]);
    Run::of(command.args(arguments.split_whitespace()).current_dir(place.path("")).output().expect("a shell"))
}

#[test]
#[cfg(unix)]
fn an_image_beyond_the_file_size_limit_is_an_error_with_a_message() {
    let place = Workplace::with_scene();
    let run = with_file_size_limit(&place, 4, "render scene.ron --size 120x90 -o big.exr --quiet");
    assert_eq!(run.code, Some(4), "{run:?}");
    assert!(run.stderr.starts_with("error: cannot write `big.exr`: ") && run.stderr.contains("large"), "{run:?}");
    assert_eq!(place.files(), ["scene.ron"]);
}

#[test]
#[cfg(unix)]
fn a_checkpoint_beyond_the_file_size_limit_is_one_warning() {
    let place = Workplace::with_scene();
    // The checkpoint takes 230 kB at the end, and the image at most 60 kB.
    let arguments = "render scene.ron --size 160x120 --spp 16 --threads 2 --checkpoint-every 1ms -o scene.png";
    let run = with_file_size_limit(&place, 150, arguments);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert_eq!(run.stderr.matches("cannot write the checkpoint").count(), 1, "{run:?}");
    assert_eq!(place.files(), ["scene.png", "scene.ron"]);
}

#[test]
#[cfg(unix)]
fn nohup_is_obeyed() {
    let place = Workplace::with_scene();
    let mut command = Command::new("nohup");
    command.arg(env!("CARGO_BIN_EXE_rt-cli")).args(LONG.split_whitespace()).args(["--checkpoint-every", "1ms"]);
    command.current_dir(place.path("")).stdin(Stdio::null());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    wait_until("a checkpoint", || place.path("scene.exr.checkpoint").exists());
    signal(&child, "HUP");
    let run = Run::end(child);
    if cfg!(target_os = "linux") {
        assert_eq!(run.code, Some(0), "{run:?}");
    }
}

#[test]
fn a_kill_leaves_the_older_image_and_nothing_else() {
    let place = Workplace::with_scene();
    place.write("scene.png", "older");
    for milliseconds in [20, 100, 400] {
        let mut child = place.command("render scene.ron --size 4000x4000 --spp 64 --quiet").spawn().expect("it starts");
        std::thread::sleep(Duration::from_millis(milliseconds));
        child.kill().expect("it runs");
        child.wait().expect("it ended");
        assert_eq!(place.files(), ["scene.png", "scene.ron"]);
        assert_eq!(place.read("scene.png"), b"older");
    }
}

#[test]
fn unfinished_checkpoints_of_killed_runs_are_removed() {
    let place = Workplace::with_scene();
    place.write(".scene.exr.checkpoint-K1ll3d.unfinished", "half of it");
    place.succeed(&format!("{LONG} --resume --checkpoint-every never"));
    assert_eq!(place.files(), ["scene.exr", "scene.ron"]);
}

#[test]
#[cfg(unix)]
fn checkpoints_of_another_image_are_not_resumed_and_none_is_overwritten() {
    let (place, kept) = interrupted_place();
    place.fails(2, LONG, "continue with --resume, or start over with --restart");
    place.fails(3, &format!("{LONG} --resume --seed 7"), "scene.exr.checkpoint: is of another image");
    let missing = "scene.exr.checkpoint: was made with other options; use the same --stats";
    let refused = place.fails(3, &format!("{LONG} --resume --stats stats.json"), missing);
    assert!(!refused.stdout.contains("continues from"), "{refused:?}");
    place.write("scene.ron", crate::program::SCENE.replace("0.7", "0.71"));
    assert_eq!(place.run(&format!("{LONG} --resume")).code, Some(3));
    assert_eq!(place.read("scene.exr.checkpoint"), kept);
    place.succeed(&format!("{LONG} --restart"));
    assert!(!place.path("scene.exr.checkpoint").exists());
}

#[test]
#[cfg(unix)]
fn a_checkpoint_of_another_image_is_kept_aside() {
    let (place, kept) = interrupted_place();
    let other = Workplace::with_scene();
    other.succeed(&format!("{LONG} --seed 7"));
    for (content, aside) in [(&kept[..], "scene.exr.checkpoint.old"), (&kept[..20], "scene.exr.checkpoint.old.2")] {
        place.write("scene.exr.checkpoint", content);
        let run = place.succeed(&format!("{LONG} --seed 7"));
        let notes: Vec<_> = run.stdout.lines().filter(|line| line.contains("scene.exr.checkpoint")).collect();
        assert!(notes.len() == 1 && notes[0].starts_with("note: scene.exr.checkpoint: is "), "{run:?}");
        let fate = format!("; kept as {aside}; this render starts over");
        assert!(notes[0].ends_with(&fate), "{run:?}");
        assert_eq!((place.read(aside), place.read("scene.exr")), (content.to_vec(), other.read("scene.exr")));
        assert!(!place.path("scene.exr.checkpoint").exists());
    }
    // The longer render continues from the file that was moved aside.
    place.succeed(&format!("{LONG} --resume --checkpoint scene.exr.checkpoint.old"));
    assert_eq!(place.files(), ["scene.exr", "scene.exr.checkpoint.old.2", "scene.ron"]);
    // An interrupted render has a checkpoint of its own.
    place.write("scene.exr.checkpoint", &kept);
    let child = place.spawn(&format!("{LONG} --seed 7 --checkpoint-every 1ms"));
    wait_until("its checkpoint", || fs::read(place.path("scene.exr.checkpoint")).is_ok_and(|content| content != kept));
    signal(&child, "INT");
    assert_eq!(Run::end(child).code, Some(130));
    assert_eq!(place.read("scene.exr.checkpoint.old"), kept);
    place.succeed(&format!("{LONG} --seed 7 --resume"));
    assert_eq!(place.read("scene.exr"), other.read("scene.exr"));
    // A part is not a checkpoint.
    place.succeed("render scene.ron --shard 1/2 -o scene.part");
    let part = place.read("scene.part");
    for options in ["", "--resume", "--restart"] {
        place.fails(3, &format!("{LONG} --checkpoint scene.part {options}"), "scene.part: is not a checkpoint");
    }
    assert_eq!(place.read("scene.part"), part);
}

/// The label, which names the image, is intact.
#[test]
#[cfg(unix)]
fn a_damaged_checkpoint_of_this_image_is_kept_aside() {
    let (place, mut damaged) = interrupted_place();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 4;
    place.write("scene.exr.checkpoint", &damaged);
    let run = place.succeed(LONG);
    let note = "note: scene.exr.checkpoint: is damaged: its content does not match its hash; kept as \
                scene.exr.checkpoint.old; this render starts over\n";
    assert!(run.stdout.contains(note), "the note does not advise to remove the file: {run:?}");
    assert_eq!(place.read("scene.exr.checkpoint.old"), damaged);
}

#[test]
#[cfg(unix)]
fn any_flipped_bit_of_a_checkpoint_is_found() {
    let (place, kept) = interrupted_place();
    for step in 0..40 {
        let mut damaged = kept.clone();
        let at = step * (kept.len() - 1) / 39;
        damaged[at] ^= 1 << (step % 8);
        place.write("scene.exr.checkpoint", &damaged);
        let run = place.run(&format!("{LONG} --resume"));
        assert_eq!(run.code, Some(3), "byte {at}: {run:?}");
        let is_reported = run.stderr.contains("is damaged") || run.stderr.contains("is not a checkpoint");
        assert!(is_reported && run.stderr.lines().count() == 1, "byte {at}: {run:?}");
    }
    for length in [0, 5, 20, kept.len() / 2, kept.len() - 1] {
        place.write("scene.exr.checkpoint", &kept[..length]);
        assert_eq!(place.run(&format!("{LONG} --resume")).code, Some(3), "{length} bytes");
    }
}

#[test]
fn an_empty_checkpoint_is_refused_and_stays() {
    let place = Workplace::with_scene();
    place.write("scene.exr.checkpoint", "");
    for options in ["", "--resume", "--restart"] {
        let message = "scene.exr.checkpoint: is empty (0 bytes); remove it, and render again";
        place.fails(3, &format!("render scene.ron -o scene.exr {options}"), message);
        assert_eq!(place.files(), ["scene.exr.checkpoint", "scene.ron"], "{options}");
    }
}

#[test]
fn unusable_outputs_are_refused_before_the_render() {
    let place = Workplace::with_scene();
    place.write("notes.txt", "mine");
    let files = place.files();
    for (options, code, message) in [
        ("--checkpoint scene.ron --restart", 4, "it is an input"),
        ("--checkpoint scene.png", 2, "the checkpoint and another output have the same file scene.png"),
        ("--stats s.json --checkpoint s.json", 2, "the checkpoint and another output have the same file s.json"),
        (
            "--stats scene.png.checkpoint",
            2,
            "the checkpoint and another output have the same file scene.png.checkpoint",
        ),
        ("--aov samples=c.pfm --checkpoint c.pfm", 2, "two outputs have the same file c.pfm"),
        ("--checkpoint notes.txt --restart", 3, "notes.txt: is not a checkpoint"),
        ("--checkpoint -", 2, "--checkpoint requires the name of a file"),
        ("--checkpoint nowhere/kept", 4, "cannot write `nowhere/kept`: nowhere does not exist; create it"),
        ("-o a.png/", 4, "cannot write `a.png/`: a name with a slash at its end is that of a directory"),
        ("--stats a.json/.", 4, "cannot write `a.json/.`: a name with a slash at its end"),
        ("--aov samples=a.pfm/", 4, "cannot write `a.pfm/`: a name with a slash at its end"),
        ("--checkpoint kept/", 4, "cannot write `kept/`: a name with a slash at its end"),
        ("--shard 1/2 -o a.part/", 4, "cannot write `a.part/`: a name with a slash at its end"),
        ("--fallback-dir nowhere", 2, "--fallback-dir nowhere is not a directory"),
    ] {
        place.fails(code, &format!("render scene.ron {options}"), message);
        assert_eq!(place.files(), files, "{options}");
    }
}

#[test]
#[cfg(unix)]
fn two_renders_do_not_share_a_checkpoint() {
    let place = Workplace::with_scene();
    let long = LONG.replace("--spp 24", "--spp 2400");
    let child = place.spawn(&format!("{long} --checkpoint-every 1ms"));
    wait_until("a checkpoint", || place.path("scene.exr.checkpoint").exists());
    for options in ["--resume", "--restart", ""] {
        let refused = place.fails(3, &format!("{long} {options}"), "scene.exr.checkpoint: another render uses this");
        assert_eq!(refused.stderr.lines().count(), 1, "{refused:?}");
    }
    signal(&child, "INT");
    assert_eq!(Run::end(child).code, Some(130));
    assert!(place.path("scene.exr.checkpoint").exists());
}

/// The first render has moved an older checkpoint aside and is stopped, while the second one leaves its own.
#[test]
#[cfg(unix)]
fn a_render_keeps_the_checkpoint_of_another_one() {
    for (spp, code) in [("--spp 24", 0), ("--spp 2400", 130)] {
        let (place, kept) = interrupted_place();
        fs::create_dir(place.path("refuge")).expect("created");
        let first = LONG.replace("--spp 24", spp);
        let first = place.spawn(&format!("{first} --seed 7 --checkpoint-every never --fallback-dir refuge"));
        wait_until("the older checkpoint", || place.path("scene.exr.checkpoint.old").exists());
        signal(&first, "STOP");
        place.interrupt(&format!("{LONG} --seed 8 --checkpoint-every 1ms"), "scene.exr.checkpoint");
        let of_second = place.read("scene.exr.checkpoint");
        // The file that was moved aside is in use by no render.
        assert!(place.read("scene.exr.checkpoint.old") == kept);
        place.succeed(&format!("{LONG} --resume --checkpoint scene.exr.checkpoint.old"));

        if code == 130 {
            signal(&first, "INT");
        }
        signal(&first, "CONT");
        let run = Run::end(first);
        assert_eq!(run.code, Some(code), "{run:?}");
        assert!(place.read("scene.exr.checkpoint") == of_second, "{run:?}");
        assert_eq!(run.stderr.contains("; --resume --checkpoint refuge/rt-cli-"), code == 130, "{run:?}");
        place.succeed(&format!("{LONG} --seed 8 --resume"));
    }
}

#[test]
fn resume_without_a_checkpoint_begins() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron --resume");
    assert_eq!(place.files(), ["scene.png", "scene.ron"]);
}

/// Renders to a directory that is removed meanwhile.
fn after_the_folder_is_gone(place: &Workplace, options: &str, gone: impl FnOnce(&Path)) -> Run {
    let folder = place.path("images");
    fs::create_dir(&folder).expect("created");
    let options = format!("{LONG} {options}").replace("-o scene.exr", "-o images/scene.exr");
    let child = place.spawn(&format!("{options} --checkpoint-every 1ms --checkpoint kept"));
    wait_until("a checkpoint", || place.path("kept").exists());
    gone(&folder);
    Run::end(child)
}

#[test]
fn an_image_whose_directory_is_gone_goes_to_the_fallback() {
    let place = Workplace::with_scene();
    fs::create_dir(place.path("refuge")).expect("created");
    let options = "--fallback-dir refuge --aov samples=images/samples.exr --stats images/stats.json";
    let run = after_the_folder_is_gone(&place, options, |folder| fs::remove_dir_all(folder).expect("removed"));
    assert_eq!(run.code, Some(4), "{run:?}");
    // The image, the samples and the statistics: each is named, with where it is.
    assert_eq!(
        run.stderr.lines().filter(|line| line.contains("it was saved as `refuge/rt-cli-")).count(),
        3,
        "{run:?}"
    );
    let saved: Vec<_> =
        fs::read_dir(place.path("refuge")).expect("there").map(|file| file.expect("a file").path()).collect();
    assert_eq!(saved.len(), 3);
    let image = saved.iter().find(|file| file.to_string_lossy().ends_with("scene.exr")).expect("saved");
    let whole = Workplace::with_scene();
    whole.succeed(&format!("{LONG} --aov samples=samples.exr --stats stats.json"));
    assert_eq!(fs::read(image).expect("there"), whole.read("scene.exr"));
}

#[test]
#[cfg(unix)]
fn the_advice_after_an_interrupt_finds_the_checkpoint_of_the_fallback() {
    let whole = Workplace::with_scene();
    whole.succeed(LONG);
    // The checkpoint goes to the fallback alone, with the image, or as one of many frames.
    for (output, frame, code) in
        [("scene.exr", "", 130), ("saved/scene.exr", "", 4), ("scene-##.exr", "--frames 0", 130)]
    {
        let place = Workplace::with_scene();
        for folder in ["saved", "refuge"] {
            fs::create_dir(place.path(folder)).expect("created");
        }
        let command = LONG.replace("-o scene.exr", &format!("-o {output}"));
        let checkpoint = if frame.is_empty() { "saved/kept" } else { "saved/##" };
        let frames = if frame.is_empty() { "" } else { "--frames 0..2" };
        let options = format!("--fallback-dir refuge --checkpoint-every 1ms --checkpoint {checkpoint} {frames}");
        let child = place.spawn(&format!("{command} {options}"));
        wait_until("a checkpoint", || place.path("saved").read_dir().is_ok_and(|mut files| files.next().is_some()));
        fs::rename(place.path("saved"), place.path("gone")).expect("renamed");
        signal(&child, "INT");
        let run = Run::end(child);
        assert_eq!(run.code, Some(code), "{run:?}");
        let (_, advice) = run.stderr.split_once("; --resume --checkpoint ").expect("an advice");
        let (file, after) = advice.split_once(" continues").expect("an advice");
        let end = if frame.is_empty() { "\n" } else { " with --frames 0\n" };
        assert!(file.starts_with("refuge/rt-cli-") && after.starts_with(end), "{run:?}");
        fs::create_dir(place.path("saved")).expect("created");
        let run = place.succeed(&format!("{command} --resume --checkpoint {file} {frame}"));
        assert!(run.stdout.contains(&format!("note: continues from {file}")), "{run:?}");
        assert_eq!(place.read(&output.replace("##", "00")), whole.read("scene.exr"), "{output}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn an_image_for_a_full_disk_goes_to_the_fallback() {
    spoil_the_disk(
        "{ dd if=/dev/zero of=full/ballast bs=1k count=390 2>/dev/null || true; }",
        "No space left on device",
    );
}

#[test]
#[cfg(target_os = "linux")]
fn an_image_for_a_disk_that_became_read_only_goes_to_the_fallback() {
    spoil_the_disk("mount -o remount,ro full", "Read-only file system");
}

/// Renders to a small file system, which a shell command spoils meanwhile. Expects the error of the system and an image in the
/// fallback directory.
#[cfg(target_os = "linux")]
fn spoil_the_disk(command: &str, reason: &str) {
    let place = Workplace::with_scene();
    for folder in ["full", "refuge"] {
        fs::create_dir(place.path(folder)).expect("created");
    }
    place.write("full/scene.exr", "older");
    let script = format!(
        "mount -t tmpfs -o size=400k tmpfs full && echo older > full/scene.exr || exit 77
        \"$0\" \"$@\" &
        until [ -s kept ]; do sleep 0.01; done
        {command} || exit 77
        wait $!; code=$?
        cat full/scene.exr; exit $code"
    );
    let options = LONG
        .replace("-o scene.exr", "-o full/scene.exr --fallback-dir refuge --checkpoint kept --checkpoint-every 1ms");
    let mut command = Command::new("unshare");
    command.current_dir(place.path("")).args(["--user", "--map-root-user", "--mount", "sh", "-c", &script]);
    command.arg(env!("CARGO_BIN_EXE_rt-cli")).args(options.split_whitespace());
    let Ok(output) = command.output() else {
        return rt_tests::skip("there is no unshare");
    };
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    if output.status.code() == Some(77) || stderr.contains("unshare failed") {
        return rt_tests::skip(format_args!("no file system can be mounted here: {stderr}"));
    }
    assert_eq!(output.status.code(), Some(4), "{stdout} {stderr}");
    assert!(stderr.contains(reason) && stderr.contains("it was saved as `refuge/rt-cli-"), "{stderr}");
    assert!(stdout.ends_with("older\n"), "the older file survives: {stdout}");
    let saved = fs::read_dir(place.path("refuge")).expect("there").next().expect("saved").expect("a file");
    let whole = Workplace::with_scene();
    whole.succeed(LONG);
    assert_eq!(fs::read(saved.path()).expect("there"), whole.read("scene.exr"));
}

#[test]
#[cfg(unix)]
fn a_default_checkpoint_with_too_long_a_name_only_warns() {
    let place = Workplace::with_scene();
    // With `.checkpoint` it is longer than file systems allow.
    let image = format!("{}.exr", "a".repeat(246));
    let run = place.succeed(&format!("{} --checkpoint-every 1ms", LONG.replace("scene.exr", &image)));
    let warning = format!("warning: the render has no checkpoints: cannot write `{image}.checkpoint`: ");
    assert_eq!(run.stderr.lines().filter(|line| line.starts_with(&warning)).count(), 1, "{run:?}");
    assert_eq!(place.files(), [image, "scene.ron".to_owned()]);
}
