"""Vehicles of a live simulator. Readings return immediately, and commands are logged."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, Protocol

from uwsim.base.commands import Placeable, command_named
from uwsim.base.motion import Pose, Velocity
from uwsim.instruments.cameras import Camera, Lamp
from uwsim.instruments.sensors import Sensor
from uwsim.instruments.sonars.multibeam import Sonar
from uwsim.navigation.estimation import Navigator
from uwsim.simulator.onboard_navigation import Use
from uwsim.simulator.vehicle import Vehicle

if TYPE_CHECKING:
    from uwsim import _core


class Commanded(Protocol):
    """A live simulator that accepts commands."""

    def command(self, name: str, /, **arguments: Any) -> Future[Any]:
        """Issue a command; see LiveSimulator.command."""


class LiveVehicle(Placeable):
    """A vehicle with the same public names as a Simulator's Vehicle, for missions and controllers on other threads.

    Readings are from the last step, which may be 20 ms old; two readings may be from different ticks. Command methods
    return once the command has taken effect, at the start of the next step, and raise the command's exceptions.
    """

    def __init__(self, live: Commanded, vehicle: Vehicle) -> None:
        self._live = live
        self._vehicle = vehicle
        self.name = vehicle.name
        self.sonars = {name: LiveSonar(live, vehicle.name, sonar) for name, sonar in vehicle.sonars.items()}
        self.cameras = {name: LiveCamera(live, vehicle.name, name, camera) for name, camera in vehicle.cameras.items()}
        self.lamps = {name: LiveLamp(live, vehicle.name, lamp) for name, lamp in vehicle.lamps.items()}

    def __repr__(self) -> str:
        return f"<Live{repr(self._vehicle)[1:]}"

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the vehicle itself, such as `thrusters` or `authority`."""
        return getattr(self._vehicle, name)

    @property
    def pose(self) -> Pose:
        """The current pose."""
        return self._vehicle.pose

    @property
    def velocity(self) -> Velocity:
        """The current velocity."""
        return self._vehicle.velocity

    @property
    def estimate(self) -> Navigator:
        """The vehicle's estimate, see Vehicle.estimate.

        The first access is a command, since it starts the navigation.
        """
        return self.start_navigation("program")

    def start_navigation(self, use: str = "steering") -> Navigator:
        """Start `estimate` for this use by a command, unless it is running; return it. See Vehicle.start_navigation."""
        navigation = self._vehicle.navigation
        if not navigation.is_begun(Use.named(use)):
            self.command("start_navigation", use=use)
        return navigation.shown

    @property
    def released(self) -> bool:
        """Whether the vehicle has left the station."""
        return self._vehicle.released

    @property
    def sensors(self) -> Mapping[str, Sensor[Any]]:
        """The sensors by name."""
        return self._vehicle.sensors

    @property
    def sonar(self) -> LiveSonar:
        """The first sonar. Raises ValueError if there is none."""
        return self.sonars[self._vehicle.sonar.name]

    def telemetry(self) -> _core.Telemetry:
        """The vehicle's panel."""
        return self._vehicle.telemetry()

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Issue one of uwsim.base.commands; return once it has taken effect. Raises ValueError if it is rejected."""
        return self._live.command(name, **command_named(name).named(self.name, arguments)).result()


class LiveSonar:
    """A multibeam sonar of a LiveVehicle; see uwsim.instruments.sonars.multibeam.Sonar."""

    def __init__(self, live: Commanded, vehicle: str, sonar: Sonar) -> None:
        self._live = live
        self._vehicle = vehicle
        self._sonar = sonar

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the sonar itself."""
        return getattr(self._sonar, name)

    def aim(self, elevation_rad: float) -> None:
        """Turn the head to an elevation; positive is up."""
        self._live.command("aim", vehicle=self._vehicle, elevation_rad=elevation_rad, sonar=self._sonar.name).result()

    def ping(self) -> _core.Ping:
        """Ping once from the current pose."""
        return self._sonar.ping()


class LiveCamera:
    """A camera of a LiveVehicle; see uwsim.instruments.cameras.Camera."""

    def __init__(self, live: Commanded, vehicle: str, key: str, camera: Camera) -> None:
        self._live = live
        self._vehicle = vehicle
        self._key = key
        self._camera = camera

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the camera itself, such as `capture` or `info`."""
        return getattr(self._camera, name)

    def aim(self, pan_rad: float | None = None, tilt_rad: float | None = None) -> None:
        """Turn the camera towards these angles; None leaves the aim of that axis unchanged."""
        self._live.command(
            "aim_camera", vehicle=self._vehicle, camera=self._key, pan_rad=pan_rad, tilt_rad=tilt_rad
        ).result()


class LiveLamp:
    """The lamps on one switch of a LiveVehicle; see uwsim.instruments.cameras.Lamp."""

    def __init__(self, live: Commanded, vehicle: str, lamp: Lamp) -> None:
        self._live = live
        self._vehicle = vehicle
        self._lamp = lamp
        self.name = lamp.name

    @property
    def on(self) -> bool:
        """Whether the lamps are on."""
        return self._lamp.on

    @on.setter
    def on(self, value: bool) -> None:
        self._live.command("set_lamp", vehicle=self._vehicle, lamp=self.name, on=value).result()
