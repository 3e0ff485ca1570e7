"""Rays at meshes, spheres and scenes."""

import threading

import numpy as np
import pytest
from shapes import bumpy_sphere, box, moller_trumbore

import rt


def random_rays(n, seed=0):
    generator = np.random.default_rng(seed)
    origins = generator.normal(size=(n, 3))
    origins *= 3 / np.linalg.norm(origins, axis=1, keepdims=True)
    return origins, generator.normal(scale=0.7, size=(n, 3)) - origins


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_hits_are_those_of_a_test_of_every_triangle(dtype):
    vertices, faces = bumpy_sphere(12)
    vertices = vertices.astype(dtype)
    origins, directions = random_rays(500)
    expected = moller_trumbore(vertices, faces, origins, directions)
    mesh = rt.TriangleMesh(vertices, faces)
    hits = mesh.closest(origins, directions)
    is_hit = ~np.isnan(expected).all(axis=1)
    assert 100 < is_hit.sum() < 500
    np.testing.assert_array_equal(hits.hit, is_hit)
    np.testing.assert_allclose(hits.t[is_hit], np.nanmin(expected[is_hit], axis=1), rtol=1e-12)
    np.testing.assert_array_equal(hits.primitive[is_hit], np.nanargmin(expected[is_hit], axis=1))
    assert (hits.t[~is_hit] == np.inf).all() and (hits.primitive[~is_hit] == -1).all()
    assert (hits.instance[is_hit] == 0).all() and (hits.instance[~is_hit] == -1).all()
    np.testing.assert_array_equal(mesh.any_hit(origins, directions), is_hit)
    np.testing.assert_array_equal(mesh.count_hits(origins, directions), (~np.isnan(expected)).sum(axis=1))
    all_hits = mesh.all_hits(origins, directions)
    for i in range(len(origins)):
        of_ray = slice(all_hits.offsets[i], all_hits.offsets[i + 1])
        np.testing.assert_allclose(all_hits.t[of_ray], np.sort(expected[i][~np.isnan(expected[i])]), rtol=1e-12)
    np.testing.assert_array_equal(np.bincount(all_hits.ray, minlength=500), mesh.count_hits(origins, directions))
    corners = vertices[faces[hits.primitive[is_hit]]].astype(np.float64)
    weights = np.column_stack([1 - hits.uv[is_hit].sum(axis=1), hits.uv[is_hit]])
    points = origins[is_hit] + hits.t[is_hit, None] * directions[is_hit]
    np.testing.assert_allclose(np.einsum("ij,ijk->ik", weights, corners), points, atol=1e-12)


def test_results_do_not_depend_on_threads_layout_and_slices():
    mesh = rt.TriangleMesh(*bumpy_sphere(40))
    origins, directions = random_rays(300_000)
    expected = mesh.closest(origins, directions, threads=1)
    records = np.zeros((len(origins), 8))
    records[:, 1:4], records[:, 4:7] = origins, directions
    for o, d in [
        (np.asfortranarray(origins), directions),
        (records[:, 1:4], records[:, 4:7]),
        (origins[::-1].copy()[::-1], np.ascontiguousarray(directions)),
        (origins.astype(">f8"), directions),
    ]:
        for threads in [None, 1, 3]:
            hits = mesh.closest(o, d, threads=threads)
            for got, wanted in zip(hits, expected):
                np.testing.assert_array_equal(got, wanted)
            np.testing.assert_array_equal(mesh.any_hit(o, d, threads=threads), expected.hit)
    every = mesh.all_hits(records[:, 1:4], records[:, 4:7])
    for got, wanted in zip(every, mesh.all_hits(origins, directions, threads=1)):
        np.testing.assert_array_equal(got, wanted)


def test_origins_and_directions_broadcast():
    mesh = rt.TriangleMesh(*box())
    fan = np.stack(np.meshgrid(np.linspace(-0.1, 0.1, 4), np.linspace(-0.1, 0.1, 5), [1.0]), axis=-1)[:, :, 0]
    hits = mesh.closest([0, 0, -5], fan)
    assert hits.t.shape == hits.primitive.shape == (5, 4) and hits.uv.shape == (5, 4, 2)
    np.testing.assert_allclose(hits.t, 4)
    grid = mesh.closest(np.zeros((3, 1, 3)), np.eye(3)[None])
    assert grid.t.shape == (3, 3) and (grid.t == 1).all()
    single = mesh.closest([0, 0, 0], [0, 0, 2])
    assert single.t.shape == () and single.t == 0.5
    many = mesh.closest(np.random.default_rng(1).uniform(-0.9, 0.9, size=(7, 3)), [1, 0, 0])
    assert many.hit.all()
    assert mesh.closest(np.empty((0, 3)), np.empty((0, 3))).t.shape == (0,)
    assert mesh.all_hits(np.empty((0, 3)), [1, 0, 0]).offsets.tolist() == [0]
    assert mesh.closest([], []).t.shape == mesh.contains([]).shape == (0,)
    assert rt.Spheres([], []).n_spheres == 0
    assert mesh.closest(np.array([0, 0, 2**70], dtype=object), [0, 0, -1]).t == 2.0**70


