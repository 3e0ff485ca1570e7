"""Scenes that are changed, against scenes that are built afresh."""

import threading

import numpy as np
import pytest

import rt

FACES = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [0, 4, 7]]


def mesh(random):
    return rt.TriangleMesh(random.normal(size=(8, 3)), FACES)


def place(random, geometry):
    transform = np.eye(4)
    transform[:3, 3] = random.uniform(-3, 3, 3)
    return rt.Instance(geometry, transform)


def assert_same(scene, rays):
    """Compares a scene with one that is built of its objects."""
    fresh = rt.Scene(scene.objects)
    numbers = np.append(np.array(scene.numbers, dtype=np.int32), -1)
    for name in ("t", "primitive", "uv"):
        np.testing.assert_array_equal(getattr(scene.closest(*rays), name), getattr(fresh.closest(*rays), name))
    np.testing.assert_array_equal(scene.closest(*rays).instance, numbers[fresh.closest(*rays).instance])
    np.testing.assert_array_equal(scene.any_hit(*rays), fresh.any_hit(*rays))
    np.testing.assert_array_equal(scene.count_hits(*rays), fresh.count_hits(*rays))


@pytest.mark.parametrize("seed", range(4))
def test_random_changes_equal_a_new_scene(seed):
    random = np.random.default_rng(seed)
    rays = random.uniform(-5, 5, (300, 3)), random.normal(size=(300, 3))
    geometries = [mesh(random), mesh(random), rt.Spheres([[0, 0, 0]], 0.7)]
    scene = rt.Scene([place(random, geometry) for geometry in geometries])
    for _ in range(25):
        numbers = list(scene.numbers)
        removed = [int(i) for i in random.permutation(numbers)[: random.integers(0, 3)]]
        kept = [i for i in numbers if i not in removed]
        moved = {i: place(random, geometries[0]).transform for i in kept[:2]}
        is_mesh = lambda item: isinstance(item.geometry, rt.TriangleMesh)
        meshes = [i for i, item in zip(scene.numbers, scene.objects) if is_mesh(item) and i in kept]
        changed = {i: random.normal(size=(8, 3)) for i in meshes[:1]}
        geometries[int(random.integers(0, 2))] = mesh(random)
        new = [place(random, geometries[int(i)]) for i in random.integers(0, 3, random.integers(0, 4))]
        inserted = scene.update(insert=new, remove=removed, transforms=moved, vertices=changed)
        assert len(inserted) == len(new) and set(inserted) | set(kept) == set(scene.numbers)
        for i, vertices in changed.items():
            np.testing.assert_array_equal(scene.objects[scene.numbers.index(i)].geometry.vertices, vertices)
        assert_same(scene, rays)


def test_new_vertices_change_all_instances_of_the_mesh_and_no_other_scene():
    triangle = rt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    moved = np.eye(4)
    moved[0, 3] = 10
    scene, other = rt.Scene([triangle, rt.Instance(triangle, moved)]), rt.Scene([triangle])
    scene.update(vertices={1: [[0, 0, 2], [1, 0, 2], [0, 1, 2]]})
    origins = [[0.25, 0.25, 5], [10.25, 0.25, 5]]
    assert scene.closest(origins, [0, 0, -1]).t.tolist() == [3, 3]
    assert other.closest(origins[0], [0, 0, -1]).t == triangle.closest(origins[0], [0, 0, -1]).t == 5


def test_geometries_without_objects_free_their_memory():
    random = np.random.default_rng(7)
    scene = rt.Scene([mesh(random)])
    memory = scene._scene.memory
    for _ in range(20):
        (number,) = scene.update(insert=[mesh(random)])
        scene.update(remove=[number])
    assert scene._scene.memory == memory and scene.numbers == (0,)


def test_removed_geometries_leave_no_traces():
    random = np.random.default_rng(9)
    scene = rt.Scene([rt.Spheres([[0, 0, 0]], 1.0)])
    for _ in range(20):
        (number,) = scene.update(insert=[mesh(random)])
        scene.update(remove=[number])
    scene.update(insert=[rt.Spheres([[0, 0, 0]], 1.0)])
    # Its geometry takes the place of the removed ones.
    with pytest.raises(ValueError, match="object 1: geometry 1: the transform is not uniform"):
        scene.update(transforms={1: np.diag([1.0, 2.0, 1.0, 1.0])})


