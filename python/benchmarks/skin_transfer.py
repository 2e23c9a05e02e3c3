"""Does what a network learned of one skin help it on another? Against kernel ridge from nothing.

    python3 python/benchmarks/skin_transfer.py radial.h5 concentric.h5

Files hold `changes` [presses, channels] and `positions_mm` [presses, 2]. A network of two hidden layers is
trained on all presses of one skin and adapted to the other with few; for each number of presses the mean
error of the network less that of kernel ridge is printed, in mm, with its 95 % interval over the presses
that measure it. NumPy and h5py are all it needs; a few minutes.
"""

import sys

import h5py
import numpy as np

MEASURED, DRAWS, MM = 250, 2, 20.0  # presses that measure; draws of those that teach; mm of a network's unit


def read(name):
    with h5py.File(name) as file:
        changes, places = np.nan_to_num(file["changes"][:]), file["positions_mm"][:]
    return changes / np.maximum(np.linalg.norm(changes, axis=1, keepdims=True), 1e-12), places


def kernel_ridge(x, places, tests):
    """Gaussian kernel; width and ridge by the leave-one-out error."""
    square = ((x[:, None] - x[None]) ** 2).sum(2)
    across = ((tests[:, None] - x[None]) ** 2).sum(2)
    middle, best = places.mean(0), (np.inf, None)
    for width in np.median(square[square > 0]) * np.array([0.06, 0.25, 1, 4]):
        values, vectors = np.linalg.eigh(np.exp(-square / width))
        for ridge in 10.0 ** np.arange(-5, 1):
            inverse = (vectors / (values + ridge)) @ vectors.T
            weights = inverse @ (places - middle)
            error = np.linalg.norm(weights / np.diag(inverse)[:, None], axis=1).mean()
            if error < best[0]:
                best = error, np.exp(-across / width) @ weights + middle
    return best[1]


def layers(sizes, random):
    return [[random.normal(size=(a, b)) * np.sqrt(2 / a), np.zeros(b)] for a, b in zip(sizes, sizes[1:])]


def forward(net, x):
    values = [x]
    for i, (weights, bias) in enumerate(net):
        x = x @ weights + bias
        values.append(np.maximum(x, 0) if i + 1 < len(net) else x)
        x = values[-1]
    return values


def train(net, x, truths, epochs, batch, random, rate=1e-3):
    """Adam on the squared error."""
    first = [[np.zeros_like(p) for p in layer] for layer in net]
    second = [[np.zeros_like(p) for p in layer] for layer in net]
    step = 0
    for _ in range(epochs):
        order = random.permutation(len(x))
        for begin in range(0, len(x), batch):
            rows, step = order[begin : begin + batch], step + 1
            values = forward(net, x[rows])
            slope = 2 * (values[-1] - truths[rows]) / len(rows)
            for i in reversed(range(len(net))):
                gradients = values[i].T @ slope, slope.sum(0)
                slope = (slope @ net[i][0].T) * (values[i] > 0)
                for k, gradient in enumerate(gradients):
                    first[i][k] += 0.1 * (gradient - first[i][k])
                    second[i][k] += 0.001 * (gradient**2 - second[i][k])
                    mean, square = first[i][k] / (1 - 0.9**step), second[i][k] / (1 - 0.999**step)
                    net[i][k] -= rate * mean / (np.sqrt(square) + 1e-8)
    return net


def compare(source, target, names):
    (x0, places0), (x, places) = source, target
    random = np.random.default_rng(0)
    order = random.permutation(len(x))
    tests = order[:MEASURED]
    scale0 = np.sqrt((x0**2).mean(0)) + 1e-12
    sizes = [x.shape[1], 96, 96, 2]
    learned = train(layers(sizes, random), x0 / scale0, places0 / MM, 25, 64, random)
    for presses in (25, 50, 100):
        excess = {"adapted": [], "from nothing": []}
        for draw in range(DRAWS):
            taught = order[2 * MEASURED :][draw * presses : (draw + 1) * presses]
            scale = np.sqrt((x[taught] ** 2).mean(0)) + 1e-12
            errors = lambda found: np.linalg.norm(found - places[tests], axis=1)
            ridge = errors(kernel_ridge(x[taught], places[taught], x[tests]))
            for name, start in (("adapted", [[w.copy() for w in one] for one in learned]),
                                ("from nothing", layers(sizes, random))):
                net = train(start, x[taught] / scale, places[taught] / MM, 150, 16, random)
                excess[name].append(errors(MM * forward(net, x[tests] / scale)[-1]) - ridge)
        for name, values in excess.items():
            mean = np.mean(values, axis=0)
            print(f"{names}, {name}, {presses} presses: {mean.mean():+.2f} "
                  f"± {1.96 * mean.std() / np.sqrt(MEASURED):.2f} mm", flush=True)


if __name__ == "__main__":
    one, other = read(sys.argv[1]), read(sys.argv[2])
    compare(one, other, "first to second")
    compare(other, one, "second to first")
