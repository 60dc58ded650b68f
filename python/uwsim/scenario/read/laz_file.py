"""LAZ files: compressed LAS, also with COPC's octree. lazrs may panic on damaged ones, so a contained process reads."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.mapping.files import las
from uwsim.mapping.files.formats import CloudFormat
from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario.read.contained import run_contained

PROCESS = Path(__file__).with_name("laz_process.py")


def encode(points_m: NDArray[np.floating]) -> bytes:
    """Return a LAZ file of the points, as las.encode does. Raises ValueError."""
    need_extra("lazrs", "a LAZ file")
    return las.encode(points_m, compresses=True)


def encode_at(points_m: NDArray[np.floating], place: Georeference) -> bytes:
    """Return a LAZ file of the points in the place's coordinate system, as las.encode_at does. Raises ValueError."""
    need_extra("lazrs", "a LAZ file")
    return las.encode_at(points_m, place, compresses=True)


def decode(data: bytes) -> NDArray[np.float64]:
    """Return the points of a LAZ file of any version. Raises ValueError."""
    need_extra("lazrs", "a LAZ file")
    with tempfile.NamedTemporaryFile(suffix=".laz") as file:
        file.write(data)
        file.flush()
        return run_contained(PROCESS, "lazrs", file.name, reads=[Path(file.name)], cpu_s_per_byte=2e-6)["points"]


LAZ = CloudFormat(encode, decode, encode_at=encode_at)
