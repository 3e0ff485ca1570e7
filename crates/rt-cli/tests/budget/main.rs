//! Memory is predicted before it is taken: what needs more than `--memory` allows is refused at once.
//!
//! A child begins with the peak of its parent's memory, so that nothing large is held here.

#![cfg(target_os = "linux")]

#[path = "../black_box/program.rs"]
#[allow(dead_code, reason = "other tests need more of it")]
mod program;

use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::process::{Command, Stdio};

use program::Workplace;
use wait4::{ResUse, Wait4};

/// Greatest processor time of a refusal in seconds; debug builds are slow.
const MAX_SECONDS: f64 = 2.0;
/// Greatest memory of a refusal.
const MAX_BYTES: u64 = 64 << 20;

/// Runs a command, with its errors to `stderr`.
fn run(place: &Workplace, arguments: &str, stderr: Stdio) -> ResUse {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rt-cli"));
    command.args(arguments.split_whitespace()).current_dir(place.path(""));
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(stderr);
    command.spawn().and_then(|mut child| child.wait4()).expect("a run")
}

/// Message of a refused command.
fn refused(place: &Workplace, arguments: &str) -> String {
    let before = place.files();
    let log = File::create(place.path("log.txt")).expect("a file");
    let used = run(place, arguments, log.into());
    let said = String::from_utf8(place.read("log.txt")).expect("text");
    std::fs::remove_file(place.path("log.txt")).expect("removed");
    assert_eq!(used.status.code(), Some(3), "{arguments}: {said}");
    assert_eq!(place.files(), before, "{arguments} leaves a file");
    let seconds = (used.rusage.utime + used.rusage.stime).as_secs_f64();
    assert!(seconds < MAX_SECONDS, "{arguments} takes {seconds} s: {said}");
    assert!(used.rusage.maxrss < MAX_BYTES, "{arguments} takes {} bytes: {said}", used.rusage.maxrss);
    assert_eq!(said.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{said}");
    assert!(said.contains(" of memory, more than the limit of ") && said.contains("; most of it, "), "{said}");
    said
}

/// The most memory that a render which succeeds takes.
fn peak(place: &Workplace, arguments: &str) -> u64 {
    let used = run(place, arguments, Stdio::null());
    assert!(used.status.success(), "{arguments}");
    used.rusage.maxrss
}

/// A file of this size that begins with `head`; what follows takes no room on the disk.
fn sparse(place: &Workplace, name: &str, head: &[u8], size: u64) {
    place.write(name, head);
    let file = OpenOptions::new().write(true).open(place.path(name)).expect("a file");
    file.set_len(size).expect("room");
}

#[test]
fn an_image_that_needs_more_is_refused_before_it_is_begun() {
    let place = Workplace::with_scene();
    let said = refused(&place, "render scene.ron --size 8192x8192 --spp 1 --memory 512M -o a.png");
    assert!(said.contains("for the image of 8192 x 8192 pixels") && said.contains("488.3 MiB"), "{said}");
    // The same size in passes needs more.
    let fits = "render scene.ron --size 1024x1024 --crop 0,0,8,8 --spp 1 --memory 16MiB -o b.png";
    place.succeed(fits);
    let passes = "explain scene.ron --size 4000x4000 --memory 500M";
    place.succeed(passes);
    let said = refused(&place, "render scene.ron --size 4000x4000 --time 1s --memory 500M -o a.png");
    assert!(said.contains("for the image of 4000 x 4000 pixels"), "{said}");
}

#[test]
fn each_scope_of_a_pbrt_file_had_a_copy_of_all_attributes() {
    let place = Workplace::new();
    let zeros = "0 ".repeat(200_000);
    let (begin, end) =
        ("AttributeBegin Attribute \"shape\" \"float a\" 1\n".repeat(1000), "AttributeEnd\n".repeat(1000));
    let text = format!("WorldBegin\nAttribute \"shape\" \"float zzz\" [{zeros}]\n{begin}Shape \"sphere\"\n{end}");
    place.write("scopes.pbrt", text.replace("\"float a\" 1", "\"float radius\" 1"));
    assert!(peak(&place, "explain scopes.pbrt --memory 64MiB") < MAX_BYTES);
}

#[test]
fn how_lines_are_laid_out_hid_what_they_hold() {
    let place = Workplace::new();
    let lines = "v 0.123456 0.654321 0.5\n".repeat(300_000) + &"f 1 2 3\n".repeat(100_000);
    place.write("indented.obj", lines.replace('\n', "\n  "));
    place.write("mac.obj", lines.replace('\n', "\r"));
    place.write("one.nff", "s 0 0 0 1 ".repeat(200_000));
    place.write("one.pbrt", format!("WorldBegin {}", "Shape \"sphere\" ".repeat(200_000)));
    for file in ["indented.obj", "mac.obj", "one.nff", "one.pbrt"] {
        let said = refused(&place, &format!("explain {file} --memory 32MiB"));
        assert!(said.contains(&format!("for the model {file}")), "{said}");
    }
}

#[test]
fn the_image_was_held_twice_when_its_tiles_were_joined() {
    const PIXELS: u64 = 1200 * 1000;
    let place = Workplace::with_scene();
    let small = peak(&place, "render scene.ron --size 8x8 --spp 1 -o a.png");
    // 12 bytes are the image, and 3 the bytes of the file; twice the image would be 24. On a busy machine, tiles may have to wait.
    let fits = (0..4).any(|_| {
        let large = peak(&place, "render scene.ron --size 1200x1000 --spp 1 -o a.png");
        let each = large.saturating_sub(small) as f64 / PIXELS as f64;
        println!("{each} bytes for a pixel");
        each < 20.0
    });
    assert!(fits);
}

#[test]
fn models_of_ten_million_triangles_are_refused_by_their_size() {
    let place = Workplace::new();
    let mut obj = File::create(place.path("m.obj")).expect("a file");
    for (line, times) in [("v 0.123456 0.654321 0.5\n", 5000), ("f 4000001 4000002 4000003\n", 10_000)] {
        let thousand = line.repeat(1000);
        (0..times).for_each(|_| obj.write_all(thousand.as_bytes()).expect("written"));
    }
    drop(obj);
    // The beginning of a GLB file: 500 bytes of JSON, and then data.
    let mut glb = b"glTF\x02\0\0\0\0\0\0\x14\xf4\x01\0\0JSON".to_vec();
    glb.extend(b"{}".repeat(10));
    sparse(&place, "m.glb", &glb, 320 << 20);
    let mut stl = vec![0; 80];
    stl.extend(10_000_000_u32.to_le_bytes());
    sparse(&place, "m.stl", &stl, 84 + 50 * 10_000_000);
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 5000000\nproperty float x\nproperty float y\nproperty float z\n\
               element face 10000000\nproperty list uchar int vertex_indices\nend_header\n";
    sparse(&place, "m.ply", ply.as_bytes(), 190 << 20);
    for (name, command) in
        [("m.obj", "render"), ("m.glb", "explain"), ("m.stl", "check"), ("m.ply", "render"), ("m.obj", "explain")]
    {
        let said = refused(&place, &format!("{command} {name} --memory 100M"));
        assert!(said.contains(&format!("for the model {name}")) && said.contains("95.4 MiB"), "{said}");
    }
    refused(&place, "convert m.obj --memory 100M -o m.ron");
}

#[test]
fn textures_are_refused_by_their_header() {
    let place = Workplace::with("large.hdr", image_of(3000, 2000, 20_000));
    place.write("small.hdr", image_of(100, 100, 4 * 100 * 100));
    let scene = r#"(
        camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), fov: 40),
        lights: [ambient(gray(1))],
        materials: {"m": phong(color: image(file: "FILE"))},
        nodes: [(shape: sphere(), material: "m")],
    )"#;
    for size in ["large", "small"] {
        place.write(&format!("{size}.ron"), scene.replace("FILE", &format!("{size}.hdr")));
    }
    place.write("plain.ron", program::SCENE);
    let said = refused(&place, "render large.ron --memory 100M");
    assert!(said.contains("for the texture ") && said.contains("large.hdr"), "{said}");
    let said = refused(&place, "render plain.ron --env large.hdr --memory 100M");
    assert!(said.contains("large.hdr"), "{said}");
    place.succeed("render small.ron --size 8x8 --memory 100M");
    place.succeed("render plain.ron --size 8x8 --env small.hdr --memory 100M");
}

