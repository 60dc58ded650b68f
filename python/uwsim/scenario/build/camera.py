"""Cameras (lens and image sensor) and lamps as core objects."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base import lens_model
from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.read.calibration import CalibrationWarning
from uwsim.scenario.spec.camera import CameraMount, Lamps
from uwsim.scenario.spec.vehicle import VehicleModel

Floats = NDArray[np.float64]

CHASE_LENGTHS = np.array([2.0, 0.8])
"""Distances by which a chase camera is behind and above the hull's centre, in hull diagonals."""


def mount_orientation_xyzw(yaw_pitch_roll_deg: Sequence[float]) -> Floats:
    """Return the rotation from the frame of a mounted part to that of its carrier, (4,) as x, y, z, w."""
    return of_yaw_pitch_roll_deg(yaw_pitch_roll_deg)


def intrinsic_matrix(mount: CameraMount) -> Floats:
    """Return the intrinsic matrix K (3, 3) in pixels: the calibration's, or that of the field of view."""
    if mount.fx is not None:
        return np.array([[mount.fx, 0, mount.cx], [0, mount.fy, mount.cy], [0, 0, 1]])
    focal = 0.5 * mount.width / np.tan(np.radians(0.5 * mount.field_of_view_deg))
    return np.array([[focal, 0, 0.5 * (mount.width - 1)], [0, focal, 0.5 * (mount.height - 1)], [0, 0, 1]])


def core_camera(name: str, mount: CameraMount) -> _core.Camera:
    """Return the core's camera, including its ray table. Raises ValueError.

    A distortion that folds a part of the picture over issues a CalibrationWarning; more than half of it is refused.
    """
    k = intrinsic_matrix(mount)
    lens = _core.Lens(
        mount.width,
        mount.height,
        fx=float(k[0, 0]),
        fy=float(k[1, 1]),
        cx=float(k[0, 2]),
        cy=float(k[1, 2]),
        distortion=list(mount.distortion),
        port=None if mount.port is None else _core.FlatPort(**mount.port.model_dump()),
    )
    try:
        camera = _core.Camera(
            name,
            lens,
            exposure=mount.exposure,
            full_well=mount.full_well,
            read_noise=mount.read_noise,
            vignetting=mount.vignetting,
            wobble_rad=None if mount.wobble_mrad is None else 1e-3 * mount.wobble_mrad,
            shutter_s=1e-3 * mount.shutter_ms,
            readout_s=1e-3 * mount.readout_ms,
        )
    except ValueError as error:
        raise ValueError(
            f"camera '{name}': {error}{'; it folds' + _fold(mount, k) if 'folds' in str(error) else ''}"
        ) from None
    if camera.folded_pixels:
        share = 100.0 * camera.folded_pixels / (mount.width * mount.height)
        text = (
            f"camera '{name}': distortion folds the picture over{_fold(mount, k)}; {share:.2g} % of its pixels continue"
        )
        warnings.warn(
            f"{text} outwards without distortion, which no calibration describes", CalibrationWarning, stacklevel=2
        )
    return camera


def _fold(mount: CameraMount, k: Floats) -> str:
    """Return where the distortion folds the picture over, as part of a message."""
    angle_rad, bent = lens_model.largest_angle(mount.distortion)
    at_pixels, middle = bent * k[0, 0], f"({k[0, 2]:.0f}, {k[1, 2]:.0f})"
    return f" {np.degrees(angle_rad):.1f} deg from the axis, {at_pixels:.0f} pixels from its principal point, {middle}"


def chase_camera(model: VehicleModel) -> CameraMount:
    """Return the default camera that follows the vehicle from behind and above.

    A vehicle's file may define another camera called `chase`.
    """
    vertices_m, _ = vehicle_hull(model)
    low, high = vertices_m.min(axis=0), vertices_m.max(axis=0)
    behind, above = CHASE_LENGTHS * float(np.linalg.norm(high - low))
    centre = 0.5 * (low + high)
    pitch_deg = float(np.degrees(np.arctan2(above, behind)))
    return CameraMount(
        position_m=(float(centre[0] - behind), float(centre[1]), float(centre[2] + above)),
        yaw_pitch_roll_deg=(0.0, pitch_deg, 0.0),
        field_of_view_deg=60.0,
        follows="heading",
    )


def core_lamp(lamps: Lamps, position_m: Floats, orientation_xyzw: Floats) -> _core.SpotLamp:
    """Return a lamp at its pose in the world frame."""
    half_angle_rad = float(np.radians(lamps.half_angle_deg))
    return _core.SpotLamp(position_m, orientation_xyzw, lamps.flux_lm, half_angle_rad, lamps.soft_share, lamps.colour)
