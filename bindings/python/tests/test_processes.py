"""Queries and renders in forked processes, and signals."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from shapes import box, bumpy_sphere

import rt

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
