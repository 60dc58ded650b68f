"""Start: a vehicle's motion as known when its navigation begins."""

from __future__ import annotations

from dataclasses import dataclass


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
