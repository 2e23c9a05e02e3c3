"""Contacts: regions of the sheet whose conductivity differs from the background's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable, List, Sequence, Tuple, Union

from ._core import InputError
from .sensor import json_of

Point = Tuple[float, float]


class _Contact:
    """What the shapes share: their form in the program's files, in mm or in domain units."""

    ratio: float
    unit: str

    def _lengths(self) -> dict:
        raise NotImplementedError

    def _spec(self) -> dict:
        keys = {"shape": type(self).__name__.lower(), "conductivity_ratio": float(self.ratio)}
        unit = self.unit
        if unit not in ("mm", "domain"):
            raise InputError(f'unit: must be "mm" or "domain" (the sheet from -1 to 1), got {unit!r}')
        for key, value in self._lengths().items():
            keys[key + ("_mm" if unit == "mm" else "")] = value
        angle = getattr(self, "angle", 0)
        if angle:
            keys["angle"] = float(angle)
        return keys


def _pair(values: Sequence[float]) -> List[float]:
    return [float(value) for value in values]


@dataclass(frozen=True)
class Disc(_Contact):
    """A disc.

    centre: (x, y) from the middle of the sheet. radius: > 0. ratio: conductivity over the
    background's, 1e-6 to 1000. unit: "mm", or "domain" where half a square's side is 1.
    """

    centre: Point
    radius: float
    ratio: float
    unit: str = "mm"

    def _lengths(self) -> dict:
        return {"centre": _pair(self.centre), "radius": float(self.radius)}


@dataclass(frozen=True)
class Ellipse(_Contact):
    """An ellipse with two semi_axes, the first at `angle` against x, counter-clockwise, rad."""

    centre: Point
    semi_axes: Point
    ratio: float
    angle: float = 0
    unit: str = "mm"

    def _lengths(self) -> dict:
        return {"centre": _pair(self.centre), "semi_axes": _pair(self.semi_axes)}


@dataclass(frozen=True)
class Rectangle(_Contact):
    """A rectangle with two half_sides, the first at `angle` against x, counter-clockwise, rad."""

    centre: Point
    half_sides: Point
    ratio: float
    angle: float = 0
    unit: str = "mm"

    def _lengths(self) -> dict:
        return {"centre": _pair(self.centre), "half_sides": _pair(self.half_sides)}


@dataclass(frozen=True)
class Polygon(_Contact):
    """A polygon with 3 to 64 vertices in order; its sides must not cross."""

    vertices: Tuple[Point, ...]
    ratio: float
    unit: str = "mm"

    def _lengths(self) -> dict:
        return {"vertices": [_pair(vertex) for vertex in self.vertices]}


Contact = Union[Disc, Ellipse, Rectangle, Polygon]


def scenes_text(scenes: Iterable[Sequence[Contact]]) -> str:
    """The scenes as the program's JSON."""
    return json_of([{"contacts": [one._spec() for one in contacts_of(scene)]} for scene in scenes])


def contacts_of(scene: Any) -> List[_Contact]:
    """The contacts of one scene: a contact, or a sequence of them."""
    contacts = [scene] if isinstance(scene, _Contact) else list(scene)
    for contact in contacts:
        if not isinstance(contact, _Contact):
            raise InputError("contacts: must be Disc, Ellipse, Rectangle or Polygon, got "
                             + type(contact).__name__)
    return contacts
