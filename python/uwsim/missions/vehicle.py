"""Vehicle: the interface through which a mission uses a vehicle, simulated or remote."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.base.commands import Commandable
from uwsim.navigation.control.protocols import EstimateLike, PanelLike, PoseLike, SensorLike, SonarLike, VelocityLike


class Panel(PanelLike, Protocol):
    """The vehicle's panel; values that a remote vehicle does not report are NaN."""

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


class TetherShape(Protocol):
    """A tether at one time: points_world_m (n, 3) from its anchor, the length out, and where it is broken."""

    @property
    def points_world_m(self) -> NDArray[np.float64]: ...
    @property
    def length_m(self) -> float: ...
    @property
    def broken_at_m(self) -> float | None: ...


class TetherLike(Protocol):
    """A tether. See uwsim.simulator.tether.Tether."""

    def read(self) -> TetherShape: ...


class LampLike(Protocol):
    """One or more lamps on a common switch."""

    on: bool


class LensLike(Protocol):
    """A picture's intrinsics in pixels, as in sensor_msgs/CameraInfo: k (3, 3), d (see uwsim.base.lens_model)."""

    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def d(self) -> NDArray[np.float64]: ...
    @property
    def k(self) -> NDArray[np.float64]: ...


class PictureLike(Protocol):
    """A picture: rgb (height, width, 3) and world_from_camera (4, 4), x ahead, y left, z up."""

    @property
    def rgb(self) -> NDArray[np.uint8]: ...
    @property
    def info(self) -> LensLike: ...
    @property
    def world_from_camera(self) -> NDArray[np.float64]: ...


class CameraLike(Protocol):
    """A camera."""

    @property
    def is_aimed(self) -> bool:
        """True once the camera has reached its target pan and tilt; always True without a motor."""

    def aim(self, pan_rad: float | None = None, tilt_rad: float | None = None) -> None:
        """Turn to a pan, positive to port, and a tilt, positive down; None leaves an axis unchanged."""

    def capture(self) -> PictureLike:
        """Capture a picture; see uwsim.instruments.cameras.Camera."""


class ImagingSonarLike(Protocol):
    """An imaging sonar: forward-looking, side-scan or profiling."""

    def ping(self, *arguments: Any, with_labels: bool = False) -> Any:
        """Ping from the current pose; see uwsim.instruments.sonars.mounted.ImagingSonar."""


class HydrophonesLike(Protocol):
    """An array of hydrophones."""

    def listen(self) -> Any:
        """Return the samples around the last ping; see uwsim.instruments.acoustics.hydrophones.Hydrophones."""


class Vehicle(Commandable, Protocol):
    """A vehicle as missions see it: readings and commands. Reading takes no simulated time; only `yield` does.

    estimate: position and motion to the best of the vehicle's knowledge, either the truth or a filter's estimate. pose,
    velocity: taken from the estimate. sonar: the first multibeam. sonars, imaging_sonars, hydrophones, sensors,
    cameras, lamps: dictionaries keyed by name.
    """

    @property
    def name(self) -> str: ...
    @property
    def time_s(self) -> float:
        """Simulated time in seconds."""

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
    def imaging_sonars(self) -> Mapping[str, ImagingSonarLike]: ...
    @property
    def hydrophones(self) -> Mapping[str, HydrophonesLike]: ...
    @property
    def cameras(self) -> Mapping[str, CameraLike]: ...
    @property
    def lamps(self) -> Mapping[str, LampLike]: ...
    @property
    def released(self) -> bool:
        """Whether the vehicle has left the station."""

    @property
    def all_stopped(self) -> bool:
        """True while all stop is set."""

    def telemetry(self) -> Panel:
        """Read the vehicle's panel."""

    def log(self, event: str, **values: Any) -> None:
        """Write an event to the mission's log. The values must be of JSON types."""
