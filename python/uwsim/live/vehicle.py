"""A vehicle of a live simulator: what it reads comes at once, what it commands goes through the log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from uwsim.cameras import Camera, Lamp
from uwsim.estimation import Navigator
from uwsim.motion import Pose, Velocity
from uwsim.sensors import Sensor
from uwsim.sonars.multibeam import Sonar
from uwsim.vehicle import Vector, Vehicle

if TYPE_CHECKING:
    from uwsim import _core
    from uwsim.live.live_simulator import LiveSimulator


class LiveVehicle:
    """A vehicle with the public names of uwsim.vehicle.Vehicle, for missions and controllers on other threads.

    Readings are of the last step, which may be 20 ms ago; two of them may be of two ticks. Commands take effect at the
    start of the next step, return when they have, and raise what the command raises.
    """

    def __init__(self, live: LiveSimulator, vehicle: Vehicle) -> None:
        self._live = live
        self._vehicle = vehicle
        self.name = vehicle.name
        self.sonars = {name: LiveSonar(live, vehicle.name, sonar) for name, sonar in vehicle.sonars.items()}
        self.cameras = {name: LiveCamera(live, vehicle.name, name, camera) for name, camera in vehicle.cameras.items()}
        self.lamps = {name: LiveLamp(live, vehicle.name, lamp) for name, lamp in vehicle.lamps.items()}

    def __getattr__(self, name: str) -> Any:
        """Return a reading, such as `thrusters` or `authority`, of the vehicle itself."""
        return getattr(self._vehicle, name)

    @property
    def pose(self) -> Pose:
        """The present pose."""
        return self._vehicle.pose

    @property
    def velocity(self) -> Velocity:
        """The present velocity."""
        return self._vehicle.velocity

    @property
    def estimate(self) -> Navigator:
        """See Vehicle.estimate. The first look is a command, since it starts the navigation."""
        if not self._vehicle.navigation.has_begun:
            self._command("start_navigation")
        return self._vehicle.estimate

    @property
    def released(self) -> bool:
        """Whether the vehicle is free of the station."""
        return self._vehicle.released

    @property
    def sensors(self) -> Mapping[str, Sensor[Any]]:
        """The sensors by name."""
        return self._vehicle.sensors

    @property
    def sonar(self) -> LiveSonar:
        """The first of the sonars. Raises ValueError if there is none."""
        return self.sonars[self._vehicle.sonar.name]

    def telemetry(self) -> _core.Telemetry:
        """The vehicle's panel."""
        return self._vehicle.telemetry()

    def release(self) -> None:
        """Leave the station."""
        self._command("release")

    def undock(self) -> None:
        """Leave the station for free water; see Vehicle.undock."""
        self._command("undock")

    def dock(self) -> None:
        """Return to the station; see Vehicle.dock."""
        self._command("dock")

    def override_failsafe(self) -> None:
        """Take the vehicle back from its failsafe; see Vehicle.override_failsafe."""
        self._command("override_failsafe")

    def all_stop(self, on: bool = True) -> None:
        """Stop the vehicle against all other commands until released; see Vehicle.all_stop."""
        self._command("all_stop", on=on)

    def set_effort(
        self,
        surge: float = 0.0,
        sway: float = 0.0,
        heave: float = 0.0,
        roll: float = 0.0,
        pitch: float = 0.0,
        yaw: float = 0.0,
    ) -> None:
        """Command efforts; see Vehicle.set_effort."""
        self._command("set_effort", surge=surge, sway=sway, heave=heave, roll=roll, pitch=pitch, yaw=yaw)

    def set_wrench(
        self, force_body_n: Sequence[float] | Vector, torque_body_nm: Sequence[float] | Vector = (0.0, 0.0, 0.0)
    ) -> None:
        """Command force and torque; see Vehicle.set_wrench."""
        self._command("set_wrench", force_body_n=force_body_n, torque_body_nm=torque_body_nm)

    def set_thrusters(self, commands: Mapping[str, float]) -> None:
        """Command thrusters by name; see Vehicle.set_thrusters."""
        self._command("set_thrusters", commands=commands)

    def set_fins(self, angles_rad: Mapping[str, float]) -> None:
        """Command fins by name; see Vehicle.set_fins."""
        self._command("set_fins", angles_rad=angles_rad)

    def place(
        self,
        position_world_m: Sequence[float] | Vector,
        orientation_xyzw: Sequence[float] | Vector = (0.0, 0.0, 0.0, 1.0),
        velocity_body: Sequence[float] | Vector = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Put the vehicle at a pose; see Vehicle.place."""
        self._command(
            "place",
            position_world_m=position_world_m,
            orientation_xyzw=orientation_xyzw,
            velocity_body=velocity_body,
        )

    def _command(self, name: str, **arguments: Any) -> None:
        self._live.command(name, vehicle=self.name, **arguments).result()


class LiveSonar:
    """A multibeam sonar of a LiveVehicle; see uwsim.sonars.multibeam.Sonar."""

    def __init__(self, live: LiveSimulator, vehicle: str, sonar: Sonar) -> None:
        self._live = live
        self._vehicle = vehicle
        self._sonar = sonar

    def __getattr__(self, name: str) -> Any:
        """Return a reading of the sonar itself."""
        return getattr(self._sonar, name)

    def aim(self, elevation_rad: float) -> None:
        """Turn the head to an elevation; positive is up."""
        self._live.command("aim", vehicle=self._vehicle, elevation_rad=elevation_rad, sonar=self._sonar.name).result()

    def ping(self) -> _core.Ping:
        """Ping once from the present pose."""
        return self._sonar.ping()


class LiveCamera:
    """A camera of a LiveVehicle; see uwsim.cameras.Camera."""

    def __init__(self, live: LiveSimulator, vehicle: str, key: str, camera: Camera) -> None:
        self._live = live
        self._vehicle = vehicle
        self._key = key
        self._camera = camera

    def __getattr__(self, name: str) -> Any:
        """Return a reading of the camera itself, such as `capture` or `info`."""
        return getattr(self._camera, name)

    def aim(self, pan_rad: float | None = None, tilt_rad: float | None = None) -> None:
        """Turn towards these angles."""
        self._live.command(
            "aim_camera", vehicle=self._vehicle, camera=self._key, pan_rad=pan_rad, tilt_rad=tilt_rad
        ).result()


class LiveLamp:
    """The lamps on one switch of a LiveVehicle; see uwsim.cameras.Lamp."""

    def __init__(self, live: LiveSimulator, vehicle: str, lamp: Lamp) -> None:
        self._live = live
        self._vehicle = vehicle
        self._lamp = lamp
        self.name = lamp.name

    @property
    def on(self) -> bool:
        """Whether they shine."""
        return self._lamp.on

    @on.setter
    def on(self, value: bool) -> None:
        self._live.command("set_lamp", vehicle=self._vehicle, lamp=self.name, on=value).result()
