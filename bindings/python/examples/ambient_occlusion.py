"""Ambient occlusion baked to the vertices of a mesh, compared with the closed form of a sphere on a plane.

    python ambient_occlusion.py [--samples 16] [--figure ambient_occlusion.png]

A vertex is as bright as the share of the sky that it sees, weighted by the cosine. A sphere of radius r that touches a plane
takes away r³ / (r² + d²)^(3/2) of the light of a point on the plane, at the distance d from the point where they touch.
"""

import argparse
import time

import numpy as np
from numpy.typing import NDArray

import rt


def cosine_directions(normals: NDArray[np.float64], n: int, generator: np.random.Generator) -> NDArray[np.float64]:
    """n² directions around each normal with a density proportional to the cosine, jittered in strata."""
    cells = np.indices((n, n)).reshape(2, -1).T
    u, v = ((cells + generator.random((len(normals), n * n, 2))) / n).transpose(2, 0, 1)
    radius, angle = np.sqrt(u), 2 * np.pi * v
    helper = np.where(np.abs(normals[:, :1]) > 0.5, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    tangent = np.cross(normals, helper)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    bitangent = np.cross(normals, tangent)
    x, y, z = radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - u)
    directions: NDArray[np.float64] = (
        x[..., None] * tangent[:, None] + y[..., None] * bitangent[:, None] + z[..., None] * normals[:, None]
    )
    return directions


def bake(
    scene: rt.Scene, points: NDArray[np.float64], normals: NDArray[np.float64], n: int, offset: float = 1e-6, seed: int = 0
) -> NDArray[np.float64]:
    """Visible share of the sky at each point."""
    directions = cosine_directions(normals, n, np.random.default_rng(seed))
    origins = points + offset * normals
    hidden: NDArray[np.float64] = scene.any_hit(origins[:, None], directions).mean(axis=1)
    return 1 - hidden


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=16, help="square root of the number of rays of a vertex")
    parser.add_argument("--size", type=int, default=96, help="vertices of the plane on each side")
    parser.add_argument("--figure", help="image of the plane (needs matplotlib)")
    options = parser.parse_args()
    n = options.size
    x, y = np.meshgrid(np.linspace(-3, 3, n), np.linspace(-3, 3, n), indexing="ij")
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    scene = rt.Scene([rt.TriangleMesh(points, faces), rt.Spheres([[0, 0, 1]], 1.0)])
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    started = time.perf_counter()
    sky = bake(scene, points, normals, options.samples)
    seconds = time.perf_counter() - started
    exact = 1 - (1 + (points**2).sum(axis=1)) ** -1.5
    n_rays = len(points) * options.samples**2
    error = np.sqrt(np.mean((sky - exact) ** 2))
    bias = np.mean(sky - exact)
    print(f"{n_rays} rays, {n_rays / seconds / 1e6:.1f} Mrays/s; error {error:.4f} (root mean square), mean deviation {bias:.1e}")
    if options.figure:
        import matplotlib.pyplot as plt

        figure, (left, right) = plt.subplots(1, 2, figsize=(7, 3.2), dpi=100)
        left.imshow(sky.reshape(n, n).T, origin="lower", extent=(-3, 3, -3, 3), cmap="gray", vmin=0, vmax=1)
        left.set_title("visible share of the sky")
        distance = np.linalg.norm(points, axis=1)
        right.plot(distance, sky, ".", markersize=1, label="baked")
        line = np.linspace(0, 4, 200)
        right.plot(line, 1 - (1 + line**2) ** -1.5, label="closed form")
        right.set(xlabel="distance from the sphere's foot", ylim=(0, 1))
        right.legend()
        figure.tight_layout()
        figure.savefig(options.figure)


if __name__ == "__main__":
    main()
