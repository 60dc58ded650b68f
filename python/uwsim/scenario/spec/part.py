"""Parts of an obstacle that an inspection looks for: joints, anodes, defects, holes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Part(NamedTuple):
    """A part of an obstacle. kind: such as anode, damage or hole. place_m (3,): its middle, in the world."""

    kind: str
    place_m: Floats


def places_by_kind(parts: Iterable[Part]) -> dict[str, Floats]:
    """Return the places (n, 3) of parts, by kind."""
    found: dict[str, list[Floats]] = {}
    for part in parts:
        found.setdefault(part.kind, []).append(part.place_m)
    return {kind: np.array(places) for kind, places in found.items()}
