"""Rays that programs have answered wrongly: hits and numbers exactly, t to rounding."""

import json
from pathlib import Path

import numpy as np
import pytest

import rt

CASES = json.loads((Path(__file__).parent / "field_cases" / "cases.json").read_text())

#: Error of t over the distance of the farthest vertex from the origin of the ray, in lengths of its direction. A weighted
#: mean of three such distances has a rounding error of 2⁻⁵⁰ or less; weights of grazing rays are less exact.
ROUNDING = 2.0**-44


def bound(case, triangle, ray):
    origin, direction = np.array(ray[0]), np.array(ray[1])
    corners = np.array(case["vertices"])[case["faces"][triangle]]
    with np.errstate(over="ignore"):
        return ROUNDING * np.abs(corners - origin).max() / np.abs(direction).max()


@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
@pytest.mark.parametrize("quality", ["fast", "balanced", "high"])
def test_all_hits(case, quality):
    mesh = rt.TriangleMesh(np.array(case["vertices"]), np.array(case["faces"]), quality=quality)
    t_max = np.inf if case["t_max"] is None else case["t_max"]
    origins, directions = np.moveaxis(np.array(case["rays"]), 1, 0)
    limits = {"t_min": case["t_min"], "t_max": t_max}
    hits = mesh.all_hits(origins, directions, **limits)
    closest = mesh.closest(origins, directions, **limits)
    for i, expected in enumerate(case["hits"]):
        of_ray = slice(hits.offsets[i], hits.offsets[i + 1])
        numbers = hits.primitive[of_ray]
        assert len(set(numbers)) == len(numbers), f"ray {i}"
        assert sorted(numbers) == expected["exact"], f"ray {i}"
        exact = dict(zip(expected["primitive"] + expected["border"], expected["t"] + expected["border_t"]))
        for number, t in zip(numbers, hits.t[of_ray]):
            assert abs(t - exact[number]) <= bound(case, number, case["rays"][i]), f"ray {i}, triangle {number}"
        assert (np.diff(hits.t[of_ray]) >= 0).all(), f"ray {i}"
        if len(numbers):
            assert closest.t[i] == hits.t[of_ray][0] and closest.primitive[i] == numbers[0]
        else:
            assert closest.t[i] == np.inf and closest.primitive[i] == -1
    np.testing.assert_array_equal(mesh.any_hit(origins, directions, **limits), closest.hit)
    np.testing.assert_array_equal(mesh.count_hits(origins, directions, **limits), np.diff(hits.offsets))


def test_most_answers_leave_no_choice():
    answers = [expected for case in CASES for expected in case["hits"]]
    certain = [not expected["border"] for expected in answers]
    assert sum(certain) >= 0.85 * len(answers)


def test_there_are_enough_cases():
    assert len(CASES) >= 24 and len({case["name"] for case in CASES}) == len(CASES)
    assert all(any(expected["t"] for expected in case["hits"]) or case["risk"] for case in CASES)
