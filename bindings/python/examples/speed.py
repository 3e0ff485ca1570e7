"""Closest hits on one thread, beside trimesh with embreex on the same arrays: a table in Markdown.

    python speed.py [--rays 1e6]

A bumpy sphere of 871,200 triangles; primary rays from a grid, and random rays across the mesh. The least of three runs counts.
"""

import argparse
import importlib.metadata
import resource
import sys
import time
from pathlib import Path

import numpy as np

import rt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from shapes import bumpy_sphere  # noqa: E402


def rays(side):
    x, y = np.meshgrid(np.linspace(-0.45, 0.45, side), np.linspace(-0.45, 0.45, side))
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    generator = np.random.default_rng(1)
    origins = generator.normal(size=(side * side, 3))
    origins *= 3 / np.linalg.norm(origins, axis=1, keepdims=True)
    targets = 0.5 * generator.normal(size=(side * side, 3))
    return {"primary": (np.tile([0, 0, 3.0], (side * side, 1)), directions), "random": (origins, targets - origins)}


def seconds(work, runs=3):
    best = np.inf
    for _ in range(runs):
        started = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - started)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rays", type=float, default=1e6, help="rays of each kind")
    parser.add_argument("--detail", type=int, default=660, help="squares along each side of the mesh")
    options = parser.parse_args()
    vertices, faces = bumpy_sphere(options.detail)
    vertices = vertices.astype(np.float32)
    mesh = rt.TriangleMesh(vertices, faces)
    programs = {
        "rt closest": lambda o, d: mesh.closest(o, d, threads=1),
        "rt any_hit": lambda o, d: mesh.any_hit(o, d, threads=1),
    }
    versions = f"rt {importlib.metadata.version('rt-rays')}"
    try:
        import trimesh
        from trimesh.ray.ray_pyembree import RayMeshIntersector

        theirs = RayMeshIntersector(trimesh.Trimesh(vertices, faces, process=False, validate=False))
        programs["embreex intersects_first"] = theirs.intersects_first
        programs["embreex intersects_location"] = lambda o, d: theirs.intersects_location(o, d, multiple_hits=False)
        versions += f", trimesh {trimesh.__version__}, embreex {importlib.metadata.version('embreex')}"
    except ImportError:
        print("trimesh with embreex is not installed and left out")
    kinds = rays(int(options.rays**0.5))
    print(f"{len(faces):,} triangles, one thread, millions of rays per second ({versions})\n")
    print("| | " + " | ".join(kinds) + " |\n|---|" + "--:|" * len(kinds))
    for name, trace in programs.items():
        trace(*(part[:10] for part in kinds["primary"]))
        rates = [len(origins) / seconds(lambda o=origins, d=directions: trace(o, d)) / 1e6 for origins, directions in kinds.values()]
        print(f"| {name} | " + " | ".join(f"{rate:.2f}" for rate in rates) + " |")
    inputs = sum(part.nbytes for kind in kinds.values() for part in kind)
    print(f"\npeak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB, of which {inputs / 1e6:.0f} MB are the rays")


if __name__ == "__main__":
    main()
