#!/usr/bin/env python3
"""Makes the pairs of light sources, studio lights and images around bare models: scenes, and references by numeric integration.

    python3 tests/physics/make/lamps.py        # writes tests/physics/pairs/lamp-* and bare-*; needs numpy

Every scene has one plane of Lambert's law, seen straight from a parallel camera. The reference of a pixel is

    L(x) = albedo / pi * E(x),    E = sum of I(w) cos / d^2 (point, spot), E cos (directional), integral of L cos (surfaces)

averaged over its area by the midpoint rule. Nothing of the renderer is used: units are those of glTF's KHR_lights_punctual
(cd, lx), of pbrt-v4 (I, L, scale, power, illuminance), and radiance for emissive surfaces, images and backgrounds.
A `ref.json` holds the mean over blocks of pixels by row, column and channel; a standard error of 0 marks an integral.
"""
import base64
import json
import math
import os
import struct
import zlib

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "pairs")
SIZE, BLOCK, SUB, HALF = 16, 4, 16, 2.0     # pixels, pixels of a block, midpoints of a pixel, half of the height that is seen
ALBEDO = np.array([0.8, 0.5, 0.2])
GRAY = np.array([0.8, 0.8, 0.8])
DIRECT_ONLY = {"KHR_materials_specular": {"specularFactor": 0.0}}


# --- places on the plane ----------------------------------------------------------------------------------------------
def offsets(half=HALF):
    """Midpoints from one edge of the image to the other."""
    n = SIZE * SUB
    return ((np.arange(n) + 0.5) / n * 2.0 - 1.0) * half


def floor(half=HALF):
    """Points of the floor y = 0, seen from above: rows run to +z, columns to +x."""
    x, z = np.meshgrid(offsets(half), offsets(half))
    return np.stack([x, np.zeros_like(x), z], -1), np.array([0.0, 1.0, 0.0])


def block_means(image):
    pixels = image.reshape(SIZE, SUB, SIZE, SUB, 3).mean((1, 3))
    n = SIZE // BLOCK
    return pixels.reshape(n, BLOCK, n, BLOCK, 3).mean((1, 3))


# --- irradiance -------------------------------------------------------------------------------------------------------
def unit(v):
    v = np.asarray(v, float)
    return v / np.linalg.norm(v)


def point(at, position, intensity, axis=None, inner=0.0, outer=0.0):
    """Irradiance from a point, or from a cone with a squared ramp between two angles in radians."""
    places, normal = at
    way = np.asarray(position, float) - places
    d2 = (way * way).sum(-1)
    cos = np.maximum((way @ normal) / np.sqrt(d2), 0.0)
    beam = np.ones_like(cos)
    if axis is not None:
        off = -(way @ unit(axis)) / np.sqrt(d2)
        beam = np.clip((off - math.cos(outer)) / (math.cos(inner) - math.cos(outer)), 0.0, 1.0) ** 2
    return (beam * cos / d2)[..., None] * np.asarray(intensity, float)


def parallel(at, direction, irradiance):
    places, normal = at
    cos = max(-(unit(direction) @ normal), 0.0)
    return np.broadcast_to(cos * np.asarray(irradiance, float), places.shape)


def rectangle(at, corner, along, across, radiance, n=48):
    """Irradiance from a rectangle that emits to the side of along x across: midpoint rule, n x n."""
    places, normal = at
    corner, along, across = (np.asarray(a, float) for a in (corner, along, across))
    facing = np.cross(along, across)
    area = np.linalg.norm(facing)
    facing = facing / area
    total = np.zeros(places.shape[:-1])
    for u in (np.arange(n) + 0.5) / n:
        for w in (np.arange(n) + 0.5) / n:
            way = corner + u * along + w * across - places
            d2 = (way * way).sum(-1)
            total += np.maximum(way @ normal, 0) * np.maximum(-(way @ facing), 0) / (d2 * d2)
    return (total * area / (n * n))[..., None] * np.asarray(radiance, float)


