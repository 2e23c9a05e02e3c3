"""Pictures of images, where matplotlib is installed."""

from __future__ import annotations

from typing import Any, Optional, Sequence

import numpy as np

from . import _core
from .sensor import Sensor


def images(images: Any, sensor: Sensor, titles: Optional[Sequence[str]] = None, columns: int = 6,
           limit: Optional[float] = None):
    """Draws changes of the conductivity, [rows, columns] or [N, rows, columns] S/m, and electrodes.

    titles: one for each image. limit: end of the colour scale, S/m; by default the largest change.
    Zero is white, less conductivity blue, more red. Returns matplotlib's figure.
    """
    import matplotlib.pyplot as plt

    pictures = np.asarray(images, dtype=float)
    pictures = pictures[np.newaxis] if pictures.ndim == 2 else pictures
    if pictures.shape[1:] != tuple(sensor.image_shape):
        raise _core.InputError(f"images: must have the shape {list(sensor.image_shape)} or "
                               f"[N, rows, columns], got {list(np.shape(images))}")
    if limit is None:
        limit = float(np.nanmax(np.abs(pictures), initial=0)) or 1.0
    columns = min(columns, len(pictures))
    rows = -(-len(pictures) // columns)
    figure, axes = plt.subplots(rows, columns, squeeze=False, figsize=(2.2 * columns + 1, 2.4 * rows),
                                layout="constrained")
    shown = np.where(sensor.on_sheet, pictures, np.nan)
    for axis in axes.flat[len(pictures):]:
        axis.axis("off")
    for index, (axis, picture) in enumerate(zip(axes.flat, shown)):
        mesh = axis.pcolormesh(sensor.x_mm, sensor.y_mm, picture, cmap="RdBu_r", vmin=-limit,
                               vmax=limit)
        axis.plot(*sensor.electrodes_mm.T, "k.", markersize=3, clip_on=False)
        axis.set_aspect("equal")
        axis.set_title(titles[index] if titles else "", fontsize=9)
        axis.tick_params(labelsize=7)
    figure.colorbar(mesh, ax=axes, label="change of the conductivity (S/m)", shrink=0.8)
    return figure
