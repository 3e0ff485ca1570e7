//! Files to measure.

use std::path::{Path, PathBuf};

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

/// A set of rays.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct RayFile {
    pub kind: String,
    pub rays: PathBuf,
    pub query: Query,
    pub reference: Option<PathBuf>,
    /// Output file of the hits.
    pub hits: Option<PathBuf>,
}

/// Jobs that the command line names, or those of the folder.
pub(super) fn jobs(options: &RayOptions) -> Result<Vec<Job>, TaskError> {
    let jobs = match &options.folder {
        Some(folder) => in_folder(folder, options)?,
        None => named(options)?,
    };
    if jobs.iter().all(|job| job.sets.is_empty()) {
        return Err(TaskError::Other("no files to measure: name MESH and RAYS, or --folder".into()));
    }
    Ok(jobs)
}

fn named(options: &RayOptions) -> Result<Vec<Job>, TaskError> {
    let mut jobs: Vec<Job> = Vec::new();
    let pairs = options.files.chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return Err(TaskError::Other("every MESH needs RAYS after it".into()));
    }
    if (options.out.is_some() && pairs.len() > 1) || options.reference.len() > pairs.len() {
        return Err(TaskError::Other("--out allows one pair of files, and --reference one file for each pair".into()));
    }
    for (index, pair) in pairs.enumerate() {
        let (mesh, rays) = (&pair[0], &pair[1]);
        let set = RayFile {
            kind: kind(rays),
            rays: rays.clone(),
            query: query(&kind(rays), options),
            reference: options.reference.get(index).cloned(),
            hits: options.out.clone(),
        };
        match jobs.last_mut().filter(|job| job.mesh == *mesh) {
            Some(job) => job.sets.push(set),
            None => jobs.push(Job { sets: vec![set], ..job(mesh, options)? }),
        }
    }
    Ok(jobs)
}

/// Every `scene.mesh` with every `scene.kind.rays`, and its `scene.kind.ref`.
fn in_folder(folder: &Path, options: &RayOptions) -> Result<Vec<Job>, TaskError> {
    let files = sorted_entries(folder)?;
    let mut jobs = Vec::new();
    for mesh in files.iter().filter(|path| path.extension().is_some_and(|extension| extension == "mesh")) {
        let mut job = job(mesh, options)?;
        if !options.scene.is_empty() && !options.scene.contains(&job.scene) {
            continue;
        }
        for rays in &files {
            let kind = kind(rays);
            let named = rays.file_name() == Some(format!("{}.{kind}.rays", job.scene).as_ref());
            if !named || (!options.kind.is_empty() && !options.kind.contains(&kind)) {
                continue;
            }
            let reference = rays.with_extension("ref");
            job.sets.push(RayFile {
                rays: rays.clone(),
                query: query(&kind, options),
                reference: reference.exists().then_some(reference),
                hits: options.out.as_ref().map(|folder| folder.join(format!("{}.{kind}.hit", job.scene))),
                kind,
            });
        }
        jobs.push(job);
    }
    Ok(jobs)
}

/// A mesh without rays as yet.
fn job(mesh: &Path, options: &RayOptions) -> Result<Job, TaskError> {
    let tolerance_file = mesh.with_extension("eps");
    let tolerance = match &options.eps {
        Some(text) => match text.parse() {
            Ok(number) => number,
            Err(_) => files::read_tolerance(Path::new(text))?,
        },
        None if tolerance_file.exists() => files::read_tolerance(&tolerance_file)?,
        None => TOLERANCE,
    };
    let scene = mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Job { scene, mesh: mesh.to_owned(), tolerance, sets: Vec::new() })
}

/// Kind of rays: the last part of the file name before `.rays`.
fn kind(rays: &Path) -> String {
    let stem = rays.file_stem().unwrap_or_default().to_string_lossy();
    stem.rsplit_once('.').map_or(&*stem, |(_, kind)| kind).to_owned()
}

/// Query of the command line; by default any hit for shadow rays and the closest hit for others.
fn query(kind: &str, options: &RayOptions) -> Query {
    options.query.unwrap_or(if kind == "shadow" { Query::Occluded } else { Query::Closest })
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
        let here = folder.path().to_str().unwrap();
        let options = |args: &[&str]| super::super::options::parsed(&[&["--folder", here], args].concat());
        let jobs = jobs(&options(&[])).unwrap();
        let names: Vec<(&str, f32, usize)> =
            jobs.iter().map(|job| (job.scene.as_str(), job.tolerance, job.sets.len())).collect();
        assert_eq!(names, [("a", 0.25, 2), ("ab", TOLERANCE, 1)]);
        let shadow = &jobs[0].sets[1];
        assert_eq!((shadow.query, shadow.reference.is_some()), (Query::Occluded, true));
        let only = super::jobs(&options(&["--scene", "a", "--kind", "primary"])).unwrap();
        assert_eq!((only.len(), only[0].sets.len(), &*only[0].sets[0].kind), (1, 1, "primary"));
        assert!(super::jobs(&options(&["--scene", "c"])).is_err(), "nothing is no success");
    }

    #[test]
    fn pairs_with_one_mesh_build_it_once() {
        let named = |args: &[&str]| jobs(&super::super::options::parsed(args));
        let jobs = named(&["x.mesh", "x.shadow.rays", "x.mesh", "mine.rays", "--eps", "0.5"]).unwrap();
        assert_eq!((jobs.len(), jobs[0].tolerance), (1, 0.5));
        let kinds: Vec<(&str, Query)> = jobs[0].sets.iter().map(|set| (set.kind.as_str(), set.query)).collect();
        assert_eq!(kinds, [("shadow", Query::Occluded), ("mine", Query::Closest)]);
        assert!(named(&["x.mesh"]).is_err());
    }
}
