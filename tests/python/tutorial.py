"""Runs docs/tutorial.ipynb from end to end, as Jupyter does, and needs no Jupyter.

    python3 tests/python/tutorial.py           # in a folder that goes away
    python3 tests/python/tutorial.py --keep    # keeps what the cells print and draw in the notebook

Cells with the tag "torch" are left out where PyTorch is not installed.
"""

import base64
import contextlib
import importlib.util
import io
import json
import os
import sys
import tempfile
from pathlib import Path

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "tutorial.ipynb"


def pictures():
    """The figures that are open, as outputs of a cell, in 256 colours; closes them."""
    import matplotlib.pyplot as plt
    from PIL import Image

    outputs = []
    for number in plt.get_fignums():
        drawn, small = io.BytesIO(), io.BytesIO()
        plt.figure(number).savefig(drawn, format="png", dpi=75)
        Image.open(drawn).convert("RGB").quantize(256).save(small, format="png", optimize=True)
        outputs.append({"output_type": "display_data", "metadata": {},
                        "data": {"image/png": base64.b64encode(small.getvalue()).decode() + "\n"}})
    plt.close("all")
    return outputs


def run_cell(source, names):
    """Runs one cell in the working folder and returns its outputs."""
    if source.startswith("%%writefile "):
        first, text = source.split("\n", 1)
        Path(first.split()[1]).write_text(text + "\n")
        return []
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(source, "tutorial", "exec"), names)
    text = [{"output_type": "stream", "name": "stdout",
             "text": said.getvalue().splitlines(keepends=True)}]
    return (text if said.getvalue() else []) + pictures()


def run(notebook, folder):
    """Runs the cells in a folder, with their outputs in the notebook's; returns their names."""
    pictures()  # those of others who draw in this process
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    names, count = {"__name__": "__main__"}, 0
    for cell in notebook["cells"]:
        left_out = ("torch" in cell["metadata"].get("tags", [])
                    and importlib.util.find_spec("torch") is None)
        if cell["cell_type"] == "code" and not left_out:
            count += 1
            cell["outputs"], cell["execution_count"] = run_cell("".join(cell["source"]), names), count
    return names


def main():
    os.environ["MPLBACKEND"] = "agg"
    notebook = json.loads(NOTEBOOK.read_text())
    with tempfile.TemporaryDirectory() as folder:
        run(notebook, Path(folder))
        os.chdir("/")
    if "--keep" in sys.argv:
        NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
