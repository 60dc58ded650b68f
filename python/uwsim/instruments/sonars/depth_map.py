"""The depth-map method: a multibeam's ranges from a depth image, as in simulators based on game engines.

A depth image is rendered at the sonar's pose, each beam selects the pixel column at its angle, and depth is converted
to range by 1 / cos(angle). uwsim itself casts a ray along each beam, which is exact; this method is for comparison.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.instruments.sonars.imaging import Place, checked_pose, pose_matrix

REDUCTIONS = {"middle": _core.RowReduction.MIDDLE, "nearest": _core.RowReduction.NEAREST}
EDGE_MARGIN = 1e-9  # relative widening of a camera's field of view, so that rounding does not lose the outermost beams


@dataclass(frozen=True, kw_only=True)
class DepthMap:
    """Settings for rendering a depth image and converting it to ranges.

    width, height: size of one camera in pixels. cameras: number of cameras that share the field of view side by side,
    since one pinhole camera cannot cover 180 degrees and, close to that, spends most of its pixels on the edges.
    field_of_view_rad: horizontal field of view of all cameras together. vertical_fov_rad: vertical field of view of
    each. reduction: "middle" for the row in the fan's plane, or "nearest" for the nearest depth in any row, which is
    the first echo within vertical_fov_rad. interpolate: whether to interpolate between the inverse depths of two
    columns instead of taking the nearest pixel. depth_bits: bits of quantised depths; 0 for floats.
    """

    field_of_view_rad: float
    range_max_m: float
    width: int = 1024
    height: int = 1
    cameras: int = 1
    vertical_fov_rad: float = float(np.radians(1.0))
    reduction: str = "middle"
    interpolate: bool = False
    depth_bits: int = 0

    @property
    def rays(self) -> int:
        """Number of rays cast for one set of ranges."""
        return self.width * self.height * self.cameras

    def camera(self) -> _core.DepthCamera:
        """Return one of the cameras, which are all identical. Raises ValueError if a setting is invalid."""
        if self.reduction not in REDUCTIONS:
            raise ValueError(f"depth_map.reduction = {self.reduction!r}: must be one of {', '.join(REDUCTIONS)}")
        for name in ("width", "height", "cameras", "depth_bits"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | np.integer):
                raise ValueError(f"depth_map.{name} = {value!r}: must be a whole number")
        if not 1 <= self.cameras <= 64:
            raise ValueError(f"depth_map.cameras = {self.cameras}: must be in [1, 64]")
        camera = _core.DepthCamera()
        camera.width, camera.height, camera.depth_bits = self.width, self.height, self.depth_bits
        camera.horizontal_fov_rad = float(self.field_of_view_rad) / self.cameras * (1 + EDGE_MARGIN)
        camera.vertical_fov_rad = float(self.vertical_fov_rad)
        camera.range_max_m = float(self.range_max_m)
        camera.check()
        return camera


def depth_images(sim: Place, world_from_sonar: ArrayLike, model: DepthMap) -> NDArray[np.float32]:
    """Return depths along each camera's axis, (cameras, height, width) float32, inf if nothing is hit.

    Cameras are ordered from starboard to port of the sonar's x axis; row 0 is the top row, column 0 is farthest to
    port. Raises ValueError if the pose or a setting is invalid.
    """
    from scipy.spatial.transform import Rotation  # slow to import

    camera = model.camera()
    pose = checked_pose(world_from_sonar)
    images = []
    for turn_rad in _axes_rad(model):
        turned = pose @ pose_matrix(yaw_rad=turn_rad)
        place = np.ascontiguousarray(turned[:3, 3])
        turn = Rotation.from_matrix(turned[:3, :3]).as_quat()
        images.append(_core.depth_image(camera, sim.scene, place, turn, sim.threads))
    return np.stack(images)


def ranges_m(sim: Place, world_from_sonar: ArrayLike, angles_rad: ArrayLike, model: DepthMap) -> NDArray[np.float32]:
    """Return ranges (n,) float32 at angles (n,) about the sonar's z axis, positive to port; inf if there is no echo.

    Raises ValueError if the pose or a setting is invalid.
    """
    angles = np.asarray(angles_rad, np.float64)
    images, axes = depth_images(sim, world_from_sonar, model), _axes_rad(model)
    camera, reduction = model.camera(), REDUCTIONS[model.reduction]
    nearest = np.argmin(np.abs(angles[:, None] - axes[None, :]), axis=1)
    found = np.full(len(angles), np.inf, np.float32)
    for k, (image, axis) in enumerate(zip(images, axes, strict=True)):
        own = nearest == k
        found[own] = _core.depth_image_ranges(camera, image, angles[own] - axis, reduction, model.interpolate)
    return found


@dataclass(frozen=True)
class Difference:
    """Statistics of the differences between ranges and exact ranges.

    beams: number of beams with an echo in both; the differences in metres refer to these. missed: number of beams with
    an echo only in the exact ranges. invented: number of beams with an echo only in the other ranges.
    """

    beams: int
    missed: int
    invented: int
    mean_m: float
    percentile_95_m: float
    max_m: float


def difference(found_m: ArrayLike, exact_m: ArrayLike) -> Difference:
    """Compare ranges (n,) with exact ranges (n,); the statistics are NaN if no beam has an echo in both.

    Raises ValueError if the shapes differ.
    """
    found, exact = np.asarray(found_m, np.float64), np.asarray(exact_m, np.float64)
    if found.shape != exact.shape:
        raise ValueError(f"found_m.shape = {found.shape}: expected {exact.shape}, that of the exact ranges")
    echo, true_echo = np.isfinite(found), np.isfinite(exact)
    both = echo & true_echo
    off = np.abs(found[both] - exact[both])
    figures = (off.mean(), np.percentile(off, 95), off.max()) if both.any() else (np.nan, np.nan, np.nan)
    return Difference(
        int(both.sum()),
        int((true_echo & ~echo).sum()),
        int((echo & ~true_echo).sum()),
        *(float(value) for value in figures),
    )


def _axes_rad(model: DepthMap) -> NDArray[np.float64]:
    """Return the angle of each camera's axis about the sonar's z axis."""
    share = model.field_of_view_rad / model.cameras
    return np.asarray((np.arange(model.cameras) - (model.cameras - 1) / 2) * share, np.float64)
