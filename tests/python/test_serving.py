"""Methods of one's own as rows of the program's tables."""

import importlib.util
import json
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import ertbench as eb

EXAMPLES = Path(__file__).parents[2] / "examples"
SMALL = {"datasets.train.count": 300, "datasets.validation.count": 20, "datasets.test.count": 20}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("ERTBENCH_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", os.path.dirname(sys.executable) + os.pathsep + os.environ["PATH"])


RIDGE = '''
import numpy as np
import ertbench as eb

class Ridge:
    def __init__(self, sensor, ridge):
        self.ridge = ridge
    def fit(self, train, validation):
        changes = train.changes
        print("a word for the log")
        gram = changes.T @ changes
        gram += self.ridge * np.trace(gram) / len(gram) * np.eye(len(gram))
        self.inverse = np.linalg.solve(gram, changes.T @ train.image_changes.reshape(len(train), -1))
        self.shape = train.images.shape[1:]
    def reconstruct(self, changes):
        return (changes @ self.inverse).reshape(-1, *self.shape)

eb.serve(Ridge)
'''


def test_a_class_becomes_a_row(program, tmp_path, refused):
    (tmp_path / "ridge.py").write_text(RIDGE)
    row = {"type": "command", "label": "ridge", "command": [sys.executable, "ridge.py"]}
    kind = {"snr_db": 50, "snr_basis": "absolute", "scenes": {"contacts": [1, 2]}}
    experiment = {
        "title": "t", "question": "q?",
        "datasets": {name: {"count": count, "seed": seed, **kind} for name, count, seed in
                     (("train", 300, 1), ("validation", 30, 2), ("test", 30, 3))},
        "solvers": [{"type": "tsvd", "rank": 30}, {**row, "parameters": {"ridge": 1e-4}},
                    {**row, "label": "wrong", "parameters": {}}]}
    (tmp_path / "e.json").write_text(json.dumps(experiment))
    results = eb.run(tmp_path / "e.json", only=["ridge", "wrong"], set={"datasets.test.count": 20},
                     out=tmp_path / "out")
    rows = {one["label"]: one for one in results.rows}
    assert {"truth", "ridge", "wrong"} <= set(rows) and results.failed
    assert rows["ridge"]["status"] == "ok" and rows["ridge"]["frames"] == 20
    assert 0 < rows["ridge"]["metrics"]["relative_error"]["mean"] < 1
    assert "missing 1 required positional argument: 'ridge'" in json.dumps(rows["wrong"])
    assert "ridge" in results.table
    assert "nowhere.json" in refused(eb.run, tmp_path / "nowhere.json")


WRONG = '''
import ertbench as eb
import numpy as np

class Wrong:
    def __init__(self, sensor, how):
        self.how, self.shape = how, sensor.image_shape
    def fit(self, train, validation): pass
    def reconstruct(self, changes):
        images = np.zeros((len(changes), *self.shape))
        return {"turned": images.transpose(1, 2, 0), "complex": images + 1j, "short": (images, [0]),
                "large": (images, np.full(len(changes), 258))}[self.how]

eb.serve(Wrong)
'''


def test_answers_of_another_shape_are_refused(program, tmp_path):
    (tmp_path / "wrong.py").write_text(WRONG)
    ways = ("turned", "complex", "short", "large")
    experiment = {
        "title": "t", "question": "q?", "timing": {"enabled": False},
        "datasets": {"test": {"count": 30, "seed": 3, "snr_db": 50, "snr_basis": "absolute",
                              "scenes": {"contacts": 1}}},
        "solvers": [{"type": "command", "label": how, "command": [sys.executable, "wrong.py"],
                     "parameters": {"how": how}} for how in ways]}
    (tmp_path / "e.json").write_text(json.dumps(experiment))
    results = eb.run(tmp_path / "e.json", out=tmp_path / "out")
    rows = {one["label"]: one for one in results.rows}
    for how in ways:
        assert rows[how]["status"] != "ok", how
        assert "reconstruct: must return" in json.dumps(rows[how]), rows[how]


