"""Sensors and cameras of descriptions, as those of a vehicle's file."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwsim.evidence.robots.robot import Found, Robot, plain_name
from uwsim.evidence.robots.xml_file import Floats, Pose, yaw_pitch_roll_deg

Errors = dict[str, dict[str, Any]]
RATES_HZ = (0.1, 1000.0)
PLACED = ("dvl", "usbl", "altitude", "proximity", "depth", "pressure", "temperature", "imu", "velocity", "position")
"""The kinds that have a position."""


def put_sensor(
    robot: Robot, found: Found, path: str, name: str, kind: str, at: Pose, rate_hz: float, errors: Errors | None = None
) -> None:
    """Add a sensor to a vehicle. path: of its element. at: its pose on the vehicle. errors: as in a vehicle's file."""
    rate = float(np.clip(rate_hz if rate_hz > 0.0 else 10.0, *RATES_HZ))
    sensor: dict[str, Any] = {"kind": kind, "rate_hz": rate}
    if kind in PLACED:
        sensor["position_m"] = at.position_m.tolist()
    sensor |= errors or {}
    if kind not in ("dvl", "compass", "depth", "pressure") and not np.allclose(at.turn, np.eye(3), atol=1e-3):
        found.left_out(f"{path}: its axes are turned against the vehicle's; here they are the vehicle's")
    robot.sensors[plain_name(name, robot.sensors)] = sensor


def put_camera(robot: Robot, name: str, at: Pose, field_of_view_deg: float, size: tuple[int, int]) -> None:
    """Add a camera that looks along the x of its pose, with z up."""
    robot.cameras[plain_name(name, robot.cameras)] = {
        "position_m": at.position_m.tolist(),
        "yaw_pitch_roll_deg": [round(angle, 4) for angle in yaw_pitch_roll_deg(at.turn)],
        "width": size[0],
        "height": size[1],
        "field_of_view_deg": field_of_view_deg,
    }


def from_optical(turn: Floats) -> Floats:
    """Return the rotation of a camera along x, z up, from that of one along z, y down."""
    return np.asarray(turn @ np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]))
