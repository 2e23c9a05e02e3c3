"""The page's examples, run in order as one program."""

import os
import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "python.md"


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
