"""The interface of trimesh, where trimesh is installed."""

import copy
import inspect
import pickle

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

import rt  # noqa: E402
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
    lowest = [np.flatnonzero((mesh.faces == i).any(axis=1))[0] for i in range(8)]
    np.testing.assert_array_equal(index_tri, lowest)
    for array, same in zip(mesh.ray.intersects_id(origins, mesh.vertices), (index_tri, index_ray), strict=True):
        np.testing.assert_array_equal(array, same)


def test_the_lowest_of_equal_faces_is_named():
    """Rounding decided which one."""
    vertices = np.array([[0, 0, 0], [1, 0.1, 0.2], [0.3, 1, 0.1]])
    mesh = trimesh.Trimesh(vertices, [[1, 2, 0], [0, 1, 2]], process=False)
    points = np.random.default_rng(0).dirichlet([1, 1, 1], 200) @ vertices
    origins = np.tile([3.0, 1, 2], (200, 1))
    index_tri, index_ray = RayMeshIntersector(mesh).intersects_id(origins, points - origins)
    np.testing.assert_array_equal(index_tri, np.zeros(200))
    np.testing.assert_array_equal(index_ray, np.arange(200))


def test_vertices_without_faces_do_not_merge_locations():
    """A far vertex made all hits one."""
    box = trimesh.creation.box()
    mesh = trimesh.Trimesh(np.vstack([box.vertices, [[1e13, 0, 0]]]), box.faces, process=False)
    locations, _, _ = RayMeshIntersector(mesh).intersects_location([[0.1, 0.2, 5]], [[0, 0, -1]])
    np.testing.assert_allclose(locations[:, 2], [0.5, -0.5])


@pytest.mark.parametrize("scale", [1e-30, 1e-9, 1e-4, 1.0, 1e4, 1e8, 1e30])
def test_hits_at_an_edge_count_once_at_every_scale(scale):
    mesh = trimesh.creation.box().subdivide().subdivide()
    mesh.apply_scale(scale)
    mesh.ray = RayMeshIntersector(mesh)
    generator = np.random.default_rng(5)
    a, b = (mesh.vertices[mesh.edges_unique[:, k]] for k in range(2))
    weights = generator.random((len(a), 1))
    origins = np.concatenate([mesh.vertices, a + weights * (b - a)])
    # Both from the surface inwards and from far outside, along an axis and slanted.
    for start in [origins, origins * 1000]:
        directions = scale * generator.normal(scale=0.01, size=start.shape) - start
        for towards in [directions, -start]:
            index_ray = mesh.ray.intersects_id(start, towards)[1]
            np.testing.assert_array_equal(np.bincount(index_ray, minlength=len(start)), 2)
            assert len(mesh.ray.intersects_location(start, towards)[0]) == 2 * len(start)


