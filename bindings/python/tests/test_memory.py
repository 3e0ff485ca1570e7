"""More results than there is memory."""

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


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits the addresses of a process")
def test_lists_of_hits_without_memory_raise_a_memory_error():
    script = """if True:
        import resource
        import numpy as np
        import rt

        triangles = np.array([[[0, 0, -i], [1, 0, -i], [0, 1, -i]] for i in range(20)], dtype=float)
        mesh = rt.TriangleMesh(triangles.reshape(-1, 3), np.arange(60).reshape(-1, 3))
        directions = np.broadcast_to([0.0, 0.0, -1.0], (2_000_000, 3))
        with open("/proc/self/statm") as file:
            limit = int(file.read().split()[0]) * resource.getpagesize() + 500_000_000
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        try:
            mesh.all_hits([0.1, 0.1, 1.0], directions, threads=1)
        except MemoryError:
            print("MemoryError")
    """
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False).stdout
    assert output == "MemoryError\n"
