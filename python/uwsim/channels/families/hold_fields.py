"""The fields of /telemetry that describe a vehicle's holds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from uwsim.navigation.estimation import Navigator
from uwsim.simulator.vehicle import Vehicle


def hold_fields(vehicle: Vehicle, estimate: Navigator | None) -> dict[str, Any]:
    """Return the names of the active holds, their targets, and a note about the last hold that was lost.

    A depth hold keeps a height; its target is shown below the surface, like the depth gauge, as far as it is estimated.
    """
    holds = vehicle.holds
    if holds is None:
        return {"holds": [], "hold_targets": np.empty(0, np.float32), "hold_note": ""}
    targets = [_number(name, target, estimate) for name, target in holds.targets.items()]
    return {"holds": list(holds.targets), "hold_targets": np.array(targets, np.float32), "hold_note": holds.note}


def _number(name: str, target: list[float] | None, estimate: Navigator | None) -> float:
    if target is None:
        return math.nan
    if name == "position":
        return math.nan if estimate is None else math.dist(target, estimate.pose.position_world_m[:2])
    if name == "depth":
        return (0.0 if estimate is None else estimate.surface_m[0]) - target[0]
    return target[0]
