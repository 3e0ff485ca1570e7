"""Type hints of the package, as users see them."""

from pathlib import Path
from typing import get_args, get_type_hints

import pytest

import rt

CALLS = """
from pathlib import Path

import numpy as np
import numpy.typing as npt

import rt
from rt.compat.trimesh import RayMeshIntersector


def calls(vertices: npt.NDArray[np.float32], faces: npt.NDArray[np.int64]) -> None:
    mesh = rt.TriangleMesh(vertices, faces, quality="high")
    quality: str = mesh.quality
    ball = rt.Spheres([[0, 0, 0]], 1.0)
    rt.Scene(mesh)
    rt.Scene([mesh, ball, rt.Instance(mesh, np.eye(4))])
    rt.Scene({3: ball}.values())
    scene = rt.Scene(item for item in [mesh, mesh])
    t: npt.NDArray[np.float64] = scene.closest([0, 0, 0], [1, 0, 0], t_max=np.ones(5), threads=np.int64(2)).t
    ball.nearest_point([0, 0, 0], max_distance=np.float32(2))
    numbers: list[int] = scene.update(insert=[ball], remove=[np.int64(1), 2], transforms={0: np.eye(4)}, vertices={0: vertices})
    RayMeshIntersector(mesh, threads=np.int32(2)).intersects_any([[0, 0, 0]], [[0, 0, 1]])
    image = rt.render(Path("scene.ron"), spp=np.int64(4), seed=np.uint64(3), time=np.float32(1), size=[8, 8], fov=40)
    rt.render(scene, size=np.array([3, 4]), look_from=(0, 1, 2))
    rt.converge("scene.ron", spp=np.array([1, 4]), reference_spp=np.int64(64), seeds=np.int8(2), size=(8, 8))
    error: float | None = image.error
    if image.statistics is not None:
        seconds: float = image.statistics["render_seconds"]
"""

# The attributes of other arrays that are made from an image are `None`.
WRONG = """
import rt

image = rt.render("scene.ron").T
image.samples_per_pixel + 1.0
image.stopped.upper()
image.statistics["samples"]
"""


def test_attributes_of_images_may_be_none():
    image = rt.render(rt.Spheres([[0, 0, 0]], 1), spp=1, size=(4, 4)).T
    hints = get_type_hints(rt.Image)
    assert hints["statistics"] == dict[str, float] | None
    for name, hint in hints.items():
        assert getattr(image, name) is None and type(None) in get_args(hint)


def test_mypy_accepts_what_the_package_accepts(tmp_path):
    api = pytest.importorskip("mypy.api")
    for name, text, n_errors in [("calls.py", CALLS, 0), ("wrong.py", WRONG, 3)]:
        path = tmp_path / name
        path.write_text(text)
        report, _, _ = api.run(["--strict", "--cache-dir", str(tmp_path / "cache"), str(path)])
        assert report.count(" error: ") == n_errors, report


def test_mypy_accepts_the_package_itself(tmp_path):
    api = pytest.importorskip("mypy.api")
    package = Path(__file__).parent.parent / "python" / "rt"
    report, errors, status = api.run(["--strict", "--cache-dir", str(tmp_path / "cache"), str(package)])
    assert status == 0, report + errors
