"""What calls from Python cost: prints a table, in Markdown.

    python3 python/benchmarks/calls.py [SCENES]

Beside them: the program `ertbench` where it is found ($ERTBENCH_PROGRAM). SCENES are drawn and
generated, 2000 by default. Each number is the least of several tries, as other programs only add to
it. beside_pyeit.py compares with pyEIT.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import ertbench as eb
from ertbench.experiments import _program


def least_s(call, tries=5):
    """The least time of a call, s."""
    times = []
    for _ in range(tries):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def of_a_frame(solver, frame, tries=20000):
    """The median time of one frame, us."""
    times = np.empty(tries)
    for i in range(tries):
        start = time.perf_counter_ns()
        solver.reconstruct(frame)
        times[i] = time.perf_counter_ns() - start
    return np.median(times) / 1000


def program_generates(folder, count):
    """Scenes a second of `ertbench generate`, its start included."""
    experiment = {"title": "t", "question": "q?", "solvers": [{"type": "tsvd", "rank": 30}], "datasets": {
        "test": {"count": count, "grid": "auto", "snr_db": 50, "snr_basis": "absolute",
                 "scenes": {"contacts": [1, 3]}}}}
    file = Path(folder) / "e.json"
    file.write_text(json.dumps(experiment))
    out = Path(folder) / "test.h5"

    def generate():
        out.unlink(missing_ok=True)
        subprocess.run([_program(), "generate", str(file), "--dataset", "test", "--out", str(out)],
                       check=True, capture_output=True)

    return count / least_s(generate, 3)


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    sensor = eb.Sensor()
    scenes = eb.Scenes(sensor, contacts=(1, 3), name="test")
    drawn = scenes.draw(2000, 50)
    exact, grid = eb.ForwardModel(sensor), eb.ForwardModel(sensor, 24)
    solver = eb.Solver("one-step-gn", prior="noser", regularisation=0.3).fit(sensor)
    frames = np.resize(drawn.voltages, (10000, sensor.channels))
    tiny = eb.Sensor(electrode_count=8, image_grid=4, electrode_offset=0.5)
    small = eb.Solver("one-step-gn", regularisation=0.3).fit(tiny)
    listed = [drawn.scene(i) for i in range(1000)]
    rows = [
        ("voltages of 1000 images, 24 grid", f"{1000 / least_s(lambda: grid.voltages(drawn.images[:1000])):.0f} a second"),
        ("voltages of 1000 scenes, exact", f"{1000 / least_s(lambda: exact.voltages(listed), 2):.0f} a second"),
        ("Jacobian, exact", f"{1000 * least_s(exact.jacobian):.1f} ms"),
        ("one-step-gn, 10 000 frames", f"{10000 / least_s(lambda: solver.reconstruct(frames)):.0f} a second"),
        ("one-step-gn, one frame", f"{of_a_frame(solver, frames[0]):.1f} us"),
        ("a call as such: one frame of 8 electrodes, 4 x 4 pixels",
         f"{of_a_frame(small, small.reference):.1f} us"),
        ("drawing exact scenes", f"{count / least_s(lambda: scenes.draw(count, 50), 3):.0f} a second"),
    ]
    with tempfile.TemporaryDirectory() as folder:
        try:
            rows.append(("the same by `ertbench generate`", f"{program_generates(folder, count):.0f} a second"))
        except eb.InputError as error:
            rows.append(("`ertbench generate`", str(error)))
    print("| call | |\n|---|---:|")
    for name, value in rows:
        print(f"| {name} | {value} |")


if __name__ == "__main__":
    main()
