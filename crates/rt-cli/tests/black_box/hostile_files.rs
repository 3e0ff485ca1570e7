//! Crafted checkpoints, parts and frame logs, and links of their names.

use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;
use std::time::{Duration, Instant};

use rt_render::Shard;
use serde_json::Value;

use crate::program::{Run, Workplace};

const RENDER: &str = "render scene.ron --size 20x18 --spp 1";

const MAGIC: usize = b"rt-cli checkpoint 2\n".len();

const HASH: usize = 16;

/// Part file: label, content and hash.
struct PartFile {
    label: Vec<u8>,
    part: Value,
}

impl PartFile {
    fn read(bytes: &[u8]) -> Self {
        let content = &bytes[..bytes.len() - HASH];
        let decode = |at: usize| match postcard::take_from_bytes::<Shard>(&content[at..]) {
            Ok((part, [])) => Some((at, part)),
            _ => None,
        };
        let (at, part) = (MAGIC..content.len()).find_map(decode).expect("a shard");
        Self { label: content[..at].to_vec(), part: serde_json::to_value(part).expect("numbers") }
    }

    /// File with a number of the part replaced.
    fn with(&self, number: &str, value: u64) -> Vec<u8> {
        // A unique number marks the position.
        const MARK: u64 = 0x7A11_7A11_7A11;
        let mut part = self.part.clone();
        *part.pointer_mut(number).unwrap_or_else(|| panic!("{number}")) = MARK.into();
        let part: Shard = serde_json::from_value(part).expect("a shard");
        let content = postcard::to_stdvec(&part).expect("written");
        let mark = postcard::to_stdvec(&MARK).expect("written");
        let at = content.windows(mark.len()).position(|bytes| bytes == mark).expect("the mark");
        let value = postcard::to_stdvec(&value).expect("written");
        let content = [&content[..at], &value, &content[at + mark.len()..]].concat();
        self.file(&content)
    }

    fn file(&self, content: &[u8]) -> Vec<u8> {
        let bytes = [&self.label, content].concat();
        let hash = xxhash_rust::xxh3::xxh3_128(&bytes).to_le_bytes();
        [&bytes[..], &hash].concat()
    }
}

fn with_parts() -> Workplace {
    let place = Workplace::with_scene();
    for part in [1, 2] {
        place.succeed(&format!("{RENDER} --shard {part}/2 -o {part}.part"));
    }
    place
}

#[test]
fn crafted_parts_are_refused() {
    let place = with_parts();
    let part = PartFile::read(&place.read("1.part"));
    assert_eq!(
        part.file(
            &postcard::to_stdvec(&serde_json::from_value::<Shard>(part.part.clone()).expect("a shard"))
                .expect("written")
        ),
        place.read("1.part")
    );
    for number in [
        "/statistics/samples",
        "/statistics/bad_samples",
        "/statistics/primary_rays_skipped",
        "/statistics/counters/by_kind/0/rays",
        "/statistics/counters/by_kind/4/hits",
        "/statistics/shading/fresnel",
    ] {
        for value in [u64::MAX, u64::MAX - 1000, 1 << 61] {
            place.write("crafted.part", part.with(number, value));
            for order in ["crafted.part 2.part", "2.part crafted.part"] {
                let run = place.run(&format!("merge {order} -o scene.exr"));
                assert_eq!(run.code, Some(3), "{number} = {value}: {run:?}");
                let is_reported = run.stderr.contains("crafted.part: is not a valid shard of an image: the number of");
                assert!(is_reported && run.stderr.lines().count() == 1, "{number} = {value}: {run:?}");
                assert!(!place.path("scene.exr").exists());
            }
        }
    }
    // A count that is possible is taken.
    place.write("crafted.part", part.with("/statistics/shading/fresnel", 1 << 50));
    place.succeed("merge crafted.part 2.part -o scene.exr");
}

