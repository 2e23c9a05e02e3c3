"""A method of one's own as a row of the program's tables."""

from __future__ import annotations

import inspect
import json
import os
import pickle
import sys
import traceback
from pathlib import Path
from typing import Any, BinaryIO, Tuple

import numpy as np

from .scenes import read_scenes
from .sensor import Sensor


class _Fresh:
    """Fresh scenes from the program, by protocol 2; the next ones are asked for ahead."""

    most = 1 << 16  # at a time

    def __init__(self, stdin: BinaryIO, stdout: BinaryIO, told: dict):
        self.stdin, self.stdout = stdin, stdout
        self.shapes = [(told["channels"],), tuple(told["image"])]
        self.left = [np.empty((0, *shape)) for shape in self.shapes]
        self.asked = self.drawn = 0

    def __call__(self, count: int) -> Tuple[np.ndarray, np.ndarray]:
        while len(self.left[0]) < count:
            if not self.asked:
                self.ask(count)
            self.take()
            self.ask(count)
        self.drawn += count
        out = self.left[0][:count], self.left[1][:count]
        self.left = [rows[count:] for rows in self.left]
        return out

    def ask(self, count: int) -> None:
        self.asked = min(count, self.most)
        self.stdout.write(json.dumps({"scenes": self.asked}).encode() + b"\n")
        self.stdout.flush()

    def take(self) -> None:
        """Reads what was asked for, if anything."""
        for part, shape in enumerate(self.shapes):
            rows = np.frombuffer(self.stdin.read(8 * self.asked * int(np.prod(shape))))
            self.left[part] = np.concatenate([self.left[part], rows.reshape(self.asked, *shape)])
        self.asked = 0


def serve(method: type) -> None:
    """Serves a class as a solver of the type "command" (docs/your_method.md); returns at the end.

        class Ridge:
            def __init__(self, sensor, ridge=1e-4): ...  # "parameters" of the experiment
            def fit(self, train, validation): ...        # SceneSets, or None
            def reconstruct(self, changes): ...          # [n, channels] V -> [n, rows, columns] S/m

        if __name__ == "__main__":
            ertbench.serve(Ridge)

    and in the experiment {"type": "command", "command": ["python3", "ridge.py"], "parameters": {}}.
    `reconstruct` may return (images, status) with the [n] statuses of `Solver.reconstruct`. What the
    class prints goes to the log. An exception in `fit` fails the row with its message.

    With "seeds" in the experiment `__init__` gets `seed`. With "protocol": 2 there a
    `fit(self, train, validation, fresh)` gets new scenes of the training set's kind, any number:
    `changes, images = fresh(256)`, [256, channels] V and [256, rows, columns] S/m (changes). They go on
    behind those of `train`, each turned by a random symmetry of the sensor, with noise.

    The fitted object is pickled into the work folder of the fit; where that is possible it is not
    fitted again when the program is started again.
    """
    stdin = sys.stdin.buffer
    stdout = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # prints of the class must not end up among the images
    told = json.loads(stdin.readline())
    os.environ["ERTBENCH_THREADS"] = str(told["threads"])
    try:
        served, parameters = _fitted(method, told, stdin, stdout)
        answer = {"ready": True, "parameters": parameters}
    except Exception as error:
        traceback.print_exc()
        answer = {"error": f"{type(error).__name__}: {error}"}
    stdout.write(json.dumps(answer).encode() + b"\n")
    stdout.flush()
    channels, pixels = told["channels"], told["image"][0] * told["image"][1]
    while "ready" in answer and (header := stdin.read(8)):
        count = int.from_bytes(header, "little")
        changes = np.frombuffer(stdin.read(8 * count * channels)).reshape(count, channels)
        made = served.reconstruct(changes)
        images, status = made if isinstance(made, tuple) else (made, np.zeros(count, int))
        images, status = np.asarray(images), np.asarray(status)
        if images.dtype.kind not in "fiub" or images.shape not in ((count, pixels),
                                                                   (count, *told["image"])):
            raise ValueError(f"reconstruct: must return real numbers [{count}, rows, columns], got "
                             f"{images.dtype} {list(images.shape)}")
        if status.shape != (count,) or not np.isin(status, (0, 1, 2, 3)).all():
            raise ValueError(f"reconstruct: must return {count} statuses of 0 to 3")
        stdout.write(images.astype(np.float64).tobytes() + status.astype(np.uint8).tobytes())
        stdout.flush()


def _fitted(method: type, told: dict, stdin: BinaryIO, stdout: BinaryIO) -> Tuple[Any, dict]:
    """The fitted object and the parameters that stand in its row."""
    kept = Path(told["work_folder"]) / "fitted.pickle"
    if kept.exists():
        return pickle.loads(kept.read_bytes())
    parameters = dict(told["parameters"])
    keywords = dict(parameters, **({"seed": told["seed"]} if "seed" in told else {}))
    served = method(Sensor._of(json.dumps(told["sensor"])), **keywords)
    sets = [read_scenes(told[key]) if told[key] else None for key in ("train", "validation")]
    if "fresh" in inspect.signature(served.fit).parameters:
        if told["protocol"] < 2:
            raise ValueError('fit takes fresh scenes; give the row "protocol": 2')
        fresh = _Fresh(stdin, stdout, told)
        served.fit(*sets, fresh=fresh)
        fresh.take()
        parameters["fresh_scenes"] = fresh.drawn
    else:
        served.fit(*sets)
    try:
        whole = pickle.dumps((served, parameters))
        kept.with_suffix(".part").write_bytes(whole)
        kept.with_suffix(".part").replace(kept)
    except Exception as error:
        print(f"is fitted again at each start, as it is not pickled: {error}", file=sys.stderr)
    return served, parameters
