"""Voltages of a disc with a concentric inclusion, by Fourier series: what DiscSheet is held against.

A current density j(angle) = sum of j_n e^(i n angle) on the border of the unit disc of conductivity 1,
with a concentric disc of radius r and conductivity f, makes the potential u_n = j_n g_n / |n| there,
g_n = (1 + m r^(2|n|)) / (1 - m r^(2|n|)), m = (1 - f) / (1 + f) (Isaacson 1986; Somersalo, Cheney and
Isaacson 1992). Electrodes are points; or of a width with the current spread evenly over it and the
potential averaged (gap); or conductors behind a contact impedance z (complete): u + z j = U on each,
by Galerkin's method with many pieces of constant current on each electrode, graded towards its edges.
Everything but point electrodes converges absolutely; for those the series' part at f = 1 is
-ln|2 sin(angle/2)|/pi, and the rest converges like r^(2n).

Writes disc_series.json: channels drive by drive as ertbench has them (sensors/disc_16.json).
Run: python3 disc_series.py
"""
import json
import pathlib

import numpy as np

L, CURRENT, BACKGROUND, UNIT_M = 16, 0.025, 0.06, 0.1
RADIUS, RATIO, WIDTH, IMPEDANCE = 0.5, 0.3, 0.2, 0.02  # impedance in ohm m^2
PIECES, TERMS = 60, 20000
MIDDLES = -2 * np.pi * np.arange(L) / L  # clockwise; where from does not matter to a concentric disc


def channels(potentials):
    """[L, L] by unit currents, to [208] V: drive k is -I at k and +I at k+1, reads V_j - V_(j+1)."""
    out = []
    for k in range(L):
        drive = potentials[:, (k + 1) % L] - potentials[:, k]
        for j in range(L):
            if (j - k) % L in (0, 1, L - 1):
                continue
            out.append(CURRENT / BACKGROUND * (drive[j] - drive[(j + 1) % L]))
    return out


def gains(ratio, n):
    m = (1 - ratio) / (1 + ratio)
    return (1 + m * RADIUS ** (2.0 * n)) / (1 - m * RADIUS ** (2.0 * n))


def point(ratio):
    n = np.arange(1, 400)
    lag = MIDDLES[:, None] - MIDDLES[None, :]
    with np.errstate(divide="ignore"):
        free = -np.log(np.abs(2 * np.sin(lag / 2))) / np.pi
    free[np.diag_indices(L)] = 0  # never measured
    more = np.cos(lag[:, :, None] * n) @ ((gains(ratio, n) - 1) / n) / np.pi
    return channels(free + more)


def mean_potentials(centres, widths, ratio):
    """[pieces, pieces] mean potential of one by unit current spread over another."""
    out = np.zeros((len(centres), len(centres)))
    n = np.arange(1, TERMS + 1)
    weight = gains(ratio, n) / n / np.pi
    for first in range(0, TERMS, 1000):
        k = n[first:first + 1000]
        spread = np.sinc(np.outer(widths, k) / 2 / np.pi)
        even = spread * np.cos(np.outer(centres, k))
        odd = spread * np.sin(np.outer(centres, k))
        part = weight[first:first + 1000]
        out += (even * part) @ even.T + (odd * part) @ odd.T
    return out


def gap(ratio):
    return channels(mean_potentials(MIDDLES, np.full(L, WIDTH), ratio))


def complete(ratio):
    edges = -np.cos(np.pi * np.arange(PIECES + 1) / PIECES) * WIDTH / 2
    centres = (MIDDLES[:, None] + (edges[1:] + edges[:-1])[None, :] / 2).ravel()
    widths = np.tile(np.diff(edges), L)
    matrix = mean_potentials(centres, widths, ratio)
    matrix[np.diag_indices(len(matrix))] += IMPEDANCE * BACKGROUND / UNIT_M / widths
    matrix += 1  # potentials are up to a constant
    whose = np.kron(np.eye(L), np.ones((PIECES, 1)))
    return channels(np.linalg.inv(whose.T @ np.linalg.solve(matrix, whose)))


if __name__ == "__main__":
    numbers = {"radius": RADIUS, "ratio": RATIO, "width": WIDTH, "contact_impedance": IMPEDANCE}
    for model in (point, gap, complete):
        numbers[model.__name__] = {"reference": model(1.0), "inclusion": model(RATIO)}
    path = pathlib.Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(numbers, separators=(",", ":")) + "\n", encoding="utf-8")