def test_limits_are_inclusive_and_may_differ_from_ray_to_ray():
    mesh = rt.TriangleMesh(*box())
    limits = [0.5, 1.0, np.nextafter(1, 0), np.inf]
    assert mesh.closest(np.zeros((4, 3)), [1, 0, 0], t_max=limits).hit.tolist() == [False, True, False, True]
    assert mesh.closest([-2, 0.1, 0.2], [1, 0, 0], t_min=1.0).t == 1
    assert mesh.closest([-2, 0.1, 0.2], [1, 0, 0], t_min=np.nextafter(1, 2)).t == 3


def test_a_ray_through_an_edge_hits_both_triangles_once():
    mesh = rt.TriangleMesh(*box())
    hits = mesh.all_hits([0, 0, -5], [0, 0, 1])
    assert hits.t.tolist() == [4, 4, 6, 6] and hits.primitive.tolist() == [0, 1, 2, 3]


def test_instances_are_numbered_by_position_and_share_their_tree():
    mesh = rt.TriangleMesh(*box())
    ball = rt.Spheres([[0, 0, 0], [0, 5, 0]], [1.0, 2.0])
    moved = np.eye(4)
    moved[:3, 3] = [10, 0, 0]
    stretched = np.diag([1.0, 1.0, 3.0, 1.0])
    scene = rt.Scene([mesh, rt.Instance(mesh, moved), ball, rt.Instance(mesh, moved @ moved @ stretched)])
    hits = scene.closest([[0.1, 0.2, 9], [10.1, 0.2, 9], [0, 5, 9], [20.1, 0.2, 9], [30, 0, 9]], [0, 0, -1])
    assert hits.t.tolist() == [8, 8, 7, 6, np.inf]
    assert hits.instance.tolist() == [0, 1, 2, 3, -1]
    assert hits.primitive[2] == 1
    assert rt.Scene(mesh).closest([0.1, 0.2, 9], [0, 0, -1]).t == 8
    crossings = scene.all_hits([-5.0, 0.1, 0.2], [1, 0, 0])
    assert crossings.instance.tolist() == [0, 2, 2, 0, 1, 1, 3, 3] or np.all(np.diff(crossings.t) >= 0)


