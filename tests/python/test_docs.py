"""The page's examples, run in order as one program."""

import json
import os
import re
import sys
from pathlib import Path

import pytest

import ertbench as eb

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "python.md"


def test_the_pages_examples_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) >= 7
    names = {}
    for number, block in enumerate(blocks):
        try:
            exec(compile(block, f"{PAGE.name}, block {number}", "exec"), names)
        except Exception as error:
            pytest.fail(f"block {number}: {error!r}\n{block}")
    said = capsys.readouterr().out
    assert "relative_error" in said and "pressed at" in said
    assert os.path.exists("gn.h5")


README = DOCS.parent / "README.md"


def test_the_front_pages_examples_work(program, tmp_path, monkeypatch, capsys):
    method, session = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    exec(compile(session, "README.md", "exec"), {})
    assert "relative_error" in capsys.readouterr().out
    (tmp_path / "ridge.py").write_text(method)
    row = json.loads(re.search(r"`(\{\"type\": \"command\".*?\})`", README.read_text())[1])
    row["command"][0] = sys.executable
    experiment = json.loads((DOCS.parent / "examples" / "numpy_ridge.json").read_text())
    del experiment["$schema"]
    (tmp_path / "e.json").write_text(json.dumps({**experiment, "solvers": [{**row, "label": "ridge"}]}))
    monkeypatch.setenv("ERTBENCH_CACHE", str(tmp_path / "cache"))
    results = eb.run(tmp_path / "e.json", out=tmp_path / "out",
                     set={"datasets.train.count": 300, "datasets.validation.count": 20, "datasets.test.count": 20})
    ridge = next(one for one in results.rows if one["label"] == "ridge")
    assert ridge["status"] == "ok" and 0 < ridge["metrics"]["relative_error"]["mean"] < 1
