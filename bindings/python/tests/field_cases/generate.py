"""Writes cases.json: rays that programs have answered wrongly, with the exact answers.

    python bindings/python/tests/field_cases/generate.py

Each case is built from the description of a reported problem; `source` names the thread. Answers are
computed by `exact.py` from the numbers as they are stored, and checked against what each case is known to have to give.
"""

import json
import math
from fractions import Fraction
from pathlib import Path

import exact

CASES = []

#: For programs that round: barycentric weights up to this size are on the border of a triangle, if differences between vertices
#: and the origin of the ray have to be rounded: by 2⁻⁵³ of a distance that is a few times the triangle.
SLACK = Fraction(1, 2**50)


def case(name, source, risk, vertices, faces, rays, *, single=False, t_min=0.0, t_max=math.inf, hits_per_ray=None):
    """Adds a case. `single` rounds the vertices to single precision; `hits_per_ray` is what the answers have to be."""
    if single:
        import struct

        vertices = [[struct.unpack("f", struct.pack("f", number))[0] for number in vertex] for vertex in vertices]
    vertices = [[float(number) for number in vertex] for vertex in vertices]
    answers = []
    for origin, direction in rays:
        hits, border = exact.all_hits(vertices, faces, origin, direction, t_min, t_max, SLACK)
        exact_hits, _ = exact.all_hits(vertices, faces, origin, direction, t_min, t_max, Fraction(0))
        answers.append({
            "exact": sorted(index for _, index in exact_hits),
            "t": [float(t) for t, _ in hits],
            "primitive": [index for _, index in hits],
            "border_t": [float(t) for t, _ in border],
            "border": [index for _, index in border],
        })
    counts = [len(answer["t"]) + len(answer["border"]) for answer in answers]
    if hits_per_ray is not None:
        expected = [hits_per_ray] * len(rays) if isinstance(hits_per_ray, int) else list(hits_per_ray)
        assert counts == expected, f"{name}: {counts}, not {expected}"
    numbers = {
        "name": name,
        "source": source,
        "risk": risk,
        "vertices": vertices,
        "faces": [list(face) for face in faces],
        "rays": [[[float(x) for x in origin], [float(x) for x in direction]] for origin, direction in rays],
        "t_min": t_min,
        "t_max": None if t_max == math.inf else t_max,
        "hits": answers,
    }
    assert all(other["name"] != name for other in CASES)
    CASES.append(numbers)


def grid(n, size=1.0, z=0.0, offset=(0.0, 0.0, 0.0)):
    """Square of n by n cells in the plane z, from 0 to `size`."""
    x0, y0, z0 = offset
    vertices = [[x0 + size * i / n, y0 + size * j / n, z0 + z] for i in range(n + 1) for j in range(n + 1)]
    faces = []
    for i in range(n):
        for j in range(n):
            a, b = i * (n + 1) + j, (i + 1) * (n + 1) + j
            faces += [[a, b, b + 1], [a, b + 1, a + 1]]
    return vertices, faces


def box(low, high, n=1):
    """Closed box with n by n cells on each side; vertices are shared by position only."""
    vertices, faces = [], []
    for axis in range(3):
        for side in (low, high):
            first = len(vertices)
            for i in range(n + 1):
                for j in range(n + 1):
                    vertex = [0.0, 0.0, 0.0]
                    vertex[axis] = side[axis]
                    for k, step in ((1, i), (2, j)):
                        m = (axis + k) % 3
                        vertex[m] = low[m] + (high[m] - low[m]) * step / n
                    vertices.append(vertex)
            for i in range(n):
                for j in range(n):
                    a, b = first + i * (n + 1) + j, first + (i + 1) * (n + 1) + j
                    faces += [[a, b, b + 1], [a, b + 1, a + 1]]
    return vertices, faces


def shifted(vertices, offset):
    return [[x + d for x, d in zip(vertex, offset)] for vertex in vertices]


def towards(origin, targets):
    return [(origin, [t - o for t, o in zip(target, origin)]) for target in targets]


