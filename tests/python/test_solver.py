"""Solvers: the program's images, and what calls of all kinds do."""

import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import ertbench as eb


@pytest.mark.parametrize("spec", [
    {"type": "one-step-gn", "prior": "noser", "lambda": 0.3},
    {"type": "tsvd", "rank": 40},
    {"type": "pdipm", "alpha": 1e-9},
    {"type": "contacts", "noise": 1e-5, "prior_weight": 1}])
def test_images_are_the_programs_to_the_bit(program, drawn, tmp_path, spec):
    h5py = pytest.importorskip("h5py")
    drawn.save(tmp_path / "frames.h5")
    (tmp_path / "solver.json").write_text(json.dumps(spec))
    solver = eb.Solver(spec["type"], **{key: spec[key] for key in spec if key != "type"})
    solver.fit(drawn.sensor)
    program("reconstruct", "--solver", tmp_path / "solver.json", "--input", tmp_path / "frames.h5",
            "--output", tmp_path / "images.h5")
    images, status = solver.reconstruct(drawn.voltages, reference=drawn.reference)
    with h5py.File(tmp_path / "images.h5") as file:
        np.testing.assert_array_equal(images, file["conductivity_change"][:])
        np.testing.assert_array_equal(status, file["status"][:])
        if "contacts" in file:
            np.testing.assert_allclose(solver.contacts(drawn.voltages, drawn.reference),
                                       file["contacts"][:], rtol=1e-12)


def test_chooses_what_is_auto(scenes, drawn):
    solver = eb.Solver("one-step-gn", prior="noser", regularisation="auto")
    assert solver.sensor is None and solver.parameters["lambda"] == "auto"
    assert solver.fit(scenes.draw(100, 50, seed=9)) is solver
    assert solver.sensor == drawn.sensor
    assert 1e-3 < solver.parameters["lambda"] < 10
    images, status = solver.reconstruct(drawn.voltages)
    scores = eb.score(images, drawn)
    assert scores["relative_error"].mean() < 0.85  # an empty image has 1
    assert np.isin(status, (0, 3)).all()  # a few are flagged


def test_images_are_linear_in_the_changes(solver, drawn):
    changes = drawn.changes
    images, _ = solver.reconstruct(changes, reference=0)
    again, _ = solver.reconstruct(changes[:20] - 2 * changes[20:40], reference=0)
    np.testing.assert_allclose(again, images[:20] - 2 * images[20:40], atol=1e-12)
    np.testing.assert_array_equal(solver.reconstruct(np.zeros(208), 0)[0], np.zeros((24, 24)))


def test_refuses_frames_of_another_sensor(solver, drawn):
    other = eb.Scenes(eb.Sensor(background=0.09), contacts=1, seed=4).draw(3, 50)
    with pytest.raises(eb.InputError, match="another sensor"):
        solver.reconstruct(other)
    np.testing.assert_array_equal(solver.reconstruct(drawn)[0],
                                  solver.reconstruct(drawn.changes, reference=0)[0])


def test_refuses_changes_in_the_place_of_conductivities(drawn):
    with pytest.raises(eb.InputError, match="conductivities, not their changes"):
        eb.Solver("lmmse").fit(eb.SceneSet(drawn.sensor, drawn.voltages, drawn.image_changes,
                                           drawn.reference))


def test_one_frame_is_squeezed(solver, drawn):
    images, status = solver.reconstruct(drawn.voltages, drawn.reference)
    image, one = solver.reconstruct(drawn.voltages[3], drawn.reference)
    assert image.shape == (24, 24) and one == status[3] and isinstance(one, int)
    np.testing.assert_allclose(image, images[3], atol=1e-12)
    np.testing.assert_array_equal(solver.reconstruct(drawn)[0], images)  # it knows its reference
    single = solver.reconstruct(drawn.voltages.astype(np.float32), drawn.reference)[0]
    assert np.abs(single - images).max() < 1e-3 * np.abs(images).max()


def test_is_kept_in_files_and_pickles(solver, drawn, tmp_path):
    images, _ = solver.reconstruct(drawn.voltages)
    solver.save(tmp_path / "gn.h5")
    for other in (eb.load(tmp_path / "gn.h5"), pickle.loads(pickle.dumps(solver))):
        assert (other.type, other.sensor) == ("one-step-gn", drawn.sensor)
        np.testing.assert_array_equal(other.reconstruct(drawn.voltages)[0], images)
    (tmp_path / "gn.json").write_text(json.dumps({"type": "one-step-gn", "prior": "noser",
                                                  "checkpoint": "gn.h5"}))
    np.testing.assert_array_equal(eb.load(tmp_path / "gn.json").reconstruct(drawn.voltages)[0], images)
    assert pickle.loads(pickle.dumps(eb.Solver("tsvd", rank=3))).parameters["rank"] == 3


@pytest.mark.parametrize("name", ["one-step-gn", "contacts"])
def test_loads_what_comes_with_the_program(name):
    sensor = eb.Sensor()
    there = eb.load(name)
    assert (there.type, there.sensor) == (name, sensor)
    frame = eb.ForwardModel(sensor).voltages(eb.Disc((20, -30), radius=20, ratio=0.4))
    image = there.reconstruct(frame)[0]
    row, column = np.unravel_index(np.abs(image).argmax(), image.shape)
    assert np.hypot(sensor.x_mm[column] - 20, sensor.y_mm[row] + 30) < 20


