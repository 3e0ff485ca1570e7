//! Load time and memory of a mesh: the same rock in each format, read by the release binary.

use std::{
    fmt::{self, Display, Formatter},
    fs::{self, File},
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    time::Duration,
};

use rt_geometry::MeshData;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::common::print;
use crate::{
    error::TaskError, files, number::three_digits, renderer::Renderer, scenes::rock_data, table::Table,
    timings::Spread, workspace::Workspace,
};

#[derive(Debug, clap::Args)]
pub(super) struct LoadOptions {
    /// Set the approximate number of triangles.
    #[arg(long, default_value_t = 1_310_720)]
    triangles: usize,
    /// Load each file this often.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
    /// Keep the files in this directory, to measure other programs.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
}

#[derive(Debug, Serialize)]
struct LoadResult {
    file: String,
    bytes: u64,
    /// From the first byte to the arrays of the mesh.
    load_seconds: Spread,
    /// The accelerator over it.
    build_seconds: Spread,
    /// Maximum resident memory of the process, accelerator included.
    peak_bytes: u64,
}

#[derive(Debug, Serialize)]
struct LoadResults {
    triangles: usize,
    files: Vec<LoadResult>,
}

/// Times in the renderer's statistics.
#[derive(Debug, Deserialize)]
struct Timed {
    seconds: LoadSeconds,
}

#[derive(Debug, Deserialize)]
struct LoadSeconds {
    load: f64,
    build: f64,
}

/// Measures and prints.
pub(super) fn run(workspace: &Workspace, options: &LoadOptions) -> Result<(), TaskError> {
    let program = workspace.build_release_renderer()?;
    let folder = workspace.fresh_folder("bench-load")?;
    let keep = options.keep.clone().unwrap_or_else(|| folder.clone());
    fs::create_dir_all(&keep).map_err(TaskError::file(&keep))?;
    let (triangles, files) = write_files(&keep, options.triangles)?;
    let renderer = Renderer::new(program, Duration::MAX);
    let files =
        files.iter().map(|path| measure(&renderer, &folder, path, options.reps)).collect::<Result<Vec<_>, _>>()?;
    let results = LoadResults { triangles, files };
    print(&results, &results)
}

/// The rock as OBJ and as GLB, and how many triangles it has.
fn write_files(folder: &Path, wanted: usize) -> Result<(usize, [PathBuf; 2]), TaskError> {
    let mesh = rock_data(wanted);
    let files = ["rock.obj", "rock.glb"].map(|name| folder.join(name));
    let file = |path: &Path| File::create(path).map(BufWriter::new).map_err(TaskError::file(path));
    write_obj(&mesh, file(&files[0])?).map_err(TaskError::file(&files[0]))?;
    write_glb(&mesh, file(&files[1])?).map_err(TaskError::file(&files[1]))?;
    Ok((mesh.triangles.len(), files))
}

fn write_obj(mesh: &MeshData, mut file: impl Write) -> std::io::Result<()> {
    for p in &mesh.positions {
        writeln!(file, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(file, "f {} {} {}", a + 1, b + 1, c + 1)?;
    }
    file.flush()
}

fn write_glb(mesh: &MeshData, mut file: impl Write) -> std::io::Result<()> {
    let (min, max) =
        mesh.positions.iter().fold((rt_math::Vec3::INFINITY, rt_math::Vec3::NEG_INFINITY), |(min, max), position| {
            (min.min(*position), max.max(*position))
        });
    let (positions, indices) = (12 * mesh.positions.len(), 12 * mesh.triangles.len());
    let document = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": positions + indices}],
        "bufferViews": [
            {"buffer": 0, "byteLength": positions},
            {"buffer": 0, "byteOffset": positions, "byteLength": indices},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3",
             "min": min.to_array(), "max": max.to_array()},
            {"bufferView": 1, "componentType": 5125, "count": 3 * mesh.triangles.len(), "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    });
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let whole = 12 + 8 + json.len() + 8 + positions + indices;
    // A GLB holds at most 4 GiB: the rock stays far below.
    file.write_all(b"glTF\x02\0\0\0")?;
    file.write_all(&(whole as u32).to_le_bytes())?;
    file.write_all(&(json.len() as u32).to_le_bytes())?;
    file.write_all(b"JSON")?;
    file.write_all(&json)?;
    file.write_all(&((positions + indices) as u32).to_le_bytes())?;
    file.write_all(b"BIN\0")?;
    for position in &mesh.positions {
        position.to_array().into_iter().try_for_each(|x| file.write_all(&x.to_le_bytes()))?;
    }
    for triangle in &mesh.triangles {
        triangle.iter().try_for_each(|index| file.write_all(&index.to_le_bytes()))?;
    }
    file.flush()
}

fn measure(renderer: &Renderer, folder: &Path, path: &Path, reps: u32) -> Result<LoadResult, TaskError> {
    let scene = path.to_string_lossy();
    let stats = folder.join("stats.json");
    let args = ["render", &scene, "-o", "rock.png", "--size", "8x8", "--spp", "1", "--threads", "1", "--quiet"];
    let args = [&args[..], &["--stats", "stats.json"]].concat();
    let (mut load, mut build, mut peak_bytes) = (Vec::new(), Vec::new(), 0);
    for _ in 0..reps {
        peak_bytes = renderer.measure(folder, &args)?.bytes.max(peak_bytes);
        let Timed { seconds } = files::read_json(&stats)?;
        load.push(seconds.load);
        build.push(seconds.build);
    }
    Ok(LoadResult {
        file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        bytes: fs::metadata(path).map_err(TaskError::file(path))?.len(),
        load_seconds: Spread::of(load),
        build_seconds: Spread::of(build),
        peak_bytes,
    })
}

impl Display for LoadResults {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let per_million = |number: f64| three_digits(number * 1e6 / self.triangles as f64);
        let mebibytes = |bytes: u64| per_million(bytes as f64 / f64::from(1 << 20));
        let header = ["file", "MiB in the file", "load s (min..max)", "build s", "peak MiB of the process"];
        let mut table = Table::new(1, header);
        for file in &self.files {
            table.push([
                file.file.clone(),
                mebibytes(file.bytes),
                file.load_seconds.shown(per_million),
                per_million(file.build_seconds.median),
                mebibytes(file.peak_bytes),
            ]);
        }
        write!(f, "A mesh of {} triangles, on one thread. Per million triangles:\n\n{table}", self.triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_scene_io::{LoadOptions, load_model};

    #[test]
    fn both_files_hold_the_same_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let (triangles, files) = write_files(folder.path(), 320).unwrap();
        assert_eq!(triangles, 320);
        let [obj, glb] = files.map(|path| load_model(&path, &LoadOptions::default()).unwrap());
        let corners = |model: &rt_scene_io::Model| -> Vec<_> {
            let mesh = &model.meshes[0].mesh;
            (0..320).map(|triangle| mesh.vertices(triangle).unwrap()).collect()
        };
        assert_eq!(corners(&obj), corners(&glb));
    }
}
