"""Sensors: the sheet, its electrodes and the pairs that drive and measure."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Optional, Tuple

import numpy as np

from . import _core, eidors, exchange


def _folders() -> list:
    return [Path(__file__).parent / "sensors", Path(_core.project_folder) / "sensors"]


class Sensor(_core.Sensor):
    """A resistive sheet with electrodes on its border.

    Sensor()                       EIDORS's d2s: a square of 200 mm with 16 point electrodes
    Sensor("disc_16")              a built-in one (`Sensor.names()`)
    Sensor("my_sensor.json")       a file; docs/sensor.md tells its keys
    Sensor(shape="disc", diameter_mm=230, electrode_count=16, drive={"skip": 3})

    Keywords are the keys of such a file; with a name or file they replace its own.

    Attributes: shape; channels, the length of a frame; electrodes, their number; image_shape (rows,
    columns); background, S/m; drive_current, A; size_mm (width, height); x_mm [columns] and y_mm
    [rows], the pixels' centres from the middle of the sheet; on_sheet [rows, columns] bool;
    electrodes_mm [electrodes, 2]; channel_electrodes [channels, 4], the electrodes of each channel's
    drive (out of the first, into the second) and measurement (first less second), from 0;
    reciprocal_pairs [n, 2], channels that read the same voltage by reciprocity.

    Raises InputError for an unknown name or key and for values out of range.
    """

    def __init__(self, name: "str | os.PathLike | None" = None, **keywords: Any):
        spec, source = {}, "Sensor"
        if name is not None:
            source = str(self._file(name))
            _core.Sensor(Path(source).read_text(), source)  # says what is wrong in the file itself
            spec = json.loads(Path(source).read_text())
        spec.update(keywords)
        super().__init__(json_of(spec), source)

    @staticmethod
    def names() -> list:
        """Names of the built-in sensors."""
        files = {file.stem for folder in _folders() for file in folder.glob("*.json")}
        return sorted(files - {"schema"})

    @staticmethod
    def _file(name) -> Path:
        path = Path(name)
        if path.is_file():
            return path
        for folder in _folders():
            if path.suffix == "" and (folder / f"{path}.json").is_file():
                return folder / f"{path}.json"
        raise _core.InputError(f"Sensor: there is no file \"{name}\", nor a built-in sensor of that "
                               f"name; built in are {', '.join(Sensor.names())}")

    @classmethod
    def _of(cls, text: str) -> "Sensor":
        return cls(**json.loads(text))

    @classmethod
    def from_eidors(cls, file: "str | os.PathLike", unit: Optional[str] = None, variable: str = "",
                    **keywords: Any) -> "Sensor":
        """The sensor of an EIDORS forward model in a .mat file, by SciPy.

        Sensor.from_eidors("fmdl.mat", unit="m")            the mesh is in metres ("cm", "mm")
        Sensor.from_eidors("fmdl.mat", diameter_mm=230)     ... in any unit: a disc (side_mm, sides_mm)
        Sensor.from_eidors("tank3d.mat", shape="disc", diameter_mm=230)   its stimulation alone

        Takes from stimulation drives, measurements and current; from nodes, elems and electrode a
        disc or a rectangle, and electrodes that are points or, with several nodes, complete. variable:
        the fmdl, img or inv_model, where the file holds several. Frames of the model, [channels] in
        EIDORS's order and sign, are frames of the sensor. Keywords are those of Sensor and replace what
        the model says; `background`, S/m, is none of its fields.

        Raises InputError for drives and measurements that a sensor does not have: of other than two
        electrodes, of several currents, rotating with the drive, or not the same for all drives.
        """
        return cls(**eidors.keys(file, unit, variable, keywords))

    @classmethod
    def from_pyeit(cls, protocol: Any, name: "str | os.PathLike | None" = None,
                   **keywords: Any) -> "Sensor":
        """A sensor with the channels of a pyEIT protocol, on the sheet that Sensor(name, ...) has.

        protocol: ex_mat [drives, 2]; meas_mat [channels, 3], or [drives, measurements, 2] as pyEIT has
        it until 1.2.4. Frames of pyEIT's forward model are frames of the sensor, in order and sign. Its
        currents are 1 A, and its circle's electrodes begin at the left: give drive_current and
        electrode_places_mm if these matter.

        Raises InputError as from_eidors does.
        """
        if name is None and not any(key.startswith("electrode_p") for key in keywords):
            rows = exchange.read_protocol(protocol)
            most = max(rows[0].max(), rows[1][:, :2].max())
            keywords.setdefault("electrode_count", int(most) + 1)
        sheet = cls(name, **keywords)
        return cls(name, **{**exchange.pyeit_keys(protocol, sheet.electrodes), **keywords})

    def to_pyeit(self) -> Any:
        """A PyEITProtocol with the sensor's channels, in order and sign; without pyEIT its arrays.

        ex_mat [drives, 2], meas_mat [channels, 3] ([drives, measurements, 2] of a pyEIT that has it
        so), keep_ba [drives * measuring pairs] bool, which picks the channels from a frame of all.
        """
        return exchange.to_pyeit(self)

    def symmetries(self) -> Tuple[np.ndarray, np.ndarray]:
        """Rotations and reflections that map electrodes onto electrodes, the identity first.

        Returns pixels [n, rows * columns] and channels [n, channels]: the k-th symmetry maps an
        image to image.ravel()[pixels[k]] and its frame to frame[channels[k]].
        """
        return super().symmetries()

    def __reduce__(self):
        return (Sensor._of, (self.to_json(),))

    def __hash__(self):
        return hash(self.to_json())

    def __repr__(self) -> str:
        width, height = self.size_mm
        return (f"<Sensor: {self.shape} {width:g} x {height:g} mm, {self.electrodes} electrodes, "
                f"{self.channels} channels>")


def own(sensor: "_core.Sensor | Sensor") -> Sensor:
    """The class of this file for a sensor that came from C++."""
    return sensor if isinstance(sensor, Sensor) else Sensor._of(sensor.to_json())


def json_of(spec: Any) -> str:
    """The program's JSON of numbers, text, lists and dicts, and of NumPy's numbers and arrays.

    Raises InputError for anything else, and for numbers that are not finite.
    """
    def plain(value: Any) -> Any:
        if isinstance(value, (np.generic, np.ndarray)):
            return value.tolist()
        raise _core.InputError(f"{value!r}: is no number, text, list or dict")

    try:
        return json.dumps(spec, default=plain, allow_nan=False)
    except ValueError:
        raise _core.InputError(f"{spec!r:.500}: has a number that is not finite") from None