def test_results_are_arrays_of_the_documented_types():
    hits = rt.TriangleMesh(*box()).closest(np.zeros((2, 3), dtype=np.float32), np.eye(3, dtype=np.float32)[:2])
    assert [array.dtype for array in hits] == [np.float64, np.int32, np.int32, np.float64]
    assert rt.TriangleMesh(*box()).count_hits([0, 0, 0], [1, 0, 0]).dtype == np.int32


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: m.closest([[0, 0, 0], [0, np.nan, 0]], [1, 0, 0]), "row 1 of origins"),
        (lambda m: m.any_hit([0, 0, 0], [[1, 0, 0], [0, 0, 1], [np.inf, 0, 0]]), "row 2 of directions"),
        (lambda m: m.closest([[0, 0, 0]] * 2, [[1, 0, 0]] * 3), "do not fit together"),
        (lambda m: m.closest([0, 0], [1, 0, 0]), r"origins must have the shape \(\.\.\., 3\)"),
        (lambda m: m.closest("abc", [1, 0, 0]), "origins must be numbers"),
        (lambda m: m.closest([0, 0, 0], [1, 0, 0], t_max=[1, 2]), "t_max of shape"),
        (lambda m: m.closest([0, 0, 0], [1, 0, 0], t_max=None), "t_max must be a number"),
        (lambda m: m.closest([0, 0, 0], [1, 0, 0], t_max=[None]), "t_max must be a number"),
        (lambda m: m.closest([0, 0, 0], [1, 0, 0], t_min=1j), "t_min must be real numbers"),
        (lambda m: m.closest([0, 0, 0], [1, 0, 0], t_min=np.nan), "t_min must be a number, .*not nan"),
        (lambda m: m.any_hit([[0, 0, 0]] * 2, [1, 0, 0], t_max=[5, np.nan]), "row 1 of t_max is not a number"),
        (lambda m: m.all_hits([[0, 0, 0]] * 3, [1, 0, 0], t_min=[0, 0, np.nan]), "row 2 of t_min is not a number"),
        (lambda m: m.nearest_point([0, 0, 0], max_distance=np.nan), "max_distance must be a number, not nan"),
        (lambda m: m.nearest_point([0, 0, 0], max_distance=None), "max_distance must be a number"),
        (lambda m: m.closest(np.zeros((2, 3), "datetime64[s]"), [1, 0, 0]), "origins must be numbers, not datetime64"),
        (lambda m: m.closest(["1", "2", "3"], [1, 0, 0]), "origins must be numbers, not <U1"),
        (lambda m: m.closest(np.ma.masked_less([[-1.0, 0, 0]], 0), [1, 0, 0]), "origins has masked numbers"),
        (lambda m: m.closest([0, 0, 1j], [1, 0, 0]), "origins must be real numbers"),
        (lambda m: m.closest([0, 0, 0], [1, 0, 0], threads=0), "threads must be"),
        (lambda m: m.closest([0, 0, 0], [1, 0, 0], threads=10**6), "threads must be an integer from 1 to 1024"),
        (lambda m: m.contains([[0, 0, 0], [np.nan, 0, 0]]), "row 1 of points"),
        (lambda m: rt.TriangleMesh([[0, 0, 0]], [[0, 0, 1]]), "triangle 0: vertex index 1 is out of range"),
        (lambda m: rt.TriangleMesh([[0, 0, 0], [0, np.inf, 0]], [[0, 1, 0]]), "vertex 1 has a coordinate that is not"),
        (lambda m: rt.TriangleMesh([[0, 0, 1e61]], [[0, 0, 0]]), "vertex 0 has a coordinate that is not"),
        (lambda m: rt.TriangleMesh([[0, 0, 0]], [[0, 0, -1]]), "row 0 of faces"),
        (lambda m: rt.TriangleMesh([[0, 0, 0]], [[0.0, 0.0, 0.0]]), "faces must be integers"),
        (lambda m: rt.TriangleMesh([[0, 0, 0]], [[0, 0]]), "faces must have the shape"),
        (lambda m: rt.TriangleMesh(*box(), quality="best"), "quality"),
        (lambda m: rt.Spheres([[0, 0, 0]], [1, 2]), r"radii of shape \(2,\) does not fit the shape \(1,\)"),
        (lambda m: rt.Spheres([[0, 0, 0], [1, 1, 1]], [1, -1]), "sphere 1: radius -1"),
        (lambda m: rt.Spheres([[0, 0, 0], [1, 1, 1]], [1, [2, 3]]), "^radii must be a number, or an array of one for each"),
        (lambda m: rt.TriangleMesh([[0, 0, 0], [1, 1]], [[0, 1, 0]]), "^vertices must be numbers"),
        (lambda m: rt.Spheres([[0, 0, 0]], 1e-320), "sphere 0: radius 1e-320 must be positive"),
        (lambda m: rt.Spheres([[0, 0, 0]], [np.nan]), "sphere 0: radius NaN must be positive"),
        (lambda m: rt.Scene([rt.Instance(m, np.diag([0, 0, 0, 1]))]), "object 0: the transform is singular$"),
        (lambda m: rt.Instance(m, 1j * np.eye(4)), "a transform must be real numbers"),
        (lambda m: rt.Scene([rt.Instance(rt.Spheres([[0, 0, 0]], 1), np.diag([1, 2, 1, 1]))]), "same factor"),
    ],
)
def test_errors_name_the_offending_row(call, message):
    with pytest.raises(ValueError, match=message):
        call(rt.TriangleMesh(*box()))


def test_wrong_types_are_refused():
    with pytest.raises(TypeError, match="object 1 is a str"):
        rt.Scene([rt.TriangleMesh(*box()), "mesh"])
    with pytest.raises(TypeError, match="not a|not dict"):
        rt.Instance({}, np.eye(4))


def test_other_threads_of_python_run_while_rays_are_traced():
    mesh = rt.TriangleMesh(*bumpy_sphere(60))
    origins, directions = random_rays(400_000)
    count, stop = [0], threading.Event()

    def tick():
        while not stop.wait(0.001):
            count[0] += 1

    thread = threading.Thread(target=tick)
    thread.start()
    before = count[0]
    mesh.closest(origins, directions, threads=1)
    during = count[0] - before
    stop.set()
    thread.join()
    assert during > 0


