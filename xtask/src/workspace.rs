//! Paths and packages of the workspace, from `cargo metadata`.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use serde::Deserialize;

use crate::error::TaskError;

/// The workspace that this task runs in.
#[derive(Debug, Deserialize)]
pub(crate) struct Workspace {
    /// Folder of the root manifest.
    #[serde(rename = "workspace_root")]
    pub root: PathBuf,
    #[serde(rename = "target_directory")]
    target: PathBuf,
    pub packages: Vec<Package>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Package {
    pub name: String,
    pub manifest_path: PathBuf,
    pub dependencies: Vec<Dependency>,
}

/// A dependency as its manifest declares it.
#[derive(Debug, Deserialize)]
pub(crate) struct Dependency {
    pub name: String,
    /// `None` for a normal dependency, else "dev" or "build".
    pub kind: Option<String>,
    /// Set for crates of the workspace.
    pub path: Option<PathBuf>,
}

/// The cargo that runs this task.
pub(crate) fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// Runs a command and returns what it prints; its messages go to the terminal.
pub(crate) fn output_of(command: &mut Command) -> Result<String, TaskError> {
    let output = command.stderr(Stdio::inherit()).output();
    let failed = |reason: String| TaskError::Command { command: format!("{command:?}"), reason };
    let output = output.map_err(|error| failed(error.to_string()))?;
    if !output.status.success() {
        return Err(failed(output.status.to_string()));
    }
    String::from_utf8(output.stdout).map_err(|error| failed(error.to_string()))
}

/// Entries of a folder, sorted.
pub(crate) fn sorted_entries(folder: &Path) -> Result<Vec<PathBuf>, TaskError> {
    let entries = fs::read_dir(folder).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    let mut paths: Vec<PathBuf> = entries.map_err(TaskError::file(folder))?;
    paths.sort();
    Ok(paths)
}

impl Workspace {
    /// Runs `cargo metadata`.
    pub(crate) fn load() -> Result<Self, TaskError> {
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let mut command = cargo();
        command.args(["metadata", "--format-version", "1", "--no-deps", "--manifest-path"]).arg(&manifest);
        let metadata = output_of(&mut command)?;
        serde_json::from_str(&metadata).map_err(TaskError::file(&manifest))
    }

    /// A fresh, empty folder below the target folder.
    pub(crate) fn fresh_folder(&self, name: &str) -> Result<PathBuf, TaskError> {
        let folder = self.target.join(name);
        if folder.exists() {
            fs::remove_dir_all(&folder).map_err(TaskError::file(&folder))?;
        }
        self.folder(name)
    }

    /// A folder below the target folder, with what earlier runs left in it.
    pub(crate) fn folder(&self, name: &str) -> Result<PathBuf, TaskError> {
        let folder = self.target.join(name);
        fs::create_dir_all(&folder).map_err(TaskError::file(&folder))?;
        Ok(folder)
    }

    /// Builds the renderer by the release profile, for measurements, and returns the program.
    pub(crate) fn build_release_renderer(&self) -> Result<PathBuf, TaskError> {
        self.build_program("release", "release")
    }

    /// Builds the renderer by the profile of this task and returns the program. It gives the images of any other
    /// profile, and shares compiled crates with the task.
    pub(crate) fn build_renderer(&self) -> Result<PathBuf, TaskError> {
        let (profile, folder) = if cfg!(debug_assertions) { ("dev", "debug") } else { ("release", "release") };
        self.build_program(profile, folder)
    }

    fn build_program(&self, profile: &str, folder: &str) -> Result<PathBuf, TaskError> {
        let mut command = cargo();
        // Together with this task, for equal features of shared crates: none is compiled again.
        command.args(["build", "--profile", profile, "--package", "rt-cli", "--package", "xtask"]);
        command.current_dir(&self.root);
        output_of(&mut command)?;
        Ok(self.target.join(folder).join(format!("rt-cli{}", std::env::consts::EXE_SUFFIX)))
    }

    /// Processor, number of its threads and commit, for pages of measured figures.
    pub(crate) fn provenance(&self) -> String {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        format!("one {} with {threads} threads, at commit {}", crate::processor::processor(), self.commit())
    }

    /// Short hash of the commit, marked if files differ from it; "unknown" without git.
    pub(crate) fn commit(&self) -> String {
        let output = Command::new("git")
            .args(["describe", "--always", "--dirty", "--exclude", "*"])
            .current_dir(&self.root)
            .stderr(Stdio::null())
            .output();
        let hash = output.ok().filter(|output| output.status.success()).map(|output| output.stdout);
        let hash = hash.and_then(|hash| String::from_utf8(hash).ok());
        hash.map_or_else(|| "unknown".to_owned(), |hash| hash.trim().to_owned())
    }

    /// `path` relative to the root; unchanged if it lies elsewhere.
    pub(crate) fn relative<'p>(&self, path: &'p Path) -> std::path::Display<'p> {
        path.strip_prefix(&self.root).unwrap_or(path).display()
    }

    /// All files below `folder`, a path from the root, whose names end with `extension`; sorted.
    ///
    /// Skips hidden files, but for the folders `.cargo` and `.ci`, and build products, which cargo marks with a tag
    /// (<https://bford.info/cachedir/>).
    pub(crate) fn files(&self, folder: &str, extension: &str) -> Result<Vec<PathBuf>, TaskError> {
        let mut found = Vec::new();
        let mut folders = vec![self.root.join(folder)];
        while let Some(folder) = folders.pop() {
            if !folder.exists() {
                continue;
            }
            for entry in fs::read_dir(&folder).map_err(TaskError::file(&folder))? {
                let path = entry.map_err(TaskError::file(&folder))?.path();
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                if path.join("CACHEDIR.TAG").exists() || (name.starts_with('.') && name != ".cargo" && name != ".ci") {
                    continue;
                }
                if path.is_dir() {
                    folders.push(path);
                } else if name.ends_with(extension) {
                    found.push(path);
                }
            }
        }
        found.sort();
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    /// `cfg!(debug_assertions)` stands for the dev profile. Without assertions there, benchmarks measured it.
    #[test]
    fn the_dev_profile_has_the_assertions_that_tell_it_from_release() {
        let manifest: toml::Table = include_str!("../../Cargo.toml").parse().expect("the root manifest");
        let dev = &manifest["profile"]["dev"]["package"]["xtask"];
        assert_eq!(dev["debug-assertions"].as_bool(), Some(true));
    }
}
