"""The example programs, with small numbers: their errors against closed forms."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def run(program, *arguments):
    command = [sys.executable, str(EXAMPLES / program), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def number(pattern, text):
    found = re.search(pattern, text)
    assert found, text
    return float(found[1])


def test_lidar(tmp_path):
    text = run("lidar.py", "--columns", "128", "--out", str(tmp_path / "cloud.npy"))
    # Ranges of up to 120 m, in double precision.
    assert number(r"at most (\S+) m", text) < 1e-11
    import numpy as np

    cloud = np.load(tmp_path / "cloud.npy")
    assert cloud["number"].max() >= 1 and (cloud["intensity"] > 0).all()


def test_sky_view():
    text = run("sky_view.py", "--size", "16", "--directions", "8")
    # 160,000 directions in strata, and 40 halvings of a right angle.
    assert number(r"factor \S+, error (\S+);", text) < 2e-4
    assert number(r"°, error (\S+)°", text) < 1e-9


def test_thickness():
    text = run("thickness.py", "--detail", "20")
    error, flat = number(r"thickness: error at most (\S+),", text), number(r"explain (\S+);", text)
    assert error < flat
    assert number(r"outside: (\S+) of", text) == 0
    assert number(r"distance: error at most (\S+)", text) < flat


def test_ambient_occlusion():
    text = run("ambient_occlusion.py", "--size", "24", "--samples", "16")
    # 256 rays in strata for each of 576 vertices.
    assert number(r"error (\S+) \(root", text) < 0.015
    assert abs(number(r"deviation (\S+)", text)) < 2e-3


def test_speed():
    text = run("speed.py", "--rays", "1e4", "--detail", "20", "--runs", "1")
    for kind in ["primary", "diffuse", "random"]:
        assert kind in text
    rows = dict(re.findall(r"^\| (rt \w+) \|(.*)\|$", text, re.MULTILINE))
    assert {"rt closest", "rt any_hit"} <= set(rows)
    for row in rows.values():
        *rates, _memory = row.split("|")
        assert len(rates) == 3 and all(float(rate) > 0 for rate in rates)


@pytest.mark.parametrize("program", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_help(program):
    assert "usage" in run(program, "--help")
