"""A vehicle's motion as known when its navigation begins, and the saved state of a Navigator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Base64Bytes, Field, FiniteFloat

from uwsim.base.saved_state import Nanoseconds, State


@dataclass(frozen=True)
class Start:
    """Position and velocity, with a standard deviation for each axis; world ENU.

    Attitude comes from the first IMU and compass readings. held_xyzw: the orientation in which a dock holds the vehicle
    at this position, at rest, until Navigator.release; None if the vehicle is free.
    """

    position_world_m: tuple[float, float, float]
    position_std_m: float
    velocity_world_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity_std_m_s: float = 0.3
    held_xyzw: tuple[float, float, float, float] | None = None


class WaterState(State):
    """The water properties that a Navigator assumes from its creation onwards."""

    silence_ns: Annotated[int, Field(gt=0, lt=2**63)]
    gravity_m_s2: Annotated[FiniteFloat, Field(gt=0)]
    density_kg_m3: Annotated[FiniteFloat, Field(gt=0)]
    compressibility_1_pa: Annotated[FiniteFloat, Field(ge=0)]


class HeldState(State):
    """The dock that holds a vehicle.

    next_ns: time of its next reading. reading: position of the IMU, then orientation x, y, z, w.
    """

    next_ns: Nanoseconds
    reading: Annotated[list[FiniteFloat], Field(min_length=7, max_length=7)]


class NavigatorState(State):
    """A saved Navigator.

    version: that of `filter`. use: who uses the estimate, as in uwsim.simulator.onboard_navigation. from_ns: the
    earliest possible stamp of each sensor's next sample.
    """

    version: int
    use: Literal["observer", "program", "steering"]
    figures: WaterState
    held: HeldState | None
    filter: Base64Bytes
    imu_ns: Nanoseconds
    from_ns: dict[str, Nanoseconds]