FRESH = '''
import numpy as np
import ertbench as eb

class Fresh:
    def __init__(self, sensor, sizes=(), seed=0):
        self.sizes, self.seed = sizes, seed
    def fit(self, train, validation, fresh):
        blocks = [fresh(size) for size in self.sizes]
        changes, images = (np.concatenate(part) for part in zip(*blocks))
        np.savez(f"drawn-{self.seed}-{len(self.sizes)}.npz", changes=changes, images=images)
        self.mean = images.mean(0)
        print("fits")
    def reconstruct(self, changes):
        return np.broadcast_to(self.mean, (len(changes), *self.mean.shape))

eb.serve(Fresh)
'''


def test_fresh_scenes_do_not_depend_on_the_blocks(program, tmp_path, sensor):
    (tmp_path / "fresh.py").write_text(FRESH)
    row = {"type": "command", "command": [sys.executable, "fresh.py"], "protocol": 2}
    solvers = [{**row, "label": "one", "parameters": {"sizes": [60]}, "seeds": [1, 2]},
               {**row, "label": "many", "parameters": {"sizes": [7, 7, 40, 1, 5]}, "seed": 1},
               {**row, "label": "first", "parameters": {"sizes": [1]}, "protocol": 1}]
    experiment = json.loads((EXAMPLES / "numpy_ridge.json").read_text())
    del experiment["$schema"]
    experiment.update(solvers=solvers, timing={"enabled": False})
    (tmp_path / "e.json").write_text(json.dumps(experiment))
    results = eb.run(tmp_path / "e.json", set=SMALL, out=tmp_path / "out")
    rows = {one["label"]: one for one in results.rows}
    one, many, other = (np.load(tmp_path / f"drawn-{name}.npz") for name in ("1-1", "1-5", "2-1"))
    for part in ("changes", "images"):
        np.testing.assert_array_equal(one[part], many[part])
        assert not np.array_equal(one[part], other[part])
    # Frames and images belong together, in whatever symmetry both are.
    solver = eb.Solver("one-step-gn", prior="noser", regularisation=0.3).fit(sensor)
    made = solver.reconstruct(one["changes"], reference=0)[0].reshape(60, -1)
    alike = [np.corrcoef(a, b)[0, 1] for a, b in zip(made, one["images"].reshape(60, -1))]
    assert min(alike) > 0.2 and np.median(alike) > 0.6
    assert rows["one"]["seeds"]["values"] == [1, 2]
    assert rows["many"]["parameters"]["parameters"]["fresh_scenes"] == 60
    assert rows["first"]["status"] == "failed"
    assert 'give the row "protocol": 2' in rows["first"]["message"]


def test_the_example_is_fitted_once_for_each_seed(program, tmp_path):
    if not importlib.util.find_spec("torch"):
        pytest.skip("needs python3-torch")
    for name in ("torch_network.py", "torch_network.json", "numpy_ridge.json"):
        shutil.copy(EXAMPLES / name, tmp_path)
    results = eb.run(tmp_path / "torch_network.json", only=["torch network"], out=tmp_path / "out", set={
        **SMALL, "solvers.2.seeds": [1, 2], "solvers.2.parameters.scenes": 1280,
        "timing": {"frames": 662, "rounds": 1}})
    row = next(row for row in results.rows if row["label"] == "torch network")
    assert row["status"] == "ok" and row["metrics"]["relative_error"]["mean"] < 1
    assert row["seeds"]["values"] == [1, 2] and "over 2 seeds" in results.table
    assert row["seeds"]["deviation"]["relative_error"] > 0
    logs = list((tmp_path / "out" / "records").glob("torch network*.log"))
    trained = [log.name for log in logs if "step 0 of 20" in log.read_text()]
    assert len(logs) > 2 and all("accuracy" in name for name in trained) and len(trained) == 2