def test_many_threads_may_query_one_mesh():
    mesh = rt.TriangleMesh(*bumpy_sphere(20))
    origins, directions = random_rays(20_000)
    results = [None] * 4

    def query(i):
        results[i] = mesh.closest(origins, directions, threads=2).t

    threads = [threading.Thread(target=query, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results[1:]:
        np.testing.assert_array_equal(result, results[0])


def test_arrays_of_the_caller_are_not_kept():
    vertices, faces = box()
    mesh = rt.TriangleMesh(vertices, faces)
    vertices *= 100
    assert mesh.closest([0, 0, 0], [1, 0, 0]).t == 1
    origins = np.zeros((2, 3))
    origins.setflags(write=False)
    assert mesh.closest(origins, [1, 0, 0]).hit.all()


def misaligned(values):
    """Copy of an array whose numbers lie at addresses that are no multiples of their size."""
    values = np.asarray(values)
    moved = np.frombuffer(b"x" + values.tobytes(), values.dtype, values.size, 1).reshape(values.shape)
    assert not moved.flags.aligned
    return moved


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_misaligned_arrays_are_copied(dtype):
    vertices, faces = bumpy_sphere(12)
    origins, directions = (array.astype(dtype) for array in random_rays(500))
    t_max = np.linspace(0.1, 1.5, 500)
    expected = rt.TriangleMesh(vertices.astype(dtype), faces).closest(origins, directions, t_max=t_max)
    mesh = rt.TriangleMesh(misaligned(vertices.astype(dtype)), misaligned(faces.astype(np.uint32)))
    rays = misaligned(origins), misaligned(directions)
    hits = mesh.closest(*rays, t_max=misaligned(t_max))
    np.testing.assert_array_equal(hits.t, expected.t)
    np.testing.assert_array_equal(mesh.any_hit(*rays, t_max=misaligned(t_max)), expected.hit)
    np.testing.assert_array_equal(mesh.nearest_point(rays[0]).distance, mesh.nearest_point(origins).distance)
    balls = rt.Spheres(misaligned(np.eye(3)), misaligned(np.ones(3)))
    np.testing.assert_array_equal(balls.radii, np.ones(3))
    moved = rt.Scene([rt.Instance(mesh, misaligned(np.eye(4)))])
    np.testing.assert_array_equal(moved.closest(origins, directions, t_max=t_max).t, expected.t)


def test_the_extension_module_refuses_misaligned_arrays():
    vertices, faces = np.eye(3), np.array([[0, 1, 2]], dtype=np.uint32)
    scene = rt.TriangleMesh(vertices, faces)._core()
    rays = np.zeros((3, 3)), np.ones((3, 3)), np.zeros(3), np.ones(3)
    for i, name in enumerate(["origins", "directions", "t_min", "t_max"]):
        with pytest.raises(ValueError, match=f"{name} must be .*aligned"):
            scene.any_hit(*[misaligned(array) if k == i else array for k, array in enumerate(rays)], 1)
    with pytest.raises(ValueError, match="vertices must be aligned"):
        rt._rt.Mesh(misaligned(vertices), faces)
    with pytest.raises(ValueError, match="faces must be aligned"):
        rt._rt.Mesh(vertices, misaligned(faces))
    with pytest.raises(ValueError, match="aligned"):
        rt._rt.SphereSet(misaligned(vertices), np.ones(3))
    with pytest.raises(ValueError, match="aligned"):
        rt._rt.Scene([(0, rt._rt.Mesh(vertices, faces))], [(0, misaligned(np.eye(4)))], "fast")


def test_limits_of_one_ray_are_an_array(recwarn):
    mesh = rt.TriangleMesh(*box())
    ray = [[-2, 0.1, 0.2]], [1, 0, 0]
    for t_min in (1.5, [1.5], np.array(1.5), np.float32(1.5), np.float32([1.5])):
        assert mesh.closest(*ray, t_min=t_min).t == [3]
        assert mesh.count_hits(*ray, t_max=t_min) == [1]
    assert not recwarn.list
    with pytest.raises(ValueError, match="^row 0 of t_min is not a number"):
        mesh.closest(*ray, t_min=[np.nan])


def test_faces_of_objects_are_integers():
    mesh = rt.TriangleMesh(np.eye(3), np.array([[0, 1, np.int64(2)]], dtype=object))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2]])
    for faces in ([[0, 1, 2**70]], [[0, 1, 2.5]]):
        with pytest.raises(ValueError, match="^faces must be integers from 0 to 4294967295, not object"):
            rt.TriangleMesh(np.eye(3), np.array(faces, dtype=object))
    with pytest.raises(ValueError, match=r"^row 0 of faces is \[0, 1, -1\], which are not indices"):
        rt.TriangleMesh(np.eye(3), np.array([[0, 1, -1]], dtype=object))