def add_edges_and_vertices():
    vertices, faces = box([-1, -1, -1], [1, 1, 1], 4)
    corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    case("corners of a box from its centre", "trimesh #2317", "A ray through a corner slips out.", vertices, faces,
         towards([0, 0, 0], corners))
    middles = [[1, y / 2, z / 2] for y in range(-2, 3) for z in range(-2, 3)]
    case("vertices of a subdivided side from within", "trimesh #1496", "A ray through a vertex of the grid slips out.",
         vertices, faces, towards([0.1, 0.2, 0.3], middles))
    edges = [[1, y / 8, z / 4] for y in range(-7, 8, 2) for z in range(-3, 4)]
    case("edges of a subdivided side from within", "trimesh #1919", "A ray through an edge slips out.", vertices, faces,
         towards([0, 0, 0], edges))
    flat, flat_faces = grid(4)
    case("a ray straight down on a vertex of six triangles", "three-mesh-bvh #169", "The vertex is missed, or hit once.", flat,
         flat_faces, [([0.5, 0.5, 1], [0, 0, -1])], hits_per_ray=6)
    case("rays straight down on the diagonals of a grid", "trimesh #1766", "The common edge of two triangles is missed.",
         flat, flat_faces, [([(i + 0.5) / 4, (i + 0.5) / 4, 1], [0, 0, -1]) for i in range(4)], hits_per_ray=2)
    case("rays straight down on the border of a sheet", "trimesh #263", "The border does not belong to the sheet.", flat,
         flat_faces, [([i / 4 + 0.125, 0, 1], [0, 0, -1]) for i in range(4)], hits_per_ray=1)
    tenths, tenths_faces = grid(10)
    case("vertices at tenths, which no binary number holds", "trimesh #457",
         "The vertices are rounded, and the rays aim at other numbers.", tenths, tenths_faces,
         [([i / 10, j / 10, 1], [0, 0, -1]) for i in range(1, 10, 2) for j in range(1, 10, 2)])
    fan = [[0, 0, 0]] + [[math.cos(k * math.pi / 16), math.sin(k * math.pi / 16), 0] for k in range(32)]
    case("the tip of a fan of 32 triangles", "embree #174", "The tip is missed, or one of its triangles.", fan,
         [[0, k + 1, (k + 1) % 32 + 1] for k in range(32)], [([0.3, -0.2, 2], [-0.3, 0.2, -2])], hits_per_ray=32)


def add_parallel_and_grazing():
    vertices, faces = box([0, 0, 0], [1, 1, 1], 2)
    case("rays along an axis within a side of a box", "embree #589", "A ray in the plane of a side gives NaN or no hit.",
         vertices, faces, [([-1, y, 0], [1, 0, 0]) for y in (0.25, 0.5, 0.75)])
    case("a ray along an edge of a box", "svenstaro/bvh #140", "A ray along an edge gives NaN or no hit.", vertices, faces,
         [([-1, 0, 0], [1, 0, 0]), ([2, 1, 1], [-1, 0, 0])])
    case("directions with negative zeros", "embree #589", "The sign of a zero turns a box inside out.", vertices, faces,
         [([0.3, 0.6, -1], [-0.0, -0.0, 1]), ([0.3, 0.6, 2], [0.0, -0.0, -1]), ([-1, 0.3, 0.6], [1, -0.0, 0.0])],
         hits_per_ray=2)
    flat, flat_faces = grid(4)
    case("rays that graze a sheet at a millionth of its size", "embree #387", "The hit is lost or far from the sheet.", flat,
         flat_faces, [([-1, 0.3, 1e-6], [1, 0, -1e-6 / 1.6]), ([-1, 0.3, 1e-9], [1, 0, -1e-9 / 1.6])], hits_per_ray=1)
    case("rays that start in the plane of a sheet and stay there", "embree #298", "A hit edge-on has no parameter.", flat,
         flat_faces, [([-1, 0.3, 0], [1, 0, 0]), ([0.5, 0.3, 0], [0, 1, 0])], hits_per_ray=0)
    case("the smallest direction and the largest", "", "The reciprocal of the direction overflows.", flat, flat_faces,
         [([0.3, 0.6, 1], [0, 0, -1e-300]), ([0.3, 0.6, 1], [0, 0, -1e300])], hits_per_ray=1)


def add_scales():
    small, small_faces = box([-0.0005] * 3, [0.0005] * 3, 2)
    town = shifted(small, [4321.0, -1234.0, 987.0])
    case("a box of a millimetre in a scene of kilometres", "Open3D #5777", "The box is smaller than the rounding of positions.",
         town, small_faces, [([4321.0002, -1234.0001, 990.0], [0, 0, -1]), ([4320.0, -1234.0001, 987.0002], [1, 0, 0])],
         hits_per_ray=2)
    far, far_faces = grid(4, offset=(1e7, -1e7, 1e7))
    case("a unit square ten million units away from the origin", "Open3D #5777",
         "Single precision has steps of one unit there.", far, far_faces,
         [([1e7 + x, -1e7 + y, 1e7 + 2], [0, 0, -1]) for x in (0.1, 0.3, 0.9) for y in (0.2, 0.7)], hits_per_ray=1)
    unit, unit_faces = box([-1, -1, -1], [1, 1, 1], 2)
    case("a ray that starts a hundred million units away", "trimesh #1338", "The distance swallows the size of the box.", unit,
         unit_faces, [([0.3, 0.4, 1e8], [0, 0, -1]), ([1e8, 0.3, 0.4], [-1, 0, 0])], hits_per_ray=2)
    long = [[0, 0, 0], [1e6, 0, 0], [1e6, 1e-3, 0]]
    case("a sliver of a million by a thousandth", "embree #387", "Barycentric coordinates of a sliver are noise.", long,
         [[0, 1, 2]], [([5e5, 2.5e-4, 1], [0, 0, -1]), ([9e5, 8e-4, 1], [0, 0, -1]), ([5e5, 6e-4, 1], [0, 0, -1])],
         hits_per_ray=[1, 1, 0])
    tiny, tiny_faces = box([-1e-15] * 3, [1e-15] * 3)
    case("a box of a millionth of a nanometre", "trimesh #331", "An absolute epsilon swallows the box.", tiny, tiny_faces,
         [([3e-16, 2e-16, 1e-14], [0, 0, -1]), ([-1e-14, 3e-16, 2e-16], [1, 0, 0])], hits_per_ray=2)
    huge, huge_faces = box([-1e15] * 3, [1e15] * 3)
    case("a box of the size of a light year in kilometres", "embree #416", "The limit of the far plane cuts it off.", huge,
         huge_faces, [([3e14, 2e14, 1e16], [0, 0, -1])], hits_per_ray=2)