def test_refused_changes_leave_the_scene_as_it_is():
    random = np.random.default_rng(8)
    scene = rt.Scene([mesh(random), rt.Spheres([[0, 0, 0]], 1.0)])
    rays = random.uniform(-5, 5, (100, 3)), random.normal(size=(100, 3))
    before = scene.closest(*rays).t
    with pytest.raises(KeyError, match="there is no object 5"):
        scene.update(remove=[5])
    with pytest.raises(ValueError, match="object 0 is removed twice"):
        scene.update(remove=[0, 0])
    with pytest.raises(ValueError, match="^object 0: triangle 1: vertex index 3 is out of range: there are 3 vertices"):
        scene.update(vertices={0: np.zeros((3, 3))}, transforms={1: 2 * np.eye(4)})
    with pytest.raises(ValueError, match="object 1 has no vertices"):
        scene.update(vertices={1: np.zeros((3, 3))})
    with pytest.raises(ValueError, match="^object 0: vertex 2 has a coordinate that is not a finite number"):
        scene.update(vertices={0: np.where(np.arange(8)[:, None] == 2, np.nan, np.zeros((8, 3)))})
    with pytest.raises(ValueError, match=r"object 0: a transform has the shape \(4, 4\), not \(3, 3\)"):
        scene.update(transforms={0: np.eye(3)})
    with pytest.raises(ValueError, match="object 1: geometry 1: the transform is not uniform"):
        scene.update(transforms={1: np.diag([1.0, 2.0, 1.0, 1.0])})
    with pytest.raises(ValueError, match=r"^object 0: vertices must have the shape \(n, 3\), not \(1, 8, 3\)"):
        scene.update(vertices={0: np.zeros((1, 8, 3))})
    for wrong in ({"remove": [0.9]}, {"remove": ["1"]}, {"transforms": {0.0: np.eye(4)}}):
        with pytest.raises(ValueError, match="numbers of objects are integers, not"):
            scene.update(**wrong)
    with pytest.raises(TypeError, match="object 0 of insert is a str"):
        scene.update(insert=["sphere"])
    assert scene.numbers == (0, 1)
    np.testing.assert_array_equal(scene.closest(*rays).t, before)
    assert_same(scene, rays)


def test_updates_from_several_threads_are_all_made():
    sphere = rt.Spheres([[0, 0, 0]], 1.0)
    scene = rt.Scene([sphere])
    numbers = [[] for _ in range(4)]

    def insert(own):
        for _ in range(25):
            own.extend(scene.update(insert=[place(np.random.default_rng(len(own)), sphere)]))

    threads = [threading.Thread(target=insert, args=(own,)) for own in numbers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(sum(numbers, [])) == list(range(1, 101)) and scene.numbers == tuple(range(101))


def test_changes_are_taken_from_any_iterable():
    sphere = rt.Spheres([[0, 0, 0]], 1.0)
    scene = rt.Scene([sphere, place(np.random.default_rng(1), sphere)])
    assert scene.update(remove=(i for i in [1]), insert=(item for item in [sphere])) == [1]
    scene.update(remove=np.array([1]))
    assert scene.numbers == (0,)


def test_one_mesh_takes_vertices_once():
    triangle = rt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    scene = rt.Scene([triangle, rt.Instance(triangle, np.eye(4))])
    with pytest.raises(ValueError, match="objects 0 and 1 share a mesh: give its vertices once"):
        scene.update(vertices={0: np.zeros((3, 3)), 1: np.ones((3, 3))})


def test_queries_during_updates_see_a_whole_scene():
    sphere = rt.Spheres([[0, 0, 0]], 1.0)
    up, down = np.eye(4), np.eye(4)
    up[2, 3], down[2, 3] = 3, -3
    scene = rt.Scene([rt.Instance(sphere, up), rt.Instance(sphere, down)])
    seen, stop = set(), threading.Event()

    def query():
        origins = np.tile([[0.0, 0.0, 9.0], [0.0, 0.0, -9.0]], (500, 1))
        directions = np.tile([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], (500, 1))
        while not stop.is_set():
            seen.update(map(tuple, scene.closest(origins, directions).t.reshape(-1, 2).tolist()))

    thread = threading.Thread(target=query)
    thread.start()
    for i in range(200):
        size = 1 + i % 2
        scene.update(transforms={0: up @ np.diag([size, size, size, 1]), 1: down @ np.diag([size, size, size, 1])})
    stop.set()
    thread.join()
    assert seen and seen <= {(5.0, 5.0), (4.0, 4.0)}


def test_transforms_without_an_inverse_name_the_object():
    sphere = rt.Spheres([[0, 0, 0]], 1.0)
    scene = rt.Scene([sphere, sphere])
    for matrix, rule in [
        (np.zeros((4, 4)), "the transform is singular: all of its numbers are zero"),
        (np.diag([1.0, 1.0, 0.0, 1.0]), "the transform is singular"),
        (np.diag([1.0, 1.0, 1.0, 2.0]), r"the last row of the matrix must be \(0, 0, 0, 1\)"),
        (np.diag([1.0, 2.0, 1.0, 1.0]), "geometry 0: the transform is not uniform"),
    ]:
        with pytest.raises(ValueError, match=f"^object 1: {rule}"):
            rt.Scene([sphere, rt.Instance(sphere, matrix)])
        with pytest.raises(ValueError, match=f"^object 1: {rule}"):
            scene.update(transforms={1: matrix})
        with pytest.raises(ValueError, match=f"^object 0 of insert: {rule}"):
            scene.update(insert=[rt.Instance(sphere, matrix)])
