"""The true state of a simulator at one moment, against which goals and limits are judged."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from uwsim.base.arrays import Floats as Floats
from uwsim.simulator.failures import Event
from uwsim.simulator.failures.events import notes_of
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class Moment:
    """A simulator between two steps. time_s: time since the exercise began. position_world_m: (3,), the vehicle's."""

    sim: Simulator
    vehicle: Vehicle
    time_s: float
    position_world_m: Floats
    yaw_rad: float
    speed_m_s: float
    collisions: int

    @classmethod
    def of(cls, sim: Simulator, vehicle: Vehicle, time_s: float) -> Moment:
        """Read the true state."""
        pose = vehicle.pose
        velocity_body_m_s = vehicle.velocity.linear_body_m_s
        return cls(
            sim, vehicle, time_s, np.array(pose.position_world_m, np.float64), pose.yaw_rad,
            float(np.linalg.norm(velocity_body_m_s)), vehicle.collisions,
        )  # fmt: skip

    @property
    def altitude_m(self) -> float:
        """The height above the bed or above any object below the vehicle."""
        return float(self.vehicle.telemetry().distance_to_seabed_m)

    def notes(self, category: str) -> list[Event]:
        """Return the notes of a category that have been written about the vehicle."""
        found = (note for note in notes_of(self.sim.events) if note.vehicle == self.vehicle.name)
        return [note for note in found if note.values["category"] == category]

    def distance_m(self, point_world_m: tuple[float, float, float]) -> float:
        """Return the distance to a point."""
        return float(math.dist(self.position_world_m.tolist(), point_world_m))