#[test]
fn images_to_compare_or_develop_are_refused_by_their_header() {
    let place = Workplace::with("large.hdr", image_of(3000, 2000, 20_000));
    place.write("small.hdr", image_of(100, 100, 4 * 100 * 100));
    let said = refused(&place, "develop large.hdr -o a.png --memory 100M");
    assert!(said.contains("large.hdr: needs ") && said.contains("95.4 MiB"), "{said}");
    refused(&place, "compare large.hdr large.hdr --memory 200M");
    refused(&place, "compare small.hdr large.hdr --memory 100M");
    refused(&place, "compare large.hdr small.hdr --memory 100M");
    place.succeed("develop small.hdr -o a.png --memory 1M");
    place.succeed("compare small.hdr small.hdr --heat-map b.png --memory 1M");
}

#[test]
fn images_take_no_more_than_predicted() {
    const PIXELS: u64 = 640 * 480;
    const FEW_PIXELS: u64 = 320 * 240;
    let place = Workplace::with_scene();
    for name in ["a.exr", "b.exr", "a.png", "a.pfm"] {
        place.succeed(&format!("render scene.ron --size 640x480 --spp 1 -o {name}"));
        place.succeed(&format!("render scene.ron --size 320x240 --spp 1 -o small-{name}"));
    }
    for (command, bytes) in [
        ("compare a.exr b.exr", 40),
        ("compare a.exr b.exr --heat-map h.png", 56),
        ("compare a.exr a.png", 40),
        ("develop a.exr -o o.png", 24),
        ("develop a.png -o o.jpg", 19),
        ("develop a.pfm -o o.png", 16),
    ] {
        refused(&place, &format!("{command} --memory {}", bytes * PIXELS - 1));
        let _ = std::fs::remove_file(place.path("o.png"));
        // Code, stacks and buffers of the program take as much with a smaller image.
        let smaller = peak(&place, &command.replace(" a.", " small-a.").replace(" b.", " small-b."));
        let taken = peak(&place, &format!("{command} --memory {}", bytes * PIXELS)).saturating_sub(smaller);
        let each = taken as f64 / (PIXELS - FEW_PIXELS) as f64;
        assert!(each < 1.1 * bytes as f64 + 1.0, "{command} takes {each} bytes a pixel, not {bytes}");
    }
}

