"""Exact rays on triangle meshes and spheres, and images.

>>> import rt
>>> mesh = rt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
>>> hits = mesh.closest([0.25, 0.25, 2.0], [[0, 0, -1], [1, 0, 0]])
>>> hits.t
array([ 2., inf])

Rays are traced in double precision, with exact decisions at edges and vertices: no ray slips through a closed mesh, and
each triangle is hit at most once. Contiguous arrays of numpy are read in place, and all processors work by default.
"""

from ._rt import VERSION as __version__
from ._render import ConvergenceRow, Image, converge, render
from ._results import AllHits, Hits, NearestPoints
from ._scene import Instance, Scene, Spheres, TriangleMesh

__all__ = [
    "AllHits",
    "ConvergenceRow",
    "Hits",
    "Image",
    "Instance",
    "NearestPoints",
    "Scene",
    "Spheres",
    "TriangleMesh",
    "__version__",
    "converge",
    "render",
]
