"""Sky-view factor and horizon of a terrain, compared with the closed form of a long valley.

    python sky_view.py [--size 96] [--figure sky_view.png]

The sky-view factor is the share of the light of an overcast sky that a horizontal surface receives: the mean visibility of
directions that are distributed by the cosine. Where two long slopes of angle β meet, it is cos β.
"""

import argparse
import time

import numpy as np
from numpy.typing import NDArray

import rt


def terrain(heights: NDArray[np.float64], step: float) -> tuple[rt.TriangleMesh, NDArray[np.float64]]:
    """Grid of heights as a mesh."""
    n, m = heights.shape
    x, y = np.meshgrid(np.arange(n) * step, np.arange(m) * step, indexing="ij")
    index = np.arange(n * m).reshape(n, m)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return rt.TriangleMesh(np.stack([x, y, heights], axis=-1).reshape(-1, 3), faces), np.stack([x, y, heights], axis=-1)


def cosine_directions(n: int) -> NDArray[np.float64]:
    """n² directions of the upper hemisphere, stratified, with a density proportional to the cosine."""
    u, v = ((np.indices((n, n)) + 0.5) / n).reshape(2, -1)
    radius = np.sqrt(u)
    return np.stack([radius * np.cos(2 * np.pi * v), radius * np.sin(2 * np.pi * v), np.sqrt(1 - u)], axis=-1)


def sky_view(mesh: rt.TriangleMesh, points: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    # A little above the surface: the point itself lies on it.
    origins = points + [0, 0, 1e-9]
    hidden: NDArray[np.float64] = mesh.any_hit(origins[..., None, :], directions).mean(axis=-1)
    return 1 - hidden


def horizon(mesh: rt.TriangleMesh, points: NDArray[np.float64], azimuth: float, steps: int = 40) -> NDArray[np.float64]:
    """Elevation of the horizon in radians, by bisection: visible above, hidden below."""
    low: NDArray[np.float64] = np.zeros(points.shape[:-1])
    high: NDArray[np.float64] = np.full(points.shape[:-1], np.pi / 2)
    flat = np.array([np.cos(azimuth), np.sin(azimuth)])
    for _ in range(steps):
        middle = (low + high) / 2
        directions = np.concatenate([np.cos(middle)[..., None] * flat, np.sin(middle)[..., None]], axis=-1)
        hidden = mesh.any_hit(points + [0, 0, 1e-9], directions)
        low, high = np.where(hidden, middle, low), np.where(hidden, high, middle)
    return (low + high) / 2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=96, help="points of the terrain on each side")
    parser.add_argument("--directions", type=int, default=24, help="square root of the number of directions")
    parser.add_argument("--figure", help="map of the sky-view factor (needs matplotlib)")
    options = parser.parse_args()
    directions = cosine_directions(options.directions)

    # A valley so long that its ends do not matter.
    angle = np.radians(30)
    slopes = np.repeat(np.tan(angle) * np.abs([-1000.0, 0.0, 1000.0])[:, None], 2, axis=1)
    x, y = np.array([0.0, 1000.0, 2000.0]), np.array([-1e6, 1e6])
    valley = rt.TriangleMesh(
        [[x[i], y[j], slopes[i, j]] for i in range(3) for j in range(2)],
        [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
    )
    bottom = np.array([1000.0, 0.0, 0.0])
    factor = sky_view(valley, bottom, cosine_directions(400))
    elevation = horizon(valley, bottom, 0.0)
    print(f"valley: sky-view factor {factor:.4f}, error {abs(factor - np.cos(angle)):.1e}; "
          f"horizon {np.degrees(elevation):.6f}°, error {abs(np.degrees(elevation) - 30):.1e}°")

    n = options.size
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    heights = 60 * np.sin(5 * u + 3 * v) * np.cos(7 * v - 2 * u) + 25 * np.sin(17 * u) * np.sin(19 * v)
    mesh, points = terrain(heights, 600 / n)
    started = time.perf_counter()
    factors = sky_view(mesh, points, directions)
    seconds = time.perf_counter() - started
    n_rays = points.size // 3 * len(directions)
    print(f"terrain: {n_rays} rays, {n_rays / seconds / 1e6:.1f} Mrays/s, factors from {factors.min():.2f} to {factors.max():.2f}")
    if options.figure:
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(figsize=(4.6, 3.6), dpi=100)
        picture = axes.imshow(factors.T, origin="lower", extent=(0, 600, 0, 600), cmap="gray")
        axes.set(xlabel="x in m", ylabel="y in m")
        figure.colorbar(picture, label="sky-view factor")
        figure.tight_layout()
        figure.savefig(options.figure)


if __name__ == "__main__":
    main()
