"""Images of scene files and geometry."""

import re

import numpy as np
import pytest
from shapes import box, bumpy_sphere

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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"spp": 0}, "spp must be an integer from 1 to"),
        ({"spp": -1}, "spp must be an integer from 1 to"),
        ({"spp": 1.5}, "spp must be an integer from 1 to"),
        ({"size": (16.7, 16)}, "the width of size must be an integer from 1 to 4294967295, not 16.7"),
        ({"size": (5, -1)}, "the height of size must be an integer from 1 to 4294967295, not -1"),
        ({"size": 5}, "size must be a width and a height, not 5"),
        ({"depth": -1}, "depth must be an integer from 0 to"),
        ({"seed": -1}, "seed must be an integer from 0 to"),
        ({"threads": np.inf}, "threads must be an integer from 1 to 1024, not inf"),
        ({"threads": [2]}, "threads must be an integer from 1 to 1024, not"),
        ({"time": 0}, "time must be positive and finite, not 0"),
        ({"time": -1.0}, "time must be positive and finite, not -1.0"),
        ({"time": np.inf}, "time must be positive and finite, not inf"),
        ({"time": 1e300}, "time must be positive and below 1.8e19 seconds, not 1e300$"),
        ({"target_error": 0}, "target_error must be positive and finite, not 0"),
        ({"target_error": np.nan}, "target_error must be a number, not nan"),
        ({"fov": np.nan}, "fov must be a number, not nan"),
        ({"fov": 180}, "fov must be between 0 and 180, not 180"),
        ({"look_from": (0, np.nan, 0)}, r"look_from \[0.0, nan, 0.0\] holds a number that is not finite"),
        ({"look_from": (0, 5, 0), "look_at": (0, 5, 0)}, "look_from and look_at are the same point"),
        ({"look_from": (0, 5, 0), "up": (0, 1, 0)}, r"up \[0.0, 1.0, 0.0\] is zero or parallel to the view"),
        ({"look_from": (0, 5, 0), "up": (0, 0, 0)}, r"up \[0.0, 0.0, 0.0\] is zero or parallel to the view"),
        ({"up": (0, 1, 0)}, "up needs look_from"),
    ],
)
def test_options_out_of_range_are_named(options, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        rt.render(rt.Spheres([[0, 0, 0]], 1.0), **{"spp": 1, "size": (8, 8)} | options)


def test_errors_of_geometry_do_not_name_temporary_files():
    with pytest.raises(ValueError, match="^size: "):
        rt.render(rt.Spheres([[0, 0, 0]], 1.0), size=(1 << 20, 1 << 20))


def test_errors_of_geometry_name_arguments_and_quote_no_generated_text():
    ball = rt.Spheres([[0, 0, 0]], 1.0)
    far = np.diag([1e70, 1e70, 1e70, 1.0])
    for scene, options, message in [
        (ball, {"look_from": (0, 0, 1e70)}, "look_from: 1e70 is not a number of magnitude at most 1e60"),
        (ball, {"look_from": (0, 0, 5), "look_at": (0, 0, 1e70)}, "look_at: 1e70 is not a number of magnitude at most 1e60"),
        (ball, {"look_from": (0, 0, 5), "up": (0, 1e-200, 0)}, "up .* is zero or parallel to the view: choose another direction"),
        (rt.Scene([rt.Instance(ball, far)]), {}, "scene: .* is a coordinate of the camera .* closer to the origin"),
    ]:
        with pytest.raises(ValueError) as raised:
            rt.render(scene, spp=1, size=(8, 8), **options)
        assert re.fullmatch(message, str(raised.value))


def test_no_line_of_an_error_names_the_scene_file():
    with pytest.raises(ValueError) as raised:
        rt.render(rt.Spheres([[0, 0, 0]], 1.0), spp=1, size=(8, 8), fov=1e-320)
    assert "the field of view is" in str(raised.value)
    assert not re.search("^camera", str(raised.value), re.M)


@pytest.mark.filterwarnings("error")
def test_a_view_longer_than_all_numbers_is_refused_without_a_warning():
    with pytest.raises(ValueError, match="^look_from: 1e308 is not"):
        rt.render(rt.Spheres([[0, 0, 0]], 1.0), spp=1, size=(8, 8), look_from=(1e308, 0, 0), look_at=(-1e308, 0, 0))


def test_seeds_of_a_table_are_limited_by_their_number(scene):
    with pytest.raises(ValueError, match="^seed 18446744073709551615 is too large for 2 seeds"):
        rt.converge(scene, spp=(1,), seeds=2, seed=2**64 - 1, size=(8, 8))
    assert rt.converge(scene, spp=(1,), reference_spp=1, seeds=2, seed=2**64 - 3, size=(8, 8))


def test_a_target_error_ends_at_4096_samples_by_default(scene):
    image = rt.render(scene, size=(4, 4), target_error=1e-9)
    assert image.stopped == "samples" and image.samples_per_pixel == 4096
    assert rt.render(scene, size=(1, 1), time=1).samples_per_pixel > 4096


def test_tables_hold_the_samples_that_were_rendered(scene):
    (row,) = rt.converge(scene, spp=(3,), reference_spp=4, seeds=1, size=(8, 8))
    assert row.spp == rt.render(scene, spp=3, size=(8, 8)).samples_per_pixel == 4
    # The size is read once, although several images have it.
    assert rt.converge(scene, spp=(1,), reference_spp=1, seeds=2, size=iter((8, 8)))
    for options, message in [
        ({"spp": (1.5,)}, "spp must be an integer"),
        ({"spp": ()}, "spp must hold"),
        ({"seeds": 0}, "seeds must be an integer from 1"),
        ({"reference_spp": 0}, "^reference_spp must be an integer from 1"),
    ]:
        with pytest.raises(ValueError, match=message):
            rt.converge(scene, **{"spp": (1,), "seeds": 1, "size": (8, 8)} | options)


def test_references_do_not_end_by_time_or_error(scene, monkeypatch):
    images, render = [], rt.render
    monkeypatch.setattr(rt._render, "render", lambda *scenes, **options: images.append(render(*scenes, **options)) or images[-1])
    rt.converge(scene, spp=(16,), reference_spp=1024, seeds=1, size=(16, 16), time=60, target_error=1.0)
    assert [image.samples_per_pixel for image in images] == [1024, 16]
    assert images[0].stopped == "samples"


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


def test_views_along_the_y_axis_and_with_another_up():
    # A bar along x: upright in the image if x is up.
    spheres = rt.Spheres([[x, 0, 0] for x in np.linspace(-2, 2, 9)], 0.5)
    options = {"size": (32, 32), "spp": 1, "integrator": "depth", "look_from": (0, 8, 0), "look_at": (0, 0, 0)}
    wide, high = (np.asarray(rt.render(spheres, **options, **up)).max(axis=-1) > 0 for up in ({}, {"up": (1, 0, 0)}))
    assert wide.any(axis=0).sum() > 2 * wide.any(axis=1).sum() > 0
    assert high.any(axis=1).sum() > 2 * high.any(axis=0).sum() > 0


def test_meshes_without_area_are_left_out():
    line = rt.TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    # Without area in single precision.
    thin = rt.TriangleMesh([[1, 0, 0], [2, 0, 0], [1.5, 1e-60, 0]], [[0, 1, 2]])
    options = {"size": (16, 16), "spp": 1, "look_from": (0, 0, 5), "integrator": "depth"}
    mesh = rt.TriangleMesh(*box())
    expected = rt.render(mesh, **options)
    np.testing.assert_array_equal(rt.render(rt.Scene([mesh, line, thin]), **options), expected)


@pytest.mark.parametrize("distance", [1e4, 1e6, 1e8])
def test_vertices_far_from_the_origin_keep_their_digits(distance):
    vertices, faces = bumpy_sphere(12)
    mesh = rt.TriangleMesh(vertices, faces)
    centre, moved = np.full(3, distance), np.eye(4)
    moved[:3, 3] = centre
    options = {"look_from": centre + [0, 0, 4], "look_at": centre, "size": (32, 32), "spp": 4}
    expected = rt.render(rt.Scene([rt.Instance(mesh, moved)]), **options)
    # The last vertex is part of no triangle.
    far = rt.TriangleMesh(np.vstack([vertices + centre, [[1e50, 0, 0]]]), faces)
    np.testing.assert_allclose(rt.render(far, **options), expected, rtol=1e-4)
    twice = rt.Scene([rt.Instance(far, np.diag([2.0, 2.0, 2.0, 1.0]))])
    options |= {"look_from": 2 * options["look_from"], "look_at": 2 * centre}
    moved = moved @ moved @ np.diag([2.0, 2.0, 2.0, 1.0])
    expected = rt.render(rt.Scene([rt.Instance(mesh, moved)]), **options)
    np.testing.assert_allclose(rt.render(twice, **options), expected, rtol=1e-4)


def test_vertices_beyond_single_precision_are_refused():
    ball, large = rt.Spheres([[0, 0, 0]], 1.0), rt.TriangleMesh(np.eye(3) * 1e50, [[0, 1, 2]])
    with pytest.raises(ValueError, match=r"^scene: vertex 0 is \[1e\+50, 0.0, 0.0\], too large to render"):
        rt.render(large, spp=1, size=(8, 8))
    with pytest.raises(ValueError, match=r"^scene: vertex 0 of object 1 is \[1e\+50, 0.0, 0.0\]"):
        rt.render(rt.Scene([ball, large]), spp=1, size=(8, 8))


def test_a_default_camera_sees_the_geometry():
    image = rt.render(rt.Spheres([[5, 5, 5]], 2.0), size=(32, 32), spp=4)
    assert np.isfinite(image).all() and image.std() > 0.01


def test_a_camera_without_a_target_looks_at_the_centre_of_the_bounds():
    moved = np.diag([2.0, 2.0, 2.0, 1.0])
    moved[:3, 3] = [0, 100, 0]
    mesh = rt.TriangleMesh(box()[0] + [50, 0, 0], box()[1])
    nothing = rt.TriangleMesh([[900, 0, 0], [901, 0, 0], [902, 0, 0]], [[0, 1, 2]])
    options = {"size": (64, 64), "spp": 1, "integrator": "depth", "fov": 100}
    for scene, centre, distance in [
        (mesh, [50, 0, 0], 5),
        (rt.Spheres([[5, 5, 5], [7, 5, 5]], [1, 3]), [7, 5, 5], 9),
        (rt.Scene([rt.Instance(mesh, moved), nothing, rt.Spheres([], [])]), [100, 100, 0], 9),
        (rt.Scene([mesh, rt.Instance(mesh, moved)]), [75.5, 50.5, 0], 60),
    ]:
        eye = np.add(centre, [1, 2, distance])
        image = rt.render(scene, look_from=eye, **options)
        np.testing.assert_array_equal(image, rt.render(scene, look_from=eye, look_at=centre, **options))
        assert image.any()


def test_options_of_the_camera_are_for_geometry(scene):
    with pytest.raises(ValueError, match="cameras of its own"):
        rt.render(scene, look_from=[0, 0, 1])
    with pytest.raises(ValueError, match="look_at needs look_from"):
        rt.render(rt.Spheres([[0, 0, 0]], 1.0), look_at=[0, 0, 1])
