"""The forward model against formulas and symmetries."""

import pickle
import warnings

import numpy as np
import pytest

import ertbench as eb


def concentric(sensor, radius, ratio):
    """Change of the voltages of a disc by a concentric disc: the series of separated variables.

    Harmonic n of the potential is multiplied by (1 + m r^2n) / (1 - m r^2n), m = (1 - k) / (1 + k).
    """
    angles = np.arctan2(sensor.electrodes_mm[:, 1], sensor.electrodes_mm[:, 0])
    m = (1 - ratio) / (1 + ratio)
    change = np.zeros(sensor.channels)
    for n in range(1, 200):
        gain = 2 * m * radius ** (2 * n) / (1 - m * radius ** (2 * n)) / n
        out, into, plus, minus = angles[sensor.channel_electrodes.T]
        for place, sign in ((plus, 1), (minus, -1)):
            change += sign * gain * (np.cos(n * (place - into)) - np.cos(n * (place - out)))
    return change * sensor.drive_current / (np.pi * sensor.background)


def test_agrees_with_the_series_of_a_concentric_disc(worst):
    sensor = eb.Sensor(shape="disc", diameter_mm=230, electrode_count=16)
    model = eb.ForwardModel(sensor, accuracy=1e-8)
    for radius, ratio in ((0.3, 0.2), (0.6, 3), (0.5, 1e-4)):
        frame = model.voltages(eb.Disc((0, 0), 115 * radius, ratio))
        assert worst(frame - model.reference(), concentric(sensor, radius, ratio)) < 1e-7


@pytest.mark.parametrize("grid", ["auto", 24, 48])
def test_obeys_reciprocity(sensor, grid, worst):
    model = eb.ForwardModel(sensor, grid, accuracy=1e-6)
    frame = model.voltages([eb.Rectangle((20, -30), (15, 8), 0.3, angle=0.4), eb.Disc((-50, 10), 20, 5)])
    one, other = sensor.reciprocal_pairs.T
    assert worst(frame[one], frame[other]) < 1e-6


def test_voltages_scale_with_the_inverse_of_the_conductivity(sensor, drawn, worst):
    model = eb.ForwardModel(sensor)
    images = drawn.images[:4]
    assert worst(model.voltages(2 * images), model.voltages(images) / 2) < 1e-12


@pytest.mark.parametrize("grid", ["auto", 24])
def test_the_jacobian_obeys_eulers_identity(sensor, grid, worst):
    # Voltages are homogeneous of degree -1 in the conductivities: sum of sigma dV/dsigma = -V.
    model = eb.ForwardModel(sensor, grid)
    jacobian = model.jacobian()
    assert jacobian.shape == (208, 24, 24)
    assert worst(sensor.background * jacobian.sum(axis=(1, 2)), -model.reference()) < 1e-6


def test_the_jacobian_at_an_image_is_the_slope(sensor, drawn, worst):
    model = eb.ForwardModel(sensor, grid=24)
    image = drawn.images[0]
    direction = np.random.default_rng(1).standard_normal(image.shape) * 1e-6
    slope = (model.voltages(image + direction) - model.voltages(image - direction)) / 2
    assert worst((model.jacobian(image) * direction).sum(axis=(1, 2)), slope) < 1e-5
    assert worst((model.jacobian(image) * image).sum(axis=(1, 2)), -model.voltages(image)) < 1e-9


def test_symmetries_of_the_square_permute_frames(sensor, worst):
    pixels, channels = sensor.symmetries()
    assert pixels.shape == (8, 576) and channels.shape == (8, 208)
    image = np.full(576, 0.06)
    image[[100, 101, 130]] = 0.01
    model = eb.ForwardModel(sensor)
    frame = model.voltages(image.reshape(24, 24))
    for pixel, channel in zip(pixels, channels):
        assert worst(model.voltages(image[pixel].reshape(24, 24)), frame[channel]) < 1e-10