def sky(at, radiance):
    """Irradiance from a radiance that depends on the direction: midpoint rule over the hemisphere."""
    places, normal = at
    n = 400
    cos2, turn = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * 2 * math.pi)
    cos, sin = np.sqrt(cos2), np.sqrt(1 - cos2)
    side = unit(np.cross(normal, [0.3, 0.5, 0.7]))
    other = np.cross(normal, side)
    to = (sin * np.cos(turn))[..., None] * side + (sin * np.sin(turn))[..., None] * other + cos[..., None] * normal
    return np.broadcast_to(math.pi * radiance(to).mean((0, 1)), places.shape)


def reflected(irradiance, albedo=ALBEDO):
    return albedo / math.pi * irradiance


# --- files ------------------------------------------------------------------------------------------------------------
def quad(corner, along, across):
    corner, along, across = (np.asarray(a, float) for a in (corner, along, across))
    return [corner, corner + along, corner + along + across, corner + across], unit(np.cross(along, across))


FLOOR = quad((-60, 0, 60), (120, 0, 0), (0, 0, -120))
WALL = quad((-60, -60, 0), (120, 0, 0), (0, 120, 0))


def gltf(quads, materials, lights=(), camera="down", scale=1.0):
    """A document of quads, one for each material, with lights as (node, light), and a parallel camera."""
    data, views, accessors, meshes = b"", [], [], []

    def put(array, kind, component):
        nonlocal data
        array = np.ascontiguousarray(array)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        entry = {"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind}
        if kind == "VEC3":
            entry.update(min=array.min(0).tolist(), max=array.max(0).tolist())
        accessors.append(entry)
        data += array.tobytes()
        return len(accessors) - 1

    for index, (corners, normal) in enumerate(quads):
        attributes = {
            "POSITION": put(np.asarray(corners, "<f4"), "VEC3", 5126),
            "NORMAL": put(np.asarray([normal] * 4, "<f4"), "VEC3", 5126),
        }
        indices = put(np.asarray([0, 1, 2, 0, 2, 3], "<u4"), "SCALAR", 5125)
        meshes.append({"primitives": [{"attributes": attributes, "indices": indices, "material": index}]})
    half = math.sqrt(0.5)
    place = {"down": {"translation": [0, 9, 0], "rotation": [-half, 0, 0, half]}, "ahead": {"translation": [0, 0, 9]}}
    nodes = [{"mesh": i} for i in range(len(meshes))] + [{"camera": 0, **place[camera]}]
    for i, (node, _) in enumerate(lights):
        nodes.append({**node, "extensions": {"KHR_lights_punctual": {"light": i}}})
    used = sorted({name for material in materials for name in material.get("extensions", {})})
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": meshes,
        "materials": materials,
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": HALF, "ymag": HALF, "znear": 0.1, "zfar": 100}}],
        "nodes": nodes,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "scene": 0,
    }
    if lights:
        used.append("KHR_lights_punctual")
        document["extensions"] = {"KHR_lights_punctual": {"lights": [light for _, light in lights]}}
    if used:
        document["extensionsUsed"] = used
    return json.dumps(document)


