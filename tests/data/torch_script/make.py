#!/usr/bin/env python3
"""Writes traced modules and what PyTorch itself makes of some frames, for torch_script_test.cpp.

    python3 tests/data/torch_script/make.py

small.pt       [n, 208] -> [n, 576]: dense layers with batch normalisation
maps.pt        [n, 208] -> [n, 1, 24, 24]: a dense layer and convolutions
wrong_shape.pt [n, 208] -> [n, 10]
eager.h5       /changes [12, 208] V; /small [12, 576] and /maps [12, 576]: the modules' outputs of
               (change - mean) / std, computed in eager mode; attributes mean and std, V
"""

import pathlib

import h5py
import numpy as np
import torch
from torch import nn

here = pathlib.Path(__file__).parent
torch.manual_seed(5)
mean, std = 2e-4, 1.5e-3

small = nn.Sequential(
    nn.Linear(208, 16), nn.BatchNorm1d(16), nn.PReLU(), nn.Linear(16, 576), nn.Sigmoid())
maps = nn.Sequential(
    nn.Linear(208, 36), nn.Unflatten(1, (1, 6, 6)), nn.Upsample(scale_factor=4, mode="bilinear"),
    nn.Conv2d(1, 6, 3, padding=1), nn.ReLU(), nn.Conv2d(6, 1, 3, padding=1))
wrong = nn.Linear(208, 10)
with torch.no_grad():  # as after a training
    small[1].running_mean.normal_(0, 0.3)
    small[1].running_var.uniform_(0.5, 2)

changes = np.random.default_rng(5).normal(0, 1.5e-3, (12, 208))
fed = torch.from_numpy((changes - mean) / std).float()
with h5py.File(here / "eager.h5", "w") as file:
    file["changes"] = changes
    file.attrs["mean"], file.attrs["std"] = mean, std
    for name, module in (("small", small), ("maps", maps), ("wrong_shape", wrong)):
        module.eval()
        with torch.no_grad():
            if name != "wrong_shape":
                file[name] = module(fed).reshape(12, 576).double().numpy()
            torch.jit.save(torch.jit.trace(module, fed[:2]), here / f"{name}.pt")
