"""The vehicle and clock interfaces for missions, implemented by uwsim.Simulator and by remote vehicles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import NDArray

from uwsim.base.commands import Steerable


class Watch(Protocol):
    """A source of the current time."""

    @property
    def time_s(self) -> float:
        """Seconds since a fixed time."""


class Clock(Watch, Protocol):
    """A clock that can wait. A simulator's clock advances simulated time; a remote vehicle's clock sleeps."""

    def wait(self, duration_s: float) -> None:
        """Return after duration_s seconds."""


class PoseLike(Protocol):
    """A pose: position_world_m (3,), world_from_body (4, 4), yaw_rad."""

    @property
    def position_world_m(self) -> NDArray[Any]: ...
    @property
    def world_from_body(self) -> NDArray[Any]: ...
    @property
    def yaw_rad(self) -> float: ...


class VelocityLike(Protocol):
    """A velocity: linear_body_m_s (3,), angular_body_rad_s (3,)."""

    @property
    def linear_body_m_s(self) -> NDArray[Any]: ...
    @property
    def angular_body_rad_s(self) -> NDArray[Any]: ...


class PingLike(Protocol):
    """A ping: ranges_m (beams,), inf = no echo; points_sonar_m (beams, 3), NaN = no echo; world_from_sonar (4, 4)."""

    @property
    def ranges_m(self) -> NDArray[Any]: ...
    @property
    def points_sonar_m(self) -> NDArray[Any]: ...
    @property
    def world_from_sonar(self) -> NDArray[Any]: ...


class SonarLike(Protocol):
    """A sonar head that tilts and pings."""

    def aim(self, elevation_rad: float) -> None:
        """Turn the head to an elevation, positive up."""

    @property
    def is_aimed(self) -> bool:
        """True once the head has reached the elevation it was last turned to."""

    def ping(self) -> PingLike:
        """Ping from the current pose."""


class SensorLike(Protocol):
    """A sensor whose readings are numbers."""

    def read(self) -> Any:
        """Return the reading in the sensor's SI unit."""


class PanelLike(Protocol):
    """The part of the vehicle's panel that missions use."""

    @property
    def battery_percent(self) -> float: ...


class EstimateLike(Protocol):
    """The estimated or true motion of a vehicle. A simulated vehicle itself provides its true motion."""

    @property
    def pose(self) -> PoseLike: ...
    @property
    def velocity(self) -> VelocityLike: ...


class SteeredVehicle(EstimateLike, Steerable, Protocol):
    """A vehicle that accepts efforts."""


class SurveyVehicle(SteeredVehicle, Protocol):
    """A vehicle that can fly a survey."""

    @property
    def sonar(self) -> SonarLike: ...
    @property
    def sensors(self) -> Mapping[str, SensorLike]: ...
    @property
    def released(self) -> bool: ...
    def release(self) -> None:
        """Leave the station."""

    def telemetry(self) -> PanelLike:
        """Return the vehicle's panel."""
