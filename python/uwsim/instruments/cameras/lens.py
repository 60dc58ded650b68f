"""A camera's lens: its native ray table, its intrinsics, and the lens of its rectified pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base import lens_model
from uwsim.base.arrays import Floats
from uwsim.instruments.cameras.frame import CameraInfo
from uwsim.scenario.build.camera import core_camera, intrinsic_matrix
from uwsim.scenario.spec.camera import CameraMount


@dataclass(eq=False)
class Lens:
    """The lens of a mount. The native camera is built on first use because computing its ray table takes time."""

    name: str
    mount: CameraMount

    @cached_property
    def core(self) -> _core.Camera:
        """The native camera."""
        return core_camera(self.name, self.mount)

    @cached_property
    def info(self) -> CameraInfo:
        """The intrinsics. Those of a flat port are fitted, because no lens without a port matches exactly."""
        k, d, model = intrinsic_matrix(self.mount), np.array(self.mount.distortion), self.mount.distortion_model
        if self.mount.port is not None:
            k, d, model = *_calibrated(k, self.core.ray_table()), "plumb_bob"
        p = np.hstack([k, np.zeros((3, 1))])
        return CameraInfo(f"{self.name}_optical", self.mount.width, self.mount.height, model, d, k, np.eye(3), p)

    @cached_property
    def rectified(self) -> Lens:
        """An ideal pinhole camera with the projection matrix of `info`: no distortion, no port."""
        (fx, _, cx, _), (_, fy, cy, _), _ = self.info.p.tolist()
        angle_rad = 2.0 * np.arctan(0.5 * self.mount.width / fx)
        pinhole = {
            "field_of_view_deg": float(np.degrees(angle_rad)),
            "port": None,
            "distortion_model": "plumb_bob",
            "distortion": (0.0,) * 5,
        }
        if self.mount.fx is not None:
            pinhole |= {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
        return Lens(self.name, self.mount.model_copy(update=pinhole))


def _calibrated(k: Floats, rays: NDArray[np.float32]) -> tuple[Floats, Floats]:
    """Return the K (3, 3) and k1 k2 p1 p2 k3 (5,) that best fit rays in water, like a calibration with distant points.

    A pixel's distance from the principal point, f (x' y'), is linear in f and in f times each coefficient. The ratio of
    both focal lengths is that of k (3, 3).
    """
    step = max(1, max(rays.shape[:2]) // 64)
    v, u = np.mgrid[0 : rays.shape[0] : step, 0 : rays.shape[1] : step]
    x, y = rays[::step, ::step].reshape(-1, 2).astype(np.float64).T
    r2 = x * x + y * y
    across = [x, x * r2, x * r2**2, 2 * x * y, r2 + 2 * x * x, x * r2**3]
    down = [y, y * r2, y * r2**2, r2 + 2 * y * y, 2 * x * y, y * r2**3]
    squeeze = k[1, 1] / k[0, 0]
    from_centre = np.hstack([u.ravel() - k[0, 2], (v.ravel() - k[1, 2]) / squeeze])
    (focal, *scaled), *_ = np.linalg.lstsq(np.hstack([across, down]).T, from_centre, rcond=None)
    fitted = k.copy()
    fitted[0, 0], fitted[1, 1] = focal, squeeze * focal
    return fitted, np.array(scaled) / focal


def rectify(rgb: NDArray[np.uint8], k: Floats, d: Floats, p: Floats) -> NDArray[np.uint8]:
    """Return a picture (h, w, 3) as seen through the pinhole with the projection matrix p (3, 4).

    As ROS's image_proc and OpenCV's initUndistortRectifyMap do: each pixel of the result is interpolated linearly at
    the point to which k (3, 3) and d (see uwsim.base.lens_model) project its ray; black beyond the picture.
    """
    if not d.any() and np.array_equal(k, p[:, :3]):
        return rgb
    height, width = rgb.shape[:2]
    u, v = project(*np.meshgrid(np.arange(width), np.arange(height)), k, d, p)
    left, top = np.floor(u).astype(np.int32), np.floor(v).astype(np.int32)
    right_share, lower_share = (u - left)[..., None], (v - top)[..., None]
    # A border of one black pixel represents everything beyond the picture.
    padded = np.pad(rgb.astype(np.float32), ((1, 1), (1, 1), (0, 0)))

    def at(column: NDArray[np.int32], row: NDArray[np.int32]) -> NDArray[np.float32]:
        return padded[np.clip(row + 1, 0, height + 1), np.clip(column + 1, 0, width + 1)]

    upper = at(left, top) * (1 - right_share) + at(left + 1, top) * right_share
    lower = at(left, top + 1) * (1 - right_share) + at(left + 1, top + 1) * right_share
    return np.asarray(np.rint(upper * (1 - lower_share) + lower * lower_share), np.uint8)


def project(
    u: NDArray[np.int64], v: NDArray[np.int64], k: Floats, d: Floats, p: Floats
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the pixels of a lens with k and d that see the rays through pixels (u, v) of the pinhole p."""
    left, top = lens_model.project(k, d, (u - p[0, 2]) / p[0, 0], (v - p[1, 2]) / p[1, 1])
    return left.astype(np.float32), top.astype(np.float32)
