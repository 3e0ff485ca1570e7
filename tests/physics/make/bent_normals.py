#!/usr/bin/env python3
"""References for shading normals that face away from the viewer, by numeric integration. Needs numpy alone.

    python3 bent_normals.py [FOLDER]         writes one folder per pair below ../pairs, or below FOLDER

Convention (docs/FORMATS.md, "Shading normals"):

    n  the interpolated normal, or what a normal map makes of it, unit length, on the side of the viewer's geometric normal g
    n' = n                            if n . wo >= 0
       = normalize(n - (n . wo) wo)   otherwise: perpendicular to the view
    L(wo) = integral of f(wo, wi) L(wi) max(0, n' . wi) over the wi with g . wi > 0; of glass, also of |n' . wi| over the wi
            with n' . wi < 0 and g . wi < 0. A single mirrored direction with g . wi < 0 is mirrored once more, in g.

Nothing of the renderer is used: BSDFs are written down from their papers, and all integrals are midpoint rules.
"""
import json
import os
import struct
import sys
import zlib

import numpy as np

SIZE, BLOCK = 32, 8
HALF = 8.0  # of the side of the wall
DISTANCE = 40.0
HEIGHT = 2.0  # of the orthographic view


def unit(v):
    v = np.asarray(v, float)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def dot(a, b):
    return (a * b).sum(-1)


# ---- Geometry: a wall in z = 0 that faces +z, seen by an orthographic camera from the direction wo.


def image_points(wo, per_pixel, up=(0.0, 1.0, 0.0)):
    """Points of the camera plane through the origin, [rows, columns, samples, 3]; samples are the centres of a grid."""
    right = unit(np.cross(-wo, up))
    above = np.cross(right, -wo)
    at = (np.arange(SIZE * per_pixel) + 0.5) / per_pixel - SIZE / 2
    x, y = np.meshgrid(at, -at)
    grid = (x[..., None] * right + y[..., None] * above) * (HEIGHT / SIZE)
    grid = grid.reshape(SIZE, per_pixel, SIZE, per_pixel, 3).swapaxes(1, 2)
    return grid.reshape(SIZE, SIZE, per_pixel**2, 3)


def wall_points(wo, per_pixel):
    p = image_points(wo, per_pixel)
    return p - wo * (p[..., 2:] / wo[2])


def wall_normals(points, corners):
    """Normals interpolated over the triangles (0, 1, 2) and (0, 2, 3) of the corners (-,-), (+,-), (+,+), (-,+)."""
    c = unit(corners)
    s, t = (points[..., 0] / HALF + 1) / 2, (points[..., 1] / HALF + 1) / 2
    assert s.min() > 0 and s.max() < 1 and t.min() > 0 and t.max() < 1
    s, t = s[..., None], t[..., None]
    lower = c[0] * (1 - s) + c[1] * (s - t) + c[2] * t
    upper = c[0] * (1 - t) + c[2] * s + c[3] * (t - s)
    return unit(np.where(s >= t, lower, upper))


def bent(n, wo):
    facing = dot(n, wo)[..., None]
    return unit(np.where(facing < 0, n - facing * wo, n))


