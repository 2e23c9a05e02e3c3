"""Reconstruction methods."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from pathlib import Path
from typing import Any, Callable, Dict, Optional, Union

import numpy as np

from . import _core
from .scenes import SceneSet
from .sensor import Sensor, json_of, own


class Solver(_core.Solver):
    """A reconstruction method: fit it once, then reconstruct any number of frames.

    type: "one-step-gn", "tsvd", "contacts", "lean-net", ... (`solver_types()`).
    parameters: those of the type, as in an experiment; `regularisation` is its "lambda" (of "pdipm"
    its "alpha"). "auto" chooses on validation scenes.

        solver = Solver("one-step-gn", prior="noser", regularisation="auto").fit(train)
        images, status = solver.reconstruct(frames)

    Raises InputError for an unknown type or parameter.
    """

    def __init__(self, type: str, **parameters: Any):
        if "regularisation" in parameters:
            parameters["alpha" if type == "pdipm" else "lambda"] = parameters.pop("regularisation")
        super().__init__(json_of({"type": type, **parameters}))
        self.type = type

    def fit(self, on: Union[Sensor, SceneSet, str, os.PathLike],
            validation: Union[SceneSet, str, os.PathLike, None] = None, *, threads: int = 0,
            progress: Union[bool, Callable, None] = None) -> "Solver":
        """Fits the solver and returns it.

        on: the sensor, for methods that need no scenes; or scenes to train on: a SceneSet or a
        dataset file. Only classical parameters given as "auto" and learned methods look at them.
        validation: scenes to choose on; by default others drawn like `on`.
        progress: True for a bar of tqdm's, if it is there; or a function (done, total, text).

        Raises InputError where scenes are needed and missing. Warns where a training went wrong.
        """
        with tempfile.TemporaryDirectory(prefix="ertbench-") as folder:
            files = Path(folder)
            if isinstance(on, _core.Sensor):
                sensor: _core.Sensor = on
                training = None
            else:
                training = self._file(on, files / "train.h5", threads)
                sensor = on.sensor if isinstance(on, SceneSet) else _core.read_scenes(training)[0]
                if validation is None and isinstance(on, SceneSet):
                    validation = _others_like(on)
            chosen = None
            if validation is not None:
                chosen = self._file(validation, files / "validation.h5", threads)
            self._fit(sensor, training, chosen, threads, _progress(progress))
        if self._report:
            warnings.warn(f"{self.type}: the fit ended with {self._report}", stacklevel=2)
        return self

    @staticmethod
    def _file(scenes, place: Path, threads: int) -> str:
        if not isinstance(scenes, SceneSet):
            return os.fspath(scenes)
        scenes.save(place, threads)
        return str(place)

    def contacts(self, frames, reference=None, threads: int = 0) -> np.ndarray:
        """Contacts that the solver finds itself, [N, 8, 6], the strongest first, NaN where absent.

        x and y, mm from the middle of the sheet; radius of the disc of the same area, mm; largest
        change of the conductivity, S/m; standard deviations of x and y, mm. Arguments as for
        `reconstruct`. Raises InputError for solvers that make images alone.
        """
        return self._contacts(frames, reference, threads)

    def save(self, file: Union[str, os.PathLike]) -> None:
        """Writes the fitted solver to a file, for `load` and for "checkpoint" of the program."""
        self._save(os.fspath(file))

    @property
    def sensor(self) -> Optional[Sensor]:
        """The sensor it was fitted for; None before."""
        sensor = self._sensor
        return None if sensor is None else own(sensor)

    @property
    def parameters(self) -> Dict[str, Any]:
        """All parameters, with what the fit chose in place of "auto"."""
        return json.loads(self._parameters)

    def __getstate__(self):
        if self._sensor is None:
            return {"specification": self._specification, "file": None}
        with tempfile.TemporaryDirectory(prefix="ertbench-") as folder:
            file = Path(folder) / "solver.h5"
            self.save(file)
            return {"specification": self._specification, "file": file.read_bytes()}

    def __reduce__(self):
        return (_restored, (self.__getstate__(),))

    def __repr__(self) -> str:
        state = "not fitted" if self._sensor is None else f"fitted for {self.sensor!r}"
        return f"<Solver {self.type}: {state}>"


def _of_specification(text: str) -> Solver:
    spec = json.loads(text)
    return Solver(spec.pop("type"), **spec)


def _restored(state: dict) -> Solver:
    solver = _of_specification(state["specification"])
    if state["file"] is not None:
        with tempfile.TemporaryDirectory(prefix="ertbench-") as folder:
            file = Path(folder) / "solver.h5"
            file.write_bytes(state["file"])
            solver._load(str(file))
    return solver


def _others_like(scenes: SceneSet) -> SceneSet:
    """A tenth as many other scenes of the same kind, 200 at least; listed ones as they are."""
    spec = json.loads(scenes._recipe) if scenes._as_made() else {}
    if not isinstance(spec.get("scenes"), dict):
        return scenes
    spec["count"] = max(200, len(scenes) // 10)
    name = scenes._name + "-validation"
    made = (scenes.voltages[:0], scenes.images[:0], scenes.reference)
    return SceneSet(scenes.sensor, *made, _recipe=json.dumps(spec), _name=name, _made=made)


def _progress(progress):
    if progress is not True:
        return progress or None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    bar = tqdm()

    def update(done, total, text):
        bar.total = total
        bar.set_description(text, refresh=False)
        bar.update(done - bar.n)

    return update


def load(name: Union[str, os.PathLike]) -> Solver:
    """Loads a fitted solver: a file, or the name of one that comes with ertbench ("lean-net-8").

    A file is one that `Solver.save` or a run wrote, or a JSON specification whose "checkpoint" names
    one or its name. Raises InputError where there is none.
    """
    file = Path(_core.fitted_file(os.fspath(name)))
    if file.suffix == ".json":
        try:
            spec = json.loads(file.read_text())
        except ValueError as error:
            raise _core.InputError(f"{file}: is no JSON: {error}") from None
        if not isinstance(spec, dict) or not isinstance(spec.get("type"), str):
            raise _core.InputError(f"{file}: /type: is missing; it names the type of the solver")
        checkpoint = spec.pop("checkpoint", None)
        if checkpoint is None:
            raise _core.InputError(f"{file}: /checkpoint: is missing; it names the file of the "
                                   "fitted solver")
        solver = _of_specification(json.dumps(spec))
        solver._load(_core.fitted_file(checkpoint, str(file.parent)))
        return solver
    solver = _of_specification(_core.specification_of(str(file)))
    solver._load(str(file))
    return solver


def solver_types() -> Dict[str, dict]:
    """Types of solvers: {type: {"summary": text, "parameters": {name: text}}}."""
    return {kind: {"summary": summary, "parameters": parameters}
            for kind, (summary, parameters) in _core.solver_types().items()}
