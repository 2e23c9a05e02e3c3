"""Fresh scenes for the training of networks, where PyTorch is installed."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any, Optional

import numpy as np

from .scenes import Scenes

try:
    from torch import from_numpy
    from torch.utils.data import IterableDataset, get_worker_info
except ImportError:
    IterableDataset = object  # type: ignore


class FreshScenes(IterableDataset):
    """Endless batches of scenes that were never seen before.

    Each item is a batch: changes of the voltages [batch, channels] V and changes of the conductivity
    [batch, rows, columns] S/m, as float32 tensors; give it to a DataLoader with batch_size=None. The
    next batch is drawn in a thread of its own while the last one is used.

    scenes: what to draw. snr_db: of the noise, None for none. symmetries: each scene comes in a
    random one of the sensor's symmetries, with noise of its own. reuse: batches are made of so many
    symmetric copies of each drawn scene, 1 to the number of symmetries.
    seed: two objects with the same seed draw the same.
    """

    def __init__(self, scenes: Scenes, batch: int, snr_db: Optional[float] = None,
                 symmetries: bool = True, reuse: int = 1, seed: int = 1):
        if IterableDataset is object:
            raise ImportError("FreshScenes needs PyTorch: apt-get install python3-torch")
        self.scenes, self.batch, self.snr_db, self.seed = scenes, batch, snr_db, seed
        self._pixels, self._channels = scenes.sensor.symmetries()
        if not symmetries:
            self._pixels, self._channels = self._pixels[:1], self._channels[:1]
        self.reuse = reuse

    def __iter__(self) -> Any:
        worker = get_worker_info()
        first, step = (worker.id, worker.num_workers) if worker else (0, 1)
        with ThreadPoolExecutor(1) as thread:
            number = first
            waiting = thread.submit(self._draw, number)
            while True:
                changes, images = waiting.result()
                number += step
                waiting = thread.submit(self._draw, number)
                yield from_numpy(changes), from_numpy(images)

    def _draw(self, number: int):
        random = np.random.default_rng([self.seed, number])
        drawn = self.scenes.draw(-(-self.batch // self.reuse), seed=int(random.integers(2**31 - 1)))
        scene = np.arange(self.batch) % len(drawn)
        turn = (np.arange(self.batch) // len(drawn) + random.integers(len(self._pixels), size=len(
            drawn))[scene]) % len(self._pixels)
        assert drawn.clean_voltages is not None  # as of all that are drawn
        voltages = drawn.clean_voltages[scene[:, np.newaxis], self._channels[turn]]
        if self.snr_db is not None:
            noise = random.standard_normal(voltages.shape)
            noise *= (np.linalg.norm(voltages, axis=1) / np.linalg.norm(noise, axis=1)
                      * 10 ** (-self.snr_db / 20))[:, np.newaxis]
            voltages = voltages + noise
        images = drawn.image_changes.reshape(len(drawn), -1)[scene[:, np.newaxis],
                                                             self._pixels[turn]]
        return ((voltages - drawn.reference).astype(np.float32),
                images.reshape(-1, *drawn.images.shape[1:]).astype(np.float32))