def frames(n):
    """Two tangents of unit normals."""
    helper = np.where(np.abs(n[..., :1]) < 0.6, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    x = unit(np.cross(helper, n))
    return x, np.cross(n, x)


# ---- BSDFs for wo, wi and n of matching shapes, without the cosine.


def lambert(albedo):
    return lambda wo, wi, n: np.broadcast_to(np.asarray(albedo) / np.pi, dot(wi, n).shape + (3,))


def ggx_d(cos, alpha):
    """Trowbridge, Reitz 1975."""
    return alpha**2 / (np.pi * (cos * cos * (alpha**2 - 1) + 1) ** 2)


def smith_lambda(cos, alpha):
    return (np.sqrt(1 + alpha**2 * (1 / (cos * cos) - 1)) - 1) / 2


def metal(base, roughness):
    """glTF 2.0, appendix B.2, fully metallic, with Smith's height-correlated masking (Heitz 2014)."""
    alpha = roughness**2

    def f(wo, wi, n):
        h = unit(wo + wi)
        # The limit at n . wo = 0 is finite; stay a hair beside it.
        co, ci = np.maximum(dot(wo, n), 1e-7), np.maximum(dot(wi, n), 1e-12)
        g = 1 / (1 + smith_lambda(co, alpha) + smith_lambda(ci, alpha))
        fresnel = np.asarray(base) + (1 - np.asarray(base)) * ((1 - np.clip(dot(wo, h), 0, 1)) ** 5)[..., None]
        return fresnel * (ggx_d(dot(n, h), alpha) * g / (4 * co * ci))[..., None]

    return f


def fresnel_dielectric(ci, eta):
    """Unpolarised, for the cosine of incidence; eta is the index beyond the surface over that before it."""
    sin2 = (1 - ci * ci) / eta**2
    ct = np.sqrt(np.maximum(1 - sin2, 0))
    sums = np.maximum(ci + eta * ct, 1e-300), np.maximum(eta * ci + ct, 1e-300)
    s, p = (ci - eta * ct) / sums[0], (eta * ci - ct) / sums[1]
    return np.where(sin2 >= 1, 1.0, (s * s + p * p) / 2)


def glass(eta, roughness):
    """Walter et al. 2007, of radiance: transmission is divided by eta^2. `eta` is the index beyond over that before."""
    alpha = roughness**2

    def f(wo, wi, n):
        co, ci = np.maximum(dot(wo, n), 1e-7), dot(wi, n)
        reflects = ci > 0
        m = unit(np.where(reflects[..., None], wo + wi, wo + eta * wi))
        m = np.where(dot(m, n)[..., None] < 0, -m, m)
        om, im, ac = dot(wo, m), dot(wi, m), np.maximum(np.abs(ci), 1e-12)
        fr = fresnel_dielectric(np.clip(om, 0, 1), eta)
        lo, li = smith_lambda(co, alpha), smith_lambda(ac, alpha)
        d = ggx_d(dot(n, m), alpha)
        reflected = fr * d / ((1 + lo + li) * 4 * co * ac)
        # Masking and shadowing by the two sides apart (Walter et al., equation 23).
        passes = (om > 0) & (im < 0)
        stretch = np.where(passes, (om + eta * im) ** 2, 1.0)
        transmitted = (1 - fr) * d / ((1 + lo) * (1 + li)) * np.abs(om * im) / (co * ac * stretch)
        value = np.where(reflects, reflected, np.where(passes, transmitted, 0.0))
        return np.repeat(value[..., None], 3, -1)

    return f


# ---- Light.


class Sky:
    """Radiance from `bottom` straight down to `top` straight up, linear in y."""

    def __init__(self, bottom, top):
        self.bottom, self.top = np.asarray(bottom, float), np.asarray(top, float)

    def radiance(self, w):
        return self.bottom + (self.top - self.bottom) * (0.5 + 0.5 * w[..., 1:2])

    def text(self):
        return "background:gradient(bottom:rgb%s,top:rgb%s)," % (triple(self.bottom), triple(self.top))


class Sun:
    """A directional light; a classical light counts pi times for BSDFs."""

    def __init__(self, towards, intensity, casts_shadows=True):
        self.towards, self.intensity, self.casts_shadows = unit(towards), np.asarray(intensity, float), casts_shadows

    def reflected(self, f, wo, n, g):
        ci = dot(n, self.towards)
        lit = (ci > 0) & (dot(g, self.towards) > 0)
        wi = np.broadcast_to(self.towards, n.shape)
        return np.where(lit[..., None], f(np.broadcast_to(wo, n.shape), wi, n) * (ci * np.pi)[..., None] * self.intensity, 0.0)

    def text(self):
        shadows = "" if self.casts_shadows else ",casts_shadows:false"
        return "directional(direction:%s,intensity:rgb%s%s)," % (triple(-self.towards), triple(self.intensity), shadows)


class Quad:
    """A rectangular light in a plane z = const above the wall that shines down."""

    def __init__(self, corner, width, height, radiance):
        self.corner, self.width, self.height = np.asarray(corner, float), width, height
        self.radiance = np.asarray(radiance, float)

    def reflected(self, f, wo, points, n, g, steps=64):
        total = np.zeros(n.shape)
        at = (np.arange(steps) + 0.5) / steps
        for s in at:
            for t in at:
                d = self.corner + [s * self.width, t * self.height, 0.0] - points
                r2 = dot(d, d)
                wi = d / np.sqrt(r2)[..., None]
                ci = np.where(dot(g, wi) > 0, np.maximum(dot(n, wi), 0), 0.0)
                geometry = ci * wi[..., 2] / r2
                total += f(np.broadcast_to(wo, n.shape), wi, n) * geometry[..., None]
        return total * self.radiance * (self.width * self.height / steps**2)

    def text(self):
        edges = "((0.0, %r, 0.0), (%r, 0.0, 0.0))" % (self.height, self.width)
        return "quad(corner:%s,edges:%s,radiance:rgb%s)," % (triple(self.corner), edges, triple(self.radiance))


def triple(v):
    return "(%s)" % ", ".join(repr(float(x)) for x in v)


def sky_reflected(f, sky, wo, n, g, transmits=False, steps=(160, 320)):
    """Light of the sky that surfaces with the shading normals n (viewer's side, bent) send to wo; n: [points, 3]."""
    cos = (np.arange(steps[0]) + 0.5) / steps[0]
    phi = (np.arange(steps[1]) + 0.5) / steps[1] * 2 * np.pi
    cos, phi = (a.ravel() for a in np.meshgrid(cos, phi))
    sin = np.sqrt(1 - cos * cos)
    local = np.stack([sin * np.cos(phi), sin * np.sin(phi), cos], -1)
    total = np.empty(n.shape)
    for i, normal in enumerate(n):
        x, y = frames(normal)
        # Midpoints of a grid in the cosine and the azimuth.
        wis = [local @ np.stack([x, y, normal])]
        if transmits:
            wis.append((local * [1, 1, -1]) @ np.stack([x, y, normal]))
        total[i] = 0
        for wi, side in zip(wis, (1, -1)):
            kept = dot(wi, g) * side > 0
            many = np.broadcast_to(normal, wi.shape)
            value = f(np.broadcast_to(wo, wi.shape), wi, many) * sky.radiance(wi) * cos[:, None]
            total[i] += 2 * np.pi * np.where(kept[:, None], value, 0.0).mean(0)
    return total


# ---- Pairs.

VIEW = unit([0.95, 0.12, 0.24])
AWAY = [(-0.8, 0.1, 0.6), (-0.7, 0.3, 0.5), (-0.6, -0.2, 0.7), (-0.8, 0.0, 0.4)]
TURNING = [(-0.9, 0.1, 0.6), (0.5, 0.2, 0.8), (0.4, -0.3, 0.9), (-0.8, -0.1, 0.5)]
# Far above: shadow rays start where normals suggest the smooth surface, which is units above so large triangles.
LAMP = Quad((-25.0, -10.0, 20.0), 30.0, 20.0, (2, 3, 4))
SKY = Sky((0.2, 0.5, 1.0), (1.0, 0.6, 0.1))


def scene(wo, lights, material, nodes, integrator="path", depth=0, background=""):
    look_from = wo * DISTANCE
    return (
        "(\n"
        f" camera:(look_from:{triple(look_from)},look_at:(0.0, 0.0, 0.0),up:(0.0, 1.0, 0.0),orthographic:{HEIGHT}),\n"
        f" film:(size:({SIZE},{SIZE})),\n"
        f" settings:(integrator:{integrator},sampler:sobol,depth:{depth}),\n"
        f" {background}\n"
        f" lights:[{lights}],\n"
        f" materials:{{{material}}},\n"
        f" nodes:[{nodes}],\n"
        ")\n"
    )


def wall(corners):
    points = [(-HALF, -HALF, 0), (HALF, -HALF, 0), (HALF, HALF, 0), (-HALF, HALF, 0)]
    return "(shape:mesh(positions:[%s],triangles:[(0, 1, 2), (0, 2, 3)],normals:[%s]),material:\"m\")" % (
        ", ".join(triple(p) for p in points),
        ", ".join(triple(n) for n in corners),
    )


def block_means(values):
    """[rows, columns, samples, 3] to [blocks, blocks, 3]."""
    n = SIZE // BLOCK
    return values.mean(2).reshape(n, BLOCK, n, BLOCK, 3).mean((1, 3))


def write(root, name, text, means, note, tol, atol=0.0, spp=64, seeds=8, files=()):
    folder = os.path.join(root, name)
    os.makedirs(folder, exist_ok=True)
    pair = dict(name=name, scene="ours.ron", args=[], spp=spp, seeds=seeds, block=BLOCK, tol=tol, atol=atol, note=note,
                expect="agree", kind="numeric", first_seed=24_000)
    flat = [float("%.9g" % x) for x in np.asarray(means).ravel()]
    reference = dict(shape=list(np.shape(means)), mean=flat, stderr=[0.0] * len(flat))
    for file, content in [("ours.ron", text), ("pair.json", json.dumps(pair, indent=1) + "\n"),
                          ("ref.json", json.dumps(reference) + "\n"), *files]:
        with open(os.path.join(folder, file), "wb" if isinstance(content, bytes) else "w") as out:
            out.write(content)
    print(f"{name}: mean {np.asarray(means).mean((0, 1))}", flush=True)


def lit_wall(root, name, corners, material, f, note, suns=(), quads=(), sky=None, wo=VIEW, transmits=False,
             integrator="path", per_pixel=2, tol=1e-3, atol=0.0):
    points = wall_points(wo, per_pixel)
    g = np.array([0.0, 0.0, 1.0 if wo[2] > 0 else -1.0])
    n = bent(wall_normals(points, corners) * g[2], wo)
    value = np.zeros(points.shape)
    for sun in suns:
        value += sun.reflected(f, wo, n, g)
    for quad in quads:
        value += quad.reflected(f, wo, points, n, g)
    if sky is not None:
        # The normals change slowly: the centres of squares of 2 by 2 pixels are enough.
        step = 2
        at = image_points(wo, 1)[:, :, 0]
        at = at.reshape(SIZE // step, step, SIZE // step, step, 3).mean((1, 3))
        at = at - wo * (at[..., 2:] / wo[2])
        normals = bent(wall_normals(at, corners) * g[2], wo)
        light = sky_reflected(f, sky, wo, normals.reshape(-1, 3), g, transmits).reshape(at.shape)
        value += np.repeat(np.repeat(light, step, 0), step, 1)[:, :, None, :]
    lights = "".join(light.text() for light in (*suns, *quads))
    text = scene(wo, lights, f'"m":{material}', wall(corners), integrator, background=sky.text() if sky else "")
    write(root, name, text, block_means(value), note, tol, atol)


def bent_mirror(root):
    points = wall_points(VIEW, 2)
    g = np.array([0.0, 0.0, 1.0])
    n = bent(wall_normals(points, TURNING), VIEW)
    wi = 2 * dot(n, VIEW)[..., None] * n - VIEW
    wi = np.where(wi[..., 2:] < 0, wi * [1, 1, -1], wi)
    text = scene(VIEW, "", '"m":mirror(reflectance:rgb(0.9, 0.8, 0.7))', wall(TURNING), depth=1, background=SKY.text())
    write(root, "bent-mirror-sky", text, block_means(SKY.radiance(wi) * [0.9, 0.8, 0.7]),
          "mirrored directions stay above the surface", 1e-3)


def png(pixel, side=4):
    """A PNG of one colour."""
    rows = (b"\0" + bytes(pixel) * side) * side

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def normal_map(root, name, pixel, wo, note):
    """A flat wall with a normal map of one colour, u along x and v along y."""
    g = np.array([0.0, 0.0, 1.0])
    n = bent(unit(np.array(pixel) / 127.5 - 1), wo)
    f = lambert((0.8, 0.8, 0.8))
    sun = Sun((-0.3, 0.5, 0.9), (0.6, 0.5, 0.4))
    value = sun.reflected(f, wo, n, g) + sky_reflected(f, SKY, wo, n[None], g, steps=(512, 1024))[0]
    h = repr(HALF)
    obj = (f"mtllib wall.mtl\nv -{h} -{h} 0\nv {h} -{h} 0\nv {h} {h} 0\nv -{h} {h} 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
           "vn 0 0 1\nusemtl m\nf 1/1/1 2/2/1 3/3/1 4/4/1\n")
    mtl = "newmtl m\nKa 0 0 0\nKd 0.8 0.8 0.8\nKs 0 0 0\nnorm map.png\n"
    text = scene(wo, sun.text(), "", '(model:"wall.obj")', background=SKY.text())
    means = np.broadcast_to(value, (SIZE // BLOCK, SIZE // BLOCK, 3))
    write(root, name, text, means, note, 1e-3, files=[("wall.obj", obj), ("wall.mtl", mtl), ("map.png", png(pixel))])


def ball_mesh(around=12, high=6):
    """Vertices of a unit ball, which are its normals as well, and triangles that run counter-clockwise from outside."""
    points, triangles = [(0.0, 1.0, 0.0)], []
    for j in range(1, high):
        theta = np.pi * j / high
        for i in range(around):
            phi = 2 * np.pi * i / around
            points.append((np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)))
    points.append((0.0, -1.0, 0.0))
    at = lambda j, i: 1 + (j - 1) * around + i % around
    for i in range(around):
        triangles.append((0, at(1, i), at(1, i + 1)))
        triangles.append((len(points) - 1, at(high - 1, i + 1), at(high - 1, i)))
        for j in range(1, high - 1):
            a, b, c, d = at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)
            triangles += [(a, b, c), (a, c, d)]
    return np.round(np.array(points), 6) + 0.0, triangles


def ball(root):
    """A convex ball of few faces: all of the sky above a face is seen from it, and no face shadows another."""
    wo, per_pixel, albedo = unit([0.2, 0.35, 1.0]), 8, np.array([0.8, 0.6, 0.4])
    vertices, triangles = ball_mesh()
    sun = Sun((0.7, 0.5, 0.4), (0.5, 0.5, 0.6))
    sky = np.array([0.5, 0.6, 0.8])
    points = image_points(wo, per_pixel)
    value, depth = np.broadcast_to(sky, points.shape).copy(), np.full(points.shape[:-1], -np.inf)
    normals = unit(vertices)
    for triangle in triangles:
        a, b, c = vertices[list(triangle)]
        g = np.cross(b - a, c - a)
        if g @ wo <= 0:
            continue
        height = (a - points) @ g / (wo @ g)
        hit = points + height[..., None] * wo
        weights = np.stack([np.cross(c - b, hit - b) @ g, np.cross(a - c, hit - c) @ g, np.cross(b - a, hit - a) @ g], -1)
        weights /= g @ g
        seen = (weights.min(-1) >= 0) & (height > depth)
        n = bent(unit(weights @ normals[list(triangle)]), wo)
        g = unit(g)
        # The part of white light that comes from above two planes at an angle, by the cosine to one: (1 + cos) / 2.
        light = albedo * (sky * ((1 + n @ g) / 2)[..., None])
        light = light + sun.reflected(lambert(albedo), wo, n, g)
        value[seen], depth[seen] = light[seen], height[seen]
    mesh = "(shape:mesh(positions:[%s],triangles:[%s],normals:[%s]),material:\"m\")" % (
        ", ".join(map(triple, vertices)), ", ".join(str(t) for t in triangles), ", ".join(map(triple, vertices)))
    text = scene(wo, sun.text(), f'"m":diffuse(albedo:rgb{triple(albedo)})', mesh, background=f"background:constant(rgb{triple(sky)}),")
    write(root, "bent-ball-of-few-faces", text, block_means(value), "silhouettes of a smooth ball of 120 triangles", 3e-3)


def main(root):
    diffuse, f = 'diffuse(albedo:rgb(0.9, 0.7, 0.5))', lambert((0.9, 0.7, 0.5))
    sun = Sun((-0.2, 0.5, 0.8), (0.6, 0.5, 0.4))
    behind = [Sun((-0.6, 0.5, -0.3), (1, 1, 1)), Sun((-0.8, -0.1, -0.5), (1, 1, 1), casts_shadows=False)]
    lit_wall(root, "bent-diffuse-sun", AWAY, diffuse, f, "all normals face away from the viewer", [sun], tol=1e-4)
    lit_wall(root, "bent-diffuse-sun-distributed", AWAY, diffuse, f, "the same under another integrator", [sun],
             integrator="distributed", tol=1e-4)
    lit_wall(root, "bent-diffuse-sun-whitted", AWAY, "phong(ambient:gray(0),diffuse:rgb(0.9, 0.7, 0.5))", f,
             "the same under another integrator", [sun], integrator="whitted", tol=1e-4)
    lit_wall(root, "bent-diffuse-turning-sun-and-sky", TURNING, diffuse, f, "normals turn away in the middle", [sun], sky=SKY)
    lit_wall(root, "bent-diffuse-lamp", TURNING, diffuse, f, "a lamp partly behind the bent normals",
             quads=[LAMP], tol=2e-3)
    lit_wall(root, "bent-metal-sky", TURNING, "metallic_roughness(base_color:rgb(0.9, 0.6, 0.3),metallic:1,roughness:0.6)",
             metal((0.9, 0.6, 0.3), 0.6), "microfacets at a cosine of 0", sky=SKY)
    lit_wall(root, "bent-metal-lamp", TURNING, "metallic_roughness(base_color:rgb(0.9, 0.6, 0.3),metallic:1,roughness:0.5)",
             metal((0.9, 0.6, 0.3), 0.5), "drawn and found light of the same lamp",
             quads=[LAMP], tol=3e-3)
    lit_wall(root, "bent-glass-outside", TURNING, "glass(ior:1.5,roughness:0.6)", glass(1.5, 0.6),
             "the index of refraction is not inverted", sky=SKY, transmits=True)
    lit_wall(root, "bent-glass-inside", TURNING, "glass(ior:1.5,roughness:0.6)", glass(1 / 1.5, 0.6),
             "the same from inside", sky=SKY, transmits=True, wo=unit([-0.9, 0.1, -0.3]))
    lit_wall(root, "bent-wall-lit-from-behind", AWAY, diffuse, f, "no light passes an opaque wall", behind,
             quads=[], tol=0.0)
    bent_mirror(root)
    normal_map(root, "bent-normal-map-grazing", (28, 160, 180), unit([0.97, 0.05, 0.22]), "a normal map that faces away from the viewer")
    normal_map(root, "bent-normal-map-facing", (190, 100, 210), VIEW, "a normal map that faces the viewer")
    ball(root)


if __name__ == "__main__":
    here = os.path.dirname(os.path.abspath(__file__))
    main(sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(here), "pairs"))
