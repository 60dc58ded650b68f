"""Boustrophedon over any simple polygon: lanes as far apart as swath and overlap allow, at a height above the bed.

Lanes are parallel to the polygon's side that makes them fewest (Huang, "Optimal line-sweep-based decompositions for
coverage algorithms", ICRA 2001). Where the polygon is concave, they fall into cells that are mown one after the other
(Choset, "Coverage of known spaces: the boustrophedon cellular decomposition", Autonomous Robots 9, 2000).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from uwsim.missions.lanes import Lane
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.lookout import Lookout
from uwsim.missions.planners.unknown_water import find_bed
from uwsim.missions.steps import Steps

Floats = NDArray[np.float64]
Span = tuple[float, float]


@dataclass(frozen=True)
class MownArea:
    """spacing_m: of the lanes. lanes: how many there are. left_out: lanes to whose start or end no way led."""

    spacing_m: float
    lanes: int
    left_out: tuple[int, ...]


def mow_area(
    vehicle: OwnVehicle,
    area_m: Sequence[Sequence[float]] | Floats,
    *,
    altitude_m: float = 4.0,
    overlap: float = 0.2,
    speed_m_s: float = 0.6,
) -> Steps[MownArea]:
    """Mow a polygon (k, 2) at altitude_m above the bed, round what cannot be passed over.

    overlap: share of the swath that neighbouring lanes both see, in [0, 0.9]. Logs `lane` for each one, and `left_out`.
    Raises ValueError, StoppedError.
    """
    if not 0.0 <= overlap <= 0.9:
        raise ValueError(f"overlap = {overlap}: must be in [0, 0.9]")
    lookout = Lookout(vehicle, altitude_m, speed_m_s)
    spacing_m = (1.0 - overlap) * lookout.swath_m
    lanes = boustrophedon_lanes(area_m, spacing_m, np.asarray(vehicle.pose.position_world_m[:2], np.float64))
    yield from lookout.tilt()
    yield from find_bed(vehicle)
    return MownArea(spacing_m, len(lanes), (yield from fly_lanes(lookout, lanes)))


def fly_lanes(lookout: Lookout, lanes: Sequence[Lane]) -> Steps[tuple[int, ...]]:
    """Fly lanes in their order; return the numbers of those to whose start or end no way led, which are logged."""
    left_out = []
    for k, lane in enumerate(lanes):
        started = yield from lookout.go_to(lane.start_m)
        lookout.vehicle.log("lane", number=k, of=len(lanes))
        if not (yield from lookout.go_to(lane.end_m)) or not started:
            left_out.append(k)
            lookout.vehicle.log("left_out", number=k)
    return tuple(left_out)


def boustrophedon_lanes(area_m: Sequence[Sequence[float]] | Floats, spacing_m: float, near_m: Floats) -> list[Lane]:
    """Cover a simple polygon (k, 2), concave or not, by lanes at most spacing_m apart, in the order to fly them.

    Raises ValueError for a polygon without area, or a spacing that is not positive.
    """
    area = np.asarray(area_m, np.float64)
    if area.ndim != 2 or area.shape[1:] != (2,) or len(area) < 3 or not np.isfinite(area).all():
        raise ValueError(f"area_m.shape = {area.shape}: must be (k, 2) finite corners, k at least 3")
    if not 0.0 < spacing_m < math.inf:
        raise ValueError(f"spacing_m = {spacing_m} m: must be positive")
    following = np.roll(area, -1, axis=0)
    area_m2 = 0.5 * abs(float(np.sum(area[:, 0] * following[:, 1] - area[:, 1] * following[:, 0])))
    if area_m2 < 1e-6:
        raise ValueError(f"area_m = {area.tolist()} m: has no area")
    along = _direction(area)
    across = np.array([-along[1], along[0]])
    sweeps = _sweeps(area @ along, area @ across, spacing_m)
    cells = [
        [Lane(first * along + offset * across, last * along + offset * across) for offset, (first, last) in cell]
        for cell in _cells(sweeps)
    ]
    return _ordered(cells, near_m)


def _direction(area: Floats) -> Floats:
    """The unit vector along that side across which the polygon is narrowest."""
    sides = np.roll(area, -1, axis=0) - area
    lengths = np.linalg.norm(sides, axis=1)
    units = sides[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    widths = [float(np.ptp(area @ (-y, x))) for x, y in units]
    return np.asarray(units[int(np.argmin(np.round(widths, 9)))])


def _sweeps(along: Floats, across: Floats, spacing_m: float) -> list[tuple[float, list[Span]]]:
    """Parallel lines, at most spacing_m apart, and what of each is in the polygon.

    The outermost ones are half of that from the polygon's ends and from its inner corners, where cells meet.
    """
    sweeps = []
    for low, high in pairwise(_ends_and_inner_corners(along, across)):
        count = max(1, math.ceil((high - low) / spacing_m - 1e-9))
        offsets = low + (np.arange(count) + 0.5) * (high - low) / count
        sweeps += [(offset, _spans(along, across, offset)) for offset in offsets.tolist()]
    return sweeps


def _ends_and_inner_corners(along: Floats, across: Floats) -> list[float]:
    """The offsets, in order, of the polygon's ends and of the corners at which it is concave."""
    into = along - np.roll(along, 1), across - np.roll(across, 1)
    out = np.roll(along, -1) - along, np.roll(across, -1) - across
    turns = into[0] * out[1] - into[1] * out[0]
    area = float(np.sum(along * np.roll(across, -1) - across * np.roll(along, -1)))
    inner = across[turns * area < -1e-9]
    return sorted(set(np.round([across.min(), across.max(), *inner], 6).tolist()))


