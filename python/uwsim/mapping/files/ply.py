"""PLY by plyfile: a `vertex` element with x, y, z; other properties and elements are skipped."""

from __future__ import annotations

import io
import re

import numpy as np
from numpy.typing import NDArray
from plyfile import PlyData, PlyElement

from uwsim.mapping.files.float32 import to_float32


def encode(points_m: NDArray[np.floating]) -> bytes:
    """Encode as binary little-endian float32 x, y, z, which PCL, MeshLab and CloudCompare read."""
    rows = to_float32(points_m).view([("x", "<f4"), ("y", "<f4"), ("z", "<f4")])[:, 0]
    file = io.BytesIO()
    PlyData([PlyElement.describe(rows, "vertex")], byte_order="<").write(file)
    return file.getvalue()


def decode(data: bytes) -> NDArray[np.float64]:
    """Decode text, or binary of either byte order."""
    counts = re.findall(rb"^element\s+\S+\s+(\d+)", data.partition(b"end_header")[0], flags=re.MULTILINE)
    if sum(map(int, counts)) > len(data):  # plyfile would allocate memory for all of them
        raise ValueError(f"{len(data)} bytes do not hold the {sum(map(int, counts))} elements of the header")
    vertex = PlyData.read(io.BytesIO(data))["vertex"]
    return np.stack([np.asarray(vertex[axis], np.float64) for axis in "xyz"], axis=1)
