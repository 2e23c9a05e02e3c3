"""A small network in eager PyTorch, trained once: the command of torch_eager.json.

The trained network is kept in the work folder, which goes with the fit: when the program is started
again for the same fit, it trains nothing.
"""

import json
import pathlib
import sys

import h5py
import numpy as np
import torch
from torch import nn

stdin, stdout = sys.stdin.buffer, sys.stdout.buffer
told = json.loads(stdin.readline())
channels, pixels = told["channels"], told["image"][0] * told["image"][1]
epochs = told["parameters"].get("epochs", 15)
torch.set_num_threads(told["threads"])
torch.manual_seed(told["parameters"].get("seed", 1))
network = nn.Sequential(nn.Linear(channels, 256), nn.ReLU(), nn.Linear(256, pixels))
kept = pathlib.Path(told["work_folder"]) / "network.npz"


def train():
    with h5py.File(told["train"]) as file:
        changes = file["voltages"][:] - file["reference_voltages"][:]
        y = 1 - file["conductivity"][:].reshape(len(changes), pixels) / told["background"]
    mean, std = changes.mean(0), changes.std(0)
    inputs = torch.from_numpy((changes - mean) / std).float()
    targets = torch.from_numpy(y).float()
    optimiser = torch.optim.Adam(network.parameters(), 2e-3)
    for epoch in range(epochs):
        for batch in torch.randperm(len(inputs)).split(64):
            optimiser.zero_grad()
            nn.functional.mse_loss(network(inputs[batch]), targets[batch]).backward()
            optimiser.step()
        print(f"epoch {epoch + 1} of {epochs}", file=sys.stderr)
    weights = {name: tensor.numpy() for name, tensor in network.state_dict().items()}
    np.savez(kept, mean=mean, std=std, **weights)


def answer(line):
    stdout.write(json.dumps(line).encode() + b"\n")
    stdout.flush()


if not kept.exists():
    if told["train"] is None:
        answer({"error": "is trained; add /datasets/train"})
        sys.exit(1)
    train()
with np.load(kept) as file:
    mean, std = file["mean"], file["std"]
    network.load_state_dict({n: torch.from_numpy(file[n]) for n in network.state_dict()})
network.eval()
answer({"ready": True, "parameters": {"epochs": epochs}})

with torch.no_grad():
    while header := stdin.read(8):
        frames = int.from_bytes(header, "little")
        changes = np.frombuffer(stdin.read(8 * frames * channels)).reshape(frames, channels)
        y = network(torch.from_numpy((changes - mean) / std).float())
        stdout.write((-told["background"] * y.double().numpy()).tobytes())
        stdout.write(bytes(frames))
        stdout.flush()
