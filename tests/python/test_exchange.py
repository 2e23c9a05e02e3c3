"""Sensors of EIDORS and pyEIT: patterns as those programs write them, voltages that they computed."""

import json
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import ertbench as eb

DATA = Path(__file__).parents[1] / "data"
L = 16


# EIDORS

@pytest.fixture
def io():
    return pytest.importorskip("scipy.io")


def stim_patterns(io, drive=(0, 1), measurement=(0, 1), current=0.01, electrodes=L, rotate=False,
                  meas_current=False, no_redundant=False):
    """EIDORS's mk_stim_patterns: [-1; 1] at the drive's electrodes, [1, -1] in each measurement."""
    sparse = pytest.importorskip("scipy.sparse")
    stimulation, seen = [], set()
    for k in range(electrodes):
        stim = np.zeros((electrodes, 1))
        pair = [(e + k) % electrodes for e in drive]
        stim[pair, 0] = -current, current
        rows = []
        for m in range(electrodes):
            of = [(e + m + rotate * k) % electrodes for e in measurement]
            if not meas_current and set(of) & set(pair):
                continue
            if no_redundant and (frozenset(of), frozenset(pair)) in seen:
                continue
            seen.add((frozenset(pair), frozenset(of)))
            rows.append(np.zeros(electrodes))
            rows[-1][of] = 1, -1
        if rows:
            stimulation.append({"stimulation": "Amp", "stim_pattern": sparse.csc_matrix(stim),
                                "meas_pattern": sparse.csc_matrix(np.array(rows))})
    return stimulation


def records(rows):
    """A struct array of MATLAB."""
    out = np.zeros((1, len(rows)), dtype=[(name, object) for name in rows[0]])
    for k, row in enumerate(rows):
        out[0, k] = tuple(row.values())
    return out


def model(stimulation, nodes, elements, at, z_contact=0.01, **others):
    """fmdl; at: the nodes of each electrode, from 0."""
    electrode = [{"nodes": np.atleast_2d(e) + 1.0, "z_contact": z_contact} for e in at]
    return {"type": "fwd_model", "nodes": nodes, "elems": elements + 1.0, "gnd_node": 1.0,
            "electrode": records(electrode), "stimulation": records(stimulation), **others}


def disc_mesh(around=64, radius=1.0, centre=(0.0, 0.0)):
    """Triangles from the middle, border nodes clockwise from the top: node k is k steps from it."""
    angle = 2 * np.pi * np.arange(around) / around
    nodes = radius * np.column_stack([np.sin(angle), np.cos(angle)])
    nodes = np.vstack([nodes, [0, 0]]) + centre
    k = np.arange(around)
    return nodes, np.column_stack([k, (k + 1) % around, np.full(around, around)])


