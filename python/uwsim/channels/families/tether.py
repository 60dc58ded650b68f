"""Tethers of vehicles and loose bodies: shape, tension and length. They are true, not measured."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator

RATE_HZ = 10.0
PATH, FLOATS = "nav_msgs/msg/Path", "std_msgs/msg/Float64MultiArray"
FIELDS = (
    "length out [m], rate [m/s], tension at the anchor and at the other end [N], 1 if broken, each element's tension"
)


def tether_channels(source: Source, sim: Simulator, *, truth: bool) -> list[Channel]:
    """Return the channels of a vehicle's tether; none without one."""
    return _channels(source.topic, source.name, sim) if truth else []


def object_tether_channels(sim: Simulator) -> list[Channel]:
    """Return the channels of the tethers of loose bodies."""
    return [each for name in sim.objects for each in _channels(partial(object_topic, name), name, sim)]


def object_topic(name: str, topic: str) -> str:
    """Return the full name of a topic of a loose body."""
    return f"objects/{name}/{topic}"


def _channels(topic: Callable[[str], str], name: str, sim: Simulator) -> list[Channel]:
    if name not in sim.tethers:
        return []
    found = [
        Channel(
            topic("tether/shape"), PATH, "out", "the tether's nodes, from its anchor",
            rate_hz=RATE_HZ, frame_id="world", delivery=Delivery(), read=lambda sim: _shape(name, sim),
        ),
        Channel(
            topic("tether/tension"), FLOATS, "out", FIELDS,
            rate_hz=RATE_HZ, frame_id="world", delivery=Delivery(), read=lambda sim: _tension(name, sim),
        ),
        Channel(
            topic("tether/turns"), FLOATS, "out", "its turns about upright obstacles; any but 0: tangled",
            rate_hz=RATE_HZ, frame_id="world", delivery=Delivery(), read=lambda sim: _turns(name, sim),
        ),
    ]  # fmt: skip
    return found if sim.tethers[name].read().turns else found[:2]


def _shape(name: str, sim: Simulator) -> Any:
    header = build.header(sim.time_ns, "world")
    pose, point = "geometry_msgs/msg/Pose", "geometry_msgs/msg/Point"
    turn = build.message("geometry_msgs/msg/Quaternion", w=1.0)
    nodes = [
        build.message(
            "geometry_msgs/msg/PoseStamped", header=header,
            pose=build.message(pose, position=build.xyz(point, node), orientation=turn),
        )
        for node in sim.tethers[name].read().points_world_m
    ]  # fmt: skip
    return build.message(PATH, header=header, poses=nodes)


def _tension(name: str, sim: Simulator) -> Any:
    now = sim.tethers[name].read()
    broken = 0.0 if now.broken_at_m is None else 1.0
    first = [now.length_m, now.rate_m_s, now.anchor_tension_n, now.vehicle_tension_n, broken]
    return build.message(FLOATS, data=np.concatenate([first, now.tensions_n]))


def _turns(name: str, sim: Simulator) -> Any:
    return build.message(FLOATS, data=np.array(list(sim.tethers[name].read().turns.values()), np.float64))
