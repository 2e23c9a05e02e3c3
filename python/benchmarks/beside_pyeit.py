"""Beside pyEIT in one process: prints a table, in Markdown.

    PYEIT=FOLDER python3 python/benchmarks/beside_pyeit.py

pyEIT (github.com/eitcom/pyEIT, BSD) is imported from the environment or from the folder that $PYEIT
names; without it nothing is measured. It gets the mesh of our grid model, two triangles a pixel with
electrodes on nodes, and the sensor's protocol, so that both compute the same voltages, which is checked.
Each number is the least of several tries; both have one thread, as pyEIT's solver has.
"""

import os
import sys
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "ERTBENCH_THREADS"):
    os.environ[variable] = "1"

import numpy as np

import ertbench as eb

sys.path[:0] = [os.environ["PYEIT"]] if "PYEIT" in os.environ else []
try:
    from pyeit.eit.fem import EITForward
    from pyeit.eit.jac import JAC
    from pyeit.mesh.wrapper import PyEITMesh
except ImportError as error:
    sys.exit(f"skipped: {error}; name the folder of pyEIT in $PYEIT")


def least_s(call, tries=5):
    """The least time of a call, s."""
    times = []
    for _ in range(tries):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def mesh_of(sensor):
    """The triangles of the grid model, in domain units."""
    side = sensor.image_shape[0]
    places = np.linspace(-1, 1, side + 1)
    x, y = np.meshgrid(places, places)
    corner = (np.arange(side) + (side + 1) * np.arange(side)[:, np.newaxis]).ravel()
    lower = np.column_stack([corner, corner + 1, corner + side + 2])
    upper = np.column_stack([corner, corner + side + 2, corner + side + 1])
    nodes = np.column_stack([x.ravel(), y.ravel()])
    at = [np.linalg.norm(nodes - place / sensor.unit_mm, axis=1).argmin()
          for place in sensor.electrodes_mm]
    return PyEITMesh(node=nodes, element=np.stack([lower, upper], 1).reshape(-1, 3),
                     perm=sensor.background, el_pos=np.array(at), ref_node=(side // 2) * (side + 2))


def main():
    sensor = eb.Sensor("d2s")
    scenes = eb.Scenes(sensor, contacts=(1, 3), shapes=["disc", "ellipse"])
    drawn = scenes.draw(1000, 50)
    grid, exact = eb.ForwardModel(sensor, 24), eb.ForwardModel(sensor)
    mesh, protocol = mesh_of(sensor), sensor.to_pyeit()
    theirs = EITForward(mesh, protocol)
    elements = np.repeat(drawn.images.reshape(1000, -1), 2, axis=1)  # two triangles a pixel
    voltages = sensor.drive_current * theirs.solve_eit(perm=elements[0])
    ours = grid.voltages(drawn.images[0])
    worst = np.linalg.norm(voltages - ours) / np.linalg.norm(ours)
    print(f"voltages differ by {worst:.1e} of their norm\n")

    solver = eb.Solver("one-step-gn", prior="noser", regularisation=0.3).fit(sensor)
    frames = np.resize(drawn.voltages, (10000, sensor.channels))
    jac = JAC(mesh, protocol)
    jac.setup(p=0.5, lamb=0.01, method="kotre", perm=sensor.background)
    listed = [drawn.scene(i) for i in range(1000)]
    forward_s = least_s(lambda: [theirs.solve_eit(perm=one) for one in elements[:20]], 3) * 50
    rows = [
        ("voltages of 1000 images, 24 grid", least_s(lambda: grid.voltages(drawn.images)), forward_s),
        ("voltages of 1000 scenes, exact", least_s(lambda: exact.voltages(listed), 3), None),
        ("Jacobian at an image, 24 grid", least_s(lambda: grid.jacobian(drawn.images[0])),
         least_s(lambda: theirs.compute_jac(perm=elements[0]), 3)),
        ("10 000 frames by Gauss-Newton", least_s(lambda: solver.reconstruct(frames)),
         least_s(lambda: jac.solve(frames, solver.reference, normalize=False), 3)),
        ("1000 frames, one at a time",
         least_s(lambda: [solver.reconstruct(one) for one in frames[:1000]]),
         least_s(lambda: [jac.solve(one, solver.reference, normalize=False)
                          for one in frames[:1000]], 3)),
    ]
    print("| call | ertbench | pyEIT | ratio |\n|---|---:|---:|---:|")
    for name, mine, other in rows:
        beside = f"{1000 * other:.4g} ms | {other / mine:.3g}" if other else "| "
        print(f"| {name} | {1000 * mine:.4g} ms | {beside} |")


if __name__ == "__main__":
    main()
