"""The page's examples, run in order as one program."""

import os
import re
from pathlib import Path

import pytest

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


def test_the_page_of_methods_shows_the_example():
    page, examples = (DOCS / "your_method.md").read_text(), DOCS.parent / "examples"
    assert "```python\n" + (examples / "torch_network.py").read_text() + "```" in page
    assert "```json\n" + (examples / "torch_network.json").read_text() + "```" in page
