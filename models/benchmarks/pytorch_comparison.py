#!/usr/bin/env python3
"""Training steps of ertbench's networks against the same networks in Python PyTorch.

    cmake --build build/release && python3 models/benchmarks/pytorch_comparison.py

Needs Debian's python3-torch (the version of libtorch that ertbench links, or the comparison means
nothing). Both sides take the same step: a batch of 32 through the network, its losses, gradients
and Adam; for dd-ert (base width 24, two convolutions in a block) the discriminator's step first.
The two are measured in turn, several rounds each, and the medians compared: the machine must be
otherwise idle, two threads that share a core with anything else wait for each other.
"""

import argparse
import json
import statistics
import subprocess
import time
from pathlib import Path

import torch
import torch.nn.functional as F
from torch import nn

BATCH = 32


def dense(inputs, widths):
    layers = []
    for width in widths:
        layers += [nn.Linear(inputs, width, bias=False), nn.BatchNorm1d(width), nn.ReLU(True)]
        inputs = width
    return layers


class Image(nn.Module):
    def forward(self, x):
        return x.view(-1, 1, 24, 24)


def fcnn():
    return nn.Sequential(*dense(208, [2304, 576, 576]), nn.Linear(576, 576), Image())


def eit_nn():
    convolutions = []
    for inputs, width in ((1, 32), (32, 64)):
        convolutions += [nn.Conv2d(inputs, width, 3, padding=1, bias=False),
                         nn.BatchNorm2d(width), nn.ReLU(True)]
    return nn.Sequential(*dense(208, [2304, 576, 576]), Image(), *convolutions,
                         nn.ConvTranspose2d(64, 1, 3, padding=1, bias=False))


