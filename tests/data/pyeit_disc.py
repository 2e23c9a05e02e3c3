"""Voltages of pyEIT's circular model with 16 point electrodes, adjacent drive and measurement, on two
meshes: uniform, and with one disc of radius 0.2 and conductivity 0.5 at (0.3, 0.2). Writes
pyeit_disc.json. pyEIT as eitcom/pyEIT on GitHub has it, commit 3ed2fca.
Run: PYTHONPATH=.../pyEIT python3 pyeit_disc.py
"""
import json
import pathlib

import numpy as np
import pyeit.eit.protocol as protocol
import pyeit.mesh as mesh
from pyeit.eit.fem import EITForward

L, CENTRE, RADIUS, RATIO = 16, np.array([0.3, 0.2]), 0.2, 0.5


def voltages(model, conductivity):
    """[L, L] potentials by drive to [208]: drive k is -1 at k and +1 at k+1, reads V_j - V_(j+1)."""
    model.assemble_pde(conductivity)
    drives = np.array([[(k + 1) % L, k] for k in range(L)])
    potentials = model.solve_vectorized(drives)[:, model.mesh.el_pos]
    return [potentials[k, j] - potentials[k, (j + 1) % L] for k in range(L) for j in range(L)
            if (j - k) % L not in (0, 1, L - 1)]


def share_in_disc(points, elements):
    a, b = np.meshgrid((np.arange(15) + 0.5) / 15, (np.arange(15) + 0.5) / 15)
    a, b = a.ravel(), b.ravel()
    flip = a + b > 1
    a[flip], b[flip] = 1 - a[flip], 1 - b[flip]
    p, q, r = (points[elements[:, k], :2] for k in range(3))
    at = p[:, None] + a[None, :, None] * (q - p)[:, None] + b[None, :, None] * (r - p)[:, None]
    return (np.linalg.norm(at - CENTRE, axis=2) < RADIUS).mean(axis=1)


if __name__ == "__main__":
    out = {"centre": CENTRE.tolist(), "radius": RADIUS, "ratio": RATIO, "current": 1, "background": 1}
    for name, size in (("coarse", 0.06), ("fine", 0.035)):
        np.random.seed(1)
        circle = mesh.create(L, h0=size)
        model = EITForward(circle, protocol.create(L, dist_exc=1, step_meas=1, parser_meas="std"))
        share = share_in_disc(circle.node, circle.element)
        places = circle.node[circle.el_pos, :2]
        out[name] = {"elements": len(circle.element),
                     "electrodes": np.round(places, 12).ravel().tolist(),
                     "reference": voltages(model, np.ones(len(circle.element))),
                     "inclusion": voltages(model, 1 - (1 - RATIO) * share)}
    path = pathlib.Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(out, separators=(",", ":")) + "\n", encoding="utf-8")