def test_a_broken_frame_has_no_image(solver, drawn):
    frames = drawn.voltages[:5].copy()
    frames[2, 7] = np.nan
    images, status = solver.reconstruct(frames)
    assert status[2] == 2 and np.isnan(images[2]).all()
    assert np.isfinite(images[[0, 1, 3, 4]]).all()


def test_two_threads_share_a_solver_that_is_fitted_anew(solver, sensor, drawn):
    shared = pickle.loads(pickle.dumps(solver))
    expected = shared.reconstruct(drawn.voltages)[0]
    wrong = []

    def reconstruct():
        for _ in range(200):
            if not np.array_equal(shared.reconstruct(drawn.voltages, threads=2)[0], expected):
                wrong.append(1)

    threads = [threading.Thread(target=reconstruct) for _ in range(2)]
    for thread in threads:
        thread.start()
    for _ in range(3):
        shared.fit(sensor)
    for thread in threads:
        thread.join()
    assert not wrong


def test_a_forked_process_may_go_on(solver, drawn):
    expected = solver.reconstruct(drawn.voltages, threads=2)[0]
    child = os.fork()
    if child == 0:
        same = np.array_equal(solver.reconstruct(drawn.voltages, threads=2)[0], expected)
        os._exit(0 if same else 1)
    assert os.waitpid(child, 0)[1] == 0


def resident_mb():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def test_does_not_leak(sensor, solver, drawn):
    model = eb.ForwardModel(sensor, grid=24)

    def calls(number):
        for _ in range(number):
            solver.reconstruct(drawn.voltages[:2])
            model.voltages(drawn.images[0], threads=1)
            try:
                solver.reconstruct(drawn.voltages[:, :5])
            except eb.InputError:
                pass

    calls(500)
    before = resident_mb()
    calls(10000)
    assert resident_mb() - before < 3  # one frame and image of each call would be 60 MB


@pytest.mark.parametrize("call", ["scenes.draw(100000, 50)", "model.voltages(images, threads=1)"])
def test_ctrl_c_ends_long_calls(call):
    code = f"""
import numpy as np, ertbench as eb
scenes, model = eb.Scenes(eb.Sensor()), eb.ForwardModel(eb.Sensor(image_grid=96))
images = np.broadcast_to(np.random.rand(96, 96) + .1, (8000, 96, 96)).astype(np.float32)
print("ready", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(1.5)
    child.send_signal(signal.SIGINT)
    assert child.communicate(timeout=20)[0] == "interrupted\n"


def test_a_network_is_trained_and_interrupted(scenes, drawn):
    train = scenes.draw(100, 50, seed=9)
    try:
        net = eb.Solver("lean-net", width=8, epochs=1).fit(train)
    except eb.InputError as error:
        if "libertbench_models.so" in str(error):
            pytest.skip("the learned solvers are not built")
        raise
    images = net.reconstruct(drawn.voltages)[0]
    again = pickle.loads(pickle.dumps(net)).reconstruct(drawn.voltages)[0]
    np.testing.assert_array_equal(again, images)

    def interrupt(done, total, _):  # a report comes every second or so
        assert 0 <= done <= total
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        eb.Solver("lean-net", width=8, epochs=1000).fit(train, progress=interrupt)


def test_lists_its_types():
    types = eb.solver_types()
    assert {"one-step-gn", "tsvd", "pdipm", "contacts", "lean-net", "dd-ert"} <= set(types)
    assert "lambda" in types["one-step-gn"]["parameters"] and types["tsvd"]["summary"]


def test_says_what_would_be_right(solver, sensor, drawn, tmp_path, refused):
    assert 'no solver is called "gn"; known: one-step-gn' in refused(eb.Solver, "gn")
    assert '/ran: unknown key; did you mean "rank"?' in refused(eb.Solver, "tsvd", ran=3)
    assert "is not fitted; call fit first" in refused(eb.Solver("tsvd", rank=3).reconstruct, [1.0])
    assert "lambda" in refused(eb.Solver("one-step-gn", regularisation="auto").fit, sensor)
    assert "[208] or [N, 208] (V), got [60, 5]" in refused(solver.reconstruct, drawn.voltages[:, :5])
    assert "reference: must have the shape [208]" in refused(solver.reconstruct, drawn.voltages, [1, 2])
    assert "these frames have their own" in refused(solver.reconstruct, drawn, drawn.reference)
    assert "makes images alone" in refused(solver.contacts, drawn)
    assert "nowhere.h5: does not exist" in refused(solver.fit, tmp_path / "nowhere.h5")
    assert 'did you mean "lean-net-8"?' in refused(eb.load, "lean-nt-8")
    (tmp_path / "mine.h5").write_text("mine")
    assert "mine.h5" in refused(solver.save, tmp_path / "mine.h5")
    assert "mine.h5" in refused(eb.load, tmp_path / "mine.h5")
    drawn.save(tmp_path / "set.h5")
    assert "is no fitted solver" in refused(eb.load, tmp_path / "set.h5")
