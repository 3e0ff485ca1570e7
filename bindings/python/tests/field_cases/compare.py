"""Asks other programs for the answers of the field cases, and writes docs/FIELD-CASES.md.

    python bindings/python/tests/field_cases/compare.py [--write]

Columns of programs that are not installed say so: trimesh (with rtree), embreex, open3d, and tinybvh-rs, which cargo and a C++
compiler build.
"""

import argparse
import importlib.metadata
import json
import math
import platform
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
REPOSITORY = FOLDER.parents[3]
PAGE = REPOSITORY / "docs" / "FIELD-CASES.md"

#: Relative error of t that counts as right for programs in single precision.
SINGLE_PRECISION = 1e-5

#: Cells of a program that is not installed.
MISSING = "not installed"

#: Seconds after which a program that runs by itself is stopped.
TIME_LIMIT = 60


class Program:
    """One program: a name, the closest hit of each ray, as t and the number of the triangle, -1 for none, and the number of hits of
    each ray. Programs without a query of all hits have `all_hits` of None, and programs that are not installed `closest` of None.
    """

    def __init__(self, name, closest=None, all_hits=None):
        self.name, self.closest, self.all_hits = name, closest, all_hits


def version(package):
    return importlib.metadata.version(package)


def ours():
    import rt

    def closest(vertices, faces, origins, directions, t_max):
        hits = rt.TriangleMesh(vertices, faces).closest(origins, directions, t_max=t_max)
        return hits.t, hits.primitive

    def count(vertices, faces, origins, directions, t_max):
        return rt.TriangleMesh(vertices, faces).count_hits(origins, directions, t_max=t_max)

    return Program(f"rt {version('rt-rays')}", closest, count)


def of_trimesh(name, module):
    import trimesh

    def answers(vertices, faces, origins, directions, t_max, multiple):
        mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False)
        tri, ray, where = module.RayMeshIntersector(mesh).intersects_id(
            origins, directions, multiple_hits=multiple, return_locations=True
        )
        where = np.asarray(where).reshape(-1, 3)
        lengths = (directions[ray] ** 2).sum(axis=1)
        t = ((where - origins[ray]) * directions[ray]).sum(axis=1) / lengths
        keep = t <= t_max * (1 + SINGLE_PRECISION)
        return t[keep], np.asarray(tri)[keep], np.asarray(ray)[keep]

    def closest(vertices, faces, origins, directions, t_max):
        t, tri, ray = answers(vertices, faces, origins, directions, t_max, False)
        all_t, all_tri = np.full(len(origins), np.inf), np.full(len(origins), -1)
        all_t[ray], all_tri[ray] = t, tri
        return all_t, all_tri

    def count(vertices, faces, origins, directions, t_max):
        mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False)
        tri, ray = module.RayMeshIntersector(mesh).intersects_id(origins, directions, multiple_hits=True)
        return np.bincount(np.asarray(ray, dtype=int), minlength=len(origins)) if t_max == np.inf else None

    return Program(name, closest, count)


def of_open3d():
    import open3d

    def scene(vertices, faces):
        scene = open3d.t.geometry.RaycastingScene()
        scene.add_triangles(np.asarray(vertices, dtype=np.float32), np.asarray(faces, dtype=np.uint32))
        return scene

    def closest(vertices, faces, origins, directions, t_max):
        rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
        answer = scene(vertices, faces).cast_rays(rays)
        t = answer["t_hit"].numpy().astype(np.float64)
        tri = answer["primitive_ids"].numpy().astype(np.int64)
        missed = ~np.isfinite(t) | (t > t_max * (1 + SINGLE_PRECISION))
        return np.where(missed, np.inf, t), np.where(missed, -1, tri)

    def count(vertices, faces, origins, directions, t_max):
        rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
        return scene(vertices, faces).count_intersections(rays).numpy() if t_max == np.inf else None

    return Program(f"Open3D {version('open3d')}", closest, count)


def of_tinybvh():
    folder = FOLDER / "tinybvh"
    package = re.search(r'^tinybvh-rs = "=(.*)"$', (folder / "Cargo.toml").read_text(), re.MULTILINE)
    if shutil.which("cargo") is None:
        raise ImportError("cargo is not installed")
    target = REPOSITORY / "target" / "tinybvh"
    build = ["cargo", "build", "--quiet", "--release", "--locked", "--manifest-path", str(folder / "Cargo.toml")]
    if subprocess.run([*build, "--target-dir", str(target)], check=False).returncode != 0:
        raise ImportError("its build fails")
    program = target / "release" / ("field-cases-tinybvh.exe" if platform.system() == "Windows" else "field-cases-tinybvh")

    def line(*vectors):
        return " ".join(repr(number) for number in np.concatenate(vectors).astype(np.float32).tolist())

    def closest(vertices, faces, origins, directions, t_max):
        triangles = [line(*vertices[face]) for face in faces]
        rays = [f"{line(*ray)} {t_max!r}" for ray in zip(origins, directions)]
        text = "\n".join([str(len(triangles)), *triangles, str(len(rays)), *rays])
        answer = subprocess.run([program], input=text, capture_output=True, text=True, check=True, timeout=TIME_LIMIT).stdout
        hits = [(math.inf, -1) if hit == "miss" else hit.split() for hit in answer.splitlines()]
        return np.array([float(t) for t, _ in hits]), np.array([int(triangle) for _, triangle in hits])

    return Program(f"tinybvh-rs {package[1]}", closest)