def test_grids_converge_to_the_exact_sheet(sensor):
    disc = eb.Disc((20, -30), 30, 0.4)
    exact = eb.ForwardModel(sensor)
    change = exact.voltages(disc) - exact.reference()
    errors = []
    for grid in (24, 48, 96):
        model = eb.ForwardModel(sensor, grid)
        errors.append(np.linalg.norm(model.voltages(disc) - model.reference() - change))
    assert errors[0] > 1.5 * errors[1] > 2 * errors[2]


def test_takes_one_and_many_in_either_precision(sensor, drawn):
    model = eb.ForwardModel(sensor)
    many = model.voltages(drawn.images)
    assert many.shape == (60, 208) and many.dtype == np.float64
    np.testing.assert_array_equal(model.voltages(drawn.images[7]), many[7])
    np.testing.assert_array_equal(model.voltages(drawn.images, threads=1), many)
    np.testing.assert_array_equal(model.voltages(np.asfortranarray(drawn.images)), many)
    np.testing.assert_allclose(model.voltages(drawn.images.astype(np.float32)), many, rtol=1e-6)
    disc = eb.Disc((20, -30), 15, 0.4)
    assert model.voltages(disc).shape == (208,)
    np.testing.assert_array_equal(model.voltages([[disc], []])[0], model.voltages([disc]))
    np.testing.assert_allclose(model.voltages([[disc], []])[1], model.reference())
    same = eb.Disc((0.2, -0.3), 0.15, 0.4, unit="domain")
    np.testing.assert_allclose(model.voltages(same), model.voltages(disc), rtol=1e-12)


def test_pickles(sensor):
    for grid in ("auto", 24):
        model = eb.ForwardModel(sensor, grid)
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(model)).reference(), model.reference())
    other = eb.Sensor(shape="rectangle", sides_mm=[300, 200], electrode_count=20, background=0.1)
    assert pickle.loads(pickle.dumps(other)) == other != sensor
    assert hash(eb.Sensor(**{"electrode_count": np.int64(16)})) == hash(sensor)


def test_warns_of_an_accuracy_that_is_not_reached(sensor):
    squares = [eb.Rectangle((-20, 0), (19.99, 20), 1e-6), eb.Rectangle((20, 0), (19.99, 20), 1e-6)]
    with pytest.warns(UserWarning, match="scene 0: the estimated error"):
        eb.ForwardModel(sensor, accuracy=1e-9).voltages(squares)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        eb.ForwardModel(sensor, accuracy=1e-4).voltages(eb.Disc((20, -30), 15, 0.4))


def test_says_what_would_be_right(sensor, drawn, refused):
    model = eb.ForwardModel(sensor)
    assert "images: must have the shape [24, 24] or [N, 24, 24] (S/m), got [24, 23]" in refused(
        model.voltages, np.ones((24, 23)))
    assert "> 0 S/m, not their changes" in refused(model.voltages, drawn.image_changes)
    broken = drawn.images.copy()
    broken[3, 2, 1] = np.nan
    assert refused(model.voltages, broken) == "images: must be finite, got nan at [3, 2, 1]"
    assert "real numbers (float64 or float32), got complex128; take its .real" in refused(
        model.voltages, drawn.images + 0j)
    assert "/0/contacts/0/radius_mm: must be from" in refused(model.voltages, eb.Disc((0, 0), -1, 0.5))
    assert 'unit: must be "mm" or "domain"' in refused(model.voltages, eb.Disc((0, 0), 1, 0.5, "cm"))
    assert "Disc, Ellipse, Rectangle or Polygon, got str" in refused(model.voltages, ["disc"])
    assert 'grid: must be "auto"' in refused(eb.ForwardModel, sensor, "fine")
    disc = eb.Sensor("disc_16")
    assert 'give contacts, with grid="auto"' in refused(eb.ForwardModel, disc, 24)
    assert 'give contacts, with grid="auto"' in refused(eb.ForwardModel(disc).voltages, drawn.images)
    assert "threads: must be a number >= 1" in refused(model.voltages, drawn.images, threads=-2)
    assert "built in are d2s, disc_16" in refused(eb.Sensor, "d3s")
    assert 'did you mean "shape"?' in refused(eb.Sensor, shap="disc")
