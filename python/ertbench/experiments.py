"""Experiments of the program."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Union

from . import _core
from .sensor import json_of


class Results:
    """Results of an experiment: `rows`, one dict a method; `summary`, the whole summary.json;
    `folder`, with tables, figures and report.html; `failed`, whether a row or figure failed."""

    def __init__(self, folder: Union[str, os.PathLike], failed: bool = False):
        self.folder, self.failed = Path(folder), failed
        self.summary: Dict[str, Any] = json.loads((self.folder / "summary.json").read_text())
        self.rows: List[dict] = self.summary.get("rows", self.summary.get("results", []))

    @property
    def table(self) -> str:
        """The table as text (Markdown)."""
        return (self.folder / "table.md").read_text()

    def to_pandas(self):
        """A DataFrame with a row for each method, columns such as "metrics.RIE.mean"."""
        import pandas

        return pandas.json_normalize(self.rows)

    def __repr__(self) -> str:
        return f"<Results: {len(self.rows)} rows in {self.folder}>"


def _program() -> str:
    built = Path(__file__).resolve().parent / "../../bench/ertbench"
    for place in (os.environ.get("ERTBENCH_PROGRAM"), built, shutil.which("ertbench"),
                  Path(_core.project_folder) / "ertbench"):
        if place and os.access(place, os.X_OK):
            return os.fspath(place)
    raise _core.InputError("run: the program ertbench is not found; install it, or name it in "
                           "$ERTBENCH_PROGRAM")


def run(experiment: Union[str, os.PathLike], only: Optional[Sequence[str]] = None,
        set: Optional[Dict[str, Any]] = None, out: Union[str, os.PathLike, None] = None,
        fresh: bool = False) -> Results:
    """Runs an experiment by the program, as `ertbench run` does, and returns its results.

    only: labels of the rows to run. set: values to replace, {"datasets.test.count": 100}.
    out: folder of the results; by default results/NAME in the working folder.
    fresh: forget what an earlier run finished.

    Progress goes to standard error. Raises InputError with the program's message where the
    experiment cannot be used, RuntimeError where the program fails; a row that failed is in the
    results, see `Results.failed`.
    """
    folder = Path(out) if out else Path("results") / Path(experiment).stem
    command = [_program(), "run", os.fspath(experiment), "--out", str(folder)]
    if only:
        command += ["--only", ",".join(only)]
    for place, value in (set or {}).items():
        command += ["--set", f"{place}={json_of(value)}"]
    command += ["--fresh"] if fresh else []
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said: List[str] = []
    try:
        for line in process.stderr:  # type: ignore
            said.append(line.rstrip())
            os.write(2, line.encode())
    finally:
        process.wait()  # Ctrl-C reaches it, too
    if process.returncode == 2:
        raise _core.InputError("\n".join(said[-5:]))
    if process.returncode not in (0, 1):
        raise RuntimeError(f"ertbench run ended with {process.returncode}: " + "\n".join(said[-5:]))
    return Results(folder, process.returncode == 1)
