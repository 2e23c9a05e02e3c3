"""Forward models of EIDORS as sensors."""

from __future__ import annotations

import os
from typing import Any, Dict, List, Tuple

import numpy as np

from ._core import InputError
from .exchange import Pair, Places, pattern_keys

SIZES = {"disc": "diameter_mm", "square": "side_mm", "rectangle": "sides_mm"}
UNITS = {"m": 1000.0, "cm": 10.0, "mm": 1.0}


def keys(file, unit, variable: str, given: Dict[str, Any]) -> Dict[str, Any]:
    """The keys of the sensor in a .mat file; `given` are the caller's own, which replace them."""
    name, model = _model(os.fspath(file), variable)
    current, drives, measured, electrodes = _stimulation(name, model)
    place = Places(lambda d: f"{name}.stimulation({d + 1})",
                   lambda d, m: f"{name}.stimulation({d + 1}).meas_pattern({m + 1},:)", first=1)
    out = {"drive_current": current, **pattern_keys(drives, measured, electrodes, place)}
    if "shape" in given and unit is not None:
        raise InputError("unit: is of the mesh, which shape= replaces; leave one of the two out")
    if "shape" not in given:
        out.update(_Mesh(name, model).keys(electrodes, unit, given))
    elif not any(key.startswith("electrode_p") for key in given):
        out["electrode_count"] = electrodes
    return {**out, **given}


def _model(file: str, variable: str) -> Tuple[str, Any]:
    """The model of a file and its name for messages."""
    try:
        from scipy.io import loadmat
    except ImportError:
        raise InputError(f"{file}: MATLAB's files are read by SciPy, which is not installed; install "
                         "Debian's python3-scipy") from None
    if not os.path.isfile(file):
        raise InputError(f"{file}: there is no such file")
    try:
        content = loadmat(file, appendmat=False, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:
        raise InputError(f"{file}: is a file of MATLAB 7.3, which SciPy does not read; save it by "
                         "save(..., '-v7')") from None
    except Exception as error:  # SciPy raises several kinds for what is no such file
        raise InputError(f"{file}: is no file that MATLAB's or Octave's save(..., '-v7') wrote: "
                         f"{error}") from None
    found = {}
    for name, value in content.items():
        path = f"{file}: {name}"
        while hasattr(value, "fwd_model"):
            path, value = path + ".fwd_model", value.fwd_model
        if (not variable or name == variable) and (
                hasattr(value, "stimulation") or hasattr(value, "electrode")):
            found[name] = (path, value)
    if len(found) == 1:
        return next(iter(found.values()))
    if found:
        raise InputError(f"{file}: holds several models, {', '.join(sorted(found))}; name one by "
                         "variable=")
    names = ", ".join(name for name in content if not name.startswith("__")) or "nothing"
    raise InputError(f"{file}: {variable or 'the file'} holds no EIDORS forward model (fmdl, or an img "
                     f"or inv_model with one in fwd_model); the file has {names}")


def _list(name: str, model, field: str) -> list:
    values = np.atleast_1d(getattr(model, field, np.empty(0))).ravel()
    if values.size == 0:
        made = "; set it by mk_stim_patterns" if field == "stimulation" else ""
        raise InputError(f"{name}: has no {field}{made}")
    return list(values)


def _dense(matrix) -> np.ndarray:
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix, dtype=float)


def _stimulation(name: str, model) -> Tuple[float, List[Pair], List[List[Pair]], int]:
    """The current, A, the drives and their measurements, and the number of electrodes."""
    electrodes = len(_list(name, model, "electrode"))
    currents: List[float] = []
    drives: List[Pair] = []
    measured: List[List[Pair]] = []
    for d, stimulation in enumerate(_list(name, model, "stimulation")):
        place = f"{name}.stimulation({d + 1})"
        stim, rows = (_dense(getattr(stimulation, field, ()))
                      for field in ("stim_pattern", "meas_pattern"))
        # SciPy takes axes of length one from full matrices; sparse ones keep both.
        if stim.shape not in ((electrodes,), (electrodes, 1)):
            raise InputError(f"{place}.stim_pattern: must be [electrodes, 1] for the model's "
                             f"{electrodes} electrodes, is {list(stim.shape)}")
        if rows.size == 0 or rows.shape[-1] != electrodes:
            raise InputError(f"{place}.meas_pattern: must be [measurements, electrodes] for the "
                             f"model's {electrodes} electrodes, is {list(rows.shape)}")
        first, second, current = _pair(stim.ravel(), f"{place}.stim_pattern", "a drive")
        currents.append(current)
        if abs(current - currents[0]) > 1e-9 * currents[0]:
            raise InputError(f"{place}.stim_pattern: drives {current:g} A, stimulation(1) "
                             f"{currents[0]:g} A; a sensor has one drive current")
        drives.append((second, first))  # a sensor's drives name first where current leaves the sheet
        measured.append([])
        for m, row in enumerate(rows.reshape(-1, electrodes)):
            first, second, gain = _pair(row, f"{place}.meas_pattern({m + 1},:)", "a measurement")
            if abs(gain - 1) > 1e-9:
                raise InputError(f"{place}.meas_pattern({m + 1},:): has a gain of {gain:g}; divide "
                                 "frames by it and set it to 1, a sensor's voltages have none")
            measured[-1].append((first, second))
    return currents[0], drives, measured, electrodes


