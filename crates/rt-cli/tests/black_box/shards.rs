//! Images of which several machines render a shard each.

use crate::program::{Run, Workplace};

const RENDER: &str = "render scene.ron --size 100x70 --integrator path --spp 16";

fn with_parts(count: u32, options: &str) -> Workplace {
    let place = Workplace::with_scene();
    for part in 1..=count {
        place.prints(
            &format!("{RENDER} {options} --shard {part}/{count}"),
            &format!("wrote scene.{part}-of-{count}.part (shard {part} of {count}"),
        );
    }
    place
}

fn parts(order: &[u32], count: u32) -> String {
    order.iter().map(|part| format!("scene.{part}-of-{count}.part ")).collect()
}

#[test]
fn parts_in_any_order_make_the_image_of_one_run() {
    let place = with_parts(5, "");
    let whole = Workplace::with_scene();
    let one = whole.succeed(&format!("{RENDER} -o scene.exr --aov samples=samples.exr --aov stderr=variance.pfm"));
    let aovs = "--aov samples=samples.exr --aov stderr=variance.pfm";
    let run = place.succeed(&format!("merge {} -o scene.exr {aovs}", parts(&[4, 1, 5, 3, 2], 5)));
    assert!(run.stdout.starts_with("merged 5 shards: 112,000 samples"), "{run:?}");
    let error = |run: &Run| run.stdout.lines().find(|line| line.starts_with("relative RMSE")).map(str::to_owned);
    assert!(error(&run).is_some() && error(&run) == error(&one), "the same measure: {run:?} {one:?}");
    for file in ["scene.exr", "samples.exr", "variance.pfm"] {
        assert_eq!(place.read(file), whole.read(file), "{file}");
    }
}

#[test]
fn parts_are_developed_as_the_scene_or_the_options_of_merge_say() {
    let place = Workplace::with(
        "scene.ron",
        crate::program::SCENE.replace("size: (48, 32)", "size: (48, 32), exposure: 1.5, tone: reinhard"),
    );
    for part in [1, 2] {
        place.succeed(&format!("render scene.ron --background transparent --shard {part}/2"));
    }
    place.succeed("render scene.ron --background transparent -o one.png");
    place.succeed("merge scene.1-of-2.part scene.2-of-2.part -o joined.png");
    assert_eq!(place.read("one.png"), place.read("joined.png"));
    place.succeed("render scene.ron --background transparent --exposure -1 --tone aces -o one.png");
    place.succeed("merge scene.1-of-2.part scene.2-of-2.part --exposure -1 --tone aces -o joined.png");
    assert_eq!(place.read("one.png"), place.read("joined.png"));
    // The first part in the list determined the exposure.
    place.succeed("render scene.ron --background transparent --exposure 3 --shard 2/2 -o bright.part");
    place.succeed("merge scene.1-of-2.part bright.part -o one.png");
    place.succeed("merge bright.part scene.1-of-2.part -o joined.png");
    assert_eq!(place.read("one.png"), place.read("joined.png"));
    let run = place.run("merge scene.1-of-2.part scene.2-of-2.part -o joined.hdr");
    assert_eq!(run.code, Some(2), "transparent images do not fit there: {run:?}");
}

#[test]
fn what_is_missing_doubled_or_foreign_is_named() {
    let place = with_parts(3, "");
    place.succeed(&format!("{RENDER} --seed 9 --shard 2/3 -o foreign.part"));
    place.succeed(&format!("{RENDER} --shard 1/2 -o half.part"));
    place.write("text.part", "no part");
    place.write("empty.part", "");
    let mut damaged = place.read("scene.2-of-3.part");
    let middle = damaged.len() / 2;
    damaged[middle] ^= 4;
    place.write("damaged.part", damaged);
    let all = parts(&[1, 2, 3], 3);
    let two = parts(&[1, 3], 3);
    for (files, message) in [
        (two.clone(), "shard 2/3 is missing; render it".to_owned()),
        (format!("{all} scene.2-of-3.part"), "scene.2-of-3.part is given twice".to_owned()),
        (format!("{two} foreign.part"), "foreign.part: is of another image".to_owned()),
        (format!("{two} half.part"), "half.part: is one of 2 shards, but scene.1-of-3.part is one of 3".to_owned()),
        (format!("{two} text.part"), "text.part: is not a shard of an image".to_owned()),
        (format!("{two} empty.part"), "empty.part: is empty (0 bytes); remove it, and render again".to_owned()),
        (format!("{two} damaged.part"), "damaged.part: is damaged".to_owned()),
        (format!("{two} nowhere.part"), "nowhere.part: does not exist".to_owned()),
        (format!("{two} scene.ron"), "scene.ron: is not a shard of an image".to_owned()),
    ] {
        let run = place.run(&format!("merge {files} -o scene.exr"));
        assert_eq!(run.code, Some(3), "{files}: {run:?}");
        assert!(run.stderr.contains(&message) && run.stderr.lines().count() == 1, "{files}: {run:?}");
        assert!(!place.path("scene.exr").exists());
    }
    let over_itself = place.run(&format!("merge {all} -o scene.1-of-3.part"));
    assert_eq!(over_itself.code, Some(2), "{over_itself:?}");
}

