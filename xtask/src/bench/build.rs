//! Cold build: processor and wall seconds of each package, measured by this program as the wrapper of rustc.

use std::{
    collections::BTreeMap,
    env,
    ffi::OsString,
    fs::{self, OpenOptions},
    io::Write as _,
    path::Path,
    process::{Command, ExitCode},
    time::Instant,
};

use wait4::{ResUse, Wait4 as _};

use crate::{
    error::TaskError,
    files,
    table::Table,
    workspace::{Workspace, cargo},
};

/// Names the log in which the wrapper writes one line per call of rustc.
const LOG: &str = "RT_BUILD_LOG";
/// Packages that take less are added up in the page.
const LISTED_SECONDS: f64 = 1.0;

#[derive(Debug, clap::Args)]
pub(super) struct BuildOptions {
    /// Build this package and its dependencies.
    #[arg(long, default_value = "rt-cli")]
    package: String,
    /// Build with this profile.
    #[arg(long, default_value = "dev")]
    profile: String,
    /// Also write the page docs/BUILD-TIME.md.
    #[arg(long)]
    write: bool,
}

/// Seconds of one or more processes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Seconds {
    cpu: f64,
    wall: f64,
}

/// Compiles as rustc if this program was started as its wrapper; `None` if it was not.
pub(crate) fn wrapped_rustc() -> Option<ExitCode> {
    let log = env::var_os(LOG)?;
    let mut args = env::args_os().skip(1);
    let rustc = args.next()?;
    let args: Vec<OsString> = args.collect();
    let started = Instant::now();
    let used = Command::new(&rustc).args(&args).spawn().and_then(|mut child| child.wait4());
    let Ok(used) = used else {
        eprintln!("error: {} cannot be run", rustc.display());
        return Some(ExitCode::FAILURE);
    };
    // Calls that query the compiler have no crate name, or this one.
    let is_crate = args.windows(2).any(|pair| pair[0] == "--crate-name" && pair[1] != "___");
    if let (true, Ok(package)) = (is_crate, env::var("CARGO_PKG_NAME")) {
        let Seconds { cpu, wall } = Seconds::of(&used, started);
        let line = format!("{package} {cpu} {wall}\n");
        // Appending one short line is atomic. A line that is lost shows as time that no package took.
        let _ =
            OpenOptions::new().append(true).create(true).open(log).and_then(|mut log| log.write_all(line.as_bytes()));
    }
    Some(if used.status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Builds into an empty folder, without downloads if an earlier build has made them. Prints the table, and with `--write` writes the page.
pub(super) fn run(workspace: &Workspace, options: &BuildOptions) -> Result<(), TaskError> {
    let folder = workspace.fresh_folder("bench-build")?;
    let log = folder.join("rustc.log");
    let this = env::current_exe().map_err(TaskError::other)?;
    let BuildOptions { package, profile, .. } = options;
    let mut command = cargo();
    command.args(["build", "--locked", "--package", package, "--profile", profile, "--target-dir"]).arg(&folder);
    command.current_dir(&workspace.root).env("RUSTC_WRAPPER", this).env(LOG, &log).env_remove("CARGO_INCREMENTAL");
    let name = format!("{command:?}");
    let failed = |reason: String| TaskError::Command { command: name.clone(), reason };
    let started = Instant::now();
    let used = command.spawn().and_then(|mut child| child.wait4()).map_err(|error| failed(error.to_string()))?;
    if !used.status.success() {
        return Err(failed(used.status.to_string()));
    }
    let all = Seconds::of(&used, started);
    let text = files::read(&log)?;
    let packages = read_log(&text);
    fs::remove_dir_all(&folder).map_err(TaskError::file(&folder))?;
    print!("{}", table(&packages, all, 0.0));
    if options.write {
        let path = workspace.root.join("docs/BUILD-TIME.md");
        let page = page(options, &table(&packages, all, LISTED_SECONDS), &workspace.provenance());
        files::write(&path, page)?;
        println!("wrote {}", workspace.relative(Path::new(&path)));
    }
    Ok(())
}

impl Seconds {
    fn of(used: &ResUse, started: Instant) -> Self {
        let cpu = (used.rusage.utime + used.rusage.stime).as_secs_f64();
        Self { cpu, wall: started.elapsed().as_secs_f64() }
    }

    fn plus(self, other: Self) -> Self {
        Self { cpu: self.cpu + other.cpu, wall: self.wall + other.wall }
    }
}

/// Seconds by package; a build script counts as part of its package.
fn read_log(log: &str) -> BTreeMap<&str, Seconds> {
    let mut packages: BTreeMap<&str, Seconds> = BTreeMap::new();
    for line in log.lines() {
        let mut words = line.split(' ');
        if let (Some(package), Some(cpu), Some(wall)) = (words.next(), words.next(), words.next())
            && let (Ok(cpu), Ok(wall)) = (cpu.parse(), wall.parse())
        {
            let sum = packages.entry(package).or_default();
            *sum = sum.plus(Seconds { cpu, wall });
        }
    }
    packages
}

/// A row per package, the longest first; those below `min_cpu` seconds are added up.
fn table(packages: &BTreeMap<&str, Seconds>, all: Seconds, min_cpu: f64) -> Table {
    let mut table = Table::new(1, ["package", "CPU s", "wall s"]);
    let mut row = |name: &str, seconds: Seconds| {
        table.push([name.to_owned(), format!("{:.1}", seconds.cpu), format!("{:.1}", seconds.wall)]);
    };
    let mut sorted: Vec<(&str, Seconds)> = packages.iter().map(|(name, seconds)| (*name, *seconds)).collect();
    sorted.sort_by(|a, b| b.1.cpu.total_cmp(&a.1.cpu));
    let (listed, small): (Vec<_>, Vec<_>) = sorted.into_iter().partition(|(_, seconds)| seconds.cpu >= min_cpu);
    let sum =
        |packages: &[(&str, Seconds)]| packages.iter().fold(Seconds::default(), |sum, package| sum.plus(package.1));
    for (name, seconds) in &listed {
        row(name, *seconds);
    }
    if !small.is_empty() {
        row(&format!("{} smaller packages", small.len()), sum(&small));
    }
    let compiled = sum(&listed).plus(sum(&small)).cpu;
    row("cargo and build scripts", Seconds { cpu: (all.cpu - compiled).max(0.0), wall: 0.0 });
    row(&format!("all {} packages", packages.len()), all);
    table
}

fn page(options: &BuildOptions, table: &Table, provenance: &str) -> String {
    let BuildOptions { package, profile, .. } = options;
    format!(
        "# Build time\n\n\
         After reading this page you know which packages dominate the build time of `{package}`.\n\n\
         Cold build of `{package}` with the profile `{profile}` and all dependencies, into an empty target directory, after all \
         downloads. Written by `cargo xtask bench build --package {package} --profile {profile} --write` on {provenance}.\n\n\
         CPU seconds are user and system time of rustc and of the linkers that it starts. Wall seconds of packages overlap; \
         the last row has those of the whole build.\n\n\
         {table}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_added_up_and_sorted() {
        let packages = read_log("a 0.5 0.75\nb 2 3\na 0.25 0.5\nc 0.125 0.125\nbroken\n");
        assert_eq!(packages["a"], Seconds { cpu: 0.75, wall: 1.25 });
        let text = table(&packages, Seconds { cpu: 4.0, wall: 3.5 }, 0.5).to_string();
        let rows: Vec<Vec<&str>> = text
            .lines()
            .skip(2)
            .map(|line| line.split('|').map(str::trim).filter(|cell| !cell.is_empty()).collect())
            .collect();
        assert_eq!(
            rows,
            [
                ["b", "2.0", "3.0"],
                ["a", "0.8", "1.2"],
                ["1 smaller packages", "0.1", "0.1"],
                ["cargo and build scripts", "1.1", "0.0"],
                ["all 3 packages", "4.0", "3.5"]
            ]
        );
    }
}
