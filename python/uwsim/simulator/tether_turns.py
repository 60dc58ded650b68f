"""Entanglement: how often a tether goes round the upright obstacles of a scenario."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.scenario.obstacles.cylinder import Cylinder
from uwsim.scenario.obstacles.gate import Gate
from uwsim.scenario.spec.scenario import Scenario

MOST_TILT_DEG = 20.0


def upright_axes(scenario: Scenario) -> dict[str, tuple[float, float]]:
    """Return east and north of the vertical axes that a tether may go round, by name.

    They are those of cylinders within 20 degrees of upright, and of a gate's two posts, `<gate> left` and `right` as
    one flies through it along its yaw.
    """
    axes: dict[str, tuple[float, float]] = {}
    for item in scenario.obstacles:
        if isinstance(item, Cylinder):
            _, pitch, roll = np.radians(item.yaw_pitch_roll_deg)
            if math.cos(pitch) * math.cos(roll) >= math.cos(math.radians(MOST_TILT_DEG)):
                axes[item.name] = (item.position_m[0], item.position_m[1])
        elif isinstance(item, Gate):
            yaw, half_m = math.radians(item.yaw_deg), 0.5 * item.width_m
            for side, sign in (("left", 1.0), ("right", -1.0)):
                at_m = (
                    item.position_m[0] - sign * half_m * math.sin(yaw),
                    item.position_m[1] + sign * half_m * math.cos(yaw),
                )
                axes[f"{item.name} {side}"] = at_m
    return axes


def turns_about(points_world_m: Floats, axis_m: tuple[float, float]) -> int:
    """Return the winding number about a vertical axis of a tether (n, 3) that is closed by the straight line back.

    Seen from above and positive counter-clockwise: 0 if the tether can be drawn tight, and 1 or -1 if the axis holds it
    on the way, or it goes once round. One that passes over the top of an obstacle counts, too.
    """
    offsets = points_world_m[:, :2] - axis_m
    angles = np.arctan2(offsets[:, 1], offsets[:, 0])
    ways = np.append(np.diff(angles), angles[0] - angles[-1])
    return round(float(np.sum((ways + math.pi) % (2 * math.pi) - math.pi)) / (2 * math.pi))


def turns(points_world_m: Floats, axes: Mapping[str, tuple[float, float]]) -> dict[str, int]:
    """Return turns_about each axis, by its name."""
    return {name: turns_about(points_world_m, axis_m) for name, axis_m in axes.items()}