#[test]
fn parts_of_a_scene_that_was_named_without_a_folder_belonged_to_that_folder() {
    let [place, other] = [(); 2].map(|()| Workplace::with_scene());
    place.succeed(&format!("{RENDER} --shard 1/2"));
    other.succeed(&format!("{RENDER} --shard 2/2"));
    place.write("scene.2-of-2.part", other.read("scene.2-of-2.part"));
    place.succeed(&format!("merge {} -o scene.exr", parts(&[1, 2], 2)));
    other.succeed(&format!("{RENDER} -o scene.exr"));
    assert!(place.read("scene.exr") == other.read("scene.exr"));
}

#[test]
fn a_part_that_is_there_is_not_rendered_again() {
    let place = with_parts(2, "");
    let before = place.read("scene.1-of-2.part");
    place.prints(&format!("{RENDER} --shard 1/2 --resume"), "scene.1-of-2.part exists and is finished");
    assert_eq!(place.read("scene.1-of-2.part"), before);
    place.fails(3, &format!("{RENDER} --shard 1/2 --resume --seed 3"), "scene.1-of-2.part: is of another image");
}

#[test]
fn a_finished_part_without_its_statistics_is_rendered_again() {
    let place = with_parts(2, "");
    let resume = format!("{RENDER} --shard 1/2 --resume --stats");
    place.prints(&format!("{resume} stats.json"), "wrote scene.1-of-2.part");
    assert!(place.json("stats.json").is_object());
    place.prints(&format!("{resume} stats.json"), "scene.1-of-2.part exists and is finished");
    let run = place.succeed(&format!("{resume} -"));
    assert!(run.stdout.starts_with('{'), "{run:?}");
}

/// A kill after the shard is renamed and before its checkpoint is removed leaves both.
#[test]
#[cfg(unix)]
fn a_checkpoint_next_to_its_finished_part_is_removed() {
    let place = Workplace::with_scene();
    let of_shard = |shard: u32| {
        format!("render scene.ron --integrator path --size 160x120 --spp 24 --threads 2 --shard {shard}/2 -o a.part")
    };
    let kept = [1, 2].map(|shard| {
        place.interrupt(&format!("{} --checkpoint-every 1ms", of_shard(shard)), "a.part.checkpoint");
        let kept = place.read("a.part.checkpoint");
        std::fs::remove_file(place.path("a.part.checkpoint")).expect("removed");
        kept
    });
    place.succeed(&of_shard(1));
    let part = place.read("a.part");
    for (checkpoint, is_removed) in [(&kept[0], true), (&kept[1], false)] {
        place.write("a.part.checkpoint", checkpoint);
        place.prints(&format!("{} --resume", of_shard(1)), "a.part exists and is finished");
        assert_eq!(place.path("a.part.checkpoint").exists(), !is_removed);
        assert!(place.read("a.part") == part);
    }
}

#[test]
fn parts_that_make_no_sense_are_refused() {
    let place = Workplace::with_scene();
    for (options, message) in [
        ("--shard 0/8", "expected I/N, such as 1/8 to 8/8"),
        ("--shard 9/8", "expected I/N"),
        ("--shard 1/0", "expected I/N"),
        ("--shard one", "expected I/N"),
        ("--shard 1/8 -o scene.png", "--shard writes .part files, not scene.png"),
        ("-o scene.part", "scene.part is a .part file, which needs --shard I/N"),
        ("--shard 1/2 --time 3s", "--time cannot be used with --shard"),
        ("--shard 1/2 --target-error 1%", "--target-error cannot be used with --shard"),
        ("--shard 1/2 --aov samples=s.exr", "`merge` writes stderr and samples"),
        ("--checkpoint-every soon", "or never"),
        ("--resume --restart", "cannot be used with"),
    ] {
        place.fails(2, &format!("render scene.ron {options}"), message);
    }
    assert_eq!(place.files(), ["scene.ron"]);
}

/// The prediction lacked the maps of standard errors and sample counts.
#[test]
fn the_maps_of_a_part_count_as_memory() {
    let place = Workplace::with_scene();
    let run = place.run("render scene.ron --size 8000x8000 --spp 1 --shard 1/2 --memory 1800MiB");
    assert_eq!(run.code, Some(3), "{run:?}");
    assert!(run.stderr.contains("needs") && run.stderr.contains("--memory"), "{run:?}");
}
