"""Meshes that several tests use."""

import numpy as np

BOX_FACES = np.array(
    [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6],
     [1, 3, 5], [3, 7, 5]]
)


def box(half=1.0, dtype=np.float64):
    """Vertices and faces of a closed box around the origin."""
    corners = [[x, y, z] for z in (-half, half) for y in (-half, half) for x in (-half, half)]
    return np.array(corners, dtype=dtype), BOX_FACES


def bumpy_sphere(n):
    """A star-shaped mesh of about 2 n² triangles, open at the poles."""
    longitude = np.linspace(0, 2 * np.pi, n, endpoint=False)
    latitude = np.linspace(0.02, np.pi - 0.02, n + 1)
    u, v = np.meshgrid(longitude, latitude, indexing="ij")
    radius = 1 + 0.1 * np.sin(17 * u) * np.sin(13 * v)
    vertices = np.stack([radius * np.sin(v) * np.cos(u), radius * np.sin(v) * np.sin(u), radius * np.cos(v)], axis=-1)
    index = np.arange(n * (n + 1)).reshape(n, n + 1)
    a, b = index[:, :-1], np.roll(index, -1, axis=0)[:, :-1]
    c, d = np.roll(index, -1, axis=0)[:, 1:], index[:, 1:]
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    return vertices.reshape(-1, 3), faces


def moller_trumbore(vertices, faces, origins, directions):
    """t of every ray and triangle in double precision, NaN for a miss: Möller and Trumbore, 1997."""
    a, b, c = (vertices[faces[:, k]].astype(np.float64) for k in range(3))
    p = np.cross(directions[:, None], (c - a)[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / np.einsum("rtk,tk->rt", p, b - a)
        offset = origins[:, None] - a[None]
        u = np.einsum("rtk,rtk->rt", offset, p) * scale
        q = np.cross(offset, (b - a)[None])
        v = np.einsum("rk,rtk->rt", directions, q) * scale
        t = np.einsum("tk,rtk->rt", c - a, q) * scale
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0)
    return np.where(inside, t, np.nan)
