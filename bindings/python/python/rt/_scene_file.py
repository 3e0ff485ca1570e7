"""Scene files of geometries, for rendering."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from ._scene import Instance, Scene, Spheres, TriangleMesh


def write(folder: Path, scene: Scene | TriangleMesh | Spheres, camera: dict[str, object]) -> Path:
    """Writes the scene file and the meshes that it names. Vertices are in single precision."""
    objects = scene.objects if isinstance(scene, Scene) else (scene,)
    groups: dict[str, list[dict[str, object]]] = {}
    names: dict[int, str] = {}
    nodes = []
    for item in objects:
        geometry = item.geometry if isinstance(item, Instance) else item
        name = names.get(id(geometry))
        if name is None:
            name = names[id(geometry)] = f"geometry {len(names)}"
            groups[name] = _nodes(folder, f"{len(names)}.ply", geometry)
        node: dict[str, object] = {"instance": name}
        if isinstance(item, Instance):
            node["transform"] = [{"matrix": item.transform.tolist()}]
        nodes.append(node)
    content: dict[str, object] = {"nodes": nodes, "groups": groups}
    if camera:
        content["camera"] = camera
    path = folder / "scene.json"
    path.write_text(json.dumps(content))
    return path


def _nodes(folder: Path, file_name: str, geometry: TriangleMesh | Spheres) -> list[dict[str, object]]:
    if isinstance(geometry, Spheres):
        spheres = zip(geometry.centres.tolist(), geometry.radii.tolist())
        return [{"shape": {"sphere": {"center": centre, "radius": radius}}} for centre, radius in spheres]
    if not geometry._geometry.has_area():
        return []
    _write_ply(folder / file_name, geometry.vertices, geometry.faces)
    return [{"model": file_name}]


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