def programs():
    found = [ours()]
    try:
        import rtree  # noqa: F401
        from trimesh.ray import ray_triangle

        found.append(of_trimesh(f"trimesh {version('trimesh')}", ray_triangle))
    except ImportError as error:
        print(f"trimesh is left out: {error}")
        found.append(Program("trimesh"))
    try:
        import embreex  # noqa: F401
        from trimesh.ray import ray_pyembree

        found.append(of_trimesh(f"trimesh with embreex {version('embreex')}", ray_pyembree))
    except ImportError as error:
        print(f"embreex is left out: {error}")
        found.append(Program("trimesh with embreex"))
    try:
        found.append(of_open3d())
    except (ImportError, OSError) as error:
        print(f"Open3D is left out: {error}")
        found.append(Program("Open3D"))
    try:
        found.append(of_tinybvh())
    except ImportError as error:
        print(f"tinybvh-rs is left out: {error}")
        found.append(Program("tinybvh-rs"))
    return found


def judge(case, program):
    """What is wrong: numbers of rays whose closest hit or whose number of hits is not right, as text."""
    if program.closest is None:
        return MISSING
    vertices, faces = np.array(case["vertices"]), np.array(case["faces"])
    origins, directions = np.moveaxis(np.array(case["rays"]), 1, 0)
    t_max = math.inf if case["t_max"] is None else case["t_max"]
    with np.errstate(all="ignore"):
        try:
            t, tri = program.closest(vertices, faces, origins, directions, t_max)
            counts = program.all_hits and program.all_hits(vertices, faces, origins, directions, t_max)
        except subprocess.CalledProcessError as error:
            return f"ends with code {error.returncode}"
        except Exception as error:  # noqa: BLE001: a program may fail in any way, which is what the page says.
            return f"fails: {type(error).__name__}"
    lost = ghosts = wrong = miscounted = 0
    for i, expected in enumerate(case["hits"]):
        certain, border = expected["t"], expected["border_t"]
        possible = sorted(certain + border)
        if math.isinf(t[i]):
            lost += bool(possible)
            continue
        near = [exact for exact in possible if abs(t[i] - exact) <= SINGLE_PRECISION * max(abs(exact), 1e-300)]
        starts = [exact for exact in possible if exact == 0]
        first = min(certain) if certain else possible[0] if possible else None
        if first is None:
            ghosts += 1
        elif not near and not (starts and abs(t[i]) <= SINGLE_PRECISION):
            wrong += 1
        elif min(near or starts) > first * (1 + SINGLE_PRECISION):
            wrong += 1
        elif t_max != math.inf and not possible:
            ghosts += 1
    if counts is not None:
        for i, expected in enumerate(case["hits"]):
            least = len(expected["t"]) + bool(expected["border"])
            most = len(expected["t"]) + len(expected["border"])
            # Some programs count hits at one location once.
            locations = len(set(expected["t"] + expected["border_t"]))
            miscounted += not (least <= counts[i] <= most or counts[i] == locations)
    n = len(case["hits"])
    parts = [(lost, "lost"), (ghosts, "invented"), (wrong, "wrong t"), (miscounted, "miscounted")]
    text = ", ".join(f"{count} {what}" for count, what in parts if count)
    return f"{text} of {n}" if text else "right"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="also write docs/FIELD-CASES.md")
    options = parser.parse_args()
    cases = json.loads((FOLDER / "cases.json").read_text())
    found = programs()
    rows = [[case["name"], case["source"] or "–"] + [judge(case, program) for program in found] for case in cases]
    columns = list(zip(*rows))[2:]
    totals = ["–" if MISSING in column else f"**{column.count('right')} of {len(cases)}**" for column in columns]
    right = ["**right**", "", *totals]
    header = ["case", "after"] + [program.name for program in found]
    lines = ["| " + " | ".join(row) + " |" for row in [header, ["---"] * len(header), *rows, right]]
    table = "\n".join(lines)
    print(table)
    if options.write:
        PAGE.write_text(f"""# Field cases: rays that programs have traced wrongly

After reading this page you know which rays give wrong hits in which programs.

Each case is built after a reported problem; *after* names the project and the number of the report. The right results are computed
by rational arithmetic from the stored numbers (`bindings/python/tests/field_cases/exact.py`). Tests in Rust and Python compare this
project with them, with every accelerator.

A cell counts the rays whose closest hit is lost, invented, or at a wrong distance (*wrong t*). It also counts the rays whose number of
hits is wrong (*miscounted*).

A distance is right here to {SINGLE_PRECISION:g} of its value, as other programs compute in single precision. The tests of this project require
2⁻⁴⁴ of the distance of the farthest vertex. Edges and vertices belong to all of their triangles. A program may count all of these
hits, as this one does, or count hits at one location once.

Most programs round the differences between vertices and the origin of a ray. A ray along an edge may then pass on either side
of it. Both results count as right here, but a ray that passes between the triangles is wrong. The tests of this project
require the exact side.

tinybvh has no query of all hits, so its column tests closest hits only. It is called through its Rust bindings, tinybvh-rs. The
tree is `bvh::BVH` with default settings, rays are from `Ray::new`, and `hit.t` is the end of the ray. Its build is for this processor.

Written by `python bindings/python/tests/field_cases/compare.py --write`, Python {platform.python_version()}, on {platform.machine()}:

{table}
""")


if __name__ == "__main__":
    main()
