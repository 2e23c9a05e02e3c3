"""Sets of scenes with their voltages."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _core
from .sensor import Sensor, json_of, own
from .shapes import Contact, Disc, Ellipse, Polygon, Rectangle, scenes_text


@dataclass(eq=False)
class SceneSet:
    """N scenes with their voltages, as `Scenes.draw` makes them and files hold them.

    One of your own: SceneSet(sensor, voltages, images, reference), to train on or to score with; its
    contacts are not known. The arrays of a drawn or read set are read-only; copy them to change them.
    """

    sensor: Sensor
    voltages: np.ndarray  #: [N, channels] V, with noise
    images: np.ndarray  #: [N, rows, columns] S/m, the true conductivities
    reference: np.ndarray  #: [channels] V, of the sheet without contact
    clean_voltages: Optional[np.ndarray] = None  #: [N, channels] V, without noise, where known
    _contacts: Optional[np.ndarray] = field(default=None, repr=False)
    _vertices: Optional[np.ndarray] = field(default=None, repr=False)
    _recipe: str = field(default="", repr=False)
    _name: str = field(default="", repr=False)
    _made: tuple = field(default=(), repr=False)  #: the arrays that the recipe makes

    def __len__(self) -> int:
        return len(self.voltages)

    def __repr__(self) -> str:
        return f"<SceneSet: {len(self)} scenes of {self.sensor!r}>"

    @property
    def changes(self) -> np.ndarray:
        """Voltages less the reference, [N, channels] V."""
        return self.voltages - self.reference

    @property
    def image_changes(self) -> np.ndarray:
        """True images less the background, [N, rows, columns] S/m: what solvers estimate."""
        return self.images - self.sensor.background

    @property
    def contacts(self) -> np.ndarray:
        """[N, contacts, 7], NaN where there is none.

        Kind (0 disc, 1 ellipse, 2 rectangle, 3 polygon); x and y of the centre, mm from the middle
        of the sheet; half sizes along both axes, mm (NaN of a polygon); angle, rad; conductivity
        over the background's.
        """
        if self._contacts is None:
            raise _core.InputError("contacts: are not known of a set that was put together")
        contacts = self._contacts.copy()
        contacts[..., 1:5] *= self.sensor.unit_mm
        return contacts

    def scene(self, index: int) -> List[Contact]:
        """The contacts of one scene, which `ForwardModel.voltages` takes, in domain units."""
        if self._contacts is None or self._vertices is None:
            raise _core.InputError("contacts: are not known of a set that was put together")
        scene: List[Contact] = []
        for row, corners in zip(self._contacts[index], self._vertices[index]):
            kind, x, y, a, b, angle, ratio = row.tolist()
            if np.isnan(kind):
                continue
            if kind == 0:
                scene.append(Disc((x, y), a, ratio, "domain"))
            elif kind == 3:
                points = [(px, py) for px, py in corners[~np.isnan(corners[:, 0])].tolist()]
                scene.append(Polygon(tuple(points), ratio, "domain"))
            elif kind == 1:
                scene.append(Ellipse((x, y), (a, b), ratio, angle, "domain"))
            else:
                scene.append(Rectangle((x, y), (a, b), ratio, angle, "domain"))
        return scene

    def save(self, file: Union[str, os.PathLike], threads: int = 0) -> None:
        """Writes the set as HDF5; of a drawn one the same numbers as `ertbench generate` does.

        Overwrites only a dataset. Raises InputError where arrays do not go together.
        """
        if not self._as_made():
            _core.write_scenes(self.sensor, self.voltages, self.images, self.reference,
                               os.fspath(file))
            return
        _core.generate(self.sensor, self._recipe, self._name, os.fspath(file), threads)

    def __setstate__(self, state: dict) -> None:
        self.__dict__.update(state)
        for array in self._made:
            array.flags.writeable = False

    def _as_made(self) -> bool:
        """Whether the recipe makes these arrays: no other was put in its place, none was changed."""
        arrays = (self.voltages, self.images, self.reference)
        return bool(self._recipe) and all(now is made and not now.flags.writeable
                                          for now, made in zip(arrays, self._made))


def _set_of(sensor: Sensor, arrays: dict, recipe: str, name: str) -> SceneSet:
    made = tuple(arrays[key] for key in ("voltages", "images", "reference"))
    for array in made:
        array.flags.writeable = False
    return SceneSet(sensor, *made, arrays["clean_voltages"], arrays["contacts"], arrays["vertices"],
                    recipe, name, made)


class Scenes:
    """Random scenes, each quantity uniform in its interval, or scenes that are listed.

    contacts: their number, (least, most). Other keywords are those of "scenes" in an experiment:
    shapes (of "disc", "ellipse", "rectangle", "polygon", "ring", "cross", "bar"), radius_mm, aspect,
    corners, conductivity_ratio, blank_fraction, placement, centre, gap_mm; an interval is (low, high)
    or one number (docs/experiment.md).
    scenes: a list of lists of contacts, in place of all of these.
    seed, name: two sets with the same seed and name have the same scenes.
    grid: "auto", the exact sheet, whose error is at most `model_error` of the noise; or a grid of
    finite elements, as ForwardModel's.
    faults: as in an experiment, {"dead_electrodes": 1}.

    Raises InputError for unknown keys and values out of range.
    """

    def __init__(self, sensor: Sensor, contacts: Union[int, Tuple[int, int]] = (1, 3), *,
                 scenes: Optional[Sequence[Any]] = None, seed: int = 1, name: str = "scenes",
                 grid: Union[str, int] = "auto", model_error: Optional[float] = None,
                 rasterisation: str = "area", faults: Optional[dict] = None, **distribution: Any):
        self.sensor, self.name = sensor, name
        self._spec: dict = {"seed": seed, "grid": grid, "rasterisation": rasterisation}
        if model_error is not None:
            self._spec["model_error"] = model_error
        if faults:
            self._spec["faults"] = faults
        if scenes is not None:
            self._spec["scenes"] = json.loads(scenes_text(scenes))
        else:
            self._spec["scenes"] = {"contacts": contacts, **distribution}
        self._listed = None if scenes is None else len(self._spec["scenes"])
        self.draw(self._listed or 1)  # what is wrong is said here

    def draw(self, count: Optional[int] = None, snr_db: Optional[float] = None, *,
             snr_basis: str = "absolute", seed: Optional[int] = None,
             threads: int = 0) -> SceneSet:
        """Draws `count` scenes and computes their voltages, on all cores.

        snr_db: 20 log10 of the norm of each frame over that of its noise; None: no noise.
        snr_basis: "absolute" (of the voltages) or "difference" (of their change).
        The same call gives the same scenes, whatever the number of threads; `seed` replaces that of
        the object, for other scenes of the same kind.
        """
        spec = dict(self._spec, snr_db=snr_db, count=self._listed or count)
        if spec["count"] is None:
            raise _core.InputError("count: must be given, a whole number >= 1")
        if snr_db is not None:
            spec["snr_basis"] = snr_basis
        if seed is not None:
            spec["seed"] = seed
        recipe = json_of(spec)
        return _set_of(self.sensor, _core.draw(self.sensor, recipe, self.name, threads), recipe,
                       self.name)

    def __repr__(self) -> str:
        return f"<Scenes: {self._spec} of {self.sensor!r}>"


def read_scenes(file: Union[str, os.PathLike]) -> SceneSet:
    """Reads a dataset that `SceneSet.save`, `ertbench generate` or a run wrote.

    Raises InputError, naming the file and the HDF5 object, for what is no such file.
    """
    sensor, recipe, name, arrays = _core.read_scenes(os.fspath(file))
    if recipe:
        spec = json.loads(recipe)
        for key in ("format_version", "sensor", "name"):
            spec.pop(key, None)
        recipe = json.dumps(spec)
    return _set_of(own(sensor), arrays, recipe, name)
