"""Visits patches of an area that the sonar has not seen, viewing each from the distance where the fan hits the bed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.missions.planners.area_pilot import AreaPilot
from uwsim.missions.steps import Steps

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
