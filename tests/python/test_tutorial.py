"""The notebook, run from end to end, and what it keeps of its last run."""

import base64
import importlib.util
import json
import os
import struct
import sys

import pytest
from tutorial import NOTEBOOK, run


def pictures_of(notebook):
    """The pictures in the outputs of each cell, as bytes of PNG files."""
    outputs = [cell.get("outputs", []) for cell in notebook["cells"]]
    return [[base64.b64decode(one["data"]["image/png"]) for one in some if "data" in one]
            for some in outputs]


def test_runs_and_keeps_its_pictures(program, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    pytest.importorskip("PIL")
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setenv("ERTBENCH_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", os.path.dirname(sys.executable) + os.pathsep + os.environ["PATH"])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    kept, notebook = json.loads(NOTEBOOK.read_text()), json.loads(NOTEBOOK.read_text())
    names = run(notebook, tmp_path)
    assert [len(some) for some in pictures_of(notebook)] == [len(some) for some in pictures_of(kept)]
    results = names["results"]
    assert not results.failed
    errors = {row["label"]: row["metrics"]["relative_error"]["mean"] for row in results.rows}
    assert errors["ridge"] < errors["one-step-gn"] < errors["no-contact"]
    if importlib.util.find_spec("torch"):
        row = next(row for row in results.rows if row["label"] == "network")
        assert row["seeds"]["values"] == [1, 2] and row["seeds"]["deviation"]["relative_error"] > 0
        assert row["parameters"]["parameters"]["fresh_scenes"] == 8000
        assert errors["network"] < errors["one-step-gn"]


def test_is_small_and_whole():
    assert NOTEBOOK.stat().st_size < 300_000
    notebook = json.loads(NOTEBOOK.read_text())
    pictures = [picture for some in pictures_of(notebook) for picture in some]
    assert len(pictures) >= 5
    for picture in pictures:
        width, height, depth, colours = struct.unpack(">IIBB", picture[16:26])
        assert 200 < width < 1000 and 100 < height < 600
        assert colours == 3  # of a palette
    for cell in notebook["cells"]:
        assert not any(one["output_type"] == "error" for one in cell.get("outputs", []))