def add_coincidence():
    vertices, faces = grid(2)
    case("each face twice", "embree #188", "Only one of two equal faces is reported.", vertices, faces + faces,
         [([0.3, 0.1, 1], [0, 0, -1]), ([0.9, 0.6, 1], [0, 0, -1])], hits_per_ray=2)
    case("each face twice, turned around", "embree #188", "The back face is reported once more or not at all.", vertices,
         faces + [[a, c, b] for a, b, c in faces], [([0.3, 0.1, 1], [0, 0, -1])], hits_per_ray=2)
    layers, layer_faces = [], []
    for k in range(40):
        sheet, sheet_faces = grid(1, z=-k / 64)
        layer_faces += [[i + len(layers) for i in face] for face in sheet_faces]
        layers += sheet
    case("forty sheets in order", "trimesh #457", "Hits are out of order, or the list ends early.", layers, layer_faces,
         [([0.75, 0.25, 1], [0, 0, -1]), ([0.75, 0.25, -2], [0, 0, 1])], hits_per_ray=40)
    near = [[x, y, z] for z in (0, 2.0**-40) for x, y in ((0, 0), (1, 0), (0, 1))]
    case("two sheets a millionth of a millionth apart", "embree #188",
         "Stepping past a hit by an epsilon skips the second sheet.", near, [[0, 1, 2], [3, 4, 5]],
         [([0.25, 0.25, 1], [0, 0, -1]), ([0.25, 0.25, -1], [0, 0, 1])], hits_per_ray=2)
    wall, wall_faces = box([0, 0, 0], [1, 1, 1])
    next_wall, next_faces = box([1, 0, 0], [2, 1, 1])
    case("two boxes that share a side", "embree #188", "One of the two walls at the same place is lost.",
         wall + next_wall, wall_faces + [[i + len(wall) for i in face] for face in next_faces],
         [([-1, 0.3, 0.6], [1, 0, 0]), ([3, 0.3, 0.6], [-1, 0, 0])], hits_per_ray=4)


def add_limits_and_degenerate():
    vertices, faces = box([-1, -1, -1], [1, 1, 1])
    inside = [([0, 0.25, 0.5], [1, 0, 0])]
    case("a hit exactly at the end of the ray", "embree #423", "The end of the ray does not belong to it.", vertices, faces,
         inside, t_max=1.0, hits_per_ray=1)
    case("a hit one rounding step beyond the end of the ray", "embree #423", "The end of the ray is rounded up.", vertices,
         faces, inside, t_max=math.nextafter(1.0, 0.0), hits_per_ray=0)
    case("a hit exactly at the start of the ray", "embree #133", "A ray that starts on a surface misses it.", vertices, faces,
         [([1, 0.25, 0.5], [1, 0, 0]), ([1, 0.25, 0.5], [-1, 0, 0])], hits_per_ray=[1, 2])
    case("a ray that starts one rounding step beyond a surface", "trimesh #331", "It hits the surface that it has left.",
         vertices, faces, [([math.nextafter(1.0, 2.0), 0.25, 0.5], [1, 0, 0]), ([math.nextafter(1.0, 0.0), 0.25, 0.5], [1, 0, 0])],
         hits_per_ray=[0, 1])
    case("triangles that are points and lines among good ones", "", "A triangle without area gives NaN or shifts ids.",
         [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.5, 0.5, 0]],
         [[0, 0, 0], [0, 3, 4], [0, 1, 2], [1, 1, 2], [1, 3, 2]],
         [([0.2, 0.2, 1], [0, 0, -1]), ([0.8, 0.8, 1], [0, 0, -1]), ([0.5, 0.5, 1], [0, 0, -1])], hits_per_ray=[1, 1, 2])
    case("triangles seen from both sides", "", "Triangles are culled from the back.", *grid(1),
         [([0.6, 0.3, 1], [0, 0, -1]), ([0.6, 0.3, -1], [0, 0, 1])], hits_per_ray=1)


