"""From the specs of cameras and lamps to the native core's: lens, image sensor, lamps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.scenario.spec.camera import CameraMount, Lamps

Floats = NDArray[np.float64]


def mount_orientation_xyzw(yaw_pitch_roll_deg: Sequence[float]) -> Floats:
    """Return the rotation from what is mounted to what carries it, (4,) as x, y, z, w."""
    orientation: Floats = Rotation.from_euler("ZYX", yaw_pitch_roll_deg, degrees=True).as_quat()
    return orientation


def intrinsic_matrix(mount: CameraMount) -> Floats:
    """Return the (3, 3) intrinsic matrix K, in pixels; square pixels, the principal point in the middle."""
    focal = 0.5 * mount.width / np.tan(np.radians(0.5 * mount.horizontal_fov_deg))
    return np.array([[focal, 0, 0.5 * (mount.width - 1)], [0, focal, 0.5 * (mount.height - 1)], [0, 0, 1]])


def core_camera(name: str, mount: CameraMount) -> _core.Camera:
    """Return the native camera, with its table of rays. Raises ValueError."""
    k = intrinsic_matrix(mount)
    lens = _core.Lens(
        mount.width,
        mount.height,
        fx=float(k[0, 0]),
        fy=float(k[1, 1]),
        cx=float(k[0, 2]),
        cy=float(k[1, 2]),
        distortion=list(mount.distortion),
    )
    return _core.Camera(
        name,
        lens,
        exposure=mount.exposure,
        full_well=mount.full_well,
        read_noise=mount.read_noise,
        vignetting=mount.vignetting,
        wobble_rad=1e-3 * mount.wobble_mrad,
    )


def core_lamp(lamps: Lamps, position_m: Floats, orientation_xyzw: Floats) -> _core.SpotLamp:
    """Return one of the lamps on a switch, at its pose in the world."""
    half_angle_rad = float(np.radians(lamps.half_angle_deg))
    return _core.SpotLamp(position_m, orientation_xyzw, lamps.flux_lm, half_angle_rad, lamps.soft_share, lamps.colour)
