"""Measured frames."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Optional, Union

import numpy as np

from . import _core
from .sensor import Sensor, own


@dataclass(eq=False)
class Frames:
    """N measured frames with their reference."""

    sensor: Sensor
    voltages: np.ndarray  #: [N, channels] V, in the order of the sensor's channels
    reference: np.ndarray  #: [channels] V, of the sheet without contact
    changes: np.ndarray = field(repr=False)  #: [N, channels] V, from the reference
    verdict: str = field(default="", repr=False)  #: how the reference fits the sensor's model

    def __len__(self) -> int:
        return len(self.voltages)


def read_frames(file: Union[str, os.PathLike], sensor: Optional[Sensor] = None, *, unit: str = "V",
                channels: str = "", background: str = "", dataset: str = "",
                transposed: bool = False, fix: bool = False, force: bool = False) -> Frames:
    """Reads frames: HDF5, MATLAB, Octave, tables, .dat, .get, or .eit (docs/own_frames.md).

    sensor: by default the one that the file names, else d2s. unit: "V", "mV" or "uV".
    channels: the order of the columns ("drive-major", "measure-major", "rotating", "full", ...).
    background: rows without contact as "0-19", the last included, or another file; their mean is the
    reference. By default the file's own.
    dataset, transposed: which dataset, and whether frames are its columns.

    The reference is compared with the model of the sensor. Where a wrong unit, sign or order explains
    it better, InputError says so; fix=True reads the frames so, force=True takes them as they are.
    """
    out = _core.read_frames(os.fspath(file), sensor, unit, channels, dataset, transposed,
                            os.fspath(background), fix, force)
    return Frames(own(out["sensor"]), out["voltages"], out["reference"], out["changes"],
                  out["verdict"])
