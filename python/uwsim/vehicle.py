"""A vehicle of a simulator: commands in, pose, velocity, telemetry and instruments out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.instruments import Sensor, Sonar

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a vehicle is: position_world_m (3,), orientation_xyzw (4,), world_from_body (4, 4); ENU, REP 103."""

    position_world_m: Vector
    orientation_xyzw: Vector
    world_from_body: Vector

    @property
    def yaw_rad(self) -> float:
        """Heading of the body's x axis from east, counter-clockwise, in (-pi, pi]."""
        return float(np.arctan2(self.world_from_body[1, 0], self.world_from_body[0, 0]))


@dataclass(frozen=True, eq=False)
class Velocity:
    """How a vehicle moves through the world, in body axes: linear_body_m_s (3,), angular_body_rad_s (3,)."""

    linear_body_m_s: Vector
    angular_body_rad_s: Vector


class Vehicle:
    """One vehicle of a simulator; see Simulator.vehicles.

    sensors: by name, such as "imu" or "depth". sonars: by name; sonar: the first.
    """

    def __init__(self, simulation: _core.Simulation, index: int, spec: _core.VehicleSpec) -> None:
        self._simulation = simulation
        self._index = index
        self.name: str = spec.name
        self.sensors = {s.name: Sensor(simulation, index, k, s.name, s.kind) for k, s in enumerate(spec.sensors)}
        self.sonars = {s.name: Sonar(simulation, index, k, s) for k, s in enumerate(spec.sonars)}

    @property
    def sonar(self) -> Sonar:
        """The first of the sonars."""
        return next(iter(self.sonars.values()))

    def release(self) -> None:
        """Leave the station; the mission time starts. Does nothing when already free."""
        self._simulation.release(self._index)

    @property
    def released(self) -> bool:
        """Whether the vehicle is free of the station."""
        return self._simulation.released(self._index)

    def set_effort(
        self,
        surge: float = 0.0,
        sway: float = 0.0,
        heave: float = 0.0,
        roll: float = 0.0,
        pitch: float = 0.0,
        yaw: float = 0.0,
    ) -> None:
        """Efforts in [-1, 1] along and about the body axes (REP 103: forward, left, up), held until the next call.

        Raises ValueError beyond, or when not finite.
        """
        self._simulation.set_effort(self._index, np.array([surge, sway, heave, roll, pitch, yaw], np.float64))

    @property
    def effort(self) -> Vector:
        """(6,) surge, sway, heave, roll, pitch, yaw as last set."""
        return self._simulation.effort(self._index)

    @property
    def pose(self) -> Pose:
        """Where the vehicle is now."""
        state = self._simulation.state(self._index)
        return Pose(state.position_world_m, state.orientation_xyzw, state.world_from_body)

    @property
    def velocity(self) -> Velocity:
        """How it moves now."""
        nu = self._simulation.state(self._index).velocity_body
        return Velocity(nu[:3], nu[3:])

    def place(
        self,
        position_world_m: Sequence[float] | Vector,
        orientation_xyzw: Sequence[float] | Vector = (0.0, 0.0, 0.0, 1.0),
        velocity_body: Sequence[float] | Vector = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Put the vehicle somewhere at once, at rest unless velocity_body (6,) is given. Raises ValueError."""
        self._simulation.set_state(self._index, _core.BodyState(position_world_m, orientation_xyzw, velocity_body))

    @property
    def collisions(self) -> int:
        """How often it has come to touch something."""
        return self._simulation.collisions(self._index)

    def telemetry(self) -> _core.Telemetry:
        """The paper's panel: speed, depth, pressure, temperature, distances, battery, warnings."""
        return self._simulation.telemetry(self._index)
