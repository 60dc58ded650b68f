"""Boustrophedon coverage of any simple polygon at constant altitude, with lane spacing from swath and overlap.

Lanes are parallel to the side of the polygon that minimises their number (Huang, "Optimal line-sweep-based
decompositions for coverage algorithms", ICRA 2001). Where the polygon is concave, they are grouped into cells that are
mown one after the other (Choset, "Coverage of known spaces: the boustrophedon cellular decomposition", Autonomous
Robots 9, 2000). Patches that the sonar has not seen are then viewed from the distance where the fan hits the bed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arguments import require_positive
from uwsim.base.arrays import Floats
from uwsim.mapping import OccupancyMap
from uwsim.missions.heights import HIGHEST_Z_M
from uwsim.missions.lanes import Lane, Span, cells_of, ordered, spans
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.area_chart import AreaChart
from uwsim.missions.planners.area_pilot import AreaPilot
from uwsim.missions.planners.lane_flight import FlownLanes, fly_lanes
from uwsim.missions.planners.unknown_water import find_bed
from uwsim.missions.planners.wayfinder import PASSABLE_Z_M, Wayfinder
from uwsim.missions.steps import Steps, StoppedError
from uwsim.navigation.sensor_choice import height_above_bed_m

MOST_PATCHES = 40
TOO_NEAR, TOO_FAR = 1.1, 1.8  # distances from which to look at a patch, in multiples of the view distance


def look_at_unseen(pilot: AreaPilot) -> Steps[int]:
    """Look at each reachable unseen patch, nearest first; return the number tried. Logs `unseen` for each patch."""
    chart, vehicle, tried = pilot.chart, pilot.lookout.vehicle, 0
    given_up: list[NDArray[np.float64]] = []
    while tried < MOST_PATCHES:
        patches = np.array([p for p in chart.unseen_patches() if not any((p == q).all() for q in given_up)])
        if not len(patches):
            break
        ways = chart.ways_from(pilot.here())
        lengths_m = ways.lengths_m(patches)
        if not np.isfinite(lengths_m.min()):
            break
        patch = patches[int(np.argmin(lengths_m))]
        given_up.append(patch)
        tried += 1
        vehicle.log("unseen", position_m=patch.tolist())
        places = chart.open_places()
        away_m = np.linalg.norm(places - patch, axis=1) / pilot.lookout.view_m
        places = places[(away_m > TOO_NEAR) & (away_m < TOO_FAR)]
        back_m = ways.lengths_m(places)
        here_m = float(np.linalg.norm(patch - pilot.here()))
        if here_m < TOO_NEAR * pilot.lookout.view_m and len(places) and np.isfinite(back_m.min()):
            yield from pilot.go_to(places[int(np.argmin(back_m))])
        yield from pilot.go_to(patch, enough=lambda patch=patch: bool(chart.patch_seen(patch)))  # type: ignore[misc]
    return tried


@dataclass(frozen=True)
class MownArea(FlownLanes):
    """The outcome of `mow_area`. spacing_m: distance between lanes. lanes: number of lanes. Others: see FlownLanes."""

    spacing_m: float
    lanes: int


def mow_area(
    vehicle: OwnVehicle,
    area_m: Sequence[Sequence[float]] | Floats,
    *,
    altitude_m: float = 4.0,
    overlap: float = 0.2,
    speed_m_s: float = 0.6,
    known: OccupancyMap | None = None,
) -> Steps[MownArea]:
    """Mow a polygon (k, 2) at altitude_m above the bed, going around everything that cannot be passed over.

    The vehicle stays in the polygon: paths extend at most BEYOND_M outside it, except the initial approach. overlap:
    fraction of the swath shared by neighbouring lanes, in [0, 0.9]. known: a map from an earlier visit; parts that it
    shows to be too high are excluded before the flight. Patches not seen from the lanes are visited at the end. See
    fly_lanes for its log entries; `shallow` is logged where the water is too shallow for the altitude. Raises
    ValueError for invalid arguments, and StoppedError if no part of the area can be flown.
    """
    if not 0.0 <= overlap <= 0.9:
        raise ValueError(f"overlap = {overlap}: must be in [0, 0.9]")
    here = np.asarray(vehicle.pose.position_world_m[:2], np.float64)
    area = checked_area(area_m)
    chart = AreaChart(area, PASSABLE_Z_M, here)
    if known is not None:
        chart.add_map(known)
    lookout = Wayfinder(vehicle, altitude_m, speed_m_s, on_ping=lambda ping, echoes: chart.add(echoes))
    spacing_m = (1.0 - overlap) * lookout.swath_m
    lanes = boustrophedon_lanes(area, spacing_m, here)
    yield from lookout.tilt()
    yield from find_bed(vehicle)
    depth_m = height_above_bed_m(vehicle) - float(vehicle.pose.position_world_m[2])
    if altitude_m > depth_m + HIGHEST_Z_M:
        vehicle.log("shallow", depth_m=depth_m, altitude_m=altitude_m, kept_m=max(depth_m + HIGHEST_Z_M, 0.0))
    flown = yield from fly_lanes(lookout, lanes, chart)
    yield from look_at_unseen(AreaPilot(lookout, chart))
    if len(flown.left_out) == len(lanes):
        raise StoppedError("no lane of the area can be reached: it is too shallow, or enclosed")
    return MownArea(**vars(flown), spacing_m=spacing_m, lanes=len(lanes))


def boustrophedon_lanes(area_m: Sequence[Sequence[float]] | Floats, spacing_m: float, near_m: Floats) -> list[Lane]:
    """Cover a simple polygon (k, 2), concave or not, with lanes at most spacing_m apart, in flight order.

    Raises ValueError for a polygon without area or a non-positive spacing.
    """
    area = checked_area(area_m)
    require_positive(spacing_m=spacing_m)
    along = _direction(area)
    across = np.array([-along[1], along[0]])
    sweeps = _sweeps(area @ along, area @ across, spacing_m)
    cells = [
        [Lane(first * along + offset * across, last * along + offset * across) for offset, (first, last) in cell]
        for cell in cells_of(sweeps)
    ]
    return ordered(cells, near_m)


def checked_area(area_m: Sequence[Sequence[float]] | Floats) -> Floats:
    """Return the corners (k, 2) of a simple polygon. Raises ValueError if it is not simple or has no area."""
    import shapely  # imported here, since it takes 0.2 s

    area = np.asarray(area_m, np.float64)
    if area.ndim != 2 or area.shape[1:] != (2,) or len(area) < 3 or not np.isfinite(area).all():
        raise ValueError(f"area_m.shape = {area.shape}: must be (k, 2) finite corners, k at least 3")
    polygon = shapely.Polygon(area)
    if polygon.area < 1e-6 and polygon.convex_hull.area < 1e-6:
        raise ValueError(f"area_m = {area.tolist()} m: has no area")
    if not polygon.is_valid:
        raise ValueError(f"area_m = {area.tolist()} m: its sides must not cross: {shapely.is_valid_reason(polygon)}")
    return area


def _direction(area: Floats) -> Floats:
    """Return the unit vector along the side across which the polygon is narrowest."""
    sides = np.roll(area, -1, axis=0) - area
    lengths = np.linalg.norm(sides, axis=1)
    units = sides[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    widths = [float(np.ptp(area @ (-y, x))) for x, y in units]
    return np.asarray(units[int(np.argmin(np.round(widths, 9)))])


def _sweeps(along: Floats, across: Floats, spacing_m: float) -> list[tuple[float, list[Span]]]:
    """Return parallel lines at most spacing_m apart, each with its intervals inside the polygon.

    The outermost lines are at most spacing_m / 2 from the polygon's outermost corners, and from the reflex
    corners at which cells meet.
    """
    sweeps = []
    for low, high in pairwise(_ends_and_inner_corners(along, across)):
        count = max(1, math.ceil((high - low) / spacing_m - 1e-9))
        offsets = low + (np.arange(count) + 0.5) * (high - low) / count
        sweeps += [(offset, spans(along, across, offset)) for offset in offsets.tolist()]
    return sweeps


def _ends_and_inner_corners(along: Floats, across: Floats) -> list[float]:
    """Return the sorted offsets of the polygon's ends and its concave corners."""
    into = along - np.roll(along, 1), across - np.roll(across, 1)
    out = np.roll(along, -1) - along, np.roll(across, -1) - across
    turns = into[0] * out[1] - into[1] * out[0]
    area = float(np.sum(along * np.roll(across, -1) - across * np.roll(along, -1)))
    inner = across[turns * area < -1e-9]
    return sorted(set(np.round([across.min(), across.max(), *inner], 6).tolist()))
