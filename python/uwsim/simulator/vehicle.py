"""Vehicle: pose, velocity, telemetry and instruments of a simulated vehicle. Its commands are in vehicle_commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from uwsim import _core
from uwsim.base.arguments import read_only
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.journal import Journal
from uwsim.base.motion import Pose, Velocity
from uwsim.base.named import Named
from uwsim.instruments.acoustics.hydrophones import Hydrophones
from uwsim.instruments.acoustics.pinger_sound import PingerSound
from uwsim.instruments.cameras import Camera, Lamp
from uwsim.instruments.sensors import Sensor, Sensors
from uwsim.instruments.sonars.imaging import Acoustics
from uwsim.instruments.sonars.mounted import ImagingSonar
from uwsim.instruments.sonars.multibeam import ChainOf, Sonar
from uwsim.scenario.build.craft import ControlSettings, floating_text
from uwsim.scenario.build.loose_bodies import HELD
from uwsim.scenario.build.vehicle import authority
from uwsim.scenario.spec.arm import Dropper as DropperModel
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.pinger import HydrophoneArray
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.simulator.arm import Arm, Sensed
from uwsim.simulator.docking import Dock
from uwsim.simulator.dropper import Dropper
from uwsim.simulator.forces import Thruster, WetTriangles, Wrench, forces_by_name
from uwsim.simulator.helm import Helm
from uwsim.simulator.onboard_navigation import ALIGNMENT_STD_M, ALIGNMENT_STD_M_S, OnboardNavigation, Use
from uwsim.simulator.programs import FailsafeLike, HoldsLike
from uwsim.simulator.tether import Tether
from uwsim.simulator.vehicle_commands import CommandedVehicle

if TYPE_CHECKING:
    from uwsim.navigation.estimation import Navigator, Start


class Vehicle(CommandedVehicle):
    """One vehicle of a simulator; see Simulator.vehicles.

    sensors: sensors by name, such as "imu" or "depth". sonars: the multibeams by name; sonar: the first of them.
    cameras, imaging_sonars, hydrophones, droppers: by name. lamps: keyed by switch name. control: the model and
    gains from its file, for a Controller; later changes of parameters are not included. tether, arm: None without
    one. A docked vehicle's thrusters are off: if simulated time passes while it is commanded, a DockedWarning is
    issued once.
    """

    name: str
    sensors: Sensors
    sonars: Named[Sonar]
    cameras: Named[Camera]
    lamps: Named[Lamp]
    imaging_sonars: Named[ImagingSonar]
    hydrophones: Named[Hydrophones]
    droppers: Named[Dropper]
    control: ControlSettings
    tether: Tether | None
    arm: Arm | None
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
    _meant = (
        dict.fromkeys(("position", "location", "xyz"), "pose.position_world_m")
        | dict.fromkeys(("orientation", "attitude", "quaternion", "roll", "pitch"), "pose.orientation_xyzw")
        | dict.fromkeys(("yaw", "heading"), "pose.yaw_rad")
        | {
            "state": "pose, velocity or telemetry()",
            "save": "its Simulator, which saves all vehicles at once",
            "close": "del of its simulator: there is nothing to close",
            "depth": "telemetry().depth_m",
            "speed": "velocity.linear_body_m_s",
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
        mounts: Mapping[str, SensorMount],
        arrays: Mapping[str, HydrophoneArray],
        sound: PingerSound,
        droppers: Mapping[str, DropperModel],
        objects: Mapping[str, LooseBody],
        seed: Callable[[], int],
        chain_of: ChainOf,
        water_column: bool = False,
        threads: int,
        step_s: float,
        navigate: Callable[[Vehicle, Start], Navigator],
        control: ControlSettings,
        beyond_terrain: Callable[[float, float, float], str | None],
        temperature_is_known: Callable[[], bool],
        tether: Tether | None = None,
        joints: Sensed | None = None,
    ) -> None:
        self._simulation = simulation
        self._index = index
        self.name = spec.name
        self.control = control
        self._beyond_terrain = beyond_terrain
        self._temperature_is_known = temperature_is_known
        self.tether = tether
        links = [link for link in spec.arm if not link.name.startswith(HELD)]
        self.arm = Arm(simulation, index, links, self.set_joints, joints) if links else None
        sensors: dict[str, Sensor[Any]] = {
            s.name: Sensor(simulation, index, k, s, step_s, mounts[s.name], f"{spec.name}/{s.name}", seed, sound)
            for k, s in enumerate(spec.sensors)
        }
        sonars = {
            s.name: Sonar(
                simulation,
                index,
                k,
                s,
                journal,
                spec.name,
                chain_of,
                lambda: self.pose,
                water_column=water_column,
                threads=threads,
            )
            for k, s in enumerate(spec.sonars)
        }
        self.sensors = Sensors(sensors, f"{spec.name}.sensors")
        self.sonars = Named(sonars, f"{spec.name}.sonars")
        self._sonar = next(iter(sonars.values()), None)
        self.cameras = Named(cameras, f"{spec.name}.cameras")
        self.lamps = Named(lamps, f"{spec.name}.lamps")
        self.imaging_sonars = Named(imaging_sonars, f"{spec.name}.imaging_sonars")
        heard = {
            name: Hydrophones(self, name, array, sound, lambda: 1e-9 * simulation.time_ns, seed)
            for name, array in arrays.items()
        }
        self.hydrophones = Named(heard, f"{spec.name}.hydrophones")
        held = {
            name: Dropper(simulation, spec.name, name, dropper, objects, journal, lambda: self.all_stopped)
            for name, dropper in droppers.items()
        }
        self.droppers = Named(held, f"{spec.name}.droppers")
        self._dock = dock
        self._journal = journal
        for lamp in lamps.values():
            lamp.report_to(journal, spec.name)
        self._craft: _core.Craft = spec.craft
        self._idle_axes = self._find_idle_axes()
        self._last_motion = self._new_motion()
        self._last_panel: tuple[int, _core.Telemetry] | None = None
        self._navigation = OnboardNavigation(
            spec.name, journal, step_s, lambda: simulation.tick, lambda start: navigate(self, start), self._known_start
        )
        self.helm = Helm(spec.name, self._halt)

    def _halt(self) -> None:
        self._simulation.set_effort(self._index, *[0.0] * 6)
        if self.arm is not None:
            self.arm.halt()

    def __repr__(self) -> str:
        east, north, up = self.pose.position_world_m.tolist()
        state = "released" if self.released else "docked"
        floats = floating_text(self.control.net_buoyancy_n)
        return f"<Vehicle '{self.name}', {state}, at ({east:.2f}, {north:.2f}, {up:.2f}) m; {floats}>"

    def change(self, entry: VehicleEntry, spec: _core.VehicleSpec, imaging_models: Mapping[str, Acoustics]) -> None:
        """Continue with changed parameters. Called by Simulator.parameters."""
        self._craft = spec.craft
        self.__dict__["_idle_axes"] = self._find_idle_axes()
        for sensor in spec.sensors:
            self.sensors[sensor.name].change(sensor, entry.model.sensors[sensor.name])
        for sonar in spec.sonars:
            self.sonars[sonar.name].change(sonar)
        for name, model in imaging_models.items():
            self.imaging_sonars[name].change(model)

    def _find_idle_axes(self) -> tuple[int, ...]:
        return tuple(k for k, is_driven in enumerate(self._simulation.controllable(self._index)) if not is_driven)

    @property
    def sonar(self) -> Sonar:
        """The first sonar. Raises ValueError if there is none."""
        if self._sonar is None:
            raise ValueError(f"vehicle '{self.name}': carries no sonar")
        return self._sonar

    def beyond_terrain(self, x_m: float, y_m: float, z_m: float = math.inf) -> str | None:
        """Return as text the terrain's bounds, or its height there, if a position is outside or below it; else None."""
        return self._beyond_terrain(x_m, y_m, z_m)

    @property
    def authority(self) -> Floats:
        """The acceleration (6,) from rest at full effort on each axis alone, deep in still water [m/s2, rad/s2].

        Computed from the smaller of the ahead and astern wrenches, and the total mass, including added mass.
        """
        return authority(self._craft, self.full_wrench_body)

    @property
    def failsafe(self) -> FailsafeLike | None:
        """The vehicle's autonomous reaction to silence or failure; None unless its YAML file defines one."""
        return self.helm.failsafe

    @property
    def holds(self) -> HoldsLike | None:
        """The vehicle's holds, see `command("hold", heading=True)`."""
        return self.helm.holds

    @property
    def effort(self) -> Floats:
        """The last efforts set, (6,): surge, sway, heave, roll, pitch, yaw; zero after set_wrench or set_thrusters."""
        return read_only(self._simulation.effort(self._index))

    @property
    def controllable(self) -> frozenset[str]:
        """The axes (of surge, sway, heave, roll, pitch, yaw) on which efforts have an effect."""
        driven = self._simulation.controllable(self._index)
        return frozenset(axis for axis, is_driven in zip(AXES, driven, strict=True) if is_driven)

    @property
    def full_wrench_body(self) -> tuple[Floats, Floats]:
        """The largest wrenches on each axis alone, ahead and astern, in still water: (6,) magnitudes, N and N m."""
        ahead, astern = self._simulation.full_wrench_body(self._index)
        return read_only(ahead), read_only(astern)

    @property
    def thrusters(self) -> Named[Thruster]:
        """The state of each thruster, by name."""
        simulation, index = self._simulation, self._index
        each = zip(
            simulation.thruster_commands(index), simulation.thrusts_n(index), simulation.currents_a(index), strict=True
        )
        states = {name: Thruster(value, thrust, current) for (name, value), (_, thrust), (_, current) in each}
        return Named(states, f"{self.name}.thrusters", "set_thrusters()")

    @property
    def fins(self) -> Named[float]:
        """The current deflections of the fins [rad] by name; they follow `set_fins` at a limited rate."""
        return Named(dict(self._simulation.fin_angles_rad(self._index)), f"{self.name}.fins", "set_fins()")

    @property
    def pose(self) -> Pose:
        """The current pose."""
        motion = self._last_motion
        return motion[1] if motion[0] == self._simulation.version else self._new_motion()[1]

    @property
    def velocity(self) -> Velocity:
        """The current velocity."""
        motion = self._last_motion
        return motion[2] if motion[0] == self._simulation.version else self._new_motion()[2]

    def _new_motion(self) -> tuple[int, Pose, Velocity]:
        """Compute version, pose and velocity, and cache them, since missions read them several times per period."""
        position, orientation, world_from_body, linear, angular = self._simulation.motion(self._index)
        motion = self._simulation.version, Pose(position, orientation, world_from_body), Velocity(linear, angular)
        self.__dict__["_last_motion"] = motion  # faster than __setattr__, which checks names
        return motion

    @property
    def estimate(self) -> Navigator:
        """Pose, velocity and covariance, estimated from the vehicle's own instruments by an error-state filter.

        The first access starts the filter from the pose and velocity at that time, assumed to be known to 0.1 m and
        0.05 m/s; place, dock and undock restart it in the same way, and so does whatever first steers by it, such as a
        hold, or command("start_navigation"). The filter assumes the sensors' error parameters as they were when it
        started. Raises ValueError for a vehicle without an IMU. See docs/guides/estimation.md.
        """
        return self._navigation.begun(Use.PROGRAM)

    def start_navigation(self, use: str = "steering") -> Navigator:
        """Start `estimate` now, unless it has been started for this use or a higher one; return it.

        use: "observer", "program" or, the highest, "steering". A higher use starts it again, so that a flight does not
        depend on who has observed the vehicle. Raises ValueError.
        """
        return self._navigation.begun(Use.named(use))

    @property
    def navigation(self) -> OnboardNavigation:
        """The object that keeps `estimate` up to date. Used by Simulator."""
        return self._navigation

    def _known_start(self) -> Start:
        from uwsim.navigation.estimation import Start  # imported here: few simulators estimate

        position, turn = self.pose.position_world_m, self.pose.world_from_body[:3, :3]
        velocity = turn @ self.velocity.linear_body_m_s
        held = None if self.released else tuple(self.pose.orientation_xyzw.tolist())
        return Start(tuple(position.tolist()), ALIGNMENT_STD_M, tuple(velocity.tolist()), ALIGNMENT_STD_M_S, held)

    @property
    def forces(self) -> Named[Wrench]:
        """The wrenches on the vehicle's rigid body by name: means over the last step, body axes, about its origin.

        weight; buoyancy: the pressure of the water around, waves included; drag; added_mass: the inertia of the water
        that moves with the vehicle, -M_A (nu' - nu_c') - C_A nu_r; coriolis: -C_RB nu, since the axes turn; actuators:
        thrusters and fins; applied: by apply_wrench and the scenario's `wrenches`; contact; dock: what holds a docked
        vehicle; tether, only in a scenario with one; wind, only of a vehicle with a `windage` where it blows; and
        total, their sum, which is M_RB times the change of velocity in the step, to rounding error. Before the first
        step, and after a placement or a change of parameters, they are those at this instant, without actuators and
        contacts. Computed when read. Raises ValueError with `dynamics: {engine: bullet}`.
        """
        return forces_by_name(self._simulation.forces(self._index), self.name)

    def wet_triangles(self) -> WetTriangles:
        """Return the triangles of the hull that are under water now, and the water's push on each, in body axes.

        They are cut at the surface as the volume is from which `forces["buoyancy"]` follows: at the water's plane, or,
        in waves, at the planes that have the mean height and slopes of the surface over slices of the hull.
        """
        return WetTriangles(*self._simulation.wet_surface(self._index))

    @property
    def contacts(self) -> list[_core.ContactForce]:
        """The points at which the vehicle was pressed in the last step, with the forces on it.

        While it stays at rest, they are those of the step in which they were last solved. Raises ValueError with
        `dynamics: {engine: bullet}`.
        """
        return self._simulation.contacts(self._index)

    @property
    def collisions(self) -> int:
        """The number of times that the vehicle has come into contact with an object."""
        return self._simulation.collisions(self._index)

    @property
    def battery(self) -> _core.BatteryState:
        """The battery's voltage, current and charge; if it is a mission time, all but the percentage are NaN."""
        return self._simulation.battery(self._index)

    def telemetry(self) -> _core.Telemetry:
        """The panel described in the seed paper: speed, depth, pressure, temperature, distances, battery, warnings.

        The temperature is NaN if the scenario's water has a profile of sound speed alone.
        """
        version = self._simulation.version
        last = self._last_panel
        if last is None or last[0] != version:
            self.__dict__["_last_panel"] = last = version, self._panel()
        return last[1]

    def _panel(self) -> _core.Telemetry:
        panel = self._simulation.telemetry(self._index)
        if self._temperature_is_known():
            return panel
        without = _core.Telemetry.__new__(_core.Telemetry)
        without.__setstate__({**panel.to_dict(), "temperature_deg_c": math.nan})
        return without
