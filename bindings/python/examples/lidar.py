"""A spinning scanner with 64 beams drives through a small town: a cloud of points with intensity and several returns.

    python lidar.py [--columns 512] [--out lidar.npy] [--figure lidar.png]

Every column of beams is fired from another place and heading, as the sensor moves. Trees are many small leaves: a beam that
meets leaves goes on with less light, so that one beam has several returns. A return has the intensity cos θ / r², times the
light that is left.
"""

import argparse
import time

import numpy as np
from numpy.typing import NDArray

import rt

LEAF_SHARE = 0.5
MAX_RETURNS = 4
MOUNTING_HEIGHT = 1.8

# Vertices and faces.
Part = tuple[NDArray[np.float64], NDArray[np.int64]]


def box(low: list[float], high: list[float]) -> Part:
    corners = np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
             [1, 5, 7], [1, 7, 3]]
    return corners, np.array(faces)


def merged(parts: list[Part]) -> Part:
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in parts[:-1]])
    return np.concatenate([v for v, _ in parts]), np.concatenate([f + o for (_, f), o in zip(parts, offsets)])


def town(generator: np.random.Generator) -> tuple[rt.TriangleMesh, rt.TriangleMesh]:
    """Solid things and leaves as two meshes."""
    ground = (np.array([[-200.0, -200, 0], [200, -200, 0], [200, 200, 0], [-200, 200, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    houses = [box([x, y, 0], [x + 12, y + 10 * np.sign(y), 6 + 4 * generator.random()])
              for x in range(-60, 60, 20) for y in (-9, 9)]
    poles = [box([x - 0.1, y - 0.1, 0], [x + 0.1, y + 0.1, 6]) for x in range(-55, 60, 20) for y in (-5, 5)]
    leaves = []
    for x in range(-50, 60, 20):
        for y in (-6, 6):
            centres = [x, y, 4.5] + generator.normal(scale=[0.8, 0.8, 0.9], size=(1500, 3))
            corners = centres[:, None] + generator.normal(scale=0.12, size=(1500, 3, 3))
            leaves.append((corners.reshape(-1, 3), np.arange(4500).reshape(-1, 3)))
    return rt.TriangleMesh(*merged([ground, *houses, *poles])), rt.TriangleMesh(*merged(leaves))


def beams(columns: int, speed: float = 10.0, turn_time: float = 0.1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Origins and directions of all beams of one turn, of shape (columns, 64, 3)."""
    moment = np.arange(columns) / columns
    azimuth = 2 * np.pi * moment
    elevation = np.radians(np.linspace(-24.8, 2.0, 64))
    origins = np.stack([speed * turn_time * moment, np.zeros(columns), np.full(columns, MOUNTING_HEIGHT)], axis=-1)
    flat = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    directions = np.concatenate([
        flat[:, None] * np.cos(elevation)[None, :, None],
        np.broadcast_to(np.sin(elevation)[None, :, None], (columns, 64, 1)),
    ], axis=-1)
    return origins[:, None], directions


def scan(
    solid: rt.TriangleMesh,
    leaves: rt.TriangleMesh,
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    reach: float = 120.0,
) -> NDArray[np.void]:
    """Points of all returns as records: place, intensity, number of the return, column and beam."""
    scene = rt.Scene([solid, leaves])
    hits = scene.all_hits(origins, directions, t_max=reach)
    ray = hits.ray
    is_leaf = hits.instance == 1
    # Light that is left in front of each hit: a share of it for each leaf before, and none behind a wall.
    before = np.concatenate([[0], np.cumsum(is_leaf)])[:-1]
    first = hits.offsets[ray]
    leaves_before = before - before[first]
    walls = np.concatenate([[0], np.cumsum(~is_leaf)])[:-1]
    is_lit = (walls - walls[first] == 0) & (leaves_before < MAX_RETURNS)
    light = np.where(is_lit, (1 - LEAF_SHARE) ** leaves_before, 0.0) * np.where(is_leaf, LEAF_SHARE, 1.0)
    origin = np.broadcast_to(origins, directions.shape).reshape(-1, 3)[ray]
    direction = directions.reshape(-1, 3)[ray]
    normals = np.empty((len(ray), 3))
    for instance, mesh in enumerate((solid, leaves)):
        chosen = hits.instance == instance
        a, b, c = np.moveaxis(mesh.vertices.astype(float)[mesh.faces[hits.primitive[chosen]]], 1, 0)
        normals[chosen] = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    cosine = np.abs((normals * direction).sum(axis=1))
    cloud = np.zeros(len(ray), dtype=[("point", "f8", 3), ("intensity", "f8"), ("number", "i4"), ("column", "i4"), ("beam", "i4")])
    cloud["point"] = origin + hits.t[:, None] * direction
    cloud["intensity"] = light * cosine / hits.t**2
    cloud["number"], cloud["column"], cloud["beam"] = leaves_before, ray // 64, ray % 64
    return cloud[light > 0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--columns", type=int, default=2048, help="columns of 64 beams in one turn")
    parser.add_argument("--out", help="file for the cloud, as a numpy array of records")
    parser.add_argument("--figure", help="image of the cloud from above (needs matplotlib)")
    options = parser.parse_args()
    solid, leaves = town(np.random.default_rng(1))
    origins, directions = beams(options.columns)
    scan(solid, leaves, origins[:1], directions[:1])
    started = time.perf_counter()
    cloud = scan(solid, leaves, origins, directions)
    seconds = time.perf_counter() - started
    # On the ground far from everything, the range is the height over the sine of the elevation.
    ground = cloud[np.abs(cloud["point"][:, 2]) < 1e-6]
    sines = directions[ground["column"], ground["beam"], 2]
    ranges = np.linalg.norm(ground["point"] - origins[ground["column"], 0], axis=1)
    error = np.abs(ranges - MOUNTING_HEIGHT / -sines).max()
    several = np.bincount(cloud["column"] * 64 + cloud["beam"], minlength=options.columns * 64)
    print(f"{directions.size // 3} beams, {len(cloud)} returns, {(several > 1).mean():.1%} of the beams with several")
    print(f"range error on the ground at most {error:.1e} m, {directions.size / 3 / seconds / 1e6:.2f} million beams per second")
    if options.out:
        np.save(options.out, cloud)
    if options.figure:
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(figsize=(7, 3.2), dpi=100)
        x, y, z = cloud["point"].T
        axes.scatter(x, y, c=z, s=0.2, cmap="viridis", vmax=9)
        axes.set(xlim=(-60, 60), ylim=(-25, 25), aspect="equal", xlabel="x in m", ylabel="y in m")
        figure.tight_layout()
        figure.savefig(options.figure)


if __name__ == "__main__":
    main()
