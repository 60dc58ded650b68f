"""Parallel lanes that cover a polygon, flown in a lawn-mower pattern, and their lengths, flown and planned."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from uwsim.base.arrays import Floats

LANE_FLOWN, LANES_FLOWN = "lane_flown", "lanes_flown"
"""The events at the end of each lane and of all."""
LEAST_FLOWN = 0.95
"""The share of the planned length below which a mission over lanes is not complete."""


@dataclass(frozen=True)
class LaneEnd:
    """The end of a lane: how much of it was flown, and why no more; "" if it was flown to its end."""

    flown_m: float
    because: str


def lane_values(number: int, planned_m: float, end: LaneEnd) -> dict[str, float | str]:
    """Return the values of the event LANE_FLOWN."""
    why = {"because": end.because} if end.because else {}
    return {"number": number, "flown_m": round(end.flown_m, 2), "planned_m": round(planned_m, 2), **why}


def not_flown_because(flown_m: float, planned_m: float, ended: Iterable[LaneEnd]) -> str:
    """Return a clause that states how much was flown, and why lanes were cut short."""
    reasons = Counter(end.because for end in ended if end.because)
    cut = "; ".join(f"{reason} on {count} of the lanes" for reason, count in reasons.most_common())
    return f"only {flown_text(flown_m, planned_m)} was flown{f': {cut}' if cut else ''}"


def flown_text(flown_m: float, planned_m: float) -> str:
    """Return text such as `93.2 % of the planned lanes (178 of 191 m)`, never rounded up."""
    percent = math.floor(1000.0 * flown_m / planned_m) / 10.0 if planned_m > 0.0 else 100.0
    return f"{percent:g} % of the planned lanes ({flown_m:,.0f} of {planned_m:,.0f} m)"


Span = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Lane:
    """A straight line to fly from start_m to end_m, (2,) each."""

    start_m: Floats
    end_m: Floats

    @cached_property
    def length_m(self) -> float:
        """Distance from start to end."""
        return float(np.linalg.norm(self.end_m - self.start_m))

    @cached_property
    def heading_rad(self) -> float:
        """Direction of the lane, counterclockwise from east."""
        return math.atan2(self.direction[1], self.direction[0])

    @cached_property
    def direction(self) -> Floats:
        """Unit vector from start to end."""
        return (self.end_m - self.start_m) / self.length_m

    def locate(self, point_m: Floats) -> tuple[float, float]:
        """Return (along, across) of a point: metres past the start, and metres to port of the line."""
        along_x, along_y, start_x, start_y = self._line
        dx, dy = float(point_m[0]) - start_x, float(point_m[1]) - start_y
        return along_x * dx + along_y * dy, along_x * dy - along_y * dx

    def point(self, along_m: float) -> tuple[float, float]:
        """Return the point of the line at a distance past the start."""
        along_x, along_y, start_x, start_y = self._line
        return start_x + along_m * along_x, start_y + along_m * along_y

    @cached_property
    def _line(self) -> tuple[float, ...]:
        """Direction and start as Python floats, which are faster than arrays in a control loop."""
        return (*self.direction.tolist(), *np.asarray(self.start_m, np.float64).tolist())


def lawn_mower_lanes(
    area_m: Sequence[Sequence[float]] | Floats,
    spacing_m: float,
    run_out_m: float,
    near_m: Floats,
    *,
    heading_deg: float | None = None,
    cross_lines: int = 0,
) -> list[Lane]:
    """Cover a simple polygon with parallel lanes, flown back and forth from the corner nearest to near_m.

    Where the polygon is concave, a line across it is split into several lanes; the lanes are then grouped into cells,
    which are flown one after the other. The lanes run parallel to the polygon's longest edge, at most spacing_m apart
    and at most spacing_m / 2 from its sides, and extend run_out_m beyond it at both ends, so that a forward-looking
    sonar sees the polygon's rim. heading_deg: their direction or its opposite, clockwise from y, in place of the
    longest edge's. cross_lines: the number of lanes across all others, evenly spaced, that are flown after them. Raises
    ValueError if no lane fits.
    """
    area = np.asarray(area_m, np.float64)
    if heading_deg is None:
        along = max(np.roll(area, -1, axis=0) - area, key=np.linalg.norm)
        along = along / np.linalg.norm(along)
    else:
        along = np.array([math.sin(math.radians(heading_deg)), math.cos(math.radians(heading_deg))])
    across = np.array([-along[1], along[0]])
    width_m = float(np.ptp(area @ across))
    lanes = ordered(_cells(area, along, max(1, math.ceil(width_m / spacing_m)), run_out_m), near_m)
    if not cross_lines:
        return lanes
    return lanes + ordered(_cells(area, across, cross_lines, run_out_m), lanes[-1].end_m)


def _cells(area: Floats, along: Floats, count: int, run_out_m: float) -> list[list[Lane]]:
    """Return a number of evenly spaced lanes along a direction, in cells. Raises ValueError if no lane fits."""
    across = np.array([-along[1], along[0]])
    low, high = (area @ across).min(), (area @ across).max()
    offsets = low + (np.arange(count) + 0.5) * (high - low) / count
    sweeps = [(offset, spans(area @ along, area @ across, offset)) for offset in offsets.tolist()]
    cells = [
        [
            Lane((first - run_out_m) * along + offset * across, (last + run_out_m) * along + offset * across)
            for offset, (first, last) in cell
        ]
        for cell in cells_of(sweeps)
    ]
    if not cells:
        raise ValueError(f"survey.area_m = {area.tolist()} m: no lane fits into it")
    return cells


def spans(along: Floats, across: Floats, offset: float) -> list[Span]:
    """Return the intervals of the line at `offset` that lie inside the polygon.

    along, across: along-line and across-line coordinates of the polygon's corners.
    """
    crossings = []
    for k in range(len(along)):
        a, b = across[k - 1], across[k]
        if (a < offset) != (b < offset):
            crossings.append(float(along[k - 1] + (offset - a) / (b - a) * (along[k] - along[k - 1])))
    crossings.sort()
    return [(first, last) for first, last in zip(crossings[::2], crossings[1::2], strict=True) if last > first]


def cells_of(sweeps: Sequence[tuple[float, list[Span]]]) -> list[list[tuple[float, Span]]]:
    """Group the spans of successive lines into cells; a cell ends where the polygon splits or merges."""
    cells: list[list[tuple[float, Span]]] = []
    open_cells: list[list[tuple[float, Span]]] = []
    for offset, here in sweeps:
        following = []
        for span in here:
            before = [cell for cell in open_cells if _overlap(cell[-1][1], span)]
            alone = len(before) == 1 and sum(_overlap(before[0][-1][1], other) for other in here) == 1
            cell = before[0] if alone else []
            if not alone:
                cells.append(cell)
            following.append(cell)
        for cell, span in zip(following, here, strict=True):
            cell.append((offset, span))
        open_cells = following
    return cells


def _overlap(a: Span, b: Span) -> bool:
    return a[0] < b[1] and b[0] < a[1]


def ordered(cells: Sequence[list[Lane]], near_m: Floats) -> list[Lane]:
    """Return the lanes in flight order: after each cell, the one whose start is nearest comes next."""
    flown: list[Lane] = []
    here, left = near_m, list(cells)
    while left:
        choices = [(cell, lanes) for cell in left for lanes in _ways_to_fly(cell)]
        cell, lanes = min(choices, key=lambda choice: float(np.linalg.norm(choice[1][0].start_m - here)))
        flown += lanes
        here = lanes[-1].end_m
        left = [other for other in left if other is not cell]
    return flown


def _ways_to_fly(lanes: list[Lane]) -> list[list[Lane]]:
    """Return the possible flight orders: alternating directions, from either end of the first or the last lane."""
    turned = [Lane(lane.end_m, lane.start_m) for lane in lanes]
    both = [(lanes, turned), (lanes[::-1], turned[::-1]), (turned, lanes), (turned[::-1], lanes[::-1])]
    return [[pair[k % 2] for k, pair in enumerate(zip(*ways, strict=True))] for ways in both]
