"""Vehicle, one of a simulator's: commands in; pose, velocity, telemetry and instruments out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.arguments import number, numbers_by_name, read_only
from uwsim.cameras import Camera, Lamp
from uwsim.command_gate import CommandGate, FailsafeLike
from uwsim.docking import Dock
from uwsim.journal import Journal
from uwsim.motion import Pose, Velocity
from uwsim.named import Named
from uwsim.onboard_navigation import ALIGNMENT_STD_M, ALIGNMENT_STD_M_S, OnboardNavigation
from uwsim.scenario.build.control import ControlSettings, floating_text
from uwsim.scenario.build.vehicle import authority
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.sealed import Sealed
from uwsim.sensors import Sensor, Sensors
from uwsim.sonars.imaging import Acoustics
from uwsim.sonars.mounted import ImagingSonar
from uwsim.sonars.multibeam import Sonar
from uwsim.thruster import Thruster

if TYPE_CHECKING:
    from uwsim.estimation import Navigator, Start

Vector = NDArray[np.float64]
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
PLAIN = {float}


class Vehicle(Sealed):
    """One vehicle of a simulator; see Simulator.vehicles.

    sensors: by name, such as "imu" or "depth". sonars: the multibeams by name; sonar: the first. cameras,
    imaging_sonars: by name. lamps: by the name of their switch.
    control: the model and the gains of its file, for uwsim.control.Controller; parameters that change later are not in
    it.
    Commands are held until the next one; a command that raises ValueError changes nothing. A docked vehicle's thrusters
    are off: the first time that simulated time passes while it is commanded, there is a DockedWarning.
    """

    name: str
    sensors: Sensors
    sonars: Named[Sonar]
    cameras: Named[Camera]
    lamps: Named[Lamp]
    imaging_sonars: Named[ImagingSonar]
    control: ControlSettings
    gate: CommandGate
    _changed_by = MappingProxyType(
        {
            "pose": "place()",
            "velocity": "place(position, orientation, velocity_body)",
            "effort": "set_effort()",
            "thrusters": "set_thrusters()",
            "fins": "set_fins()",
            "released": "release(), undock() or dock()",
            "all_stopped": "all_stop()",
        }
    )

    def __init__(
        self,
        simulation: _core.Simulation,
        index: int,
        spec: _core.VehicleSpec,
        *,
        dock: Dock,
        cameras: Mapping[str, Camera],
        lamps: Mapping[str, Lamp],
        imaging_sonars: Mapping[str, ImagingSonar],
        journal: Journal,
        sensors_on: Mapping[str, bool],
        step_s: float,
        navigate: Callable[[Vehicle, Start], Navigator],
        control: ControlSettings,
    ) -> None:
        self._simulation = simulation
        self._index = index
        self.name = spec.name
        self.control = control
        sensors: dict[str, Sensor[Any]] = {
            s.name: Sensor(simulation, index, k, s, step_s, sensors_on[s.name]) for k, s in enumerate(spec.sensors)
        }
        sonars = {s.name: Sonar(simulation, index, k, s, journal, spec.name) for k, s in enumerate(spec.sonars)}
        self.sensors = Sensors(sensors, f"{spec.name}.sensors")
        self.sonars = Named(sonars, f"{spec.name}.sonars")
        self.cameras = Named(cameras, f"{spec.name}.cameras")
        self.lamps = Named(lamps, f"{spec.name}.lamps")
        self.imaging_sonars = Named(imaging_sonars, f"{spec.name}.imaging_sonars")
        self._dock = dock
        self._journal = journal
        for lamp in lamps.values():
            lamp.report_to(journal, spec.name)
        self._craft: _core.Craft = spec.craft
        self._last_motion = self._new_motion()
        self._last_panel: tuple[int, _core.Telemetry] | None = None
        self._navigation = OnboardNavigation(
            spec.name, journal, step_s, lambda: simulation.tick, lambda start: navigate(self, start), self._known_start
        )
        self.gate = CommandGate(spec.name, partial(simulation.set_effort, index, *[0.0] * 6))

    def __repr__(self) -> str:
        east, north, up = self.pose.position_world_m.tolist()
        state = "released" if self.released else "docked"
        floats = floating_text(self.control.net_buoyancy_n)
        return f"<Vehicle '{self.name}', {state}, at ({east:.2f}, {north:.2f}, {up:.2f}) m; {floats}>"

    def change(self, entry: VehicleEntry, spec: _core.VehicleSpec, imaging_models: Mapping[str, Acoustics]) -> None:
        """Go on with other figures. Simulator.parameters calls this."""
        self._craft = spec.craft
        for sensor in spec.sensors:
            self.sensors[sensor.name].change(sensor, entry.model.sensors[sensor.name].on)
        for sonar in spec.sonars:
            self.sonars[sonar.name].change(sonar)
        for name, model in imaging_models.items():
            self.imaging_sonars[name].change(model)

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

    @property
    def failsafe(self) -> FailsafeLike | None:
        """What it does by itself when nobody speaks to it or something fails; None unless its YAML file says so."""
        return self.gate.failsafe

    def steer_silently(self, efforts: Sequence[float]) -> None:
        """Set efforts, saturated, without a note: what a program aboard does follows from what is noted already."""
        if not self.all_stopped:
            self._simulation.set_effort(self._index, *[min(max(effort, -1.0), 1.0) for effort in efforts])

    def override_failsafe(self) -> None:
        """Take the vehicle back from its failsafe, which acts no more on this cause. ValueError if there is none."""
        self.gate.override()
        self._note("override_failsafe")

    def all_stop(self, on: bool = True) -> None:
        """Stop the thrusters and put the fins to neutral, whoever commands what, until False releases them. ValueError.

        Until then commands have no effect, which an AllStopWarning tells once, and the dock keeps a docked vehicle.
        After that it rests until the next command; a failsafe that steers goes on from there.
        """
        self.gate.all_stop(on)
        self._note("all_stop", on=bool(on))

    @property
    def all_stopped(self) -> bool:
        """Whether all stop is set."""
        return self.gate.all_stopped

    def release(self) -> None:
        """Leave the station; the mission time starts. Nothing if already free; ValueError if all stop keeps it."""
        if not self.released:
            self.gate.require_no_stop("release")
        self._simulation.release(self._index)
        self._note("release")

    def undock(self) -> None:
        """Leave the station at once: release the vehicle and put it, at rest, at the dock's way out (station.exit_m).

        It keeps the dock's heading and its commands. Raises ValueError, changing nothing, if it is not docked, the
        water there is not free, or all stop is set.
        """
        if self.released:
            raise ValueError(f"vehicle '{self.name}': undock: is not docked")
        self.gate.require_no_stop("undock")
        with self._named_errors():
            self._dock.require_exit(self._index)
        self._put(_core.BodyState(self._dock.exit_world_m, self._dock.orientation_xyzw, np.zeros(6)))
        self._note("undock")

    def dock(self) -> None:
        """Enter the station's dock from nearby: it holds the vehicle, at rest, until the next release or undock.

        The vehicle must be within 1.5 m of its place in the dock, slower than 0.5 m/s and within 30 degrees of the
        dock's heading, and the dock empty; else ValueError, which says how far away it is. Its commands end and its
        battery is charged at once: the next release starts another mission.
        """
        if not self.released:
            raise ValueError(f"vehicle '{self.name}': dock: is docked already")
        with self._named_errors():
            self._dock.require_entry(self._index)
        self._simulation.dock(self._index, self._dock.position_world_m, self._dock.orientation_xyzw)
        self.gate.is_driven = False
        self._note("dock")

    @contextmanager
    def _named_errors(self) -> Iterator[None]:
        try:
            yield
        except ValueError as error:
            raise ValueError(f"vehicle '{self.name}': {error}") from None

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
        efforts: tuple[float, ...] = (surge, sway, heave, roll, pitch, yaw)
        if set(map(type, efforts)) != PLAIN:
            efforts = tuple(number(value, f"effort.{axis}") for axis, value in zip(AXES, efforts, strict=True))
        self.gate.hears()
        self._simulation.set_effort(self._index, *efforts)
        self.gate.yields(moves=any(efforts))
        if self._journal.observers:
            self._note("set_effort", **dict(zip(AXES, efforts, strict=True)))

    @property
    def effort(self) -> Vector:
        """(6,) surge, sway, heave, roll, pitch, yaw as last set; zero after set_wrench or set_thrusters."""
        return read_only(self._simulation.effort(self._index))

    @property
    def controllable(self) -> frozenset[str]:
        """The axes, of surge, sway, heave, roll, pitch, yaw, on which an effort has an effect."""
        driven = self._simulation.controllable(self._index)
        return frozenset(axis for axis, is_driven in zip(AXES, driven, strict=True) if is_driven)

    @property
    def full_wrench_body(self) -> tuple[Vector, Vector]:
        """The largest wrenches in still water for each axis alone, ahead and astern: (6,) magnitudes, N and N m."""
        ahead, astern = self._simulation.full_wrench_body(self._index)
        return read_only(ahead), read_only(astern)

    def set_wrench(
        self, force_body_n: Sequence[float] | Vector, torque_body_nm: Sequence[float] | Vector = (0.0, 0.0, 0.0)
    ) -> None:
        """Command the thrusters' force (3,) and torque (3,) in still water, body axes, about the origin; fins stay.

        A wrench beyond the thrusters keeps its direction and is scaled to the largest that they give. Raises
        ValueError.
        """
        given = (("force_body_n", force_body_n, "N"), ("torque_body_nm", torque_body_nm, "N m"))
        parts: list[float] = []
        for name, part, unit in given:
            if np.shape(part) != (3,):
                raise ValueError(f"{name}.shape = {np.shape(part)}: expected (3,)")
            parts += [number(value, f"{name}[{k}]", unit) for k, value in enumerate(part)]
        self.gate.hears()
        self._simulation.set_wrench(self._index, np.array(parts))
        self.gate.yields(moves=any(parts))
        self._note("set_wrench", force_body_n=parts[:3], torque_body_nm=parts[3:])

    def set_thrusters(self, commands: Mapping[str, float]) -> None:
        """Command thrusters in [-1, 1] by name; unnamed thrusters stop; fins stay. Raises ValueError."""
        pairs = numbers_by_name(commands, "thrusters", [name for name, _ in self._thruster_commands()])
        self.gate.hears()
        self._simulation.set_thrusters(self._index, pairs)
        self.gate.yields(moves=any(value for _, value in pairs))
        self._note("set_thrusters", commands=dict(pairs))

    @property
    def thrusters(self) -> Named[Thruster]:
        """Each thruster's state, by name."""
        both = zip(self._thruster_commands(), self._simulation.thrusts_n(self._index), strict=True)
        states = {name: Thruster(value, thrust) for (name, value), (_, thrust) in both}
        return Named(states, f"{self.name}.thrusters", "set_thrusters()")

    def _thruster_commands(self) -> list[tuple[str, float]]:
        return self._simulation.thruster_commands(self._index)

    def set_fins(self, angles_rad: Mapping[str, float]) -> None:
        """Command deflections by name, right-handed about each fin's span; unnamed fins return to 0; thrusters stay.

        Raises ValueError.
        """
        pairs = numbers_by_name(angles_rad, "fins", list(self.fins), "rad")
        self.gate.hears()
        self._simulation.set_fins(self._index, pairs)
        self.gate.yields(moves=self.gate.is_driven or any(value for _, value in pairs))
        self._note("set_fins", angles_rad=dict(pairs))

    @property
    def fins(self) -> Named[float]:
        """The fins' present deflections [rad] by name; they follow `set_fins` at their rate."""
        return Named(dict(self._simulation.fin_angles_rad(self._index)), f"{self.name}.fins", "set_fins()")

    @property
    def pose(self) -> Pose:
        """The present pose."""
        motion = self._last_motion
        return motion[1] if motion[0] == self._simulation.version else self._new_motion()[1]

    @property
    def velocity(self) -> Velocity:
        """The present velocity."""
        motion = self._last_motion
        return motion[2] if motion[0] == self._simulation.version else self._new_motion()[2]

    def _new_motion(self) -> tuple[int, Pose, Velocity]:
        """Make version, pose and velocity, once for each version: missions ask several times in each period."""
        position, orientation, world_from_body, linear, angular = self._simulation.motion(self._index)
        motion = self._simulation.version, Pose(position, orientation, world_from_body), Velocity(linear, angular)
        self.__dict__["_last_motion"] = motion  # faster than by __setattr__, which checks names
        return motion

    @property
    def estimate(self) -> Navigator:
        """Where the vehicle is by its own instruments: pose, velocity and their covariance, by an error-state filter.

        The first look starts it, from the pose and velocity of that moment, which it takes to be known within 0.1 m and
        0.05 m/s; so do place, dock and undock. It goes by the errors that the sensors had then. Raises ValueError for a
        vehicle without an IMU. See docs/estimation.md.
        """
        return self._navigation.navigator

    @property
    def navigation(self) -> OnboardNavigation:
        """What keeps `estimate` up to date. For Simulator."""
        return self._navigation

    def _known_start(self) -> Start:
        from uwsim.estimation import Start  # here, since scipy takes long to import

        position, turn = self.pose.position_world_m, self.pose.world_from_body[:3, :3]
        velocity = turn @ self.velocity.linear_body_m_s
        return Start(tuple(position.tolist()), ALIGNMENT_STD_M, tuple(velocity.tolist()), ALIGNMENT_STD_M_S)

    def place(
        self,
        position_world_m: Sequence[float] | Vector,
        orientation_xyzw: Sequence[float] | Vector = (0.0, 0.0, 0.0, 1.0),
        velocity_body: Sequence[float] | Vector = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Put the vehicle at a pose at once, at rest unless velocity_body (6,) is given; a docked one is released.

        Commands are still held, propellers keep turning, and sensors keep their samples. Raises ValueError for numbers
        that are not finite or too large, and if the vehicle's origin, by whatever distance, is not above the ground or
        is inside a closed obstacle. The hull is not checked: where it overlaps a surface, contacts push it out.
        """
        self._put(_core.BodyState(position_world_m, orientation_xyzw, velocity_body))
        self._note(
            "place",
            position_world_m=position_world_m,
            orientation_xyzw=orientation_xyzw,
            velocity_body=velocity_body,
        )

    def _put(self, state: _core.BodyState) -> None:
        self._simulation.set_state(self._index, state)

    def _note(self, command: str, **arguments: Any) -> None:
        """Tell whoever watches the simulator that a command has taken effect."""
        if self._journal.observers:
            self._journal.note(command, vehicle=self.name, **arguments)

    def warn_if_docked(self) -> None:
        """Warn, once, if the vehicle is commanded while its dock holds it. Simulator.step calls this."""
        if self.gate.is_driven and not self.released:
            self.gate.warn_of_dock()

    @property
    def collisions(self) -> int:
        """The number of times that the vehicle has come to touch something."""
        return self._simulation.collisions(self._index)

    def telemetry(self) -> _core.Telemetry:
        """The panel of the seed paper: speed, depth, pressure, temperature, distances, battery, warnings."""
        version = self._simulation.version
        last = self._last_panel
        if last is None or last[0] != version:
            self.__dict__["_last_panel"] = last = version, self._simulation.telemetry(self._index)
        return last[1]
