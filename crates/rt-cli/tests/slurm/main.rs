//! An image rendered by a Slurm cluster: parts, one of which is killed and queued again, and the job that joins them.

#![cfg(target_os = "linux")]

mod cluster;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use cluster::Cluster;

const OPTIONS: [&str; 6] = ["--size", "320x240", "--spp", "64", "--checkpoint-every", "20ms"];
const PARTS: usize = 8;

/// Waits for a file. Slurm delays a requeued job by two minutes; this skips the delay.
fn wait_for(cluster: &Cluster, queued_again: &str, file: &str) {
    let mut hurried = Instant::now();
    let is_there = || {
        // Fails until the job waits; frequent requests starve the scheduler.
        if hurried.elapsed() > Duration::from_secs(8) {
            let _ = cluster.slurm("scontrol", &["update", &format!("JobId={queued_again}"), "StartTime=now"]);
            hurried = Instant::now();
        }
        cluster.path(file).exists()
    };
    assert!(cluster.wait(Duration::from_secs(300), is_there), "no {file}: {}", cluster.logs());
}

/// The process that renders a part, by its command line.
fn process_of(part: &str) -> Option<u32> {
    let is_it = |folder: &PathBuf| {
        let words = fs::read(folder.join("cmdline")).unwrap_or_default();
        let mut words = words.split(|&byte| byte == 0);
        words.next().is_some_and(|program| program.ends_with(b"rt-cli"))
            && words.any(|word| word.ends_with(part.as_bytes()))
    };
    let folders = fs::read_dir("/proc").ok()?.flatten().map(|entry| entry.path());
    folders.into_iter().find(is_it)?.file_name()?.to_str()?.parse().ok()
}

fn render_alone(cluster: &Cluster, scene: &Path) -> Vec<u8> {
    let mut alone = Command::new(env!("CARGO_BIN_EXE_rt-cli"));
    alone.current_dir(cluster.path("")).arg("render").arg(scene).args(OPTIONS).args(["-o", "alone.exr", "--quiet"]);
    assert!(alone.status().expect("it starts").success());
    fs::read(cluster.path("alone.exr")).expect("there")
}

#[test]
fn eight_parts_on_slurm_one_of_them_killed_have_the_bits_of_one_run() {
    let cluster = match Cluster::start() {
        Ok(cluster) => cluster,
        Err(reason) => return rt_tests::skip(format_args!("no Slurm cluster can be started here: {reason}")),
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the project");
    let scene = root.join("scenes/lecture/cornell-direct.ron");
    let mut submit = cluster.command(root.join("contrib/slurm/submit.sh"));
    submit
        .env("RT_CLI", env!("CARGO_BIN_EXE_rt-cli"))
        .arg(&scene)
        .args([&PARTS.to_string(), "picture.exr"])
        .args(OPTIONS);
    let submitted = submit.output().expect("it starts");
    let said = String::from_utf8_lossy(&submitted.stdout).into_owned();
    assert!(submitted.status.success(), "{said} {}", String::from_utf8_lossy(&submitted.stderr));
    let array = said.split([' ', ',']).nth(2).expect("the job's number").to_owned();

    // One is killed when it has something to lose, and queues itself again.
    let part = "5-of-8.part";
    let has_begun = || cluster.path(format!("picture.exr.parts/{part}.checkpoint")).exists();
    assert!(cluster.wait(Duration::from_secs(120), has_begun), "no checkpoint: {}", cluster.logs());
    let process = process_of(part).expect("it runs").to_string();
    assert!(Command::new("kill").args(["-s", "KILL", &process]).status().expect("there is a kill").success());
    wait_for(&cluster, &format!("{array}_5"), "picture.exr");
    let log = fs::read_to_string(cluster.path("picture.exr.parts/5.log")).expect("a log");
    assert!(log.contains("note: continues from picture.exr.parts/5-of-8.part.checkpoint"), "{log}");
    assert_eq!(fs::read(cluster.path("picture.exr")).expect("there"), render_alone(&cluster, &scene));
}

#[test]
fn a_job_that_runs_out_of_time_saves_and_queues_itself_again() {
    let cluster = match Cluster::start() {
        Ok(cluster) => cluster,
        Err(reason) => return rt_tests::skip(format_args!("no Slurm cluster can be started here: {reason}")),
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the project");
    let scene = root.join("scenes/lecture/cornell-direct.ron");
    let mut submit = cluster.command("sbatch");
    submit.env("RT_CLI", env!("CARGO_BIN_EXE_rt-cli")).args(["--parsable", "--array=1-1", "--output=%a.log"]);
    let submitted = submit.arg(root.join("contrib/slurm/part.sbatch")).arg(&scene).arg(".").args(OPTIONS).output();
    let job = format!("{}_1", String::from_utf8_lossy(&submitted.expect("sbatch").stdout).trim());
    let has_begun = || cluster.path("1-of-1.part.checkpoint").exists();
    assert!(cluster.wait(Duration::from_secs(60), has_begun), "{}", cluster.logs());
    // What Slurm sends to the script 90 seconds before the time limit.
    assert!(cluster.slurm("scancel", &["--batch", "--signal=TERM", &job]).expect("scancel").status.success());
    wait_for(&cluster, &job, "1-of-1.part");
    let log = fs::read_to_string(cluster.path("1.log")).expect("a log");
    assert!(log.contains("interrupted ") && log.contains("note: continues from"), "{log}");
}
