"""Scores of images."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

from . import _core
from .scenes import SceneSet
from .sensor import Sensor


class Scores(dict):
    """One array [N] for each metric, NaN where a metric is undefined. `legend(name)` explains it."""

    @staticmethod
    def legend(metric: str) -> str:
        """What a metric is and its ideal."""
        return _core.metrics[metric]

    def summary(self) -> str:
        """A table: mean with its 95 % bootstrap interval, median, frames without a value."""
        lines = [f"{'metric':<20}{'mean':>9}  {'95 %':^19}{'median':>10}{'undefined':>11}"]
        for metric, values in self.items():
            mean, interval, median, _, undefined = _core.summary(values, metric)
            if mean is None:
                lines.append(f"{metric:<20}{'-':>9}  {'':^19}{'-':>10}{undefined:>11}")
                continue
            low, high = interval
            lines.append(f"{metric:<20}{mean:>9.4g}  {f'{low:.4g} to {high:.4g}':^19}"
                         f"{median:>10.4g}{undefined:>11}")
        return "\n".join(lines)


def score(images: Any, truth: Any, sensor: Optional[Sensor] = None, threads: int = 0) -> Scores:
    """Scores images by all metrics of `ertbench list`, frame by frame.

    images: [N, rows, columns] S/m, changes of the conductivity as `Solver.reconstruct` makes them,
    or one image. truth: a SceneSet; or true conductivities of the same shape, S/m, with `sensor`:
    then there are no metrics of contacts.

    Raises InputError for shapes that do not match.
    """
    contacts = vertices = None
    if isinstance(truth, SceneSet):
        sensor, contacts, vertices, truth = truth.sensor, truth._contacts, truth._vertices, truth.images
    elif sensor is None:
        raise _core.InputError("sensor: must be given where the truth is an array of images")
    if np.any(np.asarray(truth) <= 0):
        raise _core.InputError("truth: must be conductivities > 0, S/m; changes are no truth")
    if np.ndim(images) == 2 and np.ndim(truth) == 3 and len(truth) == 1:
        images = np.asarray(images)[np.newaxis]
    return Scores(_core.score(sensor, images, truth, contacts, vertices, threads))