def box_mesh(columns, rows, width, height):
    """Two triangles a cell; node c + (columns + 1) r in column c and row r from the least x and y."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    c, r = np.meshgrid(np.arange(columns), np.arange(rows))
    a = (c + (columns + 1) * r).ravel()
    b, d = a + 1, a + columns + 1
    return (np.column_stack([x.ravel(), y.ravel()]),
            np.vstack([np.column_stack([a, b, d]), np.column_stack([b, d + 1, d])]))


@pytest.fixture
def saved(io, tmp_path):
    def save(**variables):
        io.savemat(tmp_path / "model.mat", variables)
        return tmp_path / "model.mat"
    return save


@pytest.fixture
def disc_file(saved):
    """A disc with point electrodes, clockwise from the top, and this stimulation."""
    return lambda stimulation: saved(fmdl=model(stimulation, *disc_mesh(), np.arange(0, 64, 4)))


def test_eidors_adjacent_disc(io, disc_file):
    sensor = eb.Sensor.from_eidors(disc_file(stim_patterns(io)), diameter_mm=200, background=0.06)
    assert sensor == eb.Sensor("disc_16", drive_current=0.01)
    rows = [(d, (d + 1) % L, m, (m + 1) % L) for d in range(L) for m in range(L)
            if not {d, (d + 1) % L} & {m, (m + 1) % L}]  # the order in which EIDORS stacks channels
    assert sensor.channels == 208 and sensor.channel_electrodes.tolist() == [list(row) for row in rows]


def test_eidors_voltages_in_order_and_sign(io, saved, worst):
    theirs = json.loads((DATA / "eidors_disc.json").read_text())
    for mesh in ("f2c", "j2c"):
        points = np.reshape(theirs[mesh]["electrodes"], (L, 2))
        nodes, elements = disc_mesh()
        at = [np.linalg.norm(nodes - point, axis=1).argmin() for point in points]
        file = saved(fmdl=model(stim_patterns(io, current=theirs["current"]), nodes, elements, at))
        sensor = eb.Sensor.from_eidors(file, unit="m", background=theirs["background"])
        np.testing.assert_allclose(sensor.electrodes_mm / 1000, points, atol=1e-9)
        forward = eb.ForwardModel(sensor)
        touched = forward.voltages(eb.Disc(theirs["centre"], theirs["radius"], theirs["ratio"], "domain"))
        # The tolerances of tests/forward/sensors_test.cpp: EIDORS's meshes are not the sheet.
        reference = np.array(theirs[mesh]["reference"])
        assert worst(forward.reference(), reference) < 5e-3
        assert worst(touched - forward.reference(),
                     np.array(theirs[mesh]["inclusion"]) - reference) < 0.05


@pytest.mark.parametrize("drive, measurement, keys", [
    ((0, 8), (0, 1), {"drive": "opposite"}),
    ((0, 4), (0, 4), {"drive": {"skip": 3}, "measurement": {"skip": 3}}),
    ((0, 1), (0, 3), {"measurement": {"skip": 2}}),
    ((1, 0), (0, 1), {"drive": [[(k + 1) % L, k] for k in range(L)], "measurement": "adjacent"}),
])
def test_eidors_patterns(io, disc_file, drive, measurement, keys):
    sensor = eb.Sensor.from_eidors(disc_file(stim_patterns(io, drive, measurement)), diameter_mm=200,
                                   background=0.06)
    assert sensor == eb.Sensor("disc_16", drive_current=0.01, **keys)


def test_eidors_lists_of_pairs(io, disc_file):
    # Every second drive, and of the measurements every third: no name is theirs.
    stimulation = stim_patterns(io)[::2]
    for one in stimulation:
        pattern = one["meas_pattern"].toarray()
        one["meas_pattern"] = pattern[pattern[:, ::3].max(axis=1) == 1]
    sensor = eb.Sensor.from_eidors(disc_file(stimulation), diameter_mm=200)
    assert sensor.channel_electrodes.tolist() == [
        [d, d + 1, m, (m + 1) % L] for d in range(0, L, 2) for m in range(0, L, 3)
        if not {d, d + 1} & {m, (m + 1) % L}]


def test_eidors_rectangles_and_squares(io, saved):
    nodes, elements = box_mesh(12, 6, 0.3, 0.15)
    stimulation = stim_patterns(io, electrodes=12)
    # Clockwise from the top left corner, as a sensor counts, every third node: 75 mm apart.
    border = [13 * 6 + c for c in range(12)] + [13 * r + 12 for r in range(6, 0, -1)] + \
        [c for c in range(12, 0, -1)] + [13 * r for r in range(6)]
    file = saved(fmdl=model(stimulation, nodes, elements, border[1::3]))
    sensor = eb.Sensor.from_eidors(file, unit="m", background=0.1)
    assert sensor == eb.Sensor(shape="rectangle", sides_mm=[300, 150], electrode_count=12,
                               electrode_offset_mm=25, drive_current=0.01, background=0.1)
    half = eb.Sensor.from_eidors(file, sides_mm=[150, 75])
    np.testing.assert_allclose(half.electrodes_mm, sensor.electrodes_mm / 2, atol=1e-9)
    turned = saved(fmdl=model(stimulation, nodes, elements, border[1::3][::-1]))
    np.testing.assert_allclose(eb.Sensor.from_eidors(turned, unit="m").electrodes_mm,
                               sensor.electrodes_mm[::-1], atol=1e-9)
    nodes, elements = box_mesh(8, 8, 2, 2)
    border = [9 * 8 + c for c in range(8)] + [9 * r + 8 for r in range(8, 0, -1)] + \
        [c for c in range(8, 0, -1)] + [9 * r for r in range(8)]
    file = saved(fmdl=model(stim_patterns(io, current=0.025), nodes, elements, border[1::2]))
    assert eb.Sensor.from_eidors(file, side_mm=200) == eb.Sensor("d2s")


def test_eidors_electrodes_with_a_width(io, saved):
    at = [(np.arange(-1, 2) + 4 * k) % 64 for k in range(L)]
    file = saved(fmdl=model(stim_patterns(io, meas_current=True), *disc_mesh(radius=0.1), at, 0.02))
    keys = {"drive_current": 0.01, "electrode_model": "complete", "electrode_width": 2 * np.pi / 32,
            "contact_impedance": 0.02, "measures_driven": True}
    sensor, same = eb.Sensor.from_eidors(file, unit="m"), eb.Sensor("disc_16", **keys)
    assert sensor.channels == same.channels == 256
    np.testing.assert_allclose(eb.ForwardModel(sensor).reference(), eb.ForwardModel(same).reference(),
                               rtol=1e-6)
    # z_contact times conductivity over length counts: twice the size has twice the impedance.
    twice = json.loads(eb.Sensor.from_eidors(file, diameter_mm=400).to_json())
    assert twice["contact_impedance"] == pytest.approx(0.04)


def test_eidors_models_within_others(io, saved, refused):
    fmdl = model(stim_patterns(io), *disc_mesh(), np.arange(0, 64, 4))
    want = eb.Sensor("disc_16", drive_current=0.01)
    assert eb.Sensor.from_eidors(saved(img={"fwd_model": fmdl}), diameter_mm=200) == want
    nested = saved(imdl={"inv_model": 0, "fwd_model": {"fwd_model": fmdl}}, v=np.ones(3))
    assert eb.Sensor.from_eidors(nested, diameter_mm=200) == want
    several = saved(a=fmdl, b={"fwd_model": fmdl}, other={"x": 1})
    assert eb.Sensor.from_eidors(several, diameter_mm=200, variable="b") == want
    assert "holds several models, a, b; name one by variable=" in refused(
        eb.Sensor.from_eidors, several, diameter_mm=200)
    for keywords in ({}, {"variable": "v"}, {"variable": "fmdl"}):
        said = refused(eb.Sensor.from_eidors, saved(v=1, w="text"), unit="m", **keywords)
        assert "holds no EIDORS forward model" in said and "the file has v, w" in said


def test_eidors_patterns_that_a_sensor_does_not_have(io, disc_file, refused):
    def said(stimulation):
        return refused(eb.Sensor.from_eidors, disc_file(stimulation), diameter_mm=200)

    def changed(d, field, change):
        stimulation = stim_patterns(io)
        stimulation[d][field] = stimulation[d][field].toarray()
        change(stimulation[d][field])
        return said(stimulation)

    # Drive 5 measures pair 3 after pair 7, drive 1 before it; until then the orders agree.
    assert "model.mat: fmdl.stimulation(5): measures in another order than the drives before it" in said(
        stim_patterns(io, rotate=True))
    # No drive measures 1 or 2, which by reciprocity are known, and drive 5 is the first to leave out 3.
    assert "fmdl.stimulation(5): does not measure electrode 3 against 4, which other drives" in said(
        stim_patterns(io, no_redundant=True))
    assert "stimulation(2).stim_pattern: a drive of a sensor is of two electrodes with opposite signs, " \
        "this one is of 3 (1 at 1, -0.01 at 2, 0.01 at 3)" in changed(
            1, "stim_pattern", lambda a: a.__setitem__(0, 1))
    assert "stimulation(4).stim_pattern: drives 0.02 A, stimulation(1) 0.01 A" in changed(
        3, "stim_pattern", lambda a: a.__imul__(2))
    assert "stimulation(1).meas_pattern(3,:): a measurement of a sensor is of two electrodes" in changed(
        0, "meas_pattern", lambda a: a.__setitem__((2, 4), 0))
    assert "stimulation(1).meas_pattern(1,:): has a gain of 10" in changed(
        0, "meas_pattern", lambda a: a.__imul__(10))
    assert "stimulation(1).meas_pattern(4,:): is measured already by" in changed(
        0, "meas_pattern", lambda a: a.__setitem__(3, a[1]))
    stimulation = stim_patterns(io)
    stimulation[5]["meas_pattern"] = stimulation[5]["meas_pattern"].T
    assert "stimulation(6).meas_pattern: must be [measurements, electrodes]" in said(stimulation)
    assert "needs electrodes with a width" in said(stim_patterns(io, meas_current=True))
    file = disc_file(stim_patterns(io, meas_current=True))
    assert eb.Sensor.from_eidors(file, diameter_mm=200, measures_driven=False).channels == 208


def test_eidors_meshes_that_a_sensor_does_not_have(io, saved, disc_file, refused):
    read = eb.Sensor.from_eidors
    file = disc_file(stim_patterns(io))
    assert 'a disc of 2 x 2; give either unit="m" (or "cm", "mm") or diameter_mm=' in refused(read, file)
    assert "give either unit" in refused(read, file, unit="m", diameter_mm=200)
    assert "side_mm: the mesh is a disc of 2 x 2; give diameter_mm=" in refused(read, file, side_mm=200)
    assert "diameter_mm: must be numbers, got 'wide'" in refused(read, file, diameter_mm="wide")
    assert "got 'inch'" in refused(read, file, unit="inch")
    assert "unit: is of the mesh" in refused(read, file, unit="m", shape="square")

    def said(nodes, elements, at=np.arange(0, 64, 4), **keywords):
        return refused(read, saved(fmdl=model(stim_patterns(io), nodes, elements, at)), **keywords)

    nodes, elements = disc_mesh()
    assert "neither a disc nor a rectangle along the axes" in said(nodes * [1, 0.9], elements, unit="m")
    assert "electrode(1): a node is not on the border of the disc, 1 from it" in said(
        nodes, elements, [64, *range(4, 64, 4)], unit="m")
    assert "the mesh is not of triangles between its nodes" in said(nodes, elements + 1, unit="m")
    assert "electrode(16): has no nodes, or such" in said(nodes, elements, [*range(0, 60, 4), 65], unit="m")
    uneven = [[0, 1, 2], *([4 * k, 4 * k + 1] for k in range(1, 16))]
    assert "fmdl.electrode: has electrodes of" in said(nodes, elements, uneven, unit="m")
    assert "are not in the proportion of the mesh, 3 x 1" in said(
        *box_mesh(12, 6, 3, 1), np.arange(13, 29), sides_mm=[300, 150])
    solid = np.column_stack([nodes, np.zeros(len(nodes))])
    assert "is 3-dimensional, sensors are flat; give shape=" in said(solid, elements, unit="m")
    tank = eb.Sensor.from_eidors(saved(fmdl=model(stim_patterns(io), solid, elements, np.arange(16))),
                                 shape="disc", diameter_mm=200)
    assert tank == eb.Sensor("disc_16", drive_current=0.01)
    for field in ("electrode", "stimulation"):
        fmdl = model(stim_patterns(io), nodes, elements, np.arange(0, 64, 4))
        del fmdl[field]
        assert f"fmdl: has no {field}" in refused(read, saved(fmdl=fmdl), unit="m")


def test_files_that_are_no_models(io, tmp_path, refused):
    read = eb.Sensor.from_eidors
    assert "nowhere.mat: there is no such file" in refused(read, tmp_path / "nowhere.mat", unit="m")
    (tmp_path / "text.mat").write_text("fmdl = mk_common_model('d2c', 16);" * 20)
    assert "text.mat: is no file that MATLAB's" in refused(read, tmp_path / "text.mat", unit="m")
    # The header that MATLAB writes before HDF5: version 2.0, little-endian.
    header = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    (tmp_path / "new.mat").write_bytes(header.ljust(512, b"\0") + b"\x89HDF\r\n\x1a\n".ljust(512, b"\0"))
    assert "new.mat: is a file of MATLAB 7.3" in refused(read, tmp_path / "new.mat", unit="m")


def test_eidors_without_scipy(tmp_path, refused, monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.io", None)
    assert "install Debian's python3-scipy" in refused(eb.Sensor.from_eidors, tmp_path / "fmdl.mat")


# pyEIT

def std_protocol(distance=1, step=1, meas_current=False, old=False):
    """What pyEIT's protocol.create makes: [k, k + distance] driven, [m + step, m] read."""
    drives = [(k, (k + distance) % L) for k in range(L)]
    full = [((m + step) % L, m, d) for d in range(L) for m in range(L)]
    keep = np.array([not {n, m} & set(drives[d]) for n, m, d in full])
    rows = np.array(full)[keep | meas_current]
    if old:
        rows = rows[:, :2].reshape(L, -1, 2)
    return SimpleNamespace(ex_mat=np.array(drives), meas_mat=rows, keep_ba=keep)


