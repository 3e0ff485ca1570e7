"""Rays per second on one thread, and memory, beside trimesh with embreex on the same arrays: a table in Markdown.

    python speed.py [--rays 1e7] [--mesh dragon_vrip.ply]

Primary rays from a grid; diffuse rays, distributed by the cosine, from the points that primary rays hit, in their order; random rays
across the mesh. The mesh is a bumpy sphere of 871,200 triangles, or read by trimesh and brought to the size of the sphere. Each program
runs in a process of its own, the programs by turns. Times are those of the processor. Memory is that beyond inputs and outputs, at its
peak during a call.
"""

import argparse
import importlib.metadata
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

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


OURS, THEIRS = "rt.compat.trimesh", "trimesh.ray.ray_pyembree"

#: Calls in each process, of which the fastest counts: the first one may pay for memory that the system has to find.
CALLS = 2

#: By name: functions of a mesh that return a function of origins and directions.
PROGRAMS = {
    "rt closest": of_rt("closest"),
    "rt any_hit": of_rt("any_hit"),
    "rt intersects_first": of_trimesh(OURS, "intersects_first"),
    "rt intersects_location": of_trimesh(OURS, "intersects_location", multiple_hits=False),
    "embreex intersects_first": of_trimesh(THEIRS, "intersects_first"),
    "embreex intersects_location": of_trimesh(THEIRS, "intersects_location", multiple_hits=False),
}

#: Programs with comparable results, whose ratio is stated.
RATIOS = [
    ("rt intersects_first", "embreex intersects_first"),
    ("rt intersects_location", "embreex intersects_location"),
    ("rt closest", "embreex intersects_location"),
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


def measure(program, folder, kinds):
    """Seconds, bytes beyond inputs and outputs, and hits of one program for each kind of rays."""
    trace = PROGRAMS[program](np.load(folder / "vertices.npy"), np.load(folder / "faces.npy"))
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


def run_alone(program, folder, kinds):
    command = [sys.executable, __file__, "--measure", program, "--folder", str(folder), "--kinds", *kinds]
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    return json.loads(subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rays", type=float, default=1e6, help="rays of each kind")
    parser.add_argument("--detail", type=int, default=660, help="squares along each side of the bumpy sphere")
    parser.add_argument("--mesh", type=Path, help="file of a mesh instead of the bumpy sphere; needs trimesh")
    parser.add_argument("--runs", type=int, default=3, help="runs of each program, by turns")
    parser.add_argument("--measure", choices=PROGRAMS, help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--kinds", nargs="*", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        print(json.dumps(measure(options.measure, options.folder, options.kinds)))
        return
    programs, versions = [], [f"rt {importlib.metadata.version('rt-rays')}"]
    for start, packages in [("rt closest", []), ("rt any", []), ("rt inter", ["trimesh"]), ("embreex", ["trimesh", "embreex"])]:
        if all(importlib.util.find_spec(package) for package in packages):
            programs += [name for name in PROGRAMS if name.startswith(start)]
            versions += [f"{package} {importlib.metadata.version(package)}" for package in packages[-1:]]
        else:
            print(f"left out, as {packages[-1]} is not installed: {start}*")
    with tempfile.TemporaryDirectory() as name:
        folder, kinds = Path(name), []
        vertices, faces = load_mesh(options)
        np.save(folder / "vertices.npy", vertices)
        np.save(folder / "faces.npy", faces)
        for kind, origins, directions in rays(vertices, faces, int(options.rays**0.5)):
            kinds.append(kind)
            np.save(folder / f"{kind}.origins.npy", origins)
            np.save(folder / f"{kind}.directions.npy", directions)
            n_rays = len(origins)
        del origins, directions
        runs = [{program: run_alone(program, folder, kinds) for program in programs} for _ in range(options.runs)]
    report(runs, programs, kinds, n_rays, f"{len(faces):,} triangles, {n_rays:,} rays of each kind, {', '.join(versions)}")


def report(runs, programs, kinds, n_rays, title):
    rates = {
        program: [sorted(n_rays / run[program][kind]["seconds"] / 1e6 for run in runs) for kind in kinds] for program in programs
    }
    print(f"Millions of rays per second on one thread, best (least) of {len(runs)} runs, and MB beyond inputs and outputs: {title}\n")
    print("| | " + " | ".join(kinds) + " | memory |\n|---|" + "--:|" * (len(kinds) + 1))
    for program in programs:
        cells = [f"{of_kind[-1]:.2f} ({of_kind[0]:.2f})" for of_kind in rates[program]]
        peaks = [run[program][kind]["beyond"] for run in runs for kind in kinds]
        cells.append("–" if None in peaks else f"{max(peaks) / 1e6:.0f}")
        print(f"| {program} | " + " | ".join(cells) + " |")
    for ours, theirs in RATIOS:
        if theirs in rates:
            ratios = [f"{a[-1] / b[-1]:.2f}" for a, b in zip(rates[ours], rates[theirs])]
            print(f"| {ours} / {theirs} | " + " | ".join(ratios) + " | |")


if __name__ == "__main__":
    main()
