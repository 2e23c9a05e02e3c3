"""Frames of files, scores, pictures, and the surface as a whole."""

import json
import subprocess
import sys

import numpy as np
import pytest

import ertbench as eb


def test_frames_of_a_csv_file(sensor, drawn, tmp_path, refused):
    reference = np.tile(drawn.reference, (3, 1))
    np.savetxt(tmp_path / "lab.csv", 1000 * np.vstack([reference, drawn.voltages]), delimiter=",")
    frames = eb.read_frames(tmp_path / "lab.csv", sensor, unit="mV", background="0-2")
    assert len(frames) == 63 and frames.sensor == sensor and frames.verdict
    np.testing.assert_allclose(frames.voltages[3:], drawn.voltages, rtol=1e-12)
    np.testing.assert_allclose(frames.reference, drawn.reference, rtol=1e-12)
    np.testing.assert_allclose(frames.changes[3:], drawn.changes, atol=1e-12)
    assert "fix=True" in refused(eb.read_frames, tmp_path / "lab.csv", sensor, background="0-2")
    mended = eb.read_frames(tmp_path / "lab.csv", sensor, background="0-2", fix=True)
    np.testing.assert_allclose(mended.voltages[3:], drawn.voltages, rtol=1e-9)
    assert "--background" in refused(eb.read_frames, tmp_path / "lab.csv", sensor, unit="mV")
    assert "nowhere.csv" in refused(eb.read_frames, tmp_path / "nowhere.csv", sensor)


def test_an_electrode_that_is_dead_in_the_reference_is_replaced(sensor, drawn, tmp_path):
    solver = eb.load("lean-net-8")
    uses = (sensor.channel_electrodes == 5).any(axis=1)
    images = []
    for dead_from in (20, 0):
        rows = np.vstack([np.tile(drawn.reference, (20, 1)), drawn.voltages])
        rows[dead_from:, uses] = 0
        np.savetxt(tmp_path / "lab.csv", rows, delimiter=",")
        frames = eb.read_frames(tmp_path / "lab.csv", sensor, background="0-19")
        images.append(solver.reconstruct(frames)[0][20:])
    np.testing.assert_allclose(images[1], images[0], atol=1e-6)


def test_scores_of_perfect_and_of_empty_images(drawn):
    perfect = eb.score(drawn.image_changes, drawn)
    np.testing.assert_allclose(perfect["AR"], 1, rtol=1e-12)
    np.testing.assert_allclose(perfect["CC"], 1, rtol=1e-12)
    for metric in ("RIE", "relative_error", "RES_error"):
        np.testing.assert_allclose(perfect[metric], 0, atol=1e-12)
    empty = eb.score(np.zeros_like(drawn.images), drawn)
    np.testing.assert_allclose(empty["relative_error"], 1)
    assert np.isnan(empty["PE"]).all() and (empty["detected"] == 0).all()
    lines = perfect.summary().splitlines()
    assert lines[1].split()[:2] == ["AR", "1"] and len(lines) == 1 + len(perfect)
    assert "ideal 1" in perfect.legend("AR")


def test_scores_are_the_programs(program, solver, drawn, tmp_path):
    drawn.save(tmp_path / "test.h5")
    solver.save(tmp_path / "gn.h5")
    (tmp_path / "gn.json").write_text(
        json.dumps({"type": "one-step-gn", "prior": "noser", "checkpoint": "gn.h5"}))
    program("reconstruct", "--solver", tmp_path / "gn.json", "--input", tmp_path / "test.h5",
            "--output", tmp_path / "images.h5")
    program("score", tmp_path / "images.h5", tmp_path / "test.h5", "--json", tmp_path / "scores.json")
    metrics = json.loads((tmp_path / "scores.json").read_text())["metrics"]
    scores = eb.score(solver.reconstruct(drawn)[0], drawn)
    assert set(metrics) == set(scores)
    for name, there in metrics.items():
        assert np.nanmean(scores[name]) == pytest.approx(there["mean"], rel=1e-12), name
    assert f"{metrics['RIE']['ci95'][0]:.4g} to {metrics['RIE']['ci95'][1]:.4g}" in scores.summary()


def test_scores_without_contacts(sensor, drawn, refused):
    scores = eb.score(drawn.image_changes[0], drawn.images[0], sensor)
    assert "detected" not in scores and scores["CC"] == pytest.approx(1)
    assert "sensor: must be given" in refused(eb.score, drawn.image_changes, drawn.images)
    assert "must be as many as the truth's 60, got 3" in refused(
        eb.score, drawn.image_changes[:3], drawn)


def test_the_surface_is_small_and_documented():
    assert len(eb.__all__) <= 25
    for name in eb.__all__:
        thing = getattr(eb, name)
        assert thing.__doc__, name
        for member, function in vars(thing).items():
            if not member.startswith("_") and callable(function) and isinstance(thing, type):
                assert function.__doc__, f"{name}.{member}"


def test_does_not_load_pytorch_before_it_is_asked_for():
    code = "import sys, ertbench as eb; assert 'torch' not in sys.modules; eb.torch.FreshScenes"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_comes_without_warnings_of_pyflakes():
    flakes = [sys.executable, "-m", "pyflakes"]
    if subprocess.run(flakes + ["--version"], capture_output=True).returncode != 0:
        pytest.skip("pyflakes is not installed")
    folder = eb.__path__[0]
    done = subprocess.run(flakes + [folder], capture_output=True, text=True)
    assert done.stdout == "", done.stdout


def test_pictures(sensor, drawn):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    figure = eb.plot.images(drawn.image_changes[:8], sensor, titles=[f"{i}" for i in range(8)])
    assert len(figure.axes) == 13 and figure.axes[7].get_title() == "7"


def test_fresh_scenes_for_networks(scenes):
    torch = pytest.importorskip("torch")
    batches = iter(eb.torch.FreshScenes(scenes, batch=16, snr_db=50, reuse=4, seed=2))
    changes, images = next(batches)
    assert changes.shape == (16, 208) and images.shape == (16, 24, 24)
    assert changes.dtype == torch.float32
    # Frames and images belong together: a linear method images them, whatever their symmetry.
    solver = eb.Solver("one-step-gn", prior="noser", regularisation=0.3).fit(scenes.sensor)
    made = solver.reconstruct(changes.numpy(), reference=0)[0]
    for image, true in zip(made.reshape(16, -1), images.numpy().reshape(16, -1)):
        assert np.corrcoef(image, true)[0, 1] > 0.3
    assert not torch.equal(next(batches)[0], changes)
