"""Electrical resistance tomography of robot skins: the C++ library of ertbench for NumPy.

    import ertbench as eb
    sensor = eb.Sensor("d2s")
    model = eb.ForwardModel(sensor)
    frame = model.voltages(eb.Disc((20, -30), radius=15, ratio=0.4))
    solver = eb.Solver("one-step-gn", prior="noser", regularisation=0.1).fit(sensor)
    image, status = solver.reconstruct(frame)

Lengths are in mm from the middle of the sheet, conductivities in S/m, voltages in V. Rows of an
image run upwards from the least y, columns from the least x. A frame is [channels], in the order
drive by drive, measurements ascending; frames are [N, channels], images [N, rows, columns]. One item
may be given without its first axis and comes back without it. float64 that is contiguous is read
without a copy.

What cannot be used raises InputError, a ValueError that names the place and what would be right.
Long calls release Python's lock and end at Ctrl-C. `threads=0` uses $ERTBENCH_THREADS, else all
cores. After a fork, use nothing that was made before it while other threads ran. Sub-interpreters
are not supported.
"""

from typing import TYPE_CHECKING, Any

from . import plot
from ._core import InputError
from .experiments import Results, run
from .forward import ForwardModel
from .frames import Frames, read_frames
from .scenes import Scenes, SceneSet, read_scenes
from .scores import Scores, score
from .sensor import Sensor
from .serving import serve
from .shapes import Disc, Ellipse, Polygon, Rectangle
from .solver import Solver, load, solver_types

if TYPE_CHECKING:
    from . import torch

__version__ = "0.2.0"
__all__ = [
    "Disc", "Ellipse", "ForwardModel", "Frames", "InputError", "Polygon", "Rectangle", "Results",
    "Scenes", "SceneSet", "Scores", "Sensor", "Solver", "load", "plot", "read_frames",
    "read_scenes", "run", "score", "serve", "solver_types", "torch",
]


def __getattr__(name: str) -> Any:
    if name != "torch":
        raise AttributeError(f"module 'ertbench' has no attribute {name!r}")
    from importlib import import_module

    return import_module(".torch", __name__)  # not before it is asked for: PyTorch takes seconds