def matte(albedo=ALBEDO):
    factor = {"baseColorFactor": [*map(float, albedo), 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
    return {"pbrMetallicRoughness": factor, "extensions": DIRECT_ONLY}


def emitter(factor, strength):
    black = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0.0, "roughnessFactor": 1.0}
    extensions = {**DIRECT_ONLY, "KHR_materials_emissive_strength": {"emissiveStrength": strength}}
    return {"pbrMetallicRoughness": black, "emissiveFactor": factor, "extensions": extensions}


def turned(direction):
    """A rotation that takes -z to a direction, as a quaternion."""
    a, b = np.array([0.0, 0.0, -1.0]), unit(direction)
    q = np.array([*np.cross(a, b), 1.0 + a @ b])
    return (q / np.linalg.norm(q)).tolist()


def hdr(radiance, width=8, height=4):
    """An image of one colour as Radiance writes it, with the colour that it holds then."""
    exponent = math.ceil(math.log2(max(radiance)))
    mantissas = [min(int(c / 2.0**exponent * 256), 255) for c in radiance]
    held = np.array(mantissas) / 256.0 * 2.0**exponent
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    return head + struct.pack("4B", *mantissas, exponent + 128) * (width * height), held


# --- pairs ------------------------------------------------------------------------------------------------------------
def pair(name, scene, files, args, image, spp=64, seeds=4, tol=2e-3, note=""):
    folder = os.path.join(ROOT, name)
    os.makedirs(folder, exist_ok=True)
    for file, content in files.items():
        with open(os.path.join(folder, file), "wb") as out:
            out.write(content if isinstance(content, bytes) else content.encode())
    blocks = block_means(np.asarray(image, float))
    entry = {
        "name": name, "scene": scene, "args": args, "spp": spp, "seeds": seeds, "block": BLOCK, "tol": tol, "atol": 0.0,
        "note": note, "expect": "agree", "kind": "numeric", "first_seed": 1 + zlib.crc32(name.encode()) % 1000000,
    }
    with open(os.path.join(folder, "pair.json"), "w") as out:
        out.write(json.dumps(entry, indent=1) + "\n")
    mean = [float(f"{value:.9g}") for value in blocks.ravel()]
    reference = {"shape": list(blocks.shape), "mean": mean, "stderr": [0.0] * len(mean)}
    with open(os.path.join(folder, "ref.json"), "w") as out:
        out.write(json.dumps(reference) + "\n")


FRAME = ["--size", f"{SIZE}x{SIZE}"]


def bare(name, document, image, integrators, extra=(), files=None, note="", **kwargs):
    for integrator in integrators:
        args = [*FRAME, "--integrator", integrator, *extra]
        pair(f"{name}-{integrator}", "ours.gltf", {"ours.gltf": document, **(files or {})}, args, image, note=note, **kwargs)


def gltf_lamps():
    at = floor()
    everyone = ["path", "direct", "distributed", "whitted"]
    I = np.array([1.0, 0.5, 0.25]) * 40
    lamp = {"type": "point", "color": [1.0, 0.5, 0.25], "intensity": 40.0}
    node = {"translation": [0.3, 1.0, -0.4], "scale": [3.0, 2.0, 0.5]}
    document = gltf([FLOOR], [matte()], [(node, lamp)])
    image = reflected(point(at, (0.3, 1.0, -0.4), I))
    bare("lamp-gltf-point", document, image, [*everyone, "caustics"], note="luminous intensity in cd; scale of nodes does not count")

    one = gltf([FLOOR], [matte((1, 1, 1))], [({"translation": [0, 1, 0]}, {"type": "point"})])
    image = reflected(point(at, (0, 1, 0), (1, 1, 1)), np.ones(3))
    bare("lamp-gltf-candela", one, image, everyone, note="1 cd at 1 m above a white floor: 1/pi straight below")

    axis, inner, outer = (0.4, -1.0, 0.2), 0.3, 0.7
    lamp = {"type": "spot", "color": [0.5, 1.0, 0.75], "intensity": 30.0, "spot": {"innerConeAngle": inner, "outerConeAngle": outer}}
    node = {"translation": [-0.5, 2.0, 0.2], "rotation": turned(axis)}
    image = reflected(point(at, (-0.5, 2.0, 0.2), np.array([0.5, 1.0, 0.75]) * 30, axis, inner, outer))
    bare("lamp-gltf-spot", gltf([FLOOR], [matte()], [(node, lamp)]), image, everyone, note="the squared ramp of KHR_lights_punctual")

    direction = (0.6, -1.0, -0.3)
    lamp = {"type": "directional", "color": [1.0, 0.9, 0.8], "intensity": 5.0}
    document = gltf([FLOOR], [matte()], [({"rotation": turned(direction)}, lamp)])
    image = reflected(parallel(at, direction, np.array([1.0, 0.9, 0.8]) * 5))
    bare("lamp-gltf-directional", document, image, everyone, note="illuminance in lx across the direction")


def beside_others():
    at = floor()
    lamp = {"type": "point", "intensity": 12.0}
    node = {"translation": [0.8, 1.5, 0.5]}
    corner, along, across = (-3.0, 1.5, -0.5), (0.8, 0.0, 0.0), (0.0, 0.0, 1.2)
    document = gltf([FLOOR, quad(corner, along, across)], [matte(), emitter([1.0, 0.5, 0.2], 20.0)], [(node, lamp)])
    image = reflected(point(at, (0.8, 1.5, 0.5), (12,) * 3) + rectangle(at, corner, along, across, (20.0, 10.0, 4.0)))
    bare("lamp-gltf-beside-emissive", document, image, ["path", "direct", "distributed"], spp=128, note="candela beside radiance")
    only = gltf([FLOOR, quad(corner, along, across)], [matte(), emitter([1.0, 0.5, 0.2], 20.0)])
    image = reflected(rectangle(at, corner, along, across, (20.0, 10.0, 4.0)))
    bare("bare-gltf-emissive", only, image, ["path", "direct"], spp=128, note="emissive objects are lights: no studio lights beside them")

    file, held = hdr((0.9, 0.6, 0.4))
    env = ["--env", "env.hdr"]
    document = gltf([FLOOR], [matte()], [(node, lamp)])
    image = reflected(point(at, (0.8, 1.5, 0.5), (12,) * 3) + math.pi * held)
    bare("lamp-gltf-beside-env", document, image, ["path", "direct"], env, {"env.hdr": file}, spp=256, note="candela beside an image")
    image = np.broadcast_to(ALBEDO * held, at[0].shape)
    bare("bare-gltf-env", gltf([FLOOR], [matte()]), image, ["path", "direct"], env, {"env.hdr": file}, spp=256,
         note="with an image around it a bare model gets no studio lights")
    obj = "mtllib m.mtl\nv -60 0 60\nv 60 0 60\nv 60 0 -60\nv -60 0 -60\nusemtl matte\nf 1 2 3 4\n"
    files = {"m.obj": obj, "m.mtl": "newmtl matte\nKd 0.8 0.5 0.2\nillum 1\n", "env.hdr": file}
    view = ["--look-from", "0,9,0", "--look-at", "0,0,0", "--up", "0,0,-1", "--fov", "20"]
    pair("bare-obj-env", "m.obj", files, [*FRAME, *env, *view], image, spp=256, note="as before, by the default integrator")
    files = {"m.obj": obj, "m.mtl": "newmtl matte\nKd 0.8 0.5 0.2\nillum 1\n"}
    lit = np.broadcast_to(ALBEDO * np.array([0.5, 1.0, 2.0]), at[0].shape)
    pair("bare-obj-background-path", "m.obj", files, [*FRAME, *view, "--integrator", "path", "--background", "0.5,1,2"], lit,
         spp=256, note="a background lights the scene under path: no studio lights beside it")


def studio():
    """The studio lights of scenes without lights, as the guide documents them, on a white wall that faces +z."""
    at = (np.zeros((SIZE * SUB, SIZE * SUB, 3)), np.array([0.0, 0.0, 1.0]))
    document = gltf([WALL], [matte(GRAY)], camera="ahead")
    lamps = parallel(at, (0.25, -0.35, -0.9), (0.72 * math.pi,) * 3) + parallel(at, (-1.0, -0.3, -0.6), (0.3 * math.pi,) * 3)
    bottom, top = np.array([0.15, 0.15, 0.15]), np.array([0.24, 0.26, 0.29])
    gradient = sky(at, lambda to: bottom + (top - bottom) * (0.5 + 0.5 * to[..., 1:2]))
    note = "key and fill light, and the backdrop under path or a tenth of the ambient light under whitted"
    bare("bare-gltf-studio", document, reflected(lamps + gradient, GRAY), ["path", "direct", "distributed"], spp=256, note=note)
    bare("bare-gltf-studio", document, reflected(lamps, GRAY) + 0.1 * GRAY, ["whitted"], note=note)
    bare("bare-gltf-dark", document, np.zeros_like(lamps), ["path"], ["--lights", "none", "--background", "black"], note="no light at all")


def pbrt_lamps():
    at = floor(1.0)     # the default screen window
    look = "LookAt 0 9 0  0 0 0  0 0 -1\nCamera \"orthographic\"\n"
    film = f"Film \"rgb\" \"integer xresolution\" {SIZE} \"integer yresolution\" {SIZE}\n"
    ground = (
        "Material \"diffuse\" \"rgb reflectance\" [0.8 0.5 0.2]\n"
        "Shape \"trianglemesh\" \"point3 P\" [-60 0 60  60 0 60  60 0 -60  -60 0 -60] \"integer indices\" [0 1 2 0 2 3]\n"
    )
    # LookAt of pbrt is left-handed: x runs to the left of the image unless the world is mirrored.
    mirror = "Scale -1 1 1\n"

    def lamp(name, light, irradiance, integrators, note="", **kwargs):
        text = mirror + look + film + "WorldBegin\n" + light + "\n" + ground
        for integrator in integrators:
            args = [*FRAME, "--integrator", integrator]
            pair(f"lamp-pbrt-{name}-{integrator}", "ours.pbrt", {"ours.pbrt": text}, args, reflected(irradiance), note=note, **kwargs)

    both = ["path", "whitted"]
    position = (0.3, 1.0, -0.4)
    at_lamp = 'LightSource "point" "point3 from" [0.3 1 -0.4] "rgb I" [20 10 5]'
    lamp("point", at_lamp, point(at, position, (20, 10, 5)), both)
    lamp("point-scale", at_lamp + ' "float scale" 2.5', point(at, position, np.array([20, 10, 5]) * 2.5), ["path"])
    white = 'LightSource "point" "point3 from" [0.3 1 -0.4] "float power" 100'
    lamp("point-power", white, point(at, position, (100 / (4 * math.pi),) * 3), ["path"], "100 lm in all directions")
    distant = 'LightSource "distant" "point3 from" [0 0 0] "point3 to" [0.6 -1 -0.3]'
    lamp("distant", distant + ' "rgb L" [3 2 1]', parallel(at, (0.6, -1, -0.3), (3, 2, 1)), both)
    lamp("distant-illuminance", distant + ' "float illuminance" 4', parallel(at, (0.6, -1, -0.3), (4, 4, 4)), ["path"], "4 lx")
    even = 'LightSource "infinite" "rgb L" [0.5 1 2] "float scale" 2'
    lamp("infinite", even, math.pi * np.broadcast_to([1.0, 2.0, 4.0], at[0].shape), ["path", "direct"], spp=256)


def scene_units():
    """Units in scene files: physical and classical lights beside each other."""
    at = floor()
    text = """(
    camera: (look_from: (0, 9, 0), look_at: (0, 0, 0), up: (0, 0, -1), orthographic: 4.0),
    film: (size: (16, 16)),
    lights: [
        point(position: (0.3, 1, -0.4), intensity: rgb(20, 10, 5), falloff: inverse_square, units: physical),
        spot(position: (-1, 2, 1), direction: (0.4, -1, 0.2), inner: 15, outer: 40, intensity: gray(8), falloff: inverse_square,
            units: physical),
        directional(direction: (0.6, -1, -0.3), intensity: rgb(0.5, 1, 2), units: physical),
        directional(direction: (0.2, -1, 0.3), intensity: rgb(0.1, 0.2, 0.3)),
    ],
    materials: { "matte": diffuse(albedo: rgb(0.8, 0.5, 0.2)) },
    nodes: [(shape: plane(), material: "matte")],
)
"""
    lit = point(at, (0.3, 1, -0.4), (20, 10, 5)) + parallel(at, (0.6, -1, -0.3), (0.5, 1, 2))
    lit = lit + point(at, (-1, 2, 1), (8, 8, 8), (0.4, -1, 0.2), math.radians(15), math.radians(40))
    lit = lit + parallel(at, (0.2, -1, 0.3), np.array([0.1, 0.2, 0.3]) * math.pi)
    for integrator in ("path", "direct", "distributed", "whitted", "caustics"):
        pair(f"lamp-units-{integrator}", "ours.ron", {"ours.ron": text}, ["--integrator", integrator], reflected(lit),
             note="physical and classical lights in one scene")


if __name__ == "__main__":
    gltf_lamps()
    beside_others()
    studio()
    pbrt_lamps()
    scene_units()
