"""Queries and renders in forked processes, and signals."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from shapes import box, bumpy_sphere

import rt
from rt.compat.trimesh import RayMeshIntersector

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs fork and signals of POSIX")

MESH = rt.TriangleMesh(*box())
ORIGINS = np.full((100_000, 3), 0.25)
POINTS = np.linspace(-2, 2, 3 * 5000).reshape(-1, 3)


def work(threads):
    new = rt.TriangleMesh(*bumpy_sphere(80))
    image = rt.render(MESH, spp=1, size=(16, 16), integrator="depth", threads=threads)
    return (
        int(MESH.any_hit(ORIGINS, [0, 0, -1], threads=threads).sum()),
        float(MESH.signed_distance(POINTS, threads=threads).sum()),
        int(new.count_hits([0, 0, 3], POINTS - [0, 0, 3], threads=threads).sum()),
        image.tobytes(),
    )


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_forked_processes_have_threads_of_their_own():
    expected = [work(threads) for threads in (None, 2)]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(work, [None, 2], chunksize=1).get(timeout=120) == expected


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_process_forked_while_a_tree_is_built_does_not_wait():
    class Mesh:
        vertices, faces = box()

    mesh, scene, intersector = rt.TriangleMesh(*box()), rt.Scene([MESH]), RayMeshIntersector(Mesh())
    held, forked = threading.Event(), threading.Event()

    def build():
        with mesh._lock, scene._lock, intersector._lock:
            held.set()
            forked.wait()

    builder = threading.Thread(target=build)
    builder.start()
    held.wait()
    process = os.fork()
    if process == 0:
        # Ends a process that waits.
        signal.alarm(20)
        try:
            mesh.any_hit([0, 0, 0], [0, 0, 1])
            scene.update(insert=mesh)
            intersector.intersects_any([[0, 0, 0]], [[0, 0, 1]])
        except BaseException:
            os._exit(1)
        os._exit(0)
    forked.set()
    builder.join()
    assert os.waitpid(process, 0)[1] == 0


def test_a_render_ends_with_the_exception_of_a_signal_handler():
    class TimeOut(Exception):
        pass

    def handler(number, frame):
        raise TimeOut

    former = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(TimeOut):
            rt.render(MESH, spp=1 << 20, size=(200, 200), integrator="path")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, former)


def test_ctrl_c_ends_a_render_with_long_tiles():
    script = """if True:
        import rt
        ball = rt.Spheres([[0, 0, 0]], 1)
        print("started", flush=True)
        try:
            rt.render(ball, spp=2**31, size=(16, 16))
        except KeyboardInterrupt:
            print("interrupted")
    """
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout.readline() == "started\n"
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            assert process.communicate(timeout=20)[0] == "interrupted\n"
        finally:
            process.kill()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_idle_threads_are_bounded():
    def n_threads():
        return len(os.listdir("/proc/self/task"))

    limit = max(64, 2 * os.cpu_count())
    for threads in (20, 30, 31, 300, 301, 302, 21, 32, 33):
        MESH.any_hit(ORIGINS, [0, 0, -1], threads=threads)
    # Threads of dropped pools end by themselves. Those of Python and numpy are few.
    for _ in range(100):
        if n_threads() < limit + 100:
            break
        time.sleep(0.1)
    assert n_threads() < limit + 100


def test_a_signal_handler_may_query_the_mesh_whose_tree_is_built():
    """It waited for the lock of its own thread forever."""
    generator = np.random.default_rng(1)
    mesh = rt.TriangleMesh(generator.normal(size=(300_000, 3)), np.arange(300_000).reshape(-1, 3))
    answers = []
    former = signal.signal(signal.SIGALRM, lambda *_: answers.append(mesh.any_hit([0, 0, 50], [0, 0, -1])))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.01)
        answers.append(mesh.any_hit([0, 0, 50], [0, 0, -1]))
        signal.setitimer(signal.ITIMER_REAL, 0)
    finally:
        signal.signal(signal.SIGALRM, former)
    assert len(set(map(bool, answers))) == 1


def test_an_update_within_an_update_is_refused():
    scene = rt.Scene([MESH])

    with scene._lock, pytest.raises(RuntimeError, match="interrupted"):
        scene.update(insert=[MESH])
    assert scene.update(insert=[MESH]) == [1]
