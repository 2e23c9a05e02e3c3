"""Drives and measurements of other programs, and pyEIT's protocols."""

from __future__ import annotations

import json
from graphlib import CycleError, TopologicalSorter
from typing import Any, Callable, Dict, List, NamedTuple, Tuple

import numpy as np

from ._core import InputError

Pair = Tuple[int, int]


class Protocol(NamedTuple):
    """The arrays of a pyEIT protocol, for where pyEIT is not installed."""

    ex_mat: np.ndarray  #: [drives, 2], the electrodes of each drive, from 0
    meas_mat: np.ndarray  #: [channels, 3], the electrodes of each voltage and the drive's row
    keep_ba: np.ndarray  #: [drives * pairs] bool, False where a pair shares an electrode with the drive


def pairs_of(pattern: Any, electrodes: int) -> List[Pair]:
    """The pairs of "adjacent", "opposite", {"skip": k} or a list, in the order of the sensor."""
    if isinstance(pattern, list):
        return [(first, second) for first, second in pattern]
    step = {"adjacent": 1, "opposite": electrodes // 2}[pattern] if isinstance(pattern, str) \
        else 1 + pattern["skip"]
    return [(k, (k + step) % electrodes) for k in range(electrodes)]


def share(one: Pair, other: Pair) -> bool:
    """Whether two pairs share an electrode."""
    return bool(set(one) & set(other))


def pattern_keys(drives: List[Pair], measured: List[List[Pair]], electrodes: int,
                 place: Places) -> Dict[str, Any]:
    """The keys "drive", "measurement" and "measures_driven" of a sensor with these channels.

    drives: current leaves the sheet at the first electrode and enters it at the second. measured:
    of each drive the pairs that it measures, the first less the second, in the order of the
    channels. place(d) is how the other program names drive d, place(d, m) its m-th measurement.

    Raises InputError where a sensor has no such channels: it measures the same pairs in the same
    order with every drive, but those that share an electrode with the drive, or without exception.
    """
    driven = any(share(drive, pair) for drive, own in zip(drives, measured) for pair in own)

    def of_drive(pairs: List[Pair], drive: Pair) -> List[Pair]:
        return [pair for pair in pairs if driven or not share(pair, drive)]

    def as_written(pairs: List[Pair], fits: Callable[[List[Pair]], bool]) -> Any:
        """The name of these pairs, or of some that make the same channels, else their list."""
        names: List[Any] = ["adjacent"] + ["opposite"] * (electrodes % 2 == 0)
        names += [{"skip": skip} for skip in range(1, electrodes - 1)]
        found = [name for name in names if fits(pairs_of(name, electrodes))]
        return found[0] if found else [list(pair) for pair in pairs]

    def fits(pairs: List[Pair]) -> bool:
        return all(of_drive(pairs, drive) == own for drive, own in zip(drives, measured))

    pairs = _merged(measured, place)
    for d, (drive, own) in enumerate(zip(drives, measured)):
        absent = [pair for pair in of_drive(pairs, drive) if pair not in own]
        if absent:
            raise InputError(
                f"{place(d)}: does not measure electrode {place.count(absent[0][0])} against "
                f"{place.count(absent[0][1])}, which other drives measure; a sensor measures the "
                "same pairs with every drive" + ("" if driven else ", but those on driven electrodes"))
    return {"drive": as_written(drives, lambda named: named == drives),
            "measurement": as_written(pairs, fits), "measures_driven": driven}


def _merged(measured: List[List[Pair]], place: Places) -> List[Pair]:
    """All pairs, in an order in which each drive's are in its own."""
    before: Dict[Pair, Dict[Pair, None]] = {}
    order: List[Pair] = []
    for d, own in enumerate(measured):
        for m, pair in enumerate(own):
            if pair in own[:m]:
                raise InputError(f"{place(d, m)}: is measured already by {place(d, own.index(pair))}; "
                                 "a sensor has no channel twice")
            before.setdefault(pair, {}).update(dict.fromkeys(own[max(m - 1, 0):m]))
        try:
            order = list(TopologicalSorter(before).static_order())
        except CycleError:
            raise InputError(
                f"{place(d)}: measures in another order than the drives before it; a sensor's "
                'measurements do not rotate with the drive. Leave out "rotate_meas", and read frames '
                'in that order by read_frames(..., channels="rotating")') from None
    return order


class Places:
    """Names of drives and measurements in messages: f(d), f(d, m), and electrodes from `first`."""

    def __init__(self, drive: Callable[[int], str], measurement: Callable[[int, int], str], first: int):
        self._drive, self._measurement, self._first = drive, measurement, first

    def __call__(self, d: int, *m: int) -> str:
        return self._measurement(d, *m) if m else self._drive(d)

    def count(self, electrode: int) -> int:
        return electrode + self._first


def to_pyeit(sensor) -> Any:
    """`Sensor.to_pyeit`."""
    spec = json.loads(sensor.to_json())
    drives = pairs_of(spec.get("drive", "adjacent"), sensor.electrodes)
    pairs = pairs_of(spec.get("measurement", "adjacent"), sensor.electrodes)
    keep = np.array([not share(drive, pair) for drive in drives for pair in pairs])
    # pyEIT puts +1 A into the first electrode of a drive and reads the first of a measurement less the
    # second. Here current enters at the second; with both pairs turned round the voltage is the same.
    rows = np.array([(second, first, d) for d in range(len(drives)) for first, second in pairs])
    if not spec.get("measures_driven", False):
        rows = rows[keep]
    arrays = Protocol(np.array(drives), rows, keep)
    try:
        from pyeit.eit.protocol import PyEITProtocol
    except ImportError:
        return arrays
    try:
        return PyEITProtocol(*arrays)
    except TypeError:  # until 1.2.4 meas_mat was [drives, measurements, 2]
        counts = np.bincount(rows[:, 2], minlength=len(drives))
        if len(set(counts)) > 1:
            raise InputError("to_pyeit: this pyEIT takes as many measurements of every drive, the "
                             f"sensor has {counts.min()} to {counts.max()}; install a newer pyEIT "
                             "from its repository") from None
        return PyEITProtocol(arrays.ex_mat, rows[:, :2].reshape(len(drives), -1, 2), keep)


def read_protocol(protocol) -> Tuple[np.ndarray, np.ndarray]:
    """ex_mat [drives, 2] and meas_mat [channels, 3] of pyEIT's protocols, old or new."""
    try:
        drives, rows = np.asarray(protocol.ex_mat), np.asarray(protocol.meas_mat)
    except (AttributeError, ValueError) as error:
        raise InputError(f"protocol: {error}; a PyEITProtocol of pyEIT is taken") from None
    if rows.ndim == 3 and rows.shape[0] == len(drives) and rows.shape[2] == 2:
        number = np.repeat(np.arange(len(drives)), rows.shape[1])
        rows = np.column_stack([rows.reshape(-1, 2), number])
    if drives.ndim != 2 or drives.shape[1] != 2 or rows.ndim != 2 or rows.shape[1] != 3:
        raise InputError("protocol: ex_mat must be [drives, 2] and meas_mat [channels, 3] or "
                         f"[drives, measurements, 2], are {list(drives.shape)} and {list(rows.shape)}")
    for name, array in (("ex_mat", drives), ("meas_mat", rows)):
        if array.size == 0 or not np.issubdtype(array.dtype, np.integer) or array.min() < 0:
            raise InputError(f"protocol.{name}: must hold electrodes, whole numbers from 0")
    return drives, rows


def pyeit_keys(protocol, electrodes: int) -> Dict[str, Any]:
    """The keys of a sensor with `electrodes` electrodes whose channels are the protocol's rows."""
    drives, rows = read_protocol(protocol)
    starts = np.searchsorted(rows[:, 2], np.arange(len(drives)))
    back = np.flatnonzero(np.diff(rows[:, 2]) < 0)
    if back.size:
        raise InputError(f"protocol.meas_mat[{back[0] + 1}]: goes back to drive "
                         f"{rows[back[0] + 1, 2]}; a sensor's channels come drive by drive")
    if rows[-1, 2] >= len(drives):
        raise InputError(f"protocol.meas_mat[{len(rows) - 1}]: is of drive {rows[-1, 2]}, but ex_mat "
                         f"has {len(drives)}, counted from 0")
    most = max(drives.max(), rows[:, :2].max())
    if most >= electrodes:
        raise InputError(f"protocol: names electrode {most}, counted from 0, but the sensor has "
                         f"{electrodes} electrodes")
    measured: List[List[Pair]] = [[] for _ in drives]
    for first, second, d in rows.tolist():
        measured[d].append((second, first))  # turned round, as in to_pyeit
    place = Places(lambda d: f"protocol.ex_mat[{d}]",
                   lambda d, m: f"protocol.meas_mat[{starts[d] + m}]", first=0)
    return pattern_keys([(first, second) for first, second in drives.tolist()], measured, electrodes,
                        place)
