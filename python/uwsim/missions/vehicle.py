"""Vehicle: everything that a mission sees of a vehicle, simulated or remote."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.commands import Commandable
from uwsim.navigation.control.protocols import EstimateLike, PanelLike, PoseLike, SensorLike, SonarLike, VelocityLike


class Panel(PanelLike, Protocol):
    """The vehicle's panel; NaN for values that a remote vehicle does not report."""

    @property
    def depth_m(self) -> float: ...
    @property
    def speed_m_s(self) -> float: ...
    @property
    def distance_to_seabed_m(self) -> float: ...
    @property
    def distance_to_station_m(self) -> float: ...
    @property
    def range_warning(self) -> bool: ...
    @property
    def proximity_warning(self) -> bool: ...
    @property
    def collision_warning(self) -> bool: ...


class LampLike(Protocol):
    """Lamps on one switch."""

    on: bool


class LensLike(Protocol):
    """The intrinsics of a picture, as in sensor_msgs/CameraInfo: d (5,), k (3, 3); pixels."""

    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def d(self) -> NDArray[np.float64]: ...
    @property
    def k(self) -> NDArray[np.float64]: ...


class PictureLike(Protocol):
    """A picture: rgb (height, width, 3); world_from_camera (4, 4), x ahead, y left, z up."""

    @property
    def rgb(self) -> NDArray[np.uint8]: ...
    @property
    def info(self) -> LensLike: ...
    @property
    def world_from_camera(self) -> NDArray[np.float64]: ...


class CameraLike(Protocol):
    """A camera."""

    def capture(self) -> PictureLike:
        """Take a picture; see uwsim.instruments.cameras.Camera."""


class Vehicle(Commandable, Protocol):
    """A vehicle as missions see it: readings and commands. Reading does not let time pass: only `yield` does.

    estimate: its position and motion to the best of its knowledge: the truth, or a filter's estimate. pose,
    velocity: the estimate's. sonar: the first multibeam; sonars, sensors, cameras, lamps: by name.
    """

    @property
    def name(self) -> str: ...
    @property
    def time_s(self) -> float:
        """Simulated seconds."""

    @property
    def estimate(self) -> EstimateLike: ...
    @property
    def pose(self) -> PoseLike: ...
    @property
    def velocity(self) -> VelocityLike: ...
    @property
    def sensors(self) -> Mapping[str, SensorLike]: ...
    @property
    def sonar(self) -> SonarLike: ...
    @property
    def sonars(self) -> Mapping[str, SonarLike]: ...
    @property
    def cameras(self) -> Mapping[str, CameraLike]: ...
    @property
    def lamps(self) -> Mapping[str, LampLike]: ...
    @property
    def released(self) -> bool:
        """Whether it is free of the station."""

    def telemetry(self) -> Panel:
        """Read the vehicle's panel."""

    def log(self, event: str, **values: Any) -> None:
        """Write an event with values of JSON types to the mission's log."""