/// Runs a command that must end at once.
fn at_once(place: &Workplace, arguments: &str) -> Run {
    let started = Instant::now();
    let mut child = place.spawn(arguments);
    while child.try_wait().expect("it can be asked").is_none() {
        if started.elapsed() > Duration::from_secs(20) {
            child.kill().expect("it runs");
            panic!("{arguments} does not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Run::end(child)
}

#[test]
fn pipes_and_devices_do_not_block() {
    let place = with_parts();
    assert!(Command::new("mkfifo").arg(place.path("pipe")).status().expect("mkfifo").success());
    fs::create_dir(place.path("folder")).expect("created");
    place.write("empty", "");
    place.write("short.part", &place.read("1.part")[..40]);
    let files = place.files();
    for (file, message) in [
        ("/dev/zero", "not a regular file"),
        ("pipe", "not a regular file"),
        ("folder", "not a regular file"),
        ("empty", "empty"),
        ("short.part", "short.part"),
        ("nowhere", "nowhere"),
    ] {
        for command in [
            format!("merge {file} -o out.png"),
            format!("merge 1.part {file} -o out.png"),
            format!("compare {file} {file}"),
            format!("develop {file} -o out.png"),
        ] {
            let run = at_once(&place, &command);
            assert_eq!(run.code, Some(3), "{command}: {run:?}");
            assert!(run.stderr.contains(message) && run.stderr.lines().count() == 1, "{command}: {run:?}");
        }
    }
    for file in ["pipe", "/dev/zero", "folder"] {
        for options in ["", "--resume", "--restart"] {
            let run = at_once(&place, &format!("{RENDER} --checkpoint {file} {options}"));
            assert_eq!(run.code, Some(3), "{file} {options}: {run:?}");
            assert!(run.stderr.contains("is not a regular file"), "{file} {options}: {run:?}");
        }
    }
    let run = at_once(&place, &format!("{RENDER} --shard 1/2 --resume -o pipe.part --checkpoint pipe"));
    assert_eq!(run.code, Some(3), "{run:?}");
    assert_eq!(place.files(), files);
    // What looks like the rest of a killed run may be a pipe as well.
    fs::rename(place.path("pipe"), place.path(".scene.png-x.unfinished")).expect("renamed");
    assert_eq!(at_once(&place, RENDER).code, Some(0));
}

#[test]
fn links_named_like_checkpoints_parts_and_frame_logs_are_not_followed() {
    let place = Workplace::with_scene();
    place.write("precious", "precious");
    let names = [
        "scene.png.checkpoint.new",
        "scene.png.checkpoint",
        "scene.1-of-2.part",
        "scene.1-of-2.part.checkpoint",
        "scene-####.png.frames.json",
        "scene-0001.png.checkpoint",
    ];
    let long = "render scene.ron --size 80x60 --spp 16 --checkpoint-every 1ms";
    for target in ["precious", "nowhere"] {
        for name in names {
            symlink(place.path(target), place.path(name)).expect("linked");
        }
        place.succeed(long);
        place.succeed(&format!("{long} --shard 1/2"));
        if target == "nowhere" {
            place.succeed(&format!("{RENDER} --frames 1..2"));
            assert!(!place.path("scene-####.png.frames.json").is_symlink());
        } else {
            let run = place.run(&format!("{RENDER} --frames 1..2"));
            assert_eq!(run.code, Some(3), "a log that cannot be read: {run:?}");
        }
        assert_eq!(place.read("precious"), b"precious");
        assert!(!place.path("nowhere").exists() && !place.path("scene.1-of-2.part").is_symlink());
        for name in names.iter().chain(&["scene.png", "scene-0001.png"]) {
            let _ = fs::remove_file(place.path(name));
        }
    }
    // A finished render takes a checkpoint away, and never what a link leads to.
    symlink(place.path("precious"), place.path("scene.png.checkpoint")).expect("linked");
    place.succeed(RENDER);
    assert!(place.path("precious").exists() && !place.path("scene.png.checkpoint").is_symlink());
}

#[test]
fn overlapping_runs_log_all_frames() {
    let place = Workplace::with_scene();
    let render = |frames: &str| {
        let arguments = format!("render scene.ron --size 4x4 --spp 1 --frames {frames} -o out-##.pfm --quiet");
        place.command(&arguments).spawn().expect("it starts")
    };
    let runs: Vec<_> = ["0..19", "20..39", "40..59"].map(render).into();
    for mut run in runs {
        assert_eq!(run.wait().expect("it ended").code(), Some(0));
    }
    let log = place.json("out-##.pfm.frames.json");
    let frames = log["frames"].as_object().expect("frames");
    let missing: Vec<_> = (0..60).filter(|frame| !frames.contains_key(&frame.to_string())).collect();
    assert!(missing.is_empty(), "{missing:?} are missing");
    assert_eq!(place.files().len(), 62, "an image for each frame, the log, and the scene");
}
