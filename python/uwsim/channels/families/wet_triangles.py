"""The triangles of a hull that are under water, as Foxglove and RViz draw them. They are true, not measured."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.families.forces import ADD, MARKER, still_pose
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator

RATE_HZ = 2.0  # a message of 2000 triangles takes 14 ms
DELETE, TRIANGLE_LIST = 2, 11
SHALLOW, DEEP = (0.70, 0.90, 1.00), (0.03, 0.19, 0.50)
SHADES = 16
"""Colours between the smallest and the largest pressure."""


def wet_triangles_channels(source: Source, *, truth: bool) -> list[Channel]:
    """Return a vehicle's channel of wet triangles, which are computed only while it is subscribed to."""
    frame_id = source.frame("base_link")
    found = Channel(
        source.topic("wet_triangles"), MARKER, "out",
        "the triangles of the hull that are under water; the darker, the higher the pressure",
        rate_hz=RATE_HZ, frame_id=frame_id, delivery=Delivery(on_request=True),
        read=lambda sim: _marker(source, sim, frame_id),
    )  # fmt: skip
    return [found] if truth else []


def _marker(source: Source, sim: Simulator, frame_id: str) -> Any:
    wet = source.of(sim).wet_triangles()
    header = build.header(sim.time_ns, frame_id)
    if not len(wet):
        return build.message(MARKER, header=header, ns="wet_triangles", action=DELETE)
    pressures_pa = np.linalg.norm(wet.forces_body_n, axis=1) / wet.areas_m2
    return build.message(
        MARKER, header=header, ns="wet_triangles", type=TRIANGLE_LIST, action=ADD, pose=still_pose(),
        scale=build.vector((1.0, 1.0, 1.0)), color=_shade(SHADES // 2),
        points=_points(wet.corners_body_m.reshape(-1, 3)),
        colors=[_shade(shade) for shade in np.repeat(_shades(pressures_pa), 3).tolist()],
    )  # fmt: skip


def _points(corners_m: NDArray[np.float64]) -> list[Any]:
    return [build.message("geometry_msgs/msg/Point", x=x, y=y, z=z) for x, y, z in corners_m.tolist()]


def _shades(pressures_pa: NDArray[np.float64]) -> NDArray[np.int64]:
    low, high = pressures_pa.min(), pressures_pa.max()
    share = (pressures_pa - low) / max(high - low, 1e-9)
    return np.asarray(np.rint(share * (SHADES - 1)), np.int64)


@cache
def _shade(index: int) -> Any:
    share = index / (SHADES - 1)
    red, green, blue = (a + share * (b - a) for a, b in zip(SHALLOW, DEEP, strict=True))
    return build.message("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0)
