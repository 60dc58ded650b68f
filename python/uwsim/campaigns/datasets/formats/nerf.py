"""transforms.json, as read by NeRF and Gaussian splatting programs such as nerfstudio and instant-ngp."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base import lens_model

OPTICAL_FROM_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
"""In OpenGL's camera frame, x points right, y up, z back; in the optical frame, x points right, y down, z ahead."""


def transforms(
    k: NDArray[np.float64], d: NDArray[np.float64], size: tuple[int, int], frames: Iterable[Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the contents of transforms.json.

    k: (3, 3), d: intrinsics as in CameraInfo, for the pictures as written, of a plumb_bob or an equidistant lens.
    size: width, height. frames: mappings
    with world_from_optical (4, 4), file, split and optionally depth_file. Pixel centres have half-integer coordinates
    in transforms.json, but integer coordinates here.
    """
    width, height = size
    listed = list(frames)
    content: dict[str, Any] = {
        "camera_model": "OPENCV_FISHEYE" if len(d) == 4 else "OPENCV",
        "w": width,
        "h": height,
        "fl_x": k[0, 0],
        "fl_y": k[1, 1],
        "cx": k[0, 2] + 0.5,
        "cy": k[1, 2] + 0.5,
        "camera_angle_x": 2.0 * float(np.arctan(0.5 * width / k[0, 0])),
        **dict(zip(lens_model.COEFFICIENTS["equidistant" if len(d) == 4 else "plumb_bob"], d.tolist(), strict=True)),
        "frames": [_frame(frame) for frame in listed],
    }
    for split in ("train", "val"):
        content[f"{split}_filenames"] = [frame["file"] for frame in listed if frame["split"] == split]
    return content


def _frame(frame: Mapping[str, Any]) -> dict[str, Any]:
    matrix = np.asarray(frame["world_from_optical"]) @ OPTICAL_FROM_OPENGL
    depth = {"depth_file_path": frame["depth_file"]} if "depth_file" in frame else {}
    return {"file_path": frame["file"], "transform_matrix": matrix.tolist(), **depth}
