"""Images of scene files."""

import numpy as np
import pytest

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
    with pytest.raises(ValueError, match="integrator "fast" is not one of whitted"):
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