def test_sheets_close_to_each_other_are_different_locations():
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    heights = np.repeat([0.0, 1e-10, 2e-10], 4)
    vertices = np.tile(square, (3, 1)) + heights[:, None] * [0, 0, 1.0]
    faces = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * i for i in range(3)])
    ray = RayMeshIntersector(trimesh.Trimesh(vertices, faces, process=False))
    locations, index_ray, index_tri = ray.intersects_location([[0.5, 0.5, 1]], [[0, 0, -1]])
    assert locations[:, 2].tolist() == [2e-10, 1e-10, 0]
    assert index_tri.tolist() == [4, 2, 0] and index_ray.tolist() == [0, 0, 0]


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


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("threads", [1, 3, None])
def test_slices_of_rays_give_the_results_of_all(threads, order):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    generator = np.random.default_rng(3)
    # Rays of several slices on one thread, and a part of one.
    n = 3 * (1 << 16) + 11
    origins = (3 * generator.normal(size=(n, 3))).astype(np.float32)
    directions = (0.7 * generator.normal(size=(n, 3)) - origins).astype(np.float32)
    hits = rt.TriangleMesh(mesh.vertices, mesh.faces).closest(origins, directions)
    assert 0.2 < hits.hit.mean() < 0.8
    # Read in place, or gathered.
    origins, directions = np.asarray(origins, order=order), np.asarray(directions, order=order)
    ours = RayMeshIntersector(mesh, threads=threads)
    first = ours.intersects_first(origins, directions)
    np.testing.assert_array_equal(first, hits.primitive)
    locations, index_ray, index_tri = ours.intersects_location(origins, directions, multiple_hits=False)
    np.testing.assert_array_equal(index_ray, np.flatnonzero(hits.hit))
    np.testing.assert_array_equal(index_tri, first[hits.hit])
    expected = origins[index_ray].astype(float) + hits.t[index_ray, None] * directions[index_ray].astype(float)
    np.testing.assert_allclose(locations, expected, atol=1e-13)
    assert [array.dtype for array in (first, index_ray, index_tri)] == [np.int64] * 3
    without = ours.intersects_id(origins, directions, multiple_hits=False)
    for array, same in zip(without, (index_tri, index_ray), strict=True):
        np.testing.assert_array_equal(array, same)
    # No ray hits an edge, so that all hits count.
    hits = rt.TriangleMesh(mesh.vertices, mesh.faces).all_hits(origins, directions)
    locations, index_ray, index_tri = ours.intersects_location(origins, directions)
    np.testing.assert_array_equal(index_ray, hits.ray)
    np.testing.assert_array_equal(index_tri, hits.primitive)
    expected = origins[index_ray].astype(float) + hits.t[:, None] * directions[index_ray].astype(float)
    np.testing.assert_allclose(locations, expected, atol=1e-13)
    at_most_one = ours.intersects_id(origins, directions, max_hits=1)
    for array, same in zip(at_most_one, without, strict=True):
        np.testing.assert_array_equal(array, same)


@pytest.mark.parametrize("row", [0, 70_000, 199_999])
@pytest.mark.parametrize("threads", [1, None])
def test_the_row_of_an_invalid_number_is_named(row, threads):
    ray = RayMeshIntersector(trimesh.creation.box(), threads=threads)
    origins, directions = np.zeros((200_000, 3)), np.ones((200_000, 3))
    directions[row, 1] = np.nan
    for query in [ray.intersects_id, ray.intersects_location, ray.intersects_first, ray.intersects_any]:
        with pytest.raises(ValueError, match=f"row {row} of directions"):
            query(origins, directions)


def their_intersectors():
    modules = [trimesh.ray.ray_triangle, *([trimesh.ray.ray_pyembree] if trimesh.ray.has_embree else [])]
    return [module.RayMeshIntersector for module in modules]


@pytest.mark.parametrize("theirs", their_intersectors())
def test_methods_take_the_arguments_of_trimesh(theirs):
    methods = [name for name in dir(theirs) if not name.startswith("_")]
    assert {"intersects_id", "intersects_location", "intersects_first", "intersects_any", "contains_points"} <= set(methods)
    for name in ["__init__", *methods]:
        expected = inspect.signature(getattr(theirs, name)).parameters
        found = inspect.signature(getattr(RayMeshIntersector, name)).parameters
        for parameter in expected.values():
            # Some of their methods are wrapped, which hides the arguments.
            if parameter.kind in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
                continue
            assert parameter.name in found, f"{name} takes {parameter.name}"
            if name != "intersects_id" and parameter.name != "geometry":
                assert list(found).index(parameter.name) == list(expected).index(parameter.name)


