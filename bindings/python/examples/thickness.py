"""Thickness of a closed mesh, and a map of the distance from its surface: a shell between two spheres.

    python thickness.py [--figure thickness.png]

The thickness at a point is the length of the ray from there against the normal to the other side. Of a shell it is the
difference of the radii, where both spheres have the same faces.
"""

import argparse
import time

import numpy as np
from numpy.typing import NDArray

import rt


def sphere(radius: float, n: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Sphere of 6 n² squares, each of two triangles, counter-clockwise seen from outside."""
    side = np.tan(np.linspace(-np.pi / 4, np.pi / 4, n + 1))
    u, v = np.meshgrid(side, side, indexing="ij")
    one = np.ones_like(u)
    sides = [(one, u, v), (-one, v, u), (v, one, u), (u, -one, v), (u, v, one), (v, u, -one)]
    vertices, faces = [], []
    for i, components in enumerate(sides):
        points = np.stack(components, axis=-1).reshape(-1, 3)
        vertices.append(radius * points / np.linalg.norm(points, axis=1, keepdims=True))
        index = i * (n + 1) ** 2 + np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
        a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
        faces += [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    return np.concatenate(vertices), np.concatenate(faces)


def thickness(mesh: rt.TriangleMesh) -> NDArray[np.float64]:
    """Thickness at the centroid of each face, along the normal of the face; infinite where there is no other side."""
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    origins = corners.mean(axis=1)
    hits = mesh.all_hits(origins, -normals)
    # The first hit of another face.
    other = hits.primitive != hits.ray
    first = np.full(len(origins), np.inf)
    np.minimum.at(first, hits.ray[other], hits.t[other])
    return first


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--detail", type=int, default=60, help="squares on each side of the spheres")
    parser.add_argument("--figure", help="slice of the signed distance (needs matplotlib)")
    options = parser.parse_args()
    outer, faces = sphere(1.0, options.detail)
    inner, _ = sphere(0.7, options.detail)
    # The inner surface faces inwards.
    shell = rt.TriangleMesh(np.concatenate([outer, inner]), np.concatenate([faces, faces[:, ::-1] + len(outer)]))
    shell.any_hit([0, 0, 0], [1, 0, 0])
    started = time.perf_counter()
    measured = thickness(shell)[: len(faces)]
    seconds = time.perf_counter() - started
    # Faces are flat: centroids lie below the sphere by as much as the square of their size.
    sagitta = 0.5 * (np.pi / 2 / options.detail) ** 2
    error = np.abs(measured - 0.3).max()
    print(f"thickness: error at most {error:.1e}, where flat faces explain {sagitta:.1e}; {len(faces) / seconds / 1e6:.2f} Mrays/s")

    points = np.random.default_rng(3).uniform(-1.1, 1.1, size=(20_000, 3))
    radius = np.linalg.norm(points, axis=1)
    clear = np.minimum(np.abs(radius - 1), np.abs(radius - 0.7)) > sagitta
    wrong = (shell.contains(points) != ((radius > 0.7) & (radius < 1)))[clear].sum()
    exact = np.maximum(radius - 1, 0.7 - radius)
    deviation = np.abs(shell.signed_distance(points) - exact).max()
    print(f"inside or outside: {wrong} of {clear.sum()} points wrong; signed distance: error at most {deviation:.1e}")
    if options.figure:
        import matplotlib.pyplot as plt

        x, y = np.meshgrid(np.linspace(-1.2, 1.2, 160), np.linspace(-1.2, 1.2, 160))
        distance = shell.signed_distance(np.stack([x, y, np.zeros_like(x)], axis=-1))
        figure, axes = plt.subplots(figsize=(4.4, 3.6), dpi=90)
        picture = axes.imshow(distance, origin="lower", extent=(-1.2, 1.2, -1.2, 1.2), cmap="RdBu", vmin=-0.4, vmax=0.4)
        axes.contour(x, y, distance, levels=[0], colors="black", linewidths=1)
        figure.colorbar(picture, label="signed distance")
        figure.tight_layout()
        figure.savefig(options.figure)


if __name__ == "__main__":
    main()
