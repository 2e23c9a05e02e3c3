"""The types of the package: by mypy where it is, and the stub of the C++ module against the module."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import ertbench as eb

FOLDER = Path(eb.__path__[0])


def test_mypy_has_nothing_to_say(tmp_path):
    mypy = [sys.executable, "-m", "mypy"]
    if subprocess.run([*mypy, "--version"], capture_output=True).returncode != 0:
        pytest.skip("python3-mypy is not installed")
    (tmp_path / "use.py").write_text("import ertbench as eb\n"
                                     "frames = eb.ForwardModel(eb.Sensor('d2s')).voltages([])\n"
                                     "reveal_type(frames)\neb.Sensor().nothing\n")
    done = subprocess.run([*mypy, "--cache-dir", str(tmp_path / "cache"), "--ignore-missing-imports",
                           str(FOLDER), "use.py"], capture_output=True, text=True, cwd=tmp_path)
    said = done.stdout.splitlines()
    assert [line for line in said if "error" in line and not line.startswith(("use.py", "Found"))] == []
    assert any("ndarray" in line for line in said), done.stdout  # py.typed: users see the types
    assert any('"Sensor" has no attribute "nothing"' in line for line in said), done.stdout


def functions(body):
    return {node.name: [one.arg for one in node.args.args] for node in body
            if isinstance(node, ast.FunctionDef)}


def named(body):
    """Names that a body of the stub gives, without functions."""
    return {node.target.id for node in body if isinstance(node, ast.AnnAssign)}


def signature_of(function):
    """The parameters that pybind11 writes at the head of a docstring."""
    inside = function.__doc__.split("(", 1)[1].rsplit(") ->", 1)[0]
    names = [part.split(":")[0].strip() for part in inside.split(", ") if ":" in part]
    return [name for name in names if name.isidentifier()]


def test_the_stub_is_that_of_the_module():
    from ertbench import _core

    stub = ast.parse((FOLDER / "_core.pyi").read_text())
    classes = {node.name: node.body for node in stub.body if isinstance(node, ast.ClassDef)}
    there = {name for name in vars(_core) if not name.startswith("__")}
    assert there == set(classes) | set(functions(stub.body)) | named(stub.body)
    for name, parameters in functions(stub.body).items():
        assert len(signature_of(getattr(_core, name))) == len(parameters), name
    for name, body in classes.items():
        members = {member for member, value in vars(getattr(_core, name)).items()
                   if not member.startswith("__") or member == "__init__" and inspect.isroutine(value)}
        assert members - {"__init__"} <= set(functions(body)) | named(body), name
        for member in set(functions(body)) - {"__init__"}:
            assert len(signature_of(getattr(getattr(_core, name), member))) == len(
                functions(body)[member]), f"{name}.{member}"
        for member in named(body):
            assert hasattr(getattr(_core, name), member), f"{name}.{member}"
