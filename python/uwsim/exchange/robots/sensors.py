"""Sensors and cameras of descriptions, as those of a vehicle's file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from uwsim.exchange.robots.robot import SENSES, Description, Robot, plain_name
from uwsim.exchange.robots.xml_file import Element, Floats, Pose, yaw_pitch_roll_deg
from uwsim.scenario.spec.imaging_sonar import imaging_kind

Errors = dict[str, dict[str, Any]]
RATES_HZ = (0.1, 1000.0)
PLACED = ("dvl", "usbl", "altitude", "proximity", "depth", "pressure", "temperature", "imu", "velocity", "position")
"""The kinds that have a position."""
GZ_SENSORS = {
    "imu": "imu",
    "magnetometer": "compass",
    "air_pressure": "pressure",
    "altimeter": "depth",
    "dvl": "dvl",
    "navsat": "gps",
    "gps": "gps",
}
"""Kinds of sensors by their types in SDF."""
RAYS = ("gpu_lidar", "lidar", "ray", "gpu_ray")
CAMERAS = ("camera", "depth", "depth_camera", "rgbd", "rgbd_camera", "wideanglecamera", "multicamera")


def put_sensor(
    robot: Robot, found: Description, path: str, name: str, kind: str, at: Pose, rate_hz: float,
    errors: Errors | None = None,
) -> None:  # fmt: skip
    """Add a sensor to a vehicle. path: of its element. at: its pose on the vehicle. errors: as in a vehicle's file."""
    rate = float(np.clip(rate_hz if rate_hz > 0.0 else 10.0, *RATES_HZ))
    sensor: dict[str, Any] = {"kind": kind, "rate_hz": rate}
    if kind in PLACED:
        sensor["position_m"] = at.position_m.tolist()
    sensor |= errors or {}
    if kind not in ("dvl", "compass", "depth", "pressure") and not np.allclose(at.turn, np.eye(3), atol=1e-3):
        found.left_out(f"{path}: its axes are turned against the vehicle's; here they are the vehicle's", SENSES)
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


def put_imaging(
    robot: Robot, found: Description, path: str, name: str, kind: str, at: Pose, stated: Mapping[str, float]
) -> None:
    """Add an imaging sonar that looks along the x of its pose, with z up. stated: its parameters, by their keys."""
    sonar: dict[str, Any] = {
        "kind": kind,
        "position_m": at.position_m.tolist(),
        "yaw_pitch_roll_deg": [round(angle, 4) for angle in yaw_pitch_roll_deg(at.turn)],
    }
    for key, value in stated.items():
        limits = imaging_kind(kind).parameters[key.removesuffix("_deg") + "_rad" if key.endswith("_deg") else key]
        low, high = np.degrees([limits.low, limits.high]) if key.endswith("_deg") else (limits.low, limits.high)
        if low <= value <= high:
            sonar[key] = int(value) if float(value).is_integer() else float(value)
        else:
            found.left_out(f"{path}: {key} = {value:g}: must be {low:g} to {high:g}", SENSES)
    found.assumed(f"{path}: what it does not state are the parameters of `{kind}`", SENSES)
    robot.imaging_sonars[plain_name(name, robot.imaging_sonars)] = sonar


def from_optical(turn: Floats) -> Floats:
    """Return the rotation of a camera along x, z up, from that of one along z, y down."""
    return np.asarray(turn @ np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]))


def put_gz_sensor(robot: Robot, found: Description, sensor: Element, at: Pose) -> None:
    """Add a <sensor> of SDF, which URDF has within <gazebo>, or note it. Raises ValueError."""
    kind, rate = sensor.needed("type"), sensor.number("update_rate", 10.0)
    if kind in CAMERAS:
        camera = sensor.find("camera")
        angle = 1.047 if camera is None else camera.number("horizontal_fov", 1.047)
        width, height = (
            (320.0, 240.0)
            if camera is None
            else (camera.number("image/width", 320.0), camera.number("image/height", 240.0))
        )
        put_camera(robot, sensor.name, at, float(np.degrees(angle)), (int(width), int(height)))
    elif kind in RAYS and "dvl" in sensor.name:
        found.dropped(sensor, ": a beam of the DVL, which has its own here")
    elif kind in RAYS:
        robot.sonar = at.position_m.tolist()
        found.assumed(f"{sensor.path}: its place is the multibeam's mount", SENSES)
    elif kind in GZ_SENSORS or (kind == "custom" and "dvl" in (sensor.attribute("gz:type") or sensor.name)):
        mine = GZ_SENSORS.get(kind, "dvl")
        put_sensor(robot, found, sensor.path, sensor.name, mine, at, rate, _errors(sensor, kind))
    else:
        found.dropped(sensor, f", of type {kind}")


def _errors(sensor: Element, kind: str) -> Errors:
    """Return the white noise of an IMU, the largest of its axes, as in a vehicle's file."""
    if kind != "imu":
        return {}
    channels = {
        channel: {"std": max(sensor.number(f"imu/{channel}/{axis}/noise/stddev", 0.0) for axis in "xyz")}
        for channel in ("angular_velocity", "linear_acceleration")
    }
    stated = {channel: errors for channel, errors in channels.items() if errors["std"] > 0.0}
    return {"channels": stated} if stated else {}
