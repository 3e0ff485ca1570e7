//! Files to measure.

use std::path::PathBuf;

use super::{files, options::RayOptions, trace::Query};
use crate::{error::TaskError, workspace::sorted_entries};

/// The absolute tolerance of scenes that have no file of it.
const TOLERANCE: f32 = 1e-5;

/// A mesh and the sets of rays through it.
#[derive(Debug, PartialEq)]
pub(super) struct Job {
    pub scene: String,
    pub mesh: PathBuf,
    pub tolerance: f32,
    pub sets: Vec<RayFile>,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct RayFile {
    pub kind: String,
    pub rays: PathBuf,
    pub query: Query,
    pub reference: Option<PathBuf>,
}

/// Every `scene.mesh` of the folder with every `scene.kind.rays`, and its `scene.kind.ref`.
pub(super) fn jobs(options: &RayOptions) -> Result<Vec<Job>, TaskError> {
    let entries = sorted_entries(&options.folder)?;
    let mut jobs = Vec::new();
    for mesh in entries.iter().filter(|path| path.extension().is_some_and(|extension| extension == "mesh")) {
        let scene = mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !options.scene.is_empty() && !options.scene.contains(&scene) {
            continue;
        }
        let set = |rays: &PathBuf| {
            let name = rays.file_name()?.to_str()?;
            let kind =
                name.strip_prefix(&format!("{scene}."))?.strip_suffix(".rays").filter(|kind| !kind.contains('.'))?;
            let query = if kind == "shadow" { Query::Occluded } else { Query::Closest };
            let reference = Some(rays.with_extension("ref")).filter(|path| path.exists());
            Some(RayFile { kind: kind.to_owned(), rays: rays.clone(), query, reference })
        };
        let sets = entries.iter().filter_map(set).collect();
        let tolerance_file = mesh.with_extension("eps");
        let tolerance = if tolerance_file.exists() { files::read_tolerance(&tolerance_file)? } else { TOLERANCE };
        jobs.push(Job { scene, mesh: mesh.clone(), tolerance, sets });
    }
    if jobs.iter().all(|job| job.sets.is_empty()) {
        return Err(TaskError::Other(format!("{}: contains no files to measure", options.folder.display())));
    }
    Ok(jobs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_folder_gives_every_scene_with_its_rays() {
        let folder = tempfile::tempdir().unwrap();
        let touch = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        for name in ["a.mesh", "a.primary.rays", "a.shadow.rays", "a.shadow.ref", "ab.mesh", "ab.primary.rays"] {
            touch(name, "");
        }
        touch("a.eps", "0.25\n");
        let options = |args: &[&str]| super::super::options::parsed(folder.path(), args);
        let jobs = jobs(&options(&[])).unwrap();
        let names: Vec<(&str, f32, usize)> =
            jobs.iter().map(|job| (job.scene.as_str(), job.tolerance, job.sets.len())).collect();
        assert_eq!(names, [("a", 0.25, 2), ("ab", TOLERANCE, 1)]);
        let [primary, shadow] = &jobs[0].sets[..] else { panic!("two sets") };
        assert_eq!((primary.query, primary.reference.is_some()), (Query::Closest, false));
        assert_eq!((shadow.query, shadow.reference.is_some()), (Query::Occluded, true));
        assert_eq!(super::jobs(&options(&["--scene", "ab"])).unwrap(), jobs[1..]);
        assert!(super::jobs(&options(&["--scene", "c"])).is_err(), "nothing is no success");
    }
}
