"""A small convolutional network in PyTorch, trained on fresh scenes: the command of torch_network.json."""

import torch
from torch import nn

import ertbench as eb


class Network:
    def __init__(self, sensor, seed=1, scenes=16000, batch=64):
        torch.manual_seed(seed)
        rows, columns = sensor.image_shape
        self.scenes, self.batch, self.background = scenes, batch, sensor.background
        self.layers = nn.Sequential(
            nn.Linear(sensor.channels, 8 * rows * columns), nn.Unflatten(1, (8, rows, columns)),
            nn.ReLU(), nn.Conv2d(8, 16, 3, padding=1), nn.ReLU(), nn.Conv2d(16, 1, 3, padding=1))

    def fit(self, train, validation, fresh):
        self.mean, self.std = train.changes.mean(0), train.changes.std(0)
        steps = self.scenes // self.batch
        optimiser = torch.optim.Adam(self.layers.parameters())
        rate = torch.optim.lr_scheduler.OneCycleLR(optimiser, 4e-3, total_steps=steps)
        for step in range(steps):
            changes, image_changes = fresh(self.batch)
            truths = torch.from_numpy(image_changes).float() / self.background
            error = (self.image(changes) - truths).flatten(1).norm(dim=1)
            loss = (error / truths.flatten(1).norm(dim=1).clamp(min=1e-6)).mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            rate.step()
            if step % 50 == 0:
                print(f"step {step} of {steps}: relative error {loss.item():.3f}")

    def image(self, changes):
        return self.layers(torch.from_numpy((changes - self.mean) / self.std).float())[:, 0]

    def reconstruct(self, changes):
        with torch.no_grad():
            return self.background * self.image(changes).double().numpy()


if __name__ == "__main__":
    eb.serve(Network)
