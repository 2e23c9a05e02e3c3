"""Ridge regression from voltages to images: the command of numpy_ridge.json."""

import json
import sys

import h5py
import numpy as np

stdin, stdout = sys.stdin.buffer, sys.stdout.buffer
told = json.loads(stdin.readline())
channels, pixels = told["channels"], told["image"][0] * told["image"][1]
ridge = told["parameters"].get("ridge", 1e-4)

with h5py.File(told["train"]) as train:
    changes = train["voltages"][:] - train["reference_voltages"][:]
    images = train["conductivity"][:].reshape(len(changes), pixels) - told["background"]
gram = changes.T @ changes
gram += ridge * np.trace(gram) / channels * np.eye(channels)
inverse = np.linalg.solve(gram, changes.T @ images)

stdout.write(json.dumps({"ready": True, "parameters": {"ridge": ridge}}).encode() + b"\n")
stdout.flush()
while header := stdin.read(8):
    frames = int.from_bytes(header, "little")
    changes = np.frombuffer(stdin.read(8 * frames * channels)).reshape(frames, channels)
    stdout.write((changes @ inverse).tobytes())
    stdout.write(bytes(frames))  # one status for each frame: 0, ok
    stdout.flush()
