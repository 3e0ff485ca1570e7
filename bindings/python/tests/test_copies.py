"""Copies and pickles, and objects that do not change."""

import copy
import pickle
import weakref

import numpy as np
import pytest
from shapes import box

import rt

RAYS = np.random.default_rng(3).uniform(-4, 4, (200, 3)), np.random.default_rng(4).normal(size=(200, 3))

COPIES = [
    copy.copy,
    copy.deepcopy,
    *(lambda item, protocol=protocol: pickle.loads(pickle.dumps(item, protocol)) for protocol in (2, 4, 5)),
]


def moved(x):
    transform = np.eye(4)
    transform[0, 3] = x
    return transform


def assert_same(first, second):
    for got, wanted in zip(first.closest(*RAYS), second.closest(*RAYS)):
        np.testing.assert_array_equal(got, wanted)


@pytest.mark.parametrize("copied", COPIES)
def test_geometries_and_scenes(copied):
    mesh = rt.TriangleMesh(*box(), quality="high")
    spheres = rt.Spheres([[0, 0, 2], [0, 3, 0]], [0.5, 1.0])
    for geometry in (mesh, spheres, rt.TriangleMesh([], []), rt.Spheres([], [])):
        same = copied(geometry)
        assert type(same) is type(geometry) and same.quality == geometry.quality and len(same) == len(geometry)
        assert_same(same, geometry)
    single = rt.TriangleMesh(box()[0].astype(np.float32), box()[1])
    assert copied(single).vertices.dtype == np.float32
    instance = copied(rt.Instance(mesh, moved(3)))
    np.testing.assert_array_equal(instance.transform, moved(3))
    scene = rt.Scene([mesh, rt.Instance(mesh, moved(3)), spheres], quality="fast")
    scene.update(remove=[1], insert=[rt.Instance(spheres, moved(-3)), rt.Instance(mesh, moved(-2))])
    scene.update(remove=[0])
    same = copied(scene)
    assert same.numbers == scene.numbers == (1, 2, 3)
    assert_same(same, scene)
    assert same.objects[0].geometry is same.objects[1]
    # The copy changes by itself.
    assert same.update(insert=[mesh]) == [0]
    assert scene.numbers == (1, 2, 3) and same.numbers == (0, 1, 2, 3)
    empty = copied(rt.Scene([]))
    assert empty.numbers == () and len(empty) == 0 and empty


def test_weak_references():
    mesh = rt.TriangleMesh(*box())
    scene = rt.Scene([rt.Instance(mesh, moved(1))])
    assert [weakref.ref(item)() is item for item in (mesh, scene, scene.objects[0])] == [True] * 3


def test_transforms_of_instances_are_read_only():
    matrix = moved(0)
    instance = rt.Instance(rt.Spheres([[0, 0, 0]], 1.0), matrix)
    scene = rt.Scene([instance])
    matrix[0, 3] = 100
    with pytest.raises(ValueError, match="read-only"):
        instance.transform[0, 3] = 100
    with pytest.raises(AttributeError):
        instance.transform = matrix
    with pytest.raises(ValueError, match="read-only"):
        scene.objects[0].transform[0, 3] = 100
    scene.update(transforms={0: matrix})
    with pytest.raises(ValueError, match="read-only"):
        scene.objects[0].transform[0, 3] = 0
    image = rt.render(scene, spp=1, size=(9, 9), look_from=(100, 0, 5), look_at=(100, 0, 0), integrator="depth")
    assert image[4, 4].max() > 0 and scene.closest([100, 0, 5], [0, 0, -1]).t == 4


@pytest.mark.parametrize("copied", [*COPIES, lambda image: image.copy()])
def test_copies_of_images_keep_their_statistics(copied):
    image = rt.render(rt.Spheres([[0, 0, 0]], 1.0), spp=16, size=(16, 16), integrator="path")
    same = copied(image)
    np.testing.assert_array_equal(same, image)
    assert type(same) is rt.Image and vars(same) == vars(image)
    assert same.error is not None and same.stopped == "samples" and same.samples_per_pixel == 16


def test_arrays_made_of_images_have_no_statistics():
    image = rt.render(rt.Spheres([[0, 0, 0]], 1.0), spp=16, size=(16, 16), integrator="path")
    for derived in (image * 0, image[:1, :1], image.view(), image.mean(axis=0), np.flip(image)):
        assert isinstance(derived, rt.Image)
        assert derived.error is derived.statistics is derived.samples_per_pixel is None