def add_reported_numbers():
    """Cases whose numbers are those of the thread."""
    small, small_faces = box([-20] * 3, [20] * 3, 2)
    big, _ = box([-30] * 3, [30] * 3, 3)
    targets = sorted({tuple(vertex) for vertex in big})
    case("from the centre of a box of 40 to the vertices of one of 60", "trimesh #1496",
         "Whether and what a ray hits are two answers.", small, small_faces, towards([0, 0, 0], targets))
    square = [[-1, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0]]
    case("the middle of a square of two triangles", "trimesh #1766", "The ray passes between the triangles.", square,
         [[0, 1, 2], [2, 3, 0]], [([0, 0, 1], [0, 0, -1])], hits_per_ray=2)
    quad = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]]
    case("a slanted ray at the diagonal of a square", "Oblikovati #2146", "Rounding puts the ray outside of both triangles.", quad,
         [[0, 1, 2], [0, 2, 3]], [([0, 0, 10], [0.30458447, 0.30458447, -0.9024725])], hits_per_ray=2)
    wall = [[-1.3836679458618164, -4.480311870574951, 10], [3.9273109436035156, 5.897944450378418, 8],
            [-1.3836679458618164, -4.480311870574951, 8]]
    rays = [([-0.028221702575683627, -2.5058889150619503 - k / 1000, 8], [-0.16852837373762, 0.9856968028990217, 0])
            for k in range(3)]
    case("rays at the lower edge of a wall, in its height", "three-mesh-bvh #684", "The edge is hit by chance.", wall, [[0, 1, 2]],
         rays, hits_per_ray=1)
    corners = [[x, y, z] for z in (1.6, 14.4) for y in (1.6, 14.4) for x in (1.6, 14.4)]
    cube = [[2, 1, 0], [1, 2, 3], [4, 2, 0], [2, 4, 6], [1, 4, 0], [4, 1, 5], [6, 5, 7], [5, 6, 4], [3, 6, 7], [6, 3, 2],
            [5, 3, 7], [3, 5, 1]]
    case("rays along an axis through a cube from 1.6 to 14.4", "fcpw #14", "Rays on the diagonal of a side are missed.", corners,
         cube, [([1, 8, 11.5], [1, 0, 0]), ([1, 8, 8], [1, 0, 0]), ([15, 4.5, 11.5], [-1, 0, 0])])
    unit, unit_faces = box([0, 0, 0], [1, 1, 1])
    around = [([2, 0.5, 0.5], [math.cos(k * math.pi / 36), math.sin(k * math.pi / 36), 0]) for k in range(72)]
    case("rays in all directions from a point next to a cube", "Open3D #6188", "Rays that pass by are reported as hits.", unit,
         unit_faces, around)
    flat = [[-1.5, -1.5, 0], [1.5, -1.5, 0], [1.5, 1.5, 0], [-1.5, 1.5, 0]]
    turned = [[x * 0.8 + 0.6 * z + 3, y, -0.6 * x + 0.8 * z + 4] for x, y, z in flat]
    case("distances to a slanted plane", "Open3D #5777", "Distances are off by a hundred-thousandth.", turned, [[0, 1, 2], [0, 2, 3]],
         [([3.1, 0.2, 14], [0, 0, -1]), ([2.5, -0.7, 14], [0.1, 0.05, -1])], hits_per_ray=1)
    slab, slab_faces = box([0, 0, 0], [5.89075e11, 5.89075e11, 120000.0])
    case("a flat box of 589 million kilometres", "embree #416", "A second hit is made up near the far side.", slab, slab_faces,
         [([2.9e11, 1.3e11, 120500.0], [0, 0, -1])], t_max=119000.0, hits_per_ray=1)
    cells, cell_faces = grid(8, size=8)
    case("rays down the vertices of a grid of integers", "tinybvh #168", "Rays on borders of boxes and triangles are lost.", cells,
         cell_faces, [([i, j, 3], [0, 0, -1]) for i in range(9) for j in range(9)])


def main():
    add_reported_numbers()
    add_edges_and_vertices()
    add_parallel_and_grazing()
    add_scales()
    add_coincidence()
    add_limits_and_degenerate()
    path = Path(__file__).with_name("cases.json")
    text = ",\n".join(json.dumps(item, separators=(",", ":")) for item in CASES)
    path.write_text("[\n" + text + "\n]\n")
    print(f"{len(CASES)} cases, {sum(len(item['rays']) for item in CASES)} rays, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
