"""Images of scene files and geometry."""

import numpy as np
import pytest
from shapes import box

import rt

SCENE = """(
    background: constant(rgb(0.5, 0.25, 0.125)),
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0)),
    settings: (integrator: path),
    nodes: [(shape: sphere(radius: 1))],
)
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.ron"
    path.write_text(SCENE)
    return path


def test_an_image_is_linear_radiance_with_its_statistics(scene):
    image = rt.render(scene, spp=4, size=(32, 24))
    assert image.shape == (24, 32, 3) and image.dtype == np.float32
    np.testing.assert_array_equal(image[0, 0], np.float32([0.5, 0.25, 0.125]))
    assert image.statistics["samples"] == 4 * 32 * 24 and image.stopped == "samples"
    assert image.samples_per_pixel == 4


def test_images_depend_on_the_seed_and_not_on_threads(scene):
    first = rt.render(scene, spp=2, size=(24, 24), seed=1, threads=1)
    np.testing.assert_array_equal(first, rt.render(str(scene), spp=2, size=(24, 24), seed=1, threads=2))
    assert (first != rt.render(scene, spp=2, size=(24, 24), seed=2)).any()


def test_a_render_ends_at_its_target_error(scene):
    image = rt.render(scene, size=(48, 48), target_error=0.05)
    assert image.stopped == "target" and image.error <= 0.05
    low, high = image.error_interval
    assert low <= image.error <= high


def test_a_render_ends_in_time(scene):
    image = rt.render(scene, size=(16, 16), time=0.2, spp=1 << 20)
    assert image.stopped in ("time", "samples") and image.statistics["render_seconds"] < 2


def test_errors_say_what_and_where(scene, tmp_path):
    with pytest.raises(ValueError, match="absent.ron"):
        rt.render(tmp_path / "absent.ron")
    with pytest.raises(ValueError, match='integrator "fast" is not one of whitted'):
        rt.render(scene, integrator="fast")
    bad = tmp_path / "bad.ron"
    bad.write_text("Scene(camera: 3)")
    with pytest.raises(ValueError, match="bad.ron"):
        rt.render(bad)
    with pytest.raises(ValueError, match="positive number of seconds"):
        rt.render(scene, time=-1.0)


def test_the_error_falls_with_the_number_of_samples(scene):
    rows = rt.converge(scene, spp=(4, 64), reference_spp=1024, seeds=2, size=(24, 24))
    assert [row.spp for row in rows] == [4, 64]
    assert rows[1].relative_rmse < 0.5 * rows[0].relative_rmse
    assert all(row.seconds > 0 and abs(row.bias) < 0.1 for row in rows)


def test_geometry_is_rendered_where_rays_hit_it():
    moved = np.eye(4)
    moved[0, 3] = 3
    mesh = rt.TriangleMesh(*box())
    scene = rt.Scene([mesh, rt.Instance(mesh, moved), rt.Spheres([[-3, 0, 0]], 1.0)])
    camera = {"look_from": [0, 0, 10], "look_at": [0, 0, 0], "fov": 60}
    depth = rt.render(scene, size=(60, 60), spp=4, integrator="depth", **camera)
    height = np.tan(np.radians(30))
    x, y = np.meshgrid((np.arange(60) + 0.5) / 30 - 1, 1 - (np.arange(60) + 0.5) / 30)
    directions = np.stack([x * height, y * height, np.full_like(x, -1.0)], axis=-1)
    hit = scene.any_hit([0, 0, 10], directions)
    assert 0.1 < hit.mean() < 0.9
    is_bright = np.asarray(depth).max(axis=-1) > 0
    # Nearest white, farthest and background black; pixels on a silhouette may be either.
    assert (is_bright == hit).mean() > 0.95


def test_a_default_camera_sees_the_geometry():
    image = rt.render(rt.Spheres([[5, 5, 5]], 2.0), size=(32, 32), spp=4)
    assert np.isfinite(image).all() and image.std() > 0.01


def test_options_of_the_camera_are_for_geometry(scene):
    with pytest.raises(ValueError, match="cameras of its own"):
        rt.render(scene, look_from=[0, 0, 1])
    with pytest.raises(ValueError, match="look_at needs look_from"):
        rt.render(rt.Spheres([[0, 0, 0]], 1.0), look_at=[0, 0, 1])
