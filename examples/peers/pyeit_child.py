"""pyEIT as a command: its methods JAC, BP and GREIT on the sheet of the experiment.

    {"type": "command", "command": ["python3", "peers/pyeit_child.py"],
     "parameters": {"method": "jac", "folder": "$PYEIT"}}

pyEIT itself is not here (get.sh says where it is); it is imported from the environment, or from the
folder that the environment variable PYEIT names. It gets the mesh that the benchmark's own model has:
two right triangles a pixel, point electrodes on the nodes of the border, currents and voltages between
neighbours.

"method"    "jac" (EITForward's Jacobian, (J'J + lamb R)^-1 J'), "bp" (back projection along
            equipotential lines) or "greit" (with pyEIT's distribution method).
"p"         the exponent of R = diag(J'J)^p, as pyEIT has it; default 0.5 (as in its examples).
"lamb"      > 0, or "auto" (the default): the one of a ladder of decades and half decades that has the
            least mean relative error on the validation set.

BP and GREIT give images in units of their own; those are scaled by the one factor that fits the
validation set best, which is reported as "gain". All else is what pyEIT makes of its arguments.
"""

import json
import os
import sys

stdin, stdout = sys.stdin.buffer, sys.stdout.buffer
told = json.loads(stdin.readline())


def answer(line):
    stdout.write(json.dumps(line).encode() + b"\n")
    stdout.flush()


def refuse(why):
    answer({"error": why})
    sys.exit(1)


if os.environ.get("PYEIT"):
    sys.path.insert(0, os.environ["PYEIT"])
try:
    import h5py
    import numpy as np
    from pyeit.eit.bp import BP
    from pyeit.eit.greit import GREIT
    from pyeit.eit.jac import JAC
    from pyeit.eit.protocol import PyEITProtocol
    from pyeit.mesh.wrapper import PyEITMesh
except ImportError as error:
    refuse(f"{error}: examples/peers/get.sh says where pyEIT is; name its folder in $PYEIT")

sensor = told["sensor"]
side, electrodes = told["image"][0], sensor["electrode_count"]
background, current = told["background"], sensor["drive_current"]
method = told["parameters"].get("method", "jac")
p = told["parameters"].get("p", 0.5)
lamb = told["parameters"].get("lamb", "auto")


def border_node(distance):
    """The node at a distance along the border, clockwise from the top left corner."""
    edge, along = divmod(round(distance / (2 / side)) % (4 * side), side)
    column, row = [(along, side), (side, side - along), (side - along, 0), (0, along)][edge]
    return column + (side + 1) * row


def mesh_of_sheet():
    places = np.linspace(-1, 1, side + 1)
    x, y = np.meshgrid(places, places)
    triangles = []
    for row in range(side):
        for column in range(side):
            a = column + (side + 1) * row
            b, c, d = a + 1, a + side + 1, a + side + 2
            triangles += [[a, b, d], [a, d, c]]
    nodes = np.column_stack([x.ravel(), y.ravel()])
    distances = sensor["electrode_offset"] + 8 / electrodes * np.arange(electrodes)
    at = np.array([border_node(distance) for distance in distances])
    centre = (side // 2) * (side + 2)
    return PyEITMesh(node=nodes, element=np.array(triangles), perm=background, el_pos=at,
                     ref_node=centre)


def protocol_of_sheet():
    """Drive k takes the current out of electrode k + 1 into the sheet and in again at k."""
    drives, measured = [], []
    for drive in range(electrodes):
        drives.append([(drive + 1) % electrodes, drive])
        for j in range(electrodes):
            if not {j, (j + 1) % electrodes} & {drive, (drive + 1) % electrodes}:
                measured.append([j, (j + 1) % electrodes, drive])
    return PyEITProtocol(np.array(drives), np.array(measured), np.ones(len(measured), dtype=bool))


def pixels_of_elements(values):
    """[elements, frames], two triangles a pixel -> [frames, pixels]."""
    return values.reshape(side * side, 2, -1).mean(1).T


def pixels_of_nodes(values):
    """[nodes, frames] -> the mean of a pixel's corners, [frames, pixels]."""
    grid = values.reshape(side + 1, side + 1, -1)
    corners = grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]
    return (corners / 4).reshape(side * side, -1).T


mesh, protocol = mesh_of_sheet(), protocol_of_sheet()
reference = np.array(told["reference_voltages"]) / current


def set_up(value):
    if method == "jac":
        eit = JAC(mesh, protocol)
        eit.setup(p=p, lamb=value, method="kotre", perm=background)
    elif method == "greit":
        eit = GREIT(mesh, protocol)
        # Its images are of points from the corner on; every other one of twice as many is the centre
        # of a pixel.
        eit.setup(p=p, lamb=value, n=2 * side, perm=background)
        eit.H = eit.H.reshape(2 * side, 2 * side, -1)[1::2, 1::2].reshape(side * side, -1)
    else:
        eit = BP(mesh, protocol)
        eit.setup(perm=background)
    return eit


def images_of(eit, changes):
    """[frames, channels] V -> [frames, pixels], with pyEIT's own `solve`."""
    voltages = reference + changes / current
    values = eit.solve(voltages, reference, normalize=method == "bp")
    if method == "jac":
        return pixels_of_elements(values)
    return pixels_of_nodes(values) if method == "bp" else values.T


def relative_error(images, truths):
    return np.mean(np.linalg.norm(images - truths, axis=1) / np.linalg.norm(truths, axis=1))


def best_gain(images, truths):
    return 1.0 if method == "jac" else float(np.sum(images * truths) / np.sum(images * images))


if method not in ("jac", "bp", "greit"):
    refuse(f'"method" must be "jac", "bp" or "greit", got {method!r}')
simulated = set_up(1.0).fwd.solve_eit(perm=background)
if np.linalg.norm(simulated - reference) > 0.01 * np.linalg.norm(reference):
    print("the reference voltages are not those of this mesh", file=sys.stderr)
used, gain = {"method": method}, 1.0
if told["validation"] is not None:
    with h5py.File(told["validation"]) as file:
        changes = file["voltages"][:500] - file["reference_voltages"][:]
        truths = file["conductivity"][:500].reshape(len(changes), -1) - background
    shown = np.linalg.norm(truths, axis=1) > 0
    changes, truths = changes[shown], truths[shown]
elif method != "jac" or lamb == "auto":
    refuse("is fitted on the validation set; add /datasets/validation, or give lamb to jac")
if method == "bp":
    eit = set_up(0)
elif lamb == "auto":
    tried = []
    for value in 10.0 ** np.arange(-8, 3.1, 0.5):
        try:
            images = images_of(set_up(value), changes)
        except np.linalg.LinAlgError:
            continue
        tried.append((relative_error(best_gain(images, truths) * images, truths), value))
    used["lamb"] = min(tried)[1]
    eit = set_up(used["lamb"])
else:
    used["lamb"] = lamb
    eit = set_up(lamb)
if method != "bp":
    used["p"] = p
if method != "jac":
    gain = best_gain(images_of(eit, changes), truths)
    used["gain"] = gain
answer({"ready": True, "parameters": used})

channels = told["channels"]
while header := stdin.read(8):
    n = int.from_bytes(header, "little")
    frames = np.frombuffer(stdin.read(8 * n * channels)).reshape(n, channels)
    stdout.write(np.ascontiguousarray(gain * images_of(eit, frames)).tobytes())
    stdout.write(bytes(n))
    stdout.flush()
