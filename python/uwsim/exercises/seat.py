"""A pilot's seat ashore: what a scripted pilot sees of the vehicle, and commands, goes over the link."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.agenda import Rank
from uwsim.base.commands import COMMANDS, Commandable
from uwsim.link.remote import crosses_link, packed
from uwsim.missions import OwnVehicle
from uwsim.missions.run import MissionFunction, made, steps_of
from uwsim.simulator.network import STATION
from uwsim.simulator.simulator import Simulator

SIGHT, SIGHT_S, LAYOUT = "pilot/sight", 0.1, struct.Struct("<13d")
"""The message with the vehicle's motion, how often it is sent, and its position, orientation and velocities."""
COMMAND_LIFE_S = 5.0
KNOWN = ("name", "control", "authority", "controllable", "beyond_terrain", "released")
"""Attributes of the vehicle that its pilot knows without seeing it; `released` is the pilot's own doing."""


@dataclass(frozen=True, eq=False)
class Sight:
    """The vehicle's motion as it was when it was sent: a PoseLike and a VelocityLike. position_world_m: (3,)."""

    position_world_m: NDArray[np.float64]
    orientation_xyzw: NDArray[np.float64]
    linear_body_m_s: NDArray[np.float64]
    angular_body_rad_s: NDArray[np.float64]

    @property
    def world_from_body(self) -> NDArray[np.float64]:
        """The pose (4, 4)."""
        found = np.eye(4)
        found[:3, :3] = Rotation.from_quat(self.orientation_xyzw).as_matrix()
        found[:3, 3] = self.position_world_m
        return found

    @property
    def yaw_rad(self) -> float:
        """The heading, counter-clockwise from east."""
        return float(Rotation.from_quat(self.orientation_xyzw).as_euler("ZYX")[0])


class Seat(Commandable):
    """A hull for OwnVehicle whose motion arrives over the simulator's link, and whose commands leave over it.

    Until the first message arrives, the vehicle is where it began. Sensors, cameras and sonars are not carried.
    """

    def __init__(self, sim: Simulator, vehicle: str) -> None:
        assert sim.link is not None
        self._sim, self._link, self._vehicle = sim, sim.link, sim.vehicles[vehicle]
        self._looked_ns, self._seen = sim.time_ns, LAYOUT.unpack(self._motion())
        self.due_tick = sim.tick
        self._steps = max(round(SIGHT_S / sim.step_s), 1)
        sim.agenda.add(self, Rank.OBSERVER, self._send)

    def __getattr__(self, name: str) -> Any:
        """Return what a pilot knows of the vehicle."""
        if name in KNOWN:
            return getattr(self._vehicle, name)
        raise AttributeError(f"vehicle: {name}: is not seen over the lag, only pose and velocity are")

    def close(self) -> None:
        """Send no more."""
        self._sim.agenda.remove(self)

    @property
    def lag_s(self) -> float:
        """The time that sound takes from the vehicle to the pilot."""
        return float(self._link.reception(self._vehicle.name, STATION).delay_s)

    @property
    def pose(self) -> Sight:
        """The pose that arrived last."""
        return self._sight()

    @property
    def velocity(self) -> Sight:
        """The velocity that arrived last."""
        return self._sight()

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Send a command to the vehicle; one that concerns the pilot's side alone, such as a note, is done at once."""
        if not crosses_link(name):
            return self._vehicle.command(name, **arguments)
        topic, payload = packed(name, dict(arguments))
        return self._link.send(
            STATION, self._vehicle.name, topic, payload, lifetime_s=COMMAND_LIFE_S, replaces=COMMANDS[name].replaces
        )

    def _motion(self) -> bytes:
        pose, velocity = self._vehicle.pose, self._vehicle.velocity
        parts = (pose.position_world_m, pose.orientation_xyzw, velocity.linear_body_m_s, velocity.angular_body_rad_s)
        return LAYOUT.pack(*np.concatenate(parts).tolist())

    def _send(self, tick: int) -> None:
        self.due_tick = tick + self._steps
        self._link.send(self._vehicle.name, STATION, SIGHT, self._motion(), replaces=True)

    def _sight(self) -> Sight:
        arrived = [got for got in self._link.received(STATION, 1e-9 * self._looked_ns) if got.topic == SIGHT]
        if arrived:
            self._looked_ns, self._seen = round(1e9 * arrived[-1].arrived_s), LAYOUT.unpack(arrived[-1].payload)
        values = np.array(self._seen)
        return Sight(values[:3], values[3:7], values[7:10], values[10:])


def ashore(mission: MissionFunction, sim: Simulator) -> MissionFunction:
    """Return a mission for one vehicle that is flown from the station's end of the simulator's link."""

    @wraps(mission)
    def steps(vehicle: OwnVehicle) -> Any:
        seat = Seat(sim, vehicle.name)
        try:
            own = OwnVehicle(seat, vehicle, estimate=seat, hear=_heard(vehicle))
            return (yield from steps_of(made(mission, {vehicle.name: own})))
        finally:
            seat.close()

    return steps


def _heard(vehicle: OwnVehicle) -> Callable[[Any], object]:
    def hear(event: Any) -> None:
        values: Mapping[str, Any] = event.values
        vehicle.log(event.name, **values)

    return hear
