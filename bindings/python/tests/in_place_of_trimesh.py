"""Plugin of pytest that puts our intersector in place of both of trimesh's, for the tests of trimesh itself.

    PYTHONPATH=bindings/python/tests python -m pytest -p in_place_of_trimesh TRIMESH/tests/test_ray.py
"""

import trimesh

from rt.compat.trimesh import RayMeshIntersector

for module in [trimesh.ray.ray_triangle, *([trimesh.ray.ray_pyembree] if trimesh.ray.has_embree else [])]:
    module.RayMeshIntersector = RayMeshIntersector
