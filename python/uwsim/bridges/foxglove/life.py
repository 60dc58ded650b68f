"""Fish and bubbles in Foxglove's 3D panel, as ellipsoids and spheres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from foxglove.messages import Color, Pose, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, Vector3
from numpy.typing import NDArray

from uwsim.bridges.foxglove.primitives import timestamp
from uwsim.simulator.moving_shapes import Swarm

SHARES = {"fish": (1.0, 0.15, 0.28), "bubbles": (1.0, 1.0, 1.0)}
"""Length, width and height, of the size."""


def life(swarms: Sequence[Swarm], places: NDArray[np.float64], time_ns: int) -> SceneUpdate:
    """Return the swarms in the world frame. places (n, 6): positions and unit vectors ahead, swarm by swarm."""
    ends = np.cumsum([one.drawn for one in swarms])
    parts = np.split(places, ends[:-1])
    return SceneUpdate(entities=[_entity(one, part, time_ns) for one, part in zip(swarms, parts, strict=True)])


def _entity(swarm: Swarm, places: NDArray[np.float64], time_ns: int) -> SceneEntity:
    size = Vector3(**dict(zip("xyz", (swarm.size_m * share for share in SHARES[swarm.kind]), strict=True)))
    red, green, blue = swarm.colour
    color = Color(r=red, g=green, b=blue, a=1.0)
    turns = [Quaternion(x=x, y=y, z=z, w=w) for x, y, z, w in level_turns(places[:, 3:]).tolist()]
    spheres = [
        SpherePrimitive(pose=Pose(position=Vector3(x=x, y=y, z=z), orientation=turn), size=size, color=color)
        for (x, y, z), turn in zip(places[:, :3].tolist(), turns, strict=True)
    ]
    return SceneEntity(timestamp=timestamp(time_ns), id=swarm.name, frame_id="world", spheres=spheres)


def level_turns(ahead: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the quaternions x, y, z, w (n, 4) of bodies that look along unit vectors (n, 3), with level wings."""
    half_yaw = 0.5 * np.arctan2(ahead[:, 1], ahead[:, 0])
    half_pitch = -0.5 * np.arcsin(np.clip(ahead[:, 2], -1.0, 1.0))
    (cy, sy), (cp, sp) = ((np.cos(half), np.sin(half)) for half in (half_yaw, half_pitch))
    return np.column_stack([-sy * sp, cy * sp, sy * cp, cy * cp])
