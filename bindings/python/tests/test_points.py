"""Nearest points, inside and outside, and signed distances."""

import numpy as np
from shapes import box

import rt


def grid():
    return np.stack(np.meshgrid(*[np.linspace(-1.5, 1.5, 13)] * 3), axis=-1)


def distance_from_box(points):
    outside = np.linalg.norm(np.maximum(np.abs(points) - 1, 0), axis=-1)
    return np.where(outside > 0, outside, (np.abs(points) - 1).max(axis=-1))


def test_distances_from_a_box():
    mesh = rt.TriangleMesh(*box())
    points = grid()
    expected = distance_from_box(points)
    np.testing.assert_allclose(mesh.signed_distance(points), expected, atol=1e-14)
    np.testing.assert_array_equal(mesh.contains(points), expected <= 0)
    nearest = mesh.nearest_point(points)
    assert nearest.point.shape == points.shape and nearest.distance.shape == points.shape[:-1]
    np.testing.assert_allclose(nearest.distance, np.abs(expected), atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(nearest.point - points, axis=-1), nearest.distance, atol=1e-14)
    np.testing.assert_array_equal(mesh.signed_distance(points, threads=1), mesh.signed_distance(points, threads=3))


def test_results_in_single_precision_are_those_of_the_same_numbers_in_double():
    mesh = rt.TriangleMesh(*box())
    points = grid().astype(np.float32)
    np.testing.assert_array_equal(mesh.signed_distance(points), mesh.signed_distance(points.astype(np.float64)))


def test_surfaces_beyond_the_largest_distance_do_not_count():
    mesh = rt.TriangleMesh(*box())
    nearest = mesh.nearest_point([[3.0, 0, 0], [4.0, 0, 0]], max_distance=2.0)
    assert nearest.distance.tolist() == [2.0, np.inf] and nearest.primitive[1] == nearest.instance[1] == -1
    assert np.isnan(nearest.point[1]).all()


def test_transformed_meshes_and_spheres():
    stretched = np.diag([2.0, 1.0, 1.0, 1.0])
    moved = np.diag([0.5, 0.5, 0.5, 1.0])
    moved[0, 3] = 10
    scene = rt.Scene([rt.Instance(rt.TriangleMesh(*box()), stretched), rt.Instance(rt.Spheres([[0, 0, 0]], 1), moved)])
    points = [[3.0, 0, 0], [1.5, 0, 0], [10, 0, 0.25], [10, 0, 2]]
    np.testing.assert_allclose(scene.signed_distance(points), [1.0, -0.5, -0.25, 1.5])
    assert scene.nearest_point(points).instance.tolist() == [0, 0, 1, 1]


def test_a_hollow_box_is_empty_inside():
    outer, faces = box(2.0)
    inner, _ = box(1.0)
    mesh = rt.TriangleMesh(np.concatenate([outer, inner]), np.concatenate([faces, faces + 8]))
    assert mesh.contains([[0, 0, 0], [1.5, 0, 0], [2.5, 0, 0]]).tolist() == [False, True, False]


def test_nothing_is_near_an_empty_mesh():
    mesh = rt.TriangleMesh(np.empty((0, 3)), np.empty((0, 3), dtype=int))
    assert mesh.signed_distance([0, 0, 0]) == np.inf and not mesh.contains([0, 0, 0])
    assert not mesh.any_hit([0, 0, 0], [1, 0, 0])
