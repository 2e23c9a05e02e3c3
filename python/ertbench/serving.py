"""A method of one's own as a row of the program's tables."""

from __future__ import annotations

import json
import os
import sys
import traceback

import numpy as np

from .scenes import read_scenes
from .sensor import Sensor


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
    """
    stdin = sys.stdin.buffer
    stdout = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # prints of the class must not end up among the images
    told = json.loads(stdin.readline())
    try:
        served = method(Sensor._of(json.dumps(told["sensor"])), **told["parameters"])
        served.fit(*(read_scenes(told[key]) if told[key] else None for key in ("train", "validation")))
        answer = {"ready": True, "parameters": told["parameters"]}
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
        images, status = made if isinstance(made, tuple) else (made, np.zeros(count))
        images = np.ascontiguousarray(images, dtype=np.float64).reshape(count, pixels)
        stdout.write(images.tobytes() + np.asarray(status, dtype=np.uint8).tobytes())
        stdout.flush()
