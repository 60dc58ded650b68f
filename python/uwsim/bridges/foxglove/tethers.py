"""The tethers in Foxglove's 3D panel, coloured by tension."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from foxglove.messages import Color, LinePrimitive, LinePrimitiveLineType, SceneEntity, SceneUpdate
from numpy.typing import ArrayLike, NDArray

from uwsim.bridges.foxglove.primitives import points, timestamp
from uwsim.scenario import Scenario
from uwsim.simulator.tether import TetherReading

SLACK_N = 1.0
STOPS = np.array([[0.25, 0.6, 1.0], [1.0, 0.9, 0.3], [1.0, 0.15, 0.1]])
"""Colours of a slack tether, between, and at the breaking load, as on the station's page (map3d/tethers.js)."""
WIDTH_PX = 3.0


def tension_colours(tensions_n: ArrayLike, breaking_load_n: float) -> NDArray[np.float64]:
    """Return colours (n, 3) by the logarithms of tensions (n,) [N], between 1 N and the breaking load."""
    tensions = np.maximum(np.asarray(tensions_n, float), SLACK_N) / SLACK_N
    share = np.log(tensions) / np.log(max(breaking_load_n, 10.0 * SLACK_N) / SLACK_N)
    return np.stack([np.interp(share, [0.0, 0.5, 1.0], stop) for stop in STOPS.T], axis=-1)


def tethers(now: Mapping[str, TetherReading], scenario: Scenario, time_ns: int) -> SceneUpdate:
    """Return the tethers by name as lines in the world frame, without the elements that have broken."""
    entities = []
    for one in scenario.tethered:
        reading = now[one.name]
        ends = np.stack([reading.points_world_m[:-1], reading.points_world_m[1:]], axis=1)[reading.is_whole]
        colours = np.repeat(tension_colours(reading.tensions_n, one.tether.breaking_load_n)[reading.is_whole], 2, 0)
        lines = LinePrimitive(
            type=LinePrimitiveLineType.LineList, points=points(ends.reshape(-1, 3)), thickness=WIDTH_PX,
            scale_invariant=True, colors=[Color(r=r, g=g, b=b, a=1.0) for r, g, b in colours.tolist()],
        )  # fmt: skip
        name = f"tether of {one.name}"
        entities.append(SceneEntity(timestamp=timestamp(time_ns), id=name, frame_id="world", lines=[lines]))
    return SceneUpdate(entities=entities)
