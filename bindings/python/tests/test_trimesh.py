"""The interface of trimesh, where trimesh is installed."""

import copy
import pickle

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

import rt  # noqa: E402
import rt.compat.trimesh as compat  # noqa: E402
from rt.compat.trimesh import RayMeshIntersector  # noqa: E402


def box():
    mesh = trimesh.creation.box()
    mesh.ray = RayMeshIntersector(mesh)
    return mesh


def test_a_ray_through_a_vertex_has_one_location():
    mesh = box()
    origins = np.zeros_like(mesh.vertices)
    locations, index_ray, index_tri = mesh.ray.intersects_location(origins, mesh.vertices)
    assert (np.bincount(index_ray) == 1).all()
    np.testing.assert_array_equal(locations, mesh.vertices[index_ray])
    index_tri, index_ray = mesh.ray.intersects_id(origins, mesh.vertices)
    touching = [(mesh.faces == i).any(axis=1).sum() for i in range(8)]
    np.testing.assert_array_equal(np.bincount(index_ray), touching)


def test_rays_through_a_grid_hit_the_bottom_and_the_top():
    mesh = box()
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 33), np.linspace(-0.5, 0.5, 33))
    origins = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -100.0)])
    directions = np.tile([0, 0, 1.0], (len(origins), 1))
    locations, index_ray, _ = mesh.ray.intersects_location(origins, directions)
    np.testing.assert_array_equal(np.bincount(index_ray), 2)
    np.testing.assert_array_equal(index_ray, np.repeat(np.arange(len(origins)), 2))
    np.testing.assert_allclose(locations[::2], np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -0.5)]), atol=1e-15)
    np.testing.assert_allclose(locations[1::2, 2], 0.5)


def test_first_and_any():
    mesh = box()
    origins, directions = [[0.1, 0.2, 5], [3, 3, 5]], [[0, 0, -1], [0, 0, -1]]
    first = mesh.ray.intersects_first(origins, directions)
    assert first.dtype == np.int64 and first[1] == -1 and mesh.face_normals[first[0]].tolist() == [0, 0, 1]
    assert mesh.ray.intersects_any(origins, directions).tolist() == [True, False]
    index_tri, index_ray, locations = mesh.ray.intersects_id(
        origins, directions, multiple_hits=False, return_locations=True
    )
    assert index_tri.tolist() == [first[0]] and index_ray.tolist() == [0]
    np.testing.assert_allclose(locations, [[0.1, 0.2, 0.5]])


def test_the_number_of_hits_may_be_limited():
    mesh = box()
    index_tri, index_ray = mesh.ray.intersects_id([[0.1, 0.2, 5], [0.1, 0.2, 4]], [[0, 0, -1]] * 2, max_hits=1)
    assert index_ray.tolist() == [0, 1]
    np.testing.assert_array_equal(mesh.face_normals[index_tri], [[0, 0, 1]] * 2)


def test_results_without_hits_are_arrays():
    mesh = box()
    for result in [mesh.ray.intersects_id([[9, 9, 9]], [[0, 0, 1]]), mesh.ray.intersects_id([], [])]:
        assert [array.shape for array in result] == [(0,), (0,)]
    locations, index_ray, index_tri = mesh.ray.intersects_location([[9, 9, 9]], [[0, 0, 1]])
    assert locations.shape == (0, 3) and index_ray.shape == index_tri.shape == (0,)


def test_the_tree_follows_changes_of_the_mesh():
    mesh = box()
    down = [[0, 0, 5]], [[0, 0, -1]]
    assert mesh.ray.intersects_any(*down)
    mesh.apply_translation([10, 0, 0])
    assert not mesh.ray.intersects_any(*down)


def test_trimesh_itself_uses_it():
    mesh = box()
    assert mesh.contains([[0, 0, 0], [0.6, 0, 0]]).tolist() == [True, False]
    assert trimesh.ray.ray_util.contains_points(mesh.ray, [[0, 0, 0], [0.6, 0, 0]]).tolist() == [True, False]
    assert trimesh.proximity.longest_ray(mesh, [[0, 0, 0.0]], [[0, 0, 1.0]]).tolist() == [0.5]
    assert mesh.ray.contains_points([]).shape == (0,)


def test_it_can_be_copied_and_pickled():
    mesh = box()
    for twin in [copy.copy(mesh.ray), copy.deepcopy(mesh.ray), pickle.loads(pickle.dumps(mesh.ray))]:
        assert twin.intersects_any([[0, 0, 5]], [[0, 0, -1]]).all()


def test_it_agrees_with_the_intersector_of_trimesh():
    pytest.importorskip("rtree")
    mesh = trimesh.creation.icosphere(subdivisions=3)
    generator = np.random.default_rng(7)
    origins = generator.normal(size=(300, 3)) * 2
    directions = generator.normal(size=(300, 3))
    theirs = trimesh.ray.ray_triangle.RayMeshIntersector(mesh).intersects_location(origins, directions)
    ours = RayMeshIntersector(mesh).intersects_location(origins, directions)
    order = np.lexsort((np.linalg.norm(theirs[0] - origins[theirs[1]], axis=1), theirs[1]))
    np.testing.assert_array_equal(ours[1], theirs[1][order])
    np.testing.assert_array_equal(ours[2], theirs[2][order])
    np.testing.assert_allclose(ours[0], theirs[0][order], atol=1e-9)


def test_slices_of_rays_give_the_results_of_all(monkeypatch):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    generator = np.random.default_rng(3)
    origins = (3 * generator.normal(size=(101, 3))).astype(np.float32)
    directions = (0.7 * generator.normal(size=(101, 3)) - origins).astype(np.float32)
    hits = rt.TriangleMesh(mesh.vertices, mesh.faces).closest(origins, directions)
    assert 20 < hits.hit.sum() < 80
    for rays_per_slice in [1 << 19, 101, 100, 10, 1]:
        monkeypatch.setattr(compat, "_RAYS_PER_SLICE", rays_per_slice)
        ours = RayMeshIntersector(mesh)
        first = ours.intersects_first(origins, directions)
        np.testing.assert_array_equal(first, hits.primitive)
        locations, index_ray, index_tri = ours.intersects_location(origins, directions, multiple_hits=False)
        np.testing.assert_array_equal(index_ray, np.flatnonzero(hits.hit))
        np.testing.assert_array_equal(index_tri, first[hits.hit])
        expected = origins[index_ray].astype(float) + hits.t[index_ray, None] * directions[index_ray].astype(float)
        np.testing.assert_allclose(locations, expected, atol=1e-14)
        assert [array.dtype for array in (first, index_ray, index_tri)] == [np.int64] * 3
        without = ours.intersects_id(origins, directions, multiple_hits=False)
        for array, same in zip(without, (index_tri, index_ray), strict=True):
            np.testing.assert_array_equal(array, same)


def test_wrong_shapes_are_refused():
    with pytest.raises(ValueError, match="must be"):
        box().ray.intersects_id([[0, 0, 0]], [[0, 0, 1], [0, 1, 0]])
