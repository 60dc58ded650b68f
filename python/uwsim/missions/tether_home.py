"""A mission step for tethered vehicles: the way home along the tether."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.missions.moves import goto
from uwsim.missions.own_vehicle import own_vehicle
from uwsim.missions.steps import Steps, StoppedError
from uwsim.missions.vehicle import Vehicle

SPACING_M = 2.0
BENT = 0.3
"""The change of direction [rad] over twice SPACING_M from which a tether is held by something on the inside."""


def follow_tether(
    vehicle: Vehicle, *, short_of_m: float = 1.0, clear_m: float = 1.5, speed_m_s: float = 0.5, lowest_m: float = -1e4
) -> Steps[None]:
    """Move home along the tether as it lies now, which takes it off whatever it goes round.

    short_of_m: how far along the tether from its anchor to stop. clear_m: distance kept on the outside of bends, where
    the tether is held. lowest_m: z below which the way does not lead, however low the tether hangs. Raises ValueError
    for a vehicle without a tether, and StoppedError for a broken one.
    """
    own = own_vehicle(vehicle)
    if own.tether is None:
        raise ValueError(f"follow_tether: vehicle = '{own.name}': must have a tether")
    now = own.tether.read()
    if now.broken_at_m is not None:
        raise StoppedError("the tether is broken and leads nowhere")
    for place in way_along(now.points_world_m, short_of_m, clear_m):
        place[2] = min(max(place[2], lowest_m), -0.3)
        yield from goto(vehicle, place, speed_m_s=speed_m_s, within_m=0.6)


def way_along(points_world_m: NDArray[np.float64], short_of_m: float, clear_m: float) -> NDArray[np.float64]:
    """Return places (m, 3) along a tether (n, 3) from its second end to its first, outside of its bends."""
    points = points_world_m[::-1]
    along_m = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    end_m = max(along_m[-1] - short_of_m, 0.0)

    def at(distance_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.column_stack([np.interp(distance_m, along_m, points[:, k]) for k in range(3)])

    stations_m = np.append(np.arange(SPACING_M, end_m, SPACING_M), end_m)
    places = at(stations_m)
    before, after = places - at(stations_m - SPACING_M), at(stations_m + SPACING_M) - places
    bends = (after / np.maximum(np.linalg.norm(after, axis=1), 1e-9)[:, None]) - (
        before / np.maximum(np.linalg.norm(before, axis=1), 1e-9)[:, None]
    )
    bends[:, 2] = 0.0
    sharp = np.linalg.norm(bends, axis=1)
    held = (sharp > BENT) & (stations_m < end_m)
    places[held] -= clear_m * bends[held] / sharp[held, None]
    return places