def arrays(protocol):
    """Its arrays, meas_mat in the newer of pyEIT's forms."""
    rows = np.asarray(protocol.meas_mat)
    if rows.ndim == 3:
        number = np.repeat(np.arange(len(rows)), rows.shape[1])
        rows = np.column_stack([rows.reshape(-1, 2), number])
    return np.asarray(protocol.ex_mat), rows, np.asarray(protocol.keep_ba)


@pytest.mark.parametrize("keys, made", [
    ({}, std_protocol()),
    ({"drive": "opposite"}, std_protocol(8)),
    ({"drive": {"skip": 3}, "measurement": {"skip": 2}}, std_protocol(4, 3)),
    ({"electrode_model": "gap", "electrode_width": 0.1, "measures_driven": True},
     std_protocol(meas_current=True)),
])
def test_pyeit_protocols_there_and_back(keys, made):
    sensor = eb.Sensor("disc_16", **keys)
    for ours, theirs in zip(arrays(sensor.to_pyeit()), arrays(made)):
        np.testing.assert_array_equal(ours, theirs)
    width = {key: keys[key] for key in keys if key.startswith("electrode")}
    for protocol in (made, sensor.to_pyeit()):
        assert eb.Sensor.from_pyeit(protocol, "disc_16", **width) == sensor
    pattern = json.loads(sensor.to_json())
    plain = eb.Sensor.from_pyeit(made, **width)
    assert json.loads(plain.to_json()).get("drive") == pattern.get("drive")