def _spans(along: Floats, across: Floats, offset: float) -> list[Span]:
    """Where a line is in the polygon: from one crossing of its sides to the next."""
    crossings = []
    for k in range(len(along)):
        a, b = across[k - 1], across[k]
        if (a < offset) != (b < offset):
            crossings.append(float(along[k - 1] + (offset - a) / (b - a) * (along[k] - along[k - 1])))
    crossings.sort()
    return [(first, last) for first, last in zip(crossings[::2], crossings[1::2], strict=True) if last > first]


def _cells(sweeps: list[tuple[float, list[Span]]]) -> list[list[tuple[float, Span]]]:
    """Join spans of neighbouring lines into cells: a cell ends where the polygon splits or merges."""
    cells: list[list[tuple[float, Span]]] = []
    open_cells: list[list[tuple[float, Span]]] = []
    for offset, spans in sweeps:
        following = []
        for span in spans:
            before = [cell for cell in open_cells if _overlap(cell[-1][1], span)]
            alone = len(before) == 1 and sum(_overlap(before[0][-1][1], other) for other in spans) == 1
            cell = before[0] if alone else []
            if not alone:
                cells.append(cell)
            following.append(cell)
        for cell, span in zip(following, spans, strict=True):
            cell.append((offset, span))
        open_cells = following
    return cells


def _overlap(a: Span, b: Span) -> bool:
    return a[0] < b[1] and b[0] < a[1]


def _ordered(cells: list[list[Lane]], near_m: Floats) -> list[Lane]:
    """The lanes, each next cell and the corner to begin it at being the nearest to where the last one ended."""
    flown: list[Lane] = []
    here, left = near_m, list(cells)
    while left:
        choices = [(cell, lanes) for cell in left for order in (cell, cell[::-1]) for lanes in _both_ways(order)]
        cell, lanes = min(choices, key=lambda choice: float(np.linalg.norm(choice[1][0].start_m - here)))
        flown += lanes
        here = lanes[-1].end_m
        left = [other for other in left if other is not cell]
    return flown


def _both_ways(lanes: list[Lane]) -> list[list[Lane]]:
    """The lanes back and forth, begun at either end of the first one."""
    turned = [Lane(lane.end_m, lane.start_m) for lane in lanes]
    return [[pair[(k + first) % 2] for k, pair in enumerate(zip(lanes, turned, strict=True))] for first in (0, 1)]
