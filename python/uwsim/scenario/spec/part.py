"""Parts of an obstacle that an inspection looks for, each with a test for where a picture shows it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Seen(NamedTuple):
    """The points that straight rays from one eye met first, in the world frame.

    eye_m (3,): where they begin. points_m (n, 3): where each met a surface. is_on (n,): true if that is the obstacle's.
    """

    eye_m: Floats
    points_m: Floats
    is_on: Mask


@dataclass(frozen=True, eq=False)
class Part:
    """A part of an obstacle, such as an anode, a damaged place, a hole, or what has grown on it.

    kind: its class in labelled pictures. place_m (3,): its middle, which the goal `find` looks for; None for a part
    without one. radius_m: of a sphere about it that contains the part. shows: returns a mask (n,) of the rays that
    end on the part or, for a hole, pass through it; it may be given those near the sphere only.
    """

    kind: str
    place_m: Floats | None
    radius_m: float
    shows: Callable[[Seen], Mask]

    def mask(self, seen: Seen) -> Mask:
        """Return the mask (n,) of the rays that show the part."""
        if self.place_m is None:
            return self.shows(seen)
        ways = seen.points_m - seen.eye_m
        to_place = self.place_m - seen.eye_m
        # The distance of the sphere's middle from the segment between the eye and the surface.
        length2 = np.maximum(np.einsum("nk,nk->n", ways, ways), 1e-12)
        along = np.clip(ways @ to_place / length2, 0.0, 1.0)
        off = ways * along[:, None] - to_place
        near = np.asarray(np.einsum("nk,nk->n", off, off) <= self.radius_m**2)
        if near.any():
            near[near] = self.shows(Seen(seen.eye_m, seen.points_m[near], seen.is_on[near]))
        return near


def places_by_kind(parts: Iterable[Part]) -> dict[str, Floats]:
    """Return the places (n, 3) of the parts that have one, by kind."""
    found: dict[str, list[Floats]] = {}
    for part in parts:
        if part.place_m is not None:
            found.setdefault(part.kind, []).append(part.place_m)
    return {kind: np.array(places) for kind, places in found.items()}