@pytest.mark.parametrize("theirs", their_intersectors())
def test_results_have_the_types_of_trimesh(theirs):
    if theirs is trimesh.ray.ray_triangle.RayMeshIntersector:
        pytest.importorskip("rtree")
    mesh = trimesh.creation.icosphere(subdivisions=2)
    ours, theirs = RayMeshIntersector(mesh), theirs(mesh)
    generator = np.random.default_rng(11)
    hits = generator.normal(size=(40, 3)) * 2, generator.normal(size=(40, 3))
    misses = np.full((3, 3), 9.0), np.full((3, 3), 1.0)
    for rays in [hits, misses, [array.tolist() for array in hits], [array.astype(np.float32) for array in hits]]:
        for multiple_hits in [True, False]:
            id_options = {"multiple_hits": multiple_hits, "return_locations": True}
            locations = [each.intersects_location(*rays, multiple_hits=multiple_hits) for each in (ours, theirs)]
            pairs = [
                locations,
                (ours.intersects_id(*rays, **id_options), theirs.intersects_id(*rays, **id_options)),
                (ours.intersects_id(*rays), theirs.intersects_id(*rays)),
                ((ours.intersects_first(*rays),), (theirs.intersects_first(*rays),)),
                ((ours.intersects_any(*rays),), (theirs.intersects_any(*rays),)),
            ]
            for found, expected in pairs:
                assert len(found) == len(expected)
                for array, other in zip(found, expected, strict=True):
                    assert array.dtype.kind == other.dtype.kind and len(array) == len(other)
                    assert array.ndim == other.ndim or len(array) == 0


def test_queries_of_trimesh_give_the_same_with_it():
    pytest.importorskip("rtree")
    pytest.importorskip("scipy")
    mesh = trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=2.0)
    theirs, ours = mesh.copy(), mesh.copy()
    theirs.ray, ours.ray = trimesh.ray.ray_triangle.RayMeshIntersector(theirs), RayMeshIntersector(ours)
    generator = np.random.default_rng(13)
    points = generator.uniform(-1.2, 1.2, size=(100, 3))
    on_surface, faces = trimesh.sample.sample_surface(mesh, 50, seed=1)
    inwards = -mesh.face_normals[faces]
    queries = [
        lambda mesh: mesh.contains(points),
        lambda mesh: trimesh.proximity.signed_distance(mesh, points),
        lambda mesh: mesh.nearest.signed_distance(points),
        lambda mesh: trimesh.proximity.longest_ray(mesh, on_surface + 1e-6 * inwards, inwards),
        lambda mesh: trimesh.proximity.thickness(mesh, on_surface, exterior=False, method="ray"),
        lambda mesh: trimesh.proximity.thickness(mesh, on_surface, exterior=True, method="ray"),
        lambda mesh: trimesh.ray.ray_util.contains_points(mesh.ray, points),
        lambda mesh: sorted(trimesh.voxel.creation.voxelize(mesh, 0.17, method="ray").points.round(9).tolist()),
    ]
    for query in queries:
        np.testing.assert_allclose(query(ours), query(theirs), atol=1e-9)


def test_a_mesh_with_it_can_be_copied_and_pickled():
    mesh = box()
    twin = pickle.loads(pickle.dumps(mesh))
    assert isinstance(twin.ray, RayMeshIntersector) and twin.ray.mesh is twin
    twin.apply_translation([10, 0, 0])
    assert not twin.ray.intersects_any([[0, 0, 5]], [[0, 0, -1]]).any()
    for twin in [mesh.copy(), copy.copy(mesh), copy.deepcopy(mesh)]:
        assert twin.contains([[0, 0, 0]]).all()


def test_meshes_without_faces_have_no_hits():
    ray = RayMeshIntersector(geometry=trimesh.Trimesh(np.zeros((3, 3)), np.empty((0, 3), dtype=int), process=False))
    rays = [[0, 0, 5]], [[0, 0, -1]]
    assert [len(array) for array in ray.intersects_location(*rays)] == [0, 0, 0]
    assert ray.intersects_first(*rays).tolist() == [-1] and not ray.intersects_any(*rays).any()


def test_wrong_shapes_are_refused():
    with pytest.raises(ValueError, match="must be"):
        box().ray.intersects_id([[0, 0, 0]], [[0, 0, 1], [0, 1, 0]])
