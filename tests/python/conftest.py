"""What the tests of the Python package share."""

import os
import subprocess

import numpy as np
import pytest

import ertbench as eb


@pytest.fixture(scope="session")
def sensor():
    return eb.Sensor("d2s")


@pytest.fixture(scope="session")
def scenes(sensor):
    return eb.Scenes(sensor, contacts=(1, 2), shapes=["disc", "ellipse", "polygon"], radius_mm=(10, 40),
                     seed=3, name="test")


@pytest.fixture(scope="session")
def drawn(scenes):
    return scenes.draw(60, snr_db=50)


@pytest.fixture(scope="session")
def solver(sensor):
    return eb.Solver("one-step-gn", prior="noser", regularisation=0.3).fit(sensor)


@pytest.fixture(scope="session")
def program():
    """Calls the C++ program with arguments; skips where it is not named."""
    path = os.environ.get("ERTBENCH_PROGRAM")
    if not path:
        pytest.skip("ERTBENCH_PROGRAM does not name the program")

    def call(*arguments):
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call


def refusal(function, *arguments, **keywords):
    """The text of the InputError, which must be a ValueError, that a call raises."""
    with pytest.raises(eb.InputError) as caught:
        function(*arguments, **keywords)
    assert isinstance(caught.value, ValueError)
    return str(caught.value)


@pytest.fixture(scope="session")
def refused():
    return refusal


@pytest.fixture(scope="session")
def worst():
    """Largest difference, relative to the largest number."""
    return lambda a, b: np.abs(a - b).max() / np.abs(b).max()
