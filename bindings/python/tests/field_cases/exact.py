"""Rays and triangles in rational arithmetic: the reference of the field cases.

All numbers are taken as they are stored, so that every answer is exact. Edges and vertices belong to a triangle; triangles
without area, and triangles in a plane that holds the ray, are not hit.
"""

from fractions import Fraction


def _vector(point):
    return [Fraction(float(number)) for number in point]


def _minus(a, b):
    return [x - y for x, y in zip(a, b)]


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def intersect(triangle, origin, direction):
    """t of the plane and the smallest barycentric weight, as fractions: Cramer's rule as in Möller and Trumbore, 1997.

    `None` if the plane is parallel to the ray or there is no plane.
    """
    a, b, c = map(_vector, triangle)
    origin, direction = _vector(origin), _vector(direction)
    edge1, edge2 = _minus(b, a), _minus(c, a)
    p = _cross(direction, edge2)
    determinant = _dot(edge1, p)
    if determinant == 0:
        return None
    offset = _minus(origin, a)
    u = _dot(offset, p) / determinant
    q = _cross(offset, edge1)
    v = _dot(direction, q) / determinant
    return _dot(edge2, q) / determinant, min(u, v, 1 - u - v)


def differences_are_exact(vertices, origin):
    """True if the differences between all vertices and the origin are numbers of double precision."""
    return all(
        Fraction(float(x)) - Fraction(float(o)) == Fraction(float(x) - float(o))
        for vertex in vertices
        for x, o in zip(vertex, origin)
    )


def all_hits(vertices, faces, origin, direction, t_min, t_max, slack):
    """Hits in order, as pairs of t and the index of the triangle: those that are certain, and those on a border.

    For programs that round: if differences between vertices and the origin have to be rounded, a ray within `slack` of a border may
    pass on either side of it. Otherwise, and with a `slack` of 0, all hits are certain.
    """
    slack = Fraction(0) if differences_are_exact(vertices, origin) else slack
    certain, border = [], []
    for index, face in enumerate(faces):
        hit = intersect([vertices[i] for i in face], origin, direction)
        if hit is None:
            continue
        t, weight = hit
        if Fraction(t_min) <= t and (t_max == float("inf") or t <= Fraction(t_max)):
            if weight > slack or (slack == 0 and weight == 0):
                certain.append((t, index))
            elif weight >= -slack and slack > 0:
                border.append((t, index))
    return sorted(certain), sorted(border)
