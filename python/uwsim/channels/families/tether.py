"""A vehicle's tether: its shape, and its tension and length. They are true, not measured."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwsim.channels.channel import Channel, Delivery
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.tether import TetherReading

RATE_HZ = 10.0
PATH, FLOATS = "nav_msgs/msg/Path", "std_msgs/msg/Float64MultiArray"
FIELDS = "length out [m], rate [m/s], tension at the anchor and at the vehicle [N], 1 if broken, each element's tension"


def tether_channels(source: Source, sim: Simulator) -> list[Channel]:
    """Return the channels of a vehicle's tether; none without one."""
    if source.of(sim).tether is None:
        return []
    return [
        Channel(
            source.topic("tether/shape"), PATH, "out", "the tether's nodes, from its anchor",
            rate_hz=RATE_HZ, frame_id="world", delivery=Delivery(), read=lambda sim: _shape(source, sim),
        ),
        Channel(
            source.topic("tether/tension"), FLOATS, "out", FIELDS,
            rate_hz=RATE_HZ, frame_id="world", delivery=Delivery(), read=lambda sim: _tension(source, sim),
        ),
        *_turns_channel(source, sim),
    ]  # fmt: skip


def _turns_channel(source: Source, sim: Simulator) -> list[Channel]:
    names = list(_read(source, sim).turns)
    if not names:
        return []
    return [
        Channel(
            source.topic("tether/turns"), FLOATS, "out", "its turns about upright obstacles; any but 0: tangled",
            rate_hz=RATE_HZ, frame_id="world", delivery=Delivery(), read=lambda sim: _turns(source, sim),
        )
    ]  # fmt: skip


def _read(source: Source, sim: Simulator) -> TetherReading:
    tether = source.of(sim).tether
    assert tether is not None, "its channels exist only with it"
    return tether.read()


def _shape(source: Source, sim: Simulator) -> Any:
    header = build.header(sim.time_ns, "world")
    pose, point = "geometry_msgs/msg/Pose", "geometry_msgs/msg/Point"
    turn = build.message("geometry_msgs/msg/Quaternion", w=1.0)
    nodes = [
        build.message(
            "geometry_msgs/msg/PoseStamped", header=header,
            pose=build.message(pose, position=build.xyz(point, node), orientation=turn),
        )
        for node in _read(source, sim).points_world_m
    ]  # fmt: skip
    return build.message(PATH, header=header, poses=nodes)


def _tension(source: Source, sim: Simulator) -> Any:
    now = _read(source, sim)
    broken = 0.0 if now.broken_at_m is None else 1.0
    first = [now.length_m, now.rate_m_s, now.anchor_tension_n, now.vehicle_tension_n, broken]
    return build.message(FLOATS, data=np.concatenate([first, now.tensions_n]))


def _turns(source: Source, sim: Simulator) -> Any:
    return build.message(FLOATS, data=np.array(list(_read(source, sim).turns.values()), np.float64))