#[test]
fn parts_and_checkpoints_are_refused_by_their_size() {
    let place = Workplace::with_scene();
    for part in [1, 2] {
        place.succeed(&format!("render scene.ron --size 1000x800 --spp 1 --shard {part}/2 -o {part}.part"));
    }
    let said = refused(&place, "merge 1.part 2.part -o a.exr --memory 12M");
    assert!(said.contains("merging 2 shards: needs ") && said.contains("for the content of 2 shards"), "{said}");
    let said = refused(&place, "merge 1.part 2.part -o a.exr --memory 30M");
    assert!(said.contains("for the image"), "{said}");
    let at_rest = peak(&place, "--version");
    let taken = peak(&place, "merge 1.part 2.part -o a.exr --memory 60M") - at_rest;
    assert!(taken < 60_000_000, "{taken}");
    // File with the header of a part, and larger than any.
    let mut head = [0; 300];
    File::open(place.path("1.part")).and_then(|mut file| file.read_exact(&mut head)).expect("read");
    sparse(&place, "long.part", &head, 1 << 40);
    let said = refused(&place, "merge long.part 2.part -o a.exr --memory 1GiB");
    assert!(said.contains("for the content of 2 shards"), "{said}");
    let said = refused(&place, "merge 1.part long.part -o a.exr --memory 1GiB");
    assert!(said.contains("for the content of 2 shards"), "{said}");
    let resumed = "render scene.ron --size 1000x800 --spp 1 --shard 1/2 --resume --memory 1GiB";
    let said = refused(&place, &format!("{resumed} -o long.part"));
    assert!(said.contains("for the shard of an image long.part"), "{said}");
}

/// A black Radiance image that claims this size, with so many bytes of pixels.
fn image_of(width: u32, height: u32, bytes: usize) -> Vec<u8> {
    let mut image = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    image.resize(image.len() + bytes, 0);
    image
}

#[test]
fn instances_are_refused_by_their_number() {
    let place = Workplace::new();
    let ten = |what: &str| format!("(instance: \"{what}\"), ").repeat(10);
    let mut groups = r#""g0": [(shape: sphere()), (shape: sphere(center: (3, 0, 0)))], "#.to_owned();
    for i in 1..9 {
        write!(groups, "\"g{i}\": [{}], ", ten(&format!("g{}", i - 1))).expect("memory");
    }
    place.write("many.ron", format!("(groups: {{{groups}}}, nodes: [{}])", ten("g8")));
    for command in ["render", "explain", "check"] {
        let said = refused(&place, &format!("{command} many.ron --memory 4GiB"));
        assert!(said.contains("200000000 objects of the group `g8`"), "{said}");
        assert!(said.contains("GiB of memory"), "{said}");
    }
}

#[test]
fn the_default_is_a_share_of_what_there_is() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron --size 8x8");
    place.succeed("render scene.ron --size 8x8 --memory 90% -o b.png");
    let wrong = place.run("render scene.ron --memory 12parsecs");
    assert_eq!(wrong.code, Some(2), "{wrong:?}");
    let table = place.succeed("--limits").stdout;
    for row in [
        "predicted memory",
        "size of a file",
        "nesting of brackets",
        "pixels of a texture",
        "bounces of a ray",
        "dielectrics around a point",
        "null interfaces in a row",
    ] {
        assert!(table.lines().any(|line| line.trim_start().starts_with(row)), "{row} in {table}");
    }
    let of = |row: &str| table.lines().find(|line| line.trim_start().starts_with(row)).unwrap_or_default().to_owned();
    assert!(of("predicted memory").contains("--memory") && of("size of a file").contains("--max-file-size"), "{table}");
    assert!(of("size of a file").contains("1.0 GiB"), "{table}");
}

/// The render ended with "memory allocation failed" and a core dump.
#[test]
fn a_limit_of_the_address_space_is_part_of_the_default() {
    let place = Workplace::with_scene();
    let script = "ulimit -v 500000 && exec \"$0\" render scene.ron --size 8000x8000";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_rt-cli")]).current_dir(place.path(""));
    let run = command.output().expect("a shell");
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(3), "{said}");
    assert!(said.contains("more than the limit of 366.2 MiB (raise --memory)"), "{said}");
}

#[test]
fn the_largest_file_can_be_chosen() {
    let place = Workplace::with_scene();
    place.succeed("explain scene.ron --max-file-size 1MiB");
    let run = place.run("explain scene.ron --max-file-size 1000");
    assert_eq!(run.code, Some(3), "{run:?}");
    assert!(run.stderr.contains("above the limit of 1000"), "{run:?}");
}
