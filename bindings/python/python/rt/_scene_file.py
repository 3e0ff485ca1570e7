"""Scene files of geometries, for rendering."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from ._scene import Instance, Scene, Spheres, TriangleMesh

# A mesh is far from the origin if it is farther than this many times its size.
_FAR = 1024.0


def write(folder: Path, scene: Scene | TriangleMesh | Spheres, camera: dict[str, object]) -> Path:
    """Writes the scene file and the meshes that it names.

    Vertices are in single precision. Those of meshes far from the origin are relative to a centre, which the transforms of
    the nodes add in double precision.
    """
    objects = dict(zip(scene.numbers, scene.objects)) if isinstance(scene, Scene) else {None: scene}
    groups: dict[str, list[dict[str, object]]] = {}
    written: dict[int, tuple[str, np.ndarray]] = {}
    nodes = []
    for number, item in objects.items():
        geometry = item.geometry if isinstance(item, Instance) else item
        if id(geometry) not in written:
            name, file_name = f"geometry {len(written)}", f"{len(written) + 1}.ply"
            of_object = "" if number is None else f" of object {number}"
            groups[name], centre = _nodes(folder, file_name, geometry, of_object)
            written[id(geometry)] = name, centre
        name, centre = written[id(geometry)]
        node: dict[str, object] = {"instance": name}
        if isinstance(item, Instance) or centre.any():
            matrix = item.transform.copy() if isinstance(item, Instance) else np.eye(4)
            if centre.any():
                matrix[:3, 3] += matrix[:3, :3] @ centre
            node["transform"] = [{"matrix": matrix.tolist()}]
        nodes.append(node)
    content: dict[str, object] = {"nodes": nodes, "groups": groups}
    if camera:
        content["camera"] = camera
    path = folder / "scene.json"
    path.write_text(json.dumps(content))
    return path


def centre(scene: Scene | TriangleMesh | Spheres) -> np.ndarray:
    """Centre of the bounds of all objects with an area; the origin without any."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    boxes: dict[int, tuple[np.ndarray, np.ndarray] | None] = {}
    for item in scene.objects if isinstance(scene, Scene) else [scene]:
        geometry = item.geometry if isinstance(item, Instance) else item
        if id(geometry) not in boxes:
            boxes[id(geometry)] = _box(geometry)
        box = boxes[id(geometry)]
        if box is None:
            continue
        middle, half = 0.5 * box[0] + 0.5 * box[1], 0.5 * box[1] - 0.5 * box[0]
        if isinstance(item, Instance):
            matrix = item.transform[:3, :3]
            middle, half = matrix @ middle + item.transform[:3, 3], np.abs(matrix) @ half
        low, high = np.minimum(low, middle - half), np.maximum(high, middle + half)
    return 0.5 * low + 0.5 * high if (low <= high).all() else np.zeros(3)


def _box(geometry: TriangleMesh | Spheres) -> tuple[np.ndarray, np.ndarray] | None:
    """Lowest and highest coordinates of a geometry; `None` without an area."""
    if isinstance(geometry, Spheres):
        centres, radii = geometry.centres, geometry.radii[:, None]
        return ((centres - radii).min(axis=0), (centres + radii).max(axis=0)) if len(geometry) else None
    vertices = geometry.vertices.astype(np.float64)[np.unique(geometry.faces)]
    if not len(vertices):
        return None
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return (low, high) if geometry._geometry.has_area((0.5 * low + 0.5 * high).tolist()) else None


def _nodes(
    folder: Path, file_name: str, geometry: TriangleMesh | Spheres, of_object: str
) -> tuple[list[dict[str, object]], np.ndarray]:
    """Nodes of a geometry, and the centre that their vertices are relative to."""
    if isinstance(geometry, Spheres):
        spheres = zip(geometry.centres.tolist(), geometry.radii.tolist())
        return [{"shape": {"sphere": {"center": centre, "radius": radius}}} for centre, radius in spheres], np.zeros(3)
    vertices, faces = geometry.vertices, geometry.faces
    # Meshes keep vertices in single precision if it holds all of them.
    centre = np.zeros(3)
    if vertices.dtype != np.float32:
        vertices, centre = _rounded(vertices, faces, of_object)
    if not geometry._geometry.has_area(centre.tolist()):
        return [], np.zeros(3)
    _write_ply(folder / file_name, vertices, faces)
    return [{"model": file_name}], centre


def _rounded(vertices: np.ndarray, faces: np.ndarray, of_object: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices minus a centre in single precision, and the centre: zero unless the mesh is far from the origin."""
    is_used = np.zeros(len(vertices), dtype=bool)
    is_used[faces] = True
    used, centre = vertices[is_used], np.zeros(3)
    if len(used):
        low, high = used.min(axis=0), used.max(axis=0)
        middle, size = 0.5 * low + 0.5 * high, (high - low).max()
        if size > 0 and np.abs(middle).max() > _FAR * size:
            centre = middle
    # Vertices without a triangle may be anywhere.
    offsets = np.where(is_used[:, None], vertices - centre, 0.0)
    largest = np.finfo(np.float32).max
    bad = np.flatnonzero((np.abs(offsets) > largest).any(axis=1))
    if bad.size:
        vertex = vertices[bad[0]].tolist()
        raise ValueError(f"scene: vertex {bad[0]}{of_object} is {vertex}, too large to render: at most {largest:.1e}")
    return offsets.astype(np.float32), centre


def _write_ply(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), dtype=[("count", "u1"), ("vertices", "<i4", 3)])
    records["count"], records["vertices"] = 3, faces
    with path.open("wb") as file:
        file.write(header.encode())
        file.write(np.ascontiguousarray(vertices, dtype="<f4").tobytes())
        file.write(records.tobytes())
