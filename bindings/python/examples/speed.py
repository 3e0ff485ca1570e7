"""Rays per second on one thread, and memory, beside trimesh with embreex on the same arrays: a table in Markdown.

    python speed.py [--rays 1e7] [--mesh dragon_vrip.ply] [--rust target/release/examples/batches]

Primary rays from a grid; diffuse rays, distributed by the cosine, from the points that primary rays hit, in their order; random rays
across the mesh. The mesh is a bumpy sphere of 871,200 triangles, or read by trimesh and brought to the size of the sphere. Each program
runs in a process of its own, the programs by turns. Times are those of the processor. Memory is that beyond inputs and outputs, at its
peak during a call.
"""

import argparse
import datetime
import importlib.metadata
import importlib.util
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np

import rt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from shapes import bumpy_sphere  # noqa: E402

#: Largest coordinate of the bumpy sphere.
SIZE = 1.1

#: Start of diffuse rays above the surface, so that programs in single precision do not hit it again.
OFFSET = 1e-4


def load_mesh(options):
    if options.mesh is None:
        vertices, faces = bumpy_sphere(options.detail)
    else:
        import trimesh

        mesh = trimesh.load(options.mesh, process=False, force="mesh")
        low, high = mesh.bounds
        vertices, faces = (mesh.vertices - (low + high) / 2) * (2 * SIZE / (high - low).max()), np.asarray(mesh.faces)
    return np.asarray(vertices, dtype=np.float32), faces


def primary_rays(side):
    x, y = np.meshgrid(np.linspace(-0.45, 0.45, side), np.linspace(-0.45, 0.45, side))
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    return np.tile([0, 0, 3.0], (side * side, 1)), directions


