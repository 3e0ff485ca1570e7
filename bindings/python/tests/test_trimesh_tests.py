"""The tests of trimesh itself, with our intersector in place of its own. They need a copy of its repository.

RT_TRIMESH names that copy, of the same version as the package, with the folders tests and models.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("trimesh")

#: Of files of tests that trace rays.
TRACES_RAYS = re.compile(r"\.ray\b|\.contains\(|thickness|signed_distance|voxelized")


def failures(files, *options):
    """Names of tests that fail, and the number of those that pass."""
    command = [sys.executable, "-m", "pytest", "-q", "-rfE", "-p", "no:cacheprovider", *options, *map(str, files)]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    output = subprocess.run(command, env=environment, capture_output=True, text=True, check=False).stdout
    passed = re.search(r"(\d+) passed", output)
    assert passed, output
    return set(re.findall(r"^(?:FAILED|ERROR) (\S+)", output, re.MULTILINE)), int(passed[1])


def test_they_pass_with_our_intersector():
    if "RT_TRIMESH" not in os.environ:
        pytest.skip("RT_TRIMESH does not name a copy of trimesh's repository")
    folder = Path(os.environ["RT_TRIMESH"]).resolve() / "tests"
    files = sorted(path for path in folder.glob("test_*.py") if TRACES_RAYS.search(path.read_text()))
    assert folder / "test_ray.py" in files
    # Some fail anyway, where packages or models are missing.
    of_theirs, _ = failures(files)
    of_ours, passed = failures(files, "-p", "in_place_of_trimesh")
    assert of_ours <= of_theirs and passed > 50
