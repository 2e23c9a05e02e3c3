"""The command with which docs/python.md installs the package, into a folder."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

import ertbench as eb

PROJECT = Path(__file__).parents[2]
COMMAND = "pip install --no-build-isolation ./python"
USE = """
import re, ertbench as eb
frame = eb.ForwardModel(eb.Sensor("d2s")).voltages(eb.Disc((20, -30), radius=15, ratio=0.4))
print(frame.shape, eb.__file__)
print(*set(re.findall(r"/.*libertbench_.*", open("/proc/self/maps").read())), sep="\\n")
"""


def test_pip_installs_what_works_alone(program, tmp_path):
    if not all(importlib.util.find_spec(name) for name in ("pip", "setuptools")):
        pytest.skip("needs python3-pip and python3-setuptools")
    build = Path(eb.__path__[0]).parents[1]
    if not (build / "CMakeCache.txt").is_file():
        pytest.skip("the package is not that of a build folder")
    assert COMMAND in (PROJECT / "docs" / "python.md").read_text()
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run([sys.executable, "-m", *COMMAND.split(), "--target", str(tmp_path / "site"),
                           "--no-index", "--no-deps"], cwd=PROJECT, capture_output=True, text=True,
                          env=dict(environment, ERTBENCH_BUILD=str(build)))
    assert done.returncode == 0, done.stdout + done.stderr
    used = subprocess.run([sys.executable, "-c", USE], cwd=tmp_path, capture_output=True, text=True,
                          env=dict(environment, PYTHONPATH=str(tmp_path / "site")))
    said = used.stdout.splitlines()
    assert said[0] == f"(208,) {tmp_path / 'site' / 'ertbench' / '__init__.py'}", used.stderr
    assert len(said) > 3 and all(str(tmp_path) in library for library in said[1:]), used.stdout
