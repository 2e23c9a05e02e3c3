#!/usr/bin/env python3
"""Leave-one-out errors of kernel ridge regression on the presses of experiments/data, by numpy.

The numbers in tests/solvers/kernel_ridge_test.cpp are what this prints:
    python3 tests/data/skin_leave_one_out.py experiments/data/skin_presses.h5
"""
import sys

import h5py
import numpy as np

with h5py.File(sys.argv[1]) as file:
    change = file["voltages"][()].astype(float) - file["reference_voltages"][()].astype(float)
    place = file["positions_mm"][()]
    depth = file["depth_mm"][()]

norm = np.linalg.norm(change, axis=1, keepdims=True)
direction = change / norm


def leave_one_out(features, targets, width, ridge):
    squared = ((features[:, None] - features[None]) ** 2).sum(-1)
    median = np.median(squared[np.triu_indices(len(features), 1)])
    inverse = np.linalg.inv(np.exp(-squared / (width * median)) + ridge * np.eye(len(features)))
    ones = inverse.sum(1)
    bordered = inverse - np.outer(ones, ones) / ones.sum()
    return np.linalg.norm(bordered @ targets / np.diag(bordered)[:, None], axis=1).mean()


print("place, direction, 0.5, 1e-4:", leave_one_out(direction, place, 0.5, 1e-4), "mm")
print("place, raw, 1, 1e-2:", leave_one_out(change, place, 1, 1e-2), "mm")
both = np.hstack([direction, np.log(norm)])
print("depth, norm weight 1, 0.5, 1e-3:", leave_one_out(both, depth[:, None], 0.5, 1e-3), "mm")
