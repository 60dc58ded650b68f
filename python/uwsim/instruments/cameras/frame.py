"""Frame: a captured picture, with depth, normals and labels from the same pass."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.atomic_file import write_atomically
from uwsim.base.npz import npz_bytes
from uwsim.instruments.cameras.image_file import check_suffix, encode_jpeg, encode_png, write_image

MOUNT_FROM_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Rotation from the optical frame (x right, y down, z ahead) to the camera's frame (x ahead, y left, z up)."""


@dataclass(frozen=True, eq=False)
class CameraInfo:
    """Intrinsics as in sensor_msgs/CameraInfo, in pixels: k (3, 3), r (3, 3), p (3, 4); d: see base.lens_model.

    frame: the name of the optical frame (x right, y down, z ahead).
    """

    frame: str
    width: int
    height: int
    distortion_model: str
    d: Floats
    k: Floats
    r: Floats
    p: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """A captured picture. All arrays are read-only and come from the same pass.

    rgb: (H, W, 3) uint8, sRGB; (0, W, 3) in a geometry-only frame. depth_m: (H, W) float32 along the optical axis, inf
    if nothing is hit. normals_world: (H, W, 3) float32, on the side given by the triangle winding, 0 if nothing is hit.
    labels: (H, W) uint16, indices into label_names. classes: (H, W) uint8, indices into class_names. class_of_label:
    the class of each label. pieces: (H, W) uint32, the number of each piece of cover, else 0; (0, W) in a world without
    cover. Depth, normals, labels and classes describe the first solid on the straight ray through
    each pixel, as if the water and its surface were clear; colour follows the light through the surface. radiance: (H,
    W, 3) float32 before exposure, if requested, in units in which the sun's irradiance outside the atmosphere is 1.
    gain: factor from radiance to the exposed signal.
    """

    rgb: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    normals_world: NDArray[np.float32]
    labels: NDArray[np.uint16]
    classes: NDArray[np.uint8]
    pieces: NDArray[np.uint32]
    radiance: NDArray[np.float32]
    gain: float
    label_names: tuple[str, ...]
    class_names: tuple[str, ...]
    class_of_label: tuple[int, ...]
    info: CameraInfo
    time_ns: int
    world_from_camera: Floats

    @property
    def world_from_optical(self) -> Floats:
        """Pose of the optical frame, (4, 4): x right, y down, z ahead."""
        pose = np.array(self.world_from_camera)
        pose[:3, :3] = pose[:3, :3] @ MOUNT_FROM_OPTICAL
        return pose

    def jpeg(self, quality: int = 90) -> bytes:
        """Return a JPEG file. Raises ValueError for a geometry-only frame or a quality outside [1, 100]."""
        return encode_jpeg(self._rgb_or_error(), quality)

    def png(self) -> bytes:
        """Return a PNG file. Raises ValueError for a geometry-only frame."""
        return encode_png(self._rgb_or_error())

    def save(self, path: str | Path) -> None:
        """Write a .png, .jpg or .jpeg file atomically.

        Raises ValueError for other suffixes, OSError if writing fails.
        """
        check_suffix("path", Path(path))
        write_image(Path(path), self._rgb_or_error())

    def save_npz(self, path: str | Path) -> None:
        """Write all arrays, the time and the pose atomically, for np.load.

        Raises ValueError unless the path ends in .npz, OSError if writing fails.
        """
        target = Path(path)
        if target.suffix != ".npz":
            raise ValueError(f"path '{target}': must end in .npz")
        write_atomically(target, npz_bytes(**self._arrays()))

    def to_dict(self) -> dict[str, Any]:
        """Return all fields, keyed by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def _arrays(self) -> dict[str, Any]:
        names = {"label_names": np.array(self.label_names), "class_names": np.array(self.class_names)}
        skipped = ("info", *names, *(() if len(self.pieces) else ("pieces",)))
        plain = {name: np.asarray(value) for name, value in self.to_dict().items() if name not in skipped}
        return {**plain, **names, "k": self.info.k, "d": self.info.d}

    def _repr_png_(self) -> bytes | None:
        """Return the picture as a PNG, for notebooks; None for a geometry-only frame."""
        return self.png() if len(self.rgb) else None

    def __repr__(self) -> str:
        height, width = self.depth_m.shape
        colour = "" if len(self.rgb) else ", geometry only"
        return f"Frame({width} x {height} pixels, {self.info.frame}, t = {self.time_ns * 1e-9:.3f} s{colour})"

    def _rgb_or_error(self) -> NDArray[np.uint8]:
        if not len(self.rgb):
            raise ValueError("rgb: this frame contains only geometry; capture without geometry_only")
        return self.rgb
