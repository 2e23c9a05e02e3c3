"""From conductivities to voltages."""

from __future__ import annotations

import warnings
from typing import Any, Union

import numpy as np

from . import _core
from .sensor import Sensor
from .shapes import _Contact, scenes_text


class ForwardModel(_core.ForwardModel):
    """Voltages of a sheet, div(sigma grad u) = 0.

    grid: "auto", the exact continuous sheet, by an equation on the borders of the contacts; or the
    pixels along the longer side of a finite element grid (24, 48, ... for a sensor whose image has
    24; equal to EIDORS's d2s to rounding).
    accuracy: with "auto", the largest estimated error relative to the norm of the voltages' change.

    Raises InputError where a grid does not serve the sensor.
    """

    def __init__(self, sensor: Sensor, grid: Union[str, int] = "auto", accuracy: float = 1e-4):
        if grid != "auto" and not (isinstance(grid, (int, np.integer)) and grid > 0):
            raise _core.InputError(f'grid: must be "auto" or a number of pixels, got {grid!r}')
        if not 1e-9 <= accuracy <= 1:
            raise _core.InputError(f"accuracy: must be from 1e-9 to 1, got {accuracy}")
        self.sensor, self.grid, self.accuracy = sensor, grid, accuracy
        super().__init__(sensor, 0 if grid == "auto" else int(grid))

    def reference(self) -> np.ndarray:
        """Voltages of the uniform sheet, [channels] V."""
        return super().reference()

    def voltages(self, scene: Any, threads: int = 0) -> np.ndarray:
        """Voltages [channels] or [N, channels] V, without noise.

        scene: a contact; a list of contacts, one scene (empty: the uniform sheet); a list of such
        lists; or conductivities [rows, columns] or [N, rows, columns] S/m, all > 0. Images are
        computed by finite elements on their own pixels: the sensor's image or, with "auto", also
        one of twice, four times, ... as many pixels a side.

        Warns where a scene's estimated error stays above `accuracy`, as of sharp corners close to
        each other.
        """
        if isinstance(scene, _Contact):
            scene = [scene]
        if isinstance(scene, (list, tuple)) and not _is_array(scene):
            many = len(scene) > 0 and not isinstance(scene[0], _Contact)
            voltages, errors = self._of_scenes(scenes_text(scene if many else [scene]),
                                               self.accuracy, threads)
            worst = errors.max(initial=0)
            if worst > self.accuracy:
                warnings.warn(f"scene {errors.argmax()}: the estimated error of the voltages is "
                              f"{worst:.1e} of their change, above the accuracy "
                              f"{self.accuracy:.1e}", stacklevel=2)
            return voltages if many else voltages[0]
        return self._of_images(scene, threads)

    def __reduce__(self):
        return (ForwardModel, (self.sensor, self.grid, self.accuracy))

    def __repr__(self) -> str:
        return f"<ForwardModel: grid={self.grid!r} of {self.sensor!r}>"


def _is_array(scene) -> bool:
    """Whether nested lists hold numbers."""
    while isinstance(scene, (list, tuple)) and scene:
        scene = scene[0]
    return isinstance(scene, (int, float, np.ndarray, np.generic))
