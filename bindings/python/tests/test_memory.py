"""More results than there is memory."""

import os
import subprocess
import sys

import numpy as np
import pytest
from shapes import box

import rt

#: Rows. Their results need more bytes than a process has addresses.
N_ROWS = 10**15
MESH = rt.TriangleMesh(*box())
ROWS = np.broadcast_to([0.0, 0.0, 1.0], (N_ROWS, 3))


@pytest.mark.parametrize("query", ["closest", "any_hit", "all_hits", "count_hits"])
def test_rays_without_memory_for_results_raise_a_memory_error(query):
    with pytest.raises(MemoryError):
        getattr(MESH, query)([0.1, 0.1, -1.0], ROWS)


@pytest.mark.parametrize("query", ["nearest_point", "contains", "signed_distance"])
def test_points_without_memory_for_results_raise_a_memory_error(query):
    with pytest.raises(MemoryError):
        getattr(MESH, query)(ROWS)


def test_geometry_without_memory_raises_a_memory_error():
    with pytest.raises(MemoryError):
        rt.TriangleMesh(ROWS, [[0, 1, 2]])
    with pytest.raises(MemoryError):
        rt.TriangleMesh(np.eye(3), np.broadcast_to(np.uint32([0, 1, 2]), (N_ROWS, 3)))


@pytest.mark.parametrize("options", [{"multiple_hits": False}, {"multiple_hits": False, "return_locations": True}])
def test_crossings_without_memory_raise_a_memory_error(options):
    trimesh = pytest.importorskip("trimesh")
    from rt.compat.trimesh import RayMeshIntersector

    intersector = RayMeshIntersector(trimesh.creation.box())
    with pytest.raises(MemoryError):
        intersector.intersects_id(ROWS, ROWS, **options)
    with pytest.raises(MemoryError):
        intersector.intersects_first(ROWS, ROWS)


#: Sheets of triangles, rays down through all of them, and a limit on memory: 500 MB more than in use.
LIMITED = """if True:
    import resource
    import sys
    import numpy as np
    import rt

    n_sheets, n_rays = map(int, sys.argv[1:])
    sheets = np.array([[[0, 0, -i], [1, 0, -i], [0, 1, -i]] for i in range(n_sheets)], dtype=float).reshape(-1, 3)
    faces = np.arange(3 * n_sheets).reshape(-1, 3)
    mesh = rt.TriangleMesh(sheets, faces)
    directions = np.broadcast_to([0.0, 0.0, -1.0], (n_rays, 3))
    {prepare}
    with open("/proc/self/statm") as file:
        limit = int(file.read().split()[0]) * resource.getpagesize() + 500_000_000
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    try:
        {query}
    except MemoryError:
        print("MemoryError")
"""


def run_with_limit(query, n_sheets, n_rays, prepare="pass"):
    script = LIMITED.format(prepare=prepare, query=query)
    command = [sys.executable, "-c", script, str(n_sheets), str(n_rays)]
    # Threads have an arena of addresses each, which may take all of the limit.
    environment = {**os.environ, "MALLOC_ARENA_MAX": "1"}
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


linux_only = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits the addresses of a process")


# Few hits of many rays end in Python's own lists, hundreds of hits for each ray in those of the library.
@linux_only
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("n_sheets", "n_rays"), [(20, 2_000_000), (500, 60_000), (200_000, 60)])
def test_lists_of_hits_without_memory_raise_a_memory_error(n_sheets, n_rays, threads):
    query = f"mesh.all_hits([0.1, 0.1, 1.0], directions, threads={threads})"
    result = run_with_limit(query, n_sheets, n_rays)
    assert result.stdout == "MemoryError\n", result.stderr


@linux_only
@pytest.mark.parametrize(("n_sheets", "n_rays"), [(20, 2_000_000), (500, 60_000), (300, 60_000)])
def test_lists_of_crossings_without_memory_raise_a_memory_error(n_sheets, n_rays):
    pytest.importorskip("trimesh")
    prepare = (
        "import trimesh; from rt.compat.trimesh import RayMeshIntersector; "
        "intersector = RayMeshIntersector(trimesh.Trimesh(sheets, faces, process=False)); "
        "origins = np.broadcast_to([0.1, 0.1, 1.0], (n_rays, 3)); "
        "intersector.intersects_id(origins[:1], directions[:1])"
    )
    query = "intersector.intersects_id(origins, directions)"
    result = run_with_limit(query, n_sheets, n_rays, prepare)
    assert result.stdout == "MemoryError\n", result.stderr