def test_pyeit_lists_and_older_forms():
    keys = {"drive": [[0, 3], [5, 2], [9, 4]], "measurement": [[1, 0], [7, 5], [8, 9], [6, 10], [11, 15]]}
    sensor = eb.Sensor("disc_16", **keys)
    assert sensor.channels == 12  # each drive shares an electrode with one measurement
    assert eb.Sensor.from_pyeit(sensor.to_pyeit(), "disc_16") == sensor
    assert eb.Sensor.from_pyeit(std_protocol(old=True), "disc_16") == eb.Sensor("disc_16")
    assert eb.Sensor.from_pyeit(std_protocol(meas_current=True), "disc_16",
                                measures_driven=False) == eb.Sensor("disc_16")


class OldProtocol(SimpleNamespace):
    """As in pyEIT until 1.2.4."""

    def __init__(self, ex_mat, meas_mat, keep_ba):
        if meas_mat.ndim != 3 or meas_mat.shape[::2] != (len(ex_mat), 2):
            raise TypeError("Wrong shape")
        super().__init__(ex_mat=ex_mat, meas_mat=meas_mat, keep_ba=keep_ba)


def test_pyeit_absent_and_old(monkeypatch, refused):
    module = ModuleType("pyeit.eit.protocol")
    uneven = eb.Sensor("disc_16", drive=[[0, 1], [0, 2]])
    for name in ("pyeit", "pyeit.eit"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    monkeypatch.setitem(sys.modules, "pyeit.eit.protocol", None)
    assert uneven.to_pyeit()._fields == ("ex_mat", "meas_mat", "keep_ba")
    assert eb.Sensor.from_pyeit(uneven.to_pyeit(), "disc_16") == uneven
    module.PyEITProtocol = OldProtocol
    monkeypatch.setitem(sys.modules, "pyeit.eit.protocol", module)
    made = eb.Sensor("d2s").to_pyeit()
    np.testing.assert_array_equal(made.meas_mat, std_protocol(old=True).meas_mat)
    assert "the sensor has 12 to 13" in refused(uneven.to_pyeit)


def test_pyeit_voltages_in_order_and_sign(worst):
    # What pyEIT computed of its circle, kept in tests/data: drive k enters at k + 1, V_j - V_(j+1).
    theirs = json.loads((DATA / "pyeit_disc.json").read_text())
    points = np.reshape(theirs["fine"]["electrodes"], (L, 2))
    sensor = eb.Sensor.from_pyeit(std_protocol(), shape="disc", diameter_mm=200, drive_current=1,
                                  background=1, electrode_points_mm=100 * points)
    assert worst(eb.ForwardModel(sensor).reference(), np.array(theirs["fine"]["reference"])) < 5e-3


@pytest.mark.parametrize("keywords", [{}, {"distance": 8}, {"distance": 4, "step": 3},
                                      {"meas_current": True}])
def test_pyeits_protocols_are_as_here(keywords):
    create = pytest.importorskip("pyeit.eit.protocol").create
    parser = "meas_current" if keywords.get("meas_current") else "std"
    theirs = create(L, keywords.get("distance", 1), keywords.get("step", 1), parser)
    for one, other in zip(arrays(theirs), arrays(std_protocol(**keywords))):
        np.testing.assert_array_equal(one, other)


def test_pyeits_forward_model_agrees(worst):
    mesh = pytest.importorskip("pyeit.mesh")
    fem = pytest.importorskip("pyeit.eit.fem")
    sensor = eb.Sensor(shape="disc", diameter_mm=200, electrode_places=np.pi * (1.5 + np.arange(L) / 8),
                       drive="opposite", drive_current=1, background=1)  # its circle starts at the left
    circle = mesh.create(L, h0=0.08)
    np.testing.assert_allclose(circle.node[circle.el_pos, :2], sensor.electrodes_mm / 100, atol=1e-6)
    for one in (sensor, eb.Sensor(**{**json.loads(sensor.to_json()), "drive": "adjacent"})):
        voltages = fem.EITForward(circle, one.to_pyeit()).solve_eit(perm=1.0)
        assert worst(voltages, eb.ForwardModel(one).reference()) < 0.02


def test_pyeit_protocols_that_a_sensor_does_not_have(refused):
    def said(change, made=None, **keywords):
        protocol = made or std_protocol()
        change(protocol)
        return refused(eb.Sensor.from_pyeit, protocol, "disc_16", **keywords)

    def rows(change):
        return lambda protocol: setattr(protocol, "meas_mat", change(protocol.meas_mat))

    nothing = rows(lambda a: a)
    assert "protocol.ex_mat[3]: does not measure electrode 0 against 1, which other drives" in said(
        rows(lambda a: a[~((a == [1, 0, 3]).all(axis=1))]))
    assert "protocol.meas_mat[14]: goes back to drive 0" in said(
        rows(lambda a: np.vstack([a[:14], a[:1], a[14:]])))
    assert "protocol.meas_mat[1]: is measured already by protocol.meas_mat[0]" in said(
        rows(lambda a: np.vstack([a[:1], a])))
    assert "protocol.ex_mat[1]: measures in another order" in said(
        rows(lambda a: np.vstack([a[:13], a[13:26][::-1], a[26:]])))
    assert "is of drive 16, but ex_mat has 16" in said(rows(lambda a: np.vstack([a, [3, 2, 16]])))
    assert "names electrode 15, counted from 0, but the sensor has 12" in said(
        nothing, electrode_count=12)
    assert "must be [drives, 2] and meas_mat [channels, 3]" in said(rows(lambda a: a[:, :2]))
    assert "must hold electrodes, whole numbers from 0" in said(rows(lambda a: a - 1))
    assert "must hold electrodes, whole numbers from 0" in said(rows(lambda a: a + 0.5))
    assert "needs electrodes with a width" in said(nothing, std_protocol(meas_current=True))
    assert "a PyEITProtocol of pyEIT is taken" in refused(eb.Sensor.from_pyeit, [1, 2])
