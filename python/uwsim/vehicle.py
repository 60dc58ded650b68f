"""Vehicle, one of a simulator's: commands in; pose, velocity, telemetry and instruments out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.cameras import Camera, Lamp
from uwsim.scenario.build.vehicle import authority
from uwsim.sensors import Sensor
from uwsim.sonars.mounted import ImagingSonar
from uwsim.sonars.multibeam import Sonar

Vector = NDArray[np.float64]
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass(frozen=True, eq=False)
class Pose:
    """A vehicle's pose: position_world_m (3,), orientation_xyzw (4,), world_from_body (4, 4); ENU, REP 103."""

    position_world_m: Vector
    orientation_xyzw: Vector
    world_from_body: Vector

    @property
    def yaw_rad(self) -> float:
        """Heading of the body's x axis from east, counter-clockwise, in (-pi, pi]."""
        return float(np.arctan2(self.world_from_body[1, 0], self.world_from_body[0, 0]))


@dataclass(frozen=True, eq=False)
class Velocity:
    """A vehicle's velocity over ground, in body axes: linear_body_m_s (3,), angular_body_rad_s (3,)."""

    linear_body_m_s: Vector
    angular_body_rad_s: Vector


@dataclass(frozen=True)
class Thruster:
    """A thruster's state: its command in [-1, 1] and its still-water thrust, which follows with a lag."""

    command: float
    thrust_n: float


class Vehicle:
    """One vehicle of a simulator; see Simulator.vehicles.

    sensors: by name, such as "imu" or "depth". sonars: the multibeams by name; sonar: the first. cameras,
    imaging_sonars: by name. lamps: by the name of their switch.
    Commands are held until the next one; a command that raises ValueError changes nothing.
    """

    def __init__(
        self,
        simulation: _core.Simulation,
        index: int,
        spec: _core.VehicleSpec,
        *,
        cameras: Mapping[str, Camera],
        lamps: Mapping[str, Lamp],
        imaging_sonars: Mapping[str, ImagingSonar],
    ) -> None:
        self._simulation = simulation
        self._index = index
        self.name: str = spec.name
        self.sensors = {s.name: Sensor(simulation, index, k, s) for k, s in enumerate(spec.sensors)}
        self.sonars = {s.name: Sonar(simulation, index, k, s) for k, s in enumerate(spec.sonars)}
        self.cameras = dict(cameras)
        self.lamps = dict(lamps)
        self.imaging_sonars = dict(imaging_sonars)
        self._craft: _core.Craft = spec.craft

    @property
    def sonar(self) -> Sonar:
        """The first of the sonars. Raises ValueError if there is none."""
        if not self.sonars:
            raise ValueError(f"vehicle '{self.name}': carries no sonar")
        return next(iter(self.sonars.values()))

    @property
    def authority(self) -> Vector:
        """(6,) acceleration from rest that full effort of each axis alone gives, deep in still water [m/s2, rad/s2].

        From the smaller of the wrenches ahead and astern, and the full mass, added mass included.
        """
        return authority(self._craft, self.full_wrench_body)

    def release(self) -> None:
        """Leave the station; the mission time starts. Does nothing if already free."""
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
        """Command efforts in [-1, 1] along and about the body axes (REP 103: forward, left, up), held until the next.

        Full effort of one axis alone is the largest wrench about it that the vehicle gives, or its fins' largest
        deflection; efforts that exceed the thrusters together are scaled down together. Efforts of axes that are not
        `controllable` do nothing. Raises ValueError for an effort outside [-1, 1] or not finite.
        """
        self._simulation.set_effort(self._index, np.array([surge, sway, heave, roll, pitch, yaw], np.float64))

    @property
    def effort(self) -> Vector:
        """(6,) surge, sway, heave, roll, pitch, yaw as last set; zero after set_wrench or set_thrusters."""
        return self._simulation.effort(self._index)

    @property
    def controllable(self) -> frozenset[str]:
        """The axes, of surge, sway, heave, roll, pitch, yaw, on which an effort has an effect."""
        driven = self._simulation.controllable(self._index)
        return frozenset(axis for axis, is_driven in zip(AXES, driven, strict=True) if is_driven)

    @property
    def full_wrench_body(self) -> tuple[Vector, Vector]:
        """The largest wrenches in still water for each axis alone, ahead and astern: (6,) magnitudes, N and N m."""
        ahead, astern = self._simulation.full_wrench_body(self._index)
        return ahead, astern

    def set_wrench(
        self, force_body_n: Sequence[float] | Vector, torque_body_nm: Sequence[float] | Vector = (0.0, 0.0, 0.0)
    ) -> None:
        """Command the thrusters' force (3,) and torque (3,) in still water, body axes, about the origin; fins stay.

        A wrench beyond the thrusters keeps its direction and is scaled to the largest that they give. Raises
        ValueError.
        """
        parts = [np.asarray(part, np.float64) for part in (force_body_n, torque_body_nm)]
        for name, part in zip(("force_body_n", "torque_body_nm"), parts, strict=True):
            if part.shape != (3,):
                raise ValueError(f"{name}.shape = {part.shape}: expected (3,)")
        self._simulation.set_wrench(self._index, np.concatenate(parts))

    def set_thrusters(self, commands: Mapping[str, float]) -> None:
        """Command thrusters in [-1, 1] by name; unnamed thrusters stop; fins stay. Raises ValueError."""
        self._simulation.set_thrusters(self._index, [(str(name), float(value)) for name, value in commands.items()])

    @property
    def thrusters(self) -> dict[str, Thruster]:
        """Each thruster's state, by name."""
        commands = self._simulation.thruster_commands(self._index)
        thrusts = self._simulation.thrusts_n(self._index)
        return {name: Thruster(value, thrust) for (name, value), (_, thrust) in zip(commands, thrusts, strict=True)}

    def set_fins(self, angles_rad: Mapping[str, float]) -> None:
        """Command deflections by name, right-handed about each fin's span; unnamed fins return to 0; thrusters stay.

        Raises ValueError.
        """
        self._simulation.set_fins(self._index, [(str(name), float(value)) for name, value in angles_rad.items()])

    @property
    def fins(self) -> dict[str, float]:
        """The fins' present deflections [rad] by name; they follow `set_fins` at their rate."""
        return dict(self._simulation.fin_angles_rad(self._index))

    @property
    def pose(self) -> Pose:
        """The present pose."""
        state = self._simulation.state(self._index)
        return Pose(state.position_world_m, state.orientation_xyzw, state.world_from_body)

    @property
    def velocity(self) -> Velocity:
        """The present velocity."""
        nu = self._simulation.state(self._index).velocity_body
        return Velocity(nu[:3], nu[3:])

    def place(
        self,
        position_world_m: Sequence[float] | Vector,
        orientation_xyzw: Sequence[float] | Vector = (0.0, 0.0, 0.0, 1.0),
        velocity_body: Sequence[float] | Vector = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Put the vehicle at a pose at once, at rest unless velocity_body (6,) is given. Raises ValueError.

        Commands are still held, propellers keep turning, and sensors keep their samples.
        """
        self._simulation.set_state(self._index, _core.BodyState(position_world_m, orientation_xyzw, velocity_body))

    @property
    def collisions(self) -> int:
        """The number of times that the vehicle has come to touch something."""
        return self._simulation.collisions(self._index)

    def telemetry(self) -> _core.Telemetry:
        """The panel of the seed paper: speed, depth, pressure, temperature, distances, battery, warnings."""
        return self._simulation.telemetry(self._index)