def _pair(weights: np.ndarray, place: str, kind: str) -> Tuple[int, int, float]:
    """The electrodes of the positive and of the negative weight, and its size."""
    used = np.flatnonzero(weights)
    positive, negative = int(weights.argmax()), int(weights.argmin())
    size = float(weights[positive])
    if used.size != 2 or not abs(weights.sum()) <= 1e-9 * size:
        listed = ", ".join(f"{weights[e]:g} at {e + 1}" for e in used[:3])
        raise InputError(f"{place}: {kind} of a sensor is of two electrodes with opposite signs, this "
                         f"one is of {used.size} ({listed}{', ...' if used.size > 3 else ''})")
    return positive, negative, size


class _Mesh:
    """A sheet in the model's own unit: a disc, or a rectangle along the axes."""

    def __init__(self, name: str, model):
        self.name, self.model = name, model
        nodes = np.asarray(getattr(model, "nodes", ()), dtype=float)
        elements = np.asarray(getattr(model, "elems", ()))
        if nodes.ndim != 2 or elements.ndim != 2:
            self._refuse("has no nodes and elems")
        if nodes.shape[1] != 2:
            self._refuse(f"is {nodes.shape[1]}-dimensional, sensors are flat")
        if elements.shape[1] != 3 or elements.min() < 1 or elements.max() > len(nodes) or not (
                np.isfinite(nodes).all()):
            self._refuse("is not of triangles between its nodes")
        self.nodes = nodes
        sides = np.sort(elements.astype(int)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        sides, times = np.unique(sides, axis=0, return_counts=True)
        border = nodes[np.unique(sides[times == 1]) - 1]  # sides of one triangle alone
        corners = [nodes[elements[:, k].astype(int) - 1] for k in range(3)]
        a, b = corners[1] - corners[0], corners[2] - corners[0]
        area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2
        self.low, self.size = border.min(axis=0), np.ptp(border, axis=0)
        self.tolerance = 0.005 * self.size.max()
        inside = np.minimum(border - self.low, self.low + self.size - border).min(axis=1)
        # The circle through the border, by least squares: |p|^2 = 2 p.c + (r^2 - |c|^2).
        system = np.column_stack([2 * border, np.ones(len(border))])
        solution = np.linalg.lstsq(system, (border**2).sum(axis=1), rcond=None)[0]
        self.centre = solution[:2]
        radii = np.linalg.norm(border - self.centre, axis=1)
        self.radius = radii.mean()
        if inside.max() < self.tolerance and abs(area / self.size.prod() - 1) < 0.01:
            self.shape = "square" if abs(self.size[0] / self.size[1] - 1) < 1e-6 else "rectangle"
            self.length = 2 * self.size.sum()
        elif np.ptp(radii) < self.tolerance:
            self.shape, self.length = "disc", 2 * np.pi * self.radius
        else:
            self._refuse("is neither a disc nor a rectangle along the axes")

    def _refuse(self, what: str) -> None:
        raise InputError(f"{self.name}: the mesh {what}; give shape= and its size, and electrodes are "
                         "placed as in a sensor's file")

    def keys(self, electrodes: int, unit, given: Dict[str, Any]) -> Dict[str, Any]:
        scale = self._scale(unit, given)  # mm
        size = {"disc": 2 * self.radius, "square": self.size.mean(), "rectangle": self.size}[self.shape]
        places, widths, impedances = zip(*(self._electrode(e) for e in range(electrodes)))
        out = {"shape": self.shape, SIZES[self.shape]: _rounded(scale * size),
               **self._places(np.array(places), scale)}
        if max(widths) > 0:
            for what, values, tolerance in (("wide", widths, 0.05), ("z_contact", impedances, 1e-6)):
                if max(values) - min(values) > tolerance * max(values):
                    raise InputError(
                        f"{self.name}.electrode: has electrodes of {min(values):g} and of "
                        f"{max(values):g} ({what}); a sensor's electrodes are all alike")
            out.update(electrode_model="complete", electrode_width_mm=_rounded(scale * np.mean(widths)),
                       contact_impedance=_rounded(np.mean(impedances) * scale / 1000))
        return out

    def _scale(self, unit, given: Dict[str, Any]) -> float:
        """mm of the model's unit."""
        key = SIZES[self.shape]
        sizes = [size for size in SIZES.values() if size in given]
        extent = " x ".join(f"{side:g}" for side in self.size)
        if sizes != [key] * len(sizes):
            raise InputError(f"{sizes[0]}: the mesh is a {self.shape} of {extent}; give {key}=")
        if (unit is None) == (not sizes):
            raise InputError(f"unit: a model of EIDORS does not tell its unit, and this one is a "
                             f'{self.shape} of {extent}; give either unit="m" (or "cm", "mm") or {key}=')
        if unit is not None:
            if unit not in UNITS:
                raise InputError(f'unit: must be "m", "cm" or "mm", got {unit!r}')
            return UNITS[unit]
        own = 2 * self.radius if self.shape == "disc" else self.size
        try:
            scales = np.atleast_1d(np.asarray(given[key], dtype=float) / own)
        except (TypeError, ValueError):
            raise InputError(f"{key}: must be numbers, got {given[key]!r}") from None
        if np.ptp(scales) > 0.01 * scales.max():
            raise InputError(f"{key}: {given[key]} are not in the proportion of the mesh, {extent}")
        return float(scales.mean())

    def _electrode(self, e: int) -> Tuple[float, float, float]:
        """Of electrode e the middle and the width along the border, and the contact impedance."""
        electrode = _list(self.name, self.model, "electrode")[e]
        place = f"{self.name}.electrode({e + 1})"
        numbers = np.atleast_1d(getattr(electrode, "nodes", ())).astype(int).ravel()
        if numbers.size == 0 or numbers.min() < 1 or numbers.max() > len(self.nodes):
            raise InputError(f"{place}: has no nodes, or such as the mesh has not")
        along = np.array([self._along(self.nodes[number - 1], place) for number in numbers])
        apart = (along - along[0] + self.length / 2) % self.length - self.length / 2
        middle = along[0] + (apart.min() + apart.max()) / 2
        impedance = np.atleast_1d(getattr(electrode, "z_contact", 0)).astype(float)
        return middle % self.length, np.ptp(apart), impedance.mean() if impedance.size else 0.0

    def _along(self, point: np.ndarray, place: str) -> float:
        """The distance of a point along the border, clockwise from its start."""
        if self.shape == "disc":
            x, y = point - self.centre
            depth, along = abs(np.hypot(x, y) - self.radius), np.arctan2(x, y) * self.radius
        else:
            (width, height), (x, y) = self.size, point - self.low
            sides = [(height - y, x), (width - x, width + height - y),
                     (y, 2 * width + height - x), (x, 2 * width + height + y)]
            depth, along = min(sides)
        if depth > self.tolerance:
            raise InputError(f"{place}: a node is not on the border of the {self.shape}, "
                             f"{depth:g} from it")
        return along

    def _places(self, along: np.ndarray, scale: float) -> Dict[str, Any]:
        spacing = self.length / len(along)
        close = 1e-6 * spacing
        first = along[0] if along[0] < self.length - close else 0.0
        gaps = (along[1:] - first) % self.length - spacing * np.arange(1, len(along))
        if first < spacing - close and np.abs(gaps).max(initial=0) < close:
            return {"electrode_count": len(along), "electrode_offset_mm": _rounded(scale * first)}
        return {"electrode_places_mm": _rounded(scale * along)}


def _rounded(values) -> Any:
    """Without the last digits, which differ by how a mesh was made."""
    rounded = [float(f"{value:.12g}") for value in np.atleast_1d(values)]
    return rounded if np.ndim(values) else rounded[0]