def diffuse_rays(mesh, origins, directions, generator):
    hits = mesh.closest(origins, directions)
    n, found = len(origins), np.flatnonzero(hits.hit)
    chosen = found[np.arange(n) * len(found) // n]
    corners = mesh.vertices[mesh.faces[hits.primitive[chosen]]].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals *= -np.sign((normals * directions[chosen]).sum(axis=1, keepdims=True))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    # Cosine distribution: the normal and a point of the unit sphere, added.
    sphere = generator.normal(size=(n, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    return origins[chosen] + hits.t[chosen, None] * directions[chosen] + OFFSET * normals, normals + sphere


def random_rays(n, generator):
    origins = generator.normal(size=(n, 3))
    origins *= 3 / np.linalg.norm(origins, axis=1, keepdims=True)
    return origins, 0.5 * generator.normal(size=(n, 3)) - origins


def rays(vertices, faces, side):
    """Yields the name, origins and directions of each kind of rays."""
    generator = np.random.default_rng(1)
    primary = primary_rays(side)
    yield "primary", *primary
    yield "diffuse", *diffuse_rays(rt.TriangleMesh(vertices, faces), *primary, generator)
    yield "random", *random_rays(side * side, generator)


def of_rt(query):
    def prepare(vertices, faces):
        scene = rt.Scene(rt.TriangleMesh(vertices, faces))
        return lambda origins, directions: getattr(scene, query)(origins, directions, threads=1)

    return prepare


def of_trimesh(module, query, **options):
    def prepare(vertices, faces):
        import trimesh

        mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False)
        intersector = importlib.import_module(module).RayMeshIntersector(mesh)
        return lambda origins, directions: getattr(intersector, query)(origins, directions, **options)

    return prepare


class Program(NamedTuple):
    """A program and the packages that it needs. `prepare` takes a mesh and returns a function of origins and directions."""

    name: str
    packages: tuple
    prepare: Callable


OURS, THEIRS = ("trimesh",), ("trimesh", "embreex")
OUR_RAYS, THEIR_RAYS = "rt.compat.trimesh", "trimesh.ray.ray_pyembree"
FIRST_HIT = {"multiple_hits": False}

PROGRAMS = [
    Program("rt closest", (), of_rt("closest")),
    Program("rt any_hit", (), of_rt("any_hit")),
    Program("rt intersects_first", OURS, of_trimesh(OUR_RAYS, "intersects_first")),
    Program("rt intersects_location, first hits", OURS, of_trimesh(OUR_RAYS, "intersects_location", **FIRST_HIT)),
    Program("rt intersects_location, all hits", OURS, of_trimesh(OUR_RAYS, "intersects_location")),
    Program("embreex intersects_first", THEIRS, of_trimesh(THEIR_RAYS, "intersects_first")),
    Program("embreex intersects_location, first hits", THEIRS, of_trimesh(THEIR_RAYS, "intersects_location", **FIRST_HIT)),
    Program("embreex intersects_location, all hits", THEIRS, of_trimesh(THEIR_RAYS, "intersects_location")),
]

#: Queries of the example `batches` of rt-accel, by their names in the table.
RUST_QUERIES = {"Rust closest_batch": "closest", "Rust occluded_batch": "occluded"}

#: Around the table in the guide.
MARKS = "<!-- speed -->", "<!-- end of speed -->"

#: Calls in each process, of which the fastest counts: the first one may pay for memory that the system has to find.
CALLS = 2

#: Programs with comparable results, whose ratio is stated.
RATIOS = [
    ("rt closest", "Rust closest_batch"),
    ("rt any_hit", "Rust occluded_batch"),
    ("rt intersects_first", "embreex intersects_first"),
    ("rt intersects_location, first hits", "embreex intersects_location, first hits"),
    ("rt intersects_location, all hits", "embreex intersects_location, all hits"),
    ("rt closest", "embreex intersects_location, first hits"),
]


def memory(name):
    """A line of /proc/self/status in bytes: VmRSS, memory now, or VmHWM, its peak since `reset_peak`."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(name + ":"))
    return 1024 * int(line.split()[1])


def reset_peak():
    """Sets VmHWM to VmRSS. False on systems other than Linux."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return False
    return True


def measure(name, folder, kinds):
    """Seconds, and bytes beyond inputs and outputs, of one program for each kind of rays."""
    prepare = next(program.prepare for program in PROGRAMS if program.name == name)
    trace = prepare(np.load(folder / "vertices.npy"), np.load(folder / "faces.npy"))
    found = {}
    for kind in kinds:
        origins, directions = np.load(folder / f"{kind}.origins.npy"), np.load(folder / f"{kind}.directions.npy")
        # Builds the tree, and loads code.
        trace(origins[:10], directions[:10])
        calls = [measure_call(trace, origins, directions) for _ in range(CALLS)]
        seconds, beyond = zip(*calls)
        found[kind] = {"seconds": min(seconds), "beyond": None if None in beyond else max(beyond)}
    return found


def measure_call(trace, origins, directions):
    """Seconds of the processor, and bytes beyond inputs and outputs."""
    can_measure = reset_peak()
    before = memory("VmRSS") if can_measure else 0
    started = time.process_time()
    result = trace(origins, directions)
    seconds = time.process_time() - started
    outputs = sum(part.nbytes for part in (result if isinstance(result, tuple) else (result,)))
    return seconds, max(memory("VmHWM") - before - outputs, 0) if can_measure else None


def run_alone(name, rust, folder, kinds):
    """Results of one program by kind of rays, measured in a process of its own."""
    if name in RUST_QUERIES:
        command = [rust, RUST_QUERIES[name], str(folder), *kinds]
    else:
        command = [sys.executable, __file__, "--measure", name, "--folder", str(folder), "--kinds", *kinds]
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    return json.loads(subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rays", type=float, default=1e6, help="rays of each kind")
    parser.add_argument("--detail", type=int, default=660, help="squares along each side of the bumpy sphere")
    parser.add_argument("--mesh", type=Path, help="file of a mesh instead of the bumpy sphere; needs trimesh")
    parser.add_argument("--runs", type=int, default=3, help="runs of each program, by turns")
    parser.add_argument("--rust", metavar="PROGRAM", help="example `batches` of rt-accel, to measure as well")
    parser.add_argument("--write", action="store_true", help="write the table into docs/PYTHON.md of the repository")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the arrays in this folder")
    parser.add_argument("--measure", choices=[program.name for program in PROGRAMS], help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--kinds", nargs="*", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        print(json.dumps(measure(options.measure, options.folder, options.kinds)))
        return
    installed, names = {}, list(RUST_QUERIES) if options.rust else []
    for program in PROGRAMS:
        missing = [package for package in program.packages if importlib.util.find_spec(package) is None]
        if missing:
            print(f"left out, as {', '.join(missing)} is not installed: {program.name}")
            continue
        names.append(program.name)
        installed |= {package: importlib.metadata.version(package) for package in program.packages}
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        kinds, vertices, faces = [], *load_mesh(options)
        np.save(folder / "vertices.npy", vertices)
        np.save(folder / "faces.npy", faces.astype(np.uint32))
        for kind, origins, directions in rays(vertices, faces, int(options.rays**0.5)):
            kinds.append(kind)
            np.save(folder / f"{kind}.origins.npy", origins)
            np.save(folder / f"{kind}.directions.npy", directions)
            n_rays = len(origins)
        del origins, directions
        runs = [{name: run_alone(name, options.rust, folder, kinds) for name in names} for _ in range(options.runs)]
    versions = [f"{package} {version}" for package, version in {"rt": importlib.metadata.version("rt-rays"), **installed}.items()]
    title = f"{len(faces):,} triangles, {n_rays:,} rays of each kind, {', '.join(versions)}, Python {platform.python_version()}"
    table = report(runs, names, kinds, n_rays, title)
    print(table)
    if options.write:
        write(table, options)


def report(runs, names, kinds, n_rays, title):
    """The table in Markdown."""
    of_runs = f"best (least) of {len(runs)} runs" if len(runs) > 1 else "one run"
    rates = {name: [sorted(n_rays / run[name][kind]["seconds"] / 1e6 for run in runs) for kind in kinds] for name in names}
    lines = [
        f"{title}. Millions of rays per second on one thread, {of_runs}. Memory is in MB beyond inputs and",
        "outputs. Ratios are medians of those within a run.",
        "",
        f"| | {' | '.join(kinds)} | memory |",
        "|---|" + "--:|" * (len(kinds) + 1),
    ]
    for name in names:
        cells = [f"{of_kind[-1]:.2f}" + (f" ({of_kind[0]:.2f})" if len(runs) > 1 else "") for of_kind in rates[name]]
        peaks = [run[name][kind].get("beyond") for run in runs for kind in kinds]
        cells.append("–" if None in peaks else f"{max(peaks) / 1e6:.0f}")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    for ours, theirs in RATIOS:
        if ours in rates and theirs in rates:
            ratios = [median(run[theirs][kind]["seconds"] / run[ours][kind]["seconds"] for run in runs) for kind in kinds]
            lines.append(f"| {ours} / {theirs} | {' | '.join(f'{ratio:.2f}' for ratio in ratios)} | |")
    return "\n".join(lines) + "\n"


def processor():
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    flags = next((line.split() for line in lines if line.startswith("flags")), [])
    simd = next((name for flag, name in [("avx512f", "AVX-512"), ("avx2", "AVX2")] if flag in flags), "no AVX2")
    return f"{names[0]} with {simd}" if names else platform.processor() or platform.machine()


def write(table, options):
    """Replaces the part of the guide between the two marks."""
    repository = Path(__file__).resolve().parents[3]
    page = repository / "docs" / "PYTHON.md"
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=repository, stdout=subprocess.PIPE, text=True, check=True
    ).stdout.strip()
    command = f"python bindings/python/examples/speed.py --rays {options.rays:.0e}".replace("e+0", "e")
    command += f" --runs {options.runs}"
    command += f" --mesh {options.mesh.name}" if options.mesh else ""
    command += " --rust batches" if options.rust else ""
    text = f"Written by `{command} --write` on {processor()}, at commit `{commit}` ({datetime.date.today()}):\n\n{table}"
    before, _, rest = page.read_text().partition(MARKS[0])
    _, _, after = rest.partition(MARKS[1])
    if not after:
        sys.exit(f"{page} lacks the marks {MARKS[0]} and {MARKS[1]}")
    page.write_text(f"{before}{MARKS[0]}\n{text}\n{MARKS[1]}{after}")


if __name__ == "__main__":
    main()