class PRelu(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.slope = nn.Parameter(torch.full((channels, 1, 1), 0.25))

    def forward(self, x):
        return x.relu() - self.slope * (-x).relu()


class Map(nn.Module):
    """The frame as the 16 x 16 map of drives and measurements."""

    def __init__(self):
        super().__init__()
        source = [208] * 256
        channel = 0
        for drive in range(16):
            for measurement in range(16):
                if (measurement - drive) % 16 not in (0, 1, 15):
                    source[16 * drive + measurement] = channel
                    channel += 1
        self.register_buffer("source", torch.tensor(source))

    def forward(self, x):
        return F.pad(x, (0, 1)).index_select(1, self.source).view(-1, 1, 16, 16)


def dcnn(w0=64, w1=128, w2=256):
    def after(width):
        return [nn.BatchNorm2d(width), PRelu(width)]

    def convolution(inputs, width):
        return [nn.Conv2d(inputs, width, 3, padding=1, bias=False), *after(width)]

    def rise(inputs, width, factor):
        return [nn.ConvTranspose2d(inputs, width, factor, factor, bias=False), *after(width)]

    return nn.Sequential(Map(), *convolution(1, w0), nn.MaxPool2d(2), *convolution(w0, w1),
                         nn.MaxPool2d(2), *convolution(w1, w2), *rise(w2, w1, 3),
                         *rise(w1, w0, 2), nn.Conv2d(w0, 1, 3, padding=1))


class Attention(nn.Module):
    def __init__(self):
        super().__init__()
        self.convolution = nn.Conv2d(2, 1, 7, padding=3, bias=False)

    def forward(self, x):
        summary = torch.cat([x.mean(1, True), x.amax(1, True)], 1)
        return x * self.convolution(summary).sigmoid()


def block(inputs, width, convolutions=2, **first):
    layers = []
    for i in range(convolutions):
        options = {"padding": 1, **first} if i == 0 else {"padding": 1}
        layers += [nn.Conv2d(inputs if i == 0 else width, width, 3, bias=False, **options),
                   nn.BatchNorm2d(width), nn.ReLU(True)]
    return nn.Sequential(*layers)


class DdErt(nn.Module):
    def __init__(self, w=24):
        super().__init__()
        self.initial = nn.Sequential(nn.Linear(208, 576), Image())
        self.down_full = block(1, w)
        self.down_half = block(w, 2 * w, stride=2)
        self.down_quarter = nn.Sequential(block(2 * w, 4 * w, stride=2), Attention())
        self.bottom = nn.Sequential(block(4 * w, 8 * w, padding=0), Attention())
        self.rise_quarter = nn.ConvTranspose2d(8 * w, 4 * w, 3)
        self.rise_half = nn.ConvTranspose2d(4 * w, 2 * w, 2, 2)
        self.rise_full = nn.ConvTranspose2d(2 * w, w, 2, 2)
        self.up_quarter = block(8 * w, 4 * w)
        self.up_half = block(4 * w, 2 * w)
        self.up_full = block(2 * w, w)
        self.image = nn.Conv2d(w, 1, 1)

    def forward(self, x):
        full = self.down_full(self.initial(x))
        half = self.down_half(full)
        quarter = self.down_quarter(half)
        x = self.up_quarter(torch.cat([self.rise_quarter(self.bottom(quarter)), quarter], 1))
        x = self.up_half(torch.cat([self.rise_half(x), half], 1))
        x = self.up_full(torch.cat([self.rise_full(x), full], 1))
        return self.image(x).float().sigmoid()


def discriminator():
    return nn.Sequential(nn.Conv2d(1, 64, 4, 2, 1), nn.LeakyReLU(0.2),
                         nn.Conv2d(64, 128, 4, 1, 1, bias=False), nn.BatchNorm2d(128),
                         nn.LeakyReLU(0.2), nn.Conv2d(128, 1, 4, 1, 1))


def squared_error(images, truths):
    return F.mse_loss(images, truths)


class Adversarial:
    """DD-ERT's loss with its discriminator: L1 + 0.001 adversarial + 0.1 mask, minimax."""

    def __init__(self, precision):
        self.net = discriminator()
        self.optimiser = torch.optim.Adam(self.net.parameters(), betas=(0.5, 0.999))
        self.precision = precision

    def odds(self, images):
        with self.precision():
            return self.net(images).float()

    def __call__(self, images, truths):
        self.net.requires_grad_(True)
        self.optimiser.zero_grad()
        loss = F.softplus(-self.odds(truths)).mean() + F.softplus(self.odds(images.detach())).mean()
        loss.backward()
        self.optimiser.step()
        self.net.requires_grad_(False)
        mask = F.binary_cross_entropy(images, truths, weight=(truths >= 0.05).float())
        return F.l1_loss(images, truths) - 1e-3 * F.softplus(self.odds(images)).mean() + 0.1 * mask


NETWORKS = {"fcnn": fcnn, "dcnn": dcnn, "eit-nn": eit_nn, "dd-ert": DdErt}


def python_step(name, threads, bfloat16, seconds):
    """Median milliseconds a sample over `seconds`."""
    torch.set_num_threads(threads)
    torch.set_flush_denormal(True)

    def precision():
        return torch.cpu.amp.autocast(enabled=bfloat16, dtype=torch.bfloat16)

    torch.manual_seed(1)
    net = NETWORKS[name]()
    loss_of = Adversarial(precision) if name == "dd-ert" else squared_error
    optimiser = torch.optim.Adam(net.parameters())
    frames = torch.randn(BATCH, 208)
    truths = (torch.rand(BATCH, 1, 24, 24) > 0.9).float() * 0.4
    times = []
    begin = time.perf_counter()
    while len(times) < 5 or time.perf_counter() - begin < seconds:
        start = time.perf_counter()
        with precision():
            images = net(frames).float()
        loss = loss_of(images, truths)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        loss.item()
        times.append(1e3 * (time.perf_counter() - start) / BATCH)
    return statistics.median(times[2:])


def cpp_step(program, name, threads, bfloat16, seconds):
    which = f"training_step/{name}/threads:{threads}/{'bfloat16' if bfloat16 else 'float32'}"
    out = subprocess.run([program, f"--benchmark_filter={which}", "--benchmark_format=json",
                          f"--benchmark_min_time={seconds}"],
                         check=True, capture_output=True, text=True)
    return json.loads(out.stdout)["benchmarks"][0]["ms_per_sample"]


def main():
    here = Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program",
                        default=here / "build/release/benchmarks/training_benchmark")
    parser.add_argument("--networks", nargs="+", default=list(NETWORKS), choices=list(NETWORKS))
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2], choices=[1, 2])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=2, help="for each measurement")
    arguments = parser.parse_args()
    if not Path(arguments.program).exists():
        parser.error(f"{arguments.program} is not built: cmake --build build/release")
    print(f"PyTorch {torch.__version__}, medians of {arguments.rounds} rounds, batch {BATCH}")
    print(f"{'network':8} {'threads':>7} {'precision':>9} {'C++ ms':>8} {'Python ms':>9} {'ratio':>6}")
    for name in arguments.networks:
        for threads in arguments.threads:
            for bfloat16 in (False, True):
                rounds = [(cpp_step(arguments.program, name, threads, bfloat16, arguments.seconds),
                           python_step(name, threads, bfloat16, arguments.seconds))
                          for _ in range(arguments.rounds)]
                cpp = statistics.median(r[0] for r in rounds)
                python = statistics.median(r[1] for r in rounds)
                precision = "bfloat16" if bfloat16 else "float32"
                print(f"{name:8} {threads:7} {precision:>9} {cpp:8.3f} {python:9.3f} "
                      f"{cpp / python:6.2f}", flush=True)


if __name__ == "__main__":
    main()
