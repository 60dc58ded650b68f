"""Calibration of a vehicle's cameras and IMU: EuRoC's sensor.yaml, and Kalibr's camchain-imucam.yaml and imu.yaml."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.quaternions import matrix, of_yaw_pitch_roll_deg
from uwsim.instruments.cameras import Camera
from uwsim.instruments.cameras.frame import MOUNT_FROM_OPTICAL, CameraInfo
from uwsim.instruments.sensors import Sensor
from uwsim.scenario.spec.sensor import Noise, SensorMount

GYROSCOPE, ACCELEROMETER = "angular_velocity", "linear_acceleration"


def mounted(position_m: Any, yaw_pitch_roll_deg: Any) -> Floats:
    """Return the pose of a mount in the body frame, (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3] = matrix(of_yaw_pitch_roll_deg(yaw_pitch_roll_deg))
    pose[:3, 3] = position_m
    return pose


def require_calibrated(name: str, camera: Camera) -> None:
    """Raise ValueError unless EuRoC's and Kalibr's camera model, pinhole-radtan, describes this camera exactly."""
    mount = camera.mount
    if mount.follows != "body":
        raise ValueError(
            f"camera {name}: follows the vehicle's {mount.follows} from outside: it is no part of a sequence"
        )
    if mount.distortion_model != "plumb_bob":
        raise ValueError(f"camera {name}: distortion_model = {mount.distortion_model}: must be plumb_bob, as radtan is")
    if mount.distortion[4] != 0.0:
        raise ValueError(f"camera {name}: distortion k3 = {mount.distortion[4]:g}: must be 0, as radtan has none")
    if mount.port is not None:
        raise ValueError(f"camera {name}: has a flat port, whose refraction radtan does not describe")


def camera_calibration(info: CameraInfo, rate_hz: float) -> dict[str, Any]:
    """Return the keys of a camera in EuRoC's sensor.yaml: [fu, fv, cu, cv] and [k1, k2, p1, p2]."""
    return {
        "rate_hz": rate_hz,
        "resolution": [info.width, info.height],
        "camera_model": "pinhole",
        "intrinsics": _intrinsics(info),
        "distortion_model": "radial-tangential",
        "distortion_coefficients": [float(value) for value in info.d[:4]],
    }


def camera_chain(
    cameras: Mapping[str, tuple[CameraInfo, Floats]], topics: Mapping[str, str], body_from_imu: Floats | None
) -> dict[str, Any]:
    """Return Kalibr's camchain-imucam.yaml, or its camchain.yaml without an IMU.

    cameras: intrinsics and body_from_optical (4, 4) by name. T_cn_cnm1: from the previous camera's frame to this one's;
    T_cam_imu: from the IMU's frame to the camera's. All time stamps use one clock, so timeshift_cam_imu is 0.
    """
    chain: dict[str, Any] = {}
    before: Floats | None = None
    for k, (name, (info, body_from_optical)) in enumerate(cameras.items()):
        own: dict[str, Any] = {
            "cam_overlaps": [other for other in range(len(cameras)) if other != k],
            "camera_model": "pinhole",
            "distortion_coeffs": [float(value) for value in info.d[:4]],
            "distortion_model": "radtan",
            "intrinsics": _intrinsics(info),
            "resolution": [info.width, info.height],
            "rostopic": f"/{topics[name]}",
        }
        optical_from_body = np.linalg.inv(body_from_optical)
        if before is not None:
            own["T_cn_cnm1"] = (optical_from_body @ before).tolist()
        if body_from_imu is not None:
            own |= {"T_cam_imu": (optical_from_body @ body_from_imu).tolist(), "timeshift_cam_imu": 0.0}
        chain[f"cam{k}"] = own
        before = body_from_optical
    return chain


def body_from_optical(info_pose: Floats, world_from_body: Floats) -> Floats:
    """Return the pose of a camera's optical frame in the body frame, (4, 4), given the poses of both in the world."""
    camera = np.linalg.inv(world_from_body) @ info_pose
    camera[:3, :3] = camera[:3, :3] @ MOUNT_FROM_OPTICAL
    return camera


def imu_noise(mount: SensorMount, sensor: Sensor[Any]) -> dict[str, Any]:
    """Return an IMU's noise under EuRoC's names, in SI units per root hertz.

    Noise density: that of the white noise, density or std / sqrt(rate). Random walk: the intensity q of the bias's
    derivative, from `walk` and, for a first-order Gauss-Markov bias of standard deviation s and correlation time T,
    from the noise that drives it, q = s sqrt(2 / T), for which its variance is stationary: d(s^2)/dt = -2 s^2 / T + q^2
    = 0.
    """
    rate_hz = 1.0 / sensor.period_s
    found: dict[str, Any] = {"rate_hz": rate_hz}
    for name, channel in (("gyroscope", GYROSCOPE), ("accelerometer", ACCELEROMETER)):
        noise = mount.channels.get(channel) or mount.noise or Noise(std=mount.noise_std or 0.0)
        found[f"{name}_noise_density"] = math.hypot(noise.density, noise.std / math.sqrt(rate_hz))
        driven = noise.bias_std * math.sqrt(2.0 / noise.bias_time_s) if noise.bias_time_s else 0.0
        found[f"{name}_random_walk"] = math.hypot(noise.walk, driven)
    return found


def kalibr_imu(noise: Mapping[str, Any], topic: str) -> dict[str, Any]:
    """Return Kalibr's imu.yaml."""
    rest = {key: value for key, value in noise.items() if key != "rate_hz"}
    return {**rest, "rostopic": f"/{topic}", "update_rate": noise["rate_hz"]}


def _intrinsics(info: CameraInfo) -> list[float]:
    return [float(info.k[0, 0]), float(info.k[1, 1]), float(info.k[0, 2]), float(info.k[1, 2])]
